# SPDX-License-Identifier: LGPL-3.0-or-later
"""The matrix of all solids for Krylov methods: held once, whatever contacts add to it.

What contacts add changes with each correction and reaches few unknowns; the solids' matrix is most
of the memory, and does not change while they are linear. So sums are never formed: a product with
one is that of both.
"""

from __future__ import annotations

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from .solid_rows import SolidRows, petsc_matrix


class SolidMatrix:
    """That of the rows in their present linearisation.

    Attributes:
        matrix: PETSc's.
        of: the solids' linearisations.
    """

    def __init__(self, rows: SolidRows, comm: MPI.Comm) -> None:
        self.of = rows.now()
        self.matrix = petsc_matrix(rows(), comm)
        rows.forget()

    def plus(self, more: PETSc.Mat, at: np.ndarray) -> PETSc.Mat:
        """The sum with a matrix, which it keeps, of those rows and columns ``at`` which each
        process has; behind those of the solids there may be further ones."""
        n = self.matrix.getLocalSize()[0]
        sizes = max(n, int(at[-1]) + 1 if len(at) else 0), PETSc.DECIDE
        total = PETSc.Mat().createPython((sizes, sizes), _Sum(self.matrix, more, at), more.comm)
        total.setUp()
        return total

    def diagonal(self) -> np.ndarray:
        """This process's part of its diagonal."""
        diagonal = self.matrix.getDiagonal()
        local = diagonal.array_r.copy()
        diagonal.destroy()
        return local

    def destroy(self) -> None:
        """Free what PETSc holds, when nothing refers to it any more."""
        self.matrix.destroy()


class _Sum:
    def __init__(self, solids: PETSc.Mat, more: PETSc.Mat, at: np.ndarray) -> None:
        self._solids, self._more, self._at = solids, more, at
        self._n = solids.getLocalSize()[0]
        self._x, self._y = solids.createVecs()
        self._u, self._v = more.createVecs()

    def mult(self, matrix: PETSc.Mat, x: PETSc.Vec, y: PETSc.Vec) -> None:
        """y = (solids + more) x."""
        given = x.array_r
        self._x.setArray(given[: self._n])
        self._u.setArray(given[self._at])
        self._solids.mult(self._x, self._y)
        self._more.mult(self._u, self._v)
        self._add(y)

    def getDiagonal(self, matrix: PETSc.Mat, diagonal: PETSc.Vec) -> None:
        """That of the sum."""
        self._solids.getDiagonal(self._y)
        self._more.getDiagonal(self._v)
        self._add(diagonal)

    def _add(self, result: PETSc.Vec) -> None:
        values = result.array_w
        values[: self._n], values[self._n :] = self._y.array_r, 0.0
        values[self._at] += self._v.array_r

    def destroy(self, matrix: PETSc.Mat) -> None:
        """Free what the sum alone has."""
        for thing in (self._more, self._x, self._y, self._u, self._v):
            thing.destroy()
