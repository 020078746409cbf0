# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rigid bodies of the scenes of friction_truth.py."""

import tempfile
from collections.abc import Callable
from math import pi
from pathlib import Path
from time import perf_counter
from typing import Any

import dolfinx
import meshio
import numpy as np
from mpi4py import MPI

from fenicsx_contact import NamedMesh, RigidSolid, Scene, mesh_from_file, name_facets


def box(size: tuple[float, float, float], low: tuple[float, float, float]) -> NamedMesh:
    """A box of one cell from its lowest corner, its sides named by where they look."""
    corners = [np.array(low), np.array(low) + np.array(size)]
    kind = dolfinx.mesh.CellType.hexahedron
    mesh = dolfinx.mesh.create_box(MPI.COMM_WORLD, corners, [1, 1, 1], kind)
    named = {"left": (0, 0), "right": (0, 1), "base": (2, 0), "top": (2, 1)}
    sides = {name: _plane(i, corners[k][i]) for name, (i, k) in named.items()}
    return name_facets(mesh, sides)


def _plane(i: int, value: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda x: np.isclose(x[i], value)


def disc(n: dict[str, Any]) -> NamedMesh:
    """A prism over a regular polygon whose only points are those of the rims."""
    corners, ring = n["disc_points"], 2 * pi * np.arange(n["disc_points"]) / n["disc_points"]
    rim = n["disc_radius"] * np.stack([np.cos(ring), np.sin(ring)], axis=1)
    points = np.concatenate([np.c_[rim, np.full(corners, z)] for z in (0.0, n["disc_height"])])
    cells = []
    for i in range(1, corners - 1):
        (a, b, c), (d, e, f) = (0, i, i + 1), (corners, corners + i, corners + i + 1)
        cells += [[a, b, c, f], [a, b, e, f], [a, d, e, f]]
    with tempfile.TemporaryDirectory() as directory:
        file = Path(directory) / "disc.vtk"
        meshio.write(file, meshio.Mesh(points, [("tetra", np.array(cells))]))
        mesh = mesh_from_file(file).mesh
    return name_facets(mesh, {"base": lambda x: np.isclose(x[2], 0)})


def cube(n: dict[str, Any], gravity: Any, **motion: Any) -> RigidSolid:
    """A cube on the floor, centred over the origin."""
    side = n["side"]
    mesh = box((side,) * 3, (-side / 2, -side / 2, 0.0))
    return RigidSolid(mesh, density=n["density"], gravity=gravity, name="cube", **motion)


def run(scene: Scene, until: float, n: dict[str, Any]) -> tuple[float, float]:
    """Seconds per step, and how far the first body rose at most, m."""
    body = scene.solids[0]
    assert isinstance(body, RigidSolid)
    height, start = float(body.place[2]), perf_counter()
    history = scene.run(
        until, n["dt"], progress=False, probes={"height": lambda: float(body.place[2])}
    )
    assert history.finished, history.reason
    cost = (perf_counter() - start) / history.steps
    return cost, float(history["height"].max()) - height
