# SPDX-License-Identifier: LGPL-3.0-or-later
"""How far apart rigid solids are that strike each other: by the distance of each facet from each,
the truth that means over facets miss where corners meet."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from ..solids import Solid
from .inside import SIMPLICES
from .mortar import Pairing, Side


class Strikes:
    """Takes note of how far two solids were apart where points begin to bear.

    Args:
        solids: the two.
        points: number of points of the slave.

    Attributes:
        apart: how far, at most, beyond what both may have gone in the step, m; of what deforms
            nobody asks.
    """

    def __init__(self, solids: Sequence[Solid], points: int) -> None:
        self._asked = all(solid.shiftable for solid in solids)
        self._bore, self._way = np.zeros(points, dtype=bool), 0.0
        self.apart = 0.0

    def see(self, bears: np.ndarray, pairing: Pairing, places: np.ndarray, way: float) -> float:
        """What bears after a step, (n,) of bool, and where nodes (N, d) are then; they are about to
        go a ``way`` to each other, m. Gives how far apart solids were."""
        fresh, gone = bears & ~self._bore, self._way
        self._bore, self._way = bears, way
        if self._asked and fresh.any():
            slave, master = (simplices(side) for side in (pairing.slave, pairing.master))
            slave = slave[fresh[slave].any(axis=1)]
            last = len(pairing.slave.nodes)
            away = separation(places[:last][slave], places[last:][master])
            self.apart = max(self.apart, away - gone)
        return self.apart


def simplices(side: Side) -> np.ndarray:
    """Nodes of the facets of a side, of quadrilaterals of their halves, (m, d)."""
    return side.corners[:, SIMPLICES[side.cell]].reshape(-1, side.dim)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray((a * b).sum(axis=-1))


def separation(ones: np.ndarray, others: np.ndarray) -> float:
    """The distance of simplices (m, d, d) from others (n, d, d), in m; where they reach into each
    other no more than by how much."""
    corners = (each.reshape(-1, each.shape[2]) for each in (ones, others))
    mine, theirs = (np.unique(each, axis=0) for each in corners)
    least = min(_nearest(mine, others), _nearest(theirs, ones))
    if ones.shape[2] == 3:
        least = min(least, _crossing(_edges(ones), _edges(others)))
    return least


def _nearest(points: np.ndarray, simplices: np.ndarray) -> float:
    """The least distance of points (p, d) from simplices (n, k, d)."""
    p, a = points[:, None], simplices[:, 0]
    if simplices.shape[1] == 2:
        way = simplices[:, 1] - a
        share = np.clip(_dot(p - a, way) / _dot(way, way), 0.0, 1.0)
        away = p - a - share[..., None] * way
        return float(np.sqrt(_dot(away, away).min()))
    u, v = simplices[:, 1] - a, simplices[:, 2] - a
    normal = np.cross(u, v)
    size = _dot(normal, normal)
    arm = p - a
    first, second = (_dot(np.cross(*each), normal) / size for each in ((arm, v), (u, arm)))
    over = (first >= 0) & (second >= 0) & (first + second <= 1)
    height = np.abs(_dot(arm, normal)) / np.sqrt(size)
    return min(float(height[over].min(initial=np.inf)), _nearest(points, _edges(simplices)))


def _edges(triangles: np.ndarray) -> np.ndarray:
    """All edges, (3 n, 2, d)."""
    return np.concatenate([triangles[:, pair] for pair in combinations(range(3), 2)])


def _crossing(ones: np.ndarray, others: np.ndarray) -> float:
    """The least distance of edges (m, 2, 3) and (n, 2, 3) that pass each other between their
    ends."""
    a, c = ones[:, None, 0], others[:, 0]
    u, v = ones[:, None, 1] - a, others[:, 1] - c
    w, uu, vv, uv = a - c, _dot(u, u), _dot(v, v), _dot(u, v)
    uw, vw, det = _dot(u, w), _dot(v, w), uu * vv - uv**2
    det = np.where(det > 0, det, np.inf)
    s, t = (uv * vw - vv * uw) / det, (uu * vw - uv * uw) / det
    between = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1) & np.isfinite(det)
    away = w + s[..., None] * u - t[..., None] * v
    return float(np.sqrt(_dot(away, away)[between].min(initial=np.inf)))
