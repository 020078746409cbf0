# SPDX-License-Identifier: LGPL-3.0-or-later
"""What drives a beam along its axis: a fall in water, or a drive that inserts it; what that adds to
a step, and the energy that it takes.

The *travel* z [m] of a beam is the mean of its axial displacement over its mass, positive against
the direction of its axis: a rod whose axis runs upwards from its tip travels downwards.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Protocol, runtime_checkable

import numpy as np

from ..base import checks
from ..theory.theta import Step
from .water import Water


class AxialForce(NamedTuple):
    """A force along the travel, N, and its derivatives by speed [N s/m] and travel [N/m]."""

    name: str
    value: float
    by_speed: float = 0.0
    by_travel: float = 0.0


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
        stop_stiffness: of that spring, N/m.
    """

    water: Water | None = None
    drive_friction: float = 0.0
    stop: float | None = None
    stop_stiffness: float = 1.7e5
    prescribed: ClassVar[None] = None

    def __post_init__(self) -> None:
        if self.water is not None:
            checks.instance("water", self.water, Water, "an object with buoyancy, added_mass, drag")
        checks.keep(self, "drive_friction", at_least=0)
        checks.keep(self, "stop_stiffness", above=0)
        if self.stop is not None:
            checks.keep(self, "stop")

    def check(self, mass: float, gravity: float, held: bool) -> None:
        """Refuse a rod that would never fall."""
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
    stop: ClassVar[None] = None

    def __post_init__(self) -> None:
        checks.keep(self, "speed")

    @property
    def prescribed(self) -> float:
        """The speed, m/s."""
        return self.speed

    def check(self, mass: float, gravity: float, held: bool) -> None:
        """Refuse an axis that no drive can move."""
        if held:
            raise checks.InputError(
                f"law = {self!r}: a driven axis must be inextensible and not supported along itself"
            )

    def added_mass(self, travel: float) -> float:
        """None."""
        return 0.0

    def forces(
        self, travel: float, speed: float, mass: float, gravity: float, dt: float
    ) -> Sequence[AxialForce]:
        """None but the drive's own, which the balance of the beam gives."""
        return ()


class AxialMotion:
    """Applies a law to the mean axial motion of a beam.

    Args:
        mean: share of each axial unknown in the mean over the mass.
        mass: of the beam, kg.
        gravity: along the travel, m/s².
        held: the axis stretches, or is supported along itself: no drive can move it.

    Attributes:
        taken: energy that the law has taken so far, J, by name.
        drive_force: force of a drive along the travel in the last step, N.
    """

    def __init__(self, mean: np.ndarray, mass: float, gravity: float, held: bool) -> None:
        self.mean, self.mass, self.gravity, self._held = mean, mass, gravity, held
        self.law: AxialLaw | None = None
        self.taken: dict[str, float] = {}
        self.drive_force = 0.0
        self._forces: Sequence[AxialForce] = ()
        self._changes: Sequence[float] = ()
        self._added = 0.0
        self._works: dict[str, float] = {}

    def follow(self, law: AxialLaw | None) -> None:
        """Take up a law that can drive this beam."""
        if law is not None:
            checks.instance("law", law, AxialLaw, "a Fall, a Driven, an AxialLaw or None")
            law.check(self.mass, self.gravity, self._held)
        self.law = law

    @property
    def prescribed(self) -> float | None:
        """The speed that the law imposes, m/s; None: it acts by forces."""
        return self.law.prescribed if self.law else None

    def drive(
        self, step: Step, travel: float, speed: float, inverse: np.ndarray, load: np.ndarray
    ) -> np.ndarray:
        """Take up the law for a step: adds its forces to the axial load and its rate to the matrix.

        The forces are those at the scheme's force point, their change within the step to first
        order: what is left out is O(dt²) of it.

        Args:
            step: the step.
            travel, speed: at its start, m, m/s.
            inverse: of the axial matrix without the law.
            load: axial load, changed.

        Returns:
            The inverse of the axial matrix; zero where a drive prescribes the motion.
        """
        self._forces, self._changes, self._added = (), (), 0.0
        if self.law is None:
            return inverse
        if self.prescribed is not None:
            return np.zeros_like(inverse)
        weight = step.scheme.force_weight
        z = travel + weight * step.dt * speed
        self._added = self.law.added_mass(z)
        if step.dt:
            self._forces = self.law.forces(z, speed, self.mass, self.gravity, step.dt)
        self._changes = [weight * (f.by_speed + step.gap_rate * f.by_travel) for f in self._forces]
        c = self._added / step.span - sum(self._changes)
        load -= self.mean * (sum(f.value for f in self._forces) + c * speed)
        y = inverse @ self.mean  # Sherman-Morrison: the law acts on the mean alone
        return inverse - c / (1 + c * float(self.mean @ y)) * np.outer(y, y)

    def works(
        self, step: Step, before: float, after: float, pushed: float, others: dict[str, float]
    ) -> tuple[float, float]:
        """Works of the law in the step, J: against the added inertia, and of its forces.

        Args:
            step: the step.
            before, after: speeds at its ends, m/s.
            pushed: force of the contacts along the axis, N, for the balance of a drive.
            others: works that are kept in the same books.
        """
        change, middle = after - before, 0.5 * (after + before)
        works = dict(others)
        for force, by in zip(self._forces, self._changes):
            works[force.name] = step.dt * middle * (force.value + by * change)
        if self.prescribed is not None:
            rate = self.mass * change / step.span
            self.drive_force = rate - step.loaded * self.mass * self.gravity + pushed
            works["drive"] = step.span * middle * self.drive_force
        self._works = works
        return self._added * change * middle, sum(works.values())

    def accept(self, before: tuple[float, float], after: tuple[float, float]) -> None:
        """Book the works of the step between two states (travel, speed)."""
        for name, work in self._works.items():
            self.taken[name] = self.taken.get(name, 0.0) - work
        if self._added:  # (M + m_a(z)) z'' is not the rate of a kinetic energy alone
            inertial = self._added * 0.5 * (after[1] ** 2 - before[1] ** 2)
            lost = inertial - self.added_energy(*after) + self.added_energy(*before)
            self.taken["added mass"] = self.taken.get("added mass", 0.0) + lost

    def added_energy(self, travel: float, speed: float) -> float:
        """Kinetic energy of the water that moves along, J."""
        return 0.5 * self.law.added_mass(travel) * speed**2 if self.law else 0.0

    def state(self) -> dict[str, np.ndarray]:
        """What :meth:`restore` takes up: the energies that were taken."""
        names, values = list(self.taken), list(self.taken.values())
        return {"taken.names": np.array(names, dtype=str), "taken": np.array(values)}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Take up a state that :meth:`state` gave."""
        self.taken = dict(zip(map(str, state["taken.names"]), map(float, state["taken"])))
