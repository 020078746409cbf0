# SPDX-License-Identifier: LGPL-3.0-or-later
"""What drives a beam along its axis: a fall in water, or a drive that inserts it; what that adds to
a step, and the energy that it takes.

The *travel* z [m] of a beam is the mean of its axial displacement over its mass, positive against
the direction of its axis: a rod whose axis runs upwards from its tip travels downwards.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Protocol, runtime_checkable

from ..base import checks
from .water import Water

#: A place s [m] on an axis, or what a force is spread over: "mass" or "length".
Place = float | str
MASS, LENGTH = "mass", "length"


class AxialForce(NamedTuple):
    """A force along the travel, N, and its derivatives by speed [N s/m] and travel [N/m].

    On an axis that stretches it acts ``at`` a place s [m], or spread over "mass" or "length", and
    depends on the travel and the speed there. A law always lists all its forces, zero or not.

    Of a force of the travel alone, ``mean`` gives its mean over the way from one travel to another
    (which is the fall of its potential over the way, the same from either end), and the derivative
    of that by the latter. A step then solves for where it goes, and makes no energy by it.
    """

    name: str
    value: float
    by_speed: float = 0.0
    by_travel: float = 0.0
    at: Place = MASS
    mean: Callable[[float, float], tuple[float, float]] | None = None


@runtime_checkable
class AxialLaw(Protocol):
    """What drives a beam; write another one and pass it in the place of a Fall or a Driven.

    Attributes:
        prescribed: the speed that it imposes, m/s; None: it acts by forces.
        stop: travel beyond which no rod is meant to go, m; None: there is none.
    """

    @property
    def prescribed(self) -> float | None: ...
    @property
    def stop(self) -> float | None: ...

    def check(self, mass: float, gravity: float, held: bool) -> None:
        """Refuse a beam that it cannot drive: of a mass [kg], under gravity along the travel
        [m/s²], with an axis that stretches or is ``held`` along itself."""
        ...

    def added_mass(self, travel: float) -> float:
        """Mass that moves along with the beam, kg."""
        ...

    def forces(
        self, travel: float, speed: float, mass: float, gravity: float, dt: float
    ) -> Sequence[AxialForce]:
        """The forces along the travel in a step of dt seconds, weight left out."""
        ...


@dataclass(frozen=True)
class Fall:
    """A free fall, held back by water, by the friction of the drive line and by an end stop.

    Args:
        water: what the fluid does; None in air.
        drive_friction: constant friction of the drive line, N.
        stop: travel at which the end stop, a spring, is met, m; None: there is none.
        stop_stiffness: of that spring, N/m; the default is for SI units.
        stop_at: place s [m] at which it meets a rod whose axis stretches: the tip.
    """

    water: Water | None = None
    drive_friction: float = 0.0
    stop: float | None = None
    stop_stiffness: float = 1.7e5
    stop_at: float = 0.0
    prescribed: ClassVar[None] = None

    def __post_init__(self) -> None:
        if self.water is not None:
            checks.instance("water", self.water, Water, "an object with buoyancy, added_mass, drag")
            checks.vector("water.drag(0)", checks.called("water.drag(0)", self.water.drag, 0.0), 2)
        checks.keep(self, "drive_friction", at_least=0)
        checks.keep(self, "stop_stiffness", above=0)
        checks.keep(self, "stop_at", at_least=0)
        if self.stop is not None:
            checks.keep(self, "stop")

    def check(self, mass: float, gravity: float, held: bool) -> None:
        """Refuse a rod that would never fall."""
        if gravity == 0:
            raise checks.InputError(
                "fall: no gravity acts along the axis of the rod, it would never fall; "
                "give it one, such as gravity = (0, -9.81)"
            )
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
            forces.append(AxialForce("buoyancy", -self.water.buoyancy * gravity, at=LENGTH))
            by = -2 * C * abs(speed), -slope * speed * abs(speed)
            forces.append(AxialForce("drag", -C * speed * abs(speed), *by, at=LENGTH))
        if self.stop is not None:
            pressed = travel > self.stop
            force = -self.stop_stiffness * max(0.0, travel - self.stop)
            rate = -self.stop_stiffness * pressed
            forces.append(AxialForce("stop", force, 0.0, rate, self.stop_at, self._stopped))
        if self.drive_friction:
            inertia = mass + self.added_mass(travel)
            driving = inertia * speed / dt + mass * gravity + sum(f.value for f in forces)
            held = driving
            if driving > self.drive_friction:  # a friction of 0 ties with nothing: it has a slope
                held = self.drive_friction
            elif driving < -self.drive_friction:
                held = -self.drive_friction
            forces.append(AxialForce("drive line", -held))
        return forces

    def _stopped(self, start: float, end: float) -> tuple[float, float]:
        """Mean force of the stop over a way, N, and its derivative by the end, N/m."""
        assert self.stop is not None
        a, b, k = start - self.stop, end - self.stop, self.stop_stiffness
        if a >= 0 and b >= 0:
            return -k * (a + b) / 2, -k / 2
        if a <= 0 and b <= 0:
            return 0.0, 0.0
        deepest, met = max(a, b), max(a, b) / abs(b - a)  # over this share of the way
        rate = met - met * met / 2 if b > 0 else met * met / 2
        return -k * deepest * met / 2, -k * rate


@dataclass(frozen=True)
class Driven:
    """A drive that inserts the rod at a given speed.

    Args:
        speed: m/s along the travel; 0 holds it.
        at: place s [m] at which it holds a :class:`~fenicsx_contact.rods.von_karman.VonKarmanBeam`;
            None: its end.
    """

    speed: float = 0.0
    at: float | None = None
    stop: ClassVar[None] = None

    def __post_init__(self) -> None:
        checks.keep(self, "speed")
        if self.at is not None:
            checks.keep(self, "at", at_least=0)

    @property
    def prescribed(self) -> float:
        """The speed, m/s."""
        return self.speed

    def check(self, mass: float, gravity: float, held: bool) -> None:
        """Refuse an axis that no drive can move."""
        if held:
            raise checks.InputError(
                f"law = {self!r}: a driven axis must be inextensible and not supported along "
                "itself, or that of a VonKarmanBeam"
            )

    def added_mass(self, travel: float) -> float:
        """None."""
        return 0.0

    def forces(
        self, travel: float, speed: float, mass: float, gravity: float, dt: float
    ) -> Sequence[AxialForce]:
        """None but the drive's own, which the balance of the beam gives."""
        return ()
