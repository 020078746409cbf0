# SPDX-License-Identifier: LGPL-3.0-or-later
"""The linearised step, as sparse matrices, and its solution, forwards and transposed.

    plus dx + minus ds + by dp = 0

x: all unknowns of a step, the state at its end first; s: the state at its start; p: parameters.
Tangents solve it for dx, adjoints solve it transposed: one solve with the matrix of each deformable
solid a step and column, and a dense system of the contacts.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from ..base.constants import ROUND_OFF, SAME
from ..contact.mortar.matrices import dense
from .residuals import Ways, share
from .slack import slack


class Blocks:
    """A matrix made of blocks that add up, dense, sparse, or of points.

    Args:
        shape: of it.

    Attributes:
        parts: rows and columns of each block, and the block.
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        self._shape = shape
        self.parts: list[tuple[slice, slice, Any]] = []

    def add(self, rows: slice, columns: slice, block: Any) -> None:
        """Add a block at these rows and columns."""
        self.parts.append((rows, columns, block))

    def copy(self) -> Blocks:
        """One to which others are added."""
        result = Blocks(self._shape)
        result.parts = list(self.parts)
        return result

    def times(self, values: np.ndarray) -> np.ndarray:
        """The product with columns."""
        result = np.zeros((self._shape[0], values.shape[1]))
        for rows, columns, block in self.parts:
            result[rows] += block @ values[columns]
        return result

    def transposed(self, values: np.ndarray) -> np.ndarray:
        """The product of its transpose with columns."""
        result = np.zeros((self._shape[1], values.shape[1]))
        for rows, columns, block in self.parts:
            result[columns] += block.T @ values[rows]
        return result


class InnerSolver(Protocol):
    """The rows of a solid among its own unknowns, for which it has a solver of its own."""

    def solve(self, right: np.ndarray, transposed: bool) -> np.ndarray:
        """Its unknowns from its rows, (rows, columns), or the other way round."""

    def columns(self, block: Any, first: int) -> np.ndarray:
        """Its unknowns from a block of its rows, of which it begins with this one."""

    @property
    def exact(self) -> bool:
        """Whether these are solutions, or near them."""

    def left(self, values: np.ndarray, transposed: bool) -> np.ndarray:
        """What is left of the rows after unknowns were solved for."""

    def renew(self) -> None:
        """Be exact from now on."""


