# SPDX-License-Identifier: LGPL-3.0-or-later
"""A contact: a solid's facets against an obstacle or another solid's, with or without friction.

It follows the solids through a step and feeds gaps and normals to the equations of its surface.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import frexp
from typing import Any

import numpy as np

from ..base import checks
from ..solids import Solid
from ..theory.formulations import Formulation, StepData
from ..theory.formulations import formulation as as_formulation
from ..theory.friction import FrictionBound, friction_bound
from ..theory.theta import Step
from .equations import SurfaceEquations
from .jump import Coupling, MortarJump, side_of
from .nodal import NodalJump
from .surface import Surface
from .wall import Obstacle

#: What a solid's facets may meet: an obstacle, or the named facets of another solid.
Master = Obstacle | tuple[Solid, str]

#: Distances below this share of the coordinates, and jumps below this share of the speeds of what
#: jumps, are noise.
ROUND_OFF = 1e-14

#: Weight of gaps and jumps between two solids beside the multipliers in what decides who bears and
#: who slips: those of a point that bears and sticks are not quite zero before the last iteration.
MEETING = 0.1


class Contact:
    """A contact between the named facets of a solid (slave) and what they may touch (master).

    Args:
        solid: the slave; between two solids better the softer one, or the one of the finer mesh.
        facets: the name of its facets in contact.
        master: an obstacle, or another solid and the name of its facets.
        formulation: a formulation or its name; see :mod:`fenicsx_contact.theory.formulations`.
        friction: Coulomb's coefficient, or a law of friction (see
            :mod:`fenicsx_contact.theory.friction`); 0 leaves friction out, unknowns and all.
        normal_augmentation, tangential_augmentation: pure numbers; rho_n and rho_t are these
            times values scaled by the scene. They act on the way to the solution, not on it.
        gap_tolerance: share of the surface's extent to which the arrival of a point is located.
        name: for messages and files.

    Attributes:
        gap, jump: at the start of the step, m and m/s; ``trial_jump`` in the trial state.
        allowed: points that may bear in the step, if they are asked to.
        status: of the points in the last step: 0 open, 1 stick, 2 slip.
        force: mean of the last step on the solid, N.

    Raises:
        InputError: friction < 0 or NaN, unknown formulation or facets, dimensions that differ,
            points of a formulation that are no nodes of the facets, surfaces that do not face
            each other anywhere or are the same.
    """

    #: Whether its forces can only take energy from the solids, as far as the books of these say.
    gives_nothing = True

    def __init__(
        self,
        solid: Solid,
        facets: str,
        master: Master,
        formulation: Formulation | str = "velocity",
        friction: float | FrictionBound = 0.0,
        *,
        normal_augmentation: float = 1.0,
        tangential_augmentation: float = 1.0,
        gap_tolerance: float = 1e-11,
        name: str | None = None,
    ) -> None:
        checks.offers("solid", solid, Solid, "a solid")
        other = _check_master(solid, facets, master)
        self.solid, self.facets = solid, facets
        self.formulation = as_formulation(formulation)
        self.friction, self.friction_law = friction, friction_bound(friction)
        augmentation = (
            checks.number("normal_augmentation", normal_augmentation, above=0),
            checks.number("tangential_augmentation", tangential_augmentation, above=0),
        )
        self.name = checks.label("name", f"{solid.name}.{facets}" if name is None else name)
        self.surface = self._make_surface()
        self.extent = float(np.ptp(self.surface.points, axis=0).max())
        self.tolerance = checks.number("gap_tolerance", gap_tolerance, at_least=0) * self.extent

        self.chosen, weight = self._points()
        self._paired = isinstance(other, tuple)
        if self._paired and weight is self.surface.area:
            weight = weight.copy()  # by what of it is paired
        self.equations = SurfaceEquations(
            self.surface, self.formulation, self.friction_law, self.chosen, weight, augmentation
        )
        self.coupling = self._couple(other)
        self.solids, self.traces = self.coupling.solids, self.coupling.traces
        self.part = self.coupling.part
        self.force = np.zeros(self.surface.points.shape)
        self.status = np.zeros(self.surface.size)
        self._stretch = np.zeros(self.surface.points.shape)  # of tangential springs
        self._octave, self._units = -np.inf, np.ones((2, self.surface.size))
        self._mobility = self._resolution = 0.0
        self._moved = 1.0  # length of the last step, s
        self._remembers = not self.formulation.multipliers
        self._set_normal(self.coupling.normals())
        self._locate()

    def _couple(self, other: Obstacle | tuple[Solid, str]) -> Coupling:
        if not isinstance(other, tuple):
            coupling = NodalJump(self.solid, self.equations, other)
            coupling.wall.check(coupling.positions())
            return coupling
        solid, facets = other
        sides = side_of(self.solid, self.facets, self.surface), side_of(solid, facets)
        pair = MortarJump((self.solid, solid), sides, self.equations)
        if not pair.faces:
            raise checks.InputError(
                f"master = ({solid.name!r}, {facets!r}): nowhere faces {self.facets!r} of "
                f"{self.solid.name!r}; the outward normals of the two must point at each other"
            )
        return pair

    def _points(self) -> tuple[np.ndarray, np.ndarray]:
        """The points that the formulation acts on, and their weights in the integrals."""
        chosen = np.ones(self.surface.size, dtype=bool)
        if not self.formulation.at_points:
            return chosen, self.surface.area
        points = self.formulation.points
        if points is not None:
            problem = f"points = {points!r}: each must be a node of the facets {self.facets!r}"
            try:
                wanted = np.array(points, dtype=float)
            except (TypeError, ValueError):
                raise checks.InputError(problem) from None
            if wanted.ndim != 2 or wanted.shape[1] != self.surface.dim or not len(wanted):
                raise checks.InputError(f"{problem}, {self.surface.dim} coordinates each")
            nodes = self.surface.nodes_at(wanted, 1e-6 * self.extent)
            if (nodes < 0).any():
                raise checks.InputError(problem)
            chosen[:] = False
            chosen[nodes] = True
        return chosen, chosen.astype(float)

    def _make_surface(self) -> Surface:
        return Surface(*self.solid.mesh.boundary(self.facets))

    def _locate(self) -> None:
        """Gap (n,) and jump (n, d) at the start of a step."""
        self.gap = self.coupling.gaps()
        self.jump = self.coupling.jump("velocity")
        self._start()

    def _start(self) -> None:
        """Frame from which the next step starts."""
        tangents = self.equations.fields.frame()[1]
        if self.surface.dim == 3 and len(tangents):
            self.equations.fields.set_tangent(tangents[0])

    # -- the step -------------------------------------------------------------------------------

    def predict(self, step: Step, closing: bool = True) -> None:
        """Follow the solids' explicit prediction and choose the candidates of the step; points that
        are open now only if ``closing``, in a percussion only those of a law of velocities."""
        if bool(step.dt) != bool(self._moved):  # impulses are alike in a percussion and a step
            self.equations.scale_multipliers((self._moved or 1.0) / step.span)
        self.coupling.begin(step)
        if self.coupling.driven:
            self.jump = self.coupling.jump("velocity")
        self.coupling.follow()
        self.allowed = self.formulation.closed(self.coupling.gaps(), self.tolerance)
        if not closing:
            self.allowed = self.allowed & self.touching()
        if not step.dt and not self.formulation.percussive:
            self.allowed = np.zeros(self.surface.size, dtype=bool)
        self._asked = np.ones(self.surface.size, dtype=bool)
        self._choose()

    def _choose(self) -> None:
        self.equations.choose(self.allowed & self._asked & self.coupling.near())

    def screen(self, free: np.ndarray, step: Step) -> None:
        """Narrow the candidates to points that bore, or would do what the law forbids without
        contact, from the free velocities of the traces' points, flat: no others bear, unless
        :meth:`grow` finds that the contact made them."""
        bore = self.status > 0
        self._asked = bore | self._violates(self.coupling.to_jump(free), step)
        self._choose()
        if self._paired:  # its operators are those of the candidates
            self.coupling.linearise(step, False, self.formulation.gap_share)

    def grow(self, step: Step) -> bool:
        """Let points be candidates that do in the trial state what the law forbids; whether there
        were any."""
        more = self._violates(self.trial_jump, step) & ~self._asked
        if not (more & self.allowed & self.coupling.near()).any():
            return False
        self._asked |= more
        self._choose()
        return True

    def _violates(self, jump: np.ndarray, step: Step) -> np.ndarray:
        """Points whose jump (n, d) is more than the law allows, (n,) of bool."""
        approach = _dot(jump, self.normal)
        limit = self.limit(step)
        if limit is None:  # springs know no limit, but what they do not touch
            k = self.equations.fields
            limit = -k.gap.x.array / step.gap_rate if step.gap_rate else np.inf * approach
            return (approach > limit) | (self.gap > 0)
        return approach > limit

    def touching(self) -> np.ndarray:
        """Points that bore in the last step, or touch at the start of this one and do not leave,
        (n,) of bool."""
        stays = _dot(self.jump, self.coupling.normals()) >= -self._resolution
        return self.chosen & ((self.status > 0) | ((self.gap >= -self.tolerance) & stays))

    def linearise(self, step: Step, exact: bool = False) -> None:
        """Take up the trial states of the solids: operators, normals and gaps; if ``exact`` with
        the derivatives of all these."""
        for trace in self.traces:
            trace.linearise(step)
        k, share = self.equations.fields, self.formulation.gap_share
        if self._paired:
            if not self.formulation.at_points:
                self.equations.set_weight(self.coupling.area)
            self._choose()
        if not self.coupling.fixed_normal:
            self._set_normal(self.coupling.normals())
        gap = self.gap if step.dt else np.minimum(self.gap, 0.0)  # no way to correct a drift
        # what less than the resolved speed would close is closed
        gap = np.where((gap < 0) & (gap >= -self._resolution * step.horizon), 0.0, gap)
        if share:
            # the gap at the end of the step as a function of w: end + gap_rate w_n
            approach = _dot(self.coupling.jump("trial_velocity"), self.normal)
            self._end = self.coupling.gaps() - step.gap_rate * approach
            gap = (1 - share) * gap + share * self._end
        k.gap.x.array[:] = gap
        start = _dot(self.jump, self.normal)  # as the operators of this step see it
        self._start_jump_n = np.where(np.abs(start) <= self._resolution, 0.0, start)
        k.start_jump_n.x.array[:] = self._start_jump_n
        rate = share * step.gap_rate
        self.equations.set_rates(rate, step.span, step.limit_rate, step.horizon)
        if self._remembers:
            rate = step.scheme.force_weight * (step.dt - step.gap_rate)
            k.elongation.x.array[:] = (self._stretch + rate * self.jump).ravel()
            k.start_gap.x.array[:] = self.gap
            k.mean_share.value = step.mean_share
            k.force_rate.value = step.scheme.force_weight * step.gap_rate
            self.equations.refresh()
        self.coupling.linearise(step, exact, share)

    def _set_normal(self, normal: np.ndarray) -> None:
        self.normal = np.ascontiguousarray(normal)
        self.equations.fields.set_normal(self.normal)

    def units(self, step: Step) -> np.ndarray:
        """The pressures that stop 1 m/s of each point alone within the step, along its normal and
        its tangents, (2, n); kept while the length of the step does not change by much."""
        octave = float(frexp(step.span)[1])
        if self._octave != octave:
            mobility = self.coupling.mobility()
            normal = (mobility * self.normal**2).sum(axis=1)
            tangential = (mobility.sum(axis=1) - normal) / (self.surface.dim - 1)
            flexible = np.array([normal, tangential]) * self.equations.weight
            self._units = np.array([_units(each) for each in flexible])
            if self._paired:
                self._units *= MEETING
            self._octave, self._mobility = octave, float(mobility.max())
        return self._units

    def push(self, force: np.ndarray, step: Step) -> float:
        """The speed that forces on the points (N) would give to one alone, m/s."""
        largest = float(np.abs(force).max(initial=0.0))
        if not largest:
            return 0.0
        self.units(step)
        return largest * self._mobility

    def start(self, free: np.ndarray) -> None:
        """Starting values of a step, from the velocities of the points without contact, flat."""
        jump = self.coupling.to_jump(free)
        self.equations.start(self.jump.ravel(), jump.ravel())

    def limit(self, step: Step) -> np.ndarray | None:
        """The w_n that the law allows at each point at most, None for springs."""
        return self.formulation.limit(
            StepData(
                gap=self.equations.fields.gap.x.array,
                start_jump_n=self._start_jump_n,
                gap_rate=step.gap_rate,
                limit_rate=step.limit_rate,
                horizon=step.horizon,
            )
        )

    def approaches(self, step: Step, where: np.ndarray) -> np.ndarray:
        """Points that start the step faster than its law allows, by more than the last step
        resolved, among ``where`` (n,)."""
        return where & self.chosen & self.coupling.near() & (self._excess(step) > self._resolution)

    def struck(self, step: Step, points: np.ndarray) -> bool:
        """Whether one of these points is faster than its law allows by more than what the loads of
        the step change: less is a body coming to rest, which the step itself can stop. Solids and
        traces are linearised about the prediction of the step."""
        for trace in self.traces:
            trace.linearise(step)
        self.coupling.begin(step)
        free = self.coupling.to_jump(np.concatenate([t.free_jump() for t in self.traces]))
        change = np.abs(_dot(free - self._struck_jump(), self.coupling.normals()))
        return bool((self._excess(step) > change)[points].any())

    def _excess(self, step: Step) -> np.ndarray:
        """How much faster than its law allows each point starts the step, (n,) in m/s."""
        self.coupling.begin(step)
        approach = _dot(self._struck_jump(), self.coupling.normals())
        return np.asarray(approach + np.minimum(self.gap, 0.0) / step.horizon)

    def _struck_jump(self) -> np.ndarray:
        """w at the start of the begun step, if it starts with a percussion, (n, d)."""
        return self.coupling.struck_jump() if self.coupling.driven else self.jump

    def astray(self, step: Step) -> np.ndarray:
        """How much deeper each point is in the trial state than its velocities say, (n,) in m."""
        way = step.gap_rate * _dot(self.trial_jump, self.normal)
        way += (step.dt - step.gap_rate) * self._start_jump_n
        return np.asarray(self.coupling.gaps() - self.gap - way)

    def farthest(self) -> float:
        """The largest coordinate of its points, m."""
        return float(np.abs(self.coupling.positions()).max())

    def normal_rows(self, points: np.ndarray) -> list[np.ndarray]:
        """For each solid the derivatives of the gaps of these points by its unknowns."""
        d, normals = self.surface.dim, self.normal[points]
        rows = (points[:, None] * d + np.arange(d)).ravel()
        operators = self.coupling.jump_rows(rows)
        return [np.einsum("pi,pij->pj", normals, J.reshape(len(points), d, -1)) for J in operators]

    def follow(self) -> None:
        """Follow the solids to their trial states, which have just been computed."""
        self.coupling.follow()
        self.trial_jump = self.coupling.jump("trial_velocity")

    def error(self, step: Step) -> tuple[float, float, float]:
        """Follow the solids to their trial states, which have just been computed; by how much the
        jumps [m/s] and gaps [m] there differ from the linearised ones over the candidates, and
        the largest speed [m/s] of a point."""
        self.follow()
        points = self.equations.candidates
        if not len(points):
            return 0.0, 0.0, 0.0
        linear = self.equations.values[: self.equations.jumps].reshape(self.normal.shape)
        jump = np.abs(self.trial_jump - linear)[points].max()
        gap = 0.0
        if self.formulation.gap_share:
            expected = self._end + step.gap_rate * _dot(linear, self.normal)
            gap = float(np.abs(self.coupling.gaps() - expected)[points].max())
            gap = max(0.0, gap - ROUND_OFF * float(np.abs(self.coupling.positions()).max()))
        return float(jump), gap, float(np.abs(self.trial_jump).max())

    def violation(self, step: Step) -> float:
        """By how much the rows of the candidates fail with the jumps and gaps of the trial state,
        in shares of the speeds of the step and of the forces that stop them."""
        e, k, share = self.equations, self.equations.fields, self.formulation.gap_share
        if not len(e.candidates):
            return 0.0
        before, gap = e.values, k.gap.x.array.copy()
        values = before.copy()
        values[: e.jumps] = self.trial_jump.ravel()
        e.values = values
        if share:
            way = step.gap_rate * _dot(self.trial_jump, self.normal)
            k.gap.x.array[:] = (1 - share) * self.gap + share * (self.coupling.gaps() - way)
        n = len(e.active_jumps)
        rows = e.active_residual()[n:] * e.scales()[1][n:]
        e.values, k.gap.x.array[:] = before, gap
        pushed = self.push(-e.residual()[e.active_jumps], step)
        return float(np.abs(rows).max(initial=0.0)) * e.speed / max(e.speed, pushed)

    def trial_work(self, step: Step) -> tuple[float, float]:
        """Work of the contact forces on the jumps of the step in the trial state, and what they
        would do at most at the speed of the step, J."""
        e = self.equations
        if not len(e.active_jumps):
            return 0.0, 0.0
        mean = step.mean(self.jump, self.trial_jump).ravel()[e.active_jumps]
        force = e.residual()[e.active_jumps]
        return -step.span * float(force @ mean), step.span * e.speed * float(np.abs(force).sum())

    def _statuses(self, step: Step, resolution: float) -> np.ndarray:
        """Statuses in the trial state; what moves along the surface by less than ``resolution``,
        m/s, sticks, and a point whose force would move it by less is open, whatever round-off says
        where hardly anything presses."""
        status = self.equations.statuses()
        along = self.trial_jump - _dot(self.trial_jump, self.normal)[:, None] * self.normal
        status = np.where(np.linalg.norm(along, axis=1) <= resolution, status.clip(max=1), status)
        hardly = self.units(step)[0] * self.equations.weight * resolution
        return np.where(np.abs(_dot(self.force, self.normal)) <= hardly, 0.0, status)

    def accept(self, force: np.ndarray, step: Step, resolution: float) -> None:
        """Keep what the next step starts from.

        Args:
            force: on the traces' points, flat, N.
            step: that was solved.
            resolution: speeds below it are none, m/s.
        """
        self.equations.release()
        self._moved = step.dt
        speeds = self.coupling.velocities("trial_velocity")  # where a wall moves, not small
        resolution = max(resolution, ROUND_OFF * float(np.abs(speeds).max(initial=0.0)))
        self.force = self._nodal_force() if self._paired else force.reshape(self.normal.shape)
        self.status = self._statuses(step, resolution)
        if self._remembers and self.friction_law is not None:
            self._keep_stretch(step, getattr(self.formulation, "stiffness_t", np.inf))
        self._resolution = resolution
        self.coupling.accept()
        self.gap, self.jump = self.coupling.gaps(), self.trial_jump
        self._start()

    def _nodal_force(self) -> np.ndarray:
        """Forces on the slave at the nodes of the surface, (n, d) in N."""
        force = np.zeros(self.equations.jumps)
        active = self.equations.active_jumps
        if len(active):
            force[active] = -self.equations.residual()[active]
        return force.reshape(self.normal.shape)

    def _keep_stretch(self, step: Step, stiffness: float) -> None:
        """Stretch of the tangential springs: elastic while they stick, returned on slip; a law
        without such a stiffness has none."""
        tangential = self.force - _dot(self.force, self.normal)[:, None] * self.normal
        held = -tangential / stiffness
        stuck = self._stretch + (held - self._stretch) / (step.scheme.force_weight or 1.0)
        self._stretch = np.where((self.status == 1)[:, None], stuck, held)

    # -- what it tells --------------------------------------------------------------------------

    def work(self, means: Mapping[int, np.ndarray], step: Step) -> tuple[float, float, float]:
        """Work of the contact on its solids in the step, J, from their mean velocities (by id): of
        the normal and of the friction forces on the jumps, which both are losses, and of what
        drives the other side."""
        if not self.force.any():
            return 0.0, 0.0, 0.0
        jump, span = self.coupling.mean_jump(means, step), step.span
        total = span * float((self.force * jump).sum())
        normal = span * float((_dot(self.force, self.normal) * _dot(jump, self.normal)).sum())
        driven = span * float((self.force * self.coupling.carried(step)).sum())
        return normal, total - normal, driven

    def counts(self) -> tuple[int, int]:
        """Points that bear, and that slip, in the last step."""
        return int(np.count_nonzero(self.status)), int(np.count_nonzero(self.status > 1))

    def depth(self) -> float:
        """Penetration of the deepest point, m."""
        return max(0.0, float(self.gap[self.chosen].max()))

    @property
    def multiplier(self) -> np.ndarray | None:
        """lam at the nodes in the last step, Pa (N for point multipliers), None for springs."""
        return self.equations.multiplier

    def state(self) -> dict[str, np.ndarray]:
        """The arrays from which :meth:`restore` continues identically."""
        return {
            "unknowns": self.equations.values,
            "status": self.status,
            "force": self.force,
            "stretch": self._stretch,
            "tangent": self.equations.fields.tangent,
            "units": self._units,
            "octave": np.array([self._octave, self._mobility, self._resolution, self._moved]),
            **self.coupling.state(),
        }

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Take up a state that :meth:`state` gave; the solid has been restored before."""
        self.equations.values = np.array(state["unknowns"])
        self.status, self.force = np.array(state["status"]), np.array(state["force"])
        self._stretch, self._units = np.array(state["stretch"]), np.array(state["units"])
        self._octave, self._mobility, self._resolution, self._moved = map(float, state["octave"])
        self.coupling.restore(state)
        self._locate()
        self.equations.fields.set_tangent(np.array(state["tangent"]))

    def describe(self) -> str:
        """What is there and what was left out."""
        k, n = self.equations.fields, int(self.chosen.sum())
        parts = [f"{self.formulation.name}, {n} points of {self.solid.name!r}"]
        parts.append(f"before {self.coupling.describe()}")
        parts.append(self.friction_law.describe() if self.friction_law else "no friction (no tau)")
        unknowns = n * (k.components - self.surface.dim)
        parts.append(f"{unknowns} multipliers" if unknowns else "springs (no multipliers)")
        return ", ".join(parts)


