# SPDX-License-Identifier: LGPL-3.0-or-later
"""UFL on points that belong to no mesh."""

from __future__ import annotations

from typing import Any

import dolfinx
import numpy as np
from dolfinx import fem
from mpi4py import MPI

from . import compat


class PointCloud:
    """n points anywhere, on which UFL of a position ``x`` (d components), a time ``t`` and fields
    of ``numbers`` is evaluated: constant in each of n cells, which are no place (one process)."""

    def __init__(self, n: int, dim: int) -> None:
        mesh = dolfinx.mesh.create_unit_interval(MPI.COMM_SELF, n)
        self.numbers = compat.cellwise_space(mesh)
        vectors = compat.cellwise_space(mesh, dim)
        self.x, self.t = fem.Function(vectors, name="x"), fem.Function(self.numbers, name="t")
        self._rows = compat.cell_dofs(vectors).ravel()

    def place(self, points: np.ndarray, time: float) -> None:
        """Put the points (n, d) where they are at a time."""
        self.x.x.array.reshape(points.shape)[self._rows] = points
        self.t.x.array[:] = time

    def compiled(self, expression: Any) -> compat.PointExpression:
        """An expression in ``x`` and ``t``; its values are (n, components)."""
        return compat.PointExpression(expression, self.numbers)
