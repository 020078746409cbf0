# SPDX-License-Identifier: LGPL-3.0-or-later
"""Multigrid for elastic solids tied by stiff springs: smoothed aggregation (PETSc's GAMG).

The springs of a contact must not choose the aggregates: these would grow across the surface and
could not slide, and the counts would grow with the mesh. So the transfers between the levels are
those of the solids alone, which are told their rigid motions; the springs are carried to the
coarser levels by them and added there. They reach few unknowns, so that costs little.
"""

from __future__ import annotations

import numpy as np
from petsc4py import PETSc

from ..solids import DeformableSolid


class Multigrid:
    """Multigrid cycles for a matrix and springs that change; PETSc options have the prefix
    ``multigrid_``.

    Args:
        matrix: of the solids, symmetric or nearly so.
        modes: rigid motions at this process's unknowns, (n, 3 or 6).
        block: unknowns of a node.
        touched: those of this process's unknowns that springs may touch.
    """

    def __init__(
        self, matrix: PETSc.Mat, modes: np.ndarray, block: int, touched: np.ndarray
    ) -> None:
        matrix.setBlockSize(block)
        matrix.setNearNullSpace(_null_space(matrix, modes))
        hierarchy = PETSc.PC().create(matrix.comm)
        hierarchy.setOptionsPrefix("multigrid_")
        hierarchy.setType("gamg")
        hierarchy.setOperators(matrix)
        hierarchy.setFromOptions()
        hierarchy.setUp()
        # from the finest level down
        below = range(hierarchy.getMGLevels() - 1, 0, -1)
        self._transfers = [hierarchy.getMGInterpolation(k) for k in below]
        self._coarser = [hierarchy.getMGSmoother(k - 1).getOperators()[0] for k in below]
        hierarchy.destroy()
        # springs go down from where they are; the others' rows would cost most of the time
        self._carriers = list(self._transfers)
        for finest in self._transfers[:1]:
            first, last = finest.getOwnershipRangeColumn()
            rows = PETSc.IS().createGeneral(touched.astype(np.int32), matrix.comm)
            columns = PETSc.IS().createStride(last - first, first, 1, matrix.comm)
            self._carriers[0] = finest.createSubMatrix(rows, columns)
            rows.destroy()
            columns.destroy()
        self._cycle: PETSc.PC | None = None
        self._levels: list[PETSc.Mat] = []

    def stiffen(self, matrix: PETSc.Mat, springs: PETSc.Mat) -> None:
        """Cycles are from now on for this matrix, solids and springs together, which it
        takes; the springs, of touched unknowns alone, are kept with it."""
        self._free()
        self._levels, passing = [matrix], []
        for carrier, solids in zip(self._carriers, self._coarser):
            springs = springs.ptap(carrier)
            level = solids.copy()
            level.axpy(1.0, springs, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
            self._levels.append(level)
            passing.append(springs)
        for each in passing:
            each.destroy()
        self._cycle = cycle = PETSc.PC().create(matrix.comm)
        cycle.setOptionsPrefix("multigrid_")
        cycle.setType("mg")
        top = len(self._transfers)
        cycle.setMGLevels(top + 1)
        cycle.setMGCycleType(PETSc.PC.MGCycleType.W)  # V: 16 -> 13 cycles at 1e5 unknowns
        for k, transfer in enumerate(self._transfers):
            cycle.setMGInterpolation(top - k, transfer)
        for k, level in enumerate(self._levels):
            smoother = cycle.getMGSmoother(top - k)
            smoother.setOperators(level)
            if k < top:
                smoother.setType("chebyshev")
                smoother.getPC().setType("jacobi")
        cycle.setOperators(matrix)
        cycle.setFromOptions()
        cycle.setUp()

    def apply(self, right: PETSc.Vec, left: PETSc.Vec) -> None:
        """One cycle from zero for the right side."""
        assert self._cycle is not None
        self._cycle.apply(right, left)

    def _free(self) -> None:
        for thing in (self._cycle, *self._levels):
            if thing is not None:
                thing.destroy()

    def destroy(self) -> None:
        """Free what PETSc holds."""
        self._free()
        for thing in (*self._carriers[:1], *self._transfers, *self._coarser):
            thing.destroy()


def rigid_modes(solid: DeformableSolid) -> np.ndarray:
    """Rigid motions at the owned unknowns, (owned, 3 or 6)."""
    d, x = solid.dim, solid.vectors.places
    pairs = [(i, j) for i in range(d) for j in range(i)]
    modes = np.zeros((len(x), d, d + len(pairs)))
    modes[:, range(d), range(d)] = 1.0
    for k, (i, j) in enumerate(pairs):
        modes[:, i, d + k], modes[:, j, d + k] = -x[:, j], x[:, i]
    return modes.reshape(len(x) * d, -1)


def _null_space(matrix: PETSc.Mat, modes: np.ndarray) -> PETSc.NullSpace:
    """The modes, made orthonormal."""
    vectors: list[PETSc.Vec] = []
    for column in modes.T:
        vector = matrix.createVecRight()
        vector.setArray(column)
        for other in vectors:
            vector.axpy(-vector.dot(other), other)
        vector.normalize()
        vectors.append(vector)
    return PETSc.NullSpace().create(vectors=vectors, comm=matrix.comm)
