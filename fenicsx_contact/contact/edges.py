# SPDX-License-Identifier: LGPL-3.0-or-later
"""Normals of points at an edge of a wall, which has those of all its faces.

Round-off would choose one of them, another at each iterate, along which the point is free. But a
body that lies on a face up to its very edge is borne by it, and what slides over an edge is borne
by the face by which it comes until it is beyond.
"""

from __future__ import annotations

import numpy as np

from ..base.constants import RIGHT, SAME
from .wall import Wall


def lain_on(wall: Wall, points: np.ndarray, cells: np.ndarray, time: float) -> np.ndarray:
    """Outward normals of a wall at points, (n, d): at an edge those of the face on which a facet
    beside the point lies.

    Args:
        wall: that they may touch.
        points: nodes of facets, (n, d) in m.
        cells: nodes of each facet, (m, k).
        time: s.
    """
    normals, distance = wall.normals(points, time), wall.distance(points, time)
    ways = points[cells].mean(axis=1)[:, None] - points[cells]
    size = np.linalg.norm(ways, axis=2)
    cell, corner = (np.abs(distance[cells]) <= SAME * size).nonzero()
    if not len(cell):
        return normals
    node = cells[cell, corner]
    beside = points[node] + SAME * ways[cell, corner]
    order = np.lexsort((wall.distance(beside, time), node))  # the nearest of each node first
    first = order[np.unique(node[order], return_index=True)[1]]
    node, there = node[first], wall.normals(beside[first], time)
    edge = (np.abs(there - normals[node]) > RIGHT).any(axis=1)
    normals = normals.copy()
    normals[node[edge]] = there[edge]
    return normals


def come_by(
    wall: Wall,
    points: np.ndarray,
    ways: np.ndarray,
    time: float,
    start: np.ndarray,
    size: float,
) -> np.ndarray:
    """Outward normals of a wall at points, (n, d): at an edge, or as near to one as places are told
    apart, those of the face before which they were.

    Args:
        wall, points: what is met, and where, (n, d) in m.
        ways: by which the points got there, as seen from the wall, (n, d) in m.
        time: s.
        start: outward normals from where they came, (n, d).
        size: of the surface, m.
    """
    normals = wall.normals(points, time)
    turned = (np.abs(normals - start) > SAME).any(axis=1)
    if not turned.any():
        return normals
    there = points - SAME * ways  # of all: some walls are compiled for a number of points
    # what goes along an edge, or rests, may be beyond it by round-off
    beside = there + SAME * size * (start - normals)
    before, nearby = wall.normals(np.concatenate([there, beside]), time).reshape(2, *points.shape)
    stays = (np.abs(before - start) <= RIGHT).all(axis=1)
    before = np.where(stays[:, None], before, nearby)
    edge = turned & (np.abs(before - normals) > RIGHT).any(axis=1)
    return np.where(edge[:, None], before, normals) if edge.any() else normals
