# SPDX-License-Identifier: LGPL-3.0-or-later
"""Facets of a pair that are inside what they were to meet, and have no partner there.

Facets meet those that face them. Sides of one body that turn by more than a right angle before they
touch, or tips that have no name, go through each other, of which gaps say nothing.
"""

from __future__ import annotations

import numpy as np

from ..base.cells import NODES
from ..solids import Solid
from .contact import Contact
from .inside import crossed, seen_in
from .mortar import Side
from .pierced import RISE
from .simplices import split


def unmet(contact: Contact) -> str:
    """What a reader should know of such facets, deeper than coarse ones of what is round may be, or
    nothing; all processes ask together."""
    pair = getattr(contact.coupling, "pairing", None)
    if pair is None or len(contact.solids) < 2:
        return ""
    last = len(pair.slave.nodes)
    alone = np.split(~seen_in(pair), [last])
    for i, side in enumerate((pair.slave, pair.master)):
        mine, other = contact.solids[i], contact.solids[1 - i]
        places = contact.coupling.traces[i].positions()
        asked = np.flatnonzero(alone[i][side.cells].any(axis=1))
        count = _around(_below(side, places, asked), other)
        inside = (count % 2 == 0) & (count > 0) if mine is other else count % 2 == 1
        if inside.any():
            where = "that body itself" if mine is other else repr(other.name)
            place = places[side.corners[asked[inside][0]]].mean(axis=0).round(9).tolist()
            return (
                f"contact {contact.name!r}: {inside.sum()} facets of {mine.name!r} are inside "
                f"{where} and meet nothing there (one at {place}): facets meet those that face "
                "them; give names to all that may touch, tips and edges, too"
            )
    return ""


def _below(side: Side, places: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """A little below the middles of facets of a side whose nodes are there, (m, d)."""
    outward = side.middle_normals(places, facets)
    outward *= (RISE * side.sizes[facets] / np.linalg.norm(outward, axis=1))[:, None]
    return places[side.corners[facets]].mean(axis=1) - outward


def _around(points: np.ndarray, solid: Solid) -> np.ndarray:
    """How often rays from points (n, d) meet the boundary of a solid, (n,)."""
    nodes, cells, cell = solid.mesh.skin()
    simplices = split(cells[:, : NODES[cell][0]], cell)
    return crossed(points, solid.trace(nodes).positions()[simplices])
