# SPDX-License-Identifier: LGPL-3.0-or-later
"""Equal expressions of UFL, told in a time that grows with their parts.

UFL compares two expressions path by path: parts that are met by several paths are compared as
often, ``2^n`` times at the bottom of n nested squares. A compiler asks that wherever two parts may
be one, and laws that go from step to step, differentiated, took it minutes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import RLock
from typing import Any

from ufl.core.expr import Expr


def _equal(this: Any, other: Any) -> bool:
    """Whether two expressions are written alike; if so they share their parts from now on."""
    if this is other:
        return True
    if type(this) is not type(other) or hash(this) != hash(other):
        return False
    pairs, met = [(this, other)], set[tuple[int, int]]()
    for one, two in pairs:  # which become more on the way
        if one._ufl_is_terminal_:
            if one != two:
                return False
            continue
        if len(one.ufl_operands) != len(two.ufl_operands):
            return False
        for part, its in zip(one.ufl_operands, two.ufl_operands):
            if part is its or (key := (id(part), id(its))) in met:
                continue
            if type(part) is not type(its) or hash(part) != hash(its):
                return False
            met.add(key)
            pairs.append((part, its))
    for one, two in pairs:
        if not one._ufl_is_terminal_:
            one.ufl_operands = two.ufl_operands
    return True


_alone = RLock()


@contextmanager
def part_by_part() -> Iterator[None]:
    """Within it UFL compares expressions so; one thread at a time is there."""
    with _alone:
        usual = Expr.__eq__
        Expr.__eq__ = _equal
        try:
            yield
        finally:
            Expr.__eq__ = usual
