# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where a pair of lines is integrated: points on pieces of the slave's facets.

The facets are cut where corners of the other side face them: what is integrated is smooth on each
piece, and the integral exact for straight facets (mortar). Forces on a facet that is covered in
part, from a to b of its local coordinate, act at the ends of this part (parts.py).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import basix
import numpy as np

from .clipping import gauss
from .itself import Admits
from .partners import Hits, Partners, Rays, intersect
from .parts import Parts
from .pieces import Brink, Ends, Pieces
from .search import Near, Spheres
from .side import TURN, Side, unit_and_length
from .stance import Places, Sides, Stance, look

#: Points on a piece of a line.
PIECE_POINTS = {1: 2, 2: 4}


@dataclass(frozen=True)
class Points:
    """Integration points: facet (q,), local coordinates (q, d - 1), weights there (q,)."""

    facet: np.ndarray
    xi: np.ndarray
    weight: np.ndarray


def whole(side: Side) -> Points:
    """A rule on whole facets, exact for their normals times linear functions."""
    if side.cell == "interval":
        x, w = gauss(PIECE_POINTS[side.degree])
        x = x[:, None]
    else:
        degree = 2 * side.degree + (side.cell == "quadrilateral")
        x, w = basix.make_quadrature(getattr(basix.CellType, side.cell), degree)
    m = len(side.cells)
    facet, xi = np.repeat(np.arange(m), len(w)), np.tile(x, (m, 1))
    return Points(facet, xi, np.tile(w, m))


