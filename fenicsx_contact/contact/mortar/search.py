# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which rays may meet which facets: a search by trees, coarse and safe, before any intersection.

The rays of a facet are a bundle. A bundle sees the facets whose spheres enter the tube around it,
which is cut into pieces about as long as wide; trees find what is near a piece, one for what is
about of the same size, so that a few large ones far away do not make everything near. What is near
is found with some margin, and sought again only when something has moved farther.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial import cKDTree

from ...base.checks import StepFailed
from ...base.vectors import normalised

#: Partners are sought within so many facets, and four times the way of the step.
FACETS = 3.0
#: Cost: spheres are larger by this factor than their facets' nodes tell: curved ones bulge.
BULGE = 1.1
#: Cost: what is near is sought this share of a typical sphere farther than asked.
MARGIN = 0.3


class Spheres:
    """Spheres, middles (n, d) and radii (n,); around facets from the places of their nodes."""

    def __init__(self, middles: np.ndarray, radii: np.ndarray) -> None:
        self.middles, self.radii = middles, radii

    @classmethod
    def around(cls, facets: np.ndarray) -> Spheres:
        """Those of facets whose nodes are at (n, k, d)."""
        middles = facets.sum(axis=1) / facets.shape[1]
        arms = facets - middles[:, None]
        return cls(middles, BULGE * np.sqrt((arms**2).sum(axis=2).max(axis=1)))

    def wider(self, by: np.ndarray | float) -> Spheres:
        """With larger radii."""
        return Spheres(self.middles, self.radii + by)

    def changed(self, old: Spheres) -> float:
        """By how much one reaches farther than the old one did, at most."""
        away = np.sqrt(((self.middles - old.middles) ** 2).sum(axis=1))
        return float((away + self.radii - old.radii).max(initial=0.0))


class Near:
    """Pairs of spheres of two sets that meet, and some that do not."""

    def __init__(self) -> None:
        self._sought: tuple[Spheres, Spheres] | None = None
        self._margin = 0.0
        self._pairs = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)

    def __call__(self, ones: Spheres, others: Spheres) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of the pairs, ascending in the first."""
        if self._moved(ones, others):
            margin = MARGIN * float(ones.radii.sum() / max(len(ones.radii), 1))
            self._pairs = _close(ones.wider(margin), others)
            self._sought, self._margin = (ones, others), margin
        return self._pairs

    def _moved(self, ones: Spheres, others: Spheres) -> bool:
        """By more than the margin."""
        if self._sought is None or len(self._sought[0].radii) != len(ones.radii):
            return True
        return ones.changed(self._sought[0]) + others.changed(self._sought[1]) > self._margin


def _close(ones: Spheres, others: Spheres) -> tuple[np.ndarray, np.ndarray]:
    found = [(np.empty(0, dtype=np.int64),) * 2]
    try:
        if not all(np.isfinite(each.middles).all() for each in (ones, others)):
            raise ValueError("not finite")
        trees = [list(_by_size(each)) for each in (ones, others)]
        for mine, tree, size in trees[0]:
            for theirs, other, its_size in trees[1]:
                pairs = tree.sparse_distance_matrix(other, size + its_size, output_type="ndarray")
                one, two = mine[pairs["i"]], theirs[pairs["j"]]
                meet = pairs["v"] <= ones.radii[one] + others.radii[two]
                found.append((one[meet], two[meet]))
    except ValueError as failure:  # of an iterate that diverges: their squares are not finite
        raise StepFailed("facets of a contact collapse, or are nowhere") from failure
    one, other = (np.concatenate(each) for each in zip(*found))
    order = np.lexsort((other, one))
    return one[order], other[order]


def _by_size(spheres: Spheres) -> Iterator[tuple[np.ndarray, cKDTree, float]]:
    """Spheres of about the same size, an octave: their numbers, tree of middles, largest radius."""
    octave = np.floor(np.log2(np.maximum(spheres.radii, np.finfo(float).tiny)))
    for each in np.unique(octave):
        members = np.flatnonzero(octave == each)
        yield members, cKDTree(spheres.middles[members]), spheres.radii[members].max()


def candidates(
    x: np.ndarray,
    n: np.ndarray,
    bundle: np.ndarray,
    far: np.ndarray,
    bundles: Spheres,
    facets: Spheres,
    near: Near,
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs (ray, facet) that may meet.

    Args:
        x, n: origins and unit directions of the rays, (q, d), which run to both sides.
        bundle: number of the bundle of each ray, (q,), ascending; each bundle has rays.
        far: how far the rays of each bundle go, m.
        bundles, facets: spheres around the origins of each bundle, and around the facets.
        near: finds which of them are near.
    """
    start = np.flatnonzero(first_of_each(bundle))
    count = np.bincount(bundle)
    axis = normalised(np.add.reduceat(n, start))
    turned = np.sqrt(((n - axis[bundle]) ** 2).sum(axis=1))
    slack = bundles.radii + 2 * np.maximum.reduceat(turned, start) * far
    one, facet = in_tubes(axis, far, slack, bundles, facets, near)
    ray = np.repeat(start[one], count[one]) + counted(count[one])
    facet = np.repeat(facet, count[one])
    seen = _aside(facets.middles[facet] - x[ray], n[ray]) <= facets.radii[facet]
    return ray[seen], facet[seen]


def in_tubes(
    axis: np.ndarray,
    far: np.ndarray,
    radii: np.ndarray,
    bundles: Spheres,
    facets: Spheres,
    near: Near,
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs (bundle, facet), ascending, of facets that enter the tubes around the bundles.

    Args:
        axis, radii: of the tubes, unit vectors (b, d), and (b,) in m, no less than the bundles'.
        far: how far the tubes go beyond the bundles, to both sides, m.
        bundles, facets, near: as above.
    """
    # more pieces than facets find nothing sooner, and an iterate that diverges would need many
    radii = np.maximum(radii, np.finfo(float).tiny)  # or nobody is there
    pieces = np.ceil(np.fmin((far + bundles.radii) / radii, len(facets.radii)))
    pieces = np.maximum(1, pieces).astype(np.int64)
    half = (far + bundles.radii) / pieces
    of, which = np.repeat(np.arange(len(pieces)), pieces), counted(pieces)
    middles = bundles.middles[of] + ((2 * which + 1 - pieces[of]) * half[of])[:, None] * axis[of]
    piece, facet = near(Spheres(middles, np.hypot(radii, half)[of]), facets)

    one = of[piece]
    arm = facets.middles[facet] - bundles.middles[one]
    along = np.einsum("ij,ij->i", arm, axis[one]) / (2 * half[one]) + pieces[one] / 2
    mine = np.clip(np.floor(along), 0, pieces[one] - 1) == which[piece]
    seen = mine & (_aside(arm, axis[one]) <= radii[one] + facets.radii[facet])
    return one[seen], facet[seen]


def first_of_each(numbers: np.ndarray) -> np.ndarray:
    """Where in ascending numbers a new one begins."""
    first = np.ones(len(numbers), dtype=bool)
    first[1:] = numbers[1:] != numbers[:-1]
    return first


def _aside(arm: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Distance from the axis."""
    along = np.einsum("ij,ij->i", arm, axis)
    return np.sqrt(((arm - along[:, None] * axis) ** 2).sum(axis=1))


def counted(counts: np.ndarray) -> np.ndarray:
    """0, 1, ... up to each count, one after the other."""
    ends = np.cumsum(counts)
    return np.arange(ends[-1] if len(ends) else 0) - np.repeat(ends - counts, counts)
