# SPDX-License-Identifier: LGPL-3.0-or-later
"""Convex polyhedra: what half-spaces have in common; boxes and wedges."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import linprog

from ...base import checks
from ...base.constants import SAME
from ...base.quoted import quoted
from ...base.shown import marked
from ...solids.rotations import angles, rotation_matrix
from ..obstacle import HalfSpace
from .last import Last


class _Flats(NamedTuple):
    """Where k of the planes meet: which, (m, k), their normals, (m, k, d), and the inverses of
    their Gram matrices, (m, k, k)."""

    planes: np.ndarray
    normals: np.ndarray
    inverses: np.ndarray


class Polyhedron:
    """What half-spaces have in common (a convex polygon in 2D), its edges and corners round.

    The distance to a convex set is the largest of its lower bounds: of those to the flats in which
    up to d of the planes meet, each where the point lies in the cone of their normals. That is
    exact outside and inside, without a tolerance. (Duality of distance and support: S. Boyd, L.
    Vandenberghe, *Convex Optimization*, Cambridge 2004, section 8.1.)

    A sharp edge has no normal. What is pressed on one meets one of its faces, and Newton's method
    may not settle on which; a radius, however small against the mesh, leaves it no choice.

    Args:
        half_spaces: two at least, of one dimension.
        rounding: radius of edges and corners, m, >= 0; the faces stay where they are.

    Raises:
        InputError: no half-spaces, of different dimensions, or with nothing in common that would
            hold a ball of the rounding's radius.
    """

    flat = False

    def __init__(self, half_spaces: Sequence[HalfSpace], rounding: float = 0.0) -> None:
        spaces = checks.sequence("half_spaces", half_spaces, HalfSpace, "half-spaces")
        dims = sorted({space.dim for space in spaces})
        if len(spaces) < 2 or len(dims) > 1:
            raise checks.InputError(
                f"half_spaces = {quoted(half_spaces)}: must be two at least, all in 2D or all in 3D"
            )
        self.dim, self.rounding = dims[0], checks.number("rounding", rounding, at_least=0)
        self._normals = np.array([space.normal for space in spaces])
        offsets = np.array([space.point @ space.normal for space in spaces])
        self._check_room(offsets)
        self._nearest = Last(self._find)
        self._offsets = offsets - self.rounding
        every = (self._flats(size) for size in range(2, self.dim + 1))
        self._meeting = [flats for flats in every if len(flats.planes)]

    def _flats(self, size: int) -> _Flats:
        """Where so many of the planes meet."""
        planes = np.array(list(combinations(range(len(self._normals)), size)), dtype=int)
        planes = planes.reshape(-1, size)
        normals = self._normals[planes]
        grams = normals @ normals.swapaxes(1, 2)
        meet = np.linalg.det(grams) > SAME
        return _Flats(planes[meet], normals[meet], np.linalg.inv(grams[meet]))

    def _check_room(self, offsets: np.ndarray) -> None:
        """Whether the largest ball inside, if there is one, is larger than the rounding."""
        d, planes = self.dim, len(offsets)
        # in units of the planes' own extent about the foot of the first one
        middle = offsets[0] * self._normals[0]
        near = offsets - self._normals @ middle
        size = float(np.abs(near).max()) or 1.0
        rows = np.hstack([self._normals, np.ones((planes, 1))])
        bounds = [(None, None)] * d + [(None, 1.0)]
        ball = linprog(-np.eye(d + 1)[d], rows, near / size, bounds=bounds)
        radius = ball.x[d] * size
        if ball.x[d] < 1 and radius <= max(self.rounding, SAME * size):
            raise checks.InputError(
                f"half_spaces, rounding = {self.rounding:g}: what they have in common must hold a "
                f"ball of more than this radius; the largest has {max(radius, 0.0):g}"
            )

    def _find(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Distances (n,) from the polyhedron of which this one is the offset, normals (n, d), and
        the directions that leave its flat, as projectors (n, d, d)."""
        over = points @ self._normals.T - self._offsets
        face = over.argmax(axis=1)
        distance, normals = over[np.arange(len(points)), face], self._normals[face]
        across = normals[:, :, None] * normals[:, None, :]
        outside = np.flatnonzero(distance > 0)  # inside, a face is the nearest
        for flats in self._meeting if len(outside) else ():
            away = over[outside][:, flats.planes]
            pull = (away[:, :, None] @ flats.inverses)[:, :, 0]
            size = np.sqrt(np.maximum((pull * away).sum(axis=2), 0.0))
            size[(pull < 0).any(axis=2)] = -np.inf
            one, best = np.arange(len(outside)), size.argmax(axis=1)
            better = size[one, best] > distance[outside]
            one, best, at = one[better], best[better], outside[better]
            own = flats.normals[best]
            distance[at] = size[one, best]
            normals[at] = (pull[one, best][:, None] @ own)[:, 0] / distance[at, None]
            across[at] = own.swapaxes(1, 2) @ flats.inverses[best] @ own
        return distance, normals, across

    def distance(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Signed distance of the points (n, d), positive outside."""
        return self._nearest(points)[0] - self.rounding

    def normals(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Outward unit normals, (n, d)."""
        return self._nearest(points)[1].copy()

    slopes = normals

    def curvature(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Derivatives of the normals, (n, d, d): zero before faces, and before a sharp edge, at
        which normals jump."""
        distance, n, across = self._nearest(points)
        bend = (self.rounding > 0) / np.where(distance > 0, distance, np.inf)
        return bend[:, None, None] * (across - n[:, :, None] * n[:, None, :])

    def __repr__(self) -> str:
        planes = self._normals.tolist(), self._offsets.tolist()  # as far as round-off goes
        faces = marked(f"{len(self._normals)} faces", *planes)
        return f"{type(self).__name__}({faces}, rounding={self.rounding:.9g})"


class Box(Polyhedron):
    """A box (a rectangle in 2D).

    Args:
        center: m, d coordinates.
        size: lengths of its sides, d numbers in m, > 0.
        rotation: about its centre, rad (a rotation vector in 3D).
        rounding: radius of edges and corners, m, less than half of the shortest side.

    Raises:
        InputError: a side that is not positive, a rounding that is too large.
    """

    def __init__(
        self,
        center: Sequence[float],
        size: Sequence[float],
        rotation: float | Sequence[float] = 0.0,
        rounding: float = 0.0,
    ) -> None:
        d, middle = checks.point("center", center)
        sides = checks.vector("size", size, d)
        for i, side in enumerate(sides):
            checks.number(f"size[{i}]", side, above=0)
        turn = rotation_matrix(angles("rotation", rotation, 1 if d == 2 else 3))
        faces = [
            HalfSpace(middle + sign * 0.5 * side * axis, sign * axis)
            for side, axis in zip(sides, turn.T)
            for sign in (1.0, -1.0)
        ]
        super().__init__(faces, rounding)


class Wedge(Polyhedron):
    """A wedge, without end but at its edge (its tip in 2D).

    Args:
        tip: where its two faces meet, m; with a rounding they would.
        direction: the way it points, of any length but zero; what of it is along the edge does not
            count.
        angle: between its faces, rad, in (0, pi).
        edge: along its edge, in 3D; not along the direction.
        rounding: radius of the edge, m.

    Raises:
        InputError: an angle out of its range, a direction along the edge, an edge in 2D or none
            in 3D.
    """

    def __init__(
        self,
        tip: Sequence[float],
        direction: Sequence[float],
        angle: float,
        edge: Sequence[float] | None = None,
        rounding: float = 0.0,
    ) -> None:
        d, point = checks.point("tip", tip)
        ahead = checks.direction("direction", direction, d)
        half = checks.number("angle", angle, above=0) / 2
        if half >= np.pi / 2:
            raise checks.InputError(f"angle = {angle!r}: must be < pi")
        if (edge is None) != (d == 2):
            wanted = "None in 2D" if d == 2 else "3 finite numbers in 3D"
            raise checks.InputError(f"edge = {edge!r}: must be {wanted}")
        aside = np.array([-ahead[1], ahead[0]]) if d == 2 else _across(ahead, edge)
        ahead = ahead if d == 2 else checks.direction("direction", np.cross(aside, _unit(edge)), d)
        normals = [np.sin(half) * ahead + sign * np.cos(half) * aside for sign in (1.0, -1.0)]
        super().__init__([HalfSpace(list(point), list(normal)) for normal in normals], rounding)


def _unit(edge: Any) -> np.ndarray:
    return checks.direction("edge", edge, 3)


def _across(ahead: np.ndarray, edge: Any) -> np.ndarray:
    """The unit vector across both."""
    aside = np.cross(_unit(edge), ahead)
    if np.linalg.norm(aside) <= SAME:
        raise checks.InputError(f"edge = {edge!r}: must not lie along the direction")
    return aside / np.linalg.norm(aside)