def _check_master(solid: Solid, facets: str, master: Any) -> Master:
    """The master as given, or a refusal."""
    if not isinstance(master, tuple):
        checks.instance(
            "master", master, Obstacle, "an obstacle (HalfSpace, ...) or (solid, name of facets)"
        )
        if master.dim != solid.dim:
            raise checks.InputError(
                f"master = {master!r}: has dimension {master.dim}, the solid {solid.dim}"
            )
        return master
    if len(master) != 2 or not isinstance(master[1], str):
        raise checks.InputError(f"master = {master!r}: must be (solid, name of facets)")
    other, theirs = checks.offers("master[0]", master[0], Solid, "a solid"), master[1]
    if other.dim != solid.dim:
        raise checks.InputError(
            f"master = ({other.name!r}, {theirs!r}): has dimension {other.dim}, "
            f"{solid.name!r} has {solid.dim}"
        )
    if other is solid and theirs == facets:
        raise checks.InputError(
            f"master = ({other.name!r}, {theirs!r}): a surface cannot be in contact with itself; "
            "name the two parts that may meet"
        )
    return other, theirs


def _units(flexible: np.ndarray) -> np.ndarray:
    """1 over these, (n,); where they vanish (held points, points without area) as at the median of
    the others, or 1."""
    there = flexible > 0
    usual = float(np.median(flexible[there])) if there.any() else 1.0
    return 1 / np.where(there, flexible, usual)


def _dot(a: Any, b: Any) -> np.ndarray:
    return (a * b).sum(axis=1)
