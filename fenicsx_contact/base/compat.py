# SPDX-License-Identifier: LGPL-3.0-or-later
"""The only module that knows dolfinx versions: 0.5.2 (Debian 12), 0.9 (Debian 13) and 0.11."""

from __future__ import annotations

from typing import Any

import basix
import dolfinx
import numpy as np
import ufl
from dolfinx import fem, geometry
from mpi4py import MPI

from .compiling import compiled, compiler, without_numbers

VERSION = tuple(int(part) for part in dolfinx.__version__.split(".")[:2])
MODERN = VERSION >= (0, 8)  # elements come from basix.ufl, wrappers hold a _cpp_object

if MODERN:
    import basix.ufl

#: What UFL raises where an expression makes no sense.
UFLError: type[Exception] = getattr(ufl, "UFLException", ValueError)


# -- meshes -------------------------------------------------------------------------------------


def create_mesh(
    comm: MPI.Comm, cells: np.ndarray, points: np.ndarray, cell: str, degree: int = 1
) -> Any:
    """A mesh of cells of a degree: ``cells`` (m, k), all their nodes in basix's order, index
    ``points`` (n, gdim)."""
    gdim, cells = points.shape[1], np.ascontiguousarray(cells, dtype=np.int64)
    points = np.ascontiguousarray(points, dtype=np.float64)
    if not MODERN:
        element = ufl.VectorElement("Lagrange", ufl.Cell(cell, geometric_dimension=gdim), degree)
        mesh = dolfinx.mesh.create_mesh(comm, cells, points, ufl.Mesh(element))
        settle_coordinates(mesh)
        return mesh
    domain = ufl.Mesh(basix.ufl.element("Lagrange", cell, degree, shape=(gdim,)))
    if VERSION >= (0, 10):
        return dolfinx.mesh.create_mesh(comm, cells, domain, points)
    return dolfinx.mesh.create_mesh(comm, cells, points, domain)


def settle_coordinates(mesh: Any) -> None:
    """Name the mesh's coordinate element as the first compilation would: forms before and after
    it, equal but for that name, are compiled once."""
    if MODERN:
        return
    domain = mesh.ufl_domain()
    element = domain.ufl_coordinate_element()
    if element.sub_elements()[0].variant() is None:
        kind, cell, degree = element.family(), element.cell(), element.degree()
        scalar = ufl.FiniteElement(kind, cell, degree, variant="equispaced")
        domain._ufl_coordinate_element = ufl.VectorElement(scalar)


def cell_name(mesh: Any) -> str:
    """Name of the cell type, e.g. ``"triangle"``."""
    return mesh.basix_cell().name if MODERN else mesh.topology.cell_type.name


def gmsh_order(cell: str, nodes: int) -> np.ndarray:
    """Where the nodes of a cell of dolfinx stand among those of gmsh."""
    return np.asarray(dolfinx.cpp.io.perm_gmsh(getattr(dolfinx.mesh.CellType, cell), nodes))


def cell_geometry(mesh: Any) -> np.ndarray:
    """Geometry nodes of the local cells, (m, k)."""
    if VERSION >= (0, 11):
        return np.asarray(mesh.geometry.dofmaps[0])
    return np.asarray(mesh.geometry.dofmap) if MODERN else _table(mesh.geometry.dofmap)


def tags_of(tags: Any, mesh: Any) -> bool:
    """Whether tags are of entities of this mesh, not of another one."""
    of = getattr(tags, "topology", None) or getattr(getattr(tags, "mesh", None), "topology", None)
    mine, theirs = (getattr(each, "_cpp_object", each) for each in (mesh.topology, of))
    return theirs is None or theirs is mine


def num_local_cells(mesh: Any) -> int:
    """Number of cells this process owns."""
    return mesh.topology.index_map(mesh.topology.dim).size_local


def given_cells(mesh: Any) -> np.ndarray:
    """Numbers of the owned cells, (m,): as given, the same on any processes; a submesh's own."""
    first, end = mesh.topology.index_map(mesh.topology.dim).local_range
    try:
        given = mesh.topology.original_cell_index[: end - first]
    except RuntimeError:  # of a submesh in 0.9
        given = ()
    return np.asarray(given if np.size(given) else range(first, end), dtype=np.int64)


def given_nodes(mesh: Any) -> np.ndarray:
    """Numbers of the local geometry nodes in the mesh as it was given, (n,)."""
    return np.asarray(mesh.geometry.input_global_indices, dtype=np.int64)


# -- function spaces ----------------------------------------------------------------------------


