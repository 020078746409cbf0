# SPDX-License-Identifier: LGPL-3.0-or-later
"""The viscous stress of a hyperelastic solid, see :class:`~.damping.KelvinVoigt`."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from ..base import assembly
from ..theory.theta import Step
from .energies import Energy, in_space
from .vector_space import VectorSpace


class ViscousStress:
    """A damper. Its dissipation ``v' C(u) v`` is beta times the second variation of the stored
    energy at rest in the direction of the rate E' = sym(F' grad v) of the strain at u.

    Args:
        vectors: the space of displacements.
        energy: stored energy density.
        beta: s.
        measure: of the volume.
    """

    def __init__(
        self, vectors: VectorSpace, energy: Energy, beta: float, measure: ufl.Measure
    ) -> None:
        self._vectors, space, d = vectors, vectors.space, vectors.dim
        self._displacement, self._rate, rest = (fem.Function(space) for _ in range(3))
        F = ufl.Identity(d) + ufl.grad(self._displacement)
        strain_rate = ufl.sym(F.T * ufl.grad(rest))  # zero: at rest
        at_rest = energy(in_space(ufl.Identity(d) + strain_rate)) * measure
        v, dv = ufl.TestFunction(space), ufl.TrialFunction(space)
        second = ufl.derivative(ufl.derivative(at_rest, rest, v), rest, dv)
        weight = fem.Constant(vectors.mesh.mesh, beta)
        self._force_form = fem.form(weight * ufl.action(second, self._rate))
        self._matrix_form = fem.form(weight * second)
        self._matrix = assembly.assemble_petsc_matrix(self._matrix_form)

    def _points(self, step: Step, start: np.ndarray, end: np.ndarray) -> Iterator[float]:
        """Put the solid where the scheme takes forces; the weights there, 1 in sum."""
        for share, weight in step.scheme.force_points:
            self._vectors.assign(self._displacement, share * end + (1 - share) * start)
            yield weight / step.load_weight

    def force(self, step: Step, start: np.ndarray, end: np.ndarray, rate: np.ndarray) -> np.ndarray:
        self._vectors.assign(self._rate, rate)
        total, part = np.zeros((2, len(rate)))
        for weight in self._points(step, start, end):
            assembly.assemble_owned(self._force_form, part)
            total += weight * part
        return total

    def add_to(self, matrix: PETSc.Mat, step: Step, start: np.ndarray, end: np.ndarray) -> None:
        for weight in self._points(step, start, end):
            self._matrix.zeroEntries()
            assembly.add_to_petsc_matrix(self._matrix, self._matrix_form)
            subset = PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN
            matrix.axpy(step.rate_weight * weight, self._matrix, subset)
