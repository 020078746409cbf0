# SPDX-License-Identifier: LGPL-3.0-or-later
"""The tangent of a surface problem in all of its unknowns, factored."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from ..contact.mortar.matrices import Matrix

#: From right sides (n,) or (n, k) to solutions.
Inverse = Callable[[np.ndarray], np.ndarray]


class Factored(NamedTuple):
    """The tangent, scaled, and factors of it made regular.

    Attributes:
        stiffness: derivative of the forces on the active velocities, (v, unknowns), or what knows
            its products.
        matrix: the tangent; None if the factors are its own.
        inverse: of the regular one, applied to a vector.
        rows, columns: scales.
        active: the velocities among all.
    """

    stiffness: Matrix
    matrix: Matrix | None
    inverse: Inverse
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
        step = self.inverse(residual)
        if self.matrix is not None:
            step += self.inverse(residual - self.matrix @ step)
        return step * self.columns


def by_factors(matrix: np.ndarray) -> Inverse | None:
    """The inverse of a dense matrix (n, n) by factors of its precision, which take its place; None
    if it is singular."""
    getrf, getrs = lapack.get_lapack_funcs(("getrf", "getrs"), dtype=matrix.dtype)
    factors, pivots, singular = getrf(matrix.T, overwrite_a=True)  # in the order of LAPACK
    if singular:
        return None
    return lambda b: np.asarray(getrs(factors, pivots, b, trans=1)[0], dtype=float)
