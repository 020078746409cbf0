# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where two surfaces in space lie over each other: the overlaps of their facets, cut out exactly.

Each slave facet has a plane across its normal n at its middle. The corners of the master's facets
are projected on it along n, and the polygon that both cover (Puso and Laursen, Comput. Methods
Appl. Mech. Engrg. 193, 2004) gets points of integration. Points of both facets that lie above each
other are those of the flat or bilinear facets that the corners span: such surfaces are continuous
and their edges straight, so the polygons cover what they share once and without gaps. What is
integrated is smooth on each of them, between triangles a polynomial. On facets of second degree the
fields are taken at these points, and the gap is  n . (x_m - x_s).

Places in the plane are given by the slave's tangents g at the middle,  x = middle + g p + h n.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...base.vectors import largest
from .clipping import areas, clip, covers, cross, fans, gauss, points
from .itself import Admits
from .partners import facing, inverses
from .pieces import Brink, Pieces
from .search import Near, Spheres, counted, first_of_each, in_tubes
from .side import OUTLINE, Side, unit_and_length
from .stance import Places, Sides, Stance, look

#: Cost: a facet covered more than once by this share is searched for what lies behind.
TWICE = 1e-9


class Overlaps:
    """Finds what some facets of a side share with those of another, in the planes of the former."""

    def __init__(self, slave: Side, master: Side, admits: Admits, facets: np.ndarray) -> None:
        self._facets = facets
        self._slave, self._master, self._admits = slave, master, admits
        self._near = Near()
        # exact, with derivatives, between triangles, and quadrilaterals that are parallelograms
        degree = max(slave.degree, master.degree)
        square = {slave.cell, master.cell} != {"triangle"}
        self._degree = 2 * degree + 4 * square
        self._line = gauss(2 + degree + square)
        self._free = _free_edges(master)

    def meet(self, places: Places, reach: np.ndarray, stance: Stance) -> tuple[Pieces, Brink]:
        """The pieces in the present places of the nodes, (N, 3) of slave and master, not farther
        apart than ``reach`` [m] of each slave facet; and where the master's edge ends them."""
        xm, sides = places[1], (self._slave.flat, self._master.flat)
        planes = _Planes(sides, places, stance)
        pairs = self._facing(planes, xm, reach)
        outlines = pairs.corners[:, OUTLINE[self._master.cell], :2]
        window = planes.corners[pairs.facet][:, OUTLINE[self._slave.cell], :2]
        number, shared, edges = clip(outlines, window)
        pairs = pairs.of(number)
        midst = shared.mean(axis=1, keepdims=True)
        away = self._away(pairs.corners, planes.corners[pairs.facet], midst)
        may = self._admits(pairs.facet, pairs.other, away)
        pairs, shared, edges = pairs.of(may), shared[may], edges[may]
        polygon, edge, triangles = fans(shared)
        number, p, weight = points(polygon, triangles, self._degree)
        cover = np.bincount(pairs.facet[number], weight.sum(axis=1), len(reach))
        twice = cover > (1 + TWICE) * planes.size

        # edges of triangles that are part of free ones of the master, and outwards across them
        edge = edges[polygon, edge]
        free = (edge >= 0) & self._free[pairs.other[polygon], edge]
        polygon, triangles, (local, lengths) = polygon[free], triangles[free], self._line
        way = triangles[:, 2] - triangles[:, 1]
        outwards = np.stack([way[:, 1], -way[:, 0]], axis=1) * np.sign(areas(triangles))[:, None]
        ends = triangles[:, 1, None] + local[:, None] * way[:, None]
        lengths = np.tile(lengths, (len(way), 1))

        found = []
        for which, at, size in ((number, p, weight), (polygon, ends, lengths)):
            behind = np.flatnonzero(twice[pairs.facet[which]])
            if len(behind):
                size[behind] *= self._nearest(planes, pairs, which[behind], at[behind])
            found.append(self._pieces(planes, xm, pairs.of(which), at, size))
        pieces, there = found
        near, near_there = (
            np.abs(each.distance.mean(axis=1)) <= reach[each.facet] for each in found
        )
        corners = pairs.corners[polygon]
        bend = _on_facet(self._master.flat, corners, ends)[2] @ corners[..., :2]  # (2, q, g, 2)
        across = -np.moveaxis((bend * outwards[:, None]).sum(axis=3), 0, 2)
        still = np.zeros((len(there.facet), there.corner.shape[2]))
        return pieces.only(near), Brink(there, there, across, still).only(near_there)

    def _facing(self, planes: _Planes, xm: np.ndarray, reach: np.ndarray) -> _Pairs:
        """Facets that face each other and are near."""
        side = self._master.flat
        asked = self._facets
        mine, theirs = Spheres.around(planes.places[asked]), Spheres.around(xm[side.cells])
        tubes = planes.unit[asked], reach[asked], mine.radii
        facet, other = in_tubes(*tubes, mine, theirs, self._near)
        facet = asked[facet]
        faces = facing(planes.unit[facet], side.middle_normals(xm)[other])
        facet, other = facet[faces], other[faces]
        pairs = _Pairs(facet, other, planes.see(xm[side.cells[other]], facet))
        low, high = pairs.corners.min(axis=1), pairs.corners.max(axis=1)
        met = ((low < planes.high[facet]) & (high > planes.low[facet]))[:, :2].all(axis=1)
        anyhow = self._admits(facet, other, np.full(len(facet), np.inf))  # wherever they meet
        return pairs.of(met & anyhow)

    def _away(self, theirs: np.ndarray, mine: np.ndarray, at: np.ndarray) -> np.ndarray:
        """How far from each other facets, with corners there (q, k, 3), are at places (q, 1, 2) in
        the planes, (q,) in m."""
        pairs = (self._master.flat, theirs), (self._slave.flat, mine)
        far, near = (_heights(c, _on_facet(side, c, at)[1])[:, 0] for side, c in pairs)
        return far - near

    def _nearest(
        self, planes: _Planes, pairs: _Pairs, number: np.ndarray, p: np.ndarray
    ) -> np.ndarray:
        """Whether the master facets of pairs of these numbers (q,) are those nearest at points p
        (q, g, 2) of them, (q, g)."""
        size, number, p = p.shape[:2], number.repeat(p.shape[1]), p.reshape(-1, 2)
        facet = pairs.facet[number]
        first = np.searchsorted(pairs.facet, facet)
        count = np.searchsorted(pairs.facet, facet, "right") - first
        point, rival = np.arange(len(p)).repeat(count), first.repeat(count) + counted(count)
        outlines = pairs.corners[rival][:, OUTLINE[self._master.cell], :2]
        within = covers(outlines, p[point]) | (rival == number[point])
        point, rival = point[within], rival[within]
        away = self._away(pairs.corners[rival], planes.corners[facet[point]], p[point, None])
        order = np.lexsort((rival, np.abs(away), point))
        return (rival[order][first_of_each(point[order])] == number).reshape(size)

    def _pieces(
        self, planes: _Planes, xm: np.ndarray, pairs: _Pairs, p: np.ndarray, weight: np.ndarray
    ) -> Pieces:
        """Those of pairs with points p (q, g, 2) in the planes that weigh (q, g) there."""
        slave, master, shape = self._slave, self._master, p.shape[:2]
        facet, other, mine = pairs.facet, pairs.other, planes.corners[pairs.facet]
        xi, corner, bend = _on_facet(slave.flat, mine, p)
        g = bend @ mine[..., :2]
        values, slopes = (corner, bend) if slave.degree == 1 else _fields(slave, xi)
        measure = slave.reference_measure(
            facet.repeat(shape[1]), slopes.reshape(2, -1, slopes.shape[3])
        )
        weight = weight * measure.reshape(shape) / cross(g[0], g[1])

        their_xi, their_corner, bend = _on_facet(master.flat, pairs.corners, p)
        theirs = (their_corner, bend) if master.degree == 1 else _fields(master, their_xi)
        if master.flat.straight:
            bend = bend[:, :, :1]
        unit = planes.unit[facet][:, None]
        matrix = np.empty((*bend.shape[1:3], 3, 3))
        matrix[..., :2] = np.moveaxis(bend @ xm[master.flat.cells[other]], 0, 3)
        matrix[..., 2] = -unit
        return Pieces(
            facet=facet, other=other, weight=weight, corner=corner,
            values=values, their_values=theirs[0], their_slopes=theirs[1],
            guide=corner, their_guide=their_corner, aligned=slave.degree == master.degree == 1,
            distance=_heights(pairs.corners, their_corner) - _heights(mine, corner),
            unit=unit, side=slave.flat, slopes=planes.slopes.repeat(len(facet), axis=1),
            length=planes.length[facet], stance=planes.stance.of(facet), inverse=inverses(matrix),
        )  # fmt: skip


