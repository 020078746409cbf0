# SPDX-License-Identifier: LGPL-3.0-or-later
"""Obstacles that turn: cams, drums, turntables, mills."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..base import checks
from ..base.shown import shown
from ..solids.rotations import GENERATORS, rotation_matrix
from .obstacle import Carried
from .wall import Obstacle


class Turned(Carried):
    """An obstacle that is turned about a fixed point, or in space about an axis through it.

    Its material goes round with it and drags along what rubs on it. One that also goes along a way
    is ``Moved(Turned(...), way)``.

    Args:
        obstacle: any obstacle.
        about: the point, d coordinates in m.
        angle: as a function of the time [s], rad, counterclockwise (about ``axis``).
        axis: in space, of any length but zero.

    Raises:
        InputError: no obstacle, an angle that is no function of the time, an axis in the plane or
            none in space.
    """

    flat = False

    def __init__(
        self,
        obstacle: Obstacle,
        about: Sequence[float],
        angle: Callable[[float], Any],
        axis: Sequence[float] | None = None,
    ) -> None:
        checks.function("angle", angle, " of the time")
        super().__init__(obstacle)
        self._angle = angle
        self.about, self.axis = checks.vector("about", about, self.dim), None
        if self.dim == 3:
            if axis is None:
                raise checks.InputError("axis = None: must be 3 numbers for an obstacle in space")
            self.axis = checks.direction("axis", axis, 3)
        elif axis is not None:
            raise checks.InputError(f"axis = {axis!r}: must be None for an obstacle in the plane")
        self._along = np.ones(1) if self.axis is None else self.axis
        self._spin = np.tensordot(self._along, GENERATORS[self.dim], 1)  # d/d angle at 0
        self.angle(0.0)

    def angle(self, time: float) -> float:
        """At a time, rad."""
        what = f"angle({time:g})"
        return checks.number(what, checks.called(what, self._angle, time))

    def distance(self, points: np.ndarray, time: float) -> np.ndarray:
        """Signed distance of the points (n, d), positive outside."""
        return self._wall.distance(self._back(points, time), time)

    def normals(self, points: np.ndarray, time: float) -> np.ndarray:
        """Outward unit normals, (n, d)."""
        return self._wall.normals(self._back(points, time), time) @ self._turn(time).T

    def _slopes(self, points: np.ndarray, time: float) -> np.ndarray:
        return self._wall.slopes(self._back(points, time), time) @ self._turn(time).T

    def curvature(self, points: np.ndarray, time: float) -> np.ndarray | None:
        """Derivatives of the normals, (n, d, d); None if the obstacle does not tell them."""
        bend, turn = self._wall.curvature(self._back(points, time), time), self._turn(time)
        return None if bend is None else turn @ bend @ turn.T

    def velocity(self, points: np.ndarray, start: float, end: float) -> np.ndarray:
        """Of the material beside the points at the end, by the mean rate from start to end, (n, d):
        that of a rigid body, to which all points of one that is rigid can stick; places at both
        ends would tell a chord, by which it grows."""
        rate = (self.angle(end) - self.angle(start)) / (end - start)
        own = self._wall.velocity(self._back(points, end), start, end) @ self._turn(end).T
        return rate * (points - self.about) @ self._spin.T + own

    def _velocity_slopes(self, points: np.ndarray, start: float, end: float) -> np.ndarray:
        rate = (self.angle(end) - self.angle(start)) / (end - start)
        own, turn = self._wall.velocity_slopes(self._back(points, end), start, end), self._turn(end)
        return rate * self._spin + turn @ own @ turn.T

    def changes(
        self, number: Any, points: np.ndarray, time: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the distances (n,) and of the normals (n, d) by one of the numbers."""
        changes = self._wall.obstacle.changes  # type: ignore[attr-defined]
        closer, turned = changes(number, self._back(points, time), time)
        return closer, turned @ self._turn(time).T

    def velocity_changes(
        self, number: Any, points: np.ndarray, start: float, end: float
    ) -> np.ndarray:
        """And of the velocity, (n, d)."""
        changes = self._wall.obstacle.velocity_changes  # type: ignore[attr-defined]
        return changes(number, self._back(points, end), start, end) @ self._turn(end).T

    def _turn(self, time: float) -> np.ndarray:
        return rotation_matrix(self.angle(time) * self._along)

    def _back(self, points: np.ndarray, time: float) -> np.ndarray:
        """Where they were when nothing had turned."""
        return self.about + (points - self.about) @ self._turn(time)

    def __repr__(self) -> str:
        axis = "" if self.axis is None else f", axis={self.axis.tolist()}"
        about = self.about.tolist()
        return f"Turned({self._wall.describe()}, about={about}, {shown(self._angle)}{axis})"
