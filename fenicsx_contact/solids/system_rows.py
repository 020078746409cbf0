# SPDX-License-Identifier: LGPL-3.0-or-later
"""A deformable solid's rows of a monolithic system."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI

from ..base.vectors import largest
from ..theory.scheme import Step
from .balance import BalancedSolid
from .factor import Factorisation


class SystemRows(BalancedSolid):
    """What a solid with a displacement field gives to a system whose rows are shared out by
    process: those of its owned unknowns."""

    factorisation: Factorisation
    free_load: np.ndarray

    def layout(self, comm: MPI.Comm) -> list[int]:
        return list(comm.allgather(self.owned))

    def owned_range(self, comm: MPI.Comm) -> slice:
        return slice(self.vectors.first, self.vectors.first + self.owned)

    def matrix_rows(self, comm: MPI.Comm) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return self.factorisation.matrix.getValuesCSR()

    def residual(self) -> np.ndarray:
        return self.linear_residual()

    def load_size(self) -> float:
        free = self.free_load.copy()
        free[self.fixed_unknowns] = 0.0
        own = float(max(largest(free), largest(self._force)))
        return own if self.comm.size == 1 else max(self.comm.allgather(own))

    def load_speed(self) -> float:
        free = self.free_load / self.factorisation.diagonal
        free[self.fixed_unknowns] = 0.0
        own = largest(free)
        return own if self.comm.size == 1 else max(self.comm.allgather(own))

    def respond(self, step: Step) -> None:
        """Move on from the trial state by what the forces spread so far do alone: so no digits are
        lost where loads and contact undo each other."""
        load = self._force
        load[self.fixed_unknowns] = 0.0
        self.go(self.trial_velocity + self.factorisation.solve(load), step)

    def linear_residual(self) -> np.ndarray:
        moved = self.vectors.multiply(self.factorisation.matrix, self.trial_velocity)
        result = moved - self.free_load - self._force
        result[self.fixed_unknowns] = 0.0
        return result
