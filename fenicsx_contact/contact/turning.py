# SPDX-License-Identifier: LGPL-3.0-or-later
"""Normals that turn on the way of a step, along a round wall or with the solids.

A law of velocities says what the jumps at the end may be, along the normal n+ there. Forces along
n+ alone would work on what slides by: ``n+ . (v+ + v-)/2 = n+ . v-/2``, not zero where n turns. So
they act along the mean of n- and n+, weighed as the scheme weighs velocities: by theta = 1/2, where
points slide, ``(n- + n+) . (v+ + v-) = -(n+ - n-) . (v+ - v-)``, to which the contact itself adds
nothing. Its work is of third order in the step, and a step taken backwards undoes one forwards.
In guides, along which a rod moves far in a step, n- is n+ mirrored at the normal to the way.

Friction acts across the mean normal, and slips of the start are across n-: of all frames at the
three, which lie in one plane, those that turn into each other by the least rotation keep what no
choice of tangents changes. Components of friction and of slips along them belong together.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.vectors import dot
from ..theory.scheme import Step
from .jump import Coupling
from .surface_fields import SurfaceFields


def turning(other: Any) -> bool:
    """Whether normals before a master change on the way of a step."""
    return isinstance(other, tuple) or not getattr(other, "flat", False)


def start_speeds(
    fields: SurfaceFields,
    coupling: Coupling,
    step: Step,
    jump: np.ndarray,
    normals: tuple[np.ndarray, np.ndarray],
    touches: np.ndarray,
) -> np.ndarray:
    """How fast points come at the start of a step, (n,) in m/s; tells the fields the normals there.

    Along those of the end, where forces act along these alone: by theta = 1, at points that do not
    touch yet, and beyond an edge, where what comes along one face strikes the other.

    Args:
        fields: of the surface.
        coupling: what its points meet.
        step: that is linearised.
        jump: at the start, (n, d) in m/s.
        normals: at the start and at the end, (n, d).
        touches: points that touch at the start, (n,) of bool.
    """
    (old, new), share = normals, coupling.end_share(step)
    if fields.start_normal is None:
        return dot(jump, new)
    turns = np.zeros(len(new), dtype=bool)
    if share < 1:
        old, turns = coupling.begun(old, new, touches, step)
    fields.set_start_normal(old, np.where(turns, share, 1.0))
    before = dot(jump, old)
    return before if turns.all() else np.where(turns, before, coupling.start_along(jump, new))
