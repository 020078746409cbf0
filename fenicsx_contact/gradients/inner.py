# SPDX-License-Identifier: LGPL-3.0-or-later
"""The solver of a deformable solid among its own unknowns in a linearised step."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from petsc4py import PETSc

from ..contact.mortar.matrices import dense
from ..solids.factor import Factorisation
from .seen import Picked, Pushed


class Inner:
    """The rows of a deformable solid among its own unknowns (q, v) in one step::

        q - rate v = r_q           stiffness q + inertia v = r_v

    Args:
        factor: of ``inertia + rate stiffness`` over what is not held, the identity elsewhere.
        stiffness: over what is not held.
        rate: derivative of q by v, s.
        held: unknowns.
        matrix: that matrix, where the factor may be of one which is near it.
        loose: rigid motions of a solid that nothing but contact, or weak springs, holds, (n, k),
            whose matrix is not to be factored.

    Attributes:
        factor, loose: as given.
    """

    def __init__(
        self,
        factor: Factor,
        stiffness: sp.csr_matrix,
        rate: float,
        held: np.ndarray,
        matrix: sp.csr_matrix | None = None,
        loose: np.ndarray | None = None,
    ) -> None:
        self.factor, self._stiffness, self._rate, self._held = factor, stiffness, rate, held
        self._matrix = factor.matrix if matrix is None else matrix
        self.loose = loose

    @property
    def exact(self) -> bool:
        """Whether the factor is that of the matrix."""
        return self._matrix is self.factor.matrix

    def left(self, values: np.ndarray, transposed: bool) -> np.ndarray:
        """What is left of its rows after :meth:`solve` gave these (q, v), (2 n, columns), or of its
        columns after it gave these multipliers."""
        n = len(values) // 2
        result = np.zeros_like(values)
        result[n:] = (self._rest.T if transposed else self._rest) @ values[n:]
        return result

    @cached_property
    def _rest(self) -> sp.csr_matrix:
        """What the factored matrix has more than the matrix."""
        return self.factor.matrix - self._matrix

    def renew(self) -> None:
        """Factor the matrix itself."""
        self.factor = self.factor.other(self._matrix)

    def solve(self, right: np.ndarray, transposed: bool) -> np.ndarray:
        """(q, v) from (r_q, r_v), (2 n, columns), or multipliers of the rows from columns."""
        n = len(right) // 2
        first, last = right[:n], right[n:]
        K, rate = self._stiffness, self._rate
        load = last + rate * first if transposed else last - K @ first
        load[self._held] = 0.0  # nothing moves what is held
        v = (self.factor.transposed if transposed else self.factor).solve(load)
        return np.concatenate([first - K.T @ v if transposed else first + rate * v, v])

    def columns(self, block: Any, first: int) -> np.ndarray:
        """Its unknowns from a block of its rows, of which it begins with this one."""
        if isinstance(block, Pushed) and first:
            return self.factor.pushed(block.points, self._rate)
        right = np.zeros((2 * len(self._stiffness.indptr) - 2, block.shape[1]))
        right[first : first + block.shape[0]] = dense(block)
        return self.solve(right, False)


class Factor:
    """A direct factorisation of a matrix, made when it is first asked; knows what it has solved for
    points, which come again.

    Args:
        matrix: the matrix.
        name: of the solid.
        symmetric: whether it is.
        held: unknowns that nothing moves.

    Attributes:
        matrix: the matrix.
    """

    def __init__(self, matrix: sp.csr_matrix, name: str, symmetric: bool, held: np.ndarray) -> None:
        self.matrix, self._name, self._symmetric = matrix, name, symmetric
        self._held = held
        self._columns: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        self._last: tuple[Picked, np.ndarray] | None = None

    @cached_property
    def _factor(self) -> Factorisation:
        parts = self.matrix.indptr, self.matrix.indices, self.matrix.data
        made = PETSc.Mat().createAIJ(self.matrix.shape, csr=parts, comm=PETSc.COMM_SELF)
        return Factorisation(made, f"{self._name}_gradients")

    def other(self, matrix: sp.csr_matrix) -> Factor:
        """That of another matrix of the solid."""
        return Factor(matrix, self._name, self._symmetric, self._held)

    @cached_property
    def transposed(self) -> Factor:
        """That of the transpose."""
        if self._symmetric:
            return self
        return self.other(self.matrix.T.tocsr())

    def solve(self, right: np.ndarray) -> np.ndarray:
        """For columns (n, k)."""
        result = np.zeros_like(right)
        asked = right.any(axis=0).nonzero()[0]
        if len(asked):
            result[:, asked] = self._factor.solve_many(right[:, asked])
        return result

    def pushed(self, points: Picked, rate: float) -> np.ndarray:
        """What forces at the points of a contact make of (q, v) on the other side, (2 n, k c)."""
        if self._last is None or self._last[0] is not points:
            n, key = len(self.matrix.indptr) - 1, id(points.whole)
            if key not in self._columns:
                size = points.whole.shape[0]
                self._columns[key] = np.empty((n, size)), np.zeros(size, dtype=bool)
            columns, known = self._columns[key]
            missing = points.rows[~known[points.rows]]
            if len(missing):
                right = -points.whole[missing].T.toarray()
                right[self._held] = 0.0
                columns[:, missing], known[missing] = self.solve(right), True
            v = columns[:, points.rows]
            self._last = points, np.concatenate([rate * v, v])
        return self._last[1]
