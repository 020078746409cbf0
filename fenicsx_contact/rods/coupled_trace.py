# SPDX-License-Identifier: LGPL-3.0-or-later
"""A beam seen from points of its axis, where bending and axial motion are one system."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from ..base.constants import ROUND_OFF
from ..base.vectors import dot
from ..solids.base import Trace
from ..theory.scheme import Step
from .trace import BeamTrace, Slender


class Coupled(Slender, Protocol):
    """What such a trace needs of a beam; see
    :class:`~fenicsx_contact.rods.von_karman.VonKarmanBeam`.

    Attributes:
        inverse: of the tangent of the step, (n, n).
    """

    inverse: np.ndarray

    def push(
        self, force: np.ndarray, held: Callable[[], tuple[np.ndarray, np.ndarray]]
    ) -> None: ...


class CoupledTrace(BeamTrace):
    """A trace whose operator J stands in one matrix with all unknowns of the beam."""

    _solid: Coupled
    normals: Callable[[], np.ndarray] | None = None  # of the walls at the points, (n, d)
    roundness: Callable[[], np.ndarray] | None = None  # their derivatives by places, in space

    def linearise(self, step: Step) -> None:
        """J, and the columns A^-1 J' of all components, (n d, unknowns)."""
        solid = self._solid
        if self._acting is self._now and self._linear is solid.free_velocity:
            return
        self._acting, self._linear = self._now, solid.free_velocity
        acting = self._acting
        bending, along = solid.split(solid.velocity)
        n, d = len(acting.s), len(self._axes)
        local = np.zeros((n, d, bending.size + along.size))
        at = np.arange(n)[:, None]
        for i in range(d - 1):
            local[at, i, i * bending.shape[1] + acting.dofs] = acting.w
        local[at, d - 1, bending.size + acting.ends] = acting.u
        self._rows = np.einsum("nkj,kd->ndj", local, self._axes).reshape(n * d, -1)
        self._columns = self._rows @ solid.inverse

    def compliance(self, mine: np.ndarray, other: Trace, theirs: np.ndarray) -> np.ndarray:
        assert isinstance(other, CoupledTrace)
        return self._columns[mine] @ other._rows[theirs].T

    def mobility(self) -> np.ndarray:
        return np.einsum("ij,ij->i", self._columns, self._rows)

    def spread(self, force: np.ndarray) -> None:
        if force.any():
            self._solid.push(force @ self._rows, lambda: self._held(force))

    def _held(self, force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows of J along the normals where these forces press, (k, unknowns): there the rod moves
        no farther; and by what round walls hold it sideways there, which turn their forces against
        what slides around them, (unknowns, unknowns) in N/m. Of walls that give way, or that nobody
        told the trace, there are none."""
        unknowns = self._rows.shape[1]
        nothing = np.zeros((unknowns, unknowns))
        if self.normals is None:
            return self._rows[:0], nothing
        n = self.normals()
        pressed = np.abs(dot(force.reshape(n.shape), n))
        held = pressed > ROUND_OFF * pressed.max()
        rows = self._rows.reshape(*n.shape, -1)[held]
        along = np.einsum("pi,pij->pj", n[held], rows)
        if self.roundness is None:
            return along, nothing
        turned = pressed[held, None, None] * self.roundness()[held]
        return along, np.einsum("pia,pij,pjb->ab", rows, turned, rows)
