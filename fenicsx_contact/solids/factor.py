# SPDX-License-Identifier: LGPL-3.0-or-later
"""Linear solves with the matrix of a solid: factored once, solved many times.

Everything else about a linear solid happens on the contact points: its compliance there,
``W = J A^-1 J'`` (the Delassus operator), is formed once for each factorisation, and the Newton
loop is dense and as small as the surface.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import scipy.sparse as sp
from petsc4py import PETSc

#: Cost: nonzeros above which a matrix is factored by MUMPS, in the plane (some 50 000 unknowns) and
#: in space (6000), where it solves for many columns in a fifth of the time of PETSc's own LU.
LARGE, LARGE_IN_SPACE = 1e6, 4e5
#: Cost: columns that are solved for at once.
AT_ONCE = 32

#: MUMPS' errors that stand for too little memory.
LACKS = (-8, -9)
#: Cost: the percentage by which MUMPS may need more memory than it estimates, at first.
ROOM = 20


class Direct:
    """A direct solver for any regular matrix, with PETSc options of a prefix.

    MUMPS estimates the memory that it needs; where that was too little it is asked again with twice
    the room, for a matrix is not singular because of that.
    """

    def __init__(self, matrix: PETSc.Mat, prefix: str, package: str = "mumps") -> None:
        self._matrix, self._prefix, self._package = matrix, re.sub(r"\W+", "_", prefix), package
        self._room = ROOM
        self._make()

    def _make(self) -> None:
        self._solver = solver = PETSc.KSP().create(self._matrix.comm)
        solver.setOptionsPrefix(self._prefix + "_")
        solver.setType("preonly")
        solver.setOperators(self._matrix)
        solver.getPC().setType("lu")
        solver.getPC().setFactorSolverType(self._package)
        solver.getPC().setFactorPivot(0.0)  # PETSc's own bound, 2e-14, is of no unit
        solver.setFromOptions()
        if self.by_mumps and self._room != ROOM:
            solver.getPC().setFactorSetUpSolverType()
            solver.getPC().getFactorMatrix().setMumpsIcntl(14, self._room)

    @property
    def by_mumps(self) -> bool:
        """Whether MUMPS factors it."""
        return str(self._solver.getPC().getFactorSolverType()) == "mumps"

    def factor(self) -> bool:
        """Factor the matrix, if it has changed; False where MUMPS finds it singular."""
        self._solver.setUp()
        while (found := self._complaint()) in LACKS:
            self._room *= 2
            self._solver.destroy()
            self._make()
            self._solver.setUp()
        return found >= 0

    def _complaint(self) -> int:
        """MUMPS' error, negative; it must not be asked to solve after one."""
        return self._solver.getPC().getFactorMatrix().getMumpsInfog(1) if self.by_mumps else 0

    @property
    def entries(self) -> int:
        """Numbers that the factors hold, once they are made."""
        factors = self._solver.getPC().getFactorMatrix()
        if not self.by_mumps:
            return int(factors.getInfo()["nz_used"])
        size = int(factors.getMumpsInfog(9))
        return size if size >= 0 else -1_000_000 * size  # as MUMPS tells large ones

    def solve(self, right: PETSc.Vec, left: PETSc.Vec) -> bool:
        """Whether there is a solution."""
        if not self.factor():
            return False
        self._solver.solve(right, left)
        return bool(self._solver.getConvergedReason() >= 0)

    def solve_many(self, right: PETSc.Mat, left: PETSc.Mat) -> None:
        """For dense columns, on one process."""
        if self.factor():
            self._solver.getPC().getFactorMatrix().matSolve(right, left)
        else:
            left.getDenseArray()[:] = np.nan

    def refactor(self) -> None:
        """The matrix has new values; it is factored when it is next needed."""
        self._solver.setOperators(self._matrix)

    def destroy(self) -> None:
        """Free what PETSc holds."""
        self._solver.destroy()


class Factorisation:
    """A direct factorisation of a PETSc matrix, which it owns.

    Its PETSc options have the prefix ``<name>_``, so that ``-<name>_pc_factor_mat_solver_type``
    and the like choose another solver.
    """

    def __init__(self, matrix: PETSc.Mat, name: str) -> None:
        self._matrix = matrix
        # in the plane PETSc's own LU solves in a third of the time of MUMPS, which scales in
        # factoring
        most = LARGE_IN_SPACE if matrix.getBlockSize() == 3 else LARGE
        large = matrix.comm.size > 1 or matrix.getInfo()["nz_used"] > most
        self._solver = Direct(matrix, name, "mumps" if large else "petsc")
        self._x, self._b = matrix.createVecs()
        self._diagonal: np.ndarray | None = None

    def solve(self, values: np.ndarray) -> np.ndarray:
        """A^-1 times the owned part of a vector."""
        self._b.setArray(values)
        if not self._solver.solve(self._b, self._x):
            return np.full_like(values, np.nan)
        return self._x.array_r.copy()

    @property
    def together(self) -> int:
        """How many columns are solved for at once: what comes of one depends, to round-off, on the
        others."""
        return AT_ONCE if self._solver.by_mumps and self._matrix.comm.size == 1 else 1

    def solve_many(self, columns: Any) -> np.ndarray:
        """A^-1 times the owned parts of columns (n, k), dense or sparse; dense."""
        columns = columns.toarray() if sp.issparse(columns) else columns
        if self.together == 1:
            return np.stack([self.solve(column) for column in columns.T], axis=1)
        result = np.empty(columns.shape, order="F")
        for first in range(0, columns.shape[1], AT_ONCE):
            some = slice(first, first + AT_ONCE)
            result[:, some] = self._at_once(columns[:, some])
        return result

    def _at_once(self, columns: np.ndarray) -> np.ndarray:
        right, left = (
            PETSc.Mat().createDense(columns.shape, comm=self._matrix.comm) for _ in range(2)
        )
        for each in (right, left):
            each.setUp()
            each.assemble()
        right.getDenseArray()[:] = columns
        self._solver.solve_many(right, left)
        result = left.getDenseArray().copy()
        right.destroy()
        left.destroy()
        return result

    def refactor(self, resisting: np.ndarray | None = None) -> None:
        """The matrix has new values, and resists so what is free to move; it is factored when it is
        next needed."""
        self._diagonal = None
        self._solver.refactor()

    @property
    def diagonal(self) -> np.ndarray:
        """Of the matrix, the owned part."""
        if self._diagonal is None:
            self._matrix.getDiagonal(self._x)
            self._diagonal = self._x.array_r.copy()
        return self._diagonal

    @property
    def bytes(self) -> int:
        """That the factors hold, once they are made."""
        return 8 * self._solver.entries

    @property
    def matrix(self) -> PETSc.Mat:
        """The matrix; after changing its values call :meth:`refactor`."""
        return self._matrix

    def destroy(self) -> None:
        """Free what PETSc holds."""
        for thing in (self._solver, self._matrix, self._x, self._b):
            thing.destroy()
