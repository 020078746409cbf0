# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a Function of a user's is at the nodes of a contact surface."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
import ufl

from ..base import compat
from .surface import Surface


class NodalValues:
    """Values of a scalar dolfinx Function, on the mesh of the solid, at the nodes of its surface.

    Of one that is not continuous at nodes it is the mean over the facets there, by their shares of
    the area of the node, each read in the cell behind the facet, so that its integral is kept.

    Raises:
        ValueError: as of :class:`~fenicsx_contact.base.compat.PointValues`.
    """

    def __init__(self, function: Any, surface: Surface) -> None:
        self._mean: sp.csr_matrix | None = None
        at_vertices = function.function_space.dofmap.dof_layout.entity_dofs(0, 0)
        if function.ufl_shape or len(at_vertices):
            self._values = compat.PointValues(function, surface.points)
            return
        shares = surface.shares()
        place = compat.PointExpression(
            ufl.SpatialCoordinate(surface.mesh), compat.cellwise_space(surface.mesh)
        )
        middles = np.repeat(place()[:, : surface.dim], shares.shape[1], axis=0)
        sites = surface.sites[surface.cell_sites.ravel()]
        self._values = compat.PointValues(function, sites, middles)
        nodes, every = surface.cell_nodes.ravel(), np.arange(shares.size)
        weights = shares.ravel() / np.bincount(nodes, shares.ravel())[nodes]
        self._mean = sp.csr_matrix((weights, (nodes, every)), (surface.size, shares.size))

    def __call__(self) -> np.ndarray:
        """The values now, (n,)."""
        values = self._values()
        return values if self._mean is None else np.asarray(self._mean @ values)
