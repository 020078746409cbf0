# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes whose facets have names."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import dolfinx
import numpy as np
import ufl

from . import cells, checks, compat
from .quoted import quoted


@dataclass(frozen=True)
class NamedMesh:
    """A dolfinx mesh of cells of first or second degree, tags of its facets, the names of the tags,
    and the coordinates of points that have names.

    Attributes:
        degree: of its geometry, 1 or 2.

    Raises:
        InputError: cells of other kinds or degrees, flat, turned over or twice there, nodes that
            are nowhere, tags that are none or not of facets of the mesh, points that are none or
            have names of facets.
    """

    mesh: Any
    facet_tags: Any
    names: Mapping[str, int]
    points: Mapping[str, Sequence[float]] = field(default_factory=dict)
    degree: int = field(init=False)

    def __post_init__(self) -> None:
        _check_mesh(self.mesh)
        for name, of in ("points", "from names to coordinates"), ("names", "from names to tags"):
            object.__setattr__(self, name, checks.mapping(name, getattr(self, name), of))
        for name, tag in self.names.items():
            checks.whole_number(f"names[{name!r}]", tag, at_least=-(2**31))
        tdim, gdim = self.mesh.topology.dim, self.mesh.geometry.dim
        if tdim != gdim or gdim not in (2, 3):
            raise checks.InputError(
                f"mesh of dimension {tdim} in a space of dimension {gdim}: a solid needs a mesh "
                "of triangles or quadrilaterals in 2D, of tetrahedra or hexahedra in 3D"
            )
        self._check_tags()
        for name, place in self.points.items():
            checks.vector(f"points[{name!r}]", place, gdim)
            if name in self.names:
                raise checks.InputError(f"points[{name!r}]: the mesh has facets of this name")
        cell, comm = compat.cell_name(self.mesh), self.mesh.comm
        nodes = max(comm.allgather(compat.cell_geometry(self.mesh).shape[1]))
        if not cells.degree_of(cell, nodes):
            raise checks.InputError(
                f"mesh: has {nodes} nodes in each {cell}; allowed are {cells.ALLOWED}"
            )
        object.__setattr__(self, "degree", cells.degree_of(cell, nodes))
        compat.settle_coordinates(self.mesh)
        if problem := max(comm.allgather(self._problem())):
            raise checks.InputError(f"mesh: {problem}")

    def _check_tags(self) -> None:
        """Refuse tags that are not of facets of the mesh."""
        tags, topology, comm = self.facet_tags, self.mesh.topology, self.mesh.comm
        if not all(hasattr(tags, each) for each in ("find", "dim", "indices")):
            raise checks.InputError(f"facet_tags = {quoted(tags)}: must be MeshTags")
        fdim = topology.dim - 1
        if tags.dim != fdim:
            raise checks.InputError(
                f"facet_tags: are of dimension {tags.dim}; must be of facets, of dimension {fdim}"
            )
        if not compat.tags_of(tags, self.mesh):
            raise checks.InputError("facet_tags: are of the facets of another mesh")
        topology.create_entities(fdim)
        facets, given = topology.index_map(fdim), np.asarray(tags.indices)
        there = facets.size_local + facets.num_ghosts
        if strange := comm.allreduce(int(((given < 0) | (given >= there)).sum())):
            raise checks.InputError(
                f"facet_tags: {strange} of them are of facets that the mesh does not have"
            )

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
    def grain(self) -> float:
        """The largest extent of a cell of this process along an axis, m."""
        corners = self.mesh.geometry.x[compat.cell_geometry(self.mesh)]
        return float(np.ptp(corners, axis=1).max(initial=0.0))

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

    def _outer(self, name: str, or_none: bool = False) -> np.ndarray:
        """Local facets that bear the name, all of which must bound the mesh, or may all be within
        it."""
        facets = self.facets(name)
        owned = facets[facets < self.mesh.topology.index_map(self.dim - 1).size_local]
        inner = len(np.setdiff1d(owned, self.skin_facets()))
        inside, every = (self.mesh.comm.allreduce(n) for n in (inner, len(owned)))
        if inside and not (or_none and inside == every):
            raise checks.InputError(
                f"facets = {name!r}: {inside} of these {every} facets are inside the mesh; all "
                "must be on its boundary"
            )
        return facets

    def measures(self, *names: str) -> list[ufl.Measure]:
        """Integration over each of these facets, in one form. They are numbered anew: whatever
        numbers their tags have, equal forms are compiled once. Facets inside the mesh give nothing.

        Raises:
            InputError: the mesh has no such name, or no facet bears it, or some that do bound the
                mesh and others are inside.
        """
        parts = [self._outer(name, or_none=True) for name in names]
        marks = np.repeat(np.arange(1, len(parts) + 1, dtype=np.int32), list(map(len, parts)))
        facets = np.concatenate([np.empty(0, dtype=np.int32), *parts])
        order = np.argsort(facets)
        tags = dolfinx.mesh.meshtags(self.mesh, self.dim - 1, facets[order], marks[order])
        ds = ufl.Measure("ds", domain=self.mesh, subdomain_data=tags)
        return [ds(number) for number in range(1, len(parts) + 1)]

    def boundary(self, name: str, degree: int = 1) -> tuple[np.ndarray, np.ndarray, str]:
        """The named facets, whole on every process and in the same order on any number of them, as
        they bound a field of a degree: curved ones as they are for one of their own degree, for
        one of first degree the straight facets between all their nodes.

        Returns:
            Points (n, d), cells (m, k), corners first, and the name of the cell.

        Raises:
            InputError: the mesh has no such name, or no facet bears it, or some that do are inside.
        """
        return self._gathered(self._outer(name), degree)

    def skin(self) -> tuple[np.ndarray, np.ndarray, str]:
        """All facets that bound the mesh, whatever their names, likewise, straight."""
        return self._gathered(self.skin_facets(), 1)

    def skin_facets(self) -> np.ndarray:
        """The facets that bound the mesh, of this process, by local numbers."""
        fdim = self.dim - 1
        self.mesh.topology.create_connectivity(fdim, self.dim)
        return dolfinx.mesh.locate_entities_boundary(
            self.mesh, fdim, lambda x: np.ones(x.shape[1], dtype=bool)
        )

    def _gathered(self, facets: np.ndarray, degree: int) -> tuple[np.ndarray, np.ndarray, str]:
        mesh, comm = self.mesh, self.mesh.comm
        nodes, _ = self._owned_facets(facets, degree)
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
        nodes, behind = self._owned_facets(self.facets(name), degree)
        x, corners = self.mesh.geometry.x[:, : self.dim], cells.NODES[self._facet][0]
        ends = x[nodes[:, :corners]].mean(axis=1), x[behind].mean(axis=1)
        return np.concatenate(self.mesh.comm.allgather(np.stack(ends, axis=1)))

    @property
    def _facet(self) -> str:
        return cells.FACET[compat.cell_name(self.mesh)]

    def _owned_facets(self, facets: np.ndarray, degree: int) -> tuple[np.ndarray, np.ndarray]:
        """Nodes of those of the facets that this process owns, (m, k), and of the cells behind."""
        owned = self.mesh.topology.index_map(self.dim - 1).size_local
        nodes, behind = cells.facet_nodes(self.mesh, facets[facets < owned], self.degree)
        if degree < self.degree:
            pieces = np.array(cells.PIECES[self._facet])
            nodes = nodes[:, pieces].reshape(-1, pieces.shape[1])
            behind = np.repeat(behind, len(pieces), axis=0)
        return nodes, behind


