# SPDX-License-Identifier: LGPL-3.0-or-later
"""Normals of points that get to an edge of a wall, to the last digit."""

from __future__ import annotations

import numpy as np

from ..base.constants import RIGHT, ROUND_OFF, SAME
from ..base.vectors import largest
from .wall import Wall


def by_their_ways(
    wall: Wall, points: np.ndarray, ways: np.ndarray, time: float, start: np.ndarray
) -> tuple[np.ndarray, bool]:
    """Outward normals of a wall at points, (n, d), and whether any of these got onto an edge.

    An edge has the normals of all its faces, of which round-off would choose one at each iterate,
    along which the point leaves. It is that of the face by which the point gets there.

    Args:
        wall, points: what is met, and where, (n, d) in m.
        ways: by which the points got there, as seen from the wall, (n, d) in m.
        time: s.
        start: outward normals from where they came, (n, d).
    """
    normals = wall.normals(points, time)
    rows = (np.abs(normals - start) > SAME).any(axis=1).nonzero()[0]
    if not len(rows):
        return normals, False
    there, way = points[rows], ways[rows]
    length = np.linalg.norm(way, axis=1)
    short = SAME + ROUND_OFF * largest(there) / np.where(length > 0, length, np.inf)
    before = wall.normals(there - short[:, None] * way, time)
    edge = (np.abs(before - normals[rows]) > RIGHT).any(axis=1)
    if edge.any():
        normals = normals.copy()
        normals[rows[edge]] = before[edge]
    return normals, bool(edge.any())
