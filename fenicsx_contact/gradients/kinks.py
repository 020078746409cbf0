# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where a derivative does not exist: points whose status is about to change.

A status is a decision: open or bearing, stick or slip. Where the solution lies on the edge of one
(an open point that neither approaches nor leaves its obstacle, a point that sticks at its bound, a
bearing point without pressure) the step has a linearisation on either side. The derivative exists
all the same where the tangent of one side solves the other, too: points between others of a rigid
solid are such.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import sqrt
from typing import NamedTuple

import numpy as np

from ..base.constants import ROUND_OFF
from ..base.vectors import dot, largest
from ..steps.certificate import ACCEPTED
from ..steps.trial import Trial
from ..theory.theta import Step
from .surface import ContactRows

#: What a status is.
NAMES = ("open", "sticks", "slips")


class Kink(NamedTuple):
    """A point at which the derivative does not exist.

    Attributes:
        contact: its name.
        place: reference coordinates of the point, m.
        time: at the end of the step, s.
        what: the decision on whose edge it is.
    """

    contact: str
    place: tuple[float, ...]
    time: float
    what: str

    def __str__(self) -> str:
        return f"contact {self.contact!r}, point {self.place}, t = {self.time:.9g} s: {self.what}"


class NoDerivative(Exception):
    """The derivative does not exist; where and why."""


def resolved(rows: ContactRows, resolution: float) -> float:
    """The speed below which the step told nothing apart, m/s."""
    own = largest(rows.contact.coupling.velocities("trial_velocity"))
    return max(resolution, ROUND_OFF * own)


class Edge(NamedTuple):
    """Points that a small change of their jumps takes to another status.

    Attributes:
        points: their numbers, (k,).
        what: is undecided, (k,).
        values: the unknowns of the other side.
    """

    points: np.ndarray
    what: list[str]
    values: np.ndarray


def weak(rows: ContactRows, speed: float) -> Iterator[Edge]:
    """The candidates whose status changes when their jumps change by ``speed``."""
    e, k = rows.contact.equations, rows.contact.equations.fields
    if not len(rows.points):
        return
    values, before = e.values.copy(), e.statuses()
    n, d = rows.normal.shape
    ways = [rows.normal]
    if e.size > e.tractions:
        tau = values[e.tractions :].reshape(d - 1, n)
        size = np.linalg.norm(tau, axis=0)
        along = np.where(size > 0, tau / np.where(size > 0, size, 1.0), 0.0)
        along[0, size == 0] = 1.0
        ways.append(np.einsum("tn,tnd->nd", along, k.frame()[1]))
    for way in ways:
        for sign in (1.0, -1.0):
            changed = values.copy()
            changed[: e.jumps] += sign * speed * way.ravel()
            e.values = changed
            after = e.statuses()
            e.values = values
            points = rows.points[(after != before)[rows.points]]
            if len(points):
                names = [[NAMES[int(s[p])] for s in (before, after)] for p in points]
                yield Edge(points, [f"{a}, on the edge of: {b}" for a, b in names], changed)


def grazing(rows: ContactRows, trial: Trial, speed: float) -> Iterator[Edge]:
    """Points that have no equations and neither approach nor leave."""
    contact, step = rows.contact, trial.step
    limit = contact.candidates.limit(step)
    if limit is None or (step.dt and not contact.candidates.allowed.any()):
        return
    asked = contact.chosen & contact.candidates.allowed & contact.coupling.near()
    asked[rows.points] = False
    approach = dot(rows.jump, rows.normal)
    points = np.flatnonzero(asked & (np.abs(limit - approach) <= speed))
    if len(points):
        e, changed = contact.equations, contact.equations.values.copy()
        changed[: e.jumps] = (rows.jump + speed * rows.normal).ravel()
        yield Edge(points, ["open, on the edge of: bears"] * len(points), changed)


def refuse_grazing(rows: ContactRows, at: int, step: Step, resolution: float) -> None:
    """A point that arrives with no more speed than it loses within the tolerance of its place
    may as well not arrive.

    Raises:
        NoDerivative: it does.
    """
    speed = float(rows.normal[at] @ rows.jump[at])
    change = abs(speed - float(rows.normal[at] @ rows.start_jump[at])) / step.dt
    graze = sqrt(2 * change * rows.contact.tolerance)
    if speed <= max(graze, resolved(rows, resolution)):
        place = tuple(rows.contact.surface.points[at].tolist())
        kink = Kink(rows.contact.name, place, step.end, "arrives without speed: grazing")
        raise NoDerivative(str(kink))


def alike(left: np.ndarray, terms: np.ndarray) -> np.ndarray:
    """Whether tangents solve rows, as well as steps are asked to solve theirs: what is left, and
    the terms that it is left of; by the first index."""
    return (np.abs(left) <= ACCEPTED * terms).reshape(len(left), -1).all(axis=1)


def kinks(
    rows: ContactRows,
    trial: Trial,
    resolution: float,
    misses: Callable[[np.ndarray, np.ndarray], np.ndarray],
) -> list[Kink]:
    """The kinks of a step.

    Args:
        rows: of a contact, in the step.
        trial: the step.
        resolution: of its velocities, m/s.
        misses: whether the tangent fails the rows of points with other unknowns.
    """
    speed = resolved(rows, resolution)
    edges = [*weak(rows, speed), *([] if trial.arrives else grazing(rows, trial, speed))]
    found: dict[int, str] = {}
    for edge in edges:
        for point, what, missed in zip(edge.points, edge.what, misses(edge.points, edge.values)):
            if missed:
                found.setdefault(int(point), what)
    places = rows.contact.surface.points
    return [
        Kink(rows.contact.name, tuple(places[p].tolist()), trial.step.end, what)
        for p, what in sorted(found.items())
    ]
