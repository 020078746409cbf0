# SPDX-License-Identifier: LGPL-3.0-or-later
"""The theta-scheme (8): ``u+ = u- + dt (1 - theta) v- + dt theta v+``, ``a = (v+ - v-)/dt``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ..base import checks
from .scheme import Points, gauss

#: Exact for stored energies of degree 6 in F.
_GAUSS = gauss(3)


@dataclass(frozen=True)
class ThetaScheme:
    """The theta-scheme.

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
    memory_rows: ClassVar[int] = 0

    def __post_init__(self) -> None:
        checks.keep(self, "theta", at_least=0, at_most=1)
        checks.choice("forces", self.forces, ["theta", "end"])

    @property
    def position_rate(self) -> float:
        """Derivative of the increment by v+, over dt."""
        return self.theta

    @property
    def force_weight(self) -> float:
        """Share of u+ in the displacement at which the forces are taken."""
        return self.theta if self.forces == "theta" else 1.0

    @property
    def linear_weights(self) -> tuple[float, float]:
        """The force of a linear solid is that at one point."""
        return 1 - self.force_weight, self.force_weight

    @property
    def load_points(self) -> Points:
        """Loads are taken at the same point."""
        return [(self.force_weight, 1.0)]

    @property
    def force_points(self) -> Points:
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
    def growth(self) -> str:
        """Below 1/2 it makes (1/2 - theta) (dv' M dv + du' K du) in each step of a linear solid."""
        if self.theta >= 0.5:
            return ""
        return (
            f"theta = {self.theta!r}: must be >= 1/2, below which the scheme makes energy in each "
            "step, in deformable solids exponentially"
        )

    @property
    def bounds_work(self) -> bool:
        """From 1/2 on."""
        return self.theta >= 0.5

    @property
    def error_constant(self) -> float | None:
        """That of the trapezoidal rule."""
        return 1 / 12 if self.theta == 0.5 and self.forces == "theta" else None

    def increment(
        self, dt: float, v_old: np.ndarray, v_new: np.ndarray, memory: np.ndarray | None = None
    ) -> np.ndarray:
        """(8)."""
        return dt * ((1 - self.theta) * v_old + self.theta * v_new)

    def mean(self, v_old: np.ndarray, v_new: np.ndarray) -> np.ndarray:
        """Of the velocities at both ends."""
        return 0.5 * (v_old + v_new)

    def first(self, force: np.ndarray) -> None:
        """Nothing to remember."""

    def carried(self, memory: np.ndarray | None) -> float:
        """Nothing."""
        return 0.0

    def remember(
        self,
        dt: float,
        v_old: np.ndarray,
        v_new: np.ndarray,
        force: np.ndarray,
        memory: np.ndarray | None,
    ) -> None:
        """Nothing."""

    def describe(self) -> str:
        """Its name and parameters."""
        return f"theta = {self.theta!r}, forces at {self.forces}"


@dataclass(frozen=True)
class QuasiStatic(ThetaScheme):
    """No inertia: every step ends in equilibrium (theta = 1, forces at the end).

    Time only orders the loads; velocities are increments per step over its length.
    """

    theta: float = field(default=1.0, init=False)
    forces: str = field(default="end", init=False)
    inertia: ClassVar[float] = 0.0

    @property
    def bounds_work(self) -> bool:
        """An equilibrium may be reached by a snap, from more energy or to more."""
        return False

    def mean(self, v_old: np.ndarray, v_new: np.ndarray) -> np.ndarray:
        """The increments of the step over its length."""
        return v_new

    def describe(self) -> str:
        """Its name; it has no parameters."""
        return "quasi-static"
