# SPDX-License-Identifier: LGPL-3.0-or-later
"""Several processes pair a surface: each its share of the slave's facets.

Every process knows where both surfaces are, seeks partners of its facets alone, and integrates
there. Only sums over the facets travel, those at the nodes and those in matrices; they are added in
the same order on every process, so that all go on with the same digits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI
from scipy.spatial import cKDTree

from ...base.processes import any_of, together
from .matrices import Matrix
from .side import Side

T = TypeVar("T")
#: Cost: facets beside each other that one process takes: more share fewer nodes with others',
#: fewer are the same work for all.
PATCH = 64


class Shares:
    """This process's facets, and sums over all.

    Args:
        side: the slave; lines are not shared out, and everybody has all of them.
        comm: the processes.

    Attributes:
        facets: this process's, ascending.
    """

    def __init__(self, side: Side, comm: MPI.Comm) -> None:
        alone = side.dim == 2 or comm.size == 1
        self._comm: Any = MPI.COMM_SELF if alone else comm
        m = len(side.cells)
        self.facets = np.arange(m)
        if not alone:  # patches of the surface, dealt out one after the other
            middles = side.nodes[side.corners].mean(axis=1)
            patches = np.arange(m) // max(1, min(PATCH, m // comm.size))
            order = cKDTree(middles, leafsize=PATCH).indices
            self.facets = np.sort(order[patches % comm.size == comm.rank])

    def together(self, action: Callable[[], T]) -> T:
        """What an action returns; a step that fails on one process fails on all."""
        return together(self._comm, action)

    def anywhere(self, truth: bool) -> bool:
        """Whether that holds on any process."""
        return any_of(self._comm, truth)[0]

    def sum(self, values: np.ndarray) -> np.ndarray:
        """The sum of arrays of one shape."""
        if self._comm.size == 1:
            return values
        total = np.empty(values.shape)
        self._comm.Reduce(np.ascontiguousarray(values, dtype=float), total)  # counts of nothing
        self._comm.Bcast(total)
        return total

    def add(self, matrix: Matrix) -> Matrix:
        """The sum of matrices of one shape."""
        if self._comm.size == 1:
            return matrix
        if isinstance(matrix, np.ndarray):
            return self.sum(matrix)
        counts = self._comm.allgather(matrix.nnz)
        parts = [
            _everywhere(self._comm, each, sizes)
            for each, sizes in (
                (matrix.data, counts),
                (matrix.indices.astype(np.int32), counts),
                (matrix.indptr.astype(np.int64), [matrix.shape[0] + 1] * len(counts)),
            )
        ]
        total = sp.csr_matrix(matrix.shape)
        for part in zip(*parts):
            total = total + sp.csr_matrix(part, matrix.shape)
        return total


def _everywhere(comm: MPI.Comm, array: np.ndarray, counts: list[int]) -> list[np.ndarray]:
    """The arrays of all processes, which are so long."""
    every = np.empty(sum(counts), dtype=array.dtype)
    comm.Allgatherv(np.ascontiguousarray(array), (every, counts))
    return np.split(every, np.cumsum(counts)[:-1])
