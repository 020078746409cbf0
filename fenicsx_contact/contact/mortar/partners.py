# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which point of the other side each integration point meets: rays along the slave's normals.

A ray from x along n meets a facet at x + alpha n = x_m(xi); alpha > 0 is open. Of several facets
that face the ray the nearest wins. Corners and edges of the other side need no care of their own:
its surface is continuous, so alpha is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...base.vectors import cross, largest
from .itself import Admits
from .search import BULGE, MARGIN, Near, Spheres, candidates, first_of_each
from .side import Side

#: Overlap of facets, in local coordinates: rays through an edge must not pass between two facets.
EDGE = 1e-8
#: A facet faces a ray if the cosine between its normal and the ray is below this.
FACING = -0.05


@dataclass(frozen=True)
class Hits:
    """The rays that meet something (h,), facets of the other side (h,), local coordinates there
    (h, d - 1), alpha (h,), and ``inverse``, (h, d, d): M^-1 of  M (dxi, dalpha) = dx + alpha dn -
    dx_m."""

    ray: np.ndarray
    facet: np.ndarray
    xi: np.ndarray
    distance: np.ndarray
    inverse: np.ndarray


class Rays(NamedTuple):
    """Rays from x (q, d) along the unit vectors n (q, d), to both sides, that come from the facets
    ``origin`` (q,), ascending, at least one from each, and go as far as ``reach`` of these, m."""

    x: np.ndarray
    n: np.ndarray
    origin: np.ndarray
    reach: np.ndarray


class Partners:
    """Shoots rays from the facets of one side to those of the other."""

    def __init__(self, side: Side, other: Side, admits: Admits) -> None:
        self._side, self._other, self._admits = side, other, admits
        self._near = Near()
        self._seen: _Seen | None = None

    def meet(self, rays: Rays, places: tuple[np.ndarray, np.ndarray]) -> Hits:
        """What the rays meet first; ``places``: present ones of the nodes of both sides, (N, d)."""
        side, nodes = self._other, places[1]
        ray, facet = self._candidates(rays, places)
        direction, origin = rays.n[ray], rays.origin[ray]
        xi, alpha, inverse, tangents = intersect(rays.x[ray], direction, side, nodes, facet)
        good = facing(direction, side.normal(tangents, facet))
        good &= side.holds(xi, EDGE) & (np.abs(alpha) <= rays.reach[origin])
        good &= self._admits(origin, facet, alpha)
        good = np.flatnonzero(good)
        order = good[np.lexsort((facet[good], np.abs(alpha[good]), ray[good]))]
        best = order[first_of_each(ray[order])]
        return Hits(ray[best], facet[best], xi[best], alpha[best], inverse[best])

    def _candidates(
        self, rays: Rays, places: tuple[np.ndarray, np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Pairs (ray, facet) that may meet, found with some margin, and kept while that lasts."""
        seen, nodes = self._seen, places[1]
        if seen and seen.serves(rays, nodes):
            return seen.pairs
        bundles = Spheres.around(places[0][self._side.cells])
        facets = Spheres.around(nodes[self._other.cells])
        if not self._other.straight:  # which are met by iterations that end for all together
            return candidates(*rays, bundles, facets, self._near)
        margin = MARGIN * float(bundles.radii.sum() / len(bundles.radii))
        arm = 2 * float(rays.reach.max() + facets.radii.max())
        farther = rays._replace(reach=rays.reach + margin)
        wide = bundles.wider(margin), facets.wider(margin)
        pairs = candidates(*farther, *wide, self._near)
        self._seen = _Seen(farther, nodes, arm, margin, pairs)
        return pairs


class _Seen(NamedTuple):
    """What some rays may meet, as long as no distance of theirs changes by more than a margin."""

    rays: Rays
    nodes: np.ndarray
    arm: float  # of what turns them
    margin: float
    pairs: tuple[np.ndarray, np.ndarray]

    def serves(self, rays: Rays, nodes: np.ndarray) -> bool:
        """Whether these rays are as many from the same facets, and meet nothing else."""
        mine = self.rays
        if not np.array_equal(rays.origin, mine.origin) or (rays.reach > mine.reach).any():
            return False
        # a sphere grows by twice what its nodes move, and its middle goes as far as they do
        moved = farthest(rays.x, mine.x) + (1 + 2 * BULGE) * farthest(nodes, self.nodes)
        return moved + self.arm * farthest(rays.n, mine.n) <= self.margin


def facing(rays: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Whether unit vectors (q, d) run against normals (q, d) of any length, (q,) of bool."""
    return (normals * rays).sum(axis=1) < FACING * np.sqrt((normals**2).sum(axis=1))


def farthest(ones: np.ndarray, others: np.ndarray) -> float:
    """The largest distance between these places, (n, d)."""
    return float(np.sqrt(((ones - others) ** 2).sum(axis=1).max(initial=0.0)))


def intersect(
    x: np.ndarray, n: np.ndarray, side: Side, nodes: np.ndarray, facet: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Where rays meet the facets, continued beyond their edges: xi, alpha, M^-1 and the tangents
    of the facets there, (d - 1, q, d)."""
    q, d = x.shape
    xi, alpha = np.tile(side.midpoint, (q, 1)), np.zeros(q)
    matrix = np.empty((q, d, d))
    matrix[:, :, -1] = -n
    places = nodes[side.cells[facet]]
    for _ in range(1 if side.straight else 8):
        values, slopes = side.shape(xi)
        error = x + alpha[:, None] * n - np.einsum("qk,qkj->qj", values, places)
        tangents = np.einsum("tqk,qkj->tqj", slopes, places)
        matrix[:, :, :-1] = np.moveaxis(tangents, 0, 2)
        inverse = inverses(matrix)
        step = np.einsum("qij,qj->qi", inverse, error)
        # far from the facet a curved one need not be met: do not run away
        xi = xi + step[:, :-1] if side.straight else np.clip(xi + step[:, :-1], -5.0, 6.0)
        alpha = alpha + step[:, -1]
        if largest(step[:, :-1]) < 1e-13:
            break
    if not side.straight:
        miss = np.abs(step[:, :-1]).max(axis=1, initial=0.0) > 1e-9
        xi[miss] = -1.0  # not on the facet
    return xi, alpha, inverse, tangents


def inverses(matrix: np.ndarray) -> np.ndarray:
    """Inverses (..., d, d) by Cramer's rule; a ray along a facet, which has none, gives a far-away
    point."""
    if matrix.shape[-1] == 2:
        adjugate = np.empty_like(matrix)
        adjugate[..., 0, 0], adjugate[..., 0, 1] = matrix[..., 1, 1], -matrix[..., 0, 1]
        adjugate[..., 1, 0], adjugate[..., 1, 1] = -matrix[..., 1, 0], matrix[..., 0, 0]
    else:
        a, b, c = matrix[..., 0], matrix[..., 1], matrix[..., 2]
        adjugate = np.empty_like(matrix)
        for row, (left, right) in enumerate(((b, c), (c, a), (a, b))):
            adjugate[..., row, :] = cross(left, right)
    determinant = (adjugate[..., 0, :] * matrix[..., :, 0]).sum(axis=-1)
    singular = np.abs(determinant) < 1e-300
    adjugate[singular] = np.eye(matrix.shape[-1])
    return adjugate / np.where(singular, 1e-30, determinant)[..., None, None]
