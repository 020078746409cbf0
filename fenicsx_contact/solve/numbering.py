# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where the unknowns of several solids stand in one system: by process, on each by solid."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mpi4py import MPI

from ..contact.contact import Contact
from ..solids import MonolithicSolid, MonolithicTrace


class Numbering:
    """Numbers of the unknowns of solids in one system.

    Attributes:
        size: of the system.
        starts: the first row of each process, and the size.
        mine: this process's rows.
        own: for each solid the numbers of those that this process owns.
    """

    def __init__(self, solids: Sequence[MonolithicSolid], comm: MPI.Comm) -> None:
        counts = np.array([solid.layout(comm) for solid in solids])  # (solids, ranks)
        self.starts = start = np.concatenate([[0], np.cumsum(counts.sum(axis=0))])
        self.size = int(start[-1])
        self.mine = slice(int(start[comm.rank]), int(start[comm.rank + 1]))
        # of each solid, for each process: how many unknowns it and those before it have, and what
        # is added to the number of an unknown in the solid
        self._ends = counts.cumsum(axis=1)
        before = counts.cumsum(axis=0) - counts
        self._shifts = start[:-1] + before - (self._ends - counts)
        ranges = [solid.owned_range(comm) for solid in solids]
        self.own = [self.number(k, np.arange(r.start, r.stop)) for k, r in enumerate(ranges)]

    def number(self, k: int, unknowns: np.ndarray) -> np.ndarray:
        """Numbers of some unknowns of solid k."""
        process = np.searchsorted(self._ends[k], unknowns, side="right")
        return np.asarray(unknowns + self._shifts[k][process])

    def all_of(self, k: int) -> np.ndarray:
        """Numbers of all unknowns of solid k."""
        return self.number(k, np.arange(self._ends[k][-1]))


def numbered_traces(
    contact: Contact, solids: Sequence[MonolithicSolid]
) -> list[tuple[int, MonolithicTrace]]:
    """The traces of a contact, each with the number of its solid among these."""
    index = {id(solid): k for k, solid in enumerate(solids)}
    pairs = zip(contact.solids, contact.traces)
    return [(index[id(s)], trace) for s, trace in pairs if isinstance(trace, MonolithicTrace)]
