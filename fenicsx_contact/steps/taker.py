# SPDX-License-Identifier: LGPL-3.0-or-later
"""What takes steps: the stepper of a scene, or something that judges what one takes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ..contact.contact import Contact
from ..theory.scheme import Step
from .trial import Trial


class StepTaker(Protocol):
    """What takes steps: a :class:`~.step.Stepper`, or something that judges what one takes."""

    @property
    def contacts(self) -> Sequence[Contact]: ...
    @property
    def time(self) -> float: ...
    def struck(self, step: Step, touching: bool = False) -> bool: ...
    def attempt(
        self, step: Step, closing: bool = True, rates: Sequence[np.ndarray] | None = None
    ) -> Trial: ...
    def accept(self, trial: Trial) -> list[float]: ...
    def mean_accelerations(self, step: Step) -> list[np.ndarray]: ...