@compiler()
def lagrange_space(mesh: Any, degree: int = 1, shape: tuple[int, ...] = ()) -> Any:
    """Continuous Lagrange space of scalars (``shape=()``) or vectors (``shape=(d,)``)."""
    if MODERN:
        return fem.functionspace(mesh, ("Lagrange", degree, shape))
    if shape:
        return fem.VectorFunctionSpace(mesh, ("Lagrange", degree), dim=shape[0])
    return fem.FunctionSpace(mesh, ("Lagrange", degree))


@compiler()
def component_space(mesh: Any, components: int, degree: int = 1) -> Any:
    """A mixed space of ``components`` scalar Lagrange fields (never blocked, so that any of them
    can stand in a native sparse matrix)."""
    if MODERN:
        scalar = basix.ufl.element("Lagrange", mesh.basix_cell(), degree)
        return fem.functionspace(mesh, basix.ufl.mixed_element([scalar] * components))
    scalar = ufl.FiniteElement("Lagrange", mesh.ufl_cell(), degree)
    return fem.FunctionSpace(mesh, ufl.MixedElement([scalar] * components))


@compiler()
def cellwise_space(mesh: Any, dim: int = 0, degree: int = 0) -> Any:
    """Space of scalars, or vectors of ``dim`` components, of a degree in each cell: constant."""
    if MODERN:
        return fem.functionspace(mesh, ("DG", degree, (dim,)) if dim else ("DG", degree))
    if dim:
        return fem.VectorFunctionSpace(mesh, ("DG", degree), dim=dim)
    return fem.FunctionSpace(mesh, ("DG", degree))


def cell_dofs(space: Any) -> np.ndarray:
    """Dofs of the local cells, (m, k); of a sub-space: numbered in its parent."""
    return np.asarray(space.dofmap.list) if MODERN else _table(space.dofmap.list)


def _table(lists: Any) -> np.ndarray:
    """0.5.2's lists of equal length as an array, also where a process has none."""
    return lists.array.reshape(lists.num_nodes, -1 if lists.num_nodes else 1)


def space_with(space: Any, cells: np.ndarray, owned: int, ghosts: Any, ranks: Any) -> Any:
    """A space with other numbers for its blocks of unknowns.

    Args:
        space: whose elements it keeps.
        cells: the local numbers of the blocks of each local cell, ghosts after the owned ones.
        owned: how many blocks this process owns.
        ghosts: of the others the numbers among all, and the processes that own them.
        ranks: the processes that own ghosts of this one, and those which have some of its blocks.
    """
    old, V, cpp = space.dofmap, space._cpp_object, dolfinx.cpp
    of = np.asarray(ghosts[0], dtype=np.int64), np.asarray(ghosts[1], dtype=np.int32)
    known = [np.asarray(each, dtype=np.int32) for each in ranks]
    blocks = cpp.common.IndexMap(space.mesh.comm, owned, known, *of)
    table = cpp.graph.AdjacencyList_int32(np.ascontiguousarray(cells, dtype=np.int32))
    dofs = cpp.fem.DofMap(old.dof_layout, blocks, old.index_map_bs, table, old.bs)
    make = cpp.fem.FunctionSpace_float64 if MODERN else cpp.fem.FunctionSpace
    shape = (space.value_shape,) if MODERN and VERSION < (0, 10) else ()
    return fem.FunctionSpace(space.mesh, space.ufl_element(), make(V.mesh, V.element, dofs, *shape))


# -- forms --------------------------------------------------------------------------------------


def nodal_measure(mesh: Any, degree: int = 1) -> ufl.Measure:
    """Integration by the values at the nodes of degree 1 or, on intervals, 2.

    Lobatto's rule of degree 1 is the vertex rule on intervals and quadrilaterals (the one named
    "vertex" does not compile on intervals in 0.5.2), that of degree 3 is Simpson's.
    """
    rule = "vertex" if cell_name(mesh) in ("triangle", "tetrahedron") else "GLL"
    metadata = {"quadrature_rule": rule, "quadrature_degree": 2 * degree - 1}
    return ufl.Measure("dx", domain=mesh, metadata=metadata)


class _Assembler:
    """A form, compiled once, with what an assembly of it needs."""

    def __init__(self, form: ufl.Form) -> None:
        self._form = compiled(form)
        self._cpp = self._form._cpp_object if MODERN else self._form
        self.refresh_constants()

    def refresh_constants(self) -> None:
        """Read the form's constants again; to be called when one has changed."""
        self._constants = dolfinx.cpp.fem.pack_constants(self._cpp)

    def _packed(self) -> tuple[Any, Any]:
        return self._constants, dolfinx.cpp.fem.pack_coefficients(self._cpp)


