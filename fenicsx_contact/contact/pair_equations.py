# SPDX-License-Identifier: LGPL-3.0-or-later
"""The equations of a contact between two solids, in the velocities of the nodes of both sides.

The weak form (7) sees them through jumps ``w = J y``, gaps and normals at the slave's nodes. With
the geometry frozen J alone enters the tangent; Newton's method for the whole problem needs besides
how J, gaps and normals turn with the nodes.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from .equations import SurfaceEquations
from .mortar import Pairing
from .mortar.matrices import (
    Matrix,
    along,
    block,
    by_point,
    gather,
    nonzero,
    stack,
    used_columns,
)
from .mortar.rates import Rates
from .tangent import PointRows


class PairedEquations:
    """A part of a system, see :class:`~fenicsx_contact.contact.part.Part`.

    Args:
        equations: of the slave surface.
        pairing: of the two sides.

    Attributes:
        velocities: of the nodes of both sides, flat, m/s.
        active_places: those of them that the candidates see.
        keeps: whether its tangent is the last one, from before the geometry was taken up.
    """

    def __init__(self, equations: SurfaceEquations, pairing: Pairing) -> None:
        self.equations, self.pairing = equations, pairing
        self._d, self._dense = equations.fields.surface.dim, pairing.dense
        self.velocities = np.zeros(self.places)
        self.active_places = np.empty(0, dtype=np.int64)
        self.revision = 0
        self._rates: Rates | None = None
        self._rows: PointRows | None = None  # the last ones, with derivatives of the geometry
        self.keeps, self._of = False, equations.candidates

    @property
    def places(self) -> int:
        """Number of velocities: components of all nodes of both sides."""
        return self.pairing.total * self._d

    def linearise(
        self,
        velocities: np.ndarray,
        exact: bool,
        gap_rate: float,
        share: float,
        kept: bool = False,
    ) -> None:
        """Take up the pairing where it is now.

        Args:
            velocities: of the nodes, flat.
            exact: with the derivatives of the geometry.
            gap_rate: derivative of the places by the velocities, s.
            share: of the end of the step in the gap that the law reads.
            kept: whether the last tangent with these derivatives may stand for the present one,
                as long as the same points see the same nodes.
        """
        e, d, n = self.equations, self._d, self.pairing.n
        self.velocities = velocities.copy()
        self.revision += 1
        self._operator = self.pairing.operator
        J = self._operator[e.active_jumps]
        self.keeps = kept and self._rows is not None and self._of is e.candidates
        if self.keeps:
            mine = J[:, self.active_places]
            if nonzero(mine) == nonzero(J):
                self._J = mine
                self._set_jumps()
                return
        self.keeps, self._of = False, e.candidates
        self._rates, self._rows, self._gap_rate = None, None, gap_rate
        seen = [J]
        if exact and len(e.candidates):
            self._rates = rates = Rates(self.pairing)
            full = self._operator + gap_rate * rates.jump(velocities.reshape(-1, d))
            turn = gap_rate * rates.normal
            normal = e.fields.normal.x.array.reshape(n, d)
            jump = (self._operator @ velocities).reshape(n, d)
            gap = share * gap_rate * (rates.gap - along(normal, full) - along(jump, turn))
            seen += [full[e.active_jumps], gap[e.candidates], turn[e.active_jumps]]
        self.active_places = mine = used_columns(seen)
        self._J = J[:, mine]
        if self._rates:
            # point by point what its equations read: jumps, gap and normal
            jumps = np.arange(len(e.active_jumps)).reshape(-1, d)
            gaps = jumps.size + np.arange(len(jumps))[:, None]
            order = np.concatenate([jumps, gaps, jumps.size + len(jumps) + jumps], axis=1)
            self._seen = stack([each[:, mine] for each in seen[1:]])[order.ravel()]
        self._set_jumps()

    def _set_jumps(self) -> None:
        values = self.equations.values
        values[: self.equations.jumps] = self._operator @ self.velocities
        self.equations.values = values

    # -- as a part of a system ------------------------------------------------------------------

    @property
    def multipliers(self) -> int:
        """Number of active multipliers."""
        return self.equations.multipliers

    def scales(self) -> tuple[np.ndarray, np.ndarray]:
        """Sizes of the active unknowns, and what makes their rows pure numbers."""
        e, n = self.equations, len(self.active_places)
        return tuple(
            np.concatenate([np.full(n, scale[0]), scale[e.active_multipliers]])
            for scale in (e.column_scale, e.row_scale)
        )

    def active_values(self) -> np.ndarray:
        """The active unknowns."""
        e = self.equations
        mine = self.velocities[self.active_places]
        return np.concatenate([mine, e.values[e.active_multipliers]])

    def active_residual(self) -> np.ndarray:
        """Their rows: forces J' F_w, then those of the multipliers."""
        e = self.equations
        residual = e.active_residual()
        forces = self._J.T @ residual[: len(e.active_jumps)]
        return np.concatenate([forces, residual[len(e.active_jumps) :]])

    def point_rows(self, frozen: bool = False) -> PointRows:
        """Their tangent point by point; if ``frozen`` without the derivatives of the geometry."""
        if self.keeps and self._rows is not None and not frozen:
            return self._rows
        e, mine, d = self.equations, self.active_places, self._d
        tangents, rates = e.point_rows().tangents, self._rates
        if rates is None or frozen:
            return PointRows(tangents, self._J, self._J)
        by = e.tangents.parameters()[e.candidates]
        at_nodes = np.zeros((self.pairing.n, d))
        at_nodes[e.candidates] = e.active_residual()[: len(e.active_jumps)].reshape(-1, d)
        areas = np.array_equal(e.weight, self.pairing.area)  # or they are points
        turning = self._gap_rate * rates.spread(at_nodes, areas)[mine][:, mine]
        read = np.concatenate([tangents[:, :, :d], by, tangents[:, :, d:]], axis=2)
        self._rows = PointRows(read, self._seen, self._J, turning)
        return self._rows

    def _tangent(self, frozen: bool = False) -> Matrix:
        """Their tangent; if ``frozen`` without the derivatives of the geometry."""
        d = self._d
        tangents, seen, J, turning = self.point_rows(frozen)
        assert J is not None
        c, u, r = tangents.shape
        r -= u - d  # what a point reads
        forces = J.T @ by_point(tangents[:, :d, :r], seen)
        if turning is not None:
            forces = forces + turning
        own = np.arange(c * (u - d)).reshape(u - d, c).T  # multipliers stand component by component
        order = np.arange(c * (u - d)).reshape(c, u - d).T.ravel()
        rows = by_point(tangents[:, d:, :r], seen)[order]
        columns = by_point(tangents[:, :d, r:].transpose(0, 2, 1), J)[order].T
        inner = tangents[:, d:, r:]
        corner = gather(inner, own[:, :, None], own[:, None], (own.size, own.size), self._dense)
        return block([[forces, columns], [rows, corner]])

    def sparse_tangent(self, frozen: bool = False) -> sp.csr_matrix:
        """Their tangent, sparse; if ``frozen`` without the derivatives of the geometry."""
        return sp.csr_matrix(self._tangent(frozen))

    def active_tangent(self) -> np.ndarray:
        """Their tangent, dense."""
        tangent = self._tangent()
        return tangent if self._dense else tangent.toarray()

    def move(self, step: np.ndarray) -> None:
        """Add to the active unknowns."""
        n, e = len(self.active_places), self.equations
        self.velocities[self.active_places] += step[:n]
        values = e.values
        values[e.active_multipliers] += step[n:]
        e.values = values
        self._set_jumps()

    def set_places(self, velocities: np.ndarray) -> None:
        """Set the active velocities."""
        self.velocities[self.active_places] = velocities
        self._set_jumps()

    def statuses(self) -> np.ndarray:
        """0 open, 1 stick, 2 slip, for each node of the slave."""
        return self.equations.statuses()

    def kind(self, row: int) -> str:
        """What an active row is."""
        e = self.equations
        return e.kind(max(row - len(self.active_places) + len(e.active_jumps), 0))

    def jump_operator(self) -> np.ndarray:
        """Jumps of the candidates from the active velocities."""
        return self._J if self._dense else self._J.toarray()
