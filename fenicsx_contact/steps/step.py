# SPDX-License-Identifier: LGPL-3.0-or-later
"""One step of a scene: solved by a method, then accepted, and the energy books kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from math import inf

import numpy as np

from ..base.checks import StepFailed
from ..base.processes import Meeting
from ..base.vectors import largest
from ..contact.arrivals import arrives, missed
from ..contact.bounds import statuses
from ..contact.contact import Contact
from ..contact.percussion import approaching, strikes
from ..contact.pierced import Pierced
from ..contact.unmet import Unmet
from ..contact.work import counts, work
from ..solids import DeformableSolid, Solid, communicator
from ..solve.loop import GEOMETRY_TOLERANCE, StepSolver
from ..solve.newton import Newton
from ..solve.problem import Assembly, Clock
from ..theory.scheme import Step
from .alike import refuse_other_givens
from .certificate import ACCEPTED, Books, Certificate, certify
from .frames import Frames
from .hold import hold_gaps
from .insight import Insight
from .neighbours import Neighbours
from .trial import Trial

#: Velocities are off by so many times what Newton's method has left, at most: statuses of a
#: hyperstatic contact share an error out unevenly.
LOOSE = 10.0


class Stepper(Insight):
    """Takes the steps of a scene and keeps its books.

    Args:
        solids, contacts: of the scene.
        newton: settings of the Newton loop.
        geometry, solver: "newton", "fixed point", "mixed"; "condensed", "monolithic", "iterative".
        inertia, loose: that of the scheme, and without any solids that at most springs hold.

    Attributes:
        time: s; ``times``: seconds spent by phase.
        work: of impacts, friction, drives, damping and the scheme since the start, J; ``balance``,
            what they and the energies leave unexplained.
        watchers: called with each trial before it is accepted, to look; ``rounds``: solved again.
    """

    def __init__(
        self,
        solids: Sequence[Solid],
        contacts: Sequence[Contact],
        newton: Newton,
        geometry: str,
        solver: str,
        inertia: float,
        loose: Sequence[DeformableSolid],
    ) -> None:
        self.solids, self._every = list(solids), list(contacts)
        self._tolerance, self._inertia = newton.tolerance, inertia
        self._solver = partial(
            StepSolver, newton=newton, geometry=geometry, solver=solver, loose=list(loose)
        )
        self._comm = communicator(self.solids)
        self._meeting = Meeting(self._comm)
        self._neighbours = Neighbours(self._every)
        self._arrange()
        self._linear = not any(s.shiftable for s in solids)
        pairs = [c.coupling for c in self.contacts if len(c.solids) > 1]
        self._paired = bool(pairs)
        # above which errors a step is solved again about where solids were put back
        self._again = GEOMETRY_TOLERANCE if any(p.by_means for p in pairs) else ACCEPTED
        self.times: dict[str, float] = {}
        self.time, self.balance, self.work = 0.0, 0.0, np.zeros(5)
        self.energies = self.sum_energies()
        self._frames = Frames(self.solids, self._every)
        self.watchers: list[Callable[[Trial], None]] = []
        self.rounds: list[Callable[[Trial], None]] = []
        self._begun: Step | None = None
        self.pierced, self.unmet = Pierced(self._every), Unmet(self._every)
        # the largest force at a point so far, N, and what rounds the works, J, see Books
        self._pushed, self.rounding = 0.0, (0.0, 0.0)
        # contacts may have stored energy before the start, of which the books do not know
        inside = any(min(c.depth(), c.gap.max()) > c.tolerance for c in self.contacts)
        self._charged = inside or any(c.candidates.anywhere for c in self.contacts)

    def _arrange(self) -> None:
        """Let steps be about the contacts that are awake."""
        self.contacts = [c for c, awake in zip(self._every, self._neighbours.awake) if awake]
        self._assembly = Assembly(self.solids, self.contacts)
        self._method = self._solver(self._assembly)

    def attempt(
        self, step: Step, closing: bool = True, rates: Sequence[np.ndarray] | None = None
    ) -> Trial:
        """Solve a step from the present state.

        Args:
            step: its length and scheme.
            closing: whether points that are open now may close.
            rates: accelerations of the solids, m/s², by which geometry is guessed, if they are
                known from a step like it; they spare linearisations.

        Raises:
            StepFailed: with the reason; the state is as before.
        """
        while True:
            trial = self._attempt(step, closing, rates)
            if not self._neighbours.met():
                return trial
            self._begun = None

    def _attempt(self, step: Step, closing: bool, rates: Sequence[np.ndarray] | None) -> Trial:
        clock = Clock(self.times)
        self._meeting.after(lambda: self._begin(step))
        self._begun = None  # the prediction is left
        before = [(contact.equations.values, contact.moved) for contact in self.contacts]
        try:
            return self._meeting.after(lambda: self._sound(step, closing, rates, clock))
        except BaseException:  # an interrupt, too
            for contact, was in zip(self.contacts, before):
                contact.equations.values, contact.moved = was
            raise

    def _sound(
        self, step: Step, closing: bool, rates: Sequence[np.ndarray] | None, clock: Clock
    ) -> Trial:
        """The begun step solved, about where solids are put back, too, and certified."""
        for contact in self.contacts:
            contact.predict(step, closing)
        refuse_other_givens(self._comm, self.solids, self.contacts)
        if rates is not None:
            self._guess(step, rates)
        clock("pairing")
        trial, moved = self._solved(step, closing, clock)
        # a flight beyond an arrival errs by the impact that it missed
        moved = moved and (closing or self._paired or not any(map(arrives, self.contacts)))
        while moved and trial.errors.worst > self._again:  # as long as it gains
            tried, last = trial, trial.errors
            for look in self.rounds:
                look(tried)
            try:
                trial, moved = self._solved(step, closing, clock)
            except StepFailed as failure:
                raise StepFailed(last.refusal or str(failure)) from failure
            trial = tried.then(trial)
            moved = moved and trial.errors.worst < last.worst
        if refusal := trial.errors.refusal:
            raise StepFailed(refusal)
        return trial

    def _solved(self, step: Step, closing: bool, clock: Clock) -> tuple[Trial, bool]:
        """The step solved about where solids are put; whether they are put elsewhere after it."""
        solution = self._method.solve(step, clock, self._meeting.after)
        for contact in self.contacts:
            contact.equations.turn(False)  # rows of a search are none to be judged by
            contact.trial_status = statuses(contact)
        moved = not self._linear and hold_gaps(self.contacts, step, self.resolution)
        for solid in self.solids:
            if reason := solid.unsound(step):
                raise StepFailed(reason)
        for contact in self.contacts:
            if reason := missed(contact, step, closing):
                raise StepFailed(reason)
        return Trial(step, *solution, self._certify(step)), moved

    @property
    def takes(self) -> bool:
        """Whether contacts are to take energy, and solids have any that is known."""
        nothing = all(contact.gives_nothing for contact in self.contacts)
        return nothing and bool(self._inertia) and not self._charged

    def _certify(self, step: Step) -> Certificate:
        energy = self._frames.energy(self.energies) + abs(self.work[2]) if self.takes else inf
        books = Books(self.work[:2].sum() + min(self.work[4], 0.0), energy, *self.rounding)
        return certify(self._assembly, step, books, self._pushed)

    def struck(self, step: Step, touching: bool = False) -> bool:
        """Whether a velocity law is violated at the start of a step to be crossed from the present
        state: a percussion is due. Only points that touch are asked if ``touching``; the others
        are watched otherwise."""
        if not (step.scheme.inertia and any(c.formulation.percussive for c in self._every)):
            return False
        return self._meeting.after(lambda: self._comes(step, touching))

    def _comes(self, step: Step, touching: bool) -> bool:
        # what touches is asked as a percussion would stop it: where it is, not where it slides to
        self._begin(replace(step, dt=0.0, ahead=step.horizon) if touching else step)
        percussive = [c for c in self.contacts if c.formulation.percussive]  # some woke up
        asked = [(contact, *approaching(contact, step, touching)) for contact in percussive]
        asked = [(c, comes, points) for c, comes, points in asked if points.any()]
        if not asked:
            return False
        self._begin(step)
        for solid in self.solids:
            solid.linearise(step)
        return any(strikes(c, step, comes, points, ACCEPTED) for c, comes, points in asked)

    def _begin(self, step: Step) -> None:
        """Predict the solids, and take up what is given in the step, if not done yet."""
        if step is self._begun:
            return
        if self._neighbours.look(step, bool(self.watchers)):  # who see all contacts
            self._arrange()
        for solid in self.solids:
            solid.patient = self._method.patient  # whatever other scenes it is in
            solid.predict(step)
        for contact in self.contacts:  # which asks obstacles where they are
            self._meeting.after(partial(contact.begin, step))
        self._begun = step

    def _guess(self, step: Step, rates: Sequence[np.ndarray]) -> None:
        for solid, rate in zip(self.solids, rates):
            if not solid.linear:
                solid.go(solid.velocity + step.dt * rate, step)
        for contact in self.contacts:
            contact.follow()

    def mean_accelerations(self, step: Step) -> list[np.ndarray]:
        """Of the solids in a step that was attempted last, m/s²."""
        return [(solid.trial_velocity - solid.velocity) / step.dt for solid in self.solids]

    def accept(self, trial: Trial) -> list[float]:
        """Make the trial state the state; returns the row of the history."""
        for watch in self.watchers:
            watch(trial)
        clock, step, self.rounding = Clock(self.times), trial.step, trial.errors.rounding
        momentum, loads, supports, tractions = map(sum, zip(*(s.works(step) for s in self.solids)))
        damped = sum(solid.damped(step) for solid in self.solids)
        means = {id(solid): solid.mean_velocity(step) for solid in self.solids}
        for solid in self.solids:
            solid.accept(step)
        impact = friction = driven = 0.0
        for contact, part in zip(self.contacts, self._assembly.parts):
            contact.accept(trial.force[part], step, self.resolution)
            if step.dt:
                self._pushed = max(self._pushed, largest(contact.force))
            normal, tangential, moved = work(contact, means, step)
            impact, friction, driven = impact + normal, friction + tangential, driven + moved
        old, self.energies = self.energies, self.sum_energies()
        change = sum(self.energies) - sum(old)
        # what the scheme makes: energies change otherwise than forces and momenta work
        scheme = change - momentum + loads - tractions - damped
        self.work += (impact, friction, supports + tractions + driven, damped, scheme)
        self.balance += momentum - loads - impact - friction - supports - driven
        self.time += step.dt
        self.pierced.see(self.time)
        self._neighbours.accept()
        row = self.row(step.dt, trial.newton, trial.geometry, trial.certificate)
        clock("history")
        return row

    @property
    def resolution(self) -> float:
        """Errors of velocities, m/s, with which Newton's method may end the step attempted last."""
        return LOOSE * max(self._tolerance, self._method.reached) * self._method.speed

    @property
    def unresolved(self) -> float:
        """The same, as far as they are known."""
        return LOOSE * self._method.left or self.resolution

    def state(self) -> dict[str, np.ndarray]:
        """What a run continues from, beside the solids and contacts."""
        numbers = {"time": self.time, "balance": self.balance, "most": self._frames.most}
        arrays = {name: np.array(each) for name, each in numbers.items()}
        arrays["rounding"] = np.array(self.rounding)
        return {"work": self.work, **arrays, **self._neighbours.state()}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Take up a state that :meth:`state` gave; solids and contacts have been restored."""
        self.time, self.balance = float(state["time"]), float(state["balance"])
        self._frames.most, self.work = float(state["most"]), np.array(state["work"])
        self.rounding = tuple(state["rounding"].tolist())
        if self._neighbours.restore(state):
            self._arrange()
        self._begun, self.energies = None, self.sum_energies()

    def sum_energies(self) -> tuple[float, float, float]:
        """Kinetic, strain and potential energy of all solids, J."""
        kinetic, strain, potential = zip(*(s.energies() for s in self.solids))
        return self._inertia * sum(kinetic), sum(strain), sum(potential)

    def row(
        self, dt: float = 0.0, newton: int = 0, geometry: int = 0, certificate: float = 0.0
    ) -> list[float]:
        """The row of the history that stands for the present state."""
        books = *self.energies, *self.work, self.balance
        row = [self.time, dt, *books, certificate, newton, geometry]
        for contact in self._every:
            row += [*contact.borne.sum(axis=0), *counts(contact), contact.depth()]
        return row
