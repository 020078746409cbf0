# SPDX-License-Identifier: LGPL-3.0-or-later
"""The method of multipliers for the surface problem: what Newton's method falls back on.

Where statuses cycle, many points that close at once on a rigid solid say, the contact is given
springs in series, and friction the bound of the pressure that is known (Tresca). Softened like that
the problem is convex and its solution unique, Newton's method settles in a few steps, the more so
the softer the springs; their centre is then moved to the multipliers found, and the bound with
them, until nothing moves any more: the springs then bear nothing, and what is found solves the
problem as it was. The stiffer they are, the fewer rounds it takes: they are as stiff as lets the
problem settle, softer where it does not, stiffer again where it does at once; where no springs do,
and what is solved is known to be convex, all is tried once more, with patience. Where every problem
settles and bounds turn round and round all the same (much friction at points that jam each other)
the springs become softer, too: pressures, and bounds with them, then move less in a round. Where
all settles and a bound follows the others but slowly (along a belt), Newton's method without
springs ends what it came near. A solid that buckles where contact gives way, or rolls over, goes
the farther the softer the springs are: there the method ends as soon as it gains no more.
(M.J.D. Powell 1969, M.R. Hestenes 1969; R.T. Rockafellar, SIAM J. Control Optim. 14, 877-898,
1976.)
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

#: The springs in units of what the points themselves yield: the stiffest, and the softest, which
#: gives way more than a thousand points together.
STIFFEST, SOFTEST = 1e-3, 1e3
#: Cost: how many times softer or stiffer the next ones are.
CHANGE = 10.0
#: So many Newton steps that do not halve the error are patience enough.
STALLS = 3
#: Cost: and so many where that did not solve it, and what falls in each step is a convex function,
#: which the error, that of its slope, need not do.
PATIENCE = 20
#: So many tolerances are accepted where iterations gain no more.
ROUGH = 1e3


class Softened(Protocol):
    """What the method asks of a contact problem.

    Attributes:
        worst: the largest error of any row, after `error`.
        buckles: whether with springs, however soft, there is nothing least: something gives way.
    """

    worst: float
    buckles: bool

    def iterate(self) -> bool: ...
    def error(self) -> float: ...
    def state(self) -> list[np.ndarray]: ...
    def go_back(self, state: list[np.ndarray], share: float = 1.0) -> None: ...
    def soften(self, compliance: float) -> None: ...
    def begin_again(self) -> bool: ...


def method_of_multipliers(system: Softened, tolerance: float, rough: float) -> int:
    """Solve, from the present unknowns; they then hold the solution, or the last that was found.

    Args:
        system: the surface problem, begun.
        tolerance: on the largest scaled residual of any row.
        rough: what of it is enough where rounds gain no more.

    Returns:
        The number of Newton steps. ``system.worst`` says whether they solved it.
    """
    total, settled = _rounds(system, tolerance, rough, STALLS)
    # what settled each time would do the same again
    if not (system.worst <= rough or settled) and system.begin_again():
        total += _rounds(system, tolerance, rough, PATIENCE)[0]
    return total


def _rounds(system: Softened, tolerance: float, enough: float, patience: int) -> tuple[int, bool]:
    """Of the method, with so much patience where an error does not halve: the steps, and whether
    all problems with springs settled."""
    total, compliance, rough, stiffest, settled = 0, STIFFEST, 0, STIFFEST, True
    outer, gains = Patience(np.inf, stalls=np.finfo(float).nmant), Patience(np.inf)
    # multipliers may have to double, or errors to halve, as often as a number has digits
    for _ in range(4 * np.finfo(float).nmant):
        system.soften(compliance)
        inner, steps = Patience(system.error(), stalls=patience), 0
        while inner.lasts:
            steps += 1
            if not system.iterate():
                break
            inner.see(system.error())
            if inner.best <= tolerance:
                break
        total += steps
        system.soften(0.0)
        off = system.error()  # of what is by far more, no more digits are needed
        done = inner.best <= tolerance or ROUGH * inner.best <= min(off, 1.0)
        settled &= done
        lost = inner.best * np.finfo(float).eps > 1  # nothing holds it: no digit is left
        if off <= tolerance or lost:
            break
        outer.see(system.worst)
        gains.see(system.worst)
        if not gains.lasts:
            if system.worst <= enough or system.buckles:
                break
            if done:
                total += _ended(system, tolerance)
                if system.worst <= tolerance:
                    break
                gains = Patience(system.worst)
        if not outer.lasts and done and stiffest < SOFTEST:
            # bounds that follow pressures at once turn round with them
            stiffest = compliance = max(compliance, CHANGE * stiffest)
            outer = Patience(outer.best, stalls=np.finfo(float).nmant)
        elif done:
            compliance = max(compliance / CHANGE, stiffest) if steps <= STALLS else compliance
        elif compliance < SOFTEST:
            compliance *= CHANGE
        else:  # as soft as can be: near its round-off it may end a little lower next time
            rough += 1
            if inner.best > ROUGH * tolerance or rough > STALLS:
                break
    return total, settled


def _ended(system: Softened, tolerance: float) -> int:
    """Steps of Newton's method from here on, as long as each halves the error; back where they do
    not end in a solution. How many."""
    start, steps, last = system.state(), 0, np.inf
    while system.worst > tolerance and 2 * system.worst <= last:
        steps, last = steps + 1, system.worst
        if not system.iterate():
            break
        system.error()
    if not system.worst <= tolerance:
        system.go_back(start)
        system.error()
    return steps


class Patience:
    """Whether an error still falls.

    Args:
        error: the first one.
        gain: how many times less one must be than all before to be a gain.
        stalls: how many without a gain end it.

    Attributes:
        best: the smallest one so far.
    """

    def __init__(self, error: float, gain: float = 2.0, stalls: int = STALLS) -> None:
        self.best, self._gain, self._stalls, self._most = error, gain, 0, stalls

    def see(self, error: float) -> None:
        """Take up one more."""
        self._stalls = self._stalls + 1 if self._gain * error >= self.best else 0
        self.best = min(self.best, error)

    @property
    def lasts(self) -> bool:
        """Whether there was a gain lately."""
        return self._stalls < self._most
