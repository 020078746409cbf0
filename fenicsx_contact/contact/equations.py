# SPDX-License-Identifier: LGPL-3.0-or-later
"""The contact terms of a weak form, compiled once, as dense arrays for the Newton loop.

The unknowns of a surface of n points stand in the order (w point by point, lam, tau component by
component). Only the *candidates* of a step have equations: at the others nothing acts.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI

from ..base import compat
from ..base.expressions import finite_form
from ..base.vectors import components, largest
from ..theory.formulations import Formulation
from ..theory.friction import FrictionBound
from .augmentation import Augmentation
from .bounds import refuse_negative
from .memory import at_points
from .mortar.matrices import placed
from .surface import Surface
from .surface_fields import SurfaceFields
from .tangent import PointRows, SurfaceTangent
from .unknowns import SurfaceUnknowns, own_multipliers


class SurfaceEquations(SurfaceUnknowns):
    """The compiled equations of one contact surface.

    Args:
        surface: the surface.
        formulation: gives the weak form.
        friction: the law of friction, None if there is none.
        chosen: the points that the formulation acts on, (n,) of bool.
        weight: what a point weighs in the integrals: its area, or 1, (n,).
        augmentation: pure numbers that multiply rho_n and rho_t.
        turning: whether normals change on the way of a step.

    Attributes:
        gap, start_jump_n, normal: what the form reads as d_n, as w_n at the start of the step and
            as n, flat, in m, m/s and 1; ``revision`` counts changes of candidates and scales.
        carried: velocities of the other side that are given, flat, m/s: the velocities of the
            points are w and these.
    """

    keeps = _turned = False

    def __init__(
        self,
        surface: Surface,
        formulation: Formulation,
        friction: FrictionBound | None,
        chosen: np.ndarray,
        weight: np.ndarray,
        augmentation: tuple[float, float],
        turning: bool = False,
    ) -> None:
        n, d = surface.points.shape
        share = None if weight is surface.nodal_area else weight / surface.nodal_area
        lam = formulation.multipliers
        unknown = lam, getattr(formulation, "tractions", lam)
        self.fields = k = SurfaceFields(surface, friction, *unknown, share, turning)
        form, status = k.form_of(formulation)
        self._residual = compat.VectorAssembler(finite_form(form))
        self._status = compat.PointExpression(status, surface.scalars)

        self._surface, self._chosen = surface, chosen
        self.augmentation = Augmentation(augmentation, n)
        self.weight = weight
        self.jumps = self.places = n * d
        self.size = k.components * n
        self.tractions = self.jumps + n * lam  # where tau begins
        self.order = np.concatenate([k.dofs[:d].T.ravel(), k.dofs[d:].ravel()])
        self.tangents = SurfaceTangent(k, form, self.order)
        self._z, self._closed, self.gap = (f.x.array for f in (k.unknowns, k.closed, k.gap))
        self.start_jump_n, self.normal = k.start_jump_n.x.array, k.normal.x.array
        self._key, self._rates, self.revision = b"", (0.0, 0.0, 0.0, 0.0), 0
        self.speed = 0.0  # the typical one of the step, by which unknowns are scaled, m/s
        self._units = self.augmentation.units
        self.carried, self._last = np.zeros(self.jumps), np.zeros(self.size)
        self.choose(chosen)
        refuse_negative(self, friction)

    def choose(self, candidates: np.ndarray) -> None:
        """The points that may bear in this step, (n,) of bool."""
        candidates = candidates & self._chosen
        key = candidates.tobytes()
        if key == self._key:
            return
        self._key = key
        self.revision += 1
        self._closed[:] = candidates
        self.candidates = np.flatnonzero(candidates)
        self._stopping: float | None = None
        n, d = self._surface.points.shape
        self.active_jumps = components(self.candidates, d)
        blocks = np.arange(self.jumps, self.size, n)[:, None] + self.candidates
        self.active_multipliers = blocks.ravel()
        self.active = np.concatenate([self.active_jumps, blocks.ravel()]).astype(np.int64)
        self._active_dofs = self.order[self.active]
        self._block = None if len(self.active) == self.size else np.ix_(self.active, self.active)
        idle = np.ones(self.size, dtype=bool)
        idle[: self.jumps] = idle[self.active] = False
        self.idle_multipliers = np.flatnonzero(idle)

    def set_scale(self, units: np.ndarray, alone: np.ndarray, speed: float) -> None:
        """Scale unknowns, rows and augmentation by a typical speed of the step, m/s.

        Args:
            units: pressures (forces) that scale multipliers at 1 m/s, along normals and tangents,
                (2, n), and ``alone``: those that stop 1 m/s of each point: its augmentation.
        """
        changed = self.augmentation.take_up(alone)
        if not changed and speed == self.speed and units is self._units:
            return
        if changed:
            self._set_rho()
        self.speed, self._units = speed, units
        self.revision += 1
        d, share = self._surface.dim, np.where(self.weight > 0, self.weight, 1.0)
        self.force_scale = alone[0] * speed * share  # of each point, N
        self._stopping = None
        self.column_scale = np.full(self.size, speed)
        self.row_scale = np.full(self.size, 1 / speed)
        self.row_scale[self.jumps :] = np.tile(1 / (share * speed), self.fields.components - d)
        if self.tractions > self.jumps:
            self.column_scale[self.jumps : self.tractions] = units[0] * speed
        if self.size > self.tractions:
            self.column_scale[self.tractions :] = np.tile(units[1] * speed, d - 1)

    def _set_rho(self) -> None:
        self.fields.rho_n.x.array[:], self.fields.rho_t.x.array[:] = self.augmentation.rho
        self.revision += 1

    def turn(self, careful: bool, shared: bool = False) -> bool:
        """Augment friction by what a correction did, see Augmentation.turn; whether rows change."""
        both, self._last = (self.values, self._last), self.values
        if not (self._turned or careful) or not self.size > self.tractions > self.jumps:
            return False
        (n, d), tangents, self._turned = self._surface.points.shape, self.fields.frame()[1], careful
        slips = tuple((tangents * v[: self.jumps].reshape(n, d)).sum(axis=2) for v in both)
        tractions = tuple(v[self.tractions :].reshape(d - 1, n) for v in both)
        if changed := self.augmentation.turn(tractions, slips, careful, shared):
            self._set_rho()
        return changed

    @property
    def stopping_force(self) -> float:
        """The largest force that stops a candidate of that speed within the step, N."""
        if self._stopping is None:
            self._stopping = largest(self.force_scale[self.candidates])
        return self._stopping

    def set_weight(self, weight: np.ndarray) -> None:
        """The points weigh otherwise in the integrals than before, (n,)."""
        if not np.array_equal(weight, self.weight):
            self.weight = weight
            self.fields.set_weight(weight / self._surface.nodal_area)
            self.speed = 0.0  # scales are to be set anew

    def set_rates(self, gap_rate: float, dt: float, limit_rate: float, horizon: float) -> None:
        """Derivative of the gap by w, s, length of the step, s, (1 - theta)/theta, and the time
        over which a law of velocities looks ahead, s."""
        rates = (gap_rate, dt, limit_rate, horizon)
        if self._rates != rates:
            self._rates = rates
            k = self.fields
            k.gap_rate.value, k.dt.value, k.limit_rate.value, k.horizon.value = rates
            self.refresh()

    def natural(self, scaled: np.ndarray) -> np.ndarray:
        """What the scaled residuals of the active rows stand for: where a row says what a
        multiplier is (open points, friction that slips) it is divided by rho."""
        if (shares := self.augmentation.shares()) is None:
            return scaled
        m, kinds = len(self.candidates), self.fields.components - self._surface.dim
        status, result = self.statuses()[self.candidates], scaled.copy()
        rows = result[len(result) - m * kinds :].reshape(kinds, m)
        normal = int(self.tractions > self.jumps)  # springs have none
        shares = shares[:, self.candidates]
        rows[:normal] *= np.where(status == 0, shares[0], 1.0)
        rows[normal:] *= np.where(status != 1, shares[1], 1.0)
        return result

    def freeze_bound(self, augmentation: float) -> None:
        """Whether the bound of friction is that of the present pressure, which then is no unknown
        in it: Tresca's problem. It is solved with this augmentation; 0: no longer."""
        self.augmentation.tresca = augmentation
        if self.speed:
            self.set_scale(self._units, self.augmentation.units, self.speed)
        if self.size > self.tractions > self.jumps:
            self.fields.frozen.value = float(augmentation > 0)
            lam = self.values[self.jumps : self.tractions]
            self.fields.known_pressure.x.array[:] = np.maximum(-lam, 0) if augmentation else 0.0
            self.refresh()

    def refresh(self) -> None:
        """Constants of the form have changed."""
        self.revision += 1
        self._residual.refresh_constants()
        self.tangents.refresh_constants()

    def residual(self) -> np.ndarray:
        """The assembled contact terms of (7)."""
        return self._residual()[self.order]

    def forces(self) -> np.ndarray:
        """What the unknowns of the candidates are to the points, (n, d) in N."""
        forces = np.zeros(self.jumps)
        if len(self.active_jumps):
            forces[self.active_jumps] = -self.residual()[self.active_jumps]
        return forces.reshape(-1, self._surface.dim)

    # -- as a part of a system: restricted to the candidates --------------------------------------

    @property
    def active_places(self) -> np.ndarray:
        """Those that it has: the jumps of the candidates."""
        return self.active_jumps

    @property
    def multipliers(self) -> int:
        """Number of its multipliers."""
        return len(self.active_multipliers)

    def scales(self) -> tuple[np.ndarray, np.ndarray]:
        """Sizes of the active unknowns, and what makes their rows pure numbers."""
        return self.column_scale[self.active], self.row_scale[self.active]

    def active_values(self) -> np.ndarray:
        """The active unknowns: velocities of the candidates, and multipliers."""
        values = self._z[self._active_dofs]
        values[: len(self.active_jumps)] += self.carried[self.active_jumps]
        return values

    def active_residual(self) -> np.ndarray:
        """Their rows."""
        return self._residual()[self._active_dofs]

    def active_tangent(self) -> np.ndarray:
        """And their tangent, dense."""
        dense = self.tangents.dense()
        return dense if self._block is None else dense[self._block]

    def own(self, comm: MPI.Comm) -> np.ndarray:
        """Numbers of the candidates that are this process's share."""
        return np.array_split(np.arange(len(self.candidates)), comm.size)[comm.rank]

    def share(self, own: np.ndarray, frozen: bool = False) -> sp.csr_matrix:
        """What these candidates add to the tangent, in the active jumps and their multipliers."""
        d, n = self.fields.surface.dim, self.active_jumps.size
        places = components(own, d)
        multipliers = own_multipliers(own, len(self.candidates), self.multipliers)
        active = self.active[np.concatenate([places, n + multipliers])]
        onto = np.concatenate([places, n + np.arange(len(multipliers))])
        tangent = self.tangents.sparse(frozen)[active][:, active]
        return placed(tangent, onto, onto, (n + len(multipliers),) * 2)

    def point_rows(self) -> PointRows:
        """The same, the candidates one by one."""
        return PointRows(self.tangents.blocks()[self.candidates])

    def move(self, step: np.ndarray) -> None:
        """Add to the active unknowns."""
        self._z[self._active_dofs] += step

    def kind(self, row: int) -> str:
        """What an active row is."""
        row -= len(self.active_jumps)
        normal = len(self.candidates) * (self.tractions > self.jumps)
        return "jump" if row < 0 else "multiplier" if row < normal else "friction"

    def jump_operator(self) -> None:
        """The unknown velocities are the jumps of the candidates and what is carried."""

    def force_operator(self) -> None:
        """Forces on the candidates act on these velocities."""

    def set_places(self, velocities: np.ndarray) -> None:
        """Set the active velocities."""
        values = self.values
        values[self.active_jumps] = velocities - self.carried[self.active_jumps]
        self.values = values

    @property
    def equations(self) -> SurfaceEquations:
        """The equations of the surface: these."""
        return self

    def sparse_tangent(self, frozen: bool = False) -> sp.csr_matrix:
        """The tangent of the active unknowns, sparse."""
        return self.tangents.sparse(frozen)[self.active][:, self.active]

    def statuses(self) -> np.ndarray:
        """0 open, 1 stick (or bearing without friction), 2 slip, -1 a bound < 0, for each point."""
        if not len(self.candidates):
            return np.zeros(self._surface.size)
        return at_points(self._surface, self._status) * self._closed
