# SPDX-License-Identifier: LGPL-3.0-or-later
"""Refusal of bad input: every message names the argument, its value and what is allowed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from numbers import Real
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np
import ufl

from .overflow import told
from .quoted import quoted
from .valueless import valueless

#: The size of admissible numbers lies between the inverse of this and this: their squares and
#: products stay far inside the range of a double.
LARGEST = 1e60


class InputError(ValueError):
    """Input that cannot be computed with; raised before the first step."""


class StepFailed(RuntimeError):
    """A step that cannot be taken at its length; the message is the reason."""


@contextmanager
def asked_at(time: float) -> Iterator[None]:
    """Within it input is asked for what it is at a time, s: what cannot be computed with at the
    start is refused, later a step fails by it."""
    try:
        yield
    except InputError as error:
        if time > 0:
            raise StepFailed(str(error)) from None
        raise


def plain(value: Any) -> Any:
    """The value of a ``fem.Constant``, as it is now, None for another expression of UFL, in lists
    and arrays too: numpy and ``float`` would ask it for its components without end."""
    if isinstance(value, ufl.core.expr.Expr):
        return getattr(value, "value", None)
    if isinstance(value, np.ndarray) and value.dtype == object:
        value = value.tolist()
    return [plain(each) for each in value] if isinstance(value, (list, tuple)) else value


def floats(value: Any) -> np.ndarray:
    """The value as floats; text, truth values, times and what is masked are no numbers.

    Raises:
        TypeError, ValueError: it cannot be had.
    """
    array = np.asarray(plain(value))
    if array.dtype.kind in "bSUcmM" or np.ma.is_masked(value) or _holds_truth(value):
        raise TypeError("no real numbers")
    if array.dtype.kind == "O" and any(each is None for each in array.flat):  # NaN to numpy
        raise TypeError("no real numbers: None")
    try:
        return np.array(array, dtype=float)
    except Exception as problem:  # of a number of the user's, or an int that is too large
        raise TypeError(f"no real numbers: {problem}") from None


def _holds_truth(value: Any) -> bool:
    """Whether a truth value stands in lists, among numbers too, of which numpy makes 0 and 1."""
    if isinstance(value, (list, tuple)):
        return any(map(_holds_truth, value))
    return isinstance(value, (bool, np.bool_))


def number(
    name: str,
    value: Any,
    *,
    at_least: float | None = None,
    above: float | None = None,
    at_most: float | None = None,
    also: str = "",
) -> float:
    """``value``, a number or a scalar ``fem.Constant``, as a float, or an :class:`InputError`, that
    tells what is ``also`` allowed in its place."""
    limits = (">=", at_least), (">", above), ("<=", at_most)
    bounds = [f"{sign} {limit:g}" for sign, limit in limits if limit is not None]
    allowed = "a finite number" + (" " + " and ".join(bounds) if bounds else "") + also
    value = value.item() if isinstance(value, np.generic) else value  # told as a plain number
    try:
        array = floats(value)
        if array.ndim:
            raise TypeError("a list, be it of one number")
        result = float(array)
    except (TypeError, ValueError):
        raise InputError(f"{name} = {quoted(value)}: must be {allowed}") from None
    inside = (
        math.isfinite(result)
        and (at_least is None or result >= at_least)
        and (above is None or result > above)
        and (at_most is None or result <= at_most)
    )
    if not inside:
        raise InputError(f"{name} = {quoted(value)}: must be {allowed}")
    if abs(result) > LARGEST or 0 < abs(result) < 1 / LARGEST:
        raise InputError(
            f"{name} = {quoted(value)}: must lie between {1 / LARGEST:g} and {LARGEST:g} in size; "
            "in these units its powers overflow, choose others"
        )
    return result


def keep(thing: Any, name: str, **limits: Any) -> None:
    """Check a number that a frozen dataclass was given, see :func:`number`, and let it hold the
    float in place of a Constant or a fraction."""
    object.__setattr__(thing, name, number(name, getattr(thing, name), **limits))


def called(what: str, function: Callable, *arguments: Any) -> Any:
    """What a function of the user's gives, or an :class:`InputError` with what it raises."""
    try:
        with told():
            return function(*arguments)
    except StepFailed:
        raise
    except Exception as problem:
        raise InputError(
            f"{what}: its function {quoted(function)} raises {type(problem).__name__}: {problem}"
        ) from problem


@contextmanager
def naming(what: str) -> Iterator[None]:
    """Within it what a user's own part raises is an :class:`InputError` that names it."""
    try:
        with valueless():
            yield
    except (InputError, StepFailed):
        raise
    except Exception as problem:
        raise InputError(f"{what} raises {type(problem).__name__}: {problem}") from problem


def scalar(what: str, value: Any) -> ufl.core.expr.Expr:
    """A scalar of UFL, or an :class:`InputError` that says what it is instead."""
    shape = getattr(value, "ufl_shape", None)
    if not isinstance(value, (Real, ufl.core.expr.Expr)) or shape:
        found = f"of the shape {shape}" if shape else f"a {type(value).__name__}"
        raise InputError(f"{what} is {found}: must be a scalar in UFL")
    return ufl.as_ufl(value)


def is_function(value: Any) -> TypeGuard[Callable[..., Any]]:
    """Whether it is to be called; UFL may be called, too, but for other ends."""
    return callable(value) and not isinstance(value, ufl.core.expr.Expr)


def function(name: str, value: Any, allowed: str = "") -> Any:
    """``value`` if it is to be called, else an :class:`InputError`."""
    if not is_function(value):
        raise InputError(f"{name} = {quoted(value)}: must be a function{allowed}")
    return value


