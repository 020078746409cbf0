# SPDX-License-Identifier: LGPL-3.0-or-later
"""What points of a beam see of the guide around them."""

from __future__ import annotations

import numpy as np

from ..rods import GuideContact
from .parameters import Parameter


class Sight:
    """What points of a beam see of the guide around them, and what that depends on.

    With a the slope of the wall (of the beam, at a station) towards the axis the normal is
    ``(a, -1)/sqrt(1 + a²)`` in the direction of the guide and across, and the gap
    ``(|off| - c)/sqrt(1 + a²)``. What slides is the derivative by s of the material at a station.

    Args:
        contact: the contact.
        points: their numbers, (k,).
        displacement: of the beam.
        seen: axial displacement by which the stations find their material, m.

    Attributes:
        stands: which of them are stations, (k,) of bool; ``material``: s of the beam there, m;
            ``w``, ``dw``: of its deflection and that of its derivative, (k, unknowns).
        depth: of the points, (k,) in m; ``centre``, ``rate``, ``clearance``, ``taper``: place of
            the tube around them, the slope of that, its clearance and the slope of that, (k,).
        down, across: directions of the guide, (d,); ``turn``: cosine of the latter and the beam's.
        side, a: of the wall that is nearer, 1 or -1, and its slope, (k,).
        jump, jump_slides: operator of the velocities, and what slides of it, (k, d, unknowns).
        normal, normal_by: of the slave, and its derivative by the slope a, (k, d).
        slope, slope_slides: derivative of that by the displacement, (k, unknowns), and (k,).
        gap, gap_slides: of the gap, likewise.
    """

    def __init__(
        self, contact: GuideContact, points: np.ndarray, displacement: np.ndarray, seen: float
    ) -> None:
        self._contact = contact
        rod, guide = contact.solid.rod, contact.obstacle
        axis, k, m, n = rod.axis, rod.matrices, len(points), len(displacement)
        self._along = axis.along(contact.surface.points[points])
        self._reach = axis.stretch(contact.facets)
        number = np.full(contact.surface.size, -1)
        number[contact.stations] = np.arange(len(contact.stations))
        station = number[points]
        self.stands = stands = station >= 0
        moves = ~stands

        # the beam there
        self.material = self._along - stands * seen
        cell, xi, weights = k.interpolate(self.material)
        first, second = k.shapes[1, cell, 1:3].swapaxes(0, 1)
        bend = (first + 2 * xi[:, None] * second) / np.diff(k.s)[cell][:, None]
        w, dw, ddw = np.zeros((3, m, n))
        places = 2 * cell[:, None] + np.arange(4)
        for rows, values in zip((w, dw, ddw), (*weights, bend)):
            np.put_along_axis(rows, places, values, axis=1)
        self.w, self.dw = w, dw
        across, along = axis.frame[0], axis.direction
        self.jump = w[:, None] * across[:, None]
        self.jump[:, :, -1] += along
        self.jump_slides = (stands[:, None] * dw)[:, None] * across[:, None]

        # the guide there
        place = self._along + moves * displacement[-1]
        x = axis.origin + (w @ displacement)[:, None] * across + place[:, None] * along
        self.depth = guide.depth(x)
        local, off, rate, clearance, taper, _ = guide.around(x)
        self.centre, self.clearance = local[:, 1] - off[:, 0], clearance
        off = np.where(stands, local[:, 1] - guide.centres[station, 0], off[:, 0])
        clearance = np.where(stands, guide.clearance()[station], clearance)
        self.rate, self.taper = rate[:, 0], taper
        self.down, self.across = guide.direction, guide.lateral[0]
        turn, tilt = float(across @ guide.lateral[0]), dw @ displacement
        self.turn = turn
        self.side = side = np.where(off < 0, -1.0, 1.0)
        leans, taper = np.where(stands, -turn * tilt, rate[:, 0]), moves * taper
        self.a = a = side * leans + taper
        self._steep = np.sqrt(1 + a * a)
        self._distance = (np.abs(off) - clearance) / self._steep

        # and how both change; a node goes up with the axis
        self.normal = side[:, None] * guide.lateral[0] - a[:, None] * guide.direction
        self.normal = self.normal / self._steep[:, None]
        self.normal_by = -(guide.direction + (side * a)[:, None] * guide.lateral[0])
        self.normal_by = self.normal_by / self._steep[:, None] ** 3
        self.slope = -(side * turn * stands)[:, None] * dw
        self.slope[:, -1] -= side * moves * guide.line_curvature(self.depth)
        self.slope_slides = -side * turn * stands * (ddw @ displacement)
        moved = (side * turn)[:, None] * w
        moved[:, -1] += moves * (side * rate[:, 0] + taper)
        self.gap = self._gap(moved, self.slope)
        slid = side * turn * stands * tilt
        self.gap_slides = self._gap(slid[:, None], self.slope_slides[:, None])[:, 0]

    def _gap(self, moved: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """Change of the gap from those of ``|off| - c`` and of the slope, (k, ...)."""
        a, steep = self.a[:, None], self._steep[:, None]
        return moved / steep - self._distance[:, None] * a * slope / steep**2

    def leave_out(self, axial: float) -> None:
        """Nothing changes at stations that the beam has not reached, or has passed, when its axial
        displacement is this, m."""
        low, high = (end + axial for end in self._reach)
        away = self.stands & ((self._along < low) | (self._along > high))
        self.gap[away], self.gap_slides[away] = 0.0, 0.0

    def offset(self, parameter: Parameter) -> tuple[np.ndarray | float, np.ndarray | float]:
        """Changes of the place and of the clearance of the tube by a parameter, (k,) in m each."""
        wider = parameter.widened(self._contact, self.depth)
        return parameter.bend(self._contact, self.depth)[0], wider

    def moved(self, parameter: Parameter) -> tuple[np.ndarray, np.ndarray]:
        """Changes of the slope a and of the gap where a parameter moves or widens the guide, (k,)
        each."""
        offset, slope = parameter.bend(self._contact, self.depth)
        change = self.side * slope * ~self.stands
        nearer = -self.side * offset - parameter.widened(self._contact, self.depth)
        return change, self._gap(nearer[:, None], change[:, None])[:, 0]
