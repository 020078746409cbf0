# SPDX-License-Identifier: LGPL-3.0-or-later
"""The semi-smooth Newton loop on the surface problem, and what it falls back on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from ..base import checks
from ..base.constants import ROUND_OFF
from .multipliers import ROUGH, STALLS, Softened, method_of_multipliers

#: Cost: damped steps of many bodies before one that solves is searched for by pivots.
TRIED = 8


class ContactProblem(Softened, Protocol):
    """A contact problem on frozen geometry: condensed on the surfaces, or with all solids.

    Attributes:
        size: number of its unknowns; 0: nothing may touch.
        hyperstatic: whether there may be more forces than the motion determines.
        crowded: whether many rigid bodies meet each other.
        rounding: up to which an error that falls no more is round-off: of solids that deform, or of
            a geometry that is yet to be renewed, until when rigid points that stick contradict each
            other.
    """

    size: int
    hyperstatic: bool
    crowded: bool
    rounding: float

    def iterate(self, enough: float = 0.0) -> bool: ...
    def state(self) -> list[np.ndarray]: ...
    def go_back(self, state: list[np.ndarray], share: float = 1.0) -> None: ...
    def turn(self, careful: bool) -> bool: ...
    def remember(self) -> np.ndarray: ...
    def flips(self) -> str: ...
    def stall(self) -> str: ...
    def force(self) -> np.ndarray: ...


@dataclass
class Solution:
    """Forces on the solids at the points (flat, N), and how they were found."""

    force: np.ndarray
    iterations: int
    error: float = 0.0  # of any row, at most
    exact: bool = True  # but for what counts as round-off
    remarks: list[str] = field(default_factory=list)
    found: bool = True  # else what was found last


class NotConverged(RuntimeError):
    """The surface problem was not solved; the message says what stalls or flips. ``last``: what was
    found last, if anything."""

    def __init__(self, message: str, last: Solution | None = None) -> None:
        super().__init__(message)
        self.last = last


@dataclass(frozen=True)
class Newton:
    """Settings of the Newton loop.

    Convergence is judged on the scaled residual of every row. When statuses come back that were
    there before (ping-pong), steps are damped; where that fails, the method of multipliers takes
    over.

    Args:
        tolerance: on the largest scaled residual of any row, and where solids, geometry and
            contact are solved together on the momentum balances.
        max_iterations: of full steps, and again of damped ones, or from contact that has settled.
    """

    tolerance: float = 1e-10
    max_iterations: int = 30

    def __post_init__(self) -> None:
        checks.keep(self, "tolerance", above=0, at_most=1e-2)
        checks.whole_number("max_iterations", self.max_iterations, at_least=1)

    def solve(
        self,
        system: ContactProblem,
        hopeless: Callable[[], str] | None = None,
        elsewhere: Callable[[], bool] | None = None,
    ) -> Solution:
        """Solve the surface problem of a step; the surfaces then hold the solution.

        Args:
            system: the surface problem, begun.
            hopeless: why it has no solution, or nothing; asked where Newton's method finds none.
            elsewhere: lets it begin from a place that it finds; whether there is one; likewise.

        Raises:
            NotConverged: with the reason.
        """
        if not system.size:
            return Solution(system.force(), 0)
        start, first = system.state(), system.error()
        # where many bodies stick their points contradict each other by how they lie
        rough = ROUGH * self.tolerance if system.crowded else self.tolerance
        stalled = max(rough, system.rounding)
        iterations, enough = self._iterated(system, stalled, elsewhere is None)
        if system.worst <= max(enough, rough):
            return Solution(system.force(), iterations, system.worst, system.worst <= rough)
        if hopeless and (reason := hopeless()):
            raise NotConverged(reason)
        flips = system.flips()
        if elsewhere and system.crowded:  # of many a search takes longer than some steps
            iterations += self._damped(system, start, rough, TRIED)
            if system.worst <= rough:
                return Solution(system.force(), iterations, system.worst)
        if elsewhere and elsewhere():
            found, there = system.error(), system.state()
            start, enough = start if found > first else there, self.tolerance
            if found > ROUND_OFF:
                more, enough = self._iterated(system, stalled)
                iterations += more
            if enough < system.worst and found <= rough:  # of which steps make nothing better
                system.go_back(there)
                enough = max(system.error(), rough)
            if system.worst <= enough:
                return Solution(system.force(), iterations, system.worst, system.worst <= rough)
        iterations += self._damped(system, start, rough)
        if system.worst <= rough:  # NaN is not
            return Solution(system.force(), iterations, system.worst)
        steps = method_of_multipliers(system, self.tolerance, rough)
        iterations += steps
        told = f"{flips}; method of multipliers took over, {steps} steps"
        if system.worst <= stalled:
            return Solution(system.force(), iterations, system.worst, system.worst <= rough, [told])
        last = Solution(system.force(), iterations, system.worst, False, [told], False)
        raise NotConverged(f"{system.stall()}; {told}", last)

    def _iterated(
        self, system: ContactProblem, rough: float, patient: bool = True
    ) -> tuple[int, float]:
        """The same as :meth:`_iterate`, the error being that of the usual rows."""
        steps, enough = self._iterate(system, rough, patient)
        if system.turn(False):
            system.error()
        return steps, enough

    def _iterate(
        self, system: ContactProblem, rough: float, patient: bool = True
    ) -> tuple[int, float]:
        """Newton steps until converged, or until the statuses cycle, or, if not ``patient``, until
        the error falls no more; how many, and the error to be accepted: where it falls no more and
        is not above ``rough``, that."""
        seen: dict[bytes, float] = {}
        last, error, stalls, returns = b"", system.error(), 0, 0
        for iteration in range(1, self.max_iterations + 1):
            before = error
            if not system.iterate(self.tolerance):
                return iteration, self.tolerance
            error = system.error()
            # what was turned ends with the usual rows, of which all digits are known
            if not np.isfinite(error) or (error <= self.tolerance and not system.turn(False)):
                return iteration, self.tolerance
            if system.turn(iteration > 1 and error >= before):
                error = system.error()
            stalls = stalls + 1 if before <= 2 * error else 0
            if stalls >= STALLS and error <= rough:
                return iteration, rough
            if iteration == 1:  # from a first guess statuses may change
                continue
            key = system.remember().tobytes()
            if 2 * error > seen.get(key, np.inf) and key != last and iteration > 4:
                returns += 1
                if returns == STALLS or not system.crowded:
                    # points that contradict each other may go round for ever by what rounds them
                    return iteration, rough if system.hyperstatic else self.tolerance
            # pieces of which statuses know nothing, leapt over back and forth
            leaps = key == last and not (system.crowded or system.hyperstatic)
            if stalls > STALLS and (leaps or not patient):
                return iteration, self.tolerance
            seen[key] = error
            last = key
        return self.max_iterations, self.tolerance

    def _damped(
        self, system: ContactProblem, start: list[np.ndarray], rough: float, most: int = 0
    ) -> int:
        """Newton steps from there, at most so many, each halved until the error falls; how many.
        The rows are smooth in pieces (stick, slip, open, a slip that turns round): along a step the
        error falls with the way, up to the end of the piece that it begins in. A full step may leap
        over the piece in which the solution is, back and forth between its neighbours; one cut
        short ends in it. From where full steps ended, far from any solution, they would be cut to
        nothing; there the system is again where this leads nowhere."""
        end, steps = system.state(), 0
        system.go_back(start)
        error = system.error()
        while steps < (most or self.max_iterations):
            steps += 1
            before, halvings = system.state(), 0
            if not (np.isfinite(error) and system.iterate(self.tolerance)):
                break
            while not system.error() < error and halvings < np.finfo(float).nmant:
                system.go_back(before, 0.5)
                halvings += 1
            fell, error = system.error() < error, system.error()
            if not fell or (error <= self.tolerance and not halvings):  # a whole step ends on it
                break
        if not error <= rough:
            system.go_back(end)
            system.error()
        return steps
