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
    losses, and of what drives the other side. What meets nothing does none, wherever it is: only
    what acts is certified."""
    span, acts = step.span, contact.force.any(axis=1)
    if not acts.any():
        return 0.0, 0.0, 0.0
    force, jump = contact.force[acts], contact.coupling.mean_jump(means, step)[acts]
    total = span * float(np.vdot(force, jump))
    pressed = span * float(np.vdot(contact.normal_forces[acts], jump))
    if not contact.coupling.driven:
        return pressed, total - pressed, 0.0
    carried = np.broadcast_to(contact.coupling.carried(step), contact.force.shape)[acts]
    return pressed, total - pressed, span * float(np.vdot(force, carried))


def counts(contact: Contact) -> tuple[int, int]:
    """Points that bear, and that slip, in the last step."""
    return int(np.count_nonzero(contact.status)), int(np.count_nonzero(contact.status > 1))
