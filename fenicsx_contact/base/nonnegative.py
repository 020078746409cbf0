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
#: Cost: how far proximal points go, as a share of the squares of the columns.
PROXIMAL = 1e-4


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
    """The smallest g >= 0 of those with these sums ``rows g``: g = max(0, rows' y), where y is the
    minimum of g . g / 2 - sums . y, approached by proximal points as long as each halves what the
    sums lack (R.T. Rockafellar, SIAM J. Control Optim. 14, 877-898, 1976). Where there are none
    with these sums, some that come near them.

    Args:
        rows: (m, n).
        sums: (m,).
        start: y to begin with, (m,).
    """
    near = PROXIMAL * float(np.square(rows).sum(axis=0).max(initial=0.0))
    y, last = start, float("inf")
    while True:
        y = _proximal(rows, sums, y, near)
        g = np.maximum(y @ rows, 0.0)
        lacks = float(np.linalg.norm(sums - rows @ g))
        if not 2 * lacks < last:
            return g
        last = lacks


def _proximal(rows: np.ndarray, sums: np.ndarray, centre: np.ndarray, near: float) -> np.ndarray:
    """The minimum y of g . g / 2 - sums . y + near |y - centre|^2 / 2, by Newton's method down to
    round-off."""

    def at(way: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
        y = centre + way
        g = np.maximum(y @ rows, 0.0)
        return g, float(g @ g / 2 - sums @ y + near * (way @ way) / 2), sums - rows @ g - near * way

    gone = np.zeros(len(centre))
    g, value, slope = at(gone)
    while slope.any():
        bears, noise, share = rows[:, g > 0], ROUND_OFF * abs(value), 1.0
        way = np.linalg.solve(bears @ bears.T + near * np.eye(len(gone)), slope)
        while at(gone + share * way)[1] > value - share * (way @ slope) / 4 + noise:
            share /= 2
            if share < ROUND_OFF:
                return centre + gone
        g, lower, left = at(gone + share * way)
        # the minimum is flat: of its value the last half of all digits know nothing
        if not (lower < value - noise or 2 * np.linalg.norm(left) < np.linalg.norm(slope)):
            break
        gone, value, slope = gone + share * way, lower, left
    return centre + gone
