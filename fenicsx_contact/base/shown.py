# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a user gave, as a reader would like to see it: formulas, and functions by name and place.
By which a run knows its own scene again are digits, which say nothing to a reader: told.py."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

from .expressions import is_expression
from .quoted import code_of, quoted
from .told import MARK, digits, legible, name_of, told

_EXACTLY = ContextVar("exactly", default=False)


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
    if is_expression(given) or code_of(given):
        return quoted(given)
    return name_of(given)


def worded(text: str) -> str:
    """A text that told.py has told, but within :func:`exactly` without the digits of what it tells,
    which say nothing to a reader."""
    return text if _EXACTLY.get() else legible(text)


def marked(name: str, *parts: Any) -> str:
    """A name, within :func:`exactly` with eight digits of what it stands for."""
    return f"{name} {MARK}{digits(*parts)}" if _EXACTLY.get() else name
