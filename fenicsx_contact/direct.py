# SPDX-License-Identifier: LGPL-3.0-or-later
"""The linear system of the full Newton method, factored.

Before its numbers a sparse matrix has its pattern analysed, which may take longer than the rest. As
partners change the pattern does, by little: so it is made with room for partners one facet away,
and kept while that will do, but not beyond a step: what a run computes must not depend on whether
it was interrupted.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI

from .assembly import Assembly
from .linear import direct_solver
from .monolithic import Monolithic, petsc_matrix
from .theta import Step


class Direct(Monolithic):
    """Solved by a direct factorisation, which is new in each iteration."""

    def __init__(self, assembly: Assembly) -> None:
        super().__init__(assembly)
        self._step: Step | None = None
        self._system: _System | None = None

    def begin(self, step: Step) -> tuple[float, np.ndarray]:
        if step is not self._step:
            self._step = step
            self._drop()
        return super().begin(step)

    def _drop(self) -> None:
        if self._system is not None:
            self._system.destroy()
        self._system = None

    def _solve(self) -> np.ndarray:
        contacts = (self._contact_block() + self._compliance())[self._rows_here]
        here = self._system is not None and self._system.holds(contacts)
        old = bool(self.comm.allreduce(here, op=MPI.MIN)) if self.comm.size > 1 else here
        if not old:
            self._make()
        change = self._solve_with(contacts)
        if old and not np.isfinite(change).all():  # it may lack pivots or memory for these values
            self._make()
            change = self._solve_with(contacts)
        return change

    def _solve_with(self, contacts: sp.csr_matrix) -> np.ndarray:
        assert self._system is not None
        matrices = self._solid_rows(*contacts.shape), contacts
        return self._everywhere(self._system.solve(matrices, self._residual()[self._rows_here]))

    def _make(self) -> None:
        """A system with room for what the contacts may add to the solids."""
        self._drop()
        seen = self._seen()
        room = _pattern(seen.T.tocsr()[self._rows_here] @ seen)
        self._system = _System(_pattern(self._solid_rows(*room.shape)), room, self.comm)

    def _seen(self) -> sp.csr_matrix:
        """Ones where a point of a contact sees an unknown, its multipliers among them, or may see
        it when its partner is the next facet, (points, size). Whatever it sees it may couple."""
        last, blocks = self._places.size, [sp.csr_matrix((0, self._size))]
        for contact, part in enumerate(self._parts):
            points, m = len(part.equations.candidates), part.multipliers
            J, see = part.jump_operator(), _pattern(self._onto(contact, "seeing", last))
            if J is not None:
                J = sp.block_diag([_pattern(sp.csr_matrix(J)), sp.identity(m)])
                see = J @ see @ self._neighbours(contact)
            jumps = np.repeat(np.arange(points), (see.shape[0] - m) // max(points, 1))
            point = np.concatenate([jumps, np.arange(m) % max(points, 1)])
            place = point, np.arange(len(point))
            gather = sp.csr_matrix((np.ones(len(point)), place), (points, len(point)))
            blocks.append(gather @ see)
            last += m
        return sp.vstack(blocks, "csr")

    def _neighbours(self, contact: int) -> sp.csr_matrix:
        """Ones where two unknowns of the surfaces of a contact, of which one is this process's,
        belong to the same cell, or are the same."""
        mine, size = self._places.mine, self._size
        numbers = [self._places.numbers[k][t.seeing().indices] for k, t in self._traces[contact]]
        surface = np.unique(np.concatenate(numbers))
        own = surface[(surface >= mine.start) & (surface < mine.stop)]
        rows = _pattern(self._solid_rows(0, size)[own - mine.start])
        on = np.zeros(size)
        on[surface] = 1.0
        place = own, np.arange(len(own))
        placed = sp.csr_matrix((np.ones(len(own)), place), (size, len(own)))
        return placed @ rows @ sp.diags(on) + sp.identity(size)


class _System:
    """A matrix of a given pattern, and its factors.

    Args:
        solids, room: this process's rows: ones where the solids have entries, and where there is
            room for those of the contacts.
        comm: the processes.
    """

    def __init__(self, solids: sp.csr_matrix, room: sp.csr_matrix, comm: MPI.Comm) -> None:
        self._room = room
        self._A = petsc_matrix(solids + room, comm)
        self._solver = direct_solver(self._A, "monolithic")
        self._x, self._b = self._A.createVecs()

    def holds(self, contacts: sp.csr_matrix) -> bool:
        """Whether there is room for these entries."""
        room = self._room
        return room.shape == contacts.shape and (room + _pattern(contacts)).nnz == room.nnz

    def solve(self, matrices: Sequence[sp.csr_matrix], right: np.ndarray) -> np.ndarray:
        """This process's part of the solution with the sum of the matrices, whose rows are this
        process's; NaN where there is none."""
        self._A.zeroEntries()
        for rows in matrices:
            csr = rows.indptr.astype(np.int32), rows.indices.astype(np.int32), rows.data
            self._A.setValuesCSR(*csr, addv=True)
        self._A.assemble()
        self._b.setArray(right)
        self._solver.setOperators(self._A)
        self._solver.solve(self._b, self._x)
        failed = self._solver.getConvergedReason() < 0
        return np.full(len(right), np.nan) if failed else self._x.array_r.copy()

    def destroy(self) -> None:
        """Free what PETSc holds."""
        for thing in (self._solver, self._A, self._x, self._b):
            thing.destroy()


def _pattern(matrix: sp.csr_matrix) -> sp.csr_matrix:
    """Ones where the matrix has entries."""
    matrix = sp.csr_matrix(matrix)
    ones = np.ones(matrix.nnz)
    return sp.csr_matrix((ones, matrix.indices, matrix.indptr), matrix.shape)
