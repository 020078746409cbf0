# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which facets of one surface may meet which others of it.

Every two that face each other are asked once: the first of them, in an order that does not change,
is the slave. Sharp edges divide the surface into smooth parts, of which the smaller one is slave,
as if they were named. Within a part the order runs along a direction of the undeformed body: what
folds then meets as two surfaces that are named, one of them slave throughout, but where a fold lies
across the direction. And what a ray meets on the far side of the body's own wall is no contact.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from .ridges import smooth_parts
from .side import Side


class Admits(Protocol):
    """Which facets may meet."""

    def __call__(self, facet: np.ndarray, other: np.ndarray, away: np.ndarray) -> np.ndarray:
        """Whether facets (q,) may meet others (q,) ``away`` [m] along their normals, (q,)."""

    def pass_through(self, mine: np.ndarray, theirs: np.ndarray) -> bool:
        """Whether sides that were and are at these places, (2, N, d), may have changed them."""


#: What lies so deep in the wall behind a facet, as a share of how deep it was in the undeformed
#: body, is the far side of the wall, not what went through the facet.
WALL = 0.5
#: Cost: the direction of the order, which no symmetry of a mesh is likely to have: where a fold
#: lies across it slave and master take turns, and Newton's method some more iterations.
ALONG = (1.0, 0.618, 0.382)
#: Cost: parts whose shares of the surface agree to so many digits are taken for equally large.
DIGITS = 6


class Itself:
    """Says of two facets of a side, one before the other, whether they may touch.

    Args:
        side: both slave and master.
    """

    def __init__(self, side: Side) -> None:
        m = len(side.cells)
        self._middles = side.nodes[side.corners].mean(axis=1)
        slopes = side.shape(np.tile(side.midpoint, (m, 1)))[1]
        normals = side.normals(side.nodes, np.arange(m), slopes)
        self._normals = normals / np.linalg.norm(normals, axis=1)[:, None]
        self._rank = np.empty(m, dtype=int)
        way, part = self._middles @ ALONG[: side.dim], smooth_parts(side)
        first = np.full(part.max() + 1, np.inf)
        np.minimum.at(first, part, way)
        area = np.bincount(part, np.linalg.norm(normals, axis=1))
        size = np.round(area / area.sum(), DIGITS)  # alike ones as their first facets lie
        order = np.lexsort((way, part, first[part], size[part]))
        self._rank[order] = np.arange(m)

    def __call__(self, facet: np.ndarray, other: np.ndarray, away: np.ndarray) -> np.ndarray:
        """Whether facets (q,) may meet others ``away`` [m] along their normals, (q,) of bool."""
        arm = self._middles[other] - self._middles[facet]
        before = (arm * self._normals[facet]).sum(axis=1)
        wall = (before < 0) & (away <= WALL * before)
        return (self._rank[facet] < self._rank[other]) & ~wall

    def pass_through(self, mine: np.ndarray, theirs: np.ndarray) -> bool:
        """Nothing goes through itself as a whole."""
        return False
