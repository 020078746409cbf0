# SPDX-License-Identifier: LGPL-3.0-or-later
"""The semi-smooth Newton loop on the contact surfaces, and what it falls back on.

The solids enter only through the jump without contact, ``w_free``, and their compliance at the
points, ``W = J A^-1 J'``. With F the assembled contact terms of (7), the system is::

    w - w_free + W F_w(w, lam, Lam) = 0          F_lam = 0          F_Lam = 0

Unknowns and rows are scaled (speed, pressure, 1), and convergence is judged on every row.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack

from .equations import SurfaceEquations
from .projection import project

#: Compliance added to the tangent, never to the residual. Points of a rigid solid are hyperstatic
#: and their multipliers not unique; this picks those nearest to the last ones.
COMPLIANCE = 1e-8


class NotConverged(RuntimeError):
    """The surface problem was not solved; the message says what stalls or flips."""


@dataclass
class Solution:
    """Forces on the solids at the points (flat, N), and how they were found."""

    force: np.ndarray
    iterations: int
    remarks: list[str]


@dataclass(frozen=True)
class Newton:
    """Settings of the Newton loop.

    Args:
        tolerance: on the largest scaled residual of any row.
        max_iterations: before the projected solver takes over.
    """

    tolerance: float = 1e-10
    max_iterations: int = 30

    def solve(
        self,
        surfaces: Sequence[SurfaceEquations],
        names: Sequence[str],
        free: Sequence[np.ndarray],
        compliance: np.ndarray,
        limits: Sequence[tuple[np.ndarray, float] | None],
    ) -> Solution:
        """Solve one step's surface problem; the surfaces hold the solution.

        Args:
            surfaces, names: the contacts.
            free: for each the jump without contact, flat.
            compliance: W for all jumps of all contacts, one after the other.
            limits: for each the speeds w_n that its law allows and its friction coefficient, for
                the projected solver; None where it cannot help.
        """
        system = _System(surfaces, free, compliance)
        if not len(system.columns):
            return Solution(system.force(), 0, [])
        seen: dict[bytes, int] = {}
        remarks: list[str] = []
        for attempt in ("newton", "projected start"):
            for iteration in range(1, self.max_iterations + 1):
                system.iterate()
                if system.error() <= self.tolerance:
                    return Solution(system.force(), len(seen) + 1, remarks)
                statuses = system.statuses()
                key = statuses.tobytes()
                if not np.isfinite(system.worst) or (seen.get(key, 0) and iteration > 6):
                    break  # the statuses ping-pong
                seen[key] = seen.get(key, 0) + 1
            flips = system.flips(names)
            if attempt == "newton" and all(limits):
                sweeps = project(system, limits)  # type: ignore[arg-type]
                remarks.append(f"{flips}; projected solver took over, {sweeps} sweeps")
                if system.error() <= self.tolerance:
                    return Solution(system.force(), len(seen) + 1, remarks)
                seen.clear()
        raise NotConverged(f"{system.stall(names)}; {flips}")


class _System:
    """The stacked equations of all contacts, restricted to the candidates."""

    def __init__(
        self, surfaces: Sequence[SurfaceEquations], free: Sequence[np.ndarray], W: np.ndarray
    ) -> None:
        self.surfaces = surfaces
        offset, jumps = 0, []
        for surface in surfaces:
            jumps.append(surface.active_jumps + offset)
            offset += surface.jumps
        self.jumps = np.concatenate(jumps)
        everything = len(self.jumps) == offset
        self.W = W if everything else W[np.ix_(self.jumps, self.jumps)]
        self.free = np.concatenate(list(free))[self.jumps]
        self._total = offset
        # unknowns: all jumps, then the multipliers of each contact
        self._parts = []
        w, m = 0, len(self.jumps)
        for s in surfaces:
            extra = len(s.active) - len(s.active_jumps)
            place = np.concatenate(
                [np.arange(w, w + len(s.active_jumps)), np.arange(m, m + extra)]
            )
            self._parts.append((s, s.active, place))
            w, m = w + len(s.active_jumps), m + extra
        self.size = m
        self.columns, self.rows, self._sign = (
            self._gather([getattr(s, what) for s in surfaces])
            for what in ("column_scale", "row_scale", "own_sign")
        )
        self.tangent = np.zeros((m, m))
        self._diagonal = np.arange(m)
        self._history: list[np.ndarray] = []
        self.residual = self._scaled_residual()

    def _gather(self, arrays: Sequence[np.ndarray]) -> np.ndarray:
        result = np.empty(self.size)
        for (_, active, place), array in zip(self._parts, arrays, strict=True):
            result[place] = array[active]
        return result

    def _scaled_residual(self) -> np.ndarray:
        nw = len(self.jumps)
        self.assembled = self._gather([s.residual() for s in self.surfaces])
        result = self.assembled.copy()
        w = self._gather([s.values for s in self.surfaces])[:nw]
        result[:nw] = w - self.free + self.W @ self.assembled[:nw]
        return result * self.rows

    def iterate(self) -> None:
        """One Newton step."""
        nw, A = len(self.jumps), self.tangent
        for surface, active, place in self._parts:
            dense = surface.tangent()
            full = len(active) == surface.size
            block = dense if full else dense[np.ix_(active, active)]
            if len(self._parts) == 1:
                A[:] = block
            else:
                A[np.ix_(place, place)] = block
        A[:nw] = self.W @ A[:nw]
        A[self._diagonal[:nw], self._diagonal[:nw]] += 1.0
        A *= self.columns
        A *= self.rows[:, None]
        exact = A.copy()
        A[self._diagonal, self._diagonal] += COMPLIANCE * self._sign
        factors, pivots, info = lapack.dgetrf(A)
        if info:
            self.worst = np.nan
            return
        step, _ = lapack.dgetrs(factors, pivots, self.residual)
        step += lapack.dgetrs(factors, pivots, self.residual - exact @ step)[0]
        step *= self.columns
        for surface, active, place in self._parts:
            values = surface.values
            values[active] -= step[place]
            surface.values = values
        self.residual = self._scaled_residual()

    def error(self) -> float:
        """The largest scaled residual of any row."""
        errors = [s.error(self.residual[place]).max(initial=0.0) for s, _, place in self._parts]
        self.worst = float(max(errors))
        return self.worst if np.isfinite(self.worst) else np.inf

    def force(self) -> np.ndarray:
        """Forces on the solids at all points, flat."""
        result = np.zeros(self._total)
        if self.size:
            result[self.jumps] = -self.assembled[: len(self.jumps)]
        return result

    def statuses(self) -> np.ndarray:
        """Statuses of all points of all contacts; remembers them."""
        self._history.append(np.concatenate([s.statuses() for s in self.surfaces]))
        return self._history[-1]

    def flips(self, names: Sequence[str]) -> str:
        """Which points changed their status among the last iterations."""
        recent = np.array(self._history[-6:])
        flipping = np.flatnonzero((recent != recent[-1:]).any(axis=0)) if len(recent) else []
        if not len(flipping):
            return "no status changes"
        return "statuses flip at " + self._name_points(flipping, names)

    def _name_points(self, points: np.ndarray, names: Sequence[str]) -> str:
        parts, offset = [], 0
        for surface, name in zip(self.surfaces, names, strict=True):
            n = surface.size // surface.fields.components
            mine = [int(p - offset) for p in points if offset <= p < offset + n]
            if mine:
                shown = ", ".join(map(str, mine[:8])) + (", ..." if len(mine) > 8 else "")
                parts.append(f"points {shown} of contact {name!r}")
            offset += n
        return " and ".join(parts)

    def stall(self, names: Sequence[str]) -> str:
        """Which residual is largest."""
        if not np.isfinite(self.residual).all():
            return "the contact equations have no finite solution"
        row = int(np.abs(self.residual).argmax())
        nw = len(self.jumps)
        kind = "jump" if row < nw else "multiplier" if self._sign[row] < 0 else "friction"
        return f"the {kind} row stalls at a scaled residual of {self.worst:.3g}"
