# SPDX-License-Identifier: LGPL-3.0-or-later
"""The tangent of a surface's contact terms: dense, sparse, or point by point.

They are integrated by the nodes, so that no two points are joined: the blocks of the points hold
all of the tangent that is not zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
import ufl

from ..base import compat
from .mortar.matrices import Matrix
from .parameters import ParameterTangents
from .surface_fields import SurfaceFields


class PointRows(NamedTuple):
    """The tangent of a part point by point: the rows of a point know its own multipliers, and of
    all v active velocities r numbers that it reads; forces on it act on these velocities.

    Attributes:
        tangents: by what is read and by the multipliers, (c, d + m, r + m).
        reads: what is read, (c r, v); None: the velocities are those of the points.
        spreads: its transpose spreads forces on the points, (c d, v); None likewise.
        turning: derivative of what fixed forces on the points mean for the velocities, (v, v), or
            None.
    """

    tangents: np.ndarray
    reads: Matrix | None = None
    spreads: Matrix | None = None
    turning: Matrix | None = None


class SurfaceTangent:
    """Derivatives of contact terms by their unknowns.

    Args:
        k: the fields of the form.
        form: the contact terms.
        order: the degrees of freedom in the order of the unknowns: w point by point, then the
            multipliers component by component.

    Attributes:
        form: the contact terms.
    """

    def __init__(self, k: SurfaceFields, form: ufl.Form, order: np.ndarray) -> None:
        n, d = k.surface.points.shape
        self._assembler = compat.MatrixAssembler(ufl.derivative(form, k.unknowns))
        self._fields, self.form, self._size = k, form, len(order)
        self._order_of_rows = place = np.empty(self._size, dtype=np.int64)
        place[order] = np.arange(self._size)
        rows = np.repeat(np.arange(self._size), np.diff(self._assembler.indptr))
        self._place = place[rows], place[self._assembler.indices]
        self._entries = self._place[0] * self._size + self._place[1]
        self._dense = np.zeros((self._size, self._size))
        each, more = np.arange(n), np.arange(d, k.components)
        points = np.concatenate([np.repeat(each, d), np.tile(each, len(more))])
        kinds = np.concatenate([np.tile(np.arange(d), n), np.repeat(more, n)])
        mine = points[self._place[0]] == points[self._place[1]]
        row, column = (each[mine] for each in self._place)
        self._own = mine, (points[row], kinds[row], kinds[column])
        by_jump = kinds[column] < d
        self._by_jump = mine.nonzero()[0][by_jump], tuple(each[by_jump] for each in self._own[1])
        self._blocks = np.zeros((n, k.components, k.components))
        self._turn: tuple[np.ndarray, np.ndarray] | None = None
        self._parameters: ParameterTangents | None = None

    def turn(self, gap: np.ndarray | None = None, normal: np.ndarray | None = None) -> None:
        """What w changes in the geometry that the equations read, which without is frozen.

        Args:
            gap: derivatives of the gaps by w, (n, d) in s.
            normal: of the normals, (n, d, d) in s/m.
        """
        self._turn = None if gap is None or normal is None else (gap, normal)

    def refresh_constants(self) -> None:
        """Constants of the form have changed."""
        self._assembler.refresh_constants()
        if self._parameters is not None:
            self._parameters.refresh_constants()

    def parameters(self) -> np.ndarray:
        """Derivatives of the rows of each point by its gap and normal, (n, unknowns, 1 + d)."""
        if self._parameters is None:
            self._parameters = self.by([self._fields.gap, self._fields.normal])
        return self._parameters()

    def by(self, fields: Sequence[Any]) -> ParameterTangents:
        """Derivatives of the rows of each point by fields."""
        return ParameterTangents(self._fields, self.form, fields, self._order_of_rows)

    def dense(self) -> np.ndarray:
        """All of it; the next call uses the same array again."""
        self._dense.ravel()[self._entries] = self._values()
        return self._dense

    def blocks(self, frozen: bool = False) -> np.ndarray:
        """Those of the points, (n, unknowns, unknowns); if ``frozen`` without the derivatives of
        the geometry; the next call uses the same array again."""
        mine, index = self._own
        self._blocks[index] = self._values(frozen)[mine]
        return self._blocks

    def sparse(self, frozen: bool = False) -> sp.csr_matrix:
        """All of it, sparse; if ``frozen`` without the derivatives of the geometry."""
        return sp.csr_matrix((self._values(frozen), self._place), (self._size, self._size))

    def _values(self, frozen: bool = False) -> np.ndarray:
        """Its entries as assembled; the next call uses the same array again."""
        values = self._assembler()
        if self._turn is not None and not frozen:
            gap, normal = self._turn
            by = self.parameters()
            turned = by[:, :, :1] * gap[:, None, :] + by[:, :, 1:] @ normal
            entries, index = self._by_jump
            values[entries] += turned[index]
        return values
