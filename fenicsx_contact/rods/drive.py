# SPDX-License-Identifier: LGPL-3.0-or-later
"""What drives a beam along its axis: a fall in water, or a drive that inserts it.

The *travel* z [m] of a beam is the mean of its axial displacement over its mass, positive against
the direction of its axis: a rod whose axis runs upwards from its tip travels downwards.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from ..base import checks


class AxialForce(NamedTuple):
    """A force along the travel, N, and its derivatives by speed [N s/m] and travel [N/m]."""

    name: str
    value: float
    by_speed: float = 0.0
    by_travel: float = 0.0


@runtime_checkable
class Water(Protocol):
    """What a fluid does to a falling rod; write another one and pass it in its place."""

    @property
    def buoyancy(self) -> float:
        """Mass of the displaced fluid, kg."""
        ...

    def added_mass(self, travel: float) -> float:
        """Mass of fluid that moves with the rod, kg."""
        ...

    def drag(self, travel: float) -> tuple[float, float]:
        """C in the drag C v|v|, and its derivative by the travel: N s²/m², N s²/m³."""
        ...


@dataclass(frozen=True)
class GuideTubeWater:
    """Water in guide tubes with a dashpot at their end.

    The drag ``C(z) v|v|`` falls a little as the rod leaves the upper guides and rises steeply in
    the dashpot, into which a cubic ramp leads. The default numbers reproduce the three published
    states of EDF's test FDNL100 (900 MWe, Code_Aster), to which they were fitted.

    Args:
        buoyancy: mass of the displaced water, kg.
        mass: added mass at the start, kg; it falls to nothing at ``mass_travel`` [m].
        before, before_slope: C before the dashpot is ``before + before_slope z``.
        inside, inside_slope: and in it ``inside + inside_slope (z - dashpot)``.
        dashpot: travel at which the tip enters it, m.
        ramp: length over which the one passes into the other, m.
    """

    buoyancy: float = 12.974984653305937
    mass: float = 37.603056594168685
    mass_travel: float = 5.0
    before: float = 126.92754331492887
    before_slope: float = -6.602723046996193
    inside: float = 120.44864895931809
    inside_slope: float = 3389.1263120481217
    dashpot: float = 3.05
    ramp: float = 0.05

    def __post_init__(self) -> None:
        for name in ("buoyancy", "mass", "before", "inside"):
            checks.number(name, getattr(self, name), at_least=0)
        for name in ("mass_travel", "dashpot", "ramp"):
            checks.number(name, getattr(self, name), above=0)
        for name in ("before_slope", "inside_slope"):
            checks.number(name, getattr(self, name))

    def added_mass(self, travel: float) -> float:
        """Mass of water that moves with the rod, kg."""
        return self.mass * max(0.0, 1 - travel / self.mass_travel)

    def drag(self, travel: float) -> tuple[float, float]:
        """C and its derivative by the travel."""
        deep = travel - self.dashpot
        outer, inner = (
            self.before + self.before_slope * travel,
            self.inside + self.inside_slope * deep,
        )
        x = min(max(deep / self.ramp, 0.0), 1.0)
        share, rise = x * x * (3 - 2 * x), 6 * x * (1 - x) / self.ramp
        slope = (1 - share) * self.before_slope + share * self.inside_slope + rise * (inner - outer)
        return outer + share * (inner - outer), slope


@dataclass(frozen=True)
class Fall:
    """A free fall, held back by water, by the friction of the drive line and by an end stop.

    Args:
        water: what the fluid does; None in air.
        drive_friction: constant friction of the drive line, N.
        stop: travel at which the end stop, a spring, is met, m; None: there is none.
        stop_stiffness: of that spring, N/m.
    """

    water: Water | None = None
    drive_friction: float = 0.0
    stop: float | None = None
    stop_stiffness: float = 1.7e5

    def __post_init__(self) -> None:
        if self.water is not None:
            checks.instance("water", self.water, Water, "an object with buoyancy, added_mass, drag")
        checks.number("drive_friction", self.drive_friction, at_least=0)
        checks.number("stop_stiffness", self.stop_stiffness, above=0)
        if self.stop is not None:
            checks.number("stop", self.stop)

    def check(self, mass: float, gravity: float) -> None:
        """Refuse a rod that would never fall (mass in kg, gravity along the travel in m/s²)."""
        buoyancy = self.water.buoyancy if self.water else 0.0
        if (mass - buoyancy) * gravity <= self.drive_friction:
            raise checks.InputError(
                f"fall: the weight of the rod, {mass * gravity:.6g} N, less buoyancy, "
                f"{buoyancy * gravity:.6g} N, must be > the friction of its drive line, "
                f"{self.drive_friction:.6g} N; it would never fall"
            )

    def added_mass(self, travel: float) -> float:
        """Mass of fluid that moves with the rod, kg."""
        return self.water.added_mass(travel) if self.water else 0.0

    def forces(
        self, travel: float, speed: float, mass: float, gravity: float, dt: float
    ) -> Sequence[AxialForce]:
        """The forces along the travel, weight left out.

        The drive line holds back with what would stop the rod within the step, but never with
        more than its friction.

        Args:
            travel, speed, mass: of the rod, m, m/s, kg.
            gravity: along the travel, m/s².
            dt: length of the step, s.
        """
        forces = []
        if self.water:
            C, slope = self.water.drag(travel)
            forces.append(AxialForce("buoyancy", -self.water.buoyancy * gravity))
            by = -2 * C * abs(speed), -slope * speed * abs(speed)
            forces.append(AxialForce("drag", -C * speed * abs(speed), *by))
        if self.stop is not None:
            pressed = travel > self.stop
            force = -self.stop_stiffness * max(0.0, travel - self.stop)
            forces.append(AxialForce("stop", force, 0.0, -self.stop_stiffness * pressed))
        if self.drive_friction:
            inertia = mass + self.added_mass(travel)
            driving = inertia * speed / dt + mass * gravity + sum(f.value for f in forces)
            held = float(np.clip(driving, -self.drive_friction, self.drive_friction))
            forces.append(AxialForce("drive line", -held))
        return forces


@dataclass(frozen=True)
class Driven:
    """A drive that inserts the rod at a given speed (m/s along the travel; 0 holds it)."""

    speed: float = 0.0

    def __post_init__(self) -> None:
        checks.number("speed", self.speed)


AxialLaw = Fall | Driven
