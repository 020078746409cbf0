# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where the tangents of contacts stand in a larger system: what their points see of its unknowns,
and what they push, by the traces of the solids; their multipliers stand behind."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from ..contact.part import Part
from ..solids import MonolithicTrace

#: Rows, columns and values.
_Entries = tuple[np.ndarray, np.ndarray, np.ndarray]
_NOTHING: _Entries = np.empty(0, dtype=int), np.empty(0, dtype=int), np.empty(0)


class Added(NamedTuple):
    """What a contact adds: its number, its tangent in its active velocities and some multipliers,
    and the scales of the columns and the rows of these."""

    contact: int
    tangent: sp.csr_matrix
    columns: np.ndarray
    rows: np.ndarray


class Embedding:
    """Takes what contacts add to a system there, of all of them at once: many are small.

    Args:
        parts: the contacts' equations.
        traces: of each contact, each with the number of its solid.
        number: the numbers in the system of some unknowns of solid k.
    """

    def __init__(
        self,
        parts: Sequence[Part],
        traces: Sequence[Sequence[tuple[int, MonolithicTrace]]],
        number: Callable[[int, np.ndarray], np.ndarray],
    ) -> None:
        self._parts, self._traces, self._number = parts, traces, number
        self._entries: dict[tuple[int, str], tuple] = {}
        self._kept: dict[str, tuple[tuple, sp.csr_matrix | None]] = {}

    def tangent(self, added: Sequence[Added], last: int, size: int) -> sp.csr_matrix:
        """What contacts add, (size, size); the first of their multipliers is number ``last``. Their
        tangents are changed."""
        blocks = [_scaled(each, len(self._parts[each.contact].active_places)) for each in added]
        counts = [(each.contact, len(each.rows)) for each in added]
        push, see = (self.onto(counts, which, last, size) for which in ("spreading", "seeing"))
        return (push.T @ (_diagonal(blocks) @ see)).tocsr()

    def onto(
        self, contacts: Sequence[tuple[int, int]], which: str, last: int, size: int
    ) -> sp.csr_matrix:
        """From the unknowns of the system to the active ones of contacts, each with so many
        multipliers behind, whose numbers begin with ``last``; by the operators of the traces of
        that name. Kept while nothing changes."""
        found, keys, first = [_NOTHING], [], 0
        for contact, m in contacts:
            (rows, columns, values), key = self._seen(contact, which)
            n = len(self._parts[contact].active_places)
            behind = np.arange(m)
            found.append((first + rows, columns, values))
            found.append((first + n + behind, last + behind, np.ones(m)))
            keys.append((key, m))
            first, last = first + n + m, last + m
        kept, result = self._kept.get(which, ((), None))
        if result is None or kept != (*keys, size):
            rows, columns, values = map(np.concatenate, zip(*found))
            result = sp.csr_matrix((values, (rows, columns)), (first, size))
            self._kept[which] = (*keys, size), result
        return result

    def _seen(self, contact: int, which: str) -> tuple[_Entries, tuple]:
        """Of the active unknowns of a contact, and what tells whether they are the same."""
        active, traces = self._parts[contact].active_places, self._traces[contact]
        operators = [getattr(trace, which)() for _, trace in traces]
        key = contact, *map(id, operators), active.tobytes()
        if key != self._entries.get((contact, which), ((), None, None))[0]:
            rows = np.arange(sum(each.shape[0] for each in operators))
            of = np.repeat(rows, np.concatenate([np.diff(each.indptr) for each in operators]))
            numbers = [self._number(k, each.indices) for each, (k, _) in zip(operators, traces)]
            at = np.full(len(rows), -1)
            at[active] = np.arange(len(active))
            here = at[of] >= 0
            values = np.concatenate([each.data for each in operators])[here]
            entries = at[of][here], np.concatenate(numbers)[here], values
            self._entries[contact, which] = key, entries, operators  # alive, for their ids
        return self._entries[contact, which][1], key


def _scaled(added: Added, active: int) -> sp.csr_matrix:
    """The tangent of a contact, its multipliers scaled."""
    ones, tangent = np.ones(active), added.tangent
    columns, rows = (np.concatenate([ones, each]) for each in (added.columns, added.rows))
    tangent.data *= np.repeat(rows, np.diff(tangent.indptr)) * columns[tangent.indices]
    return tangent


def _diagonal(blocks: Sequence[sp.csr_matrix]) -> sp.csr_matrix:
    """The matrix of these blocks."""
    if len(blocks) == 1:
        return blocks[0]
    firsts = np.cumsum([0, *(block.shape[0] for block in blocks)])
    entries = np.cumsum([0, *(block.nnz for block in blocks)])
    each = zip(blocks, firsts, entries)
    moved = [(block.indices + f, block.indptr[1:] + e, block.data) for block, f, e in each]
    columns, ends, values = map(np.concatenate, zip(_NOTHING, *moved))
    return sp.csr_matrix((values, columns, np.append(0, ends)), (int(firsts[-1]),) * 2)
