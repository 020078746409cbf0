# SPDX-License-Identifier: LGPL-3.0-or-later
"""The operator of a pair: nodal velocity jumps, gaps and normals on the slave surface.

The jump at node i of the slave is a mean weighted by the function psi_i that is dual to its P1
shape functions phi_j (int psi_i phi_j = delta_ij a_i on each facet; Wohlmuth 2000),

    w_i = 1/a_i  int psi_i (v_slave - v_master o pi)        a_i = int phi_i,

over the part of the surface that has a partner; gaps likewise. With these nodal values the weak
form (7) needs no change: integrated by the values at the nodes with weights a_i, it is the mortar
form  int lam_h n . [[v*]]  with lam_h = sum lam_i psi_i. On a P1 slave lam_i a_i is the force on
node i: signs are read node by node. (With phi_i in place of psi_i, lam_i oscillates at the edge of
the contact, and Newton's method lets go of one node an iteration.) Forces go to the solids by the
transpose, so they balance exactly, and a constant pressure is transmitted as such (patch test).
"""

from __future__ import annotations

from math import prod

import numpy as np

from ...base.checks import StepFailed
from .integration import Cuts, Points, whole
from .matrices import DENSE, Matrix, add_up, gather
from .partners import Partners
from .side import Side

#: Partners are sought within so many facets, and four times the way of the step.
FACETS = 3.0
#: A node with less than this share of its area paired has no partner.
COVERED = 1e-4
#: Facets whose paired part makes the mass matrix worse than this have no dual functions.
ILL = 1e3


