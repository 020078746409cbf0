# SPDX-License-Identifier: LGPL-3.0-or-later
"""The linear system of a Newton step where the equations of a point know only its own unknowns.

So it is with nodal integrals. With (w, m) the unknowns of a point, f its force and K its tangent,
a step obeys::

    df + K_ww dw + K_wm dm = 0        K_mw dw + K_mm dm = -r_m

point by point, which without dm reads ``C dw + D df = c``; with ``dw = W df - r_w`` only the forces
are left to solve for, half of the unknowns. (Between solids w is all that a point reads: its jump,
its gap and its normal.) ::

    (C W + D) df = c + C r_w

Where points stick the matrix is W's, where they slip it turns little from step to step. So factors
are made of rounded C and D, and kept: corrections with them, which converge fast, solve the system.
What is kept is a matter of time only: the same rounded blocks give the same factors.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from scipy.linalg import lapack

from ..base.constants import ROUND_OFF
from ..base.vectors import largest

#: Cost: C and D are rounded to these decimals in the factors.
DECIMALS = 1
#: Cost: so many factors are kept: Newton's method passes through some states in each step.
KEPT = 4


class PointwiseStep:
    """The equations of the points without their multipliers; pure numbers.

    Args:
        tangent: K of the points, (points, d + multipliers, r + multipliers): r numbers are read.
        residual: r_m of the points, (points, multipliers).
        d: dimension of space.

    Attributes:
        C, D, c: (points, d, r), (points, d, d) and (points, d).
    """

    def __init__(self, tangent: np.ndarray, residual: np.ndarray, d: int) -> None:
        n, size, r = tangent.shape
        m = size - d
        r -= m
        self._w = tangent[:, :, :r]
        self._known = np.zeros((n, size))
        self._known[:, d:] = -residual
        # turn the rows: dm in the first m of them only
        if m:
            self._Q, self._R = np.linalg.qr(tangent[:, :, r:], mode="complete")
        else:
            self._Q = np.broadcast_to(np.eye(size), (n, size, size))
        rest = np.swapaxes(self._Q[:, :, m:], 1, 2)
        self.C, self.D, self.c = rest @ self._w, rest[:, :, :d], _times(rest, self._known)

    def multipliers(self, dw: np.ndarray, df: np.ndarray) -> np.ndarray:
        """dm of the points, (points, multipliers)."""
        m = self._w.shape[1] - df.shape[1]
        if not m:
            return np.zeros((len(dw), 0))
        left = self._known - _times(self._w, dw)
        left[:, : df.shape[1]] -= df
        turned = _times(np.swapaxes(self._Q[:, :, :m], 1, 2), left)
        return np.linalg.solve(self._R[:, :m], turned[..., None])[..., 0]


class PointwiseSolver:
    """Solves ``(C W + D) x = b``, C and D block diagonal, with factors that it keeps.

    Args:
        compliance: added in the factors, not in the system, to what the first d numbers of a point
            gain by its own force.
    """

    def __init__(self, compliance: float) -> None:
        self._compliance = compliance
        self._W = np.empty((0, 0))
        self._kept: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}

    def solve(
        self,
        C: np.ndarray,
        D: np.ndarray,
        W: np.ndarray,
        sizes: np.ndarray,
        b: np.ndarray,
        keeps: bool = True,
    ) -> np.ndarray | None:
        """The solution (points, d), or None if the matrix is singular.

        Args:
            C, D: blocks, (points, d, r) and (points, d, d), numbers.
            W: (points r, points d).
            sizes: of its columns over those of its rows, (points, d).
            b: (points, d).
            keeps: whether W may come again; factors of one that does not are of no further use.
        """
        rows = 1 / np.maximum(np.abs(C).max(axis=2), np.abs(D).max(axis=2))
        C, D, b = C * rows[..., None], D * rows[..., None], b * rows
        x, left, flat = b, np.inf, b.ravel()

        def product(x: np.ndarray) -> np.ndarray:
            x = x.reshape(b.shape)
            moved = (W @ (sizes * x).ravel()).reshape(len(b), -1)
            return (_times(C, moved) + _times(D, x)).ravel()

        exact, rounded = (C, D), (_rounded(C), _rounded(D))
        for blocks in (rounded, exact) if keeps else (exact,):
            factors = self._factors(*blocks, W, sizes)
            if factors is not None:
                x, left = refined(partial(_backwards, factors), product, flat)
            if left <= 10 * ROUND_OFF:  # else the rounded factors have not served
                break
        return x.reshape(b.shape) if np.isfinite(left) else None

    def _factors(
        self, C: np.ndarray, D: np.ndarray, W: np.ndarray, sizes: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray] | None:
        if W is not self._W and not np.array_equal(W, self._W):
            self._kept.clear()
        self._W = W
        key = b"".join(array.tobytes() for array in (C, D, sizes))
        if key not in self._kept:
            n, d = sizes.shape
            matrix = np.matmul(C, W.reshape(n, -1, n * d)).reshape(n, d, n, d)
            matrix *= sizes
            each = np.arange(n)
            matrix[each, :, each, :] += D + self._compliance * C[:, :, :d]
            factors, pivots, singular = lapack.dgetrf(matrix.reshape(n * d, n * d))
            if singular:
                return None
            if len(self._kept) == KEPT:
                self._kept.pop(next(iter(self._kept)))
            self._kept[key] = factors, pivots
        return self._kept[key]


def refined(
    inverse: Callable[[np.ndarray], np.ndarray],
    product: Callable[[np.ndarray], np.ndarray],
    b: np.ndarray,
) -> tuple[np.ndarray, float]:
    """The solution of a system (n,), given its products and about its inverse, by corrections as
    long as they halve its relative residual, and this."""
    x, left, residual, size = np.zeros_like(b), np.inf, b, largest(b) or 1.0
    while True:
        new = x + inverse(residual)
        residual = b - product(new)
        now = largest(residual) / size
        gained = 2 * now < left
        if now < left:
            x, left = new, now
        if left <= ROUND_OFF or not gained:
            return x, left


def _backwards(factors: tuple[np.ndarray, np.ndarray], b: np.ndarray) -> np.ndarray:
    return np.asarray(lapack.dgetrs(*factors, b)[0])


def _rounded(blocks: np.ndarray) -> np.ndarray:
    """With one kind of zero."""
    return blocks.round(DECIMALS) + 0.0


def _times(blocks: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    return np.einsum("pij,pj->pi", blocks, vectors)
