# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whether surfaces could ever meet, wherever they are thrown."""

from __future__ import annotations

import numpy as np

from .side import Side


def faces_anywhere(slave: Side, master: Side, xs: np.ndarray, xm: np.ndarray) -> bool:
    """Whether a facet of each lies before the other, their normals against each other: aside of
    each other, they meet if one moves aslant. Places of the nodes, (n, d) in m."""
    (here, mine), (there, theirs) = _seen(slave, xs), _seen(master, xm)
    for x, n in zip(here, mine):
        arm = there - x
        if ((arm @ n > 0) & ((arm * theirs).sum(axis=1) < 0) & (theirs @ n < 0)).any():
            return True
    return False


def _seen(side: Side, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Middles and normals of the facets, (m, d)."""
    side = side.flat
    normals = side.normal(side.middle_tangents(x), np.arange(len(side.cells)))
    return x[side.corners].mean(axis=1), normals
