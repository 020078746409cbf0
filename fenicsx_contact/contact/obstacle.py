# SPDX-License-Identifier: LGPL-3.0-or-later
"""What is given: obstacles, which have no unknowns.

An obstacle is known by its signed distance. Planes and round ones are formulas here; a
:class:`~fenicsx_contact.contact.level_set.LevelSet` takes any function of position and time in UFL;
:class:`Moved` and :class:`~fenicsx_contact.contact.turned.Turned` move any of them; an own one is
any object with the members of :class:`~fenicsx_contact.contact.wall.Obstacle`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..base import checks
from ..base.shown import shown
from .wall import Obstacle, Wall


class HalfSpace:
    """The half-space below a plane (a half-plane in 2D).

    Args:
        point: a point of the plane, d coordinates in m.
        normal: its outward normal, of any length but zero.
    """

    flat = True

    def __init__(self, point: Sequence[float], normal: Sequence[float]) -> None:
        self.dim, self.point = checks.point("point", point)
        self.normal = checks.direction("normal", normal, self.dim)

    def distance(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Signed distance of the points (n, d), positive outside."""
        return (points - self.point) @ self.normal

    def normals(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """The outward normal, repeated for each point, (n, d)."""
        return np.broadcast_to(self.normal, points.shape)

    def __repr__(self) -> str:
        return f"HalfSpace(point={self.point.tolist()}, normal={self.normal.tolist()})"


class _Round:
    """Points nearer to a centre than a radius, or all others; across ``axis`` if there is one."""

    flat = edged = False

    def __init__(
        self,
        dim: int,
        center: Sequence[float],
        radius: float,
        inside: bool,
        axis: np.ndarray | None = None,
    ) -> None:
        self.dim, self.center = dim, checks.vector("center", center, dim)
        self.radius = checks.number("radius", radius, above=0)
        self.inside = checks.truth("inside", inside)
        self.axis = axis
        self._across = np.eye(dim)
        if self.axis is not None:
            self._across -= np.outer(self.axis, self.axis)
        self._sign = -1.0 if inside else 1.0

    def _polar(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances from the centre and directions away from it; any direction at the centre."""
        off = (points - self.center) @ self._across
        size = np.linalg.norm(off, axis=1)
        # the row of the projector that is longest is a direction
        any_one = self._across[np.abs(np.diag(self._across)).argmax()]
        away = np.where(size[:, None] > 0, off, any_one / np.linalg.norm(any_one))
        return size, away / np.where(size > 0, size, 1.0)[:, None]

    def distance(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Signed distance of the points (n, d), positive outside of the obstacle."""
        return self._sign * (self._polar(points)[0] - self.radius)

    def normals(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Outward unit normals of the obstacle, (n, d)."""
        return self._sign * self._polar(points)[1]

    slopes = normals

    def curvature(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Derivatives of the normals, (n, d, d); none at the centre."""
        size, away = self._polar(points)
        bend = self._sign / np.where(size > 0, size, np.inf)
        return bend[:, None, None] * (self._across - away[:, :, None] * away[:, None, :])

    def __repr__(self) -> str:
        axis = "" if self.axis is None else f"axis={self.axis.tolist()}, "
        return (
            f"{type(self).__name__}(center={self.center.tolist()}, {axis}radius={self.radius}, "
            f"inside={self.inside})"
        )


class Circle(_Round):
    """A disk in the plane, or all but a disk.

    Args:
        center: m.
        radius: m.
        inside: the solid is inside of the circle.
    """

    def __init__(self, center: Sequence[float], radius: float, inside: bool = False) -> None:
        super().__init__(2, center, radius, inside)


class Sphere(_Round):
    """A ball in space, or all but a ball; arguments as of :class:`Circle`."""

    def __init__(self, center: Sequence[float], radius: float, inside: bool = False) -> None:
        super().__init__(3, center, radius, inside)


class Cylinder(_Round):
    """An endless cylinder in space, or all but that: a pipe.

    Args:
        center: a point of its axis, m.
        axis: along it, of any length but zero.
        radius, inside: as of :class:`Circle`.
    """

    def __init__(
        self,
        center: Sequence[float],
        axis: Sequence[float],
        radius: float,
        inside: bool = False,
    ) -> None:
        super().__init__(3, center, radius, inside, checks.direction("axis", axis, 3))


class Carried(ABC):
    """An obstacle that is carried along in some way, and what is known of it all the same.

    Attributes:
        walls: of what it is made.
        numbers: the Constants that stand in it.
    """

    moving = True

    def __init__(self, obstacle: Obstacle) -> None:
        self._wall = wall = Wall(obstacle)
        self.dim, self.edged, self.walls = wall.dim, wall.edged, [wall]
        self.numbers: list[Any] = list(getattr(obstacle, "numbers", ()))
        if wall.smooth:
            self.slopes = self._slopes
        if wall.smooth_velocity:
            self.velocity_slopes = self._velocity_slopes

    @abstractmethod
    def _slopes(self, points: np.ndarray, time: float) -> np.ndarray: ...

    @abstractmethod
    def _velocity_slopes(self, points: np.ndarray, start: float, end: float) -> np.ndarray: ...


class Moved(Carried):
    """An obstacle that is carried along.

    Args:
        obstacle: any obstacle.
        motion: its displacement as a function of the time [s], d numbers in m. Velocities are
            differences of it over the times that a scheme asks for, so that tables will do; jumps
            only by theta = 1, in uniform steps. A sudden start is a blow, of which what rebounds
            does so by theta = 1/2 only: others take it along.

    Raises:
        InputError: no obstacle, a motion that is none.
    """

    def __init__(self, obstacle: Obstacle, motion: Callable[[float], Any]) -> None:
        checks.function("motion", motion, " of the time")
        super().__init__(obstacle)
        self._motion, self.flat = motion, self._wall.flat
        self.displacement(0.0)

    def displacement(self, time: float) -> np.ndarray:
        """At a time, (d,) in m."""
        what = f"motion({time:g})"
        return checks.vector(what, checks.called(what, self._motion, time), self.dim)

    def distance(self, points: np.ndarray, time: float) -> np.ndarray:
        """Signed distance of the points (n, d), positive outside."""
        return self._wall.distance(points - self.displacement(time), time)

    def normals(self, points: np.ndarray, time: float) -> np.ndarray:
        """Outward unit normals, (n, d)."""
        return self._wall.normals(points - self.displacement(time), time)

    def _slopes(self, points: np.ndarray, time: float) -> np.ndarray:
        return self._wall.slopes(points - self.displacement(time), time)

    def curvature(self, points: np.ndarray, time: float) -> np.ndarray | None:
        """Derivatives of the normals, (n, d, d); None if the obstacle does not tell them."""
        return self._wall.curvature(points - self.displacement(time), time)

    def velocity(self, points: np.ndarray, start: float, end: float) -> np.ndarray:
        """Mean velocity from start to end, (n, d)."""
        first, last = self.displacement(start), self.displacement(end)
        return (last - first) / (end - start) + self._wall.velocity(points - last, start, end)

    def _velocity_slopes(self, points: np.ndarray, start: float, end: float) -> np.ndarray:
        return self._wall.velocity_slopes(points - self.displacement(end), start, end)

    def changes(
        self, number: Any, points: np.ndarray, time: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the distances (n,) and of the normals (n, d) by one of the numbers."""
        changes = self._wall.obstacle.changes  # type: ignore[attr-defined]
        return changes(number, points - self.displacement(time), time)

    def velocity_changes(
        self, number: Any, points: np.ndarray, start: float, end: float
    ) -> np.ndarray:
        """And of the velocity, (n, d)."""
        changes = self._wall.obstacle.velocity_changes  # type: ignore[attr-defined]
        return changes(number, points - self.displacement(end), start, end)

    def __repr__(self) -> str:
        return f"Moved({self._wall.describe()}, {shown(self._motion)})"
