# SPDX-License-Identifier: LGPL-3.0-or-later
"""The monolithic system solved by a Krylov method, for large scenes: nothing is factored.

The multipliers make it a saddle, which no multigrid method takes. But the same contact through
springs in series, as compliant as the nodes that they push, is no saddle: its multipliers are
eliminated node by node,

    P = A + T' (C_yy - C_ym S^-1 C_my) T,      S = C_mm - C_my T D^-1 T' C_ym,      D = diag A

S in blocks of one node, and multigrid with rigid-body modes does the rest. That is the paper's
augmentation, put to use: P differs from the system only in the compliance of the contact, W + W_ii
in place of W, so the number of iterations does not grow with the mesh (the idea is that of the
augmented-Lagrangian preconditioner of Benzi and Olshanskii, SIAM J. Sci. Comput. 28, 2006).
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from petsc4py import PETSc

from .assembly import Assembly
from .checks import InputError
from .monolithic import Monolithic, petsc_matrix
from .solids import DeformableSolid

#: Share of the residual at which a linear solve ends, and how many iterations it may take.
TOLERANCE = 1e-6
MAX_ITERATIONS = 300
#: The springs are so many times as compliant as D says; a node moves its neighbours too.
SOFT = 2.0


class Iterative(Monolithic):
    """Solved by GMRES, preconditioned by multigrid and nodal elimination of the multipliers.

    PETSc options of the Krylov method have the prefix ``iterative_``, of the multigrid method
    ``multigrid_``.

    Attributes:
        counts: iterations of each linear solve so far.

    Raises:
        InputError: a solid without displacement field.
    """

    def __init__(self, assembly: Assembly) -> None:
        super().__init__(assembly)
        rigid = [s.name for s in self._solids if not isinstance(s, DeformableSolid)]
        if rigid:
            raise InputError(
                f"solver = 'iterative': {rigid} have no displacement field; use 'monolithic'"
            )
        self._modes = np.vstack([_rigid_modes(s) for s in self._solids])
        held = [own[s.fixed_unknowns] for s, own in zip(self._solids, self._places.own)]
        self._held = np.concatenate(held) - self._places.mine.start
        self.counts: list[int] = []

    def _solve(self) -> np.ndarray:
        n = self._places.size
        block = self._contact_block() + self._compliance()
        residual = self._residual()
        scale = self._row_scale()
        block, residual = sp.diags(scale) @ block, scale * residual
        yy, ym, my, mm = block[:n, :n], block[:n, n:], block[n:, :n], block[n:, n:]
        inverse = self._nodal_inverse(ym, my, mm)
        A = petsc_matrix(self._matrix(block.tocsr()), self.comm)
        rows = self._rows_here
        P = petsc_matrix(self._matrix((yy - ym @ inverse @ my).tocsr()), self.comm)
        springs = _ThroughSprings(self, P, ym @ inverse, inverse @ my, inverse)
        solver = PETSc.KSP().create(self.comm)
        solver.setOptionsPrefix("iterative_")
        solver.setType("gmres")
        solver.setGMRESRestart(100)
        solver.setPCSide(PETSc.PC.Side.RIGHT)
        solver.setTolerances(rtol=TOLERANCE, max_it=MAX_ITERATIONS)
        solver.getPC().setType("python")
        solver.getPC().setPythonContext(springs)
        solver.setOperators(A)
        solver.setFromOptions()
        x, b = A.createVecs()
        b.setArray(residual[rows])
        solver.solve(b, x)
        self.counts.append(solver.getIterationNumber())
        failed = solver.getConvergedReason() < 0
        local = np.full(len(x.array_r), np.nan) if failed else x.array_r.copy()
        for thing in (solver, A, x, b, P):
            thing.destroy()
        local[self._held] = 0.0  # to more digits than the tolerance leaves them
        return self._everywhere(local)

    def _row_scale(self) -> np.ndarray:
        """Makes the rows of the multipliers forces, as those of the solids are: norms add them."""
        stiffness = float(np.median(self._diagonal()))
        scale = np.ones(self._size)
        last = self._places.size
        for part in self._parts:
            speed = part.scales()[0][0] if len(part.active_places) else 1.0
            scale[last : last + part.multipliers] = stiffness * speed
            last += part.multipliers
        return scale

    def _diagonal(self) -> np.ndarray:
        """The diagonal of the solids' matrices, on every process."""
        rows = self._solid_rows()
        mine = self._places.mine
        return self._everywhere(rows.diagonal(k=mine.start))

    def _nodal_inverse(
        self, ym: sp.csr_matrix, my: sp.csr_matrix, mm: sp.csr_matrix
    ) -> sp.csr_matrix:
        """S^-1: the multipliers of each node by what is left of their rows."""
        springs = my @ sp.diags(SOFT / self._diagonal()) @ ym
        S = (mm - springs).tocsr()
        blocks, first = [], 0
        for part in self._parts:
            nodes, m = len(part.equations.candidates), part.multipliers
            k = m // nodes if nodes else 0
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
        system: Iterative,
        P: PETSc.Mat,
        onto: sp.csr_matrix,
        seen: sp.csr_matrix,
        inverse: sp.csr_matrix,
    ) -> None:
        comm, places = system.comm, system._places
        final = comm.rank == comm.size - 1
        self._n = n = places.mine.stop - places.mine.start
        m = inverse.shape[0] if final else 0
        own = slice(0, m)
        self._onto = petsc_matrix(onto.tocsr()[places.mine], comm, columns=m)
        self._seen = petsc_matrix(seen.tocsr()[own], comm, columns=n)
        self._inverse = petsc_matrix(inverse[own], comm)
        self._P = P
        P.setBlockSize(system._solids[0].dim)
        P.setNearNullSpace(_null_space(P, system._modes))
        self._multigrid = pc = PETSc.PC().create(comm)
        pc.setOptionsPrefix("multigrid_")
        pc.setType("gamg")
        pc.setOperators(P)
        pc.setFromOptions()
        pc.setUp()
        self._v, self._r = P.createVecs()
        self._m, self._f = self._inverse.createVecs()
        self._g = self._f.duplicate()

    def apply(self, pc: PETSc.PC, x: PETSc.Vec, y: PETSc.Vec) -> None:
        """y = P^-1 x."""
        both = x.array_r
        self._f.setArray(both[self._n :])
        self._onto.mult(self._f, self._r)
        self._r.setArray(both[: self._n] - self._r.array_r)
        self._multigrid.apply(self._r, self._v)
        self._inverse.mult(self._f, self._m)
        self._seen.mult(self._v, self._g)
        y.setArray(np.concatenate([self._v.array_r, self._m.array_r - self._g.array_r]))


def _rigid_modes(solid: DeformableSolid) -> np.ndarray:
    """Rigid motions at the owned unknowns, (owned, 3 or 6)."""
    d = solid.dim
    x = solid.space.tabulate_dof_coordinates()[: solid.owned // d, :d]
    pairs = [(i, j) for i in range(d) for j in range(i)]
    modes = np.zeros((len(x), d, d + len(pairs)))
    modes[:, range(d), range(d)] = 1.0
    for k, (i, j) in enumerate(pairs):
        modes[:, i, d + k], modes[:, j, d + k] = -x[:, j], x[:, i]
    return modes.reshape(len(x) * d, -1)


def _null_space(matrix: PETSc.Mat, modes: np.ndarray) -> PETSc.NullSpace:
    """The modes, made orthonormal."""
    vectors = []
    for column in modes.T:
        vector = matrix.createVecRight()
        vector.setArray(column)
        for other in vectors:
            vector.axpy(-vector.dot(other), other)
        vector.normalize()
        vectors.append(vector)
    return PETSc.NullSpace().create(vectors=vectors, comm=matrix.comm)
