# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a user gave, in a few words: for descriptions, by which a run knows its own scene again."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from hashlib import sha256
from numbers import Real
from types import CodeType, FunctionType
from typing import Any

import numpy as np

#: Of more numbers than so only the size is told.
MANY = 12


def told(given: Any) -> str:
    """Numbers as they are, functions by their names and code, fields by their kind: nothing that
    differs from run to run or from process to process, as addresses in memory do."""
    if given is None or isinstance(given, (str, bool)):
        return repr(given)
    if isinstance(given, Real):
        return f"{float(given):.9g}"
    if isinstance(given, Mapping):
        return "{" + ", ".join(f"{told(k)}: {told(v)}" for k, v in given.items()) + "}"
    if isinstance(given, (list, tuple)):
        return "[" + ", ".join(map(told, given)) + "]"
    if isinstance(given, FunctionType):
        return function(given)
    name = getattr(given, "__name__", type(given).__name__)
    values = given if isinstance(given, np.ndarray) else getattr(given, "value", None)
    if values is not None:  # an array, or a Constant
        values = np.asarray(values)
        few = values.dtype.kind in "biuf" and values.size <= MANY
        name += f" {values.tolist() if few else values.shape}"
    return name


def function(f: FunctionType) -> str:
    """Its name, and eight digits of what it does, which another one hardly shares: of its code, its
    defaults and what it has from around it."""
    does = _code(f.__code__) + told(f.__defaults__ or ()) + told(f.__kwdefaults__ or {})
    with suppress(ValueError, RecursionError):  # it stands in what is around it
        does += told([cell.cell_contents for cell in f.__closure__ or ()])
    return f"{f.__name__} {sha256(does.encode()).hexdigest()[:8]}"


def _code(code: CodeType) -> str:
    every = [_code(c) if isinstance(c, CodeType) else repr(c) for c in code.co_consts]
    lists = [sorted(c) if c[:9] == "frozenset" else c for c in every]
    return f"{code.co_code.hex()} {code.co_names} {lists}"


def given(arguments: Mapping[str, Any]) -> str:
    """Those of some arguments that say anything, by their names."""
    every = {name: told(each) for name, each in arguments.items()}
    return "".join(f", {n} {text}" for n, text in every.items() if text not in ("None", "[]", "{}"))
