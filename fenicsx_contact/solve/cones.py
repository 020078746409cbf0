# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where Newton's method begins anew if the statuses of its points go round: with forces that solve
almost the same problem, found in finitely many steps.

Many points on a rigid solid have few velocities among them. On frozen geometry, and with the speed
of slip known, these are the nearest to those without contact that the law allows (in de Saxcé's
variable friction is a cone, and the law a gradient: V. Acary, F. Cadoux, C. Lemaréchal & J. Malick,
Z. Angew. Math. Mech. 91, 155-175, 2011). With a pyramid for the cone, which in the plane is the
same, that is a problem of least distance (C.L. Lawson & R.J. Hanson, Solving least squares
problems, 1974, chapter 23). The speed of slip follows in a few rounds.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import lapack

from ..base.constants import RIGHT, ROUND_OFF, SAME
from ..base.nonnegative import nonnegative, smallest
from ..base.vectors import slices
from ..contact.contact import Contact
from ..contact.part import Part
from ..theory.scheme import Step
from .surface_problem import SurfaceSystem

#: Cost: rounds in which the speed of slip is to settle, and sides of a pyramid in space.
ROUNDS, SIDES = 300, 8
#: Cost: of more velocities the search may take longer than what follows without it. (24 polygons
#: in a box: 0.1 s each time, and two thirds of the run's time in all.)
FEW = 150


