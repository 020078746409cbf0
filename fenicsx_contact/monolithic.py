# SPDX-License-Identifier: LGPL-3.0-or-later
"""One linear system of the full Newton method, solids and multipliers together, sparse.

    [ A + T' C_yy T   T' C_ym ] [dv]     [ r + T' f ]
    [ C_my T          C_mm    ] [dm] = - [ F_m      ]

with r the solids' momentum balances, T their traces, and f, F, C the contacts' forces, rows and
tangents. Rows are distributed as the solids are; the multipliers, which every process knows, belong
to the last one.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI
from petsc4py import PETSc

from .assembly import Assembly
from .linear import direct_solver
from .numbering import Numbering
from .solids import MonolithicSolid, MonolithicTrace
from .system import COMPLIANCE
from .theta import Step


class Monolithic(ABC):
    """Linear systems in the velocities of all solids and the multipliers."""

    def __init__(self, assembly: Assembly) -> None:
        self._all = assembly
        self.comm = assembly.solids[0].mesh.mesh.comm
        self._solids = [s for s in assembly.solids if isinstance(s, MonolithicSolid)]
        self._parts = [contact.part for contact in assembly.contacts]
        self._places = Numbering(self._solids, self.comm)
        index = {id(solid): k for k, solid in enumerate(self._solids)}
        self._traces: list[list[tuple[int, MonolithicTrace]]] = [
            [
                (index[id(solid)], trace)
                for solid, trace in zip(contact.solids, contact.traces)
                if isinstance(trace, MonolithicTrace)
            ]
            for contact in assembly.contacts
        ]
        self._linearisations: list[int] = []

    def begin(self, step: Step) -> tuple[float, np.ndarray]:
        """Residual of the present state: its largest relative error, and the forces on all points
        (flat, N)."""
        everything = self._all.parts[-1].stop if self._all.parts else 0
        force, errors = np.zeros(everything), [0.0]
        self._rows = []
        for part, places in zip(self._parts, self._all.parts):
            residual, active = part.active_residual(), part.active_places
            force[places.start + active] = -residual[: len(active)]
            rows = residual[len(active) :] * part.scales()[1][len(active) :]
            self._rows.append(rows)
            errors.append(float(part.error(rows).max(initial=0.0)))
        self._all.spread(force)
        errors += self._all.imbalances(step, self._solids)
        self._errors = errors
        return float(np.max(errors)), force

    def iterate(self, step: Step) -> bool:
        """Solve, and move the solids; False if the system is singular."""
        change = self._solve()
        if not np.isfinite(change).all():
            return False
        for solid, own in zip(self._solids, self._places.own):
            solid.go(solid.trial_velocity - change[own], step)
        last = self._places.size
        for part in self._parts:
            n, m = len(part.active_places), part.multipliers
            multipliers = change[last : last + m] * part.scales()[0][n:]
            part.move(np.concatenate([np.zeros(n), -multipliers]))
            last += m
        return True

    @abstractmethod
    def _solve(self) -> np.ndarray:
        """The whole solution, scaled, on every process; NaN where there is none."""

    @property
    def _size(self) -> int:
        """Number of unknowns and multipliers."""
        return self._places.size + sum(part.multipliers for part in self._parts)

    def _residual(self) -> np.ndarray:
        """Scaled residual of all rows; of those of the solids only this process's."""
        values = np.zeros(self._size)
        for solid, own in zip(self._solids, self._places.own):
            values[own] = solid.residual()
        values[self._places.size :] = np.concatenate([*self._rows, np.empty(0)])
        return values

    def _contact_block(self, frozen: bool = False) -> sp.csr_matrix:
        """What the contacts add to the matrix, scaled, (size, size), on every process; if
        ``frozen`` without the derivatives of the geometry."""
        tangents, rows, columns = [], [], []
        for part, traces in zip(self._parts, self._traces):
            operators = [(k, trace.spreading(), trace.seeing()) for k, trace in traces]
            active = part.active_places
            spread = sp.vstack([self._places.renumber(s, k) for k, s, _ in operators], "csr")
            see = sp.vstack([self._places.renumber(s, k) for k, _, s in operators], "csr")
            tangents.append(part.sparse_tangent(frozen))
            rows.append((spread[active], part.scales()[1][len(active) :]))
            columns.append((see[active], part.scales()[0][len(active) :]))
        if not tangents:
            return sp.csr_matrix((self._size, self._size))
        block = _onto(rows).T @ sp.block_diag(tangents, "csr") @ _onto(columns)
        return block.tocsr()

    def _compliance(self) -> sp.csr_matrix:
        """The compliance that makes the multipliers unique, where they are not."""
        n, m = self._places.size, self._size - self._places.size
        return sp.diags(np.repeat([0.0, -COMPLIANCE], [n, m]), format="csr")

    @property
    def _rows_here(self) -> slice:
        """This process's rows of the system."""
        mine, final = self._places.mine, self.comm.rank == self.comm.size - 1
        return slice(mine.start, self._size if final else mine.stop)

    def _matrix(self, extra: sp.csr_matrix) -> sp.csr_matrix:
        """This process's rows of the solids' matrices and of what else there is, which is the same
        on every process and, for the multipliers, may be larger."""
        size, start = extra.shape[0], self._places.mine.start
        rows = slice(start, min(self._rows_here.stop, size))
        solids = self._solid_rows()
        # multipliers come and go, behind
        missing = rows.stop - rows.start - solids.shape[0]
        indptr = np.pad(solids.indptr, (0, missing), "edge")
        own = sp.csr_matrix((solids.data, solids.indices, indptr), (rows.stop - start, size))
        return extra[rows] + own

    def _solid_rows(self) -> sp.csr_matrix:
        """This process's rows of the solids' own matrices, new if one of these is."""
        now = [solid.linearisation for solid in self._solids]
        if now != self._linearisations:
            self._linearisations = now
            entries, places, columns = [], [], []
            mine = self._places.mine
            for solid, own, numbers in zip(self._solids, self._places.own, self._places.numbers):
                indptr, indices, values = solid.matrix_rows(self.comm)
                entries.append(values)
                places.append(np.repeat(own[: len(indptr) - 1], np.diff(indptr)) - mine.start)
                columns.append(numbers[indices])
            data, row, column = (np.concatenate(part) for part in (entries, places, columns))
            shape = mine.stop - mine.start, self._places.size
            self._own_rows = sp.csr_matrix((data, (row, column)), shape)
        return self._own_rows

    def _everywhere(self, local: np.ndarray) -> np.ndarray:
        """The rows of all processes."""
        return np.concatenate(self.comm.allgather(local)) if self.comm.size > 1 else local

    def stall(self) -> str:
        """What stalls."""
        names = [f"the system of contact {c.name!r}" for c in self._all.contacts]
        names += [f"the momentum balance of {s.name!r}" for s in self._solids]
        worst = int(np.argmax(self._errors[1:]))
        return f"{names[worst]} stalls at a relative error of {self._errors[1 + worst]:.3g}"


