# SPDX-License-Identifier: LGPL-3.0-or-later
"""The viscous stress of a hyperelastic solid, see :class:`~.damping.KelvinVoigt`."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from ..base import assembly
from ..base.compiling import compiled
from ..theory.scheme import Step
from .deformable import DeformableSolid
from .energies import Energy, deformation


class ViscousStress:
    """A damper. Its dissipation ``v' C(u) v`` is twice beta times the energy that a small strain E'
    would store at rest, E' = sym(F' grad v) being the rate of the strain at u.

    It is taken at one place of the way of a step. In the middle, with theta = 1/2, E' is the change
    of the strain over dt, so that a step of a rotation is not damped.

    Args:
        solid: whose it is.
        energy: its stored energy density.
        time: beta, s.
        measure: of the volume.

    Attributes:
        form: its force, a linear form.
    """

    number = "beta"

    def __init__(
        self, solid: DeformableSolid, energy: Energy, time: float, measure: ufl.Measure
    ) -> None:
        self.time = time
        self._vectors, space = solid.vectors, solid.space
        self._displacement, self._rate, rest = (fem.Function(space) for _ in range(3))
        gradient = solid.gradient(self._displacement)
        F = ufl.Identity(gradient.ufl_shape[0]) + gradient
        strain_rate = ufl.sym(F.T * solid.gradient(rest))  # zero: at rest
        at_rest = solid.breadth * energy(deformation(strain_rate)) * measure
        v, dv = ufl.TestFunction(space), ufl.TrialFunction(space)
        second = ufl.derivative(ufl.derivative(at_rest, rest, v), rest, dv)
        weight = fem.Constant(solid.mesh.mesh, time)
        self.form = weight * ufl.action(second, self._rate)
        self._force_form = compiled(self.form)
        self._matrix_form = compiled(weight * second)
        self._matrix = assembly.assemble_petsc_matrix(self._matrix_form)

    def _place(self, step: Step, start: np.ndarray, end: np.ndarray) -> None:
        share = step.force_share
        self._vectors.assign(self._displacement, share * end + (1 - share) * start)

    def force(self, step: Step, start: np.ndarray, end: np.ndarray, rate: np.ndarray) -> np.ndarray:
        self._place(step, start, end)
        self._vectors.assign(self._rate, rate)
        force = np.empty(len(rate))
        assembly.assemble_owned(self._force_form, force)
        return force

    def add_to(self, matrix: PETSc.Mat, step: Step, start: np.ndarray, end: np.ndarray) -> None:
        self._place(step, start, end)
        self._matrix.zeroEntries()
        assembly.add_to_petsc_matrix(self._matrix, self._matrix_form)
        matrix.axpy(step.rate_weight, self._matrix, PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)

    def add_bent(self, matrix: PETSc.Mat, place: np.ndarray, rate: np.ndarray) -> None:
        self.set(place, rate)
        assembly.add_to_petsc_matrix(matrix, self._bent_form)

    @cached_property
    def _bent_form(self) -> Any:
        way = ufl.TrialFunction(self._vectors.space)
        return compiled(ufl.derivative(self.form, self._displacement, way))

    def set(self, place: np.ndarray, rate: np.ndarray) -> None:
        """Set the displacement and the velocity of the form."""
        self._vectors.assign(self._displacement, place)
        self._vectors.assign(self._rate, rate)
