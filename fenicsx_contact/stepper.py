# SPDX-License-Identifier: LGPL-3.0-or-later
"""One step of a scene: prediction, linearisations with a surface problem each, acceptance.

The loop over linearisations is the paper's geometric fixed point and, for hyperelastic solids,
Newton's method for their momentum balance. A scene of linear solids passes it once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from .checks import StepFailed
from .contact import Contact
from .newton import Newton, NotConverged, Solution
from .solids import Solid
from .system import SLOW, SurfaceSystem
from .theta import Step

#: Relative error of the linearised operator, gaps and momentum at which the loop ends.
GEOMETRY_TOLERANCE = 1e-8
MAX_GEOMETRY = 25
#: It ends as well where it falls no more and is below this: the round-off of an ill-conditioned
#: solve, which shorter steps would not better.
ROUGH = 1e-6


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
        work: impact, friction and scheme work since the start, J; ``balance``, what they and the
            energies leave unexplained.
        times: seconds spent by phase.
    """

    def __init__(
        self, solids: Sequence[Solid], contacts: Sequence[Contact], newton: Newton
    ) -> None:
        self.solids, self.contacts, self.newton = list(solids), list(contacts), newton
        bounds = np.cumsum([0, *(c.equations.jumps for c in self.contacts)])
        self._slices = [slice(a, b) for a, b in zip(bounds[:-1], bounds[1:])]
        self._compliance = np.zeros((bounds[-1], bounds[-1]))
        self._system = SurfaceSystem(
            [contact.equations for contact in self.contacts],
            [contact.name for contact in self.contacts],
        )
        self.times: dict[str, float] = {}
        self.time = 0.0
        self.work, self.balance = np.zeros(3), 0.0
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
        iterations, remarks, last = 0, [], np.inf
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
            for contact, part in zip(self.contacts, self._slices):
                contact.trace.spread(solution.force[part])
            for solid in self.solids:
                solid.correct(step)
            clock("solids")
            error = self._nonlinearity(step, speed, solution.force)
            clock("pairing")
            if error <= GEOMETRY_TOLERANCE or last <= error <= ROUGH:
                return Trial(step, solution.force, iterations, sweep, remarks)
            last = error
        raise StepFailed(
            f"the geometric fixed point stalls at a relative error of {error:.3g} after "
            f"{sweep} linearisations"
        )

    def _linearise(self, step: Step, first: bool) -> float:
        """Jumps without contact, compliance and scales; returns a typical speed."""
        W = self._compliance
        for contact in self.contacts:
            contact.linearise(step)
        self._free = []
        speed = 0.0
        for contact, a in zip(self.contacts, self._slices):
            for other, b in zip(self.contacts, self._slices):
                if other.solid is contact.solid:
                    W[a, b] = contact.trace.compliance(other.trace)
            free = contact.trace.free_jump()
            self._free.append(free)
            active = contact.equations.active_jumps
            fall = float(np.abs(free[active]).max(initial=0.0))
            speed = max(speed, fall, SLOW * self._push(a, contact.force))
        # powers of two: the scales change rarely, and scaling costs no accuracy
        speed = 2.0 ** np.ceil(np.log2(speed)) if 0 < speed < np.inf else 1.0
        for contact, free, a in zip(self.contacts, self._free, self._slices):
            contact.equations.set_scale(contact.unit(W[a, a], step), speed)
            if first:
                contact.equations.start(contact.jump.ravel(), free)
        return speed

    def _push(self, part: slice, force: np.ndarray) -> float:
        """The speed that the forces on a contact's points would give to one alone, m/s."""
        softest = self._compliance[part, part].diagonal().max(initial=0.0)
        return float(np.abs(force).max(initial=0.0) * softest)

    def _solve(self, step: Step) -> Solution:
        try:
            self._system.begin(self._free, self._compliance)
            return self.newton.solve(
                self._system, lambda: [contact.speed_limit(step) for contact in self.contacts]
            )
        except NotConverged as failure:
            raise StepFailed(str(failure)) from None

    def _nonlinearity(self, step: Step, speed: float, force: np.ndarray) -> float:
        """Largest relative error of what was linearised, in the trial state."""
        error = 0.0
        for solid in self.solids:
            if reason := solid.broken():
                raise StepFailed(reason)
            if not solid.linear:
                error = max(error, solid.imbalance(step))
        for contact, part in zip(self.contacts, self._slices):
            jump, gap, size = contact.error(step)
            size = max(speed, size, SLOW * self._push(part, force[part]))
            error = max(error, jump / size, gap / (size * step.span))
        return error

    def accept(self, trial: Trial) -> list[float]:
        """Make the trial state the state; returns the row of the history."""
        clock, step = _Clock(self.times), trial.step
        momentum, loads = np.sum([solid.works(step) for solid in self.solids], axis=0)
        means = {id(solid): 0.5 * (solid.velocity + solid.trial_velocity) for solid in self.solids}
        for solid in self.solids:
            solid.accept()
        impact = friction = 0.0
        for contact, part in zip(self.contacts, self._slices):
            contact.accept(trial.force[part], step)
            normal, tangential = contact.work(means[id(contact.solid)], step.span)
            impact, friction = impact + normal, friction + tangential
        old, self.energies = self.energies, self.sum_energies()
        change = sum(self.energies) - sum(old)
        # what the scheme makes: energies change otherwise than forces and momenta work
        self.work += (impact, friction, change - momentum + loads)
        self.balance += momentum - loads - impact - friction
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


class _Clock:
    """Adds the time since the last call to a phase."""

    def __init__(self, times: dict[str, float]) -> None:
        self._times, self._last = times, perf_counter()

    def __call__(self, phase: str) -> None:
        now = perf_counter()
        self._times[phase] = self._times.get(phase, 0.0) + now - self._last
        self._last = now
