# SPDX-License-Identifier: LGPL-3.0-or-later
"""When a percussion is due: points that start a step faster than their law allows."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import inf

import numpy as np

from ..base.vectors import dot
from ..theory.scheme import Step
from .blows import struck_gap
from .contact import Contact


def approaching(
    contact: Contact, step: Step, touching: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """How fast points come at the start of the begun step, (n,) in m/s, and which of them, or of
    those that touch, faster than their law allows in ``step``, (n,) of bool: by more than the last
    step resolved and than round-off of their gaps is worth. None of those that the last percussion
    left as they were: the next one would, too."""
    touches = contact.touching()
    comes = contact.coupling.coming(_struck_jump(contact), touches)
    asked = contact.chosen & contact.candidates.near() & ~contact.blows.idle
    asked &= _excess(contact, step, comes) > _least(contact, step)
    return comes, asked & touches if touching else asked


def strikes(
    contact: Contact, step: Step, comes: np.ndarray, points: np.ndarray, error: float
) -> bool:
    """Whether one of these points is faster than its law allows by more than what the loads of
    the step change: less is a body coming to rest, which the step itself can stop; or arrives and
    goes beyond what it meets even if the step stops it, by more than errors of its gap are worth
    and that share of the fastest point, the ``error`` with which a blow is accepted. Solids and
    traces are linearised about the prediction of the step."""
    for trace in contact.traces:
        trace.linearise(step)
    free = np.concatenate([t.free_jump() for t in contact.traces])
    change = contact.coupling.loaded(free, _struck_jump(contact))
    least = contact.tolerance / step.horizon + _least(contact, step)
    least += error * contact.coupling.fastest("velocity")
    # in the mean, if it is at rest at the end
    stopped = comes * (1 - step.gap_rate / step.horizon)
    beyond = _excess(contact, step, stopped) > least
    # what rests and was lifted by a finite rotation is put back by the steps
    came = dot(contact.jump, contact.coupling.start_normals())
    beyond &= came <= contact.arriving + _least(contact, step)
    beyond &= not getattr(contact.formulation, "drift_correction", 0.0)  # which puts it back
    return bool((beyond | (_excess(contact, step, comes) > change))[points].any())


def rebounding(contacts: Iterable[Contact]) -> bool:
    """Whether anything that may be struck leaves again: the order of the strikes then counts."""
    laws = (contact.formulation for contact in contacts)
    return any(law.percussive and getattr(law, "rebounds", False) for law in laws)


def first_arrival(contacts: Iterable[Contact], step: Step) -> float:
    """After how long the first of the points arrives that start the step too fast, s."""
    first = inf
    for contact in contacts:
        if contact.formulation.percussive:
            comes, points = approaching(contact, step)
            gap = np.minimum(contact.gap, 0.0)[points]
            first = min(first, (-gap / comes[points]).min(initial=inf))
    return first


def until_sudden(contacts: Sequence[Contact], step: Step) -> float:
    """After how long in a step, s, an obstacle's velocity jumps, which is a blow to what it reaches
    then and, if anything rebounds, is to be struck there; laws without percussions need the
    velocities at both ends of a step, unless they are means. Or the length of the step."""
    if not step.scheme.inertia:
        return step.dt
    asked = {True: rebounding(contacts), False: step.implicitness < 1}
    who = [contact for contact in contacts if asked[contact.formulation.percussive]]
    return min([step.dt, *(contact.coupling.sudden(contact.gap, step) for contact in who)])


def _least(contact: Contact, step: Step) -> float:
    """What of a speed is none, m/s."""
    return contact.resolution + contact.noise / step.horizon


def _excess(contact: Contact, step: Step, comes: np.ndarray) -> np.ndarray:
    """How much faster than its law allows each point is, (n,) in m/s, if it comes as fast."""
    return np.asarray(comes + struck_gap(contact, step) / step.horizon)


def _struck_jump(contact: Contact) -> np.ndarray:
    """w at the start of the begun step, if it starts with a percussion, (n, d)."""
    return contact.coupling.struck_jump() if contact.coupling.driven else contact.jump
