# SPDX-License-Identifier: LGPL-3.0-or-later
"""Blocks of a linearised step that read the points of a solid or push them, by an operator that
stays the same from step to step."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import scipy.sparse as sp


class Picked:
    """Rows of an operator that is the same in all steps.

    Args:
        whole: the operator, sparse.
        rows: which, (k c,).
    """

    def __init__(self, whole: sp.csr_matrix, rows: np.ndarray) -> None:
        self.whole, self.rows, self.matrix = whole, rows, whole[rows]

    @cached_property
    def transposed(self) -> sp.csr_matrix:
        """The transpose of them."""
        return self.matrix.T.tocsr()

    @cached_property
    def minus(self) -> sp.csr_matrix:
        """The negative of them."""
        return -self.matrix


class Seen:
    """A block that reads points: weights times what an operator sees.

    Args:
        weights: point by point, (k, r, c).
        points: the operator, (k c, n).
    """

    def __init__(self, weights: np.ndarray, points: Picked) -> None:
        self.weights, self.points = weights, points

    def __matmul__(self, values: np.ndarray) -> np.ndarray:
        return _weighed(self.weights, self.points.matrix @ values)

    def __neg__(self) -> Seen:
        return Seen(-self.weights, self.points)

    def __abs__(self) -> Seen:
        return Seen(np.abs(self.weights), self.points)  # operators have no negative entries

    @property
    def T(self) -> Spread:
        """Its transpose."""
        return Spread(self.weights, self.points)


class Spread:
    """The transpose of :class:`Seen`."""

    def __init__(self, weights: np.ndarray, points: Picked) -> None:
        self.weights, self.points = weights, points

    def __matmul__(self, values: np.ndarray) -> np.ndarray:
        return np.asarray(self.points.transposed @ _weighed(self.weights.swapaxes(1, 2), values))


class Pushed:
    """A block of forces at points, on the other side of a solid's balance: minus the transpose of
    an operator."""

    def __init__(self, points: Picked) -> None:
        self.points = points
        self.shape = points.matrix.shape[::-1]

    @property
    def T(self) -> sp.csr_matrix:
        """Its transpose."""
        return self.points.minus

    def __matmul__(self, values: np.ndarray) -> np.ndarray:
        return np.asarray(-(self.points.transposed @ values))


def _weighed(weights: np.ndarray, values: np.ndarray) -> np.ndarray:
    k, r, c = weights.shape
    return (weights @ values.reshape(k, c, values.shape[1])).reshape(k * r, values.shape[1])
