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
        errors += [solid.imbalance(step) for solid in self._solids]
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

    def _contact_block(self) -> sp.csr_matrix:
        """What the contacts add to the matrix, scaled, (size, size), on every process."""
        tangents, rows, columns = [], [], []
        for part, traces in zip(self._parts, self._traces):
            operators = [(k, trace.spreading(), trace.seeing()) for k, trace in traces]
            active = part.active_places
            spread = sp.vstack([self._places.renumber(s, k) for k, s, _ in operators], "csr")
            see = sp.vstack([self._places.renumber(s, k) for k, _, s in operators], "csr")
            tangents.append(part.sparse_tangent())
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

    def stall(self) -> str:
        """What stalls."""
        names = [f"the system of contact {c.name!r}" for c in self._all.contacts]
        names += [f"the momentum balance of {s.name!r}" for s in self._solids]
        worst = int(np.argmax(self._errors[1:]))
        return f"{names[worst]} stalls at a relative error of {self._errors[1 + worst]:.3g}"


class Direct(Monolithic):
    """Solved by a direct factorisation, which is new in each iteration."""

    _linearisations: list[int] | None = None

    def _solve(self) -> np.ndarray:
        size, mine, final = self._size, self._places.mine, self.comm.rank == self.comm.size - 1
        rows = slice(mine.start, size if final else mine.stop)
        matrix = (self._contact_block() + self._compliance())[rows] + self._kept_rows(rows)
        matrix.sort_indices()
        n = matrix.shape[0]
        csr = (matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32), matrix.data)
        A = PETSc.Mat().createAIJ(((n, size), (n, size)), csr=csr, comm=self.comm)
        solver = direct_solver(A, "monolithic")
        x, b = A.createVecs()
        b.setArray(self._residual()[rows])
        solver.solve(b, x)
        failed = solver.getConvergedReason() < 0
        local = np.full(n, np.nan) if failed else x.array_r.copy()
        for thing in (solver, A, x, b):
            thing.destroy()
        return np.concatenate(self.comm.allgather(local)) if self.comm.size > 1 else local

    def _kept_rows(self, rows: slice) -> sp.csr_matrix:
        """The rows of the solids, which change only with their linearisations."""
        now = [solid.linearisation for solid in self._solids]
        if now != self._linearisations:
            self._linearisations, self._solid_matrix = now, self._solid_rows()
        matrix = self._solid_matrix
        shape = rows.stop - rows.start, self._size  # multipliers come and go, behind
        indptr = np.pad(matrix.indptr, (0, shape[0] - matrix.shape[0]), "edge")
        return sp.csr_matrix((matrix.data, matrix.indices, indptr), shape)

    def _solid_rows(self) -> sp.csr_matrix:
        """This process's rows of the solids' own matrices."""
        mine = self._places.mine
        entries, places, columns = [], [], []
        for solid, own, numbers in zip(self._solids, self._places.own, self._places.numbers):
            indptr, indices, values = solid.matrix_rows(self.comm)
            entries.append(values)
            places.append(np.repeat(own[: len(indptr) - 1], np.diff(indptr)) - mine.start)
            columns.append(numbers[indices])
        data, row, column = (np.concatenate(part) for part in (entries, places, columns))
        return sp.csr_matrix((data, (row, column)), (mine.stop - mine.start, self._places.size))


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
