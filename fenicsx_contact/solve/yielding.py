# SPDX-License-Identifier: LGPL-3.0-or-later
"""How much a contact yields in an iteration, where its multipliers are not unique.

Points of a rigid solid are hyperstatic, and so is a node in a corner of obstacles, which ask more
of it than it has components: the tangent is singular, and a plain Newton step goes far along forces
that do nothing, past points that then open or slip. Levenberg's and Marquardt's step stays near:
each multiplier yields, in the tangent and never in the residual, as much as the error is large,
with which the method still converges quadratically where solutions are not isolated (N. Yamashita,
M. Fukushima, Computing Suppl. 15, 239-249, 2001).
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

#: The compliance of a plain step (scaled), which picks the multipliers nearest to the last ones;
#: that of solids that deform, of which only held nodes need it.
COMPLIANCE, FIRM = 1e-8, 1e-12
#: On the way it is the error of the last iteration between these: smaller ones make much of
#: round-off, larger ones gain nothing.
YIELDING = 1e-6, 1e-3
#: The error counts by so much; by so many times more after a step that made it worse, and so many
#: times less after one that did not, down to the first.
CAUTION, MORE, LESS = 1e-4, 100.0, 10.0
#: Cost: so many careful steps that do not halve the error while no status changes are enough.
CREEPS = 5


class Stepping(Protocol):
    """What takes Newton steps.

    Attributes:
        worst: the largest error of any row, after `error`.
    """

    worst: float

    def yields(self, compliance: float) -> bool: ...
    def error(self) -> float: ...
    def now(self) -> np.ndarray: ...
    def state(self) -> list[np.ndarray]: ...
    def go_back(self, state: list[np.ndarray], share: float = 1.0) -> None: ...


class Yielding:
    """The compliance of one iteration after the other.

    Attributes:
        compliance: of the present one, scaled.
        first: whether none was asked for yet.
    """

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Begin anew, with a plain step."""
        self.compliance, self.first = COMPLIANCE, True
        self._last, self._stuck, self._caution = 0.0, 0, CAUTION
        self._statuses, self._crept = np.empty(0), 0

    def next(self, error: float, statuses: np.ndarray) -> None:
        """Take up the error before an iteration, scaled, and the statuses of all points. Where two
        of the least steps gained nothing rows contradict each other: a plain one finds the point
        that has to open. So does one where careful ones gained little though no status changed:
        light bodies below heavy ones yield by as much as these are heavier."""
        same, self._statuses = np.array_equal(statuses, self._statuses), statuses
        self._crept = self._crept + 1 if same and 2 * error > self._last else 0
        if not self.first:
            least, most = YIELDING
            gained = self.compliance > least or 2 * error <= self._last
            self._stuck = 0 if gained else self._stuck + 1
            more = MORE if error > self._last else 1 / LESS
            self._caution = max(CAUTION, more * self._caution)
            careful = min(max(self._caution * error, least), most)
            plain = self._stuck > 1 or self._crept > CREEPS
            self.compliance = COMPLIANCE if plain else careful
        self.first, self._last = False, error

    def step(self, system: Stepping, enough: float, by_pieces: bool) -> tuple[bool, float]:
        """One Newton step. A first one that makes the error worse is taken back, and another made
        if the error was more than ``enough``; if ``by_pieces`` a later one ends where the first
        point changes its status.

        Returns:
            Whether there is one, False where the tangent is singular, and the share of it that was
            gone.
        """
        first, before = self.first, system.worst
        start = system.state() if first or by_pieces else []
        self.next(before, system.now())
        done = system.yields(self.compliance)
        if not start or (done and system.error() <= before):
            return done, 1.0
        if first:
            system.go_back(start)
            return (True, 0.0) if before <= enough else self.step(system, enough, by_pieces)
        return done, _end_piece(system, start) if done else 1.0


def _end_piece(system: Stepping, start: list[np.ndarray]) -> float:
    """Go back along the last step to where the first point changed its status, by halves; the share
    that is left. Forces that do nothing are to mend what little redundant rows lack, and grow until
    one of their points opens: a step along them leads past many."""
    statuses, end = system.now(), system.state()
    system.go_back(start)
    before = system.now()
    changed, at, low, high = np.count_nonzero(statuses != before), 0.0, 0.0, 1.0
    while changed > 1 and low < (middle := 0.5 * (low + high)) < high:
        if middle < at:
            system.go_back(start, (at - middle) / at)
        else:
            system.go_back(end, (middle - at) / (1 - at))
        at, count = middle, np.count_nonzero(system.now() != before)
        if count:
            high, changed = middle, count
        else:
            low = middle
    system.go_back(end, (high - at) / (1 - at))
    return high
