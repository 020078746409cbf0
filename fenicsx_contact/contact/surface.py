# SPDX-License-Identifier: LGPL-3.0-or-later
"""The contact surface as a mesh of its own, and the fields that live on it.

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
from ..base.vectors import across, beside, cross, dot
from ..theory.friction import FrictionBound
from .law_fields import LawFields


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
    """

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
        shares = [test * self.dx]
        if breadth:
            shares.append(breadth(ufl.SpatialCoordinate(self.mesh)) * test * exact)
        elif degree < shape:
            shares.append(test * exact)
        site_areas = [compat.VectorAssembler(each)().copy() for each in shares]
        self.site_area = site_areas[-1]
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

    def nodes_at(self, points: np.ndarray, tolerance: float) -> np.ndarray:
        """For each of ``points`` (k, d) the nearest node, or -1 where none is within reach."""
        distance = np.linalg.norm(self.sites[None, :, :] - points[:, None, :], axis=2)
        nearest = self.site_nodes[distance.argmin(axis=1)]
        nearest[~(distance.min(axis=1) <= tolerance)] = -1  # NaN is not within reach
        return nearest


class SurfaceFields(LawFields):
    """What a formulation may use to write its weak form: unknowns, tests, data, parameters.

    They fulfil :class:`~fenicsx_contact.theory.weak_form.ContactFields`. A frictionless contact has
    no ``traction``, springs have no ``multiplier``: they are ``None``, and the mixed space does not
    hold them.

    Attributes:
        unknowns: w, lam and tau in one mixed function.
        mean_share, force_rate, start_gap, elongation: what only springs read: the share of forces
            that the scheme takes in the mean, the derivative [s] of the place where it takes them,
            the gap at the start [m], the stretch of tangential springs [m].
        dofs: for each component of (w, lam, tau), the dof of each node, (components, n).

    Args:
        surface: where they live.
        friction: the law of friction, None if there is none.
        multipliers: whether there are any.
        weight: shares of their areas that the points weigh, None for 1.
    """

    def __init__(
        self,
        surface: Surface,
        friction: FrictionBound | None,
        multipliers: bool,
        weight: np.ndarray | None,
    ) -> None:
        super().__init__(surface)
        self.friction = friction
        d = surface.dim
        n_mult = int(multipliers)
        n_traction = (d - 1) * int(multipliers and friction is not None)
        self.components = d + n_mult + n_traction

        space = surface.components(self.components)
        self.unknowns = fem.Function(space)
        z, test = ufl.split(self.unknowns), ufl.split(ufl.TestFunction(space))
        self.velocity_jump: Any
        self.test_jump: Any
        self.multiplier: Any
        self.test_multiplier: Any
        self.traction: Any
        self.test_traction: Any
        self.velocity_jump, self.test_jump = (ufl.as_vector(f[:d]) for f in (z, test))
        self.multiplier, self.test_multiplier = (f[d] if multipliers else None for f in (z, test))
        self.traction, self.test_traction = (
            ufl.as_vector(f[d + 1 :]) if n_traction else None for f in (z, test)
        )
        self.dofs = np.empty((self.components, surface.size), dtype=np.int64)
        for component in range(self.components):
            dofs = compat.cell_dofs(space.sub(component))
            self.dofs[component, surface.cell_nodes.ravel()] = dofs.ravel()

        self.normal = surface.vector()
        self.gap, self.closed = surface.scalar(), surface.scalar()
        self.start_jump_n, self.start_slip = surface.scalar(), surface.vector()
        self.rho_n, self.rho_t = surface.scalar(), surface.scalar()
        for rho in (self.rho_n, self.rho_t):
            rho.x.array[:] = 1.0
        self.gap_rate, self.dt = surface.constant(1.0), surface.constant(1.0)
        self.limit_rate, self.horizon = surface.constant(), surface.constant(1.0)
        if not multipliers:
            self.start_gap, self.elongation = surface.scalar(), surface.vector()
            self.mean_share, self.force_rate = surface.constant(), surface.constant(1.0)
        if n_traction:
            self.frozen, self.known_pressure = surface.constant(), surface.scalar()
        self._tangent = surface.vector() if d == 3 and friction is not None else None
        self._framed = False
        self._weight = surface.scalar() if weight is not None else None
        if self._weight is not None:
            self._weight.x.array[:] = weight

    def constant(self, value: float) -> Any:
        """A new constant."""
        return self.surface.constant(value)

    def integral(self, f: Any) -> ufl.Form:
        """The integral of f over the surface, or its sum over the chosen points."""
        if self._weight is not None:
            f = f * self._weight
        return f * self.surface.dx

    @property
    def jump_n(self) -> Any:
        """w_n = w . n."""
        return ufl.dot(self.velocity_jump, self.normal)

    @property
    def test_jump_n(self) -> Any:
        """w*_n."""
        return ufl.dot(self.test_jump, self.normal)

    @property
    def jump_t(self) -> Any:
        """The tangential components of w, a vector of d - 1."""
        return self.tangential(self.velocity_jump)

    @property
    def test_jump_t(self) -> Any:
        """The tangential components of w*."""
        return self.tangential(self.test_jump)

    def tangential(self, v: Any) -> Any:
        """Components of v along the tangents of the surface."""
        n = self.normal
        if self.surface.dim == 2:
            tangents = [ufl.as_vector((-n[1], n[0]))]
        else:
            # orthogonal to n also where n is varied
            first = self._tangent - ufl.dot(self._tangent, n) * n
            first /= ufl.sqrt(ufl.dot(first, first))
            tangents = [first, ufl.cross(n, first)]
        return ufl.as_vector([ufl.dot(v, t) for t in tangents])

    def set_weight(self, weight: np.ndarray) -> None:
        """What the points weigh, as shares of their areas."""
        assert self._weight is not None, "made for weights that are the areas"
        self._weight.x.array[:] = weight

    def set_start_slip(self, jump: np.ndarray, normal: np.ndarray, resolved: float) -> None:
        """Tell friction the jumps (n, d) [m/s] before the step; no slips below what is resolved."""
        if self.friction is not None:
            along = jump - dot(jump, normal)[:, None] * normal
            slips = dot(along, along)[:, None] > resolved**2
            self.start_slip.x.array[:] = np.where(slips, jump, 0.0).ravel()

    def set_normal(self, normal: np.ndarray) -> None:
        """Set the normals (n, d); a first tangent, where friction needs one, stays as it was."""
        self.normal.x.array[:] = normal.ravel()
        if self._tangent is not None and not self._framed:
            self.begin_frame(normal, np.ones(len(normal), dtype=bool))

    def begin_frame(self, normal: np.ndarray, where: np.ndarray) -> None:
        """Choose the first tangents anew at some points, (n,) of bool."""
        if self._tangent is not None:
            self.set_tangent(np.where(where[:, None], across(normal), self.tangent))

    def set_tangent(self, tangent: np.ndarray) -> None:
        """Set the first tangents (n, 3); frames turn about them as little as they can, so that the
        components of tau keep their meaning."""
        if self._tangent is not None:
            self._framed = True
            self._tangent.x.array[:] = tangent.ravel()

    def keep_frame(self) -> None:
        """The frames as they are now are those from which the next step starts."""
        if self._tangent is not None:
            self.set_tangent(self._first(self.normal.x.array.reshape(-1, 3)))

    def _first(self, normal: np.ndarray) -> np.ndarray:
        """The first tangents (n, 3) at these normals."""
        assert self._tangent is not None
        return beside(normal, self._tangent.x.array.reshape(-1, 3))

    @property
    def tangent(self) -> np.ndarray:
        """The first tangents as they were set, (n, 3); empty where nothing needs them."""
        values = np.empty(0) if self._tangent is None else self._tangent.x.array
        return values.reshape(-1, 3).copy()

    def frame(self) -> tuple[np.ndarray, np.ndarray]:
        """Normals (n, d) and tangents (d - 1, n, d); no tangents where nothing needs them."""
        d = self.surface.dim
        normal = self.normal.x.array.reshape(-1, d)
        if d == 2:
            return normal, np.stack([-normal[:, 1], normal[:, 0]], axis=1)[None]
        if self._tangent is None:
            return normal, np.zeros((0, *normal.shape))
        first = self._first(normal)
        return normal, np.stack([first, cross(normal, first)])
