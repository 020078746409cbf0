# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which points of a contact arrive in a step, in the trial state of it: asked by those who choose
where steps end."""

from __future__ import annotations

import numpy as np

from .contact import Contact


def arrival(contact: Contact) -> tuple[float, float, float]:
    """The deepest point in the trial state among those on which nothing acts in the step.

    A point that was closed and lifts may come back within the step: it counts from where it was.

    Returns:
        Its gap there [m], the rate of it [m/s], and its gap at the start.
    """
    free = contact.chosen & (contact.equations.fields.closed.x.array == 0)
    if not free.any():
        return -np.inf, 0.0, 0.0
    start = np.where(contact.closed, np.maximum(contact.gap, 0.0), 0.0)
    gap = np.where(free, contact.coupling.gaps() - start, -np.inf)
    deepest = int(gap.argmax())
    rate = float(contact.trial_jump[deepest] @ contact.normal[deepest])
    return float(gap[deepest]), rate, float(contact.gap[deepest] - start[deepest])


def strikes(contact: Contact, dt: float) -> bool:
    """Whether a point that counts as closed, but did not bear, arrives at the start of a step,
    faster than the loads of the step would make it: else it is coming to rest."""
    fresh = contact.chosen & contact.closed & (contact.status == 0)
    free = contact.coupling.to_jump(np.concatenate([t.free_jump() for t in contact.traces]))
    now, then = ((w * contact.normal).sum(axis=1)[fresh] for w in (contact.jump, free))
    return bool(((now * dt > contact.tolerance) & (now > np.abs(then - now))).any())


def depth(contact: Contact) -> float:
    """Gap [m] in the trial state of the deepest point that was open at the start of the step."""
    opened = contact.chosen & ~contact.closed
    return float(contact.coupling.gaps()[opened].max(initial=-np.inf))


def struck(contact: Contact, speed: float) -> bool:
    """Whether a point bears in the trial state that at the start of the step did not, and was open
    or approached faster than ``speed``, m/s: its velocity has jumped. Springs let none jump."""
    if not contact.formulation.multipliers:
        return False
    fresh = (contact.equations.statuses() > 0) & (contact.status == 0)
    fast = (contact.jump * contact.normal).sum(axis=1) > speed
    return bool((fresh & (fast | ~contact.closed)).any())
