# SPDX-License-Identifier: LGPL-3.0-or-later
"""Who bears for nodes that supports hold.

Where all of a facet is held, whoever it meets has to yield. Where some of its nodes are free, these
have functions enough for whatever it does: a multiplier at a held one would ask for once more what
theirs ask, by as little as what it meets is free there, and push as hard. So on such a facet a held
node lends its function to the free ones beside it, of which the sum stays 1: what is uniform is
transmitted as before (Puso and Laursen, Comput. Methods Appl. Mech. Engrg. 193, 2004, at supports).

Held is what cannot go along the normal that it has at rest: one that ends held so turn by, as what
is bent does, moves the gap by a lever that is as small, and would push by as much more.
"""

from __future__ import annotations

import numpy as np

from ...base.constants import ROUND_OFF
from .matrices import add_up
from .side import OUTLINE, Side


def lent(corners: np.ndarray, cell: str, held: np.ndarray) -> np.ndarray:
    """What facets (m, k) of this cell make of the functions at their corners where some nodes are
    held, (n,) of bool: phi @ H, (m, k, k)."""
    k = corners.shape[1]
    free = ~held[corners]
    place = np.argsort(OUTLINE.get(cell, [0, 1]))
    beside = np.isin((place[:, None] - place) % k, (1, k - 1))
    to = np.where((beside & free[:, None]).any(axis=2, keepdims=True), beside, True)
    to = to & free[:, None]
    share = to / np.maximum(to.sum(axis=2, keepdims=True), 1)
    own = (free | ~free.any(axis=1, keepdims=True))[..., None]
    return np.where(own, np.eye(k), share)


def directions(side: Side, n: int) -> np.ndarray:
    """Components that the normals at its n corners have in the reference placement, means over the
    facets, (n, d) of bool; all, where these cancel."""
    each, rows = side.middle_normals(side.nodes), side.corners.ravel()
    sums = [add_up(x.repeat(side.corners.shape[1], axis=0), rows, n) for x in (each, np.abs(each))]
    there = np.abs(sums[0]) > ROUND_OFF * sums[1].sum(axis=1, keepdims=True)
    return there | ~there.any(axis=1, keepdims=True)
