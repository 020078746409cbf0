# SPDX-License-Identifier: LGPL-3.0-or-later
"""Along what supports let nothing slip: nodes on a plane of symmetry of both solids.

The mean over the facets on one side of the plane sees a slip of those beside the node, as small as
both meshes are stretched differently, and of any sign; by symmetry the other half sees the
opposite. So along there the jump of such a node is nothing, friction has nothing to do, and its
normal lies in the plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

from ...base.constants import SAME
from .matrices import Matrix


def idle(
    still: np.ndarray,
    along: np.ndarray,
    means: Matrix,
    places: np.ndarray,
    size: np.ndarray,
    first: int,
) -> np.ndarray:
    """Components of the jumps at the n nodes of the slave that are none, (n, d) of bool.

    Args:
        still: components of all nodes that supports hold at rest, (N, d) of bool, the slave's
            first.
        along: components that the slave's normals have at rest, (n, d) of bool.
        means: the jumps of one component, (n, N): which nodes each sees.
        places: of the nodes, (N, d) in m.
        size: of the facets at the nodes, (n,) in m.
        first: number of the master's first node.
    """
    nodes, theirs = means.nonzero()
    seen = still[: len(along)].any(axis=1)[nodes] & (theirs >= first)
    nodes, theirs = nodes[seen], theirs[seen]
    there = np.abs(places[theirs] - places[nodes]) <= SAME * size[nodes, None]
    result = np.zeros_like(along)
    np.logical_or.at(result, nodes, still[nodes] & still[theirs] & there)
    whole = (result | ~along).all(axis=1)  # nothing is left of the normal
    return result & ~(whole[:, None] & along)


def supported(traces: Sequence[Any]) -> tuple[np.ndarray, np.ndarray]:
    """Components of the traces' points that nothing but supports moves, flat, of bool, and those of
    them that these hold at rest."""

    def of_all(name: str) -> np.ndarray:
        return np.concatenate(
            [np.broadcast_to(getattr(t, name, False), t.positions().size) for t in traces]
        )

    return of_all("held"), of_all("still")


def without(matrix: Matrix, rows: np.ndarray) -> Matrix:
    """The matrix, of which these rows, of bool, are 0."""
    return sp.diags((~rows.ravel()).astype(float)) @ matrix if rows.any() else matrix
