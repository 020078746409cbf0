# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a law adds to a step of a beam that it drives along its axis, and the energy that it takes.

A force acts by its *share*: what of it each unknown bears, which is also how the travel at its
place follows from the unknowns. Each place adds one rank to the matrix of the step, and a drive
takes the one at which it holds the beam away.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from math import isfinite
from numbers import Real

import numpy as np

from ..base import checks
from ..theory.scheme import Step
from .drive import LENGTH, MASS, AxialForce, AxialLaw, Place

#: Values of the unknowns at the start and at the end of a step.
Ends = tuple[np.ndarray, np.ndarray]


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
        # of each place: its forces, as if the speed stayed, their rates by it, the inertia added
        self._acting: list[tuple[Place, list[AxialForce], list[float], list[float], float]] = []
        self._works: dict[str, float] = {}

    def follow(self, law: AxialLaw | None) -> None:
        """Take up a law that can drive this beam."""
        self._acting = []
        if law is not None:
            checks.instance("law", law, AxialLaw, "a Fall, a Driven, an AxialLaw or None")
            law.check(self.mass, self.gravity, self._held)
            forces = _listed(law, 0.0, 0.0, self.mass, self.gravity, 1.0)
            places = [MASS, LENGTH, *(force.at for force in forces if isinstance(force.at, Real))]
            _check(forces, 0.0, places, 0.0)
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
                seen[state] = _listed(self.law, at, speed, self.mass, self.gravity, dt)
                _check(seen[state], at, self._shares)
            found += [force for force in seen[state] if force.at == place]
        return found

    def mean(self, force: AxialForce, step: Step, place: Place, u: Ends) -> tuple[float, float]:
        """Of a force that has a ``mean``, as far as the scheme takes forces in it, the rest at the
        end: N, and its derivative by the travel at the end, N/m."""
        assert force.mean is not None
        start, end = (-float(self._shares[place] @ each) for each in u)
        share, (value, rate) = step.mean_share, force.mean(start, end)
        if share < 1:
            last, half = force.mean(end, end)
            value, rate = share * value + (1 - share) * last, share * rate + (1 - share) * 2 * half
        _check([AxialForce(force.name, value, by_travel=rate)], end, [MASS])
        return value, rate

    def meets(self, u: Ends) -> bool:
        """Whether a force that has a mean acts between two states, or as the step was set up."""
        for place, forces, values, changes, _ in self._acting:
            start, end = (-float(self._shares[place] @ each) for each in u)
            for force, *told in zip(forces, values, changes):
                if force.mean and (any(told) or any(force.mean(start, end))):
                    return True
        return False

    def drive(
        self, step: Step, u: Ends, v: Ends, inverse: np.ndarray, load: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Take up the law for a step: adds its forces to the load and its rate to the matrix.

        The forces are those at the scheme's force point, their change within the step to first
        order: what is left out is O(dt²) of it. Those that have a mean over the way are linearised
        about the trial state. A drive holds its place against all of them.

        Args:
            step: the step.
            u, v: displacements and velocities at its start and in the trial state.
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
        forces = self.forces(u[0], v[0], step.dt, ahead) if step.dt else []
        for place in dict.fromkeys([MASS, *(force.at for force in forces)]):
            here, share = [f for f in forces if f.at == place], self._shares[place]
            speed, other = (-float(share @ each) for each in v)
            values, changes, added = [], [], 0.0
            for f in here:
                value, by = f.value, weight * (f.by_speed + step.gap_rate * f.by_travel)
                if f.mean:
                    value, rate = self.mean(f, step, place, u)
                    by = step.gap_rate * rate
                    value -= by * (other - speed)
                values.append(value)
                changes.append(by)
            if place == MASS:
                travel = -float(share @ u[0]) + ahead * speed
                with checks.asked_at(np.inf):  # of a step: it fails by it
                    what, told = f"added_mass({travel:g})", self.law.added_mass(travel)
                    added = checks.number(what, told, at_least=0)
            c = added / step.span - sum(changes)
            load -= share * (sum(values) + c * speed)
            y = inverse @ share  # Sherman-Morrison
            inverse = inverse - c / (1 + c * float(share @ y)) * np.outer(y, y)
            self._acting.append((place, here, values, changes, added))
        if self.prescribed is not None:
            y = inverse @ self.holding
            y /= float(self.holding @ y)
            return inverse - np.outer(y, self.holding @ inverse), -self.prescribed * y
        return inverse, np.zeros_like(load)

    def _found(self, step: Step, u: Ends, v: Ends) -> Iterator[tuple[Place, list[float], float]]:
        """At each place the forces as they are between two states, N, and the inertia added."""
        for place, forces, values, changes, added in self._acting:
            change = -float(self._shares[place] @ (v[1] - v[0]))
            found = [
                self.mean(f, step, place, u)[0] if f.mean else value + by * change
                for f, value, by in zip(forces, values, changes)
            ]
            yield place, found, added

    def balance(self, step: Step, u: Ends, v: Ends) -> np.ndarray | float:
        """What the law's forces and the added inertia are in the balance of a step between two
        states, on the unknowns, N; without a drive's force."""
        total: np.ndarray | float = 0.0
        for place, found, added in self._found(step, u, v):
            share = self._shares[place]
            change = -float(share @ (v[1] - v[0]))
            total = total - share * (sum(found) - added * change / step.span)
        return total

    def held(self, left: np.ndarray) -> np.ndarray | float:
        """What a drive holds of forces on the unknowns that balance nothing, N."""
        if self.prescribed is None:
            return 0.0
        share = self.holding
        return float(share @ left) / float(share @ share) * share

    def works(
        self,
        step: Step,
        u: Ends,
        v: Ends,
        lacking: np.ndarray,
        others: dict[str, float],
    ) -> tuple[float, float]:
        """Works of the law on the mean velocity, J: against the added inertia, and of its forces.

        Args:
            step: the step.
            u, v: displacements and velocities at its ends.
            lacking: what is left of the balance without the law: its forces and a drive's, N.
            others: works of loads that are kept in the same books, J, no part of the sum.
        """
        works: dict[str, float] = {}
        inertial = 0.0
        for (_, forces, *_), (place, found, added) in zip(self._acting, self._found(step, u, v)):
            share = self._shares[place]
            change, middle = -float(share @ (v[1] - v[0])), -float(share @ (v[1] + v[0])) / 2
            inertial += added * change * middle
            for force, value in zip(forces, found):
                works[force.name] = works.get(force.name, 0.0) + step.dt * middle * value
        if self.prescribed is not None:
            share = self.holding
            given = lacking - self.balance(step, u, v)
            self.drive_force = -float(share @ given) / float(share @ share)
            middle = -float(share @ (v[1] + v[0])) / 2
            works["drive"] = step.span * middle * self.drive_force
        self._works = works | others
        return inertial, sum(works.values())

    def accept(self, before: tuple[float, float], after: tuple[float, float]) -> None:
        """Book the works of the step between two states (travel, speed)."""
        for name, work in self._works.items():
            self.taken[name] = self.taken.get(name, 0.0) - work
        added = sum(each[-1] for each in self._acting)
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


def _listed(law: AxialLaw, travel: float, *given: float) -> list[AxialForce]:
    """What a law gives, or an error that names what it is, if it is no list of forces."""
    answer = law.forces(travel, *given)
    each = list(answer) if isinstance(answer, Iterable) else [answer]
    if not all(isinstance(force, AxialForce) for force in each):
        raise checks.InputError(f"law.forces({travel:g}, ...) = {answer!r}: must be AxialForces")
    return each


def _check(
    forces: Sequence[AxialForce], travel: float, places: Collection[Place], time: float = np.inf
) -> None:
    """Let a step fail, or refuse at time 0, s, the forces of an own law that are no numbers, or act
    where at first none did."""
    with checks.asked_at(time):
        for force in forces:
            if force.at not in places:
                raise checks.InputError(
                    f"force {force.name!r}({travel:g}): acts at {force.at!r}, where the law lists "
                    "no force at travel 0 (one of 0 N would do): a place s [m], 'mass' or 'length'"
                )
            given = force.value, force.by_speed, force.by_travel
            if not all(isinstance(number, Real) and isfinite(number) for number in given):
                checks.vector(f"force {force.name!r}({travel:g})", given, 3)
