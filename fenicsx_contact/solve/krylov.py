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

Each process has what is of its unknowns and of its contact points, whose multipliers stand behind
the former.
"""

from __future__ import annotations

from collections import deque

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI
from petsc4py import PETSc

from ..base.checks import StepFailed
from ..base.processes import together
from ..base.vectors import slices
from ..solids import DeformableSolid
from .monolithic import Monolithic
from .multigrid import Multigrid, rigid_modes
from .problem import Assembly, Clock
from .solid_matrix import SolidMatrix
from .solid_rows import petsc_matrix
from .surface_rows import SurfaceRows
from .through_springs import ThroughSprings, nodal_inverse

#: Share of the residual at which a linear solve ends, and how many iterations it may take.
TOLERANCE, MAX_ITERATIONS = 1e-6, 300
#: Cost: share at which one ends while Newton's method does not come near (cf. R.S. Dembo, S.C.
#: Eisenstat & T. Steihaug, SIAM J. Numer. Anal. 19, 400-408, 1982).
EARLY = 1e-3
#: Cost: relative error up to which derivatives of the geometry are used.
NEAR = 0.1
#: Cost: a hierarchy serves on for changed solids while it takes no more iterations than this.
PATIENCE = 40


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
        start = self.places.mine.start
        given = [own[s.fixed_unknowns] for s, own in zip(solids, self.places.own)]
        self._given = np.concatenate(given) - start
        self._each = slices(map(len, self.places.own))
        self._surface = SurfaceRows(self.parts, self._traces, self.places, self.comm)
        self.counts: deque[int] = deque(maxlen=100)
        self.times: dict[str, float] = {}
        self._multigrid: Multigrid | None = None
        self._held: SolidMatrix | None = None
        self._made_of: list[int] = []

    def restart(self) -> None:
        super().restart()
        self._before = 0.0  # the error before the last correction

    def _change(self) -> tuple[list[np.ndarray], np.ndarray]:
        clock, surface = Clock(self.times), self._surface
        surface.renew()
        t, more, diagonal = len(surface.touched), self._compliance(), self._diagonal
        frozen = surface.share(frozen=True, held=self.held) + more
        yy, ym, seen, mm = frozen[:t, :t], frozen[:t, t:], frozen[t:, :t], frozen[t:, t:]
        # far from the solution some points are paired with what they will not meet, and derivatives
        # of that push where they should pull
        far = self.frozen or max(self._errors) > self.near
        block = frozen if far else surface.share(frozen=False, held=self.held) + more
        # the rows of the multipliers times S^-1, as the forces for which these stand: norms add
        # them to those of the solids
        inverse = together(self.comm, lambda: nodal_inverse(ym, seen, mm, diagonal, surface.points))
        force = self._size(ym)
        solve = sp.diags(force) @ inverse
        block = sp.bmat([[block[:t, :t], ym], [solve @ block[t:, :t], solve @ mm]], format="csr")
        own = surface.own(block)
        springs = surface.own_touched((yy - ym @ inverse @ seen).tocsr())
        rows = np.concatenate([*self.rows, np.empty(0)])[surface.multipliers]
        own_rows = [s.linear_residual() if self.frozen else s.residual() for s in self.solids]
        residual = np.concatenate([*own_rows, solve @ rows])
        clock("surface")
        stale = self._renew(springs)
        clock("multigrid")
        n, m = self.places.mine.stop - self.places.mine.start, len(force)
        at = np.concatenate([surface.at, np.arange(n, n + m)])
        A = self._solids.plus(petsc_matrix(own, self.comm), at)
        x, b = A.createVecs()
        b.setArray(residual)
        start = np.zeros(n + m)
        if self.added is not None:  # a share of what they make of b would be more than all else
            start[n:] = self.added[surface.multipliers]
            x.setArray(start)
            b.axpy(-1.0, A * x)
            x.set(0.0)
        assert self._multigrid is not None
        through = ThroughSprings(
            self._multigrid,
            (n, surface.at),
            petsc_matrix(surface.push(own), self.comm, columns=m),
            petsc_matrix((inverse @ seen).tocsr(), self.comm, columns=len(surface.at)),
            1 / force,
        )
        count, done = self._krylov(A, b, x, through, PATIENCE if stale else MAX_ITERATIONS)
        if stale and not done:
            self._renew(springs, anew=True)
            through.multigrid = self._multigrid
            more_count, done = self._krylov(A, b, x, through, MAX_ITERATIONS)
            count += more_count
        self.counts.append(count)
        self._before = 0.0 if self.frozen else max(self._errors)
        local = start + x.array_r
        through.free()
        for thing in (A, x, b):
            thing.destroy()
        clock("GMRES")
        if not done:
            raise StepFailed(
                f"GMRES does not end within {MAX_ITERATIONS} iterations; solver = 'monolithic' "
                "needs none"
            )
        local[self._given] = 0.0  # to more digits than the tolerance leaves them
        return [local[each] for each in self._each], surface.everywhere(local[n:])

    def _compliance(self) -> sp.csr_matrix:
        surface, t = self._surface, len(self._surface.touched)
        diagonal = np.zeros(t + len(surface.multipliers))
        diagonal[t:] = -1.0 if self.held else -self._softness
        if self._weakly.any():
            spring = self._weak_spring(self._solids.diagonal())
            diagonal[surface.here] = spring * self._weakly[surface.solid[surface.here]]
        return sp.diags(diagonal, format="csr")

    def _size(self, matrix: sp.csr_matrix) -> np.ndarray:
        """The largest entry of each column; of empty ones the largest of all, or 1."""
        size = np.zeros(matrix.shape[1])
        entries = matrix.tocoo()
        np.maximum.at(size, entries.col, np.abs(entries.data))
        most = self.comm.allreduce(size.max(initial=0.0), op=MPI.MAX)
        return np.where(size > 0, size, most or 1.0)

    def _renew(self, springs: sp.csr_matrix, anew: bool = False) -> bool:
        """Set up the multigrid of P, the solids with these springs; whether its coarser levels are
        those of solids that have changed since, which they never are if made ``anew``."""
        if self._multigrid is None or anew:
            if self._multigrid is not None:
                self._multigrid.destroy()
            solids, block = self._solids.matrix, self.solids[0].dim
            first, surface = self.places.mine.start, self._surface
            self._multigrid = Multigrid(solids, self._modes, block, first + surface.at)
            self._made_of = self._solids.of
        own = petsc_matrix(springs, self.comm)
        self._multigrid.stiffen(self._solids.plus(own, self._surface.at), own)
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

    @property
    def _diagonal(self) -> np.ndarray:
        """That of the solids at the unknowns that contacts touch."""
        return self._surface.touched_everywhere(self._solids.diagonal())

    def _krylov(
        self, A: PETSc.Mat, b: PETSc.Vec, x: PETSc.Vec, through: ThroughSprings, most: int
    ) -> tuple[int, bool]:
        """Go on from x; how many iterations it took, at most so many, and whether that is it."""
        solver = PETSc.KSP().create(self.comm)
        solver.setOptionsPrefix("iterative_")
        solver.setType("gmres")
        solver.setGMRESRestart(100)
        solver.setPCSide(PETSc.PC.Side.RIGHT)
        solver.setInitialGuessNonzero(True)
        early = not self.frozen and min(self._before, max(self._errors)) > self.near
        solver.setTolerances(rtol=EARLY if early else TOLERANCE, max_it=most)
        solver.getPC().setType("python")
        solver.getPC().setPythonContext(through)
        solver.setOperators(A)
        solver.setFromOptions()
        solver.solve(b, x)
        result = solver.getIterationNumber(), solver.getConvergedReason() > 0
        solver.destroy()
        return result
