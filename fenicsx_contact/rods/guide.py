# SPDX-License-Identifier: LGPL-3.0-or-later
"""Guides: corridors of tubes and cards, straight or bent, with clearance.

A guide is an obstacle around a rod: a point at depth x and lateral place r is at the signed
distance ``g/|grad g|`` from its wall, with ``g = c(x) - |r - y(x)|``, y the centre line and c the
clearance. In 2D that is the nearer one of two walls, in 3D an annular gap. The normal has an axial
part where the wall is inclined: a rod that slides past sees its wall move sideways, and its wall
sees it push.

Where a guide is convex (the end of a tube, a card, a kink, the end of a taper) it touches the rod
*between* the rod's nodes. These places are its **stations**: points fixed on the guide, at which
the rod is interpolated.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..base import checks
from ..base.constants import SAME
from ..base.quoted import quoted
from .pieces import Card, Straight, Tube, joined


class Guide:
    """Tubes and cards along one line.

    Args:
        pieces: tubes and cards; tubes must not overlap, and are one where one leads into the other
            on the same line.
        origin: the point at depth 0, d coordinates, m.
        direction: along which the depth grows.
        plane: in 3D, the lateral direction in which the curves bend; default: the first one.
        motion: of an earthquake, say: the displacement of the whole guide as a function of the time
            [s], d coordinates in m, zero at time 0, across the guide; None: it stands.

    Attributes:
        moving: whether it has a motion.
        stations: depths of the stations, from the top down, (k,) in m.
        centres: lateral places of their holes, (k, d - 1) in m.
        faces: which stations have a face on which a tip may butt that comes from above, and from
            below, (2, k): cards, and ends of tubes into whose hole none leads.
        bottom: depth at which the last tube ends, m; infinite if a card lies below it, or no tube.
        far: the distance of points next to which there is no wall, m: more than the guide is long.

    Raises:
        InputError: no pieces, tubes that overlap, directions that are zero or not lateral, a motion
            along the guide, or one that does not begin at zero.
    """

    flat, encloses = False, True

    def __init__(
        self,
        pieces: Sequence[Tube | Card],
        origin: Sequence[float] = (0.0, 0.0),
        direction: Sequence[float] | None = None,
        plane: Sequence[float] | np.ndarray | None = None,
        motion: Callable[[float], Any] | None = None,
    ) -> None:
        if not checks.sequence("pieces", pieces, (Tube, Card), "Tube and Card"):
            raise checks.InputError("pieces = []: must be a list of Tube and Card, one at least")
        self.pieces = list(pieces)
        d, self.origin = checks.point("origin", origin)
        self.dim = d
        down = [0.0] * (d - 1) + [-1.0]
        self.direction = checks.direction("direction", down if direction is None else direction, d)
        if plane is None:  # the first coordinate that is across
            first = np.eye(d)[0 if abs(self.direction[0]) < 0.9 else 1]
            plane = first - (first @ self.direction) * self.direction
        self.plane = checks.direction("plane", plane, d)
        if abs(self.plane @ self.direction) > SAME:
            raise checks.InputError(f"plane = {plane!r}: must be perpendicular to the direction")
        second = [np.cross(self.direction, self.plane)] if d == 3 else []
        # depth first, then the lateral directions
        self._axes = np.array([self.direction, self.plane, *second])
        depths = [x for p in pieces for x in p.stations()]
        length = max(depths) - min(depths)
        self._same = SAME * length
        self.far = length + max(p.hole(x)[0] for p in pieces for x in p.stations())
        self.tubes = joined([p for p in pieces if isinstance(p, Tube)], self._same)
        straight = Straight()
        self._bent = [(i, tube) for i, tube in enumerate(self.tubes) if tube.curve != straight]
        self._segments()
        self._stations()
        if motion is not None:
            checks.function("motion", motion, " of the time")
        self.moving, self._motion = motion is not None, motion
        if (first := self.displacement(0.0)).any():
            raise checks.InputError(f"motion: must be zero at time 0, not {first.tolist()}")
        self._last: tuple[np.ndarray | None, float] = None, 0.0

    def _segments(self) -> None:
        """Bounds of what lies between two depths; there the clearance is linear: begin, value,
        slope, and which tube it is (-1: none, nothing is near)."""
        bounds: list[float] = []
        parts: list[tuple[float, float, float, int]] = [(0.0, self.far, 0.0, -1)]
        for i, tube in enumerate(self.tubes):
            depth, clearance = tube.table()
            knots = np.array([tube.top, *(x for x in depth if tube.top < x < tube.bottom)])
            values = np.interp([*knots, tube.bottom], depth, clearance)
            slopes = np.diff(values) / np.diff([*knots, tube.bottom])
            if bounds and abs(bounds[-1] - tube.top) <= self._same:
                bounds.pop()
                parts.pop()
            bounds += [*knots, tube.bottom]
            parts += [*zip(knots, values[:-1], slopes, [i] * len(knots)), (0.0, self.far, 0.0, -1)]
        self._bounds = np.array(bounds)
        self._begin, self._value, self._taper, which = np.array(parts).T
        self._which = which.astype(int)

    def _stations(self) -> None:
        """Depth, clearance, centre and faces of the stations; of two at one depth the one whose
        hole lies within the other's."""
        Station = tuple[float, float, np.ndarray, np.ndarray]

        def within(a: Station, b: Station) -> bool:
            return float(np.linalg.norm(a[2] - b[2])) + a[1] <= b[1] + self._same

        found: list[Station] = []
        pieces: list[Tube | Card] = [*self.tubes]
        pieces += [piece for piece in self.pieces if isinstance(piece, Card)]
        for piece in pieces:
            for depth in (depths := piece.stations()):
                clearance, place = piece.hole(depth)
                faces = np.array([depth == depths[0], depth == depths[-1]])
                found.append((depth, clearance, self._lateral(place)[0], faces))
        found.sort(key=lambda each: each[0])
        kept = found[:1]
        for each in found[1:]:
            same = each[0] - kept[-1][0] <= self._same
            if same and within(each, kept[-1]) and not within(kept[-1], each):
                kept[-1] = each
            elif same and within(kept[-1], each):
                # a hole that leads into its like has no face
                faces = kept[-1][3] & (each[3] | (not within(each, kept[-1])))
                kept[-1] = (*kept[-1][:3], faces)
            else:
                kept.append(each)
        depths, clearances, centres, sides = zip(*kept)
        self.stations, self._clearance = np.array(depths), np.array(clearances)
        self.centres, self.faces = np.array(centres), np.array(sides).T
        end = self.tubes[-1].bottom if self.tubes else -np.inf
        self.bottom = end if depths[-1] <= end + self._same else np.inf

    def displacement(self, time: float) -> np.ndarray:
        """Of the whole guide at a time, (d,) in m.

        Raises:
            InputError: the motion gives none, or goes along the guide.
        """
        if self._motion is None:
            return np.zeros(self.dim)
        what = f"motion({time:g})"
        way = checks.vector(what, checks.called(what, self._motion, time), self.dim)
        if abs(way @ self.direction) > SAME * float(np.linalg.norm(way)):
            raise checks.InputError(f"{what} = {way.tolist()}: must be across the guide")
        return way

    def velocity(self, points: np.ndarray, start: float, end: float) -> np.ndarray:
        """Mean velocity between two times, (n, d)."""
        way = self.displacement(end) - self.displacement(start)
        return np.broadcast_to(way / (end - start), points.shape)

    def _lateral(self, values: np.ndarray) -> np.ndarray:
        """Values of a curve as lateral components (n, d - 1)."""
        if values.ndim == 2:
            return values
        result = np.zeros((len(values), self.dim - 1))
        result[:, 0] = values
        return result

    def depth(self, points: np.ndarray) -> np.ndarray:
        """Depth of the points (n, d), m."""
        return (points - self.origin) @ self.direction

    def centre(self, depth: np.ndarray) -> np.ndarray:
        """Points (n, d) of the centre line at depths (n,), m; from station to station on a straight
        line where there is no tube."""
        lateral = [np.interp(depth, self.stations, centre) for centre in self.centres.T]
        local = np.stack([depth, *lateral], axis=1)
        for tube in self.tubes:
            inside = (depth >= tube.top) & (depth <= tube.bottom)
            local[inside, 1:] = self._lateral(tube.curve.offset(depth[inside]))
        return self.origin + local @ self._axes

    def holes(
        self, points: np.ndarray, stations: np.ndarray, time: float = 0.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """The holes around points (n, d) at a time, of which ``stations`` are at the stations, all
        of these from the top down.

        Returns:
            Places from the middle of the hole, in the lateral directions, (n, d - 1) in m, and
            clearances (n,), ``far`` where there is no hole.
        """
        local, off, _, clearance, _, which = self.around(points, time)
        clearance = np.where(which < 0, self.far, clearance)
        off[stations], clearance[stations] = local[stations, 1:] - self.centres, self._clearance
        return off, clearance

    def around(self, points: np.ndarray, time: float = 0.0) -> tuple[np.ndarray, ...]:
        """Points in the frame of the guide (n, d); their places from its centre line and the slope
        of that, (n, d - 1); the clearance, its slope and the tube there, (n,)."""
        local = (points - self.origin) @ self._axes.T
        # what goes across changes no depth, at an end of a tube not by round-off either
        local[:, 1:] -= self._axes[1:] @ self.displacement(time)
        x, off = local[:, 0], local[:, 1:].copy()
        segment = self._bounds.searchsorted(x)
        clearance = self._value[segment] + self._taper[segment] * (x - self._begin[segment])
        which = self._which[segment]
        rate = np.zeros_like(off)
        for i, tube in self._bent:
            here = (which == i).nonzero()[0]
            if len(here):
                depth = x[here]
                off[here] -= self._lateral(tube.curve.offset(depth))
                rate[here] = self._lateral(tube.curve.slope(depth))
        return local, off, rate, clearance, self._taper[segment], which

    def line_curvature(self, depth: np.ndarray) -> np.ndarray:
        """Second derivative of the centre line at depths (n,), 1/m; of tubes that bend in a plane.

        Raises:
            InputError: a curve that does not know it.
        """
        result, which = np.zeros(len(depth)), self._which[self._bounds.searchsorted(depth)]
        for i, tube in self._bent:
            if not hasattr(tube.curve, "curvature"):
                raise checks.InputError(f"curve = {quoted(tube.curve)}: has no curvature(depth)")
            result[which == i] = tube.curve.curvature(depth[which == i])
        return result

    def _look(self, points: np.ndarray, time: float) -> None:
        """Distances and normals; kept, for both are asked for at the same points."""
        last, when = self._last
        if points is last and (time == when or not self.moving):
            return
        self._last = points, time
        local, off, rate, clearance, taper, which = self.around(points, time)
        size, across = _polar(off)
        axial = (across * rate).sum(axis=1) + taper
        steep = np.sqrt(1 + axial * axial)
        self._distance = np.where(which < 0, self.far, (clearance - size) / steep)
        local[:, 0], local[:, 1:] = axial / steep, across / -steep[:, None]
        self._normal = local @ self._axes

    def distance(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Signed distance of the points (n, d) from the walls, positive inside the corridor, m."""
        self._look(points, time)
        return self._distance

    def normals(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Unit normals of the nearest walls, into the corridor, (n, d)."""
        self._look(points, time)
        return self._normal

    def at_stations(
        self, points: np.ndarray, slopes: np.ndarray, time: float = 0.0, recess: Any = (0.0, 0.0)
    ) -> tuple[np.ndarray, np.ndarray]:
        """Signed distances of a rod at the stations, (k,), and unit normals into them, (k, d).

        Args:
            points: of the rod, (k, d).
            slopes: derivative of the rod's lateral place by the depth there, in the lateral
                directions of the guide, (k, d - 1): a corner has no normal, the rod has one.
            time: at which the guide is where its motion has it, s.
            recess: of the rod's surface, m, and its derivative by the depth, (k,) each.
        """
        local = (points - self.displacement(time) - self.origin) @ self._axes.T
        size, across = _polar(local[:, 1:] - self.centres)
        axial = (across * slopes).sum(axis=1) - recess[1]
        steep = np.sqrt(1 + axial * axial)
        local[:, 0], local[:, 1:] = axial / steep, across / -steep[:, None]
        return (self._clearance + recess[0] - size) / steep, local @ self._axes

    def clearance(self) -> np.ndarray:
        """Clearances of the stations, from the top down, (k,) in m."""
        return self._clearance.copy()

    @property
    def lateral(self) -> np.ndarray:
        """The lateral directions, (d - 1, d), rows."""
        return self._axes[1:]

    def __repr__(self) -> str:
        return f"Guide({self.pieces!r}, {self.origin.tolist()}, {self.direction.tolist()})"


def _polar(off: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sizes and directions of lateral vectors; on the centre line any direction will do."""
    if off.shape[1] == 1:
        return np.abs(off[:, 0]), np.where(off < 0, -1.0, 1.0)
    size = np.hypot(off[:, 0], off[:, 1])
    across = off / np.where(size > 0, size, 1.0)[:, None]
    across[size == 0, 0] = 1.0
    return size, across
