# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a contact asks of an obstacle."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np

from ..base import checks
from ..base.constants import RIGHT, SHARP
from ..base.overflow import told
from ..base.quoted import quoted
from ..base.shown import marked
from ..base.vectors import dot, largest
from .answers import asking, finite, mean, ours, timed, wrong


@runtime_checkable
class Obstacle(Protocol):
    """Anything with a signed distance; points are (n, d) in m, time in s.

    A method may leave out the time if it does not use it. Optional are

    * ``curvature(points, time)``: derivatives of the normals by the position, which are the second
      derivatives of the distance, (n, d, d) in 1/m. Without it Newton's method converges linearly
      where the obstacle is curved;
    * ``slopes(points, time)``: derivatives of the distances by the position, (n, d): of a true
      distance the normals. With it and the curvature a run is differentiated
      (:mod:`fenicsx_contact.gradients`); what is flat needs neither;
    * ``velocity(points, start, end)``: mean velocity of the obstacle's material beside the points
      between two times, (n, d) in m/s, at the second of which it is there; asked for a thousandth
      of a step, too, of which differences of places are round-off. Or ``velocity(points, time)``,
      of first order by theta = 1 where it turns. Without, what moves does so along its normals;
    * ``velocity_slopes(points, start, end)``: derivatives of that velocity by the position,
      (n, d, d) in 1/s, with which a run is differentiated before what moves;
    * ``flat``: whether the normal is the same everywhere and always; default: no; ``edged``:
      whether there may be edges, at which it jumps; default: yes;
    * ``moving``: whether anything depends on time; default: if there is a velocity, or if the
      distance takes a time;
    * ``remark``: what a reader of a run should know of it.
    """

    dim: int

    def distance(self, points: np.ndarray, time: float) -> np.ndarray:
        """Signed distance of the points, positive outside, (n,) in m."""
        ...

    def normals(self, points: np.ndarray, time: float) -> np.ndarray:
        """Outward unit normals of the obstacle next to the points, (n, d)."""
        ...


