# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where the unknowns of several solids stand in one system: by process, on each by solid."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI

from ..contact.contact import Contact
from ..solids import MonolithicSolid, MonolithicTrace


class Numbering:
    """Numbers of the unknowns of solids in one system.

    Attributes:
        size: of the system.
        mine: this process's rows.
        numbers: for each solid the number of each of its unknowns.
        own: for each solid the numbers of those that this process owns.
    """

    def __init__(self, solids: Sequence[MonolithicSolid], comm: MPI.Comm) -> None:
        counts = np.array([solid.layout(comm) for solid in solids])  # (solids, ranks)
        start = np.concatenate([[0], np.cumsum(counts.sum(axis=0))])
        self.size = int(start[-1])
        self.mine = slice(int(start[comm.rank]), int(start[comm.rank + 1]))
        self.numbers: list[np.ndarray] = []
        for k, count in enumerate(counts):
            first = start[:-1] + counts[:k].sum(axis=0)
            blocks = [np.arange(a, a + n) for a, n in zip(first, count)]
            self.numbers.append(np.concatenate(blocks))
        self.own = [n[s.owned_range(comm)] for s, n in zip(solids, self.numbers)]

    def renumber(self, operator: sp.csr_matrix, k: int) -> sp.csr_matrix:
        """An operator on the unknowns of solid k as one on those of the system."""
        indices = self.numbers[k][operator.indices]
        return sp.csr_matrix(
            (operator.data, indices, operator.indptr), (operator.shape[0], self.size)
        )


def numbered_traces(
    contact: Contact, solids: Sequence[MonolithicSolid]
) -> list[tuple[int, MonolithicTrace]]:
    """The traces of a contact, each with the number of its solid among these."""
    index = {id(solid): k for k, solid in enumerate(solids)}
    pairs = zip(contact.solids, contact.traces)
    return [(index[id(s)], trace) for s, trace in pairs if isinstance(trace, MonolithicTrace)]
