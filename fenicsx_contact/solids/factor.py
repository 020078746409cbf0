# SPDX-License-Identifier: LGPL-3.0-or-later
"""Linear solves with the matrix of a solid: factored once, solved many times.

Everything else about a linear solid happens on the contact points: its compliance there,
``W = J A^-1 J'`` (the Delassus operator), is formed once for each factorisation, and the Newton
loop is dense and as small as the surface.
"""

from __future__ import annotations

import re

import numpy as np
import scipy.sparse as sp
from petsc4py import PETSc

#: Cost: nonzeros above which a matrix is factored by MUMPS: some 50 000 unknowns in the plane.
LARGE = 1e6


def direct_solver(matrix: PETSc.Mat, prefix: str, package: str = "mumps") -> PETSc.KSP:
    """A direct solver for any regular matrix, with PETSc options of the prefix."""
    solver = PETSc.KSP().create(matrix.comm)
    solver.setOptionsPrefix(re.sub(r"\W+", "_", prefix) + "_")
    solver.setType("preonly")
    solver.getPC().setType("lu")
    solver.getPC().setFactorSolverType(package)
    solver.setOperators(matrix)
    solver.setFromOptions()
    return solver


class Factorisation:
    """A direct factorisation of a PETSc matrix, which it owns.

    Its PETSc options have the prefix ``<name>_``, so that ``-<name>_pc_factor_mat_solver_type``
    and the like choose another solver.
    """

    def __init__(self, matrix: PETSc.Mat, name: str) -> None:
        self._matrix = matrix
        # PETSc's own LU solves in a third of the time of MUMPS, which scales in factoring
        large = matrix.comm.size > 1 or matrix.getInfo()["nz_used"] > LARGE
        self._solver = direct_solver(matrix, name, "mumps" if large else "petsc")
        self._x, self._b = matrix.createVecs()

    def solve(self, values: np.ndarray) -> np.ndarray:
        """A^-1 times the owned part of a vector."""
        self._b.setArray(values)
        self._solver.solve(self._b, self._x)
        if self._solver.getConvergedReason() < 0:
            return np.full_like(values, np.nan)
        return self._x.array_r.copy()

    def solve_many(self, columns: sp.csc_matrix) -> np.ndarray:
        """A^-1 times the owned parts of sparse columns (n, k), dense."""
        n, k = columns.shape
        if self._matrix.comm.size > 1 or k == 1:
            return np.stack([self.solve(columns[:, [i]].toarray().ravel()) for i in range(k)], 1)
        self._solver.setUp()
        right = PETSc.Mat().createDense((n, k), comm=self._matrix.comm)
        left = PETSc.Mat().createDense((n, k), comm=self._matrix.comm)
        right.setUp()
        left.setUp()
        right.getDenseArray()[:] = columns.toarray()
        right.assemble()
        left.assemble()
        self._solver.getPC().getFactorMatrix().matSolve(right, left)
        result = left.getDenseArray().copy()
        right.destroy()
        left.destroy()
        return result

    def refactor(self) -> None:
        """The matrix has new values; it is factored when it is next needed."""
        self._solver.setOperators(self._matrix)

    @property
    def matrix(self) -> PETSc.Mat:
        """The matrix; after changing its values call :meth:`refactor`."""
        return self._matrix

    def destroy(self) -> None:
        """Free what PETSc holds."""
        for thing in (self._solver, self._matrix, self._x, self._b):
            thing.destroy()
