# SPDX-License-Identifier: LGPL-3.0-or-later
"""Values at the corners of a surface that stand for a field on it: means by dual functions.

What bears before an obstacle in space is integrated by the corners of the facets. A field of second
degree has more nodes; its values at the corners alone would leave the others without a force, and
an even pressure would not be even. Its means (mortar.py), here over the whole reference surface,
take what they share, and are those values where the field is linear.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from ...base.cells import lagrange
from .integration import whole
from .matrices import add_up, gather
from .side import Side


def means(side: Side) -> sp.csr_matrix:
    """C, (corners, nodes):  (C v)_i = 1/a_i int psi_i v,  with int psi_i phi_j = delta_ij a_i."""
    rule, (m, k) = whole(side), side.corners.shape
    values, slopes = side.shape(rule.xi)
    phi = side.linear_shape(rule.xi).reshape(m, -1, k)
    weight = rule.weight * side.reference_measure(rule.facet, slopes)
    weighted = np.swapaxes(phi * weight.reshape(m, -1, 1), 1, 2)
    mass, moments = weighted @ phi, weighted @ values.reshape(m, -1, values.shape[1])
    share = mass.sum(axis=2)
    entries = share[..., None] * np.linalg.solve(mass, moments)
    n = int(side.corners.max()) + 1
    area = add_up(share.reshape(-1, 1), side.corners.ravel(), n)[side.corners]
    shape = n, len(side.nodes)
    return gather(entries / area, side.corners[..., None], side.cells[:, None], shape, False)


def bulges(side: Side) -> np.ndarray:
    """How far the means of the places lie outside of the corners, along the normals there, (n,) in
    m: where facets are curved, about h²/12 times the curvature."""
    points, (m, k) = lagrange(side.cell, 1).points, side.corners.shape
    slopes = side.shape(np.tile(points, (m, 1)))[1]
    normals = side.normals(side.nodes, np.repeat(np.arange(m), k), slopes)
    C = means(side)
    normals = add_up(normals, side.corners.ravel(), C.shape[0])
    off = C @ side.nodes - side.nodes[: C.shape[0]]
    return np.einsum("ni,ni->n", off, normals) / np.linalg.norm(normals, axis=1)
