# SPDX-License-Identifier: LGPL-3.0-or-later
"""Patch test: pressed blocks, non-matching meshes, or a wall; what presses is constant."""

import dolfinx
import numpy as np
import pytest
from dolfinx.mesh import CellType
from mpi4py import MPI

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    Newton,
    QuasiStatic,
    Scene,
    name_facets,
    neo_hookean,
)

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


SPACE = [CellType.tetrahedron, CellType.hexahedron]


@pytest.mark.parametrize("cell", SPACE)
@pytest.mark.parametrize(
    ("degree", "lower", "upper"),
    [(1, 2, 2), (1, 2, 3), (1, 3, 2), (1, 2, 4), (1, 4, 5), (2, 2, 2), (2, 3, 2), (2, 2, 3)],
)
def test_surfaces(cell, degree, lower, upper):
    """In space too: matching, one refined, coprime."""
    assert error(3, lower, upper, cell, degree) < 1e-10


# -- anywhere in space, whole or in part --------------------------------------------------------


def rotation(axis, angle):
    """By Rodrigues's formula."""
    a = np.array(axis) / np.linalg.norm(axis)
    cross = np.cross(np.eye(3), a)
    return np.eye(3) - np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def placed(n, cell, degree, material, place, **held):
    """A block 1 x 1 x 1/2 of n x n x 1 cells whose base is centred at the origin, turned about the
    vertical, moved and then turned with the rest; without lateral strains."""
    mesh = dolfinx.mesh.create_box(
        MPI.COMM_WORLD, [[-0.5, -0.5, 0], [0.5, 0.5, 0.5]], [n, n, 1], cell
    )
    up = {"bottom": lambda x: np.isclose(x[2], 0), "top": lambda x: np.isclose(x[2], 0.5)}
    named, x = name_facets(mesh, up), mesh.geometry.x
    width, about, shift, rest = place
    x[:, :2] *= width
    x[:] = (x @ rotation((0, 0, 1), about).T + shift) @ rest.T
    common = {"density": 1.0, "degree": degree, **held}
    if material == "linear":
        return ElasticSolid(named, youngs_modulus=E, poisson_ratio=0.0, **common)
    return HyperelasticSolid(named, energy=neo_hookean(E, 0.0), **common)


def pressed(
    cell, material="linear", degree=1, slave="upper", wide=False, axis=(1, 2, 3), angle=0.7
):
    """A block pressed on another one, turned in space; if ``wide`` the upper one hangs over on all
    sides and moves as a whole, slightly turned."""
    rest, down = rotation(axis, angle), 0.02
    lower = placed(
        5 if wide else 3,
        cell,
        degree,
        material,
        (1, 0, (0, 0, 0), rest),
        fixed=["bottom"],
        name="l",
    )
    place = (1.7, 0.3, (0.07, -0.03, 0.5), rest) if wide else (1, 0, (0, 0, 0.5), rest)
    push = -down * rest[:, 2]
    held = {side: (lambda t: list(t * push)) for side in (["top", "bottom"] if wide else ["top"])}
    upper = placed(3 if wide else 4, cell, degree, material, place, prescribed=held, name="u")
    sides = [(upper, "bottom"), (lower, "top")]
    (one, facets), other = sides if slave == "upper" else sides[::-1]
    seam = Contact(one, facets, other, "gap", name="seam")
    scene = Scene([lower, upper], [seam], QuasiStatic(), Newton(tolerance=1e-13))
    history = scene.run(until=1, dt=1)
    assert history.finished and not history.remarks, history.reason
    return lower, upper, seam


def uniaxial(material, strain):
    """Pressure of a block shortened by this strain that has no Poisson effect."""
    stretch = 1 - strain
    return E * strain if material == "linear" else -E / 2 * (stretch - 1 / stretch)


@pytest.mark.parametrize("wide", [False, True], ids=["same", "wide"])
@pytest.mark.parametrize("slave", ["upper", "lower"])
@pytest.mark.parametrize("material", ["linear", "neo-Hookean"])
@pytest.mark.parametrize("cell", SPACE)
def test_turned_and_overhanging(cell, material, slave, wide):
    """The pressure is constant where the two face each other, through facets that lie half in the
    open, whichever side bears the multipliers and however they stand in space."""
    *_, seam = pressed(cell, material, 1, slave, wide)
    strain = 0.04 if wide else 0.02
    bears = seam.status > 0
    assert bears.any() and (bears.all() or (wide and slave == "upper"))
    pressure = -seam.multiplier[bears]
    assert np.abs(pressure / uniaxial(material, strain) - 1).max() < 1e-10


