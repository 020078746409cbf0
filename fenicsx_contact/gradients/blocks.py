# SPDX-License-Identifier: LGPL-3.0-or-later
"""The linearised step, as sparse matrices, and its solution, forwards and transposed.

    plus dx + minus ds + by dp = 0

x: all unknowns of a step, the state at its end first; s: the state at its start; p: parameters.
Tangents solve it for dx from ds and dp, adjoints solve it transposed.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu


class Blocks:
    """A sparse matrix made of blocks that add up."""

    def __init__(self) -> None:
        self._parts: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []

    def add(self, rows: slice, columns: slice, block: Any) -> None:
        """Add a block, dense or sparse, at these rows and columns."""
        if isinstance(block, np.ndarray):
            row, column = block.nonzero()
            data = block[row, column]
        else:
            entries = block.tocoo()
            row, column, data = entries.row, entries.col, entries.data
        if len(data):
            self._parts.append((row + rows.start, column + columns.start, data))

    def matrix(self, shape: tuple[int, int]) -> sp.csc_matrix:
        """What they make."""
        if not self._parts:
            return sp.csc_matrix(shape)
        row, column, data = (np.concatenate(each) for each in zip(*self._parts))
        return sp.csc_matrix((data, (row, column)), shape)


class LinearStep(NamedTuple):
    """A linearised step.

    Attributes:
        plus, minus: derivatives by the unknowns and by the state at the start, sparse.
        by: derivatives by the parameters, (unknowns, parameters).
        soft: a small compliance of the multipliers, (unknowns,), zero elsewhere: where solids have
            fewer unknowns than points ``plus`` is singular in what does not matter.
        force: derivatives of each contact's force on its solid by the unknowns, the state at the
            start and the parameters, [(d, unknowns), (d, state), (d, parameters)].
    """

    plus: sp.csc_matrix
    minus: sp.csc_matrix
    by: np.ndarray
    soft: np.ndarray
    force: list[tuple[sp.csc_matrix, sp.csc_matrix, np.ndarray]]

    def tangent(self, solver: Solver, start: np.ndarray) -> np.ndarray:
        """dx (unknowns, parameters) from ds (state, parameters)."""
        return solver.solve(self, -(self.minus @ start + self.by))

    def adjoint(self, solver: Solver, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of functionals by the state at the start, (state, functionals), and by the
        parameters in this step, (parameters, functionals), from those by the state at the end."""
        right = np.zeros((len(self.soft), end.shape[1]))
        right[: len(end)] = end
        left = solver.solve(self, right, "T")
        return -(self.minus.T @ left), -(self.by.T @ left)


class Solver:
    """Solves linearised steps; keeps the last factor, for matrices come again.

    Attributes:
        factors, solves: how many there were.
    """

    def __init__(self) -> None:
        self.factors = self.solves = 0
        self._last: sp.csc_matrix | None = None

    def solve(self, step: LinearStep, right: np.ndarray, which: str = "N") -> np.ndarray:
        """Solve with ``plus`` ("N") or its transpose ("T").

        What is soft is made hard by iteration (proximal point), what is regular is corrected once.
        """
        self._factor(step)
        matrix = step.plus if which == "N" else step.plus.T
        result = self._lu.solve(right, which)
        self.solves += 1
        change, soft = np.inf, bool(step.soft.any())
        while True:
            last = change
            correction = self._lu.solve(right - matrix @ result, which)
            self.solves += 1
            change = float(np.abs(correction).max(initial=0.0))
            if not change < last:
                return result
            result = result + correction
            if not soft:
                return result

    def _factor(self, step: LinearStep) -> None:
        soft = step.soft.nonzero()[0]
        new = step.plus
        if len(soft):
            new = new - sp.csc_matrix((step.soft[soft], (soft, soft)), new.shape)
        last = self._last
        if last is not None and new.shape == last.shape and new.nnz == last.nnz:
            same = np.array_equal(new.indices, last.indices) and np.array_equal(new.data, last.data)
            if same and np.array_equal(new.indptr, last.indptr):
                return
        self._last, self._lu = new, splu(new)
        self.factors += 1
