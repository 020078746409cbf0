# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where the tangents of contacts stand in a larger system: what their points see of its unknowns,
and what they push, by the traces of the solids; their multipliers stand behind."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import scipy.sparse as sp

from ..contact.part import Part
from ..solids import MonolithicTrace


class Embedding:
    """Takes what contacts add to a system there.

    Args:
        parts: the contacts' equations.
        traces: of each contact, each with the number of its solid.
        numbered: an operator on the unknowns of solid k as one on those of the system.
    """

    def __init__(
        self,
        parts: Sequence[Part],
        traces: Sequence[Sequence[tuple[int, MonolithicTrace]]],
        numbered: Callable[[sp.csr_matrix, int], sp.csr_matrix],
    ) -> None:
        self._parts, self._traces, self._numbered = parts, traces, numbered
        self._kept: dict[tuple[int, str], tuple] = {}

    def tangent(
        self,
        contact: int,
        tangent: sp.csr_matrix,
        scales: tuple[np.ndarray, np.ndarray],
        last: int,
        size: int,
    ) -> sp.csr_matrix:
        """What a contact adds, (size, size).

        Args:
            contact: its number.
            tangent: in its active velocities and some multipliers; it is changed.
            scales: of the columns and the rows of these multipliers.
            last: number of the first of them in the system.
            size: of the system.
        """
        ones = np.ones(len(self._parts[contact].active_places))
        columns, rows = (np.concatenate([ones, each]) for each in scales)
        tangent.data *= np.repeat(rows, np.diff(tangent.indptr)) * columns[tangent.indices]
        place = len(scales[0]), last, size
        push, see = (self.onto(contact, which, *place) for which in ("spreading", "seeing"))
        return push.T @ (tangent @ see)

    def onto(self, contact: int, which: str, m: int, last: int, size: int) -> sp.csr_matrix:
        """From the unknowns of the system to the active ones of a contact and m multipliers behind,
        whose numbers begin with ``last``; by the operators of the traces of that name. Kept while
        nothing changes."""
        traces, active = self._traces[contact], self._parts[contact].active_places
        operators = [getattr(trace, which)() for _, trace in traces]
        key = (*map(id, operators), active.tobytes(), last, m, size)
        if key != self._kept.get((contact, which), ((), None, None))[0]:
            numbered = [self._numbered(each, k) for each, (k, _) in zip(operators, traces)]
            velocities = sp.vstack(numbered, "csr")[active]
            velocities.resize(len(active), size)
            own = sp.csr_matrix((np.ones(m), (np.arange(m), last + np.arange(m))), (m, size))
            self._kept[contact, which] = key, sp.vstack([velocities, own], "csr"), operators
        return self._kept[contact, which][1]
