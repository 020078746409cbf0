# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where two surfaces in space lie over each other: the overlaps of their facets, cut out exactly.

Each slave facet has a plane across its normal n at its middle. The corners of the master's facets
are projected on it along n, and the polygon that both cover (Puso and Laursen, Comput. Methods
Appl. Mech. Engrg. 193, 2004) falls into triangles with Gauss points. Points of both facets that lie
above each other are those of the flat or bilinear facets that the corners span: such surfaces are
continuous and their edges straight, so the polygons cover what they share once and without gaps.
What is integrated is smooth on each of them, between triangles a polynomial. On facets of second
degree the fields are taken at these points, and the gap is  n . (x_m - x_s).

Places in the plane are given by the slave's tangents g at the middle,  x = middle + g p + h n.
"""

from __future__ import annotations

import basix
import numpy as np

from .clipping import areas, clip, covers, cross, fans
from .partners import FACING, inverses
from .pieces import Pieces
from .search import Near, Spheres, counted, first_of_each, in_tubes
from .side import Side

#: Cost: a facet covered more than once by this share is searched for what lies behind.
TWICE = 1e-9
#: The corners of a facet in the order of its outline.
OUTLINE = {"triangle": [0, 1, 2], "quadrilateral": [0, 1, 3, 2]}


def rule(slave: Side, master: Side) -> tuple[np.ndarray, np.ndarray]:
    """Points (g, 2) on a triangle and their weights (g,): exact, with the derivatives, between
    triangles, and between quadrilaterals that are parallelograms."""
    degree = 2 * max(slave.degree, master.degree)
    if {slave.cell, master.cell} != {"triangle"}:
        degree += 4
    return basix.make_quadrature(basix.CellType.triangle, degree)


class Overlaps:
    """Finds what the facets of two sides share, in the planes of the slave's."""

    def __init__(self, slave: Side, master: Side) -> None:
        self._slave, self._master = slave, master
        self._near = Near()
        self._rule = rule(slave, master)

    def meet(self, xs: np.ndarray, xm: np.ndarray, reach: np.ndarray) -> Pieces:
        """The pieces in the present places of the nodes, (N, 3) of slave and master, not farther
        apart than ``reach`` [m] of each slave facet."""
        planes, theirs = _Planes(self._slave.flat, xs), self._master.flat
        facet, other = self._facing(planes, xm, reach)
        their = planes.see(xm[theirs.cells[other]], facet)
        met = (their.min(axis=1) < planes.high[facet]) & (their.max(axis=1) > planes.low[facet])
        facet, other, their = (each[met[:, :2].all(axis=1)] for each in (facet, other, their))
        polygons = their[:, OUTLINE[theirs.cell], :2]
        number, shared = clip(polygons, planes.corners[facet][:, OUTLINE[self._slave.cell], :2])
        of, triangles = fans(shared)
        of = number[of]
        pieces = self._pieces(planes, xm, facet[of], other[of], their[of], triangles)
        kept = np.abs(pieces.distance.mean(axis=1)) <= reach[pieces.facet]
        cover = np.bincount(pieces.facet, np.abs(areas(triangles)), len(reach))
        double = (cover > (1 + TWICE) * planes.size)[pieces.facet]
        if double.any():
            seen = facet, polygons, their
            kept[double] &= self._nearest(planes, seen, of[double], triangles[double].mean(axis=1))
        return pieces.only(kept)

    def _nearest(
        self,
        planes: _Planes,
        seen: tuple[np.ndarray, np.ndarray, np.ndarray],
        pair: np.ndarray,
        p: np.ndarray,
    ) -> np.ndarray:
        """Whether the master facets of these pairs are nearest at points p (q, 2) of them, of all
        pairs of a facet (n,), ascending, and a polygon (n, k, 2) whose corners are at (n, k, 3)."""
        facet, polygons, their = seen
        mine = facet[pair]
        first = np.searchsorted(facet, mine)
        count = np.searchsorted(facet, mine, "right") - first
        point, rival = np.arange(len(p)).repeat(count), first.repeat(count) + counted(count)
        within = covers(polygons[rival], p[point]) | (rival == pair[point])
        point, rival = point[within], rival[within]
        at, sides = p[point, None], (self._master.flat, self._slave.flat)
        corners = their[rival], planes.corners[mine[point]]
        theirs, own = (_heights(c, _on_facet(s, c, at)[1])[:, 0] for s, c in zip(sides, corners))
        order = np.lexsort((rival, np.abs(theirs - own), point))
        return rival[order][first_of_each(point[order])] == pair

    def _facing(
        self, planes: _Planes, xm: np.ndarray, reach: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Pairs of facets that face each other and are near."""
        side = self._master.flat
        mine, theirs = Spheres.around(planes.places), Spheres.around(xm[side.cells])
        facet, other = in_tubes(planes.unit, reach, mine.radii, mine, theirs, self._near)
        normal = side.normal(side.middle_tangents(xm), np.arange(len(side.cells)))
        length = np.sqrt((normal**2).sum(axis=1))
        facing = (planes.unit[facet] * normal[other]).sum(axis=1) < FACING * length[other]
        return facet[facing], other[facing]

    def _pieces(
        self,
        planes: _Planes,
        xm: np.ndarray,
        facet: np.ndarray,
        other: np.ndarray,
        their: np.ndarray,
        triangles: np.ndarray,
    ) -> Pieces:
        """The pieces of slave and master facets that the triangles (p, 3, 2) are, from the master's
        corners in the planes, (p, k, 3)."""
        slave, master, (local, weight) = self._slave, self._master, self._rule
        p = triangles[:, :1] + local @ (triangles[:, 1:] - triangles[:, :1])
        shape = p.shape[:2]
        xi, corner, stretch = _on_facet(slave.flat, planes.corners[facet], p)
        their_xi, their_corner, _ = _on_facet(master.flat, their, p)

        def fields(side: Side, xi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            values, slopes = side.shape(xi)
            return values.reshape(*shape, -1), slopes.reshape(2, *shape, -1)

        values, slopes = fields(slave, xi)
        their_values, their_slopes = fields(master, their_xi)
        measure = slave.reference_measure(facet.repeat(shape[1]), slopes.reshape(2, len(xi), -1))
        weights = np.abs(2 * areas(triangles))[:, None] * weight
        weights = weights * measure.reshape(shape) / stretch

        flat, unit = master.flat, planes.unit[facet][:, None]
        few = slice(1 if flat.straight else None)
        if master.degree > 1:
            bend = fields(flat, their_xi)[1][:, :, few]
        else:
            bend = their_slopes[:, :, few]
        places = xm[flat.cells[other]]
        matrix = np.empty((*bend.shape[1:3], 3, 3))
        matrix[..., :2] = np.moveaxis(bend @ places, 0, 3)
        matrix[..., 2] = -unit
        return Pieces(
            facet=facet, other=other, weight=weights, corner=corner,
            values=values, their_values=their_values, their_slopes=their_slopes,
            guide=corner, their_guide=their_corner, aligned=slave.degree == master.degree == 1,
            distance=_heights(their, their_corner) - _heights(planes.corners[facet], corner),
            unit=unit, side=slave.flat, slopes=planes.slopes.repeat(len(facet), axis=1),
            length=planes.length[facet], inverse=inverses(matrix),
        )  # fmt: skip


class _Planes:
    """The planes of the facets of a side with straight edges, from the places (N, 3) of its nodes.

    Attributes:
        places, corners: of the facets, in space and in their planes, (m, k, 3).
        unit, length: normals at the middles, (m, 3), divided by (m,).
        slopes: derivatives of the shape functions there, (2, 1, k).
        low, high: between which the corners are, (m, 3).
        size: areas in the planes, (m,).
    """

    def __init__(self, side: Side, nodes: np.ndarray) -> None:
        self.places = nodes[side.cells]
        self.slopes = side.shape(side.midpoint[None])[1]
        g = side.middle_tangents(nodes)
        normal = side.normal(g, np.arange(len(side.cells)))
        self.length = np.sqrt((normal**2).sum(axis=1))
        self.unit = normal / self.length[:, None]
        basis = np.empty((len(normal), 3, 3))
        basis[..., :2] = np.moveaxis(g, 0, 2)
        basis[..., 2] = self.unit
        self._inverse = np.swapaxes(inverses(basis), 1, 2)
        self._middle = self.places.mean(axis=1, keepdims=True)
        self.corners = self.see(self.places, np.arange(len(normal)))
        self.low, self.high = self.corners.min(axis=1), self.corners.max(axis=1)
        self.size = areas(self.corners[:, OUTLINE[side.cell], :2])

    def see(self, places: np.ndarray, facet: np.ndarray) -> np.ndarray:
        """Coordinates of places (q, k, 3) in the planes of these facets."""
        return (places - self._middle[facet]) @ self._inverse[facet]


def _heights(corners: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Those of points (q, g, k) of facets whose corners are at (q, k, 3), (q, g)."""
    return (shape @ corners[..., 2:])[..., 0]


def _on_facet(
    side: Side, corners: np.ndarray, p: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Local coordinates (q g, 2) of places p (q, g, 2) in planes where the corners of facets are at
    (q, k, 3), shape functions there (q, g, k), and the ratio of areas, (q, g)."""
    xi, flat = np.tile(side.midpoint, (*p.shape[:2], 1)), corners[..., :2]
    for _ in range(1 if side.straight else 8):
        shape, slopes = side.shape(xi.reshape(-1, 2))
        shape, slopes = shape.reshape(*p.shape[:2], -1), slopes.reshape(2, *p.shape[:2], -1)
        error, g = p - shape @ flat, slopes @ flat
        stretch = cross(g[0], g[1])
        step = np.stack([cross(error, g[1]), cross(g[0], error)], axis=2) / stretch[..., None]
        # nobody is far from a facet, but by a fold in a crooked one
        xi = np.clip(xi + step, -5.0, 6.0)
        if np.abs(step).max(initial=0.0) < 1e-13:
            break
    return xi.reshape(-1, 2), side.shape(xi.reshape(-1, 2))[0].reshape(shape.shape), stretch
