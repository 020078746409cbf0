# SPDX-License-Identifier: LGPL-3.0-or-later
"""How far an unknown yields that its neighbours go along with.

``1 / A_ii`` is what a unit of force moves unknown i by if all others are held. That is far from
what it does where these yield too: a node of nearly incompressible rubber is stopped by the volume
of its elements, which the nodes about it let it keep. The elements about it tell, on any number of
processes and without a factorisation of the whole; what lies farther off adds little.
"""

from __future__ import annotations

import numpy as np
from petsc4py import PETSc

#: Cost: nodes of a surface that are asked.
ASKED = 4
#: Cost: unknowns about one, at most; the elements farther off are left out.
ABOUT = 400


def yielding(matrix: PETSc.Mat, node: np.ndarray, whole: int) -> float:
    """How far a node n yields at least, in whatever direction: the least eigenvalue of
    ``(A_PP^-1)_nn A_nn``, P being the patch about it, which is held beyond. It is >= 1 where A is
    symmetric and positive, inf where it is singular, and the same in any axes. P is at most half
    of its piece of the solid: what nothing holds would go off.

    Args:
        matrix: A, whose rows this process has in part.
        node: its unknowns, owned, in the numbers of all processes.
        whole: how many its piece of the solid has.
    """
    first, last = matrix.getOwnershipRange()
    most = min(ABOUT, max(whole // 2, len(node)))
    rows: dict[int, tuple[np.ndarray, np.ndarray]] = {}
    patch, about = np.zeros(0, dtype=int), np.unique(node)
    while len(patch) < len(about) <= most:
        patch = about
        rows |= {i: matrix.getRow(i) for i in patch if i not in rows}
        about = np.unique(np.concatenate([patch, *(rows[i][0] for i in patch)]))
        about = about[(about >= first) & (about < last)]
    block = np.zeros((len(patch), len(patch)))
    for k, i in enumerate(patch):
        columns, values = rows[i]
        place = np.searchsorted(patch, columns)
        there = patch[np.minimum(place, len(patch) - 1)] == columns
        block[k, place[there]] = values[there]
    own = np.searchsorted(patch, node)
    forces = np.zeros((len(patch), len(node)))
    forces[own] = block[np.ix_(own, own)]
    try:
        return float(np.linalg.eigvals(np.linalg.solve(block, forces)[own]).real.min())
    except np.linalg.LinAlgError:  # it moves for nothing
        return np.inf
