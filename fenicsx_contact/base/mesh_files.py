# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes with named facets from any file that meshio reads: gmsh, Abaqus, VTK, XDMF, MED, ..."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import dolfinx
import meshio
import numpy as np
from mpi4py import MPI

from . import checks, compat
from .cells import ALLOWED, FACET, NODES, TO_MESHIO, degree_of, facet_nodes, lagrange, orientations
from .constants import SAME
from .mesh import NamedMesh
from .mesh_names import PointSet, element_sets, listed, named_elements

#: For meshio's name of a cell: dolfinx's, and which of meshio's nodes dolfinx's are.
_CELLS = {kind: (name, order) for name in TO_MESHIO for kind, order in TO_MESHIO[name].values()}


@dataclass(frozen=True)
class _Solid:
    """What rank 0 has read: points (n, d), cells (m, k) in dolfinx's order, the cell's name, and
    for each name of facets their vertices, sorted, (f, v)."""

    points: np.ndarray
    cells: np.ndarray
    cell: str
    facets: dict[str, np.ndarray]


def mesh_from_file(
    file: str | Path,
    comm: MPI.Comm = MPI.COMM_WORLD,
    *,
    solid: str | None = None,
    facets: Mapping[str, str | int] | None = None,
    data: str | None = None,
) -> NamedMesh:
    """A mesh with named facets from a file of any format that meshio reads.

    The solid is made of the file's cells of highest dimension, of one type; those of second order
    (triangle6, quad9, tetra10, hexahedron27) keep all their nodes. Its facets have the names of
    the file's sets of facet elements (gmsh's physical names, Abaqus' element sets, MED's groups).
    A file without names gives a mesh without; for facets by place, :func:`name_facets` takes its
    ``mesh``.

    Args:
        file: path of the file; its ending tells the format.
        comm: the processes over which the mesh is distributed; the first one reads.
        solid: name of the cells to take, if the file holds more than this solid.
        facets: the names to give, each with what bears it in the file: the name of a set of facet
            elements or else of points (all boundary facets whose vertices are in it), or the value
            of the facet elements' integer cell data. All sets of facet elements if not given.
        data: name of that cell data, if the file has several.

    Raises:
        InputError: no such file or not readable, cells of other kinds or distorted, no such name.
    """
    path = checks.path("file", file)
    checks.instance("facets", facets, (Mapping, type(None)), "a dict from names, or None")
    read: tuple[str, _Solid | None] = ("", None)
    if comm.rank == 0:
        try:
            read = "", _solid(read_mesh(path), solid, facets, data)
        except checks.InputError as problem:
            read = str(problem), None
    message, on_root = read
    message = comm.bcast(message)
    if message:
        raise checks.InputError(f"file = {str(file)!r}: {message}")
    cell, gdim, nodes, named = comm.bcast(
        (on_root.cell, on_root.points.shape[1], on_root.cells.shape[1], on_root.facets)
        if on_root
        else None
    )
    cells = on_root.cells if on_root else np.empty((0, nodes), dtype=np.int64)
    points = on_root.points if on_root else np.empty((0, gdim))
    mesh = compat.create_mesh(comm, cells, points, cell, degree_of(cell, nodes))
    return _tagged(mesh, named)


def _tagged(mesh: Any, named: dict[str, np.ndarray]) -> NamedMesh:
    """Names for the facets whose vertices are given by their numbers in the file."""
    fdim = mesh.topology.dim - 1
    mesh.topology.create_entities(fdim)
    index_map = mesh.topology.index_map(fdim)
    local = np.arange(index_map.size_local + index_map.num_ghosts, dtype=np.int32)
    numbers = compat.given_nodes(mesh)
    vertices = np.sort(numbers[facet_nodes(mesh, local)[0]], axis=1)
    names: dict[str, int] = {}
    tag = np.zeros(len(local), dtype=np.int32)
    for name, wanted in named.items():
        found = _rows_in(vertices, wanted)
        taken = np.unique(tag[found])
        same = [n for n in names if np.array_equal(named[n], wanted)]
        names[name] = names[same[0]] if same else len(names) + 1
        clash = "" if same or not taken.any() else next(n for n in names if names[n] == taken[-1])
        if clash := max(mesh.comm.allgather(clash)):
            raise checks.InputError(
                f"facets: {name!r} and {clash!r} claim the same facet; choose by facets = {{...}}"
            )
        tag[found] = names[name]
    tagged = np.flatnonzero(tag).astype(np.int32)
    return NamedMesh(mesh, dolfinx.mesh.meshtags(mesh, fdim, tagged, tag[tagged]), names)


