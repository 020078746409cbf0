# SPDX-License-Identifier: LGPL-3.0-or-later
"""The derivative of what puts rigid solids back, where bearing points keep their gaps
(:mod:`fenicsx_contact.steps.hold`)::

    s = -m G' y,      (G m G') y = off

m: the inverse of the mass, G: derivatives of the gaps of the bearing points by the places; both
turn with the solids, G with the normals of an obstacle and with what two solids see of each other,
too.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
from scipy.linalg import block_diag

from ..base.vectors import components, dot, slices
from ..theory.scheme import Step
from .kinematics import Arms
from .pair_hold import PairBearing
from .pairs import PairRows
from .parameters import Parameter
from .points import RigidPoints
from .rigid import RigidMotion
from .surface import ContactRows


class Shift(NamedTuple):
    """The shifts of all rigid solids, one after another, (n,).

    Attributes:
        way: the shifts.
        q, v, q_old, v_old: derivatives by the places before, the velocities, and both at the start
            of the step, (n, n).
        dt, by: by the length of the step, (n,), and by parameters, (n, p).
    """

    way: np.ndarray
    q: np.ndarray
    v: np.ndarray
    q_old: np.ndarray
    v_old: np.ndarray
    dt: np.ndarray
    by: np.ndarray


class Bearing(Protocol):
    """The bearing points of a contact, (k,), in the unknowns of its solids, (n,).

    Attributes:
        G: derivatives of the gaps, (k, n).
        off: how far they are from where they belong, (k,).
        q, v, q_old, v_old, dt, by: derivatives of that, (k, ...).
        moved: by each parameter the change of the normals, (k, d), or None.
    """

    G: np.ndarray
    off: np.ndarray
    q: np.ndarray
    v: np.ndarray
    q_old: np.ndarray
    v_old: np.ndarray
    dt: np.ndarray
    by: np.ndarray
    moved: list[np.ndarray | None]

    def bent(self, turned: np.ndarray) -> np.ndarray:
        """Change of G where the normals turn."""

    def turned_forces(self, y: np.ndarray) -> np.ndarray:
        """Derivative of G' y by q, (n, n)."""

    def turned_rows(self, u: np.ndarray) -> np.ndarray:
        """Derivative of G u by q, (k, n)."""


def held(rows: ContactRows) -> bool:
    """Whether bearing points of a contact keep their gaps."""
    rigid = all(isinstance(m, RigidMotion) for m in rows.motions)
    return rigid and rows.contact.formulation.percussive


def shift(
    motions: Sequence[RigidMotion],
    contacts: Sequence[ContactRows],
    step: Step,
    parameters: Sequence[Parameter],
) -> Shift | None:
    """Those of rigid solids, None if nothing is put back."""
    ends = np.cumsum([0, *(m.size for m in motions)])
    places = {id(m): np.arange(*at) for m, at in zip(motions, zip(ends[:-1], ends[1:]))}
    bearing: list[Bearing] = []
    columns = []
    for rows in contacts:
        if not step.dt or not held(rows):
            continue
        points = np.flatnonzero(rows.contact.equations.statuses() > 0)
        if len(points):
            pair = isinstance(rows, PairRows)
            kind = PairBearing if pair else ObstacleBearing
            bearing.append(kind(rows, points, step, parameters))  # type: ignore[arg-type]
            columns.append(np.concatenate([places[id(m)] for m in rows.motions]))
    if not bearing:
        return None
    bounds = slices(len(b.off) for b in bearing)

    def together(name: str) -> np.ndarray:
        result = np.zeros((bounds[-1].stop, ends[-1]))
        for b, at, own in zip(bearing, bounds, columns):
            result[at, own] = getattr(b, name)
        return result

    m = block_diag(*(each.mobility(each.turn[1]) for each in motions))
    G, off = together("G"), np.concatenate([b.off for b in bearing])
    inverse = np.linalg.pinv(G @ m @ G.T, rcond=1e-10, hermitian=True)
    y = inverse @ off
    forces = G.T @ y
    u = m @ forces
    parts = [(each, places[id(each)]) for each in motions]
    moved = block_diag(*(each.turned(m[np.ix_(at, at)], forces[at]) for each, at in parts))
    turned = np.zeros_like(G)
    for b, at, own in zip(bearing, bounds, columns):  # and m turns
        moved[:, own] += m[:, own] @ b.turned_forces(y[at])
        turned[at, own] = b.turned_rows(u[own])
    back = m @ G.T @ inverse
    derivatives = {name: -back @ together(name) for name in ("q", "v", "q_old", "v_old")}
    derivatives["q"] += back @ (turned + G @ moved) - moved
    for name in ("dt", "by"):
        derivatives[name] = -back @ np.concatenate([getattr(b, name) for b in bearing])
    for i, parameter in enumerate(parameters):  # m changes with the masses
        heavier = [each.heavier(parameter, each.turn[1], u[at]) for each, at in parts]
        less = m @ np.concatenate(heavier)
        derivatives["by"][:, i] += less - back @ (G @ less)
    for b, at, own in zip(bearing, bounds, columns):
        for i, by in enumerate(b.moved):
            if by is not None:
                change = b.bent(by)
                f = m[:, own] @ (change.T @ y[at])
                derivatives["by"][:, i] += back[:, at] @ (change @ u[own]) + back @ (G @ f) - f
    return Shift(-u, **derivatives)


