# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the contacts add to a system: each process has its points, with their multipliers.

Contacts touch few of the solids' unknowns, those at surfaces; in the numbers of these a process
adds up the rows of its points, its share, and rows go to the processes whose unknowns they are of.
There they stand process by process: what of the solids' unknowns is touched, then the multipliers.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI

from ..base.shared_rows import own_rows, sum_of
from ..contact.part import Part
from ..contact.unknowns import own_multipliers
from ..solids import MonolithicTrace
from .embedding import Added, Embedding
from .numbering import Numbering


class SurfaceRows:
    """This process's share of the contacts.

    Args:
        parts: the contacts' equations.
        traces: of each contact, each with the number of its solid.
        places: where the unknowns of the solids stand.
        comm: the processes.

    Attributes:
        touched: numbers of the unknowns that contacts may touch, ascending, (t,).
        solid: the number of the solid of each, (t,).
        here: which of them are this process's, a slice.
        at: these, counted from the first unknown of this process.
        points: of each contact how many points and how many multipliers this process has.
        multipliers: the numbers of their multipliers among those of all points of all contacts.
    """

    def __init__(
        self,
        parts: Sequence[Part],
        traces: Sequence[Sequence[tuple[int, MonolithicTrace]]],
        places: Numbering,
        comm: MPI.Comm,
    ) -> None:
        self._parts, self._places, self._comm = parts, places, comm
        seen = [
            (places.number(k, np.unique(trace.seeing().indices)), k)
            for each in traces
            for k, trace in each
        ]
        numbers = np.concatenate([np.empty(0, dtype=np.int64), *(each for each, _ in seen)])
        solids = np.repeat([k for _, k in seen], [len(each) for each, _ in seen])
        self.touched, first = np.unique(numbers, return_index=True)
        self.solid = solids[first]
        self._starts = np.searchsorted(self.touched, places.starts)
        self.here = slice(*self._starts[comm.rank : comm.rank + 2])
        self.at = self.touched[self.here] - places.mine.start
        self._embedding = Embedding(parts, traces, self._in_touched)

    def renew(self) -> None:
        """Take up which points may bear now."""
        self._own = [part.own(self._comm) for part in self._parts]
        counts = [part.multipliers for part in self._parts]
        mine = [
            own_multipliers(own, len(part.equations.candidates), count)
            for own, part, count in zip(self._own, self._parts, counts)
        ]
        self.points = [(len(own), len(some)) for own, some in zip(self._own, mine)]
        firsts = np.cumsum([0, *counts])
        self._mine, self._all = mine, int(firsts[-1])
        each = (first + some for first, some in zip(firsts, mine))
        self.multipliers = np.concatenate([np.empty(0, dtype=np.int64), *each])
        # rows stand process by process: touched unknowns, and multipliers behind
        t, m = len(self.touched), len(self.multipliers)
        behind = np.concatenate([[0], np.cumsum(self._comm.allgather(m))])
        self._bounds = self._starts + behind
        owner = np.searchsorted(self._starts, np.arange(t), side="right") - 1
        rank = self._comm.rank
        mine_behind = self._starts[rank + 1] + behind[rank] + np.arange(m)
        self._place = np.concatenate([np.arange(t) + behind[owner], mine_behind])
        self._unknown = np.zeros(self._bounds[-1], dtype=bool)
        self._unknown[self._place[:t]] = True

    def share(self, frozen: bool, held: bool) -> sp.csr_matrix:
        """This process's share, scaled, of the touched unknowns and, behind, its multipliers; if
        ``frozen`` without the derivatives of the geometry, if ``held`` without multipliers."""
        last, size = len(self.touched), len(self.touched) + len(self.multipliers)
        added = []
        for contact, (part, own, mine) in enumerate(zip(self._parts, self._own, self._mine)):
            n = len(part.active_places)
            scales = (each[n + mine] * (not held) for each in part.scales())
            added.append(Added(contact, part.share(own, frozen), *scales))
        return self._embedding.tangent(added, last, size)

    def _in_touched(self, k: int, unknowns: np.ndarray) -> np.ndarray:
        return np.searchsorted(self.touched, self._places.number(k, unknowns))

    def own(self, share: sp.csr_matrix) -> sp.csr_matrix:
        """This process's rows of the sum of all shares, in the order of the processes."""
        n, lengths = int(self._bounds[-1]), np.zeros(self._bounds[-1] + 1, dtype=np.int64)
        lengths[1 + self._place] = np.diff(share.indptr)
        order = np.argsort(self._place)
        share = share[order]
        rows = (share.data, self._place[share.indices], lengths.cumsum())
        return self._rows(sp.csr_matrix(rows, (n, n)), self._bounds)

    def own_touched(self, share: sp.csr_matrix) -> sp.csr_matrix:
        """The same of a matrix of touched unknowns alone."""
        return self._rows(share, self._starts)

    def _rows(self, share: sp.csr_matrix, bounds: np.ndarray) -> sp.csr_matrix:
        owner = np.repeat(np.arange(self._comm.size), np.diff(bounds))
        rank = self._comm.rank
        return own_rows(self._comm, share, owner)[bounds[rank] : bounds[rank + 1]]

    def push(self, rows: sp.csr_matrix) -> sp.csr_matrix:
        """Of :meth:`own` rows what the multipliers of all processes do to this one's unknowns."""
        return rows[: len(self.at)][:, np.flatnonzero(~self._unknown)]

    def everywhere(self, values: np.ndarray) -> np.ndarray:
        """Values of all multipliers, from those of this process's."""
        result = np.zeros(self._all)
        result[self.multipliers] = values
        return sum_of(self._comm, result)

    def touched_everywhere(self, local: np.ndarray) -> np.ndarray:
        """Values of all touched unknowns, from those of all of this process's."""
        result = np.zeros(len(self.touched))
        result[self.here] = local[self.at]
        return sum_of(self._comm, result)
