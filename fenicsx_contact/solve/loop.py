# SPDX-License-Identifier: LGPL-3.0-or-later
"""Newton's method for a step: solids, geometry and contact, in one loop.

Each round linearises solids and geometry and then corrects the contact: once, which is Newton's
method for everything ("newton"), or until it has settled on the frozen geometry: the paper's
"fixed point", which Newton's method ends as soon as it gains little where they are "mixed". Where
supports alone do not hold every solid the first round of a step settles too: where nothing touches
one correction knows nothing of what will. So do rounds after corrections that gain no more.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..base.checks import StepFailed
from ..base.overflow import diverging
from ..solids import DeformableSolid
from ..theory.scheme import Step
from .before import Before
from .condensed import Condensed
from .krylov import Krylov
from .monolithic import Monolithic
from .multipliers import ROUGH
from .newton import Newton
from .problem import Assembly, Clock
from .sparse import Sparse
from .speeds import Speeds
from .statics import free_motion, stands
from .sweeps import Solved, Sweeps
from .turns import Turns

#: The linear systems, by name.
SYSTEMS: dict[str, type[Condensed] | type[Monolithic]]
SYSTEMS = {"condensed": Condensed, "monolithic": Sparse, "iterative": Krylov}
#: Relative error of the linearised operator, gaps and momentum at which the fixed point ends.
GEOMETRY_TOLERANCE = 1e-8
#: How often a correction is halved that inverts an element, or makes the error so many times worse.
HALVINGS, WORSE = 5, 10.0

Together = Callable[[Callable[[], Solved]], Solved]


class StepSolver(Sweeps):
    """Solves steps whose solids and contacts are predicted.

    Args:
        problem: solids and contacts.
        newton: settings.
        geometry: "newton", "fixed point" or "mixed".
        solver: the linear systems, a key of SYSTEMS.
        loose: solids that only contact holds, or their springs, in a scene without inertia.

    Attributes:
        errors: the relative error before each round of the last step, and at its end.
        reached: the largest error at its end: of any row, and of what was linearised.
        speed: the typical one there, m/s; 0 where nothing moved. ``left``: what errors are known to
            leave of velocities, m/s; 0 if only that they are small beside that speed.
        system: the linear systems.
        patient: what its solids are while it solves their steps.
    """

    def __init__(
        self,
        problem: Assembly,
        newton: Newton,
        geometry: str,
        solver: str,
        loose: list[DeformableSolid],
    ) -> None:
        self._all, self._newton, self._loose = problem, newton, bool(loose)
        self._settles = problem.settles(geometry != "newton")
        self._floating = floating = [solid for solid in loose if not stands(solid)]
        self._speeds = Speeds(problem.solids, problem.contacts, floating, newton.tolerance)
        self.errors: list[float] = []
        self.reached = self.speed = self.left = self._pushed = 0.0
        self.system = SYSTEMS[solver](problem)
        # whether velocities without contact are known, which deformable solids have to solve for
        self._foresees = isinstance(self.system, Condensed) or not self._speeds.bodies
        self._mixed = geometry == "mixed"
        meets = [c.coupling for c in problem.contacts if not c.coupling.fixed_normal]
        fine = self._mixed and meets and not any(each.encloses for each in meets)
        self._within = newton.tolerance if fine else GEOMETRY_TOLERANCE
        if loose:
            self.system.hold(floating, loose)
        self.patient = self._settles or self.system.patient

    def solve(self, step: Step, clock: Clock, together: Together) -> Solved:
        """Solve a step, or raise a ``StepFailed`` with the reason; what one of several processes
        meets all shall know ``together``."""
        if not self._mixed:
            return self._by(self._settles, step, clock)
        start = Before(self._all)
        try:
            return together(lambda: self._by(True, step, clock))
        except StepFailed as failure:  # sweeps that find no state gain least of all
            start.restore(step)
            try:
                return together(lambda: self._by(False, step, clock))
            except StepFailed:
                raise failure from None

    def _by(self, sweeps: bool, step: Step, clock: Clock) -> Solved:
        self.errors, self.left = [], 0.0
        self._contradicted = float(self._settles and self._all.jams)  # of speeds
        self.system.restart()
        if not (sweeps and self._foresees):  # by which they are screened
            for contact in self._all.contacts:
                contact.candidates.choose()
        with diverging():
            return (self._fixed_point if sweeps else self._full)(step, clock)

    def _full(self, step: Step, clock: Clock) -> Solved:
        settled, halved, last, turns = 0, 0, np.inf, Turns(self._loose)
        plain, kept, sound = False, False, True  # a correction; its tangent is old; state asked
        before = firm = Before(self._all)
        left, back = np.inf, False  # by what had settled last, firm; whether it is again there
        errors, remarks, most = self.errors, list[str](), self._newton.max_iterations
        for iteration in range(2 * most + 1):  # and again from contact that has settled
            for solid in self._all.solids:
                solid.linearise(step)
            clock("solids")
            near = self.system.near
            self._see(step, exact=near == np.inf, kept=plain)
            scale = self._scale(step, self._speeds.typical(step))
            clock("pairing")
            error, force = self.system.begin(step)
            errors.append(error)
            clock("newton")
            rises = iteration > 1 and error >= errors[-2]
            stalled = (rises and not kept) or (iteration > 2 and 2 * error > errors[-3])
            stalled &= error <= ROUGH * self._newton.tolerance
            if iteration and (error <= self._newton.tolerance or stalled):
                self.reached = error
                if not sound:
                    self._all.refuse_broken()
                if self.system.settle(step, force, self._newton.tolerance):
                    self._follow()
                    if self._scale(step, self._speeds.typical(step)) != scale:
                        plain = kept = False  # what was judged was another state
                        continue
                return force, iteration + settled, 1, remarks
            if not np.isfinite(error) or iteration == 2 * most:
                self._all.refuse_broken()
                break
            if error > WORSE * max(last, 1.0) and halved < HALVINGS:
                halved += 1
                before.halve(step)
                plain = kept = False
                continue
            # a tangent is kept if one more correction as good as the last one is enough
            kept = plain and error**2 <= last * self._newton.tolerance
            if plain and not kept and isinstance(self.system, Condensed):
                self._see(step, exact=True)
                self.system.renew(step)
            last, halved = error, 0
            if error <= near < np.inf:
                self._see(step, exact=True)
                clock("pairing")
            before = Before(self._all)
            if not sound:
                firm, left = before, error
            settles = back or turns.settles(error, spent=iteration == most)
            if settles and not back and self._loose and np.inf > 2 * error > left:
                firm.restore(step)  # corrections led astray what nothing but contact holds
                plain, kept, back = False, False, True
                continue
            back = False
            if settles:
                self._see(step, exact=False)
                solution = self._settle(step, first=iteration == 0)
                self.system.carry(step, solution.force)
                settled += solution.iterations
                remarks += solution.remarks
                self._follow()
                plain = kept = sound = False
                continue
            self._advance(step, clock, before, careful=rises)
            plain, sound = isinstance(self.system, Condensed), True
        told = f"{self.system.stall()} after {len(errors) - 1} Newton iterations"
        raise StepFailed(told + free_motion(self._floating, step))

    def _see(self, step: Step, exact: bool, kept: bool = False) -> None:
        """Take up the geometry; ``exact`` with its derivatives: ``kept``, those of last time."""
        single = exact or not isinstance(self.system, Condensed)  # it leaves them out where frozen
        for contact in self._all.contacts:
            contact.linearise(step, single if len(contact.solids) == 1 else exact, kept)

    def _advance(self, step: Step, clock: Clock, before: Before, careful: bool) -> None:
        """One correction, shortened where it would invert an element."""
        if not self.system.iterate(step):
            raise StepFailed("the linearised problem is singular: is a body without support?")
        clock("linear solve")
        for _ in range(HALVINGS):
            if not any(solid.broken() for solid in self._all.solids):
                break
            before.halve(step)
        else:
            self._all.refuse_broken()
        self._follow(careful)
        clock("pairing")

    def _follow(self, careful: bool = False) -> None:
        for contact in self._all.contacts:
            contact.follow()
            contact.equations.turn(careful and not self._all.hyperstatic)
