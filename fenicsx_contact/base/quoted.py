# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a user gave, as messages quote it: without addresses in memory, which say nothing."""

from __future__ import annotations

import inspect
import re
import reprlib
from pathlib import PurePath
from types import CodeType
from typing import Any

import ufl
from dolfinx import fem

#: Cost: parts of UFL up to which it is written out, to be shortened.
LONG = 1000

_short = reprlib.Repr()
_short.maxother = 72  # of what is longer the beginning and the end are shown


class _Formula(str):
    """A text that stands without quotes."""

    __repr__ = str.__str__


def quoted(given: Any) -> str:
    """UFL as a formula, shortened, Constants by their values, functions by name, file and line,
    anything else as its ``repr`` tells it."""
    if isinstance(given, ufl.core.expr.Expr):
        if isinstance(given, fem.Constant):
            return f"Constant {given.value.tolist()}"
        if (parts := written_out(given)) > LONG:
            return f"UFL of {parts} parts"
        return _short.repr(_Formula(given))
    code = code_of(given)
    if code is None:
        return without_addresses(repr(given))
    name = "lambda" if code.co_name == "<lambda>" else code.co_name
    return f"{name} at {PurePath(code.co_filename).name}:{code.co_firstlineno}"


def written_out(expression: Any) -> int:
    """Of how many parts an expression is where it is written out, those that are met by several
    paths by each."""
    counts: dict[int, int] = {}
    stack = [expression]
    while stack:
        operands = stack[-1].ufl_operands
        if ahead := [operand for operand in operands if id(operand) not in counts]:
            stack += ahead
            continue
        counts[id(stack.pop())] = 1 + sum(counts[id(operand)] for operand in operands)
    return counts[id(expression)]


def code_of(given: Any) -> CodeType | None:
    """Of a function in Python, wrapped or with some of its arguments; None of anything else."""
    inner = getattr(given, "func", given)
    code = getattr(inspect.unwrap(inner) if callable(inner) else None, "__code__", None)
    return code if isinstance(code, CodeType) else None


def without_addresses(text: str) -> str:
    """A text of ``repr``, which says where in memory things are that have none of their own."""
    return re.sub(r" at 0x[0-9a-fA-F]+", "", text)
