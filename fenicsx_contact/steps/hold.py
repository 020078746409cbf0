# SPDX-License-Identifier: LGPL-3.0-or-later
"""What bears keeps its gap, though rigid solids turn by finite angles.

A velocity law moves a point as its velocities say, ``dt (theta w_n + (1 - theta) w_n^-)``; on a
rigid solid that turns, the point goes elsewhere, by a small length of second order in the turn
(of third for theta = 1/2). Left alone these add up, and a corner that has sunk makes the points
beside it land before the far corner does, each on its own. So the solids are put back by that much,
as little as their mass allows: a translation and a turn without velocity. Where that changes what
two solids see of each other (a corner on a face that turns, too) the step is solved again about it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..contact.contact import Contact
from ..contact.trial import astray, farthest, normal_rows
from ..theory.theta import Step


def hold_gaps(contacts: Sequence[Contact], step: Step) -> bool:
    """Put rigid solids in their trial states where the bearing points of velocity laws belong;
    whether they were not there."""
    held = []
    for contact in contacts:
        if not contact.formulation.percussive or not all(s.shiftable for s in contact.solids):
            continue
        bearing = np.flatnonzero(contact.equations.statuses() > 0)
        if len(bearing):
            off = astray(contact, step)[bearing]
            off[np.abs(off) <= 2 * np.spacing(farthest(contact))] = 0.0
            held.append((contact, bearing, off))
    if not any(off.any() for _, _, off in held):
        return False
    solids = list({id(s): s for contact, _, _ in held for s in contact.solids}.values())
    starts = np.cumsum([0, *(len(s.velocity) for s in solids)])
    rows, mobility = [], np.zeros((starts[-1], starts[-1]))
    for k, solid in enumerate(solids):
        place = slice(starts[k], starts[k + 1])
        mobility[place, place] = solid.mobility
    for contact, bearing, _ in held:
        each = np.zeros((len(bearing), starts[-1]))
        for solid, G in zip(contact.solids, normal_rows(contact, bearing)):
            k = next(i for i, other in enumerate(solids) if other is solid)
            each[:, starts[k] : starts[k + 1]] += G
        rows.append(each)
    G, off = np.concatenate(rows), np.concatenate([each for _, _, each in held])
    spread = mobility @ G.T
    forces = np.linalg.lstsq(G @ spread, -off, rcond=1e-10)[0]
    shift = spread @ forces
    for k, solid in enumerate(solids):
        solid.shift(shift[starts[k] : starts[k + 1]])
    for contact in contacts:
        contact.follow()
    return True
