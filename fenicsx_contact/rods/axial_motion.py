# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a law adds to a step of a beam that it drives along its axis, and the energy that it takes.

A force acts by its *share*: what of it each unknown bears, which is also how the travel at its
place follows from the unknowns. Each place adds one rank to the matrix of the step, and a drive
takes the one at which it holds the beam away.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite

import numpy as np

from ..base import checks
from ..theory.scheme import Step
from .drive import MASS, AxialForce, AxialLaw, Place


class AxialMotion:
    """Applies a law to the axial motion of a beam.

    Args:
        share: gives what each unknown bears of a force at a place, (n,).
        mass: of the beam, kg.
        gravity: along the travel, m/s².
        held: the beam cannot move along its axis.

    Attributes:
        taken: energy that the law has taken so far, J, by name.
        drive_force: force of a drive along the travel in the last step, N.
    """

    def __init__(
        self, share: Callable[[Place], np.ndarray], mass: float, gravity: float, held: bool
    ) -> None:
        self._share, self.mass, self.gravity, self._held = share, mass, gravity, held
        self.law: AxialLaw | None = None
        self.taken: dict[str, float] = {}
        self.drive_force = 0.0
        self._shares: dict[Place, np.ndarray] = {MASS: share(MASS)}
        # of each place: its forces, what they change by with the speed, the inertia added
        self._acting: list[tuple[Place, Sequence[AxialForce], Sequence[float], float]] = []
        self._works: dict[str, float] = {}

    def follow(self, law: AxialLaw | None) -> None:
        """Take up a law that can drive this beam."""
        if law is not None:
            checks.instance("law", law, AxialLaw, "a Fall, a Driven, an AxialLaw or None")
            law.check(self.mass, self.gravity, self._held)
            forces = law.forces(0.0, 0.0, self.mass, self.gravity, 1.0)
            at = getattr(law, "at", None)
            self._holding: Place = np.inf if at is None else at
            places = [MASS, self._holding, *(force.at for force in forces)]
            self._shares = {place: self._share(place) for place in places}
        self.law = law

    @property
    def prescribed(self) -> float | None:
        """The speed that the law imposes, m/s; None: it acts by forces."""
        return self.law.prescribed if self.law else None

    @property
    def holding(self) -> np.ndarray:
        """The share of a drive."""
        return self._shares[self._holding]

    def forces(
        self, u: np.ndarray, v: np.ndarray, dt: float, ahead: float = 0.0
    ) -> list[AxialForce]:
        """Those of the law on a beam with given unknowns, after a further time [s] at its
        speed."""
        if self.law is None:
            return []
        seen: dict[tuple[float, float], Sequence[AxialForce]] = {}
        found = []
        for place, share in self._shares.items():
            z, speed = state = -float(share @ u), -float(share @ v)
            if state not in seen:  # of an axis that does not stretch there is but one
                at = z + ahead * speed
                seen[state] = self.law.forces(at, speed, self.mass, self.gravity, dt)
                _check(seen[state], at)
            found += [force for force in seen[state] if force.at == place]
        return found

    def drive(
        self, step: Step, u: np.ndarray, v: np.ndarray, inverse: np.ndarray, load: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Take up the law for a step: adds its forces to the load and its rate to the matrix.

        The forces are those at the scheme's force point, their change within the step to first
        order: what is left out is O(dt²) of it. A drive holds its place against them, too.

        Args:
            step: the step.
            u, v: displacements and velocities at its start.
            inverse: of the matrix without the law.
            load: changed.

        Returns:
            The inverse of the matrix, and the velocity that a drive prescribes without any load.
        """
        self._acting = []
        if self.law is None:
            return inverse, np.zeros_like(load)
        weight = step.scheme.force_weight
        ahead = weight * step.dt
        forces = self.forces(u, v, step.dt, ahead) if step.dt else []
        for place in dict.fromkeys([MASS, *(force.at for force in forces)]):
            here, share = [f for f in forces if f.at == place], self._shares[place]
            changes = [weight * (f.by_speed + step.gap_rate * f.by_travel) for f in here]
            speed, added = -float(share @ v), 0.0
            if place == MASS:
                added = self.law.added_mass(-float(share @ u) + ahead * speed)
            c = added / step.span - sum(changes)
            load -= share * (sum(f.value for f in here) + c * speed)
            y = inverse @ share  # Sherman-Morrison
            inverse = inverse - c / (1 + c * float(share @ y)) * np.outer(y, y)
            self._acting.append((place, here, changes, added))
        if self.prescribed is not None:
            y = inverse @ self.holding
            y /= float(self.holding @ y)
            return inverse - np.outer(y, self.holding @ inverse), -self.prescribed * y
        return inverse, np.zeros_like(load)

    def balance(self, step: Step, before: np.ndarray, after: np.ndarray) -> np.ndarray | float:
        """What the law's forces and the added inertia are in the balance of a step between two
        velocities, on the unknowns, N; without a drive's force."""
        total: np.ndarray | float = 0.0
        for place, forces, changes, added in self._acting:
            share = self._shares[place]
            change = -float(share @ (after - before))
            value = sum(f.value + by * change for f, by in zip(forces, changes))
            total = total - share * (value - added * change / step.span)
        return total

    def works(
        self,
        step: Step,
        before: np.ndarray,
        after: np.ndarray,
        lacking: np.ndarray,
        others: dict[str, float],
    ) -> tuple[float, float]:
        """Works of the law in the step, J: against the added inertia, and of its forces.

        Args:
            step: the step.
            before, after: velocities at its ends.
            lacking: what is left of the balance without the law: its forces and a drive's, N.
            others: works that are kept in the same books.
        """
        works, inertial = dict(others), 0.0
        for place, forces, changes, added in self._acting:
            share = self._shares[place]
            change, middle = -float(share @ (after - before)), -float(share @ (after + before)) / 2
            inertial += added * change * middle
            for force, by in zip(forces, changes):
                work = step.dt * middle * (force.value + by * change)
                works[force.name] = works.get(force.name, 0.0) + work
        if self.prescribed is not None:
            share = self.holding
            given = lacking - self.balance(step, before, after)
            self.drive_force = -float(share @ given) / float(share @ share)
            middle = -float(share @ (after + before)) / 2
            works["drive"] = step.span * middle * self.drive_force
        self._works = works
        return inertial, sum(works.values())

    def accept(self, before: tuple[float, float], after: tuple[float, float]) -> None:
        """Book the works of the step between two states (travel, speed)."""
        for name, work in self._works.items():
            self.taken[name] = self.taken.get(name, 0.0) - work
        added = sum(each[3] for each in self._acting)
        if added:  # (M + m_a(z)) z'' is not the rate of a kinetic energy alone
            inertial = added * 0.5 * (after[1] ** 2 - before[1] ** 2)
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


def _check(forces: Sequence[AxialForce], travel: float) -> None:
    """Let a step fail by the forces of an own law that are no numbers."""
    for force in forces:
        given = force.value, force.by_speed, force.by_travel
        if not isfinite(sum(given)):
            with checks.asked_at(np.inf):  # of a step: it fails by them
                checks.vector(f"force {force.name!r}({travel:g})", given, 3)
