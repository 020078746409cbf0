# SPDX-License-Identifier: LGPL-3.0-or-later
"""The paper's geometric fixed point: contact with frozen geometry, which is then renewed.

The same loop is Newton's method for the momentum balance of hyperelastic solids. A scene of linear
solids before a flat obstacle passes it once.
"""

from __future__ import annotations

import numpy as np

from ..base.checks import StepFailed
from ..theory.theta import Step
from .newton import Newton, NotConverged, Solution
from .problem import Assembly, Clock, scale_of
from .surface_problem import SLOW

#: Relative error of the linearised operator, gaps and momentum at which the loop ends.
GEOMETRY_TOLERANCE = 1e-8
MAX_GEOMETRY = 25
#: It ends as well where it falls no more and is below this: the round-off of an ill-conditioned
#: solve, which shorter steps would not better.
ROUGH = 1e-6


class FixedPoint:
    """Solves a step by linearisations with a condensed surface problem each."""

    def __init__(self, assembly: Assembly, newton: Newton) -> None:
        self._all, self._newton = assembly, newton
        for solid in assembly.solids:
            solid.patient = True  # the loop goes on until all is in balance
        self.errors: list[float] = []
        self._system = assembly.surface_system()

    def solve(self, step: Step, clock: Clock) -> tuple[np.ndarray, int, int, list[str]]:
        """Solve a step whose solids and contacts are predicted.

        Returns:
            Forces on all points (flat, N), Newton iterations, linearisations, remarks.

        Raises:
            StepFailed: with the reason.
        """
        iterations, remarks, last = 0, [], np.inf
        self.errors = []
        for sweep in range(1, MAX_GEOMETRY + 1):
            for solid in self._all.solids:
                solid.linearise(step)
            clock("solids")
            speed = self._linearise(step, first=sweep == 1)
            clock("pairing")
            solution = self._solve(step)
            iterations += solution.iterations
            remarks += solution.remarks
            clock("newton")
            self._all.spread(solution.force)
            for solid in self._all.solids:
                solid.correct(step)
            clock("solids")
            error = self._nonlinearity(step, speed, solution.force)
            self.errors.append(error)
            grown = [contact.grow(step) for contact in self._all.contacts]
            clock("pairing")
            if any(grown):
                continue
            if error <= GEOMETRY_TOLERANCE or last <= error <= ROUGH:
                return solution.force, iterations, sweep, remarks
            last = error
        raise StepFailed(
            f"the geometric fixed point stalls at a relative error of {error:.3g} after "
            f"{sweep} linearisations"
        )

    def _linearise(self, step: Step, first: bool) -> float:
        """Velocities without contact and scales; returns a typical speed."""
        for contact in self._all.contacts:
            contact.linearise(step)
        self._free = self._all.free()
        if first:
            for contact, part in zip(self._all.contacts, self._all.parts):
                contact.screen(self._free[part], step)
        pushed = max((c.push(c.force, step) for c in self._all.contacts), default=0.0)
        speed = scale_of(max(self._all.fastest(self._free), SLOW * pushed))
        self._all.set_scale(step, speed)
        if first:
            for contact, part in zip(self._all.contacts, self._all.parts):
                contact.start(self._free[part])
        return speed

    def _solve(self, step: Step) -> Solution:
        try:
            active = self._system.arrange()
            self._system.begin(self._free[active], self._all.compliance(active))
            return self._newton.solve(self._system)
        except NotConverged as failure:
            raise StepFailed(str(failure)) from None

    def _nonlinearity(self, step: Step, speed: float, force: np.ndarray) -> float:
        """Largest relative error of what was linearised, in the trial state."""
        self._all.refuse_broken()
        errors = self._all.imbalances(step, [s for s in self._all.solids if not s.linear])
        for contact, part in zip(self._all.contacts, self._all.parts):
            jump, gap, size = contact.error(step)
            size = max(speed, size, SLOW * contact.push(force[part], step))
            errors += [jump / size, gap / (size * step.span)]
        return max(errors, default=0.0)