def _check_mesh(mesh: Any) -> None:
    if not hasattr(mesh, "topology") or not hasattr(mesh, "geometry"):
        raise checks.InputError(f"mesh = {quoted(mesh)}: must be a mesh of dolfinx")


def name_facets(mesh: Any, where: Mapping[str, Callable[[np.ndarray], np.ndarray]]) -> NamedMesh:
    """Names for the boundary facets of a dolfinx mesh.

    Args:
        mesh: the mesh.
        where: for each name a function of ``x`` (3, n) that is true on the facets meant.

    Raises:
        InputError: two names of the same facet, no truth values.
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
    if mesh.comm.allreduce(len(facets) - len(np.unique(facets))):
        raise checks.InputError(f"where = {list(where)}: two of the names claim the same facet")
    order = np.argsort(facets)
    tags = dolfinx.mesh.meshtags(mesh, fdim, facets[order], values[order])
    return NamedMesh(mesh, tags, {name: i for i, name in enumerate(where, start=1)})


def _marker(name: str, f: Any) -> Callable[[np.ndarray], np.ndarray]:
    """The function, its answers checked."""
    what = f"where[{name!r}]"
    problem = f"{what} = {quoted(f)}: must be a function of x (3, n) that gives n truth values"
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
    return replace(mesh, points={**mesh.points, **points})
