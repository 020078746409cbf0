# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rows of a contact between a beam and its guide, in the plane, in a linearised step.

A node keeps its material and slides past the wall: its normal follows the slope of the wall beside
it. A station keeps its place and sees the material that the start of the step predicts there, at
``s = place - u- - horizon u'-``: its jump, normal and force depend on what slides past.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base import checks
from ..contact.contact import Contact
from ..rods import GuideContact
from .beams import BeamMotion
from .chords import Chord
from .parameters import Parameter
from .reads import Weights
from .sight import Sight
from .surface import ContactRows


class GuideRows(ContactRows):
    """A beam in a guide; see :class:`~.surface.ContactRows`."""

    contact: GuideContact
    motion: BeamMotion

    def __init__(self, contact: GuideContact, motion: BeamMotion, settles: bool) -> None:
        super().__init__(contact, motion)
        if self.remembered:
            raise checks.InputError(
                f"gradients: contact {contact.name!r} remembers {self.reads.names[0]!r}, past "
                "which the rod slides in its guide"
            )
        # a law that reads no gap of the end settles with the normals of the prediction
        self._predicted = settles and not contact.formulation.gap_share

    def _refuse(self, contact: Contact) -> None:
        if contact.equations.fields.located:
            raise checks.InputError(
                f"gradients: contact {contact.name!r} has a law of the place, in a guide"
            )
        if contact.measured:  # type: ignore[attr-defined]
            law = contact.friction_law.describe() if contact.friction_law else "its formulation"
            raise checks.InputError(
                f"gradients: contact {contact.name!r} has a law of areas ({law}), which change as "
                "the rod slides past its guide"
            )
        guide = contact.coupling.obstacle  # type: ignore[attr-defined]
        guide.line_curvature(guide.stations)  # a curve may not know it

    def _kinematics(self) -> None:
        contact, solid = self.contact, self.motion.solid
        self._velocity = solid.trial_velocity
        self.start_jump, self.jump = contact.jump, contact.trial_jump
        self.normal, self.turns = contact.normal, self._turns()
        self.old_normal = contact.equations.fields.old_normal()
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

    def _changes(
        self, points: np.ndarray, w: Weights, parts: Sequence[slice]
    ) -> dict[str, tuple[Any, ...]]:
        n, solid = self.motion.size, self.motion.solid
        old, new = self._seen()
        chord = Chord(old, new, solid.displacement)
        by_start = w.start * self.old_normal[points][:, None] + w.slip
        by_slope = w.normal @ new.normal_by[:, :, None] + w.old_normal @ chord.by_slope[:, :, None]
        by_chord = w.old_normal @ chord.by_chord[:, :, None]
        rows = {
            "v": w.jump @ new.jump,
            "v_old": by_start @ new.jump,
            "q_old": w.gap * old.gap[:, None] + by_chord * chord.start[:, None],
        }
        seen = by_slope * new.slope[:, None] + w.end * new.gap[:, None]
        seen += by_chord * chord.end[:, None]
        if self._predicted:
            rows["q_old"] += seen
            rows["v_old"] += self.motion.horizon * seen
        else:
            rows["q"] = seen
        slides = by_slope * new.slope_slides[:, None, None]
        slides += w.end * new.gap_slides[:, None, None] + by_chord * chord.slides[:, None, None]
        slides += w.jump @ (new.jump_slides @ self._velocity)[:, :, None]
        slides += by_start @ (new.jump_slides @ solid.velocity)[:, :, None]
        slid = w.gap * old.gap_slides[:, None, None] + by_chord * chord.slid[:, None, None]
        rows["q_old"][:, :, -1:] -= slides + slid
        rows["v_old"][:, :, -1:] -= self.motion.horizon * slides
        return {
            name: tuple(each[:, part].reshape(-1, n) for part in parts)
            for name, each in rows.items()
        }

    def _moved(self, parameter: Parameter, points: np.ndarray) -> np.ndarray | float:
        old, new = self._seen()
        chord, w = Chord(old, new, self.motion.solid.displacement), self._weights(points)
        (slope, gap), (_, before) = new.moved(parameter), old.moved(parameter)
        mean = chord.moved(parameter)
        if not (slope.any() or mean.any() or gap.any() or before.any()):
            return 0.0
        turned = new.normal_by * slope[:, None]
        mirrored = chord.by_slope * slope[:, None] + chord.by_chord * mean[:, None]
        result = w.end[:, :, 0] * gap[:, None] + w.gap[:, :, 0] * before[:, None]
        for by_normal, change in ((w.normal, turned), (w.old_normal, mirrored)):
            result += (by_normal @ change[:, :, None])[:, :, 0]
        return result

    def spread(self) -> Any:
        """Minus the operator from forces at the candidates to velocities that they make."""
        J = self._seen()[1].jump.reshape(-1, self.motion.size)
        return -self.motion.lift(J.T)

    def turned(self) -> dict[str, Any]:
        n = self.motion.size
        slides = self._seen()[1].jump_slides.reshape(-1, n).T @ self._force
        by_place = np.zeros((n, n))
        by_place[:, -1] = -self.motion.lift(slides)
        return {"q_old": by_place, "v_old": self.motion.horizon * by_place}
