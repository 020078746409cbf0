# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where the facets of a slave look: along their normals, or those on which they stand."""

from __future__ import annotations

from collections.abc import Mapping
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
        feet: facets of the master, for each of the slave, (m, k), filled up with -1; with none it
            looks along its own normal, with several along the mean of theirs, by their sizes.
        along: of the corners of a facet that makes the direction of the edge on which it stands,
            (m, corners), along which it looks as its own normal does; 0 where that is a corner.
    """

    feet: np.ndarray
    along: np.ndarray

    @classmethod
    def none(cls, side: Side) -> Stance:
        """Of facets that all look along their own normals."""
        return cls(np.full((len(side.corners), 1), -1), np.zeros(side.corners.shape))

    @classmethod
    def restored(cls, state: Mapping[str, np.ndarray]) -> Stance:
        """That of which :meth:`state` gave this."""
        feet = [np.array(state[name]) for name in sorted(state) if name.startswith("foot ")]
        return cls(np.stack(feet, axis=1), np.array(state["along"]))

    def state(self) -> dict[str, np.ndarray]:
        """By names: one for each of the feet, for saved arrays keep their shapes."""
        feet = {f"foot {i:03d}": foot for i, foot in enumerate(self.feet.T)}
        return {**feet, "along": self.along}

    @property
    def standing(self) -> np.ndarray:
        """Numbers of the facets that stand, (q,)."""
        return np.flatnonzero(self.feet[:, 0] >= 0)

    def same(self, other: Stance) -> bool:
        """Whether it is the other one."""
        mine, theirs = (np.column_stack([each.feet, each.along]) for each in (self, other))
        return np.array_equal(mine, theirs)

    def of(self, facet: np.ndarray) -> Stance:
        """That of some facets (q,)."""
        return Stance(self.feet[facet], self.along[facet])


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
    which = stance.standing
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
    their own lengths, added, (q, d), and the directions of the edges, unit vectors or 0, (q, d),
    whose lengths were (q,)."""
    master = sides[1].flat
    edge = (stance.along[:, :, None] * places[0][sides[0].corners[facet]]).sum(axis=1)
    length = np.sqrt((edge**2).sum(axis=1))
    length[length == 0] = np.inf  # a corner
    feet = stance.feet
    each = master.middle_normals(places[1], feet.ravel()).reshape(*feet.shape, -1)
    normal = -(each * (feet >= 0)[..., None]).sum(axis=1)
    return normal, edge / length[:, None], length
