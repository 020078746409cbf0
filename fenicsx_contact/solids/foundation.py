# SPDX-License-Identifier: LGPL-3.0-or-later
"""Elastic springs between a solid and the ground (a foundation after E. Winkler, 1867)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from ..base import assembly, checks
from ..base.quoted import quoted
from .locations import Location, is_surface, nodes_at
from .vector_space import VectorSpace

#: A stiffness for all directions, or one for each.
Stiffness = float | Sequence[float]


class Foundation:
    """Springs without mass, which rest where the solid has no displacement.

    Args:
        vectors: the space of displacements.
        springs: stiffness by location: of named facets N/m per reference area (Pa/m), else N/m of
            each node there.
        breadth: what the plane stands for, in UFL.

    Attributes:
        matrix: S, N/m.
        told: the springs, as a text.
        stiffest: the largest stiffness of an unknown, N/m.
        directions: whether any spring acts in each direction, (d,).

    Raises:
        InputError: stiffness < 0, or none at all; a location that the mesh lacks.
    """

    def __init__(
        self, vectors: VectorSpace, springs: Mapping[Location, Stiffness], breadth: Any
    ) -> None:
        self._vectors, mesh, d = vectors, vectors.mesh, vectors.dim
        u, v = ufl.TrialFunction(vectors.space), ufl.TestFunction(vectors.space)
        surfaces = [where for where in springs if is_surface(vectors, where)]
        for where in surfaces:
            vectors.facets(str(where), "springs")
        over = dict(zip(surfaces, mesh.measures(*map(str, surfaces))))
        nothing = fem.Constant(mesh.mesh, 0.0)  # the pattern of all other matrices
        form = nothing * ufl.dot(u, v) * ufl.dx(mesh.mesh)
        points = np.zeros(vectors.owned)
        told = []
        for where, stiffness in springs.items():
            what = f"springs[{where!r}]"
            by_direction = self._stiffness(what, stiffness)
            told.append(f"{where!r}: {by_direction.tolist()}")
            if where in over:
                k = fem.Constant(mesh.mesh, by_direction)
                resisting = sum(k[i] * u[i] * v[i] for i in range(d))
                form += breadth * resisting * over[where]
            else:
                nodes = nodes_at(vectors, where, what)
                points[vectors.at(nodes)] += np.tile(by_direction, len(nodes))
        self.told = ", ".join(told)
        self.matrix = assembly.assemble_petsc_matrix(form)
        diagonal = self.matrix.getDiagonal()
        diagonal.setArray(diagonal.array_r + points)
        self.matrix.setDiagonal(diagonal)
        diagonal.destroy()
        resisting = vectors.diagonal(self.matrix)
        self.stiffest = max(vectors.comm.allgather(float(resisting.max(initial=0.0))))
        there = resisting.reshape(-1, d).any(axis=0)
        self.directions = np.any(vectors.comm.allgather(there), axis=0)
        if not self.directions.any():
            raise checks.InputError(f"springs = {quoted(springs)}: none of them holds anything")

    def _stiffness(self, what: str, given: Any) -> np.ndarray:
        d = self._vectors.dim
        if np.ndim(checks.plain(given)) == 0:
            return np.full(d, checks.number(what, given, at_least=0))
        return np.array([checks.number(what, k, at_least=0) for k in checks.vector(what, given, d)])

    def add_to(self, matrix: PETSc.Mat, weight: float) -> None:
        """Add the stiffness to a matrix of the space."""
        matrix.axpy(weight, self.matrix, PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)

    def times(self, displacement: np.ndarray) -> np.ndarray:
        """The force against a displacement, of the owned unknowns, N."""
        return self._vectors.multiply(self.matrix, displacement)
