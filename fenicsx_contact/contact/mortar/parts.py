# SPDX-License-Identifier: LGPL-3.0-or-later
"""The part of a facet that bears, where its master covers it in part: the box of what is covered.

Such a facet, a line or a quadrilateral, has its linear functions on this box, of local coordinates
from a to a + h:

    e_i(xi) = phi_i((xi - a)/h).

So rows stand at corners of the box, and forces act there: with the functions of the whole facet
rows would stand at its nodes, and beside the end of what bears it a solid would be borne. The box
is the facet itself where that is covered wholly, and its functions are not negative where it is
covered; by each side c it reaches as far as what is covered does,  s_c = max F_c . xi.  When it
reaches farther its corners x_k on that side move on, and the functions change within their span:

    de_i = sum_k e_k K_ki ds_c,    K_ki = -grad e_i(x_k) . F_c  or 0.

Triangles keep their own functions. (One about what is covered reaches beyond it again; one that is
drawn in to reach no farther has rows that nearly depend on each other where little is covered, and
Newton's method goes from one to the other.)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .partners import EDGE
from .side import Side


class Form(NamedTuple):
    """Of a kind of facet: F, across its sides in the order of its outline, (c, t), and corners,
    (k, t)."""

    across: np.ndarray
    corners: np.ndarray

    @property
    def full(self) -> np.ndarray:
        """How far the facet itself reaches by each side, (c,)."""
        return (self.corners @ self.across.T).max(axis=0)

    @property
    def moves(self) -> np.ndarray:
        """How its corners move with each side, (c, k, t)."""
        on = self.across @ self.corners.T == self.full[:, None]
        return on[..., None] * self.across[:, None]


#: Those that have parts.
FORMS = {
    "interval": Form(np.array([[-1.0], [1.0]]), np.array([[0.0], [1.0]])),
    "quadrilateral": Form(
        np.array([[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]),
        np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]),
    ),
}


class Parts:
    """Of the facets of a side those parts.

    Args:
        side: the slave.
        facet, xi: corners of what is covered: of facets (q,), local coordinates there (q, d - 1).
            Facets without are as if covered wholly.
    """

    def __init__(self, side: Side, facet: np.ndarray, xi: np.ndarray) -> None:
        self._side, self.form = side, FORMS[side.cell]
        form = self.form
        self._reach = np.full((len(side.cells), len(form.across)), -np.inf)
        np.maximum.at(self._reach, facet, xi @ form.across.T)
        self._reach[self._reach[:, 0] == -np.inf] = form.full
        corners = form.corners + np.einsum("mc,ckt->mkt", self._reach - form.full, form.moves)
        self._low = corners[:, 0]
        self._size = np.maximum(corners[:, -1] - self._low, EDGE)

    def within(self, facet: np.ndarray, xi: np.ndarray) -> np.ndarray:
        """By which sides such points end what is covered within a facet, (q, c)."""
        reach = self._reach[facet]
        return (xi @ self.form.across.T >= reach - EDGE) & (reach < self.form.full - EDGE)

    def functions(self, facet: np.ndarray, xi: np.ndarray) -> np.ndarray:
        """Those of the corners at local coordinates (q, g, d - 1) of facets (q,), (q, g, k)."""
        inside = (xi - self._low[facet][:, None]) / self._size[facet][:, None]
        values = self._side.linear_shape(inside.reshape(-1, xi.shape[2]))
        return values.reshape(*xi.shape[:2], values.shape[1])

    def outwards(
        self, facet: np.ndarray, by: np.ndarray, mate: np.ndarray, way: np.ndarray
    ) -> np.ndarray:
        """How much farther they reach by one side each (q,) as what ends them moves: derivatives by
        local coordinates, (q, d - 1).

        A corner of the master (``mate`` >= 0) moves as it likes. Where one of its edges, along
        ``way`` (q, d - 1), crosses a side of the facet, of number -1 - ``mate``, what moves along
        this edge stays on that side. Of several as far, each has its share, the less the more
        slantingly it crosses, so that no rounding of edges in line decides.
        """
        across, crosses = self.form.across, mate < 0
        other = across[np.where(crosses, -1 - mate, 0)]
        on = np.where(crosses, (across[by] * way).sum(axis=1), 0.0)
        past = np.where(crosses, (other * way).sum(axis=1), 1.0)
        total = on**2 + past**2
        shares = np.zeros_like(self._reach)
        np.add.at(shares, (facet, by), past**2 / total)
        shares[shares == 0] = 1.0  # edges in line
        moves = past[:, None] * across[by] - on[:, None] * other
        return moves * (past / total / shares[facet, by])[:, None]

    def changes(self, facet: np.ndarray, by: np.ndarray) -> np.ndarray:
        """K of facets (q,) for one side each (q,), (q, k, k)."""
        slopes = self._side.linear_slopes(self.form.corners)  # (t, k, i)
        moves = self.form.moves[by] / self._size[facet][:, None]
        return -np.einsum("tki,qkt->qki", slopes, moves)
