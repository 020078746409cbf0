# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where a pair of surfaces is integrated: points on the slave facets.

Between lines the facets are cut where corners of the other side face them: what is integrated is
smooth on each piece, and the integral exact for straight facets (mortar). Between surfaces a rule
with many points stands in for the cutting.
"""

from __future__ import annotations

from dataclasses import dataclass

import basix
import numpy as np
from scipy.spatial import cKDTree

from .side import Side

#: Degree of the rule on the facets of a surface in space, and points on a piece of a line.
SURFACE_DEGREE = {"triangle": 8, "quadrilateral": 11}
PIECE_POINTS = {1: 2, 2: 4}


@dataclass(frozen=True)
class Points:
    """Integration points: facet (q,), local coordinates (q, d - 1), weights there (q,)."""

    facet: np.ndarray
    xi: np.ndarray
    weight: np.ndarray


def whole(side: Side) -> Points:
    """A fixed rule on whole facets."""
    if side.cell == "interval":
        x, w = _gauss(PIECE_POINTS[side.degree])
        x = x[:, None]
    else:
        rule = getattr(basix.CellType, side.cell), SURFACE_DEGREE[side.cell]
        x, w = basix.make_quadrature(*rule)
    m = len(side.cells)
    facet, xi = np.repeat(np.arange(m), len(w)), np.tile(x, (m, 1))
    return Points(facet, xi, np.tile(w, m))


def pieces(slave: Side, slave_nodes: np.ndarray, master: Side, master_nodes: np.ndarray) -> Points:
    """Points on the pieces into which the corners of the master cut the facets of a line.

    Args:
        slave, master: the sides.
        slave_nodes, master_nodes: present places of their nodes, (N, d).
    """
    ends = slave_nodes[slave.corners]  # (m, 2, d)
    along = ends[:, 1] - ends[:, 0]
    square = (along**2).sum(axis=1)
    corners = master_nodes[np.unique(master.corners)]
    facet, corner = _near(ends.mean(axis=1), 0.5 * np.sqrt(square) + master.size, corners)
    s = ((corners[corner] - ends[facet, 0]) * along[facet]).sum(axis=1) / square[facet]
    cut = (s > 1e-9) & (s < 1 - 1e-9)
    m = len(along)
    facet = np.concatenate([np.arange(m), np.arange(m), facet[cut]])
    s = np.concatenate([np.zeros(m), np.ones(m), s[cut]])
    order = np.lexsort((s, facet))
    facet, s = facet[order], s[order]
    length = np.where(facet[1:] == facet[:-1], np.diff(s), 0.0)
    kept = np.flatnonzero(length > 1e-10)
    x, w = _gauss(PIECE_POINTS[max(slave.degree, master.degree)])
    xi = (s[kept, None] + length[kept, None] * x).reshape(-1, 1)
    return Points(np.repeat(facet[kept], len(w)), xi, (length[kept, None] * w).ravel())


def _near(centres: np.ndarray, radii: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, ...]:
    """Pairs (centre, point) closer than the radii."""
    found = cKDTree(points).query_ball_point(centres, radii)
    count = np.fromiter(map(len, found), dtype=np.int64, count=len(found))
    flat = np.fromiter((i for each in found for i in each), dtype=np.int64, count=count.sum())
    return np.repeat(np.arange(len(centres)), count), flat


def _gauss(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss's rule on [0, 1]."""
    x, w = np.polynomial.legendre.leggauss(n)
    return (x + 1) / 2, w / 2
