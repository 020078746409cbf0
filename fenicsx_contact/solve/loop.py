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
from functools import partial
from typing import Any

import numpy as np

from ..base.checks import StepFailed
from ..base.constants import ROUND_OFF
from ..base.overflow import diverging
from ..base.vectors import worst
from ..contact.trial import nonlinearity
from ..solids import DeformableSolid
from ..theory.scheme import Step
from .before import Before
from .condensed import Condensed
from .cones import begin_from_cones, few_in_cones
from .jams import hopeless
from .krylov import Krylov
from .monolithic import Monolithic
from .multipliers import ROUGH
from .newton import Newton, NotConverged, Solution
from .problem import Assembly, Clock, scale_of
from .sparse import Sparse
from .speeds import Speeds
from .statics import free_motion, stands
from .surface_problem import SLOW
from .turns import Turns

#: The linear systems, by name.
SYSTEMS: dict[str, type[Condensed] | type[Monolithic]]
SYSTEMS = {"condensed": Condensed, "monolithic": Sparse, "iterative": Krylov}
#: Relative error of the linearised operator, gaps and momentum at which the fixed point ends.
GEOMETRY_TOLERANCE = 1e-8
#: Cost: sweeps within which a mixed one is to end, by what the last one gained, without Newton.
SWEEPS = 3
#: How often a correction is halved that inverts an element, or makes the error so many times worse.
HALVINGS, WORSE = 5, 10.0

#: Forces on all points (flat, N), Newton iterations, linearisations, remarks.
Solved = tuple[np.ndarray, int, int, list[str]]
Together = Callable[[Callable[[], Solved]], Solved]


class StepSolver:
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
        speed: the typical one there, m/s; 0 where nothing moved.
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
        self.reached = self.speed = self._pushed = 0.0
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
        self.errors = []
        self._contradicted = float(self._settles and self._all.jams)  # of speeds
        self.system.restart()
        if not (sweeps and self._foresees):  # by which they are screened
            for contact in self._all.contacts:
                contact.candidates.choose()
        with diverging():
            return (self._fixed_point if sweeps else self._full)(step, clock)

    def _fixed_point(self, step: Step, clock: Clock) -> Solved:
        iterations, remarks, last = 0, [], 1.0
        deforms = bool(self._speeds.bodies)  # their solves are rounded
        for sweep in range(1, self._newton.max_iterations + 1):
            for solid in self._all.solids:
                solid.linearise(step)
            clock("solids")
            speed = self._linearise(step, first=sweep == 1)
            clock("pairing")
            solution = self._settle(step, sweep == 1, deforms or last > self._within)
            iterations += solution.iterations
            remarks += solution.remarks
            clock("newton")
            self.system.carry(step, solution.force)
            clock("solids")
            error = self._nonlinearity(step, speed, solution.force)
            self.errors.append(error)
            self.reached = worst([solution.error, error])
            grown = [contact.grow(step) for contact in self._all.contacts]
            clock("pairing")
            if any(grown):
                continue
            stalled = solution.found and last <= error <= ROUGH * self._newton.tolerance
            if stalled or (error <= self._within and (deforms or solution.exact)):
                return solution.force, iterations, sweep, remarks
            if self._mixed and error * (error / last) ** SWEEPS > self._within:
                force, more, _, told = self._full(step, clock)
                iterations, remarks = iterations + more, remarks + told
                if not any([contact.grow(step) for contact in self._all.contacts]):
                    return force, iterations, sweep, remarks
            last = error
        raise StepFailed(
            f"the geometric fixed point stalls at a relative error of {error:.3g} after "
            f"{sweep} linearisations"
        )

    def _linearise(self, step: Step, first: bool) -> float:
        """Geometry, candidates and scales; returns a typical speed."""
        self._see(step, exact=False)
        if first:
            self._pushed = max((c.pushed(step) for c in self._all.contacts), default=0.0)
        if not self._foresees:
            return self._scale(step, self._speeds.typical(step))
        free, contacts = self.system.free(), self._all.contacts
        new = [(c, free[part]) for c, part in zip(contacts, self._all.parts)] if first else []
        for contact, velocities in new:
            contact.screen(velocities, step)
        noise = ROUND_OFF / self._newton.tolerance
        speed = max(self._all.fastest(free, noise), SLOW * self._pushed) or self._speeds.known()
        inside = max((body.load_speed() for body in self._speeds.bodies), default=0.0)
        speed = self._scale(step, max(speed, SLOW * inside))
        # without inertia, and without what bore, all that is loaded would go far inside
        rests = not step.scheme.inertia and any((c.status > 0).any() for c in contacts)
        for contact, velocities in new:
            contact.start(np.zeros_like(velocities) if rests else velocities)
        return speed

    def _scale(self, step: Step, speed: float) -> float:
        """Let rows be scaled by about this speed, m/s, or any if there is none; that scale."""
        self.speed = max(speed, self._speeds.drawn(step))  # decides alike in all units of time
        scale = scale_of(self.speed)
        self._all.set_scale(step, scale)
        return scale

    def _settle(self, step: Step, first: bool, rounded: bool = True) -> Solution:
        frozen, known = self.system.freeze(step, first), dict[str, Any]()
        if self._floating or any(contact.coupling.driven for contact in self._all.contacts):
            known["hopeless"] = partial(hopeless, self._floating, self._all.contacts, step)
        frozen.rounded = rounded
        if few_in_cones(frozen, self._all.freedoms):
            known["elsewhere"] = partial(begin_from_cones, frozen, self._all.contacts, step)
        try:
            return self._newton.solve(frozen, **known)
        except NotConverged as failure:
            # rigid points that jam contradict each other by what geometry is off where they end
            if not failure.last or 2 * failure.last.error >= self._contradicted:
                raise StepFailed(str(failure)) from None
            self._contradicted = failure.last.error
            return failure.last

    def _nonlinearity(self, step: Step, speed: float, force: np.ndarray) -> float:
        """Largest relative error of what was linearised, in the trial state."""
        self._all.refuse_broken()
        exact = (solid.linear or getattr(solid, "balanced", False) for solid in self._all.solids)
        asked = [solid for solid, closed in zip(self._all.solids, exact) if not closed]
        errors = self._all.imbalances(step, asked)
        for contact, part in zip(self._all.contacts, self._all.parts):
            jump, gap, size = nonlinearity(contact, step)
            size = max(speed, size, SLOW * contact.push(force[part], step))
            errors += [jump / size, gap / (size * step.span)]
        return worst(errors)

    def _full(self, step: Step, clock: Clock) -> Solved:
        settled, halved, last, turns = 0, 0, np.inf, Turns(self._loose)
        plain, kept, sound = False, False, True  # a correction; its tangent is old; state asked
        before = Before(self._all)
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
            if turns.settles(error, spent=iteration == most):
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
