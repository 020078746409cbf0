# SPDX-License-Identifier: LGPL-3.0-or-later
"""What is given: obstacles, which have no unknowns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import numpy as np

from ..base import checks


@runtime_checkable
class Obstacle(Protocol):
    """Anything with a signed distance. ``flat`` obstacles have one normal everywhere."""

    dim: int
    flat: bool

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Signed distance of the points (n, d), positive outside, in m."""
        ...

    def normals(self, points: np.ndarray) -> np.ndarray:
        """Outward unit normals of the obstacle next to the points, (n, d)."""
        ...


class HalfSpace:
    """The half-space below a plane (a half-plane in 2D), fixed and rigid.

    Args:
        point: a point of the plane, d coordinates in m.
        normal: its outward normal, of any length but zero.
    """

    flat = True

    def __init__(self, point: Sequence[float], normal: Sequence[float]) -> None:
        size = len(np.atleast_1d(np.asarray(point)))
        if size not in (2, 3):
            raise checks.InputError(f"point = {point!r}: must be 2 or 3 finite numbers")
        self.dim = size
        self.point = checks.vector("point", point, size)
        self.normal = checks.vector("normal", normal, size)
        length = float(np.linalg.norm(self.normal))
        if length == 0:
            raise checks.InputError(f"normal = {normal!r}: must not be zero")
        self.normal /= length

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Signed distance of the points (n, d), positive outside."""
        return (points - self.point) @ self.normal

    def normals(self, points: np.ndarray) -> np.ndarray:
        """The outward normal, repeated for each point, (n, d)."""
        return np.broadcast_to(self.normal, points.shape)

    def __repr__(self) -> str:
        return f"HalfSpace(point={self.point.tolist()}, normal={self.normal.tolist()})"
