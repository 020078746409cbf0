# SPDX-License-Identifier: LGPL-3.0-or-later
"""Surfaces of revolution: any obstacle of the plane, turned about an axis."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...base import checks
from ...base.quoted import quoted
from ...base.vectors import normalised
from ..wall import Obstacle, Wall


class Revolution:
    """An obstacle of the plane, turned about an axis in space.

        Revolution(Circle((0, 0.3), 0.1), center=(0, 0, 0), axis=(0, 0, 1))

    is a torus, a :class:`~fenicsx_contact.contact.shapes.polyhedron.Box` becomes a disk, a wedge a
    cone, a :class:`~fenicsx_contact.contact.shapes.curve.Curve` whatever is turned. Distances are
    those in the plane: in the half-plane through a point nothing of the body is nearer than what
    the section has there.

    Args:
        section: in the plane of (z, r), z along the axis from the centre, r away from it. Where it
            reaches the axis it must be symmetric about that, r < 0 as r > 0: of a half the inside
            is off there.
        center: a point of the axis, m: z = 0.
        axis: the way on which z grows, of any length but zero.

    Raises:
        InputError: no obstacle of the plane.
    """

    flat = False
    dim = 3

    def __init__(self, section: Obstacle, center: Sequence[float], axis: Sequence[float]) -> None:
        self._wall = Wall(section, "section")
        if self._wall.dim != 2:
            raise checks.InputError(
                f"section = {quoted(section)}: must be an obstacle of the plane"
            )
        self.center = checks.vector("center", center, 3)
        self.axis = checks.direction("axis", axis, 3)
        self.moving, self.edged = self._wall.moving, self._wall.edged
        self._across = np.eye(3) - np.outer(self.axis, self.axis)
        if self._wall.smooth:
            self.slopes = self._slopes
        if self._wall.smooth_velocity:
            self.velocity_slopes = self._velocity_slopes

    def _plane(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places in the section's plane, (n, 2), and its axes in space, (n, 2, 3); on the axis any
        half-plane does."""
        off = points - self.center
        aside = off @ self._across
        radius = np.linalg.norm(aside, axis=1)
        any_one = self._across[np.abs(np.diag(self._across)).argmax()]
        away = normalised(np.where(radius[:, None] > 0, aside, any_one))
        along = np.broadcast_to(self.axis, away.shape)
        return np.stack([off @ self.axis, radius], axis=1), np.stack([along, away], axis=1)

    def distance(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Signed distance of the points (n, 3), positive outside."""
        return self._wall.distance(self._plane(points)[0], time)

    def normals(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Outward unit normals, (n, 3)."""
        places, axes = self._plane(points)
        return np.einsum("na,nai->ni", self._wall.normals(places, time), axes)

    def _slopes(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        places, axes = self._plane(points)
        return np.einsum("na,nai->ni", self._wall.slopes(places, time), axes)

    def curvature(self, points: np.ndarray, time: float = 0.0) -> np.ndarray | None:
        """Derivatives of the normals, (n, 3, 3): the section's, and n_r/r around the axis; None if
        a curved section does not tell its own."""
        places, axes = self._plane(points)
        bend = self._wall.curvature(places, time)
        if bend is None:
            if not self._wall.flat:
                return None
            bend = np.zeros((len(points), 2, 2))
        return _turned(self._wall.normals(places, time), bend, places, axes)

    def velocity(self, points: np.ndarray, start: float, end: float) -> np.ndarray:
        """Mean velocity of what is beside the points, as the section has it, (n, 3)."""
        places, axes = self._plane(points)
        return np.einsum("na,nai->ni", self._wall.velocity(places, start, end), axes)

    def _velocity_slopes(self, points: np.ndarray, start: float, end: float) -> np.ndarray:
        places, axes = self._plane(points)
        own, slopes = (
            f(places, start, end) for f in (self._wall.velocity, self._wall.velocity_slopes)
        )
        return _turned(own, slopes, places, axes)

    def __repr__(self) -> str:
        return (
            f"Revolution({self._wall.describe()}, center={self.center.tolist()}, "
            f"axis={self.axis.tolist()})"
        )


def _turned(
    vectors: np.ndarray, slopes: np.ndarray, places: np.ndarray, axes: np.ndarray
) -> np.ndarray:
    """Derivatives in space, (n, 3, 3), of vectors of the plane (n, 2) that go round with it, from
    their derivatives there, (n, 2, 2): on the axis those along the radius go every way."""
    radius, away = places[:, 1], vectors[:, 1]
    round_ = np.where(radius > 0, away / np.where(radius > 0, radius, 1.0), slopes[:, 1, 1])
    around = np.cross(axes[:, 0], axes[:, 1])
    hoop = round_[:, None, None] * around[:, :, None] * around[:, None, :]
    return np.einsum("nab,nai,nbj->nij", slopes, axes, axes) + hoop
