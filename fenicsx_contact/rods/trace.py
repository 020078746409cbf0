# SPDX-License-Identifier: LGPL-3.0-or-later
"""A beam seen from points of its axis, and from stations past which it slides."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..base import checks
from ..base.constants import SAME
from ..solids.base import Trace
from ..theory.scheme import Step
from .axis import AxisMesh
from .matrices import BeamMatrices


class Slender(Protocol):
    """What a trace needs of a beam; see :class:`~fenicsx_contact.rods.beam.BeamSolid`.

    Attributes:
        predictions: counts the states from which points are to be found anew.
        flexibility, axial_flexibility: inverses of the matrices of a step, in a plane and along.
        free_velocity: that the step would end with if no contact acted.
    """

    axis: AxisMesh
    frame: np.ndarray
    matrices: BeamMatrices
    predictions: int
    velocity: np.ndarray
    trial_displacement: np.ndarray
    free_velocity: np.ndarray
    flexibility: np.ndarray
    axial_flexibility: np.ndarray

    def split(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]: ...
    def bear(self, bending: np.ndarray, axial: np.ndarray, along: np.ndarray) -> None: ...


@dataclass
class _Shapes:
    """Where n points are on a beam, and by which unknowns they are interpolated there.

    Attributes:
        s: m.
        side: -1 before the lower end of the beam, where there is none, 1 beyond the upper, else 0.
        dofs, w, dw: of the deflection and its derivative, (n, 4).
        ends, u: of the axial displacement, (n, 2); the second is none of an inextensible axis.
    """

    s: np.ndarray
    side: np.ndarray
    dofs: np.ndarray
    w: np.ndarray
    dw: np.ndarray
    ends: np.ndarray
    u: np.ndarray

    @property
    def void(self) -> np.ndarray:
        """Where there is no beam."""
        return self.side != 0

    def copy(self) -> _Shapes:
        return _Shapes(*(values.copy() for values in vars(self).values()))


class BeamTrace(Trace):
    """A beam seen from points of its axis and from stations.

    A point belongs to the material and moves with it. A station is fixed in space: in a step it
    sees the material that is predicted to be there at its end; between steps, that which is there.

    Args:
        solid: the beam.
        places: s of the points, m; where a station stands, it does not count.
        stations: indices of the stations among the points.
        at: gives the places of the stations along the axis, in space, m.
        within: the stations see only what lies between these s of the beam.
    """

    def __init__(
        self,
        solid: Slender,
        places: np.ndarray,
        stations: np.ndarray | None = None,
        at: Callable[[], np.ndarray] | None = None,
        within: tuple[float, float] = (-np.inf, np.inf),
    ) -> None:
        self._solid, self._find = solid, at or (lambda: np.zeros(0))
        self.stations = np.zeros(0, dtype=int) if stations is None else stations
        knots, n = solid.matrices.s, len(places)
        self._within = max(within[0], knots[0]), min(within[1], knots[-1])
        inside = np.ones(n, dtype=bool)
        inside[self.stations] = False
        self._nodes, on = np.flatnonzero(inside), np.asarray(places)[inside]
        beyond = SAME * knots[-1]
        if not ((on >= -beyond) & (on <= knots[-1] + beyond)).all():
            raise checks.InputError("points: each point of a trace must lie on the beam's axis")
        self._axes = np.concatenate([solid.frame, solid.axis.direction[None]])
        axial = np.outer(solid.axis.direction, solid.axis.direction)
        self._shares = [
            (i, j, float(i == j) - share, share)
            for (i, j), share in np.ndenumerate(axial)
            if i == j or share
        ]
        self._extensible = len(solid.split(solid.velocity)[1]) > 1
        self._at = np.zeros(0)
        whole, real = np.zeros((n, 4)), np.zeros((n, 2))
        self._now = _Shapes(
            np.array(places, dtype=float),
            np.zeros(n, dtype=int),
            whole.astype(int),
            whole,
            whole.copy(),
            real.astype(int),
            real,
        )
        self._place(self._nodes)
        self._acting = self._now  # those of the step, by which forces act
        self._kept: np.ndarray | None = None  # the inverse that the columns belong to
        self._linear: np.ndarray | None = None  # the linearisation that they belong to
        self._seen = -1
        self.follow()

    # -- places ---------------------------------------------------------------------------------

    @property
    def rod(self) -> BeamTrace:
        """The trace itself; of a rod in an elastic tube, that of its rod."""
        return self

    @property
    def void(self) -> np.ndarray:
        """Points at which there is no beam: stations that it has not reached, or has passed."""
        return self._now.void

    @property
    def side(self) -> np.ndarray:
        """On which side of the stretch these are: -1 before its lower end, 1 beyond its upper one,
        0 where there is beam."""
        return self._now.side

    @property
    def material(self) -> np.ndarray:
        """The s of what is at the points, (n,) in m."""
        return self._now.s

    @property
    def acted(self) -> tuple[np.ndarray, np.ndarray]:
        """The same in the step that was linearised last, and where there was no beam, (n,)."""
        return self._acting.s, self._acting.void

    def _place(self, points: np.ndarray) -> None:
        """Shape functions at the present s of some points."""
        now = self._now
        cell, xi, weights = self._solid.matrices.interpolate(now.s[points])
        real = ~now.void[points][:, None]
        now.dofs[points] = 2 * cell[:, None] + np.arange(4)
        now.w[points], now.dw[points] = weights * real
        if self._extensible:
            now.ends[points] = cell[:, None] + np.arange(2)
            now.u[points] = np.stack([1 - xi, xi], axis=1) * real
        else:
            now.u[points, :1] = real

    def follow(self) -> None:
        solid = self._solid
        if self._seen != solid.predictions:
            self._seen = solid.predictions
            self._slide()

    def accept(self) -> None:
        """See, at the stations, the material that the step has brought there: what is known of the
        state is a function of the state alone."""
        if self._slid is not self._solid.trial_displacement:
            self._slide()

    def _slide(self) -> None:
        """Which material is at the stations."""
        solid, knots = self._solid, self._solid.matrices.s
        self._placed: np.ndarray | None = None  # the displacement that the positions are of
        self._slid = solid.trial_displacement
        if not len(self.stations):
            return
        self._at, axial = self._find(), solid.split(self._slid)[1]
        low, high = np.interp(self._within, knots, knots + axial)
        self._now = now = self._now.copy()
        now.s[self.stations] = (
            np.interp(self._at, knots + axial, knots) if self._extensible else self._at - axial[0]
        )
        now.side[self.stations] = (self._at > high).astype(int) - (self._at < low)
        self._place(self.stations)

    def deflections(self) -> np.ndarray:
        """Lateral displacements of the points in the trial state, (n, d) in m."""
        return self._local(self._solid.trial_displacement, self._now)[:, :-1] @ self._axes[:-1]

    def positions(self) -> np.ndarray:
        if self._placed is not self._solid.trial_displacement:
            self._placed = self._solid.trial_displacement
            local = self._local(self._solid.trial_displacement, self._now)
            local[:, -1] += self._now.s
            local[self.stations, -1] = self._at
            self._positions = self._solid.axis.origin + local @ self._axes
        return self._positions

    def slopes(self) -> np.ndarray:
        """Derivative of the deflection by s at the points in the trial state, (n, d - 1)."""
        bending, now = self._solid.split(self._solid.trial_displacement)[0], self._now
        return np.stack([(plane[now.dofs] * now.dw).sum(axis=1) for plane in bending], axis=1)

    def _local(self, values: np.ndarray, shapes: _Shapes) -> np.ndarray:
        """A field at the points in the frame of the axis: lateral, then axial, (n, d)."""
        bending, axial = self._solid.split(values)
        result = np.empty((len(shapes.s), len(bending) + 1))
        for i, plane in enumerate(bending):
            (plane[shapes.dofs] * shapes.w).sum(axis=1, out=result[:, i])
        (axial[shapes.ends] * shapes.u).sum(axis=1, out=result[:, -1])
        return result

    # -- the operator of a step -----------------------------------------------------------------

    def linearise(self, step: Step) -> None:
        """Columns A^-1 J' of bending, (n, 2m), and of axial motion, (n, axial unknowns)."""
        solid = self._solid
        if self._acting is self._now and self._linear is solid.free_velocity:
            return
        self._acting = acting = self._now
        self._linear = solid.free_velocity
        if self._kept is not solid.flexibility:
            self._kept = solid.flexibility
            self._columns = np.zeros((len(acting.s), len(solid.flexibility)))
            self._renew(self._nodes)
        self._renew(self.stations)
        axial = solid.axial_flexibility
        self._axial_columns = np.einsum("nk,nkj->nj", acting.u, axial[acting.ends])

    def _renew(self, rows: np.ndarray) -> None:
        """What some points do to the beam."""
        dofs, w = self._acting.dofs[rows], self._acting.w[rows]
        self._columns[rows] = np.einsum("nk,nkj->nj", w, self._solid.flexibility[dofs])

    def jump(self, velocity: np.ndarray) -> np.ndarray:
        return (self._local(velocity, self._now) @ self._axes).ravel()

    def mean_jump(self, velocity: np.ndarray) -> np.ndarray:
        return (self._local(velocity, self._acting) @ self._axes).ravel()

    def free_jump(self) -> np.ndarray:
        return self.mean_jump(self._solid.free_velocity)

    def compliance(self, mine: np.ndarray, other: Trace, theirs: np.ndarray) -> np.ndarray:
        assert isinstance(other, BeamTrace)
        d = len(self._axes)
        (here, a), (there, b) = (
            np.unique(each // d, return_inverse=True) for each in (mine, theirs)
        )
        matrix = self._compliance(here, other, there)
        return matrix[np.ix_(a * d + mine % d, b * d + theirs % d)]

    def mobility(self) -> np.ndarray:
        acting = self._acting
        lateral = (np.take_along_axis(self._columns, acting.dofs, axis=1) * acting.w).sum(axis=1)
        along = np.take_along_axis(self._axial_columns, acting.ends, axis=1) * acting.u
        result = np.zeros((len(lateral), len(self._axes)))
        for i, j, across, share in self._shares:
            if i == j:
                result[:, i] = across * lateral + share * along.sum(axis=1)
        return result.ravel()

    def _compliance(self, here: np.ndarray, other: BeamTrace, there: np.ndarray) -> np.ndarray:
        """J A^-1 J' between all components of some points of two traces of the beam."""
        theirs, d = other._acting, len(self._axes)
        dofs, w, ends, u = (each[there] for each in (theirs.dofs, theirs.w, theirs.ends, theirs.u))
        lateral = np.einsum("ank,nk->an", self._columns[here[:, None, None], dofs], w)
        along = np.einsum("ank,nk->an", self._axial_columns[here[:, None, None], ends], u)
        result = np.zeros((len(here), d, len(there), d))
        for i, j, across, share in self._shares:
            result[:, i, :, j] = across * lateral + share * along
        return result.reshape(len(here) * d, len(there) * d)

    def spread(self, force: np.ndarray) -> None:
        if not force.any():
            return
        acting, axial = self._acting, self._solid.axial_flexibility
        local = force.reshape(len(acting.s), -1) @ self._axes.T
        along = local[:, -1]
        borne = (along[:, None] * acting.u).ravel()
        self._solid.bear(
            local[:, :-1].T @ self._columns,
            along @ self._axial_columns,
            np.bincount(acting.ends.ravel(), borne, len(axial)),
        )
