# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes whose facets have names, from gmsh or from dolfinx."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import dolfinx
import numpy as np
from mpi4py import MPI

from . import cells, checks, compat, shipped
from .constants import SAME


@dataclass(frozen=True)
class NamedMesh:
    """A dolfinx mesh, of cells of first or second degree, tags of its facets, the names of the
    tags, and the coordinates of points that have names.

    Attributes:
        degree: of its geometry, 1 or 2.

    Raises:
        InputError: cells of other kinds or degrees, flat, turned over or twice there, nodes that
            are nowhere, tags that are none.
    """

    mesh: Any
    facet_tags: Any
    names: Mapping[str, int]
    points: Mapping[str, Sequence[float]] = field(default_factory=dict)
    degree: int = field(init=False)

    def __post_init__(self) -> None:
        _check_mesh(self.mesh)
        checks.mapping("points", self.points, "from names to coordinates")
        for name, tag in checks.mapping("names", self.names, "from names to tags").items():
            checks.whole_number(f"names[{name!r}]", tag, at_least=-(2**31))
        if not hasattr(self.facet_tags, "find"):
            raise checks.InputError(f"facet_tags = {self.facet_tags!r}: must be MeshTags")
        tdim, gdim = self.mesh.topology.dim, self.mesh.geometry.dim
        if tdim != gdim or gdim not in (2, 3):
            raise checks.InputError(
                f"mesh of dimension {tdim} in a space of dimension {gdim}: a solid needs a mesh "
                "of triangles or quadrilaterals in 2D, of tetrahedra or hexahedra in 3D"
            )
        cell, comm = compat.cell_name(self.mesh), self.mesh.comm
        nodes = max(comm.allgather(compat.cell_geometry(self.mesh).shape[1]))
        if not cells.degree_of(cell, nodes):
            raise checks.InputError(
                f"mesh: has {nodes} nodes in each {cell}; must be of first or second degree, with "
                f"{' or '.join(map(str, cells.NODES[cell]))}"
            )
        object.__setattr__(self, "degree", cells.degree_of(cell, nodes))
        if problem := max(comm.allgather(self._problem())):
            raise checks.InputError(f"mesh: {problem}")

    def _problem(self) -> str:
        if not compat.num_local_cells(self.mesh):
            return ""
        x = self.mesh.geometry.x[:, : self.dim]
        if not np.isfinite(x).all():
            return "has a node with a coordinate that is not finite"
        nodes = compat.cell_geometry(self.mesh)
        signs = cells.orientations(x[nodes], compat.cell_name(self.mesh))
        if not signs.all():
            return "has a cell without volume"
        if len(np.unique(np.sort(nodes, axis=1), axis=0)) < len(nodes):
            return "has a cell twice"
        if (signs != signs[:, :1]).any():
            return "has a cell that is turned over at a node"
        return ""

    @property
    def dim(self) -> int:
        """Dimension of space."""
        return self.mesh.geometry.dim

    def facets(self, name: str) -> np.ndarray:
        """Local facets that bear the name.

        Raises:
            InputError: the mesh has no such name, or no facet bears it.
        """
        if not isinstance(name, str) or name not in self.names:
            known = ", ".join(map(repr, sorted(self.names))) or "none"
            raise checks.InputError(
                f"facets = {name!r}: the mesh has no such name (it has {known})"
            )
        facets = self.facet_tags.find(self.names[name])
        if self.mesh.comm.allreduce(len(facets)) == 0:
            raise checks.InputError(f"facets = {name!r}: no facet of the mesh bears this name")
        return facets

    def boundary(self, name: str, degree: int = 1) -> tuple[np.ndarray, np.ndarray, str]:
        """The named facets, whole on every process and in the same order on any number of them, as
        they bound a field of a degree: curved ones as they are for one of their own degree, for
        one of first degree the straight facets between all their nodes.

        Returns:
            Points (n, d), cells (m, k), corners first, and the name of the cell.
        """
        mesh, comm = self.mesh, self.mesh.comm
        nodes, _ = self._owned_facets(name, degree)
        ids = compat.given_nodes(mesh)[nodes.ravel()]
        x = mesh.geometry.x[nodes.ravel(), : self.dim]
        all_ids = np.concatenate(comm.allgather(np.asarray(ids)))
        all_x = np.concatenate(comm.allgather(x))
        _, first, found = np.unique(all_ids, return_index=True, return_inverse=True)
        found = found.reshape(-1, nodes.shape[1])
        return all_x[first], found[np.lexsort(np.sort(found).T)], self._facet

    def behind(self, name: str, degree: int = 1) -> np.ndarray:
        """For each of these facets the mean of its corners and that of the cell behind it,
        (m, 2, d), whole on every process, in no particular order."""
        nodes, behind = self._owned_facets(name, degree)
        x, corners = self.mesh.geometry.x[:, : self.dim], cells.NODES[self._facet][0]
        ends = x[nodes[:, :corners]].mean(axis=1), x[behind].mean(axis=1)
        return np.concatenate(self.mesh.comm.allgather(np.stack(ends, axis=1)))

    @property
    def _facet(self) -> str:
        return cells.FACET[compat.cell_name(self.mesh)]

    def _owned_facets(self, name: str, degree: int) -> tuple[np.ndarray, np.ndarray]:
        """Nodes of the named facets that this process owns, (m, k), and of the cells behind."""
        owned = self.mesh.topology.index_map(self.dim - 1).size_local
        facets = self.facets(name)
        nodes, behind = cells.facet_nodes(self.mesh, facets[facets < owned], self.degree)
        if degree < self.degree:
            pieces = np.array(cells.PIECES[self._facet])
            nodes = nodes[:, pieces].reshape(-1, pieces.shape[1])
            behind = np.repeat(behind, len(pieces), axis=0)
        return nodes, behind


