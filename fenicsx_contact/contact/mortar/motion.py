# SPDX-License-Identifier: LGPL-3.0-or-later
"""How the points of pieces move on the master's facets, and how gaps change, with the nodes.

A point x of the slave meets  x + alpha n = x_m(xi)  where the guides say, and when nodes move

    M (dxi, dalpha) = dx + alpha dn - dx_m.
"""

from __future__ import annotations

import numpy as np

from .mortar import Pairing
from .pieces import Pieces


class Motion:
    """Derivatives by the components of the nodes of the facets, (k d,), at points of the slave.

    Attributes:
        columns: which these are among all, (p, k d).
        slide: of xi, (p, g, d - 1, k d).
        fall: of n . (x_s - x_m), (p, g, k d).
        turn: of n, by the first of these, (p, d, k d).
    """

    def __init__(self, pair: Pairing, pieces: Pieces) -> None:
        d, slave, nodes = pair.slave.dim, pair.slave, pair.nodes_of(pieces)
        xs, unit = pair.places[: len(slave.nodes)], pieces.unit[:, 0]
        project = np.eye(d) - unit[:, :, None] * unit[:, None, :]
        turn = pieces.side.normal_rates(xs, pieces.facet, pieces.slopes)
        turn = (project / pieces.length[:, None, None])[:, None] @ turn  # of n, (p, k, d, d)

        p, own = len(turn), pieces.values.shape[2]
        self.turn = np.swapaxes(turn, 1, 2).reshape(p, d, turn.shape[1] * d)
        turned = pieces.inverse @ self.turn[:, None]
        turned = turned.reshape(*turned.shape[:3], turn.shape[1], d)
        guides = (g[:, :, None, :, None] for g in (pieces.guide, -pieces.their_guide))
        mine, theirs = (guide * pieces.inverse[:, :, :, None] for guide in guides)
        mine = mine + pieces.distance[:, :, None, None, None] * turned
        widths = own, pieces.their_values.shape[2]
        moved = np.concatenate([*map(_widened, (mine, theirs), widths)], axis=3)
        slide, rise = moved[:, :, :-1], moved[:, :, -1]  # (p, g, d - 1, k, d), (p, g, k, d)
        if not pieces.aligned:
            tangents = pieces.their_slopes @ pair.places[nodes[:, own:]]
            along = np.moveaxis((tangents * pieces.unit).sum(axis=3), 0, 2)  # (p, g, d - 1)
            rise = (along[..., None, None] * slide).sum(axis=2)
            rise -= pieces.both[..., None] * pieces.unit[:, :, None]
            apart = -pieces.both @ pair.places[nodes]
            rise[:, :, : turn.shape[1]] += np.einsum("pgi,pkil->pgkl", apart, turn)
        self.columns = (nodes[:, :, None] * d + np.arange(d)).reshape(p, nodes.shape[1] * d)
        self.slide = slide.reshape(*slide.shape[:3], self.columns.shape[1])
        self.fall = -rise.reshape(*rise.shape[:2], self.columns.shape[1])


def _widened(array: np.ndarray, k: int) -> np.ndarray:
    """With as many nodes on its axis 3 as the field has; what they have not got is 0."""
    if array.shape[3] == k:
        return array
    wide = np.zeros((*array.shape[:3], k, array.shape[4]))
    wide[:, :, :, : array.shape[3]] = array
    return wide
