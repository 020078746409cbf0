# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Step sizes controlled by an estimate of the error.

The theta-scheme with theta = 1/2 moves a solid by dt (v- + v+)/2, which differs from the exact
motion by dt³/12 times the jerk a'. The mean acceleration of a step, (v+ - v-)/dt, is that of its
middle; two of them give the jerk, and the error that a step adds for each metre of the way is

    e = dt²/12 |a - a_ref| / |t - t_ref| / |v|,

with |.| the root mean square over the mass of a solid, of all solids the largest. Up to a factor
this is the distance to an Adams-Bashforth predictor (P.M. Gresho, R.L. Lee, R.L. Sani, "On the
time-dependent solution of the incompressible Navier-Stokes equations in two and three dimensions",
Recent Advances in Numerical Methods in Fluids 1, 27-79, 1980), and costs no solve. The reference is
the last step; where there is none, at the start and after an impact, half of the step is tried.
|v| is the largest speed since then: the turning point of a swing or a wave is not resolved more
finely than the rest of it. None of this knows units or meshes.

Steps are halved and doubled; e, of second order, falls and grows fourfold.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil, floor, log2, sqrt

import numpy as np

from ..base import checks
from ..base.checks import StepFailed
from ..contact.arrivals import depth, short, struck
from ..contact.contact import Contact
from ..solve.problem import Clock
from ..theory.scheme import Scheme, Step
from .pace import Pace
from .step import Stepper
from .trial import Trial

#: Cost: share of the allowed error that a step aims at when its length is changed.
SAFETY = 0.8
#: A part that would be shorter than this share of its usual length is one with the next.
AHEAD = 0.25

#: Accelerations of the solids, m/s², and the time at which they are, s.
Mean = tuple[list[np.ndarray], float]


class StepTooLong(StepFailed):
    """A step with too large an error; ``length``, s, would be right."""

    def __init__(self, message: str, length: float) -> None:
        super().__init__(message)
        self.length = length


