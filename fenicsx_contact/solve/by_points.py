# SPDX-License-Identifier: LGPL-3.0-or-later
"""A Newton step of some contacts by the forces on their points: pointwise.py, paired.py."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..contact.part import Part
from .paired import PairedSolver, PairedSystem, Points
from .pointwise import PointwiseSolver, PointwiseStep
from .yielding import COMPLIANCE


class Place(NamedTuple):
    """Where the active unknowns of a part stand in the system: velocities first."""

    part: Part
    place: np.ndarray


class ByPoints:
    """Takes such steps, and keeps what serves for the next."""

    def __init__(self) -> None:
        self._own, self._paired = PointwiseSolver(COMPLIANCE), PairedSolver()

    def forget(self) -> None:
        """A step begins: keep only what does not depend on how it came about."""
        self._paired.forget()

    def step(
        self,
        W: np.ndarray,
        placed: Sequence[Place],
        residual: np.ndarray,
        units: tuple[np.ndarray, np.ndarray],
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """One Newton step.

        Args:
            W: compliance of the active velocities, (v, v).
            placed: contacts that have unknowns.
            residual: of all rows, pure numbers.
            units: of the unknowns, that of velocities everywhere the same, and of the rows, its
                inverse for those of velocities.

        Returns:
            The step of the unknowns, pure numbers, and the change of the forces on the active
            velocities, N; None if the system is singular.
        """
        v, (columns, scales), speed = len(W), units, units[0][0]
        steps: list[PointwiseStep] = []
        points: list[Points] = []
        for part, place in placed:
            rows, first, count = part.point_rows(), place[0], len(part.active_places)
            mine = place[count:].reshape(-1, len(rows.tangents)).T  # multipliers of the points
            d, read = (size - mine.shape[1] for size in rows.tangents.shape[1:])
            size = part.equations.force_scale[part.equations.candidates]
            K = rows.tangents.copy()
            K[:, :, :read] *= speed
            K[:, :, read:] *= columns[mine][:, None]
            K[:, :d] /= size[:, None, None]
            K[:, d:] *= scales[mine][:, :, None]
            steps.append(each := PointwiseStep(K, residual[mine], d))
            sizes = np.repeat(size[:, None] / speed, d, axis=1)
            points.append(Points(slice(first, first + count), rows, each.C, each.D, sizes))
        if all(each.rows.reads is None for each in points):
            found = self._alone(W, points, [each.c for each in steps], residual[:v])
        else:
            found = self._together(W, points, [each.c for each in steps], residual[:v])
        if found is None or not all(np.isfinite(each).all() for each in found):
            return None
        dy, dq, change = found
        result, last = np.concatenate([dy, np.empty(len(residual) - v)]), 0
        for each, own, (part, place) in zip(steps, points, placed):
            first, last, seen = last, last + len(own.C), own.rows.reads
            z = dy[own.mine] if seen is None else seen @ dy[own.mine]
            dm = each.multipliers(z.reshape(len(own.C), -1), dq[first:last])
            result[place[len(part.active_places) :]] = dm.T.ravel()
        return result, speed * change

    def _alone(
        self, W: np.ndarray, points: list[Points], c: list[np.ndarray], behind: np.ndarray
    ) -> tuple[np.ndarray, ...] | None:
        """Points before obstacles, whose velocities are y."""
        C, D, sizes = (np.concatenate([p[i] for p in points]) for i in (2, 3, 4))
        right = np.concatenate(c) + np.einsum("pij,pj->pi", C, behind.reshape(sizes.shape))
        dq = self._own.solve(C, D, W, sizes, right)
        if dq is None:
            return None
        change = (sizes * dq).ravel()
        return W @ change - behind, dq, change

    def _together(
        self, W: np.ndarray, points: list[Points], c: list[np.ndarray], behind: np.ndarray
    ) -> tuple[np.ndarray, ...] | None:
        """Points that see two solids, and others."""
        rows = [1 / np.maximum(abs(p.C).max(axis=2), abs(p.D).max(axis=2)) for p in points]
        pure = [
            p._replace(C=p.C * row[..., None], D=p.D * row[..., None])
            for p, row in zip(points, rows)
        ]
        system = PairedSystem(W, pure)
        right = [(each * row).ravel() for each, row in zip(c, rows)]
        found = self._paired.solve(system, np.concatenate([-behind, *right]))
        if found is None:
            return None
        dy, dq = found
        return dy, dq.reshape(-1, points[0].sizes.shape[1]), system.on_nodes(dy, dq)
