# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where a pair of lines is integrated: points on pieces of the slave's facets.

The facets are cut where corners of the other side face them: what is integrated is smooth on each
piece, and the integral exact for straight facets (mortar).
"""

from __future__ import annotations

from dataclasses import dataclass

import basix
import numpy as np

from .clipping import gauss
from .itself import Admits
from .partners import Partners, Rays
from .pieces import Pieces
from .search import Near, Spheres
from .side import TURN, Side, unit_and_length
from .stance import Places, Stance, look

#: Points on a piece of a line.
PIECE_POINTS = {1: 2, 2: 4}


@dataclass(frozen=True)
class Points:
    """Integration points: facet (q,), local coordinates (q, d - 1), weights there (q,)."""

    facet: np.ndarray
    xi: np.ndarray
    weight: np.ndarray


def whole(side: Side) -> Points:
    """A rule on whole facets, exact for their normals times linear functions."""
    if side.cell == "interval":
        x, w = gauss(PIECE_POINTS[side.degree])
        x = x[:, None]
    else:
        degree = 2 * side.degree + (side.cell == "quadrilateral")
        x, w = basix.make_quadrature(getattr(basix.CellType, side.cell), degree)
    m = len(side.cells)
    facet, xi = np.repeat(np.arange(m), len(w)), np.tile(x, (m, 1))
    return Points(facet, xi, np.tile(w, m))


class Lines:
    """Finds what the facets of two lines share, by rays along the slave's normals."""

    def __init__(self, slave: Side, master: Side, admits: Admits) -> None:
        self._sides = slave, master
        self._cuts, self._partners = Cuts(slave, master), Partners(slave, master, admits)

    def meet(self, places: Places, reach: np.ndarray, stance: Stance) -> tuple[Pieces, None]:
        """Points on the pieces in the present places of the nodes, (N, 2) of slave and master, each
        as a piece, not farther apart than ``reach`` [m] of each slave facet."""
        (slave, master), xs = self._sides, places[0]
        points = self._cuts.points(places, stance)
        stance = stance.of(points.facet)
        values, slopes = slave.shape(points.xi)
        corner = values if slave.degree == 1 else slave.linear_shape(points.xi)
        x = np.einsum("qk,qkj->qj", values, xs[slave.cells[points.facet]])
        unit, length = unit_and_length(slave.normals(xs, points.facet, slopes))
        look(unit, length, stance, self._sides, places, points.facet)
        hits = self._partners.meet(Rays(x, unit, points.facet, reach), places)

        on = hits.ray
        facet, values, slopes = points.facet[on], values[on][:, None], slopes[:, on]
        weight = points.weight[on] * slave.reference_measure(facet, slopes)
        weight *= slave.breadth(facet, values[:, 0])
        theirs, their_slopes = (each[..., None, :] for each in master.shape(hits.xi))
        pieces = Pieces(
            facet=facet, other=hits.facet, weight=weight[:, None], corner=corner[on][:, None],
            values=values, their_values=theirs, their_slopes=their_slopes,
            guide=values, their_guide=theirs, aligned=True, distance=hits.distance[:, None],
            unit=unit[on][:, None], side=slave, slopes=slopes, length=length[on],
            stance=stance.of(on), inverse=hits.inverse[:, None],
        )  # fmt: skip
        return pieces, None


class Cuts:
    """Points on the pieces into which the corners of the master cut the facets of a line."""

    def __init__(self, slave: Side, master: Side) -> None:
        self._sides = slave, master
        self._rule = gauss(PIECE_POINTS[max(slave.degree, master.degree)])
        self._corners = np.unique(master.corners)
        self._near = Near()

    def points(self, places: Places, stance: Stance) -> Points:
        """Those of the present places of the nodes, (N, d)."""
        (slave, master), nodes = self._sides, places[1]
        ends = places[0][slave.corners]  # (m, 2, d)
        along = ends[:, 1] - ends[:, 0]
        square = (along**2).sum(axis=1)
        # what is cut are their chords, along their own normals or those on which they stand
        ray = along @ TURN.T
        look(ray, np.empty(len(ray)), stance, self._sides, places, np.arange(len(ray)))
        across = ray @ TURN
        height = (across * along).sum(axis=1)
        facets = Spheres(ends.sum(axis=1) / 2, 0.5 * np.sqrt(square) + master.size)
        corners = Spheres(nodes[self._corners], np.zeros(len(self._corners)))
        facet, corner = self._near(facets, corners)
        corner = corners.middles[corner]
        close = ((corner - facets.middles[facet]) ** 2).sum(axis=1) <= facets.radii[facet] ** 2
        s = ((corner - ends[facet, 0]) * across[facet]).sum(axis=1) / height[facet]
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
