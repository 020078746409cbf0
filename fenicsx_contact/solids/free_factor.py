# SPDX-License-Identifier: LGPL-3.0-or-later
"""Linear solves with the matrix of a solid that is free to move, but for springs.

In a long step inertia is little beside stiffness: A = B + K, with B = c M, has a condition of about
(omega dt)², which is 1e10 of a steel block in a hundredth of a second; so it has where springs to
ground, which B then counts too, are as much weaker than the solid. Its rigid motions R strain
nothing, K R = 0, so that A R = B R is known, and what round-off makes of it need not be asked:

    A^-1 b = R g + P A^-1 (b - B R g),   g = (R' B R)^-1 R' b,   P = 1 - R (R' B R)^-1 R' B.

Else what friction holds creeps, by a share of the speed that its loads alone would give it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp
from petsc4py import PETSc

from ..base.shared_rows import sum_of
from .factor import Factorisation


class FreeFactorisation(Factorisation):
    """A direct factorisation of B + K, of which K resists some rigid motions by nothing.

    Args:
        matrix, name: as of :class:`~.factor.Factorisation`.
        comm: the processes.
        motions, resisting: R and B R at this process's unknowns, (n, k).
    """

    def __init__(
        self, matrix: PETSc.Mat, name: str, comm: Any, motions: np.ndarray, resisting: np.ndarray
    ) -> None:
        super().__init__(matrix, name)
        self._comm, self._motions = comm, motions
        self._resist(resisting)

    def _resist(self, resisting: np.ndarray) -> None:
        self._resisting = resisting
        self._inverse = np.linalg.inv(sum_of(self._comm, self._motions.T @ resisting))

    def refactor(self, resisting: np.ndarray | None = None) -> None:
        super().refactor()
        if resisting is not None:
            self._resist(resisting)

    def _share(self, of: np.ndarray, values: np.ndarray) -> np.ndarray:
        return self._inverse @ sum_of(self._comm, of.T @ values)

    def solve(self, values: np.ndarray) -> np.ndarray:
        return self._freely(super().solve, values)

    def solve_many(self, columns: Any) -> np.ndarray:
        if self.together == 1:
            return super().solve_many(columns)
        columns = columns.toarray() if sp.issparse(columns) else columns
        return self._freely(super().solve_many, columns)

    def _freely(self, solve: Callable[[np.ndarray], np.ndarray], values: np.ndarray) -> np.ndarray:
        rigid = self._share(self._motions, values)
        strained = solve(values - self._resisting @ rigid)
        rigid = rigid - self._share(self._resisting, strained)
        return np.asarray(strained + self._motions @ rigid)
