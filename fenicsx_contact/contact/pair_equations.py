# SPDX-License-Identifier: LGPL-3.0-or-later
"""The equations of a contact between two solids, in the velocities of the nodes of both sides.

The weak form (7) sees them through jumps ``w = J y``, gaps and normals at the slave's nodes. With
the geometry frozen J alone enters the tangent; Newton's method for the whole problem needs besides
how J, gaps and normals turn with the nodes. Each process has the rows of J of its points and their
part of the tangent.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI

from ..base.vectors import components
from .equations import SurfaceEquations
from .mortar import Pairing
from .mortar.matrices import (
    Matrix,
    along,
    block,
    by_point,
    dense,
    gather,
    nonzero,
    placed,
    stack,
)
from .mortar.rates import Rates
from .tangent import PointRows
from .unknowns import own_multipliers


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
        self.active_places = self._own = np.empty(0, dtype=np.int64)
        self.revision = 0
        self._rates: Rates | None = None
        #: The last ones with derivatives of the geometry, and of which candidates.
        self._rows: tuple[np.ndarray, PointRows] | None = None
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
        start: Matrix | None = None,
    ) -> None:
        """Take up the pairing where it is now.

        Args:
            velocities: of the nodes, flat.
            exact: with the derivatives of the geometry.
            gap_rate: derivative of the places by the velocities, s.
            share: of the end of the step in the gap that the law reads.
            kept: whether the last tangent with these derivatives may stand for the present one,
                as long as the same points see the same nodes.
            start: J where the step starts: forces act by the mean of both, as along that of the
                normals.
        """
        e, d, n = self.equations, self._d, self.pairing.n
        self.velocities = velocities.copy()
        self.revision += 1
        pair, here = self.pairing, self.pairing.shared.node_here
        self._own = np.flatnonzero(here[e.candidates])
        points = e.candidates[self._own]
        jumps = components(points, d)
        J = pair.operator[jumps]
        S = J if start is None else self._mean(J, start[jumps], points)
        self.keeps = kept and self._rows is not None and self._of is e.candidates
        if self.keeps:
            here = [each[:, self.active_places] for each in (J, S)]
            if not pair.shared.anywhere(list(map(nonzero, here)) != list(map(nonzero, (J, S)))):
                self._J, self._spread = here
                self._set_jumps()
                return
        self.keeps, self._of = False, e.candidates
        self._rates, self._rows, self._gap_rate = None, None, gap_rate
        seen = [J, S]
        if exact and len(e.candidates):
            self._rates = rates = getattr(pair, "rates", None) or Rates(pair)
            full = pair.operator + gap_rate * rates.jump(velocities.reshape(-1, d))
            turn = gap_rate * rates.normal
            normal = e.fields.normal.x.array.reshape(n, d)
            jump = (pair.operator @ velocities).reshape(n, d)
            gap = share * gap_rate * (rates.gap - along(normal, full) - along(jump, turn))
            seen += [full[jumps], gap[points], turn[jumps]]
        self.active_places = mine = pair.shared.columns(seen)
        self._J, self._spread = J[:, mine], S[:, mine]
        if self._rates:
            # point by point what its equations read: jumps, gap and normal
            order = np.arange(len(jumps)).reshape(-1, d)
            gaps = len(jumps) + np.arange(len(points))[:, None]
            order = np.concatenate([order, gaps, len(jumps) + len(points) + order], axis=1)
            self._seen = stack([each[:, mine] for each in seen[2:]])[order.ravel()]
        self._set_jumps()

    def _mean(self, end: Matrix, start: Matrix, points: np.ndarray) -> Matrix:
        """Rows of points by which forces on them act, from those at both ends of a step."""
        share = self.equations.fields.end_share.x.array[points]
        if (share == 1).all():
            return end
        one = np.eye(self._d)
        weights = share[:, None, None] * one
        return by_point(weights, end) + by_point(one - weights, start)

    def _set_jumps(self) -> None:
        values = self.equations.values
        values[: self.equations.jumps] = self.pairing.jumps(self.velocities)
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
        e, d = self.equations, self._d
        residual, n = e.active_residual(), len(e.active_jumps)
        forces = self._spread.T @ residual[:n].reshape(-1, d)[self._own].ravel()
        return np.concatenate([self.pairing.shared.sum(forces), residual[n:]])

    def own(self, comm: MPI.Comm) -> np.ndarray:
        """Numbers of the candidates whose rows this process has."""
        return self._own

    def point_rows(self) -> PointRows:
        """Their tangent point by point."""
        e, d = self.equations, self._d
        rows, turning = self._point_rows(np.arange(len(e.candidates)), False), None
        if rows.turning is not None:
            turning = self.pairing.shared.whole(rows.turning)
        read = rows.tangents.shape[2] - (rows.tangents.shape[1] - d)
        reads, spreads = self._of_all(rows.reads, read), self._of_all(rows.spreads, d)
        return PointRows(rows.tangents, reads, spreads, turning)

    def _point_rows(self, asked: np.ndarray, frozen: bool) -> PointRows:
        """The same, tangents of those asked for; of matrices this process's share."""
        if self.keeps and self._rows is not None and not frozen:
            of, rows = self._rows
            if np.array_equal(of, asked):
                return rows
        e, d, rates = self.equations, self._d, self._rates
        tangents = e.tangents.blocks()[e.candidates[asked]]
        if rates is None or frozen:
            return PointRows(tangents, self._J, self._spread)
        by = e.tangents.parameters()[e.candidates[asked]]
        at_nodes = np.zeros((self.pairing.n, d))
        at_nodes[e.candidates] = e.active_residual()[: len(e.active_jumps)].reshape(-1, d)
        areas = np.array_equal(e.weight, self.pairing.area)  # or they are points
        mine = self.active_places
        at_nodes *= e.fields.end_share.x.array[:, None]  # the rest acts by the start
        turning = self._gap_rate * rates.spread(at_nodes, areas)[mine][:, mine]
        read = np.concatenate([tangents[:, :, :d], by, tangents[:, :, d:]], axis=2)
        self._rows = asked, PointRows(read, self._seen, self._spread, turning)
        return self._rows[1]

    def _tangent(self, frozen: bool = False) -> Matrix:
        """This process's share of their tangent, in the active velocities and the multipliers of
        its points; if ``frozen`` without the derivatives of the geometry."""
        d = self._d
        tangents, seen, J, turning = self._point_rows(self._own, frozen)
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

    def share(self, own: np.ndarray, frozen: bool = False) -> sp.csr_matrix:
        """What the candidates of this process add to the tangent, in the active velocities and
        their multipliers."""
        return sp.csr_matrix(self._tangent(frozen))

    def sparse_tangent(self, frozen: bool = False) -> sp.csr_matrix:
        """Their tangent, sparse; if ``frozen`` without the derivatives of the geometry."""
        return sp.csr_matrix(self._everything(self._tangent(frozen)))

    def active_tangent(self) -> np.ndarray:
        """Their tangent, dense."""
        return dense(self._everything(self._tangent()))

    def _everything(self, share: Matrix) -> Matrix:
        """The tangent of which this is this process's share."""
        e, n = self.equations, len(self.active_places)
        mine = n + own_multipliers(self._own, len(e.candidates), e.multipliers)
        place = np.concatenate([np.arange(n), mine])
        return self.pairing.shared.whole(placed(share, place, place, (n + e.multipliers,) * 2))

    def _of_all(self, rows: Matrix, each: int) -> Matrix:
        """Rows of all candidates, so many of each, from those of this process's."""
        place = components(self._own, each)
        shape = len(self.equations.candidates) * each, rows.shape[1]
        return self.pairing.shared.whole(placed(rows, place, np.arange(shape[1]), shape))

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
        return dense(self._of_all(self._J, self._d))

    def force_operator(self) -> np.ndarray:
        """Its transpose makes forces on the active velocities of those on the candidates."""
        return dense(self._of_all(self._spread, self._d))
