# SPDX-License-Identifier: LGPL-3.0-or-later
"""The monolithic system solved by a Krylov method, for large scenes: nothing is factored.

The multipliers make it a saddle, which no multigrid method takes. But the same contact through
springs in series, as compliant as the nodes that they push, is no saddle: its multipliers are
eliminated node by node,

    P = A + T' (C_yy - C_ym S^-1 C_my) T,      S = C_mm - C_my T D^-1 T' C_ym,      D = diag A

on frozen geometry, S in blocks of one node, and multigrid with rigid-body modes does the rest. That
is the paper's augmentation, put to use: P differs from the system only in the compliance of the
contact, W + W_ii in place of W, and no mesh changes by how much; nor does the multigrid take more
cycles on finer meshes, for its levels know the solids apart (the idea is that of the
augmented-Lagrangian preconditioner of Benzi and Olshanskii, SIAM J. Sci. Comput. 28, 2006).
"""

from __future__ import annotations

from collections import deque

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI
from petsc4py import PETSc

from ..base.checks import StepFailed
from ..solids import DeformableSolid
from .monolithic import Monolithic
from .multigrid import Multigrid, rigid_modes
from .problem import Assembly, Clock
from .solid_matrix import SolidMatrix
from .solid_rows import petsc_matrix

#: Share of the residual at which a linear solve ends, and how many iterations it may take.
TOLERANCE, MAX_ITERATIONS = 1e-6, 300
#: Cost: relative error up to which derivatives of the geometry are used.
NEAR = 0.1
#: Cost: a hierarchy serves on for changed solids while it takes no more iterations than this.
PATIENCE = 40

#: C_ym, S^-1 C_my and what the rows of the multipliers are divided by.
Blocks = tuple[sp.csr_matrix, sp.csr_matrix, sp.dia_matrix]


