# SPDX-License-Identifier: LGPL-3.0-or-later
"""UFL while forms are made of it: nothing in it has a value yet."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ufl.core.expr import Expr


@contextmanager
def valueless() -> Iterator[None]:
    """Within it UFL refuses to be a number, which it is asked for by functions of math. By itself
    it tries each part of what it is made of, and of these again, without an end in sight."""
    before = Expr.__float__
    Expr.__float__ = _refuse
    try:
        yield
    finally:
        Expr.__float__ = before


def _refuse(expression: Any) -> float:
    raise TypeError("UFL has no value here: take ufl.exp, ufl.sqrt ..., not those of math")