def _rows_in(rows: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Which of the rows are among those wanted; as indices."""
    if not len(rows) or not len(wanted):
        return np.empty(0, dtype=np.int64)
    maybe = np.flatnonzero(np.isin(rows, wanted).all(axis=1))
    _, number = np.unique(np.concatenate([wanted, rows[maybe]]), axis=0, return_inverse=True)
    number = number.ravel()
    return maybe[np.isin(number[len(wanted) :], number[: len(wanted)])]


def read_mesh(path: Path) -> meshio.Mesh:
    """The file by meshio, whose readers raise all sorts of things, or print and exit."""
    if not path.is_file():
        raise checks.InputError("no such file")
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            return meshio.read(path)
    except (Exception, SystemExit) as failure:
        what = str(failure) if isinstance(failure, Exception) else ""
        text = " ".join(f"{said.getvalue()} {what}".split())
        raise checks.InputError(
            f"meshio cannot read it: {text or type(failure).__name__}"
        ) from None


def _solid(
    mesh: meshio.Mesh, solid: str | None, wanted: Mapping[str, str | int] | None, data: str | None
) -> _Solid:
    """The cells of the solid, its points alone, and its named facets."""
    dim = max((block.dim for block in mesh.cells if len(block.data)), default=0)
    chosen = [block.dim == dim for block in mesh.cells]
    if dim < 2:
        raise checks.InputError(f"holds no cells of a solid; allowed are {ALLOWED}")
    picked: list[Any] = [slice(None) if yes else [] for yes in chosen]
    if solid is not None:
        sets = element_sets(mesh, dim)
        if solid not in sets:
            raise checks.InputError(f"solid = {solid!r}: it has {listed(sets)} for cells")
        picked = sets[solid]
    parts = [(b.type, b.data[p]) for b, p, yes in zip(mesh.cells, picked, chosen) if yes]
    parts = [(kind, nodes) for kind, nodes in parts if len(nodes)]
    kinds = {kind for kind, _ in parts}
    if len(kinds) != 1 or not kinds <= set(_CELLS):
        hint = "" if solid else "; if it holds several solids choose one by solid = ..."
        raise checks.InputError(
            f"has cells of type {', '.join(sorted(kinds))}; allowed are {ALLOWED}{hint}"
        )
    kind = kinds.pop()
    name, order = _CELLS[kind]
    nodes = np.concatenate([part for _, part in parts]).astype(np.int64)
    used, cells = np.unique(nodes, return_inverse=True)
    cells = cells.reshape(nodes.shape)[:, order]
    points = _points(mesh, used, dim)
    _check_shape(points, cells, name)
    twice = len(cells) - len(np.unique(np.sort(cells, axis=1), axis=0))
    if twice:
        raise checks.InputError(f"{twice} of its {len(cells)} cells are there twice")
    new = np.full(len(mesh.points), -1, dtype=np.int64)
    new[used] = np.arange(len(used))
    all_facets, cells_of = _facets(cells, name)
    if cells_of.max() > 2:
        at = points[all_facets[cells_of.argmax()]].mean(axis=0).tolist()
        raise checks.InputError(f"{cells_of.max()} of its cells share one facet, at {at}")
    facets: dict[str, np.ndarray] = {}
    for label, elements in named_elements(mesh, dim - 1, wanted, data).items():
        if isinstance(elements, PointSet):
            rows = all_facets[cells_of == 1]
            found = rows[np.isin(rows, new[elements.points]).all(axis=1)]
        else:
            fits = elements.shape[1] in NODES[FACET[name]]
            corners = elements[:, : all_facets.shape[1]]
            rows = np.unique(np.sort(new[corners], axis=1), axis=0)
            found = rows[_rows_in(rows, all_facets)] if fits else rows[:0]
            if len(found) and len(found) < len(rows) and solid is None:
                raise checks.InputError(
                    f"facets: {len(rows) - len(found)} of the {len(rows)} elements of {label!r} "
                    "are no facets of the cells"
                )
        if len(found):
            facets[label] = found
        elif wanted is not None:
            raise checks.InputError(f"facets: {label!r} has no facet of the solid")
    return _Solid(points, cells, name, facets)


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


def _points(mesh: meshio.Mesh, used: np.ndarray, dim: int) -> np.ndarray:
    """The points that belong to a cell, in as many dimensions as the cells."""
    x = np.asarray(mesh.points, dtype=np.float64)[used]
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
