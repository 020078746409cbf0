# SPDX-License-Identifier: LGPL-3.0-or-later
"""Vector fields that repeat themselves: of two sides of a mesh, a translation apart, the nodes of
the second have the unknowns of those of the first.

So nothing else of a solid has to know of it: energies, masses, loads and supports are those of the
cylinder, or torus, to which the sides close it. What holds one side holds the other, and loads on
them act along the seam, within the solid.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import fem
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ..base import assembly, checks, compat
from ..base.compiling import compiled
from ..base.constants import SAME
from ..base.glued import glued_space
from ..base.mesh import NamedMesh
from ..base.quoted import quoted
from ..base.vectors import largest
from .vector_space import Field, VectorSpace


def vector_space(mesh: NamedMesh, degree: int, periodic: Any) -> VectorSpace:
    """The vector fields on a mesh, periodic or not.

    Args:
        mesh: the mesh.
        degree: 1 or 2.
        periodic: pairs of names of its sides, none: all nodes for themselves.

    Raises:
        InputError: as :class:`VectorSpace` and :class:`PeriodicSpace`.
    """
    pairs = checks.listed("periodic", periodic, "pairs of names of facets")
    return PeriodicSpace(mesh, degree, pairs) if pairs else VectorSpace(mesh, degree)


class PeriodicSpace(VectorSpace):
    """Vector fields that are the same on two sides of a mesh, once or several times.

    Its nodes are those of the mesh without the second sides.

    Args:
        mesh: the mesh.
        degree: 1 or 2.
        pairs: for each period the names of a first and a second side.

    Raises:
        InputError: no pairs of names, names that the mesh lacks or that stand in two pairs, sides
            whose nodes do not match by a translation, or that do not look opposite ways.
    """

    def __init__(self, mesh: NamedMesh, degree: int, pairs: list[Any]) -> None:
        self._apart = apart = VectorSpace(mesh, degree)
        names = _checked(pairs)
        matches = [_match(apart, pair) for pair in names]
        stands = _stands(apart.unknowns // apart.dim, [links for links, _ in matches])
        blocks = apart.space.dofmap.index_map
        local = np.arange(blocks.size_local + blocks.num_ghosts, dtype=np.int32)
        onto = stands[np.asarray(blocks.local_to_global(local))]
        super().__init__(mesh, degree, glued_space(apart.space, onto))
        self.joined = frozenset(name for pair in names for name in pair)
        self.told += "".join(f", {second!r} is {first!r}" for first, second in names)
        self.periods = np.array([period for _, period in matches])
        self._set_sites(onto)
        for pair in names:
            self._check_normals(pair)

    def _set_sites(self, onto: np.ndarray) -> None:
        """Places of the nodes: that on the first sides stands for them."""
        apart, d = self._apart, self.dim
        n = apart.owned // d
        kept = onto[:n] == apart.first // d + np.arange(n)
        old = apart.first // d + np.flatnonzero(kept)  # their numbers as they were
        self.places = apart.places[kept]
        more = self.comm.allgather((onto[:n][~kept], apart.places[~kept]))
        numbers, places = (np.concatenate(each) for each in zip(*more))
        node = np.searchsorted(old, numbers)
        mine = np.append(old, -1)[node] == numbers
        self.sites = np.concatenate([self.places, places[mine]])
        self.site_nodes = np.concatenate([np.arange(len(old)), node[mine]])

    def _check_normals(self, pair: tuple[str, str]) -> None:
        """What lies behind the one side goes on beyond the other: their normals cancel."""
        domain, sides = self.mesh.mesh, self.mesh.measures(*pair)
        second = fem.Constant(domain, 0.0)
        out = ufl.dot(ufl.FacetNormal(domain), ufl.TestFunction(self.space))
        form = compiled(out * sides[0] + second * out * sides[1])
        sizes = np.empty((2, self.owned // self.dim))
        for second.value, size in zip((0.0, 1.0), sizes):
            load = np.empty(self.owned)
            assembly.assemble_owned(form, load)
            size[:] = np.linalg.norm(load.reshape(-1, self.dim), axis=1)
        one, both = sizes
        most = max(self.comm.allgather(largest(one)))
        off = ((both > SAME * most) & (both >= one)).any()
        if most == 0 or any(self.comm.allgather(bool(off))):
            raise checks.InputError(
                f"periodic: {pair!r}: must be two sides of the boundary of the mesh, with outward "
                "normals that are opposite"
            )

    def cell_places(self) -> np.ndarray:
        return self._apart.cell_places()

    def twins(self, points: np.ndarray) -> np.ndarray:
        distance, node = self.nearest(points)
        mine = distance <= SAME * np.ptp(points, axis=0).max()
        number = np.where(mine, self.first // self.dim + node, -1)
        away = np.zeros(len(points))
        away[mine] = np.linalg.norm(points[mine] - self.places[node[mine]], axis=1)
        number = np.max(self.comm.allgather(number), axis=0)
        away = np.sum(self.comm.allgather(away), axis=0)
        order = np.lexsort((away, number))
        _, start, group = np.unique(number[order], return_index=True, return_inverse=True)
        stands = np.empty(len(points), dtype=np.int64)
        stands[order] = order[start[group]]
        return stands

    def interpolate(self, what: str, field: Field | None) -> np.ndarray:
        given = self._apart.interpolate(what, field)
        every = self._apart.function(given).x.array.reshape(-1, self.dim)
        mine, theirs = (compat.cell_dofs(each.space).ravel() for each in (self, self._apart))
        values = np.zeros((int(mine.max(initial=-1)) + 1, self.dim))
        values[mine] = every[theirs]
        function = self.function(values[: self.owned // self.dim].ravel())
        off = largest(function.x.array.reshape(-1, self.dim)[mine] - every[theirs])
        size = max(self.comm.allgather(largest(every)))
        if max(self.comm.allgather(off)) > SAME * size:
            raise checks.InputError(
                f"{what} = {quoted(field)}: must be the same on both sides of periodic = "
                f"{sorted(self.joined)}; it differs"
            )
        return values[: self.owned // self.dim].ravel()


def _checked(pairs: list[Any]) -> list[tuple[str, str]]:
    """The pairs, or a refusal."""
    names: list[tuple[str, str]] = []
    for pair in pairs:
        two = isinstance(pair, (list, tuple)) and len(pair) == 2
        if not two or not all(isinstance(name, str) for name in pair):
            raise checks.InputError(f"periodic: {pair!r}: must be two names of facets")
        if pair[0] == pair[1]:
            raise checks.InputError(f"periodic: {pair!r}: must be two sides, not one with itself")
        if twice := {name for other in names for name in other} & set(pair):
            raise checks.InputError(f"periodic: {pair!r}: {min(twice)!r} stands in two pairs")
        names.append((pair[0], pair[1]))
    return names


def _match(vectors: VectorSpace, pair: tuple[str, str]) -> tuple[np.ndarray, np.ndarray]:
    """Nodes of the second side and those of the first, (2, n), in the numbers of all processes,
    and the translation from the first to the second, (d,) in m."""
    sides = []
    for name in pair:
        nodes = vectors.nodes_of([name], "periodic")
        parts = vectors.comm.allgather(
            (vectors.first // vectors.dim + nodes, vectors.places[nodes])
        )
        sides.append([np.concatenate(each) for each in zip(*parts)])
    (first, x), (second, y) = sides
    way = y.min(axis=0) - x.min(axis=0)
    size = SAME * max(vectors.comm.allgather(largest(vectors.places)))
    distance, partner = cKDTree(x + way).query(y)
    lost = distance > size
    without = np.setdiff1d(np.arange(len(first)), partner[~lost])
    if lost.any() or len(without):
        back = cKDTree(y).query(x[without] + way)[0] if len(without) else np.zeros(0)
        far, by = max(distance.max(), back.max(initial=0.0)), ", ".join(f"{w:.6g}" for w in way)
        raise checks.InputError(
            f"periodic: {pair!r}: must match node by node; {lost.sum()} of {len(second)} nodes of "
            f"{pair[1]!r} and {len(without)} of {len(first)} of {pair[0]!r} have no partner by the "
            f"translation [{by}], the nearest node is up to {far:.3g} m away"
        )
    return np.array([second, first[partner]]), way


def _stands(nodes: int, links: list[np.ndarray]) -> np.ndarray:
    """For each node the one that stands for it: that of those linked with it which is on no second
    side, (nodes,)."""
    second, first = np.concatenate(links, axis=1)
    graph = sp.coo_matrix((np.ones(len(second)), (second, first)), (nodes, nodes))
    count, group = connected_components(graph, directed=False)
    alone = np.setdiff1d(np.arange(nodes), second)
    stands = np.empty(count, dtype=np.int64)
    stands[group[alone]] = alone
    return stands[group]
