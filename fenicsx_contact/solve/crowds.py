# SPDX-License-Identifier: LGPL-3.0-or-later
"""The tangent of the surface problem of a crowd: many rigid bodies that meet each other.

It is sparse, as a point knows few nodes and each body yields alone. Of the places of its entries
all is found once for as long as the points see the same nodes; an iteration then takes blocks of
the points alone, and hands what they add up to to SuperLU.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from ..contact.mortar.matrices import Matrix
from ..contact.tangent import PointRows
from .by_points import Place
from .factored import Factored


class Rows(NamedTuple):
    """Rows of a matrix, r of each of c points, in the m columns at most that a point knows.

    Attributes:
        values: (c, r, m); ``columns``: (c, m); ``there``: which are any, (c, m) of bool.
    """

    values: np.ndarray
    columns: np.ndarray
    there: np.ndarray


def point_by_point(matrix: Matrix, points: int) -> Rows:
    """The rows of a sparse matrix, as many of each of so many points."""
    matrix = sp.csr_matrix(matrix)
    each, width = matrix.shape[0] // max(points, 1), matrix.shape[1]
    row = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
    known, which = np.unique(row // max(each, 1) * width + matrix.indices, return_inverse=True)
    owner, count = known // width, np.bincount(known // width, minlength=points)
    slot = np.arange(len(known)) - (np.cumsum(count) - count)[owner]
    shape = points, int(count.max(initial=0))
    columns, there = np.zeros(shape, dtype=np.int64), np.zeros(shape, dtype=bool)
    columns[owner, slot], there[owner, slot] = known % width, True
    values = np.zeros((points, each, shape[1]))
    np.add.at(values, (row // max(each, 1), row % max(each, 1), slot[which]), matrix.data)
    return Rows(values, columns, there)


class _Block:
    """What the tangent takes of one part, and where.

    Args:
        rows: its tangent point by point.
        place: where its active unknowns stand.
        W: compliance of the active velocities, which stand first.
        scales: of rows and columns.

    Attributes:
        places: rows and columns of its entries, (2, e).
        mine: where the multipliers of its points stand, (c, k).
    """

    def __init__(
        self,
        rows: PointRows,
        place: np.ndarray,
        W: sp.csr_matrix,
        scales: tuple[np.ndarray, np.ndarray],
    ) -> None:
        c, inner, _ = rows.tangents.shape
        k = int((place >= W.shape[0]).sum()) // max(c, 1)
        self._velocities, self._d = place[: len(place) - c * k], inner - k
        self.mine = mine = place[len(place) - c * k :].reshape(k, c).T
        own = sp.identity(len(self._velocities), format="csr")
        reads, spreads = (own if each is None else each for each in (rows.reads, rows.spreads))
        self._reads, self._spreads = (point_by_point(each, c) for each in (reads, spreads))
        own_W = W[:, self._velocities]  # symmetric
        self._moves = moves = point_by_point(spreads @ own_W.T, c)
        at = self._velocities[self._reads.columns] if c else self._reads.columns
        multipliers = np.ones(mine.shape, dtype=bool)
        columns, lines = (np.concatenate([each, mine], axis=1) for each in (at, moves.columns))
        known, moved = (
            np.concatenate([each.there, multipliers], axis=1) for each in (self._reads, moves)
        )
        self._mask = moved[:, :, None] & known[:, None]
        pair = np.broadcast_arrays(lines[:, :, None], columns[:, None])
        self.places = np.stack([each[self._mask] for each in pair])
        self._scaling = scales[0][mine][:, :, None] * scales[1][at][:, None]

    def _seen(self, tangents: np.ndarray) -> np.ndarray:
        """Tangents of the points by the velocities that they know and by their multipliers."""
        read = self._reads.values.shape[1]
        by_velocities = tangents[:, :, :read] @ self._reads.values
        return np.concatenate([by_velocities, tangents[:, :, read:]], axis=2)

    def entries(self, tangents: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The entries, (e,), and the largest of each row of the multipliers by velocities, scaled,
        (c, k)."""
        seen, d = self._seen(tangents), self._d
        moved = self._moves.values.transpose(0, 2, 1) @ seen[:, :d]
        entries = np.concatenate([moved, seen[:, d:]], axis=1)[self._mask]
        by_velocities = seen[:, d:, : self._scaling.shape[2]] * self._scaling
        return entries, np.abs(by_velocities).max(axis=2, initial=0.0)

    def forces(self, rows: PointRows, step: np.ndarray, onto: np.ndarray) -> None:
        """Add to the forces on the velocities what a step changes of them."""
        dv = step[self._velocities]
        known = np.concatenate([dv[self._reads.columns], step[self.mine]], axis=1)
        force = (self._seen(rows.tangents)[:, : self._d] @ known[:, :, None])[:, :, 0]
        each = (force[:, None] @ self._spreads.values)[:, 0]
        count = len(self._velocities)
        sums = np.bincount(self._spreads.columns.ravel(), each.ravel(), count)
        if rows.turning is not None:
            sums += rows.turning @ dv
        onto[self._velocities] += sums


