# SPDX-License-Identifier: LGPL-3.0-or-later
"""A preconditioner: the system with springs in the contact, whose multipliers are eliminated point
by point, each by the process that has it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from petsc4py import PETSc

from ..base.checks import StepFailed
from .multigrid import Multigrid


class ThroughSprings:
    """Its inverse, for PETSc.

    Args:
        multigrid: cycles for the solids with springs.
        places: how many unknowns of solids this process has, and which contacts touch, (t,).
        push: what multipliers do to the latter.
        seen: what multipliers take from them, S^-1 C_my.
        size: what their rows are to be multiplied by.
    """

    def __init__(
        self,
        multigrid: Multigrid,
        places: tuple[int, np.ndarray],
        push: PETSc.Mat,
        seen: PETSc.Mat,
        size: np.ndarray,
    ) -> None:
        self.multigrid = multigrid
        (self._n, self._at), self._push, self._seen, self._size = places, push, seen, size
        self._r = PETSc.Vec().createMPI((self._n, PETSc.DECIDE), comm=push.comm)
        self._v = self._r.duplicate()
        self._f, self._u = push.createVecs()
        self._t, self._g = seen.createVecs()

    def apply(self, pc: PETSc.PC, x: PETSc.Vec, y: PETSc.Vec) -> None:
        """y = P^-1 x."""
        both = x.array_r
        multipliers = self._size * both[self._n :]
        self._f.setArray(multipliers)
        self._push.mult(self._f, self._u)
        right = self._r.array_w
        right[:] = both[: self._n]
        right[self._at] -= self._u.array_r
        self.multigrid.apply(self._r, self._v)
        velocities = self._v.array_r
        self._t.setArray(velocities[self._at])
        self._seen.mult(self._t, self._g)
        y.setArray(np.concatenate([velocities, multipliers - self._g.array_r]))

    def free(self) -> None:
        """Free what PETSc holds; PETSc itself would as often as it uses this (``destroy``)."""
        mine = self._r, self._v, self._f, self._u, self._t, self._g, self._push, self._seen
        for thing in mine:
            thing.destroy()


def nodal_inverse(
    ym: sp.csr_matrix,
    my: sp.csr_matrix,
    mm: sp.csr_matrix,
    diagonal: np.ndarray,
    points: Sequence[tuple[int, int]],
) -> sp.csr_matrix:
    """S^-1: the multipliers of each point by what is left of their rows, C_mm - C_my D^-1 C_ym.

    Args:
        ym, my, mm: blocks of the contacts.
        diagonal: D, (t,).
        points: of each contact how many points and how many multipliers there are; these stand
            component by component.

    Raises:
        StepFailed: a force between two sides would move none of them.
    """
    push, inner = (ym.T @ sp.diags(1 / diagonal)).tocsr(), mm.tocoo()
    empty, first = np.empty(0, dtype=np.int64), 0
    blocks = [(np.empty(0), empty, empty)]
    for count, m in points:
        if not m:
            continue
        k = m // count
        S = np.zeros((k, k, count))
        own = (inner.row >= first) & (inner.row < first + m)
        (i, row), (j, column) = (np.divmod(x[own] - first, count) for x in (inner.row, inner.col))
        here = row == column  # the others are zero
        np.add.at(S, (i[here], j[here], row[here]), inner.data[own][here])
        parts = [slice(first + a * count, first + (a + 1) * count) for a in range(k)]
        theirs = [push[part] for part in parts]
        for a, part in enumerate(parts):
            mine = my[part]
            for b, each in enumerate(theirs):
                S[a, b] -= np.asarray(mine.multiply(each).sum(axis=1)).ravel()
        try:
            data = np.linalg.inv(np.moveaxis(S, 2, 0)).ravel()
        except np.linalg.LinAlgError:
            raise StepFailed("a point of a contact can move on neither side") from None
        at = first + np.arange(m).reshape(k, count).T  # (count, k)
        row, column = np.broadcast_arrays(at[:, :, None], at[:, None, :])
        blocks.append((data, row.ravel(), column.ravel()))
        first += m
    data, row, column = (np.concatenate(part) for part in zip(*blocks))
    return sp.csr_matrix((data, (row, column)), mm.shape)
