# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whether contacts can bear what loads a solid that nothing else holds: who may be where a step
without inertia starts, and why it has no solution, in words that its user can act on, and at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.constants import ROUND_OFF
from ..base.nonnegative import nonnegative
from ..base.vectors import across, cross, largest, slices
from ..contact.contact import Contact
from ..solids.motions import FREE, Motions
from ..theory.formulations import only_pushes
from ..theory.scheme import Step
from .least_work import least_work

#: Cost: sides of the pyramid that holds a cone of friction in space, to tell that there is no
#: equilibrium, and to choose where a step starts: what it cannot bear, no cone can; what lies
#: between is found out the long way.
SIDES, FEW = 64, 8


class Balance:
    """The loads on solids that nothing else holds, as they are linearised, and the forces of the
    contacts that may balance them, whatever the deformation.

    A force is in the cone of friction of its point, beside what acts there if it is open; where
    that is not known, in any direction along the surface, or in any at all. In equilibrium the sum
    of all works on no rigid motion that the supports allow; if it must, then what is left at least
    tells a motion that begins (Farkas).

    Args:
        solids: that only contact holds.
        contacts: of the scene.
        step: that is begun.
        sides: of the pyramids that hold cones of friction in space.
        springs: whether these hold the solids, too, or nothing but their present forces counts.
    """

    def __init__(
        self,
        solids: Sequence[Any],
        contacts: Sequence[Contact],
        step: Step,
        sides: int = FEW,
        springs: bool = True,
    ) -> None:
        self._solids, self._contacts, self._step = solids, contacts, step
        self._shares = shares = {id(solid): Motions(solid).free(springs) for solid in solids}
        found = [_loads(solid, shares[id(solid)], step) for solid in solids]
        load, terms = np.concatenate([each for each, _ in found]), max(size for _, size in found)
        self._points = [contact.equations.candidates for contact in contacts]
        self._works = []
        for contact, points in zip(contacts, self._points):
            each = [_rates(contact, solid, shares, step)[points] for solid in solids]
            rates, drawn = np.concatenate(each, axis=2), _drawn(contact, step)[points]
            self._works.append(np.einsum("ndk,njd->njk", rates, _cone(contact, sides)[points]))
            load = load + np.einsum("ndk,nd->k", rates, drawn)
            terms += np.abs(drawn).sum() + np.abs(contact.force).sum()
        size = np.abs(load).max(initial=0.0)
        none = size <= ROUND_OFF * terms or not np.isfinite(size)
        self._size = 0.0 if none else size
        self._load = np.zeros(len(load)) if none else load / size

    def left(self, chosen: Sequence[np.ndarray] | None = None) -> np.ndarray | None:
        """What forces at the points that are chosen, (n,) of bool for each contact, or at all,
        leave of the loads at least, along the free motions, as shares; None: they balance them."""
        left = self._load
        forces = np.concatenate([np.empty((0, len(left))), *self._rows(chosen)]).T
        if left.any() and forces.shape[1]:
            if (found := nonnegative(forces, -left)) is None:  # nobody knows
                return None
            left = left + forces @ found
        return left if np.abs(left).max(initial=0.0) > FREE else None

    def spread(self, chosen: Sequence[np.ndarray]) -> list[np.ndarray] | None:
        """Which of the points that are chosen bear where the solids are rigid, and each direction
        of a cone a spring behind the gap, as stiff as the point alone, (n,) of bool for each
        contact; None: nothing bears the loads, or nothing that is found."""
        if not len(self._load) or self.left(chosen) is not None:  # then there is no least work
            return None
        rows, each = self._rows(chosen), []
        for contact, mine, at, of in zip(self._contacts, chosen, self._points, self._works):
            points, e = at[mine[at]], contact.equations
            limit = contact.candidates.limit(self._step)
            room = -contact.gap / self._step.gap_rate if limit is None else limit
            both = np.stack([room, e.force_scale / e.speed])[:, points]
            each.append(np.repeat(both, of.shape[1], axis=1))
        room, springs = np.concatenate([np.empty((2, 0)), *each], axis=1)
        rows.insert(0, np.empty((0, len(self._load))))
        all_rows, stiffest = np.concatenate(rows), springs.max(initial=0.0)
        # what acts: loads, and what comes in
        unit = max(self._size, float((springs * -room).max(initial=0.0)))
        if not unit:
            return [np.zeros(len(mine), dtype=bool) for mine in chosen]
        if not (0 < stiffest < np.inf and np.isfinite(room).all()):
            return None
        springs, room = springs / stiffest, room * stiffest / unit
        motion = least_work(all_rows, springs, room, self._load * self._size / unit)
        if motion is None:
            return None
        force = springs * np.maximum(all_rows @ motion - room, 0.0)
        pushes, result = force > FREE * force.max(), []
        ends = np.cumsum([len(own) for own in rows])
        for mine, at, of, begin, end in zip(chosen, self._points, self._works, ends, ends[1:]):
            bears, points = np.zeros(len(mine), dtype=bool), at[mine[at]]
            bears[points] = pushes[begin:end].reshape(len(points), of.shape[1]).any(axis=1)
            result.append(bears)
        return result

    def _rows(self, chosen: Sequence[np.ndarray] | None) -> list[np.ndarray]:
        """What the directions of the cones of the points that are chosen, or of all, do along the
        free motions, (directions, free ones) for each contact."""
        works = self._works
        if chosen is not None:
            works = [w[mine[at]] for w, mine, at in zip(works, chosen, self._points)]
        return [w.reshape(w.shape[0] * w.shape[1], w.shape[2]) for w in works]

    def why_not(self) -> str:
        """Why no forces of the contacts balance the loads; nothing if some do."""
        if (left := self.left()) is None:
            return ""
        parts = slices(share.shape[1] for share in self._shares.values())
        ways = [self._shares[id(solid)] @ left[part] for solid, part in zip(self._solids, parts)]
        which = int(np.argmax([np.abs(way).max(initial=0.0) for way in ways]))
        solid = self._solids[which]
        motion = Motions(solid).name(ways[which])
        return f"no equilibrium: contacts cannot hold {solid.name!r} against {motion}"


