# SPDX-License-Identifier: LGPL-3.0-or-later
"""Dead loads of deformable solids: in fixed directions, given per volume or area of the solid at
rest."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
import ufl
from dolfinx import fem

from ..base import assembly, checks
from ..base.checks import is_function
from ..base.compiling import compiled
from ..base.processes import together
from ..base.quoted import quoted
from .coefficients import Field, arguments, field, is_field
from .vector_space import VectorSpace

#: d numbers, a Constant, a Function, an expression in UFL (of tractions with ``FacetNormal``, too),
#: or a function of t, of x, of x and t; of one argument that is of x whose argument is called x.
#: Constants and Functions count as they are when a step begins.
Load = Any


def _varies_in_space(what: str, value: Load) -> bool:
    if not is_function(value):
        return is_field(value)
    named = arguments(value)
    if len(named) > 2:
        raise checks.InputError(
            f"{what} = {quoted(value)}: must be a function of t, of x, or of x and t"
        )
    return named == ["x"] or len(named) == 2


class _Part(Protocol):
    def at(self, time: float) -> np.ndarray:
        """The load at a time, for the owned unknowns, N."""


class _Uniform:
    """A load that is the same everywhere: numbers times the loads of unit directions."""

    def __init__(self, what: str, value: Any, units: np.ndarray, comm: Any) -> None:
        self._what, self._value, self._units, self._comm = what, value, units, comm

    def at(self, time: float) -> np.ndarray:
        return together(self._comm, lambda: self._vector(time), checks.InputError) @ self._units

    def _vector(self, time: float) -> np.ndarray:
        value, what = self._value, self._what
        timed = is_function(value)
        what += f"({time:g})" if timed else ""
        given = checks.called(what, value, time) if timed else value
        return checks.vector(what, given, len(self._units))


class _InSpace:
    """A load that differs from place to place, assembled anew where it depends on time."""

    def __init__(self, what: str, given: Field, form: Any, vectors: VectorSpace) -> None:
        self._what, self._field, self._form, self._vectors = what, given, form, vectors
        constants = ufl.algorithms.analysis.extract_constants(given.expression)
        functions = ufl.algorithms.extract_coefficients(given.expression)
        self._given = [*(c.value for c in constants), *(f.x.array for f in functions)]
        self._read = self._now()
        self._load = self._assembled(0.0)

    def _now(self) -> np.ndarray:
        """What it is given by, which may change."""
        return np.concatenate([np.empty(0), *map(np.ravel, self._given)])

    def _assembled(self, time: float) -> np.ndarray:
        self._field.at(time)
        load = np.empty(self._vectors.owned)
        assembly.assemble_owned(self._form, load)
        if not min(self._vectors.comm.allgather(bool(np.isfinite(load).all()))):
            raise checks.InputError(f"{self._what}: not finite everywhere at t = {time:g} s")
        return load

    def at(self, time: float) -> np.ndarray:
        if not self._field.steady:
            return self._assembled(time)
        if self._given:
            now = self._now()
            if max(self._vectors.comm.allgather(not np.array_equal(now, self._read))):
                self._read, self._load = now, self._assembled(time)
        return self._load


class Loads:
    """All of them.

    Args:
        vectors: the space of displacements.
        tractions: forces on named facets, Pa (N/m per thickness in 2D).
        body_force: N/m³.
        breadth: what the plane stands for, in UFL.

    Raises:
        InputError: a name that the mesh lacks, facets inside it, a load that is not one.
    """

    def __init__(
        self, vectors: VectorSpace, tractions: Mapping[str, Load], body_force: Load, breadth: Any
    ) -> None:
        self._vectors, self._breadth = vectors, breadth
        self._parts: list[_Part] = []
        mesh = vectors.mesh
        for name, traction in tractions.items():
            vectors.facets(name, "tractions")
            self._add(f"tractions[{name!r}]", traction, *mesh.measures(name))
        if body_force is not None:
            self._add("body_force", body_force, ufl.Measure("dx", domain=mesh.mesh))
        self.total(0.0)  # refuse now what can be refused

    def _add(self, what: str, value: Load, measure: ufl.Measure) -> None:
        vectors, d = self._vectors, self._vectors.dim
        test, units = ufl.TestFunction(vectors.space), np.empty((d, vectors.owned))
        direction = fem.Constant(vectors.mesh.mesh, np.zeros(d))
        form = compiled(self._breadth * ufl.dot(direction, test) * measure)
        for i, load in enumerate(units):
            direction.value[:] = np.eye(d)[i]
            assembly.assemble_owned(form, load)
        if not max(vectors.comm.allgather(bool(units.any()))):
            raise checks.InputError(f"{what}: none of these facets is on the boundary of the mesh")
        if _varies_in_space(what, value):
            given = field(what, value, vectors.mesh, (d,), measure.integral_type() != "cell")
            density = self._breadth * ufl.dot(given.expression, test)
            if isinstance(density, ufl.constantvalue.Zero):
                return
            of = compiled(density * measure)
            self._parts.append(_InSpace(what, given, of, vectors))
        else:
            self._parts.append(_Uniform(what, value, units, vectors.comm))

    def total(self, time: float) -> np.ndarray:
        """The load at a time, for the owned unknowns, N."""
        with checks.asked_at(time):
            nothing = np.zeros(self._vectors.owned)
            return np.sum([nothing, *(part.at(time) for part in self._parts)], axis=0)
