# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rows of a contact between a beam and its guide, in the plane, in a linearised step.

A node keeps its material and slides past the wall: its normal follows the slope of the wall beside
it. A station keeps its place and sees the material that the start of the step predicts there, at
``s = place - u- - horizon u'-``: its jump, normal and force depend on what slides past.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..contact.contact import Contact
from ..rods import GuideContact
from .beams import BeamMotion
from .parameters import Parameter
from .surface import ContactRows, refuse_law, square


class GuideRows(ContactRows):
    """A beam in a guide; see :class:`~.surface.ContactRows`."""

    contact: GuideContact
    motion: BeamMotion

    def __init__(self, contact: GuideContact, motion: BeamMotion, settles: bool) -> None:
        super().__init__(contact, motion)
        # a law that reads no gap of the end settles with the normals of the prediction
        self._predicted = settles and not contact.formulation.gap_share

    def _refuse(self, contact: Contact) -> None:
        refuse_law(contact)
        guide = contact.coupling.obstacle  # type: ignore[attr-defined]
        guide.line_curvature(guide.stations)  # a curve may not know it

    def _kinematics(self) -> None:
        contact, solid = self.contact, self.motion.solid
        self.start_jump, self.jump = contact.jump, contact.trial_jump
        self.normal = contact.normal
        self._ahead = solid.displacement + self.motion.horizon * solid.velocity
        self._sights: dict[bytes, tuple[Sight, Sight]] = {}

    def _seen(self) -> tuple[Sight, Sight]:
        """What the points see at the start of the step, and what its normals belong to."""
        key, contact, solid = self.points.tobytes(), self.contact, self.motion.solid
        if key not in self._sights:
            now, ahead = solid.displacement, self._ahead
            end = ahead if self._predicted else solid.trial_displacement
            old = Sight(contact, self.points, now, now[-1])
            old.leave_out(now[-1])
            self._sights[key] = old, Sight(contact, self.points, end, ahead[-1])
        return self._sights[key]

    def _weights(self) -> tuple[np.ndarray, ...]:
        """Derivatives of the rows of the points, (k, rows, ...), by the jump at the end and at the
        start, by the normal, and by the gap at the start and at the end."""
        p, d = self.points, self._d
        T, G = self._blocks[p], self._parameters[p]
        start = (self._start[p] * self.reads_start[p][:, None])[:, :, None]
        share = float(self.contact.formulation.gap_share)
        gap, n = G[:, :, :1], self.normal[p][:, None]
        end = share * gap
        rate = self.step.gap_rate * end  # the gap at the end is read without its part in w
        by_normal = G[:, :, 1:] + start * self.start_jump[p][:, None]
        return (
            T[:, :, :d] - rate * n,
            start * n,
            by_normal - rate * self.jump[p][:, None],
            gap * self._reads_gap[p][:, None, None],
            end,
        )

    def derivatives(self) -> dict[str, tuple[Any, Any]]:
        d, n, solid = self._d, self.motion.size, self.motion.solid
        old, new = self._seen()
        by_jump, by_start, by_normal, by_gap, by_end = self._weights()
        by_slope = by_normal @ new.normal_by[:, :, None]
        rows = {
            "v": by_jump @ new.jump,
            "v_old": by_start @ new.jump,
            "q_old": by_gap * old.gap[:, None],
        }
        seen = by_slope * new.slope[:, None] + by_end * new.gap[:, None]
        if self._predicted:
            rows["q_old"] += seen
            rows["v_old"] += self.motion.horizon * seen
        else:
            rows["q"] = seen
        slides = by_slope * new.slope_slides[:, None, None]
        slides += by_end * new.gap_slides[:, None, None]
        slides += by_jump @ (new.jump_slides @ solid.trial_velocity)[:, :, None]
        slides += by_start @ (new.jump_slides @ solid.velocity)[:, :, None]
        rows["q_old"][:, :, -1:] -= slides + by_gap * old.gap_slides[:, None, None]
        rows["v_old"][:, :, -1:] -= self.motion.horizon * slides
        T = self._blocks[self.points]
        result: dict[str, tuple[Any, Any]] = {"m": (square(T[:, d:, d:]), -square(T[:, :d, d:]))}
        for name, each in rows.items():
            result[name] = each[:, d:].reshape(-1, n), -each[:, :d].reshape(-1, n)
        return result

    def by(self, parameter: Parameter) -> tuple[np.ndarray, np.ndarray]:
        p, d = self.points, self._d
        result = np.zeros(self._blocks[p].shape[:2])
        if (rows := parameter.rows(self.contact)) is not None:
            result += rows[p]
        old, new = self._seen()
        before, after = (parameter.bend(self.contact, sight.depth) for sight in (old, new))
        if before is not None and after is not None:
            _, _, by_normal, by_gap, by_end = self._weights()
            slope, gap = new.bent(*after)
            result += (by_normal @ (new.normal_by * slope[:, None])[:, :, None])[:, :, 0]
            result += by_end[:, :, 0] * gap[:, None]
            result += by_gap[:, :, 0] * old.bent(*before)[1][:, None]
        return result[:, d:].ravel(), -result[:, :d].ravel()

    def spread(self, forces: np.ndarray) -> Any:
        """Velocities that forces at the candidates make in the step."""
        J = self._seen()[1].jump.reshape(-1, self.motion.size)
        return self.motion.lift(J.T) @ forces

    def turned(self) -> dict[str, Any]:
        n = self.motion.size
        slides = self._seen()[1].jump_slides.reshape(-1, n).T @ self._force
        by_place = np.zeros((n, n))
        by_place[:, -1] = -self.motion.lift(slides)
        return {"q_old": by_place, "v_old": self.motion.horizon * by_place}


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
        depth: of the points, (k,) in m.
        jump, jump_slides: operator of the velocities, and what slides of it, (k, d, unknowns).
        normal_by: derivative of the normals by the slope a, (k, d).
        slope, slope_slides: derivative of that by the displacement, (k, unknowns), and (k,).
        gap, gap_slides: of the gap, likewise.
    """

    def __init__(
        self, contact: GuideContact, points: np.ndarray, displacement: np.ndarray, seen: float
    ) -> None:
        rod, guide = contact.solid.rod, contact.obstacle
        axis, k, m, n = rod.axis, rod.matrices, len(points), len(displacement)
        self._along = axis.along(contact.surface.points[points])
        self._reach = axis.stretch(contact.facets)
        number = np.full(contact.surface.size, -1)
        number[contact.stations] = np.arange(len(contact.stations))
        station = number[points]
        self._stands = stands = station >= 0
        moves = ~stands

        # the beam there
        cell, xi, weights = k.interpolate(self._along - stands * seen)
        first, second = k.shapes[1, cell, 1:3].swapaxes(0, 1)
        bend = (first + 2 * xi[:, None] * second) / np.diff(k.s)[cell][:, None]
        w, dw, ddw = np.zeros((3, m, n))
        places = 2 * cell[:, None] + np.arange(4)
        for rows, values in zip((w, dw, ddw), (*weights, bend)):
            np.put_along_axis(rows, places, values, axis=1)
        across, along = axis.frame[0], axis.direction
        self.jump = w[:, None] * across[:, None]
        self.jump[:, :, -1] += along
        self.jump_slides = (stands[:, None] * dw)[:, None] * across[:, None]

        # the guide there
        place = self._along + moves * displacement[-1]
        x = axis.origin + (w @ displacement)[:, None] * across + place[:, None] * along
        self.depth = guide.depth(x)
        local, off, rate, clearance, taper, _ = guide.around(x)
        off = np.where(stands, local[:, 1] - guide.centres[station, 0], off[:, 0])
        clearance = np.where(stands, guide.clearance()[station], clearance)
        turn, tilt = float(across @ guide.lateral[0]), dw @ displacement
        self._side = side = np.where(off < 0, -1.0, 1.0)
        leans, taper = np.where(stands, -turn * tilt, rate[:, 0]), moves * taper
        self._a = a = side * leans + taper
        self._steep = np.sqrt(1 + a * a)
        self._distance = (np.abs(off) - clearance) / self._steep

        # and how both change; a node goes up with the axis
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
        a, steep = self._a[:, None], self._steep[:, None]
        return moved / steep - self._distance[:, None] * a * slope / steep**2

    def leave_out(self, axial: float) -> None:
        """Nothing changes at stations that the beam has not reached, or has passed, when its axial
        displacement is this, m."""
        low, high = (end + axial for end in self._reach)
        away = self._stands & ((self._along < low) | (self._along > high))
        self.gap[away], self.gap_slides[away] = 0.0, 0.0

    def bent(self, offset: np.ndarray, slope: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Changes of the slope a and of the gap where the centre line moves by an offset (k,), m,
        with this slope (k,)."""
        change = self._side * slope * ~self._stands
        return change, self._gap(-(self._side * offset)[:, None], change[:, None])[:, 0]
