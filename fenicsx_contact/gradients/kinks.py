# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where a derivative does not exist: points whose status is about to change.

A status is a decision: open or bearing, stick or slip. Where the solution lies on the edge of one
(an open point that neither approaches nor leaves its obstacle, a point that sticks at its bound, a
bearing point without pressure) the step has a linearisation on either side. The derivative exists
all the same where the tangent of one side solves the other, too: points between others of a rigid
solid are such.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..base.constants import ROUND_OFF
from ..base.vectors import dot, largest
from ..steps.certificate import ACCEPTED
from ..steps.step import Trial
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


def weak(rows: ContactRows, speed: float) -> dict[int, tuple[str, np.ndarray]]:
    """The candidates whose status changes when their jumps change by ``speed``: what is undecided,
    and the unknowns of the other side, by point."""
    e, k = rows.contact.equations, rows.contact.equations.fields
    if not len(rows.points):
        return {}
    values, before = e.values.copy(), e.statuses()
    n, d = rows.normal.shape
    ways = [rows.normal]
    if e.size > e.tractions:
        tau = values[e.tractions :].reshape(d - 1, n)
        size = np.linalg.norm(tau, axis=0)
        along = np.where(size > 0, tau / np.where(size > 0, size, 1.0), 0.0)
        along[0, size == 0] = 1.0
        ways.append(np.einsum("tn,tnd->nd", along, k.frame()[1]))
    found: dict[int, tuple[str, np.ndarray]] = {}
    for way in ways:
        for sign in (1.0, -1.0):
            changed = values.copy()
            changed[: e.jumps] += sign * speed * way.ravel()
            e.values = changed
            after = e.statuses()
            for point in rows.points[(after != before)[rows.points]]:
                a, b = (NAMES[int(s[point])] for s in (before, after))
                found.setdefault(int(point), (f"{a}, on the edge of: {b}", changed))
    e.values = values
    return found


def grazing(rows: ContactRows, trial: Trial, speed: float) -> dict[int, tuple[str, np.ndarray]]:
    """Points that have no equations and neither approach nor leave, likewise."""
    contact, step = rows.contact, trial.step
    limit = contact.limit(step)
    if limit is None or (step.dt and not contact.candidates.allowed.any()):
        return {}
    asked = contact.chosen & contact.candidates.allowed & contact.coupling.near()
    asked[rows.points] = False
    approach = dot(rows.jump, rows.normal)
    points = np.flatnonzero(asked & (np.abs(limit - approach) <= speed))
    e, changed = contact.equations, contact.equations.values.copy()
    changed[: e.jumps] = (rows.jump + speed * rows.normal).ravel()
    return {int(point): ("open, on the edge of: bears", changed) for point in points}


def alike(left: np.ndarray, terms: np.ndarray) -> bool:
    """Whether a tangent solves rows, as well as steps are asked to solve theirs: what is left, and
    the terms that it is left of."""
    return bool((np.abs(left) <= ACCEPTED * terms).all())


def kinks(
    rows: ContactRows,
    trial: Trial,
    resolution: float,
    misses: Callable[[int, np.ndarray], bool],
) -> list[Kink]:
    """The kinks of a step.

    Args:
        rows: of a contact, in the step.
        trial: the step.
        resolution: of its velocities, m/s.
        misses: whether the tangent fails the rows of a point with other unknowns.
    """
    speed = resolved(rows, resolution)
    asked = weak(rows, speed)
    if not trial.arrives:
        asked |= grazing(rows, trial, speed)
    found = {p: what for p, (what, other) in asked.items() if misses(p, other)}
    places = rows.contact.surface.points
    return [
        Kink(rows.contact.name, tuple(places[p].tolist()), trial.step.end, what)
        for p, what in sorted(found.items())
    ]
