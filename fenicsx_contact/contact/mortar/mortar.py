# SPDX-License-Identifier: LGPL-3.0-or-later
"""The operator of a pair: nodal velocity jumps, gaps and normals on the slave surface.

The jump at node i of the slave is a mean weighted by the function psi_i that is dual to its P1
shape functions phi_j (int psi_i phi_j = delta_ij a_i on each facet; Wohlmuth 2000),

    w_i = 1/a_i  int psi_i (v_slave - v_master o pi)        a_i = int phi_i,

over the part of the surface that has a partner (phi_j are those of the corners of this part,
parts.py), which faces it along the normal of the facet or, where a sharp corner stands on the
master, of that (standing.py); gaps likewise. Integrals of solids of revolution are weighted by
2 pi r. With these nodal values the weak form (7) needs no change:
integrated by them with weights a_i, it is the mortar form  int lam_h n . [[v*]]  with lam_h = sum
lam_i psi_i. On a P1 slave lam_i a_i is the force on node i: signs are read node by node. (With
phi_i in place of psi_i, lam_i oscillates at the edge of the contact, and Newton's method lets go of
one node an iteration.) The normal at a node is the mean of those of the facets, n, over what is
covered, and along it counts what goes along these, in the jumps as in the gaps:

    m_i = 1/a_i int psi_i n,    n_i = m_i/|m_i|,    n_i . w_i = 1/(|m_i| a_i) int psi_i n . [[v]].

Forces go to the solids by the transpose: they balance exactly, those along the normals without a
moment, for n joins the points at which they act; a constant pressure is transmitted as such (patch
test).
"""

from __future__ import annotations

from math import prod

import numpy as np
from mpi4py import MPI

from ...base.constants import ROUND_OFF, SAME
from ...base.vectors import normalised
from .idle import idle, without
from .integration import Lines, whole
from .lending import bearing, directions
from .matrices import DENSE, Matrix, add_up, along, by_component, by_point, gather
from .overlaps import Overlaps
from .pieces import Brink, Pieces
from .search import FACETS
from .shares import Shares
from .side import Side
from .small import extremes, inverted
from .stance import Stance
from .walls import admission

#: A node with less than this share of its area paired has no partner.
COVERED = 1e-4
#: Facets whose paired part is so small that round-off alone is left of their dual functions.
ILL = 1e12


