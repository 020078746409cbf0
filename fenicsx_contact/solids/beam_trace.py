# SPDX-License-Identifier: LGPL-3.0-or-later
"""A beam seen from points of its axis, and from stations past which it slides."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .. import checks
from ..theta import Step
from .base import Trace
from .sections import interpolation

if TYPE_CHECKING:
    from .beam import BeamSolid


class BeamTrace(Trace):
    """A beam seen from points of its axis and from stations.

    A point belongs to the material and moves with it. A station is fixed in space: it sees the
    material that is there at the start of the step's prediction, at its interpolated deflection.

    Args:
        solid: the beam.
        places: s of the points, m; where a station stands, it does not count.
        stations: indices of the stations among the points.
        at: places of the stations along the axis, in space, m.
        within: the stations see only what lies between these s of the beam.

    Attributes:
        void: points at which there is no beam (stations that it has not reached, or has passed).
        slopes: derivative of the deflection by s at the points, (n, d - 1).
    """

    def __init__(
        self,
        solid: BeamSolid,
        places: np.ndarray,
        stations: np.ndarray | None = None,
        at: np.ndarray | None = None,
        within: tuple[float, float] = (-np.inf, np.inf),
    ) -> None:
        self._solid, self._within = solid, within
        self._s = np.array(places, dtype=float)
        self._stations = np.zeros(0, dtype=int) if stations is None else stations
        self._at = np.zeros(0) if at is None else at
        knots = solid.matrices.s
        inside = np.ones(len(self._s), dtype=bool)
        inside[self._stations] = False
        if self._s[inside].min(initial=0.0) < -1e-9 or self._s[inside].max(initial=0.0) > knots[-1] * (1 + 1e-9):
            raise checks.InputError("points: each point of a trace must lie on the beam's axis")
        n = len(self._s)
        self._extensible = len(solid.split(solid.velocity)[1]) > 1
        self.void = np.zeros(n, dtype=bool)
        self._dofs, self._w, self._dw = (np.zeros((n, 4), dtype=t) for t in (int, float, float))
        self._ends, self._u = np.zeros((n, 2), dtype=int), np.zeros((n, 2))
        self._place(np.flatnonzero(inside))
        self._moved = self._stations
        self._kept: np.ndarray | None = None  # the inverse that the columns belong to
        self._seen = -1
        self.follow()

    def _place(self, points: np.ndarray) -> None:
        """Shape functions at the present s of some points."""
        solid = self._solid
        knots = solid.matrices.s
        s = np.clip(self._s[points], knots[0], knots[-1])
        cell = np.clip(np.searchsorted(knots, s, side="right") - 1, 0, len(knots) - 2)
        h = knots[cell + 1] - knots[cell]
        xi = (s - knots[cell]) / h
        w, dw = interpolation(xi, h, solid.matrices.shear_ratio[cell])
        real = ~self.void[points]
        self._dofs[points] = 2 * cell[:, None] + np.arange(4)
        self._w[points], self._dw[points] = w * real[:, None], dw * real[:, None]
        if self._extensible:
            self._ends[points] = cell[:, None] + np.arange(2)
            self._u[points] = np.stack([1 - xi, xi], axis=1) * real[:, None]
        else:
            self._u[points, 0] = real

    def follow(self) -> None:
        solid = self._solid
        if self._seen != solid.predictions:
            self._seen = solid.predictions
            if len(self._stations):
                self._slide()
        self._deflection = None

    def _slide(self) -> None:
        """Which material is at the stations."""
        solid, knots = self._solid, self._solid.matrices.s
        axial = solid.split(solid.trial_displacement)[1]
        s = np.interp(self._at, knots + axial, knots) if self._extensible else self._at - axial[0]
        low, high = max(self._within[0], knots[0]), min(self._within[1], knots[-1])
        self.void[self._stations] = (self._at < low + axial[0]) | (self._at > high + axial[-1])
        self._s[self._stations] = s
        self._place(self._stations)

    def _deflect(self) -> None:
        bending, axial = self._solid.split(self._solid.trial_displacement)
        local = bending[:, self._dofs]
        self._deflection = np.einsum("pnk,nk->np", local, self._w)
        self.slopes = np.einsum("pnk,nk->np", local, self._dw)
        along = self._s + np.einsum("nk,nk->n", axial[self._ends], self._u)
        along[self._stations] = self._at
        axis = self._solid.axis
        self._positions = (
            axis.origin + self._deflection @ self._solid.frame + along[:, None] * axis.direction
        )

    def positions(self) -> np.ndarray:
        if self._deflection is None:
            self._deflect()
        return self._positions

    def linearise(self, step: Step) -> None:
        """Columns A^-1 J' of bending, (n, 2m), and of axial motion, (n, axial unknowns)."""
        solid = self._solid
        rows: np.ndarray | slice = self._moved
        if self._kept is not solid.flexibility:
            self._kept = solid.flexibility
            n = len(self._s)
            self._columns = np.empty((n, len(solid.flexibility)))
            self._lateral = np.empty((n, n))
            rows = np.arange(n)
        if len(rows):
            dofs, w = self._dofs[rows], self._w[rows]
            self._columns[rows] = np.einsum("nk,nkj->nj", w, solid.flexibility[dofs])
            block = np.einsum("ank,nk->an", self._columns[:, dofs], w)
            self._lateral[:, rows] = block
            self._lateral[rows] = block.T
        axial = solid.axial_flexibility
        self._axial_columns = (
            np.einsum("nk,nkj->nj", self._u, axial[self._ends])
            if self._extensible
            else self._u[:, :1] * axial[0, 0]
        )

    def _at_points(self, values: np.ndarray) -> np.ndarray:
        solid = self._solid
        bending, axial = solid.split(values)
        across = np.einsum("pnk,nk->np", bending[:, self._dofs], self._w)
        along = np.einsum("nk,nk->n", axial[self._ends], self._u)
        return (across @ solid.frame + along[:, None] * solid.axis.direction).ravel()

    def jump(self, velocity: np.ndarray) -> np.ndarray:
        return self._at_points(velocity)

    def mean_jump(self, velocity: np.ndarray) -> np.ndarray:
        return self._at_points(velocity)

    def free_jump(self) -> np.ndarray:
        return self._at_points(self._solid.free_velocity)

    def compliance(self, other: Trace) -> np.ndarray:
        assert isinstance(other, BeamTrace)
        if other is self:
            lateral = self._lateral
        else:
            lateral = np.einsum("ank,nk->an", other._columns[:, self._dofs], self._w).T
        along = np.einsum("ank,nk->an", self._axial_columns[:, other._ends], other._u)
        e = self._solid.axis.direction
        n, m, d = len(self._s), len(other._s), len(e)
        axial = np.outer(e, e)
        result = np.empty((n, d, m, d))
        across = np.eye(d) - axial
        for i in range(d):
            for j in range(d):
                result[:, i, :, j] = across[i, j] * lateral + axial[i, j] * along
        return result.reshape(n * d, m * d)

    def spread(self, force: np.ndarray) -> None:
        if not force.any():
            return
        solid = self._solid
        local = force.reshape(len(self._s), -1)
        bending, axial = solid.split(solid._gain)
        along = local @ solid.axis.direction
        bending += (local @ solid.frame.T).T @ self._columns
        axial += along @ self._axial_columns
        solid._pushed += float(along @ self._u.sum(axis=1))

    def accept(self) -> None:
        """Nothing to do: the operator follows the prediction of each step."""
