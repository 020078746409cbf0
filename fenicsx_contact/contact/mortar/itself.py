# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which facets of one surface may meet which others of it.

Every two that face each other are asked once: the first of them, in an order that does not change,
is the slave. Sharp edges divide the surface into smooth parts, of which the smaller one is slave,
as if they were named. Within a part the order runs away from an extremity of the undeformed body,
however that lies in the world: what folds then meets as two surfaces that are named, one of them
slave throughout, but where a fold lies across the way. Facets with a corner in common meet there
anyway, which is no contact: by means over what is covered a hollow corner would press itself open.
And what a ray meets on the far side of the body's own wall is none either.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from ...base.vectors import normalised
from .ridges import smooth_parts
from .side import Side


class Admits(Protocol):
    """Which facets may meet.

    Attributes:
        way: how far they have gone to each other in the step, and how deep they were before, m.
    """

    way: float

    def __call__(self, facet: np.ndarray, other: np.ndarray, away: np.ndarray) -> np.ndarray:
        """Whether facets (q,) may meet others (q,) ``away`` [m] along their normals, (q,)."""

    def pass_through(self, mine: np.ndarray, theirs: np.ndarray) -> bool:
        """Whether sides that were and are at these places, (2, N, d), may have changed them."""


#: What lies so deep in the wall behind a facet, as a share of how deep it was in the undeformed
#: body, is the far side of the wall, not what went through the facet.
WALL = 0.5
#: Cost: which of the extremities of a symmetric body begins the order, by a direction that no
#: symmetry of a mesh is likely to have: where a fold lies across the order slave and master take
#: turns, and Newton's method some more iterations.
ALONG = (1.0, 0.618, 0.382)
#: Cost: parts whose shares of the surface, and extremities whose distances from its middle, agree
#: to so many digits are taken for equally large.
DIGITS = 6


class Itself:
    """Says of two facets of a side, one before the other, whether they may touch.

    Args:
        side: both slave and master.
    """

    way = 0.0

    def __init__(self, side: Side) -> None:
        m = len(side.cells)
        self._corners = side.corners
        self._middles = side.nodes[side.corners].mean(axis=1)
        slopes = side.shape(np.tile(side.midpoint, (m, 1)))[1]
        normals = side.normals(side.nodes, np.arange(m), slopes)
        self._normals = normalised(normals)
        self._rank = np.empty(m, dtype=int)
        area, part = np.linalg.norm(normals, axis=1), smooth_parts(side)
        way = self._far(self._middles - area @ self._middles / area.sum())
        first = np.full(part.max() + 1, np.inf)
        np.minimum.at(first, part, way)
        size = np.bincount(part, area / area.sum())
        size = np.round(size, DIGITS)  # alike ones as their first facets lie
        order = np.lexsort((way, part, first[part], size[part]))
        self._rank[order] = np.arange(m)

    @staticmethod
    def _far(places: np.ndarray) -> np.ndarray:
        """How far facets at places (m, d) about the middle are from the farthest of them, (m,)."""
        away = np.linalg.norm(places, axis=1)
        ends = places[np.round(away / away.max(), DIGITS) == 1]
        first = ends[(ends @ ALONG[: places.shape[1]]).argmin()]
        return np.asarray(np.linalg.norm(places - first, axis=1))

    def __call__(self, facet: np.ndarray, other: np.ndarray, away: np.ndarray) -> np.ndarray:
        """Whether facets (q,) may meet others ``away`` [m] along their normals, (q,) of bool."""
        arm = self._middles[other] - self._middles[facet]
        before = (arm * self._normals[facet]).sum(axis=1)
        wall = (before < 0) & (away <= WALL * before)
        beside = (self._corners[facet][:, :, None] == self._corners[other][:, None]).any(
            axis=(1, 2)
        )
        return (self._rank[facet] < self._rank[other]) & ~wall & ~beside

    def pass_through(self, mine: np.ndarray, theirs: np.ndarray) -> bool:
        """Nothing goes through itself as a whole."""
        return False