def _check_mesh(mesh: Any) -> None:
    if not hasattr(mesh, "topology") or not hasattr(mesh, "geometry"):
        raise checks.InputError(f"mesh = {mesh!r}: must be a mesh of dolfinx")


def name_facets(mesh: Any, where: Mapping[str, Callable[[np.ndarray], np.ndarray]]) -> NamedMesh:
    """Names for the boundary facets of a dolfinx mesh.

    Args:
        mesh: the mesh.
        where: for each name a function of ``x`` (3, n) that is true on the facets meant.
    """
    _check_mesh(mesh)
    fdim = mesh.topology.dim - 1
    mesh.topology.create_connectivity(fdim, mesh.topology.dim)
    where = checks.mapping("where", where, "from names to functions of x (3, n)")
    found = [
        dolfinx.mesh.locate_entities_boundary(mesh, fdim, _marker(name, f))
        for name, f in where.items()
    ]
    facets = np.concatenate([*found, np.empty(0, dtype=np.int32)]).astype(np.int32)
    values = np.repeat(np.arange(1, len(found) + 1), [len(f) for f in found]).astype(np.int32)
    if len(np.unique(facets)) != len(facets):
        raise checks.InputError(f"where = {list(where)}: two of the names claim the same facet")
    order = np.argsort(facets)
    tags = dolfinx.mesh.meshtags(mesh, fdim, facets[order], values[order])
    return NamedMesh(mesh, tags, {name: i for i, name in enumerate(where, start=1)})


def _marker(name: str, f: Any) -> Callable[[np.ndarray], np.ndarray]:
    """The function, its answers checked."""
    what = f"where[{name!r}]"
    problem = f"{what} = {f!r}: must be a function of x (3, n) that gives n truth values"
    if not isinstance(name, str) or not checks.is_function(f):
        raise checks.InputError(problem)

    def marked(x: np.ndarray) -> np.ndarray:
        answer = np.asarray(checks.plain(checks.called(what, f, x)))
        if answer.dtype != bool or answer.shape != x.shape[1:]:
            raise checks.InputError(problem)
        return answer

    return marked


def name_points(mesh: NamedMesh, points: Mapping[str, Sequence[float]]) -> NamedMesh:
    """The mesh with names for points, at which a solid may be held.

    Args:
        mesh: the mesh.
        points: d coordinates, m, by name.

    Raises:
        InputError: coordinates that are none, a name that the mesh has already.
    """
    checks.instance("mesh", mesh, NamedMesh, "a NamedMesh (mesh_from_gmsh, name_facets)")
    points = checks.mapping("points", points, "from names to coordinates")
    for name, place in points.items():
        checks.vector(f"points[{name!r}]", place, mesh.dim)
        if name in mesh.names:
            raise checks.InputError(f"points[{name!r}]: the mesh has facets of this name")
    return replace(mesh, points={**mesh.points, **points})


def mesh_from_gmsh(
    file: str | Path, comm: MPI.Comm = MPI.COMM_WORLD, **parameters: float
) -> NamedMesh:
    """A mesh from a gmsh script (``.geo``) or mesh (``.msh``); its physical names are those of
    facets and points.

    Args:
        file: path of the file. A bare name that the present folder lacks (``"block.geo"``) is that
            of a script which comes with the package: see ``meshes/`` of its source.
        comm: the processes over which the mesh is distributed.
        parameters: values for what the script declares by ``DefineConstant``.

    Raises:
        InputError: no such file, a parameter that the script does not declare, nothing meshed.
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
    facets = gmsh.model.getPhysicalGroups(dim - 1)
    names = {gmsh.model.getPhysicalName(group, tag): tag for group, tag in facets}
    places = {
        gmsh.model.getPhysicalName(0, tag): gmsh.model.mesh.getNodesForPhysicalGroup(0, tag)[1]
        for _, tag in gmsh.model.getPhysicalGroups(0)
    }
    return "", names, {name: x[:dim].tolist() for name, x in places.items() if len(x) == 3}


def _declared(path: Path) -> set[str]:
    """Names that a gmsh script declares by DefineConstant."""
    blocks = re.findall(r"DefineConstant\s*\[(.*?)\]\s*;", path.read_text(), flags=re.S)
    return {name for block in blocks for name in re.findall(r"(\w+)\s*=", block)}
