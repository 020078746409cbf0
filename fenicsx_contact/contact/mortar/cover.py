# SPDX-License-Identifier: LGPL-3.0-or-later
"""How means over what is covered change where the master's edge moves over the slave's facets.

By Leibniz's rule a moving edge gives and takes what it passes: with dA its way times its length,
the mean  (J v)_i = 1/a_i int psi_i v  of a field v, psi = D M^-1 phi on each facet, changes by

    1/a_i  oint [phi_i (c_i - (J v)_i) + psi_i (v - sum_k c_k phi_k)] dA,   c = M^-1 int phi v,

the field's best linear fit there. A linear field that fits its means changes nothing. Where the
part that bears moves on by the way ds, its functions change within their span, D with them, and the
fit is read elsewhere (parts.py):

    dphi_i = sum_k phi_k K_ki ds,    dD_i = sum_k K_ki D_k ds,    dc_i = -sum_k K_ik c_k ds.

What a held corner has of all this it lends to others, by H (lending.py).
"""

from __future__ import annotations

import numpy as np

from .matrices import Matrix, add_up, by_component, gather
from .mortar import Pairing
from .motion import Motion
from .pieces import Brink, Ends


class Cover:
    """Derivatives of a pair's means by the moving edges of the master, by all nodes, (N d,)."""

    def __init__(self, pair: Pairing, brink: Brink) -> None:
        self._pair, self._points = pair, brink.points
        self._corners = pair.rows[self._points.facet]
        self._psi = self._points.corner @ pair.dual[self._points.facet]
        self._lending = pair.lending[self._points.facet]
        motion = Motion(pair, brink.guides)
        across = brink.across * self._points.weight[..., None]
        self._edge = _Way(pair, self._points.facet, across, motion)  # dA
        self._end: _End | None = None
        if (ends := brink.ends) is not None:
            motion = motion if ends.guides is brink.guides else Motion(pair, ends.guides)
            self._end = _End(pair, ends, motion)

    def means(self, pieces: np.ndarray, edge: np.ndarray, nodal: np.ndarray) -> Matrix:
        """Those of the means of a field of e components: of its values on the pieces (p, g, e), on
        the edges, and of the means (n, e); a matrix (n e, N d)."""
        pair, phi, corners = self._pair, self._points.corner, self._pair.rows
        share, fits = pair.share[:, None], self._fit(pieces)
        fit = fits[self._points.facet]
        lever = phi[..., None] * fit[:, None]
        lever += self._psi[..., None] * (edge - phi @ fit)[:, :, None]
        back = np.swapaxes(self._lending, 1, 2)[:, None]
        lever = back @ lever - (phi @ self._lending)[..., None] * nodal[self._corners][:, None]
        lever *= share[self._corners][:, None]
        result = self._edge.gather(lever, corners, pair.n)
        if end := self._end:
            at, fit = corners[end.facet], fits[end.facet]
            lever = end.lent(end.grown * fit - end.area * (end.change @ fit))
            lever -= end.lent(end.grown) * nodal[at]
            result = result + end.gather((lever * share[at])[:, None], corners, pair.n)
        return result

    def areas(self) -> Matrix:
        """Those of the areas a_i, (n, N d)."""
        rows = self._pair.rows, self._pair.n
        result = self._edge.gather((self._points.corner @ self._lending)[..., None], *rows)
        if end := self._end:
            result = result + end.gather(end.lent(end.grown)[:, None], *rows)
        return result

    def forces(self, force: np.ndarray, pressed: np.ndarray) -> Matrix:
        """Those of J' f of forces that grow with the areas, (N d, N d): those spread by the means,
        (n, d), and those along the normals of the facets, (n,)."""
        pair, pieces, (n, d) = self._pair, self._pair.pieces, force.shape
        m, c = pair.rows.shape
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
        pair, phi, corners = self._pair, self._points.corner, self._pair.rows
        each = np.arange(corners.size).reshape(corners.shape), corners.size
        pressures = pair.share[:, None] * force
        pressure = self._lending @ pressures[self._corners]  # (p, c, e)
        pulled = self._psi @ pressure  # (p, g, e)
        acting = self._points.both[..., None] * (pulled * direction)[:, :, None]
        nodes = pair.nodes_of(self._points)
        direct = self._edge.gather(acting, nodes, pair.total, each=False)
        lever = phi[..., None] * (pressure[:, None] - pulled[:, :, None])
        result = self._edge.gather(lever, *each)
        if end := self._end:
            pressure = pair.lending[end.facet] @ pressures[corners[end.facet]]
            lever = end.grown * pressure - end.back @ (end.area * pressure)
            result = result + end.gather(lever[:, None], *each)
        return direct + fit.T @ result

    def _fit(self, values: np.ndarray) -> np.ndarray:
        """The best linear fit on each facet of values on the pieces, (m, corners, e)."""
        pair, pieces = self._pair, self._pair.pieces
        m, c = pair.rows.shape
        e = values.shape[2]
        moments = np.swapaxes(pieces.corner * pieces.weight[..., None], 1, 2) @ values
        sums = add_up(moments.reshape(len(moments), c * e), pieces.facet, m)
        return pair.inverse_mass @ sums.reshape(m, c, e)


class _Way:
    """How far points (p, g) of facets (p,) go across what ends there."""

    def __init__(
        self, pair: Pairing, facet: np.ndarray, across: np.ndarray, motion: Motion
    ) -> None:
        self.facet, self._columns, self._dense = facet, motion.columns[:, None], pair.dense
        self._way = (across[:, :, None] @ motion.slide)[:, :, 0]  # (p, g, k d)
        self._total = pair.total * pair.slave.dim

    def gather(self, lever: np.ndarray, rows: np.ndarray, n: int, each: bool = True) -> Matrix:
        """What levers (p, g, c, e) on these ways give to n rows of e components: to ``rows`` (m, c)
        of facets, or, not of ``each`` facet, (p, c) of points."""
        p, g, c, e = lever.shape
        rows = rows[self.facet] if each else rows
        rows = (rows[:, :, None] * e + np.arange(e)).reshape(p, c * e, 1)
        entries = np.swapaxes(lever.reshape(p, g, c * e), 1, 2) @ self._way
        return gather(entries, rows, self._columns, (n * e, self._total), self._dense)


class _End(_Way):
    """Ways with which functions of facets change, by K, (q, c, c): ``back``: K', ``area``: D, (q,
    c, 1), ``grown``: what the former makes of the latter, (q, c, 1)."""

    def __init__(self, pair: Pairing, ends: Ends, motion: Motion) -> None:
        super().__init__(pair, ends.guides.facet, ends.across, motion)
        self.change, self.back = ends.change, np.swapaxes(ends.change, 1, 2)
        self.area = pair.lumped[self.facet][..., None]
        self.grown = self.back @ self.area
        self._lending = np.swapaxes(pair.lending[self.facet], 1, 2)

    def lent(self, values: np.ndarray) -> np.ndarray:
        """What the functions at corners give, (q, c, e), by those that count."""
        return self._lending @ values
