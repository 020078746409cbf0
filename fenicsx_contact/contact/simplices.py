# SPDX-License-Identifier: LGPL-3.0-or-later
"""How near points, edges and triangles are to each other."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from ..base.vectors import dot

#: The simplices of which a facet consists.
SIMPLICES = {
    "interval": [[0, 1]],
    "triangle": [[0, 1, 2]],
    "quadrilateral": [[0, 1, 3], [0, 3, 2]],
}


def split(corners: np.ndarray, cell: str) -> np.ndarray:
    """The corners of the simplices of which facets with these corners (m, k) consist, (n, d)."""
    simplices = np.array(SIMPLICES[cell])
    return corners[:, simplices].reshape(-1, simplices.shape[1])


def nearest(points: np.ndarray, simplices: np.ndarray) -> float:
    """The least distance of points (p, d) from simplices (n, k, d), k = 2 or 3, in m; of what is
    flat in its ends and edges."""
    p, a = points[:, None], simplices[:, 0]
    if simplices.shape[1] == 2:
        way = simplices[:, 1] - a
        square = dot(way, way)
        share = np.clip(dot(p - a, way) / np.where(square > 0, square, np.inf), 0.0, 1.0)
        away = p - a - share[..., None] * way
        return float(np.sqrt(dot(away, away).min()))
    u, v = simplices[:, 1] - a, simplices[:, 2] - a
    normal = np.cross(u, v)
    square = dot(normal, normal)
    whole, size = square > 0, np.where(square > 0, square, np.inf)
    arm = p - a
    first, second = (dot(np.cross(*each), normal) / size for each in ((arm, v), (u, arm)))
    over = whole & (first >= 0) & (second >= 0) & (first + second <= 1)
    height = np.abs(dot(arm, normal)) / np.sqrt(size)
    return min(float(height[over].min(initial=np.inf)), nearest(points, edges(simplices)))


def edges(triangles: np.ndarray) -> np.ndarray:
    """All edges of triangles (n, 3, d), (3 n, 2, d)."""
    return np.concatenate([triangles[:, pair] for pair in combinations(range(3), 2)])


def passing(ones: np.ndarray, others: np.ndarray) -> float:
    """The least distance of edges (m, 2, 3) and (n, 2, 3) that pass each other between their
    ends, in m; infinite if none do."""
    a, c = ones[:, None, 0], others[:, 0]
    u, v = ones[:, None, 1] - a, others[:, 1] - c
    s, t = shares(a, u, c, v)
    between = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    away = a - c + s[..., None] * u - t[..., None] * v
    return float(np.sqrt(dot(away, away)[between].min(initial=np.inf)))


def shares(a: np.ndarray, u: np.ndarray, c: np.ndarray, v: np.ndarray) -> tuple:
    """Where lines from a along u and from c along v are nearest to each other, in shares of these,
    (...,); of parallel ones anywhere."""
    w, uu, vv, uv = a - c, dot(u, u), dot(v, v), dot(u, v)
    uw, vw, det = dot(u, w), dot(v, w), uu * vv - uv**2
    det = np.where(det > 0, det, np.inf)
    return (uv * vw - vv * uw) / det, (uu * vw - uv * uw) / det
