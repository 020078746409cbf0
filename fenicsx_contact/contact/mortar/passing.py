# SPDX-License-Identifier: LGPL-3.0-or-later
"""What passes through a surface within a step and is then too far from it to find a partner."""

from __future__ import annotations

import numpy as np

from ...base.vectors import largest
from .side import Side

#: Places (n, d) at the start and at the end of a step.
Ways = tuple[np.ndarray, np.ndarray]


def passed(points: Ways, side: Side, nodes: Ways, asked: np.ndarray) -> np.ndarray:
    """Points and facets that meet within a step, seen as if both went straight.

    Args:
        points: their ways.
        side, nodes: a side, and the ways of its nodes.
        asked: numbers of its facets that are asked.

    Returns:
        Pairs of a point and a facet that it crosses from outside, (h, 2). Points that move less
        than a facet is large cross none: they are still near enough to be seen.
    """
    none = np.empty((0, 2), dtype=int)
    way = points[1] - points[0]
    moved = largest(way) + largest(nodes[1] - nodes[0])
    if moved <= side.sizes.min() or not len(asked):
        return none
    swept = np.concatenate(nodes)
    low, high = swept.min(axis=0) - side.sizes.max(), swept.max(axis=0) + side.sizes.max()
    inside = (np.maximum(*points) >= low) & (np.minimum(*points) <= high)
    near = np.flatnonzero(inside.all(axis=1))
    if not len(near):
        return none
    corners = nodes[1][side.corners[asked]]
    middle = corners.mean(axis=1)
    came = middle - nodes[0][side.corners[asked]].mean(axis=1)
    radius = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
    slopes = side.shape(np.tile(side.midpoint, (len(asked), 1)))[1]
    normal = side.normals(nodes[1], asked, slopes)
    found = []
    for i in near:
        after, across = points[1][i] - middle, way[i] - came
        inner = np.einsum("fj,fj->f", after, normal)
        speed = np.einsum("fj,fj->f", across, normal)
        into = (inner < 0) & (inner - speed > 0)
        share = inner / np.where(into, speed, -1.0)  # of the way, that lies behind the facet
        place = after - share[:, None] * across
        hit = into & (np.linalg.norm(place, axis=1) <= radius)
        found.append(np.stack([np.full(hit.sum(), i), asked[hit]], axis=1))
    return np.concatenate(found)
