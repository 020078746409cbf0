# SPDX-License-Identifier: LGPL-3.0-or-later
"""What numpy tells of overflow: nothing of iterates that diverge, all of functions of users."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

import numpy as np

_OUTSIDE: ContextVar[dict[str, Any] | None] = ContextVar("outside", default=None)


@contextmanager
def diverging() -> Iterator[None]:
    """Iterates that diverge overflow: their error then is inf, which every loop asks."""
    if _OUTSIDE.get():
        yield
        return
    token = _OUTSIDE.set(dict(np.geterr()))
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            yield
    finally:
        _OUTSIDE.reset(token)


def told() -> np.errstate:
    """Within :func:`diverging`: numpy tells what it tells outside."""
    return np.errstate(**(_OUTSIDE.get() or {}))
