# SPDX-License-Identifier: LGPL-3.0-or-later
"""What holds solids without inertia: which points of their contacts, beside their supports.

A step starts from what bears, where that holds all solids and can balance their loads. Else it
starts from what would bear if they were rigid, and the points springs. From a start in which a
solid may go anywhere Newton's method leaps to the weak springs that hold it in the matrix, and
back.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from ..contact.contact import Contact
from ..solids.motions import FREE, Motions
from ..solids.trace import DeformableTrace
from ..theory.scheme import Step
from .equilibrium import Balance

#: Of a contact the point that each row is of, and the rows.
_Rows = tuple[np.ndarray, sp.csr_matrix]


class Grip:
    """What holds the solids of a scene without inertia: their supports, and points of contacts as
    if they were glued, by their normals, with friction by their tangents, too.

    Args:
        solids, contacts: of the scene.
        loose: solids that only contact holds, or springs, which may be weak: these count for
            nothing then, but where contact cannot balance the loads.
    """

    def __init__(
        self, solids: Sequence[Any], contacts: Sequence[Contact], loose: Sequence[Any] = ()
    ) -> None:
        self._contacts, self._loose = contacts, loose
        self._sprung = any(Motions(solid).stand() for solid in loose)
        self._motions = {id(solid): Motions(solid) for solid in solids}
        self._solids = list(solids)
        ends = np.cumsum([0, *(len(each.names) for each in self._motions.values())])
        self._parts = {key: slice(*span) for key, span in zip(self._motions, zip(ends, ends[1:]))}
        self._supports = np.zeros((ends[-1], ends[-1]))
        for key, each in self._motions.items():
            self._supports[self._parts[key], self._parts[key]] += each.held(springs=not loose)

    def gram(self, rows: Sequence[_Rows], points: Sequence[np.ndarray]) -> np.ndarray:
        """How the supports and these points, (n,) of bool for each contact, resist each motion."""
        result = self._supports.copy()
        for (of, jumps), mine in zip(rows, points):
            own = jumps[mine[of]]
            result += (own.T @ own).toarray()
        return result

    def rows(self) -> Iterator[_Rows]:
        """Of each contact the point that each row is of, and the jumps there by all motions."""
        for contact in self._contacts:
            points, pieces = _glued(contact, self._motions)
            d = contact.solid.dim
            rows = sp.csr_matrix((len(points) * d, len(self._supports)))
            for solid, those, sign in zip(contact.solids, pieces, (1.0, -1.0)):
                at = contact.coupling.positions()[points]
                own = self._motions[id(solid)].rows(at, those)
                places = own.indices + self._parts[id(solid)].start
                rows = rows + sp.csr_matrix((sign * own.data, places, own.indptr), rows.shape)
            if contact.friction_law:
                yield np.repeat(points, d), rows
            else:
                yield points, sp.block_diag(list(contact.normal[points][:, None]), "csr") @ rows

    def taken(self, step: Step) -> list[np.ndarray] | None:
        """Of each contact the points that a step is to begin with as if they were glued, 1, and as
        if they were open, -1, of all that may bear; (n,), 0: the others. None where what bears
        holds all solids, and can balance the loads on those that are loose, or springs have to."""
        contacts, bear = self._contacts, self.bearing()
        balance = Balance(self._loose, contacts, step, springs=False)
        values = np.linalg.eigvalsh(self.gram(list(self.rows()), bear))
        if values[0] > FREE * values[-1] and balance.left(bear) is None:
            return None
        may = [c.chosen & (mine | c.coupling.near()) for c, mine in zip(contacts, bear)]
        if self._sprung and balance.left(may) is not None:
            return None
        return [2 * bears - 1 * each for bears, each in zip(balance.spread(may) or may, may)]

    def bearing(self) -> list[np.ndarray]:
        """Of each contact the points that bear as a step begins, (n,) of bool."""
        return [contact.chosen & (contact.status > 0) for contact in self._contacts]

    def name(self, way: np.ndarray) -> str:
        """The solid that moves most by some amounts of all motions, and how."""
        which = self._most(way)
        solid, part = self._solids[which], list(self._parts.values())[which]
        return f"{solid.name!r} against {self._motions[id(solid)].name(way[part])}"

    def pieces(self, way: np.ndarray) -> str:
        """The pieces of that solid, if it is in several, as the end of a sentence."""
        solid = self._solids[self._most(way)]
        told = self._motions[id(solid)].pieces.told
        return f"; {solid.name!r} is in {told}" if told else ""

    def _most(self, way: np.ndarray) -> int:
        ends = [part.stop for part in self._parts.values()]
        return int(np.searchsorted(ends, int(np.abs(way).argmax()), side="right"))


def _glued(contact: Contact, motions: dict[int, Motions]) -> tuple[np.ndarray, list[np.ndarray]]:
    """Numbers of the points of the slave, once for each piece of the master that they see, or that
    is next to them, (n,), and for each solid the pieces, (n,)."""
    coupling, points = contact.coupling, np.arange(len(contact.normal))
    slave, *masters = (motions[id(solid)].pieces for solid in contact.solids)
    own, theirs = slave.at(coupling.reference, contact.facets), []
    for master in masters:
        sees = np.ones((len(points), 1), dtype=bool)
        if master.count > 1:
            trace = contact.traces[1]
            assert isinstance(trace, DeformableTrace)
            at, n = master.at(trace.reference, trace.facets), len(contact.traces[0].positions())
            marks = np.concatenate([np.full((n, master.count), False), np.eye(master.count)[at]])
            every = [np.repeat(mark, contact.solid.dim).astype(float) for mark in marks.T]
            sees = np.stack([coupling.to_jump(mark).any(axis=1) for mark in every], axis=1)
            alone = np.flatnonzero(~sees.any(axis=1))
            next_to = cKDTree(trace.positions()).query(coupling.positions()[alone])[1]
            sees[alone, at[next_to]] = True
        points, piece = np.nonzero(sees)
        theirs.append(piece)
    return points, [own[points], *theirs]
