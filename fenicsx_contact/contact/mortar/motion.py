# SPDX-License-Identifier: LGPL-3.0-or-later
"""How the points of pieces move on the master's facets, and how gaps change, with the nodes.

A point x of the slave meets  x + alpha n = x_m(xi)  where the guides say, and when nodes move

    M (dxi, dalpha) = dx + alpha dn - dx_m.
"""

from __future__ import annotations

import numpy as np

from .mortar import Pairing
from .pieces import Pieces
from .stance import below


class Motion:
    """Derivatives by the components of the nodes of the facets, (k d,), at points of the slave.

    Attributes:
        columns: which these are among all, (p, k d); some may be there twice.
        slide: of xi, (p, g, d - 1, k d).
        fall: of n . (x_s - x_m), (p, g, k d).
        turn, turning: of n, by a slice of these, (p, d, k d).
    """

    def __init__(self, pair: Pairing, pieces: Pieces) -> None:
        d, nodes, unit = pair.slave.dim, pair.nodes_of(pieces), pieces.unit[:, 0]
        own = pieces.values.shape[2]
        project = np.eye(d) - unit[:, :, None] * unit[:, None, :]
        turn, around = _turns(pair, pieces)
        turn = (project / pieces.length[:, None, None])[:, None] @ turn  # of n, (p, k, d, d)
        p, k = turn.shape[:2]
        self.turn = np.swapaxes(turn, 1, 2).reshape(p, d, k * d)
        turned = pieces.inverse @ self.turn[:, None]
        turned = turned.reshape(*turned.shape[:3], k, d)
        guides = (g[:, :, None, :, None] for g in (pieces.guide, -pieces.their_guide))
        moved = [guide * pieces.inverse[:, :, :, None] for guide in guides]
        widths = [own, pieces.their_values.shape[2]]
        turned = pieces.distance[:, :, None, None, None] * turned
        both, first = pieces.both, 0
        if around is None:
            moved[0] = moved[0] + turned
        else:  # further nodes turn them
            first = nodes.shape[1]
            both = np.concatenate([both, np.zeros((*both.shape[:2], k))], axis=2)
            nodes = np.concatenate([nodes, around], axis=1)
            moved, widths = [*moved, turned], [*widths, k]
        moved = np.concatenate([*map(_widened, moved, widths)], axis=3)
        slide, rise = moved[:, :, :-1], moved[:, :, -1]  # (p, g, d - 1, k, d), (p, g, k, d)
        if not pieces.aligned:
            tangents = pieces.their_slopes @ pair.places[nodes[:, own : own + widths[1]]]
            along = np.moveaxis((tangents * pieces.unit).sum(axis=3), 0, 2)  # (p, g, d - 1)
            rise = (along[..., None, None] * slide).sum(axis=2)
            rise -= both[..., None] * pieces.unit[:, :, None]
            apart = -both @ pair.places[nodes]
            rise[:, :, first : first + k] += np.einsum("pgi,pkil->pgkl", apart, turn)
        self.turning = slice(first * d, (first + k) * d)
        self.columns = (nodes[:, :, None] * d + np.arange(d)).reshape(p, nodes.shape[1] * d)
        self.slide = slide.reshape(*slide.shape[:3], self.columns.shape[1])
        self.fall = -rise.reshape(*rise.shape[:2], self.columns.shape[1])


def _turns(pair: Pairing, pieces: Pieces) -> tuple[np.ndarray, np.ndarray | None]:
    """Derivatives of the normals along which pieces are seen by the places of nodes, (p, k, d, d):
    the first of the slave's facets, or, if any stands on the master, of these (p, k) among all."""
    side, last, d = pieces.side, len(pair.slave.nodes), pair.slave.dim
    places = pair.places[:last], pair.places[last:]
    turn = side.normal_rates(places[0], pieces.facet, pieces.slopes)
    which = pieces.stance.standing
    if not len(which):
        return turn, None
    stance, facet, master = pieces.stance.of(which), pieces.facet[which], pair.master.flat
    normal, edge, length = below(stance, (pair.slave, master), places, facet)
    feet, q = stance.feet.ravel(), len(which)
    slopes = np.repeat(master.middle_slopes[:, None], len(feet), axis=1)
    across = np.eye(d) - edge[:, :, None] * edge[:, None]
    rates = master.normal_rates(places[1], feet, slopes) * (feet >= 0)[:, None, None, None]
    rates = -across[:, None] @ rates.reshape(q, -1, d, d)
    # n - (n . t) t turns with the edge, too
    along = (normal * edge).sum(axis=1)[:, None, None] * np.eye(d) + edge[:, :, None] * normal[
        :, None
    ]
    along = -(along @ across) / length[:, None, None]
    own = stance.along[:, :, None, None] * along[:, None]
    theirs = last + master.cells[feet].reshape(q, -1)
    around = np.concatenate([side.corners[facet], theirs], axis=1)
    rates = np.concatenate([own, rates], axis=1)
    (p, k), more = turn.shape[:2], max(turn.shape[1], rates.shape[1])
    nodes, turns = np.zeros((p, more), dtype=np.int64), np.zeros((p, more, d, d))
    nodes[:, :k], turns[:, :k] = side.cells[pieces.facet], turn
    turns[which] = 0.0
    k = rates.shape[1]
    nodes[which, :k], turns[which, :k] = around, rates
    return turns, nodes


def _widened(array: np.ndarray, k: int) -> np.ndarray:
    """With as many nodes on its axis 3 as the field has; what they have not got is 0."""
    if array.shape[3] == k:
        return array
    wide = np.zeros((*array.shape[:3], k, array.shape[4]))
    wide[:, :, :, : array.shape[3]] = array
    return wide