class ObstacleBearing:
    """Bearing points of a contact with an obstacle; see :class:`Bearing`."""

    def __init__(
        self,
        rows: ContactRows,
        points: np.ndarray,
        step: Step,
        parameters: Sequence[Parameter],
    ) -> None:
        contact, size = rows.contact, rows.motion.size
        assert isinstance(rows.at, RigidPoints)
        d = contact.surface.dim
        at = components(points, d)
        new, old = rows.new, rows.old
        assert new.bend is not None and old.bend is not None
        J, H, J_old, H_old = (
            each[at].reshape(len(points), d, size)
            for each in (new.place, new.bend, old.place, old.bend)
        )
        n, slope, w = rows.normal[points], rows.slope[points], rows.jump[points]
        w_old, C = rows.start_jump[points], rows.bend[points]
        rest, rate = step.dt - step.gap_rate, step.gap_rate
        starts = rows.reads_start[points]
        n_old, C_old = rows.old_normal[points], rows.old_bend[points]
        start = contact.start_jump_n[points]
        self.G = np.einsum("pi,pij->pj", n, J)
        self._J, self._C, self._n = J, C, n
        self._arms = Arms(rows.at.arms[1].arms[points])
        turned = C @ J
        wall = contact.coupling.wall  # type: ignore[attr-defined]
        place = rows.places[points]
        gap = -wall.distance(place, rows.step.end)
        begun = contact.coupling.begun_gaps(contact.gap, step)[points]
        self.off = gap - begun - rate * dot(w, n) - rest * start
        self.q = np.einsum("pi,pij->pj", slope, J) - rate * (
            np.einsum("pi,pij->pj", n, H) + np.einsum("pi,pij->pj", w, turned)
        )
        late = starts * ~rows.turns[points]
        self.q -= rest * np.einsum("p,pi,pij->pj", late, w_old, turned)
        self.v = -rate * self.G
        away = np.einsum("pi,pij->pj", rows.old_slope[points], J_old)
        came = np.einsum("pi,pij->pj", n_old, H_old)
        came += np.einsum("pi,pij->pj", w_old, C_old @ J_old)
        if ride := rows.riding:
            drift = np.einsum("pi,pij->pj", n, ride.end[points])
            arriving = rest * starts[:, None] * ride.arriving[points] + ride.gap[points]
            self.q += np.einsum("pi,pij->pj", rate * drift - arriving, J)
            came += np.einsum("pi,pij->pj", ride.arriving_old[points], J_old)
        self.q_old = -away - rest * starts[:, None] * came
        self.v_old = -rest * starts[:, None] * np.einsum("pi,pij->pj", n_old, J_old)
        theta = step.scheme.position_rate
        self.dt = -(theta * dot(w, n) + (1 - theta) * start)
        self.by = np.zeros((len(points), len(parameters)))
        self.moved: list[np.ndarray | None] = []
        for i, parameter in enumerate(parameters):
            change = parameter.wall(contact, rows.places, step.end)
            self.moved.append(None if change is None else -change[1][points])
            if change is not None:
                closer, turned = (-each[points] for each in change)  # gaps and normals of the slave
                before = parameter.wall(contact, rows.old_places, step.start)
                assert before is not None
                closer_before, turned_before = (-each[points] for each in before)
                turned_before = np.where(rows.turns[points][:, None], turned_before, turned)
                self.by[:, i] = closer - closer_before - rate * dot(w, turned)
                self.by[:, i] -= rest * starts * dot(w_old, turned_before)
                if rows.riding:
                    faster, _, coming = rows.drive(parameter, change[1], before[1])
                    self.by[:, i] += rate * dot(faster[points], n) - rest * starts * coming[points]

    def bent(self, turned: np.ndarray) -> np.ndarray:
        """Change of G where the normals turn."""
        return np.einsum("pi,pij->pj", turned, self._J)

    def turned_forces(self, y: np.ndarray) -> np.ndarray:
        """Derivative of G' y by q, (size, size)."""
        result = np.einsum("p,pia,pij,pjb->ab", y, self._J, self._C, self._J)
        return np.asarray(result + self._arms.turned(y[:, None] * self._n))

    def turned_rows(self, u: np.ndarray) -> np.ndarray:
        """Derivative of G u by q, (points, size)."""
        d = self._n.shape[1]
        result = np.einsum("pia,a,pij,pjb->pb", self._J, u, self._C, self._J)
        result[:, d:] += np.einsum("pi,pikl,k->pl", self._n, self._arms.second, u[d:])
        return np.asarray(result)
