# SPDX-License-Identifier: LGPL-3.0-or-later
"""The contact surface as a mesh of its own.

All contact terms see the solids only through the velocity jump at the points of the surface. So
the facets in contact become a mesh of their own (whole on every process), the jump ``w``, the
multiplier ``lam`` and the semi-multiplier ``Lam`` are P1 fields on it, or P2 fields where a solid
of second degree in the plane meets an obstacle, and the weak form is integrated there, by the
values at the nodes: by the trapezoidal rule, or by Simpson's, which shares an even pressure out as
quadratic displacements do.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from ..base import compat
from ..base.cells import degree_of
from ..base.glued import glued_space


class Surface:
    """A contact surface: points (n, d) in metres, cells, nodal integration.

    Args:
        points: nodes of the cells, (n, d) in m.
        cells: their indices, (m, k), corners first; of curved cells all nodes of second degree.
        cell: "interval", "triangle" or "quadrilateral".
        degree: of its fields; of second degree, on intervals only, middles of cells are nodes too.
        twins: of a solid that repeats itself: which of some sites (s, d) stands for each, (s,). All
            for which the same one stands are one node, which has the areas of them all.
        breadth: of how much of the solid a place stands for, from its coordinates in UFL.

    Attributes:
        points: reference coordinates of the nodes, (n, d), in the order of all arrays here.
        cell_nodes: nodes of each cell, (m, k), corners first.
        sites, site_nodes, cell_sites: as it is drawn: places, (s, d), the node of each, (s,), and
            those of each cell, (m, k).
        site_area: share of the surface that belongs to each site, (s,).
        area: share of the surface that belongs to each node, (n,), in m (2D) or m² (3D).
        nodal_area: the same by the rule of integration, which of curved cells sees their corners
            only where fields are of first degree.
        places: of the nodes of each cell, (m, k, d).
        dim: dimension of space, d.
        extent: of the points along the axis along which it is largest, m.
        slides: whether its points stand for what slides past them, none for an area of its own.
    """

    slides = False

    def __init__(
        self,
        points: np.ndarray,
        cells: np.ndarray,
        cell: str,
        degree: int = 1,
        twins: Callable[[np.ndarray], np.ndarray] | None = None,
        breadth: Callable[[Any], Any] | None = None,
    ) -> None:
        self.dim, self._degree = points.shape[1], degree
        shape = degree_of(cell, cells.shape[1])
        self.mesh = compat.create_mesh(MPI.COMM_SELF, cells, points, cell, shape)
        self.places = self.mesh.geometry.x[compat.cell_geometry(self.mesh), : self.dim]
        every = compat.lagrange_space(self.mesh, degree)
        self.cell_sites = compat.cell_dofs(every)
        self.sites = every.tabulate_dof_coordinates()[:, : self.dim].copy()
        self.extent = float(np.ptp(self.sites, axis=0).max())
        self.dx = compat.nodal_measure(self.mesh, degree)
        test, exact = ufl.TestFunction(every), ufl.dx(self.mesh)
        rules: list[Callable[[Any], Any]] = [lambda v: v * self.dx]
        if breadth:
            wide = breadth(ufl.SpatialCoordinate(self.mesh))
            rules.append(lambda v: wide * v * exact)
        elif degree < shape:
            rules.append(lambda v: v * exact)
        site_areas = [compat.VectorAssembler(rule(test))().copy() for rule in rules]
        self.site_area, self._area_by = site_areas[-1], rules[-1]
        self._twins = twins(self.sites) if twins else np.arange(len(self.sites))
        self.scalars = glued_space(every, self._twins)
        vectors = compat.lagrange_space(self.mesh, degree, shape=(self.dim,))
        self.vectors = glued_space(vectors, self._twins)
        self.cell_nodes = compat.cell_dofs(self.scalars)
        self.site_nodes = np.empty(len(self.sites), dtype=np.int64)
        self.site_nodes[self.cell_sites.ravel()] = self.cell_nodes.ravel()
        self.points = self.sites[self._twins == np.arange(len(self.sites))]
        areas = [np.bincount(self.site_nodes, each) for each in site_areas]
        self.nodal_area, self.area = areas[0], areas[-1]

    @property
    def size(self) -> int:
        """Number of nodes."""
        return len(self.points)

    def scalar(self) -> Any:
        """A new scalar coefficient."""
        return fem.Function(self.scalars)

    def vector(self) -> Any:
        """A new vector coefficient; its array is (n, d) in the order of ``points``."""
        return fem.Function(self.vectors)

    def components(self, count: int) -> Any:
        """A mixed space of ``count`` scalar fields."""
        space = compat.component_space(self.mesh, count, self._degree)
        if self.size == len(self.sites):
            return space
        onto, dofs = np.arange(count * len(self.sites)), np.empty(len(self.sites), dtype=np.int64)
        for component in range(count):
            dofs[self.cell_sites.ravel()] = compat.cell_dofs(space.sub(component)).ravel()
            onto[dofs] = dofs[self._twins]
        return glued_space(space, onto)

    def constant(self, value: float = 0.0) -> Any:
        """A new constant."""
        return fem.Constant(self.mesh, float(value))

    def shares(self) -> np.ndarray:
        """What each cell adds to the areas of its nodes, (m, k), in m or m²."""
        apart = compat.cellwise_space(self.mesh, degree=self._degree)
        shares = compat.VectorAssembler(self._area_by(ufl.TestFunction(apart)))()
        return np.asarray(shares[compat.cell_dofs(apart)])

    def nodes_at(self, points: np.ndarray, tolerance: float) -> np.ndarray:
        """For each of ``points`` (k, d) the nearest node, or -1 where none is within reach."""
        distance = np.linalg.norm(self.sites[None, :, :] - points[:, None, :], axis=2)
        nearest = self.site_nodes[distance.argmin(axis=1)]
        nearest[~(distance.min(axis=1) <= tolerance)] = -1  # NaN is not within reach
        return nearest
