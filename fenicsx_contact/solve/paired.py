# SPDX-License-Identifier: LGPL-3.0-or-later
"""The linear system of a Newton step by the forces on points that see two solids.

With y the active velocities of both and q the forces on the points, which read ``z = S y``, a step
obeys (pointwise.py has C and D)::

    dy + W (G dy - J' dq) = b_y                 C S dy + D dq = b_q

G: what the present forces turn with the nodes. All but W is sparse, so products with the system
cost little, and within a step of time it changes little: it is solved by corrections with the
inverse of an earlier one, as long as these converge fast::

    dy = H (b_y + W J' dq)        (C S H W J' + D) dq = b_q - C S H b_y        H = (1 + W G)^-1
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from ..base.constants import ROUND_OFF
from ..contact.mortar.matrices import by_point
from ..contact.tangent import PointRows
from .factored import Inverse, by_factors
from .pointwise import refined
from .yielding import FIRM


class Points(NamedTuple):
    """Those of a contact.

    Attributes:
        mine: their velocities among all.
        rows: their rows.
        C, D: blocks of these without the multipliers, (n, d, r) and (n, d, d), pure numbers.
        sizes: of their forces over that of velocities, (n, d), N s/m.
    """

    mine: slice
    rows: PointRows
    C: np.ndarray
    D: np.ndarray
    sizes: np.ndarray


class PairedSystem:
    """The system.

    Args:
        W: compliance of the active velocities, (v, v).
        points: of the contacts.

    Attributes:
        W: as given.
        parts: for each contact its velocities, its forces, and the matrices J', C S and G or None.
        blocks: D, and what C says of jumps alone, (points, d, d).
    """

    def __init__(self, W: np.ndarray, points: Sequence[Points]) -> None:
        self.W, self.parts, first = W, [], 0
        for mine, rows, C, _, sizes in points:
            own = sp.identity(sizes.size, format="csr")
            J, S = (own if each is None else each for each in (rows.spreads, rows.reads))
            spread = by_point(sizes.reshape(-1, 1, 1), J).T
            forces = slice(first, first + sizes.size)
            self.parts.append((mine, forces, spread, by_point(C, S), rows.turning))
            first += sizes.size
        d = points[0].D.shape[1]
        self.blocks = tuple(
            np.concatenate(each) for each in zip(*((p.D, p.C[:, :, :d]) for p in points))
        )

    def on_nodes(self, dy: np.ndarray, dq: np.ndarray) -> np.ndarray:
        """Forces on the nodes, J' dq - G dy."""
        result = np.empty(len(dy))
        for mine, forces, spread, _, turning in self.parts:
            result[mine] = spread @ dq[forces]
            if turning is not None:
                result[mine] -= turning @ dy[mine]
        return result

    def rows(self, dy: np.ndarray, dq: np.ndarray) -> np.ndarray:
        """The left sides, (v + forces,)."""
        D, v = self.blocks[0], len(dy)
        result = np.concatenate([dy - self.W @ self.on_nodes(dy, dq), dq])
        result[v:] = np.einsum("pij,pj->pi", D, dq.reshape(len(D), -1)).ravel()
        for mine, forces, _, look, _ in self.parts:
            result[v:][forces] += look @ dy[mine]
        return result


class _Inverse:
    """Of a system; what forces balance each other without moving anything is as small as it can be.

    Attributes:
        shape: how many velocities and forces.
    """

    def __init__(self, system: PairedSystem) -> None:
        W, v, q = system.W, len(system.W), system.blocks[0][..., 0].size
        self.shape = v, q
        gains = np.empty((v, q))  # W J'
        for mine, forces, spread, *_ in system.parts:
            gains[:, forces] = (sp.csr_matrix(spread.T) @ W[:, mine].T).T
        turning = [(mine, G) for mine, *_, G in system.parts if G is not None]
        turns = np.zeros(v, dtype=bool)
        for mine, _ in turning:
            turns[mine] = True
        self._turns, self._others = np.flatnonzero(turns), np.flatnonzero(~turns)
        self._onto: Inverse | None = None
        self._gains: np.ndarray | None = None
        if turning:
            turned = np.concatenate([W[:, mine] @ G for mine, G in turning], axis=1)  # W G
            self._turned = turned[self._others]
            stiff = turned[self._turns]
            stiff.flat[:: len(stiff) + 1] += 1.0
            if (inverse := by_factors(stiff)) is None:
                return
            self._stiff = inverse
        self._gains = self._yielding(gains)
        self.renew(system)

    def renew(self, system: PairedSystem, kind: type = np.float32) -> None:
        """Take up the blocks of a system, that is statuses, and leave what concerns the solids; by
        factors of this precision."""
        D, C = system.blocks
        if self._gains is None:  # H is singular
            return
        self._parts = system.parts
        matrix: np.ndarray = np.empty((self.shape[1],) * 2, kind)
        with np.errstate(over="ignore", invalid="ignore"):  # infinities serve nobody
            for mine, forces, _, look, _ in system.parts:
                matrix[forces] = sp.csr_matrix(look) @ self._gains[mine]
            each, (n, d, _) = np.arange(len(D)), D.shape
            matrix.reshape(n, d, n, d)[each, :, each] += D + FIRM * C
        self._onto = by_factors(matrix)

    @property
    def singular(self) -> bool:
        """Whether there is none."""
        return self._onto is None

    def _yielding(self, velocities: np.ndarray) -> np.ndarray:
        """H times velocities (v, ...)."""
        if not self._turns.size:
            return velocities
        result = np.empty_like(velocities)
        result[self._turns] = turned = self._stiff(velocities[self._turns])
        result[self._others] = velocities[self._others] - self._turned @ turned
        return result

    def __call__(self, b: np.ndarray) -> np.ndarray:
        """dy and dq, flat, from the right sides (v + q,)."""
        v = self.shape[0]
        y, right = self._yielding(b[:v]), b[v:].copy()
        for mine, forces, _, look, _ in self._parts:
            right[forces] -= look @ y[mine]
        assert self._onto and self._gains is not None
        dq = self._onto(right)
        return np.concatenate([y + self._gains @ dq, dq])


class PairedSolver:
    """Solves one system after the other."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Keep no inverse."""
        self._inverse: _Inverse | None = None

    def solve(self, system: PairedSystem, b: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """dy and dq, or None if the system is singular.

        Args:
            b: right sides, b_y and b_q.
        """
        kept, v = self._inverse, len(system.W)
        for way in ("as it is", "renewed", "made anew", "made in full"):
            if way == "made anew":
                self._inverse = kept = _Inverse(system)
            elif kept is None or kept.shape != (v, len(b) - v):
                continue
            elif way != "as it is":
                kept.renew(system, np.float32 if way == "renewed" else np.float64)
            if not kept.singular:
                x, left = refined(kept, lambda x: system.rows(x[:v], x[v:]), b)
                if left <= 10 * ROUND_OFF or (way == "made in full" and np.isfinite(left)):
                    return x[:v], x[v:]
        self.forget()
        return None
