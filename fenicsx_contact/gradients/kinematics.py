# SPDX-License-Identifier: LGPL-3.0-or-later
"""Places and velocities of points of a contact, with their derivatives by a solid's unknowns."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp


class Kinematics:
    """Points of a solid, with derivatives by its unknowns; operators are (n d, size), flat.

    Args:
        place: derivative of the places by q, and of the velocities by v.
        bend: of the velocities by q; None where places are linear in q.
    """

    def __init__(self, place: Any, bend: np.ndarray | None = None) -> None:
        self.place, self.bend = place, bend

    def at(self, points: np.ndarray, d: int) -> Kinematics:
        """Those of some points."""
        rows = (points[:, None] * d + np.arange(d)).ravel()
        return Kinematics(self.place[rows], None if self.bend is None else self.bend[rows])

    def by_place(self, weights: np.ndarray) -> Any:
        """Derivative by q of what depends on the places by weights (k, r, d), (k r, size)."""
        return _apply(weights, self.place)

    def by_bend(self, weights: np.ndarray) -> Any:
        """Derivative by q of what depends on the velocities by weights."""
        return 0.0 if self.bend is None else _apply(weights, self.bend)


def _apply(weights: np.ndarray, operator: Any) -> Any:
    k, r, d = weights.shape
    if isinstance(operator, np.ndarray):
        return np.matmul(weights, operator.reshape(k, d, -1)).reshape(k * r, -1)
    return _diagonal(weights) @ operator


def rigid(arm: np.ndarray, spin: float, held: np.ndarray) -> Kinematics:
    """Of a rigid solid in the plane, at points (n, 2) from its centre."""
    n = len(arm)
    place, bend = np.zeros((2, n, 2, 3))
    place[:, 0, 0] = place[:, 1, 1] = 1.0
    place[:, 0, 2], place[:, 1, 2] = -arm[:, 1], arm[:, 0]
    bend[:, :, 2] = -spin * arm
    for each in (place, bend):
        each[:, :, held] = 0.0
    return Kinematics(place.reshape(2 * n, 3), bend.reshape(2 * n, 3))


def square(blocks: np.ndarray) -> Any:
    """A block diagonal matrix; dense where it is small."""
    k, r, c = blocks.shape
    result = np.zeros((k, r, k, c))
    each = np.arange(k)
    result[each, :, each] = blocks
    return result.reshape(k * r, k * c)


def _diagonal(blocks: np.ndarray) -> sp.csr_matrix:
    """A block diagonal matrix from blocks (k, rows, columns)."""
    k, r, c = blocks.shape
    columns = (np.arange(k) * c)[:, None, None] + np.arange(c)
    columns = np.broadcast_to(columns, (k, r, c)).reshape(-1)
    return sp.csr_matrix((blocks.ravel(), columns, np.arange(0, k * r * c + 1, c)), (k * r, k * c))