class Wall:
    """An obstacle as a contact sees it: the same questions to whatever it is, the answers checked.

    Args:
        obstacle: has the members of :class:`Obstacle`.
        what: the argument that gave it, for messages.

    Raises:
        InputError: it has not, or ``flat`` or ``moving`` is no truth value.
    """

    def __init__(self, obstacle: Obstacle, what: str = "obstacle") -> None:
        checks.instance(what, obstacle, Obstacle, "an obstacle (dim, distance, normals at least)")
        self.obstacle, self.dim = obstacle, obstacle.dim
        self.flat = checks.truth(f"{what}.flat", getattr(obstacle, "flat", False))
        self._distance, asks = timed(obstacle.distance, self.flat)
        self._normals, _ = timed(obstacle.normals, self.flat)
        self.ours = ours(obstacle.normals)  # of which a test knows that they are of unit length
        self._slopes, _ = timed(getattr(obstacle, "slopes", obstacle.normals))
        self.edged = checks.truth(f"{what}.edged", getattr(obstacle, "edged", not self.flat))
        names = "curvature", "velocity", "velocity_slopes"
        curvature, velocity, faster = (getattr(obstacle, name, None) for name in names)
        self._curvature = timed(curvature)[0] if curvature and not self.flat else None
        self._velocity = mean(velocity) if velocity else None
        #: Whether its velocity is told, and not made of its motion, as where that is of its class.
        self.told = bool(velocity) and not (self.ours and hasattr(type(obstacle), "velocity"))
        self._faster = mean(faster) if faster else None
        moving = getattr(obstacle, "moving", velocity is not None or asks)
        self.moving = checks.truth(f"{what}.moving", moving)
        #: Whether it tells all that derivatives of a run ask for, of distances and of velocities.
        self.smooth = self.flat or bool(curvature and hasattr(obstacle, "slopes"))
        self.smooth_velocity = not self.moving or bool(faster if velocity else self.smooth)

    def distance(self, points: np.ndarray, time: float) -> np.ndarray:
        """Signed distance of the points (n, d) at a time, positive outside, (n,) in m.

        Raises:
            StepFailed: there is none.
        """
        with asking():
            answer = self._distance(points, time)
        return finite("distance", answer, points, 0)

    def normals(self, points: np.ndarray, time: float) -> np.ndarray:
        """Outward unit normals, (n, d); raises likewise."""
        with asking():
            answer = self._normals(points, time)
        normals = finite("normals", answer, points)
        if not self.ours:
            length = dot(normals, normals) ** 0.5
            if not largest(length - 1) <= RIGHT:
                at = int(np.abs(length - 1).argmax())
                found = f"{normals[at].tolist()} at the point {points[at].tolist()}"
                raise wrong("normals", found, "unit vectors")
        return normals

    def slopes(self, points: np.ndarray, time: float) -> np.ndarray:
        """Derivatives of the distances by the position, (n, d)."""
        with asking():
            answer = self._slopes(points, time)
        return finite("slopes", answer, points)

    def curvature(self, points: np.ndarray, time: float) -> np.ndarray | None:
        """Derivatives of the normals, (n, d, d) in 1/m; None where none are known or needed."""
        if not self._curvature:
            return None
        with asking():
            answer = self._curvature(points, time)
        return None if answer is None else finite("curvature", answer, points, 2)

    def velocity(self, points: np.ndarray, start: float, end: float) -> np.ndarray:
        """Mean velocity of what is beside the points between two times, (n, d) in m/s."""
        if not self.moving:
            return np.zeros(points.shape)
        if self._velocity:
            with told(), asking():
                return finite("velocity", self._velocity(points, start, end), points)
        closer = self.distance(points, end) - self.distance(points, start)
        return -(closer / (end - start))[:, None] * self.normals(points, end)

    def velocity_slopes(self, points: np.ndarray, start: float, end: float) -> np.ndarray:
        """Derivatives of the mean velocity by the position, of what tells them, (n, d, d)."""
        if self._faster:
            with told(), asking():
                return finite("velocity_slopes", self._faster(points, start, end), points, 2)
        slopes = np.zeros((*points.shape, self.dim))
        if not self.moving:
            return slopes
        first, last = (self.distance(points, time) for time in (start, end))
        faster = (self.slopes(points, end) - self.slopes(points, start)) / (end - start)
        slopes -= self.normals(points, end)[:, :, None] * faster[:, None, :]
        bend = self.curvature(points, end)
        return (
            slopes
            if bend is None
            else slopes - ((last - first) / (end - start))[:, None, None] * bend
        )

    def check(self, points: np.ndarray) -> None:
        """Refuse an obstacle whose answers at these points, at time 0, are none or contradict each
        other at the surface beside them.

        Raises:
            InputError: with what is wrong and where.
        """
        refused = f"master = {quoted(self.obstacle)}"
        size = float(np.ptp(points, axis=0).max()) or float(np.abs(points).max())  # of a point
        reach = RIGHT * (size or 1.0)
        try:
            distance, normals = self.distance(points, 0.0), self.normals(points, 0.0)
            if self.moving:
                self.velocity(points, 0.0, 2.0**-30)  # s; any moment will do
            self.curvature(points, 0.0)
            self.slopes(points, 0.0)
            feet, off = self._feet(points, distance, reach)
            slack = float(np.finfo(distance.dtype).eps) / reach
            slack *= float(np.abs(points).max() + np.abs(distance).max())
            across, growth, wrong = self._contradicts(feet, off, reach, slack)
            if (np.abs(off) > reach).any():  # of what is none but at the surface nobody says more
                wrong[:] = (growth <= RIGHT).all()
            elif wrong.any():  # or within round-off of an edge, where normals point anywhere
                beside = feet + reach * across
                off = self.distance(beside, 0.0)
                wrong &= self._contradicts(beside, off, reach, slack)[2]
        except checks.StepFailed as problem:
            raise checks.InputError(f"{refused}: {problem}") from problem.__cause__
        if wrong.any():
            at, more = int(wrong.argmax()), getattr(self.obstacle, "remark", "")
            raise checks.InputError(
                f"{refused}: its normals must point the way on which its distance grows, by as much"
                f" as that is long; at {feet[at].tolist()} it grows by {growth[at]:.3g} of a way "
                f"along {across[at].tolist()}" + (f" ({more})" if more else "")
            )
        turned = np.abs(normals - normals[0]).max(axis=1)
        if self.flat and turned.max() > RIGHT:
            at = int(turned.argmax())
            raise checks.InputError(
                f"{refused}: flat = True: its normals must be the same everywhere; they are "
                f"{normals[0].tolist()} at {points[0].tolist()} and {normals[at].tolist()} at "
                f"{points[at].tolist()}"
            )

    def _contradicts(
        self, points: np.ndarray, off: np.ndarray, reach: float, slack: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Normals at points, (n, d), by which share of a short way along these the distance grows,
        (n,), and where neither that nor its growth on the way there is near one, (n,) of bool: at
        an edge it grows so outwards only, in a notch inwards only."""
        across = self.normals(points, 0.0)
        growth = (self.distance(points + reach * across, 0.0) - off) / reach
        wrong = (growth <= SHARP - slack) | (growth >= 1 / SHARP + slack)
        if wrong.any():  # some have no distances within
            back = (off - self.distance(points - reach * across, 0.0)) / reach
            wrong &= (back <= SHARP - slack) | (back >= 1 / SHARP + slack)
        return across, growth, wrong

    def _feet(
        self, points: np.ndarray, distance: np.ndarray, reach: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Places at the surface, at time 0, to which the distances of points lead, (k, d), and the
        distances there, (k,); or the points, if none leads within ``reach`` of it."""
        feet, off, share = points.copy(), distance.copy(), np.ones(len(points))
        for _ in range(np.finfo(float).nmant):  # what halves each time is there
            if (np.abs(off) <= reach).all():
                break
            try:
                there = feet - (share * off)[:, None] * self.normals(feet, 0.0)
                left = self.distance(there, 0.0)
            except checks.StepFailed:  # there are no distances where it leads
                break
            nearer = np.abs(left) < np.abs(off)
            feet[nearer], off[nearer] = there[nearer], left[nearer]
            share[~nearer] *= 0.5
        on = np.abs(off) <= reach
        return (feet[on], off[on]) if on.any() else (points, distance)

    def describe(self) -> str:
        """The obstacle, without an address in memory."""
        own, shows = self.obstacle, type(self.obstacle).__repr__ is not object.__repr__
        return repr(own) if shows else marked(type(own).__name__, own.distance)
