# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes with named facets from gmsh: scripts, and its own files."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from . import checks, compat, shipped
from .cells import ALLOWED, NODES
from .constants import SAME
from .mesh import NamedMesh


def mesh_from_gmsh(
    file: str | Path, comm: MPI.Comm = MPI.COMM_WORLD, **parameters: float
) -> NamedMesh:
    """A mesh from a gmsh script (``.geo``) or mesh (``.msh``); its physical names are those of
    facets and points. Cells are of first order, or of second (``Mesh.ElementOrder = 2;``).

    Args:
        file: path of the file. A bare name that the present folder lacks (``"block.geo"``) is that
            of a script which comes with the package: see ``meshes/`` of its source.
        comm: the processes over which the mesh is distributed.
        parameters: values for what the script declares by ``DefineConstant``.

    Raises:
        InputError: no such file, a parameter that the script does not declare, nothing meshed,
            cells of other types or orders.
    """
    import gmsh

    path, missing = shipped.find(checks.path("file", file))
    if missing:
        raise checks.InputError(f"file = {str(file)!r}: {missing}")
    declared = _declared(path) if path.suffix == ".geo" else set()
    given = []
    for name, value in parameters.items():
        if name not in declared:
            known = ", ".join(sorted(declared)) or "nothing"
            raise checks.InputError(f"{name} = {value!r}: {path.name} declares {known}")
        given.append(f"{name} = {checks.number(name, value)!r};")

    names: dict[str, int] = {}
    points: dict[str, list[float]] = {}
    problem = ""
    if comm.rank == 0:
        gmsh.initialize(["gmsh", "-v", "1"])
    try:
        if comm.rank == 0:
            problem, names, points = _read(gmsh, path, given)
        problem, names, points = comm.bcast((problem, names, points))
        if problem:
            raise checks.InputError(f"file = {str(file)!r}: {problem}")
        dim = comm.bcast(gmsh.model.getDimension() if comm.rank == 0 else 0)
        mesh, tags = compat.gmsh_mesh(gmsh.model if comm.rank == 0 else None, comm, dim)
    finally:
        if comm.rank == 0:
            gmsh.finalize()
    return NamedMesh(mesh, tags, names, points)


def _open(gmsh: Any, path: Path, given: list[str]) -> None:
    """Open a file, the given parameters set before: DefineConstant leaves them as they are.

    The command line's -setnumber would outlive finalize() and reach the next mesh.
    """
    if path.suffix != ".geo":
        gmsh.open(str(path))
        return
    with tempfile.TemporaryDirectory() as directory:
        script = Path(directory) / path.name
        script.write_text("\n".join([*given, f'Include "{path.resolve()}";', ""]))
        gmsh.open(str(script))


def _read(
    gmsh: Any, path: Path, given: list[str]
) -> tuple[str, dict[str, int], dict[str, list[float]]]:
    """Open and mesh; what is wrong, or nothing, the names of the facets, and points by name."""
    try:
        _open(gmsh, path, given)
        dim = gmsh.model.getDimension()
        if dim not in (2, 3):
            return f"holds a mesh of dimension {dim}, not 2 or 3", {}, {}
        if path.suffix == ".geo":
            gmsh.model.mesh.generate(dim)
    except Exception as failure:  # gmsh raises nothing more special
        return f"gmsh says: {failure}", {}, {}
    x = gmsh.model.mesh.getNodes()[1].reshape(-1, 3)
    if dim == 2 and np.ptp(x[:, 2]) > SAME * np.ptp(x, axis=0).max():
        return "holds a surface in 3D, not a mesh of a solid (in 2D all nodes have one z)", {}, {}
    if not gmsh.model.getPhysicalGroups(dim):
        kind = "Surface" if dim == 2 else "Volume"
        return f"has no Physical {kind}, which tells what belongs to the solid", {}, {}
    if strange := _strange(gmsh, dim):
        return f"has cells of type {strange}; allowed are {ALLOWED}", {}, {}
    facets = gmsh.model.getPhysicalGroups(dim - 1)
    names = {gmsh.model.getPhysicalName(group, tag): tag for group, tag in facets}
    places = {
        gmsh.model.getPhysicalName(0, tag): gmsh.model.mesh.getNodesForPhysicalGroup(0, tag)[1]
        for _, tag in gmsh.model.getPhysicalGroups(0)
    }
    return "", names, {name: x[:dim].tolist() for name, x in places.items() if len(x) == 3}


def _strange(gmsh: Any, dim: int) -> str:
    """The types of the cells of the solid, if these are none that make one, or nothing."""
    model, kinds = gmsh.model, {}
    for _, group in model.getPhysicalGroups(dim):
        for entity in model.getEntitiesForPhysicalGroup(dim, group):
            for kind in model.mesh.getElementTypes(dim, entity):
                name, _, _, nodes, *_ = model.mesh.getElementProperties(kind)
                kinds[name] = nodes in NODES.get(name.split()[0].lower(), ())
    return "" if len(kinds) == 1 and all(kinds.values()) else ", ".join(sorted(kinds))


def _declared(path: Path) -> set[str]:
    """Names that a gmsh script declares by DefineConstant."""
    blocks = re.findall(r"DefineConstant\s*\[(.*?)\]\s*;", path.read_text(), flags=re.S)
    return {name for block in blocks for name in re.findall(r"(\w+)\s*=", block)}
