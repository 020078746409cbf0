# SPDX-License-Identifier: LGPL-3.0-or-later
"""A step between its solution and its acceptance."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..theory.scheme import Step
from .certificate import Certificate


@dataclass(frozen=True)
class Trial:
    """A step that was solved and not yet accepted: the solids stand in their trial states.

    Attributes:
        step: the step.
        force: of the contacts on all points, flat, N.
        newton, geometry: iterations and linearisations.
        remarks: of the solution.
        errors: what the certificate says of it.
        arrives: it ends where a point arrives, at an instant that depends on everything.
        again: how often it was solved again about where solids had been put.
    """

    step: Step
    force: np.ndarray
    newton: int
    geometry: int
    remarks: list[str]
    errors: Certificate
    arrives: bool = False
    again: int = 0

    @property
    def certificate(self) -> float:
        """Its largest error."""
        return self.errors.worst

    def then(self, other: Trial) -> Trial:
        """The other one, which solved this one again."""
        return replace(
            other,
            newton=self.newton + other.newton,
            geometry=self.geometry + other.geometry,
            remarks=self.remarks + other.remarks,
            again=self.again + 1,
        )
