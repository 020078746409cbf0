# SPDX-License-Identifier: LGPL-3.0-or-later
"""How the velocities of an obstacle that moves as it is told change, in a linearised step.

Jumps at both ends are less by the obstacle's velocities beside the points, E where a step ends and
S where it starts. How fast points come at the start is seen along the normals n+ at the end, where
forces act along these alone (:mod:`fenicsx_contact.contact.ride`)::

    v- . n+  -  S . n-  -  (V . n+  -  M . n-)

V and M: mean velocities of the step beside where the points are at its end and were at its start.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..contact.nodal import NodalJump
from ..contact.ride import Velocity, at_end, at_start, taken
from ..theory.scheme import Step

Change = np.ndarray | float
#: A velocity with which the step before one ended, beside places where this one starts.
_Before = Callable[[Velocity, np.ndarray, Step], np.ndarray]


class Faster(NamedTuple):
    """Derivatives of the obstacle's velocities beside the points as they stand, (n, d, m): of E, S,
    V and M."""

    end: np.ndarray
    start: np.ndarray
    late: np.ndarray
    early: np.ndarray


class Riding:
    """The obstacle of a contact that moves.

    Args:
        coupling: of the contact.

    Attributes:
        velocity: E, (n, d) in m/s.
        end, start: derivatives of E and S by the places at the end and at the start, (n, d, d).
        arriving, arriving_old: how fast points come at the start, of which E and S are a part, by
            both, (n, d).
        gap: the gap at the start, where that is of another face than was met there, by the places
            at the end, (n, d).
    """

    def __init__(self, coupling: NodalJump) -> None:
        self._coupling, self._wall = coupling, coupling.wall
        self._step: Step | None = None
        self._ended: _Before = at_start
        self._taken: _Before = _taken_at_start

    def see(
        self,
        step: Step,
        places: tuple[np.ndarray, np.ndarray],
        normals: tuple[np.ndarray, np.ndarray],
        bends: tuple[np.ndarray, np.ndarray],
        turns: np.ndarray,
    ) -> None:
        """Take up a step that has been solved.

        Args:
            step: it.
            places: at its start and at its end, (n, d) in m.
            normals, bends: of the slave there, and their derivatives by the places.
            turns: where forces act along a mean of both normals, (n,) of bool.
        """
        # what is solved again, or in parts, starts where the last one did
        if (last := self._step) and last != step and step.start >= last.start + 0.5 * last.dt:
            self._after(last)
        self._step, self._places, self._normals = step, places, normals
        self._loose = ~turns & (step.dt > 0 and not self._wall.flat)
        by, start = self.faster(self._wall.velocity), self._coupling.ride.start
        self._differ, self.velocity = (start - by.late, by.early - start), by.end
        by = self.faster(self._wall.velocity_slopes)
        self.end, self.start = by.end, by.start
        self.arriving = self.along(late=by.late, end=bends[1])
        self.arriving_old = self.along(start=by.start, early=by.early, old=bends[0])
        other = self._coupling.other_faces(step)
        late_along = np.einsum("pi,pij->pj", normals[1], by.late)
        self.gap = step.dt * other[:, None] * late_along

    def faster(self, change: Velocity) -> Faster:
        """Derivatives of the velocities, from those of a mean velocity between two times."""
        step, (old, new) = self._step, self._places
        assert step is not None
        struck = _struck(self._taken, change, old, step)
        if not step.dt:  # nothing moves; what changes its velocity strikes with the new one
            return Faster(*[struck] * 4)
        goes_on = self._coupling.ride.percussive
        ends = at_end(change, new, step), self._ended(change, old, step) if goes_on else struck
        means = change(new, step.start, step.end), change(old, step.end, step.start)
        return Faster(*ends, *means)

    def _after(self, last: Step) -> None:
        """Take up with what the step before this one ended."""
        if not last.dt:
            before = self._taken
            self._ended = lambda change, x, step: _struck(before, change, x, last)
            return
        self._ended = lambda change, x, step: at_end(change, x, last)
        if last.implicitness:
            self._taken = lambda change, x, step: taken(change, x, last)

    def along(
        self,
        start: Change = 0.0,
        late: Change = 0.0,
        early: Change = 0.0,
        end: Change = 0.0,
        old: Change = 0.0,
    ) -> np.ndarray:
        """Derivatives of how fast points come at the start, (n, m), from those of S, V and M, and
        of the normals at the end and at the start, all (n, d, m)."""
        n_old, n_end = self._normals
        slower, gain = self._differ

        def times(vectors: np.ndarray, change: Change) -> Change:
            return np.einsum("pi,pim->pm", vectors, change) if np.ndim(change) else 0.0

        turned = times(n_old, early) - times(n_end, late) + times(slower, end) + times(gain, old)
        return np.asarray(np.where(self._loose[:, None], turned, 0.0) - times(n_old, start))


def _struck(before: _Before, change: Velocity, x: np.ndarray, step: Step) -> np.ndarray:
    """The velocity with which its motion goes on at the start of a step, but for the share of
    means, which is that of the last step."""
    return (1 - step.implicitness) * at_start(change, x, step) + before(change, x, step)


def _taken_at_start(change: Velocity, x: np.ndarray, step: Step) -> np.ndarray:
    return step.implicitness * at_start(change, x, step)