class LinearStep:
    """A linearised step.

    Args:
        plus, minus: derivatives by the unknowns and by the state at the start; the former without
            those of the rows of inner solids by their own unknowns.
        by: derivatives by the parameters, (unknowns, parameters).
        soft: a small compliance of the multipliers, (unknowns,), zero elsewhere: where points have
            less freedom than rows (of rigid solids, held nodes, nodes of two contacts) ``plus`` is
            singular in what does not matter.
        forces: where the forces of each contact stand among the unknowns, point by point.
        inner: solids with solvers of their own, and where their unknowns stand; the others are
            solved for together, dense.
        before: what was solved in the same step before it, and where in the state what it goes on
            from stands: by what solids were put elsewhere.

    Attributes:
        sizes: by which the unknowns are scaled; infinite for those of inner solids.
    """

    def __init__(
        self,
        plus: Blocks,
        minus: Blocks,
        by: np.ndarray,
        soft: np.ndarray,
        forces: list[slice],
        inner: list[tuple[slice, InnerSolver]],
        before: tuple[LinearStep, np.ndarray] | None = None,
    ) -> None:
        self._minus, self._by, self.forces, self._inner = minus, by, forces, inner
        self._before, self._plus, self._softness = before, plus, soft
        self._condense()

    def _condense(self) -> None:
        """Eliminate the unknowns of inner solids, and factor what remains."""
        plus, soft, inner = self._plus, self._softness, self._inner
        outer = np.ones(len(soft), dtype=bool)
        for at, _ in inner:
            outer[at] = False
        self._outer = outer.nonzero()[0]
        place = np.cumsum(outer) - 1  # none stands on both sides
        self._joints = [_Joint(at, solid) for at, solid in inner]
        matrix = np.zeros((len(self._outer), len(self._outer)))
        for rows, columns, block in plus.parts:
            row, column = (slice(place[at.start], place[at.start] + at.stop - at.start)
                           if at.stop > at.start and outer[at.start] else None
                           for at in (rows, columns))  # fmt: skip
            if row and column:
                matrix[row, column] += dense(block)
            for joint in self._joints:
                if row and joint.has(columns):
                    joint.into.append((row, joint.own(columns), block))
                elif column and joint.has(rows):
                    joint.out.append((column, joint.solid.columns(block, joint.own(rows).start)))
        # without the inner unknowns: each is solved for, for what joins it to the others
        for joint in self._joints:
            for column, moved in joint.out:
                for row, own, block in joint.into:
                    matrix[row, column] -= block @ moved[own]
        self._lapack(matrix, soft[self._outer])
        self.sizes = np.full(len(soft), np.inf)
        self.sizes[self._outer] = self._columns
        self._slack = slack(self._joints, self._forwards, len(soft))

    def _lapack(self, matrix: np.ndarray, soft: np.ndarray) -> None:
        sizes = np.abs(matrix).max(axis=1, initial=0.0)
        self._rows = 1 / np.where(sizes > 0, sizes, 1.0)
        scaled = self._rows[:, None] * matrix
        sizes = np.abs(scaled).max(axis=0, initial=0.0)
        self._columns = 1 / np.where(sizes > 0, sizes, 1.0)
        self._matrix = scaled * self._columns
        self._soft = self._rows * soft * self._columns
        self._factors = lu_factor(self._matrix - np.diag(self._soft))

    def _solve(self, right: np.ndarray, transposed: bool) -> np.ndarray:
        """The outer unknowns; what is soft is made hard by iteration (proximal point)."""
        matrix = self._matrix.T if transposed else self._matrix
        first, last = (self._columns, self._rows) if transposed else (self._rows, self._columns)
        right = first[:, None] * right
        result = lu_solve(self._factors, right, int(transposed))
        change, falls = np.inf, True
        while falls:  # down to round-off, which in what no row tells falls by hardly anything
            correction = lu_solve(self._factors, right - matrix @ result, int(transposed))
            before, change = change, float(np.abs(correction).max(initial=0.0))
            falls = change < before / 2
            result = result + correction if falls else result
        return last[:, None] * result

    def idle(self) -> np.ndarray | None:
        """A change of the unknowns, (unknowns,), which no row tells, of those that are not inner;
        None if there is none. Softness alone then holds it: ``(A - S) x = S z`` gives -z back."""
        soft, share = self._soft > 0, 0.0
        if not soft.any():
            return None
        z = soft * np.cos(np.arange(len(soft)))
        for _ in range(3):
            z = z / (np.abs(z[soft]).max(initial=0.0) or 1.0)
            z = lu_solve(self._factors, self._soft * z)
            share = float(np.abs(z[soft]).max(initial=0.0))
        if share < 0.5:
            return None
        result = np.zeros(len(self))
        result[self._outer] = self._columns * z
        return result

    def __len__(self) -> int:
        return len(self._by)

    def tangent(self, start: np.ndarray) -> np.ndarray:
        """dx (unknowns, parameters) from ds (state, parameters)."""
        if self._before:
            before, passed = self._before
            start = start.copy()
            start[passed] = before.tangent(start)[passed]
        right = -(self._minus.times(start) + self._by)
        return self._exactly(self._forwards, right, False)

    def _exactly(
        self, solve: Callable[[np.ndarray], np.ndarray], right: np.ndarray, transposed: bool
    ) -> np.ndarray:
        """The solution where inner solids are exact; else what they leave is solved for in turn,
        down to round-off (generalised conjugate residuals), or they are renewed. NaN where there is
        none, or more than one."""
        if self._slack:
            return np.full_like(right, np.nan)
        result = solve(right)
        near = [joint for joint in self._joints if not joint.solid.exact]
        rest, ways, change = self._left(near, result, transposed), Ways(), 1.0
        while near and rest.any():
            way = solve(rest)
            step, rest = ways.go(way, rest - self._left(near, way, transposed), rest)
            before, change = change, max(share(step[j.last], result[j.last]) for j in near)
            if not (falls := change < before) and not before < SAME:
                if self._slack is not None:
                    return np.full_like(right, np.nan)
                for joint in near:
                    joint.solid.renew()
                self._condense()
                return solve(right)
            result += falls * step
            if not falls or change**2 < ROUND_OFF * before:  # as the next one will be
                break
        return result

    def _left(self, near: list[_Joint], values: np.ndarray, transposed: bool) -> np.ndarray:
        """What is left of the rows after these unknowns were found, or the other way round."""
        result = np.zeros_like(values)
        for joint in near:
            result[joint.at] = joint.solid.left(values[joint.at], transposed)
        return result

    def _forwards(self, right: np.ndarray) -> np.ndarray:
        result, outer = np.zeros_like(right), right[self._outer]
        for joint in self._joints:
            result[joint.at] = own = joint.solid.solve(right[joint.at], False)
            for row, at, block in joint.into:
                outer[row] -= block @ own[at]
        result[self._outer] = outer = self._solve(outer, False)
        for joint in self._joints:
            for column, moved in joint.out:
                result[joint.at] -= moved @ outer[column]
        return result

    def adjoint(self, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of functionals by the state at the start, (state, functionals), and by the
        parameters in this step, (parameters, functionals), from those by the state at the end, or
        by all unknowns."""
        right = np.zeros((len(self._by), end.shape[1]))
        right[: len(end)] = end
        left = self._exactly(self._backwards, right, True)
        start, by = -self._minus.transposed(left), -(self._by.T @ left)
        if self._before:
            before, passed = self._before
            end = np.zeros_like(start)
            end[passed], start[passed] = start[passed], 0.0
            earlier, more = before.adjoint(end)
            start, by = start + earlier, by + more
        return start, by

    def _backwards(self, right: np.ndarray) -> np.ndarray:
        left, outer = np.zeros_like(right), right[self._outer]
        for joint in self._joints:
            for column, moved in joint.out:
                outer[column] -= moved.T @ right[joint.at]
        left[self._outer] = outer = self._solve(outer, True)
        for joint in self._joints:
            own = right[joint.at].copy()
            for row, at, block in joint.into:
                own[at] -= block.T @ outer[row]
            left[joint.at] = joint.solid.solve(own, True)
        return left


class _Joint:
    """How an inner solid and the outer unknowns read each other.

    Attributes:
        at, solid: where its unknowns stand, and its solver.
        last: where its velocities stand, or the multipliers of its balance.
        into: outer rows, own unknowns that they read, and by what.
        out: outer unknowns, and what they make of the own ones.
    """

    def __init__(self, at: slice, solid: InnerSolver) -> None:
        self.at, self.solid = at, solid
        self.last = slice((at.start + at.stop) // 2, at.stop)
        self.into: list[tuple[slice, slice, Any]] = []
        self.out: list[tuple[slice, np.ndarray]] = []

    def has(self, at: slice) -> bool:
        """Whether these unknowns are of it."""
        return self.at.start <= at.start and at.stop <= self.at.stop

    def own(self, at: slice) -> slice:
        """Where they stand among its own."""
        return slice(at.start - self.at.start, at.stop - self.at.start)
