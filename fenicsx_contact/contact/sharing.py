# SPDX-License-Identifier: LGPL-3.0-or-later
"""How points of rigid solids share what they bear.

Where more points touch than a motion tells, forces are not unique, and of what spins flat even the
sum of friction hangs on how they share. A uniform elastic foundation, however stiff, would give
pressures that are affine along a plane face: of all that do the same the most even over the area,

    min sum A p^2,   p >= 0,   sum A p n' J  as it is.

Newton's method picks the multipliers that are nearest to those with which a step begins, by a
compliance that is the same for all points (:mod:`~.scales`): it begins with these, whatever the
points bore as they came down one after the other, until a step leaves them as they are.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..base.constants import RIGHT, ROUND_OFF
from ..base.nonnegative import smallest


class Sharing:
    """Spreads the pressures of a contact with multipliers of rigid solids; of others nothing.

    Args:
        contact: whose points they are.
    """

    def __init__(self, contact: Any) -> None:
        rigid = all(solid.shiftable for solid in contact.solids)
        self._of = contact if rigid and contact.formulation.multipliers else None
        self._over = np.empty(0, dtype=bool)  # of which points the pressures were even

    def spread(self) -> None:
        """Let the points that touch as a step begins start from even pressures; tractions of those
        that slipped go with them."""
        if (contact := self._of) is None or np.array_equal(bears := contact.touching(), self._over):
            return
        self._over, at, equations = np.empty(0, dtype=bool), bears.nonzero()[0], contact.equations
        values, n, area = equations.values, len(bears), equations.weight[at]
        pressures = -values[equations.jumps : equations.jumps + n]
        borne = pressures[at]
        if not borne.any() or pressures[~bears].any():
            return
        even = _even(_does(contact, at) * area, borne, area)
        if np.abs(even - borne).max() <= RIGHT * borne.sum():
            self._over = bears
            return
        slips = (contact.status[at] == 2) & (borne > ROUND_OFF * borne.max())
        share = np.divide(even, borne, out=np.ones_like(even), where=slips)
        values[equations.jumps + at] = -even
        for first in range(equations.tractions, len(values), n):
            values[first + at] *= share
        equations.values = values

    def state(self) -> dict[str, np.ndarray]:
        """The arrays from which :meth:`restore` continues identically."""
        return {"shared": self._over} if self._of else {}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Take up a state that :meth:`state` gave."""
        self._over = np.array(state.get("shared", self._over))


def _does(contact: Any, at: np.ndarray) -> np.ndarray:
    """What unit forces along these points' normals do to what is free to move, (v, n)."""
    d, normal = contact.normal.shape[1], contact.normal[at]
    each = contact.coupling.jump_rows((d * at[:, None] + np.arange(d)).ravel())
    free = [J[:, np.diag(solid.mobility) > 0] for J, solid in zip(each, contact.solids)]
    return np.einsum("nd,ndv->vn", normal, np.concatenate(free, axis=1).reshape(*normal.shape, -1))


def _even(does: np.ndarray, pressure: np.ndarray, area: np.ndarray) -> np.ndarray:
    """The most even pressures that do the same."""
    root = np.sqrt(area)
    rows = does / root
    sizes = np.abs(rows).max(axis=1)
    rows = rows[sizes > 0] / sizes[sizes > 0, None]
    sums = rows @ (root * pressure)
    values, vectors = np.linalg.eigh(rows @ rows.T)
    kept = values > ROUND_OFF * values.max(initial=0.0)
    y = vectors[:, kept] @ ((vectors[:, kept].T @ sums) / values[kept])
    even = y @ rows
    return np.asarray((even if even.min() >= 0 else smallest(rows, sums, y)) / root)
