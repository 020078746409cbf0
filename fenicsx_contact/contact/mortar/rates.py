# SPDX-License-Identifier: LGPL-3.0-or-later
"""How the operators of a pair change when its nodes move: what Newton's method needs to know.

A ray x + alpha n = x_m(xi) moves with its facet and its partner's,

    M (dxi, dalpha) = dx + alpha dn - dx_m,

and with xi the master's share of J, with alpha the gap. The ends of the pieces move too, but what
is integrated is continuous there and they drop out. Sparse matrices act on the components of all
nodes, (N d,), the slave's before the master's.
"""

from __future__ import annotations

import numpy as np

from .matrices import Matrix, gather
from .mortar import Pairing


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
        slave, d = pair.slave, pair.slave.dim
        xs = pair.places[: len(slave.nodes)]
        unit = pieces.unit[:, 0]
        project = np.eye(d) - unit[:, :, None] * unit[:, None, :]
        turn = pieces.side.normal_rates(xs, pieces.facet, pieces.slopes)
        turn = (project / pieces.length[:, None, None])[:, None] @ turn  # of n, (p, k, d, d)

        # what the right-hand side is of the nodes that guide, and with it M^-1
        share = [pieces.guide[:, :, None, :, None], -pieces.their_guide[:, :, None, :, None]]
        mine, theirs = (each * pieces.inverse[:, :, :, None] for each in share)
        turned = pieces.inverse @ np.swapaxes(turn, 1, 2).reshape(len(turn), 1, d, -1)
        turned = turned.reshape(*turned.shape[:3], -1, d)
        mine = mine + pieces.distance[:, :, None, None, None] * turned
        own, other = pieces.values.shape[2], pieces.their_values.shape[2]
        moved = np.concatenate([_widened(mine, own), _widened(theirs, other)], axis=3)
        slide, rise = moved[:, :, :-1], moved[:, :, -1]  # of xi (p, g, d - 1, k, d), of alpha
        if not pieces.aligned:  # d (n . (x_m - x_s))
            tangents = pieces.their_slopes @ pair.places[pair.nodes[:, own:]]
            along = (tangents * pieces.unit).sum(axis=3)  # (d - 1, p, g)
            rise = (np.moveaxis(along, 0, 2)[..., None, None] * slide).sum(axis=2)
            rise -= pair.both[..., None] * pieces.unit[:, :, None]
            bent = np.einsum("pgi,pkil->pgkl", pair.apart, turn)
            rise[:, :, : bent.shape[2]] += bent
        self._columns = (pair.nodes[:, :, None] * d + np.arange(d)).reshape(len(turn), -1)
        points, width = slide.shape[1] * (d - 1), self._columns.shape[1]
        self._slide = slide.reshape(len(slide), points, width)
        self._corners = slave.corners[pieces.facet]
        self.gap = gather(
            -np.swapaxes(pair.shares, 1, 2) @ rise.reshape(*rise.shape[:2], width),
            self._corners[:, :, None],
            self._columns[:, None],
            (pair.n, pair.total * d),
            pair.dense,
        )
        self.normal = self._normals(xs)

    def _normals(self, xs: np.ndarray) -> Matrix:
        pair, d = self._pair, self._pair.slave.dim
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
        rows = (self._corners[:, :, None] * d + np.arange(d)).reshape(len(entries), -1)
        shape = (pair.n * d, pair.total * d)
        return gather(entries, rows[:, :, None], self._columns[:, None], shape, pair.dense)

    def spread(self, force: np.ndarray) -> Matrix:
        """Derivative of J' f at fixed nodal forces f (n, d), sparse (N d, N d)."""
        pair, d = self._pair, self._pair.slave.dim
        at_points = pair.shares @ force[self._corners]  # (p, g, d)
        slopes = np.moveaxis(pair.pieces.their_slopes, 0, 2)
        shares = slopes[..., None] * at_points[:, :, None, None]  # (p, g, d - 1, k, d)
        entries = -np.swapaxes(self._by_row(shares), 1, 2) @ self._slide
        own = self._columns[:, pair.pieces.values.shape[2] * d :]
        shape = (pair.total * d,) * 2
        return gather(entries, own[:, :, None], self._columns[:, None], shape, pair.dense)

    def _by_row(self, shares: np.ndarray) -> np.ndarray:
        """(p, g, d - 1, k, d) as (p, g (d - 1), k d), in the rows of the slides."""
        p, g, t, k, d = shares.shape
        return shares.reshape(p, g * t, k * d)


def _widened(array: np.ndarray, k: int) -> np.ndarray:
    """With as many nodes on its axis 3 as the field has; what they have not got is 0."""
    if array.shape[3] == k:
        return array
    wide = np.zeros((*array.shape[:3], k, array.shape[4]))
    wide[:, :, :, : array.shape[3]] = array
    return wide
