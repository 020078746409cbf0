# SPDX-License-Identifier: LGPL-3.0-or-later
"""When a percussion is due: points that start a step faster than their law allows."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf

import numpy as np

from ..base.vectors import dot
from ..theory.scheme import Step
from .blows import struck_gap
from .contact import Contact


def approaching(contact: Contact, step: Step, where: np.ndarray) -> np.ndarray:
    """Points that start the step faster than its law allows, by more than the last step
    resolved and than round-off of their gaps is worth, among ``where`` (n,)."""
    asked = where & contact.chosen & contact.candidates.near()
    return np.asarray(asked & (_excess(contact, step) > _least(contact, step)))


def strikes(contact: Contact, step: Step, points: np.ndarray, error: float) -> bool:
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
    beyond = _excess(contact, step, stopped=True) > least
    # what rests and was lifted by a finite rotation is put back by the steps
    came = dot(contact.jump, contact.coupling.start_normals())
    beyond &= came <= contact.arriving + _least(contact, step)
    beyond &= not getattr(contact.formulation, "drift_correction", 0.0)  # which puts it back
    return bool((beyond | (_excess(contact, step) > change))[points].any())


def rebounding(contacts: Iterable[Contact]) -> bool:
    """Whether anything that may be struck leaves again: the order of the strikes then counts."""
    laws = (contact.formulation for contact in contacts)
    return any(law.percussive and getattr(law, "rebounds", False) for law in laws)


def first_arrival(contacts: Iterable[Contact], step: Step) -> float:
    """After how long the first of the points arrives that start the step too fast, s."""
    first = inf
    for contact in contacts:
        if contact.formulation.percussive:
            points = approaching(contact, step, contact.chosen)
            gap = np.minimum(contact.gap, 0.0)[points]
            approach = _approach(contact)[points]
            first = min(first, (-gap / approach).min(initial=inf))
    return first


def _least(contact: Contact, step: Step) -> float:
    """What of a speed is none, m/s."""
    return contact.resolution + contact.noise / step.horizon


def _excess(contact: Contact, step: Step, stopped: bool = False) -> np.ndarray:
    """How much faster than its law allows each point starts the step, (n,) in m/s; or is in the
    mean if it is at rest at its end."""
    approach = _approach(contact)
    approach = approach * (1 - step.gap_rate / step.horizon) if stopped else approach
    return np.asarray(approach + struck_gap(contact, step) / step.horizon)


def _approach(contact: Contact) -> np.ndarray:
    """w_n at the start of the begun step, if it starts with a percussion, (n,)."""
    return contact.coupling.coming(_struck_jump(contact), contact.touching())


def _struck_jump(contact: Contact) -> np.ndarray:
    """w at the start of the begun step, if it starts with a percussion, (n, d)."""
    return contact.coupling.struck_jump() if contact.coupling.driven else contact.jump
