# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which points come to rest by impacts without end within a step, and may be put to rest at once.

A point that loads push back, a in m/s², and that leaves with the share q < 1 of the speed with
which it came, u = q w, returns after 2 u / a, then after q times that, and so on: for good after
2 u / (a (1 - q)). If that is within the step, a percussion with w_n = 0 ends it as all these
impacts would. Without loads speeds may fall without end, too: of several bodies that lose too much
in each impact to part (inelastic collapse). What goes on otherwise ends by itself, however long.

S. McNamara & W.R. Young, Phys. Fluids A 4, 496-504, 1992.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from ..base.checks import StepFailed
from ..base.vectors import dot
from ..theory.scheme import Step
from .candidates import Candidates
from .fed_fields import Teller
from .memory import Memory
from .statuses import at_once

#: So many impacts of a point within a step are located, each with its rebound, before it may be put
#: to rest where unending ones would bring it.
BLOWS = 8


class Struck(Teller, Protocol):
    """What a contact tells of what strikes it; arrays are of the points."""

    status: np.ndarray
    trial_status: np.ndarray
    jump: np.ndarray
    trial_jump: np.ndarray
    normal: np.ndarray
    resolution: float
    noise: float
    candidates: Candidates
    memory: Memory


class Blows:
    """What strikes the points of a contact within a step of a run.

    Args:
        n: number of points.

    Attributes:
        settled: points that are put to rest, (n,) of bool: in the rest of the step no percussion
            throws them back, and the parts of it may close them.
        idle: that the last percussion could stop and left as they were: so would another one.
    """

    def __init__(self, n: int) -> None:
        self.settled, self.idle = np.zeros((2, n), dtype=bool)
        self._number, self._fastest, self._came, self._back = np.zeros((4, n))
        self._here = np.zeros(n)  # blows since time last went on

    def forget(self, points: np.ndarray | None = None) -> None:
        """Another step begins; or others meet at these points, (n,) of bool."""
        each = self.settled, self.idle, self._number, self._fastest, self._came, self._back
        for values in (*each, self._here):
            values[... if points is None else points] = 0

    def closed(self, contact: Struck, step: Step) -> np.ndarray:
        """Points that touch at the start of a step, (n,) of bool, or in a percussion arrive in the
        same instant; in a step of some length those that are put to rest, too."""
        touches = contact.touching()
        if step.dt:
            return touches | self.settled
        approach = dot(contact.jump, contact.coupling.start_normals())
        speeds = approach, contact.resolution
        return at_once(touches, contact.status > 0, contact.gap, *speeds, contact.tolerance)

    def fly(self, contact: Struck, dt: float) -> None:
        """Take note of how loads push open points back, in the trial state of ``dt`` seconds in
        which none of them could close."""
        self.idle[:], self._here[:] = False, 0
        change = dot(contact.trial_jump - contact.jump, contact.coupling.start_normals())
        self._back = np.where(contact.candidates.allowed, self._back, change / dt)

    def settle(self, contact: Struck, left: float, error: float) -> tuple[bool, bool]:
        """Choose points to be put to rest in the trial state of a percussion, which then is to be
        solved once more.

        Args:
            contact: whose points these are.
            left: of the step after the percussion, s.
            error: relative one with which a blow is accepted.

        Returns:
            Whether there are any, and whether some of them go on without loads, slower than that
            share of their fastest blow.

        Raises:
            StepFailed: one rebounds within an instant as often as that, and loses nothing.
        """
        number, fastest, came, fresh = self._with(contact)  # as if it were accepted
        endless = fresh & (self._here >= BLOWS) & (came >= (1 - error) * fastest)
        if endless.any():
            raise StepFailed(
                f"a point rebounds without end within one instant, by {came[endless].max():.3g} m/s"
                " each time"
            )
        leaves = -dot(contact.trial_jump, contact.normal)
        falls = (leaves > 0) & (leaves < came) & (self._back > 0)
        ends = falls & (2 * leaves * came <= self._back * (came - leaves) * left)
        least = np.maximum(error * fastest, contact.resolution)
        faint = fresh & (np.abs(came) <= least) & ~ends
        # it would leave, but rise by less than round-off of places
        unseen = fresh & (leaves > contact.resolution) & (not contact.coupling.driven)
        unseen &= leaves**2 <= 2 * self._back * contact.noise
        new = ((ends | faint) & (number >= BLOWS) | unseen) & ~self.settled
        self.settled |= new
        return bool(new.any()), bool((new & faint & (fastest > contact.resolution / error)).any())

    def note(self, contact: Struck) -> None:
        """Count a percussion that is accepted now."""
        self._number, self._fastest, self._came, fresh = self._with(contact)
        self._here += fresh
        change = np.linalg.norm(contact.trial_jump - contact.jump, axis=1)
        self.idle = (self.idle | contact.candidates.allowed) & (change <= contact.resolution)

    def _with(self, contact: Struck) -> tuple[np.ndarray, ...]:
        """Blows, their largest speed, the last one, m/s, with those of the trial state; which
        these are."""
        approach = dot(contact.jump, contact.coupling.start_normals())
        fresh = (contact.trial_status > 0) & (
            (approach > contact.resolution) | (contact.status == 0)
        )
        came = np.where(fresh, approach, self._came)
        return self._number + fresh, np.maximum(self._fastest, came), came, fresh


def struck_gap(contact: Struck, step: Step) -> np.ndarray:
    """The gap that a percussion reads, (n,) in m: it corrects no drift, and what wears goes on
    to."""
    gap = contact.coupling.begun_gaps(contact.gap, step)
    return np.asarray(np.minimum(gap, 0.0) - contact.memory.receding * step.horizon)
