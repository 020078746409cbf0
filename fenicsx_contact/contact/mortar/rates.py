# SPDX-License-Identifier: LGPL-3.0-or-later
"""How the operators of a pair change when its nodes move: what Newton's method needs to know.

With a point on the master's facet (motion.py) move the master's share of J and the gap. The ends of
the pieces move too, but what is integrated is continuous there and they drop out; not, in space,
where the master itself ends (cover.py). Matrices act on the components of all nodes, (N d,), the
slave's before the master's.
"""

from __future__ import annotations

import numpy as np

from .cover import Cover
from .matrices import Matrix, by_component, by_point, gather
from .mortar import Pairing
from .motion import Motion


class Rates:
    """Derivatives of a pairing in its present places.

    Args:
        pair: the pairing; it must not be updated while these rates are in use.

    Attributes:
        gap: derivative of the gaps, sparse (n, N d).
        normal: derivative of the nodal normals, sparse (n d, N d).
    """

    def __init__(self, pair: Pairing) -> None:
        self._pair, pieces = pair, pair.pieces
        self._motion = motion = Motion(pair, pieces)
        p, g, t, width = motion.slide.shape
        self._slide = motion.slide.reshape(p, g * t, width)
        self._corners = pair.slave.corners[pieces.facet]
        self.gap = gather(
            np.swapaxes(pair.shares, 1, 2) @ motion.fall,
            self._corners[:, :, None],
            motion.columns[:, None],
            (pair.n, pair.total * pair.slave.dim),
            pair.dense,
        )
        self.normal = self._normals()
        self._cover: Cover | None = None
        if pair.brink is not None and len(pair.brink.across):
            self._cover, self._edge = Cover(pair, pair.brink), pair.brink.points
            inside, edge = (pair.depths(each)[..., None] for each in (pieces, self._edge))
            self.gap = self.gap + self._cover.means(inside, edge, pair.gap[:, None])

    def _normals(self) -> Matrix:
        pair, d = self._pair, self._pair.slave.dim
        xs = pair.places[: len(pair.slave.nodes)]
        m, g, c = pair.mean_weight.shape
        turn = pair.slave.normal_rates(xs, pair.rule_facets, pair.rule_slopes)  # (q, k, d, d)
        turn = np.swapaxes(pair.mean_weight, 1, 2) @ turn.reshape(m, g, -1)
        turn = turn.reshape(m, c, -1, d, d)
        corners, nodes = pair.slave.corners, pair.slave.cells
        project = np.eye(d) - pair.normal[:, :, None] * pair.normal[:, None, :]
        project /= pair.mean_length[:, None, None]
        entries = project[corners][:, :, None] @ turn  # (m, c, k, d, d)
        rows = (corners[:, :, None] * d + np.arange(d))[:, :, None, :, None]
        columns = (nodes[:, :, None] * d + np.arange(d))[:, None, :, None, :]
        return gather(entries, rows, columns, (pair.n * d, pair.total * d), pair.dense)

    def jump(self, velocity: np.ndarray) -> Matrix:
        """Derivative of the nodal jumps J v at fixed velocities (N, d), sparse (n d, N d)."""
        pair, d = self._pair, self._pair.slave.dim
        theirs = velocity[pair.nodes[:, pair.pieces.values.shape[2] :]]
        sheared = np.moveaxis(pair.pieces.their_slopes @ theirs, 0, 2)  # (p, g, d - 1, d)
        shares = pair.shares[:, :, None, :, None] * sheared[:, :, :, None]
        entries = -np.swapaxes(self._by_row(shares), 1, 2) @ self._slide
        rows = (self._corners[:, :, None] * d + np.arange(d)).reshape(entries.shape[:2])
        shape = (pair.n * d, pair.total * d)
        jump = gather(entries, rows[:, :, None], self._motion.columns[:, None], shape, pair.dense)
        if self._cover:
            sides = pair.pieces, self._edge
            inside, edge = (each.both @ velocity[pair.nodes_of(each)] for each in sides)
            jump = jump + self._cover.means(inside, edge, pair.operator @ velocity)
        return jump

    def spread(self, force: np.ndarray, areas: bool = False) -> Matrix:
        """Derivative of J' f at fixed nodal forces f (n, d), sparse (N d, N d); or of those that
        grow with the ``areas`` of the nodes."""
        pair, d = self._pair, self._pair.slave.dim
        at_points = pair.shares @ force[self._corners]  # (p, g, d)
        slopes = np.moveaxis(pair.pieces.their_slopes, 0, 2)
        shares = slopes[..., None] * at_points[:, :, None, None]  # (p, g, d - 1, k, d)
        entries = -np.swapaxes(self._by_row(shares), 1, 2) @ self._slide
        columns, shape = self._motion.columns, (pair.total * d,) * 2
        own = columns[:, pair.pieces.values.shape[2] * d :]
        spread = gather(entries, own[:, :, None], columns[:, None], shape, pair.dense)
        if self._cover:
            spread = spread + self._cover.forces(force)
            if not areas:
                pressure = (pair.share[:, None] * force)[:, :, None]
                shrunk = by_point(pressure, self._cover.areas())
                spread = spread - by_component(pair.operator, d).T @ shrunk
        return spread

    def _by_row(self, shares: np.ndarray) -> np.ndarray:
        """(p, g, d - 1, k, d) as (p, g (d - 1), k d), in the rows of the slides."""
        p, g, t, k, d = shares.shape
        return shares.reshape(p, g * t, k * d)
