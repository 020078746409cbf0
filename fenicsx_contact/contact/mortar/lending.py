# SPDX-License-Identifier: LGPL-3.0-or-later
"""Who bears for nodes that supports hold.

Where all of a facet is held, whoever it meets has to yield. Where some of its nodes are free, these
have functions enough for whatever it does: a multiplier at a held one would ask for once more what
theirs ask, by as little as what it meets is free there, and push as hard. So on such a facet a held
node lends its function to the free ones beside it, of which the sum stays 1: what is uniform is
transmitted as before (Puso and Laursen, Comput. Methods Appl. Mech. Engrg. 193, 2004, at supports).
A held facet that is alone among such ones, as at the corner of a plate that is clamped on two
sides, is a part of theirs: it lends to the free nodes across its edges.

Held is what cannot go along the normal that it has at rest: one that ends held so turn by, as what
is bent does, moves the gap by a lever that is as small, and would push by as much more.
"""

from __future__ import annotations

import numpy as np

from ...base.constants import ROUND_OFF
from .matrices import add_up
from .side import OUTLINE, Side


def lent(corners: np.ndarray, cell: str, held: np.ndarray) -> np.ndarray:
    """What facets (m, k) of this cell make of the functions at their corners where some nodes are
    held, (n,) of bool: phi @ H, (m, k, k)."""
    k = corners.shape[1]
    free = ~held[corners]
    place = np.argsort(OUTLINE.get(cell, [0, 1]))
    beside = np.isin((place[:, None] - place) % k, (1, k - 1))
    to = np.where((beside & free[:, None]).any(axis=2, keepdims=True), beside, True)
    to = to & free[:, None]
    share = to / np.maximum(to.sum(axis=2, keepdims=True), 1)
    own = (free | ~free.any(axis=1, keepdims=True))[..., None]
    return np.where(own, np.eye(k), share)


def bearing(corners: np.ndarray, cell: str, held: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Who bears for the corners (m, k) of facets where some are held, (n,) of bool: nodes (m, k),
    and by which functions, phi @ H, (m, k, k)."""
    rows, lending, k = corners.copy(), lent(corners, cell, held), corners.shape[1]
    outline = OUTLINE.get(cell, [0, 1])
    edges = [[i] for i in outline] if k == 2 else list(zip(outline, np.roll(outline, -1)))
    beside: dict[tuple[int, ...], list[int]] = {}
    for facet in np.flatnonzero(held[corners].any(axis=1)):
        for edge in edges:
            beside.setdefault(tuple(sorted(corners[facet, [*edge]])), []).append(facet)
    whole = held[corners].all(axis=1)
    for facet in np.flatnonzero(whole):
        across = [beside[tuple(sorted(corners[facet, [*edge]]))] for edge in edges]
        if sum(int(whole[others].sum()) for others in across) > len(edges):
            continue  # not alone
        nodes = [np.unique(corners[others][~held[corners[others]]]) for others in across]
        bears = np.unique(np.concatenate(nodes))
        if 0 < len(bears) <= k:
            share = np.array([
                np.isin(bears, np.concatenate([x for x, edge in zip(nodes, edges) if i in edge]))
                for i in range(k)
            ])  # fmt: skip
            share[~share.any(axis=1)] = True
            rows[facet] = np.resize(bears, k)
            lending[facet] = 0.0
            lending[facet, :, : len(bears)] = share / share.sum(axis=1, keepdims=True)
    return rows, lending


def directions(side: Side, n: int) -> np.ndarray:
    """Components that the normals at its n corners have in the reference placement, means over the
    facets, (n, d) of bool; all, where these cancel."""
    each, rows = side.middle_normals(side.nodes), side.corners.ravel()
    sums = [add_up(x.repeat(side.corners.shape[1], axis=0), rows, n) for x in (each, np.abs(each))]
    there = np.abs(sums[0]) > ROUND_OFF * sums[1].sum(axis=1, keepdims=True)
    return there | ~there.any(axis=1, keepdims=True)
