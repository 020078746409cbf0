# SPDX-License-Identifier: LGPL-3.0-or-later
"""Patch test: two pressed blocks, non-matching meshes; the pressure between them is constant."""

import dolfinx
import numpy as np
import pytest
from dolfinx.mesh import CellType
from mpi4py import MPI

from fenicsx_contact import Contact, ElasticSolid, Newton, QuasiStatic, Scene, name_facets

E, NU, STRAIN = 100.0, 0.3, 1e-3
#: Stress of the blocks free to widen: in plane strain, and in space.
STRESS = {2: E / (1 - NU**2) * STRAIN, 3: E * STRAIN}


def block(dim, n, low, cell, degree, motion):
    """A block of unit base and height 1/2, with n cells along the base, rollers on x0 and y0."""
    corners = [[0.0] * (dim - 1) + [low], [1.0] * (dim - 1) + [low + 0.5]]
    make = dolfinx.mesh.create_rectangle if dim == 2 else dolfinx.mesh.create_box
    counts = [n] * (dim - 1) + [max(1, n // 2)]
    mesh = make(MPI.COMM_WORLD, corners, counts, cell)
    up = dim - 1
    places = {
        "bottom": lambda x: np.isclose(x[up], low),
        "top": lambda x: np.isclose(x[up], low + 0.5),
        "x0": lambda x: np.isclose(x[0], 0),
    }
    rollers = {"x0": (0.0, *[None] * up)}
    if dim == 3:
        places["y0"] = lambda x: np.isclose(x[1], 0)
        rollers["y0"] = (None, 0.0, None)
    return ElasticSolid(
        name_facets(mesh, places),
        youngs_modulus=E,
        poisson_ratio=NU,
        density=1.0,
        degree=degree,
        prescribed={**rollers, **motion},
        name=f"block at {low:g}",
    )


def error(dim, lower, upper, cell, degree):
    """Largest error of a nodal pressure, relative."""
    free = [None] * (dim - 1)
    foot = block(dim, lower, 0.0, cell, degree, {"bottom": (*free, 0.0)})
    head = block(dim, upper, 0.5, cell, degree, {"top": lambda t: (*free, -STRAIN * t)})
    seam = Contact(head, "bottom", (foot, "top"), "gap")
    history = Scene([foot, head], [seam], QuasiStatic(), Newton(tolerance=1e-13)).run(until=1, dt=1)
    assert history.finished, history.reason
    return np.abs(-seam.multiplier / STRESS[dim] - 1).max()


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize(("lower", "upper"), [(4, 7), (7, 4), (4, 4)])
@pytest.mark.parametrize("cell", [CellType.triangle, CellType.quadrilateral])
def test_lines(cell, lower, upper, degree):
    """Integrated exactly, on the overlaps: round-off whether the meshes match or not."""
    assert error(2, lower, upper, cell, degree) < 1e-10


@pytest.mark.parametrize("cell", [CellType.tetrahedron, CellType.hexahedron])
@pytest.mark.parametrize(
    ("degree", "lower", "upper", "bound"),
    [(1, 2, 2, 1e-10), (1, 2, 3, 1e-10), (1, 3, 2, 1e-10), (2, 2, 2, 1e-10), (2, 3, 2, 1e-10)],
)
def test_surfaces(cell, degree, lower, upper, bound):
    """Integrated by points on the facets: exact where the meshes match."""
    assert error(3, lower, upper, cell, degree) < bound
