# SPDX-License-Identifier: LGPL-3.0-or-later
"""The linear system of the full Newton method, factored.

Before its numbers a sparse matrix has its pattern analysed, which may take longer than the rest. As
partners change the pattern does, by little: so it is made with room for partners one facet away,
and kept while that will do, but not beyond a step: what a run computes must not depend on whether
it was interrupted.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI
from petsc4py import PETSc

from .linear import direct_solver
from .monolithic import Monolithic, petsc_matrix
from .theta import Step


class Direct(Monolithic):
    """Solved by a direct factorisation, which is new in each iteration."""

    _step: Step | None = None
    _room: sp.csr_matrix | None = None  # for the contacts' entries, in this process's rows
    _solver: PETSc.KSP | None = None

    def begin(self, step: Step) -> tuple[float, np.ndarray]:
        if step is not self._step:
            self._step, self._room = step, None
        return super().begin(step)

    def _solve(self) -> np.ndarray:
        mine = (self._contact_block() + self._compliance())[self._rows_here]
        old = self._has_room(mine)
        if not old:
            self._make()
        change = self._solve_with(mine)
        if old and not np.isfinite(change).all():  # it may lack pivots or memory for these values
            self._make()
            change = self._solve_with(mine)
        return change

    def _has_room(self, entries: sp.csr_matrix) -> bool:
        """Whether the pattern at hand holds these entries, on every process."""
        room = self._room
        fits = room is not None and room.shape == entries.shape
        fits = fits and (room + _pattern(entries)).nnz == room.nnz
        return bool(self.comm.allreduce(fits, op=MPI.MIN)) if self.comm.size > 1 else fits

    def _make(self) -> None:
        """A matrix with room for what the contacts may add to those of the solids."""
        if self._solver is not None:
            for thing in (self._solver, self._A, self._x, self._b):
                thing.destroy()
        here, seen = self._rows_here, self._seen()
        self._room = _pattern(seen[here] @ seen.T)
        solids = _pattern(self._solid_rows(*self._room.shape))
        self._A = petsc_matrix(solids + self._room, self.comm)
        self._solver = direct_solver(self._A, "monolithic")
        self._x, self._b = self._A.createVecs()

    def _seen(self) -> sp.csr_matrix:
        """Which unknowns each point of a contact sees, its multipliers among them, or may see when
        its partner is the next facet: ones, (size, points). Whatever it sees it may couple."""
        velocities, multipliers = [sp.csr_matrix((self._places.size, 0))], []
        for contact, part in enumerate(self._parts):
            points, m = len(part.equations.candidates), part.multipliers
            if not points:
                continue
            J, see = part.jump_operator(), self._operator(contact, "seeing")
            seen = _pattern(see[part.active_places])
            if J is not None:
                seen = _pattern(sp.csr_matrix(J)) @ seen
                seen = seen @ self._neighbours(np.unique(see.indices))
            each = sp.kron(sp.identity(points), np.ones((1, seen.shape[0] // points)))
            velocities.append((each @ seen).T)
            own = np.arange(m), np.arange(m) % points  # component by component
            multipliers.append(sp.csr_matrix((np.ones(m), own), (m, points)))
        behind = [sp.block_diag(multipliers)] if multipliers else []
        return sp.vstack([sp.hstack(velocities), *behind], "csr")

    def _neighbours(self, surface: np.ndarray) -> sp.csr_matrix:
        """Ones where two unknowns of a surface, of which one is this process's, belong to the same
        cell or are the same."""
        mine, n = self._places.mine, self._places.size
        own = surface[(surface >= mine.start) & (surface < mine.stop)]
        rows = _pattern(self._solid_rows()[own - mine.start])
        on = np.zeros(n)
        on[surface] = 1.0
        placed = sp.csr_matrix((np.ones(len(own)), (own, np.arange(len(own)))), (n, len(own)))
        return placed @ rows @ sp.diags(on) + sp.identity(n)

    def _solve_with(self, entries: sp.csr_matrix) -> np.ndarray:
        """The solution; NaN where there is none."""
        A, x, b = self._A, self._x, self._b
        A.zeroEntries()
        for rows in (self._solid_rows(*entries.shape), entries):
            csr = rows.indptr.astype(np.int32), rows.indices.astype(np.int32), rows.data
            A.setValuesCSR(*csr, addv=True)
        A.assemble()
        b.setArray(self._residual()[self._rows_here])
        assert self._solver is not None
        self._solver.setOperators(A)
        self._solver.solve(b, x)
        failed = self._solver.getConvergedReason() < 0
        local = np.full(len(x.array_r), np.nan) if failed else x.array_r.copy()
        return self._everywhere(local)


def _pattern(matrix: sp.csr_matrix) -> sp.csr_matrix:
    """Ones where the matrix has entries."""
    matrix = sp.csr_matrix(matrix)
    ones = np.ones(matrix.nnz)
    return sp.csr_matrix((ones, matrix.indices, matrix.indptr), matrix.shape)
