# SPDX-License-Identifier: LGPL-3.0-or-later
"""What length of a rod each point of its contact stands for: one measure, ds on the rod.

The nodes at the walls of tubes and the stations that the rod is at are together the points of one
trapezoidal rule on s, which moves with the travel: each has half of the way to its neighbours, as
far as a tube is beside it. The ends of tubes are stations, so that all of it counts, or none.
"""

from __future__ import annotations

import numpy as np

from .guide import Guide


class Lengths:
    """Lengths for which the nodes of a rod and the stations of its guide stand.

    A card has no length. One outside of tubes stands for half of the way to the stations beside it
    where the rod is at it.

    Args:
        guide: the guide.
        s: of the nodes, at the stations anything, (n,) in m.
        stations: numbers of the stations among the points, from the top down, (k,).
    """

    def __init__(self, guide: Guide, s: np.ndarray, stations: np.ndarray) -> None:
        self._station = np.zeros(len(s))
        self._station[stations] = 1
        nodes = s[self._station == 0]
        self._low, self._high = nodes.min(), nodes.max()
        depth = guide.stations
        middle = 0.5 * (depth[1:] + depth[:-1])
        walls = guide.around(guide.origin + middle[:, None] * guide.direction)[-1] >= 0
        # of what is between two stations, from the lowest one up as s runs; beyond them is no tube
        walls = np.concatenate([[False], walls[::-1], [False]])
        between = np.concatenate([[0.0], np.diff(depth)[::-1], [0.0]])
        alone = ~(walls[1:] | walls[:-1])
        self._cards = np.zeros(len(s))
        self._cards[stations[::-1]] = alone * 0.5 * (between[1:] + between[:-1])
        self._walls = walls
        self._last: tuple[np.ndarray | None, np.ndarray] = None, self._cards

    def __call__(self, s: np.ndarray, void: np.ndarray) -> np.ndarray:
        """Lengths of the points, (n,) in m, when the material s is at them and none at those that
        are ``void``, (n,) each; kept, for they are asked for more than once."""
        if s is self._last[0]:
            return self._last[1]
        there, middle = np.flatnonzero(~void), 0.5 * (self._low + self._high)
        places, at, many = np.unique(
            np.clip(s[there], self._low, self._high), return_inverse=True, return_counts=True
        )
        passed = np.count_nonzero(void & (s < middle))  # stations below the rod
        below = passed + np.cumsum(np.bincount(at, self._station[there]))[:-1].astype(int)
        half = 0.5 * np.diff(places) * self._walls[below]
        share = np.zeros(len(places))
        share[:-1] += half
        share[1:] += half
        lengths = np.zeros(len(s))
        lengths[there] = (share / many)[at] + self._cards[there]
        self._last = s, lengths
        return lengths
