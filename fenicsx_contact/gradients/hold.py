# SPDX-License-Identifier: LGPL-3.0-or-later
"""The derivative of what puts rigid solids back, where bearing points keep their gaps
(:mod:`fenicsx_contact.steps.hold`)::

    s = -m G' y,      (G m G') y = off

m: the inverse of the mass, G: derivatives of the gaps of the bearing points by the place; both turn
with the solid, G with the normals of an obstacle, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..base.vectors import dot
from ..theory.theta import Step
from .kinematics import Arms
from .parameters import Parameter
from .rigid import RigidMotion
from .surface import ContactRows


class Shift(NamedTuple):
    """A shift (size,), and its derivatives by q before it, v, q_old, v_old (size, size), dt (size,)
    and parameters (size, p)."""

    way: np.ndarray
    q: np.ndarray
    v: np.ndarray
    q_old: np.ndarray
    v_old: np.ndarray
    dt: np.ndarray
    by: np.ndarray


def shift(
    motion: RigidMotion,
    contacts: Sequence[ContactRows],
    step: Step,
    parameters: Sequence[Parameter],
) -> Shift | None:
    """That of a solid, None if nothing is put back."""
    bearing = []
    for rows in contacts:
        contact = rows.contact
        if not step.dt or not contact.formulation.percussive:
            continue
        points = np.flatnonzero(contact.equations.statuses() > 0)
        if len(points):
            bearing.append(_Bearing(rows, points, step, parameters))
    if not bearing:
        return None
    m = motion.mobility(motion.turn[1])
    G, off = (np.concatenate([getattr(b, each) for b in bearing]) for each in ("G", "off"))
    inverse = np.linalg.pinv(G @ m @ G.T, rcond=1e-10, hermitian=True)
    y = inverse @ off
    forces = G.T @ y
    u = m @ forces
    moved = motion.turned(m, forces)  # and m turns
    for b, (first, last) in zip(bearing, _bounds(bearing)):
        moved = moved + m @ b.turned_forces(y[first:last])
    turned = np.concatenate([b.turned_rows(u) for b in bearing])
    back = m @ G.T @ inverse
    own = -moved + back @ (turned + G @ moved)
    derivatives = {"way": -u}
    for name in ("q", "v", "q_old", "v_old", "dt", "by"):
        derivatives[name] = -back @ np.concatenate([getattr(b, name) for b in bearing])
    derivatives["q"] = derivatives["q"] + own
    moved = np.zeros((motion.size, len(parameters)))
    for b, (first, last) in zip(bearing, _bounds(bearing)):
        for i, by in enumerate(b.moved):
            if by is not None:
                change = b.bent(by)
                f = change.T @ y[first:last]
                spread = np.zeros(len(off))
                spread[first:last] = change @ u
                moved[:, i] += -m @ f + back @ (spread + G @ (m @ f))
    derivatives["by"] = derivatives["by"] + moved
    return Shift(**derivatives)


def _bounds(bearing: Sequence[_Bearing]) -> list[tuple[int, int]]:
    ends = np.cumsum([0, *(len(b.off) for b in bearing)])
    return list(zip(ends[:-1], ends[1:]))


class _Bearing:
    """The bearing points of a contact: gaps, how far off they are, and the derivatives of that."""

    def __init__(
        self,
        rows: ContactRows,
        points: np.ndarray,
        step: Step,
        parameters: Sequence[Parameter],
    ) -> None:
        contact, size = rows.contact, rows.motion.size
        d = contact.surface.dim
        at = (points[:, None] * d + np.arange(d)).ravel()
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
        start = dot(w_old, n) * starts
        self.G = np.einsum("pi,pij->pj", n, J)
        self._J, self._C, self._n = J, C, n
        self._arms = Arms(rows.arms[1].arms[points])
        turned = C @ J
        wall = contact.coupling.wall  # type: ignore[attr-defined]
        place = rows.places[points]
        gap = -wall.distance(place, 0.0)
        self.off = gap - contact.gap[points] - rate * dot(w, n) - rest * start
        self.q = np.einsum("pi,pij->pj", slope, J) - rate * (
            np.einsum("pi,pij->pj", n, H) + np.einsum("pi,pij->pj", w, turned)
        )
        self.q -= rest * np.einsum("p,pi,pij->pj", starts, w_old, turned)
        self.v = -rate * self.G
        away = np.einsum("pi,pij->pj", rows.old_slope[points], J_old)
        self.q_old = -away - rest * starts[:, None] * np.einsum("pi,pij->pj", n, H_old)
        self.v_old = -rest * starts[:, None] * np.einsum("pi,pij->pj", n, J_old)
        theta = step.scheme.position_rate
        self.dt = -(theta * dot(w, n) + (1 - theta) * start)
        self.by = np.zeros((len(points), len(parameters)))
        self.moved: list[np.ndarray | None] = []
        for i, parameter in enumerate(parameters):
            change = parameter.wall(contact, rows.places)
            self.moved.append(None if change is None else -change[1][points])
            if change is not None:
                closer, turned = (-each[points] for each in change)  # gaps and normals of the slave
                before = rows.closer(parameter, rows.old_places)[points]
                self.by[:, i] = closer - before - rate * dot(w, turned)
                self.by[:, i] -= rest * starts * dot(w_old, turned)

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
