# SPDX-License-Identifier: LGPL-3.0-or-later
"""The tangent of a surface problem in all of its unknowns, factored."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.linalg import lapack
from scipy.sparse.linalg import splu

from ..contact.mortar.matrices import Matrix
from .by_points import Place


class Factored(NamedTuple):
    """The tangent, scaled, and factors of it made regular.

    Attributes:
        stiffness: derivative of the forces on the active velocities, (v, unknowns).
        matrix: the tangent; None if the factors are its own.
        inverse: of the regular one, applied to a vector.
        rows, columns: scales.
        active: the velocities among all.
    """

    stiffness: Matrix
    matrix: Matrix | None
    inverse: Callable[[np.ndarray], np.ndarray]
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


def by_factors(factors: np.ndarray, pivots: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """The inverse of what LAPACK has factored, dense."""
    return lambda values: lapack.dgetrs(factors, pivots, values)[0]


def factored_sparsely(
    placed: Sequence[Place],
    W: sp.csr_matrix,
    scales: tuple[np.ndarray, np.ndarray],
    active: np.ndarray,
    compliance: float,
    softened: bool,
) -> Factored | None:
    """The tangent of a surface problem, its multipliers made so compliant; None where singular.

    Args:
        placed: the contacts' tangents, and where they stand.
        W: compliance of the active velocities, which stand first.
        scales: of rows and columns.
        active: the velocities among all.
        compliance: of the multipliers, scaled.
        softened: whether that is of springs, and a part of the tangent.
    """
    rows, columns = scales
    size, nw = len(rows), len(active)
    entries = []
    for part, place in placed:
        each = part.sparse_tangent().tocoo()
        entries.append((each.data, place[each.row], place[each.col]))
    data, row, column = (np.concatenate(each) for each in zip(*entries))
    tangent = sp.csr_matrix((data, (row, column)), (size, size))
    stiffness = tangent[:nw]
    motion = _diagonal(np.ones(nw), size) + W @ stiffness
    A = sp.vstack([motion, tangent[nw:]], format="csr")
    A.data *= rows.repeat(np.diff(A.indptr)) * columns[A.indices]
    weight = np.maximum(1.0, abs(A[nw:, :nw]).max(axis=1).toarray().ravel()) if size > nw else 0.0
    softer = np.zeros(size)
    softer[nw:] = compliance * (1.0 if softened else weight**2)
    try:
        inverse = splu((A - _diagonal(softer, size)).tocsc()).solve
    except RuntimeError:  # exactly singular
        return None
    return Factored(stiffness, None if softened else A, inverse, rows, columns, active)


def _diagonal(values: np.ndarray, columns: int) -> sp.csr_matrix:
    n = np.arange(len(values) + 1)
    return sp.csr_matrix((values, n[:-1], n), (len(values), columns))
