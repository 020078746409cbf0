# SPDX-License-Identifier: LGPL-3.0-or-later
"""The matrices of all solids as one, by rows: what a monolithic system has before any contact."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI
from petsc4py import PETSc

from ..solids import MonolithicSolid
from .numbering import Numbering


class SolidRows:
    """This process's rows of the solids' matrices, made again where one of these is new.

    Args:
        solids: their solids.
        places: where their unknowns stand.
        comm: the processes.

    Attributes:
        linearisations: of the solids, that the rows are of.
    """

    def __init__(
        self, solids: Sequence[MonolithicSolid], places: Numbering, comm: MPI.Comm
    ) -> None:
        self._solids, self._places, self._comm = list(solids), places, comm
        self.linearisations: list[int] = []
        self._patterns: list[tuple[np.ndarray, np.ndarray]] = []

    def __call__(self, rows: int = 0, columns: int = 0) -> sp.csr_matrix:
        """The rows, with empty rows and columns behind, where multipliers come and go, if so many
        are asked for."""
        now = self.now()
        if now != self.linearisations:
            self.linearisations = now
            matrices = [solid.matrix_rows(self._comm) for solid in self._solids]
            self._arrange([matrix[:2] for matrix in matrices])
            values = np.concatenate([matrix[2] for matrix in matrices])
            self._values = values[self._order.data]
        order = self._order
        n, m = max(rows, order.shape[0]), max(columns, order.shape[1])
        indptr = np.pad(order.indptr, (0, n - order.shape[0]), "edge")
        return sp.csr_matrix((self._values, order.indices, indptr), (n, m))

    def now(self) -> list[int]:
        """The solids' present linearisations."""
        return [solid.linearisation for solid in self._solids]

    def forget(self) -> None:
        """Keep nothing of linear solids, whose rows are not asked for again; of others keep where
        their entries stand."""
        self.linearisations, self._values = [], np.empty(0)
        if all(solid.linear for solid in self._solids):
            self._patterns, self._order = [], sp.csr_matrix((0, 0))

    def _arrange(self, patterns: list[tuple[np.ndarray, np.ndarray]]) -> None:
        """Find where the entries of the solids' matrices stand, if not as before."""
        if self._patterns and all(
            np.array_equal(a, b) for pair in zip(patterns, self._patterns) for a, b in zip(*pair)
        ):
            return
        self._patterns = patterns
        mine, places, columns = self._places.mine, [], []
        for (indptr, indices), own, numbers in zip(
            patterns, self._places.own, self._places.numbers
        ):
            places.append(np.repeat(own[: len(indptr) - 1], np.diff(indptr)) - mine.start)
            columns.append(numbers[indices])
        row, column = np.concatenate(places), np.concatenate(columns)
        shape = mine.stop - mine.start, self._places.size
        self._order = sp.csr_matrix((np.arange(len(row), dtype=np.int32), (row, column)), shape)

    def diagonal(self) -> np.ndarray:
        """The diagonal, on every process."""
        return self.everywhere(self().diagonal(k=self._places.mine.start))

    def everywhere(self, local: np.ndarray) -> np.ndarray:
        """The entries of all processes."""
        return np.concatenate(self._comm.allgather(local)) if self._comm.size > 1 else local


def petsc_matrix(rows: sp.csr_matrix, comm: MPI.Comm, columns: int | None = None) -> PETSc.Mat:
    """The matrix whose rows, one process after the other, are these; ``columns``: how many of them
    are this process's, as many as rows if not given."""
    rows.sort_indices()
    n, size = rows.shape
    columns = n if columns is None else columns
    csr = (rows.indptr.astype(np.int32), rows.indices.astype(np.int32), rows.data)
    return PETSc.Mat().createAIJ(((n, PETSc.DECIDE), (columns, size)), csr=csr, comm=comm)