class _Points:
    """The points of a contact that may bear: of each so many directions, which are along its normal
    by one and along its tangents by the slope of friction. Forces have those of the mean normals.

    Args:
        contact: with multipliers.
        part: its rows.
        place: of its velocities among all.
        limit: what the law allows, (n,) in m/s.
    """

    def __init__(self, contact: Contact, part: Part, place: np.ndarray, limit: np.ndarray) -> None:
        e, self._part, self.place = part.equations, part, place
        # others face nothing, or may come as near as they like
        bears = (e.weight > 0)[e.candidates] & np.isfinite(limit[e.candidates])
        self._at = e.candidates[bears]
        n, d = shape = len(self._at), contact.normal.shape[1]
        law = contact.friction_law
        self._slope = (getattr(law, "slope", None) or 0.0) if law else 0.0
        self.shares = _ring(d) * self._slope if self._slope else np.zeros((1, 0))
        rows = np.repeat(bears, d)
        J, S = (
            (np.eye(len(place)) if each is None else each)[rows].reshape(*shape, len(place))
            for each in (part.jump_operator(), part.force_operator())
        )
        self._normal, self._ways = self._directions(e.fields.frame())
        along = self._directions(e.fields.frame(e.fields.mean_normal()))[1]
        self.forces = np.einsum("nkd,ndv->nkv", along, S).reshape(n * len(self.shares), len(place))
        self._see = J.reshape(n * d, len(place))
        # jumps are affine in the velocities that are unknown
        jump = e.values[: e.jumps].reshape(-1, d)[self._at].ravel()
        self._given = jump - self._see @ part.active_values()[: len(place)]
        self._limit = limit[self._at]

    def _directions(self, frame: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """The normals, (n, d), and all directions, (n, k, d), in such a frame."""
        normal, tangents = frame[0][self._at], frame[1][: self.shares.shape[1], self._at]
        return normal, normal[:, None, :] + np.einsum("kj,jnd->nkd", self.shares, tangents)

    def beyond(self, velocities: np.ndarray) -> np.ndarray:
        """How much more than the law allows, of what slips by its speed, each direction comes near,
        flat, m/s."""
        jump = (self._see @ velocities[self.place] + self._given).reshape(self._normal.shape)
        near = np.einsum("nd,nd->n", jump, self._normal)
        slip = np.linalg.norm(jump - near[:, None] * self._normal, axis=1)
        allowed = self._limit + self._slope * slip
        return (np.einsum("nd,nkd->nk", jump, self._ways) - allowed[:, None]).ravel()

    def take(self, velocities: np.ndarray, weights: np.ndarray) -> None:
        """Let these be the unknowns: velocities of all, and forces by their directions, flat."""
        part, e, n = self._part, self._part.equations, len(self._part.equations.weight)
        change = np.zeros(len(self.place) + part.multipliers)
        change[: len(self.place)] = velocities[self.place]
        change[: len(self.place)] -= part.active_values()[: len(self.place)]
        part.move(change)
        borne = weights.reshape(len(self._at), len(self.shares)) / e.weight[self._at, None]
        values = e.values
        values[e.jumps :] = 0.0
        values[e.jumps + self._at] = -borne.sum(axis=1)
        for j, shares in enumerate(self.shares.T):
            values[e.tractions + n * j + self._at] = borne @ shares
        e.values = values


def _ring(d: int) -> np.ndarray:
    """Directions along tangents, (k, d - 1), whose hull holds the unit ball."""
    if d == 2:
        return np.array([[1.0], [-1.0]])
    angles = 2 * np.pi / SIDES * np.arange(SIDES)
    return np.stack([np.cos(angles), np.sin(angles)], axis=1) / np.cos(np.pi / SIDES)


def begin_from_cones(system: SurfaceSystem, contacts: Sequence[Contact], step: Step) -> bool:
    """Let the unknowns of a surface problem be velocities and forces that almost solve it; whether
    there are some. None are looked for without multipliers, or where the rows are no numbers."""
    if not np.isfinite(system.residual).all():
        return False
    points = []
    of = {id(contact.part): contact for contact in contacts}
    for part, place in system.placed:
        contact = of[id(part)]
        limit = contact.candidates.limit(step)
        if limit is None or part.equations.tractions == part.equations.jumps:
            return False
        points.append(_Points(contact, part, place[: len(part.active_places)], limit))
    places = slices(len(each.forces) for each in points)
    forces = np.zeros((places[-1].stop, len(system.active)))
    for each, at in zip(points, places):
        forces[at, each.place] = each.forces
    factor, order, rank, _ = lapack.dpstrf(system.W, lower=1)
    root = np.empty((len(factor), rank))
    root[order - 1] = np.tril(factor)[:, :rank]
    seen = forces @ root  # what the directions do to the solids
    now, weights, change = system.free, np.zeros(len(forces)), np.inf
    for _ in range(ROUNDS):
        beyond = np.concatenate([each.beyond(now) for each in points])
        # what forces along mean normals do is not quite what is asked along those at the end
        new = _least(seen, beyond + seen @ (weights @ seen), weights)
        if new is None:
            return False
        now = system.free - system.W @ (new @ forces)
        before, weights = weights, new
        # of forces that do the same one may follow the other for ever
        last, change = change, np.abs((weights - before) @ seen).max(initial=0.0)
        if last <= change <= SAME * np.abs(weights @ seen).max(initial=0.0):  # round-off
            break
    weights = _spread(seen, weights, beyond - seen @ ((weights - before) @ seen))
    for each, at in zip(points, places):
        each.take(now, weights[at])
    system.restart()
    system.update()
    return True


def _least(seen: np.ndarray, beyond: np.ndarray, before: np.ndarray) -> np.ndarray | None:
    """Weights >= 0, (k,), of the shortest x = -weights.seen with -seen x >= beyond, (k,), of which
    each is zero unless its row holds as an equation, sought from those of a problem with the same
    ``seen``; None where there is no x."""
    stiff = _longest(seen)
    size = beyond.max(initial=0.0)
    if not (size > 0 and stiff > 0):
        return np.zeros(len(beyond))
    rows = np.concatenate([-seen.T / stiff, beyond[None] / size])
    target = np.zeros(len(rows))
    target[-1] = 1.0
    # those of the problem before, as shares of these rows: any size does, of the same signs
    found = nonnegative(rows, target, before * stiff**2 / size)
    if found is None or (left := 1.0 - rows[-1] @ found) <= ROUND_OFF:
        return None
    return found / left * size / stiff**2


def _spread(seen: np.ndarray, weights: np.ndarray, left: np.ndarray) -> np.ndarray:
    """Weights >= 0 that do the same, of which few are not zero, on all directions in which nothing
    is ``left``, (k,), as evenly as that goes."""
    does = weights @ seen
    tight = np.flatnonzero(left >= -RIGHT * np.abs(seen @ does).max(initial=0.0))  # of what came
    size = np.abs(does).max(initial=0.0)
    stiff = _longest(seen)
    if not (size > 0 and stiff > 0):
        return weights
    rows, sums = seen[tight].T / stiff, does / size
    even = np.zeros(len(weights))
    even[tight] = smallest(rows, sums, sums)
    if np.abs(rows @ even[tight] - sums).max() > SAME:
        return weights
    return even * size / stiff


def _longest(rows: np.ndarray) -> float:
    return float(np.sqrt(np.einsum("kr,kr->k", rows, rows).max(initial=0.0)))
