# SPDX-License-Identifier: LGPL-3.0-or-later
"""How means over what is covered change where the master's edge moves over the slave's facets.

By Leibniz's rule a moving edge gives and takes what it passes: with dA its way times its length,
the mean  (J v)_i = 1/a_i int psi_i v  of a field v, psi = D M^-1 phi on each facet, changes by

    1/a_i  oint [phi_i (c_i - (J v)_i) + psi_i (v - sum_k c_k phi_k)] dA,   c = M^-1 int phi v,

the field's best linear fit there. A linear field that fits its means changes nothing. Where phi_j
is of a corner of what is covered, which moves on by the way ds, phi stays behind, and the fit is
read elsewhere:

    dphi_i = -phi_i' phi_j ds,    dc_i = delta_ij sum_k c_k phi_k' ds.
"""

from __future__ import annotations

import numpy as np

from .matrices import Matrix, add_up, by_component, gather
from .mortar import Pairing
from .motion import Motion
from .pieces import Brink


class Cover:
    """Derivatives of a pair's means by the moving edges of the master, by all nodes, (N d,)."""

    def __init__(self, pair: Pairing, brink: Brink) -> None:
        self._pair, points = pair, brink.points
        self._points, motion = points, Motion(pair, brink.guides)
        self._columns, self._facet = motion.columns, points.facet
        self._corners = pair.slave.corners[points.facet]
        across = brink.across * points.weight[..., None]
        self._way = (across[:, :, None] @ motion.slide)[:, :, 0]  # dA, (p, g, k d)
        self._psi = points.corner @ pair.dual[points.facet]
        area = (points.corner[:, 0] * pair.lumped[points.facet]).sum(axis=1, keepdims=True)
        self._pull = area * brink.pull  # (p, corners)

    def means(self, pieces: np.ndarray, edge: np.ndarray, nodal: np.ndarray) -> Matrix:
        """Those of the means of a field of e components: of its values on the pieces (p, g, e), on
        the edges, and of the means (n, e); a matrix (n e, N d)."""
        pair, phi, e = self._pair, self._points.corner, nodal.shape[1]
        fit = self._fit(pieces)[self._facet]
        rest = (edge - phi @ fit)[:, :, None]
        off, pull = fit - nodal[self._corners], self._pull[..., None]
        lever = phi[..., None] * (off + (pull * fit).sum(axis=1, keepdims=True))[:, None]
        lever += self._psi[..., None] * rest - (pull * off)[:, None]
        lever *= pair.share[self._corners][:, None, :, None]
        rows = self._corners[:, :, None] * e + np.arange(e)
        return self._gather(lever, rows, pair.n * e)

    def areas(self) -> Matrix:
        """Those of the areas a_i, (n, N d)."""
        lever = self._points.corner - self._pull[:, None]
        return self._gather(lever[..., None], self._corners[:, :, None], self._pair.n)

    def forces(self, force: np.ndarray, pressed: np.ndarray) -> Matrix:
        """Those of J' f of forces that grow with the areas, (N d, N d): those spread by the means,
        (n, d), and those along the normals of the facets, (n,)."""
        pair, pieces, (n, d) = self._pair, self._pair.pieces, force.shape
        m, c = pair.slave.corners.shape
        moments = np.swapaxes(pieces.corner * pieces.weight[..., None], 1, 2) @ pieces.both
        fits = (pair.inverse_mass[pieces.facet] @ moments)[..., None]
        rows = (pieces.facet[:, None] * c + np.arange(c))[:, :, None, None]
        columns, shape = pair.nodes[:, None, :, None], (m * c, pair.total)
        fit = by_component(gather(fits, rows, columns, shape, pair.dense), d)
        spread = self._spread(force, fit, np.ones(d))
        fits, columns = fits * pieces.unit[:, :, None], columns * d + np.arange(d)
        rises = gather(fits, rows, columns, (m * c, pair.total * d), pair.dense)
        return spread + self._spread(pressed.reshape(n, 1), rises, self._points.unit)

    def _spread(self, force: np.ndarray, fit: Matrix, direction: np.ndarray) -> Matrix:
        """Of forces (n, e) whose means fit so on the facets, (m c e, N d), and that act where they
        are in a direction, (p, g, d)."""
        pair, phi, e = self._pair, self._points.corner, force.shape[1]
        m, c = pair.slave.corners.shape
        d = pair.slave.dim
        pressure = (pair.share[:, None] * force)[self._corners]  # (p, c, e)
        pulled = self._psi @ pressure  # (p, g, e)
        rows = pair.nodes_of(self._points)[:, :, None] * d + np.arange(d)
        acting = self._points.both[..., None] * (pulled * direction)[:, :, None]
        direct = self._gather(acting, rows, pair.total * d)
        lever = phi[..., None] * (pressure[:, None] - pulled[:, :, None])
        lever += self._pull[:, None, :, None] * ((phi @ pressure)[:, :, None] - pressure[:, None])
        rows = (self._facet[:, None] * c + np.arange(c))[:, :, None] * e + np.arange(e)
        return direct + fit.T @ self._gather(lever, rows, m * c * e)

    def _fit(self, values: np.ndarray) -> np.ndarray:
        """The best linear fit on each facet of values on the pieces, (m, corners, e)."""
        pair, pieces = self._pair, self._pair.pieces
        m, c = pair.slave.corners.shape
        e = values.shape[2]
        moments = np.swapaxes(pieces.corner * pieces.weight[..., None], 1, 2) @ values
        sums = add_up(moments.reshape(len(moments), c * e), pieces.facet, m)
        return pair.inverse_mass @ sums.reshape(m, c, e)

    def _gather(self, lever: np.ndarray, rows: np.ndarray, n: int) -> Matrix:
        """What levers (p, g, c, e) on the edge give the rows (p, c, e) of n."""
        p, g, c, e = lever.shape
        entries = np.swapaxes(lever.reshape(p, g, c * e), 1, 2) @ self._way
        rows, shape = rows.reshape(p, c * e, 1), (n, self._pair.total * self._pair.slave.dim)
        return gather(entries, rows, self._columns[:, None], shape, self._pair.dense)
