# SPDX-License-Identifier: LGPL-3.0-or-later
"""The tangent of a surface problem in all of its unknowns, factored."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack


class Factored(NamedTuple):
    """The tangent, scaled, and factors of it made regular.

    Attributes:
        stiffness: derivative of the forces on the active velocities, (v, unknowns).
        matrix: the tangent; None if the factors are its own.
        factors, pivots: of the regular one.
        rows, columns: scales.
        active: the velocities among all.
    """

    stiffness: np.ndarray
    matrix: np.ndarray | None
    factors: np.ndarray
    pivots: np.ndarray
    rows: np.ndarray
    columns: np.ndarray
    active: np.ndarray

    def of(self, active: np.ndarray, size: int) -> bool:
        """Whether these, and as many unknowns, are those of the tangent."""
        return size == len(self.rows) and np.array_equal(active, self.active)

    def solve(self, residual: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """The step, once corrected for what makes the factors regular, from a residual that is
        scaled by ``rows``."""
        if rows is not self.rows:
            residual = residual * (self.rows / rows)
        step, _ = lapack.dgetrs(self.factors, self.pivots, residual)
        if self.matrix is not None:
            left = residual - self.matrix @ step
            step += lapack.dgetrs(self.factors, self.pivots, left)[0]
        return step * self.columns
