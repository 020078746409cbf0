# SPDX-License-Identifier: LGPL-3.0-or-later
"""Expressions of UFL that a user wrote on a mesh: what they are made of."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import ufl
from dolfinx import fem

from .checks import InputError
from .compiling import quiet


def is_expression(value: Any) -> bool:
    """Whether it is written in UFL."""
    return isinstance(value, ufl.core.expr.Expr)


@contextmanager
def symbolic() -> Iterator[None]:
    """Within it functions of the user's are called with arguments in UFL, of which nobody can make
    a float: ``math.sin`` would end in a TypeError after some thousand warnings, or never."""
    own = ufl.core.expr.Expr.__float__
    ufl.core.expr.Expr.__float__ = _refuse_float
    try:
        with quiet(logging.ERROR):  # what UFL refuses it logs, too
            yield
    finally:
        ufl.core.expr.Expr.__float__ = own


def _refuse_float(value: Any) -> float:
    if hasattr(value, "value"):  # of a Constant
        return float(value.value)
    raise TypeError("it asks UFL for a number, as math.sin does and ufl.sin does not")


def is_coordinate(terminal: Any) -> bool:
    """Whether it is the coordinates of a mesh."""
    return isinstance(terminal, ufl.classes.SpatialCoordinate)


def terminals_off(mesh: Any, expression: Any) -> list[Any]:
    """Coordinates, Functions and Constants of an expression that are not of this mesh."""
    kinds = (ufl.classes.SpatialCoordinate, fem.Function, fem.Constant)
    found = ufl.corealg.traversal.traverse_unique_terminals(expression)
    here = mesh.ufl_domain()
    off = [each for each in found if isinstance(each, kinds)]
    return [each for each in off if here not in ufl.domain.extract_domains(each)]


def wrong_number(expression: Any) -> str:
    """What is written in it that is no finite number, for which C has no name, or nothing."""
    for each in ufl.corealg.traversal.traverse_unique_terminals(expression):
        if isinstance(each, ufl.classes.FloatValue) and not math.isfinite(float(each)):
            return f"the number {float(each)} stands in it: must be finite"
    return ""


def finite_form(form: ufl.Form) -> ufl.Form:
    """The form, if every number that is written in it is finite.

    Raises:
        InputError: one is not.
    """
    for integral in form.integrals():
        if problem := wrong_number(integral.integrand()):
            raise InputError(f"a law of the contact: {problem}")
    return form
