# SPDX-License-Identifier: LGPL-3.0-or-later
"""The normals at the start that points of a beam in a guide mirror at the chords of their ways."""

from __future__ import annotations

import numpy as np

from ..base.vectors import dot
from .parameters import Parameter
from .sight import Sight


class Chord:
    """Mean slopes on the ways of points, and normals at the start by them; see
    :meth:`fenicsx_contact.rods.coupling.GuideCoupling.begun`.

    The slope of a node is that of the wall between the depths at both ends; of a station that of
    the beam at the start, between what is there then and what the end sees there.

    Args:
        old, new: what points see at the start, and what the normals at the end belong to.
        now: displacement of the beam at the start.

    Attributes:
        normal: at the start, (k, d); ``by_chord``, ``by_slope``: derivatives by the mean slope and
            by that at the end.
        start, end: derivatives of the mean slope by the displacements at both ends, (k, unknowns).
        slides, slid: by the material that a station sees at the end and at the start, (k,).
    """

    def __init__(self, old: Sight, new: Sight, now: np.ndarray) -> None:
        self._old, self._new = old, new
        stands, side = new.stands, new.side
        self._way = way = np.where(stands, new.material - old.material, new.depth - old.depth)
        over = 1 / np.where(way != 0, way, np.inf)
        lean = -side * new.turn  # of a station, from the slope of the beam
        rise = np.where(
            stands,
            lean * ((new.w - old.w) @ now),
            side * (new.centre - old.centre) + new.clearance - old.clearance,
        )
        a = rise * over
        last = np.where(stands, lean * (new.dw @ now), side * new.rate + new.taper)
        first = np.where(stands, lean * (old.dw @ now), side * old.rate + old.taper)
        by_last, by_first = (last - a) * over, (a - first) * over
        self.start = (stands * lean * over)[:, None] * (new.w - old.w)
        self.end = np.zeros_like(self.start)
        self.start[:, -1] -= ~stands * by_first
        self.end[:, -1] -= ~stands * by_last
        self.slides, self.slid = stands * by_last, stands * by_first

        # in the plane of the normals; a quarter turn is the derivative by the angle
        down, across = new.down, new.across
        along = (side[:, None] * across - a[:, None] * down) / np.sqrt(1 + a * a)[:, None]
        self.normal = 2 * dot(along, new.normal)[:, None] * along - new.normal
        turned = side[:, None] * (
            (self.normal @ down)[:, None] * across - (self.normal @ across)[:, None] * down
        )
        self.by_chord = 2 * turned / (1 + a * a)[:, None]
        self.by_slope = -turned / (1 + new.a**2)[:, None]

    def moved(self, parameter: Parameter) -> np.ndarray:
        """Changes of the mean slope where a parameter moves or widens the guide, (k,)."""
        (last, wider), (first, wide) = (s.offset(parameter) for s in (self._new, self._old))
        rise = self._new.side * (last - first) + wider - wide
        over = ~self._new.stands / np.where(self._way != 0, self._way, np.inf)
        return np.asarray(rise * over)
