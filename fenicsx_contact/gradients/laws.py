# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which laws of contacts are differentiated: all that is written in UFL, but for what follows."""

from __future__ import annotations

import numpy as np
import ufl

from ..base import checks
from ..contact.contact import Contact
from .remembered import moving


def refuse_law(contact: Contact, inertia: bool, moving_time: bool) -> None:
    """Refuse formulations and laws that are not differentiated.

    Args:
        contact: the contact.
        inertia: whether the scene has any.
        moving_time: whether instants depend on parameters.

    Raises:
        InputError: they choose their closed points before a step, remember what is not
            differentiated, or read a time that depends on parameters.
    """
    name, law = f"gradients: contact {contact.name!r}", contact.formulation
    kind, k = type(law).__name__, contact.equations.fields
    if hasattr(law, "closed"):
        raise checks.InputError(
            f"{name} has the formulation {kind}, which chooses its closed points before a step"
        )
    remembers = moving(contact)
    if not law.multipliers:
        _refuse_springs(contact, f"{name} has the formulation {kind}", bool(remembers))
    if np.ndim(contact.memory.recess):
        if len(contact.solids) > 1:
            raise checks.InputError(f"{name} is between two solids, and wears")
        if inertia and law.percussive:
            raise checks.InputError(
                f"{name} wears by a law of velocities, in a scene with inertia; 'gap' does by one "
                "of positions"
            )
    if not moving_time:
        return
    if remembers:
        raise checks.InputError(
            f"{name} has a law that remembers {remembers[0]!r}, in a scene with located impacts"
        )
    timed = [k.dt, *(getattr(k, each) for each in ("t", "elapsed") if each in vars(k))]
    for integral in contact.equations.tangents.form.integrals():
        read = ufl.corealg.traversal.traverse_unique_terminals(integral.integrand())
        if any(terminal is each for terminal in read for each in timed):
            raise checks.InputError(f"{name} has a law of time, in a scene with located impacts")


def _refuse_springs(contact: Contact, name: str, remembers: bool) -> None:
    """Refuse springs whose stretch is not differentiated."""
    rubs = contact.equations.fields.friction is not None
    if rubs and contact.surface.dim == 3:
        raise checks.InputError(
            f"{name} and friction in space, where it is not known how tangential springs turn"
        )
    if remembers:
        raise checks.InputError(f"{name} and a law that remembers what changes with the motion")
