# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sizes of arrays."""

from __future__ import annotations

import numpy as np


def largest(values: np.ndarray) -> float:
    """The largest absolute value; 0 of none, NaN where there is one."""
    return float(np.maximum.reduce(np.abs(values), axis=None, initial=0.0))
