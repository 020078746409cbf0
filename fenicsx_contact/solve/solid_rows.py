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

    def __call__(self, rows: int = 0, columns: int = 0) -> sp.csr_matrix:
        """The rows, with empty rows and columns behind, where multipliers come and go, if so many
        are asked for."""
        now = self.now()
        if now != self.linearisations:
            self.linearisations = now
            self._values, self._indices, self._indptr = self._joined()
        n, m = max(rows, len(self._indptr) - 1), max(columns, self._places.size)
        indptr = np.pad(self._indptr, (0, n + 1 - len(self._indptr)), "edge")
        return sp.csr_matrix((self._values, self._indices, indptr), (n, m))

    def _joined(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Values, columns and row pointers of the solids below each other, as their rows stand on
        each process; numbers ascend with those of each solid, and so do columns."""
        values, columns, counts = [], [], []
        for k, solid in enumerate(self._solids):
            indptr, indices, data = solid.matrix_rows(self._comm)
            values.append(data)
            columns.append(self._places.number(k, indices).astype(np.int32))
            counts.append(np.diff(indptr))
        indptr = np.concatenate([[0], *counts]).cumsum(dtype=np.int64)
        return np.concatenate(values), np.concatenate(columns), indptr

    def now(self) -> list[int]:
        """The solids' present linearisations."""
        return [solid.linearisation for solid in self._solids]

    def forget(self) -> None:
        """Keep nothing: the rows are not asked for again soon."""
        self.linearisations = []
        self._values = self._indices = self._indptr = np.empty(0)

    def diagonal(self) -> np.ndarray:
        """This process's part of the diagonal."""
        return np.asarray(self().diagonal(k=self._places.mine.start))

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
