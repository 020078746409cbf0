# SPDX-License-Identifier: LGPL-3.0-or-later
"""Curves in the plane through given points: straight lines, or a smooth spline."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from ...base import checks
from ...base.constants import ROUND_OFF, SAME, SHARP
from ...base.shown import marked
from ...base.vectors import largest
from .last import Last


class Curve:
    """What lies on the right of a curve through points, as one goes along it, in the plane.

    So ground is told from left to right, and a body clockwise, its first point once more at the
    end. A curve that does not close goes straight on at both ends.

    The lines through the points have exact distances. Smooth, the curve is the cubic spline by the
    length of the lines (natural at ends, periodic where it closes), its normals and their
    derivatives are continuous, and distances are exact as well: the foot of a point is found by
    Newton's method from the nearest line. It must then be near the curve, against its radii.

    Args:
        points: two at least (n, 2), m, no two neighbours the same; the lines through them must not
            meet but at their ends.
        smooth: a spline through the points instead of straight lines.

    Raises:
        InputError: no such points; lines that cross each other, or run back along themselves.
    """

    flat = False
    dim = 2

    def __init__(self, points: Any, smooth: bool = False) -> None:
        problem = f"points = {points!r}: must be two or more points of the plane, (n, 2) numbers"
        x = checks.table(problem, points)
        if x.ndim != 2 or x.shape[1] != 2 or len(x) < 2:
            raise checks.InputError(problem)
        lengths, extent = np.linalg.norm(np.diff(x, axis=0), axis=1), float(np.ptp(x, axis=0).max())
        if lengths.min() <= SAME * extent:
            at = int(lengths.argmin())
            raise checks.InputError(
                f"points[{at}], points[{at + 1}] = {x[at].tolist()}, {x[at + 1].tolist()}: must "
                "not be the same"
            )
        self.smooth, self.closed = checks.truth("smooth", smooth), False
        self.edged = not self.smooth
        if np.linalg.norm(x[-1] - x[0]) <= SAME * extent:
            if len(x) < 4:
                raise checks.InputError(f"{problem}, four at least to close")
            self.closed, x[-1] = True, x[0]
        self._x, self._ways = x, np.concatenate([[0.0], np.cumsum(lengths)])
        self._along = np.diff(x, axis=0) / lengths[:, None]
        if lines := self._crossing():
            raise checks.InputError(
                f"points[{lines[0]}:{lines[0] + 2}], points[{lines[1]}:{lines[1] + 2}] = "
                f"{x[lines[0] : lines[0] + 2].tolist()}, {x[lines[1] : lines[1] + 2].tolist()}: "
                "these lines must not meet"
            )
        self._beside, self._spline = Last(self._find), None
        if self.smooth:
            ends = "periodic" if self.closed else "natural"
            self._spline = CubicSpline(self._ways, x, bc_type=ends)

    def _crossing(self) -> tuple[int, int] | None:
        """Two lines that meet elsewhere than where one follows the other, if any."""
        x, along, lengths = self._x[:-1], self._along, np.diff(self._ways)
        n, near = len(lengths), SAME * lengths.max()
        back = np.flatnonzero((along[:-1] * along[1:]).sum(axis=1) < SAME - 1)
        if len(back):
            return int(back[0]), int(back[0]) + 1
        for i in range(n - 2):
            others = np.arange(i + 2, n - (self.closed and i == 0))
            off, way, length = x[others] - x[i], along[others], lengths[others]
            det, aside = _cross(along[i], way), _cross(along[i], off)
            apart = det != 0
            mine, theirs = np.array([_cross(off, way), -aside]) / np.where(apart, det, 1.0)
            meet = apart & (mine >= -near) & (mine <= lengths[i] + near)
            meet &= (theirs >= -near) & (theirs <= length + near)
            begin = off @ along[i]  # of those along the same line
            end = begin + (way @ along[i]) * length
            same = ~apart & (aside == 0) & (np.maximum(begin, end) >= 0)
            meet |= same & (np.minimum(begin, end) <= lengths[i])
            if meet.any():
                return i, int(others[meet.argmax()])
        return None

    @property
    def remark(self) -> str:
        """What a reader of a run should know of it, or nothing."""
        if not len(corners := self.hollow()):
            return ""
        return (
            f"{self!r} has hollow corners, at {self._x[corners].tolist()}: of one obstacle a point "
            "meets the nearest face alone. Where something lies in one, or slides into it, let "
            "each of its faces() have a contact"
        )

    def hollow(self) -> np.ndarray:
        """Which of the points are sharp corners that the body does not fill, those of grooves and
        steps, by number; none of a spline."""
        if self.smooth:
            return np.zeros(0, dtype=np.int64)
        before, after = np.roll(self._along, 1, axis=0), self._along
        sharp = (_cross(before, after) > 0) & ((before * after).sum(axis=1) < SHARP)
        if not self.closed:
            sharp[0] = False
        return np.flatnonzero(sharp)

    def faces(self) -> list[Curve]:
        """The curves between hollow corners, each of which goes straight on behind these into the
        body, which is what lies behind any of them. What lies in a corner, or slides along one face
        of it into the other, meets both by two contacts, while of one obstacle a point meets the
        nearest face alone.

        Raises:
            InputError: straight on behind a hollow corner the body ends, or the face comes back to
                itself; a closed curve has one such corner alone.
        """
        corners = self.hollow()
        for at in corners:
            for back, way in ((0, self._along[at - 1]), (1, -self._along[at])):
                if (line := self._behind(at, way)) is not None:
                    raise checks.InputError(
                        f"points[{at}] = {self._x[at].tolist()}: is a hollow corner, of which the "
                        f"face {'after' if back else 'before'} it does not go straight on within "
                        f"the body, but meets points[{line}:{line + 2}]: give parts of it as "
                        "obstacles of their own, which may overlap"
                    )
        if not len(corners):
            return [self]
        x, ends = self._x, [0, *corners, len(self._x) - 1]
        if self.closed:
            if len(corners) == 1:
                raise checks.InputError(
                    f"points[{corners[0]}] = {x[corners[0]].tolist()}: is the only hollow corner of"
                    " a closed curve, which has one face: give parts of it as curves of their own"
                )
            x, ends = np.roll(x[:-1], -corners[0], axis=0), [*(corners - corners[0]), len(x) - 1]
            x = np.concatenate([x, x[:1]])
        return [_straight_on(x[low : high + 1]) for low, high in zip(ends, ends[1:])]

    def _behind(self, corner: int, way: np.ndarray) -> int | None:
        """The line that one meets who goes this way from a corner, if any."""
        x, lengths = self._x[:-1], np.diff(self._ways)
        low, high = np.zeros_like(lengths), lengths.copy()
        if not self.closed:
            low[0], high[-1] = -np.inf, np.inf
        off, det = x - self._x[corner], _cross(way, self._along)
        apart = np.abs(det) > SAME
        apart[[corner - 1, corner]] = False
        mine, theirs = np.array([_cross(off, self._along), _cross(off, way)]) / np.where(
            apart, det, 1.0
        )
        meet = apart & (mine > 0) & (theirs >= low) & (theirs <= high)
        return int(np.where(meet, mine, np.inf).argmin()) if meet.any() else None

    def _on_lines(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The nearest line of each point, and how far along it."""
        lengths = np.diff(self._ways)
        low, high = np.zeros_like(lengths), lengths.copy()
        if not self.closed:
            low[0], high[-1] = -np.inf, np.inf
        off = points[:, None] - self._x[:-1]
        along = np.clip(np.einsum("nmi,mi->nm", off, self._along), low, high)
        feet = self._x[:-1] + along[:, :, None] * self._along
        line = np.linalg.norm(points[:, None] - feet, axis=2).argmin(axis=1)
        return line, along[np.arange(len(points)), line]

    def _beside_lines(self, points: np.ndarray) -> tuple[np.ndarray, ...]:
        line, along = self._on_lines(points)
        tangent = self._along[line]
        normals = _left(tangent)
        off = points - self._x[line] - along[:, None] * tangent
        distance = (off * normals).sum(axis=1)
        # at a corner the mean of both sides tells inside from outside
        last, lengths = len(self._along) - 1, np.diff(self._ways)
        other = np.where(along <= 0, line - 1, np.where(along >= lengths[line], line + 1, line))
        if self.closed:
            other = other % (last + 1)
        corner = (other != line) & (other >= 0) & (other <= last)
        mean = normals + _left(self._along[np.clip(other, 0, last)])
        size = np.linalg.norm(off, axis=1)
        apart = corner & (size > ROUND_OFF * np.linalg.norm(points, axis=1))
        sign = np.where((off * mean).sum(axis=1) < 0, -1.0, 1.0)
        distance = np.where(apart, sign * size, distance)
        away = sign[:, None] * off / np.where(apart, size, 1.0)[:, None]
        normals = np.where(apart[:, None], away, normals)
        return distance, normals, np.zeros(len(points))  # at a corner normals jump

    def _beside_spline(self, points: np.ndarray) -> tuple[np.ndarray, ...]:
        spline, (line, along) = self._spline, self._on_lines(points)
        assert spline is not None
        whole = self._ways[-1]
        place, change, falls = self._ways[line] + along, np.inf, True
        while falls:  # down to round-off
            at = place % whole if self.closed else np.clip(place, 0, whole)
            foot, tangent, turn = spline(at), spline(at, 1), spline(at, 2)
            if not self.closed:  # natural ends go straight on
                foot = foot + (place - at)[:, None] * tangent
            off, square = points - foot, (tangent**2).sum(axis=1)
            slope = square - (off * turn).sum(axis=1)
            # beyond a centre of curvature the foot is none of the nearest: go on along the tangent
            way = (off * tangent).sum(axis=1) / np.where(slope > 0, slope, square)
            last, change = change, largest(way)
            place, falls = place + way, change < last
        speed = np.sqrt(square)
        normals = _left(tangent / speed[:, None])
        distance = (off * normals).sum(axis=1)
        # of the curve, positive where it bends towards the right: round bodies
        bend = -(turn * normals).sum(axis=1) / square
        return distance, normals, bend / (1 + bend * distance)

    def _find(self, points: np.ndarray) -> tuple[np.ndarray, ...]:
        """Distances, normals, and the curvature of the parallel curve there."""
        return self._beside_spline(points) if self.smooth else self._beside_lines(points)

    def distance(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Signed distance of the points (n, 2), positive outside."""
        return self._beside(points)[0].copy()

    def normals(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Outward unit normals, (n, 2)."""
        return self._beside(points)[1].copy()

    slopes = normals

    def curvature(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Derivatives of the normals, (n, 2, 2); zero beside lines and their corners."""
        _, n, bend = self._beside(points)
        t = _left(n)
        return bend[:, None, None] * t[:, :, None] * t[:, None, :]

    def __repr__(self) -> str:
        kind = "closed" if self.closed else "open"
        points = marked(f"{len(self._x)} points", self._x)
        return f"Curve({points}, {kind}, smooth={self.smooth})"


def _straight_on(points: np.ndarray) -> Curve:
    """The curve through points that goes straight on at both ends, which must not meet."""
    curve = Curve(points)
    (back, ahead), off = (-curve._along[0], curve._along[-1]), points[-1] - points[0]
    det = _cross(back, ahead)
    if abs(det) > SAME and min(_cross(off, ahead) / det, _cross(off, back) / det) > 0:
        raise checks.InputError(
            f"points {points[0].tolist()}, {points[-1].tolist()}: are hollow corners, between which"
            " the face is narrower within the body than outside, so that its ends would meet if it "
            "went straight on: give parts of it as obstacles of their own, which may overlap"
        )
    return curve


def _left(tangent: np.ndarray) -> np.ndarray:
    """Turned by a right angle to the left."""
    return np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a x b in the plane."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
