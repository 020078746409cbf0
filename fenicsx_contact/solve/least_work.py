# SPDX-License-Identifier: LGPL-3.0-or-later
"""Springs behind gaps: the motion of least work, by Newton's method, each step as long as work
falls."""

from __future__ import annotations

from bisect import bisect_left

import numpy as np

from ..base.constants import SAME

#: Cost: steps after which the motion is not found; ten are common.
STEPS = 100
#: Cost: what is left of the forces is damped by this share; of less the steps are longer and more.
DAMPED = 1e-3


def least_work(
    rows: np.ndarray, springs: np.ndarray, room: np.ndarray, load: np.ndarray
) -> np.ndarray | None:
    """The motion w with the least 1/2 springs.(rows w - room)_+^2 + load.w, a convex function, of
    second derivatives that jump and may be singular.

    They are damped by the gradient (Li, Fukushima, Qi, Yamashita: Regularized Newton methods for
    convex minimization problems with singular solutions, Comput. Optim. Appl. 28, 2004), and the
    length of a step is exact, as the gradient is linear between the places where springs begin to
    act or cease.

    Args:
        rows: what the motions do at each spring, (n, m).
        springs: their stiffnesses >= 0, (n,), the largest about 1.
        room: what is free before each, (n,); < 0: it acts at rest.
        load: the gradient at rest without them, (m,); it or the forces at rest are about 1.

    Returns:
        w, (m,); None: there is no least, or it is not found.
    """
    motion = np.zeros(rows.shape[1])
    for _ in range(STEPS):
        over = rows @ motion - room
        acts = over > 0
        borne = rows[acts].T * springs[acts]
        left = load + borne @ over[acts]
        if (size := np.abs(left).max()) <= SAME:
            return motion
        step = np.linalg.solve(borne @ rows[acts] + DAMPED * size * np.eye(len(left)), -left)
        motion = motion + _length(rows @ step, -over, springs, float(load @ step)) * step
    return None


def _length(rate: np.ndarray, room: np.ndarray, springs: np.ndarray, load: float) -> float:
    """How far work falls along a step of these rates; 0 if it falls for ever."""

    def slope(length: float) -> float:
        return load + float((springs * rate) @ np.maximum(rate * length - room, 0.0))

    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        turns = room / rate
    turns = np.sort(turns[(turns > 0) & np.isfinite(turns)])
    k = bisect_left(turns, 0.0, key=slope)
    low = turns[k - 1] if k else 0.0
    high = turns[k] if k < len(turns) else low + 1.0
    rise = slope(high) - slope(low)
    return low - slope(low) * (high - low) / rise if rise > 0 else 0.0
