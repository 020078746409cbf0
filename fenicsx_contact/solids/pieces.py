# SPDX-License-Identifier: LGPL-3.0-or-later
"""The pieces of a mesh, cells that hang together by facets, and the nodes by which they are joined.

Each of them can move rigidly for itself, but for the nodes that it has in common with others: one
is a hinge, and so is an edge in space. Periodic sides join what is on them likewise, a period away.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from dolfinx import fem
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ..base import compat
from ..base.constants import SAME


class Pieces:
    """The pieces of the mesh of a vector space, in the order of their cells as it was given.

    Args:
        vectors: the :class:`~.vector_space.VectorSpace`.

    Attributes:
        count: how many there are.
        of_nodes: to which the owned nodes belong, of several the first, (owned/d,).
        centres, sizes: of their bounding boxes, sizes half the largest edges, (count, d) and
            (count,) in m.
        nodes: how many each has, (count,).
        joints: owned nodes (m,) that belong to other pieces, too, or to any at another place, with
            these pieces (m,) and their places there (m, d); once for each cell there.
    """

    def __init__(self, vectors: Any) -> None:
        self._vectors, comm, d = vectors, vectors.comm, vectors.dim
        mesh = vectors.mesh.mesh
        of_cells, self.count = _pieces(mesh)
        x = mesh.geometry.x[:, :d]
        nodes = compat.cell_geometry(mesh)[: len(of_cells)]
        bounds = np.full((2, self.count, d), -np.inf)
        for bound, sign in zip(bounds, (1.0, -1.0)):
            if self.count == 1:
                bound[0] = (sign * x).max(axis=0, initial=-np.inf)
            else:
                np.maximum.at(bound, of_cells, (sign * x[nodes]).max(axis=1))
        high, low = np.max(comm.allgather(bounds), axis=0)
        self.centres, self.sizes = (high - low) / 2, (high + low).max(axis=1) / 2
        self.of_nodes = np.zeros(vectors.owned // d, dtype=np.int64)
        self.joints = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty((0, d))
        if self.count > 1 or len(vectors.periods):
            self._join(of_cells)
        self.nodes = comm.allreduce(np.bincount(self.of_nodes, minlength=self.count))

    def _join(self, of_cells: np.ndarray) -> None:
        """Find the pieces of the owned nodes, and the joints."""
        vectors, d = self._vectors, self._vectors.dim
        blocks, first = vectors.space.dofmap.index_map, vectors.first // vectors.dim
        nodes = compat.cell_dofs(vectors.space)[: len(of_cells)]
        numbers = np.asarray(blocks.local_to_global(nodes.ravel().astype(np.int32)))
        pieces, x = np.repeat(of_cells, nodes.shape[1]), vectors.cell_places().reshape(-1, d)
        ghosts = nodes.ravel() >= len(self.of_nodes)
        own = [(numbers[~ghosts], pieces[~ghosts], x[~ghosts])]
        if vectors.comm.size > 1:
            own += vectors.comm.allgather((numbers[ghosts], pieces[ghosts], x[ghosts]))
        numbers, pieces, x = (np.concatenate(each) for each in zip(*own))
        mine = (numbers >= first) & (numbers < first + len(self.of_nodes))
        nodes, pieces, x = numbers[mine] - first, pieces[mine], x[mine]
        here = np.abs(x - vectors.places[nodes]).max(axis=1) <= SAME * self.sizes[pieces]
        self.of_nodes[:] = self.count - 1
        np.minimum.at(self.of_nodes, nodes[here], pieces[here])
        joints = ~here | (pieces != self.of_nodes[nodes])
        self.joints = nodes[joints], pieces[joints], x[joints]

    def at(self, points: np.ndarray, facets: str) -> np.ndarray:
        """The pieces of the nodes of named facets next to places (n, d) in the reference placement,
        (n,)."""
        comm = self._vectors.comm
        if self.count == 1:
            return np.zeros(len(points), dtype=np.int64)
        distance, node = self._vectors.nearest(points, facets)
        piece = self.of_nodes[node] if len(self.of_nodes) else node
        every = np.array(comm.allgather((distance, piece)))
        return every[every[:, 0].argmin(axis=0), 1, np.arange(len(points))].astype(np.int64)

    @cached_property
    def told(self) -> str:
        """How many there are, and what is odd in them, if they are several; or nothing."""
        if self.count == 1:
            return ""
        told = f"{self.count} pieces, which share no facet"
        if twice := self._twice():
            told += (
                f" ({twice} nodes of one coincide with some of others and are not the same, which "
                "joins nothing: merge them, in gmsh by Coherence or BooleanFragments, unless the "
                "pieces are to come apart)"
            )
        return told

    def _twice(self) -> int:
        """At how many places nodes of different pieces coincide."""
        vectors = self._vectors
        facets = vectors.mesh.skin_facets()
        nodes = fem.locate_dofs_topological(vectors.space, vectors.dim - 1, facets)
        nodes = nodes[nodes < len(self.of_nodes)]
        every = vectors.comm.allgather((vectors.places[nodes], self.of_nodes[nodes]))
        x, pieces = (np.concatenate(each) for each in zip(*every))
        pairs = cKDTree(x).query_pairs(SAME * self.sizes.max(), output_type="ndarray")
        return len(np.unique(pairs[pieces[pairs[:, 0]] != pieces[pairs[:, 1]], 0]))


def _pieces(mesh: Any) -> tuple[np.ndarray, int]:
    """The pieces of this process's cells, (m,), and how many there are on all."""
    topology, comm, d = mesh.topology, mesh.comm, mesh.topology.dim
    topology.create_connectivity(d - 1, d)
    up, n = topology.connectivity(d - 1, d), compat.num_local_cells(mesh)
    cells, ends = np.asarray(up.array), np.asarray(up.offsets)
    two = ends[:-1][np.diff(ends) == 2]
    links = np.stack([cells[two], cells[two + 1]])
    links = links[:, (links < n).all(axis=0)]
    count, own = _components(n, links)
    if count == comm.size == 1:
        return own, count
    given = compat.given_cells(mesh)
    firsts = np.full(count, np.iinfo(np.int64).max)
    np.minimum.at(firsts, own, given)
    if comm.size > 1:  # by facets that several have
        facets = np.repeat(np.arange(len(ends) - 1, dtype=np.int32), np.diff(ends))
        numbers = np.asarray(topology.index_map(d - 1).local_to_global(facets[cells < n]))
        once = np.bincount(facets[cells < n], minlength=len(ends) - 1)[facets[cells < n]] == 1
        every = comm.allgather((firsts, numbers[once], own[cells[cells < n]][once]))
        starts = np.cumsum([0, *(len(each[0]) for each in every)])
        sides = [start + each[2] for start, each in zip(starts, every)]
        firsts = np.concatenate([each[0] for each in every])
        _, facet = np.unique(np.concatenate([each[1] for each in every]), return_inverse=True)
        links = np.stack([np.concatenate(sides), len(firsts) + facet.ravel()])
        _, piece = _components(len(firsts) + len(np.unique(facet)), links)
        piece = piece[: len(firsts)]
        own = piece[starts[comm.rank] + own]
        count = int(piece.max()) + 1
        least = np.full(count, np.iinfo(np.int64).max)
        np.minimum.at(least, piece, firsts)
        firsts = least
    rank = np.empty(count, dtype=np.int64)
    rank[firsts.argsort()] = np.arange(count)
    return rank[own], count


def _components(n: int, links: np.ndarray) -> tuple[int, np.ndarray]:
    """How many parts a graph of n has by links (2, m), and of which each is, (n,)."""
    graph = sp.coo_matrix((np.ones(links.shape[1], dtype=np.int8), tuple(links)), (n, n))
    count, which = connected_components(graph, directed=False)
    return int(count), which.astype(np.int64)
