# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which rays may meet which facets: a search by trees, coarse and safe, before any intersection.

The rays of a facet are a bundle. A bundle sees the facets whose spheres enter the tube around it;
trees find those near it, one tree for facets of about the same size, so that a few large ones far
away do not make everything near.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

#: Spheres are larger by this factor than their facets' nodes tell: curved ones bulge.
BULGE = 1.1


def candidates(
    x: np.ndarray,
    n: np.ndarray,
    bundle: np.ndarray,
    reach: np.ndarray,
    facets: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs (ray, facet) that may meet.

    Args:
        x, n: origins and unit directions of the rays, (q, d), which run to both sides.
        bundle: number of the bundle of each ray, (q,), ascending.
        reach: how far each ray goes, (q,) in m.
        facets: places of the nodes of the facets, (m, k, d).
    """
    if not len(x):
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    middles = facets.mean(axis=1)
    radii = BULGE * np.linalg.norm(facets - middles[:, None], axis=2).max(axis=1)
    start = np.flatnonzero(np.diff(bundle, prepend=bundle[0] - 1))
    count = np.diff(np.append(start, len(x)))
    of = np.repeat(np.arange(len(start)), count)
    centre = np.add.reduceat(x, start) / count[:, None]
    axis = np.add.reduceat(n, start) / count[:, None]
    spread = np.maximum.reduceat(np.linalg.norm(n - axis[of], axis=1), start)
    radius = np.maximum.reduceat(np.linalg.norm(x - centre[of], axis=1), start)
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    far = np.maximum.reduceat(reach, start)

    one, facet = _close(centre, radius + far, middles, radii)
    slack = radius[one] + radii[facet] + 2 * spread[one] * far[one]
    seen = _aside(middles[facet] - centre[one], axis[one]) <= slack
    one, facet = one[seen], facet[seen]

    ray = np.repeat(start[one], count[one]) + _counted(count[one])
    facet = np.repeat(facet, count[one])
    seen = _aside(middles[facet] - x[ray], n[ray]) <= radii[facet]
    return ray[seen], facet[seen]


def _aside(arm: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Distance from the axis."""
    along = np.einsum("ij,ij->i", arm, axis)
    return np.linalg.norm(arm - along[:, None] * axis, axis=1)


def _close(
    centres: np.ndarray, reach: np.ndarray, middles: np.ndarray, radii: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs (centre, middle) whose spheres meet, and some that do not."""
    ones, others = [], []
    octave = np.floor(np.log2(np.maximum(radii, np.finfo(float).tiny)))
    for each in np.unique(octave):
        members = np.flatnonzero(octave == each)
        tree = cKDTree(middles[members])
        found = tree.query_ball_point(centres, reach + radii[members].max())
        count = np.fromiter(map(len, found), dtype=np.int64, count=len(found))
        flat = np.fromiter((i for some in found for i in some), np.int64, count.sum())
        ones.append(np.repeat(np.arange(len(centres)), count))
        others.append(members[flat])
    return np.concatenate(ones), np.concatenate(others)


def _counted(counts: np.ndarray) -> np.ndarray:
    """0, 1, ... up to each count, one after the other."""
    ends = np.cumsum(counts)
    return np.arange(ends[-1] if len(ends) else 0) - np.repeat(ends - counts, counts)
