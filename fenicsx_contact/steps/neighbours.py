# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which contacts a step can be about. Two rigid bodies meet only where the spheres do that hold
their facets; pairs of which these stay apart sleep, and cost nothing. What wakes them is where the
bodies went: a step in which spheres met is solved again with these pairs in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..contact.contact import Contact
from ..solids import Trace
from ..theory.scheme import Step

#: Cost: so many times the way to each other that bodies have speed for in a step must lie between
#: two that sleep.
AHEAD = 4.0


class Neighbours:
    """Says which contacts are awake.

    Args:
        contacts: all of a scene.

    Attributes:
        awake: which of them are, (n,) of bool.
    """

    def __init__(self, contacts: Sequence[Contact]) -> None:
        self._contacts = list(contacts)
        self._pairs = np.flatnonzero([_may_sleep(contact) for contact in contacts])
        pairs = [contacts[k] for k in self._pairs]
        self._bodies = list({id(s): s for pair in pairs for s in pair.solids}.values())
        number = {id(body): i for i, body in enumerate(self._bodies)}
        self._of = np.array([[number[id(s)] for s in pair.solids] for pair in pairs], dtype=int)
        radii = [sum(map(_radius, pair.solids, pair.traces)) for pair in pairs]
        self._radii = np.array(radii)
        self.awake = np.ones(len(contacts), dtype=bool)
        self._met = np.zeros(len(pairs), dtype=bool)  # in the step that is being solved

    def look(self, step: Step, all_of_them: bool = False) -> bool:
        """Let pairs sleep and wake at the start of a step, or wake ``all_of_them``; whether any
        does."""
        if not len(self._pairs):
            return False
        ways = self._ways([body.velocity[: body.dim] for body in self._bodies]) * step.horizon
        needed = self._met | (self._apart() <= AHEAD * ways) | all_of_them
        now, was = self.awake.copy(), self.awake[self._pairs]
        now[self._pairs] = needed
        for k in self._pairs[was & ~needed]:  # what bore is to let go first
            now[k] = self._contacts[k].status.any()
        for k in self._pairs[~was & needed]:
            self._wake(self._contacts[k], step)
        changed = not np.array_equal(now, self.awake)
        self.awake = now
        return changed

    def met(self) -> bool:
        """Whether pairs that sleep may have met on the way to the trial state."""
        if self.awake.all():
            return False
        ways = self._ways([body.trial_place - body.place for body in self._bodies])
        through = (self._apart() <= ways) & ~self.awake[self._pairs]
        self._met |= through
        return bool(through.any())

    def accept(self) -> None:
        """The step is over."""
        self._met[:] = False

    def _apart(self) -> np.ndarray:
        """How far the spheres of the pairs are apart at the start of the step, m."""
        places = np.array([body.place for body in self._bodies])
        between = places[self._of[:, 0]] - places[self._of[:, 1]]
        return np.sqrt((between**2).sum(axis=1)) - self._radii

    def _ways(self, of_each: list[np.ndarray]) -> np.ndarray:
        """How far the bodies of the pairs go to or from each other."""
        a, b = np.array(of_each)[self._of.T]
        return np.asarray(np.linalg.norm(a - b, axis=1))

    @staticmethod
    def _wake(contact: Contact, step: Step) -> None:
        start = replace(step, dt=0.0, ahead=step.horizon)
        for solid in contact.solids:
            solid.predict(start)
        contact.coupling.follow()
        contact.coupling.accept()
        contact.blows.forget()
        contact.locate()

    def state(self) -> dict[str, np.ndarray]:
        """Who sleeps, if anyone may."""
        return {"awake": self.awake} if len(self._pairs) else {}

    def restore(self, state: dict[str, np.ndarray]) -> bool:
        """Take up a state that :meth:`state` gave; whether others are awake now."""
        before, self.awake = self.awake, np.array(state.get("awake", self.awake), dtype=bool)
        self.accept()
        return not np.array_equal(before, self.awake)


def _may_sleep(contact: Contact) -> bool:
    """A pair of rigid bodies, of a law that neither acts from afar nor remembers."""
    if len(contact.solids) != 2 or contact.solids[0] is contact.solids[1]:
        return False
    plain = contact.formulation.multipliers and not contact.memory.values
    return plain and all(solid.shiftable for solid in contact.solids)


def _radius(solid: Any, trace: Trace) -> float:
    """Of the sphere about the centre of mass that holds the facets, m."""
    return float(np.linalg.norm(trace.positions() - solid.place, axis=1).max())
