# SPDX-License-Identifier: LGPL-3.0-or-later
"""The traces of all contacts of a scene, stacked: what the methods that solve a step share."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property
from math import ceil, inf, log2
from time import perf_counter

import numpy as np

from ..base.checks import StepFailed
from ..base.vectors import largest, longest, slices, spread
from ..contact.contact import Contact
from ..solids import Solid, Trace
from ..solids.trace import DeformableTrace
from ..theory.scheme import Step
from .surface_problem import SurfaceSystem

_Made = tuple[np.ndarray, list[tuple[slice, slice, np.ndarray]], np.ndarray]

#: Forces below this share of those that stop the speeds of a step within it are noise.
NOISE = 1e-11


class Assembly:
    """Solids and contacts, and where the points of each trace stand among all points.

    Attributes:
        solids, contacts: of the scene.
        sides: solid and trace of each side of each contact, in order.
        parts: for each contact, slices: for each side, of the stacked components of the points.
    """

    def __init__(self, solids: Sequence[Solid], contacts: Sequence[Contact]) -> None:
        self.solids, self.contacts = list(solids), list(contacts)
        self.parts = slices(contact.part.places for contact in self.contacts)
        self.sides: list[tuple[Solid, Trace]] = [
            side for c in self.contacts for side in zip(c.solids, c.traces)
        ]
        self._of = {
            id(s): [c for c in self.contacts if any(s is each for each in c.solids)]
            for s in self.solids
        }
        # active points, the blocks of their W, and W
        self._made: _Made = np.empty(0), [], np.empty((0, 0))
        self.slices = slices(trace.jump(s.velocity).size for s, trace in self.sides)

    def partners(self, solid: Solid) -> list[Solid]:
        """The solid and what it may meet."""
        return [solid, *(other for contact in self._of[id(solid)] for other in contact.solids)]

    @cached_property
    def hyperstatic(self) -> bool:
        """Whether there may be forces that the motion does not determine: points of a contact
        without springs are a rigid body's, and more than it and what they meet can tell apart, or
        obstacles meet in a corner and ask more of a node than it has components."""
        firm = [c for c in self.contacts if c.formulation.multipliers]
        rigid = any(c.solids[0].shiftable for c in firm)
        return rigid or any(map(self._cornered, self._of.values()))

    def _cornered(self, contacts: list[Contact]) -> bool:
        """Whether these, of one solid, have more rows at a node than it has components."""
        alone = [c for c in contacts if len(c.solids) == 1 and c.formulation.multipliers]
        seen = [(c, t) for c in alone for t in c.traces if isinstance(t, DeformableTrace)]
        if len(seen) < 2:
            return False
        rows = np.zeros(seen[0][1].seeing().shape[1], dtype=int)
        for contact, trace in seen:
            columns = np.unique(trace.seeing().indices)
            rows[columns] += contact.solid.dim if contact.friction_law else 1
        return bool(rows.max(initial=0) > contacts[0].solid.dim)

    @property
    def crowded(self) -> bool:
        """Whether rigid bodies meet by their corners: those of a face that stick contradict each
        other by how they lie."""
        return any(len(c.solids) > 1 and not c.coupling.by_means for c in self.contacts)

    @cached_property
    def jams(self) -> bool:
        """Whether all are rigid bodies, which may jam: points that stick contradict each other by
        what geometry is off where they end."""
        return all(solid.shiftable for solid in self.solids)

    @cached_property
    def freedoms(self) -> float:
        """How many velocities the solids have, if all are rigid, else more than any."""
        return sum(len(solid.velocity) for solid in self.solids) if self.jams else inf

    def settles(self, so: bool) -> bool:
        """Whether steps settle on frozen geometry, of which contacts are told."""
        for contact in self.contacts:
            contact.settles = so
        return so

    def surface_system(self) -> SurfaceSystem:
        """The surface problem of the contacts."""
        parts, names = [c.part for c in self.contacts], [c.name for c in self.contacts]
        return SurfaceSystem(parts, names, self.hyperstatic, self.crowded)

    def free(self) -> np.ndarray:
        """Velocities of all points at the end of the step without contact, flat."""
        free = [trace.free_jump() for _, trace in self.sides]
        return free[0] if len(free) == 1 else np.concatenate([*free, np.empty(0)])

    def moved(self) -> np.ndarray:
        """Those in the trial state."""
        return np.concatenate([trace.jump(s.trial_velocity) for s, trace in self.sides])

    def fastest(self, velocities: np.ndarray, noise: float) -> float:
        """The largest of these velocities at points that are active, between solids the largest
        difference; at least the share of a velocity that is ``noise``."""
        return max(
            (
                _largest(contact, velocities[part], noise)
                for contact, part in zip(self.contacts, self.parts)
            ),
            default=0.0,
        )

    def compliance(self, active: np.ndarray) -> np.ndarray:
        """W of the active points, whose indices among all are sorted."""
        if not len(active):
            return np.empty((0, 0))
        if len(self.sides) == 1:
            _, trace = self.sides[0]
            return trace.compliance(active, trace, active)
        bounds = np.searchsorted(active, [part.start for part in self.slices] + [np.inf])
        ours = [
            (solid, trace, slice(a, b), active[a:b] - part.start)
            for (solid, trace), part, a, b in zip(self.sides, self.slices, bounds[:-1], bounds[1:])
        ]
        blocks = [
            (rows, columns, trace.compliance(mine, other, theirs))
            for solid, trace, rows, mine in ours
            for other_solid, other, columns, theirs in ours
            if other_solid is solid and len(mine) and len(theirs)
        ]
        of, made, W = self._made
        same = len(made) == len(blocks) and all(a[2] is b[2] for a, b in zip(made, blocks))
        if not (same and np.array_equal(of, active)):
            W = np.zeros((len(active), len(active)))
            for rows, columns, block in blocks:
                W[rows, columns] = block
            self._made = active, blocks, W
        return W

    def spread(self, force: np.ndarray) -> None:
        """Let forces on the points, flat in N, act on the solids in place of those that did."""
        for solid in self.solids:
            solid.drop_forces()
        for (_, trace), part in zip(self.sides, self.slices):
            trace.spread(force[part])

    def set_scale(self, step: Step, speed: float, units: Sequence[np.ndarray | None] = ()) -> None:
        """Scale the equations of all contacts by a typical speed, m/s, and by ``units``, by which
        they are augmented, too, or where there are none by their own."""
        every = [*units] or [None] * len(self.contacts)
        for contact, given in zip(self.contacts, every):
            scale = contact.units(step) if given is None else given
            alone = contact.scales.alone if given is None else given
            contact.equations.set_scale(scale, alone, speed)

    def imbalances(self, step: Step, solids: Iterable[Solid], floor: float = 0.0) -> list[float]:
        """Relative errors of the momentum balances of these solids in the trial state; forces below
        ``floor``, N, are none."""
        return [solid.imbalance(step, max(floor, self.noise(solid))) for solid in solids]

    def noise(self, solid: Solid | None = None) -> float:
        """Forces [N] of contacts of the solid, or of any, that are none: of points that just touch
        they are the round-off of gaps."""
        return NOISE * self.stopping_force(solid)

    def stopping_force(self, solid: Solid | None = None) -> float:
        """The largest force [N] at a point of the solid, or of any, that stops the typical speed
        within the step."""
        contacts = self.contacts if solid is None else self._of[id(solid)]
        return max((c.equations.stopping_force for c in contacts), default=0.0)

    def borne(self, solid: Solid) -> float:
        """The largest component of a force [N] at a point of its contacts in the last step."""
        return max((largest(c.force) for c in self._of[id(solid)] if c.force_of), default=0.0)

    def refuse_broken(self) -> None:
        """Raise StepFailed if a solid has no admissible trial state."""
        for solid in self.solids:
            if reason := solid.broken():
                raise StepFailed(reason)


def _largest(contact: Contact, velocities: np.ndarray, noise: float) -> float:
    places, d = contact.part.active_places, contact.surface.dim
    points = np.unique(places // d)
    active = velocities.reshape(-1, d)[points]
    if len(contact.solids) > 1:
        return max(noise * longest(active), spread(active))
    if contact.coupling.driven:  # what goes with the other side differs from it by round-off
        jump = contact.coupling.to_jump(velocities)[points]
        return max(noise * longest(active), longest(jump))
    return longest(active)


def scale_of(speed: float) -> float:
    """A power of two near the speed: scales change rarely then, and cost no accuracy."""
    return 2.0 ** ceil(log2(speed)) if 0 < speed < inf else 1.0


class Clock:
    """Adds the time since the last call to a phase."""

    def __init__(self, times: dict[str, float]) -> None:
        self._times, self._last = times, perf_counter()

    def __call__(self, phase: str) -> None:
        now = perf_counter()
        self._times[phase] = self._times.get(phase, 0.0) + now - self._last
        self._last = now
