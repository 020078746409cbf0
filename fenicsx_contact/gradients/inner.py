# SPDX-License-Identifier: LGPL-3.0-or-later
"""The solver of a deformable solid among its own unknowns in a linearised step."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from petsc4py import PETSc

from ..solids.factor import Factorisation
from .blocks import dense
from .seen import Picked, Pushed


class Inner:
    """The rows of a deformable solid among its own unknowns (q, v) in one step::

        q - rate v = r_q           stiffness q + inertia v = r_v

    Args:
        factor: of ``inertia + rate stiffness`` over what is not held, the identity elsewhere.
        stiffness: over what is not held.
        rate: derivative of q by v, s.
        held: unknowns.
    """

    def __init__(self, factor: Factor, stiffness: Any, rate: float, held: np.ndarray) -> None:
        self._factor, self._stiffness, self._rate, self._held = factor, stiffness, rate, held

    def solve(self, right: np.ndarray, transposed: bool) -> np.ndarray:
        """(q, v) from (r_q, r_v), (2 n, columns), or multipliers of the rows from columns."""
        n = len(right) // 2
        first, last = right[:n], right[n:]
        K, rate = self._stiffness, self._rate
        load = last + rate * first if transposed else last - K @ first
        load[self._held] = 0.0  # nothing moves what is held
        v = (self._factor.transposed if transposed else self._factor).solve(load)
        return np.concatenate([first - K.T @ v if transposed else first + rate * v, v])

    def columns(self, block: Any, first: int) -> np.ndarray:
        """Its unknowns from a block of its rows, of which it begins with this one."""
        if isinstance(block, Pushed) and first:
            return self._factor.pushed(block.points, self._rate)
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
    """

    def __init__(self, matrix: sp.csr_matrix, name: str, symmetric: bool, held: np.ndarray) -> None:
        self._matrix, self._name, self._symmetric = matrix, name, symmetric
        self._held = held
        self._columns: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        self._last: tuple[Picked, np.ndarray] | None = None

    @cached_property
    def _factor(self) -> Factorisation:
        parts = self._matrix.indptr, self._matrix.indices, self._matrix.data
        made = PETSc.Mat().createAIJ(self._matrix.shape, csr=parts, comm=PETSc.COMM_SELF)
        return Factorisation(made, f"{self._name}_gradients")

    @cached_property
    def transposed(self) -> Factor:
        """That of the transpose."""
        if self._symmetric:
            return self
        return Factor(self._matrix.T.tocsr(), self._name, False, self._held)

    def solve(self, right: np.ndarray) -> np.ndarray:
        """For columns (n, k)."""
        result = np.zeros_like(right)
        asked = right.any(axis=0).nonzero()[0]
        if len(asked):
            result[:, asked] = self._factor.solve_many(sp.csc_matrix(right[:, asked]))
        return result

    def pushed(self, points: Picked, rate: float) -> np.ndarray:
        """What forces at the points of a contact make of (q, v) on the other side, (2 n, k c)."""
        if self._last is None or self._last[0] is not points:
            n, key = len(self._matrix.indptr) - 1, id(points.whole)
            if key not in self._columns:
                size = points.whole.shape[0]
                self._columns[key] = np.empty((size, n)), np.zeros(size, dtype=bool)
            columns, known = self._columns[key]
            missing = points.rows[~known[points.rows]]
            if len(missing):
                right = -points.whole[missing].T.toarray()
                right[self._held] = 0.0
                columns[missing], known[missing] = self.solve(right).T, True
            v = columns[points.rows].T
            self._last = points, np.concatenate([rate * v, v])
        return self._last[1]