@pytest.mark.parametrize("cell", SPACE)
def test_second_degree_turned_and_overhanging(cell):
    *_, seam = pressed(cell, degree=2, wide=True)
    assert np.abs(-seam.multiplier[seam.status > 0] / uniaxial("linear", 0.04) - 1).max() < 1e-10


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("cell", SPACE)
def test_before_an_obstacle(cell, degree):
    """On a rigid wall: even, not borne by the corners alone."""
    solid = block(3, 3, 0.0, cell, degree, {"top": lambda t: (None, None, -STRAIN / 2 * t)})
    seam = Contact(solid, "bottom", HalfSpace((0, 0, 0), (0, 0, 1)), "gap")
    history = Scene([solid], [seam], QuasiStatic(), Newton(tolerance=1e-13)).run(until=1, dt=1)
    assert history.finished, history.reason
    assert np.abs(-seam.multiplier / STRESS[3] - 1).max() < 1e-10


@pytest.mark.parametrize("load", ["moved", "traction", "weight"])
@pytest.mark.parametrize("n", [1, 4, 7])
@pytest.mark.parametrize("cell", [CellType.triangle, CellType.quadrilateral])
def test_second_degree_in_the_plane_before_an_obstacle(cell, n, load):
    """On uneven facets, at corners and middles."""
    nu = 0.0 if load == "weight" else NU  # what widens by its weight bends its base
    mesh = dolfinx.mesh.create_rectangle(MPI.COMM_WORLD, [[0, 0], [1, 0.5]], [n, 2], cell)
    x = mesh.geometry.x[:, 0]
    x += 0.3 * x * (1 - x)
    sides = {
        "base": lambda x: np.isclose(x[1], 0),
        "top": lambda x: np.isclose(x[1], 0.5),
        "x0": lambda x: np.isclose(x[0], 0),
    }
    held = {"x0": (0.0, None), **({"top": (None, -STRAIN / 2)} if load == "moved" else {})}
    loads = {
        "moved": {},
        "traction": {"tractions": {"top": (0.0, -STRESS[2])}},
        "weight": {"gravity": (0.0, -2 * STRESS[2])},
    }
    solid = ElasticSolid(
        name_facets(mesh, sides),
        youngs_modulus=E,
        poisson_ratio=nu,
        density=1.0,
        degree=2,
        prescribed=held,
        **loads[load],
    )
    seam = Contact(solid, "base", HalfSpace((0, 0), (0, 1)), "gap")
    history = Scene([solid], [seam], QuasiStatic(), Newton(tolerance=1e-13)).run(until=1, dt=1)
    assert history.finished, history.reason
    assert len(seam.pressure) == 2 * n + 1
    assert np.abs(seam.pressure / STRESS[2] - 1).max() < 1e-10


@pytest.mark.parametrize("cell", SPACE)
def test_second_degree_thrown_at_an_obstacle(cell):
    """A block of second degree strikes: forces are those of the momentum, energy is not made."""
    mesh = dolfinx.mesh.create_box(MPI.COMM_WORLD, [[0, 0, 0], [0.4, 0.3, 0.3]], [2, 2, 1], cell)
    named, start = name_facets(mesh, {"bottom": lambda x: np.isclose(x[2], 0)}), [0.3, 0.0, -1.0]
    solid = ElasticSolid(
        named, youngs_modulus=1e5, poisson_ratio=0.3, density=10.0, degree=2, name="s",
        velocity=lambda x: np.outer(start, np.ones(x.shape[1])),
    )  # fmt: skip
    contact = Contact(solid, "bottom", HalfSpace((0, 0, -1e-4), (0, 0, 1)), friction=0.2, name="c")
    history = Scene([solid], [contact]).run(until=0.01, dt=1e-4)
    assert history.finished and not history.remarks
    mass = 10.0 * 0.4 * 0.3 * 0.3
    gained = mass * (solid.mean(solid.velocity) - start)
    np.testing.assert_allclose(history.impulse("c")[-1], gained, atol=1e-9 * mass)
    assert gained[2] > mass
    energy = history["kinetic"] + history["strain"]
    assert energy.max() < energy[0] * (1 + 1e-9)
