# SPDX-License-Identifier: LGPL-3.0-or-later
"""The axial motion of a beam in a step: what its law adds to it, and the energy that it takes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..base import checks
from ..theory.theta import Step
from .drive import AxialForce, AxialLaw, Driven, Fall


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
        self._law: AxialLaw | None = None
        self.taken: dict[str, float] = {}
        self.drive_force = 0.0
        self._forces: Sequence[AxialForce] = ()
        self._changes: Sequence[float] = ()
        self._added = 0.0
        self._works: dict[str, float] = {}

    @property
    def law(self) -> AxialLaw | None:
        """The law."""
        return self._law

    @law.setter
    def law(self, law: AxialLaw | None) -> None:
        if law is not None:
            checks.instance("law", law, (Fall, Driven), "a Fall, a Driven or None")
        if isinstance(law, Fall):
            law.check(self.mass, self.gravity)
        if isinstance(law, Driven) and self._held:
            raise checks.InputError(
                f"law = {law!r}: a driven axis must be inextensible and not supported along itself"
            )
        self._law = law

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
        if isinstance(self._law, Driven):
            return np.zeros_like(inverse)
        if self._law is None:
            return inverse
        weight = step.scheme.force_weight
        z = travel + weight * step.dt * speed
        self._added = self._law.added_mass(z)
        if step.dt:
            self._forces = self._law.forces(z, speed, self.mass, self.gravity, step.dt)
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
        if isinstance(self._law, Driven):
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
        if not isinstance(self._law, Fall):
            return 0.0
        return 0.5 * self._law.added_mass(travel) * speed**2
