# SPDX-License-Identifier: LGPL-3.0-or-later
"""Equal expressions of UFL, told in a time that grows with their parts.

UFL compares two expressions path by path: parts that are met by several paths are compared as
often, ``2^n`` times at the bottom of n nested squares. A compiler asks that wherever two parts may
be one, and laws that go from step to step, differentiated, took it minutes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ufl.core.expr import Expr


def _equal(this: Any, other: Any) -> bool:
    """Whether two expressions are written alike; if so they share their parts from now on."""
    pairs, met = [(this, other)], set[tuple[int, int]]()
    for one, two in pairs:  # which become more on the way
        if type(one) is not type(two) or hash(one) != hash(two):
            return False
        if one._ufl_is_terminal_:
            if one != two:
                return False
            continue
        if len(one.ufl_operands) != len(two.ufl_operands):
            return False
        for pair in zip(one.ufl_operands, two.ufl_operands):
            key = id(pair[0]), id(pair[1])
            if pair[0] is not pair[1] and key not in met:
                met.add(key)
                pairs.append(pair)
    for one, two in pairs:
        if not one._ufl_is_terminal_:
            one.ufl_operands = two.ufl_operands
    return True


@contextmanager
def part_by_part() -> Iterator[None]:
    """Within it UFL compares expressions so."""
    usual = Expr.__eq__
    Expr.__eq__ = lambda this, other: this is other or _equal(this, other)
    try:
        yield
    finally:
        Expr.__eq__ = usual
