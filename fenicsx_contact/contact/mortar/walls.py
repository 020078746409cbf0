# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which facets of two surfaces may meet: not those on the far sides of the two bodies.

Where the whole skins of two bodies are named, a ray from the far side of one goes through it and on
through the other, and what it meets last faces it, as deep behind it as both are thick. Of bodies
of one height that overlap a little aside, top and bottom face each other, too, as deep as one is
thick. A penetration is less deep than a share of the walls, and of the thinner one, but for what
comes deeper in the step: what lies on a long plank may be below its top by round-off, far from its
end. Bodies that go farther in one step may be through each other unseen, and change places.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from .itself import WALL, Admits, Itself
from .partners import EDGE, FACING, intersect
from .search import Near, Spheres, candidates
from .side import Side, unit_and_length

#: Cost: what is behind a facet by less than this share of its size is there, and no far side.
DEEP = 0.01
#: Cost: of about so many facets the mean is taken.
SAMPLE = 100


def admission(slave: Side, master: Side) -> Admits:
    """The rule of these two sides, or of the same one twice."""
    return Itself(slave) if slave is master else Others(slave, master)


class Others:
    """Says of facets of two sides, one of each, whether they may touch.

    Args:
        slave, master: the sides.
    """

    way = 0.0

    def __init__(self, slave: Side, master: Side) -> None:
        self._sizes = slave.sizes
        self._walls = Walls(slave), Walls(master)

    def __call__(self, facet: np.ndarray, other: np.ndarray, away: np.ndarray) -> np.ndarray:
        """Whether facets (q,) may meet others ``away`` [m] along their normals, (q,) of bool."""
        may = np.ones(len(facet), dtype=bool)
        deep = np.flatnonzero(away < -DEEP * self._sizes[facet])
        if len(deep):
            mine, theirs = (wall(f[deep]) for wall, f in zip(self._walls, (facet, other)))
            far = np.maximum(self.way, WALL * np.minimum(mine, theirs))
            may[deep] = -away[deep] <= np.minimum(far, WALL * (mine + theirs) / 2)
        return may

    def pass_through(self, mine: np.ndarray, theirs: np.ndarray) -> bool:
        """Whether the nodes of the sides may have gone through the other body, and out again.

        Args:
            mine, theirs: where they were, and where they are, (2, N, d) in m.
        """
        ways = [end - start for start, end in (mine, theirs)]
        low, high = ([of(way, axis=0) for way in ways] for of in (np.min, np.max))
        farthest = np.linalg.norm(np.maximum(high[0] - low[1], high[1] - low[0]))
        if farthest <= DEEP * self._sizes.min() or farthest <= WALL * self._thick:
            return False
        low, high = ([of(side, axis=(0, 1)) for side in (mine, theirs)] for of in (np.min, np.max))
        return bool(((low[0] <= high[1]) & (low[1] <= high[0])).all())

    @cached_property
    def _thick(self) -> float:
        """Of both bodies, in the mean of their walls, m."""
        return sum(wall.mean() for wall in self._walls) / 2


class Walls:
    """How far behind the facets of a side another of its own ends the undeformed body."""

    def __init__(self, side: Side) -> None:
        self._side = side.flat
        self._thickness = np.full(len(side.cells), np.nan)  # of those asked for

    def __call__(self, facet: np.ndarray) -> np.ndarray:
        """Of facets (q,), in m, infinite where no other is named."""
        new = np.unique(facet[np.isnan(self._thickness[facet])])
        if len(new):
            self._thickness[new] = self._seek(new)
        return self._thickness[facet]

    def least(self) -> float:
        """Of all facets the least, m."""
        return float(self(np.arange(len(self._thickness))).min())

    def mean(self) -> float:
        """Of the facets that have another behind them, m."""
        n = len(self._thickness)
        every = self(np.arange(0, n, max(1, n // SAMPLE)))
        found = every[np.isfinite(every)]
        return float(found.mean()) if len(found) else np.inf

    def _seek(self, asked: np.ndarray) -> np.ndarray:
        side, nodes = self._side, self._side.nodes
        unit, _ = unit_and_length(side.middle_normals(nodes))
        facets = Spheres.around(nodes[side.cells])
        mine = Spheres(facets.middles[asked], facets.radii[asked])
        far = np.full(len(asked), np.ptp(nodes, axis=0).sum())
        bundle = np.arange(len(asked))
        ray, other = candidates(mine.middles, unit[asked], bundle, far, mine, facets, Near())
        xi, alpha, *_ = intersect(mine.middles[ray], unit[asked][ray], side, nodes, other)
        ends = (unit[asked][ray] * unit[other]).sum(axis=1) < FACING
        ends &= side.holds(xi, EDGE) & (alpha < 0)
        thickness = np.full(len(asked), np.inf)
        np.minimum.at(thickness, ray[ends], -alpha[ends])
        return thickness
