# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bearing points of a contact between two rigid solids: how far they are from where they belong,
and the derivatives of that; see :mod:`~.hold`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import block_diag

from ..base.vectors import components, dot
from ..contact.mortar.matrices import dense
from ..theory.scheme import Step
from .kinematics import Kinematics
from .pairs import PairRows
from .parameters import Parameter
from .points import RigidPoints


class PairBearing:
    """Bearing points of a contact between two rigid solids; see :class:`~.hold.Bearing`. No
    parameter moves the normals.

    Args:
        rows: of the contact.
        points: that bear.
        step: that was solved.
        parameters: by which.
    """

    def __init__(
        self,
        rows: PairRows,
        points: np.ndarray,
        step: Step,
        parameters: Sequence[Parameter],
    ) -> None:
        contact, coupling, d = rows.contact, rows.contact.coupling, rows.normal.shape[1]
        self._rows, self._points, self._at = rows, points, components(points, d)
        self._nodes = [each for each in rows.nodes if isinstance(each, RigidPoints)]
        self._n, self._J = rows.normal[points], dense(rows.pair.operator)[self._at]
        self._turn = dense(rows.rates.normal)[self._at].reshape(len(points), d, -1)
        self._place = _together([each.new for each in self._nodes], "place")
        rises = _along(self._n, self._J)
        self.G = rises @ self._place

        w, w_old, starts = rows.jump[points], rows.start_jump[points], rows.reads_start[points]
        rest, rate = step.dt - step.gap_rate, step.gap_rate
        # of the clearance that is kept and the like pairings know nothing
        more = coupling.gaps() - coupling.pairing.gap  # type: ignore[attr-defined]
        gap = (rows.pair.gap + more - contact.gap)[points]
        n, turns = self._n, rows.turns[points][:, None]
        then, early = rows.before(), rest * starts[:, None]
        n_old = np.where(turns, rows.then.normal[points], n)
        self.off = gap - rate * dot(w, n) - rest * starts * dot(w_old, n_old)
        towards = rate * w + early * ~turns * w_old
        by_places = dense(rows.rates.gap)[points] - np.einsum("pi,pij->pj", towards, self._turn)
        by_places -= rate * _along(self._n, dense(rows.rates.jump(rows.velocities))[self._at])
        bend = _together([each.new for each in self._nodes], "bend")
        self.q, self.v = by_places @ self._place - rate * rises @ bend, -rate * self.G
        rises = _along(n_old, dense(rows.then.operator)[self._at])
        by_places = -dense(then.gap)[points]
        by_places -= early * _along(n_old, dense(then.jump(rows.old_velocities))[self._at])
        by_places -= early * _along(turns * w_old, dense(then.normal)[self._at])
        place, bend = (_together([e.old for e in self._nodes], name) for name in ("place", "bend"))
        self.q_old, self.v_old = by_places @ place - early * rises @ bend, -early * rises @ place
        self.dt = np.zeros(len(points))  # instants are not located between two solids
        self.by = np.zeros((len(points), len(parameters)))
        self.moved: list[np.ndarray | None] = [None] * len(parameters)

    def bent(self, turned: np.ndarray) -> np.ndarray:
        """Change of G where the normals turn."""
        return np.einsum("pi,pij->pj", turned, self._J.reshape(*turned.shape, -1)) @ self._place

    def turned_forces(self, y: np.ndarray) -> np.ndarray:
        """Derivative of G' y by q, (n, n)."""
        rows, forces = self._rows, np.zeros_like(self._rows.normal)
        forces[self._points] = y[:, None] * self._n
        spread = dense(rows.rates.spread(forces))
        spread = spread + self._J.T @ (y[:, None, None] * self._turn).reshape(len(self._at), -1)
        given = rows.sides((forces[self._points].ravel() @ self._J)[None])
        arms = [each.arms[1] for each in self._nodes]
        lever = [a.turned(g.reshape(a.arms.shape)) for a, g in zip(arms, given)]
        return np.asarray(self._place.T @ spread @ self._place + block_diag(*lever))

    def turned_rows(self, u: np.ndarray) -> np.ndarray:
        """Derivative of G u by q, (k, n)."""
        rows, way = self._rows, self._place @ u
        seen = (self._J @ way).reshape(self._n.shape)
        moved = dense(rows.rates.jump(way.reshape(rows.velocities.shape)))[self._at]
        by_places = _along(self._n, moved) + np.einsum("pi,pij->pj", seen, self._turn)
        spins, first = [], 0
        for each in self._nodes:
            size = each.new.place.shape[1]
            spins.append(each.arms[1].kinematics(u[first : first + size][rows.normal.shape[1] :]))
            first += size
        bend = _together(spins, "bend")
        return np.asarray(by_places @ self._place + _along(self._n, self._J) @ bend)


def _along(directions: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """The components along directions (k, d) of rows (k d, ...), (k, ...)."""
    return np.einsum("pi,pij->pj", directions, matrix.reshape(*directions.shape, -1))


def _together(kinematics: Sequence[Kinematics], name: str) -> np.ndarray:
    return np.asarray(block_diag(*(getattr(each, name) for each in kinematics)))