class Lines:
    """Finds what the facets of two lines share, by rays along the slave's normals."""

    def __init__(self, slave: Side, master: Side, admits: Admits) -> None:
        self._sides = slave, master
        self._flat = (
            self._sides if slave.degree == master.degree == 1 else (slave.flat, master.flat)
        )
        self._cuts, self._partners = Cuts(slave, master), Partners(slave, master, admits)

    def meet(
        self, places: Places, reach: np.ndarray, stance: Stance
    ) -> tuple[Pieces, Brink | None]:
        """Points on the pieces in the present places of the nodes, (N, 2) of slave and master, each
        as a piece, not farther apart than ``reach`` [m] of each slave facet; and the ends of what
        is covered within facets."""
        cut = self._cuts.pieces(places, stance)
        view = _look(cut.points, self._sides, places, stance)
        hits = self._partners.meet(Rays(view.x, view.unit, view.facet, reach), places)
        covered = np.zeros(len(cut.facet), dtype=bool)
        covered[hits.ray // cut.each] = True
        part = cut.part(covered, self._sides[0])
        pieces = _pieces(view.of(hits.ray), self._sides, hits, part)
        return pieces, self._brink(cut, covered, hits, part, places, stance)

    def _brink(
        self, cut: Cut, covered: np.ndarray, hits: Hits, part: Parts, places: Places,
        stance: Stance,
    ) -> Brink | None:  # fmt: skip
        def met(piece: np.ndarray, end: np.ndarray | int) -> np.ndarray:  # beside that end
            return hits.facet[np.searchsorted(hits.ray, (piece + end) * cut.each) - end]

        piece, end = cut.free(covered)
        # steps: neighbours that meet facets of no common corner
        left, corners = cut.inside(covered), self._sides[1].corners
        sides = corners[met(left, 1)], corners[met(left + 1, 0)]
        left = left[(sides[0][:, :, None] != sides[1][:, None]).all(axis=(1, 2))]
        free, steps = len(piece), len(left)
        piece = np.concatenate([piece, left, left + 1])
        end = np.concatenate([end, np.ones(steps, dtype=int), np.zeros(steps, dtype=int)])
        if not len(piece):
            return None
        facet, xi, outwards = cut.facet[piece], cut.ends[piece, end], 2.0 * end - 1
        points, other = Points(facet, xi[:, None], np.ones(len(xi))), met(piece, end)

        def at(sides: Sides, other: np.ndarray) -> tuple[Pieces, np.ndarray]:
            view = _look(points, sides, places, stance)
            meets = intersect(view.x, view.unit, sides[1], places[1], other)[:3]
            return _pieces(view, sides, Hits(np.arange(len(xi)), other, *meets), part), meets[0]

        guide, at_theirs = at(self._flat, other)  # chords are cut
        there, ends_there = guide, other
        if steps:  # where what is in front ends, what is behind begins
            inside = np.abs(at_theirs[free:, 0] - 0.5).reshape(2, steps)
            front = free + np.arange(steps) + steps * (inside[1] > inside[0])
            ends_there = other.copy()
            ends_there[free:] = np.tile(other[front], 2)
            guide = at(self._flat, ends_there)[0]
        if self._flat is not self._sides:
            there = at(self._sides, other)[0]
            seen = at(self._sides, ends_there)[0] if steps else there
            guide = replace(
                guide, values=seen.values, their_values=seen.their_values,
                their_slopes=seen.their_slopes,
            )  # fmt: skip
        tangent = guide.side.tangents(places[0], facet, guide.slopes)[0]
        pace = outwards * (guide.inverse[:, 0, 0] * tangent).sum(axis=1)  # of their coordinate
        across = -1 / pace[:, None, None]
        moves = part.within(facet, xi[:, None])[np.arange(len(xi)), end]  # not of gaps between
        ends = Ends(guide, across, moves[:, None, None] * part.changes(facet, end))
        return Brink(there, guide, across, ends)


class _View(NamedTuple):
    """Points (q,) of the slave: values and derivatives of their shape functions, where they are,
    and the unit vectors along which they look, those of normals of this length."""

    points: Points
    values: np.ndarray
    slopes: np.ndarray
    x: np.ndarray
    unit: np.ndarray
    length: np.ndarray
    stance: Stance

    @property
    def facet(self) -> np.ndarray:
        """Those of the points."""
        return self.points.facet

    def of(self, which: np.ndarray) -> _View:
        """Some of them."""
        points = Points(*(each[which] for each in vars(self.points).values()))
        values, slopes, x, unit, length, stance = self[1:]
        return _View(
            points, values[which], slopes[:, which], x[which], unit[which], length[which],
            stance.of(which),
        )  # fmt: skip


def _look(points: Points, sides: Sides, places: Places, stance: Stance) -> _View:
    slave, xs, facet = sides[0], places[0], points.facet
    values, slopes = slave.shape(points.xi)
    x = np.einsum("qk,qkj->qj", values, xs[slave.cells[facet]])
    unit, length = unit_and_length(slave.normals(xs, facet, slopes))
    look(unit, length, stance := stance.of(facet), sides, places, facet)
    return _View(points, values, slopes, x, unit, length, stance)


def _pieces(view: _View, sides: Sides, hits: Hits, part: Parts) -> Pieces:
    """Those of points that meet these."""
    (slave, master), facet, values = sides, view.facet, view.values[:, None]
    weight = view.points.weight * slave.reference_measure(facet, view.slopes)
    weight *= slave.breadth(facet, view.values)
    corner = part.functions(facet, view.points.xi[:, None])
    theirs, their_slopes = (each[..., None, :] for each in master.shape(hits.xi))
    return Pieces(
        facet=facet, other=hits.facet, weight=weight[:, None], corner=corner,
        values=values, their_values=theirs, their_slopes=their_slopes,
        guide=values, their_guide=theirs, aligned=True, distance=hits.distance[:, None],
        unit=view.unit[:, None], side=slave, slopes=view.slopes, length=view.length,
        stance=view.stance, inverse=hits.inverse[:, None],
    )  # fmt: skip


class Cut(NamedTuple):
    """Pieces of facets (k,), ascending, between local coordinates (k, 2), with ``each`` so many
    points, (k each,)."""

    facet: np.ndarray
    ends: np.ndarray
    points: Points
    each: int

    def part(self, covered: np.ndarray, side: Side) -> Parts:
        """The parts of this side's facets that the covered pieces are."""
        facet, ends = self.facet[covered].repeat(2), self.ends[covered].reshape(-1, 1)
        return Parts(side, facet, ends)

    def free(self, covered: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Covered pieces beside which their facet goes on and is not, and at which end, 0 or 1."""
        found = []
        for end in (0, 1):
            inside = np.flatnonzero(covered & (self.ends[:, end] != end))
            beside = np.clip(inside + 2 * end - 1, 0, len(covered) - 1)
            goes_on = covered[beside] & (self.facet[beside] == self.facet[inside])
            found.append(np.stack([inside[~goes_on], np.full((~goes_on).sum(), end)]))
        piece, end = np.hstack(found)
        return piece, end

    def inside(self, covered: np.ndarray) -> np.ndarray:
        """Covered pieces beside whose end 1 their facet goes on and is covered, too."""
        on = covered[:-1] & covered[1:] & (self.facet[:-1] == self.facet[1:])
        return np.flatnonzero(on)


class Cuts:
    """Points on the pieces into which the corners of the master cut the facets of a line."""

    def __init__(self, slave: Side, master: Side) -> None:
        self._sides = slave, master
        self._rule = gauss(PIECE_POINTS[max(slave.degree, master.degree)])
        self._corners = np.unique(master.corners)
        self._near = Near()

    def pieces(self, places: Places, stance: Stance) -> Cut:
        """Those of the present places of the nodes, (N, d)."""
        (slave, master), nodes = self._sides, places[1]
        ends = places[0][slave.corners]  # (m, 2, d)
        along = ends[:, 1] - ends[:, 0]
        square = (along**2).sum(axis=1)
        # what is cut are their chords, along their own normals or those on which they stand
        ray = along @ TURN.T
        look(ray, np.empty(len(ray)), stance, self._sides, places, np.arange(len(ray)))
        across = ray @ TURN
        height = (across * along).sum(axis=1)
        facets = Spheres(ends.sum(axis=1) / 2, 0.5 * np.sqrt(square) + master.size)
        corners = Spheres(nodes[self._corners], np.zeros(len(self._corners)))
        facet, corner = self._near(facets, corners)
        corner = corners.middles[corner]
        close = ((corner - facets.middles[facet]) ** 2).sum(axis=1) <= facets.radii[facet] ** 2
        s = ((corner - ends[facet, 0]) * across[facet]).sum(axis=1) / height[facet]
        cut = close & (s > 1e-9) & (s < 1 - 1e-9)
        each = np.arange(len(along))
        facet = np.concatenate([each, each, facet[cut]])
        s = np.concatenate([np.zeros(len(along)), np.ones(len(along)), s[cut]])
        order = np.lexsort((s, facet))
        facet, s = facet[order], s[order]
        length = np.where(facet[1:] == facet[:-1], s[1:] - s[:-1], 0.0)
        kept = np.flatnonzero(length > 1e-10)
        x, w = self._rule
        xi = (s[kept, None] + length[kept, None] * x).reshape(-1, 1)
        facet, ends = facet[kept], np.column_stack([s[kept], s[kept + 1]])
        points = Points(np.repeat(facet, len(w)), xi, (length[kept, None] * w).ravel())
        return Cut(facet, ends, points, len(w))
