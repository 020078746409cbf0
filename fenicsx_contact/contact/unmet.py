# SPDX-License-Identifier: LGPL-3.0-or-later
"""Facets of a pair that are inside what they were to meet, and have no partner there.

Facets meet those that face them. Sides of one body that turn by more than a right angle before they
touch, or tips that have no name, go through each other, of which gaps say nothing.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..base.cells import NODES
from ..solids import Solid
from ..solids.base import Trace
from .contact import Contact
from .inside import crossed, seen_in
from .mortar import Side
from .pierced import RISE
from .simplices import split


class Unmet:
    """Looks for them.

    Args:
        contacts: of a scene.
    """

    def __init__(self, contacts: Iterable[Contact]) -> None:
        self._pairs = [c for c in contacts if len(c.solids) > 1 and hasattr(c.coupling, "pairing")]
        #: By solid: its boundary.
        self._skins: dict[int, tuple[Trace, np.ndarray]] = {}

    def told(self) -> list[str]:
        """What a reader should know of such facets, deeper than coarse ones of what is round may
        be; all processes ask together."""
        return [text for contact in self._pairs if (text := self._look(contact))]

    def _look(self, contact: Contact) -> str:
        pair = contact.coupling.pairing  # type: ignore[attr-defined]
        alone = np.split(~seen_in(pair), [len(pair.slave.nodes)])
        for i, side in enumerate((pair.slave, pair.master)):
            mine, other = contact.solids[i], contact.solids[1 - i]
            asked = np.flatnonzero(alone[i][side.cells].any(axis=1))
            if not len(asked):
                continue
            places = contact.coupling.traces[i].positions()
            count = self._around(_below(side, places, asked), other)
            inside = (count % 2 == 0) & (count > 0) if mine is other else count % 2 == 1
            if inside.any():
                where = "that body itself" if mine is other else repr(other.name)
                place = places[side.corners[asked[inside][0]]].mean(axis=0).round(9).tolist()
                return (
                    f"contact {contact.name!r}: {inside.sum()} facets of {mine.name!r} are inside "
                    f"{where} and meet nothing there (one at {place}): facets meet those that "
                    "face them; give names to all that may touch, tips and edges, too"
                )
        return ""

    def _around(self, points: np.ndarray, solid: Solid) -> np.ndarray:
        """How often rays from points (n, d) meet the boundary of a solid, (n,)."""
        if id(solid) not in self._skins:
            nodes, cells, cell = solid.mesh.skin()
            self._skins[id(solid)] = solid.trace(nodes), split(cells[:, : NODES[cell][0]], cell)
        trace, simplices = self._skins[id(solid)]
        return crossed(points, trace.positions()[simplices])


def _below(side: Side, places: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """A little below the middles of facets of a side whose nodes are there, (m, d)."""
    outward = side.middle_normals(places, facets)
    outward *= (RISE * side.sizes[facets] / np.linalg.norm(outward, axis=1))[:, None]
    return places[side.corners[facets]].mean(axis=1) - outward
