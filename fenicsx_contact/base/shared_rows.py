# SPDX-License-Identifier: LGPL-3.0-or-later
"""Matrices that several processes hold in shares, which add up to them, and rows by owner.

A share is a matrix of the whole shape; on one process it is the whole. All sums are taken in the
order of the processes, so that they have the same digits wherever they are asked for.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

Csr = tuple[np.ndarray, np.ndarray, np.ndarray]


def sum_of(comm: Any, values: np.ndarray) -> np.ndarray:
    """The sum of arrays of one shape."""
    if comm.size == 1:
        return values
    total = np.empty(values.shape)
    comm.Reduce(np.ascontiguousarray(values, dtype=float), total)
    comm.Bcast(total)
    return total


def whole(comm: Any, share: np.ndarray | sp.csr_matrix) -> np.ndarray | sp.csr_matrix:
    """The matrix whose share each process has, dense or sparse."""
    if comm.size == 1:
        return share
    if isinstance(share, np.ndarray):
        return sum_of(comm, share)
    return _sum(comm.allgather(_packed(share)), share.shape)


def own_rows(
    comm: Any, share: np.ndarray | sp.csr_matrix, owner: np.ndarray
) -> np.ndarray | sp.csr_matrix:
    """Those rows of the matrix whose share each process has that are this process's, the others
    empty; ``owner``: the process of each row."""
    if comm.size == 1:
        return share
    if isinstance(share, np.ndarray):
        return np.where((owner == comm.rank)[:, None], sum_of(comm, share), 0.0)
    which = [np.flatnonzero(owner == rank) for rank in range(comm.size)]
    mine, n = which[comm.rank], share.shape[1]
    rows = _sum(comm.alltoall([_packed(share[rows]) for rows in which]), (len(mine), n))
    lengths = np.zeros(len(owner) + 1, dtype=rows.indptr.dtype)
    lengths[1 + mine] = np.diff(rows.indptr)
    return sp.csr_matrix((rows.data, rows.indices, lengths.cumsum()), share.shape)


def _packed(matrix: sp.csr_matrix) -> Csr:
    return matrix.data, matrix.indices.astype(np.int32), matrix.indptr


def _sum(shares: list[Csr], shape: tuple[int, int]) -> sp.csr_matrix:
    total = sp.csr_matrix(shape)
    for share in shares:
        total = total + sp.csr_matrix(share, shape)
    return total
