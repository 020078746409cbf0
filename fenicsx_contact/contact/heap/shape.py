# SPDX-License-Identifier: LGPL-3.0-or-later
"""The named facets of many rigid bodies in one numbering: corners, faces, and what is beside them.

Rigid bodies with flat facets meet where a corner of one lies on a face of another, and in space
where two edges cross: what lies between these follows. Nodes within a face or a straight edge are
no corners, so that meshes change nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ...base.constants import SAME
from ...base.vectors import dot, normalised
from ..mortar.ridges import shared
from ..mortar.search import counted
from ..mortar.side import Side, unit_and_length
from ..mortar.walls import Walls
from ..simplices import split


class Ragged:
    """Lists of numbers of several lengths.

    Attributes:
        first, count: of each list, (n,), in ``values``.
    """

    def __init__(self, of: np.ndarray, values: np.ndarray, n: int) -> None:
        order = np.argsort(of, kind="stable")
        self.count = np.bincount(of, minlength=n)
        self.first = np.cumsum(self.count) - self.count
        self.values = values[order]

    def of(self, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """For each entry of these lists the place of its list in ``which``, and the entry."""
        count = self.count[which]
        row = np.repeat(np.arange(len(which)), count)
        return row, self.values[self.first[which][row] + counted(count)]


class Shape:
    """The facets of many bodies.

    Args:
        sides: of the bodies, with flat facets.

    Attributes:
        dim: d.
        nodes: reference places of all nodes, (N, d); ``body``: whose each is, (N,); ``slices``: of
            each body.
        outline: nodes of the facets, of quadrilaterals of their halves, (F, d); ``sign``: +1 where
            they turn outwards; ``owner``: the body of each.
        part: of which part of its body each facet is, (F,): of a convex body there is one, else one
            for each of its faces; ``parts``: how many there are in all.
        plane: in which plane of its body each facet is, (F,); ``level``: the facets of each.
        faces: numbers of the facets of each body; ``corners``, ``edges``: likewise, of the nodes
            that are corners and of rows of ``ends``.
        beside: for each node the other nodes of its facets.
        ends: nodes of the edges that jut out, (E, 2), as far as they go straight on, none in the
            plane; ``flanks``: facets beside each, (E, 2); ``wings``: of either the node that is
            farthest from it, (E, 2).
        sizes: the diameter of each body, and ``thin``, how thin it may be, at least, (B,) in m.
        convex: bodies that are, (B,) of bool.
        hollow: for each end of a facet, in space edge, the end at which it meets another that
            rises there, d times its facet and its number in this, (F, d); -1: none.
    """

    def __init__(self, sides: Sequence[Side]) -> None:
        bodies = len(sides)
        self.dim = sides[0].dim
        starts = [0, *accumulate(len(side.nodes) for side in sides)]
        self.slices = [slice(a, b) for a, b in zip(starts[:-1], starts[1:])]
        self.nodes = np.concatenate([side.nodes for side in sides])
        self.body = np.repeat(np.arange(bodies), np.diff(starts))
        facets = [split(side.corners, side.cell) for side in sides]
        self.outline = np.concatenate([each + first for each, first in zip(facets, starts)])
        self.owner = np.repeat(np.arange(bodies), [len(each) for each in facets])
        self.sign = np.ones(len(self.outline))
        outwards = np.concatenate(
            [
                side.flat.middle_normals(side.nodes).repeat(len(mine) // len(side.corners), axis=0)
                for side, mine in zip(sides, facets)
            ]
        )
        self.sign = np.where((self.normals(self.nodes) * outwards).sum(axis=1) < 0, -1.0, 1.0)
        self.faces = Ragged(self.owner, np.arange(len(self.owner)), bodies)
        k = self.outline.shape[1]
        near = np.array([(i, j) for i in range(k) for j in range(k) if i != j]).T
        self.beside = Ragged(
            self.outline[:, near[0]].ravel(), self.outline[:, near[1]].ravel(), len(self.nodes)
        )
        self.sizes = np.array([np.linalg.norm(np.ptp(side.nodes, axis=0)) for side in sides])
        self.ends, self.flanks, self.wings = np.empty((3, 0, 2), dtype=np.int64)
        which = self._corners()
        self.corners = Ragged(self.body[which], which, bodies)
        self.edges = Ragged(self.body[self.ends[:, 0]], np.arange(len(self.ends)), bodies)
        self.thin, self.convex = np.full(bodies, np.inf), np.full(bodies, True)
        self._measure(sides)

    def _measure(self, sides: Sequence[Side]) -> None:
        """How thin bodies are, and their parts."""
        unit, _ = unit_and_length(self.normals(self.nodes))
        self.part, self.parts = np.empty(len(unit), dtype=np.int64), 0
        plane, planes = np.empty_like(self.part), 0
        for b, at in enumerate(self.slices):
            mine = self.faces.values[self.faces.first[b] :][: self.faces.count[b]]
            level = (self.nodes[self.outline[mine, 0]] * unit[mine]).sum(axis=1)
            rise = self.nodes[at] @ unit[mine].T - level
            same = SAME * self.sizes[b]
            # a facet is at most so far from the nodes of its body behind it
            behind = -rise.min(axis=0)
            self.thin[b] = behind[behind > same].min(initial=self.sizes[b])
            self.part[mine] = self.parts
            flat = np.round(np.column_stack([unit[mine], level / self.sizes[b]]) / SAME)
            which = np.unique(flat, axis=0, return_inverse=True)[1].ravel()
            plane[mine] = planes + which
            planes += int(which.max(initial=-1)) + 1
            if (rise > same).any():
                self.convex[b] = False
                self.thin[b] = min(self.sizes[b], Walls(sides[b]).least())
                self.part[mine] += which
            self.parts = int(self.part[mine].max(initial=self.parts)) + 1
        self.plane, self.level = plane, Ragged(plane, np.arange(len(unit)), planes)

    def normals(self, x: np.ndarray) -> np.ndarray:
        """Outward normals of the facets, as long as their area is large, from places (N, d)."""
        a = x[self.outline]
        if self.dim == 2:
            t = a[:, 1] - a[:, 0]
            return np.stack([t[:, 1], -t[:, 0]], axis=1) * self.sign[:, None]
        normal = np.cross(a[:, 1] - a[:, 0], a[:, 2] - a[:, 0])
        return normal * self.sign[:, None]

    @property
    def keys(self) -> int:
        """How many features there may be: corners before parts of bodies, and pairs of edges."""
        return len(self.nodes) * self.parts + len(self.ends) ** 2

    def units(self, x: np.ndarray, face: np.ndarray) -> np.ndarray:
        """Those of facets (k,), of length 1."""
        return normalised(self.normals(x)[face])

    def _inwards(self, p: np.ndarray, face: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Whether places p (k, d) lie on the inner side of each end of faces (k,), (k, d)."""
        normal, around = self.units(x, face), x[self.outline[face]]
        result, k = np.empty((len(face), self.dim), dtype=bool), self.dim
        for i in range(k):
            a, b = around[:, i], around[:, (i + 1) % k]
            edge = b - a
            # in the plane from either end to the other
            inwards = edge if k == 2 else np.cross(normal, edge) * self.sign[face][:, None]
            result[:, i] = dot(p - a, inwards) >= -SAME * dot(inwards, inwards)
        return result

    def holds(self, p: np.ndarray, face: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Whether places p (k, d) lie over or below faces (k,), (k,) of bool."""
        return np.asarray(self._inwards(p, face, x).all(axis=1))

    def reaches(self, p: np.ndarray, face: np.ndarray, x: np.ndarray) -> np.ndarray:
        """The same of faces that go on below their neighbours where these rise: what lies in a
        hollow corner is over both, though it be over none, or over one alone."""
        inwards = self._inwards(p, face, x)
        of, side = np.nonzero(~inwards & (self.hollow[face] >= 0))
        other, back = np.divmod(self.hollow[face[of], side], self.dim)
        row, facet = self.level.of(self.plane[other])
        goes_on = ~self._inwards(p[of], other, x)[np.arange(len(of)), back]
        goes_on[row[self.holds(p[of[row]], facet, x)]] = True
        inwards[of[goes_on], side[goes_on]] = True
        return np.asarray(inwards.all(axis=1))

    def roots(self, p: np.ndarray, face: np.ndarray, x: np.ndarray) -> np.ndarray:
        """The places, (k, d), next to these at which faces meet those below which they go on."""
        side = (~self._inwards(p, face, x) & (self.hollow[face] >= 0)).argmax(axis=1)
        a = x[self.outline[face, side]]
        if self.dim == 2:
            return a
        edge = x[self.outline[face, (side + 1) % 3]] - a
        share = np.clip(dot(p - a, edge) / dot(edge, edge), 0, 1)
        return a + share[:, None] * edge

    def _corners(self) -> np.ndarray:
        """Nodes at which the surface bends outwards, or where it ends; takes up the edges."""
        x = self.nodes
        unit, _ = unit_and_length(self.normals(x))
        middle = x[self.outline].mean(axis=1)
        ends, flanks, count = shared(self.outline)
        a, b = flanks.T
        across = middle[b] - middle[a]
        falls = -(across * unit[a]).sum(axis=1)
        least = SAME * np.linalg.norm(across, axis=1)
        self._hollow(ends[falls < -least], flanks[falls < -least])
        juts = (falls > least) | (count == 1)
        if self.dim == 2:
            return ends[juts, 0]
        self.ends = ends[juts]
        self.flanks = flanks[juts]
        bends = self._bends()
        self._join(bends, unit)
        self.wings = np.stack([self._wing(each, self.ends) for each in self.flanks.T], axis=1)
        return np.unique(self.ends)

    def _hollow(self, ends: np.ndarray, flanks: np.ndarray) -> None:
        """Take up the ends of facets, (r, d - 1), at which both that are beside them, (r, 2),
        rise."""
        d, self.hollow = self.dim, np.full(self.outline.shape, -1)
        # of an edge in space the end at which it begins, going round the facet
        here = (self.outline[flanks][..., None] == ends[:, None, None]).any(axis=3)
        side = (here & np.roll(here, -1, axis=2) if d == 3 else here).argmax(axis=2)
        self.hollow[flanks, side] = (d * flanks + side)[:, ::-1]

    def _join(self, bends: np.ndarray, unit: np.ndarray) -> None:
        """Let pieces of an edge be one, that go straight on at a node between the same two faces,
        given the nodes where they do not and the normals of the facets."""
        n = len(self.ends)
        node, piece = self.ends.ravel(), np.repeat(np.arange(n), 2)
        order = np.argsort(node, kind="stable")
        one, other = piece[order[:-1]], piece[order[1:]]
        at = node[order[:-1]]
        meet = (at == node[order[1:]]) & ~np.isin(at, bends)
        (a, b), (c, d) = (self.flanks[each].T for each in (one, other))
        beside = [np.abs(unit[x] - unit[y]).max(axis=1) <= SAME for x, y in ((a, c), (b, d))]
        across = [np.abs(unit[x] - unit[y]).max(axis=1) <= SAME for x, y in ((a, d), (b, c))]
        meet &= (beside[0] & beside[1]) | (across[0] & across[1])
        joints = (np.ones(meet.sum()), (one[meet], other[meet]))
        of = connected_components(coo_matrix(joints, (n, n)), directed=False)[1]
        nodes, times = np.unique(np.column_stack([of[piece], node]), axis=0, return_counts=True)
        self.ends = nodes[times == 1, 1].reshape(-1, 2)  # by edge: where no other piece goes on
        self.flanks = self.flanks[np.unique(of, return_index=True)[1]]

    def _wing(self, facet: np.ndarray, ends: np.ndarray) -> np.ndarray:
        """The node of each facet that is farthest from its edge."""
        x, way = self.nodes, normalised(self.nodes[ends[:, 1]] - self.nodes[ends[:, 0]])
        arm = x[self.outline[facet]] - x[ends[:, 0]][:, None]
        off = arm - (arm @ way[:, :, None]) * way[:, None]
        far = np.linalg.norm(off, axis=2).argmax(axis=1)
        return self.outline[facet, far]

    def _bends(self) -> np.ndarray:
        """Nodes at which edges do not go straight on."""
        x = self.nodes
        both = np.concatenate([self.ends, self.ends[:, ::-1]])
        way = normalised(x[both[:, 1]] - x[both[:, 0]])
        at, inverse, count = np.unique(both[:, 0], return_inverse=True, return_counts=True)
        total = np.zeros((len(at), 3))
        np.add.at(total, inverse.ravel(), way)
        straight = (count == 2) & (np.linalg.norm(total, axis=1) <= SAME)
        return at[~straight]


def nodes_at(shape: Shape, points: np.ndarray, owners: np.ndarray) -> np.ndarray:
    """The nodes of the bodies at reference places (n, d) of points that are theirs, (n,)."""
    result = np.empty(len(points), dtype=np.int64)
    for body, at in enumerate(shape.slices):
        mine = owners == body
        result[mine] = at.start + cKDTree(shape.nodes[at]).query(points[mine])[1]
    return result