class _Pairs(NamedTuple):
    """Facets of the slave, ascending, and of the master, whose corners are at (q, k, 3) in the
    planes of the former."""

    facet: np.ndarray
    other: np.ndarray
    corners: np.ndarray

    def of(self, which: np.ndarray) -> _Pairs:
        """Some of them."""
        return _Pairs(*(each[which] for each in self))


class _Planes:
    """The planes of the facets of a side with straight edges, from the places (N, 3) of its nodes.

    Attributes:
        places, corners: of the facets, in space and in their planes, (m, k, 3).
        unit, length: where they look, (m, 3): along these normals, divided by (m,).
        stance: how they stand on the other side.
        slopes: derivatives of the shape functions there, (2, 1, k).
        low, high: between which the corners are, (m, 3).
        size: areas in the planes, (m,).
    """

    def __init__(self, sides: Sides, places: Places, stance: Stance) -> None:
        side, nodes = sides[0], places[0]
        self.places, self.stance = nodes[side.cells], stance
        self.slopes = side.shape(side.midpoint[None])[1]
        g = side.middle_tangents(nodes)
        every = np.arange(len(side.cells))
        self.unit, self.length = unit_and_length(side.normal(g, every))
        look(self.unit, self.length, stance, sides, places, every)
        basis = np.empty((len(every), 3, 3))
        basis[..., :2] = np.moveaxis(g, 0, 2)
        basis[..., 2] = self.unit
        self._inverse = np.swapaxes(inverses(basis), 1, 2)
        self._middle = self.places.mean(axis=1, keepdims=True)
        self.corners = self.see(self.places, every)
        self.low, self.high = self.corners.min(axis=1), self.corners.max(axis=1)
        self.size = areas(self.corners[:, OUTLINE[side.cell], :2])

    def see(self, places: np.ndarray, facet: np.ndarray) -> np.ndarray:
        """Coordinates of places (q, k, 3) in the planes of these facets."""
        return (places - self._middle[facet]) @ self._inverse[facet]


