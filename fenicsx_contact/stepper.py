# SPDX-License-Identifier: LGPL-3.0-or-later
"""One step of a scene: prediction, linearisations with a surface problem each, acceptance.

The loop over linearisations is the paper's geometric fixed point and, for hyperelastic solids,
Newton's method for their momentum balance. A scene of linear solids passes it once.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from .checks import StepFailed
from .contact import Contact
from .newton import Newton, NotConverged, Solution
from .solids import Solid
from .system import SurfaceSystem
from .theta import Step

#: Relative error of the linearised operator, gaps and momentum at which the loop ends.
GEOMETRY_TOLERANCE = 1e-8
MAX_GEOMETRY = 25


@dataclass(frozen=True)
class Trial:
    """A step that was solved and not yet accepted: the solids stand in their trial states."""

    step: Step
    force: np.ndarray
    newton: int
    geometry: int
    remarks: list[str]


class Stepper:
    """Takes the steps of a scene and keeps its books.

    Attributes:
        time: s.
        work: of impacts, friction, drives and the scheme since the start, J; ``balance``, what they and the
            energies leave unexplained.
        times: seconds spent by phase.
    """

    def __init__(
        self, solids: Sequence[Solid], contacts: Sequence[Contact], newton: Newton
    ) -> None:
        self.solids, self.contacts, self.newton = list(solids), list(contacts), newton
        self._parts = _slices(contact.part.places for contact in self.contacts)
        self._sides = [  # solid and trace of each side of each contact
            side for c in self.contacts for side in zip(c.solids, c.traces)
        ]
        self._slices = _slices(trace.jump(s.velocity).size for s, trace in self._sides)
        self._system = SurfaceSystem(
            [contact.part for contact in self.contacts],
            [contact.name for contact in self.contacts],
        )
        self.times: dict[str, float] = {}
        self.time = 0.0
        self.work, self.balance = np.zeros(4), 0.0
        self.energies = self.sum_energies()

    def attempt(self, step: Step, closing: bool = True) -> Trial:
        """Solve a step from the present state.

        Args:
            step: its length and scheme.
            closing: whether points that are open now may close.

        Raises:
            StepFailed: with the reason; the state is as before.
        """
        before = [contact.equations.values for contact in self.contacts]
        try:
            return self._attempt(step, closing)
        except StepFailed:
            for contact, values in zip(self.contacts, before):
                contact.equations.values = values
            raise

    def _attempt(self, step: Step, closing: bool) -> Trial:
        clock = _Clock(self.times)
        for solid in self.solids:
            solid.predict(step)
        for contact in self.contacts:
            contact.predict(step, closing)
        clock("pairing")
        iterations, remarks = 0, []
        for sweep in range(1, MAX_GEOMETRY + 1):
            for solid in self.solids:
                solid.linearise(step)
            clock("solids")
            speed = self._linearise(step, first=sweep == 1)
            clock("pairing")
            solution = self._solve(step)
            iterations += solution.iterations
            remarks += solution.remarks
            clock("newton")
            for (_, trace), part in zip(self._sides, self._slices):
                trace.spread(solution.force[part])
            for solid in self.solids:
                solid.correct(step)
            clock("solids")
            error = self._nonlinearity(step, speed)
            clock("pairing")
            if error <= GEOMETRY_TOLERANCE:
                return Trial(step, solution.force, iterations, sweep, remarks)
        raise StepFailed(
            f"the geometric fixed point stalls at a relative error of {error:.3g} after "
            f"{sweep} linearisations"
        )

    def _linearise(self, step: Step, first: bool) -> float:
        """Velocities without contact, compliance and scales; returns a typical speed."""
        for contact in self.contacts:
            contact.linearise(step)
        free = [trace.free_jump() for _, trace in self._sides]
        self._free = free[0] if len(free) == 1 else np.concatenate([*free, np.empty(0)])
        speed = 0.0
        for contact, part in zip(self.contacts, self._parts):
            active = contact.part.active_places
            speed = max(speed, float(np.abs(self._free[part][active]).max(initial=0.0)))
        # powers of two: the scales change rarely, and scaling costs no accuracy
        speed = 2.0 ** np.ceil(np.log2(speed)) if 0 < speed < np.inf else 1.0
        for contact, part in zip(self.contacts, self._parts):
            contact.equations.set_scale(contact.unit(step), speed)
            if first:
                contact.start(self._free[part])
        return speed

    def _compliance(self, active: np.ndarray) -> np.ndarray:
        """W of the active points."""
        W = np.zeros((len(active), len(active)))
        bounds = np.searchsorted(active, [part.start for part in self._slices] + [np.inf])
        ours = [
            (solid, trace, slice(a, b), active[a:b] - part.start)
            for (solid, trace), part, a, b in zip(
                self._sides, self._slices, bounds[:-1], bounds[1:]
            )
        ]
        for solid, trace, rows, mine in ours:
            for other_solid, other, columns, theirs in ours:
                if other_solid is solid and len(mine) and len(theirs):
                    W[rows, columns] = trace.compliance(mine, other, theirs)
        return W

    def _solve(self, step: Step) -> Solution:
        try:
            active = self._system.arrange()
            self._system.begin(self._free[active], self._compliance(active))
            return self.newton.solve(
                self._system, lambda: [contact.speed_limit(step) for contact in self.contacts]
            )
        except NotConverged as failure:
            raise StepFailed(str(failure)) from None

    def _nonlinearity(self, step: Step, speed: float) -> float:
        """Largest relative error of what was linearised, in the trial state."""
        error = 0.0
        for solid in self.solids:
            if reason := solid.broken():
                raise StepFailed(reason)
            if not solid.linear:
                error = max(error, solid.imbalance(step))
        for contact in self.contacts:
            jump, gap, size = contact.error(step)
            error = max(error, jump / max(speed, size), gap / (max(speed, size) * step.span))
        return error

    def accept(self, trial: Trial) -> list[float]:
        """Make the trial state the state; returns the row of the history."""
        clock, step = _Clock(self.times), trial.step
        momentum, loads, supports, tractions = np.sum(
            [solid.works(step) for solid in self.solids], axis=0
        )
        mean = step.scheme.mean
        means = {id(solid): mean(solid.velocity, solid.trial_velocity) for solid in self.solids}
        for solid in self.solids:
            solid.accept()
        impact = friction = 0.0
        for contact, part in zip(self.contacts, self._parts):
            contact.accept(trial.force[part], step)
            normal, tangential = contact.work(means, step.span)
            impact, friction = impact + normal, friction + tangential
        old, self.energies = self.energies, self.sum_energies()
        change = sum(self.energies) - sum(old)
        # what the scheme makes: energies change otherwise than forces and momenta work
        scheme = change - momentum + loads - tractions
        self.work += (impact, friction, supports + tractions, scheme)
        self.balance += momentum - loads - impact - friction - supports
        self.time += step.dt
        row = self.row(step.dt, trial.newton, trial.geometry)
        clock("history")
        return row

    def sum_energies(self) -> tuple[float, float, float]:
        """Kinetic, strain and potential energy of all solids, J."""
        kinetic, strain, potential = zip(*(s.energies() for s in self.solids))
        return sum(kinetic), sum(strain), sum(potential)

    def row(self, dt: float = 0.0, newton: int = 0, geometry: int = 0) -> list[float]:
        """The row of the history that stands for the present state."""
        kinetic, strain, potential = self.energies
        row = [self.time, dt, kinetic, strain, potential, *self.work, self.balance]
        row += [newton, geometry]
        for contact in self.contacts:
            row += [*contact.force.sum(axis=0), *contact.counts(), contact.depth()]
        return row


def _slices(sizes: Iterable[int]) -> list[slice]:
    bounds = np.cumsum([0, *sizes])
    return [slice(a, b) for a, b in zip(bounds[:-1], bounds[1:])]


class _Clock:
    """Adds the time since the last call to a phase."""

    def __init__(self, times: dict[str, float]) -> None:
        self._times, self._last = times, perf_counter()

    def __call__(self, phase: str) -> None:
        now = perf_counter()
        self._times[phase] = self._times.get(phase, 0.0) + now - self._last
        self._last = now