def unbearable(solids: Sequence[Any], contacts: Sequence[Contact], step: Step) -> str:
    """Why no forces of the contacts balance the loads on these solids; nothing if some do."""
    return Balance(solids, contacts, step, SIDES).why_not()


def _loads(solid: Any, shares: np.ndarray, step: Step) -> tuple[np.ndarray, float]:
    """The loads on a solid along its free motions, N, from the balance as it was linearised; the
    sum of the sizes of what is added up, of internal forces, too."""
    trial, motions = solid.trial_velocity.copy(), Motions(solid)
    solid.go(solid.velocity, step)
    solid.drop_forces()
    rows = motions.at_nodes() @ shares
    left = solid.linear_residual()
    moved = solid.free_load + left
    load = np.array(solid.comm.allreduce(-rows.T @ left))
    terms = np.abs(rows).T @ (np.abs(moved) + np.abs(solid.free_load))
    solid.go(trial, step)
    return load, largest(solid.comm.allreduce(terms))


def _rates(contact: Contact, solid: Any, shares: dict[int, np.ndarray], step: Step) -> np.ndarray:
    """Jumps of a contact by the free motions of a solid, (n, d, free ones)."""
    motions = Motions(solid).at_nodes() @ shares[id(solid)]
    rates = np.zeros((*contact.normal.shape, motions.shape[1]))
    if any(other is solid for other in contact.solids):
        means = {id(other): np.zeros_like(other.velocity) for other in contact.solids}
        rest = contact.coupling.mean_jump(means, step)  # beside an obstacle that moves
        for k, motion in enumerate(motions.T):
            rates[:, :, k] = contact.coupling.mean_jump({**means, id(solid): motion}, step) - rest
    return rates


def _drawn(contact: Contact, step: Step) -> np.ndarray:
    """Forces on the slave at each point if all are open, (n, d) in N."""
    e, limit = contact.equations, contact.candidates.limit(step)
    if limit is None:
        return np.zeros(contact.normal.shape)
    apart = np.zeros(e.size)
    apart[: e.jumps] = ((limit - e.speed)[:, None] * contact.normal).ravel()
    with e.being(apart):
        return np.asarray(-e.residual()[: e.jumps].reshape(contact.normal.shape))


def _cone(contact: Contact, sides: int) -> np.ndarray:
    """Directions of forces on the slave at each point, whose sums with weights >= 0 are at least
    all that it may bear, (n, directions, d); in space so many and the normal."""
    normal, d = contact.normal, contact.solid.dim
    law, pushes = contact.friction_law, only_pushes(contact.formulation)
    push = -normal[:, None, :]
    if d == 2:
        along = push[:, :, ::-1] * np.array([1.0, -1.0])
        ring = np.concatenate([along, -along], axis=1)
    else:
        first = across(normal)
        axes = np.stack([first, cross(normal, first)], axis=1)
        angles = 2 * np.pi / sides * np.arange(sides)
        turns = np.stack([np.cos(angles), np.sin(angles)], axis=1) / np.cos(np.pi / sides)
        ring = np.einsum("ij,njd->nid", turns, axes)
    if not law:
        return push if pushes else np.concatenate([push, -push], axis=1)
    slope = getattr(law, "slope", None)
    if pushes and slope is not None:
        return push + slope * ring
    return np.concatenate([push, ring] if pushes else [push, -push, ring], axis=1)
