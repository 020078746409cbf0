# SPDX-License-Identifier: LGPL-3.0-or-later
"""The vector fields on a mesh: their unknowns, and which of them a process owns.

Arrays of values hold the owned unknowns, (owned,): all components of a node, node by node.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from dolfinx import fem
from petsc4py import PETSc
from scipy.spatial import cKDTree

from ..base import checks, compat
from ..base.expressions import is_expression
from ..base.mesh import NamedMesh
from ..base.quoted import quoted
from ..base.vectors import components
from .coefficients import field as in_ufl
from .pieces import Pieces

#: A field given as a function of ``x`` (3, n) with values (d, n), or in UFL on the mesh.
Field = Callable[[np.ndarray], np.ndarray] | Any


class VectorSpace:
    """Continuous vector fields on a mesh that may be distributed.

    Args:
        mesh: the mesh.
        degree: 1 or 2, not less than that of the mesh.
        space: the function space, if not that of all nodes of the mesh.

    Attributes:
        dim, comm: dimension of space, and the processes.
        space: the function space.
        owned, unknowns: how many unknowns this process owns, and how many there are.
        first: the number of this process's first unknown among all.
        places: of the owned nodes, (owned/d, d) in m.
        sites, site_nodes: all places of owned nodes, which may have several, (m, d), and whose
            they are, (m,).
        periods: translations by which all fields repeat themselves, (p, d) in m.
        joined: names of facets that are none of the surface, because their nodes are one with
            those of others.
        told: what of it is said of a solid.

    Raises:
        InputError: another degree.
    """

    joined: frozenset[str] = frozenset()

    def __init__(self, mesh: NamedMesh, degree: int, space: Any = None) -> None:
        if (degree := checks.whole_number("degree", degree, at_least=1)) > 2:
            raise checks.InputError(f"degree = {degree!r}: must be 1 or 2")
        if degree < mesh.degree:
            raise checks.InputError(
                f"degree = {degree!r}: must be 2 on a mesh of second degree; one of first degree "
                "has straight cells"
            )
        self.mesh, self.degree, self.dim = mesh, degree, mesh.dim
        many = mesh.mesh.topology.index_map(mesh.dim).size_global
        self.told = f", {many} cells ({compat.cell_name(mesh.mesh)})"
        self.comm, d = mesh.mesh.comm, mesh.dim
        every = compat.lagrange_space(mesh.mesh, degree, shape=(d,)) if space is None else space
        self.space, self.periods = every, np.empty((0, d))
        self._at_mesh = compat.lagrange_space(mesh.mesh, mesh.degree, shape=(d,))
        index_map = self.space.dofmap.index_map
        self.owned = index_map.size_local * d
        self.unknowns = index_map.size_global * d
        self.first = index_map.local_range[0] * d
        self.places = self.space.tabulate_dof_coordinates()[: index_map.size_local, :d]
        self.sites, self.site_nodes = self.places, np.arange(len(self.places))
        self._x, self._y = (self._vector() for _ in range(2))

    def _vector(self) -> PETSc.Vec:
        vector = PETSc.Vec().create(self.comm)
        vector.setSizes((self.owned, None))
        vector.setType(PETSc.Vec.Type.STANDARD)
        return vector

    def facets(self, name: str, what: str) -> np.ndarray:
        """The local facets that bear a name, given by the argument ``what``.

        Raises:
            InputError: the mesh has no such name, or no facet bears it.
        """
        try:
            return self.mesh.facets(name)
        except checks.InputError as problem:
            raise checks.InputError(f"{what}: {problem}") from None

    def nodes_of(self, names: Sequence[str] | str, what: str) -> np.ndarray:
        """The nodes of the named facets that this process owns, sorted.

        Args:
            names: of facets.
            what: the argument that names them, for messages.

        Raises:
            InputError: a name that the mesh lacks, or that no facet bears.
        """
        blocks = [np.empty(0, dtype=np.int32)]
        given = [names] if isinstance(names, str) else checks.listed(what, names, "names of facets")
        for name in given:
            facets = self.facets(name, what)
            blocks.append(fem.locate_dofs_topological(self.space, self.dim - 1, facets))
        nodes = np.unique(np.concatenate(blocks)).astype(np.int64)
        return nodes[nodes < self.owned // self.dim]

    def nearest(self, points: np.ndarray, facets: str = "") -> tuple[np.ndarray, np.ndarray]:
        """The owned node next to each point (n, d), of named facets if given: distances in m,
        infinite where this process owns none, and nodes, (n,)."""
        sites, nodes = self.sites, self.site_nodes
        if facets:
            there = np.isin(nodes, self.nodes_of(facets, "facets"))
            sites, nodes = sites[there], nodes[there]
        if not len(sites):
            return np.full(len(points), np.inf), np.zeros(len(points), dtype=np.int64)
        distance, site = cKDTree(sites).query(points)
        return distance, nodes[site]

    def twins(self, points: np.ndarray) -> np.ndarray:
        """For each of these nodes, given by coordinates (n, d), which of them stands for it: itself
        unless others have the same unknowns, (n,)."""
        return np.arange(len(points))

    @cached_property
    def pieces(self) -> Pieces:
        """Of the mesh."""
        return Pieces(self)

    def cell_places(self) -> np.ndarray:
        """Where the nodes of each owned cell are, (cells, nodes, d) in m."""
        cells = compat.cell_dofs(self.space)[: compat.num_local_cells(self.mesh.mesh)]
        return self.space.tabulate_dof_coordinates()[cells, : self.dim]

    def at(self, nodes: np.ndarray) -> np.ndarray:
        """All unknowns of some nodes, flat."""
        return components(nodes, self.dim)

    def multiply(self, matrix: PETSc.Mat, values: np.ndarray) -> np.ndarray:
        """A matrix of the space times values of the owned unknowns."""
        self._x.setArray(values)
        matrix.mult(self._x, self._y)
        return self._y.array_r.copy()

    def sum(self, value: float) -> float:
        """The sum over all processes."""
        return float(self.comm.allreduce(value)) if self.comm.size > 1 else float(value)

    @cached_property
    def numbers(self) -> np.ndarray:
        """Of the owned unknowns among all, numbered as they come in the cells of the mesh as it was
        given, whatever the processes, (owned,)."""
        mesh, blocks = self.mesh.mesh, self.space.dofmap.index_map
        cells = compat.cell_dofs(self.space)[: compat.num_local_cells(mesh)]
        given = compat.given_cells(mesh)
        places = given[:, None] * cells.shape[1] + np.arange(cells.shape[1])
        nodes = np.asarray(blocks.local_to_global(cells.ravel().astype(np.int32)))
        first = np.full(blocks.size_global, np.iinfo(np.int64).max)
        for some, at in self.comm.allgather((nodes, places.ravel())):
            np.minimum.at(first, some, at)
        numbers = np.empty(len(first), dtype=np.int64)
        numbers[first.argsort()] = np.arange(len(first))
        return self.at(numbers[slice(*blocks.local_range)])

    def whole(self, values: np.ndarray) -> np.ndarray:
        """Values of all unknowns as the mesh was given, on the first process, from those of the
        owned unknowns, (..., owned)."""
        parts = self.comm.gather((self.numbers, values))
        result = np.empty((*values.shape[:-1], self.unknowns if parts else 0))
        for numbers, some in parts or ():
            result[..., numbers] = some
        return result

    def part(self, whole: np.ndarray) -> np.ndarray:
        """Values of the owned unknowns from those of all, (..., unknowns)."""
        return np.ascontiguousarray(whole[..., self.numbers])

    def diagonal(self, matrix: PETSc.Mat) -> np.ndarray:
        """The diagonal of a matrix of the space, (owned,)."""
        matrix.getDiagonal(self._y)
        return self._y.array_r.copy()

    def interpolate(self, what: str, field: Field | None) -> np.ndarray:
        """Values of a field, None being zero.

        Args:
            what: the argument that gave it, for messages.
            field: the field: d numbers, a function of x, or UFL on the mesh (Function, Constant).

        Raises:
            InputError: no such field, values of another shape, or not finite.
        """
        if isinstance(field, (fem.Constant, Sequence, np.ndarray)):
            return np.tile(checks.vector(what, field, self.dim), self.owned // self.dim)
        function = fem.Function(self.space)

        def values_at(x: np.ndarray) -> np.ndarray:
            problem = f"{what}: must be a function of x (3, n) with values ({self.dim}, n), finite"
            values = checks.table(problem, checks.called(what, field, x))  # type: ignore[arg-type]
            if values.shape != (self.dim, x.shape[1]):
                raise checks.InputError(
                    f"{what}: gives values of shape {values.shape} at x of shape {x.shape}; must "
                    f"be a function of x (3, n) with values ({self.dim}, n)"
                )
            return values

        if is_expression(field):
            given = in_ufl(what, field, self.mesh, (self.dim,)).expression
            function.x.array[: self.owned] = self.reader(given)()
        elif field is not None:
            if not checks.is_function(field):
                raise checks.InputError(
                    f"{what} = {quoted(field)}: must be {self.dim} numbers or a function of "
                    "x (3, n)"
                )
            function.interpolate(values_at)  # the owned values are right without the ghosts
        values = function.x.array[: self.owned].copy()
        if not min(self.comm.allgather(bool((np.abs(values) <= checks.LARGEST).all()))):
            raise checks.InputError(
                f"{what}: the initial field is not finite everywhere, or above {checks.LARGEST:g}"
            )
        return values

    def reader(self, expression: Any) -> Callable[[], np.ndarray]:
        """What gives the values, (owned,), of a vector in UFL as they are when it is called."""
        nodes = compat.cell_dofs(self.space)[: compat.num_local_cells(self.mesh.mesh)].ravel()
        scalars = compat.lagrange_space(self.mesh.mesh, self.degree)
        compiled, values = compat.PointExpression(expression, scalars), fem.Function(self.space)

        def read() -> np.ndarray:
            values.x.array.reshape(-1, self.dim)[nodes] = compiled().reshape(-1, self.dim)
            return values.x.array[: self.owned].copy()

        return read

    def assign(self, function: Any, values: np.ndarray) -> None:
        """Give a function of the space the values of its owned unknowns."""
        function.x.array[: self.owned] = values
        function.x.scatter_forward()

    def function(self, values: np.ndarray) -> Any:
        """A function of the space from the values of its owned unknowns."""
        function = fem.Function(self.space)
        self.assign(function, values)
        return function

    def at_mesh(self, values: np.ndarray) -> np.ndarray:
        """The field at the local nodes of the mesh's geometry, (n, d)."""
        mesh = self.mesh.mesh
        nodes, dofs = compat.cell_geometry(mesh), compat.cell_dofs(self._at_mesh)
        there = fem.Function(self._at_mesh)
        there.interpolate(self.function(values))
        result = np.zeros((len(mesh.geometry.x), self.dim))
        result[nodes.ravel()] = there.x.array.reshape(-1, self.dim)[dofs.ravel()]
        return result
