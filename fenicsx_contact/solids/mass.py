# SPDX-License-Identifier: LGPL-3.0-or-later
"""The mass of a deformable solid: its matrix, its weight, and means over it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from math import sqrt
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from ..base import assembly
from ..base.compiling import compiled
from .coefficients import Scalar, constant, scalar
from .mass_redistribution import move_mass_inwards
from .vector_space import VectorSpace


class Mass:
    """The mass of a solid.

    Args:
        vectors: the space of its velocities.
        density: kg/m³: a number, or a field, see :mod:`~.coefficients`.
        massless: names of facets whose mass is moved inwards.
        fixed: the unknowns that are held, which take no mass.
        breadth: what the plane stands for, in UFL.

    Attributes:
        density, told: the density as a number or in UFL, and as a text.
        matrix: M, kg.
        massless: the unknowns without mass that this process owns.

    Raises:
        InputError: no positive density, a name that the mesh lacks, mass that cannot be moved.
    """

    def __init__(
        self,
        vectors: VectorSpace,
        density: Scalar,
        massless: Sequence[str],
        fixed: np.ndarray,
        breadth: Any,
    ) -> None:
        self._vectors, mesh = vectors, vectors.mesh.mesh
        self.density, self.told = scalar("density", density, vectors.mesh, {}, above=0)
        self._rho = breadth * constant(vectors.mesh, self.density)
        self._dx = ufl.Measure("dx", domain=mesh)
        u, v = ufl.TrialFunction(vectors.space), ufl.TestFunction(vectors.space)
        self.matrix = assembly.assemble_petsc_matrix(self._rho * ufl.dot(u, v) * self._dx)
        nodes = vectors.nodes_of(massless, "mass_redistribution")
        self._moved = vectors.comm.allreduce(len(nodes)) > 0
        if self._moved:
            move_mass_inwards(vectors, self.matrix, nodes, fixed)
        self.massless = vectors.at(nodes)

    def weight(self, acceleration: np.ndarray) -> np.ndarray:
        """The load of a uniform acceleration, (owned,) in N; it acts where mass is."""
        if self._moved:
            return self.times(np.tile(acceleration, self._vectors.owned // self._vectors.dim))
        g, v = fem.Constant(self._vectors.mesh.mesh, acceleration), self._vectors.space
        load = np.zeros(self._vectors.owned)
        form = self._rho * ufl.dot(g, ufl.TestFunction(v)) * self._dx
        assembly.assemble_owned(compiled(form), load)
        return load

    def times(self, velocity: np.ndarray) -> np.ndarray:
        """M v: momenta of velocities, forces of accelerations, of the owned unknowns."""
        return self._vectors.multiply(self.matrix, velocity)

    @cached_property
    def total(self) -> float:
        """kg (kg/m in 2D)."""
        uniform = np.zeros(self._vectors.owned)
        uniform[:: self._vectors.dim] = 1.0
        return self._vectors.sum(uniform @ self.times(uniform))

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Mean of a field over the mass, (d,)."""
        weighted, d = self.times(values), self._vectors.dim
        return np.array([self._vectors.sum(weighted[k::d].sum()) for k in range(d)]) / self.total

    def root_mean_square(self, values: np.ndarray) -> float:
        """Of a field over the mass."""
        square = self._vectors.sum(values @ self.times(values)) / self.total
        return sqrt(max(square, 0.0))  # not a round-off of zero

    def shortest_time(self, stiffness: PETSc.Mat) -> float:
        """1/omega of the unknown that its neighbours at rest hold most stiffly, s; infinite where
        nothing is stiff."""
        mass, held = (self._vectors.diagonal(matrix) for matrix in (self.matrix, stiffness))
        squares = np.where(mass > 0, held, 0.0) / np.where(mass > 0, mass, 1.0)
        square = max(self._vectors.comm.allgather(float(squares.max(initial=0.0))))
        return 1 / sqrt(square) if square > 0 else np.inf
