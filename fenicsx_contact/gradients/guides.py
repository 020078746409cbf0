# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rows of a contact between a beam and its guide, in the plane, in a linearised step.

A node keeps its material and slides past the wall: its normal follows the slope of the wall beside
it. A station keeps its place and sees the material that the start of the step predicts there, at
``s = place - u- - horizon u'-``: its jump, normal and force depend on what slides past.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

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
        guide.curvature(guide.stations)  # a curve may not know it

    def _kinematics(self) -> None:
        contact, solid = self.contact, self.motion.solid
        self.start_jump, self.jump = contact.jump, contact.trial_jump
        self.normal = contact.normal
        now, ahead = solid.displacement, solid.displacement + self.motion.horizon * solid.velocity
        self._old = Sight(contact, now, now[-1])
        end = ahead if self._predicted else solid.trial_displacement
        self._new = Sight(contact, end, ahead[-1])
        self._old.leave_out(now[-1])

    def _weights(self) -> tuple[np.ndarray, ...]:
        """Derivatives of the rows at the candidates, (k, rows, ...), by the jump at the end and at
        the start, by the normal, and by the gap at the start and at the end."""
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
        p, d, solid, new = self.points, self._d, self.motion.solid, self._new
        by_jump, by_start, by_normal, by_gap, by_end = self._weights()
        J, turn = new.jump[p], new.normal_by[p]
        rows = {
            "v": by_jump @ J,
            "v_old": by_start @ J,
            "q_old": by_gap * self._old.gap[p][:, None],
        }
        seen = by_normal @ (turn[:, :, None] * new.slope[p][:, None])
        seen = seen + by_end * new.gap[p][:, None]
        if self._predicted:
            rows["q_old"] += seen
            rows["v_old"] += self.motion.horizon * seen
        else:
            rows["q"] = seen
        slides = by_normal @ (turn * new.slope_slides[p][:, None])[:, :, None]
        slides = slides + by_end * new.gap_slides[p][:, None, None]
        slides = slides + by_jump @ (new.jump_slides[p] @ solid.trial_velocity)[:, :, None]
        slides = slides + by_start @ (new.jump_slides[p] @ solid.velocity)[:, :, None]
        rows["q_old"][:, :, -1:] -= slides + by_gap * self._old.gap_slides[p][:, None, None]
        rows["v_old"][:, :, -1:] -= self.motion.horizon * slides
        T = self._blocks[p]
        result: dict[str, tuple[Any, Any]] = {"m": (square(T[:, d:, d:]), -square(T[:, :d, d:]))}
        for name, each in rows.items():
            multipliers, forces = each[:, d:], each[:, :d]
            n = self.motion.size
            result[name] = multipliers.reshape(-1, n), -forces.reshape(-1, n)
        return result

    def by(self, parameter: Parameter) -> tuple[np.ndarray, np.ndarray]:
        p, d = self.points, self._d
        result = np.zeros(self._blocks[p].shape[:2])
        if (rows := parameter.rows(self.contact)) is not None:
            result += rows[p]
        bends = [parameter.bend(self.contact, sight.depth) for sight in (self._old, self._new)]
        if bends[0] is not None and bends[1] is not None:
            _, _, by_normal, by_gap, by_end = self._weights()
            (_, old), (slope, new) = (s.bent(*b) for s, b in zip((self._old, self._new), bends))
            turned = self._new.normal_by[p] * slope[p][:, None]
            result += (by_normal @ turned[:, :, None])[:, :, 0]
            result += by_gap[:, :, 0] * old[p][:, None] + by_end[:, :, 0] * new[p][:, None]
        return result[:, d:].ravel(), -result[:, :d].ravel()

    def spread(self, forces: np.ndarray) -> Any:
        """Velocities that forces at the candidates make in the step."""
        J = self._new.jump[self.points].reshape(-1, self.motion.size)
        return self.motion.lift(J.T) @ forces

    def turned(self) -> dict[str, Any]:
        p, n = self.points, self.motion.size
        slides = self._new.jump_slides[p].reshape(-1, n).T @ self._force
        column = sp.csr_matrix(self.motion.lift(slides)[:, None])
        column = sp.hstack([sp.csr_matrix((n, n - 1)), column], format="csr")
        return {"q_old": -column, "v_old": -self.motion.horizon * column}


