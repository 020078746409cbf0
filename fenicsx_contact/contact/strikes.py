# SPDX-License-Identifier: LGPL-3.0-or-later
"""How far apart rigid solids are that strike each other: by the distance of each facet from each,
the truth that means over facets miss where corners meet."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..solids import Solid
from .mortar import Pairing
from .simplices import edges, nearest, passing, split


class Strikes:
    """Takes note of how far two solids were apart where points begin to bear.

    Args:
        solids: the two.
        points: number of points of the slave.

    Attributes:
        apart: how far, at most, beyond what both may have gone in the step, m; of what deforms
            nobody asks.
    """

    def __init__(self, solids: Sequence[Solid], points: int) -> None:
        self._asked = all(solid.shiftable for solid in solids)
        self._bore, self._way = np.zeros(points, dtype=bool), 0.0
        self.apart = 0.0

    def see(self, bears: np.ndarray, pairing: Pairing, places: np.ndarray, way: float) -> float:
        """What bears after a step, (n,) of bool, and where nodes (N, d) are then; they are about to
        go a ``way`` to each other, m. Gives how far apart solids were."""
        fresh, gone = bears & ~self._bore, self._way
        self._bore, self._way = bears, way
        if self._asked and fresh.any():
            sides = pairing.slave, pairing.master
            slave, master = (split(side.corners, side.cell) for side in sides)
            slave = slave[fresh[slave].any(axis=1)]
            last = len(pairing.slave.nodes)
            away = separation(places[:last][slave], places[last:][master])
            self.apart = max(self.apart, away - gone)
        return self.apart


def separation(ones: np.ndarray, others: np.ndarray) -> float:
    """The distance of simplices (m, d, d) from others (n, d, d), in m; where they reach into each
    other no more than by how much."""
    corners = (each.reshape(-1, each.shape[2]) for each in (ones, others))
    mine, theirs = (np.unique(each, axis=0) for each in corners)
    least = min(nearest(mine, others), nearest(theirs, ones))
    if ones.shape[2] == 3:
        least = min(least, passing(edges(ones), edges(others)))
    return least
