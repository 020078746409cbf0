# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whether surfaces could ever meet, wherever they are thrown."""

from __future__ import annotations

import numpy as np

from .side import Side


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