class Sight:
    """What the points of a beam see of the guide around them, and what that depends on.

    With a the slope of the wall (of the beam, at a station) towards the axis the normal is
    ``(a, -1)/sqrt(1 + a²)`` in the direction of the guide and across, and the gap
    ``(|off| - c)/sqrt(1 + a²)``. What slides is the derivative by s of the material at a station.

    Args:
        contact: the contact.
        displacement: of the beam.
        seen: axial displacement by which the stations find their material, m.

    Attributes:
        depth: of the points, (n,) in m.
        jump, jump_slides: operator of the velocities, and what slides of it, (n, d, unknowns).
        normal_by: derivative of the normals by the slope a, (n, d).
        slope, slope_slides: derivative of that by the displacement, (n, unknowns), and (n,).
        gap, gap_slides: of the gap, likewise.
    """

    def __init__(self, contact: GuideContact, displacement: np.ndarray, seen: float) -> None:
        rod, guide = contact.solid.rod, contact.obstacle
        axis, k, n = rod.axis, rod.matrices, len(displacement)
        self._along, self._reach = axis.along(contact.surface.points), axis.stretch(contact.facets)
        m = len(self._along)
        self._stands = np.zeros(m, dtype=bool)
        self._stands[contact.stations] = True
        stands, moves = self._stands[:, None], ~self._stands[:, None]

        # the beam there
        cell, xi, weights = k.interpolate(self._along - self._stands * seen)
        second = k.shapes[1, cell, 1] + 2 * xi[:, None] * k.shapes[1, cell, 2]
        second = second / np.diff(k.s)[cell][:, None]
        w, dw, ddw = np.zeros((3, m, n))
        places = 2 * cell[:, None] + np.arange(4)
        for rows, values in zip((w, dw, ddw), (*weights, second)):
            np.put_along_axis(rows, places, values, axis=1)
        up = np.zeros(n)
        up[-1] = 1.0
        across, along = axis.frame[0], axis.direction
        self.jump = w[:, None] * across[:, None] + up * along[:, None]
        self.jump_slides = (stands * dw)[:, None] * across[:, None]

        # the guide there
        place = self._along + ~self._stands * displacement[-1]
        x = axis.origin + (w @ displacement)[:, None] * across + place[:, None] * along
        self.depth = guide.depth(x)
        _, _, rate, _, taper, _ = guide.around(x)
        off, clearance = guide.holes(x, contact.stations)
        self._side = np.where(off[:, 0] < 0, -1.0, 1.0)
        self._turn = float(across @ guide.lateral[0])
        rate, taper = moves[:, 0] * rate[:, 0], moves[:, 0] * taper
        side, turn = self._side[:, None], self._turn
        leans = np.where(self._stands, -turn * (dw @ displacement), rate)
        a = self._side * leans + taper
        self._steep = np.sqrt(1 + a * a)
        self._distance = (np.abs(off[:, 0]) - clearance) / self._steep
        self._a = a

        # and how both change; a node goes up with the axis
        self.normal_by = -(guide.direction + (self._side * a)[:, None] * guide.lateral[0])
        self.normal_by = self.normal_by / self._steep[:, None] ** 3
        bend = moves[:, 0] * guide.curvature(self.depth)
        self.slope = side * (-turn * stands * dw - bend[:, None] * up)
        self.slope_slides = -self._side * turn * self._stands * (ddw @ displacement)
        moved = side * (turn * w + rate[:, None] * up) + taper[:, None] * up
        self.gap = self._gap(moved, self.slope)
        slid = self._side * turn * self._stands * (dw @ displacement)
        self.gap_slides = self._gap(slid[:, None], self.slope_slides[:, None])[:, 0]

    def _gap(self, moved: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """Change of the gap from those of ``|off| - c`` and of the slope, (n, ...)."""
        a, steep = self._a[:, None], self._steep[:, None]
        return moved / steep - self._distance[:, None] * a * slope / steep**2

    def leave_out(self, axial: float) -> None:
        """Nothing changes at stations that the beam has not reached, or has passed, when its axial
        displacement is this, m."""
        low, high = (end + axial for end in self._reach)
        away = self._stands & ((self._along < low) | (self._along > high))
        self.gap[away], self.gap_slides[away] = 0.0, 0.0

    def bent(self, offset: np.ndarray, slope: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Changes of the slope a and of the gap where the centre line moves by an offset (n,), m,
        with this slope (n,)."""
        change = self._side * slope * ~self._stands
        return change, self._gap(-(self._side * offset)[:, None], change[:, None])[:, 0]
