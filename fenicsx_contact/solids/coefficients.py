# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers and fields as users give them, in UFL.

A material's number may be a number, a ``fem.Constant``, a ``fem.Function``, an expression in UFL of
the place x of a point at rest, or a function of x; a load may be each of these for d components,
and a function of x and t, or of t alone. Functions of x are called with the coordinates of UFL,
where ``x[0]`` is a scalar; one that UFL cannot take (``np.where``, ``np.sin``) is called with x as
an array (3, n), gives n numbers for each component, and is interpolated with degree 2 in each cell.
With functions of x and t it is the other way round: ``math.sin(t)`` of a constant of UFL never
ends.
"""

from __future__ import annotations

import inspect
import logging
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
import ufl
from dolfinx import fem
from ufl.algorithms.analysis import extract_type

from ..base import checks, compat
from ..base.checks import is_function
from ..base.compiling import quiet
from ..base.expressions import symbolic, terminals_off, wrong_number
from ..base.mesh import NamedMesh
from ..base.processes import together
from ..base.quoted import quoted
from ..base.told import written

Expression = ufl.core.expr.Expr
#: A number, Constant, Function, expression in UFL, or function of x.
Scalar = Any


def is_field(value: Any) -> bool:
    """Whether it is UFL but no constant."""
    return isinstance(value, Expression) and not isinstance(value, fem.Constant)


def arguments(function: Callable) -> list[str]:
    """The names of the arguments that a function needs, or that are called t or time, for which it
    has a default; those of one that hides them are ``t``."""
    try:
        given = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return ["t"]
    by_place = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    asked = [p for p in given if p.kind in by_place]
    needed = [p.name for p in asked if p.default is p.empty or p.name in ("t", "time")]
    return needed or ["t"]


class Field(Protocol):
    """A field in space, and perhaps in time.

    Attributes:
        expression: in UFL.
        steady: does not depend on time.
    """

    expression: Any
    steady: bool

    def at(self, time: float) -> None:
        """Make the expression that of a time, s."""


class Written:
    """A field whose expression holds the time."""

    def __init__(self, expression: Any, time: Any, steady: bool) -> None:
        self.expression, self._time, self.steady = expression, time, steady

    def at(self, time: float) -> None:
        self._time.value = time


class Sampled:
    """A field interpolated with degree 2 in each cell from the values of a function at places
    (3, n), a hair inside of the cell: so a field may jump from cell to cell; what it is, for
    messages."""

    def __init__(
        self, what: str, function: Callable, mesh: Any, shape: tuple[int, ...], steady: bool
    ) -> None:
        self._what, self._function, self.steady, self._comm = what, function, steady, mesh.comm
        space = compat.cellwise_space(mesh, sum(shape), 2)
        self.expression = fem.Function(space)
        x, cells = space.tabulate_dof_coordinates(), compat.cell_dofs(space)
        hair = np.finfo(float).eps ** 0.75  # more than round-off of places, and less than all else
        x[cells] += hair * (x[cells].mean(axis=1)[:, None] - x[cells])
        self._x = x.T
        self._values = self.expression.x.array.reshape(-1, *shape)

    def at(self, time: float) -> None:
        together(self._comm, lambda: self._ask(time), checks.InputError)

    def _ask(self, time: float) -> None:
        with checks.naming(self._what):
            given = self._function(self._x, *([] if self.steady else [time]))
            components = [given] if self._values.ndim == 1 else list(given)
            if any(isinstance(component, Expression) for component in components):
                raise TypeError("it gives UFL")
            if len(components) != self._values[:1].size and self._values.size:
                raise ValueError(f"{len(components)} components")
            for i, component in enumerate(components):
                self._values.reshape(len(self._values), -1)[:, i] = checks.floats(component)


def field(
    what: str, value: Any, mesh: NamedMesh, shape: tuple[int, ...] = (), on_facets: bool = False
) -> Field:
    """An expression of UFL or a function of x, or of x and t, as a field.

    Args:
        what: the argument that gave it, for messages.
        value: the expression or function.
        mesh: on which it lives.
        shape: of its values.
        on_facets: it is asked there, and may use their normals.

    Raises:
        InputError: values of another shape, complex or not finite, of another mesh.
    """
    domain, d = mesh.mesh, int(np.prod(shape))
    normal = ufl.FacetNormal(domain)
    any_normal = {normal: ufl.as_vector([1.0] * mesh.dim)} if on_facets else {}
    time = fem.Constant(domain, 0.0)
    size = f"{d} components" if shape else "a number"
    allowed = f"must give {size}, finite and real, on the mesh of the solid"
    steady = is_field(value) or len(arguments(value)) == 1

    def written() -> Field:
        x = ufl.SpatialCoordinate(domain)
        with symbolic():
            expression = value if is_field(value) else value(x, *([] if steady else [time]))
        return Written(_in_ufl(expression, shape), time, steady)

    def interpolated() -> Field:
        sample = Sampled(what, value, domain, shape, steady)
        sample.at(0.0)
        return sample

    ways = [written] if is_field(value) else [written, interpolated]
    problems: list[str] = []
    for way in ways if steady else reversed(ways):
        try:
            with quiet(logging.ERROR):  # of what is tried UFL logs the failure, too
                made = way()
            break
        except Exception as failure:  # what one of them cannot take raises anything
            problems.append(str(failure))
    problem = "; ".join(problems) if len(problems) == len(ways) else ""
    problem = max(domain.comm.allgather(problem))
    if not problem:
        values = sampled(ufl.replace(made.expression, any_normal), mesh)
        finite = isinstance(values, np.ndarray) and np.abs(values).max(initial=0) <= checks.LARGEST
        problem = values if isinstance(values, str) else "" if finite else "not finite everywhere"
    if problem := max(domain.comm.allgather(problem)):
        raise checks.InputError(f"{what} = {quoted(value)}: {allowed} ({problem})")
    return made


def _in_ufl(value: Any, shape: tuple[int, ...]) -> Any:
    if shape and not isinstance(value, Expression):
        value = ufl.as_vector(list(value))
    value = ufl.as_ufl(value)
    if value.ufl_shape != shape:
        raise ValueError(f"its shape is {value.ufl_shape}")
    return value


def sampled(expression: Any, mesh: NamedMesh) -> np.ndarray | str:
    """Values at the corners and midpoints of the cells of this process, or what is wrong."""
    domain = mesh.mesh
    try:
        if problem := _strange(expression, mesh):
            return problem
        here = fem.Constant(domain, 1.0) * expression  # what is the same everywhere has no mesh
        return compat.PointExpression(here, compat.lagrange_space(domain, 2))()
    except Exception as failure:  # of the form compiler, of whatever kind
        return str(failure) or repr(failure)


def of_a_field(what: str, given: Callable[[Any], Any], unknown: Any, mesh: NamedMesh) -> Any:
    """What a function gives of an unknown field, in UFL.

    Raises:
        InputError: what a form cannot hold: no scalar of UFL, one of another mesh, or with test or
            trial functions.
    """
    with symbolic():
        value = checks.called(f"{what}, in UFL", given, unknown)
    if getattr(value, "ufl_shape", None) != ():
        raise checks.InputError(f"{what} = {quoted(given)}: must give a scalar in UFL")
    if problem := _strange(value, mesh):
        raise checks.InputError(f"{what} = {quoted(given)}: {problem}")
    return value


def _strange(expression: Any, mesh: NamedMesh) -> str:
    """Why a form on the mesh cannot hold an expression, or nothing."""
    if terminals_off(mesh.mesh, expression):
        return "it lives on another mesh"
    if ufl.algorithms.extract_arguments(expression):
        return "it holds test or trial functions"
    if extract_type(expression, ufl.classes.GeometricFacetQuantity):
        return "it holds normals of facets, or what else belongs to them alone"
    if problem := wrong_number(expression):
        return problem
    parts = [c.x.array for c in ufl.algorithms.extract_coefficients(expression)]
    parts += [c.value for c in ufl.algorithms.analysis.extract_constants(expression)]
    return "it is complex" if any(np.iscomplexobj(part) for part in parts) else ""


def number(what: str, value: Scalar, *, above: float, below: float = np.inf) -> Any:
    """A number of a material where no mesh is known: a float, or a scalar in UFL as it is.

    Raises:
        InputError: out of its limits, themselves excluded; UFL that is no scalar.
    """
    if is_field(value) and value.ufl_shape == ():
        return value
    plain = checks.number(what, value, above=above, also=", or a scalar in UFL")
    if not plain < below:
        raise checks.InputError(f"{what} = {quoted(value)}: must be < {below:g}")
    return plain


def scalar(
    what: str,
    value: Scalar,
    mesh: NamedMesh,
    kept: dict[Any, Any],
    *,
    above: float,
    below: float = np.inf,
) -> tuple[Any, str]:
    """A number of a material.

    Args:
        what: the argument that gave it, for messages.
        value: a number, Constant, Function, expression in UFL, or function of x.
        mesh: of the solid.
        kept: see :func:`as_now`.
        above, below: its limits, themselves excluded.

    Returns:
        A float, or an expression in UFL that stays what it is now; and a text that tells it.

    Raises:
        InputError: out of its limits somewhere, or as :func:`field`.
    """
    if not is_field(value) and not is_function(value):
        plain = number(what, value, above=above, below=below)
        stays = as_now(value, mesh, kept) if isinstance(value, fem.Constant) else plain
        return stays, repr(plain)
    if is_function(value) and len(arguments(value)) != 1:
        raise checks.InputError(f"{what} = {quoted(value)}: must be a function of x alone")
    made = field(what, value, mesh)
    values, comm = sampled(made.expression, mesh), mesh.mesh.comm
    assert isinstance(values, np.ndarray)
    least = min(comm.allgather(float(values.min(initial=np.inf))))
    most = max(comm.allgather(float(values.max(initial=-np.inf))))
    if not (least > above and most < below):
        bounds = f"> {above:g}" + (f" and < {below:g}" if below < np.inf else "")
        raise checks.InputError(
            f"{what} = {quoted(value)}: must be {bounds}; it lies between {least:g} and {most:g}"
        )
    told = written(f"between {least:.9g} and {most:.9g}", made.expression)
    return as_now(made.expression, mesh, kept), told


def as_now(expression: Any, mesh: NamedMesh, kept: dict[Any, Any]) -> Any:
    """An expression whose Constants and Functions are what they are now, whatever becomes of them.

    Args:
        expression: in UFL.
        mesh: on which it lives.
        kept: copies, by what they are of; those that it lacks are added.
    """
    for each in ufl.corealg.traversal.traverse_unique_terminals(expression):
        if isinstance(each, fem.Constant) and each not in kept:
            kept[each] = fem.Constant(mesh.mesh, each.value)
        elif isinstance(each, fem.Function) and each not in kept:
            kept[each] = each.copy()
    return ufl.replace(expression, kept)


def constant(mesh: NamedMesh, value: Any) -> Any:
    """A number as a constant of UFL, so that other numbers need no new form; UFL as it is."""
    return value if isinstance(value, Expression) else fem.Constant(mesh.mesh, value)