class VectorAssembler(_Assembler):
    """A linear form, compiled once, assembled into one array that is made once (one process)."""

    def __init__(self, form: ufl.Form) -> None:
        super().__init__(form)
        dofmap = self._form.function_spaces[0].dofmap
        self.array = np.zeros(dofmap.index_map.size_local * dofmap.index_map_bs)

    def __call__(self) -> np.ndarray:
        self.array[:] = 0.0
        dolfinx.cpp.fem.assemble_vector(self.array, self._cpp, *self._packed())
        return self.array


class MatrixAssembler(_Assembler):
    """A bilinear form on an unblocked space, compiled once, assembled into one native sparse
    matrix that is made once (one process). ``indptr`` and ``indices`` give its pattern."""

    def __init__(self, form: ufl.Form) -> None:
        super().__init__(form)
        self._matrix = (fem if MODERN else fem.assemble).create_matrix(self._form)
        self._cpp_matrix = self._matrix._cpp_object if MODERN else self._matrix
        self._data = self._matrix.data
        self.indptr, self.indices = map(np.asarray, (self._matrix.indptr, self._matrix.indices))

    def __call__(self) -> np.ndarray:
        """Values of the matrix, in the order of its pattern."""
        self._data[:] = 0.0
        dolfinx.cpp.fem.assemble_matrix(self._cpp_matrix, self._cpp, *self._packed(), [])
        return self._data


class PointExpression:
    """A UFL expression evaluated at the nodes of a space, one row per cell."""

    def __init__(self, expression: Any, space: Any) -> None:
        mesh, points = space.mesh, space.element.interpolation_points
        if not isinstance(points, np.ndarray):
            points = points()  # a method before 0.10
        # with constants that a derivative does not hold 0.5.2 reads others in their stead
        expression = ufl.algorithms.expand_derivatives(expression)
        if not ufl.domain.extract_domains(expression):
            expression += fem.Constant(mesh, np.zeros(expression.ufl_shape))  # numbers have no mesh
        with compiler():
            self._expression = fem.Expression(without_numbers(expression, mesh), points)
        self._cells = np.arange(num_local_cells(mesh), dtype=np.int32)
        self._mesh, size = mesh, int(np.prod(expression.ufl_shape))
        self._shape = len(self._cells), len(points) * size

    def __call__(self) -> np.ndarray:
        """Values, (cells, nodes x components)."""
        if MODERN:
            return self._expression.eval(self._mesh, self._cells).reshape(self._shape)
        values = np.zeros(self._shape)
        self._expression._cpp_object.eval(self._cells, values)
        return values


class PointValues:
    """Values of a scalar dolfinx Function at fixed points (n, d) of its mesh, on every process, in
    the cells in which they are, or others (n, d) that say which of these.

    Raises:
        ValueError: it is no scalar, or a point is outside of its mesh.
    """

    def __init__(self, function: Any, points: np.ndarray, *others: np.ndarray) -> None:
        if function.ufl_shape:
            raise ValueError("it is no scalar")
        self._function, mesh = function, function.function_space.mesh
        self._points, within = (
            np.pad(each, ((0, 0), (0, 3 - each.shape[1]))) for each in (points, *others, points)[:2]
        )
        reach = 1e-10 * float(np.ptp(mesh.geometry.x, axis=0).max())
        make = geometry.bb_tree if MODERN else geometry.BoundingBoxTree
        tree = make(mesh, mesh.topology.dim, padding=reach)
        collide = geometry.compute_collisions_points if MODERN else geometry.compute_collisions
        cells = geometry.compute_colliding_cells(mesh, collide(tree, within), within)
        found = [cells.links(i)[:1] for i in range(len(points))]
        self._comm = comm = mesh.comm  # each process has a part: the first that has a point tells
        here = np.where([len(each) > 0 for each in found], comm.rank, comm.size)
        first = np.min(comm.allgather(here), axis=0)
        if (first == comm.size).any():
            raise ValueError("points of the contact are outside of its mesh")
        self._mine = np.flatnonzero(first == comm.rank)
        self._cells = np.array([found[i][0] for i in self._mine], dtype=np.int32)

    def __call__(self) -> np.ndarray:
        """The values now, (n,)."""
        values = np.zeros(len(self._points))
        if len(self._mine):
            told = self._function.eval(self._points[self._mine], self._cells)
            values[self._mine] = np.ravel(told)
        return np.sum(self._comm.allgather(values), axis=0)


def cell_constants(space: Any, values: np.ndarray) -> Any:
    """A coefficient of a :func:`cellwise_space` of scalars, from values (cells,) (one process)."""
    function = fem.Function(space)
    function.x.array[cell_dofs(space).ravel()] = values
    return function
