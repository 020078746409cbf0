# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a mesh in the plane stands for: a slice in plane strain or plane stress, 1 m thick, or half
the section of a solid of revolution, x being the radius and y the axis."""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl

from ..base import checks
from ..base.constants import SAME
from ..base.quoted import quoted
from ..base.vectors import largest
from .energies import in_space
from .vector_space import VectorSpace


class Whole:
    """A solid in space, or in plane strain: what the mesh is.

    Attributes:
        revolution: whether the mesh is half a section of a solid of revolution.
        resisted: numbers of the rigid motions of the mesh that strain the solid.
    """

    revolution = False
    resisted: tuple[int, ...] = ()
    #: For descriptions.
    name = ""

    def lame(self, E: Any, nu: Any) -> tuple[Any, Any]:
        """lambda and mu, Pa, from Young's modulus [Pa] and Poisson's ratio."""
        return E * nu / (1 + nu) / (1 - 2 * nu), E / 2 / (1 + nu)

    def gradient(self, w: Any, x: Any) -> Any:
        """Gradient of a field w at x, in UFL: (d, d), or (3, 3) with what is across the mesh."""
        return ufl.grad(w)

    def across(self, lmbda: Any, strain: Any) -> Any:
        """Stress across the plane."""
        return lmbda * ufl.tr(strain)

    def stretched(self, energy: Any, F: Any) -> Any:
        """The deformation gradient of a solid with a stored energy, from that with 1 across the
        mesh; both (3, 3)."""
        return F

    def energy(self, energy: Any) -> Any:
        """The stored energy by that with 1 across the mesh."""
        return energy

    def breadth(self, x: Any) -> Any:
        """How much of the solid a point of the mesh stands for: m across the plane, over 1 m."""
        return 1

    def axis(self, vectors: VectorSpace) -> np.ndarray:
        """The owned nodes that may not leave the axis of revolution."""
        return np.empty(0, dtype=np.int64)


class PlaneStress(Whole):
    """No stress across the plane: lambda is E nu/(1 - nu²); of a stored energy the stretch across
    is eliminated."""

    name = "plane stress, "

    def lame(self, E: Any, nu: Any) -> tuple[Any, Any]:
        return E * nu / (1 - nu**2), E / 2 / (1 + nu)

    def across(self, lmbda: Any, strain: Any) -> Any:
        return 0

    def stretched(self, energy: Any, F: Any) -> Any:
        return in_space(
            ufl.as_matrix([[F[i, j] for j in range(2)] for i in range(2)]), energy.across(F)
        )

    def energy(self, energy: Any) -> Any:
        if not hasattr(energy, "across"):
            raise checks.InputError(
                f"plane = 'stress': energy = {quoted(energy)} does not tell its stretch across the "
                "plane; neo_hookean, ciarlet and st_venant_kirchhoff do"
            )
        return lambda F: energy(self.stretched(energy, F))


class Axisymmetric(Whole):
    """A solid of revolution, whole: forces in N, energies in J, masses in kg. The gradient round
    the axis is u_r/r, on it that along r. (O. C. Zienkiewicz, R. L. Taylor, The Finite Element
    Method I, chapter 5.)"""

    name = "axisymmetric, "
    revolution = True
    resisted = (0, 2)  # moving along r, turning

    def gradient(self, w: Any, x: Any) -> Any:
        g = ufl.grad(w)
        hoop = ufl.conditional(ufl.gt(x[0], 0), w[0] / x[0], g[0, 0])
        return in_space(g, hoop)

    def breadth(self, x: Any) -> Any:
        return 2 * np.pi * x[0]

    def axis(self, vectors: VectorSpace) -> np.ndarray:
        radius, comm = vectors.places[:, 0], vectors.comm
        size = max(comm.allgather(largest(radius)))
        least = min(comm.allgather(float(radius.min(initial=np.inf))))
        if least < -SAME * size:
            raise checks.InputError(
                f"plane = 'axisymmetric': x is the radius, and must be >= 0; the mesh has {least:g}"
            )
        if largest(vectors.periods[:, 0]) > SAME * size:
            raise checks.InputError(
                "periodic: a solid of revolution may repeat itself along its axis, not along x"
            )
        return np.flatnonzero(radius <= SAME * size)


#: What a mesh in the plane may stand for.
PLANES = {"strain": Whole(), "stress": PlaneStress(), "axisymmetric": Axisymmetric()}
