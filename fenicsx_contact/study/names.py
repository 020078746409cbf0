# SPDX-License-Identifier: LGPL-3.0-or-later
"""Functions by name and by what is bound to them, by which files tell whose results they hold."""

from __future__ import annotations

import copyreg
import sys
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np

from ..base.told import MANY
from ..base.told_ufl import eight_digits

_PLAIN = (type(None), bool, int, float, complex, str, bytes)


def named(function: Any) -> str:
    """What tells a function that pickle takes from others: its file and its name in it, the same
    where that is the script and where it is imported; of a ``partial``, a method, or an object that
    is called all that is bound, too. What the function does is not told."""
    return _told(function, ())


def _told(thing: Any, around: tuple[Any, ...]) -> str:
    """By what pickle keeps of it; around: what holds it."""
    if any(thing is each for each in around):
        return "..."  # it holds itself
    if isinstance(thing, np.generic):
        thing = thing.item()
    if type(thing) in _PLAIN:
        return repr(thing)
    if isinstance(thing, (FunctionType, type)):
        return _placed(thing)
    name, parts = _parts(thing, (*around, thing))
    text = ", ".join(parts)
    few = len(parts) <= MANY
    return f"{name}({text if few else f'{len(parts)}: {eight_digits(text.encode())}'})"


def _parts(thing: Any, around: tuple[Any, ...]) -> tuple[str, list[str]]:
    """What makes it, and of what."""
    kind = type(thing)
    if kind in (list, tuple, set, frozenset):
        texts = _all(thing, around)
        return kind.__name__, texts if kind in (list, tuple) else sorted(texts)
    if kind is dict:
        return "dict", _by_name(thing, around)
    if kind is partial:
        given, by_name = thing.args, thing.keywords
        return _told(thing.func, around), _all(given, around) + _by_name(by_name, around)
    if kind is np.ndarray and not thing.dtype.hasobject:
        return "array", [str(thing.dtype), str(thing.shape), eight_digits(thing.tobytes())]
    reduced = copyreg.dispatch_table.get(kind, lambda it: it.__reduce_ex__(2))(thing)
    if isinstance(reduced, str):  # what is not written in Python
        return _placed(kind), [f"{getattr(thing, '__module__', '')}.{reduced}"]
    make, given, *rest = reduced
    if make is copyreg.__newobj__:  # type: ignore[attr-defined]
        make, *given = given
    more = [list(each) if hasattr(each, "__next__") else each for each in rest if each is not None]
    return _told(make, around), _all([*given, *more], around)


def _all(parts: Iterable[Any], around: tuple[Any, ...]) -> list[str]:
    return [_told(each, around) for each in parts]


def _by_name(parts: dict[Any, Any], around: tuple[Any, ...]) -> list[str]:
    return sorted(f"{name}={_told(value, around)}" for name, value in parts.items())


def _placed(thing: Any) -> str:
    module = str(thing.__module__)
    path = getattr(sys.modules.get(module), "__file__", None) or module
    return f"{Path(path).stem}.{thing.__qualname__}"
