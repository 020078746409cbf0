# SPDX-License-Identifier: LGPL-3.0-or-later
"""Internal forces of a hyperelastic solid whose stress is a mean over the way of the strain, see
:mod:`fenicsx_contact.theory.energy_momentum`."""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from ..base import assembly
from ..base.compiling import compiled
from ..theory.scheme import Step
from .deformable import DeformableSolid
from .energies import Energy, in_space


def second_stress(energy: Energy, C: Any) -> Any:
    """``S = 2 W_C`` at a strain C, (d, d): the energy knows C by any F with F' F = C, of which the
    triangular one needs no rotation."""
    C = ufl.variable(C)
    return 2 * ufl.sym(ufl.diff(energy(in_space(_triangular(C))), C))


def _triangular(C: Any) -> Any:
    """The upper triangular U with U' U = C (Cholesky)."""
    d = C.ufl_shape[0]
    U = [[ufl.as_ufl(0.0) for _ in range(d)] for _ in range(d)]
    for i in range(d):
        U[i][i] = ufl.sqrt(C[i, i] - sum(U[k][i] ** 2 for k in range(i)))
        for j in range(i + 1, d):
            U[i][j] = (C[i, j] - sum(U[k][i] * U[k][j] for k in range(i))) / U[i][i]
    return ufl.as_matrix(U)


class StrainWay:
    """Forces of a step, and their tangent.

    Args:
        solid: whose they are.
        energy: its stored energy density.
        measure: of the volume.
    """

    def __init__(self, solid: DeformableSolid, energy: Energy, measure: ufl.Measure) -> None:
        self._vectors, space, mesh = solid.vectors, solid.space, solid.mesh.mesh
        self._start, self._end = fem.Function(space), fem.Function(space)
        self._share, self._weight = fem.Constant(mesh, 0.0), fem.Constant(mesh, 1.0)
        v, du = ufl.TestFunction(space), ufl.TrialFunction(space)
        before, after = (
            ufl.Identity(gradient.ufl_shape[0]) + gradient
            for gradient in map(solid.gradient, (self._start, self._end))
        )
        C = (1 - self._share) * before.T * before + self._share * after.T * after
        stress = (before + after) / 2 * second_stress(energy, C)
        work = ufl.inner(stress, solid.gradient(v))
        residual = self._weight * solid.breadth * work * measure
        self._force_form = compiled(residual)
        self._tangent_form = compiled(ufl.derivative(residual, self._end, du))

    def force(self, step: Step, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        """The mean force of a step between two displacements, of the owned unknowns, N."""
        self._vectors.assign(self._start, start)
        self._vectors.assign(self._end, end)
        self._weight.value = 1.0
        return step.mean_force(self._at)

    def _at(self, share: float) -> np.ndarray:
        self._share.value, force = share, np.empty(self._vectors.owned)
        assembly.assemble_owned(self._force_form, force)
        return force

    def add_tangent(
        self, matrix: PETSc.Mat, step: Step, start: np.ndarray, end: np.ndarray
    ) -> None:
        """Add the derivative of the force by the displacement at the end, not symmetric."""
        self._vectors.assign(self._start, start)
        self._vectors.assign(self._end, end)
        for self._share.value, self._weight.value in step.scheme.force_points:
            assembly.add_to_petsc_matrix(matrix, self._tangent_form)
