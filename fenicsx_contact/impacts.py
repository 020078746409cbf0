# SPDX-License-Identifier: LGPL-3.0-or-later
"""Impacts located within a step.

Between impacts the motion is smooth and the theta-scheme with theta = 1/2 follows it at second
order. What costs accuracy is the instant of an impact, which a uniform step rounds to its end. So:
cross the step as if no open point could close; if one arrives, find when, step exactly there, let
the impact happen as a step of no length, ``M (v+ - v-) = J' P``, and go on with what is left.
"""

from __future__ import annotations

from collections.abc import Iterator

from scipy.optimize import brentq

from .stepper import Stepper
from .theta import Step, ThetaScheme

#: A body comes to rest by infinitely many impacts; after so many in one step the rest of the step
#: is crossed by the plain scheme.
MAX_IMPACTS = 8


def cross_impacts(
    stepper: Stepper, scheme: ThetaScheme, dt: float, remarks: list[str]
) -> Iterator[list[float]]:
    """Cross ``dt`` seconds; yields a row of the history after each part of the step and impact.

    Raises:
        StepFailed: the state is then that of the last good part.
    """
    left = dt

    def take(length: float, closing: bool) -> list[float]:
        trial = stepper.attempt(Step(length, scheme), closing)
        remarks.extend(trial.remarks)
        return stepper.accept(trial)

    def arrival(share: float) -> float:
        """Depth of the open points after a share of what is left, m; negative: still above."""
        if share > 0:
            stepper.attempt(Step(share * left, scheme), closing=False)
        return max(contact.arrival(moved=share > 0) for contact in stepper.contacts)

    for _ in range(MAX_IMPACTS):
        if not stepper.contacts or arrival(1.0) <= 0:
            yield take(left, closing=False)
            return
        share = brentq(arrival, 0.0, 1.0, xtol=1e-13, rtol=1e-13)
        if share > 0:
            yield take(share * left, closing=False)
        yield take(0.0, closing=True)
        left *= 1 - share
        if left <= 1e-9 * dt:
            return
    yield take(left, closing=True)
