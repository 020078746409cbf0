# SPDX-License-Identifier: LGPL-3.0-or-later
"""The contact terms of a weak form, compiled once, as dense arrays for the Newton loop.

The unknowns of a surface of n points stand in the order (w point by point, lam, Lam component by
component). Only the *candidates* of a step have equations: at the others nothing acts.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
import ufl

from ..base import compat
from ..theory.formulations import Formulation
from .surface import Surface, SurfaceFields

#: The friction row keeps this share of its usual weight where the pressure vanishes.
GUARD = 1e-8
#: Points that approach or leave more slowly than this share of the speeds of a step touch when it
#: starts: among points that rest side by side round-off must not choose those that bear.
STILL = 1e-9
#: They approach then at this share of that: less than Newton's method resolves.
HARDLY = 1e-3


class SurfaceEquations:
    """The compiled equations of one contact surface.

    Args:
        surface: the surface.
        formulation: gives the weak form.
        friction: Coulomb's coefficient.
        chosen: the points that the formulation acts on, (n,) of bool.
        weight: what a point weighs in the integrals: its area, or 1, (n,).
        augmentation: pure numbers that multiply rho_n and rho_t.
    """

    def __init__(
        self,
        surface: Surface,
        formulation: Formulation,
        friction: float,
        chosen: np.ndarray,
        weight: np.ndarray,
        augmentation: tuple[float, float],
    ) -> None:
        n, d = surface.points.shape
        discrete_sum = None if weight is surface.area else weight / surface.area
        self.fields = k = SurfaceFields(surface, friction, formulation.multipliers, discrete_sum)
        form, status = formulation.form(k)
        self.form = form
        self._residual = compat.VectorAssembler(form)
        self._tangent = compat.MatrixAssembler(ufl.derivative(form, k.unknowns))
        self._status = compat.PointExpression(status, surface.scalars)

        self._surface, self._chosen, self._augmentation = surface, chosen, augmentation
        self.weight = weight
        self.jumps = n * d
        self.size = k.components * n
        self.semi = self.jumps + n * formulation.multipliers  # where Lam begins
        self._order = np.concatenate([k.dofs[:d].T.ravel(), k.dofs[d:].ravel()])
        self.order_of_rows = place = np.empty(self.size, dtype=np.int64)
        place[self._order] = np.arange(self.size)
        rows = np.repeat(np.arange(self.size), np.diff(self._tangent.indptr))
        self._place = place[rows], place[self._tangent.indices]
        self._entries = self._place[0] * self.size + self._place[1]
        self._dense = np.zeros((self.size, self.size))
        # entries of the tangent that join unknowns of the same point: all that are not zero
        each, more = np.arange(n), np.arange(d, k.components)
        points = np.concatenate([np.repeat(each, d), np.tile(each, len(more))])
        kinds = np.concatenate([np.tile(np.arange(d), n), np.repeat(more, n)])
        mine = points[self._place[0]] == points[self._place[1]]
        row, column = (each[mine] for each in self._place)
        self._own = mine, (points[row], kinds[row], kinds[column])
        self._blocks = np.zeros((n, k.components, k.components))
        self._z = k.unknowns.x.array
        self._key, self._scale, self._rates = b"", (0.0, 0.0), (0.0, 0.0)
        self.revision = 0  # counts the changes of candidates and scales
        self.choose(chosen)

    def choose(self, candidates: np.ndarray) -> None:
        """The points that may bear in this step, (n,) of bool."""
        candidates = candidates & self._chosen
        key = candidates.tobytes()
        if key == self._key:
            return
        self._key = key
        self.revision += 1
        self.fields.closed.x.array[:] = candidates
        self.candidates = np.flatnonzero(candidates)
        n, d = self._surface.points.shape
        self.active_jumps = (self.candidates[:, None] * d + np.arange(d)).ravel()
        blocks = np.arange(self.jumps, self.size, n)[:, None] + self.candidates
        self.active_multipliers = blocks.ravel()
        self.active = np.concatenate([self.active_jumps, blocks.ravel()]).astype(np.int64)
        self._active_dofs = self._order[self.active]
        self._block = None if len(self.active) == self.size else np.ix_(self.active, self.active)

    def set_scale(self, unit: float, speed: float) -> None:
        """Scale unknowns, rows and augmentation.

        Args:
            unit: the pressure (force) that stops 1 m/s at a typical point within the step.
            speed: a typical speed of the step, m/s.
        """
        k = self.fields
        if self._scale != (unit, speed):
            self._scale = (unit, speed)
            pressure = unit * speed
            k.rho_n.value = self._augmentation[0] * unit
            k.pressure_scale.value = pressure
            share = np.where(self._chosen & (self.weight > 0), self.weight, 1.0)
            self.force_scale = pressure * share  # of each point, N
            self.column_scale = np.full(self.size, speed)
            self.row_scale = np.full(self.size, 1 / speed)
            if self.semi > self.jumps:
                lam = slice(self.jumps, self.semi)
                self.column_scale[lam] = pressure
                self.row_scale[lam] = 1 / (share * speed)
            if self.size > self.semi:
                rho_t = self._augmentation[1] / (float(k.friction.value) * speed)
                k.rho_t.value = rho_t
                self.column_scale[self.semi :] = 1.0
                components = (self.size - self.semi) // self._surface.size
                stick = 1 / (float(k.friction.value) * pressure * speed * share)
                self.row_scale[self.semi :] = np.tile(stick, components)
                self.slip_weight = rho_t * speed
            self._refresh()

    @property
    def speed(self) -> float:
        """The typical speed of the step by which its unknowns are scaled, m/s."""
        return self._scale[1]

    def set_weight(self, weight: np.ndarray) -> None:
        """The points weigh otherwise in the integrals than before, (n,)."""
        if not np.array_equal(weight, self.weight):
            self.weight = weight
            self.fields.set_weight(weight / self._surface.area)
            scale, self._scale = self._scale, (0.0, 0.0)
            if scale[0]:
                self.set_scale(*scale)

    def set_rates(self, gap_rate: float, dt: float) -> None:
        """Derivative of the gap by w, s, and length of the step, s."""
        if self._rates != (gap_rate, dt):
            self._rates = (gap_rate, dt)
            self.fields.gap_rate.value, self.fields.dt.value = gap_rate, dt
            self._refresh()

    def _refresh(self) -> None:
        self.revision += 1
        self._residual.refresh_constants()
        self._tangent.refresh_constants()

    @property
    def values(self) -> np.ndarray:
        """The unknowns; setting them sets the fields."""
        return self._z[self._order]

    @values.setter
    def values(self, values: np.ndarray) -> None:
        self._z[self._order] = values
        if self.size > self.semi:
            least = GUARD * self._scale[0] * self._scale[1]
            bearing = np.maximum(-values[self.jumps : self.semi], least)
            self.fields.bearing.x.array[:] = bearing

    def residual(self) -> np.ndarray:
        """The assembled contact terms of (7)."""
        return self._residual()[self._order]

    def tangent(self) -> np.ndarray:
        """Their derivative by the unknowns; the next call uses the same array again."""
        self._dense.ravel()[self._entries] = self._tangent()
        return self._dense

    # -- as a part of a system: restricted to the candidates --------------------------------------

    @property
    def places(self) -> int:
        """Number of velocities of the points that the system may have as unknowns."""
        return self.jumps

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
        """The active unknowns."""
        return self._z[self._active_dofs]

    def active_residual(self) -> np.ndarray:
        """Their rows."""
        return self._residual()[self._active_dofs]

    def active_tangent(self) -> np.ndarray:
        """And their tangent, dense."""
        dense = self.tangent()
        return dense if self._block is None else dense[self._block]

    def point_tangents(self) -> np.ndarray:
        """Tangents of the candidates one by one, (points, unknowns, unknowns)."""
        mine, index = self._own
        self._blocks[index] = self._tangent()[mine]
        return self._blocks[self.candidates]

    def move(self, step: np.ndarray) -> None:
        """Add to the active unknowns."""
        values = self.values
        values[self.active] += step
        self.values = values

    def kind(self, row: int) -> str:
        """What an active row is."""
        row -= len(self.active_jumps)
        return "jump" if row < 0 else "multiplier" if row < len(self.candidates) else "friction"

    def jump_operator(self) -> None:
        """The unknown velocities are the jumps of the candidates."""
        return None

    def set_places(self, velocities: np.ndarray) -> None:
        """Set the active velocities."""
        values = self.values
        values[self.active_jumps] = velocities
        self.values = values

    @property
    def equations(self) -> SurfaceEquations:
        """The equations of the surface: these."""
        return self

    def whole_tangent(self) -> sp.csr_matrix:
        """The tangent of all points, sparse."""
        return sp.csr_matrix((self._tangent(), self._place), (self.size, self.size))

    def sparse_tangent(self, frozen: bool = False) -> sp.csr_matrix:
        """The tangent of the active unknowns, sparse; the geometry is frozen here anyway."""
        return self.whole_tangent()[self.active][:, self.active]

    def statuses(self) -> np.ndarray:
        """0 open, 1 stick (or bearing without friction), 2 slip, for each point."""
        status = np.zeros(self._surface.size)
        if len(self.candidates):
            status[self._surface.cell_nodes.ravel()] = self._status().ravel()
            status[~self._chosen] = 0.0
        return status

    def error(self, scaled: np.ndarray) -> np.ndarray:
        """The error that the scaled residuals of the active rows stand for.

        The friction row measures a speed where it sticks and Lam itself where it slips; far from
        their natural size rho_n and rho_t would otherwise loosen the one or overdo the other, and
        pressures far above theirs, of a heavy body on a light one, overdo both. Where hardly any
        pressure is, hardly any friction depends on Lam.
        """
        result = np.abs(scaled)
        if self.size > self.semi:
            Lam = self.values[self.active[len(self.active_jumps) + len(self.candidates) :]]
            friction = result[len(result) - len(Lam) :]
            friction[np.abs(Lam) >= 1] *= self.slip_weight
            pressure = -self.values[self.jumps : self.semi][self.candidates]
            usual = pressure / (self._scale[0] * self._scale[1])
            low = np.where(pressure > 0, np.minimum(1.0, usual / GUARD), 1.0)
            friction *= np.tile(low / np.maximum(1.0, usual), self.fields.surface.dim - 1)
        return result

    def start(self, jump: np.ndarray, free: np.ndarray, tolerance: float) -> None:
        """Starting values of a step: what bore goes on, what closes starts from the free jump.

        Args:
            jump, free: of the last step and without contact, flat, m/s.
            tolerance: gaps below it are none, m.
        """
        z = self.values
        idle = np.ones(self.size, dtype=bool)
        idle[self.active] = False
        idle[: self.jumps] = False
        z[idle] = 0.0
        z[: self.jumps] = free
        if self.semi > self.jumps:
            d = self._surface.dim
            bearing = np.repeat(z[self.jumps : self.semi] < 0, d)
            z[: self.jumps][bearing] = jump[bearing]
            open_ = z[self.jumps : self.semi] == 0
            self._touch(z[: self.jumps].reshape(-1, d), open_, tolerance)
        self.values = z

    def _touch(self, jumps: np.ndarray, open_: np.ndarray, tolerance: float) -> None:
        """Let points that did not bear, and that without contact would just touch, approach a
        little in the jumps (n, d): all of them bear at first, and the law lets go of some."""
        normals, rate = self.fields.frame()[0], self._rates[0]
        approach = np.einsum("ij,ij->i", jumps, normals)
        slow = STILL * self._scale[1]
        if rate:
            approach += self.fields.gap.x.array / rate
            slow = max(slow, tolerance / rate)
        still = open_ & (np.abs(approach) < slow)
        jumps[still] += (HARDLY * slow - approach[still, None]) * normals[still]

    def enter_slipping(self) -> None:
        """Let points that have just begun to bear slip along their jump.

        Their pressure is still small, and so is what friction can hold; to stick would ask for
        more than that, tear off the neighbours and make statuses cycle.
        """
        if self.size == self.semi:
            return
        z, n = self.values, self._surface.size
        _, tangents = self.fields.frame()
        Lam = z[self.semi :].reshape(-1, n)
        new = (z[self.jumps : self.semi] < 0) & ~Lam.any(axis=0)
        new &= self.fields.closed.x.array > 0  # candidates
        jump = np.einsum("tij,ij->ti", tangents, z[: self.jumps].reshape(n, -1))
        size = np.linalg.norm(jump, axis=0)
        new &= size > 0
        Lam[:, new] = jump[:, new] / size[new]
        self.values = z

    @property
    def multiplier(self) -> np.ndarray | None:
        """lam at the points, Pa (N where a formulation acts at points), if there is one."""
        return self.values[self.jumps : self.semi] if self.semi > self.jumps else None
