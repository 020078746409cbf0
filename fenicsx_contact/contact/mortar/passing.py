# SPDX-License-Identifier: LGPL-3.0-or-later
"""What passes through a surface within a step and is then too far from it to find a partner."""

from __future__ import annotations

import numpy as np

from ...base.vectors import largest
from .mortar import Pairing
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


def gone_through(pair: Pairing, start: np.ndarray, asked: np.ndarray) -> np.ndarray:
    """Whether points of a slave, of those asked (n,), and what they may have met went through each
    other since places ``start`` (N, d) of all nodes, (n,) of bool."""
    lost, last = np.flatnonzero(asked), len(pair.slave.nodes)
    mine = start[:last], pair.places[:last]
    theirs = start[last:], pair.places[last:]
    facets = np.arange(len(pair.master.cells))
    into = passed((mine[0][lost], mine[1][lost]), pair.master, theirs, facets)
    into[:, 0] = lost[into[:, 0]]
    facets = np.flatnonzero(asked[pair.slave.corners].any(axis=1))
    out = passed(theirs, pair.slave, mine, facets)
    if pair.master is pair.slave:  # no point goes through its own facets
        into, out = (
            each[(pair.slave.corners[each[:, 1]] != each[:, :1]).all(axis=1)]
            for each in (into, out)
        )
    through = np.zeros(pair.n, dtype=bool)
    through[into[:, 0]] = through[pair.slave.corners[out[:, 1]]] = True
    return through
