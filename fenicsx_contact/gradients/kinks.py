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
from ..theory.friction import creeps
from ..theory.scheme import Step
from .edge import Edge
from .surface import ContactRows

#: What a status is.
NAMES = ("open", "sticks", "slips")


class Kink(NamedTuple):
    """A point at which the derivative does not exist, or a solid under a law without one.

    Attributes:
        contact: its name, or that of the solid.
        place: reference coordinates of the point, m; of a solid none.
        time: at the end of the step, s.
        what: the decision on whose edge it is.
    """

    contact: str
    place: tuple[float, ...]
    time: float
    what: str

    def __str__(self) -> str:
        where = f"contact {self.contact!r}, point {self.place}"
        if not self.place:
            where = f"solid {self.contact!r}"
        return f"{where}, t = {self.time:.9g} s: {self.what}"


class NoDerivative(Exception):
    """The derivative does not exist; where and why."""


def resolved(rows: ContactRows, resolution: float) -> float:
    """The speed below which the step told nothing apart, m/s."""
    own = largest(rows.contact.coupling.velocities("trial_velocity"))
    return max(resolution, ROUND_OFF * own)


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
            with e.being(changed):
                after = e.statuses()
            if creeps(rows.contact.friction_law):  # it has no edge between stick and slip
                before, after = (np.minimum(status, 1) for status in (before, after))
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
    asked = contact.chosen & contact.candidates.allowed & contact.candidates.near()
    asked[rows.points] = False
    approach = dot(rows.jump, rows.normal)
    points = np.flatnonzero(asked & (np.abs(limit - approach) <= speed))
    if len(points):
        e, changed = contact.equations, contact.equations.values.copy()
        changed[: e.jumps] = (rows.jump + speed * rows.normal).ravel()
        yield Edge(points, ["open, on the edge of: bears"] * len(points), changed)


def beginning(rows: ContactRows, step: Step, speed: float, first: bool) -> Iterator[Edge]:
    """Candidates that begin a step where they touch, up to round-off, without a normal speed or
    without a slip, though no step before held them so: a law reads all three by what they are
    above or below zero. What was held before the ``first`` step that is linearised was by what may
    change now, up to its error."""
    contact, e = rows.contact, rows.contact.equations
    if not len(rows.points):
        return
    # a status without a force is none that a step has decided
    status = np.where(contact.force.any(axis=1), contact.status, 0)
    held = np.zeros(len(status), dtype=bool) if first else status > 0
    k, p = e.fields, rows.points

    def edge(points: np.ndarray, what: str, *told: tuple[np.ndarray, np.ndarray]) -> Edge:
        there = []
        for field, side in told:
            there.append((field, field.copy()))
            there[-1][1].reshape(side.shape)[points] = side[points]
        return Edge(points, [f"begins the step {what}"] * len(points), told=tuple(there))

    # what bears says where the rest of a body touches
    if contact.formulation.gap_share < 1 and not held.any():
        one, own = np.ones(contact.surface.size), contact.coupling.velocities("velocity")
        gap, start = k.gap.x.array, k.start_jump_n.x.array
        stays = (start == 0) | ((status > 0) & alike(start, largest(own) * one))
        still = start, np.where(stays, 0.0, start)
        depth = np.where(contact.gap > 0, contact.gap, gap)  # of which an impact reads nothing
        if len(on := p[np.abs(depth[p]) <= contact.tolerance]):
            beyond = contact.tolerance + speed * step.horizon
            for side in (-beyond, beyond):
                there = edge(on, "exactly where it touches", (gap, side * one), still)
                yield there._replace(here=there.told[1:])
        if step.limit_rate and len(on := p[stays[p]]):
            here = edge(on, "without a normal speed", still).told
            yield edge(on, "without a normal speed", (start, -speed * one))._replace(here=here)
    slip = k.start_slip.x.array.reshape(rows.normal.shape)
    if k.friction is None or not step.limit_rate:
        return
    loose = p[(status[p] != 1) & ~slip[p].any(axis=1)]
    for along in k.frame()[1] if len(loose) else ():
        for sign in (1.0, -1.0):
            yield edge(loose, "without a slip", (k.start_slip.x.array, sign * speed * along))


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
        what = "arrives without speed: it grazes, or comes to rest by impacts without end"
        kink = Kink(rows.contact.name, place, step.end, what)
        raise NoDerivative(str(kink))


def alike(left: np.ndarray, terms: np.ndarray) -> np.ndarray:
    """Whether tangents solve rows, as well as steps are asked to solve theirs: what is left, and
    the terms that it is left of; by the first index."""
    return (np.abs(left) <= ACCEPTED * terms).reshape(len(left), -1).all(axis=1)


def kinks(
    rows: ContactRows,
    trial: Trial,
    resolution: float,
    misses: Callable[[Edge], np.ndarray],
    first: bool,
) -> list[Kink]:
    """The kinks of a step.

    Args:
        rows: of a contact, in the step.
        trial: the step.
        resolution: of its velocities, m/s.
        misses: whether the tangent fails the rows of points on the other side.
        first: whether no step before it was linearised.
    """
    speed = resolved(rows, resolution)
    edges = [*weak(rows, speed), *beginning(rows, trial.step, speed, first)]
    edges += [] if trial.arrives else grazing(rows, trial, speed)
    found: dict[int, str] = {}
    for edge in edges:
        for point, what, missed in zip(edge.points, edge.what, misses(edge)):
            if missed:
                found.setdefault(int(point), what)
    places = rows.contact.surface.points
    return [
        Kink(rows.contact.name, tuple(places[p].tolist()), trial.step.end, what)
        for p, what in sorted(found.items())
    ]
