# SPDX-License-Identifier: LGPL-3.0-or-later
"""The points of all contacts that may bear, each in the frame of its normal and its tangents: a
problem of friction in cones, on frozen geometry."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr

from ..base.constants import ROUND_OFF
from ..base.vectors import slices
from ..contact.contact import Contact
from ..contact.part import Part
from ..theory.scheme import Step
from .surface_problem import SurfaceSystem


@dataclass
class ConePoints:
    """Points whose jumps are affine in v velocities, which are ``free - compliance (do forces)``.

    Attributes:
        see: jumps by velocities, (n, d, v), and ``given``, what they are besides, (n, d) in m/s.
        do: what forces on the points do to the velocities, (n, d, v).
        limit: how fast the law lets each approach, (n,) in m/s.
        slope: of the cones, (n,); 0: without friction.
        back: -a of the law (3'), (n, d - 1) in m/s.
        group: to which contact each belongs, (n,) of int; ``bore``: those that did, (n,) of bool.
        area: on which each bears, (n,) in m² (m).
        compliance: (v, v) in m/s/N; ``free``: velocities without contact, (v,) in m/s.
    """

    see: np.ndarray
    do: np.ndarray
    given: np.ndarray
    limit: np.ndarray
    slope: np.ndarray
    back: np.ndarray
    group: np.ndarray
    bore: np.ndarray
    area: np.ndarray
    compliance: np.ndarray
    free: np.ndarray

    def __post_init__(self) -> None:
        #: what of a speed and of a force counts as one, m/s and m/s/N
        self.speed = float(np.abs(self.jumps(self.free)).max(initial=0.0))
        yields = ((self.see[:, 0] @ self.compliance) * self.do[:, 0]).sum(axis=1)
        #: how far each point yields alone along its normal, (n,) in m/s/N
        self.yields = np.where(yields > 0, yields, 1.0)

    def of(self, among: np.ndarray) -> ConePoints:
        """Some of the points, (n,) of bool, alone."""
        some = copy(self)
        for name, value in vars(self).items():
            if name not in ("compliance", "free", "speed"):
                setattr(some, name, value[among])
        some.speed = float(np.abs(some.jumps(some.free)).max(initial=0.0))
        return some

    def foremost(self, forces: np.ndarray, least: float, many: int = 1) -> np.ndarray:
        """Of each contact so many points that approach most above their limits, m/s, if that is
        more than ``least``, (n,) of bool."""
        over = self.jumps(self.velocities(forces))[:, 0] - self.limit
        order = np.lexsort((-over, self.group))
        first = np.searchsorted(self.group[order], self.group[order])
        chosen = np.zeros(len(over), dtype=bool)
        chosen[order] = np.arange(len(over)) - first < many
        return chosen & (over > least)

    def velocities(self, forces: np.ndarray) -> np.ndarray:
        """Of what bears so much along the normals and tangents, (n, d) in N."""
        sums = forces.ravel() @ self.do.reshape(forces.size, -1)
        return np.asarray(self.free - self.compliance @ sums)

    def jumps(self, velocities: np.ndarray) -> np.ndarray:
        return np.asarray(self.see @ velocities + self.given)

    def lasts(self, jumps: np.ndarray) -> np.ndarray:
        """s of (3''), (n,), of slips that go on, and less than 0, -s of (3') of those that turn
        round and slip."""
        return np.clip(-self._shares(jumps[:, 1:]), -1.0, 1.0)

    def _shares(self, along: np.ndarray) -> np.ndarray:
        """How much of the way back such (n, d - 1) go, (n,); 0 where there is none."""
        size = np.einsum("nk,nk->n", self.back, self.back)
        return np.asarray(np.einsum("nk,nk->n", along, self.back) / np.where(size > 0, size, 1.0))

    def slips(self, jumps: np.ndarray) -> np.ndarray:
        """What friction is against, (n, d - 1) in m/s."""
        return np.asarray(jumps[:, 1:] - np.abs(self.lasts(jumps))[:, None] * self.back)

    def error(self, forces: np.ndarray) -> float:
        """The largest error of any row of (2) and (4'), as a share of the speeds."""
        jumps = self.jumps(self.velocities(forces))
        normal, traction = forces[:, 0] * self.yields, forces[:, 1:] * self.yields[:, None]
        pressed = np.maximum(normal + jumps[:, 0] - self.limit, 0.0)
        g = traction + jumps[:, 1:]
        turns, lasts = np.clip(self._shares(g), 0.0, 1.0), np.maximum(self.lasts(jumps), 0.0)
        g = g - (turns + lasts)[:, None] * self.back
        bound, length = self.slope * pressed, np.linalg.norm(g, axis=1)
        held = g * (bound / np.maximum(np.maximum(bound, length), np.finfo(float).tiny))[:, None]
        off = max(np.abs(normal - pressed).max(), np.abs(traction - held).max(initial=0.0))
        return float(off / self.speed) if self.speed else float(off)


class _Points:
    """Those of a contact, and where they stand among all.

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
        self.slope = np.full(n, (getattr(law, "slope", None) or 0.0) if law else 0.0)
        self.limit, self.bore = limit[self._at], contact.status[self._at] > 0
        self.area = contact.areas(e.weight)[self._at]
        rows = np.repeat(bears, d)
        J, S = (
            (np.eye(len(place)) if each is None else each)[rows].reshape(*shape, len(place))
            for each in (part.jump_operator(), part.force_operator())
        )
        jump = e.values[: e.jumps].reshape(-1, d)[self._at]
        frame = self._frame(e.fields.frame())
        self.see = np.einsum("nkd,ndv->nkv", frame, J)
        self.given = np.einsum("nkd,nd->nk", frame, jump - J @ part.active_values()[: len(place)])
        self.back = np.einsum("nkd,nd->nk", frame[:, 1:], e.fields.back[self._at])
        # forces have the directions of the mean normals
        mean = self._frame(e.fields.frame(e.fields.mean_normal()))
        self.do = np.einsum("nkd,ndv->nkv", mean, S)

    def _frame(self, frame: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        """Normals and tangents, (n, d, d); without friction these are none."""
        normal, tangents = frame
        axes = np.zeros((len(self._at), normal.shape[1], normal.shape[1]))
        axes[:, 0] = normal[self._at]
        axes[:, 1 : 1 + len(tangents)] = tangents[:, self._at].transpose(1, 0, 2)
        return axes

    def reduced(
        self, does: np.ndarray, back: np.ndarray, free: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """By other velocities: jumps (n, d, r), what forces do to them, and jumps without contact,
        (n, d) in m/s."""
        jumps = self.see @ free[self.place] + self.given
        return self.see @ does[self.place], self.do @ back.T[self.place], jumps

    def on(self, forces: np.ndarray) -> np.ndarray:
        """Forces (n, d) as those on its velocities, N."""
        return np.asarray(np.einsum("nd,ndv->v", forces, self.do))

    def take(self, velocities: np.ndarray, forces: np.ndarray) -> None:
        """Let these be the unknowns: velocities of all, and its forces, (n, d) in N."""
        part, e, n = self._part, self._part.equations, len(self._part.equations.weight)
        change = np.zeros(len(self.place) + part.multipliers)
        change[: len(self.place)] = velocities[self.place]
        change[: len(self.place)] -= part.active_values()[: len(self.place)]
        part.move(change)
        borne, values = forces / e.weight[self._at, None], e.values
        values[e.jumps :] = 0.0
        values[e.jumps + self._at] = -borne[:, 0]
        for j in range((len(values) - e.tractions) // n):
            values[e.tractions + n * j + self._at] = borne[:, 1 + j]
        e.values = values


class Places:
    """The points of all contacts of a surface problem that is begun.

    Attributes:
        points: by as many velocities as are independent, those without contact at rest; None where
            there are contacts without multipliers, or none may bear.
    """

    def __init__(self, system: SurfaceSystem, contacts: Sequence[Contact], step: Step) -> None:
        self._each: list[_Points] = []
        self._system, self.points = system, None
        of = {id(contact.part): contact for contact in contacts}
        for part, place in system.placed:
            contact = of[id(part)]
            limit = contact.candidates.limit(step)
            if limit is None or part.equations.tractions == part.equations.jumps:
                return
            own = place[: len(part.active_places)]
            self._each.append(_Points(contact, part, own, limit))
        if not sum(len(p.limit) for p in self._each):
            return
        # W = does by what it has of columns that depend on no others
        does, by, order = qr(system.W, pivoting=True, check_finite=False)
        sizes = np.abs(np.diag(by))
        rank = int((sizes > ROUND_OFF * len(sizes) * sizes.max()).sum())
        does, back = does[:, :rank], np.empty((rank, len(order)))
        back[:, order] = by[:rank]
        see, do, jumps = (
            np.concatenate(each)
            for each in zip(*(p.reduced(does, back, unborne(system)) for p in self._each))
        )
        limit, slope, back, bore, area = (
            np.concatenate([getattr(p, name) for p in self._each])
            for name in ("limit", "slope", "back", "bore", "area")
        )
        group = np.repeat(np.arange(len(self._each)), [len(p.limit) for p in self._each])
        self.points = ConePoints(
            see, do, jumps, limit, slope, back, group, bore, area, np.eye(rank), np.zeros(rank)
        )

    def take(self, forces: np.ndarray) -> None:
        """Let forces (n, d) in N, and the velocities with them, be the unknowns."""
        system, borne = self._system, []
        for each, at in zip(self._each, slices(len(p.limit) for p in self._each)):
            borne.append((each, forces[at]))
        on = np.zeros(len(system.active))
        for each, own in borne:
            on[each.place] += each.on(own)
        velocities = unborne(system) - system.W @ on
        for each, own in borne:
            each.take(velocities, own)


def unborne(system: SurfaceSystem) -> np.ndarray:
    """Velocities of the active points of a surface problem without contact, flat."""
    return np.asarray(system.free - system.W @ np.broadcast_to(system.carried, len(system.free)))
