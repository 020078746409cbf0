# SPDX-License-Identifier: LGPL-3.0-or-later
"""What bears keeps its gap, though rigid solids turn by finite angles.

A velocity law moves a point as its velocities say, ``dt (theta w_n + (1 - theta) w_n^-)``; on a
rigid solid that turns, the point goes elsewhere, by a small length of second order in the turn
(of third for theta = 1/2). Left alone these add up, and a corner that has sunk makes the points
beside it land before the far corner does, each on its own. So the solids are put back by that much,
as little as their mass allows: a translation and a turn without velocity. Where that changes what
two solids see of each other (a corner on a face that turns, too) the step is solved again about it.
What errors of the loop moved is put back with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ulp

import numpy as np
from scipy.linalg import lapack

from ..contact.contact import Contact
from ..contact.trial import astray, farthest, normal_rows
from ..theory.scheme import Step


def hold_gaps(contacts: Sequence[Contact], step: Step, resolution: float) -> bool:
    """Put rigid solids in their trial states where the bearing points of velocity laws belong;
    whether they were not there. Speeds below the ``resolution``, m/s, are errors. In a percussion
    nothing moves."""
    if not step.dt:
        return False
    held = []
    for contact in contacts:
        if not contact.formulation.percussive or not all(s.shiftable for s in contact.solids):
            continue
        bearing = contact.trial_status.nonzero()[0]
        if len(bearing):
            off = astray(contact, step, resolution)[bearing]
            off[np.abs(off) <= 2 * ulp(farthest(contact))] = 0.0
            held.append((contact, bearing, off))
    if not held:
        return False
    off = np.concatenate([off for _, _, off in held])
    if not off.any():
        return False
    solids = {id(s): s for contact, _, _ in held for s in contact.solids}
    rows = {key: np.zeros((len(off), len(s.velocity))) for key, s in solids.items()}
    first = 0
    for contact, bearing, _ in held:
        for solid, G in zip(contact.solids, normal_rows(contact, bearing)):
            rows[id(solid)][first : first + len(bearing)] += G
        first += len(bearing)
    ways = {key: solid.mobility @ rows[key].T for key, solid in solids.items()}
    moved = sum(rows[key] @ way for key, way in ways.items())
    forces = lapack.dgelss(moved, -off, cond=1e-10)[1][: len(off)]
    for key, solid in solids.items():
        solid.shift(ways[key] @ forces)
    for contact in contacts:
        contact.follow()
    return True
