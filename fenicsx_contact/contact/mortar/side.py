# SPDX-License-Identifier: LGPL-3.0-or-later
"""One side of a pair: the facets of a solid's boundary with the shape functions of its trace."""

from __future__ import annotations

from copy import copy
from functools import cached_property
from typing import Any

import basix
import numpy as np
from scipy.spatial import cKDTree

from ...base.cells import degree_of, lagrange
from ...base.checks import StepFailed
from ...base.vectors import cross
from ...solids import DeformableSolid, Solid, Trace
from ...solids.rotations import cross_matrix

#: The corners of a facet in the order of its outline.
OUTLINE = {"triangle": [0, 1, 2], "quadrilateral": [0, 1, 3, 2]}
#: And the local coordinates of its middle.
MIDDLES = {"interval": [0.5], "triangle": [1 / 3, 1 / 3], "quadrilateral": [0.5, 0.5]}
EVERY = slice(None)
#: Rotation by -90 degrees: from the tangent of a line to its normal.
TURN = np.array([[0.0, 1.0], [-1.0, 0.0]])


def unit_and_length(normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals and the lengths of normals (n, d) of facets.

    Raises:
        StepFailed: one has none.
    """
    length = np.sqrt((normals**2).sum(axis=1))
    if not (np.isfinite(length) & (length > 0)).all():
        raise StepFailed("facets of a contact collapse, or are nowhere")
    return normals / length[:, None], length


class Side:
    """Facets of a boundary, whole on every process.

    Args:
        points: corners of the facets, (n, d) in m.
        cells: facets, (m, corners) indices of points.
        cell: "interval", "triangle" or "quadrilateral".
        inside: for each facet, in any order, its midpoint and a point of the solid behind it,
            (m, 2, d): they tell which way is out.
        degree: of the displacement, 1 or 2.
        places: of the nodes of each facet, (m, k, d), where these are curved.
        revolution: whether a place at x stands for 2 pi x of the solid.
        facets: their name.

    Attributes:
        nodes: reference coordinates of the nodes of the trace, (N, d); the first n are ``points``.
        cells: nodes of each facet, (m, k), in basix's order.
        corners: corners of each facet, (m, corners).
        middle_slopes: derivatives of the shape functions at the middle, (d - 1, k).
        sizes, size: about the diameters of the facets, (m,), and the largest, m.
        straight: whether the facets are and stay so, with constant slopes.
        sign: +1 where the parametrisation of a facet makes its normal point outwards, else -1.
    """

    def __init__(
        self,
        points: np.ndarray,
        cells: np.ndarray,
        cell: str,
        inside: np.ndarray,
        degree: int = 1,
        places: np.ndarray | None = None,
        revolution: bool = False,
        facets: str = "",
    ) -> None:
        self.facets = facets
        self.dim, self.cell, self.degree = points.shape[1], cell, degree
        self._revolution = revolution
        self.straight = degree == 1 and cell != "quadrilateral"
        self.corners = cells
        self._linear, self.element = lagrange(cell, 1), lagrange(cell, degree)
        if degree == 1:
            self.nodes, self.cells = points, cells
        else:
            places = points[cells] if places is None else places
            shape = lagrange(cell, degree_of(cell, places.shape[1]))
            at = _tabulate(shape, 0, self.element.points)[0] @ places
            self.nodes, self.cells = _number(points, at)
        self.midpoint = np.array(MIDDLES[cell])
        self.middle_slopes = self.shape(self.midpoint[None])[1][:, 0]
        self.sizes = self._diameters(points)
        self.size = float(self.sizes.max())
        _, nearest = cKDTree(inside[:, 0]).query(points[cells].mean(axis=1))
        self.sign = np.ones(len(cells))
        middle = np.tile(self.midpoint, (len(cells), 1))
        normal = self.normals(self.nodes, np.arange(len(cells)), self.shape(middle)[1])
        self._measures = np.linalg.norm(normal, axis=1)  # at the middles
        outwards = points[cells].mean(axis=1) - inside[nearest, 1]
        self.sign = np.where(np.einsum("ij,ij->i", normal, outwards) < 0, -1.0, 1.0)

    def trace(self, solid: Solid) -> Trace:
        """The solid seen from the nodes."""
        if isinstance(solid, DeformableSolid):
            return solid.trace(self.nodes, facets=self.facets)
        return solid.trace(self.nodes)

    @property
    def flat(self) -> Side:
        """The same with the facets that its corners span, of the same nodes."""
        if self.degree == 1:
            return self
        flat = copy(self)
        flat.degree, flat.element, flat.cells = 1, self._linear, self.corners
        flat.straight = self.cell != "quadrilateral"
        flat.middle_slopes = flat.shape(flat.midpoint[None])[1][:, 0]
        return flat

    def _diameters(self, points: np.ndarray) -> np.ndarray:
        corners = points[self.corners]
        return np.linalg.norm(corners - corners.mean(axis=1, keepdims=True), axis=2).max(axis=1) * 2

    def shape(self, xi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Shape functions at local coordinates (q, d - 1): values (q, k) and derivatives
        (d - 1, q, k)."""
        table = _tabulate(self.element, 1, xi)
        return table[0], table[1:]

    def linear_shape(self, xi: np.ndarray) -> np.ndarray:
        """Shape functions of the corners at local coordinates, (q, corners)."""
        return _tabulate(self._linear, 0, xi)[0]

    def linear_slopes(self, xi: np.ndarray) -> np.ndarray:
        """Their derivatives, (d - 1, q, corners)."""
        return _tabulate(self._linear, 1, xi)[1:]

    def reference_measure(self, facet: np.ndarray, slopes: np.ndarray) -> np.ndarray:
        """Surface element of the reference placement at points of the facets, (q,), from the
        derivatives of the shape functions."""
        if self.straight:
            return self._measures[facet]
        return np.linalg.norm(self.normals(self.nodes, facet, slopes), axis=1)

    def breadth(self, facet: np.ndarray, values: np.ndarray) -> np.ndarray | float:
        """Of how much of the solid these points of the facets stand for, m or 1, from the shape
        functions there (q, k)."""
        if not self._revolution:
            return 1.0
        return 2 * np.pi * (values * self.nodes[self.cells[facet], 0]).sum(axis=1)

    def tangents(self, nodes: np.ndarray, facets: np.ndarray, slopes: np.ndarray) -> np.ndarray:
        """Covariant tangents at points of the facets, (d - 1, q, d), from the places of the nodes
        and the derivatives of the shape functions."""
        return np.einsum("tqk,qkj->tqj", slopes, nodes[self.cells[facets]])

    def middle_tangents(self, nodes: np.ndarray, facets: np.ndarray | slice = EVERY) -> np.ndarray:
        """Those at the middles of facets, (d - 1, q, d)."""
        return np.einsum("tk,qkj->tqj", self.middle_slopes, nodes[self.cells[facets]])

    def middle_normals(self, nodes: np.ndarray, facets: np.ndarray | slice = EVERY) -> np.ndarray:
        """Normals there, as :meth:`normals` has them, (q, d)."""
        return self.normal(self.middle_tangents(nodes, facets), facets)

    def normals(self, nodes: np.ndarray, facets: np.ndarray, slopes: np.ndarray) -> np.ndarray:
        """Outward normals, not of unit length but of the length of the surface element, (q, d)."""
        return self.normal(self.tangents(nodes, facets, slopes), facets)

    def normal(self, g: np.ndarray, facets: np.ndarray | slice) -> np.ndarray:
        """The same from the tangents g (d - 1, q, d) at the points."""
        normal = g[0] @ TURN.T if self.dim == 2 else cross(g[0], g[1])
        return normal * self.sign[facets, None]

    def normal_rates(self, nodes: np.ndarray, facets: np.ndarray, slopes: np.ndarray) -> np.ndarray:
        """Derivatives of :meth:`normals` by the places of the facet's nodes, (q, k, d, d)."""
        if self.dim == 2:
            return np.einsum("q,qk,ij->qkij", self.sign[facets], slopes[0], TURN)
        crosses = cross_matrix(self.tangents(nodes, facets, slopes))
        rates = np.einsum("qk,qij->qkij", slopes[1], crosses[0])
        rates -= np.einsum("qk,qij->qkij", slopes[0], crosses[1])
        return rates * self.sign[facets, None, None, None]

    def at_corners(self, forces: np.ndarray) -> np.ndarray:
        """Forces on the nodes (N, k), and others after these, as forces on the corners (n, k), as
        linear functions have them: the sum and, of straight facets, the moment are the same."""
        corners, shares = self._between
        result = np.zeros((int(self.corners.max()) + 1, forces.shape[1]))
        np.add.at(result, corners, shares[..., None] * forces[: len(corners), None])
        return result

    def from_corners(self, values: np.ndarray) -> np.ndarray:
        """Values at the corners (n, k) as linear functions have them at all nodes, (N, k)."""
        corners, shares = self._between
        return np.einsum("nc,nck->nk", shares, values[corners])

    @cached_property
    def _between(self) -> tuple[np.ndarray, np.ndarray]:
        """Corners of a facet of each node, (N, corners), and the linear functions of these there,
        likewise."""
        _, first = np.unique(self.cells, return_index=True)
        facet, place = np.unravel_index(first, self.cells.shape)
        return self.corners[facet], self.linear_shape(self.element.points)[place]

    def holds(self, xi: np.ndarray, tolerance: float) -> np.ndarray:
        """Whether local coordinates (q, d - 1) are those of a point of a facet."""
        inside = (xi >= -tolerance).all(axis=1)
        if self.cell == "triangle":
            return inside & (xi.sum(axis=1) <= 1 + tolerance)
        return inside & (xi <= 1 + tolerance).all(axis=1)


def _tabulate(element: basix.finite_element.FiniteElement, order: int, xi: np.ndarray) -> Any:
    """Derivatives up to an order at points (q, d - 1), (derivatives, q, k); basix of Debian 12
    aborts if there are no points, as where two solids are far apart."""
    q = len(xi)
    if element.dim == 2:  # linear on a line, asked for most often
        return np.stack([np.hstack([1 - xi, xi]), np.tile([-1.0, 1.0], (q, 1))])[: order + 1]
    return element.tabulate(order, xi if q else np.zeros((1, xi.shape[1])))[:, :q, :, 0]


def _number(points: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Number the nodes at places (m, k, d), coinciding ones once, ``points`` first."""
    flat = at.reshape(-1, points.shape[1])
    reach = 1e-8 * np.ptp(points, axis=0).max()
    every = np.concatenate([points, flat])
    first = np.arange(len(every))
    for a, b in cKDTree(every).query_pairs(reach, output_type="ndarray"):
        first[max(a, b)] = min(first[max(a, b)], first[min(a, b)])
    first = first[first]
    kept, number = np.unique(first, return_inverse=True)
    return every[kept], number[len(points) :].reshape(at.shape[:2])
