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

    def plus(self, more: PETSc.Mat) -> PETSc.Mat:
        """The sum with a matrix, which it keeps, and which may have further rows and columns behind
        those of each process."""
        context, sizes = _Sum(self.matrix, more), more.getSizes()
        total = PETSc.Mat().createPython(sizes, context, comm=more.comm)
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
    def __init__(self, solids: PETSc.Mat, more: PETSc.Mat) -> None:
        self._solids, self._more, self._n = solids, more, solids.getLocalSize()[0]
        self._x, self._y = solids.createVecs()

    def mult(self, matrix: PETSc.Mat, x: PETSc.Vec, y: PETSc.Vec) -> None:
        """y = (solids + more) x."""
        self._more.mult(x, y)
        self._x.setArray(x.array_r[: self._n])
        self._solids.mult(self._x, self._y)
        y.array_w[: self._n] += self._y.array_r

    def getDiagonal(self, matrix: PETSc.Mat, diagonal: PETSc.Vec) -> None:
        """That of the sum."""
        self._more.getDiagonal(diagonal)
        self._solids.getDiagonal(self._y)
        diagonal.array_w[: self._n] += self._y.array_r

    def destroy(self, matrix: PETSc.Mat) -> None:
        """Free what the sum alone has."""
        for thing in (self._more, self._x, self._y):
            thing.destroy()
