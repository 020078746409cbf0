# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rigid motions of a deformable solid, and which of them nothing holds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

from .rotations import by_spins

#: Rigid motions that meet less than this share of the greatest resistance are free.
FREE = 1e-10


class Motions:
    """The rigid motions of a solid, piece by piece: unit velocities, and rotations that give such
    at its ends.

    Attributes:
        pieces: of the solid, see :class:`~.pieces.Pieces`.
        each: how many motions a piece has, translations first.
        names: of all.
    """

    def __init__(self, solid: Any) -> None:
        self._solid, self.pieces = solid, solid.vectors.pieces
        d = solid.dim
        axes = "xyz"[:d]
        turns = ["turning"] if d == 2 else [f"turning about {axis}" for axis in axes]
        self.names = [f"moving along {axis}" for axis in axes] + turns
        self.each = len(self.names)
        if self.pieces.count > 1:
            about = ["[" + ", ".join(f"{x:.6g}" for x in at) + "]" for at in self.pieces.centres]
            self.names = [f"{each} (its piece about {at})" for at in about for each in self.names]

    def held(self, springs: bool = True) -> np.ndarray:
        """How the supports, and joints of pieces, resist each motion, (motions, motions), with
        springs or without."""
        solid, every = self._solid, self.at_nodes()
        rows = every[solid.fixed_unknowns]
        gram = (rows.T @ rows).toarray()
        for foundation in solid.foundations if springs else ():
            for k in range(len(self.names)):
                against = foundation.times(every[:, [k]].toarray().ravel())
                gram[:, k] += every.T @ against / foundation.stiffest
        nodes, pieces, places = self.pieces.joints
        here = solid.vectors.places[nodes], self.pieces.of_nodes[nodes]
        apart = self.rows(*here) - self.rows(places, pieces)  # strains one of its pieces
        gram += (apart.T @ apart).toarray()
        gram = np.array(solid.comm.allreduce(gram))
        for motion in solid.plane.resisted:
            which = np.arange(motion, len(gram), self.each)
            gram[which, which] += 1.0
        return gram

    def stand(self, springs: bool = True) -> bool:
        """Whether the supports hold them all; with springs, or without, which may be weak."""
        values = np.linalg.eigvalsh(self.held(springs))
        return bool(values[0] > FREE * values[-1])

    def rows(self, points: np.ndarray, pieces: np.ndarray) -> sp.csr_matrix:
        """Velocities of points (n, 2 or 3) of some pieces, (n,): (n d, motions)."""
        n, d = len(points), self._solid.dim
        arm = (points[:, :d] - self.pieces.centres[pieces]) / self.pieces.sizes[pieces, None]
        steady = np.broadcast_to(np.eye(d), (n, d, d))
        values = np.concatenate([steady, by_spins(arm)], axis=-1)
        columns = np.repeat(self.each * pieces, d)[:, None] + np.arange(self.each)
        ends = np.arange(n * d + 1) * self.each
        return sp.csr_matrix((values.ravel(), columns.ravel(), ends), (n * d, len(self.names)))

    def at_nodes(self) -> sp.csr_matrix:
        """Velocities of the owned nodes, (owned, motions)."""
        return self.rows(self._solid.vectors.places, self.pieces.of_nodes)

    def amounts(self, field: np.ndarray) -> np.ndarray:
        """The motions that are nearest to a field, (owned,), over the sizes of their pieces,
        (pieces, each)."""
        nodes, pieces, places = self.pieces.joints
        rows = sp.vstack([self.at_nodes(), self.rows(places, pieces)]).tocsr()
        field = np.concatenate([field, field.reshape(-1, self._solid.dim)[nodes].ravel()])
        comm = self._solid.comm
        gram = comm.allreduce((rows.T @ rows).toarray())
        amounts = np.linalg.solve(gram, comm.allreduce(rows.T @ field))
        return np.abs(amounts.reshape(-1, self.each)) / self.pieces.sizes[:, None]

    def name(self, way: np.ndarray) -> str:
        """The motion of the piece that moves most by some amounts of all, (motions,): what turns
        about a point no farther from its centre than twice its ends does so."""
        every, d = np.abs(way).reshape(-1, self.each), self._solid.dim
        piece = int(every.max(axis=1).argmax())
        amounts = every[piece]
        turns = d * bool(2 * amounts[d:].max() >= amounts[:d].max())
        return self.names[piece * self.each + turns + int(amounts[turns:].argmax())]

    def free(self, springs: bool = True) -> np.ndarray:
        """Those that strain the solid and its supports by nothing, (motions, free ones), with its
        springs or without; of what is not linear translations only, for turns work on its
        stresses."""
        k = self.each if self._solid.linear else self._solid.dim
        which = np.arange(len(self.names)).reshape(-1, self.each)[:, :k].ravel()
        values, vectors = np.linalg.eigh(self.held(springs)[np.ix_(which, which)])
        found = vectors[:, values <= FREE * max(values[-1], 1.0)]
        free = np.zeros((len(self.names), found.shape[1]))
        free[which] = found
        return free


def floats(solids: Sequence[Any]) -> bool:
    """Whether, of several solids that deform, one may move rigidly for nothing but its springs,
    which may be weak."""
    several = len({id(solid) for solid in solids}) > 1
    return several and not all(Motions(solid).stand(springs=False) for solid in solids)
