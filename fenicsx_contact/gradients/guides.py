# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rows of a contact between a beam and its guide, in the plane, in a linearised step.

A node keeps its material and slides past the wall: its normal follows the slope of the wall beside
it. A station keeps its place and sees the material that the start of the step predicts there, at
``s = place - u- - horizon u'-``: its jump, normal and force depend on what slides past.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from copy import copy
from typing import Any

import numpy as np

from ..base import checks
from ..base.vectors import components, dot, slices
from ..contact.contact import Contact
from ..rods import GuideContact
from ..solve.yielding import COMPLIANCE
from ..theory.scheme import Step
from .beams import BeamMotion
from .blocks import Blocks, LinearStep
from .chords import Chord
from .laws import refuse_law
from .parameters import Parameter
from .sight import Sight
from .surface import ContactRows


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
        if contact.measured:  # type: ignore[attr-defined]
            law = contact.friction_law.describe() if contact.friction_law else "its formulation"
            raise checks.InputError(
                f"gradients: contact {contact.name!r} has a law of areas ({law}), which change as "
                "the rod slides past its guide"
            )
        guide = contact.coupling.obstacle  # type: ignore[attr-defined]
        guide.line_curvature(guide.stations)  # a curve may not know it

    def see(self, step: Step) -> None:
        self._back: Sweep | None = None
        super().see(step)
        if self._predicted:
            for points, values in self.contact.candidates.earlier:
                self._back = Sweep(self, points, values)

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
            end = self._back.displacement if self._back else end
            old = Sight(contact, self.points, now, now[-1])
            old.leave_out(now[-1])
            self._sights[key] = old, Sight(contact, self.points, end, ahead[-1])
        return self._sights[key]

    def derivatives(self) -> dict[str, tuple[Any, Any]]:
        d, n, solid = self._d, self.motion.size, self.motion.solid
        old, new = self._seen()
        chord, w = Chord(old, new, solid.displacement), self._weights()
        by_start = w.start * self.old_normal[self.points][:, None] + self._slip[self.points]
        by_slope = w.normal @ new.normal_by[:, :, None] + w.old_normal @ chord.by_slope[:, :, None]
        by_chord = w.old_normal @ chord.by_chord[:, :, None]
        rows = {
            "v": w.jump @ new.jump,
            "v_old": by_start @ new.jump,
            "q_old": w.gap * old.gap[:, None] + by_chord * chord.start[:, None],
        }
        seen = by_slope * new.slope[:, None] + w.end * new.gap[:, None]
        seen += by_chord * chord.end[:, None]
        if self._back:
            rows["q_old"] += seen @ self._back.by_place
            rows["v_old"] += seen @ self._back.by_velocity
        elif self._predicted:
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
        result = {"m": self._by_multipliers()}
        for name, each in rows.items():
            result[name] = each[:, d:].reshape(-1, n), -each[:, :d].reshape(-1, n)
        return result

    def _add_moved(self, parameter: Parameter, result: np.ndarray) -> None:
        old, new = self._seen()
        chord, w = Chord(old, new, self.motion.solid.displacement), self._weights()
        (slope, gap), (_, before) = new.moved(parameter), old.moved(parameter)
        mean = chord.moved(parameter)
        if self._back:
            way = self._back.by(parameter)
            slope, mean = slope + new.slope @ way, mean + chord.end @ way
        if slope.any() or mean.any() or gap.any() or before.any():
            turned = new.normal_by * slope[:, None]
            mirrored = chord.by_slope * slope[:, None] + chord.by_chord * mean[:, None]
            for by_normal, change in ((w.normal, turned), (w.old_normal, mirrored)):
                result += (by_normal @ change[:, :, None])[:, :, 0]
            result += w.end[:, :, 0] * gap[:, None] + w.gap[:, :, 0] * before[:, None]

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


