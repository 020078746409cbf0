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

from .search import Near, Spheres
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


class Cuts:
    """Points on the pieces into which the corners of the master cut the facets of a line."""

    def __init__(self, slave: Side, master: Side) -> None:
        self._slave, self._master = slave, master
        self._rule = _gauss(PIECE_POINTS[max(slave.degree, master.degree)])
        self._corners = np.unique(master.corners)
        self._near = Near()

    def points(self, slave_nodes: np.ndarray, master_nodes: np.ndarray) -> Points:
        """Those of the present places of the nodes, (N, d)."""
        ends = slave_nodes[self._slave.corners]  # (m, 2, d)
        along = ends[:, 1] - ends[:, 0]
        square = (along**2).sum(axis=1)
        facets = Spheres(ends.sum(axis=1) / 2, 0.5 * np.sqrt(square) + self._master.size)
        corners = Spheres(master_nodes[self._corners], np.zeros(len(self._corners)))
        facet, corner = self._near(facets, corners)
        corner = corners.middles[corner]
        close = ((corner - facets.middles[facet]) ** 2).sum(axis=1) <= facets.radii[facet] ** 2
        s = ((corner - ends[facet, 0]) * along[facet]).sum(axis=1) / square[facet]
        cut = close & (s > 1e-9) & (s < 1 - 1e-9)
        each = np.arange(len(along))
        facet = np.concatenate([each, each, facet[cut]])
        s = np.concatenate([np.zeros(len(along)), np.ones(len(along)), s[cut]])
        order = np.lexsort((s, facet))
        facet, s = facet[order], s[order]
        length = np.where(facet[1:] == facet[:-1], s[1:] - s[:-1], 0.0)
        kept = np.flatnonzero(length > 1e-10)
        x, w = self._rule
        xi = (s[kept, None] + length[kept, None] * x).reshape(-1, 1)
        return Points(np.repeat(facet[kept], len(w)), xi, (length[kept, None] * w).ravel())


def _gauss(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss's rule on [0, 1]."""
    x, w = np.polynomial.legendre.leggauss(n)
    return (x + 1) / 2, w / 2
