# SPDX-License-Identifier: LGPL-3.0-or-later
"""How far apart, or inside each other, rigid solids are that strike each other: by the distance of
each facet from each, the truth that means over facets miss where corners meet."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .inside import deepest
from .mortar import Pairing
from .simplices import edges, nearest, passing, split


class Strikes:
    """Takes note of how far two solids were apart, or inside, where points begin to bear.

    Args:
        solids: the two.
        points: number of points of the slave.

    Attributes:
        apart, inside: how far, at most, beyond what both may have gone in the step, m; of what
            deforms nobody asks.
    """

    def __init__(self, solids: Sequence[Any], points: int) -> None:
        self._solids, self._asked = solids, all(solid.shiftable for solid in solids)
        self._bore, self._way = np.zeros(points, dtype=bool), 0.0
        self.apart = self.inside = 0.0

    def see(self, bears: np.ndarray, pairing: Pairing, places: np.ndarray, way: float) -> None:
        """What bears after a step, (n,) of bool, and where nodes (N, d) are then; they are about to
        go a ``way`` to each other, m."""
        fresh, gone = bears & ~self._bore, self._way
        self._bore, self._way = bears, way
        if not (self._asked and fresh.any()):
            return
        sides, last = (pairing.slave, pairing.master), len(pairing.slave.nodes)
        at = places[:last], places[last:]
        struck = fresh[pairing.slave.corners].any(axis=1)
        pieces, shared = pairing.pieces, pairing.shared
        faced = pieces.other[struck[pieces.facet]]
        met = shared.sum(np.bincount(faced, minlength=len(sides[1].cells))) > 0
        points = np.zeros(len(struck))
        np.maximum.at(points, pieces.facet, pairing.deepest(pieces))
        depth = float(shared.sum(points)[struck].max())
        for k, faces in enumerate((struck, met)):
            x, other = at[k][np.unique(sides[k].corners[faces])], self._solids[1 - k]
            skin = other.places(other.mesh.skin()[0])
            depth = max(depth, deepest(x, other, np.full(len(x), gone), skin))
        if depth > gone:
            self.inside = max(self.inside, depth - gone)
            return
        slave, master = (split(side.corners, side.cell) for side in sides)
        slave = slave[fresh[slave].any(axis=1)]
        self.apart = max(self.apart, separation(at[0][slave], at[1][master]) - gone)


def separation(ones: np.ndarray, others: np.ndarray) -> float:
    """The distance of simplices (m, d, d) from others (n, d, d), in m; where they reach into each
    other no more than by how much."""
    corners = (each.reshape(-1, each.shape[2]) for each in (ones, others))
    mine, theirs = (np.unique(each, axis=0) for each in corners)
    least = min(nearest(mine, others), nearest(theirs, ones))
    if ones.shape[2] == 3:
        least = min(least, passing(edges(ones), edges(others)))
    return least
