# SPDX-License-Identifier: LGPL-3.0-or-later
"""The linear system of the full Newton method, factored. The multipliers, which every process
knows, belong to the last one.

Before a sparse matrix is factored its pattern is analysed, which may take longer than the rest.
With partners and statuses the pattern changes, by little: so in the plane it is made with room for
all that points may see, partners one facet away among it, and kept while that will do; but not
beyond a step, for a run must give the same bits whether it was interrupted or not.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI
from scipy.sparse.linalg import splu

from ..solids.factor import Direct
from .embedding import Added, Embedding
from .monolithic import Monolithic
from .problem import Assembly
from .solid_rows import petsc_matrix

#: Cost: sweeps over rows and columns that balance a matrix; each halves the orders that are left.
SWEEPS = 6


class Sparse(Monolithic):
    """Solved by a direct factorisation, which is new in each iteration."""

    _system: _System | None = None

    def __init__(self, assembly: Assembly) -> None:
        super().__init__(assembly)
        self._embedding = Embedding(self.parts, self._traces, self.places.number)
        self._adjacent: dict[int, sp.csr_matrix] = {}

    def restart(self) -> None:
        super().restart()
        self._drop()

    def _drop(self) -> None:
        if self._system is not None:
            self._system.destroy()
        self._system = None

    def _change(self) -> tuple[list[np.ndarray], np.ndarray]:
        change = self._solve()
        return [change[own] for own in self.places.own], change[self.places.size :]

    def _solve(self) -> np.ndarray:
        """The whole solution, scaled, on every process; NaN where there is none."""
        contacts = (self._contacts() + self._compliance())[self._rows_here]
        if self.rigid:  # the contacts are the matrix
            return self._by(pivoted(self._solid_rows(*contacts.shape) + contacts))
        here = self._system is not None and self._system.holds(contacts)
        old = bool(self.comm.allreduce(here, op=MPI.MIN)) if self.comm.size > 1 else here
        if not old:
            self._make(contacts)
        change = self._solve_with(contacts)
        if old and not np.isfinite(change).all():  # it may lack pivots or memory for these values
            self._make(contacts)
            change = self._solve_with(contacts)
        return change

    def _solve_with(self, contacts: sp.csr_matrix) -> np.ndarray:
        assert self._system is not None
        self._system.factor((self._solid_rows(*contacts.shape), contacts))
        return self._by(self._system.solve)

    def _by(self, inverse: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """The same by the inverse of the matrix, applied to this process's rows."""
        everywhere, here = self._solid_rows.everywhere, self._rows_here
        change = everywhere(inverse(self._residual()[here]))
        if self.hyperstatic and not self.held:  # once corrected for what makes it regular
            left = np.where(np.arange(self.size) < self.places.size, 0.0, -self._softness * change)
            change += everywhere(inverse(left[here]))
        return change

    def _residual(self) -> np.ndarray:
        """Scaled residual of all rows; of those of the solids only this process's."""
        values = np.zeros(self.size)
        for solid, own in zip(self.solids, self.places.own):
            values[own] = solid.linear_residual() if self.frozen else solid.residual()
        values[self.places.size :] = np.concatenate([*self.rows, np.empty(0)])
        return values

    def _contacts(self) -> sp.csr_matrix:
        """What the contacts add to the matrix, scaled, (size, size), on every process."""
        added = []
        for contact, part in enumerate(self.parts):
            if n := len(part.active_places):
                scales = (each[n:] * (not self.held) for each in part.scales())
                added.append(Added(contact, part.sparse_tangent(self.frozen), *scales))
        return self._embedding.tangent(added, self.places.size, self.size)

    def _compliance(self) -> sp.csr_matrix:
        """The compliance that makes the multipliers unique, where they are not."""
        n, m = self.places.size, self.size - self.places.size
        diagonal = np.repeat([0.0, -1.0 if self.held else -self._softness], [n, m])
        if self._weakly.any():
            spring = self._weak_spring(self._solid_rows.diagonal())
            for solid in np.flatnonzero(self._weakly):
                diagonal[self.places.all_of(solid)] = spring
        return sp.diags(diagonal, format="csr")

    @property
    def _rows_here(self) -> slice:
        """This process's rows of the system."""
        mine, final = self.places.mine, self.comm.rank == self.comm.size - 1
        return slice(mine.start, self.size if final else mine.stop)

    def _make(self, contacts: sp.csr_matrix) -> None:
        """A system with room for what the contacts add to the solids, and may add soon."""
        self._drop()
        room = _pattern(contacts)
        if self.solids[0].dim == 2:  # in space the analysis costs little, and room much
            seen = self._seen()
            room += _pattern(seen.T.tocsr()[self._rows_here] @ seen)
        self._system = _System(_pattern(self._solid_rows(*room.shape)), room, self.comm)

    def _seen(self) -> sp.csr_matrix:
        """Ones where a point of a contact sees an unknown, its multipliers among them, or may see
        it soon, (points, size). Whatever it sees it may couple."""
        last, n, blocks = self.places.size, self.places.size, [sp.csr_matrix((0, self.size))]
        for contact, part in enumerate(self.parts):
            points, m = len(part.equations.candidates), part.multipliers
            if not points:
                continue
            see = self._embedding.onto([(contact, m)], "seeing", last, self.size)
            see, J = see[: see.shape[0] - m, :n], part.jump_operator()
            if J is not None:
                see = _pattern(sp.csr_matrix(J)) @ _pattern(see) @ self._neighbours(contact)
            see, own = see.tocoo(), np.arange(m)  # component by component
            row = np.concatenate([see.row // (see.shape[0] // points), own % points])
            place = row, np.concatenate([see.col, last + own])
            blocks.append(sp.csr_matrix((np.ones(len(row)), place), (points, self.size)))
            last += m
        return sp.vstack(blocks, "csr")

    def _neighbours(self, contact: int) -> sp.csr_matrix:
        """Ones where two unknowns of the surfaces of a contact belong to the same cell; made once,
        for the solids' patterns stay."""
        if contact not in self._adjacent:
            mine, n = self.places.mine, self.places.size
            surface = np.zeros(n, dtype=bool)
            for k, trace in self._traces[contact]:
                surface[self.places.number(k, trace.seeing().indices)] = True
            rows = self._solid_rows().tocoo()
            both = surface[mine.start + rows.row] & surface[rows.col]
            found = self.comm.allgather((mine.start + rows.row[both], rows.col[both]))
            place = tuple(np.concatenate(each) for each in zip(*found))
            self._adjacent[contact] = sp.csr_matrix((np.ones(len(place[0])), place), (n, n))
        return self._adjacent[contact]


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
        self._solver = Direct(self._A, "monolithic")
        self._x, self._b = self._A.createVecs()

    def holds(self, contacts: sp.csr_matrix) -> bool:
        """Whether there is room for these entries."""
        room = self._room
        return room.shape == contacts.shape and (room + _pattern(contacts)).nnz == room.nnz

    def factor(self, matrices: Sequence[sp.csr_matrix]) -> None:
        """Take up the sum of the matrices, whose rows are this process's."""
        self._A.zeroEntries()
        for rows in matrices:
            csr = rows.indptr.astype(np.int32), rows.indices.astype(np.int32), rows.data
            self._A.setValuesCSR(*csr, addv=True)
        self._A.assemble()
        self._solver.refactor()

    def solve(self, right: np.ndarray) -> np.ndarray:
        """This process's part of the solution; NaN where there is none."""
        self._b.setArray(right)
        solved = self._solver.solve(self._b, self._x)
        return self._x.array_r.copy() if solved else np.full(len(right), np.nan)

    def destroy(self) -> None:
        """Free what PETSc holds."""
        for thing in (self._solver, self._A, self._x, self._b):
            thing.destroy()


def pivoted(matrix: sp.csr_matrix) -> Callable[[np.ndarray], np.ndarray]:
    """The inverse by SuperLU, which may take any row as the next: where most of the diagonal is
    zero others run out of pivots and of room. NaN where the matrix is singular."""
    rows, columns = _balanced(matrix)
    try:
        solve = splu((sp.diags(rows) @ matrix @ sp.diags(columns)).tocsc()).solve
    except RuntimeError:  # exactly singular
        return lambda values: np.full_like(values, np.nan)
    return lambda values: columns * solve(rows * values)


def _balanced(matrix: sp.csr_matrix) -> tuple[np.ndarray, np.ndarray]:
    """Powers of two by which rows and columns are about 1 at most, whatever their units (D. Ruiz,
    RAL-TR-2001-034): which row a pivot is in is chosen by its size."""
    A = abs(sp.csc_matrix(matrix))
    rows, columns = np.ones(A.shape[0]), np.ones(A.shape[1])
    for _ in range(SWEEPS):
        scaled = sp.diags(rows) @ A @ sp.diags(columns)
        most = scaled.max(axis=1).toarray().ravel(), scaled.max(axis=0).toarray().ravel()
        rows /= np.sqrt(np.where(most[0] > 0, most[0], 1.0))
        columns /= np.sqrt(np.where(most[1] > 0, most[1], 1.0))
    return np.exp2(np.round(np.log2(rows))), np.exp2(np.round(np.log2(columns)))


def _pattern(matrix: sp.csr_matrix) -> sp.csr_matrix:
    """Ones where the matrix has entries."""
    matrix = sp.csr_matrix(matrix)
    ones = np.ones(matrix.nnz)
    return sp.csr_matrix((ones, matrix.indices, matrix.indptr), matrix.shape)
