# SPDX-License-Identifier: LGPL-3.0-or-later
"""Refusal of bad input: every message names the argument, its value and what is allowed.

And the exception of a step that cannot be taken.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import ufl

#: The size of admissible numbers lies between the inverse of this and this: their squares and
#: products stay far inside the range of a double.
LARGEST = 1e60


class InputError(ValueError):
    """Input that cannot be computed with; raised before the first step."""


class StepFailed(RuntimeError):
    """A step that cannot be taken at its length; the message is the reason."""


def _plain(value: Any) -> Any:
    """The value of a ``fem.Constant``, as it is now, None for another expression of UFL: numpy and
    ``float`` would ask it for its components without end."""
    return getattr(value, "value", None) if isinstance(value, ufl.core.expr.Expr) else value


def floats(value: Any) -> np.ndarray:
    """The value as floats; text and truth values are no numbers."""
    array = np.asarray(_plain(value))
    if array.dtype.kind in "bSUc":
        raise TypeError("no real numbers")
    return np.array(array, dtype=float)


def number(
    name: str,
    value: Any,
    *,
    at_least: float | None = None,
    above: float | None = None,
    at_most: float | None = None,
) -> float:
    """``value``, a number or a scalar ``fem.Constant``, as a float, or an :class:`InputError`."""
    limits = (">=", at_least), (">", above), ("<=", at_most)
    bounds = [f"{sign} {limit:g}" for sign, limit in limits if limit is not None]
    allowed = "a finite number" + (" " + " and ".join(bounds) if bounds else "")
    try:
        result = float(floats(value))
    except (TypeError, ValueError):
        raise InputError(f"{name} = {value!r}: must be {allowed}") from None
    inside = (
        math.isfinite(result)
        and (at_least is None or result >= at_least)
        and (above is None or result > above)
        and (at_most is None or result <= at_most)
    )
    if not inside:
        raise InputError(f"{name} = {value!r}: must be {allowed}")
    if abs(result) > LARGEST or 0 < abs(result) < 1 / LARGEST:
        raise InputError(
            f"{name} = {value!r}: must lie between {1 / LARGEST:g} and {LARGEST:g} in size; "
            "in these units its powers overflow, choose others"
        )
    return result


def vector(name: str, value: Any, size: int) -> np.ndarray:
    """``value`` as ``size`` finite floats, or an :class:`InputError`."""
    try:
        result = floats(value)
    except (TypeError, ValueError):
        raise InputError(f"{name} = {value!r}: must be {size} finite numbers") from None
    if result.shape != (size,) or not np.isfinite(result).all():
        raise InputError(f"{name} = {value!r}: must be {size} finite numbers")
    for component in result:
        number(name, component)
    return result


def whole_number(name: str, value: Any, *, at_least: int) -> int:
    """``value`` as an int of at least ``at_least``, or an :class:`InputError`."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < at_least:
        raise InputError(f"{name} = {value!r}: must be a whole number >= {at_least}")
    return int(value)


def truth(name: str, value: Any) -> bool:
    """``value`` if it is True or False, else an :class:`InputError`."""
    if not isinstance(value, (bool, np.bool_)):
        raise InputError(f"{name} = {value!r}: must be True or False")
    return bool(value)


def label(name: str, value: Any) -> str:
    """``value`` if it can name a thing and its files, else an :class:`InputError`."""
    if not isinstance(value, str) or not value or "/" in value or not value.isprintable():
        raise InputError(f"{name} = {value!r}: must be a text that can name a file, without '/'")
    return value


def choice(name: str, value: Any, allowed: Iterable[str]) -> str:
    """``value`` if it is one of ``allowed``, else an :class:`InputError`."""
    options: Sequence[str] = list(allowed)
    if value not in options:
        raise InputError(f"{name} = {value!r}: must be one of {', '.join(map(repr, options))}")
    return value


def instance(name: str, value: Any, kind: type | tuple[type, ...], allowed: str) -> Any:
    """``value`` if it is of ``kind``, else an :class:`InputError`."""
    if not isinstance(value, kind):
        raise InputError(f"{name} = {value!r}: must be {allowed}")
    return value


def offers(name: str, value: Any, protocol: type, allowed: str) -> Any:
    """``value`` if it has all public members of a protocol (or of an abstract base class), whether
    it inherits from it or not, else an :class:`InputError` that names those which it lacks."""
    if isinstance(value, type):
        raise InputError(f"{name} = {value!r}: must be {allowed}, not a class")
    members = _members(protocol)
    lacks = sorted(m for m in members if not (hasattr(value, m) or hasattr(type(value), m)))
    if lacks:
        some = f"; it lacks {', '.join(lacks[:4])}{', ...' if len(lacks) > 4 else ''}"
        raise InputError(f"{name} = {value!r}: must be {allowed}{some}")
    return value


def _members(protocol: type) -> set[str]:
    """The public names that a class and its bases define or annotate."""
    own = [c for c in protocol.__mro__ if c.__module__ not in ("builtins", "abc", "typing")]
    names = {n for c in own for n in [*vars(c), *vars(c).get("__annotations__", ())]}
    return {n for n in names if not n.startswith("_")}


def sequence(name: str, values: Any, kind: type, allowed: str) -> list[Any]:
    """``values`` as a list of things of one class, or an :class:`InputError`."""
    if not isinstance(values, (list, tuple)) or not all(isinstance(v, kind) for v in values):
        raise InputError(f"{name} = {values!r}: must be a list of {allowed}")
    return list(values)
