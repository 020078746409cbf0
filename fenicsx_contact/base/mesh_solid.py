# SPDX-License-Identifier: LGPL-3.0-or-later
"""A solid as the first process has read it from a file, and the distributed mesh of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import dolfinx
import numpy as np
from mpi4py import MPI

from . import checks, compat
from .cells import FACET, NODES, degree_of, facet_nodes, lagrange, orientations
from .constants import SAME
from .mesh import NamedMesh


class ReadSolid:
    """Cells and the points that belong to them, with names for facets and places.

    Args:
        x: all points of the file (n, 2 or 3).
        nodes: for each cell its points, in basix's order, (m, k).
        cell: its name.

    Attributes:
        points: those that belong to a cell, in as many dimensions as the cells.
        cells: their points, (m, k).
        facets: by name the corners, sorted, (f, v); to be given.
        places: by name the coordinates of points; to be given.

    Raises:
        InputError: cells that are flat, turned over, there twice, three at one facet; a surface in
            space.
    """

    def __init__(self, x: np.ndarray, nodes: np.ndarray, cell: str) -> None:
        used, cells = np.unique(nodes, return_inverse=True)
        self.cell, self.cells = cell, cells.reshape(nodes.shape)
        self.points = _flat(
            np.asarray(x, dtype=np.float64)[used], lagrange(cell, 1).points.shape[1]
        )
        self.facets: dict[str, np.ndarray] = {}
        self.places: dict[str, list[float]] = {}
        self._new = np.full(len(x), -1, dtype=np.int64)
        self._new[used] = np.arange(len(used))
        _check_shape(self.points, self.cells, cell)
        twice = len(self.cells) - len(np.unique(np.sort(self.cells, axis=1), axis=0))
        if twice:
            raise checks.InputError(f"{twice} of its {len(self.cells)} cells are there twice")
        self._facets, self._cells_of = _facets(self.cells, cell)
        if self._cells_of.max() > 2:
            at = self.points[self._facets[self._cells_of.argmax()]].mean(axis=0).tolist()
            raise checks.InputError(f"{self._cells_of.max()} of its cells share one facet, at {at}")

    def among(self, points: np.ndarray) -> np.ndarray:
        """The facets of the boundary all of whose corners are among these points of the file."""
        rows = self._facets[self._cells_of == 1]
        return rows[np.isin(rows, self._new[points]).all(axis=1)]

    def these(self, label: str, elements: Sequence[np.ndarray], partly: bool) -> np.ndarray:
        """The facets that are elements of the file, (f, v) for each of their types.

        Args:
            partly: whether some of them may be no facets of the cells; all may anyway.
        """
        fit = [nodes for nodes in elements if nodes.shape[1] in NODES[FACET[self.cell]]]
        corners = [self._facets[:0], *(nodes[:, : self._facets.shape[1]] for nodes in fit)]
        rows = self._new[np.unique(np.sort(np.vstack(corners), axis=1), axis=0)]
        rows.sort(axis=1)
        found = rows[rows_in(rows, self._facets)]
        every = len(rows) + sum(len(nodes) for nodes in elements) - sum(map(len, fit))
        if 0 < len(found) < every and not partly:
            raise checks.InputError(
                f"facets: {every - len(found)} of the {every} elements of {label!r} are no facets "
                "of the cells"
            )
        return found


def distributed(file: Any, comm: MPI.Comm, read: Callable[[], ReadSolid], choose: str) -> NamedMesh:
    """The mesh of a solid that the first process reads; what is wrong there is raised on all.

    Args:
        file: its name, for messages.
        read: reads it.
        choose: what helps where two names claim a facet, for messages.
    """
    solid: ReadSolid | None = None
    told: tuple[str, Any] = "", None
    if comm.rank == 0:
        try:
            solid = read()
            shape = solid.points.shape[1], solid.cells.shape[1]
            told = "", (solid.cell, *shape, solid.facets, solid.places)
        except checks.InputError as problem:
            told = str(problem), None
    message, about = comm.bcast(told)
    try:
        if message:
            raise checks.InputError(message)
        cell, gdim, nodes, facets, places = about
        cells = solid.cells if solid else np.empty((0, nodes), dtype=np.int64)
        points = solid.points if solid else np.empty((0, gdim))
        mesh = compat.create_mesh(comm, cells, points, cell, degree_of(cell, nodes))
        return _tagged(mesh, facets, places, choose)
    except checks.InputError as problem:
        raise checks.InputError(f"file = {str(file)!r}: {problem}") from None


def _tagged(
    mesh: Any, named: dict[str, np.ndarray], places: Mapping[str, list[float]], choose: str
) -> NamedMesh:
    """Names for the facets whose corners are given by their numbers among the points."""
    fdim = mesh.topology.dim - 1
    mesh.topology.create_entities(fdim)
    index_map = mesh.topology.index_map(fdim)
    local = np.arange(index_map.size_local + index_map.num_ghosts, dtype=np.int32)
    numbers = compat.given_nodes(mesh)
    vertices = np.sort(numbers[facet_nodes(mesh, local)[0]], axis=1)
    names: dict[str, int] = {}
    tag = np.zeros(len(local), dtype=np.int32)
    for name, wanted in named.items():
        found = rows_in(vertices, wanted)
        taken = np.unique(tag[found])
        same = [n for n in names if np.array_equal(named[n], wanted)]
        names[name] = names[same[0]] if same else len(names) + 1
        clash = "" if same or not taken.any() else next(n for n in names if names[n] == taken[-1])
        if clash := max(mesh.comm.allgather(clash)):
            raise checks.InputError(
                f"facets: {name!r} and {clash!r} claim the same facet; {choose}"
            )
        tag[found] = names[name]
    tagged = np.flatnonzero(tag).astype(np.int32)
    return NamedMesh(mesh, dolfinx.mesh.meshtags(mesh, fdim, tagged, tag[tagged]), names, places)


def rows_in(rows: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Which of the rows are among those wanted; as indices."""
    if not len(rows) or not len(wanted):
        return np.empty(0, dtype=np.int64)
    maybe = np.flatnonzero(np.isin(rows, wanted).all(axis=1))
    _, number = np.unique(np.concatenate([wanted, rows[maybe]]), axis=0, return_inverse=True)
    number = number.ravel()
    return maybe[np.isin(number[len(wanted) :], number[: len(wanted)])]


