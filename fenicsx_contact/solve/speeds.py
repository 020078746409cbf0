# SPDX-License-Identifier: LGPL-3.0-or-later
"""Against which speed the residuals of a step are judged."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ..base.constants import ROUND_OFF
from ..base.vectors import largest, longest
from ..contact.applied import applied, applies
from ..contact.contact import Contact
from ..contact.jump import Coupling
from ..contact.trial import candidate_force
from ..solids import DeformableSolid, RigidSolid, Solid, communicator
from ..theory.scheme import Step
from .surface_problem import SLOW


class Speeds:
    """The largest speed at the contacts, and what stands for one where hardly anything moves there.

    Args:
        solids, contacts: of a scene.
        floating: solids that only contact holds, in a scene without inertia.
        tolerance: of Newton's method.

    Attributes:
        bodies: the solids that deform; ``rubs``: whether there are any, and friction.
    """

    def __init__(
        self,
        solids: Sequence[Solid],
        contacts: Sequence[Contact],
        floating: Sequence[DeformableSolid],
        tolerance: float,
    ) -> None:
        self._contacts, self._floating, self._tolerance = contacts, floating, tolerance
        self._comm = communicator(solids)
        self.bodies = [s for s in solids if isinstance(s, DeformableSolid)]
        self.rubs = bool(self.bodies) and any(contact.friction_law for contact in contacts)
        self._start: tuple[Step | None, float, float] = None, 0.0, 0.0
        self._drawing = [contact for contact in contacts if applies(contact)]
        # rigid bodies, by whose loads soft ones yield
        self._pressing = [
            (contact, solid)
            for contact in contacts
            for solid in contact.solids
            if isinstance(solid, RigidSolid) and len({s.shiftable for s in contact.solids}) > 1
        ]
        self._drawn: tuple[Step | None, float] = None, 0.0

    def typical(self, step: Step) -> float:
        """The largest speed at the contacts in the trial state, m/s, or one that inertia knew as
        the step began, or that which their forces or the speeds in the solids resolve; without
        inertia what round-off of places is worth. 0 where nothing moves yet."""
        speed, (brought, pushed) = self._fastest("trial_velocity"), self._brought(step)
        if step.scheme.inertia:
            speed = max(speed, brought)
            if not pushed:  # a first step
                each = (c.push(candidate_force(c), step) for c in self._contacts)
                pushed = max(each, default=0.0)
        loaded = max((solid.load_speed() for solid in self._floating), default=0.0)
        if step.scheme.inertia and not speed:
            for contact, body in self._pressing:
                load = body.mass / step.span * largest(body.free_velocity[: body.dim])
                loaded = max(loaded, contact.push(load, step))
        known = speed or pushed or loaded
        # a contact may all but rest: of what moves elsewhere exponentially little arrives at once
        inside = self.inside(body.trial_velocity for body in self.bodies)
        speed = max(speed, SLOW * pushed, loaded, SLOW * inside if known else inside)
        if step.scheme.inertia:
            return speed
        noise = max((contact.noise for contact in self._contacts), default=0.0)
        return max(speed, noise / (step.span * self._tolerance))

    def inside(self, velocities: Iterable[np.ndarray]) -> float:
        """The largest of velocities of the solids that deform, each of the owned nodes in m/s,
        wherever they are: solves of these solids resolve no speeds below their round-off."""
        own = [longest(v.reshape(-1, body.dim)) for v, body in zip(velocities, self.bodies)]
        return float(np.max(self._comm.allgather(own))) if own else 0.0

    def strained(self, enough: float) -> float:
        """The largest displacement in the solids that deform, each about its mean, m, by which
        friction may let points slip: in the trial state if that, or of a node, is ``enough``, else
        what was so already as the step began, if it was anything."""
        trial = [body.trial_displacement for body in self.bodies]
        if self._comm.size == 1:  # of two nodes one is half of their difference away
            some = (u[: body.dim] - u[-body.dim :] for u, body in zip(trial, self.bodies))
            if (known := 0.5 * max(map(largest, some))) >= enough:
                return known
        if (now := self.inside(self._apart(trial))) >= enough:
            return now
        before = self.inside(self._apart(body.displacement for body in self.bodies))
        noise = max((contact.noise for contact in self._contacts), default=0.0)
        return next((each for each in (min(before, now), now) if each > noise), 0.0)

    def known(self) -> float:
        """The largest speed at the contacts at the start of the step, m/s."""
        return self._fastest("velocity")

    def drawn(self, step: Step) -> float:
        """The largest speed that what laws do by themselves would give to a point, m/s: a load
        that multipliers cancel, of which all else may be the small difference."""
        if step is not self._drawn[0]:
            each = (c.push(applied(c.equations), step) for c in self._drawing)
            self._drawn = step, max(each, default=0.0)
        return self._drawn[1]

    def _fastest(self, which: str) -> float:
        return max(
            (self._scale(contact.coupling, which) for contact in self._contacts), default=0.0
        )

    def _scale(self, coupling: Coupling, which: str) -> float:
        """The scale of its speeds, m/s, of which round-off of velocities is less than an error."""
        fastest, absolute = coupling.fastest(which), coupling.velocities(which)
        return max(fastest, ROUND_OFF * largest(absolute) / self._tolerance)

    def _brought(self, step: Step) -> tuple[float, float]:
        """The largest speed at the contacts at the start of the step, m/s, which an impact stops,
        or difference of velocities within a solid, which after an impact is yet to arrive there;
        and the one that the forces of the last step stand for."""
        if step is not self._start[0]:
            apart = self.inside(self._apart(body.velocity for body in self.bodies))
            brought = max(self._fastest("velocity"), 2 * apart)
            pushed = max((c.pushed(step) for c in self._contacts), default=0.0)
            self._start = step, brought, pushed
        return self._start[1:]

    def _apart(self, fields: Iterable[np.ndarray]) -> list[np.ndarray]:
        """Fields of the solids that deform, each of the owned nodes, less their means."""
        each = [field.reshape(-1, body.dim) for field, body in zip(fields, self.bodies)]
        sums = self._comm.allgather([(len(field), field.sum(axis=0)) for field in each])
        means = [sum(s for _, s in own) / sum(n for n, _ in own) for own in zip(*sums)]
        return [field - mean for field, mean in zip(each, means)]
