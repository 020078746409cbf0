# SPDX-License-Identifier: LGPL-3.0-or-later
"""Parameters of interface laws: numbers, or what varies in space and time."""

from __future__ import annotations

from typing import Any

from ..base import checks
from ..base.expressions import is_expression
from ..base.shown import shown

#: A number >= 0; or a function of the place [m], and of the time [s] if it has a second argument,
#: in UFL; or UFL on the mesh of the slave: of its coordinates, a dolfinx Function, a Constant. A
#: function sees where a point is now (a floor), UFL belongs to the material (a coating). Values are
#: read at the nodes of the surface; of a Function that jumps there, the mean over its facets.
Parameter = Any


def varies(value: Parameter) -> bool:
    """Whether it is no number."""
    return is_expression(value) or callable(value)


def parameter(
    name: str, value: Parameter, *, above: float | None = None, also: str = ""
) -> Parameter:
    """What was given, a number as a float. What varies is asked for its values, which must be
    finite and >= 0, when a contact is made. ``also``: what else is allowed, for the refusal.

    Raises:
        InputError: a number below 0, or not above the limit if there is one, or something else.
    """
    if varies(value) and not isinstance(value, type):
        return value
    also = f", a function of x or of (x, t) that gives one in UFL{also}"
    return checks.number(name, value, at_least=0 if above is None else None, above=above, also=also)


def keep_parameter(thing: Any, name: str, *, above: float | None = None) -> None:
    """Check a parameter that a frozen dataclass was given, and let it hold a number as a float."""
    object.__setattr__(thing, name, parameter(name, getattr(thing, name), above=above))


def told(value: Parameter) -> str:
    """In a few words, without an address in memory."""
    return shown(value) if varies(value) else f"{value:g}"


def static_and_kinetic(k: Any, law: Any) -> tuple[Any, Any]:
    """``static`` and ``kinetic`` of a law on the fields k of a surface. Where they vary their
    difference is a parameter, too.

    Raises:
        InputError: mu_k > mu_s somewhere at the start; later a step in which it is fails.
    """
    static, kinetic = k.field("static", law.static), k.field("kinetic", law.kinetic)
    if varies(law.static) or varies(law.kinetic):
        k.field("static - kinetic", static - kinetic)
    return static, kinetic
