# SPDX-License-Identifier: LGPL-3.0-or-later
"""The contact of a rod with its guide.

It is a contact like any other, with the same fields, formulations and weak form; only where its
points are is its own affair. The nodes of a stretch of the rod meet the walls of the tubes; the
stations of the guide meet the rod, wherever along the rod they are just now.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import checks
from ..base.constants import SAME
from ..base.signatures import whole
from ..base.vectors import dot
from ..contact.contact import Contact
from ..contact.surface import Surface
from ..theory.formulations import Formulation, Velocity
from ..theory.friction import FrictionBound
from ..theory.scheme import Step
from .beam import BeamSolid
from .coupled_trace import CoupledTrace
from .coupling import GuideCoupling
from .guide import Guide
from .trace import BeamTrace
from .tube import PairTrace, RodInTube

#: Penetration that a rod may start or settle with, or enter a hole with, as a share of the smallest
#: clearance.
DEEPEST = 0.05
#: The velocity law of a rod that slides past walls that are bent: of what it drifts into them a
#: tenth is taken back in a step. Without that drops are 0.02 to 0.4 % too short.
VELOCITY = Velocity(drift_correction=0.1)


@whole
class GuideContact(Contact):
    """A contact between a stretch of a beam and a guide around it.

    Laws of areas (a Compliance, Tresca's friction, viscosity, wear) act per length of the rod that
    lies in tubes; a card has no length: outside of tubes it stands for half of the way to the
    stations beside it.

    Args:
        solid: the rod, or the rod and its elastic tube.
        facets: the name of the stretch of its axis that is guided.
        obstacle: the guide.
        formulation: the velocity law that takes drift back, or any other.
        others: as for :class:`~fenicsx_contact.contact.contact.Contact`.
        deepest: penetration that is accepted where it starts or enters a hole, as a share of the
            smallest clearance.

    Attributes:
        deepest: that penetration, m.
        measured: whether a law reads areas: along the rod, lengths of it (see measure.py), which
            change as it slides past the stations; forces that are in proportion need none.
        step: the last one, None before the first.

    Raises:
        InputError: no beam or guide, axes that are not parallel, a rod that is longer than its
            guide allows, a guide too bent for the rod as it starts or too narrow, a guide that
            moves around an elastic tube, and what Contact refuses.
    """

    solid: BeamSolid | RodInTube
    obstacle: Guide
    trace: BeamTrace | PairTrace
    coupling: GuideCoupling

    def __init__(
        self,
        solid: BeamSolid | RodInTube,
        facets: str,
        obstacle: Guide,
        formulation: Formulation | str = VELOCITY,
        friction: float | FrictionBound = 0.0,
        *,
        deepest: float = DEEPEST,
        **others: Any,
    ) -> None:
        checks.instance("solid", solid, (BeamSolid, RodInTube), "a BeamSolid or a RodInTube")
        checks.instance("obstacle", obstacle, Guide, "a Guide")
        if obstacle.moving and isinstance(solid, RodInTube):
            raise checks.InputError(
                "obstacle: a guide that moves takes no elastic tube along, whose inertia bends it"
            )
        if obstacle.dim == solid.dim:
            _check_place(solid.rod, facets, obstacle)
        share = checks.number("deepest", deepest, at_least=0)
        self.obstacle = obstacle
        self.deepest = share * float(obstacle.clearance().min())
        self.step: Step | None = None
        super().__init__(solid, facets, obstacle, formulation, friction, **others)
        # what touches at the start bears: whether it opens is for the law to say
        self.status = (self.gap >= -self.tolerance).astype(float)
        if reason := self.coupling.tight:
            raise checks.InputError(reason)
        worst = int(self.gap.argmax())
        if self.gap[worst] > self.deepest:
            depth = float(obstacle.depth(self.trace.positions())[worst])
            raise checks.InputError(
                f"obstacle: the guide is too bent for its clearance where the rod starts: at the "
                f"depth {depth:.4g} m the rod is {self.gap[worst]:.4g} m inside its wall; let the "
                "rod settle first (rods.settle)"
            )

    @property
    def gives_nothing(self) -> bool:  # type: ignore[override]
        """Not where a drive holds the rod at its speed, which pays for what walls push: the rod's
        own books say."""
        law = self.solid.rod.law
        return law is None or law.prescribed is None

    def _make_surface(self) -> Surface:
        """The nodes of the stretch, and beside them the stations, joined by cells of their own."""
        axis, guide = self.solid.rod.axis, self.obstacle
        points, cells, kind = axis.boundary(self.facets)
        along = axis.along(guide.origin + guide.stations[:, None] * guide.direction)
        count = len(points)
        # beside the axis: a station may stand where a node is
        self._beside = axis.length * self.solid.rod.frame[0]
        stations = axis.origin + along[:, None] * axis.direction + self._beside
        if len(stations) == 1:
            raise checks.InputError("obstacle: a guide needs two stations at least (two cards)")
        chain = count + np.stack([np.arange(len(along) - 1), np.arange(1, len(along))], axis=1)
        surface = Surface(np.concatenate([points, stations]), np.concatenate([cells, chain]), kind)
        off = (surface.points - axis.origin) @ self.solid.rod.frame[0]
        self.stations = np.flatnonzero(off > 0.5 * axis.length)
        # in the order of the guide's
        self.stations = self.stations[np.argsort(guide.depth(surface.points[self.stations]))]
        laws = [each for each in (self.formulation, self.friction_law) if each is not None]
        areas = any(vars(type(law)).get("reads_areas", True) for law in laws)
        self.measured = areas and not self.formulation.at_points
        if self.measured:
            surface.area, surface.slides = surface.area.copy(), True
        self._turn = self.solid.rod.frame @ guide.lateral.T
        return surface

    def _couple(self, other: Any, clearance: Any) -> GuideCoupling:
        rod = self.solid.rod
        s = rod.axis.along(self.surface.points)
        within = rod.axis.stretch(self.facets)
        stand = s[self.stations]
        self.trace = self.solid.around(rod.sight(s, self.stations, lambda: stand, within))
        coupling = GuideCoupling(self, self.trace, self._turn)
        if isinstance(self.trace, CoupledTrace) and self.formulation.multipliers:  # no springs
            self.trace.normals = coupling.normals
            self.trace.roundness = coupling.roundness if self.surface.dim == 3 else None
        return coupling

    def predict(self, step: Step, closing: bool = True) -> None:
        super().predict(step, closing)
        # a law of positions would put a tip that comes beside a hole into it
        if self.formulation.gap_share and (reason := self.coupling.butts()):
            raise checks.StepFailed(reason)
        # the rod slides past: with which velocity the step starts is for its own operator to say,
        # the one by which forces act; that of the last step saw other material
        self.jump = self.coupling.jump("velocity")

    def start(self, free: np.ndarray) -> None:
        # a slender rod that is held at one point seldom presses beside it, though it would if it
        # were free: who does not bear starts open
        self.equations.start(self.jump, self.jump, self.status > 0)

    def linearise(self, step: Step, exact: bool = False, kept: bool = False) -> None:
        if self.measured:
            self.trace.linearise(step)
            self._weigh(self.coupling.area)
        super().linearise(step, exact, kept)

    @property
    def _foretold(self) -> bool:
        """What settles on frozen geometry in the plane, and reads no gap of the end, keeps the
        normals that the start of a step foretells, however often it is linearised."""
        settles = self.settles and self.surface.dim == 2 and not self.formulation.gap_share
        return settles and self._told is not None

    def _set_normal(self, normal: np.ndarray) -> None:
        if not self._foretold:
            super()._set_normal(normal)

    def _tell(self, step: Step) -> None:
        if not self._foretold:
            super()._tell(step)

    def _weigh(self, lengths: np.ndarray) -> None:
        """The points stand for other lengths, (n,) in m, and what stops them changes with these."""
        if not np.array_equal(lengths, self.equations.weight):
            self.equations.set_weight(lengths)
            self.scales.renew()

    def begin(self, step: Step) -> None:
        super().begin(step)
        self.coupling.follow()
        self.jump = self.coupling.jump("velocity")

    def accept(self, force: np.ndarray, step: Step, resolution: float) -> None:
        super().accept(force, step, resolution)
        self.step = step

    @property
    def multiplier(self) -> np.ndarray | None:
        lam, lengths = super().multiplier, self.coupling.area
        if lam is None or self.formulation.at_points:
            return lam
        return lam * self.equations.weight / np.where(lengths > 0, lengths, np.inf)

    def state(self) -> dict[str, np.ndarray]:
        lengths = {"lengths": self.equations.weight} if self.measured else {}
        return {**super().state(), **lengths}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        self._told = None  # of no step
        if self.measured:
            self._weigh(np.array(state["lengths"]))
        super().restore(state)

    def normal_force(self) -> float:
        """Sum of the sizes of the normal forces in the last step, N (in an impact N s)."""
        return float(np.abs(dot(self.force, self.force_normal)).sum())

    def axial_force(self) -> tuple[float, float]:
        """Forces along the travel in the last step, of the normals and of friction, N (in an
        impact N s)."""
        down = -self.solid.rod.axis.direction
        pushed = float((self.normal_forces @ down).sum())
        return pushed, float((self.force @ down).sum()) - pushed


def _check_place(rod: BeamSolid, stretch: str, guide: Guide) -> None:
    """Refuse a guide that is not parallel to the rod, or too short for it."""
    if np.linalg.norm(rod.axis.direction + guide.direction) > SAME:
        raise checks.InputError(
            f"obstacle: a guide must run down the rod's axis, {(-rod.axis.direction).tolist()}, "
            f"not along {guide.direction.tolist()}"
        )
    stop = rod.law.stop if rod.law else None
    refuse_beyond(rod, stretch, guide, rod.travel if stop is None else max(rod.travel, stop))


def tip_depth(rod: BeamSolid, stretch: str, guide: Guide, travel: float) -> float:
    """Depth of the lower end of the guided stretch at a travel, m, if it is stretched as now."""
    low, axial = rod.axis.stretch(stretch)[0], rod.split(rod.displacement)[1]
    k = rod.matrices
    ahead = rod.travel + np.interp(low, k.s, np.broadcast_to(axial, k.s.shape))
    place = rod.axis.origin + (low + ahead) * rod.axis.direction
    return float(guide.depth(place[None])[0]) + travel


def refuse_beyond(rod: BeamSolid, stretch: str, guide: Guide, travel: float) -> None:
    """Refuse a travel [m] that takes the tip beyond the end of the guide."""
    end = tip_depth(rod, stretch, guide, travel)
    if end > guide.bottom:
        raise checks.InputError(
            f"solid: the tip of {rod.name!r} reaches the depth {end:.6g} m, beyond the end of its "
            f"guide at {guide.bottom:.6g} m: the rod is longer than its guide allows; where it may "
            "hang out, let a wide Card end the guide below"
        )
