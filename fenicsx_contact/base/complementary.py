# SPDX-License-Identifier: LGPL-3.0-or-later
"""Linear complementarity, solved in finitely many steps."""

from __future__ import annotations

import numpy as np
from scipy.linalg.blas import dger

from .constants import ROUND_OFF, SAME

#: Cost: pivots, as a multiple of all numbers, before nothing is found.
TURNS = 10
#: Cost: what is less than this share of the largest number of a column is round-off: no pivot.
TINY = 1e-11


def complementary(matrix: np.ndarray, constant: np.ndarray) -> np.ndarray | None:
    """z >= 0 with ``matrix z + constant >= 0`` of which one is 0 wherever the other is not.

    By C.E. Lemke's pivots (Manage. Sci. 11, 681-689, 1965; R.W. Cottle, J.-S. Pang & R.E. Stone,
    The linear complementarity problem, 1992, chapter 4): something is added to all rows until none
    is negative, and taken away again along the way on which the rest is complementary. What is
    added differs from row to row, so that no two of them ever tie.

    Args:
        matrix: (n, n), copositive: with it there is a way to the end wherever there is an end.
        constant: (n,).

    Returns:
        z, (n,); None: it is not found.
    """
    n, added = len(constant), 2 * len(constant)
    if not (constant < 0).any():
        return np.zeros(n)
    # multiples of the golden section are as unlike each other as can be
    cover = 1.0 + (np.sqrt(5) - 1) / 2 * np.arange(1, n + 1) % 1.0
    # each row: a number that is not 0, by those that are (the columns): w is i, z is n + i
    table = np.asfortranarray(np.column_stack([matrix, cover, constant]))
    noise = 10 * ROUND_OFF * np.abs(constant).max()
    rows, columns = np.arange(n), np.append(np.arange(n, 2 * n), added)
    place, enters = int(np.argmin(constant / cover)), n
    for _ in range(TURNS * n):
        column, pivot = table[:, enters].copy(), table[place, enters]
        row = table[place] / -pivot
        row[enters] = 1.0 / pivot
        table[:, enters] = 0.0
        table = dger(1.0, column, row, a=table, overwrite_a=True)
        table[place] = row
        left, rows[place] = rows[place], columns[enters]
        columns[enters] = left
        if left == added:
            return _found(rows, table)
        enters = int(np.flatnonzero(columns == (left + n if left < n else left - n))[0])
        falls = -table[:, enters]
        may = np.flatnonzero(falls > TINY * max(1.0, np.abs(falls).max()))
        if not len(may):
            # of what was added round-off may be left
            (still,) = (rows == added).nonzero()
            ends = table[still[0], -1] <= SAME * np.abs(constant).max()
            return _found(rows, table) if ends else None
        ways = table[may, -1] / falls[may]
        first = may[ways <= ways.min() + noise]
        # where all that was added is gone with others it is the end
        end = first[rows[first] == added]
        place = int(end[0] if len(end) else first[np.argmax(falls[first])])
    return None


def _found(rows: np.ndarray, table: np.ndarray) -> np.ndarray:
    """What is not 0 in the end, (n,)."""
    n = len(rows)
    z, of = np.zeros(n), (rows >= n) & (rows < 2 * n)
    z[rows[of] - n] = np.maximum(table[of, -1], 0.0)
    return z
