# SPDX-License-Identifier: LGPL-3.0-or-later
"""What parameters and quantities say, which may be a user's own."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import checks
from ..base.quoted import quoted
from ..base.told import name_of


def said(of: Any, name: str, size: int, *arguments: Any) -> np.ndarray:
    """What a method of it gives: so many numbers, or one for all of them.

    Raises:
        InputError: what it gives is none of that, or not finite.
    """
    return numbers(f"{name_of(of)}.{name}", getattr(of, name)(*arguments), size)


def numbers(what: str, given: Any, size: int) -> np.ndarray:
    """The same of what it gave."""
    try:
        result = checks.floats(given)
    except (TypeError, ValueError):
        result = np.full(1, np.nan)
    if result.shape not in ((), (size,)) or not np.isfinite(result).all():
        raise checks.InputError(
            f"{what}: gives {quoted(given)}; must be {size} finite numbers, or one for all of them"
        )
    return result
