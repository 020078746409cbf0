# SPDX-License-Identifier: LGPL-3.0-or-later
"""Matrices of a surface: dense while small, for speed, and sparse above.

Both kinds know ``@``, ``+``, rows by index and ``.T``; the rest is here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

Matrix = Any  # np.ndarray or sp.csr_matrix
#: Cost: entries of the largest dense matrix.
DENSE = 400_000


def add_up(values: np.ndarray, rows: np.ndarray, n: int) -> np.ndarray:
    """Sums (n, k) of the values (..., k) that belong to the same row (...)."""
    k = values.shape[-1]
    places = rows if k == 1 else rows[..., None] * k + np.arange(k)
    return _sums(places.ravel(), values, n * k).reshape(n, k)


def _sums(places: np.ndarray, values: np.ndarray, size: int) -> np.ndarray:
    """Sums (size,) of the values at each place; of nothing numpy counts integers."""
    return np.bincount(places, values.ravel(), size).astype(float, copy=False)


def gather(
    entries: np.ndarray, rows: np.ndarray, columns: np.ndarray, shape: tuple[int, int], dense: bool
) -> Matrix:
    """The matrix of these entries; what falls together adds. The index arrays broadcast; along the
    last axis rows are the same."""
    if dense:
        rows, columns = (np.broadcast_to(x, entries.shape).ravel() for x in (rows, columns))
        return _sums(rows * shape[1] + columns, entries, shape[0] * shape[1]).reshape(shape)
    # a product of matrices adds lines of entries, neither sorting these nor naming all their rows
    lines = np.broadcast_to(rows, (*entries.shape[:-1], 1)).ravel()
    each = np.arange(len(lines) + 1)
    columns = np.broadcast_to(columns.astype(np.int32), entries.shape).ravel()
    given = (entries.ravel(), columns, each * entries.shape[-1])
    pick = sp.csr_matrix((np.ones(len(lines)), (lines, each[:-1])), (shape[0], len(lines)))
    result = pick @ sp.csr_matrix(given, (len(lines), shape[1]))
    result.sort_indices()
    return result


def dense(matrix: Matrix) -> np.ndarray:
    """The matrix as an array."""
    return matrix if isinstance(matrix, np.ndarray) else matrix.toarray()


def stack(matrices: Sequence[Matrix]) -> Matrix:
    """Below each other."""
    if isinstance(matrices[0], np.ndarray):
        return np.vstack(matrices)
    return sp.vstack(matrices, format="csr")


def block(matrices: Sequence[Sequence[Matrix]]) -> Matrix:
    """A matrix of matrices."""
    if isinstance(matrices[0][0], np.ndarray):
        return np.concatenate([np.concatenate(row, axis=1) for row in matrices])
    return sp.bmat(matrices, format="csr")


def placed(matrix: Matrix, rows: np.ndarray, columns: np.ndarray, shape: tuple[int, int]) -> Matrix:
    """The matrix of this shape that has these rows and columns, whose numbers ascend, and no other
    entries."""
    if matrix.shape == shape:
        return matrix
    if isinstance(matrix, np.ndarray):
        result = np.zeros(shape)
        result[np.ix_(rows, columns)] = matrix
        return result
    entries = matrix.tocoo()
    return sp.csr_matrix((entries.data, (rows[entries.row], columns[entries.col])), shape)


def used_columns(matrices: Sequence[Matrix]) -> np.ndarray:
    """Columns that have an entry in any of them, sorted."""
    if isinstance(matrices[0], np.ndarray):
        return np.flatnonzero(np.any([(m != 0).any(axis=0) for m in matrices], axis=0))
    return np.unique(np.concatenate([m.indices for m in matrices])).astype(np.int64)


def nonzero(matrix: Matrix) -> int:
    """How many entries are not zero."""
    return int(
        np.count_nonzero(matrix) if isinstance(matrix, np.ndarray) else matrix.count_nonzero()
    )


def square(matrix: Matrix) -> Matrix:
    """The squares of the entries."""
    return matrix**2 if isinstance(matrix, np.ndarray) else matrix.power(2)


def by_point(blocks: np.ndarray, matrix: Matrix) -> Matrix:
    """The product with a matrix of c k rows of the one whose diagonal blocks are (c, u, k)."""
    c, u, k = blocks.shape
    if isinstance(matrix, np.ndarray):
        return (blocks @ matrix.reshape(c, k, matrix.shape[1])).reshape(c * u, matrix.shape[1])
    indices = np.broadcast_to(np.arange(c * k).reshape(c, 1, k), blocks.shape)
    indptr = np.arange(c * u + 1) * k
    return sp.csr_matrix((blocks.ravel(), indices.ravel(), indptr), (c * u, c * k)) @ matrix


def by_component(matrix: Matrix, d: int) -> Matrix:
    """The same for each of d components."""
    if isinstance(matrix, np.ndarray):
        n, m = matrix.shape
        result = np.zeros((n, d, m, d))
        for i in range(d):
            result[:, i, :, i] = matrix
        return result.reshape(n * d, m * d)
    return sp.kron(matrix, sp.identity(d), format="csr")


def along(vectors: np.ndarray, matrix: Matrix) -> Matrix:
    """Rows ``vectors_i . matrix_i`` from vectors (n, d) and a matrix of n d rows."""
    n, d = vectors.shape
    if isinstance(matrix, np.ndarray):
        return np.einsum("id,idk->ik", vectors, matrix.reshape(n, d, -1))
    rows = np.repeat(np.arange(n), d), np.arange(n * d)
    return sp.csr_matrix((vectors.ravel(), rows)) @ matrix
