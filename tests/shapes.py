# SPDX-License-Identifier: LGPL-3.0-or-later
"""Surfaces of triangles for tests: a ball of any roughness, and what encloses a box."""

from __future__ import annotations

import meshio
import numpy as np
from scipy.spatial import ConvexHull


def triangulated(points):
    """The convex hull of points as a mesh of triangles, anticlockwise from outside."""
    hull = ConvexHull(points)
    cells, outward = hull.simplices.copy(), hull.equations[:, :3]
    x = points[cells]
    turned = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    wrong = (turned * outward).sum(axis=1) < 0
    cells[wrong] = cells[wrong][:, ::-1]
    return meshio.Mesh(points, [("triangle", cells)])


def ball(n, center=(0, 0, 0), radius=1.0, seed=None):
    """A ball by n points, on a spiral or, with a seed, anywhere."""
    k = np.arange(n) + 0.5
    z, turn = 1 - 2 * k / n, np.pi * (1 + 5**0.5) * k
    x = np.stack([np.cos(turn) * np.sqrt(1 - z**2), np.sin(turn) * np.sqrt(1 - z**2), z], axis=1)
    if seed is not None:
        x = np.random.default_rng(seed).standard_normal((n, 3))
        x /= np.linalg.norm(x, axis=1)[:, None]
    return triangulated(center + radius * x)


def bricks(size):
    """A box about the origin."""
    corners = np.stack(np.meshgrid(*[[-0.5, 0.5]] * 3), axis=-1).reshape(-1, 3)
    return triangulated(corners * size)
