# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a user gave, in a few words: for descriptions, by which a run knows its own scene again."""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Real
from typing import Any

import numpy as np

#: Of more numbers than so only the size is told.
MANY = 12


def told(given: Any) -> str:
    """Numbers as they are, functions by their names, fields by their kind: nothing that differs
    from run to run or from process to process, as addresses in memory do."""
    if given is None or isinstance(given, (str, bool)):
        return repr(given)
    if isinstance(given, Real):
        return f"{float(given):.9g}"
    if isinstance(given, Mapping):
        return "{" + ", ".join(f"{told(k)}: {told(v)}" for k, v in given.items()) + "}"
    if isinstance(given, (list, tuple)):
        return "[" + ", ".join(map(told, given)) + "]"
    name = getattr(given, "__name__", type(given).__name__)
    values = given if isinstance(given, np.ndarray) else getattr(given, "value", None)
    if values is not None:  # an array, or a Constant
        values = np.asarray(values)
        few = values.dtype.kind in "biuf" and values.size <= MANY
        name += f" {values.tolist() if few else values.shape}"
    return name


def given(arguments: Mapping[str, Any]) -> str:
    """Those of some arguments that say anything, by their names."""
    every = {name: told(each) for name, each in arguments.items()}
    return "".join(f", {n} {text}" for n, text in every.items() if text not in ("None", "[]", "{}"))
