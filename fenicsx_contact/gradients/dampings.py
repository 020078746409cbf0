# SPDX-License-Identifier: LGPL-3.0-or-later
"""What damping a number of a deformable solid stands for."""

from __future__ import annotations

import numpy as np

from ..solids import DeformableSolid
from ..theory.scheme import Step


def damping(solid: DeformableSolid, step: Step, number: str) -> np.ndarray:
    """The damping forces of a solid in the trial state of a step that are proportional to a number
    of its damping, ``"alpha"`` or ``"beta"``."""
    ends = solid.displacement, solid.trial_displacement
    rate, force = step.rate(solid.velocity, solid.trial_velocity), np.zeros(solid.owned)
    for damper in solid.dampers:
        if damper.number == number:
            force += damper.force(step, *ends, rate)
    return force
