# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whether surfaces could ever meet, wherever they are thrown, and how far off those are that face
each other."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .side import Side

if TYPE_CHECKING:
    from .mortar import Pairing


def sought(pairing: Pairing, places: np.ndarray) -> float:
    """A way, m, for which partners are sought so far that some nodes at these places (N, d) are
    near theirs: none, longer and longer ones, or at last inf. The pairing is then that."""
    way, farthest = 0.0, float(np.ptp(places, axis=0).sum())
    while True:
        pairing.update(places, way)
        if pairing.near.any():
            return way
        if way > farthest:
            return np.inf
        way = max(4 * way, 0.01 * farthest)


def faces_anywhere(slave: Side, master: Side, xs: np.ndarray, xm: np.ndarray) -> bool:
    """Whether a facet of each lies before the other, their normals against each other: aside of
    each other, they meet if one moves aslant. Places of the nodes, (n, d) in m."""
    sides = ((slave.flat, xs), (master.flat, xm))
    here, there = (x[side.corners].mean(axis=1) for side, x in sides)
    mine, theirs = (side.middle_normals(x) for side, x in sides)
    for x, n in zip(here, mine):
        arm = there - x
        if ((arm @ n > 0) & ((arm * theirs).sum(axis=1) < 0) & (theirs @ n < 0)).any():
            return True
    return False
