# SPDX-License-Identifier: LGPL-3.0-or-later
"""Places and velocities of points of a contact, with their derivatives by a solid's unknowns."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from ..base.constants import KEPT
from ..base.vectors import components
from ..solids.rotations import GENERATORS, by_spins
from .seen import Picked, Seen


class Kinematics:
    """Points of a solid, with derivatives by its unknowns; operators are (n d, size), flat.

    Args:
        place: derivative of the places by q, and of the velocities by v.
        bend: of the velocities by q; None where places are linear in q.
    """

    def __init__(self, place: Any, bend: np.ndarray | None = None) -> None:
        self.place, self.bend = place, bend
        self._kept: dict[bytes, Kinematics] = {}

    def at(self, points: np.ndarray, d: int) -> Kinematics:
        """Those of some points; where places are linear they are kept."""
        rows = components(points, d)
        if self.bend is not None or isinstance(self.place, np.ndarray):
            return Kinematics(self.place[rows], None if self.bend is None else self.bend[rows])
        key = points.tobytes()
        if key not in self._kept:
            if len(self._kept) >= KEPT:
                self._kept.clear()
            self._kept[key] = Kinematics(Picked(self.place, rows))
        return self._kept[key]

    def by_place(self, weights: np.ndarray) -> Any:
        """Derivative by q of what depends on the places by weights (k, r, d), (k r, size)."""
        return _apply(weights, self.place)

    def by(self, velocities: Any, places: Any) -> tuple[Any, Any]:
        """Derivatives by v and q of what depends on the velocities and the places by operators
        (r, n d)."""
        bend = 0.0 if self.bend is None else velocities @ self.bend
        return velocities @ self.place, places @ self.place + bend

    def by_both(self, velocities: np.ndarray, places: np.ndarray) -> Any:
        """Derivative by q of what depends on the velocities and the places by weights."""
        result = self.by_place(places)
        return result if self.bend is None else result + _apply(velocities, self.bend)


def _apply(weights: np.ndarray, operator: Any) -> Any:
    k, r, d = weights.shape
    if isinstance(operator, np.ndarray):
        return np.matmul(weights, operator.reshape(k, d, -1)).reshape(k * r, operator.shape[1])
    return Seen(weights, operator)


class Arms:
    """Arms from the centre of a rigid solid, (n, d) in m, in the plane and in space.

    Attributes:
        arms: they.
        first, second: their derivatives by rotations, (n, d, spins), and by one after another,
            (n, d, spins, spins): what a spin makes of an arm, and that of the arm after a rotation.
    """

    def __init__(self, arms: np.ndarray) -> None:
        G = GENERATORS[arms.shape[1]]
        self.arms = arms
        self.first = by_spins(arms)
        self.second = np.einsum("kij,njl->nikl", G, self.first)

    def kinematics(self, spin: np.ndarray) -> Kinematics:
        """Of the points at their ends."""
        n, d, spins = self.first.shape
        place, bend = np.zeros((2, n, d, d + spins))
        place[:, range(d), range(d)] = 1.0
        place[:, :, d:], bend[:, :, d:] = self.first, np.einsum("nikl,k->nil", self.second, spin)
        return Kinematics(place.reshape(n * d, -1), bend.reshape(n * d, -1))

    def turned(self, forces: np.ndarray) -> np.ndarray:
        """Derivative of the torques of forces (n, d) by a rotation, as a block of all unknowns,
        (d + spins, d + spins)."""
        d, spins = self.first.shape[1:]
        result = np.zeros((d + spins, d + spins))
        result[d:, d:] = np.einsum("ni,nikl->kl", forces, self.second)
        return result


def square(blocks: np.ndarray) -> Any:
    """A block diagonal matrix; dense where it is small."""
    k, r, c = blocks.shape
    result = np.zeros((k, r, k, c))
    each = np.arange(k)
    result[each, :, each] = blocks
    return result.reshape(k * r, k * c)


def spread(blocks: np.ndarray, n: int, points: np.ndarray, rows: bool = False) -> np.ndarray:
    """The same, from blocks of some of n points: its columns are those of all points, or its
    ``rows``."""
    k, r, c = blocks.shape
    each = np.arange(k)
    first, second, shape = (points, each, (n, k)) if rows else (each, points, (k, n))
    result = np.zeros((shape[0], r, shape[1], c))
    result[first, :, second] = blocks
    return result.reshape(shape[0] * r, shape[1] * c)


def diagonal(blocks: np.ndarray) -> sp.csr_matrix:
    """A block diagonal matrix from blocks (k, rows, columns)."""
    k, r, c = blocks.shape
    columns = (np.arange(k) * c)[:, None, None] + np.arange(c)
    columns = np.broadcast_to(columns, (k, r, c)).reshape(-1)
    return sp.csr_matrix((blocks.ravel(), columns, np.arange(0, k * r * c + 1, c)), (k * r, k * c))
