# SPDX-License-Identifier: LGPL-3.0-or-later
"""How an obstacle that moves as it is told moves beside points in a step.

A velocity of its material belongs to a place and an instant, and so does the normal it is seen
along: of a surface that slides into itself, a drum that turns, the component along the normal at
the same place is zero, along that of another place it is not. Where the velocity at the start is
asked for along the normal at the end, the component there is what it was at the start and what it
changes by on the way, by the mean rates of the step: exact for what goes straight on, and for what
turns into itself.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import inf

import numpy as np

from ..base.constants import BRIEF, ROUND_OFF
from ..base.vectors import dot, largest
from ..theory.scheme import Step
from .leaps import brief_time, follows, kink, refuse_leaps
from .wall import Wall

#: A mean velocity beside points between two times, or its derivatives.
Velocity = Callable[[np.ndarray, float, float], np.ndarray]


def at_start(velocity: Velocity, x: np.ndarray, step: Step) -> np.ndarray:
    """At the very start of a step."""
    return _instant(velocity, x, step.start, brief_time(step.start, step.horizon))


def at_end(velocity: Velocity, x: np.ndarray, step: Step) -> np.ndarray:
    """With what velocity a step ends, of which the scheme takes part as the mean in it."""
    late, end = step.implicitness, step.end
    result: np.ndarray | float = 0.0
    if late < 1:
        # of a short part of a step not so brief that round-off shows
        span = min(step.horizon, step.dt / (2 * BRIEF))
        result = result + (1 - late) * _instant(velocity, x, end, -brief_time(end, span))
    return np.asarray(result + taken(velocity, x, step) if late else result)


def taken(velocity: Velocity, x: np.ndarray, step: Step) -> np.ndarray:
    """What of that is the mean in the step."""
    return step.implicitness * velocity(x, step.start, step.end)


def _instant(velocity: Velocity, x: np.ndarray, time: float, brief: float) -> np.ndarray:
    """At an instant, by what follows in a brief time, s, or, if that is negative, by what went
    before: of second order in it."""
    one, two = (velocity(x, *sorted((time, time + k * brief))) for k in (1.0, 2.0))
    return np.asarray(2 * one - two)


class Ride:
    """Velocities of an obstacle's material beside points, (n, d) in m/s.

    It ends a step with a velocity that suits the scheme: by theta = 1 with its mean velocity in the
    step, with which a point that sticks goes exactly the obstacle's way (of one that turns it is
    that beside the place at the end, which leads inwards); by theta = 1/2 with that of the very
    end. A step starts with the velocity with which the last one ended; where the motion has a
    corner there, a percussion sees the new one, and so does a law that knows no percussions.

    Args:
        wall: that moves.
        points: (n, d), how many.
        percussive: whether the law before it does.

    Attributes:
        before: with which the last step ended, or None; ``time``: when that was, s.
        mean: beside where the points were, by the mean rates of the begun step.
        start, end: in the begun step; ``struck``: at its start, if it starts with a percussion.
    """

    def __init__(self, wall: Wall, points: tuple[int, ...], percussive: bool) -> None:
        self._wall, self.percussive = wall, percussive
        self.before: np.ndarray | None = None
        self._taken = np.zeros(points)  # what of that was the mean in the last step
        self.time = 0.0
        self.start = self.end = self.struck = np.zeros(points)
        self._step: Step | None = None
        self._x = self.end  # where the points are at its end, m
        self._start_normal: np.ndarray | None = None
        self._follows = not wall.told  # until it is seen

    def begin(self, step: Step, x: np.ndarray, normal: np.ndarray | None = None) -> None:
        """Begin a step from these places, (n, d) in m, and normals there; None: of the wall."""
        self._step, self._x, wall = step, x, self._wall
        new = at_start(wall.velocity, x, step)
        if self.before is None:
            self.before, self._taken = new, step.implicitness * new
        if not self._follows:
            self._follows = follows(wall, x, step.start)
        late = step.implicitness
        self.struck = (1 - late) * new + self._taken
        self.start = self.before if step.dt and self.percussive else self.struck
        normal = -wall.normals(x, step.start) if normal is None else normal
        self._start_normal = normal
        if wall.flat or not step.dt:
            self.end = self._last_velocity(x)
        else:  # the rates of the step where it starts
            self.mean = mean = wall.velocity(x, step.end, step.start)
            self.end = late * mean + (1 - late) * (2 * mean - new)
        if late < 1 or step.is_part:
            refuse_leaps(wall, x, normal, new, step)

    def follow(self, x: np.ndarray) -> None:
        """The points are there at the end of the begun step, if one is."""
        if self._step:
            self._x, self.end = x, self._last_velocity(x)

    def accept(self) -> None:
        """What the step ended with is what the next one starts with."""
        if (step := self._step) is None:
            return
        self.before, self.time = self.end, step.end
        if step.dt and step.implicitness:
            self._taken = taken(self._wall.velocity, self._x, step)

    def state(self) -> dict[str, np.ndarray]:
        """That as arrays, and when it was: not what a step that failed has begun."""
        before = {} if self.before is None else {"carried": self.before, "taken": self._taken}
        return {"time": np.array(self.time), **before}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Take up what :meth:`state` gave."""
        before = np.array(state["carried"]) if "carried" in state else None
        self._step, self.before, self.time = None, before, float(state["time"])
        self._taken = np.array(state.get("taken", self._taken))
        self.start = self.end = np.zeros_like(self.end) if before is None else before

    def _last_velocity(self, x: np.ndarray) -> np.ndarray:
        """Beside these places at the end of the begun step."""
        step = self._step
        assert step is not None
        return at_end(self._wall.velocity, x, step) if step.dt else self.struck

    def start_speed(self, x: np.ndarray, normal: np.ndarray) -> np.ndarray:
        """The component at the start along the normals at the end, where the points are then."""
        old = self._start_normal
        assert old is not None
        return dot(self.start, old) + self._gain(x, normal, old)

    def _gain(self, x: np.ndarray, normal: np.ndarray, old: np.ndarray) -> np.ndarray | float:
        """By how much the component along the normals changes on the way from the old ones, by the
        mean rates."""
        step = self._step
        assert step is not None
        if not step.dt:
            return 0.0
        return dot(self._wall.velocity(x, step.start, step.end), normal) - dot(self.mean, old)

    def aside(
        self,
        x: np.ndarray,
        normals: tuple[np.ndarray | None, np.ndarray],
        force: np.ndarray,
        share: np.ndarray,
    ) -> np.ndarray:
        """What is missing in the mean of the velocities at both ends, (n, d): its component along
        which forces act is made of those along the normals where they are.

        Args:
            x: where the points are at the end, (n, d) in m.
            normals: at the start, None: those of the wall, and at the end, (n, d). (In a guide they
                are mirrored, for of opposite walls there is no mean.)
            force: along which forces act, (n, d): a mean of both.
            share: what those at the end count in it, (n,).
        """
        assert self._step is not None and self._start_normal is not None
        average, (old, normal) = self._step.scheme.mean, normals
        old = self._start_normal if old is None else old
        mean = average(self.start, self.end)
        first, last = dot(self.start, old), dot(self.end, normal)
        gain = self._gain(x, normal, old) if (2 * share != 1).any() else 0.0
        along = share * average(first + gain, last) + (1 - share) * average(first, last - gain)
        size = np.linalg.norm(share[:, None] * normal + (1 - share)[:, None] * old, axis=1)
        return (along / size - dot(mean, force))[:, None] * force

    def sudden(self, x: np.ndarray, own: np.ndarray, gap: np.ndarray, step: Step) -> float:
        """After how long in a step it changes its velocity at once, so that it reaches points at
        x, (n, d) in m, with velocities, (n, d) in m/s, and gaps, (n,) in m; s; inf if it does not.
        """
        normals = -self._wall.normals(x, step.start)
        found = kink(
            lambda *times: dot(self._wall.velocity(x, *times), normals),
            *(step.start, step.end),
            ROUND_OFF * largest(x),
        )
        if found is None:
            return inf
        time, before, after = found
        along = dot(own, normals)
        way = (time - step.start) * (along - before) + (step.end - time) * (along - after)
        return time - step.start if (gap + way > 0).any() else inf