def point(name: str, value: Any) -> tuple[int, np.ndarray]:
    """The dimension of space and a point in it, from 2 or 3 finite numbers."""
    try:
        size = len(np.atleast_1d(floats(value)))
    except (TypeError, ValueError):
        size = 0
    if size not in (2, 3):
        raise InputError(f"{name} = {quoted(value)}: must be 2 or 3 finite numbers")
    return size, vector(name, value, size)


def table(problem: str, value: Any) -> np.ndarray:
    """The value as finite floats of any shape, or an :class:`InputError` that tells the problem."""
    try:
        result = floats(value)
    except (TypeError, ValueError):
        raise InputError(problem) from None
    if not (np.abs(result) <= LARGEST).all():
        raise InputError(problem)
    return result


def direction(name: str, value: Any, size: int) -> np.ndarray:
    """A unit vector along this one."""
    along = vector(name, value, size)
    length = float(np.linalg.norm(along))
    if length == 0:
        raise InputError(f"{name} = {quoted(value)}: must not be zero")
    return along / length


def vector(name: str, value: Any, size: int) -> np.ndarray:
    """``value`` as ``size`` finite floats, or an :class:`InputError`."""
    try:
        result = floats(value)
    except (TypeError, ValueError):
        raise InputError(f"{name} = {quoted(value)}: must be {size} finite numbers") from None
    if result.shape != (size,) or not np.isfinite(result).all():
        raise InputError(f"{name} = {quoted(value)}: must be {size} finite numbers")
    for component in result:
        number(name, component)
    return result


def whole_number(name: str, value: Any, *, at_least: int) -> int:
    """``value`` as an int of at least ``at_least``, or an :class:`InputError`."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < at_least:
        raise InputError(f"{name} = {quoted(value)}: must be a whole number >= {at_least}")
    return int(value)


def truth(name: str, value: Any) -> bool:
    """``value`` if it is True or False, else an :class:`InputError`."""
    if not isinstance(value, (bool, np.bool_)):
        raise InputError(f"{name} = {quoted(value)}: must be True or False")
    return bool(value)


def label(name: str, value: Any) -> str:
    """``value`` if it can name a thing and its files, else an :class:`InputError`."""
    if not isinstance(value, str) or not value or "/" in value or not value.isprintable():
        raise InputError(f"{name} = {quoted(value)}: must be a text that names a file, without '/'")
    if len(value.encode()) > 200:  # of 255 that file systems take, the rest for what is appended
        raise InputError(f"{name} = {quoted(value)}: must name a file, by at most 200 bytes")
    return value


def choice(name: str, value: Any, allowed: Iterable[str]) -> str:
    """``value`` if it is one of ``allowed``, else an :class:`InputError`."""
    known: Sequence[str] = list(allowed)
    if not isinstance(value, str) or value not in known:
        raise InputError(f"{name} = {quoted(value)}: must be one of {', '.join(map(repr, known))}")
    return value


def path(name: str, value: Any) -> Path:
    """``value`` as a path, or an :class:`InputError`."""
    if instance(name, value, (str, Path), "a path") == "":  # Path takes it for the present one
        raise InputError(f"{name} = {quoted(value)}: must be a path ('.' is the present directory)")
    if "\0" in str(value):
        raise InputError(f"{name} = {quoted(value)}: must be a path, without a zero character")
    return Path(value)


def instance(name: str, value: Any, kind: type | tuple[type, ...], allowed: str) -> Any:
    """``value`` if it is of ``kind``, else an :class:`InputError`."""
    if not isinstance(value, kind):
        raise InputError(f"{name} = {quoted(value)}: must be {allowed}")
    return value


def offers(name: str, value: Any, protocol: type, allowed: str) -> Any:
    """``value`` if it has all public members of a protocol (or of an abstract base class), whether
    it inherits from it or not, else an :class:`InputError` that names those which it lacks."""
    if isinstance(value, type):
        raise InputError(f"{name} = {quoted(value)}: must be {allowed}, not a class")
    members = _members(protocol)
    lacks = sorted(m for m in members if not (hasattr(value, m) or hasattr(type(value), m)))
    if lacks:
        some = f"; it lacks {', '.join(lacks[:4])}{', ...' if len(lacks) > 4 else ''}"
        raise InputError(f"{name} = {quoted(value)}: must be {allowed}{some}")
    return value


def _members(protocol: type) -> set[str]:
    """The public names that a class and its bases define or annotate."""
    own = [c for c in protocol.__mro__ if c.__module__ not in ("builtins", "abc", "typing")]
    names = {n for c in own for n in [*vars(c), *vars(c).get("__annotations__", ())]}
    return {n for n in names if not n.startswith("_")}


def listed(name: str, values: Any, allowed: str) -> list[Any]:
    """``values`` as a list, whatever they are, or an :class:`InputError`."""
    plain = isinstance(values, (list, tuple)) or (isinstance(values, np.ndarray) and values.ndim)
    if not plain:
        raise InputError(f"{name} = {quoted(values)}: must be a list of {allowed}")
    return list(values)


def mapping(name: str, value: Any, allowed: str) -> Mapping:
    """``value`` if it is a dict, {} for None, else an :class:`InputError`."""
    if value is not None and not isinstance(value, Mapping):
        raise InputError(f"{name} = {quoted(value)}: must be a dict {allowed}")
    return {} if value is None else value


def sequence(name: str, values: Any, kind: Any, allowed: str) -> list[Any]:
    """``values`` as a list of things of one class, or an :class:`InputError`."""
    if not isinstance(values, (list, tuple)) or not all(isinstance(v, kind) for v in values):
        raise InputError(f"{name} = {quoted(values)}: must be a list of {allowed}")
    return list(values)
