# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where the derivative of a linearised step does not exist, and which of these places its tangents
meet."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..base.constants import SAME
from ..contact.arrivals import arrival
from ..scene import Scene
from ..steps.trial import Trial
from .blocks import LinearStep
from .edge import Edge
from .kinks import Kink, alike, kinks
from .linearise import Linearisation, arriving
from .recording import Along
from .surface import ContactRows
from .undetermined import rigid, shifted, sliding


class Edges:
    """Linearises the steps of a run and asks them for their kinks.

    Args:
        scene: the scene.
        linear: linearises its steps.
        along: derivatives along the run.

    Attributes:
        met: the kinks of the run so far.
    """

    def __init__(self, scene: Scene, linear: Linearisation, along: Along) -> None:
        self._scene, self._linear, self._along = scene, linear, along
        self._parameters = linear.parameters
        self.met: list[Kink] = []
        self._here: list[Kink] = []  # of the step

    def look(self, trial: Trial) -> LinearStep:
        """A step that was solved, and may be solved again."""
        if not trial.again:
            self._here.clear()
        step = self._linear.step(trial)
        self._along.solved(trial, step)
        self._here += self._kinks(trial)
        return step

    def take(self, trial: Trial) -> LinearStep:
        """The same of one that is accepted next."""
        step = self.look(trial)
        self.met += dict.fromkeys(self._here)
        return step

    def _kinks(self, trial: Trial) -> list[Kink]:
        """The kinks of the step that was linearised last, and which the derivatives along the run
        have taken up, that these meet; they are asked for only where there may be some."""
        found, resolution = self._undetermined(trial), self._scene.stepper.resolution
        for rows in self._linear.contacts:
            misses = _Met(self._linear, rows, self._along).misses
            found += kinks(rows, trial, resolution, misses, not self._along.begun)
        if self._scene.locate_impacts and trial.step.dt:
            found += self._touches(trial)
        return found + self._driven(trial)

    def _undetermined(self, trial: Trial) -> list[Kink]:
        """Points that slide under pressures that are not unique, where the motion hangs on these:
        the run has taken some of them."""
        linear = self._linear
        asked = [rows for rows in linear.contacts if rigid(rows)]
        slide = {id(rows): at for rows in asked if (at := sliding(rows)) is not None}
        idle = linear.last.idle() if slide else None
        if idle is None:
            return []
        state, sizes = slice(0, linear.size), linear.last.sizes
        moves = not alike(idle[state] / sizes[state], np.ones(linear.size)).all()
        if not moves:
            x, start = self._along.change, self._along.state
            with shifted(asked, [idle[linear.at.multipliers(rows)] for rows in asked]) as others:
                instead = {id(rows): other for rows, other in zip(asked, others)}
                contacts = [instead.get(id(rows), rows) for rows in linear.contacts]
                other = linear.assembled(contacts).tangent(start)
            largest = np.abs(x / sizes[:, None]).max(axis=0)
            change = (other - x)[state] / sizes[state, None]
            moves = not alike(change, np.broadcast_to(largest, change.shape)).all()
        if not moves:
            return []
        what = "slides under pressures that are not unique, on which its motion hangs"
        found = []
        for rows in asked:
            if id(rows) in slide:
                place = tuple(rows.contact.surface.points[slide[id(rows)]].tolist())
                found.append(Kink(rows.contact.name, place, trial.step.end, what))
        return found

    def _driven(self, trial: Trial) -> list[Kink]:
        """Beams whose law, in plain arithmetic, lies on the edge of two branches."""
        found: list[Kink] = []
        for m in self._linear.motions:
            for i, parameter in enumerate(self._parameters):
                if not m.kinked(parameter, trial.step, None):
                    continue
                start, part = self._along.state[:, i], self._linear.at.part
                each = start[part("q", m.solid)], start[part("v", m.solid)]
                if m.kinked(parameter, trial.step, each):
                    what = "the law of its drive is on the edge of another branch"
                    found.append(Kink(m.solid.name, (), trial.step.end, what))
                    break
        return found

    def _touches(self, trial: Trial) -> list[Kink]:
        """Points that are open and just touch where the step ends, beside the one that ends it."""
        found: list[Kink] = []
        first = max(self._linear.contacts, key=lambda rows: arrival(rows.contact).gap, default=None)
        for rows in self._linear.contacts:
            contact = rows.contact
            gaps, free = contact.coupling.gaps(), contact.chosen & ~contact.candidates.allowed
            ends = arriving(rows) if trial.arrives and rows is first else -1
            for point in np.flatnonzero(free & (np.abs(gaps) <= contact.tolerance)):
                if point == ends:
                    continue
                row, by = rows.gap_row(point), rows.gap_by(self._parameters, point)
                way = self._along.change[self._linear.at.part("q", rows.motion.solid)]
                left, terms = row @ way + by, np.abs(row) @ _largest(way) + np.abs(by)
                if alike(left, terms).all():
                    continue
                place = tuple(contact.surface.points[point].tolist())
                with_it = "at the same instant as another point" if trial.arrives else "and no more"
                found.append(Kink(contact.name, place, trial.step.end, f"touches {with_it}"))
        return found


