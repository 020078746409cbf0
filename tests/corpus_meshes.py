# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes of the corpus, and an obstacle."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from mpi4py import MPI
from scenes import box, rectangle

from fenicsx_contact import NamedMesh, name_facets
from fenicsx_contact.base import compat


def moved(mesh: NamedMesh, *by: float) -> NamedMesh:
    """A mesh at another place."""
    mesh.mesh.geometry.x[:, : len(by)] += by
    return mesh


def mapped(n: Sequence[int], place: Callable[..., Any], names: Sequence[str]) -> NamedMesh:
    """Quadrilaterals (n, m) over the unit square s, t, at ``place(s, t)``; ``names`` of the facets
    at s = 0, s = 1, t = 0, t = 1."""
    s, t = np.meshgrid(np.linspace(0, 1, n[0] + 1), np.linspace(0, 1, n[1] + 1), indexing="ij")
    at = np.arange(s.size).reshape(s.shape)
    corners = [at[:-1, :-1], at[1:, :-1], at[:-1, 1:], at[1:, 1:]]
    cells = np.stack([corner.ravel() for corner in corners], axis=1)
    points = np.stack([s.ravel(), t.ravel()], axis=1)
    mesh = compat.create_mesh(MPI.COMM_SELF, cells, points, "quadrilateral")
    sides = {
        names[0]: lambda x: np.isclose(x[0], 0),
        names[1]: lambda x: np.isclose(x[0], 1),
        names[2]: lambda x: np.isclose(x[1], 0),
        names[3]: lambda x: np.isclose(x[1], 1),
    }
    named = name_facets(mesh, sides)
    x = mesh.geometry.x
    x[:, :2] = np.stack(place(x[:, 0].copy(), x[:, 1].copy()), axis=1)
    return named


def ring_mesh(radius: float, thickness: float, around: int = 40) -> NamedMesh:
    """A ring about the origin; facets under, over (of its outer side), inner."""
    cells, points = [], []
    for i in range(around):
        angle = 2 * np.pi * (i + 0.0) / around
        points += [[r * np.sin(angle), -r * np.cos(angle)] for r in (radius - thickness, radius)]
        j = (i + 1) % around
        cells.append([2 * i, 2 * i + 1, 2 * j, 2 * j + 1])
    mesh = compat.create_mesh(MPI.COMM_SELF, np.array(cells), np.array(points), "quadrilateral")
    rim = radius * np.cos(np.pi / around)
    outside = lambda x: np.hypot(x[0], x[1]) > rim - thickness / 4  # noqa: E731
    return name_facets(
        mesh,
        {
            "under": lambda x: outside(x) & (x[1] < -0.7 * radius),
            "over": lambda x: outside(x) & (x[1] > 0.7 * radius),
        },
    )


class Disc:
    """A fixed drum about the origin, as somebody would write it in numpy."""

    dim = 2
    flat = False

    def __init__(self, radius: float) -> None:
        self.radius = radius

    def distance(self, points: np.ndarray) -> np.ndarray:
        return np.hypot(*points.T) - self.radius

    def normals(self, points: np.ndarray) -> np.ndarray:
        return points / np.hypot(*points.T)[:, None]


def points_base(facets: int, uneven: bool, dim: int, size: Sequence[float]) -> NamedMesh:
    """A block with so many facets along its base, equal or growing to twenty times the first."""
    if dim == 2:
        mesh = rectangle((facets, 1), size)
    else:
        mesh = box((facets, min(facets, 2), 1), (size[0], 0.5, size[1]))
    if uneven:
        x, b = mesh.mesh.geometry.x, size[0] / 2
        share = (x[:, 0] + b) / (2 * b)
        x[:, 0] = -b + 2 * b * np.expm1(3 * share) / np.expm1(3)
    return mesh
