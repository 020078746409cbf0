# SPDX-License-Identifier: LGPL-3.0-or-later
"""A beam seen from points of its axis, and from stations past which it slides."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..base import checks
from ..solids.base import Trace
from ..theory.theta import Step

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
        self.stations = np.zeros(0, dtype=int) if stations is None else stations
        self._at = np.zeros(0) if at is None else at
        knots = solid.matrices.s
        inside = np.ones(len(self._s), dtype=bool)
        inside[self.stations] = False
        if self._s[inside].min(initial=0.0) < -1e-9 or self._s[inside].max(initial=0.0) > knots[
            -1
        ] * (1 + 1e-9):
            raise checks.InputError("points: each point of a trace must lie on the beam's axis")
        n = len(self._s)
        self._axes = np.concatenate([solid.frame, solid.axis.direction[None]])
        axial = np.outer(solid.axis.direction, solid.axis.direction)
        self._shares = [
            (i, j, float(i == j) - share, share)
            for (i, j), share in np.ndenumerate(axial)
            if i == j or share
        ]
        self._extensible = len(solid.split(solid.velocity)[1]) > 1
        self.void = np.zeros(n, dtype=bool)
        self._dofs, self._w, self._dw = (np.zeros((n, 4), dtype=t) for t in (int, float, float))
        self._ends, self._u = np.zeros((n, 2), dtype=int), np.zeros((n, 2))
        self._place(np.flatnonzero(inside))
        self._moved = self.stations
        self._kept: np.ndarray | None = None  # the inverse that the columns belong to
        self._seen = -1
        self.follow()

    def _place(self, points: np.ndarray) -> None:
        """Shape functions at the present s of some points."""
        knots, shapes = self._solid.matrices.s, self._solid.matrices.shapes
        s = np.minimum(np.maximum(self._s[points], knots[0]), knots[-1])
        cell = np.minimum(knots.searchsorted(s, side="right") - 1, len(knots) - 2)
        xi = (s - knots[cell]) / (knots[cell + 1] - knots[cell])
        powers = np.ones((len(s), 1, 4))
        powers[:, 0, 1] = xi
        powers[:, 0, 2] = xi * xi
        powers[:, 0, 3] = powers[:, 0, 2] * xi
        real = ~self.void[points][:, None]
        w = powers @ shapes[:, cell]
        self._dofs[points] = 2 * cell[:, None] + np.arange(4)
        self._w[points], self._dw[points] = w[:, :, 0] * real
        if self._extensible:
            self._ends[points] = cell[:, None] + np.arange(2)
            self._u[points] = np.stack([1 - xi, xi], axis=1) * real
        else:
            self._u[points, :1] = real

    def follow(self) -> None:
        solid = self._solid
        if self._seen != solid.predictions:
            self._seen = solid.predictions
            if len(self.stations):
                self._slide()
        self._positions: np.ndarray | None = None

    def _slide(self) -> None:
        """Which material is at the stations."""
        solid, knots = self._solid, self._solid.matrices.s
        axial = solid.split(solid.trial_displacement)[1]
        s = np.interp(self._at, knots + axial, knots) if self._extensible else self._at - axial[0]
        low, high = max(self._within[0], knots[0]), min(self._within[1], knots[-1])
        self.void[self.stations] = (self._at < low + axial[0]) | (self._at > high + axial[-1])
        self._s[self.stations] = s
        self._place(self.stations)

    def move(self, at: np.ndarray) -> None:
        """Move the stations along the axis, to places in space, m."""
        self._at, self._seen = at, -1

    def deflections(self) -> np.ndarray:
        """Lateral displacements of the points in the trial state, (n, d) in m."""
        return self._local(self._solid.trial_displacement)[:, :-1] @ self._axes[:-1]

    def positions(self) -> np.ndarray:
        if self._positions is None:
            local = self._local(self._solid.trial_displacement)
            local[:, -1] += self._s
            local[self.stations, -1] = self._at
            self._positions = self._solid.axis.origin + local @ self._axes
        return self._positions

    def slopes(self) -> np.ndarray:
        """Derivative of the deflection by s at the points in the trial state, (n, d - 1)."""
        bending, _ = self._solid.split(self._solid.trial_displacement)
        return np.stack([(plane[self._dofs] * self._dw).sum(axis=1) for plane in bending], axis=1)

    def _local(self, values: np.ndarray) -> np.ndarray:
        """A field at the points in the frame of the axis: lateral, then axial, (n, d)."""
        bending, axial = self._solid.split(values)
        result = np.empty((len(self._s), len(bending) + 1))
        for i, plane in enumerate(bending):
            (plane[self._dofs] * self._w).sum(axis=1, out=result[:, i])
        if self._extensible:
            (axial[self._ends] * self._u).sum(axis=1, out=result[:, -1])
        else:
            np.multiply(self._u[:, 0], axial[0], out=result[:, -1])
        return result

    def linearise(self, step: Step) -> None:
        """Columns A^-1 J' of bending, (n, 2m), and of axial motion, (n, axial unknowns)."""
        solid = self._solid
        rows = self._moved
        if self._kept is not solid.flexibility:
            self._kept = solid.flexibility
            n = len(self._s)
            self._columns = np.empty((n, len(solid.flexibility)))
            self._lateral = np.empty((n, n))
            self._matrix = np.zeros((n, self._axes.shape[1], n, self._axes.shape[1]))
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
        return (self._local(values) @ self._axes).ravel()

    def jump(self, velocity: np.ndarray) -> np.ndarray:
        return self._at_points(velocity)

    def mean_jump(self, velocity: np.ndarray) -> np.ndarray:
        return self._at_points(velocity)

    def free_jump(self) -> np.ndarray:
        return self._at_points(self._solid.free_velocity)

    def compliance(self, mine: np.ndarray, other: Trace, theirs: np.ndarray) -> np.ndarray:
        assert isinstance(other, BeamTrace)
        matrix = self._whole_compliance(other)
        everything = len(mine) == len(matrix) and len(theirs) == matrix.shape[1]
        return matrix if everything else matrix[np.ix_(mine, theirs)]

    def mobility(self) -> np.ndarray:
        return self._whole_compliance(self).diagonal()

    def _whole_compliance(self, other: BeamTrace) -> np.ndarray:
        if other is self:
            lateral, result = self._lateral, self._matrix
        else:
            lateral = np.einsum("ank,nk->an", other._columns[:, self._dofs], self._w).T
            n, m, d = len(self._s), len(other._s), self._axes.shape[1]
            result = np.zeros((n, d, m, d))
        if self._extensible:
            along = np.einsum("ank,nk->an", self._axial_columns[:, other._ends], other._u)
        else:
            along = self._axial_columns * other._u[:, 0]
        for i, j, across, share in self._shares:
            if not across:
                result[:, i, :, j] = share * along
            elif not share:
                result[:, i, :, j] = across * lateral
            else:
                result[:, i, :, j] = across * lateral + share * along
        n, d, m, _ = result.shape
        return result.reshape(n * d, m * d)

    def spread(self, force: np.ndarray) -> None:
        if not force.any():
            return
        solid = self._solid
        local = force.reshape(len(self._s), -1) @ self._axes.T
        bending, axial = solid.split(solid._gain)
        along = local[:, -1]
        bending += local[:, :-1].T @ self._columns
        axial += along @ self._axial_columns
        solid._pushed += float(along @ self._u.sum(axis=1))

    def accept(self) -> None:
        """Nothing to do: the operator follows the prediction of each step."""
