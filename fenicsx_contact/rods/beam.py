# SPDX-License-Identifier: LGPL-3.0-or-later
"""Beams: they bend by millimetres and move by metres along their straight axis.

In the frame of the axis the two motions do not mix, and both are linear: bending (the same in all
planes, for sections are round) and axial motion, of one unknown if the axis is inextensible. What
couples them is contact with something that is not straight. The matrix of a step is constant and
inverted once; a fall adds one rank to its axial part.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..base import checks
from ..base.constants import ROUND_OFF
from ..base.vectors import largest, worst
from ..theory.scheme import Step
from .axial_motion import AxialMotion, Ends
from .axis import AxisMesh
from .beam_state import BeamState
from .drive import AxialLaw, Place
from .matrices import BeamMatrices
from .sections import Lateral, Section, Support, values_of
from .trace import BeamTrace
from .unknowns import BeamUnknowns


class BeamSolid(BeamState):
    """A beam.

    Args:
        axis: its axis mesh.
        sections: a section, or one for each stretch of the axis.
        masses: point masses, (place s [m], kg) each.
        supports: grounded nodes.
        gravity: acceleration, d numbers, m/s².
        law: what drives it along its axis: an :class:`~fenicsx_contact.rods.drive.AxialLaw`.
        lateral_load: force of a flow, N/m, a function of places in space along the axis.
        displacement: initial deflection, m, of which a function of s (n,) gives the components
            (d - 1, n) along ``frame``; zero where a support holds it.
        slope: its derivative by s; default: by differences.
        name: for messages and files.

    Attributes:
        frame: the lateral directions, (d - 1, d), rows.
        gravity: along the travel, m/s²; ``weight``: its load on the unknowns, (n,) in N.
        lateral_load: as given.
        unknowns: their masses and stiffness.
        axial: what the law does: the energy that it has ``taken``, the ``drive_force``.
        swift: slopes have no mass, and are at once where forces put them.

    Raises:
        InputError: no mass, no section somewhere, numbers out of range, what a law cannot drive,
            a deflection or a slope where a support holds fast.
    """

    _pushed: np.ndarray | float  # by the contacts
    _about: np.ndarray  # the velocity that was linearised about

    @property
    def linear(self) -> bool:  # type: ignore[override]
        """But for a stop that the trial state meets."""
        return not self.axial.meets(self._states[0])

    @property
    def _states(self) -> tuple[Ends, Ends]:
        """Displacements and velocities of the driven system, at the start and in the trial."""
        drawn = self.driven
        u = drawn(self.displacement), drawn(self.trial_displacement)
        return u, (drawn(self.velocity), drawn(self.trial_velocity))

    def __init__(
        self,
        axis: AxisMesh,
        sections: Section | Mapping[str, Section],
        *,
        masses: Sequence[tuple[float, float]] = (),
        supports: Sequence[Support] = (),
        gravity: Sequence[float] | None = None,
        law: AxialLaw | None = None,
        lateral_load: Lateral | None = None,
        displacement: Lateral | None = None,
        slope: Lateral | None = None,
        name: str = "beam",
    ) -> None:
        checks.instance("axis", axis, AxisMesh, "an AxisMesh (axis_mesh)")
        self.name = checks.label("name", name)
        self.mesh, self.dim = axis, axis.dim  # type: ignore[assignment]
        if isinstance(sections, Section):
            sections = dict.fromkeys(axis.stretches, sections)
        self.matrices = k = BeamMatrices(axis, sections, masses, supports)
        self.axis, self.frame, self.mass = axis, axis.frame, k.mass
        self.supported = not (k.free_bending.all() and k.free_axial.all())
        self.unknowns = unknowns = BeamUnknowns(axis, k)
        self.split = unknowns.split
        self.swift = bool((k.free_bending & (k.bending_mass == 0)).any())
        self._masses, self._stiffness = unknowns.masses, unknowns.stiffness
        held = len(unknowns.mean) == 1 and not k.free_axial.all()
        g = np.zeros(self.dim) if gravity is None else checks.vector("gravity", gravity, self.dim)
        self.gravity = -float(g @ axis.direction)  # along the travel
        self.axial = AxialMotion(self._share, self.mass, self.gravity, held)
        self.weight, self.lateral_load = unknowns.weight(g), lateral_load
        if lateral_load is not None:
            values_of("lateral_load", lateral_load, k.s, unknowns.planes)
        self.displacement, self.velocity = np.zeros((2, len(self.weight)))
        unknowns.bend(self.displacement, displacement, slope)
        self.predictions = 0  # counts them, for those who follow
        self.law = law
        self._begin()

    def deflect(self, deflection: np.ndarray) -> None:
        """Give the beam another deflection, (nodes, d - 1) in m in the order of s, at rest; what a
        support holds fast stays."""
        self.displacement = self.displacement.copy()
        k, given = self.matrices, np.asarray(deflection).T
        w = values_of("deflection", lambda s: given, k.s, self.unknowns.planes)
        self.split(self.displacement)[0][:] = k.bent(w, None)
        self.rest()

    @property
    def law(self) -> AxialLaw | None:
        """What drives the beam along its axis."""
        return self.axial.law

    @law.setter
    def law(self, law: AxialLaw | None) -> None:
        self._seen: Step | None = None
        self.axial.follow(law)
        if law is not None and law.prescribed is not None:  # the drive has no inertia
            along = self.unknowns.carried(self.axial.holding)
            self.velocity = np.append(self.split(self.velocity)[0], -law.prescribed * along)
            self._begin()

    def driven(self, values: np.ndarray) -> np.ndarray:
        """The unknowns of the system in which laws act."""
        return self.split(values)[1]

    def _share(self, place: Place) -> np.ndarray:
        """What each of them bears of a force along the axis."""
        return self.unknowns.share(place)

    @property
    def rod(self) -> BeamSolid:
        """The beam itself; of a rod in an elastic tube, its rod."""
        return self

    def around(self, trace: BeamTrace) -> BeamTrace:
        """A trace of the rod, seen from what is around it: from walls that do not give way."""
        return trace

    def _begin(self) -> None:
        """Refresh what is kept from step to step."""
        self.trial_displacement, self.trial_velocity = self.displacement, self.velocity
        self.memory, self._linear = None, False
        self._seen = None  # the step that was predicted last
        self._internal = self.internal_force(self.displacement)
        self._momentum = self._masses * self.velocity
        self.predictions += 1

    def internal_force(self, displacement: np.ndarray) -> np.ndarray:
        """That of a displacement, (n,) in N."""
        return self._stiffness @ displacement

    def predict(self, step: Step) -> None:
        if self._seen == step and self.trial_velocity is self.velocity:
            return  # nothing has happened since
        self._seen, self._linear = step, False
        self.memory = step.recall(self.memory, lambda: self.weight - self._internal)
        self.go(self.velocity, step.coming)  # in an impact what is around it is that of the step
        self.predictions += 1

    def linearise(self, step: Step) -> None:
        self.drop_forces()
        if self._linear and (self._about is self.trial_velocity or self.linear):
            return  # one linearisation serves a step that meets no stop
        self._linear, self._about = True, self.trial_velocity
        self.flexibility, axial = self.matrices.flexibilities(step.span, step.force_rate)
        load = self._momentum / step.span
        if step.dt:
            before, after = step.scheme.linear_weights
            load += self._loads(step) - (before + after) * self._internal
            drift = step.drift(self.velocity, self.memory)
            if drift.any():
                load -= after * (self._stiffness @ drift)
            if self.lateral_load is not None:
                self._flow = self.unknowns.flow(self.lateral_load, self.displacement)
                load += self._flow
        bending, along = self.split(load)
        self.axial_flexibility, given = self.axial.drive(step, *self._states, axial, along)
        given += self.axial_flexibility @ along
        self.free_velocity = np.concatenate([(bending @ self.flexibility).ravel(), given])

    def _loads(self, step: Step) -> np.ndarray:
        """The weight, and what the scheme carries along; laws and flow are not carried."""
        return step.load_weight * self.weight + step.carried(self.memory)

    def bear(self, bending: np.ndarray, axial: np.ndarray, along: np.ndarray) -> None:
        """Take up forces on the axis.

        Args:
            bending, axial: the velocities that they make, (d - 1, 2m) and of the axial unknowns.
            along: what the axial unknowns bear of them, N.
        """
        lateral, axially = self.split(self._gain)
        lateral += bending
        axially += axial
        self._pushed = self._pushed + along

    def correct(self, step: Step) -> None:
        self.go(self.free_velocity + self._gain, step)

    def go(self, velocity: np.ndarray, step: Step) -> None:
        way = step.increment(self.velocity, velocity, self.memory)
        self.trial_velocity, self.trial_displacement = velocity, self.displacement + way

    def drop_forces(self) -> None:
        self._gain = np.zeros_like(self.weight)
        self._pushed = 0.0

    def mean_velocity(self, step: Step) -> np.ndarray:
        # an impact finds what has no mass following: without a force it would have been, too
        start = self.velocity if step.dt else self.free_velocity
        return step.mean(start, self.trial_velocity)

    def works(self, step: Step) -> tuple[float, float, float, float]:
        mean = self.mean_velocity(step)
        lacking, change = self._lacking(step), self._trial_momentum - self._momentum
        loads, others = step.dt * float(mean @ self._acting), {}
        if self.lateral_load is not None and step.dt:  # gives what it does on the way, as weight
            loads += step.dt * float(mean @ self._flow)
            others["flow"] = float((self.trial_displacement - self.displacement) @ self._flow)
        against, works = self.axial.works(step, *self._states, lacking, others)
        return float(mean @ change) + against, loads + works, 0.0, 0.0

    def _lacking(self, step: Step) -> np.ndarray:
        """What is left of the balance of the driven system without its law, N."""
        self._trial_momentum = self._masses * self.trial_velocity
        self._trial_internal = self.internal_force(self.trial_displacement)
        self._acting = self._loads(step) - self._mean_internal(step)
        rate = (self._trial_momentum - self._momentum) / step.span
        return self.driven(rate - step.loaded * self._acting) - self._pushed

    def imbalance(self, step: Step, noise: float = 0.0) -> float:
        if self.linear:
            return 0.0
        lacking, law = self._lacking(step), self.axial.balance(step, *self._states)
        left = np.where(self.matrices.free_axial, lacking - law, 0.0)
        left = left - self.axial.held(left)
        stretched = np.abs(self.driven(self._stiffness.diagonal() * self.trial_displacement))
        round_off = largest(self.driven(self._trial_momentum)) / step.span + largest(stretched)
        wrong = largest(left) - ROUND_OFF * round_off
        size = worst([largest(self.driven(self._acting)), largest(np.asarray(law))])
        if size <= noise and wrong < np.inf:  # NaN is neither
            return 0.0
        return max(wrong, 0.0) / size

    def _mean_internal(self, step: Step) -> np.ndarray:
        """Of the internal forces of the step, as the scheme takes them."""
        return step.linear_mean(self._internal, self._trial_internal)

    def accept(self, step: Step) -> None:
        self.memory = step.remember(self.velocity, self.trial_velocity, self._acting, self.memory)
        before = self.travel, self.speed
        self.velocity, self.displacement = self.trial_velocity, self.trial_displacement
        self._seen = None
        self._momentum, self._internal = self._trial_momentum, self._trial_internal
        if step.is_part:  # however short: what has no mass came by where it is, not how fast
            self.velocity = self.trial_velocity = self._following()
        self.axial.accept(before, (self.travel, self.speed))

    def _following(self) -> np.ndarray:
        """The velocity, of what has no mass that with which it follows what has."""
        velocity, momentum = self.velocity.copy(), self.split(self._momentum)[0]
        self.split(velocity)[0][:] = momentum @ self.matrices.flexibilities(1.0, 0.0)[0]
        return velocity

    def trace(self, points: np.ndarray) -> BeamTrace:
        return self.sight(self.axis.along(points))

    def sight(self, places: np.ndarray, *stations: Any) -> BeamTrace:
        """A trace from places s [m] and from stations."""
        return BeamTrace(self, places, *stations)

    def restore(self, state: dict[str, np.ndarray]) -> None:
        self.displacement = np.array(state["displacement"])
        self.velocity = np.array(state["velocity"])
        self.axial.restore(state)
        self._begin()
        self.memory = state.get("memory")

    def rest(self) -> None:
        """Stop every motion and forget what was taken; the deflection stays."""
        self.velocity = np.zeros_like(self.velocity)
        self.axial.taken = {}
        self._begin()
