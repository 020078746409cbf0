# SPDX-License-Identifier: LGPL-3.0-or-later
"""One linear system of the full Newton method, solids and multipliers together, sparse.

    [ A + T' C_yy T   T' C_ym ] [dv]     [ r + T' f ]
    [ C_my T          C_mm    ] [dm] = - [ F_m      ]

with r the solids' momentum balances, T their traces, and f, F, C the contacts' forces, rows and
tangents. Rows are distributed as the solids are; the multipliers, which every process knows, belong
to the last one.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from petsc4py import PETSc

from .assembly import Assembly
from .linear import direct_solver
from .system import COMPLIANCE
from .theta import Step


class Monolithic:
    """Linear systems in the velocities of all solids and the multipliers."""

    def __init__(self, assembly: Assembly) -> None:
        self._all = assembly
        self.comm = assembly.solids[0].mesh.mesh.comm
        self._parts = [contact.part for contact in assembly.contacts]
        # numbers of the unknowns: by process, on each by solid; the multipliers last of all
        counts = np.array([solid.layout(self.comm) for solid in assembly.solids])  # (solids, ranks)
        start = np.concatenate([[0], np.cumsum(counts.sum(axis=0))])
        self._mine = slice(int(start[self.comm.rank]), int(start[self.comm.rank + 1]))
        self._unknowns = int(start[-1])
        self._numbers = []  # for each solid the number of each of its unknowns in the system
        for k, count in enumerate(counts):
            first = start[:-1] + counts[:k].sum(axis=0)
            blocks = [np.arange(a, a + n) for a, n in zip(first, count)]
            self._numbers.append(np.concatenate(blocks))
        index = {id(solid): k for k, solid in enumerate(assembly.solids)}
        self._of = [index[id(solid)] for solid, _ in assembly.sides]
        self._matrix: PETSc.Mat | None = None

    def begin(self, step: Step) -> tuple[float, np.ndarray]:
        """Residual of the present state: its largest relative error, and the forces on all points
        (flat, N)."""
        everything = self._all.parts[-1].stop if self._all.parts else 0
        force, errors = np.zeros(everything), [0.0]
        self._rows = []
        self._worst = ("", 0.0)
        for part, places in zip(self._parts, self._all.parts):
            residual, active = part.active_residual(), part.active_places
            force[places.start + active] = -residual[: len(active)]
            rows = residual[len(active) :] * part.scales()[1][len(active) :]
            self._rows.append(rows)
            errors.append(float(part.error(rows).max(initial=0.0)))
        self._all.spread(force)
        errors += [solid.imbalance(step) for solid in self._all.solids]
        self._errors = errors
        return float(np.max(errors)), force

    def iterate(self, step: Step) -> bool:
        """Solve, and move the solids; False if the system is singular."""
        solution = self._solve(*self._assemble())
        if not np.isfinite(solution).all():
            return False
        last = self._unknowns
        for solid, numbers in zip(self._all.solids, self._numbers):
            solid.go(solid.trial_velocity - solution[numbers[solid.owned_range(self.comm)]], step)
        for part in self._parts:
            n, m = len(part.active_places), part.multipliers
            change = np.zeros(n + m)
            change[n:] = -solution[last : last + m] * part.scales()[0][n:]
            part.move(change)
            last += m
        return True

    def _assemble(self) -> tuple[sp.csr_matrix, np.ndarray]:
        """This process's rows of the matrix and of the residual."""
        size = self._unknowns + sum(part.multipliers for part in self._parts)
        blocks, values = [], np.zeros(size)
        for solid, numbers in zip(self._all.solids, self._numbers):
            own = numbers[solid.owned_range(self.comm)]
            indptr, columns, entries = solid.matrix_rows(self.comm)
            rows = np.repeat(own, np.diff(indptr))
            blocks.append((entries, rows, numbers[columns]))
            values[own] = solid.residual()
        last, side = self._unknowns, 0
        for contact, part, rows in zip(self._all.contacts, self._parts, self._rows):
            traces = contact.traces
            spreads, sees = [], []
            for trace in traces:
                numbers = self._numbers[self._of[side]]
                spreads.append(_renumber(trace.spreading(), numbers, self._unknowns))
                sees.append(_renumber(trace.seeing(), numbers, self._unknowns))
                side += 1
            n, m = len(part.active_places), part.multipliers
            spread = sp.vstack(spreads, format="csr")[part.active_places]
            see = sp.vstack(sees, format="csr")[part.active_places]
            columns, scale = (s[n:] for s in part.scales())
            tangent = sp.csr_matrix(part.sparse_tangent())
            mixed = sp.bmat([[spread.T.tocsr(), None], [None, sp.diags(scale)]], format="csr")
            onto = sp.bmat([[see, None], [None, sp.diags(columns)]], format="csr")
            block = (mixed @ tangent @ onto).tocoo()
            at = np.concatenate([np.arange(self._unknowns), np.arange(last, last + m)])
            blocks.append((block.data, at[block.row], at[block.col]))
            own = np.arange(last, last + m)
            blocks.append((np.full(m, -COMPLIANCE), own, own))
            values[own] = rows
            last += m
        data, rows, columns = (np.concatenate(parts) for parts in zip(*blocks))
        final = self.comm.rank == self.comm.size - 1
        stop = size if final else self._mine.stop
        here = (rows >= self._mine.start) & (rows < stop)
        shape = (stop - self._mine.start, size)
        index = rows[here] - self._mine.start, columns[here]
        return sp.csr_matrix((data[here], index), shape), values[self._mine.start : stop]

    def _solve(self, matrix: sp.csr_matrix, values: np.ndarray) -> np.ndarray:
        """The whole solution, on every process."""
        n, size = matrix.shape
        csr = (matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32), matrix.data)
        A = PETSc.Mat().createAIJ(((n, size), (n, size)), csr=csr, comm=self.comm)
        solver = direct_solver(A, "monolithic")
        x, b = A.createVecs()
        b.setArray(values)
        solver.solve(b, x)
        failed = solver.getConvergedReason() < 0
        local = np.full(n, np.nan) if failed else x.array_r.copy()
        for thing in (solver, A, x, b):
            thing.destroy()
        return np.concatenate(self.comm.allgather(local)) if self.comm.size > 1 else local

    def stall(self) -> str:
        """What stalls."""
        names = [f"the rows of contact {c.name!r}" for c in self._all.contacts]
        names += [f"the momentum balance of {s.name!r}" for s in self._all.solids]
        worst = int(np.argmax(self._errors[1:]))
        return f"{names[worst]} stall at a relative error of {self._errors[1 + worst]:.3g}"


def _renumber(operator: sp.csr_matrix, numbers: np.ndarray, size: int) -> sp.csr_matrix:
    """The operator (places, unknowns of a solid) in the unknowns of the system."""
    indices = numbers[operator.indices]
    return sp.csr_matrix((operator.data, indices, operator.indptr), (operator.shape[0], size))