def _facets(cells: np.ndarray, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Vertices of the facets, sorted, (f, v), and of how many cells each is one, (f,)."""
    corners, whole = (
        np.sort(cells[:, nodes].reshape(-1, len(nodes[0])), axis=1)
        for degree in (1, degree_of(name, cells.shape[1]))
        for nodes in [lagrange(name, degree).entity_closure_dofs[-2]]
    )
    facets, cells_of = np.unique(corners, axis=0, return_counts=True)
    if len(np.unique(whole, axis=0)) > len(facets):
        raise checks.InputError("two of its cells share the corners of a facet, not its middle")
    return facets, cells_of


def _flat(x: np.ndarray, dim: int) -> np.ndarray:
    """Points in as many dimensions as the cells."""
    if not np.isfinite(x).all():
        raise checks.InputError("has a point with a coordinate that is not finite")
    if x.shape[1] > dim and np.ptp(x[:, dim:]) > SAME * np.ptp(x, axis=0).max():
        raise checks.InputError(
            "holds a surface in 3D, not a mesh of a solid (in 2D all points have one z)"
        )
    return x[:, :dim]


def _check_shape(x: np.ndarray, cells: np.ndarray, name: str) -> None:
    """Refuse cells that are flat or turn over at some node; all of one sense may be reversed."""
    signs = orientations(x[cells], name)
    bad = np.flatnonzero(np.abs(signs.sum(axis=1)) < signs.shape[1])
    if len(bad):
        corners = cells[bad[0], : NODES[name][0]]
        raise checks.InputError(
            f"{len(bad)} of its {len(cells)} cells are without volume or turned over at a node, "
            f"the first at {x[corners].mean(axis=0).tolist()}"
        )
