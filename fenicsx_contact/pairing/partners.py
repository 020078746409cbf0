# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which point of the other side each integration point meets: rays along the slave's normals.

A ray from x along n meets a facet at x + alpha n = x_m(xi); alpha > 0 is open. Of several facets
that face the ray the nearest wins. Corners and edges of the other side need no care of their own:
its surface is continuous, so alpha is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .search import candidates
from .side import Side

#: Overlap of facets, in local coordinates: rays through an edge must not pass between two facets.
EDGE = 1e-8
#: A facet faces a ray if the cosine between its normal and the ray is below this.
FACING = -0.05


@dataclass(frozen=True)
class Hits:
    """For each ray: facet of the other side (-1: none), local coordinates (q, d - 1), alpha (q,),
    and ``inverse``, (q, d, d): M^-1 of  M (dxi, dalpha) = dx + alpha dn - dx_m."""

    facet: np.ndarray
    xi: np.ndarray
    distance: np.ndarray
    inverse: np.ndarray


def meet(
    x: np.ndarray,
    n: np.ndarray,
    bundle: np.ndarray,
    reach: np.ndarray,
    side: Side,
    nodes: np.ndarray,
) -> Hits:
    """Shoot rays from x (q, d) along the unit vectors n (q, d), to both sides.

    Args:
        x, n: the rays.
        bundle: facet from which each comes, (q,), ascending.
        reach: how far each goes, (q,) in m.
        side: the other side, ``nodes`` (N, d) the present places of its nodes.
        reach: farthest distance, m; inf looks everywhere.
    """
    q, d = x.shape
    ray, facet = candidates(x, n, bundle, reach, nodes[side.cells])
    xi, alpha, inverse = _intersect(x[ray], n[ray], side, nodes, facet)
    normal = side.normals(nodes, facet, side.shape(xi)[1])
    facing = (normal * n[ray]).sum(axis=1) < FACING * np.linalg.norm(normal, axis=1)
    good = facing & side.holds(xi, EDGE) & (np.abs(alpha) <= reach[ray])
    ray, facet, xi, alpha, inverse = (a[good] for a in (ray, facet, xi, alpha, inverse))
    order = np.lexsort((facet, np.abs(alpha), ray))
    _, first = np.unique(ray[order], return_index=True)
    best = order[first]
    result = Hits(np.full(q, -1), np.zeros((q, d - 1)), reach.copy(), np.zeros((q, d, d)))
    hit = ray[best]
    result.facet[hit], result.xi[hit] = facet[best], xi[best]
    result.distance[hit], result.inverse[hit] = alpha[best], inverse[best]
    return result


def _intersect(
    x: np.ndarray, n: np.ndarray, side: Side, nodes: np.ndarray, facet: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where rays meet the facets, continued beyond their edges: xi, alpha, M^-1."""
    q, d = x.shape
    xi, alpha = np.tile(side.midpoint, (q, 1)), np.zeros(q)
    matrix = np.empty((q, d, d))
    matrix[:, :, -1] = -n
    places = nodes[side.cells[facet]]
    straight = side.degree == 1 and side.cell != "quadrilateral"
    for _ in range(1 if straight else 8):
        values, slopes = side.shape(xi)
        error = x + alpha[:, None] * n - np.einsum("qk,qkj->qj", values, places)
        matrix[:, :, :-1] = np.einsum("tqk,qkj->qjt", slopes, places)
        inverse = _inverse(matrix)
        step = np.einsum("qij,qj->qi", inverse, error)
        # far from the facet a curved one need not be met: do not run away
        xi = np.clip(xi + step[:, :-1], -5.0, 6.0) if not straight else xi + step[:, :-1]
        alpha = alpha + step[:, -1]
        if np.abs(step[:, :-1]).max(initial=0.0) < 1e-13:
            break
    if not straight:
        miss = np.abs(step[:, :-1]).max(axis=1, initial=0.0) > 1e-9
        xi[miss] = -1.0  # not on the facet
    return xi, alpha, inverse


def _inverse(matrix: np.ndarray) -> np.ndarray:
    """Inverses (q, d, d); a ray along a facet, which has none, gives a far-away point."""
    singular = np.abs(np.linalg.det(matrix)) < 1e-300
    if singular.any():
        matrix = matrix.copy()
        matrix[singular] = np.eye(matrix.shape[1]) * 1e-30
    return np.linalg.inv(matrix)
