# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where the facets of a slave look: along their normals, or those on which they stand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .side import Side, unit_and_length

#: Both sides, and the places of their nodes, (N, d); the slave's first.
Sides = tuple[Side, Side]
Places = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Stance:
    """How the facets of a slave stand on those of its master.

    Attributes:
        facet: of the master, for each of the slave, (m,), or -1: it looks along its own normal.
        along: of the corners of a facet that makes the direction of the edge on which it stands,
            (m, corners), along which it looks as its own normal does; 0 where that is a corner.
    """

    facet: np.ndarray
    along: np.ndarray

    @classmethod
    def none(cls, side: Side) -> Stance:
        """Of facets that all look along their own normals."""
        return cls(np.full(len(side.corners), -1), np.zeros(side.corners.shape))

    def same(self, other: Stance) -> bool:
        """Whether it is the other one."""
        mine, theirs = (np.column_stack([each.facet, each.along]) for each in (self, other))
        return np.array_equal(mine, theirs)

    def of(self, facet: np.ndarray) -> Stance:
        """That of some facets (q,)."""
        return Stance(self.facet[facet], self.along[facet])


def look(
    unit: np.ndarray,
    length: np.ndarray,
    stance: Stance,
    sides: Sides,
    places: Places,
    facet: np.ndarray,
) -> None:
    """Let unit vectors (q, d) of facets (q,) that stand on the master's be opposite to the normals
    of these, across their edges, which are (q,) long."""
    which = np.flatnonzero(stance.facet >= 0)
    if len(which):
        normal, edge, _ = below(stance.of(which), sides, places, facet[which])
        normal -= (normal * edge).sum(axis=1)[:, None] * edge
        unit[which], length[which] = unit_and_length(normal)


def below(
    stance: Stance,
    sides: Sides,
    places: Places,
    facet: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of facets (q,) of the slave that stand on the master: the latter's normals, towards it, of
    their own lengths, (q, d), and the directions of the edges, unit vectors or 0, (q, d), whose
    lengths were (q,)."""
    master = sides[1].flat
    edge = (stance.along[:, :, None] * places[0][sides[0].corners[facet]]).sum(axis=1)
    length = np.sqrt((edge**2).sum(axis=1))
    length[length == 0] = np.inf  # a corner
    normal = -master.middle_normals(places[1], stance.facet)
    return normal, edge / length[:, None], length
