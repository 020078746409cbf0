# SPDX-License-Identifier: LGPL-3.0-or-later
"""Newton's method for everything at once: the paper's own wish, no geometric loop.

Each iteration renews the solids' tangents, the pairing with its derivatives and the contact
statuses, and solves one linear system, condensed on the surfaces or monolithic.
"""

from __future__ import annotations

import numpy as np

from ..base.checks import StepFailed
from ..contact.jump import MortarJump
from ..solids import DeformableSolid
from ..theory.theta import Step
from .condensed import Condensed
from .krylov import Iterative
from .monolithic import Monolithic
from .newton import Newton
from .problem import Assembly, Clock, scale_of
from .sparse import Direct
from .surface_problem import SLOW

#: The linear systems, by name.
SYSTEMS: dict[str, type[Condensed] | type[Monolithic]] = {
    "condensed": Condensed,
    "monolithic": Direct,
    "iterative": Iterative,
}
#: It ends as well where it falls no more and is below this: round-off.
ROUGH = 1e-7
#: How often a correction that inverts an element is halved.
HALVINGS = 5
#: A correction is halved that makes the error so many times what it was, or this share of the
#: terms: it went beyond what the linearisation knows.
WORSE, COARSE = 10.0, 1.0


class FullNewton:
    """Solves a step by Newton's method for solids, contact and geometry together.

    Attributes:
        errors: the relative error before each iteration of the last step, and at its end.
    """

    def __init__(self, assembly: Assembly, newton: Newton, solver: str) -> None:
        self._all, self._newton = assembly, newton
        self.errors: list[float] = []
        self.system: Condensed | Monolithic = SYSTEMS[solver](assembly)
        for solid in assembly.solids:
            solid.patient = self.system.patient

    def solve(self, step: Step, clock: Clock) -> tuple[np.ndarray, int, int, list[str]]:
        """See :meth:`~fenicsx_contact.solve.fixed_point.FixedPoint.solve`."""
        speed, best, halved = 0.0, np.inf, 0
        errors: list[float] = []
        self.errors = errors
        for iteration in range(self._newton.max_iterations + 1):
            for solid in self._all.solids:
                solid.linearise(step)
            clock("solids")
            near = self.system.near
            self._see(step, exact=near == np.inf)
            speed = speed or self._speed(step)
            self._all.set_scale(step, scale_of(speed))
            clock("pairing")
            error, force = self.system.begin(step)
            errors.append(error)
            clock("newton")
            stalled = iteration > 1 and errors[-2] <= error <= ROUGH
            if iteration and (error <= self._newton.tolerance or stalled):
                return force, iteration, 1, []
            if not np.isfinite(error):
                break
            if error > WORSE * max(best, COARSE) and halved < HALVINGS:
                halved += 1
                self._halve(step)
                continue
            best, halved = error, 0
            if error <= near < np.inf:
                self._see(step, exact=True)
                clock("pairing")
            self._advance(step, clock)
        raise StepFailed(f"{self.system.stall()} after {len(errors) - 1} Newton iterations")

    def _see(self, step: Step, exact: bool) -> None:
        """Take up the geometry of the contacts; ``exact`` with its derivatives, which between
        solids take longest."""
        for contact in self._all.contacts:
            paired = isinstance(contact.coupling, MortarJump)
            contact.linearise(step, exact=exact or not paired)

    def _speed(self, step: Step) -> float:
        """The largest speed at the contacts, m/s, or that which their forces resolve, or else, at
        the start of a drive, anywhere in the solids; 0 where nothing moves yet."""
        solids = [contact.coupling.velocities("trial_velocity") for contact in self._all.contacts]
        speed = max((float(np.abs(v).max(initial=0.0)) for v in solids), default=0.0)
        pushed = max((c.push(c.force, step) for c in self._all.contacts), default=0.0)
        if speed or pushed:
            return max(speed, SLOW * pushed)
        bodies = [solid for solid in self._all.solids if isinstance(solid, DeformableSolid)]
        inside = [float(np.abs(solid.trial_velocity).max(initial=0.0)) for solid in bodies]
        comm = self._all.solids[0].mesh.mesh.comm
        return max((max(each) for each in comm.allgather([0.0, *inside])), default=0.0)

    def _advance(self, step: Step, clock: Clock) -> None:
        """One correction, shortened where it would invert an element."""
        self._before = [
            [solid.trial_velocity.copy() for solid in self._all.solids],
            [contact.equations.values for contact in self._all.contacts],
        ]
        if not self.system.iterate(step):
            raise StepFailed("the linearised problem is singular: is a body without support?")
        clock("linear solve")
        for _ in range(HALVINGS):
            if not any(solid.broken() for solid in self._all.solids):
                break
            self._halve(step)
        else:
            self._all.refuse_broken()
        for contact in self._all.contacts:
            contact.follow()
        clock("pairing")

    def _halve(self, step: Step) -> None:
        """Go back half of the last correction."""
        velocities, unknowns = self._before
        for solid, old in zip(self._all.solids, velocities):
            solid.go(0.5 * (old + solid.trial_velocity), step)
        for contact, values in zip(self._all.contacts, unknowns):
            contact.equations.values = 0.5 * (values + contact.equations.values)
            contact.follow()
