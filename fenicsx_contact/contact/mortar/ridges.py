# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where a surface bends sharply, and the smooth parts between such edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ...base.constants import SHARP
from .side import OUTLINE, Side, unit_and_length


@dataclass(frozen=True)
class Ridges:
    """What the facets of a side have in common, points in the plane and edges in space, in the
    reference placement.

    Attributes:
        ends: their corners, (r, d - 1).
        inner: numbers of those between two facets, (i,).
        facets: these two, (i, 2).
        bent: whether they meet at a sharp angle, (i,), and ``juts``: outwards.
    """

    ends: np.ndarray
    inner: np.ndarray
    facets: np.ndarray
    bent: np.ndarray
    juts: np.ndarray

    @classmethod
    def of(cls, side: Side) -> Ridges:
        """Those of a side."""
        cells, nodes = side.corners, side.nodes
        ends, facets, count = shared(cells[:, OUTLINE.get(side.cell, [0, 1])])
        inner = np.flatnonzero(count == 2)
        a, b = facets[inner].T
        normal, _ = unit_and_length(side.flat.middle_normals(nodes))
        middle = nodes[cells].mean(axis=1)
        bent = (normal[a] * normal[b]).sum(axis=1) < SHARP
        behind = ((middle[b] - middle[a]) * normal[a]).sum(axis=1) < 0
        return cls(ends, inner, facets[inner], bent, bent & behind)


def shared(outlines: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What facets (m, k) of so many corners round about have in common: corners of the points in
    the plane or edges in space, (r, d - 1), the first and the second of the facets beside each, the
    same where there is but one, (r, 2), and how many there are, (r,)."""
    k = outlines.shape[1]
    ridges = [outlines] if k == 2 else [outlines, np.roll(outlines, -1, axis=1)]
    flat = np.sort(np.stack(ridges, axis=2).reshape(-1, len(ridges)), axis=1)
    ends, which, count = np.unique(flat, axis=0, return_inverse=True, return_counts=True)
    facet = np.argsort(which.ravel(), kind="stable") // k
    first = np.cumsum(count) - count
    return ends, np.stack([facet[first], facet[first + np.minimum(count - 1, 1)]], axis=1), count


def smooth_parts(side: Side) -> np.ndarray:
    """Of which part of a side each facet is, (m,): sharp edges, and where it ends, bound them."""
    ridges, m = Ridges.of(side), len(side.corners)
    a, b = ridges.facets[~ridges.bent].T
    joined = sp.csr_matrix((np.ones(len(a)), (a, b)), shape=(m, m))
    return sp.csgraph.connected_components(joined, directed=False)[1]
