# SPDX-License-Identifier: LGPL-3.0-or-later
"""Linear solves with the matrix of a solid that is free to move.

In a long step inertia is little beside stiffness: A = c M + K has a condition of about (omega dt)²,
which is 1e10 of a steel block in a hundredth of a second. Its rigid motions R strain nothing,
K R = 0, so that A R = c M R is known, and what round-off makes of it need not be asked:

    A^-1 b = R g / c + P A^-1 (b - M R g),   g = (R' M R)^-1 R' b,   P = 1 - R (R' M R)^-1 R' M.

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
    """A direct factorisation of c M + K, of which some rigid motions are free.

    Args:
        matrix, name: as of :class:`~.factor.Factorisation`.
        comm: the processes.
        motions, momenta: R and M R at this process's unknowns, (n, k).
    """

    def __init__(
        self, matrix: PETSc.Mat, name: str, comm: Any, motions: np.ndarray, momenta: np.ndarray
    ) -> None:
        super().__init__(matrix, name)
        self._comm, self._motions, self._momenta = comm, motions, momenta
        self._inverse = np.linalg.inv(sum_of(comm, motions.T @ momenta))

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
        strained = solve(values - self._momenta @ rigid)
        rigid = rigid / self.rate - self._share(self._momenta, strained)
        return np.asarray(strained + self._motions @ rigid)
