# SPDX-License-Identifier: LGPL-3.0-or-later
"""Beams: they bend by millimetres and move by metres along their straight axis.

In the frame of the axis the two motions do not mix, and both are linear: bending (the same in all
planes, for sections are round) and axial motion, of one unknown if the axis is inextensible. What
couples them is contact with something that is not straight. The matrix of a step is constant and
inverted once; a fall adds one rank to its axial part.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import sqrt

import numpy as np
import scipy.sparse

from ..base import checks
from ..base.compat import cell_geometry
from ..solids.base import Solid
from ..theory.theta import Step
from .axial import AxialMotion
from .axis import AxisMesh
from .drive import AxialLaw, Driven
from .sections import BeamMatrices, Section, Support
from .trace import BeamTrace

#: A lateral field: of places along the axis [m] (n,), values (d - 1, n).
Lateral = Callable[[np.ndarray], np.ndarray]


class BeamSolid(Solid):
    """A beam.

    Args:
        axis: its axis mesh.
        sections: a section, or one for each stretch of the axis.
        masses: point masses, (place s [m], kg) each.
        supports: grounded nodes.
        gravity: acceleration, d numbers, m/s².
        law: what drives it along its axis: a :class:`~fenicsx_contact.rods.drive.Fall`, a
            :class:`~fenicsx_contact.rods.drive.Driven`, or None: nothing but loads and supports.
        lateral_load: force of a flow, N/m, a function of places in space along the axis.
        displacement: initial deflection, m, a function of s.
        slope: its derivative by s; default: by differences.
        name: for messages and files.

    Attributes:
        frame: the lateral directions, (d - 1, d), rows.
        gravity: along the travel, m/s².

    Raises:
        InputError: no mass, no section somewhere, a rod that would never fall, numbers out of
            range, a driven axis that is supported or stretches.
    """

    linear = True

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
        self.name, self.mesh, self.dim = name, axis, axis.dim  # type: ignore[assignment]
        if isinstance(sections, Section):
            sections = dict.fromkeys(axis.stretches, sections)
        self.matrices = k = BeamMatrices(axis, sections, masses, supports)
        self.axis, self.mass = axis, k.mass
        self.frame = _frame(axis.direction)
        self.supported = not (k.free_bending.all() and k.free_axial.all())
        d, m = self.dim, len(k.s)
        self.planes, self._bends = d - 1, 2 * m * (d - 1)
        self._mean = k.weights / k.mass if len(k.axial_mass) > 1 else np.ones(1)
        held = len(self._mean) > 1 or not k.free_axial.all()
        g = np.zeros(d) if gravity is None else checks.vector("gravity", gravity, d)
        self.gravity = -float(g @ axis.direction)  # along the travel
        self.axial = AxialMotion(self._mean, self.mass, self.gravity, held)
        self._load = np.zeros(self._bends + len(k.axial_mass))
        bending, axial = self.split(self._load)
        bending[:, ::2] = (self.frame @ g)[:, None] * k.bending_mass[::2]
        axial[:] = -self.gravity * k.axial_mass
        self._masses = np.concatenate([np.tile(k.bending_mass, self.planes), k.axial_mass])
        blocks = [k.bending_stiffness] * self.planes + [k.axial_stiffness]
        sparse = [scipy.sparse.csr_matrix(block) for block in blocks]
        self._stiffness = scipy.sparse.block_diag(sparse, format="csr")
        self._lateral_load = lateral_load
        self._lengths = np.gradient(k.s) * np.where(np.isin(k.s, k.s[[0, -1]]), 0.5, 1.0)

        self.displacement = np.zeros_like(self._load)
        self.velocity = np.zeros_like(self._load)
        if displacement is not None:
            self._set_deflection(displacement(k.s), None if slope is None else slope(k.s))
        self._inverses: dict[tuple[float, float], tuple[np.ndarray, np.ndarray]] = {}
        self.predictions = 0  # counts them, for those who follow
        self.law = law
        self._begin()

    # -- unknowns -------------------------------------------------------------------------------

    def split(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Views of the unknowns: (w, psi) by node in each plane, (d - 1, 2m), and axial."""
        return values[: self._bends].reshape(self.planes, -1), values[self._bends :]

    def _set_deflection(self, w: np.ndarray, slope: np.ndarray | None) -> None:
        s, (bending, _) = self.matrices.s, self.split(self.displacement)
        w = np.asarray(w, dtype=float)
        if w.shape != (self.planes, len(s)) or not np.isfinite(w).all():
            raise checks.InputError(
                f"displacement: gives values of shape {w.shape}; must be a function of s (n,) with "
                f"finite values ({self.planes}, n)"
            )
        bending[:, ::2] = w
        bending[:, 1::2] = np.gradient(w, s, axis=1) if slope is None else slope
        bending[:, ~self.matrices.free_bending] = 0.0

    def deflect(self, deflection: np.ndarray) -> None:
        """Give the beam another deflection, (nodes, d - 1) in m in the order of s, at rest."""
        self.displacement = self.displacement.copy()
        self._set_deflection(np.asarray(deflection).T, None)
        self.rest()

    @property
    def law(self) -> AxialLaw | None:
        """What drives the beam along its axis."""
        return self.axial.law

    @law.setter
    def law(self, law: AxialLaw | None) -> None:
        self.axial.law = law
        if isinstance(law, Driven):  # the drive has no inertia
            self.velocity = self.velocity.copy()
            self.split(self.velocity)[1][:] = -law.speed
            self._begin()

    @property
    def taken(self) -> dict[str, float]:
        """Energy that water, drive line, drive, stop and flow have taken so far, J, by name."""
        return self.axial.taken

    @property
    def drive_force(self) -> float:
        """Force of a drive along the travel in the last step, N."""
        return self.axial.drive_force

    @property
    def rod(self) -> BeamSolid:
        """The beam itself; of a rod in an elastic tube, its rod."""
        return self

    @property
    def travel(self) -> float:
        """How far the beam has moved against the direction of its axis, m."""
        return -float(self._mean @ self.split(self.displacement)[1])

    @property
    def speed(self) -> float:
        """Rate of the travel, m/s."""
        return -float(self._mean @ self.split(self.velocity)[1])

    # -- the step -------------------------------------------------------------------------------

    def _begin(self) -> None:
        """Refresh what is kept from step to step."""
        self.trial_displacement, self.trial_velocity = self.displacement, self.velocity
        self.memory = None
        self._internal = self._stiffness @ self.displacement
        self._momentum = self._masses * self.velocity
        self.predictions += 1

    def predict(self, step: Step) -> None:
        self.memory = step.recall(self.memory, lambda: self._load - self._internal)
        self.trial_velocity = self.velocity
        self._move(step)
        self.predictions += 1

    def _move(self, step: Step) -> None:
        increment = step.increment(self.velocity, self.trial_velocity, self.memory)
        self.trial_displacement = self.displacement + increment

    def linearise(self, step: Step) -> None:
        key = (step.span, step.force_rate)
        if key not in self._inverses:
            if len(self._inverses) > 8:  # steps of many lengths: do not hoard
                self._inverses.pop(next(iter(self._inverses)))
            k = self.matrices
            self._inverses[key] = (
                _inverse(
                    np.diag(k.bending_mass) / key[0] + key[1] * k.bending_stiffness, k.free_bending
                ),
                _inverse(np.diag(k.axial_mass) / key[0] + key[1] * k.axial_stiffness, k.free_axial),
            )
        self.flexibility, axial = self._inverses[key]
        load = self._momentum / step.span
        if step.dt:
            before, after = step.scheme.linear_weights
            load += self._loads(step) - (before + after) * self._internal
            drift = step.drift(self.velocity, self.memory)
            if drift.any():
                load -= after * (self._stiffness @ drift)
            if self._lateral_load is not None:
                load += self._flow()
        bending, along = self.split(load)
        self.axial_flexibility = self.axial.drive(step, self.travel, self.speed, axial, along)
        self.free_velocity = np.concatenate(
            [(bending @ self.flexibility).ravel(), self.axial_flexibility @ along]
        )
        if isinstance(self.law, Driven):
            self.free_velocity[self._bends :] = -self.law.speed
        self._gain = np.zeros_like(load)
        self._pushed = 0.0

    def _loads(self, step: Step) -> np.ndarray:
        """The weight, and what the scheme carries along; laws and flow are not carried."""
        return step.load_weight * self._load + step.carried(self.memory)

    def _flow(self) -> np.ndarray:
        """The lateral load of the flow on the nodes, where they are now."""
        assert self._lateral_load is not None
        axial = self.split(self.displacement)[1]
        result = np.zeros_like(self._load)
        bending, _ = self.split(result)
        bending[:, ::2] = self._lateral_load(self.matrices.s + axial) * self._lengths
        self._flow_force = result
        return result

    def correct(self, step: Step) -> None:
        self.go(self.free_velocity + self._gain, step)

    def go(self, velocity: np.ndarray, step: Step) -> None:
        self.trial_velocity = velocity
        self._move(step)

    def drop_forces(self) -> None:
        self._gain = np.zeros_like(self._gain)
        self._pushed = 0.0

    def imbalance(self, step: Step, noise: float = 0.0) -> float:
        return 0.0

    def root_mean_square(self, velocity: np.ndarray) -> float:
        return sqrt(float(velocity @ (self._masses * velocity)) / self.mass)

    def works(self, step: Step) -> tuple[float, float, float, float]:
        mean = step.mean(self.velocity, self.trial_velocity)
        self._trial_momentum = self._masses * self.trial_velocity
        self._trial_internal = self._stiffness @ self.trial_displacement
        internal = step.linear_mean(self._internal, self._trial_internal)
        self._acting = self._loads(step) - internal
        momentum = float(mean @ (self._trial_momentum - self._momentum))
        loads = step.dt * float(mean @ self._acting)
        others = {}
        if self._lateral_load is not None and step.dt:
            others["flow"] = step.dt * float(mean @ self._flow_force)
        after = -float(self._mean @ self.split(self.trial_velocity)[1])
        against, works = self.axial.works(step, self.speed, after, self._pushed, others)
        return momentum + against, loads + works, 0.0, 0.0

    def accept(self, step: Step) -> None:
        self.memory = step.remember(self.velocity, self.trial_velocity, self._acting, self.memory)
        before = self.travel, self.speed
        self.velocity, self.displacement = self.trial_velocity, self.trial_displacement
        self._momentum, self._internal = self._trial_momentum, self._trial_internal
        self.axial.accept(before, (self.travel, self.speed))

    # -- what it tells --------------------------------------------------------------------------

    def trace(self, points: np.ndarray) -> BeamTrace:
        return BeamTrace(self, self.axis.along(points))

    def energies(self) -> tuple[float, float, float]:
        """Kinetic energy (with the water that moves along), strain energy, and the potential of
        the weight plus all that was ``taken``, J."""
        kinetic = 0.5 * float(self.velocity @ self._momentum)
        kinetic += self.axial.added_energy(self.travel, self.speed)
        strain = 0.5 * float(self.displacement @ self._internal)
        return kinetic, strain, sum(self.taken.values()) - float(self._load @ self.displacement)

    def lateral_energy(self) -> float:
        """Kinetic and strain energy of bending, J."""
        n = self._bends
        kinetic = self.velocity[:n] @ self._momentum[:n]
        return 0.5 * float(kinetic + self.displacement[:n] @ self._internal[:n])

    def state(self) -> dict[str, np.ndarray]:
        return {
            "displacement": self.displacement,
            "velocity": self.velocity,
            "taken.names": np.array(list(self.taken), dtype=str),
            "taken": np.array(list(self.taken.values())),
            **self.memories(),
        }

    def restore(self, state: dict[str, np.ndarray]) -> None:
        self.displacement = np.array(state["displacement"])
        self.velocity = np.array(state["velocity"])
        names = [str(name) for name in state["taken.names"]]
        self.axial.taken = dict(zip(names, map(float, state["taken"])))
        self._begin()
        self.memory = state.get("memory")

    def rest(self) -> None:
        """Stop every motion and forget what was taken; the deflection stays."""
        self.velocity = np.zeros_like(self.velocity)
        self.axial.taken = {}
        self._begin()

    def fields(self) -> dict[str, np.ndarray]:
        x = self.axis.mesh.geometry.x[:, : self.dim]
        node = np.abs(self.axis.along(x)[:, None] - self.matrices.s).argmin(axis=1)
        result = {}
        for what, values in (("displacement", self.displacement), ("velocity", self.velocity)):
            bending, axial = self.split(values)
            along = np.broadcast_to(axial, len(self.matrices.s)) if len(axial) == 1 else axial
            every = bending[:, ::2].T @ self.frame + along[:, None] * self.axis.direction
            result[what] = every[node]
        return result

    def describe(self) -> str:
        kind = "inextensible" if len(self._mean) == 1 else "extensible"
        return (
            f"beam, {kind}, {len(cell_geometry(self.axis.mesh))} cells, mass {self.mass:.9g}, "
            f"stiffness {self._stiffness.diagonal().sum():.9g}, gravity {self.gravity:.9g}, "
            f"{self.law!r}, {len(self._load)} unknowns"
        )


def _frame(direction: np.ndarray) -> np.ndarray:
    """Unit vectors across a direction, (d - 1, d), as near as can be to the first axes."""
    if len(direction) == 2:
        return np.array([[direction[1], -direction[0]]])
    first = np.eye(3)[np.abs(direction).argmin()]
    first = first - (first @ direction) * direction
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(direction, first)])


def _inverse(matrix: np.ndarray, free: np.ndarray) -> np.ndarray:
    """The inverse over the free unknowns, zero elsewhere."""
    result = np.zeros_like(matrix)
    here = np.ix_(free, free)
    result[here] = np.linalg.inv(matrix[here])
    return result
