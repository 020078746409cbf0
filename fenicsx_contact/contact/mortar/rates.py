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
        self._pair = pair
        slave, d = pair.slave, pair.slave.dim
        xs = pair.places[: len(slave.nodes)]
        project = np.eye(d) - pair.unit[:, :, None] * pair.unit[:, None, :]
        turn = slave.normal_rates(xs, pair.facet, pair.slopes)
        turn = np.einsum("qij,qkjl->qkil", project / pair.length[:, None, None], turn)
        mine = pair.distance[:, None, None, None] * turn
        mine += pair.values[:, :, None, None] * np.eye(d)
        theirs = -pair.their_values[:, :, None, None] * np.eye(d)
        local = np.concatenate([mine, theirs], axis=1)  # (q, k, d, d)
        moved = np.einsum("qij,qkjl->qkil", pair.inverse, local)
        self._slide, rise = moved[:, :, :-1], moved[:, :, -1]  # of xi and of alpha
        self._columns = (pair.nodes[:, :, None] * d + np.arange(d)).reshape(len(local), -1)
        rise = rise.reshape(len(local), -1)
        corners = pair.slave.corners[pair.facet]
        self.gap = gather(
            -pair.shares[:, :, None] * rise[:, None],
            corners[:, :, None],
            self._columns[:, None],
            (pair.n, pair.total * d),
            pair.dense,
        )
        self.normal = self._normals(xs)

    def _normals(self, xs: np.ndarray) -> Matrix:
        pair, d = self._pair, self._pair.slave.dim
        facets = pair.rule_facets
        turn = pair.slave.normal_rates(xs, facets, pair.rule_slopes)  # (q, k, d, d)
        corners, nodes = pair.slave.corners[facets], pair.slave.cells[facets]
        project = np.eye(d) - pair.normal[:, :, None] * pair.normal[:, None, :]
        project /= pair.mean_length[:, None, None]
        project = pair.mean_weight[:, :, None, None] * project[corners]
        entries = np.einsum("qcij,qkjl->qcikl", project, turn)
        rows = (corners[:, :, None] * d + np.arange(d))[:, :, :, None, None]
        columns = (nodes[:, :, None] * d + np.arange(d))[:, None, None]
        return gather(entries, rows, columns, (pair.n * d, pair.total * d), pair.dense)

    def jump(self, velocity: np.ndarray) -> Matrix:
        """Derivative of the nodal jumps J v at fixed velocities (N, d), sparse (n d, N d)."""
        pair, d = self._pair, self._pair.slave.dim
        sheared = self._sheared(velocity)  # (q, d - 1, d)
        moved = np.einsum("qti,qktl->qikl", sheared, self._slide)
        entries = -pair.shares[:, :, None, None, None] * moved[:, None]
        rows = (pair.slave.corners[pair.facet][:, :, None] * d + np.arange(d))[..., None]
        flat = entries.reshape(*entries.shape[:3], -1)
        shape = (pair.n * d, pair.total * d)
        return gather(flat, rows, self._columns[:, None, None], shape, pair.dense)

    def _sheared(self, values: np.ndarray) -> np.ndarray:
        """Derivatives by xi of the master's field, (q, d - 1, d)."""
        pair = self._pair
        theirs = values[pair.nodes[:, pair.values.shape[1] :]]
        return np.einsum("tqk,qkj->qtj", pair.their_slopes, theirs)

    def spread(self, force: np.ndarray) -> Matrix:
        """Derivative of J' f at fixed nodal forces f (n, d), sparse (N d, N d)."""
        pair, d = self._pair, self._pair.slave.dim
        at_points = np.einsum("qc,qcj->qj", pair.shares, force[pair.slave.corners[pair.facet]])
        moved = np.einsum("tqb,qktl->qbkl", pair.their_slopes, self._slide)
        entries = -at_points[:, None, :, None, None] * moved[:, :, None]
        own = self._columns.reshape(len(entries), -1, d)[:, pair.values.shape[1] :]
        flat = entries.reshape(*entries.shape[:3], -1)
        shape = (pair.total * d,) * 2
        return gather(flat, own[..., None], self._columns[:, None, None], shape, pair.dense)
