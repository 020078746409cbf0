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
        m, cells, nodes = side.corners.shape[0], side.corners, side.nodes
        ridges = cells[:, :, None]
        if side.dim == 3:
            outline = cells[:, OUTLINE[side.cell]]
            ridges = np.sort(np.stack([outline, np.roll(outline, -1, axis=1)], axis=2), axis=2)
        flat = ridges.reshape(-1, ridges.shape[2])
        _, which, count = np.unique(flat, axis=0, return_inverse=True, return_counts=True)
        of = np.argsort(which.ravel(), kind="stable")
        facet = np.repeat(np.arange(m), ridges.shape[1])[of]
        first = np.cumsum(count) - count
        inner = np.flatnonzero(count == 2)
        a, b = facet[first[inner]], facet[first[inner] + 1]
        flat_side = side.flat
        normal, _ = unit_and_length(
            flat_side.normal(flat_side.middle_tangents(nodes), np.arange(m))
        )
        middle = nodes[cells].mean(axis=1)
        bent = (normal[a] * normal[b]).sum(axis=1) < SHARP
        behind = ((middle[b] - middle[a]) * normal[a]).sum(axis=1) < 0
        return cls(flat[of[first]], inner, np.stack([a, b], axis=1), bent, bent & behind)


def smooth_parts(side: Side) -> np.ndarray:
    """Of which part of a side each facet is, (m,): sharp edges, and where it ends, bound them."""
    ridges, m = Ridges.of(side), len(side.corners)
    a, b = ridges.facets[~ridges.bent].T
    joined = sp.csr_matrix((np.ones(len(a)), (a, b)), shape=(m, m))
    return sp.csgraph.connected_components(joined, directed=False)[1]
