# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where two surfaces in space lie over each other: the overlaps of their facets, cut out exactly.

Each slave facet has a plane across its normal n at its middle. The corners of the master's facets
are projected on it along n, and the polygon that both cover (Puso and Laursen, Comput. Methods
Appl. Mech. Engrg. 193, 2004) gets points of integration. Points of both facets that lie above each
other are those of the flat or bilinear facets that the corners span: such surfaces are continuous
and their edges straight, so the polygons cover what they share once and without gaps. What is
integrated is smooth on each of them, between triangles a polynomial. Forces on a facet that these
polygons cover in part act by its part that bears, of quadrilaterals (parts.py). On facets of second
degree the fields are taken at these points, and the gap is  n . (x_m - x_s).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .clipping import areas, clip, corners, covers, cross, fans, gauss, points
from .itself import Admits
from .partners import facing, inverses
from .parts import FORMS, Parts
from .pieces import Brink, Ends, Pieces
from .planes import Pairs, Planes, fields, heights, on_facet
from .search import Near, Spheres, counted, first_of_each, in_tubes
from .side import OUTLINE, Side
from .stance import Places, Stance

#: Cost: a facet covered more than once by this share is searched for what lies behind, and one
#: covered less by it for the part that is.
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
        planes = Planes(sides, places, stance)
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
        free = (edge >= 0) & self._free[pairs.other[polygon], np.maximum(edge, 0)]
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
            each = self._pieces(planes, xm, pairs.of(which), at, size)
            near = np.abs(each.distance.mean(axis=1)) <= reach[each.facet]
            found.append((each.only(near), near))
        (pieces, seen), (there, near) = found
        across = self._across(pairs.of(polygon[near]), ends[near], outwards[near])

        # the parts that bear of facets that are covered partly
        brink = Brink(there, there, across, None)
        if self._slave.cell not in FORMS:
            return pieces, brink
        cover = np.bincount(pairs.facet[number[seen]], weight[seen].sum(axis=1), len(reach))
        partly = (cover > 0) & (cover < (1 - TWICE) * planes.size)
        if not partly.any():
            return pieces, brink
        which = np.unique(number[seen & partly[pairs.facet[number]] & (weight > 0).any(axis=1)])
        part, ends = self._part(planes, xm, pairs.of(which), shared[which], edges[which])
        pieces, there = (_on_part(each, part, partly[each.facet]) for each in (pieces, there))
        return pieces, Brink(there, there, across, ends)

    def _part(
        self, planes: Planes, xm: np.ndarray, pairs: Pairs, shared: np.ndarray, edges: np.ndarray
    ) -> tuple[Parts, Ends]:
        """The parts of facets that polygons (r, w, 2) of pairs (r,), with these edges, cover, and
        what moves them."""
        polygon, at, labels = corners(shared, edges)
        pairs, at = pairs.of(polygon), at[:, None]
        mine = planes.corners[pairs.facet]
        xi, _, bend = on_facet(self._slave.flat, mine, at)
        part = Parts(self._slave, pairs.facet, xi[:, 0])
        masters = (labels >= 0).any(axis=1)[:, None]
        ends, by = np.nonzero(part.within(pairs.facet, xi[:, 0]) & masters)
        pairs, at, labels = pairs.of(ends), at[ends], labels[ends]
        inverse = inverses(np.moveaxis(bend @ mine[..., :2], 0, 2)[ends, 0])  # (q, 2, 2)
        outline = pairs.corners[:, OUTLINE[self._master.cell], :2]
        edge, each = labels.max(axis=1), np.arange(len(ends))
        way = np.roll(outline, -1, axis=1)[each, edge] - outline[each, edge]
        way = (way[:, None] @ inverse)[:, 0]
        outwards = part.outwards(pairs.facet, by, labels.min(axis=1), way)
        outwards = (inverse @ outwards[..., None])[..., 0]
        guides = self._pieces(planes, xm, pairs, at, np.ones((len(at), 1)))
        across = self._across(pairs, at, outwards)
        return part, Ends(guides, across, part.changes(pairs.facet, by))

    def _across(self, pairs: Pairs, at: np.ndarray, outwards: np.ndarray) -> np.ndarray:
        """How far points of the master at places (q, g, 2) in the planes go outwards (q, 2) there
        as they move on its facets, by local coordinates of these, (q, g, 2)."""
        bend = on_facet(self._master.flat, pairs.corners, at)[2] @ pairs.corners[..., :2]
        return -np.moveaxis((bend * outwards[:, None]).sum(axis=3), 0, 2)

    def _facing(self, planes: Planes, xm: np.ndarray, reach: np.ndarray) -> Pairs:
        """Facets that face each other and are near."""
        side = self._master.flat
        asked = self._facets
        mine, theirs = Spheres.around(planes.places[asked]), Spheres.around(xm[side.cells])
        tubes = planes.unit[asked], reach[asked], mine.radii
        facet, other = in_tubes(*tubes, mine, theirs, self._near)
        facet = asked[facet]
        faces = facing(planes.unit[facet], side.middle_normals(xm)[other])
        facet, other = facet[faces], other[faces]
        pairs = Pairs(facet, other, planes.see(xm[side.cells[other]], facet))
        low, high = pairs.corners.min(axis=1), pairs.corners.max(axis=1)
        met = ((low < planes.high[facet]) & (high > planes.low[facet]))[:, :2].all(axis=1)
        anyhow = self._admits(facet, other, np.full(len(facet), np.inf))  # wherever they meet
        return pairs.of(met & anyhow)

    def _away(self, theirs: np.ndarray, mine: np.ndarray, at: np.ndarray) -> np.ndarray:
        """How far from each other facets, with corners there (q, k, 3), are at places (q, 1, 2) in
        the planes, (q,) in m."""
        pairs = (self._master.flat, theirs), (self._slave.flat, mine)
        far, near = (heights(c, on_facet(side, c, at)[1])[:, 0] for side, c in pairs)
        return far - near

    def _nearest(
        self, planes: Planes, pairs: Pairs, number: np.ndarray, p: np.ndarray
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
        self, planes: Planes, xm: np.ndarray, pairs: Pairs, p: np.ndarray, weight: np.ndarray
    ) -> Pieces:
        """Those of pairs with points p (q, g, 2) in the planes that weigh (q, g) there."""
        slave, master, shape = self._slave, self._master, p.shape[:2]
        facet, other, mine = pairs.facet, pairs.other, planes.corners[pairs.facet]
        xi, corner, bend = on_facet(slave.flat, mine, p)
        g = bend @ mine[..., :2]
        values, slopes = (corner, bend) if slave.degree == 1 else fields(slave, xi)
        measure = slave.reference_measure(
            facet.repeat(shape[1]), slopes.reshape(2, -1, slopes.shape[3])
        )
        weight = weight * measure.reshape(shape) / cross(g[0], g[1])

        their_xi, their_corner, bend = on_facet(master.flat, pairs.corners, p)
        theirs = (their_corner, bend) if master.degree == 1 else fields(master, their_xi)
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
            distance=heights(pairs.corners, their_corner) - heights(mine, corner),
            unit=unit, side=slave.flat, slopes=planes.slopes.repeat(len(facet), axis=1),
            length=planes.length[facet], stance=planes.stance.of(facet), inverse=inverses(matrix),
        )  # fmt: skip


def _on_part(pieces: Pieces, part: Parts, partly: np.ndarray) -> Pieces:
    """The same with the functions of the parts that bear, where these are of such facets."""
    corner = pieces.corner.copy()
    xi = corner[partly] @ part.form.corners
    corner[partly] = part.functions(pieces.facet[partly], xi)
    return replace(pieces, corner=corner)


def _free_edges(side: Side) -> np.ndarray:
    """Whether the edges of its facets, in the order of their outlines, belong to one facet only,
    (m, k)."""
    outline = side.corners[:, OUTLINE[side.cell]]
    edges = np.sort(np.stack([outline, np.roll(outline, -1, axis=1)], axis=2), axis=2)
    _, which, count = np.unique(
        edges.reshape(-1, 2), axis=0, return_inverse=True, return_counts=True
    )
    return (count[which.ravel()] == 1).reshape(outline.shape)
