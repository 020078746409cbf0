# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes with named facets from any file that meshio reads: gmsh, Abaqus, VTK, XDMF, MED, ..."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from mpi4py import MPI

from . import checks
from .cells import ALLOWED, TO_MESHIO
from .mesh import NamedMesh
from .mesh_names import PointSet, element_sets, listed, named_elements, refuse_lost_names
from .mesh_solid import ReadSolid, distributed

#: For meshio's name of a cell: dolfinx's, and which of meshio's nodes dolfinx's are.
_CELLS = {kind: (name, order) for name in TO_MESHIO for kind, order in TO_MESHIO[name].values()}


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
    A file without names gives a mesh without; for facets by place, :func:`~.mesh.name_facets` takes
    its ``mesh``.

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

    def read() -> ReadSolid:
        mesh = read_mesh(path)
        if facets is None and path.suffix == ".msh":
            refuse_lost_names(mesh, path.read_bytes())
        return _solid(mesh, solid, facets, data)

    return distributed(file, comm, read, "choose by facets = {...}")


def read_mesh(path: Path) -> meshio.Mesh:
    """The file by meshio, whose readers raise all sorts of things, or print and exit."""
    if path.suffix == ".geo":
        raise checks.InputError("is a script of gmsh, not a mesh: mesh_from_gmsh reads it")
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
) -> ReadSolid:
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
    read = ReadSolid(mesh.points, nodes[:, order], name)
    for label, elements in named_elements(mesh, dim - 1, wanted, data).items():
        if isinstance(elements, PointSet):
            found = read.among(elements.points)
        else:
            found = read.these(label, [elements], partly=solid is not None)
        if len(found):
            read.facets[label] = found
        elif wanted is not None:
            raise checks.InputError(f"facets: {label!r} has no facet of the solid")
    return read
