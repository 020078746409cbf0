# SPDX-License-Identifier: LGPL-3.0-or-later
"""Obstacles that reach into facets between their nodes, which alone bear.

A corner that is blunter than facets are long, or a bulge, does that a little. What is narrower than
a facet goes through it, and a body on it falls, of which its gaps, those of the nodes, say nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import acos, tan
from typing import Any

import numpy as np

from ..base.checks import StepFailed
from ..base.constants import SHARP
from ..base.vectors import dot
from .contact import Contact
from .nodal import NodalJump

#: Where lines between nodes are asked, as shares of them.
SHARES = np.arange(1, 8) / 8
#: How far an arc stands out from a chord at whose ends it makes the angle of a sharp corner.
RISE = tan(acos(SHARP) / 4) / 2


def _lines(contact: Contact) -> np.ndarray:
    """Pairs of nodes of a facet, (m, 2); in the plane such between which there is no other."""
    cells = contact.surface.cell_nodes
    k = cells.shape[1]
    if contact.surface.dim == 2 and k == 3:  # the middle stands last
        ends = np.concatenate([cells[:, [0, 2]], cells[:, [2, 1]]])
    else:
        i, j = np.triu_indices(k, 1)
        ends = np.stack([cells[:, i], cells[:, j]], axis=2).reshape(-1, 2)
    return np.unique(np.sort(ends, axis=1), axis=0)


def _asked(contact: Contact) -> bool:
    """Whether all nodes of the surface bear, before an obstacle that may be between them."""
    other = contact.coupling
    if not isinstance(other, NodalJump) or other.wall.flat or other.encloses:
        return False
    return bool(contact.chosen.all())


class Pierced:
    """How deep obstacles were in facets, at most.

    Args:
        contacts: of a scene.
    """

    def __init__(self, contacts: Iterable[Contact]) -> None:
        self._lines = [(c, _lines(c)) for c in contacts if _asked(c)]
        #: By contact: how deep, of which size of a facet, m, and when, s.
        self._most: dict[str, tuple[float, float, float]] = {}

    def see(self, time: float) -> None:
        """Look at the accepted state."""
        for contact, lines in self._lines:
            x, normal, gap = contact.start_positions, contact.start_normal, contact.gap
            i, j = lines.T
            bent = (dot(normal[i], normal[j]) < SHARP).nonzero()[0]
            if not len(bent):
                continue
            start, way = x[i[bent]], x[j[bent]] - x[i[bent]]
            size = np.linalg.norm(way, axis=1)
            near = np.maximum(gap[i[bent]], gap[j[bent]]) > -size
            if near.any():
                self._look(contact, start[near], way[near], size[near], time)

    def _look(
        self, contact: Contact, start: np.ndarray, way: np.ndarray, size: np.ndarray, time: float
    ) -> None:
        between = start[:, None] + SHARES[:, None] * way[:, None]
        coupling: Any = contact.coupling
        try:
            distance = coupling.wall.distance(between.reshape(-1, way.shape[1]), coupling.time)
        except StepFailed:  # there are none within
            return
        depth = -distance.reshape(between.shape[:2]).min(axis=1)
        worst = int((depth / size).argmax())
        if depth[worst] > max(RISE * size[worst], self._most.get(contact.name, (0.0,))[0]):
            self._most[contact.name] = float(depth[worst]), float(size[worst]), time

    def told(self, comm: Any) -> list[str]:
        """What a reader should know of them; all processes ask together."""
        found: dict[str, tuple[float, float, float]] = {}
        for each in comm.allgather(self._most):
            for name, most in each.items():
                found[name] = max(most, found.get(name, most))
        return [
            f"contact {name!r}: its obstacle was {depth:.3g} m inside facets of {size:.3g} m, "
            f"between the points that bear (t = {time:.6g} s): it goes through coarse facets; "
            "give them a fraction of its size"
            for name, (depth, size, time) in found.items()
        ]
