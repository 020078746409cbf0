# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the points of a rod and the stations of its guide meet: gaps, normals, and what stops the
rod."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from ..base.constants import SAME
from ..base.vectors import dot, normalised
from ..contact.equations import SurfaceEquations
from ..contact.nodal import NodalJump
from ..theory.formulations import Formulation
from ..theory.scheme import Step
from .beam import BeamSolid
from .guide import Guide
from .measure import Lengths
from .trace import BeamTrace
from .tube import PairTrace, RodInTube


class Guided(Protocol):
    """What this needs of a :class:`~fenicsx_contact.rods.contact.GuideContact`."""

    solid: BeamSolid | RodInTube
    facets: str
    equations: SurfaceEquations
    obstacle: Guide
    formulation: Formulation
    stations: np.ndarray
    deepest: float
    measured: bool


class GuideCoupling(NodalJump):
    """Points of a rod and stations of its guide: the stations see it by its slope, too."""

    encloses = True

    def __init__(self, contact: Guided, trace: BeamTrace | PairTrace, turn: np.ndarray) -> None:
        super().__init__(contact.solid, contact.equations, contact.obstacle, trace)
        self._guide, self._stations = contact.obstacle, contact.stations
        self._solid, self._rod = contact.solid, contact.solid.rod
        self._trace, self._own, self._turn = trace, trace.rod, turn
        self._rigid = contact.formulation.multipliers
        self._by_places = not self._rigid or contact.formulation.gap_share > 0
        self._deepest, self._side = contact.deepest, self._own.side.copy()
        self._lengths = Lengths(self._guide, self._own.material, self._stations)
        self._measured = contact.measured
        axis, (low, high) = self._rod.axis, self._rod.axis.stretch(contact.facets)
        # where the stretch ends and the rod goes on there is no tip
        tips = np.abs([low, high - axis.length]) <= SAME * axis.length
        self._faces = self._guide.faces & tips[:, None]
        self._at: np.ndarray | None = None
        self._begun: Step | None = None
        self._when = 0.0

    def _look(self) -> None:
        """Distances and normals of all points, in the trial state."""
        x = self._trace.positions()
        if x is self._at and (self._when == self.time or not self.driven):
            return
        self._at, self._when, guide, rows = x, self.time, self._guide, self._stations
        self._distances = guide.distance(x, self.time).copy()
        self._outward = guide.normals(x, self.time).copy()
        recess: Any = (0.0, 0.0)
        if (outline := self.outline()) is not None:
            along = self._outward @ guide.direction
            self._distances += outline[0] * np.sqrt(1 - along * along)
            recess = outline[0][rows], -outline[1][rows]
        if isinstance(self._trace, PairTrace):
            self._tilt(self._trace.tube.slopes() @ self._rod.frame)
        # the beam's slopes are by its own s, upwards, and in its own lateral directions
        slopes = -self._own.slopes()[rows] @ self._turn
        self._distances[rows], self._outward[rows] = guide.at_stations(
            x[rows], slopes, self.time, recess
        )
        self._distances[self._own.void] = guide.far

    def holes(self) -> tuple[np.ndarray, np.ndarray]:
        """Places of the points from the middle of their holes, (n, d - 1) in m, and what the rod
        has around it there where it is straight in the middle, (n,) in m; the guide's ``far`` where
        there is no hole, or no rod."""
        off, clearance = self._guide.holes(self._trace.positions(), self._stations, self.time)
        clearance[self._own.void] = self._guide.far
        if (outline := self.outline()) is not None:
            clearance += np.where(clearance < self._guide.far, outline[0], 0.0)
        return off, clearance

    def clearance(self) -> np.ndarray:
        """The latter."""
        return self.holes()[1]

    def keep_normals(self) -> np.ndarray:
        self._start_holes = self.holes()
        self._start_material = self._own.material.copy()
        self._was = super().keep_normals()
        return self._was

    def begin(self, step: Step) -> None:
        super().begin(step)
        self._begun = step

    def start_normals(self) -> np.ndarray:
        normals = self.normals()
        if self._begun is None or self.end_share(self._begun) == 1:
            return normals
        everywhere = np.ones(len(normals), dtype=bool)
        return self.begun(self._was, normals, everywhere, self._begun)[0]

    def begun(
        self, old: np.ndarray, new: np.ndarray, touches: np.ndarray, step: Step
    ) -> tuple[np.ndarray, np.ndarray]:
        """Those at the end, mirrored at the normals to the ways of the points: these are their
        mean. By laws of positions everywhere; by laws of velocities, which see one face strike at a
        kink, where points touch and slide on."""
        along, met = self._chords(new, step)
        if not self._by_places:
            turns = self.turns(old, new, step)
            turns[self._stations] = True  # which see the rod, that has no kinks
            met &= touches & turns
        mirrored = 2 * dot(along, new)[:, None] * along - new
        return np.where(met[:, None], mirrored, new), met

    def _chords(self, new: np.ndarray, step: Step) -> tuple[np.ndarray, np.ndarray]:
        """Normals n along which a force works as much as its point comes nearer to the wall,
        ``n . (x+ - x-) ~ d+ - d-``, whatever it passes on its way, and where there are any, (n,) of
        bool; else those at the end, ``new``, (n, d).

        A discrete gradient of ``d = |off| - c`` (O. Gonzalez (1996), J. Nonlinear Sci. 6, 449-467).
        What walls at rest do by a law of positions is then ``lam (d+ - d-) <= 0``.
        """
        guide, solid = self._guide, self._solid
        (old, before), (off, clearance) = self._start_holes, self.holes()
        way = self._trace.jump(solid.trial_displacement - solid.displacement).reshape(self._shape)
        if self.driven:
            way -= guide.displacement(step.end) - guide.displacement(step.start)
        across, down = way @ guide.lateral.T, way @ guide.direction
        # past a station slides what its end sees there
        rows = self._stations
        down[rows] = (self._own.material - self._start_material)[rows]
        # |b| - |a| = u . (b - a); who crosses the hole meets the wall at its end
        same = dot(old, off) > 0
        u, size = (off + old * same[:, None]), _sizes(off) + _sizes(old) * same
        met = (size > 0) & (np.abs(down) > SAME * guide.far) & bool(step.dt)
        met &= (before < guide.far) & (clearance < guide.far)
        u /= np.where(met, size, 1.0)[:, None]
        rise = dot(u, off - old - across) - (clearance - before)
        axial = rise / np.where(met, down, 1.0)
        normal = u @ guide.lateral + axial[:, None] * guide.direction
        return normalised(np.where(met[:, None], normal, new)), met

    @property
    def tight(self) -> str:
        """Where the rod does not fit into its hole, or ""."""
        if (outline := self.outline()) is None:
            return ""
        clearance = self.clearance()
        worst = int(clearance.argmin())
        if clearance[worst] > 0:
            return ""
        depth, recess = self._guide.depth(self._trace.positions())[worst], outline[0][worst]
        hole = clearance[worst] - recess
        return (
            f"recess = {recess:.6g}, clearance = {hole:.6g}: their sum must be > 0; "
            f"at the depth {depth:.6g} m {self._rod.name!r} does not fit into its hole"
        )

    def outline(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Recess of the rod's surface at the points, m, and its derivative by s, (n,) each; None of
        a rod that has none."""
        k = self._rod.matrices
        if not k.recess.any():
            return None
        cell, xi, _ = k.interpolate(self._own.material)
        step = np.diff(k.recess)[cell]
        return k.recess[cell] + xi * step, step / np.diff(k.s)[cell]

    def _tilt(self, slopes: np.ndarray) -> None:
        """Turn the normals with an elastic tube; its slopes are by s, as vectors (n, d)."""
        up = self._rod.axis.direction
        self._outward = normalised(self._outward - dot(self._outward, slopes)[:, None] * up)

    def near(self) -> np.ndarray:
        # a station that the rod has passed meets nothing, though it bore a moment ago
        there = ~self._own.void
        if self._measured:  # nothing acts where nothing weighs
            there &= self._lengths(self._own.material, self._own.void) > 0
        return there

    def met(self, gap: np.ndarray) -> np.ndarray:
        """Which points, of these gaps, have a wall beside them: what comes to be inside one as the
        rod reaches it has not arrived there."""
        return gap > -0.5 * self._guide.far

    @property
    def area(self) -> np.ndarray:
        """Lengths of the rod for which the points stood in the last step, (n,) in m."""
        return self._lengths(*self._own.acted)

    @property
    def blocked(self) -> str:
        """Where an end of the rod would go into the face of a tube or card, the rod is too thick,
        or beside its hole."""
        return self.tight or self.butts() or self._outside()

    def butts(self) -> str:
        """Where an end of the rod, in the followed state, goes into the face of a tube or card, or
        ""."""
        rows, guide = self._stations, self._guide
        (from_above, from_below), was = self._faces, self._side[rows]
        reached = (from_above & (was < 0) | from_below & (was > 0)) & ~self._own.void[rows]
        within = np.where(reached, self.gaps()[rows], 0.0)
        worst = int(within.argmax())
        if within[worst] <= self._deepest:
            return ""
        return (
            f"the tip of {self._rod.name!r} butts at the depth {guide.stations[worst]:.6g} m, "
            f"{within[worst]:.3g} m beside the hole: align the tubes, or let the hole begin wider "
            "(clearance = [(depth, clearance), ...])"
        )

    def _outside(self) -> str:
        """Where the rod is deeper in a wall than its hole is wide, or "": rigid walls let none."""
        gaps = self.gaps()
        if not self._rigid or gaps.max() <= self._deepest:
            return ""
        beyond = gaps - np.maximum(self.clearance(), self._deepest)
        worst = int(beyond.argmax())
        if beyond[worst] <= 0:
            return ""
        depth = self._guide.depth(self._trace.positions())[worst]
        return (
            f"{self._rod.name!r} leaves its guide sideways at the depth {depth:.6g} m, "
            f"{gaps[worst]:.3g} m inside its wall"
        )

    def accept(self) -> None:
        super().accept()
        self._side = self._own.side.copy()

    def _depths(self) -> np.ndarray:
        self._look()
        return -self._distances

    def normals(self) -> np.ndarray:
        self._look()
        return -self._outward

    def linearise(self, step: Step, exact: bool, share: float, kept: bool = False) -> None:
        super().linearise(step, exact, share, kept)
        if exact and self._guide.dim == 3:
            turn = step.gap_rate * self.roundness()
            gap = -share * np.einsum("pi,pij->pj", self.jump("trial_velocity"), turn)
            self.equations.tangents.turn(step.gap_rate * gap, turn)

    def roundness(self) -> np.ndarray:
        """Derivatives of the normals by the position across the guide, (n, d, d) in 1/m: what moves
        along a wall in space turns its normal."""
        off = self._guide.holes(self._trace.positions(), self._stations, self.time)[0]
        size = np.hypot(*off.T)
        along = np.stack([-off[:, 1], off[:, 0]], axis=1) @ self._guide.lateral
        along /= np.where(size > 0, size, np.inf)[:, None] ** 1.5
        return along[:, :, None] * along[:, None, :]


def _sizes(vectors: np.ndarray) -> np.ndarray:
    return np.asarray(np.linalg.norm(vectors, axis=1))