class _Stiffness:
    """Derivative of the forces on the active velocities: its products with steps."""

    def __init__(self, blocks: Sequence[_Block], rows: Sequence[PointRows], nw: int) -> None:
        self._blocks, self._rows, self._nw = blocks, rows, nw

    def __matmul__(self, step: np.ndarray) -> np.ndarray:
        result = np.zeros(self._nw)
        for block, rows in zip(self._blocks, self._rows):
            block.forces(rows, step, result)
        return result


class CrowdTangent:
    """Makes and factors it, as long as points see the same nodes.

    Args:
        placed: the contacts' tangents, and where they stand.
        W: compliance of the active velocities, which stand first.
        scales: of rows and columns.
    """

    def __init__(
        self,
        placed: Sequence[Place],
        W: sp.csr_matrix,
        scales: tuple[np.ndarray, np.ndarray],
    ) -> None:
        self._placed, self._W, self._scales = placed, W, scales
        self._blocks: list[_Block] = []
        self._places = np.empty((2, 0), dtype=np.int64)

    def of(self, placed: Sequence[Place], W: sp.csr_matrix) -> bool:
        """Whether it is that of these."""
        return placed is self._placed and W is self._W

    def factored(self, active: np.ndarray, compliance: float, softened: bool) -> Factored | None:
        """The tangent, its multipliers made so compliant (scaled); None where singular.

        Args:
            active: the velocities among all.
            compliance: of the multipliers; ``softened``: whether that is of springs, and a part of
                the tangent.
        """
        size, nw, scales = len(self._scales[0]), len(active), self._scales
        rows = [part.point_rows() for part, _ in self._placed]
        if not self._blocks:
            given = zip(rows, self._placed)
            self._blocks = [_Block(each, place, self._W, scales) for each, (_, place) in given]
        diagonal = np.tile(np.arange(size), (2, 1))
        data, places, softer = [(diagonal[0] < nw).astype(float)], [diagonal], np.zeros(size)
        for block, each, (_, place) in zip(self._blocks, rows, self._placed):
            entries, largest = block.entries(each.tangents)
            softer[block.mine] = compliance * (1.0 if softened else np.maximum(1.0, largest) ** 2)
            data.append(entries)
            places.append(block.places)
            if each.turning is not None:
                mine = place[: each.turning.shape[0]]
                moved = (self._W[:, mine] @ sp.csr_matrix(each.turning)).tocoo()
                data.append(moved.data)
                places.append(np.stack([moved.row, mine[moved.col]]))
        self._arrange(np.concatenate(places, axis=1))
        values = np.bincount(self._slot, np.concatenate(data), len(self._scaling)) * self._scaling
        regular = values.copy()
        regular[self._slot[:size]] -= softer
        try:
            inverse = splu(self._matrix(regular)).solve
        except RuntimeError:  # exactly singular
            return None
        matrix = None if softened else self._matrix(values)
        return Factored(_Stiffness(self._blocks, rows, nw), matrix, inverse, *scales, active)

    def _arrange(self, places: np.ndarray) -> None:
        """Find where entries at these places, (2, e), add up in the matrix, column by column."""
        if np.array_equal(places, self._places):
            return
        size, (rows, columns) = len(self._scales[0]), places
        known, self._slot = np.unique(columns * size + rows, return_inverse=True)
        self._indices, which = (known % size).astype(np.int32), known // size
        self._indptr = np.searchsorted(which, np.arange(size + 1)).astype(np.int32)
        self._scaling = self._scales[0][self._indices] * self._scales[1][which]
        self._places = places

    def _matrix(self, values: np.ndarray) -> sp.csc_matrix:
        size = len(self._scales[0])
        return sp.csc_matrix((values, self._indices, self._indptr), (size, size))
