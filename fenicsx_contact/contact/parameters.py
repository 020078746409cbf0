# SPDX-License-Identifier: LGPL-3.0-or-later
"""Derivatives of the contact terms by the geometry that they read: gaps and normals."""

from __future__ import annotations

import numpy as np
import ufl

from ..base import compat
from .surface_fields import SurfaceFields


class ParameterTangents:
    """Derivatives of a contact form by gap and normal, point by point.

    Args:
        k: the fields of the form.
        form: the contact terms.
        order_of_rows: place of each dof of the unknowns among (w point by point, lam, tau component
            by component).
    """

    def __init__(self, k: SurfaceFields, form: ufl.Form, order_of_rows: np.ndarray) -> None:
        n, d = k.surface.size, k.surface.dim
        space = k.surface.components(1 + d)
        trial = ufl.split(ufl.TrialFunction(space))
        normal = ufl.as_vector(trial[1:])
        tangent = ufl.derivative(form, k.normal, normal) + ufl.derivative(form, k.gap, trial[0])
        self._assembler = compat.MatrixAssembler(tangent)
        point, kind = np.empty((2, n * (1 + d)), dtype=np.int64)
        for component in range(1 + d):
            dofs = compat.cell_dofs(space.sub(component)).ravel()
            point[dofs], kind[dofs] = k.surface.cell_nodes.ravel(), component
        lengths = np.diff(self._assembler.indptr)
        row = order_of_rows[np.repeat(np.arange(len(order_of_rows)), lengths)]
        column, jump, behind = self._assembler.indices, row < n * d, row - n * d
        at = np.where(jump, row // d, behind % n)
        what = np.where(jump, row % d, d + behind // n)
        self._mine = at == point[column]  # all that are not zero
        self._place = at[self._mine], what[self._mine], kind[column][self._mine]
        self._blocks = np.zeros((n, k.components, 1 + d))

    def refresh_constants(self) -> None:
        """Constants of the form have changed."""
        self._assembler.refresh_constants()

    def __call__(self) -> np.ndarray:
        """Those of all points, (n, unknowns, 1 + d); the next call uses the same array again."""
        self._blocks[self._place] = self._assembler()[self._mine]
        return self._blocks