class _Met:
    """What the tangent of a step changes of what the rows of a contact read; it is asked for only
    where they have an edge.

    Args:
        linear: has just linearised the step.
        rows: of the contact.
        along: has taken it up.
    """

    def __init__(self, linear: Linearisation, rows: ContactRows, along: Along) -> None:
        self._linear, self._rows, self._along = linear, rows, along

    @cached_property
    def _changes(self) -> dict[str, np.ndarray]:
        """Of the solids' q and v at both ends."""
        return self._linear.at.changes(self._rows, self._along.change, self._along.state)

    @cached_property
    def _sizes(self) -> dict[str, np.ndarray]:
        """The largest of each."""
        return {name: _largest(change) for name, change in self._changes.items()}

    @cached_property
    def _multipliers(self) -> np.ndarray:
        """Changes of the multipliers, (candidates, kinds, parameters)."""
        change, rows = self._along.change[self._linear.at.multipliers(self._rows)], self._rows
        points = len(rows.points)
        return change.reshape(points, rows.unknowns // points, change.shape[1])

    def misses(self, edge: Edge) -> np.ndarray:
        """Whether the tangent fails the rows of points on the other side of their decision; all of
        them candidates, or none."""
        changes, sizes = dict(self._changes), dict(self._sizes)
        at = np.flatnonzero(np.isin(self._rows.points, edge.points))
        if len(at):  # multipliers of a kind are as large as the largest of all points
            own, size = self._multipliers[at], np.abs(self._multipliers).max(axis=0)
            changes["m"] = own.reshape(-1, own.shape[2])
            size = np.maximum(size, SAME * size.max(axis=0))  # what is less is round-off of others
            sizes["m"] = np.broadcast_to(size, own.shape).reshape(changes["m"].shape)
        left, terms = self._left(edge, changes, sizes)
        # by the terms of either side: where all pressures stay 0 these alone are round-off
        here = self._left(Edge(edge.points, edge.what, told=edge.here), changes, sizes)
        terms = np.maximum(terms, here[1])
        if edge.told:  # nothing is missed where what is told there changes nothing
            left = left - here[0]
        return ~alike(*(each.reshape(len(edge.points), -1) for each in (left, terms)))

    def _left(
        self, edge: Edge, changes: dict[str, np.ndarray], sizes: dict[str, np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:
        """What changes leave of the rows of points there, and the terms that it is left of."""
        with self._rows.other(edge) as other:
            parameters = self._linear.parameters
            by = np.stack([other.by(parameter)[0] for parameter in parameters], axis=1)
            derivatives = other.derivatives()
        left, terms = by, np.abs(by)
        for name, (multipliers, _) in derivatives.items():
            if name in changes:
                left = left + multipliers @ changes[name]
                terms = terms + abs(multipliers) @ sizes[name]
        return left, terms


def _largest(changes: np.ndarray) -> np.ndarray:
    """The largest of each column everywhere: where little changes, round-off does."""
    return np.broadcast_to(np.abs(changes).max(axis=0, initial=0.0), changes.shape)
