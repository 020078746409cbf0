# SPDX-License-Identifier: LGPL-3.0-or-later
"""Derivatives of the contact terms by the fields that they read: gaps, normals, what was before."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import ufl

from ..base import compat
from .surface_fields import SurfaceFields


class ParameterTangents:
    """Derivatives of a contact form by fields, point by point.

    Args:
        k: the fields of the form.
        form: the contact terms.
        by: the fields, scalars and vectors, some of which the form reads.
        order_of_rows: place of each dof of the unknowns among (w point by point, lam, tau component
            by component).
    """

    def __init__(
        self, k: SurfaceFields, form: ufl.Form, by: Sequence[Any], order_of_rows: np.ndarray
    ) -> None:
        n, d = k.surface.size, k.surface.dim
        count = sum(int(np.prod(field.ufl_shape)) for field in by)
        space = k.surface.components(count)
        trial = iter(ufl.split(ufl.TrialFunction(space)))
        ways = [ufl.as_vector([next(trial) for _ in f]) if f.ufl_shape else next(trial) for f in by]
        self._assembler = compat.MatrixAssembler(ufl.derivative(form, tuple(by), ways))
        point, kind = np.empty((2, n * count), dtype=np.int64)
        for component in range(count):
            dofs = compat.cell_dofs(space.sub(component)).ravel()
            point[dofs], kind[dofs] = k.surface.cell_nodes.ravel(), component
        lengths = np.diff(self._assembler.indptr)
        row = order_of_rows[np.repeat(np.arange(len(order_of_rows)), lengths)]
        column, jump, behind = self._assembler.indices, row < n * d, row - n * d
        at = np.where(jump, row // d, behind % n)
        what = np.where(jump, row % d, d + behind // n)
        self._mine = at == point[column]  # all that are not zero
        self._place = at[self._mine], what[self._mine], kind[column][self._mine]
        self._blocks = np.zeros((n, k.components, count))

    def refresh_constants(self) -> None:
        """Constants of the form have changed."""
        self._assembler.refresh_constants()

    def __call__(self) -> np.ndarray:
        """Those of all points, (n, unknowns, numbers of all fields); the next call uses the same
        array again."""
        self._blocks[self._place] = self._assembler()[self._mine]
        return self._blocks
