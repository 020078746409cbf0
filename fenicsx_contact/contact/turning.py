# SPDX-License-Identifier: LGPL-3.0-or-later
"""Normals that turn on the way of a step, along a round wall or with the solids.

A law of velocities says what the jumps at the end may be, along the normal n+ there. Forces along
n+ alone would work on what slides by: ``n+ . (v+ + v-)/2 = n+ . v-/2``, not zero where n turns. So
they act along the mean of n- and n+, weighed as the scheme weighs velocities: by theta = 1/2, where
points slide, ``(n- + n+) . (v+ + v-) = -(n+ - n-) . (v+ - v-)``, to which the contact itself adds
nothing. Its work is of third order in the step, and a step taken backwards undoes one forwards.
"""

from __future__ import annotations

import numpy as np

from ..base.vectors import dot
from .surface_fields import SurfaceFields


def start_normals(
    fields: SurfaceFields, old: np.ndarray, new: np.ndarray, touches: np.ndarray, end_share: float
) -> np.ndarray:
    """The normals (n, d) along which jumps at the start of a step count; tells them to the fields.

    Those of the end, where forces act along these alone: by theta = 1, at points that do not touch
    yet, and where a normal turns by more than a right angle, which no wall's does.

    Args:
        fields: of the surface.
        old, new: normals at the start and at the end, (n, d).
        touches: points that touch at the start, (n,) of bool.
        end_share: what the normals at the end count in the mean.
    """
    if fields.start_normal is None:
        return new
    turns = touches & (dot(old, new) > 0) & (end_share < 1)
    fields.set_start_normal(old, np.where(turns, end_share, 1.0))
    return np.where(turns[:, None], old, new)
