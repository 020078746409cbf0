# SPDX-License-Identifier: LGPL-3.0-or-later
"""Many obstacles as one: the pins of a board, the rollers of a conveyor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..base import checks
from .obstacle import Obstacle
from .wall import Wall


class Union:
    """All of several obstacles, of which a point sees the nearest.

    A contact with each costs one a step, whether it is near or not. A point that may touch two at
    once, in a notch between them, needs a contact with each.

    Args:
        obstacles: at least one, all in the plane or all in space.

    Raises:
        InputError: none, something else, or unlike dimensions.
    """

    flat = False

    def __init__(self, obstacles: Sequence[Obstacle]) -> None:
        every = checks.listed("obstacles", obstacles, "at least one obstacle")
        if not every:
            raise checks.InputError("obstacles = []: must be a list of at least one obstacle")
        self.walls = [Wall(each, f"obstacles[{k}]") for k, each in enumerate(every)]
        self.dim = self.walls[0].dim
        for k, wall in enumerate(self.walls):
            if wall.dim != self.dim:
                raise checks.InputError(
                    f"obstacles[{k}].dim = {wall.dim}: must be {self.dim}, as of the others"
                )
        self.moving = any(wall.moving for wall in self.walls)
        #: Derivatives of the normals, if all tell them.
        self.curvature = self._curvature if all(wall.smooth for wall in self.walls) else None
        if all(wall.smooth_velocity for wall in self.walls):
            self.velocity_slopes = self._velocity_slopes
        # what was asked last, and told: one tuple, as several threads may ask
        self._last: tuple[np.ndarray, float, np.ndarray, np.ndarray] | None = None

    def _nearest(self, points: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
        """The least distances of the points, (n,) in m, and whose they are, (n,)."""
        last = self._last
        if last is None or time != last[1] or not np.array_equal(points, last[0]):
            every = np.array([wall.distance(points, time) for wall in self.walls])
            which = every.argmin(axis=0)
            last = points.copy(), time, every[which, np.arange(len(points))], which
            self._last = last
        return last[2:]

    def _of_each(self, what: str, size: int, points: np.ndarray, *times: float) -> np.ndarray:
        """What the nearest obstacles, at the last of these times, answer for the points."""
        d, which = self.dim, self._nearest(points, times[-1])[1]
        result = np.zeros((len(points), *[d] * size))
        for k in np.unique(which):
            answer = getattr(self.walls[k], what)(points[which == k], *times)
            result[which == k] = np.zeros(1) if answer is None else answer
        return result

    def distance(self, points: np.ndarray, time: float) -> np.ndarray:
        """Signed distance of the points (n, d) from the nearest, positive outside of all."""
        return self._nearest(points, time)[0].copy()

    def normals(self, points: np.ndarray, time: float) -> np.ndarray:
        """Outward unit normals of the nearest, (n, d)."""
        return self._of_each("normals", 1, points, time)

    def slopes(self, points: np.ndarray, time: float) -> np.ndarray:
        """Derivatives of the distances by the position, (n, d)."""
        return self._of_each("slopes", 1, points, time)

    def _velocity_slopes(self, points: np.ndarray, start: float, end: float) -> np.ndarray:
        return self._of_each("velocity_slopes", 2, points, start, end)

    def _curvature(self, points: np.ndarray, time: float) -> np.ndarray:
        """(n, d, d) in 1/m; what is flat tells none."""
        return self._of_each("curvature", 2, points, time)

    def velocity(self, points: np.ndarray, start: float, end: float) -> np.ndarray:
        """Mean velocity of the nearest from start to end, (n, d)."""
        return self._of_each("velocity", 1, points, start, end)

    def __repr__(self) -> str:
        return f"Union([{', '.join(wall.describe() for wall in self.walls)}])"
