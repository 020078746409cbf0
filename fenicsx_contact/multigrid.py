# SPDX-License-Identifier: LGPL-3.0-or-later
"""Smoothed-aggregation multigrid for elasticity: PETSc's, which is told the rigid-body modes."""

from __future__ import annotations

import numpy as np
from petsc4py import PETSc

from .solids import DeformableSolid


class Multigrid:
    """A multigrid cycle for a matrix, which it owns; PETSc options have the prefix
    ``multigrid_``.

    Args:
        matrix: symmetric or nearly so.
        modes: rigid motions at this process's unknowns, (n, 3 or 6).
        block: unknowns of a node.
    """

    def __init__(self, matrix: PETSc.Mat, modes: np.ndarray, block: int) -> None:
        self._matrix = matrix
        matrix.setBlockSize(block)
        matrix.setNearNullSpace(_null_space(matrix, modes))
        self._cycle = PETSc.PC().create(matrix.comm)
        self._cycle.setOptionsPrefix("multigrid_")
        self._cycle.setType("gamg")
        self._cycle.setOperators(matrix)
        self._cycle.setFromOptions()
        self._cycle.setUp()

    def apply(self, right: PETSc.Vec, left: PETSc.Vec) -> None:
        """One cycle from zero for the right side."""
        self._cycle.apply(right, left)

    def destroy(self) -> None:
        """Free what PETSc holds."""
        self._cycle.destroy()
        self._matrix.destroy()


def rigid_modes(solid: DeformableSolid) -> np.ndarray:
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
    vectors: list[PETSc.Vec] = []
    for column in modes.T:
        vector = matrix.createVecRight()
        vector.setArray(column)
        for other in vectors:
            vector.axpy(-vector.dot(other), other)
        vector.normalize()
        vectors.append(vector)
    return PETSc.NullSpace().create(vectors=vectors, comm=matrix.comm)
