# SPDX-License-Identifier: LGPL-3.0-or-later
"""How a step is crossed: impacts at its start, or located within it.

A velocity law stops what it catches. A point that starts a step faster than its law allows is
struck: velocities jump, in a step of no length, ``M (v+ - v-) = J' P``, for all points at once that
would pass their obstacles by the end of the step. The step then is smooth. So an impact costs the
same energy whatever the step, no point is left penetrated that would be taken for an approach
later, and points that bear next to each other share one impact.

By uniform steps the instant of an impact is rounded to the start of a step: first order. What
rebounds is struck in the order in which it would arrive: a point that others have thrown back
before it arrives does not rebound.

Located impacts are of second order: cross the step as if no open point could close; if one arrives,
find when, step exactly there, and let it be struck.

An obstacle whose velocity jumps within a step strikes what it touches, too: where anything
rebounds, a step is crossed in parts that end where that is.

However many impacts there are in a step, each has its own; only those points that come to rest by
impacts without end within it are put to rest, see :mod:`~..contact.blows`; at once where a way out
and back rises by less than round-off of places, of which flights and impacts give each other energy
for ever.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from math import inf, nan, sqrt

import numpy as np

from ..base.checks import StepFailed
from ..base.constants import BRIEF, RIGHT, SAME
from ..contact.arrivals import Arrival, arrival
from ..contact.leaps import no_velocity
from ..contact.percussion import first_arrival, rebounding, until_sudden
from ..theory.scheme import Scheme, Step
from ..theory.theta import ThetaScheme
from .certificate import ACCEPTED
from .taker import StepTaker
from .trial import Trial

#: Flights until an arrival is found, at most: the bracket may be halved to round-off; and parts of
#: a step after which what is swift and touches stays.
MAX_FLIGHTS = 50

#: What a reader should know of a wall that starts suddenly, by a scheme whose ends are means.
TAKEN_ALONG = (
    "an obstacle's velocity jumps: what it reaches is taken along and does not rebound, for which "
    "take theta = 1/2"
)

#: A flight: its trial state, and the deepest point there.
Flight = tuple[Trial, Arrival]


class Impacts(ABC):
    """Crosses steps with their impacts.

    Args:
        scheme: of the scene.
    """

    def __init__(self, scheme: Scheme) -> None:
        self._scheme = scheme

    def cross(self, stepper: StepTaker, dt: float, remarks: list[str]) -> Iterator[list[float]]:
        """Cross ``dt`` seconds; yields a row of the history after each part and impact.

        Raises:
            StepFailed: the state is then that of the last good part.
        """
        for contact in stepper.contacts:
            contact.blows.forget()
        left = dt
        while left > 0:
            step = Step(left, self._scheme, stepper.time)
            part = until_sudden(stepper.contacts, step)
            if part < left and step.implicitness and rebounding(stepper.contacts):
                remarks.append(TAKEN_ALONG)  # its velocities are means, in which none jumps
            yield from self._cross(stepper, part, remarks)
            left -= part

    @abstractmethod
    def _cross(self, stepper: StepTaker, dt: float, remarks: list[str]) -> Iterator[list[float]]:
        """Cross a step in which no obstacle's velocity jumps."""