def _heights(corners: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Those of points (q, g, k) of facets whose corners are at (q, k, 3), (q, g)."""
    return (shape @ corners[..., 2:])[..., 0]


def _free_edges(side: Side) -> np.ndarray:
    """Whether the edges of its facets, in the order of their outlines, belong to one facet only,
    (m, k)."""
    outline = side.corners[:, OUTLINE[side.cell]]
    edges = np.sort(np.stack([outline, np.roll(outline, -1, axis=1)], axis=2), axis=2)
    _, which, count = np.unique(
        edges.reshape(-1, 2), axis=0, return_inverse=True, return_counts=True
    )
    return (count[which.ravel()] == 1).reshape(outline.shape)


def _fields(side: Side, xi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Shape functions (q, g, k) at points (q, g, 2), and derivatives, (2, q, g, k)."""
    values, slopes = side.shape(xi.reshape(-1, 2))
    shape = (*xi.shape[:2], values.shape[1])
    return values.reshape(shape), slopes.reshape(2, *shape)


def _on_facet(
    side: Side, corners: np.ndarray, p: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Local coordinates (q, g, 2) of places p (q, g, 2) in planes where the corners of facets are
    at (q, k, 3), and shape functions there with their derivatives, (q, g, k), (2, q, g, k)."""
    xi, flat = np.tile(side.midpoint, (*p.shape[:2], 1)), corners[..., :2]
    for _ in range(1 if side.straight else 8):
        shape, slopes = _fields(side, xi)
        error, g = p - shape @ flat, slopes @ flat
        step = np.stack([cross(error, g[1]), cross(g[0], error)], axis=2)
        step /= cross(g[0], g[1])[..., None]
        # nobody is far from a facet, but by a fold in a crooked one
        xi = np.clip(xi + step, -5.0, 6.0)
        if largest(step) < 1e-13:
            break
    return (xi, *_fields(side, xi))
