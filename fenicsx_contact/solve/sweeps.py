# SPDX-License-Identifier: LGPL-3.0-or-later
"""The fixed point of a step: solids and geometry are linearised, contact is solved on them until
both have settled.

A first pass starts from velocities without contact, and errors are relative to these. Where contact
balances large loads, as of what is pressed and light or in steps that are long for what deforms,
nothing moves nearly as fast: what is left is then solved for about the state that was found.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from math import ulp
from typing import Any

import numpy as np

from ..base.checks import StepFailed
from ..base.constants import RIGHT, ROUND_OFF
from ..base.vectors import largest, worst
from ..contact.trial import nonlinearity
from ..solids import DeformableSolid
from ..solids.rotations import by_spins
from ..theory.scheme import Step
from .condensed import Condensed
from .cones import begin_from_cones, few_in_cones
from .jams import hopeless
from .monolithic import Monolithic
from .multipliers import ROUGH
from .newton import Newton, NotConverged, Solution
from .problem import Assembly, Clock, scale_of
from .speeds import Speeds
from .surface_problem import SLOW

#: Cost: sweeps within which a mixed one is to end, by what the last one gained, without Newton.
SWEEPS = 3

#: Forces on all points (flat, N), Newton iterations, linearisations, remarks.
Solved = tuple[np.ndarray, int, int, list[str]]


class Sweeps(ABC):
    """The fixed point of a :class:`~.loop.StepSolver`, whose attributes these are."""

    errors: list[float]
    reached: float
    speed: float
    left: float
    system: Condensed | Monolithic
    _all: Assembly
    _newton: Newton
    _speeds: Speeds
    _floating: list[DeformableSolid]
    _foresees: bool
    _mixed: bool
    _within: float
    _pushed: float
    _contradicted: float

    @abstractmethod
    def _see(self, step: Step, exact: bool, kept: bool = False) -> None: ...

    @abstractmethod
    def _full(self, step: Step, clock: Clock) -> Solved: ...

    def _fixed_point(self, step: Step, clock: Clock) -> Solved:
        iterations, remarks, last = 0, list[str](), 1.0
        deforms = bool(self._speeds.bodies)  # their solves are rounded
        for sweep in range(1, self._newton.max_iterations + 1):
            rounding = ROUGH * self._newton.tolerance if deforms or last > self._within else 0.0
            solution, speed, error = self._sweep(step, clock, sweep == 1, rounding)
            iterations += solution.iterations
            remarks += solution.remarks
            self.errors.append(error)
            self.reached = worst([solution.error, error])
            if self._grown(step, clock):
                continue
            stalled = solution.found and last <= error <= ROUGH * self._newton.tolerance
            if stalled or (error <= self._within and (deforms or solution.exact)):
                force, more = solution.force, 0
                if self._speeds.rubs and self._foresees:
                    force, more = self._refined(step, clock, solution, speed)
                    if more and self._grown(step, clock):
                        continue
                return force, iterations + more, sweep, remarks
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

    def _sweep(
        self,
        step: Step,
        clock: Clock,
        first: bool,
        rounding: float,
        fine: float = 0.0,
        units: Sequence[np.ndarray | None] = (),
    ) -> tuple[Solution, float, float]:
        """What contacts bear on solids and geometry as they are, and the state that has it; a
        typical speed, or the ``fine`` one, and what is left to linearise, relative to that."""
        for solid in self._all.solids:
            solid.linearise(step)
        clock("solids")
        speed = self._linearise(step, first, fine, units)
        clock("pairing")
        solution = self._settle(step, first, rounding, bool(fine))
        clock("newton")
        move = self.system.settle if fine else self.system.carry  # by what forces change, or whole
        move(step, solution.force)
        clock("solids")
        return solution, speed, self._nonlinearity(step, speed, None if fine else solution.force)

    def _grown(self, step: Step, clock: Clock) -> bool:
        """Whether more points may bear than were asked."""
        grown = [contact.grow(step) for contact in self._all.contacts]
        clock("pairing")
        return any(grown)

    def _refined(
        self, step: Step, clock: Clock, solution: Solution, speed: float
    ) -> tuple[np.ndarray, int]:
        """The forces of a state found by errors relative to a speed, or of a better one where these
        would let slip by more than the solids are strained: by errors relative to that, as long as
        they fall; and how many further iterations."""
        off, more = max(self.reached, ROUND_OFF) * speed, 0
        seen = off * step.dt / RIGHT  # in a percussion nothing slips
        if (strained := self._speeds.strained(seen)) >= seen:
            self.left = off
            return solution.force, more
        fine, noise = strained / step.dt, ulp(speed)  # of solves
        rounding = max(ROUGH * self._newton.tolerance, off / fine if fine else 0.0)
        units = self._bent(step) if fine else []
        for _ in range(self._newton.max_iterations if units else 0):
            held = [(contact.equations, contact.equations.values) for contact in self._all.contacts]
            finer, scale, error = self._sweep(step, clock, False, rounding, fine, units)
            more += finer.iterations
            left = worst([finer.error, error]) * scale
            if not left < off:
                for equations, values in held:
                    equations.values = values
                self.system.settle(step, solution.force)
                self._nonlinearity(step, fine, solution.force)
                break
            fell, off, solution = 2 * left < off, left, finer
            if not fell or off <= max(RIGHT * fine, noise):
                break
        if more:  # rows are judged by what errors are worth
            off = max(off, noise)
            self._scale(step, min(speed, max(fine, off / self._newton.tolerance)))
            self.reached = off / self.speed
        self.left = max(off, ROUND_OFF * speed)
        return solution.force, more

    def _bent(self, step: Step) -> list[np.ndarray | None]:
        """The pressures that stop 1 m/s of each point alone, but for what its body moves as a whole
        by these, (2, n) for each contact with an obstacle."""
        assert isinstance(self.system, Condensed)
        surfaces, result, first = self.system.surfaces, list[np.ndarray | None](), 0
        for contact in self._all.contacts:
            e, p = contact.equations, contact.equations.candidates
            d, size = contact.surface.dim, len(contact.part.active_places)
            own = slice(first, first + size)
            first += size
            if contact.part is not e or len(p) <= d:  # so few tell nothing but such motions
                result.append(None)
                continue
            W = surfaces.W[own, own]
            basis = np.linalg.qr(motions(contact.coupling.positions()[p]))[0]
            off = W - basis @ (basis.T @ W)
            off -= (off @ basis) @ basis.T
            blocks = off.reshape(len(p), d, len(p), d)[range(len(p)), :, range(len(p))]
            along = np.einsum("pi,pij,pj->p", contact.normal[p], blocks, contact.normal[p])
            across = (np.trace(blocks, axis1=1, axis2=2) - along) / (d - 1)
            least = max(ulp(largest(W)), largest(W - W.T))  # what round-off tells of it
            if not np.median(along) > least:
                return []
            weight = np.where(e.weight[p] > 0, e.weight[p], 1.0)
            units = contact.units(step).copy()
            stops = 1 / np.maximum([along, across], least) / weight
            units[:, p] = np.maximum(units[:, p], stops)
            result.append(units)
        return result

    def _linearise(
        self,
        step: Step,
        first: bool,
        fine: float = 0.0,
        units: Sequence[np.ndarray | None] = (),
    ) -> float:
        """Geometry, candidates and scales; returns a typical speed, or the ``fine`` one."""
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
        speed = self._scale(step, fine or max(speed, SLOW * inside), units)
        # without inertia, and without what bore, all that is loaded would go far inside
        rests = not step.scheme.inertia and any((c.status > 0).any() for c in contacts)
        for contact, velocities in new:
            contact.start(np.zeros_like(velocities) if rests else velocities)
        return speed

    def _scale(self, step: Step, speed: float, units: Sequence[np.ndarray | None] = ()) -> float:
        """Let rows be scaled by about this speed, m/s, or any if there is none; that scale."""
        self.speed = max(speed, self._speeds.drawn(step))  # decides alike in all units of time
        scale = scale_of(self.speed)
        self._all.set_scale(step, scale, units)
        return scale

    def _settle(
        self, step: Step, first: bool, rounding: float | None = None, known: bool = False
    ) -> Solution:
        """Contact on solids and geometry as they are; ``known``: a state is, and whatever comes
        nearer is as good."""
        frozen, asked = self.system.freeze(step, first), dict[str, Any]()
        driven = any(contact.coupling.driven for contact in self._all.contacts)
        if (self._floating or driven) and not known:
            asked["hopeless"] = partial(hopeless, self._floating, self._all.contacts, step)
        frozen.rounding = ROUGH * self._newton.tolerance if rounding is None else rounding
        if few_in_cones(frozen, self._all.freedoms):
            asked["elsewhere"] = partial(begin_from_cones, frozen, self._all.contacts, step)
        try:
            return self._newton.solve(frozen, **asked)
        except NotConverged as failure:
            # rigid points that jam contradict each other by what geometry is off where they end
            if known and failure.last:
                return failure.last
            # in a percussion nothing moves, and by how they lie they do in that of any shorter step
            lies = not step.dt and frozen.hyperstatic
            if lies and failure.last and failure.last.error <= ROUGH * self._newton.tolerance:
                return replace(failure.last, exact=True, found=True)
            if not failure.last or 2 * failure.last.error >= self._contradicted:
                raise StepFailed(str(failure)) from None
            self._contradicted = failure.last.error
            return failure.last

    def _nonlinearity(self, step: Step, speed: float, force: np.ndarray | None) -> float:
        """Largest relative error of what was linearised, in the trial state: of what forces stand
        for, too, if they are given."""
        self._all.refuse_broken()
        exact = (solid.linear or getattr(solid, "balanced", False) for solid in self._all.solids)
        asked = [solid for solid, closed in zip(self._all.solids, exact) if not closed]
        errors = self._all.imbalances(step, asked)
        for contact, part in zip(self._all.contacts, self._all.parts):
            jump, gap, size = nonlinearity(contact, step)
            if force is not None:
                size = max(speed, size, SLOW * contact.push(force[part], step))
            else:
                size = speed
            errors += [jump / size, gap / (size * step.span)]
        return worst(errors)


def motions(places: np.ndarray) -> np.ndarray:
    """Velocities of places (n, d) in all rigid motions, (n d, motions)."""
    n, d = places.shape
    moves = np.tile(np.eye(d), (n, 1))
    arms = places - places.mean(axis=0)
    return np.hstack([moves, by_spins(arms).reshape(n * d, -1)])
