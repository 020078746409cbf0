# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a contact asks of an obstacle, and how it asks whatever it was given."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Protocol, runtime_checkable

import numpy as np

from ..base import checks
from ..base.constants import RIGHT, SHARP
from ..base.overflow import told
from ..base.quoted import quoted
from ..base.shown import marked
from ..base.vectors import dot, largest


@runtime_checkable
class Obstacle(Protocol):
    """Anything with a signed distance; points are (n, d) in m, time in s.

    A method may leave out the time if it does not use it. Optional are

    * ``curvature(points, time)``: derivatives of the normals by the position, which are the second
      derivatives of the distance, (n, d, d) in 1/m. Without it Newton's method converges linearly
      where the obstacle is curved;
    * ``slopes(points, time)``: derivatives of the distances by the position, (n, d): of a true
      distance the normals. With it and the curvature a run is differentiated
      (:mod:`fenicsx_contact.gradients`), where nothing moves; what is flat needs neither;
    * ``velocity(points, start, end)``: mean velocity of the obstacle's material beside the points
      between two times, (n, d) in m/s, at the second of which it is there; asked for a thousandth
      of a step, too, of which differences of places are round-off. Or ``velocity(points, time)``,
      of first order by theta = 1 where it turns. Without, what moves does so along its normals;
    * ``flat``: whether the normal is the same everywhere and always; default: no; ``edged``:
      whether there may be edges, at which it jumps; default: yes; ``uniform``: whether the velocity
      is the same everywhere, too, so that derivatives see it as at rest;
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
        self._distance, asks = _timed(obstacle.distance, self.flat)
        self._normals, _ = _timed(obstacle.normals, self.flat)
        self.ours = _ours(obstacle.normals)  # of which a test knows that they are of unit length
        self._slopes, _ = _timed(getattr(obstacle, "slopes", obstacle.normals))
        self.edged = checks.truth(f"{what}.edged", getattr(obstacle, "edged", not self.flat))
        curvature, velocity = (getattr(obstacle, name, None) for name in ("curvature", "velocity"))
        self._curvature = _timed(curvature)[0] if curvature and not self.flat else None
        self._velocity = _mean(velocity) if velocity else None
        #: Whether its velocity is told, and not made of its motion, as where that is of its class.
        self.told = bool(velocity) and not (self.ours and hasattr(type(obstacle), "velocity"))
        #: Whether it tells all that derivatives of a run ask for.
        self.smooth = self.flat or bool(curvature and hasattr(obstacle, "slopes"))
        moving = getattr(obstacle, "moving", velocity is not None or asks)
        self.moving = checks.truth(f"{what}.moving", moving)
        self.uniform = self.flat and bool(getattr(obstacle, "uniform", False))

    def distance(self, points: np.ndarray, time: float) -> np.ndarray:
        """Signed distance of the points (n, d) at a time, positive outside, (n,) in m.

        Raises:
            StepFailed: there is none.
        """
        with _asked():
            answer = self._distance(points, time)
        return _finite("distance", answer, points, 0)

    def normals(self, points: np.ndarray, time: float) -> np.ndarray:
        """Outward unit normals, (n, d); raises likewise."""
        with _asked():
            answer = self._normals(points, time)
        normals = _finite("normals", answer, points)
        if not self.ours:
            length = dot(normals, normals) ** 0.5
            if not largest(length - 1) <= RIGHT:
                at = int(np.abs(length - 1).argmax())
                found = f"{normals[at].tolist()} at the point {points[at].tolist()}"
                raise wrong("normals", found, "unit vectors")
        return normals

    def slopes(self, points: np.ndarray, time: float) -> np.ndarray:
        """Derivatives of the distances by the position, (n, d)."""
        with _asked():
            answer = self._slopes(points, time)
        return _finite("slopes", answer, points)

    def curvature(self, points: np.ndarray, time: float) -> np.ndarray | None:
        """Derivatives of the normals, (n, d, d) in 1/m; None where none are known or needed."""
        if not self._curvature:
            return None
        with _asked():
            answer = self._curvature(points, time)
        return None if answer is None else _finite("curvature", answer, points, 2)

    def velocity(self, points: np.ndarray, start: float, end: float) -> np.ndarray:
        """Mean velocity of what is beside the points between two times, (n, d) in m/s."""
        if not self.moving:
            return np.zeros(points.shape)
        if self._velocity:
            with told(), _asked():
                return _finite("velocity", self._velocity(points, start, end), points)
        closer = self.distance(points, end) - self.distance(points, start)
        return -(closer / (end - start))[:, None] * self.normals(points, end)

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


@contextmanager
def _asked() -> Iterator[None]:
    """Within it an obstacle is asked for what it is: a step fails by what it raises."""
    try:
        yield
    except checks.StepFailed:
        raise
    except Exception as problem:
        name = type(problem).__name__
        raise checks.StepFailed(f"an obstacle raises {name}: {problem}") from problem


def _parameters(function: Callable) -> list[inspect.Parameter] | None:
    """Parameters that may be given by place, or None if nobody knows."""
    try:
        parameters = list(inspect.signature(function).parameters.values())
    except (TypeError, ValueError):
        return None
    if any(p.kind is p.VAR_POSITIONAL for p in parameters):
        return None
    return [p for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]


def _timed(
    function: Callable, flat: bool = False
) -> tuple[Callable[[np.ndarray, float], np.ndarray], bool]:
    """The function of points as one of points and time, and whether it asks for the time; what is
    ``flat`` is affine in places, which are not so large that it would overflow."""
    parameters = _parameters(function)
    asks = parameters is None or len(parameters) > 1
    answer = function if asks else lambda points, time: function(points)

    def asked(points: np.ndarray, time: float) -> np.ndarray:
        if not largest(points) <= checks.LARGEST:  # of an iterate that diverges
            raise checks.StepFailed("facets of a contact collapse, or are nowhere")
        if flat:
            return answer(points, time)
        with told():
            return answer(points, time)

    # what is ours and has a default for the time does not depend on it without saying so
    needed = asks and parameters and parameters[1].default is inspect.Parameter.empty
    return asked, bool(needed) or (asks and not _ours(function))


def _ours(function: Callable) -> bool:
    """Whether it is a function of the package."""
    return str(getattr(function, "__module__", "")).startswith(__name__.partition(".")[0])


def _mean(velocity: Callable) -> Callable[[np.ndarray, float, float], np.ndarray]:
    """The velocity as a function of points, start and end."""
    parameters = _parameters(velocity)
    if parameters is None or len(parameters) > 2:
        return velocity
    if len(parameters) == 2:
        return lambda points, start, end: velocity(points, 0.5 * (start + end))
    return lambda points, start, end: velocity(points)


def _finite(what: str, answer: Any, points: np.ndarray, order: int = 1) -> np.ndarray:
    """An answer, at each point a tensor of an order, or StepFailed if it is none."""
    shape = len(points), *points.shape[1:] * order
    found, allowed = "", f"{shape} real numbers for {len(points)} points"
    if type(answer) is not np.ndarray or answer.dtype.kind != "f":  # it is asked often
        try:
            answer = checks.floats(answer)
        except (TypeError, ValueError):
            found = "complex, masked, text, truth values or lists of unlike lengths"
    if not found and answer.shape != shape:
        found = f"of the shape {answer.shape}"
    if not found and not largest(answer) <= checks.LARGEST:  # nor NaN; powers of it overflow
        at = np.argwhere(~(np.abs(answer) <= checks.LARGEST))[0]
        allowed = f"finite, at most {checks.LARGEST:g}"
        found = f"{answer[tuple(at)]} at the point {points[at[0]].tolist()}"
    if found:
        raise wrong(what, found, allowed)
    return np.asarray(answer)


def wrong(what: str, found: str, allowed: str) -> checks.StepFailed:
    """What a step fails by in which an obstacle gives such an answer."""
    return checks.StepFailed(f"the {what} of an obstacle is {found}: must be {allowed}")
