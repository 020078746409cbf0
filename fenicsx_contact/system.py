# SPDX-License-Identifier: LGPL-3.0-or-later
"""The surface problem of a step: the equations of all contacts and the compliance that joins them.

With F the assembled contact terms of (7), ``w_free`` the jump without contact and
``W = J A^-1 J'``, it reads::

    w - w_free + W F_w(w, lam, Lam) = 0          F_lam = 0          F_Lam = 0

over the candidates of the step. Unknowns and rows are scaled (speed, pressure, 1).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from .equations import SurfaceEquations

#: Compliance added to the tangent, never to the residual. Points of a rigid solid are hyperstatic
#: and their multipliers not unique; this picks those nearest to the last ones.
COMPLIANCE = 1e-8
#: Speeds below this share of those that the contact forces stand for are not resolved: where forces
#: balance each other, as in a squeezed body, jumps are far smaller, down to round-off.
SLOW = 1e-4


class _Part(NamedTuple):
    """Where the candidates' unknowns of a surface stand: there, in its tangent, in the system."""

    surface: SurfaceEquations
    active: np.ndarray
    block: tuple[np.ndarray, ...] | None
    place: np.ndarray


class SurfaceSystem:
    """The stacked equations of the contacts of a scene, restricted to the candidates.

    Attributes:
        surfaces, names: of the contacts.
        W, free: compliance and free jump of the candidates.
        worst: the largest error of any row, after :meth:`error`.
    """

    def __init__(self, surfaces: Sequence[SurfaceEquations], names: Sequence[str]) -> None:
        self.surfaces, self.names = list(surfaces), list(names)
        self._total = sum(s.jumps for s in self.surfaces)
        self._revision = -1
        self.worst = 0.0

    def begin(self, free: Sequence[np.ndarray], compliance: np.ndarray) -> None:
        """Take up the free jumps (flat, one array a contact) and W (over all jumps)."""
        revision = sum(s.revision for s in self.surfaces)
        if revision != self._revision:
            self._revision = revision
            self._arrange()
        everything = len(self.jumps) == self._total
        self.W = compliance if everything else compliance[self._jump_block]
        self.free = free[0] if len(free) == 1 else np.concatenate([*free, np.empty(0)])
        if not everything:
            self.free = self.free[self.jumps]
        self.history: list[np.ndarray] = []
        if self.size:
            self.update()

    def _arrange(self) -> None:
        """Places of the candidates' unknowns: all jumps, then the multipliers by contact."""
        offset, jumps = 0, [np.empty(0, dtype=np.int64)]
        for surface in self.surfaces:
            jumps.append(surface.active_jumps + offset)
            offset += surface.jumps
        self.jumps = np.concatenate(jumps)
        self._jump_block = np.ix_(self.jumps, self.jumps)
        self.parts: list[_Part] = []
        w, m = 0, len(self.jumps)
        for s in self.surfaces:
            count, extra = len(s.active_jumps), len(s.active) - len(s.active_jumps)
            place = np.concatenate([np.arange(w, w + count), np.arange(m, m + extra)])
            whole = len(s.active) == s.size
            block = None if whole else np.ix_(s.active, s.active)
            self.parts.append(_Part(s, s.active, block, place))
            w, m = w + count, m + extra
        self.size = m
        if m:
            self._columns, self._rows = (
                self._gather([getattr(s, what) for s in self.surfaces])
                for what in ("column_scale", "row_scale")
            )
            self._scaling = self._rows[:, None] * self._columns

    def _gather(self, arrays: Sequence[np.ndarray]) -> np.ndarray:
        result = np.empty(self.size)
        for part, array in zip(self.parts, arrays):
            result[part.place] = array[part.active]
        return result

    def update(self) -> None:
        """Assemble the residual from the unknowns that the surfaces hold."""
        nw = len(self.jumps)
        self.assembled = self._gather([s.residual() for s in self.surfaces])
        w = self._gather([s.values for s in self.surfaces])[:nw]
        self.residual = self.assembled.copy()
        self.residual[:nw] = w - self.free + self.W @ self.assembled[:nw]
        self.residual *= self._rows

    def iterate(self) -> bool:
        """One Newton step; False where the tangent is singular."""
        nw = len(self.jumps)
        A = np.zeros((self.size, self.size))
        for part in self.parts:
            dense = part.surface.tangent()
            block = dense if part.block is None else dense[part.block]
            if len(self.parts) == 1:
                A[:] = block
            else:
                A[np.ix_(part.place, part.place)] = block
        A[:nw] = self.W @ A[:nw]
        A.flat[: nw * self.size : self.size + 1] += 1.0
        A *= self._scaling
        regular = A.copy()
        regular.flat[nw * (self.size + 1) :: self.size + 1] -= COMPLIANCE
        factors, pivots, singular = lapack.dgetrf(regular)
        if singular:
            return False
        step, _ = lapack.dgetrs(factors, pivots, self.residual)
        step += lapack.dgetrs(factors, pivots, self.residual - A @ step)[0]
        step *= self._columns
        for part in self.parts:
            values = part.surface.values
            values[part.active] -= step[part.place]
            part.surface.values = values
        self.update()
        return True

    def error(self) -> float:
        """The largest error that the residual of any row stands for."""
        nw = len(self.jumps)
        pushed = np.abs(self.W) @ np.abs(self.assembled[:nw]) * self._rows[:nw]
        scaled = self.residual.copy()
        scaled[:nw] /= np.maximum(1.0, SLOW * pushed)
        errors = (p.surface.error(scaled[p.place]).max(initial=0.0) for p in self.parts)
        self.worst = float(max(errors))
        return self.worst if np.isfinite(self.worst) else np.inf

    def force(self) -> np.ndarray:
        """Forces on the solids at all points, flat, N."""
        result = np.zeros(self._total)
        if self.size:
            result[self.jumps] = -self.assembled[: len(self.jumps)]
        return result

    def remember(self) -> np.ndarray:
        """Statuses of all points of all contacts, kept to tell which ones flip."""
        self.history.append(np.concatenate([s.statuses() for s in self.surfaces]))
        return self.history[-1]

    def flips(self) -> str:
        """Which points changed their status among the last iterations."""
        if not self.history:
            return "no status changes"
        recent = np.array(self.history[-6:])
        flipping = np.flatnonzero((recent != recent[-1]).any(axis=0))
        if not len(flipping):
            return "no status changes"
        parts, offset = [], 0
        for surface, name in zip(self.surfaces, self.names):
            n = surface.size // surface.fields.components
            mine = [int(p - offset) for p in flipping if offset <= p < offset + n]
            if mine:
                shown = ", ".join(map(str, mine[:8])) + (", ..." if len(mine) > 8 else "")
                parts.append(f"points {shown} of contact {name!r}")
            offset += n
        return "statuses flip at " + " and ".join(parts)

    def stall(self) -> str:
        """Which residual is largest."""
        if not np.isfinite(self.residual).all():
            return "the contact equations have no finite solution"
        row, kind = int(np.abs(self.residual).argmax()), "jump"
        for part in self.parts:
            if row >= len(self.jumps) and row in part.place:
                own = part.active[part.place == row][0]
                kind = "multiplier" if own < part.surface.semi else "friction"
        return f"a {kind} row stalls at a scaled residual of {self.worst:.3g}"
