# SPDX-License-Identifier: LGPL-3.0-or-later
"""Size, centre and second moments of a meshed shape."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import ufl
from dolfinx import fem

from ..base import assembly
from ..base.compiling import compiled
from ..base.mesh import NamedMesh


def moments(mesh: NamedMesh) -> tuple[float, np.ndarray, np.ndarray]:
    """Size [m^d], centre (d,) [m] and second moments about the centre (d, d) [m^(d+2)].

    One form for all: a polynomial whose coefficients are constants.
    """
    domain, d = mesh.mesh, mesh.dim
    pairs = list(combinations_with_replacement(range(d), 2))
    coefficients = fem.Constant(domain, np.zeros(1 + d + len(pairs)))
    origin = fem.Constant(domain, np.zeros(d))
    y = ufl.SpatialCoordinate(domain) - origin
    terms = [1, *(y[i] for i in range(d)), *(y[i] * y[j] for i, j in pairs)]
    exact = (d + 2) * mesh.degree - 1  # two coordinates and the Jacobian's determinant
    dx = ufl.Measure("dx", domain=domain, metadata={"quadrature_degree": exact})
    form = compiled(sum(coefficients[k] * term for k, term in enumerate(terms)) * dx)

    def integral(term: int) -> float:
        coefficients.value[:] = 0.0
        coefficients.value[term] = 1.0
        return assembly.assemble_scalar(form, domain.comm)

    size = integral(0)
    # first about the origin of coordinates, then about what that gives: far away digits cancel
    centre = np.zeros(d)
    for _ in range(2):
        origin.value[:] = centre
        centre = centre + np.array([integral(1 + i) for i in range(d)]) / size
    origin.value[:] = centre
    second = np.zeros((d, d))
    for k, (i, j) in enumerate(pairs):
        second[i, j] = second[j, i] = integral(1 + d + k)
    return size, centre, second
