# SPDX-License-Identifier: LGPL-3.0-or-later
"""The theta-scheme (8): ``u+ = u- + dt (1 - theta) v- + dt theta v+``, ``a = (v+ - v-)/dt``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ..base import checks

#: Gauss points over the way of a step, and weights: exact for stored energies of degree 6 in F.
_GAUSS = [(float(1 + x) / 2, float(w) / 2) for x, w in zip(*np.polynomial.legendre.leggauss(3))]


@dataclass(frozen=True)
class ThetaScheme:
    """The time scheme of a scene.

    Args:
        theta: in [0, 1].
        forces: where the internal forces are taken. ``"end"``: at the end of the step, as the
            paper prints it; even theta = 1/2 then damps (ratio theta omega dt/2). ``"theta"``: at
            theta u+ + (1 - theta) u-, which makes theta = 1/2 second order and conserves energy
            without contact (damping ratio (theta - 1/2) omega dt); of a hyperelastic solid the
            mean over the step in place of the midpoint, see ``force_points``.

    Raises:
        InputError: theta outside [0, 1], unknown ``forces``.
    """

    theta: float = 0.5
    forces: str = "theta"
    inertia: ClassVar[float] = 1.0

    def __post_init__(self) -> None:
        checks.number("theta", self.theta, at_least=0, at_most=1)
        checks.choice("forces", self.forces, ["theta", "end"])

    @property
    def force_weight(self) -> float:
        """Share of u+ in the displacement at which the forces are taken."""
        return self.theta if self.forces == "theta" else 1.0

    @property
    def force_points(self) -> list[tuple[float, float]]:
        """Where a nonlinear solid takes its internal forces: shares of the way from u- to u+ and
        their weights.

        2 min(theta, 1 - theta) of them are the mean over the way, whose work is the change of the
        stored energy; a midpoint's is not, at large strain. The rest is taken at the nearer end.
        Of a linear solid that is the force at the theta-point. (Average vector field method:
        Quispel & McLaren 2008, doi:10.1088/1751-8113/41/4/045206.)
        """
        if self.forces == "end" or self.theta in (0.0, 1.0):
            return [(self.force_weight, 1.0)]
        mean = 2 * min(self.theta, 1 - self.theta)
        points = [(share, mean * weight) for share, weight in _GAUSS]
        return points if mean == 1 else [*points, (float(self.theta > 0.5), 1 - mean)]

    @property
    def mean_share(self) -> float:
        """How much of the forces is taken in the mean over the way; see ``force_points``."""
        return 2 * min(self.theta, 1 - self.theta) if self.forces == "theta" else 0.0

    def mean(self, v_old: np.ndarray, v_new: np.ndarray) -> np.ndarray:
        """The velocity by which works are counted: what multiplies a change of momentum to give
        that of the kinetic energy."""
        return 0.5 * (v_old + v_new)

    def increment(self, dt: float, v_old: np.ndarray, v_new: np.ndarray) -> np.ndarray:
        """The displacement increment u+ - u- of a step."""
        return dt * ((1 - self.theta) * v_old + self.theta * v_new)


@dataclass(frozen=True)
class QuasiStatic(ThetaScheme):
    """No inertia: every step ends in equilibrium (theta = 1, forces at the end).

    Time only orders the loads; velocities are increments per step over its length.
    """

    theta: float = field(default=1.0, init=False)
    forces: str = field(default="end", init=False)
    inertia: ClassVar[float] = 0.0

    def mean(self, v_old: np.ndarray, v_new: np.ndarray) -> np.ndarray:
        """The increments of the step over its length."""
        return v_new


@dataclass(frozen=True)
class Step:
    """One time step: its length in seconds and the scheme that crosses it.

    An impact is a step of no length. Its forces are percussions: impulses over a ``span`` of 1 s
    instead of over dt, with which nothing moves and no load acts. It looks ``ahead`` over the step
    that follows it: no point may come out of it faster than it would arrive then.
    """

    dt: float
    scheme: ThetaScheme
    start: float = 0.0
    ahead: float = 0.0

    @property
    def horizon(self) -> float:
        """The time by whose end no point may pass its obstacle, s."""
        return self.dt or self.ahead or 1.0

    @property
    def limit_rate(self) -> float:
        """How fast a point may fall back, over how fast it left: (1 - theta)/theta, with which it
        is back at the end of the step; 0 in an impact."""
        theta = self.scheme.theta
        return (1 - theta) / theta if self.dt and theta else 0.0

    @property
    def implicitness(self) -> float:
        """How far the velocity at the end of a step is the mean over it: 1 for theta = 1, 0 for
        theta = 1/2."""
        return max(0.0, 2 * self.scheme.theta - 1)

    @property
    def end(self) -> float:
        """Time at which it ends, s."""
        return self.start + self.dt

    @property
    def force_time(self) -> float:
        """Time at which its forces are taken, s."""
        return self.start + self.scheme.force_weight * self.dt

    @property
    def span(self) -> float:
        """The time over which the forces of the step are spread, s."""
        return self.dt or 1.0

    @property
    def loaded(self) -> float:
        """1 where loads and internal forces act, 0 in an impact."""
        return 1.0 if self.dt else 0.0

    @property
    def gap_rate(self) -> float:
        """Derivative of the end position by the end velocity: theta dt."""
        return self.scheme.theta * self.dt

    @property
    def force_rate(self) -> float:
        """Derivative of the position at which forces are taken by the end velocity."""
        return self.scheme.force_weight * self.gap_rate
