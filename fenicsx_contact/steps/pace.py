# SPDX-License-Identifier: LGPL-3.0-or-later
"""How a step of the grid is crossed: whole, or in parts where it fails.

Places in it are shares of its length. Parts are halved and doubled, and double only where they
then end on a multiple of themselves: lengths come back, and with them the factors of a matrix.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.checks import StepFailed
from .taker import StepTaker


class Pace:
    """Uniform steps: a part is as long as it may be, shorter only after a failure.

    Args:
        stepper: what takes the steps.
        dt: length of the steps of the grid, s.
        shortest: shortest part, as a share of dt.
    """

    stepper: Any  # a StepTaker

    def __init__(self, stepper: StepTaker, dt: float, shortest: float) -> None:
        self.stepper = stepper
        self.dt, self.shortest = dt, shortest
        self._part = 1.0

    def begin(self, done: float) -> None:
        """A step of the grid begins, or goes on from ``done``."""
        self._part = 1.0 - done

    def end(self, done: float) -> float:
        """Where the part that begins at ``done`` ends."""
        return done + self._part

    def shorten(self, tried: float, failure: StepFailed) -> bool:
        """A part as long as ``tried`` failed; whether a shorter one may be tried."""
        self._part = tried / 2
        return self._part >= self.shortest

    def lengthen(self, done: float) -> None:
        """A part ended at ``done``."""
        while self._part < 1.0 and (done / (2 * self._part)).is_integer():
            self._part *= 2
        self._part = min(self._part, 1.0 - done) if done < 1.0 else self._part

    def state(self) -> dict[str, np.ndarray]:
        """The arrays from which :meth:`restore` continues identically: none, between steps of the
        grid."""
        return {}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Take up a state that :meth:`state` gave."""