class UniformImpacts(Impacts):
    """With impacts at the start of each step."""

    def _cross(self, stepper: StepTaker, dt: float, remarks: list[str]) -> Iterator[list[float]]:
        step = Step(dt, self._scheme, stepper.time)
        order = True
        while order and stepper.struck(step):  # which wakes contacts
            order = rebounding(stepper.contacts)
            within = first_arrival(stepper.contacts, step) if order else inf
            strike = Step(0.0, self._scheme, stepper.time, dt, within)
            yield _strike(stepper, strike, 0.0, remarks)
        trial = stepper.attempt(step)
        remarks.extend(trial.remarks)
        yield stepper.accept(trial)

    def state(self) -> dict[str, np.ndarray]:
        """The arrays from which :meth:`restore` continues identically: none."""
        return {}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Take up a state that :meth:`state` gave."""


def _strike(
    stepper: StepTaker, step: Step, left: float, remarks: list[str], closing: bool = True
) -> list[float]:
    """A percussion, with ``left`` seconds of the step to go."""
    struck = [contact for contact in stepper.contacts if contact.formulation.percussive]
    trial, rests = None, True
    while rests or trial is None:
        trial, rests = stepper.attempt(step, closing), False
        for contact in struck:
            some, unending = contact.blows.settle(contact, left, ACCEPTED)
            rests |= some
            remark = f"contact {contact.name!r}: impacts that go on without end are cut short"
            if unending and remark not in remarks:
                remarks.append(remark)
    remarks.extend(trial.remarks)
    for contact in struck:
        contact.blows.note(contact)
    return stepper.accept(trial)


class LocatedImpacts(Impacts):
    """From impact to impact."""

    def __init__(self, scheme: Scheme) -> None:
        super().__init__(scheme)
        self._rates: list[np.ndarray] | None = None  # accelerations in the last flight, m/s²

    def _cross(self, stepper: StepTaker, dt: float, remarks: list[str]) -> Iterator[list[float]]:
        left, solids = dt, [solid for contact in stepper.contacts for solid in contact.solids]
        brief = RIGHT * dt * any(getattr(solid, "swift", False) for solid in solids)
        tolerance = min((contact.tolerance for contact in stepper.contacts), default=0.0)
        parts = 0
        while left > SAME * dt:
            while stepper.struck(Step(left, self._scheme, stepper.time, dt), touching=True):
                yield self._strike(stepper, dt, left, remarks)
            flight = self._fly(stepper, left, dt)
            for contact in stepper.contacts:
                contact.blows.fly(contact, left)
            arrives = flight[1].gap > tolerance  # what is nearer touches, and may strike at once
            fly = partial(self._fly, stepper, whole=dt)
            noise = max((contact.noise for contact in stepper.contacts), default=0.0)
            trial = _arrive(fly, flight, tolerance, noise, brief) if arrives else flight[0]
            rests = arrives and trial.step.dt <= BRIEF * dt and flight[1].unseen(trial.step.dt)
            if rests:
                length, trial = trial.step.dt, self._rest(stepper, trial.step.dt, dt)
                if not flight[1].stopped():
                    rests, trial = False, replace(fly(length)[0], arrives=True)
            remarks.extend(trial.remarks)
            left -= trial.step.dt
            yield stepper.accept(trial)
            parts += 1
            # of what is swift what came at once, or that often, stays: it would come for ever
            if brief and (trial.step.dt <= brief or parts > MAX_FLIGHTS):
                for contact in stepper.contacts:
                    contact.blows.settled |= contact.gap >= -contact.tolerance
            if arrives and not rests:
                yield self._strike(stepper, dt, left, remarks)

    def _rest(self, stepper: StepTaker, length: float, whole: float) -> Trial:
        """So short a part of the whole step that nothing moves in it, but loads stop what they
        push back: by theta = 1, at whose end what is put to rest has no speed."""
        self._rates = None
        step = Step(length, ThetaScheme(1.0), stepper.time, whole)
        return stepper.attempt(step, closing=False)

    def _strike(
        self, stepper: StepTaker, dt: float, left: float, remarks: list[str]
    ) -> list[float]:
        self._rates = None
        # what is still open, however near, has an instant of its own
        step = Step(0.0, self._scheme, stepper.time, dt)
        return _strike(stepper, step, left, remarks, closing=False)

    def _fly(self, stepper: StepTaker, length: float, whole: float) -> Flight:
        """A part of the whole step as if no open point could close."""
        step = Step(length, self._scheme, stepper.time, whole)
        rates, self._rates = self._rates, None  # not those of a step that fails
        trial = stepper.attempt(step, closing=False, rates=rates)
        self._rates = stepper.mean_accelerations(step)
        arrivals = (arrival(contact) for contact in stepper.contacts)
        return trial, max(arrivals, key=lambda each: each[:4], default=Arrival())

    def state(self) -> dict[str, np.ndarray]:
        """The arrays from which :meth:`restore` continues identically."""
        return {f"rate.{i}": rate for i, rate in enumerate(self._rates or [])}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Take up a state that :meth:`state` gave."""
        self._rates = [np.array(state[f"rate.{i}"]) for i in range(len(state))] or None


def _arrive(
    fly: Callable[[float], Flight], flight: Flight, tolerance: float, noise: float, brief: float
) -> Trial:
    """The step to the instant at which the first point arrives, from a flight beyond it.

    The gap is nearly a parabola in the length of the step. It is followed to where it rises: first
    the one through the gaps at the start and at the end with the rate at the start, then those
    through the last three gaps; where this leaves the bracket, which it does not in smooth motion,
    the bracket is halved, down to what the clock tells, or to what is ``brief`` in the step, s,
    where solids are swift: when contact begins or ends they are at once elsewhere, and the shorter
    the flight the faster. What touches at the start leaves, having rebounded, and arrives when it
    is back where it was. Gaps of points far from the origin are known to ``noise``, m.

    Raises:
        StepFailed: the gap jumps, or the point lies beside what it was to meet.
    """
    trial, deepest = flight
    whole, clock = trial.step.dt, trial.step.start
    inside = max(deepest.start, 0.0)  # by less than what counts as arrived
    start, gap, came = deepest.start - inside, deepest.gap - inside, deepest.came
    points = [(0.0, start), (whole, gap)]
    new = _rise(start, came, (gap - start - came * whole) / whole**2)
    low, high = 0.0, whole
    for _ in range(MAX_FLIGHTS):
        new = max(new, brief)  # NaN stays
        if not clock + low < clock + new < clock + high:
            new = 0.5 * (low + high)
        if high - low <= brief or not clock + low < clock + new < clock + high:
            trial, found = fly(high)
            instant = high - low + 2 * float(np.spacing(clock + high))
            if found.gap - inside - abs(found.rate) * instant > tolerance + noise:
                raise no_velocity("what a point meets", found.gap, clock + low)
            break
        trial, found = fly(new)
        gap = found.gap - inside
        low, high = (new, high) if gap < 0 else (low, new)
        if abs(found.gap) <= tolerance:
            break
        (a, gap_a), (b, gap_b) = points[-2:]
        points.append((new, gap))
        slope = (gap - gap_b) / (new - b)
        bend = (slope - (gap_b - gap_a) / (b - a)) / (new - a)
        new += _rise(gap, slope + bend * (new - b), bend)
    if found.beside:
        raise StepFailed("what a corner or an edge was to meet it passes by")
    return replace(trial, arrives=True)


def _rise(value: float, slope: float, bend: float) -> float:
    """How far from here a parabola rises through 0, or its lowest point if it stays above; NaN if
    it never does."""
    root = sqrt(max(slope**2 - 4 * bend * value, 0.0))
    if slope > 0:
        return -2 * value / (slope + root)
    return (root - slope) / (2 * bend) if bend > 0 else nan
