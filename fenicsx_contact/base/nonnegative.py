# SPDX-License-Identifier: LGPL-3.0-or-later
"""Least squares in numbers none of which is negative, and the smallest of those.

Not by ``scipy.optimize.nnls``: that of SciPy 1.15, which Debian 13 has, returns a wrong answer
without a word where columns depend on each other, as those of points on a rigid face do.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_triangular

from .constants import ROUND_OFF

#: Cost: columns that are taken in or put back, as a multiple of all, before nothing is found.
TURNS = 3


def nonnegative(rows: np.ndarray, target: np.ndarray) -> np.ndarray | None:
    """The x >= 0 of the least |rows x - target|, with as many numbers above 0 as there are
    independent columns at most: the active sets of C.L. Lawson & R.J. Hanson (Solving least squares
    problems, 1974, chapter 23).

    Args:
        rows: (m, n).
        target: (m,).

    Returns:
        x, (n,); None: it is not found.
    """
    x = np.zeros(rows.shape[1])
    taken = x > 0
    # what the columns have in common with what is left, if that is round-off
    noise = ROUND_OFF * np.linalg.norm(rows, axis=0) * np.linalg.norm(target)
    vain = np.zeros(len(x), dtype=bool)  # columns that were put back at once: round-off
    new = None
    for _ in range(TURNS * len(x) + 1):
        if taken.any():
            best = np.zeros(len(x))
            q, r = np.linalg.qr(rows[:, taken])
            best[taken] = solve_triangular(r, target @ q, check_finite=False)
            if new is not None and best[new] <= 0:
                taken[new], vain[new] = False, True
                new = None
                continue
            if (beyond := taken & (best <= 0)).any():
                # as far as none falls below zero
                shares = x[beyond] / (x[beyond] - best[beyond])
                x += shares.min() * (best - x)
                x[np.flatnonzero(beyond)[shares <= shares.min()]] = 0.0
                taken &= x > 0
                new = None
                continue
            x, vain[:] = best, False
        gain = rows.T @ (target - rows @ x)
        gain[taken | vain] = 0.0
        if not (gain > noise).any() or taken.sum() == len(rows):  # then nothing is left
            return x
        new = int(np.argmax(gain))
        taken[new] = True
    return None


def smallest(rows: np.ndarray, sums: np.ndarray, start: np.ndarray) -> np.ndarray:
    """The smallest g >= 0 of those with these sums ``rows g``, of which there are some: g = max(0,
    rows' y), where y is the minimum of g . g / 2 - sums . y, sought by Newton's method down to
    round-off.

    Args:
        rows: (m, n).
        sums: (m,).
        start: y to begin with, (m,).
    """

    def at(y: np.ndarray) -> tuple[np.ndarray, float]:
        g = np.maximum(y @ rows, 0.0)
        return g, float(g @ g / 2 - sums @ y)

    y, (g, value) = start, at(start)
    while True:
        bears = rows[:, g > 0]
        way = np.linalg.lstsq(bears @ bears.T, sums - rows @ g, rcond=ROUND_OFF**0.5)[0]
        falls, share = float(way @ (sums - rows @ g)), 1.0
        while at(y + share * way)[1] > value - share * falls / 4 and share > ROUND_OFF:
            share /= 2
        new, lower = at(y + share * way)
        if not lower < value:
            return g
        y, g, value = y + share * way, new, lower
