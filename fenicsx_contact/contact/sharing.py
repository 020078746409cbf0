# SPDX-License-Identifier: LGPL-3.0-or-later
"""How points of rigid solids share what they bear.

Where more points touch than a motion tells, forces are not unique, and of what spins flat even the
sum of friction hangs on how they share. A uniform elastic foundation, however stiff, would give
pressures that are affine along a plane face: of all that do the same the most even over the area,

    min sum A p^2,   p >= 0,   sum A p n' J  as it is.

Newton's method picks the multipliers that are nearest to those with which a step begins, by a
compliance that is the same for all points (:mod:`~.scales`): it begins with these, whatever the
points bore as they came down one after the other, wherever other points touch or bear otherwise
than before, but where a step left other pressures that do the same.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..base.constants import ROUND_OFF, SAME
from ..base.nonnegative import smallest
from ..base.vectors import largest


class Sharing:
    """Spreads the pressures of a contact with multipliers of rigid solids; of others nothing.

    Args:
        contact: whose points they are.
    """

    def __init__(self, contact: Any) -> None:
        rigid = contact.coupling.shares and all(solid.shiftable for solid in contact.solids)
        self._of = contact if rigid and contact.formulation.multipliers else None
        self._touch = np.empty(0, dtype=bool)  # which points did,
        self._borne = self._sums = np.empty(0)  # what each bore, and all together

    def spread(self) -> None:
        """Let the points that touch as a step begins start from even pressures; tractions that are
        bounded by them go with them where points slipped."""
        if (contact := self._of) is None:
            return
        touch, equations = contact.touching(), contact.equations
        values, n, weight = equations.values, len(touch), equations.weight
        pressures, at = -values[equations.jumps : equations.jumps + n], touch.nonzero()[0]
        bear, same = touch * weight * pressures, np.array_equal(touch, self._touch)
        if same and _alike(bear, self._borne):
            return
        before, self._touch, self._borne = self._sums, touch, bear
        borne = bear[at]
        if not borne.any() or borne.min() < 0 or pressures[~touch].any() or not weight[at].all():
            return  # nothing bears, something is drawn, or bears apart
        does = _does(contact, at)
        self._sums = sums = does @ borne
        if not does.any() or (same and _alike(sums, before)):
            return
        even = _even(does, borne, contact.areas(weight)[at])
        if _alike(even, borne):
            return
        values[equations.jumps + at] = -even / weight[at]
        if getattr(contact.friction_law, "slope", None):
            slips = (contact.status[at] == 2) & (borne > ROUND_OFF * borne.max())
            share = np.divide(even, borne, out=np.ones_like(even), where=slips)
            for first in range(equations.tractions, len(values), n):
                values[first + at] *= share
        equations.values = values

    def state(self) -> dict[str, np.ndarray]:
        """The arrays from which :meth:`restore` continues identically."""
        if not self._of:
            return {}
        told = {"shared": self._touch, "shares": self._borne, "sums": self._sums}
        return {**told, "weight": self._of.equations.weight}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Take up a state that :meth:`state` gave."""
        if self._of and "sums" in state:
            self._touch = np.array(state["shared"])
            self._borne, self._sums = np.array(state["shares"]), np.array(state["sums"])
            self._of.equations.set_weight(np.array(state["weight"]))


def _alike(forces: np.ndarray, others: np.ndarray) -> bool:
    return len(forces) == len(others) and largest(forces - others) <= SAME * largest(others)


def _does(contact: Any, at: np.ndarray) -> np.ndarray:
    """What unit forces along these points' normals do to what is free to move, (v, n); of two
    solids to the slave's, by which the other follows: turns by arms of the surface's size."""
    (slave, *others), normal = contact.solids, contact.normal[at]
    d = normal.shape[1]
    J = contact.traces[0].rows((d * at[:, None] + np.arange(d)).ravel())
    J = np.concatenate([J[:, :d], J[:, d:] / contact.surface.extent], axis=1)
    if not others:
        J = J[:, np.diag(slave.mobility) > 0]
    return np.einsum("nd,ndv->vn", normal, J.reshape(len(at), d, -1))


def _even(does: np.ndarray, force: np.ndarray, area: np.ndarray) -> np.ndarray:
    """The forces of the most even pressures that do the same, (n,)."""
    root = np.sqrt(area)
    rows = does * root
    sizes = np.abs(rows).max(axis=1)
    rows = rows[sizes > SAME * sizes.max(initial=0.0)]
    sums = rows @ (force / root)
    values, vectors = np.linalg.eigh(rows @ rows.T)
    kept = values > ROUND_OFF * values.max(initial=0.0)
    y = vectors[:, kept] @ ((vectors[:, kept].T @ sums) / values[kept])
    even = y @ rows
    return np.asarray((even if even.min() >= 0 else smallest(rows, sums, y)) * root)
