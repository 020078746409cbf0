# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a user gave, as a reader would like to see it: formulas, and functions by name and place.
By which a run knows its own scene again are digits, which say nothing to a reader: told.py."""

from __future__ import annotations

import inspect
import reprlib
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import PurePath
from types import CodeType
from typing import Any

from .expressions import is_expression
from .told import digits, told

_EXACTLY = ContextVar("exactly", default=False)
_short = reprlib.Repr()
_short.maxother = 72  # of what is longer the beginning and the end are shown


class _Formula(str):
    """A text that stands without quotes."""

    __repr__ = str.__str__


@contextmanager
def exactly() -> Iterator[None]:
    """Within it :func:`shown` tells what is given by digits, so that nothing else is told alike."""
    token = _EXACTLY.set(True)
    try:
        yield
    finally:
        _EXACTLY.reset(token)


def shown(given: Any) -> str:
    """UFL as a formula, shortened, functions by name, file and line, objects that are called by
    their class; anything else, and all within :func:`exactly`, as told.py does."""
    if _EXACTLY.get() or not (callable(given) or is_expression(given)):
        return told(given)
    if is_expression(given):
        return _short.repr(_Formula(given))
    code = getattr(inspect.unwrap(getattr(given, "func", given)), "__code__", None)
    if not isinstance(code, CodeType):
        return str(getattr(given, "__name__", type(given).__name__))
    name = "lambda" if code.co_name == "<lambda>" else code.co_name
    return f"{name} at {PurePath(code.co_filename).name}:{code.co_firstlineno}"


def marked(name: str, *parts: Any) -> str:
    """A name, within :func:`exactly` with eight digits of what it stands for."""
    return f"{name} {digits(*parts)}" if _EXACTLY.get() else name