class Krylov(Monolithic):
    """Solved by GMRES, preconditioned by multigrid and nodal elimination of the multipliers.

    PETSc options of the Krylov method have the prefix ``iterative_``, of the multigrid method
    ``multigrid_``.

    Attributes:
        counts: iterations of the last linear solves.
        times: seconds that they took, by part.
    """

    near = NEAR

    def __init__(self, assembly: Assembly) -> None:
        super().__init__(assembly)
        solids = [s for s in self.solids if isinstance(s, DeformableSolid)]
        self._modes = np.vstack([rigid_modes(s) for s in solids])
        given = [own[s.fixed_unknowns] for s, own in zip(solids, self.places.own)]
        self._given = np.concatenate(given) - self.places.mine.start
        # unknowns at the surfaces, which contacts touch: all, this process's, and these from 0
        touched = np.zeros(self.places.size, dtype=bool)
        for k, trace in (each for traces in self._traces for each in traces):
            touched[self.places.numbers[k][trace.seeing().indices]] = True
        self._touched, here = np.flatnonzero(touched), self.places.mine
        self._at = np.flatnonzero(touched[here])
        self._mine = here.start + self._at
        self.counts: deque[int] = deque(maxlen=100)
        self.times: dict[str, float] = {}
        self._multigrid: Multigrid | None = None
        self._held: SolidMatrix | None = None
        self._made_of: list[int] = []

    def _solve(self) -> np.ndarray:
        clock, n = Clock(self.times), self.places.size
        frozen = self._contact_block(frozen=True) + self._compliance()
        yy, ym, seen, mm = frozen[:n, :n], frozen[:n, n:], frozen[n:, :n], frozen[n:, n:]
        # far from the solution some points are paired with what they will not meet, and derivatives
        # of that push where they should pull
        far = self.frozen or max(self._errors) > self.near
        block = frozen if far else self._contact_block() + self._compliance()
        # the rows of the multipliers times S^-1, as the forces for which these stand: norms add
        # them to those of the solids
        inverse, force = self._nodal_inverse(ym, seen, mm), _column_size(ym)
        solve = sp.diags(force) @ inverse
        block = sp.bmat([[block[:n, :n], ym], [solve @ block[n:, :n], solve @ mm]], format="csr")
        residual = self.residual()
        residual[n:] = solve @ residual[n:]
        blocks = ym, inverse @ seen, sp.diags(1 / force)
        springs = (yy - ym @ inverse @ seen).tocsr()
        clock("surface")
        stale = self._renew(springs)
        clock("multigrid")
        A = self._system(block)
        x, b = A.createVecs()
        b.setArray(residual[self._rows_here])
        count, done = self._krylov(A, b, x, blocks, PATIENCE if stale else MAX_ITERATIONS)
        if stale and not done:
            self._renew(springs, anew=True)
            more, done = self._krylov(A, b, x, blocks, MAX_ITERATIONS)
            count += more
        self.counts.append(count)
        clock("GMRES")
        local = x.array_r.copy()
        for thing in (A, x, b):
            thing.destroy()
        if not done:
            raise StepFailed(
                f"GMRES does not end within {MAX_ITERATIONS} iterations; solver = 'monolithic' "
                "needs none"
            )
        local[self._given] = 0.0  # to more digits than the tolerance leaves them
        return self._solid_rows.everywhere(local)

    def _system(self, block: sp.csr_matrix) -> PETSc.Mat:
        """The solids with what the contacts add to them and their multipliers."""
        multipliers = np.arange(self.places.size, self.size)
        here = multipliers[: self._rows_here.stop - self.places.mine.stop]
        rows = np.concatenate([self._mine, here])
        own = block[rows][:, np.concatenate([self._touched, multipliers])]
        return self._solids.plus(petsc_matrix(own, self.comm), rows - self.places.mine.start)

    def _renew(self, springs: sp.csr_matrix, anew: bool = False) -> bool:
        """Set up the multigrid of P, the solids with these springs; whether its coarser levels are
        those of solids that have changed since, which they never are if made ``anew``."""
        if self._multigrid is None or anew:
            if self._multigrid is not None:
                self._multigrid.destroy()
            solids, block = self._solids.matrix, self.solids[0].dim
            self._multigrid = Multigrid(solids, self._modes, block, self._mine)
            self._made_of = self._solids.of
        own = petsc_matrix(springs[self._mine][:, self._touched], self.comm)
        self._multigrid.stiffen(self._solids.plus(own, self._at), own)
        return self._made_of != self._solids.of

    @property
    def _solids(self) -> SolidMatrix:
        """The solids as they are linearised now."""
        now = self._solid_rows.now()
        if self._held is None or self._held.of != now:
            if self._held is not None:
                self._held.destroy()
            self._held = SolidMatrix(self._solid_rows, self.comm)
        return self._held

    def _diagonal(self) -> np.ndarray:
        return self._solid_rows.everywhere(self._solids.diagonal())

    def _krylov(
        self, A: PETSc.Mat, b: PETSc.Vec, x: PETSc.Vec, blocks: Blocks, most: int
    ) -> tuple[int, bool]:
        """Go on from x; how many iterations it took, at most so many, and whether that is it."""
        assert self._multigrid is not None
        solver = PETSc.KSP().create(self.comm)
        solver.setOptionsPrefix("iterative_")
        solver.setType("gmres")
        solver.setGMRESRestart(100)
        solver.setPCSide(PETSc.PC.Side.RIGHT)
        solver.setInitialGuessNonzero(True)
        solver.setTolerances(rtol=TOLERANCE, max_it=most)
        solver.getPC().setType("python")
        solver.getPC().setPythonContext(
            _ThroughSprings(self._multigrid, self.places.mine, blocks, self.comm)
        )
        solver.setOperators(A)
        solver.setFromOptions()
        solver.solve(b, x)
        result = solver.getIterationNumber(), solver.getConvergedReason() > 0
        solver.destroy()
        return result

    def _nodal_inverse(
        self, ym: sp.csr_matrix, my: sp.csr_matrix, mm: sp.csr_matrix
    ) -> sp.csr_matrix:
        """S^-1: the multipliers of each node by what is left of their rows."""
        springs = my @ sp.diags(1 / self._diagonal()) @ ym
        S = (mm - springs).tocsr()
        empty = np.empty(0, dtype=np.int64)
        blocks, first = [(np.empty(0), empty, empty)], 0
        for part in self.parts:
            nodes, m = len(part.equations.candidates), part.multipliers
            if not m:
                continue
            k = m // nodes
            at = first + np.arange(m).reshape(k, nodes).T  # (nodes, k)
            row, column = np.broadcast_arrays(at[:, :, None], at[:, None, :])
            dense = np.asarray(S[row.ravel(), column.ravel()]).reshape(nodes, k, k)
            data = np.linalg.inv(dense).ravel()
            blocks.append((data, row.ravel(), column.ravel()))
            first += m
        data, row, column = (np.concatenate(part) for part in zip(*blocks))
        return sp.csr_matrix((data, (row, column)), mm.shape)


class _ThroughSprings:
    """The preconditioner: the system with springs in the contact, eliminated to the solids."""

    def __init__(
        self,
        multigrid: Multigrid,
        mine: slice,
        blocks: Blocks,
        comm: MPI.Comm,
    ) -> None:
        push, seen, multipliers = blocks
        self._n = n = mine.stop - mine.start
        m = seen.shape[0] if comm.rank == comm.size - 1 else 0
        self._push = petsc_matrix((push @ multipliers).tocsr()[mine], comm, columns=m)
        self._seen = petsc_matrix(seen.tocsr()[:m], comm, columns=n)
        self._multipliers = multipliers.diagonal()[:m]
        self._multigrid = multigrid
        self._v, self._r = self._seen.createVecRight(), self._push.createVecLeft()
        self._f, self._g = self._push.createVecRight(), self._seen.createVecLeft()

    def apply(self, pc: PETSc.PC, x: PETSc.Vec, y: PETSc.Vec) -> None:
        """y = P^-1 x."""
        both = x.array_r
        self._f.setArray(both[self._n :])
        self._push.mult(self._f, self._r)
        self._r.setArray(both[: self._n] - self._r.array_r)
        self._multigrid.apply(self._r, self._v)
        self._seen.mult(self._v, self._g)
        multipliers = self._multipliers * self._f.array_r - self._g.array_r
        y.setArray(np.concatenate([self._v.array_r, multipliers]))


def _column_size(matrix: sp.csr_matrix) -> np.ndarray:
    """The largest entry of each column; of empty ones the largest of all, or 1."""
    size = np.zeros(matrix.shape[1])
    entries = matrix.tocoo()
    np.maximum.at(size, entries.col, np.abs(entries.data))
    return np.where(size > 0, size, size.max(initial=0.0) or 1.0)