class Sweep:
    """A sweep of a step, to whose candidates others were added: the next one has its normals.

    Args:
        rows: of the contact.
        points, values: the candidates, and the unknowns with which it ended.

    Attributes:
        displacement: of the beam at its end.
        by_place, by_velocity: derivatives of that by the state at the start, (unknowns, unknowns).
    """

    def __init__(self, rows: GuideRows, points: np.ndarray, values: np.ndarray) -> None:
        self._rows, contact = copy(rows), rows.contact
        mine, solid, e = self._rows, rows.motion.solid, contact.equations
        mine.points, mine._sights = points, {}
        old, sight = mine._seen()
        mine.normal, mine.old_normal = rows.normal.copy(), rows.old_normal.copy()
        mine.normal[points] = sight.normal
        mirrored = Chord(old, sight, solid.displacement).normal
        mine.old_normal[points] = np.where(rows.turns[points][:, None], mirrored, sight.normal)
        start = dot(rows.start_jump, mine.old_normal)
        self._start = np.where(np.abs(start) <= contact.resolution, 0.0, start)
        mine.reads_start = (self._start != 0).astype(float)
        self._values, mine.jump = values, values[: e.jumps].reshape(mine.normal.shape)
        n, d = rows.motion.size, rows.normal.shape[1]
        with self._as_it_was():
            mine._linearise()
            mine._force = -e.residual()[components(points, d)]
        lifted = rows.motion.lift(sight.jump.reshape(-1, n).T)
        mine._velocity = solid.free_velocity + lifted @ mine._force
        mine.motion = rows.motion.with_velocity(mine._velocity)
        step = rows.step
        way = step.increment(solid.velocity, mine._velocity, None)
        self.displacement = solid.displacement + way

        # v, multipliers and forces
        kind = np.arange(e.jumps, e.size, len(rows.normal))[:, None] + points
        soft = (COMPLIANCE / (e.column_scale * e.row_scale)[kind]).T.ravel()
        v, m, f = slices([n, len(soft), len(mine._force)])
        rate, early = step.gap_rate, step.dt - step.gap_rate
        by, balance, turned = mine.derivatives(), mine.motion.balance(step), mine.turned()
        plus, one = Blocks((f.stop, f.stop)), np.eye(n)
        plus.add(v, v, one)
        plus.add(v, f, -lifted)
        plus.add(f, f, np.eye(len(mine._force)))
        for at, name in ((v, "v"), (m, "m")):
            plus.add(m, at, by[name][0])
            plus.add(f, at, -by[name][1])
        self._plus, self._soft = plus, np.concatenate([np.zeros(n), soft, 0 * mine._force])
        changes = {}
        for name, own in (("q_old", balance.q_old), ("v_old", balance.v_old)):
            changes[name] = self._solve(own - turned[name], *by[name])
        self.by_place = one + rate * changes["q_old"]
        self.by_velocity = early * one + rate * changes["v_old"]

    def by(self, parameter: Parameter) -> np.ndarray:
        """Derivative of its displacement by a parameter, (unknowns,)."""
        step = self._rows.step
        with self._as_it_was():
            rows = self._rows.by(parameter)
        own = self._rows.motion.by(parameter, step)
        return step.gap_rate * self._solve(own[:, None], *(each[:, None] for each in rows))[:, 0]

    def _solve(self, own: np.ndarray, multipliers: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """Changes of v from those of its rows, of the rows of the multipliers and of the forces."""
        right = np.concatenate([own, multipliers, -forces])
        nothing = Blocks((len(right), 1))
        linear = LinearStep(self._plus, nothing, right, self._soft, [], [])
        return linear.tangent(np.zeros((1, right.shape[1])))[: len(own)]

    @contextmanager
    def _as_it_was(self) -> Iterator[None]:
        """The equations of the contact have the unknowns and normals of the sweep meanwhile."""
        mine, e = self._rows, self._rows.contact.equations
        k = e.fields
        before = e.values, mine.contact.normal, k.start_jump_n.x.array.copy()
        share = k.end_share.x.array.copy()
        told = k.start_normal.x.array.reshape(mine.normal.shape).copy()
        try:
            e.values, k.start_jump_n.x.array[:] = self._values, self._start
            k.set_normal(mine.normal)
            k.set_start_normal(mine.old_normal, share)
            yield
        finally:
            e.values, k.start_jump_n.x.array[:] = before[0], before[2]
            k.set_normal(before[1])
            k.set_start_normal(told, share)
