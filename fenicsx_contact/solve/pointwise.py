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
are made of rounded C and D, in single precision, and kept: corrections with them, which converge
fast, solve the system. What is kept is a matter of time only: the same rounded blocks give the same
factors.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..base.constants import ROUND_OFF
from ..base.vectors import largest
from .factored import Inverse, by_factors

#: Cost: C and D are rounded to these decimals in the factors.
DECIMALS = 2
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
        self._W = self._single = np.empty((0, 0))
        self._kept: dict[bytes, Inverse] = {}

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

        if keeps:
            inverse = self._rounded(C.round(DECIMALS) + 0.0, D.round(DECIMALS) + 0.0, W, sizes)
            if inverse is not None:
                x, left = refined(inverse, product, flat)
        if left > 10 * ROUND_OFF:  # nothing is kept, or it has not served
            inverse = _inverse(C, D, W, sizes, self._compliance)
            if inverse is not None:
                x, left = refined(inverse, product, flat)
        return x.reshape(b.shape) if np.isfinite(left) else None

    def _rounded(
        self, C: np.ndarray, D: np.ndarray, W: np.ndarray, sizes: np.ndarray
    ) -> Inverse | None:
        """Of rounded blocks, with one kind of zero, kept or made."""
        if W is not self._W and not np.array_equal(W, self._W):
            self._kept.clear()
            with np.errstate(over="ignore"):  # infinities serve nobody
                self._single = W.astype(np.float32)
        self._W = W
        key = b"".join(array.tobytes() for array in (C, D, sizes))
        if key not in self._kept:
            with np.errstate(over="ignore", invalid="ignore"):
                found = _inverse(C, D, self._single, sizes, self._compliance)
            if found is None:
                return None
            if len(self._kept) == KEPT:
                self._kept.pop(next(iter(self._kept)))
            self._kept[key] = found
        return self._kept[key]


def _inverse(
    C: np.ndarray, D: np.ndarray, W: np.ndarray, sizes: np.ndarray, compliance: float
) -> Inverse | None:
    """By factors of W's precision; None if there are none."""
    kind, (n, d), each = W.dtype, sizes.shape, np.arange(len(sizes))
    matrix = np.matmul(C.astype(kind), W.reshape(n, -1, n * d)).reshape(n, d, n, d)
    matrix *= sizes.astype(kind)
    matrix[each, :, each, :] += D + compliance * C[:, :, :d]
    return by_factors(matrix.reshape(n * d, n * d))


def refined(
    inverse: Inverse,
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


def _times(blocks: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    return np.einsum("pij,pj->pi", blocks, vectors)
