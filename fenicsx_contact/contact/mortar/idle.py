# SPDX-License-Identifier: LGPL-3.0-or-later
"""Along what supports let nothing slip: nodes on a plane of symmetry of both solids.

The mean over the facets on one side of the plane sees a slip of those beside the node, as small as
both meshes are stretched differently, and of any sign; by symmetry the other half sees the
opposite. So along there the jump of such a node is nothing, friction has nothing to do, and its
normal lies in the plane.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from ...base.constants import SAME
from .matrices import Matrix


def idle(
    held: np.ndarray,
    along: np.ndarray,
    means: Matrix,
    places: np.ndarray,
    size: np.ndarray,
    first: int,
) -> np.ndarray:
    """Components of the jumps at the n nodes of the slave that are none, (n, d) of bool.

    Args:
        held: components of all nodes that supports hold, (N, d) of bool, the slave's first.
        along: components that the slave's normals have at rest, (n, d) of bool.
        means: the jumps of one component, (n, N): which nodes each sees.
        places: of the nodes, (N, d) in m.
        size: of the facets at the nodes, (n,) in m.
        first: number of the master's first node.
    """
    result = held[: len(along)].copy()
    for node in np.flatnonzero(result.any(axis=1)):
        row = means[node] if isinstance(means, np.ndarray) else means[node].toarray()[0]
        theirs = first + np.flatnonzero(row[first:])
        there = np.abs(places[theirs] - places[node]) <= SAME * size[node]
        result[node] &= (held[theirs] & there).any(axis=0)
    whole = (result | ~along).all(axis=1)  # nothing is left of the normal
    return result & ~(whole[:, None] & along)


def without(matrix: Matrix, rows: np.ndarray) -> Matrix:
    """The matrix, of which these rows, of bool, are 0."""
    return sp.diags((~rows.ravel()).astype(float)) @ matrix if rows.any() else matrix