class ErrorControl:
    """A stepper that refuses steps with too large an error.

    In a step in which a point strikes velocities jump, whatever its length; such a step is short
    enough if the way in it is the allowed share of the whole way so far, and so is the depth at
    which a point arrives. With impacts located this happens in steps of no length.

    Args:
        stepper: solves and accepts the steps.
        scheme: of the scene.
        error: what a step may add to the error, relative to the way in it.

    Attributes:
        length: the longest step, s, that the last estimate allows.
        least: length of a step, s, that is not refused whatever its error; a remark says so.

    Raises:
        InputError: no positive error, or a scheme that is not of second order.
    """

    def __init__(self, stepper: Stepper, scheme: Scheme, error: float) -> None:
        self.error = checks.number("step_error", error, above=0, at_most=1)
        if not scheme.inertia:
            raise checks.InputError(
                f"step_error = {error!r}: without inertia time only orders the loads; there is no "
                "error in time to control"
            )
        if scheme.error_constant is None:
            raise checks.InputError(
                f"step_error = {error!r}: the estimate is that of a scheme of second order, such "
                f"as theta = 0.5 with forces at 'theta', not of {scheme.describe()}"
            )
        self._constant = scheme.error_constant
        self._stepper, self.solids, self.least = stepper, stepper.solids, 0.0
        self._tolerance = max((c.tolerance for c in stepper.contacts), default=0.0)
        self.length = np.inf
        self._last: Mean | None = None
        self._jumped = False
        self._coarse = False
        self._judged = 0.0  # the longest step from the present state that was not refused
        self._arc = self._top = self._size(self._of("velocity"))
        self._way = 0.0  # since the start, m

    @property
    def contacts(self) -> Sequence[Contact]:
        """Of the scene."""
        return self._stepper.contacts

    @property
    def time(self) -> float:
        """The present time, s."""
        return self._stepper.time

    def mean_accelerations(self, step: Step) -> list[np.ndarray]:
        """Of the solids in a step that was attempted last, m/s²."""
        return self._stepper.mean_accelerations(step)

    def struck(self, step: Step, touching: bool = False) -> bool:
        """Whether a percussion is due, as :meth:`Stepper.struck` says."""
        return self._stepper.struck(step, touching)

    def attempt(
        self, step: Step, closing: bool = True, rates: Sequence[np.ndarray] | None = None
    ) -> Trial:
        """Solve a step, as :meth:`Stepper.attempt` does.

        Raises:
            StepTooLong: its error is too large.
            StepFailed: with the reason.
        """
        self._jumped = False
        if not step.dt:
            trial = self._stepper.attempt(step, closing, rates)
            self._judge_impact(step)
            return trial
        if step.dt <= self._judged:  # on the way of a step that was judged
            return self._stepper.attempt(step, closing, rates)
        reference = self._last
        if reference is None:
            half = Step(step.dt / 2, step.scheme, step.start)
            self._stepper.attempt(half, closing, rates)
            reference = self._mean(half)
        trial = self._stepper.attempt(step, closing, reference[0])
        clock = Clock(self._stepper.times)
        speed = self._fastest(step)
        error = self._estimate(step, reference) / speed
        clock("error")
        length = step.dt * sqrt(SAFETY * self.error / error) if error else np.inf
        if error <= self.error:
            self.length = length
        else:
            self._jumped = any(struck(c, self.error * speed) for c in self.contacts)
        # a located impact is not rounded, another one to a share of the way
        reason = self._refuse(error, speed * step.dt if closing else 0.0)
        if reason and step.dt > self.least:
            raise StepTooLong(reason, min(length, step.dt / 2))
        if reason and not self._coarse:  # once for the steps that follow each other
            trial.remarks.append(f"shortest step: {reason}")
        self._coarse, self._judged = bool(reason), step.dt
        return trial

    def _judge_impact(self, step: Step) -> None:
        """Refuse an impact that is rounded to a start too early: the step after it is too long."""
        speed = self._size(self._of("velocity"))
        allowed = self.error * (self._way + speed * step.ahead)
        far = max((short(contact) for contact in self.contacts), default=0.0)
        if far > allowed and step.ahead > self.least:
            reason = f"a point is struck {far:.2g} m before it arrives, above {allowed:.2g} m"
            raise StepTooLong(reason, step.ahead / 2)

    def _refuse(self, error: float, way: float) -> str:
        """Why the trial state has too large an error, or nothing; ``way``: of the step, m."""
        allowed = self.error * (self._way + way)
        if way:
            deepest = max((depth(contact) for contact in self.contacts), default=0.0)
            if deepest > allowed:
                return f"a point arrives {deepest:.2g} m deep, above {allowed:.2g} m"
        if error <= self.error or (self._jumped and way <= allowed):
            return ""
        return f"error {error:.2g}, above {self.error:g}"

    def accept(self, trial: Trial) -> list[float]:
        """Make the trial state the state; returns the row of the history."""
        smooth = trial.step.dt > 0 and not self._jumped
        self._last = self._mean(trial.step) if smooth else None
        row = self._stepper.accept(trial)
        self._judged = 0.0
        speed = self._size(self._of("velocity"))
        self._way += speed * trial.step.dt
        self._arc = max(self._arc, speed) if smooth else speed
        self._top = max(self._top, speed)
        return row

    def _of(self, what: str) -> list[np.ndarray]:
        return [getattr(solid, what) for solid in self.solids]

    def _mean(self, step: Step) -> Mean:
        """Mean accelerations of the solids in the trial state, m/s², and the time of them, s."""
        return self.mean_accelerations(step), step.start + step.dt / 2

    def _size(self, values: Sequence[np.ndarray]) -> float:
        return max(solid.root_mean_square(v) for solid, v in zip(self.solids, values))

    def _estimate(self, step: Step, reference: Mean) -> float:
        """The error of the way in the trial state, over the length of the step, m/s."""
        (accelerations, time), (others, other_time) = self._mean(step), reference
        change = self._size([a - b for a, b in zip(accelerations, others)])
        # of this step and of a reference half as long
        noise = 3 * self._stepper.resolution / step.dt
        return self._constant * step.dt**2 * max(change - noise, 0.0) / (time - other_time)

    def _fastest(self, step: Step) -> float:
        """The largest speed since the last impact, m/s."""
        # what is slower than a share ``error`` of the fastest so far, or moves by less than gaps
        # are told apart, is at rest
        rest = max(self.error * self._top, self._tolerance / step.dt)
        speed = max(self._size(self._of("trial_velocity")), self._arc, rest)
        return speed or 1.0  # nothing moves, nor does it err

    def state(self) -> dict[str, np.ndarray]:
        """The arrays from which :meth:`restore` continues identically."""
        state = {"speeds": np.array([self._arc, self._top, self._way, self.length])}
        if self._last is not None:
            state["time"] = np.array(self._last[1])
            state |= {f"acceleration.{i}": a for i, a in enumerate(self._last[0])}
        return state

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Take up a state that :meth:`state` gave."""
        self._arc, self._top, self._way, self.length = map(float, state["speeds"])
        if "time" in state:
            means = [np.array(state[f"acceleration.{i}"]) for i in range(len(self.solids))]
            self._last = means, float(state["time"])


class AdaptivePace(Pace):
    """Parts as long as the error allows, kept from one step of the grid to the next.

    An impact within a step of the grid leaves the multiples of the parts; the next part goes back
    to them.
    """

    stepper: ErrorControl

    def __init__(self, control: ErrorControl, dt: float, shortest: float) -> None:
        super().__init__(control, dt, shortest)
        control.least = (1 + AHEAD) * shortest * dt

    def begin(self, done: float) -> None:
        """A step of the grid begins, or goes on from ``done``."""

    def end(self, done: float) -> float:
        return min(1.0, self._part * ceil(done / self._part + AHEAD))

    def shorten(self, tried: float, failure: StepFailed) -> bool:
        wanted = tried / 2
        if isinstance(failure, StepTooLong):
            wanted = max(min(wanted, failure.length / self.dt), self.shortest)
        self._part = 2.0 ** floor(log2(wanted))
        return wanted >= self.shortest

    def lengthen(self, done: float) -> None:
        longer = 2 * self._part
        allowed = longer <= 1.0 and longer * self.dt <= self.stepper.length
        if allowed and (done / longer).is_integer():
            self._part = longer

    def state(self) -> dict[str, np.ndarray]:
        own = {"run.part": np.array(self._part)}
        return own | {f"run.error.{key}": value for key, value in self.stepper.state().items()}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        self._part = float(state["run.part"])
        prefix = "run.error."
        own = {k.removeprefix(prefix): v for k, v in state.items() if k.startswith(prefix)}
        self.stepper.restore(own)
