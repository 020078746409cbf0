# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edges of two bodies that cross.

Where two edges touch, the bodies lie on their sides of the plane that the edges span. Where a face
lies flat on another, the edges around these cross in one plane and all bear; which of them have the
bodies on their sides, is round-off. So a face beside an edge may reach through a little, as long as
the other edge goes on over it: what is above the face there is above the edge, too. At the end of
the other edge it is not, and its corner may slide off.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from ...base.constants import SAME, SHARP
from ...base.vectors import dot, normalised
from ..simplices import shares
from .shape import Shape

#: The sine of the angle by which a body may reach through the plane of a face or two edges that
#: goes on there: a face that lies flat on another turns by round-off, what is round by its facets.
THROUGH = sqrt(1 - SHARP**2)


def crossing(
    s: Shape,
    mine: np.ndarray,
    theirs: np.ndarray,
    x: np.ndarray,
    goes: np.ndarray,
    inside: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """How far edges are apart, how their cross product shows, and whether they are what is
    nearest of the bodies behind them, if the bodies go so far (k,) and are so deep ``inside`` of
    others (k,), in m: by so little no edge reaches beyond another."""
    (a, b), (c, d) = ((x[i] for i in s.ends[edge].T) for edge in (mine, theirs))
    u, v = b - a, d - c
    normal = np.cross(u, v)
    size = np.sqrt(dot(normal, normal))
    lengths = np.sqrt(dot(u, u) * dot(v, v))
    cross = size > SAME * lengths
    normal /= np.where(cross, size, 1.0)[:, None]
    arms = [_across(x[s.wings[mine, i]] - a, u) for i in (0, 1)]
    # out of the first body: away from what is beside its edge
    turn = np.where(dot(arms[0] + arms[1], normal) > 0, -1.0, 1.0)
    normal *= turn[:, None]
    first, second = shares(a, u, c, v)
    for share, arm in ((first, u), (second, v)):
        cross &= np.minimum(share, 1 - share) > SAME + inside / np.sqrt(dot(arm, arm))
    height, same = dot(c - a, normal), SAME * np.sqrt(lengths)
    far = goes + same
    others = [_across(x[s.wings[theirs, i]] - c, v) for i in (0, 1)]
    for arm, way, ends in (
        *((arm, normal, (c - a, d - a)) for arm in arms),
        *((arm, -normal, (a - c, b - c)) for arm in others),
    ):
        rise = dot(arm, way)  # both bodies on their sides, or below what goes on over them
        level = arm - rise[:, None] * way
        over = np.maximum(*(dot(end, level) for end in ends)) > far
        cross &= rise <= np.where(over, THROUGH, SAME)
    # and no face beside them that is farther from all of the other edge and of what is beside it
    faces = s.units(x, np.arange(len(s.outline)))
    for edge, other in ((theirs, mine), (mine, theirs)):
        nodes = [*s.ends[other].T, *s.wings[other].T]
        for i in (0, 1):
            f = s.flanks[edge, i]
            at = x[s.outline[f, 0]]
            least = np.minimum.reduce([dot(x[node] - at, faces[f]) for node in nodes])
            cross &= least <= height + same
    return height, turn, cross


def _across(arm: np.ndarray, edge: np.ndarray) -> np.ndarray:
    """The directions of arms (k, 3) across edges."""
    return normalised(arm - (dot(arm, edge) / dot(edge, edge))[:, None] * edge)


def nearest(
    s: Shape, mine: np.ndarray, theirs: np.ndarray, x: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Where edges are nearest to each other, on either."""
    (a, b), (c, d) = ((x[i] for i in s.ends[edge].T) for edge in (mine, theirs))
    share, other = shares(a, b - a, c, d - c)
    return a + share[:, None] * (b - a), c + other[:, None] * (d - c)