class Pairing:
    """Slave and master surface in the places where they are.

    Arrays of positions and velocities are (N, d), the slave's nodes before the master's.

    Args:
        slave, master: the sides.

    Attributes:
        operator: J of one component, (n, N).
        dense: whether it and its derivatives are small enough for dense matrices.
        gap: weighted d_n, positive: penetration, (n,) in m; -reach where there is no partner.
        normal: outward unit normals of the slave at its corners, (n, d).
        area: paired share of the surface of each node, (n,).
        paired: nodes that have a partner.
        reach: how far from each node partners were sought, (n,) in m.
    """

    def __init__(self, slave: Side, master: Side) -> None:
        self.slave, self.master = slave, master
        self.n = int(slave.corners.max()) + 1
        self.total = len(slave.nodes) + len(master.nodes)
        self.dense = (self.total * slave.dim) ** 2 <= DENSE
        self._sizes = np.zeros(self.n)  # of the largest facet at each node
        np.maximum.at(self._sizes, slave.corners, slave.sizes[:, None])
        self._partners = Partners(slave, master)
        self._cuts = Cuts(slave, master) if slave.dim == 2 else None
        self._rule = whole(slave)
        self._rule_shapes = self._shapes(self._rule.xi)
        self._rule_weight = self._weight(self._rule, self._rule_shapes[1])
        phi = self._rule_shapes[2] * self._rule_weight[:, None]
        self.full_area = self.collect(phi, self._rule.facet)

    def _shapes(self, xi: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        values, slopes = self.slave.shape(xi)
        linear = values if self.slave.degree == 1 else self.slave.linear_shape(xi)
        return values, slopes, linear

    def _weight(self, points: Points, slopes: np.ndarray) -> np.ndarray:
        return points.weight * self.slave.reference_measure(points.facet, slopes)

    def collect(self, values: np.ndarray, facet: np.ndarray) -> np.ndarray:
        """Sum values (q, corners, ...) of points on slave facets to the corners, (n, ...)."""
        rows = self.slave.corners[facet].ravel()
        flat = values.reshape(len(rows), prod(values.shape[2:]))  # also of no points
        return add_up(flat, rows, self.n).reshape(self.n, *values.shape[2:])

    def update(self, places: np.ndarray, way: float) -> None:
        """Take up new places (N, d) of the nodes, whose longest ``way`` [m] in the step tells how
        far partners are sought."""
        reach = FACETS * self.slave.sizes + 4 * way
        self.reach = FACETS * self._sizes + 4 * way
        slave, master = self.slave, self.master
        xs, xm = places[: len(slave.nodes)], places[len(slave.nodes) :]
        if self._cuts:
            points = self._cuts.points(xs, xm)
            shapes = self._shapes(points.xi)
            weight = self._weight(points, shapes[1])
        else:
            points, shapes, weight = self._rule, self._rule_shapes, self._rule_weight
        values, slopes, phi = shapes
        x = np.einsum("qk,qkj->qj", values, xs[slave.cells[points.facet]])
        normal = slave.normals(xs, points.facet, slopes)
        length = np.sqrt((normal**2).sum(axis=1))
        if not (np.isfinite(length) & (length > 0)).all():
            raise StepFailed("facets of a contact collapse, or are nowhere")
        unit = normal / length[:, None]
        hits = self._partners.meet(x, unit, points.facet, reach, (xs, xm))

        on = hits.ray
        self.facet, self.phi, weight = points.facet[on], phi[on], weight[on]
        self.values, self.slopes = values[on], slopes[:, on]
        self.unit, self.length = unit[on], length[on]
        self.distance, self.inverse = hits.distance, hits.inverse
        self.their_values, self.their_slopes = master.shape(hits.xi)
        self.nodes = np.concatenate(
            [slave.cells[self.facet], master.cells[hits.facet] + len(slave.nodes)], axis=1
        )
        self.places = places

        weighted = self.phi * weight[:, None]
        area = self.collect(weighted, self.facet)
        self.paired = area > COVERED * self.full_area
        self.area = np.where(self.paired, area, 0.0)
        share = 1 / np.where(self.paired, area, np.inf)
        dual = self._dual(self.phi, weight) * weight[:, None]
        self.shares = dual * share[slave.corners[self.facet]]  # psi_i w / a_i at the points
        gap = self.collect(self.shares * -self.distance[:, None], self.facet)
        self.gap = np.where(self.paired, gap, -self.reach)
        both = np.concatenate([self.values, -self.their_values], axis=1)
        self.operator: Matrix = gather(
            self.shares[:, :, None] * both[:, None, :],
            slave.corners[self.facet][:, :, None],
            self.nodes[:, None],
            (self.n, self.total),
            self.dense,
        )
        self._turn_normals(xs)

    @property
    def near(self) -> np.ndarray:
        """Nodes that may close in the step: those with a partner that is not far, (n,)."""
        return self.paired & (self.gap > -0.5 * self.reach)

    def _dual(self, phi: np.ndarray, weight: np.ndarray) -> np.ndarray:
        """The functions psi_i dual to phi_j on the paired part of each facet, at the points: there
        int psi_i phi_j = delta_ij int phi_j. phi_i itself where that part is too small to tell."""
        m, k = self.slave.corners.shape
        products = (weight[:, None, None] * phi[:, :, None] * phi[:, None, :]).reshape(-1, k * k)
        mass = add_up(products, self.facet, m).reshape(m, k, k)
        lumped = mass.sum(axis=2)
        scale = np.where(lumped > 0, lumped, 1.0) ** -0.5
        eigenvalues = np.linalg.eigvalsh(mass * scale[:, :, None] * scale[:, None, :])
        good = ILL * eigenvalues[:, 0] > eigenvalues[:, -1]
        turn = np.tile(np.eye(k), (m, 1, 1))
        turn[good] = lumped[good, :, None] * np.linalg.inv(mass[good])
        return np.einsum("qij,qj->qi", turn[self.facet], phi)

    def _turn_normals(self, xs: np.ndarray) -> None:
        """Normals at the corners: means of the facets' normals."""
        _, slopes, phi = self._rule_shapes
        normal = self.slave.normals(xs, self._rule.facet, slopes)
        self.mean_weight = phi * self._rule.weight[:, None]
        mean = self.collect(self.mean_weight[:, :, None] * normal[:, None], self._rule.facet)
        self.mean_length = np.linalg.norm(mean, axis=1)
        self.normal = mean / self.mean_length[:, None]

    @property
    def rule_facets(self) -> np.ndarray:
        """Facets of the points at which the normals are averaged."""
        return self._rule.facet

    @property
    def rule_slopes(self) -> np.ndarray:
        """Slopes of the slave's shape functions there."""
        return self._rule_shapes[1]
