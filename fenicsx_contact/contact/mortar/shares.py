# SPDX-License-Identifier: LGPL-3.0-or-later
"""Several processes pair a surface: each its share of the slave's facets, and of its nodes.

Every process knows where both surfaces are, seeks partners of its facets alone, and integrates
there. What is known at nodes is summed up for all, in the same order on every process, so that all
go on with the same digits; of matrices each process has the rows of its nodes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np
from mpi4py import MPI
from scipy.spatial import cKDTree

from ...base.processes import any_of, together
from ...base.shared_rows import own_rows, sum_of, whole
from .matrices import Matrix, used_columns
from .side import Side

T = TypeVar("T")
#: Cost: facets beside each other that one process takes: more share fewer nodes with others',
#: fewer are the same work for all.
PATCH = 64


class Shares:
    """This process's facets and nodes, and sums over all.

    Args:
        side: the slave.
        comm: the processes.

    Attributes:
        facets: this process's, ascending.
        facet_here, node_here: whether each facet, and each node at a corner, is this process's.
    """

    def __init__(self, side: Side, comm: MPI.Comm) -> None:
        self._comm = comm
        m = len(side.cells)
        # patches of the surface, dealt out one after the other
        middles = side.nodes[side.corners].mean(axis=1)
        patches = np.arange(m) // max(1, min(PATCH, m // comm.size))
        process = np.empty(m, dtype=np.int64)
        process[cKDTree(middles, leafsize=PATCH).indices] = patches % comm.size
        self.facet_here = process == comm.rank
        self.facets = np.flatnonzero(self.facet_here)
        self._owner = np.zeros(int(side.corners.max()) + 1, dtype=np.int64)
        self._owner[side.corners] = process[:, None]
        self.node_here = self._owner == comm.rank

    def together(self, action: Callable[[], T]) -> T:
        """What an action returns; a step that fails on one process fails on all."""
        return together(self._comm, action)

    def anywhere(self, truth: bool) -> bool:
        """Whether that holds on any process."""
        return any_of(self._comm, truth)[0]

    def sum(self, values: np.ndarray) -> np.ndarray:
        """The sum of arrays of one shape."""
        return sum_of(self._comm, values)

    def rows(self, share: Matrix) -> Matrix:
        """Of a matrix whose share each process has the rows of this process's nodes, which may
        have several each; the others are empty."""
        return own_rows(self._comm, share, self._owner.repeat(share.shape[0] // len(self._owner)))

    def columns(self, matrices: Sequence[Matrix]) -> np.ndarray:
        """Columns that have an entry in any of these matrices on any process, ascending."""
        used = np.zeros(matrices[0].shape[1])
        used[used_columns(matrices)] = 1.0
        return np.flatnonzero(self.sum(used))

    def whole(self, share: Matrix) -> Matrix:
        """The matrix whose share each process has."""
        return whole(self._comm, share)
