# SPDX-License-Identifier: LGPL-3.0-or-later
"""A contact: a solid's facets against an obstacle or another solid's, with or without friction.
It follows the solids through a step and feeds gaps and normals to the equations of its surface."""

from __future__ import annotations

import numpy as np

from ..base import checks
from ..base.constants import ROUND_OFF
from ..base.vectors import dot, largest, orthogonal
from ..solids import Solid
from ..theory.formulations import Formulation
from ..theory.formulations import formulation as as_formulation
from ..theory.friction import FrictionBound, friction_bound
from ..theory.scheme import Step
from .blows import Blows, struck_gap
from .candidates import Candidates
from .clearance import Clearance
from .equations import SurfaceEquations
from .jump import Coupling
from .pairing import Master, acting_points, check_master, couple, worn
from .results import SurfaceResults
from .scales import Scaled, Scales
from .sharing import Sharing
from .springs import TangentialSprings
from .statuses import coming, kept, leaving
from .surface import Surface
from .surfaces import surface_of
from .turning import start_speeds, turning

KEPT = "status", "force", "borne", "arriving", "force_normal"  # of its state


class Contact(Scaled, SurfaceResults):
    """A contact between the named facets of a solid (slave) and what they may touch (master).

    Args:
        solid: the slave; of two solids better the softer, or of two alike the finer one.
        facets: the name of its facets in contact.
        master: an obstacle, or another solid and the name of its facets; the same ones: itself.
        formulation: a formulation or its name; see :mod:`fenicsx_contact.theory.formulations`.
        friction: Coulomb's coefficient, a number or a function of x or (x, t) in UFL, or a law of
            friction (see :mod:`fenicsx_contact.theory.friction`); 0 leaves friction out.
        normal_augmentation, tangential_augmentation: pure numbers; rho_n and rho_t are these
            times values scaled by the scene. They act on the way to the solution, not on it.
        gap_tolerance: share of the surface's extent to which the arrival of a point is located.
        clearance: of two solids that stay opposite each other, m at the start (< 0: they
            interfere), a number or a function of x (d, n), in place of what their meshes say.
        name: for messages and files.

    Attributes:
        gap, jump: at the start of the step, m, m/s; ``trial_jump``, ``trial_status``: in its trial.
        start_positions: of its points, (n, d) in m; ``start_jump_n``: w_n at the start, by the
            operators of the step; ``end_gap``: at its end if nothing approached.
        resolution: speeds below it, m/s, the last step did not resolve.
        moved: length of the step, s, of which the multipliers are: the last one, or one tried.
        noise: distances below it, m, are round-off of the places.
        candidates: of the step; ``blows``: within the step of the run; ``memory``: of its laws.
        status, force: of the last step: 0 open, 1 stick, 2 slip; mean on the solid, N; ``borne``:
            on its nodes, ``acting``: with its moment, too; ``arriving``: how fast what bears came.

    Raises:
        InputError: friction < 0 or NaN, unknown formulation or facets, dimensions that differ,
            points of a formulation that are no nodes of the facets, surfaces that do not face
            each other anywhere, a rigid solid before itself.
    """

    #: Whether its forces only take energy, say the solids' books; steps settle on frozen geometry.
    gives_nothing, settles = True, False

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
        clearance: Clearance = None,
        name: str | None = None,
    ) -> None:
        checks.offers("solid", solid, Solid, "a solid")
        other = self._meant(solid, facets, master)
        self.solid, self.facets, self.formulation = solid, facets, as_formulation(formulation)
        self.friction, self.friction_law = friction, friction_bound(friction)
        augmentation = (
            checks.number("normal_augmentation", normal_augmentation, above=0),
            checks.number("tangential_augmentation", tangential_augmentation, above=0),
        )
        self._paired = isinstance(other, tuple)
        self.surface = self._make_surface()
        self.name = checks.label("name", f"{solid.name}.{facets}" if name is None else name)
        share = checks.number("gap_tolerance", gap_tolerance, at_least=0)
        self.tolerance = share * self.surface.extent

        self.chosen, weight = acting_points(self.surface, self.formulation, facets)
        if self._paired and weight is self.surface.area:
            weight = weight.copy()  # by what of it is paired
        rows = self.formulation, self.friction_law, self.chosen, weight, augmentation
        self.equations = SurfaceEquations(self.surface, *rows, turning(other))
        self.memory = self.equations.fields.memory
        self.coupling = coupling = self._couple(other, clearance)
        coupling.recess = worn(self.memory, self.formulation)
        self.solids, self.traces, self.part = coupling.solids, coupling.traces, coupling.part
        self.force, self.status = np.zeros(self.surface.points.shape), np.zeros(self.surface.size)
        self.borne, self.arriving = self.force, np.full(self.surface.size, np.inf)
        self.candidates = Candidates(self.equations, self.coupling, self.formulation)
        self.sharing = Sharing(self)
        self._springs = TangentialSprings(self.equations, self.formulation)
        self.blows, self.scales = Blows(self.surface.size), Scales(coupling, self.surface.size)
        self.resolution, self.moved = ROUND_OFF * largest(coupling.velocities("velocity")), 1.0
        self._told: Step | None = None  # of whose start the equations know
        self.force_of = 1.0  # how long the step took of which the forces are, s
        self._set_normal(self.coupling.normals())
        self.trial_status, self.force_normal = self.status, self.normal
        self.locate()

    def _meant(self, solid: Solid, facets: str, master: Master) -> Master:
        return check_master(solid, facets, master)

    def _couple(self, other: Master, clearance: Clearance) -> Coupling:
        return couple(self.solid, self.facets, self.equations, other, self.formulation, clearance)

    def _make_surface(self) -> Surface:
        return surface_of(self.solid, self.facets, self._paired)

    def locate(self) -> None:
        """Gap (n,) and jump (n, d) at the start of a step."""
        self.gap, self.jump = self.coupling.gaps(), self.coupling.jump("velocity")
        self._start()

    def _start(self) -> None:
        """Frame from which the next step starts, and round-off of the distances in it."""
        self.start_positions = at = self.coupling.positions()
        self.noise, self.start_normal = ROUND_OFF * largest(at), self.coupling.keep_normals()
        self._springs.begin(self.start_normal, self.coupling.positions)
        if not self.coupling.fixed_normal:
            self.equations.fields.keep_frame()

    # -- the step -------------------------------------------------------------------------------

    def begin(self, step: Step) -> None:
        """Take up what the other side does in the step, from the state at its start."""
        self.coupling.begin(step)
        if self.coupling.stand(self.status > 0, step):
            self.locate()
        if self._paired:
            self.scales.renew()

    def predict(self, step: Step, closing: bool = True) -> None:
        """Follow the solids' prediction of the begun step; what may be its candidates: points that
        are open now only if ``closing``, or put to rest, in a percussion only those of a law of
        velocities."""
        if bool(step.dt) != bool(self.moved):  # impulses are alike in a percussion and a step
            self.equations.scale_multipliers((self.moved or 1.0) / step.span)
        self.moved, self._told = step.dt, None
        self.equations.turn(False)
        if self.coupling.driven:
            self.jump = self.coupling.jump("velocity")
        self.coupling.follow()
        self.sharing.spread()
        asked = self.chosen if closing else self.blows.closed(self, step)
        self.candidates.begin(asked & self.chosen, self.gap, self.tolerance, step)

    def screen(self, free: np.ndarray, step: Step) -> None:
        """Narrow the candidates to points that bore, or would do what the law forbids without
        contact, by the free velocities of the traces' points, flat; :meth:`grow` finds more."""
        bore = (self.status > 0) | self.equations.fields.held
        self.candidates.narrow(bore, free, step)
        if self._paired:  # its operators are those of the candidates
            self.coupling.linearise(step, False, self.formulation.gap_share)

    def grow(self, step: Step) -> bool:
        """Let points be candidates that do what the law forbids in the trial state; if any do."""
        return self.candidates.widen(self.trial_jump, step)

    def touching(self) -> np.ndarray:
        """Points that bore in the last step, unless an impact threw them back, are inside at the
        start of this one, or touch there and do not leave, (n,) of bool; the others are open."""
        stays = dot(self.jump, self.coupling.start_normals()) >= -self.resolution
        at = (self.gap > self.tolerance) | ((self.gap >= -self.tolerance) & stays)
        thrown = getattr(self.formulation, "rebounds", False) and not self.force_of
        return self.chosen & (((self.status > 0) & (stays | (not thrown))) | at)

    def linearise(self, step: Step, exact: bool = False, kept: bool = False) -> None:
        """Take up the trial states of the solids: operators, normals and gaps; if ``exact`` with
        the derivatives of all these, between solids those of last time if ``kept``."""
        for trace in self.traces:
            trace.linearise(step)
        k, share = self.equations.fields, self.formulation.gap_share
        if self._paired:
            if not self.formulation.at_points:
                self.equations.set_weight(self.coupling.area)
            self.candidates.choose()
        if not self.coupling.fixed_normal:
            self._set_normal(self.coupling.normals())
        if self._told is not step or not self.coupling.fixed_normal:
            self._tell(step)
        if share:
            # the gap at the end of the step as a function of w: end + gap_rate w_n
            approach = dot(self.coupling.jump("trial_velocity"), self.normal)
            self.end_gap = self.coupling.gaps() - step.gap_rate * approach
            self.equations.gap[:] = (1 - share) * self._start_gap + share * self.end_gap
            self.candidates.renew()
        if k.feed(self, step):
            self.equations.refresh()
        self.equations.set_rates(share * step.gap_rate, step.span, step.limit_rate, step.horizon)
        self._springs.linearise(step, self.gap, self.jump, self.coupling.positions)
        self.coupling.linearise(step, exact, share, kept)

    def _tell(self, step: Step) -> None:
        """Tell the equations how the step starts."""
        gap = self.coupling.begun_gaps(self.gap, step) if step.dt else struck_gap(self, step)
        # what less than the resolved speed would close is closed, and what round-off opened
        closed = max(self.resolution * step.horizon, self.noise)
        self._start_gap = np.where((gap < 0) & (gap >= -closed), 0.0, gap)
        self._told, e = step, self.equations
        touches = (self.status > 0) | (self.gap >= -self.tolerance)
        ends = self.start_normal, self.normal
        start = start_speeds(e.fields, self.coupling, step, self.jump, ends, touches)
        still = (np.abs(start) <= self.resolution) | (self.blows.settled & (not step.dt))
        self.start_jump_n = np.where(still, 0.0, start)  # what is put to rest does not rebound
        e.gap[:], e.start_jump_n[:] = self._start_gap, self.start_jump_n
        e.fields.set_start_slip(self.jump, self.status == 1, self.resolution)
        self.candidates.renew()

    def _set_normal(self, normal: np.ndarray) -> None:
        self.normal = np.ascontiguousarray(normal)
        self.equations.fields.set_normal(self.normal)

    def start(self, free: np.ndarray) -> None:
        """Starting values of a step, from velocities of the points that did not bear, flat."""
        self.equations.start(self.jump, self.coupling.to_jump(free), self.status > 0)

    def follow(self) -> None:
        """Follow the solids to their trial states, which have just been computed."""
        self.coupling.follow()
        self.trial_jump = self.coupling.jump("trial_velocity")

    def accept(self, force: np.ndarray, step: Step, resolution: float) -> None:
        """Keep what the next step starts from.

        Args:
            force: on the traces' points, flat, N.
            step: that was solved.
            resolution: speeds below it are none, m/s; so is round-off of those of the points.
        """
        e, fastest = self.equations, largest(self.coupling.velocities("trial_velocity"))
        e.release()
        self.resolution = resolution = max(resolution, ROUND_OFF * fastest)
        thrown = getattr(self.formulation, "rebounds", False) and not self.force_of
        left = leaving(self.jump, self.normal, self.surface.extent, step, thrown)
        self.force, self.force_of = self.coupling.force(force), step.dt
        self.borne = self.coupling.borne(self.force, force)
        self.force_normal = e.fields.mean_normal()
        hardly = self.units(step)[0] * e.weight * resolution
        presses = e.pressed(dot(self.force, self.normal)) > hardly
        slip = orthogonal(self.normal, self.trial_jump)
        self.status = kept(self.trial_status, presses, slip, e.fields.back, resolution)
        self.arriving = np.where(self.status > 0, coming(self.gap, left, step.horizon), np.inf)
        self._springs.accept(step, self.force - self.normal_forces, self.status == 1)
        if self.memory.values:
            told = self._springs.slips(self.candidates.told(self.trial_jump, step), self.normal)
            self.memory.advance(e, told, step.dt)
        self.coupling.accept()
        self.gap, self.jump = self.coupling.gaps(), self.coupling.arrived(self.trial_jump)
        self._start()

    def state(self) -> dict[str, np.ndarray]:
        """The arrays from which :meth:`restore` continues identically."""
        return {
            **{name: getattr(self, name) for name in KEPT},
            "unknowns": self.equations.values,
            "stretch": self._springs.stretch,
            "normal": self.normal,
            "tangent": self.equations.fields.tangent,
            "last": np.array([self.resolution, self.moved]),
            **self.memory.state(),
            **self.scales.state(),
            **self.sharing.state(),
            **self.coupling.state(),
        }

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Take up a state that :meth:`state` gave; the solid has been restored before."""
        self.equations.values = np.array(state["unknowns"])
        for name in KEPT:
            setattr(self, name, np.array(state[name]))
        self._set_normal(state["normal"])
        self._springs.stretch = np.array(state["stretch"])
        self.resolution, self.moved = map(float, state["last"])
        self.force_of = self.moved
        for each in self.memory, self.scales, self.sharing, self.coupling:
            each.restore(state)
        self.locate()
        self.equations.fields.set_tangent(np.array(state["tangent"]))
