# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whether the surface of a body that is not convex lies between two places.

What is inside a body comes out of it straight: between a corner and the face that it is behind,
or between two edges that passed each other, there is nothing but the bodies. Where a surface lies
between, it is another arm that the face belongs to, and nothing has met there.
"""

from __future__ import annotations

import numpy as np

from ...base.constants import SAME
from ...base.vectors import dot
from .shape import Shape


def apart(
    shape: Shape, x: np.ndarray, ends: tuple[np.ndarray, np.ndarray], bodies: np.ndarray
) -> np.ndarray:
    """Which ways from one end to the other, (p, d) each, go through the surface of a body, (p,) of
    bool; through a convex one, which has nothing between, none is said to.

    Args:
        shape: of all bodies.
        x: places of their nodes, (N, d) in m.
        ends: of the ways, m.
        bodies: of which each is asked, (p,).
    """
    result = np.zeros(len(bodies), dtype=bool)
    asked = np.flatnonzero(~shape.convex[bodies])
    row, face = shape.faces.of(bodies[asked])
    way, same = asked[row], SAME * shape.sizes[bodies[asked]][row]
    normal, first = shape.units(x, face), x[shape.outline[face, 0]]
    one, other = (dot(end[way] - first, normal) for end in ends)
    sides = (one * other < 0) & (np.minimum(abs(one), abs(other)) > same)
    way, face, one, other = (each[sides] for each in (way, face, one, other))
    share = (one / (one - other))[:, None]
    at = ends[0][way] * (1 - share) + ends[1][way] * share
    result[way[shape.holds(at, face, x)]] = True
    return result