class Direct(Monolithic):
    """Solved by a direct factorisation, which is new in each iteration."""

    def _solve(self) -> np.ndarray:
        A = petsc_matrix(self._matrix(self._contact_block() + self._compliance()), self.comm)
        solver = direct_solver(A, "monolithic")
        x, b = A.createVecs()
        b.setArray(self._residual()[self._rows_here])
        solver.solve(b, x)
        failed = solver.getConvergedReason() < 0
        local = np.full(len(x.array_r), np.nan) if failed else x.array_r.copy()
        for thing in (solver, A, x, b):
            thing.destroy()
        return self._everywhere(local)


def petsc_matrix(rows: sp.csr_matrix, comm: MPI.Comm, columns: int | None = None) -> PETSc.Mat:
    """The matrix whose rows, one process after the other, are these; ``columns``: how many of them
    are this process's, as many as rows if not given."""
    rows.sort_indices()
    n, size = rows.shape
    columns = n if columns is None else columns
    csr = (rows.indptr.astype(np.int32), rows.indices.astype(np.int32), rows.data)
    return PETSc.Mat().createAIJ(((n, PETSc.DECIDE), (columns, size)), csr=csr, comm=comm)


def _onto(parts: list[tuple[sp.csr_matrix, np.ndarray]]) -> sp.csr_matrix:
    """From the unknowns of the system to those of the parts, one part after the other, each with
    its multipliers behind its velocities."""
    count, blocks = sum(len(scale) for _, scale in parts), []
    start = 0
    for operator, scale in parts:
        m = len(scale)
        picked = sp.csr_matrix((scale, (np.arange(m), start + np.arange(m))), (m, count))
        blocks += [[operator, None], [None, picked]]
        start += m
    return sp.bmat(blocks, format="csr")
