# SPDX-License-Identifier: LGPL-3.0-or-later
"""Closed surfaces of triangles: what of them is nearest to a point."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from ...base import checks
from ...base.constants import SAME
from ...base.vectors import cross, normalised
from ..mortar.matrices import add_up


class Triangles:
    """A closed, oriented surface of triangles.

    Args:
        points: (v, 3) in m; equal ones are one.
        cells: (m, 3), each anticlockwise as seen from outside.

    Attributes:
        points, cells: without what is given twice or not used.
        corners, edges: of each triangle, and from each corner to the next, (m, 3, 3) in m.
        normals: of the triangles, (m, 3), unit.
        beyond: the triangle beyond each of these edges, (m, 3).

    Raises:
        InputError: a triangle without area, an edge that is not shared by two triangles of one
            orientation.
    """

    def __init__(self, points: np.ndarray, cells: np.ndarray) -> None:
        self.points, number = np.unique(points[cells.ravel()], axis=0, return_inverse=True)
        self.cells = number.reshape(-1, 3)
        self.corners = x = self.points[self.cells]
        self.edges = np.roll(x, -1, axis=1) - x
        area = cross(self.edges[:, 0], self.edges[:, 1])
        size, longest = np.linalg.norm(area, axis=1), np.linalg.norm(self.edges, axis=2).max(axis=1)
        flat = np.flatnonzero(size <= SAME * longest**2)
        if len(flat):
            raise checks.InputError(
                f"surface: {len(flat)} of its triangles have no area, the first at "
                f"{x[flat[0]].mean(axis=0).tolist()}"
            )
        self.normals = area / size[:, None]
        self._across = self._other_halves()
        self.beyond = self._across // 3
        self._summed = self._angle_weighted()
        middles = x.mean(axis=1)
        self._reach = float(np.linalg.norm(x - middles[:, None], axis=2).max())
        self._corner_tree, self._tree = cKDTree(self.points), cKDTree(middles)

    def _other_halves(self) -> np.ndarray:
        """Of each edge the number 3 t + i of the same one as the i-th of the triangle t beyond."""
        many, ends = len(self.points), np.roll(self.cells, -1, axis=1)
        ahead, back = (self.cells * many + ends).ravel(), (ends * many + self.cells).ravel()
        order = np.argsort(ahead)
        at = np.searchsorted(ahead[order], back).clip(max=len(ahead) - 1)
        _, same, times = np.unique(ahead, return_inverse=True, return_counts=True)
        alone = np.flatnonzero((ahead[order][at] != back) | (times[same] > 1))
        if len(alone):
            raise checks.InputError(
                "surface: must be closed and of one orientation, each edge shared by two triangles "
                f"that run along it in opposite directions; {len(alone)} edges are not, the first "
                f"from {self.points[self.cells.ravel()[alone[0]]].tolist()}"
            )
        return order[at].reshape(-1, 3)

    def fans(self, sharp: float) -> tuple[np.ndarray, np.ndarray]:
        """The smooth fans of triangles about the points: the number of that at each corner of each
        triangle, (m, 3), and which edges divide them, as the cosine between the normals beside them
        is below ``sharp``, (m, 3)."""
        bent = (self.normals[:, None] * self.normals[self.beyond]).sum(axis=2) < sharp
        here, there = np.arange(self.cells.size).reshape(-1, 3), self._across
        start, end = here, np.roll(here, -1, axis=1)
        pairs = np.concatenate(
            [[start[~bent], end.ravel()[there[~bent]]], [end[~bent], there[~bent]]], axis=1
        )
        joined = sp.csr_matrix((np.ones(pairs.shape[1]), pairs), shape=(here.size, here.size))
        return sp.csgraph.connected_components(joined, directed=False)[1].reshape(-1, 3), bent

    def _angle_weighted(self) -> np.ndarray:
        """Sums at the points of the normals, weighted by their triangles' angles there, (v, 3)."""
        ahead, back = self.edges, -np.roll(self.edges, 1, axis=1)
        sine = np.linalg.norm(cross(ahead, back), axis=2)
        angle = np.arctan2(sine, (ahead * back).sum(axis=2))
        weighted = angle[:, :, None] * self.normals[:, None]
        return add_up(weighted, self.cells, len(self.points))

    def at(self, cells: np.ndarray, shares: np.ndarray) -> np.ndarray:
        """Places in triangles, (n, 3), from shares of the corners, (n, 3)."""
        return np.einsum("ni,nid->nd", shares, self.corners[cells])

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The nearest triangle of each point (n,), and what of it is nearest, as shares of its
        corners (n, 3): exactly zero where that is an edge or a corner."""
        bound = self._corner_tree.query(points)[0] + self._reach
        lists = self._tree.query_ball_point(points, bound * (1 + SAME))
        owner = np.repeat(np.arange(len(points)), [len(each) for each in lists])
        cells = np.concatenate([*lists, []]).astype(int)
        shares = self.shares(points[owner], cells)
        off = points[owner] - self.at(cells, shares)
        cells, shares = first_of_each(owner, (off**2).sum(axis=1), cells, shares)
        return cells, shares

    def shares(self, points: np.ndarray, cells: np.ndarray) -> np.ndarray:
        """Of the place in each triangle that is nearest to each point, (n, 3)."""
        edges, off = self.edges[cells], points[:, None] - self.corners[cells]
        # of the foot on the plane: what lies beyond the edge between two is the third one's
        part = np.einsum("nid,nd->ni", cross(edges, off), self.normals[cells])
        inside = (part > 0).all(axis=1)
        foot = np.roll(part, -1, axis=1) / part.sum(axis=1)[:, None]
        # else of the nearest of the feet on its edges
        along = ((off * edges).sum(axis=2) / (edges**2).sum(axis=2)).clip(0.0, 1.0)
        edge = ((off - along[:, :, None] * edges) ** 2).sum(axis=2).argmin(axis=1)
        rows, on_edge = np.arange(len(points)), np.zeros_like(foot)
        on_edge[rows, edge] = 1 - along[rows, edge]
        on_edge[rows, (edge + 1) % 3] = along[rows, edge]
        return np.where(inside[:, None], foot, on_edge)

    def pseudo_normals(self, cells: np.ndarray, shares: np.ndarray) -> np.ndarray:
        """Of places in triangles: its own normal inside, the sum of two on an edge, and at a corner
        the sum by angles, which tell inside from outside (J.A. Bærentzen, H. Aanæs, IEEE Trans.
        Vis. Comput. Graph. 11, 243-253, 2005); (n, 3), unit."""
        own, rows, zero = self.normals[cells], np.arange(len(cells)), shares == 0
        beyond = self.beyond[cells, (zero.argmax(axis=1) + 1) % 3]
        corner = self._summed[self.cells[cells, shares.argmax(axis=1)]]
        summed = np.stack([own, own + self.normals[beyond], corner])[zero.sum(axis=1), rows]
        return normalised(summed)


def first_of_each(
    owner: np.ndarray, size: np.ndarray, *values: np.ndarray
) -> tuple[np.ndarray, ...]:
    """For each owner, all of which occur, the values where the size is least."""
    order = np.lexsort((size, owner))
    _, first = np.unique(owner[order], return_index=True)
    return tuple(value[order[first]] for value in values)
