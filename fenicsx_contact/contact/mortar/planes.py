# SPDX-License-Identifier: LGPL-3.0-or-later
"""The planes across the normals of a slave's facets at their middles, and what is seen in them.

Places in a plane are given by the slave's tangents g at the middle,  x = middle + g p + h n.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...base.vectors import largest
from .clipping import areas, cross
from .partners import inverses
from .side import OUTLINE, Side, unit_and_length
from .stance import Places, Sides, Stance, look


class Pairs(NamedTuple):
    """Facets of the slave, ascending, and of the master, whose corners are at (q, k, 3) in the
    planes of the former."""

    facet: np.ndarray
    other: np.ndarray
    corners: np.ndarray

    def of(self, which: np.ndarray) -> Pairs:
        """Some of them."""
        return Pairs(*(each[which] for each in self))


class Planes:
    """The planes of the facets of a side with straight edges, from the places (N, 3) of its nodes.

    Attributes:
        places, corners: of the facets, in space and in their planes, (m, k, 3).
        unit, length: where they look, (m, 3): along these normals, divided by (m,).
        stance: how they stand on the other side.
        slopes: derivatives of the shape functions there, (2, 1, k).
        low, high: between which the corners are, (m, 3).
        size: areas in the planes, (m,).
    """

    def __init__(self, sides: Sides, places: Places, stance: Stance) -> None:
        side, nodes = sides[0], places[0]
        self.places, self.stance = nodes[side.cells], stance
        self.slopes = side.shape(side.midpoint[None])[1]
        g = side.middle_tangents(nodes)
        every = np.arange(len(side.cells))
        self.unit, self.length = unit_and_length(side.normal(g, every))
        look(self.unit, self.length, stance, sides, places, every)
        basis = np.empty((len(every), 3, 3))
        basis[..., :2] = np.moveaxis(g, 0, 2)
        basis[..., 2] = self.unit
        self._inverse = np.swapaxes(inverses(basis), 1, 2)
        self._middle = self.places.mean(axis=1, keepdims=True)
        self.corners = self.see(self.places, every)
        self.low, self.high = self.corners.min(axis=1), self.corners.max(axis=1)
        self.size = areas(self.corners[:, OUTLINE[side.cell], :2])

    def see(self, places: np.ndarray, facet: np.ndarray) -> np.ndarray:
        """Coordinates of places (q, k, 3) in the planes of these facets."""
        return (places - self._middle[facet]) @ self._inverse[facet]


def heights(corners: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Those of points (q, g, k) of facets whose corners are at (q, k, 3), (q, g)."""
    return (shape @ corners[..., 2:])[..., 0]


def fields(side: Side, xi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Shape functions (q, g, k) at points (q, g, 2), and derivatives, (2, q, g, k)."""
    values, slopes = side.shape(xi.reshape(-1, 2))
    shape = (*xi.shape[:2], values.shape[1])
    return values.reshape(shape), slopes.reshape(2, *shape)


def on_facet(
    side: Side, corners: np.ndarray, p: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Local coordinates (q, g, 2) of places p (q, g, 2) in planes where the corners of facets are
    at (q, k, 3), and shape functions there with their derivatives, (q, g, k), (2, q, g, k)."""
    xi, flat = np.tile(side.midpoint, (*p.shape[:2], 1)), corners[..., :2]
    for _ in range(1 if side.straight else 8):
        shape, slopes = fields(side, xi)
        error, g = p - shape @ flat, slopes @ flat
        step = np.stack([cross(error, g[1]), cross(g[0], error)], axis=2)
        step /= cross(g[0], g[1])[..., None]
        if largest(step) < 1e-13:
            return xi, shape, slopes
        # nobody is far from a facet, but by a fold in a crooked one
        xi = np.minimum(np.maximum(xi + step, -5.0), 6.0)
    return (xi, *fields(side, xi))
