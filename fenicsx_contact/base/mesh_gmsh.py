# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes with named facets from gmsh: scripts, and its own files."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from . import checks, compat, shipped
from .cells import ALLOWED, NODES
from .mesh import NamedMesh
from .mesh_session import opened
from .mesh_solid import ReadSolid, distributed


def mesh_from_gmsh(
    file: str | Path, comm: MPI.Comm = MPI.COMM_WORLD, **parameters: float
) -> NamedMesh:
    """A mesh from a gmsh script (``.geo``) or mesh (``.msh``); its physical names are those of
    facets and points. Cells are of first order, or of second (``Mesh.ElementOrder = 2;``).

    The solid is made of all cells in physical groups, each taken once; what belongs to none of
    them is left out, with the names of facets and the nodes that only that has. A group of facets
    without a name has its number for one (``"7"``); one of points is taken where it has a name and
    one point. A session of gmsh that is open already stays as it is; the options that are set there
    hold for scripts, too.

    Args:
        file: path of the file. A bare name that the present folder lacks (``"block.geo"``) is that
            of a script which comes with the package: see ``meshes/`` of its source.
        comm: the processes over which the mesh is distributed.
        parameters: values for what the script declares by ``DefineConstant``.

    Raises:
        InputError: no such file, a parameter that the script does not declare, nothing meshed,
            cells of other types or orders, or distorted; facets in two groups that are not the
            same, or partly of what is left out; a name for two groups.
    """
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

    def read() -> ReadSolid:
        with opened(path, given) as model:
            return _solid(model)

    return distributed(file, comm, read, "let each be in one physical group")


def _solid(model: Any) -> ReadSolid:
    """The cells of an open model, its named facets and points."""
    dim = model.getDimension()
    tags, x, _ = model.mesh.getNodes()
    order = np.argsort(tags)
    tags, x = tags[order], x.reshape(-1, 3)[order]

    def elements(dim: int, *groups: int) -> dict[str, np.ndarray]:
        """Of each type the elements (m, k), each once, as indices of nodes."""
        found: dict[str, list[np.ndarray]] = {}
        for group in groups:
            for entity in model.getEntitiesForPhysicalGroup(dim, group):
                for kind, _, nodes in zip(*model.mesh.getElements(dim, entity)):
                    name, _, _, size, *_ = model.mesh.getElementProperties(kind)
                    rows = np.searchsorted(tags, nodes).reshape(-1, size)
                    found.setdefault(name, []).append(rows)
        return {name: _each_once(np.concatenate(parts)) for name, parts in found.items()}

    solid = elements(dim, *(group for _, group in model.getPhysicalGroups(dim)))
    if not solid:
        kind = "Surface" if dim == 2 else "Volume"
        raise checks.InputError(
            f"has no cells in a Physical {kind}, which tells what belongs to the solid"
        )
    (kind, cells), *others = solid.items()
    cell = kind.split()[0].lower()
    if others or cells.shape[1] not in NODES.get(cell, ()):
        strange = ", ".join(sorted(solid))
        raise checks.InputError(f"has cells of type {strange}; allowed are {ALLOWED}")
    read = ReadSolid(x, cells[:, compat.gmsh_order(cell, cells.shape[1])], cell)
    for name, group in _groups(model, dim - 1).items():
        found = read.these(name, list(elements(dim - 1, group).values()), partly=False)
        if len(found):
            read.facets[name] = found
    for name, group in _groups(model, 0).items():
        place = model.mesh.getNodesForPhysicalGroup(0, group)[1]
        if len(place) == 3 and model.getPhysicalName(0, group):
            read.places[name] = place[:dim].tolist()
    return read


def _each_once(rows: np.ndarray) -> np.ndarray:
    """The rows in their order, without those that come again: files of version 2 hold an element
    once for each of its groups."""
    return rows[np.sort(np.unique(rows, axis=0, return_index=True)[1])]


def _groups(model: Any, dim: int) -> dict[str, int]:
    """The physical groups of a dimension by name, those without one by their number."""
    groups: dict[str, int] = {}
    for _, group in model.getPhysicalGroups(dim):
        name = model.getPhysicalName(dim, group) or str(group)
        if name in groups:
            raise checks.InputError(f"has two physical groups {name!r} of dimension {dim}")
        groups[name] = group
    return groups


def _declared(path: Path) -> set[str]:
    """Names that a gmsh script declares by DefineConstant."""
    blocks = re.findall(r"DefineConstant\s*\[(.*?)\]\s*;", path.read_text(), flags=re.S)
    return {name for block in blocks for name in re.findall(r"(\w+)\s*=", block)}
