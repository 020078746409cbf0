# SPDX-License-Identifier: LGPL-3.0-or-later
"""Why a step has no solution, whatever the forces: what moves as it is told closes on solids that
cannot give way, so that no motion of theirs keeps them apart."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.nonnegative import nonnegative
from ..base.vectors import dot, largest
from ..contact.contact import Contact
from ..solids.motions import FREE
from ..theory.scheme import Step
from .equilibrium import unbearable


def hopeless(floating: Sequence[Any], contacts: Sequence[Contact], step: Step) -> str:
    """Why a begun step has no solution, or nothing: contacts cannot bear the loads on solids that
    nothing else holds, the ``floating`` ones; or they are jammed."""
    why = unbearable(floating, contacts, step) if floating else ""
    return why or jammed(contacts, step)


def jammed(contacts: Sequence[Contact], step: Step) -> str:
    """Which contacts close on rigid solids, however these move; nothing if some motion of theirs
    keeps all points apart.

    There is none if and only if pushes at the points can add up to nothing on every solid while
    what pushes comes nearer (Farkas).

    Args:
        contacts: of the scene; a point on what deforms gives way.
        step: that is begun.
    """
    stiff = [c for c in contacts if all(solid.shiftable for solid in c.solids)]
    if not any(contact.coupling.driven for contact in stiff):
        return ""
    solids = {id(solid): solid for contact in stiff for solid in contact.solids}
    rest = {key: np.zeros_like(solid.velocity) for key, solid in solids.items()}

    def approach(contact: Contact, moving: dict[int, np.ndarray]) -> np.ndarray:
        return dot(contact.coupling.mean_jump({**rest, **moving}, step), contact.normal)

    points = [contact.equations.candidates for contact in stiff]
    told = [approach(contact, {}) for contact in stiff]  # by what moves as it is told
    nearer = np.concatenate([each[at] for each, at in zip(told, points)])
    rows = []
    for key, solid in solids.items():
        for way in np.eye(solid.velocity.size)[solid.mobility.any(axis=1)]:
            by = [approach(contact, {key: way}) - each for contact, each in zip(stiff, told)]
            row = np.concatenate([each[at] for each, at in zip(by, points)])
            rows.append(row / (largest(row) or 1.0))
    if not nearer.size or not nearer.max() > 0:
        return ""
    target = np.eye(len(rows) + 1)[-1]
    found = nonnegative(np.array([*rows, nearer / nearer.max()]), target)
    if found is None or largest(np.array(rows) @ found) > FREE * found.sum():
        return ""
    ends = np.cumsum([len(at) for at in points])
    pushes = [largest(each) > 0 for each in np.split(found, ends[:-1])]
    pressed = [contact for contact, push in zip(stiff, pushes) if push]
    names = " and ".join(repr(contact.name) for contact in pressed)
    within = " and ".join(dict.fromkeys(repr(s.name) for c in pressed for s in c.solids))
    return f"contacts {names} close on {within}, which cannot give way"