class Pairing:
    """Slave and master surface in the places where they are.

    Arrays of positions and velocities are (N, d), the slave's nodes before the master's.

    Args:
        slave, master: the sides; the same one twice: a surface before itself.
        comm: the processes that share the work, each with all of both sides.
        held: components of the nodes that nothing but supports moves, (N, d) of bool; ``still``:
            that these hold at rest.

    Attributes:
        operator: J, (n d, N d), of which each process has the rows of its nodes.
        means, rises: J of one component without regard to normals, (n, N), and n_i . J, (n, N d),
            likewise.
        dense: whether it and its derivatives are small enough for dense matrices.
        gap: weighted d_n, positive: penetration, (n,) in m; -reach where there is no partner.
        normal, length: n_i, outward at the slave's corners, (n, d), and |m_i|, (n,).
        idle: components of the jumps that are none (idle.py), (n, d) of bool.
        area: paired share of the surface of each node, (n,).
        paired, alone: nodes that have a partner, and that would bear and have none, (n,) of bool.
        rows, lending: nodes that bear for the corners of each facet (lending.py), (m, corners), and
            H, by which psi and phi count there, (m, corners, corners).
        shared: which facets this process pairs, and whose nodes' rows it has.
        pieces, brink: what is integrated, and where it ends with the master, on these.
        dual, inverse_mass: of each facet, psi = phi @ dual, (m, corners, corners); ``lumped``:
            int phi, (m, corners).
        shares: psi_i w / a_i at the points, (p, g, corners), and share: 1 / a_i, (n,).
        reach: how far from each node partners were sought, (n,) in m; ``sight``: at least.
        stance, admits: how the slave's facets stand on the master's; which of these may meet.
        carries: whether forces on a node of the slave act on those beside it, too.
        recess: how far places of the slave have worn back from its nodes, (n,) in m, or 0.
        sunk, apart: how deep in each other they began the step; how far apart those touch, m.
    """

    carries, sunk, apart = False, 0.0, 0.0
    recess: np.ndarray | float = 0.0

    def __init__(
        self,
        slave: Side,
        master: Side,
        comm: MPI.Comm = MPI.COMM_SELF,
        held: np.ndarray | None = None,
        still: np.ndarray | None = None,
    ) -> None:
        self.slave, self.master = slave, master
        self.n = int(slave.corners.max()) + 1
        self.total = len(slave.nodes) + len(master.nodes)
        none = np.zeros((self.total, slave.dim), dtype=bool)
        self.held = none if held is None else held.reshape(none.shape)
        self.still = none if still is None else still.reshape(none.shape)
        self._along = directions(slave, self.n)  # what holds these holds the gap
        held = (self.held[: self.n] | ~self._along).all(axis=1)
        self.rows, self.lending = bearing(slave.corners, slave.cell, held)
        self.dense = (self.total * slave.dim) ** 2 <= DENSE
        self._sizes = np.zeros(self.n)  # of the largest facet at each node
        np.maximum.at(self._sizes, slave.corners, slave.sizes[:, None])
        self.sight = FACETS * float(self._sizes.min())
        self.admits = admits = admission(slave, master)
        self.shared = Shares(slave, comm)
        self._common = (
            Lines(slave, master, admits)
            if slave.dim == 2
            else Overlaps(slave, master, admits, self.shared.facets)
        )
        self.brink: Brink | None = None
        self.stance = Stance.none(slave)
        self.places, self._seen = np.empty((0, slave.dim)), (np.nan, 0.0)
        self._rule = rule = whole(slave)
        phi, (values, self.rule_slopes) = slave.linear_shape(rule.xi), slave.shape(rule.xi)
        measure = slave.reference_measure(rule.facet, self.rule_slopes)
        measure = measure * slave.breadth(rule.facet, values)
        self._whole = np.arange(len(slave.cells))
        phi = phi.reshape(len(slave.cells), -1, phi.shape[1])
        self.mean_weight = phi * rule.weight.reshape(*phi.shape[:2], 1)
        areas = self.mean_weight * measure.reshape(*phi.shape[:2], 1)
        self.full_area = self.collect(areas @ self.lending, self._whole)

    def collect(self, values: np.ndarray, facet: np.ndarray) -> np.ndarray:
        """Sum values (p, g, corners) of points on slave facets to the corners, (n,), or values
        (p, g, corners, d), (n, d)."""
        sums = values.sum(axis=1)
        rows = self.rows[facet].ravel()
        flat = sums.reshape(len(rows), prod(sums.shape[2:]))  # also of no points
        return add_up(flat, rows, self.n).reshape(self.n, *sums.shape[2:])

    def _integral(self, values: np.ndarray) -> np.ndarray:
        """The same of points on the pieces of all processes."""
        return self.shared.sum(self.collect(values, self.pieces.facet))

    def nodes_of(self, pieces: Pieces) -> np.ndarray:
        """Nodes of the slave's and the master's facets, (p, k)."""
        theirs = self.master.cells[pieces.other] + len(self.slave.nodes)
        return np.concatenate([self.slave.cells[pieces.facet], theirs], axis=1)

    def depths(self, pieces: Pieces) -> np.ndarray:
        """n . (x_s - x_m) at the points, (p, g) in m."""
        if pieces.aligned:
            return -pieces.distance
        return (pieces.both @ self.places[self.nodes_of(pieces)] * pieces.unit).sum(axis=2)

    def deepest(self, pieces: Pieces) -> np.ndarray:
        """The largest of these of each, (p,); 0 where what lies flush overlaps by round-off."""
        whole = self.slave.sizes[pieces.facet] ** (self.slave.dim - 1)
        wide = pieces.weight.sum(axis=1) > SAME * whole
        return np.where(wide, self.depths(pieces).max(axis=1), 0.0)

    def stand(self, stance: Stance) -> None:
        """Let the slave's facets stand so on the master's from the next update on."""
        if not stance.same(self.stance):
            self.stance, self._seen = stance, (np.nan, 0.0)

    def update(self, places: np.ndarray, way: float) -> None:
        """Take up new places (N, d) of the nodes, whose longest ``way`` [m] to each other in the
        step tells how far partners are sought."""
        if (way, self.sunk) == self._seen and np.array_equal(places, self.places):  # at rest
            return
        self._seen, self.admits.way = (way, self.sunk), way + self.sunk
        reach, self.reach = (
            FACETS * s + 4 * way + self.apart for s in (self.slave.sizes, self._sizes)
        )
        self.places = places
        xs, xm = places[: len(self.slave.nodes)], places[len(self.slave.nodes) :]
        pieces, brink = self.shared.together(
            lambda: self._common.meet((xs, xm), reach, self.stance)
        )
        here = self.shared.facet_here
        self.pieces = pieces = pieces.only(here[pieces.facet])
        self.brink = brink.only(here) if brink else None
        corners = self.rows[pieces.facet]
        self.nodes = self.nodes_of(pieces)

        area = self._integral(pieces.corner * pieces.weight[..., None] @ self.lending[pieces.facet])
        self.paired = area > COVERED * self.full_area
        self.area = np.where(self.paired, area, 0.0)
        self.share = share = 1 / np.where(self.paired, area, np.inf)
        dual = self._dual(pieces) @ self.lending[pieces.facet] * pieces.weight[..., None]
        self.shares = dual * share[corners][:, None]
        self._mean()
        self._turn_normals(xs)
        gap = self._integral(self.shares * self.depths(pieces)[..., None])
        self.gap = np.where(self.paired, gap / self.length, -self.reach)
        self._operate()

    def _mean(self) -> None:
        rows, columns = self.rows[self.pieces.facet][:, :, None], self.nodes[:, None]
        self._each = np.swapaxes(self.shares, 1, 2) @ self.pieces.both  # (p, corners, k)
        own = gather(self._each, rows, columns, (self.n, self.total), self.dense)
        self.means: Matrix = self.shared.rows(own)
        self.idle = np.zeros((self.n, self.slave.dim), dtype=bool)
        if self.still.any():
            seen = self.means, self.places, self._sizes, len(self.slave.nodes)
            own = idle(self.still, self._along, *seen)
            self.idle = self.shared.sum(own.astype(float)) > 0

    def _operate(self) -> None:
        pieces, d = self.pieces, self.slave.dim
        rows, columns = self.rows[pieces.facet][:, :, None], self.nodes[:, None]
        own = gather(
            self._each[..., None] * (pieces.unit / self.length[rows])[:, :, None],
            rows[..., None],
            columns[..., None] * d + np.arange(d),
            (self.n, self.total * d),
            self.dense,
        )
        self.rises: Matrix = self.shared.rows(own)
        each = by_component(self.means, d)
        jump = each + self.at_normals(self.rises - along(self.normal, each))
        self.operator: Matrix = without(jump, self.idle)

    def jumps(self, velocities: np.ndarray) -> np.ndarray:
        """J v of all nodes, flat."""
        return self.shared.sum(self.operator @ velocities.ravel())

    def evened(self, values: np.ndarray) -> np.ndarray:
        """Forces and areas of nodes, (n, k), as shares of those that act at one place: of a facet
        that is covered in part the node beyond the edge acts by it, where the next one does."""
        side, add = self.slave, self.shared.sum
        at_nodes = side.from_corners(side.at_corners(add(self.means.T @ values)))
        shares = add(self.means[:, : len(at_nodes)] @ at_nodes)
        return np.where(self.area[:, None] > 0, shares, values)

    def fixed(self) -> np.ndarray:
        """Nodes whose gaps nothing but held components of both sides' nodes changes, (n,) of
        bool."""
        if not self.held.any():
            return np.zeros(self.n, dtype=bool)
        free = self.shared.sum(abs(self.means) @ ~self.held)
        return np.asarray(((free <= ROUND_OFF) | ~self._along).all(axis=1))

    def at_normals(self, matrix: Matrix) -> Matrix:
        """Rows (n,) as components along the normals, (n d,)."""
        return by_point(self.normal[:, :, None], matrix)

    @property
    def alone(self) -> np.ndarray:
        return ~self.paired & (self.full_area > 0)

    def run_over(self) -> np.ndarray:
        """Held nodes for which others bear on facets of which points are inside by more than half
        their size, (n,) of bool: supports go through each other."""
        lends = ~self.lending.diagonal(axis1=1, axis2=2).all(axis=1)
        deep = np.zeros(self.n, dtype=bool)
        if lends.any():
            mine = self.pieces.only(lends[self.pieces.facet])
            facet = mine.facet[2 * self.depths(mine).max(axis=1) > self.slave.sizes[mine.facet]]
            deep[self.slave.corners[facet]] = True
            deep = self.shared.sum(deep.astype(float)) > 0
        return deep & (self.full_area == 0)

    @property
    def near(self) -> np.ndarray:
        """Nodes that may close in the step: those with a partner that is not far, (n,)."""
        return self.paired & (self.gap > -0.5 * (self.reach + self.apart))

    def _dual(self, pieces: Pieces) -> np.ndarray:
        """The functions psi_i dual to phi_j on the paired part of each facet, at the points: there
        int psi_i phi_j = delta_ij int phi_j. phi_i itself where that part is too small to tell."""
        m, k = self.slave.corners.shape
        phi = pieces.corner
        products = np.swapaxes(phi * pieces.weight[..., None], 1, 2) @ phi
        mass = add_up(products.reshape(-1, k * k), pieces.facet, m).reshape(m, k, k)
        self.lumped = lumped = mass.sum(axis=2)
        scale = np.where(lumped > 0, lumped, 1.0) ** -0.5
        lowest, highest = extremes(mass * scale[:, :, None] * scale[:, None, :])
        good = ILL * lowest > highest
        self.inverse_mass = np.zeros_like(mass)
        self.inverse_mass[good] = inverted(mass[good])
        self.dual = self.inverse_mass * lumped[:, None]  # psi = phi @ dual
        self.dual[~good] = np.eye(k)
        return phi @ self.dual[pieces.facet]

    def _turn_normals(self, xs: np.ndarray) -> None:
        units = self.shares[..., None] * self.pieces.unit[:, :, None]
        mean = self._integral(units) * ~self.idle
        length = np.linalg.norm(mean, axis=1)
        self.paired &= length > 0
        alone = ~self.paired
        if alone.any():  # by all of the facets
            normal = self.slave.normals(xs, self._rule.facet, self.rule_slopes)
            normal = normal.reshape(*self.mean_weight.shape[:2], 1, -1)
            each = (self.mean_weight[..., None] * normal).sum(axis=1)  # (m, corners, d)
            whole = add_up(each.reshape(-1, each.shape[2]), self.slave.corners.ravel(), self.n)
            mean[alone] = normalised(whole[alone])
        self.length = np.where(self.paired, length, 1.0)
        self.normal = mean / self.length[:, None]
