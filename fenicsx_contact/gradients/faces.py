# SPDX-License-Identifier: LGPL-3.0-or-later
"""How gaps before a wall depend on the places of points: at its edges by the planes of the faces
that are met, which are not those of what is nearest."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.constants import RIGHT
from ..contact.wall import Wall
from ..theory.scheme import Step


class Slopes(NamedTuple):
    """At points, in their own sense.

    Attributes:
        gap: derivatives of the gaps by the places, (n, d).
        normal: (n, d); ``bend``: their derivatives by the places, (n, d, d) in 1/m.
    """

    gap: np.ndarray
    normal: np.ndarray
    bend: np.ndarray


def slopes(contact: Any, step: Step, places: np.ndarray, start: np.ndarray) -> tuple[Slopes, ...]:
    """Where a step ends, and where it starts.

    Args:
        contact: of a deformable solid or a rigid one with a wall.
        step: that has been solved.
        places, start: of its points, (n, d) in m.
    """
    wall, by_faces = contact.coupling.wall, contact.coupling.by_faces
    ends = [_nearest(wall, *each) for each in ((places, step.end), (start, step.start))]
    if not by_faces:
        return tuple(ends)
    for (gap, normal, bend), met in zip(ends, (contact.normal, contact.start_normal)):
        kept = (np.abs(met - normal) > RIGHT).any(axis=1)
        gap[kept], normal[kept], bend[kept] = met[kept], met[kept], 0.0
    other = contact.coupling.other_faces(
        step
    )  # the gap at the start is that of the face at the end
    ends[1].gap[other] = contact.normal[other]
    return tuple(ends)


def _nearest(wall: Wall, places: np.ndarray, time: float) -> Slopes:
    """Of what is nearest."""
    bend = wall.curvature(places, time)
    bend = np.zeros((*places.shape, places.shape[1])) if bend is None else -bend
    return Slopes(-wall.slopes(places, time), -wall.normals(places, time), bend)
