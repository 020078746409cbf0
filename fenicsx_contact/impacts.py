# SPDX-License-Identifier: LGPL-3.0-or-later
"""Impacts located within a step.

Between impacts the motion is smooth and the theta-scheme with theta = 1/2 follows it at second
order. What costs accuracy is the instant of an impact, which a uniform step rounds to its end. So:
cross the step as if no open point could close; if one arrives, find when, step exactly there, let
the impact happen as a step of no length, ``M (v+ - v-) = J' P``, and go on with what is left.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.optimize import brentq

from .stepper import Stepper, Trial
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

    def fly(length: float) -> tuple[Trial, float]:
        """The step as if no open point could close, and how deep the deepest of them then is."""
        trial = stepper.attempt(Step(length, scheme, stepper.time), closing=False)
        depths = (contact.arrival(moved=True) for contact in stepper.contacts)
        return trial, max(depths, default=-np.inf)

    def accept(trial: Trial) -> list[float]:
        remarks.extend(trial.remarks)
        return stepper.accept(trial)

    for _ in range(MAX_IMPACTS):
        trial, depth = fly(left)
        if any(contact.strikes(left) for contact in stepper.contacts):
            yield accept(stepper.attempt(Step(0.0, scheme)))
            continue
        if depth <= 0:
            yield accept(trial)
            return
        start = max(contact.arrival(moved=False) for contact in stepper.contacts)
        share = brentq(
            lambda share, whole=left, start=start: fly(share * whole)[1] if share else start,
            0.0,
            1.0,
            xtol=1e-13,
            rtol=1e-13,
        )
        if share > 0:
            yield accept(fly(share * left)[0])
        yield accept(stepper.attempt(Step(0.0, scheme, stepper.time)))
        left *= 1 - share
        if left <= 1e-9 * dt:
            return
    yield accept(stepper.attempt(Step(left, scheme, stepper.time)))
