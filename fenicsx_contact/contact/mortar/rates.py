# SPDX-License-Identifier: LGPL-3.0-or-later
"""How the operators of a pair change when its nodes move: what Newton's method needs to know.

With a point on the master's facet (motion.py) move the master's share of J and the gap. The ends of
the pieces move too, but what is integrated is continuous there and they drop out; not, in space,
where the master itself ends (cover.py). Matrices act on the components of all nodes, (N d,), the
slave's before the master's.

The jumps are  J v = w + n (r - n . w),  w: the means of the velocities without regard to normals,
r: what rises along those of the facets; the transpose spreads  J' f = W' (f - n f_n) + R' f_n.

Each process has the rows of its nodes, and of what is spread its share, that of its facets and
nodes.
"""

from __future__ import annotations

import numpy as np

from ...base.vectors import dot
from .cover import Cover
from .idle import without
from .matrices import Matrix, along, by_component, by_point, gather
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
        self._corners = pair.rows[pieces.facet]
        sum_up = np.swapaxes(pair.shares, 1, 2)  # (p, corners, g)
        columns, across = motion.columns[:, None], pair.total * pair.slave.dim
        gap = gather(
            sum_up @ motion.fall, self._corners[:, :, None], columns, (pair.n, across), pair.dense
        )
        turn = motion.turn[:, None] * sum_up.sum(axis=2)[..., None, None]  # (p, corners, d, k d)
        columns = columns[:, :, None, motion.turning]
        rows, shape = self._rows(), (pair.normal.size, across)
        mean = gather(turn, rows[..., None], columns, shape, pair.dense)  # of m_i
        self._cover: Cover | None = None
        if pair.brink is not None and pair.shared.anywhere(pair.brink.moves):
            self._cover, self._edge = Cover(pair, pair.brink), pair.brink.points
            sides, lengths = (pieces, self._edge), pair.length[:, None]
            inside, edge = (pair.depths(each)[..., None] for each in sides)
            gap = gap + self._cover.means(inside, edge, pair.gap[:, None] * lengths)
            inside, edge = (
                np.broadcast_to(each.unit, (*each.distance.shape, pair.slave.dim)) for each in sides
            )
            mean = mean + self._cover.means(inside, edge, pair.normal * lengths)
        gap, mean = pair.shared.rows(gap), pair.shared.rows(mean)
        n = pair.normal
        self._stretch = along(n, mean)  # of |m_i|
        self.gap = self._per_length(gap, pair.gap)
        project = np.eye(pair.slave.dim) - n[:, :, None] * n[:, None]
        project *= ~pair.idle[:, None]
        self.normal = by_point(project / pair.length[:, None, None], mean)

    @property
    def areas(self) -> Matrix | None:
        """Derivative of the areas of the nodes, (n, N d); None where the master ends nowhere."""
        return self._pair.shared.rows(self._cover.areas()) if self._cover else None

    def _rows(self) -> np.ndarray:
        """Rows of the components at the corners, (p, corners, d)."""
        d = self._pair.slave.dim
        return self._corners[:, :, None] * d + np.arange(d)

    def _per_length(self, matrix: Matrix, values: np.ndarray) -> Matrix:
        """Derivative of values (n,) that are per |m_i|, from that of what they are of it."""
        each = 1 / self._pair.length[:, None, None]
        return by_point(each, matrix) - by_point(each * values[:, None, None], self._stretch)

    def jump(self, velocity: np.ndarray) -> Matrix:
        """Derivative of the nodal jumps J v at fixed velocities (N, d), sparse (n d, N d)."""
        pair, n = self._pair, self._pair.normal
        total = pair.shared.sum
        mean, rise = total(pair.means @ velocity), total(pair.rises @ velocity.ravel())
        means, rises = self._seen(velocity, mean, rise)
        more = (rise - dot(n, mean))[:, None, None] * np.eye(n.shape[1])
        more -= n[:, :, None] * mean[:, None]
        jump = means + pair.at_normals(rises - along(n, means)) + by_point(more, self.normal)
        return without(jump, pair.idle)

    def _seen(
        self, velocity: np.ndarray, mean: np.ndarray, rise: np.ndarray
    ) -> tuple[Matrix, Matrix]:
        """Derivatives of w (n d, N d) and r (n, N d) at fixed velocities, from both."""
        pair, pieces, corners = self._pair, self._pair.pieces, self._corners[:, :, None]
        theirs = velocity[pair.nodes[:, pieces.values.shape[2] :]]
        sheared = np.moveaxis(pieces.their_slopes @ theirs, 0, 2)  # (p, g, d - 1, d)
        shares = pair.shares[:, :, None, :, None] * sheared[:, :, :, None]
        slid = -np.swapaxes(self._by_row(shares), 1, 2) @ self._slide
        rows, columns = self._rows(), self._motion.columns[:, None]
        shape = (pair.normal.size, pair.total * velocity.shape[1])
        means = gather(slid, rows.reshape(*slid.shape[:2], 1), columns, shape, pair.dense)
        # the same along the normals, and what these turn towards
        up = (slid.reshape(*rows.shape, slid.shape[2]) * pieces.unit[:, :, :, None]).sum(axis=2)
        apart = np.swapaxes(pair.shares, 1, 2) @ (pieces.both @ velocity[pair.nodes])  # (p, c, d)
        turn = self._motion.turn
        up[:, :, self._motion.turning] += apart @ turn
        rises = gather(up, corners, columns, (pair.n, shape[1]), pair.dense)
        if self._cover:
            sides = pieces, self._edge
            inside, edge = (each.both @ velocity[pair.nodes_of(each)] for each in sides)
            means = means + self._cover.means(inside, edge, mean)
            up, at = ((v * x.unit).sum(axis=2)[..., None] for v, x in zip((inside, edge), sides))
            rises = rises + self._cover.means(up, at, (rise * pair.length)[:, None])
        means, rises = pair.shared.rows(means), pair.shared.rows(rises)
        return means, self._per_length(rises, rise)

    def spread(self, force: np.ndarray, areas: bool = False) -> Matrix:
        """Derivative of J' f at fixed nodal forces f (n, d), sparse (N d, N d); or of those that
        grow with the ``areas`` of the nodes. Of several processes the shares add up to it."""
        pair, d, n = self._pair, self._pair.slave.dim, self._pair.normal
        pieces, motion, shape = pair.pieces, self._motion, (pair.total * d,) * 2
        normal = dot(force, n)
        tangential, pressed = force - normal[:, None] * n, normal / pair.length
        up = pair.shares @ pressed[self._corners][..., None]  # (p, g, 1)
        at_points = pair.shares @ tangential[self._corners] + up * pieces.unit  # (p, g, d)
        slopes = np.moveaxis(pieces.their_slopes, 0, 2)
        shares = slopes[..., None] * at_points[:, :, None, None]  # (p, g, d - 1, k, d)
        slid = -np.swapaxes(self._by_row(shares), 1, 2) @ self._slide
        columns = motion.columns
        rows = columns[:, : pieces.both.shape[2] * d]
        acting = np.zeros((*rows.shape, columns.shape[1]))
        acting[:, pieces.values.shape[2] * d :] = slid
        # the normals of the facets turn, and those of the nodes
        pushed = (pieces.both * up).sum(axis=1)  # (p, k)
        turned = pushed[:, :, None, None] * motion.turn[:, None]  # (p, k, d, corners d)
        acting[:, :, motion.turning] += turned.reshape(*rows.shape, motion.turn.shape[2])
        spread = gather(acting, rows[:, :, None], columns[:, None], shape, pair.dense)
        if self._cover:
            spread = spread + self._cover.forces(tangential, pressed)
        more = normal[:, None, None] * np.eye(d) + n[:, :, None] * force[:, None]
        spread = spread - by_component(pair.means, d).T @ by_point(more, self.normal)
        more = along(force, self.normal) - by_point(pressed[:, None, None], self._stretch)
        spread = spread + pair.rises.T @ more
        if not areas and (grown := self.areas) is not None:
            pressure = (pair.share[:, None] * force)[:, :, None]
            spread = spread - pair.operator.T @ by_point(pressure, grown)
        return spread

    def _by_row(self, shares: np.ndarray) -> np.ndarray:
        """(p, g, d - 1, k, d) as (p, g (d - 1), k d), in the rows of the slides."""
        p, g, t, k, d = shares.shape
        return shares.reshape(p, g * t, k * d)
