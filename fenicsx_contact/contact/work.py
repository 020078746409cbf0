# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a contact does to its solids in a step, for the books of a scene."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..theory.scheme import Step
from .contact import Contact


def work(
    contact: Contact, means: Mapping[int, np.ndarray], step: Step
) -> tuple[float, float, float]:
    """Work of the contact on its solids in the step that was accepted, J, from their mean
    velocities (by id): of the normal and of the friction forces on the jumps, which both are
    losses, and of what drives the other side."""
    force, span = contact.force, step.span
    if not force.any():
        return 0.0, 0.0, 0.0
    jump = contact.coupling.mean_jump(means, step)
    total = span * float(np.vdot(force, jump))
    pressed = span * float(np.vdot(contact.normal_forces, jump))
    if not contact.coupling.driven:
        return pressed, total - pressed, 0.0
    driven = span * float((force * contact.coupling.carried(step)).sum())
    return pressed, total - pressed, driven


def counts(contact: Contact) -> tuple[int, int]:
    """Points that bear, and that slip, in the last step."""
    return int(np.count_nonzero(contact.status)), int(np.count_nonzero(contact.status > 1))
