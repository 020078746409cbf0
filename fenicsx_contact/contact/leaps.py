# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whether what moves as it is told jumps, no velocity follows that, or its velocity does."""

from __future__ import annotations

from collections.abc import Callable
from itertools import compress
from typing import NamedTuple

import numpy as np

from ..base.checks import StepFailed
from ..base.constants import BRIEF, RIGHT, ROUND_OFF, SHARP
from ..base.vectors import dot, largest
from ..theory.scheme import Step
from .answers import wrong
from .wall import Wall


def brief_time(time: float, span: float) -> float:
    """Over which what moves as it is told is differentiated at a time in a span, s: a share of it
    that the clock tells as finely."""
    return max(BRIEF * span, float(np.spacing(time)) / BRIEF)


class Leap(NamedTuple):
    """How far it jumps, m, and after when, s."""

    size: float
    time: float


def leap(
    place: Callable[[float], np.ndarray], start: float, end: float, noise: float
) -> Leap | None:
    """The jump that is more than half of the way between two times, or None.

    Of a motion that is continuous the half of its time in which it goes farther is halved until
    less than half of the way is left; of one that jumps it never is, down to the round-off of both
    times.

    Args:
        place: as a function of the time, (n,) in m.
        start, end: times, s.
        noise: what is shorter is round-off, m.
    """
    way = place(end) - place(start)
    if not largest(way) > noise:
        return None
    at, first, last = int(np.abs(way).argmax()), start, end
    size = whole = abs(way[at])
    # about t = 0 numbers go on to 5e-324, of which a motion may have no powers
    least = np.spacing(max(abs(start), abs(end)))
    while last - first > least:
        middle = 0.5 * (first + last)
        here = place(middle)[at]
        left, right = abs(here - place(first)[at]), abs(place(last)[at] - here)
        first, last, size = (first, middle, left) if left > right else (middle, last, right)
        if size <= 0.5 * whole:
            return None
    # what begins to move at the very end goes on
    after = abs((place(last + (end - start)) - place(last))[at])
    return Leap(float(size), first) if size > max(noise, after) else None


def kink(
    speed: Callable[[float, float], np.ndarray], start: float, end: float, noise: float
) -> tuple[float, np.ndarray, np.ndarray] | None:
    """When within two times speeds jump by more than half of what they change by between them, s,
    and the speeds at both, (n,) in m/s; or None.

    The time is halved as by :func:`leap`. Seen from before and from behind speeds are known right
    beside a time, so that no half has a part of the jump; beside the ends they are not, and a jump
    there is none.

    Args:
        speed: the mean one between two times, (n,) in m/s.
        start, end: times, s.
        noise: what is shorter is round-off, m.
    """
    brief = brief_time(end, BRIEF * (end - start))
    first, last = bounds = start + brief, end - brief
    before, after = speed(start, first), speed(last, end)
    at = int(np.abs(after - before).argmax())
    low, high = before[at], after[at]
    if not (whole := abs(high - low)) > noise / brief:
        return None
    while first < (middle := 0.5 * (first + last)) < last:
        ahead, behind = speed(middle, middle + brief)[at], speed(middle - brief, middle)[at]
        left, right = abs(ahead - low), abs(high - behind)
        if max(left, right) <= 0.5 * whole:
            return None
        first, last, low, high = (
            (first, middle, low, ahead) if left > right else (middle, last, behind, high)
        )
    within = first > bounds[0] and last < bounds[1]
    return (first, before, after) if within else None


def no_velocity(what: str, size: float, time: float) -> StepFailed:
    """Why a step fails in which something jumps so far, m, after that time, s."""
    return StepFailed(
        f"{what} jumps by {size:.4g} m at t = {time:.9g} s: no velocity follows that, for which "
        "theta < 1 and located impacts ask"
    )


def follows(wall: Wall, points: np.ndarray, time: float) -> bool:
    """Whether an obstacle's distances were seen to change as its velocity says: False where none of
    the points, (n, d), has reached its surface, or nothing moves there.

    Raises:
        StepFailed: they change otherwise at all of these.
    """
    off, size = wall.distance(points, time), float(np.ptp(points, axis=0).max())
    reach = RIGHT * (size or float(np.abs(points).max()))
    if not (on := off <= reach).any():
        return False
    beside = points + reach * wall.normals(points, time)  # of edges
    speed = largest(wall.velocity(beside, time, time + reach)[on])
    brief = max(0.1 * reach / speed, float(np.spacing(time)) / RIGHT) if speed else reach
    velocity = wall.velocity(beside, time, time + brief)[on]
    told = dot(velocity, wall.normals(beside, time)[on]) * brief
    gone = (wall.distance(beside, time) - wall.distance(beside, time + brief))[on]
    sizes = np.maximum(np.abs(told), np.abs(gone))
    moves = sizes > (1 - SHARP) * np.linalg.norm(velocity, axis=1) * brief
    moves &= sizes > ROUND_OFF * largest(points) / RIGHT
    if not moves.any():
        return False
    if (np.abs(told - gone) > (1 - SHARP) * sizes)[moves].all():
        at = int((moves * sizes).argmax())
        found = f"{told[at] / brief:.6g} m/s along its normal at {points[on][at].tolist()}"
        raise wrong("velocity", found, f"{gone[at] / brief:.6g} m/s, by its distances")
    return True


def refuse_leaps(
    wall: Wall, points: np.ndarray, normals: np.ndarray, first: np.ndarray, step: Step
) -> None:
    """Refuse an obstacle that jumps in a step or where its velocities at the ends are asked for.

    Args:
        points, normals: beside and along which it is looked at, (n, d) in m and 1.
        first: its velocity at the start, (n, d) in m/s.

    Raises:
        StepFailed: it does.
    """
    start, end = step.coming.start, step.coming.end
    brief, noise = brief_time(end, end - start), ROUND_OFF * largest(points)
    intervals = [(start, start + brief), (end - brief, end), (start, end)]
    velocities = [first, *(wall.velocity(points, *each) for each in intervals[1:])]
    at_start, at_end, mean = (largest(dot(velocity, normals)) for velocity in velocities)
    # a jump at an end makes that velocity many times the mean one, any other the mean one
    doubtful = [at_start > 2 * mean, at_end > 2 * mean, mean > 2 * max(at_start, at_end)]

    def place(time: float) -> np.ndarray:
        return wall.distance(points, time)

    for interval in compress(intervals, doubtful):
        if found := leap(place, *interval, noise):
            raise no_velocity(f"the obstacle {wall.describe()}", *found)
