# SPDX-License-Identifier: LGPL-3.0-or-later
"""What passes through a surface within a step and is then too far from it to find a partner."""

from __future__ import annotations

import numpy as np

from .side import Side


def passed(
    points: tuple[np.ndarray, np.ndarray], side: Side, nodes: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, d), at the start and at the end of a step, that go into a side whose nodes are
    (N, d) then, on straight ways as seen from its facets, as these lie at the end.

    Returns:
        The pairs: points, and facets that they cross. Points that move less than a facet is large
        cross none: they are still near enough to be seen.
    """
    way = points[1] - points[0]
    moved = np.abs(way).max(initial=0.0) + np.abs(nodes[1] - nodes[0]).max(initial=0.0)
    if moved <= side.sizes.min():
        return np.empty(0, dtype=int), np.empty(0, dtype=int)
    facets = np.arange(len(side.cells))
    slopes = side.shape(np.tile(side.midpoint, (len(facets), 1)))[1]
    normal = side.normals(nodes[1], facets, slopes)
    corners = nodes[1][side.corners]
    middle = corners.mean(axis=1)
    came = middle - nodes[0][side.corners].mean(axis=1)
    radius = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
    found = []
    for i, (end, own) in enumerate(zip(points[1], way)):  # a few at a time: few get here
        after, across = end - middle, own - came
        inner = np.einsum("fj,fj->f", after, normal)
        speed = np.einsum("fj,fj->f", across, normal)
        into = (inner < 0) & (inner - speed > 0)
        share = inner / np.where(into, speed, -1.0)  # of the way, that lies behind the facet
        place = after - share[:, None] * across
        hit = into & (np.linalg.norm(place, axis=1) <= radius)
        found.append(np.stack([np.full(hit.sum(), i), facets[hit]], axis=1))
    pairs = np.concatenate(found)
    return pairs[:, 0], pairs[:, 1]
