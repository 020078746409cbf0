# SPDX-License-Identifier: LGPL-3.0-or-later
"""Small symmetric matrices, many at once, (m, k, k): by formulas where they have two rows."""

from __future__ import annotations

import numpy as np


def extremes(matrices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Their lowest and highest eigenvalues, (m,)."""
    if matrices.shape[1] == 2:
        a, b, c = matrices[:, 0, 0], matrices[:, 0, 1], matrices[:, 1, 1]
        middle, apart = 0.5 * (a + c), np.hypot(0.5 * (a - c), b)
        return middle - apart, middle + apart
    eigenvalues = np.linalg.eigvalsh(matrices)
    return eigenvalues[:, 0], eigenvalues[:, -1]


def inverted(matrices: np.ndarray) -> np.ndarray:
    """Their inverses; they are regular."""
    if matrices.shape[1] == 2:
        a, b, c = matrices[:, 0, 0], matrices[:, 0, 1], matrices[:, 1, 1]
        result = np.empty_like(matrices)
        result[:, 0, 0], result[:, 1, 1] = c, a
        result[:, 0, 1] = result[:, 1, 0] = -b
        return result / (a * c - b * b)[:, None, None]
    return np.asarray(np.linalg.inv(matrices))
