# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a law may know of its points before a step is solved."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class StepData:
    """What a law may know of the points when it limits their velocities.

    Attributes:
        gap: what the form reads as d_n, (n,) in m.
        start_jump_n: w_n at the start of the step, (n,) in m/s.
        gap_rate: derivative of the end position by the end velocity, s.
        limit_rate: (1 - theta)/theta of the scheme, 0 in a percussion.
        horizon: time over which it looks ahead, s: the step, or that of which it is a part.
        loaded: 1 where time passes, 0 in a percussion.
    """

    gap: np.ndarray
    start_jump_n: np.ndarray
    gap_rate: float
    limit_rate: float
    horizon: float
    loaded: float = 1.0
