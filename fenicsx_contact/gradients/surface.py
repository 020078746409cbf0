# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rows of a contact in a linearised step: its multipliers, and the forces that it gives.

The jump is ``w = J(q+) v+``; gaps and normals are those of the points' places. The rows of the
weak form are UFL, and so are their derivatives by the jump, the multipliers, the gap, the normal
and the jump at the start; here they meet the solid's kinematics.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from ..base.vectors import components
from .kinematics import spread, square
from .motion import Motion
from .parameters import Parameter
from .reads import Weights
from .seen import Pushed
from .solved import SolvedContact


class ContactRows(SolvedContact):
    """The rows of a contact with an obstacle; see :class:`~.solved.SolvedContact`."""

    # -- its rows ---------------------------------------------------------------------------------

    def derivatives(self) -> dict[str, tuple[Any, Any]]:
        """Of the rows of the multipliers, and of the forces at the candidates (k d, ...): by ``v``,
        ``q`` at the end, ``v_old``, ``q_old``, by the multipliers, ``m``, and by what was
        remembered at the start, ``r_old``."""
        p, d, ends = self.points, self._d, self._d + self._more
        T, w = self.reads.own[p], self._weights(p)
        result = {"m": (square(T[:, d:ends, d:]), -square(T[:, :d, d:]))}
        if self.remembered:
            n = len(self.normal)
            result["r_old"] = tuple(  # type: ignore[assignment]
                sign * spread(w.old[:, rows], n, p)
                for sign, rows in ((1, slice(d, ends)), (-1, slice(0, d)))
            )
        for name, (rows, forces) in self._changes(p, w, (slice(d, ends), slice(0, d))).items():
            result[name] = rows, -forces
        return result

    def remembering(self) -> dict[str, Any]:
        """Of what is remembered at the end, point by point, by the same."""
        n, d, ends = len(self.normal), self._d, self._d + self._more
        every, last = np.arange(n), slice(ends, None)
        w, rows = self._weights(every), self.reads.own[self.points, ends:]
        result = {name: each for name, (each,) in self._changes(every, w, (last,)).items()}
        result["m"] = spread(rows[:, :, d:], n, self.points, rows=True)
        result["r_old"] = square(w.old[:, last])
        return result

    def _changes(
        self, points: np.ndarray, w: Weights, parts: Sequence[slice]
    ) -> dict[str, tuple[Any, ...]]:
        """Derivatives of parts of the rows of points by ``v``, ``q``, ``v_old`` and ``q_old``."""
        p, d = points, self._d
        new, old = self.new.at(p, d), self.old.at(p, d)
        # what the rows depend on: velocities and places at the end, and at the start
        by_place = w.end * self.slope[p][:, None] + w.normal @ self.bend[p] + w.place
        by_start = w.start * self.old_normal[p][:, None] + w.slip
        by_gap = w.gap * self.old_slope[p][:, None] + w.old_normal @ self._old_bend[p] + w.old_place
        if ride := self.riding:
            by_place = by_place - w.jump @ ride.end[p]
            by_place += w.start * ride.arriving[p][:, None] + w.gap * ride.gap[p][:, None]
            by_gap = by_gap - w.slip @ ride.start[p] + w.start * ride.arriving_old[p][:, None]
        result = {}

        def told(weights: Callable[[slice], Any]) -> tuple[Any, ...]:
            return tuple(weights(rows) for rows in parts)

        result["v"] = told(lambda r: new.by_place(w.jump[:, r]))
        if by_place.any() or new.bend is not None:
            result["q"] = told(lambda r: new.by_both(w.jump[:, r], by_place[:, r]))
        if by_start.any():
            result["v_old"] = told(lambda r: old.by_place(by_start[:, r]))
        if by_gap.any() or (by_start.any() and old.bend is not None):
            result["q_old"] = told(lambda r: old.by_both(by_start[:, r], by_gap[:, r]))
        return result

    def begun(self, parameter: Parameter) -> np.ndarray | float:
        """Derivative of what is remembered at the start of the run by a parameter."""
        number = parameter.constant(self.contact)
        if number is None or not self.remembered:
            return 0.0
        return self.reads.begun(number).ravel()

    def by(self, parameter: Parameter) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Derivatives of the same by a parameter: of the multipliers, the forces, and what is
        remembered."""
        p, d, ends = self.points, self._d, self._d + self._more
        result = np.zeros((len(self.normal), self.reads.own.shape[1]))
        if (number := parameter.constant(self.contact)) is not None:
            result += self.reads.by_constant(number)
        result[p] += self._moved(parameter, p)
        at = result[p]
        return at[:, d:ends].ravel(), -at[:, :d].ravel(), result[:, ends:].ravel()

    def _moved(self, parameter: Parameter, points: np.ndarray) -> np.ndarray | float:
        """What moves with the obstacle in the rows of the points, (k, rows of a point)."""
        p, contact, step, result = points, self.contact, self.step, 0.0
        if (wall := parameter.wall(contact, self.places, step.end)) is None:
            return result
        before, w = parameter.wall(contact, self.old_places, step.start), self._weights(p)
        assert before is not None
        ends = (wall, w.end, w.normal), (before, w.gap, w.old_normal)
        for (closer, turned), by_gap, by_normal in ends:  # those of the slave: the opposite
            result = result - by_gap[:, :, 0] * closer[p][:, None]
            result -= np.einsum("pci,pi->pc", by_normal, turned[p])
        if self.riding:
            end, slip, arriving = self.drive(parameter, wall[1], before[1])
            result -= np.einsum("pci,pi->pc", w.jump, end[p])
            result -= np.einsum("pci,pi->pc", w.slip, slip[p])
            result += w.start[:, :, 0] * arriving[p][:, None]
        return result

    def drive(
        self, parameter: Parameter, turned: np.ndarray, before: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Derivatives by a parameter of the velocities of an obstacle that moves where the step
        ends and where it starts, (n, d), and of how fast points come there, (n,), from those of its
        normals."""
        ride, contact = self.riding, self.contact
        assert ride is not None
        by = ride.faster(lambda *at: parameter.drive(contact, *at)[:, :, None])
        normals = {"end": -turned[:, :, None], "old": -before[:, :, None]}
        along = ride.along(start=by.start, late=by.late, early=by.early, **normals)
        return by.end[:, :, 0], by.start[:, :, 0], along[:, 0]

    def gap_row(self, point: int) -> np.ndarray:
        """Derivative of the gap of a point at the end by q, (size,)."""
        wall = self.contact.coupling.wall  # type: ignore[attr-defined]
        slope = -wall.slopes(self.at.end_places[point : point + 1], self.step.end)[0]
        row = slope @ self.at.ends.place[point * self._d : (point + 1) * self._d]
        return np.asarray(row).ravel()

    def gap_by(self, parameters: Sequence[Parameter], point: int) -> np.ndarray:
        """And by parameters, (p,)."""
        place = self.at.end_places[point : point + 1]
        time = self.step.end
        walls = [parameter.wall(self.contact, place, time) for parameter in parameters]
        return np.array([0.0 if wall is None else -wall[0][0] for wall in walls])

    def spread(self) -> Any:
        """Minus the operator from forces at the candidates to those on the solid, (size, k d)."""
        forced = self.at.forces
        if forced is self.new.place and not isinstance(forced, np.ndarray):
            return Pushed(self.new.at(self.points, self._d).place)
        return -forced[components(self.points, self._d)].T

    @staticmethod
    def key(name: str, number: int) -> str:
        """What a derivative by q, v, ... of a solid of the contact is called."""
        return name if not number else f"{name} of the master"

    def spreads(self) -> Iterator[tuple[Motion, Any]]:
        """The same, solid by solid."""
        yield self.motion, self.spread()

    def bent(self) -> Iterator[tuple[Motion, str, Any]]:
        """Derivatives of J' f at fixed forces on each solid, by what J depends on."""
        for name, block in self.turned().items():
            yield self.motion, name, block

    def read(self) -> list[tuple[Motion, Any]]:
        """Operators from solids to the places of nodes, ``"y"``, by which their forces on each
        other change; of obstacles none."""
        return []

    def turned(self) -> dict[str, Any]:
        """Derivatives of J' f at fixed forces, of what J depends on."""
        forces = np.zeros_like(self.places)
        forces[self.points] = self._force.reshape(-1, self._d)
        return self.at.turned(forces)

    def soft(self, compliance: float) -> np.ndarray:
        """A compliance of the multipliers, from one of scaled unknowns and rows."""
        columns, rows = self.contact.equations.scales()
        jumps = len(self.points) * self._d
        each = len(self.points)
        return (compliance / (columns * rows)[jumps:]).reshape(self._more, each).T.ravel()
