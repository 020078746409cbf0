# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact pressure, friction traction and stress, asked for and written, against exact values."""

from __future__ import annotations

import re
from pathlib import Path

import dolfinx
import meshio
import numpy as np
import pytest
from mpi4py import MPI
from processes import mpirun, needs_mpirun, output_of
from scenes import FLOOR, FLOOR_3D, G, box, rectangle
from scipy.optimize import brentq

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HyperelasticSolid,
    LevelSet,
    Moved,
    QuasiStatic,
    RigidSolid,
    Scene,
    name_facets,
    neo_hookean,
    read_history,
)

P, E, NU = 2e5, 1e7, 0.3
#: Four cells across.
ACROSS = {2: (4, 6), 3: (2, 2, 2)}


def pressed(d=2, friction=0.0, **others):
    """A square metre pressed on the floor by P on its top; in 3D a box, its base 1 m²."""
    mesh = rectangle(ACROSS[2], (1.0, 1.0)) if d == 2 else box(ACROSS[3], (1.0, 1.0, 1.0))
    load = np.zeros(d)
    load[-1] = -P
    given = {"youngs_modulus": E, "poisson_ratio": NU} | others
    solid = ElasticSolid(mesh, density=1.0, tractions={"top": load}, name="block", **given)
    floor = FLOOR if d == 2 else FLOOR_3D
    return solid, Contact(solid, "base", floor, "gap", friction=friction, name="floor")


def written(directory, name):
    """The files of a thing at the last time, one a process."""
    collection = (directory / "fields" / f"{name}.pvd").read_text()
    found = re.findall(r'timestep="(.*?)" .*file="(.*?)"', collection)
    return [directory / "fields" / file for time, file in found if time == found[-1][0]]


def last(directory, name):
    """What was written last of a thing, by field of points and of cells."""
    (file,) = written(directory, name)
    grid = meshio.read(file)
    return grid.point_data, {key: values[0] for key, values in grid.cell_data.items()}


def uniaxial(sigma, across=0.0, d=2):
    """The stress (3, 3) of sigma along the height, ``across`` the plane."""
    return np.diag([0.0, sigma, across] if d == 2 else [0.0, 0.0, sigma])


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize(
    ("plane", "across"), [("strain", -NU * P), ("stress", 0.0)], ids=["strain", "stress"]
)
def test_a_pressed_block(plane, across, degree, tmp_path):
    """p = F/A at every node; uniaxial stress in every cell; the same in the files."""
    solid, contact = pressed(plane=plane, prescribed={"left": (0, None)}, degree=degree)
    scene = Scene([solid], [contact], QuasiStatic())
    assert not contact.pressure.any()
    scene.run(1, 1, directory=tmp_path, fields_every=1)
    np.testing.assert_allclose(contact.pressure, P, rtol=1e-9)
    np.testing.assert_allclose(contact.friction_traction, 0, atol=1e-9 * P)
    exact = uniaxial(-P, across)
    np.testing.assert_allclose(solid.stress(), np.tile(exact, (24, 1, 1)), atol=1e-9 * P)
    points, _ = last(tmp_path, "floor")
    np.testing.assert_array_equal(points["pressure"], contact.pressure)
    assert (
        points["friction_traction"].shape == (4 * degree + 1, 3) and (points["status"] == 1).all()
    )
    _, cells = last(tmp_path, "block")
    np.testing.assert_array_equal(cells["stress"].reshape(-1, 3, 3), solid.stress())
    mises = np.sqrt(P**2 - P * abs(across) + across**2)
    np.testing.assert_allclose(cells["von_mises"], mises, rtol=1e-9)


def test_friction_traction_is_on_the_solid_and_at_the_bound():
    """A slab slides: mu p against its motion at every node, together mu m g."""
    mu = 0.4
    body = RigidSolid(box(size=(1.0, 1.0, 0.2)), mass=100.0, gravity=(0, 0, -G), velocity=(1, 0, 0))
    contact = Contact(body, "base", FLOOR_3D, friction=mu, name="floor")
    Scene([body], [contact]).run(0.01, 1e-3)
    pressure, friction = contact.pressure, contact.friction_traction
    assert pressure @ contact.surface.area == pytest.approx(100 * G, rel=1e-9)
    np.testing.assert_allclose(np.linalg.norm(friction, axis=1), mu * pressure, rtol=1e-9)
    assert (friction[:, 0] < 0).all() and (contact.status == 2).all()  # against the motion
    np.testing.assert_allclose(
        contact.traction, friction + pressure[:, None] * [0.0, 0.0, 1.0], rtol=1e-12
    )


def test_points_that_are_open_bear_nothing():
    """A block that is lifted on its left: pressure on the right alone, together its weight."""
    body = RigidSolid(
        rectangle((4, 1), (1.0, 0.2)), mass=10.0, gravity=(0, -G), rotation=-0.05, about=(0.5, 0)
    )
    contact = Contact(body, "base", FLOOR, name="floor")
    Scene([body], [contact]).run(2e-3, 1e-3)
    right = contact.surface.points[:, 0] > 0.49
    assert contact.pressure[right] > 0 and not contact.pressure[~right].any()
    assert (contact.status > 0).tolist() == right.tolist()


@pytest.mark.parametrize("formulation", ["lagrange", "gap"])
def test_per_area_or_point(formulation, tmp_path):
    """Forces at points have no pressure in the files, and are N when asked for."""
    body = RigidSolid(rectangle(size=(0.5, 0.2)), mass=10.0, gravity=(0, -G))
    contact = Contact(body, "base", FLOOR, formulation, name="floor")
    Scene([body], [contact]).run(1e-3, 1e-3, directory=tmp_path, fields_every=1)
    areas = {"lagrange": 1.0, "gap": 0.25}[formulation]
    np.testing.assert_allclose(contact.pressure * areas, 10 * G / 2, rtol=1e-9)
    points, cells = last(tmp_path, "floor")
    assert ("pressure" in points) is (formulation == "gap")
    assert not last(tmp_path, body.name)[1] and not cells


def test_a_hyperelastic_block_in_space():
    """Its top is pressed down by a fifth: Cauchy's stress is uniaxial, that of the law at the
    stretches, and the pressure is per area as it was."""
    stretch, down = 0.8, {"top": lambda t: (None, None, -0.2 * t)}
    held = {"left": (0, None, None), (-0.5, -0.5, 0.0): (None, 0, None)}
    solid = HyperelasticSolid(
        box(ACROSS[3], (1.0, 1.0, 1.0)),
        energy=neo_hookean(E, NU),
        density=1.0,
        prescribed={**down, **held},
    )
    contact = Contact(solid, "base", FLOOR_3D, "gap")
    history = Scene([solid], [contact], QuasiStatic()).run(1, 1 / 4)
    assert history.finished, history.reason
    lmbda, mu = E * NU / (1 + NU) / (1 - 2 * NU), E / 2 / (1 + NU)

    def cauchy(along, side):
        J = along * side**2
        return [(mu * (s**2 - 1) + lmbda * np.log(J)) / J for s in (along, side)]

    side = brentq(lambda side: cauchy(stretch, side)[1], 1.0, 1.3, xtol=1e-14)
    exact = cauchy(stretch, side)[0]
    assert exact < -0.2 * E
    np.testing.assert_allclose(
        solid.stress(), np.tile(uniaxial(exact, d=3), (8, 1, 1)), atol=1e-7 * E
    )
    np.testing.assert_allclose(contact.pressure, -exact * side**2, rtol=1e-7)


def test_plane_strain_of_a_hyperelastic_solid_has_a_stress_across():
    """Equal in all directions of the plane, and what the law gives across it."""
    swell = 1.1
    solid = HyperelasticSolid(
        rectangle(ACROSS[2]),
        energy=neo_hookean(E, NU),
        density=1.0,
        displacement=lambda x: (swell - 1) * x[:2],
    )
    lmbda, mu = E * NU / (1 + NU) / (1 - 2 * NU), E / 2 / (1 + NU)
    across = lmbda * np.log(swell**2) / swell**2
    within = across + mu * (1 - swell**-2)
    exact = np.diag([within, within, across])
    np.testing.assert_allclose(solid.stress(), np.tile(exact, (24, 1, 1)), atol=1e-10 * E)


def test_a_solid_of_revolution():
    """Pressed all round and along: r, y and hoop."""
    mesh = dolfinx.mesh.create_rectangle(
        MPI.COMM_WORLD, [np.zeros(2), np.ones(2)], [3, 3], dolfinx.mesh.CellType.triangle
    )
    where = {"out": lambda x: np.isclose(x[0], 1), "top": lambda x: np.isclose(x[1], 1)}
    solid = ElasticSolid(
        name_facets(mesh, {**where, "base": lambda x: np.isclose(x[1], 0)}),
        youngs_modulus=E,
        poisson_ratio=NU,
        density=1.0,
        plane="axisymmetric",
        tractions={"out": (-2 * P, 0), "top": (0, -P)},
        prescribed={"base": (None, 0)},
    )
    Scene([solid], [], QuasiStatic()).run(1, 1)
    exact = np.diag([-2 * P, -P, -2 * P])
    np.testing.assert_allclose(solid.stress(), np.tile(exact, (18, 1, 1)), atol=1e-9 * P)


def test_two_blocks_whose_meshes_do_not_match():
    """The slave's pressure is even, and so is the stress in both."""
    free = {"left": (0, None)}
    upper, _ = pressed(prescribed=free)
    lower = ElasticSolid(
        name_facets(
            below((3, 2)),
            {
                "bottom": lambda x: np.isclose(x[1], -1),
                "up": lambda x: np.isclose(x[1], 0),
                "left": lambda x: np.isclose(x[0], -0.5),
            },
        ),
        youngs_modulus=E,
        poisson_ratio=NU,
        density=1.0,
        name="lower",
        prescribed={**free, "bottom": (None, 0)},
    )
    contact = Contact(upper, "base", (lower, "up"), "gap")
    Scene([upper, lower], [contact], QuasiStatic()).run(1, 1)
    np.testing.assert_allclose(contact.pressure, P, rtol=1e-9)
    for solid in (upper, lower):
        exact = np.broadcast_to(uniaxial(-P, -NU * P), solid.stress().shape)
        np.testing.assert_allclose(solid.stress(), exact, atol=1e-9 * P)


def below(n):
    """A mesh of the square metre below the floor."""
    corners = [np.array([-0.5, -1.0]), np.array([0.5, 0.0])]
    return dolfinx.mesh.create_rectangle(MPI.COMM_WORLD, corners, list(n))


PARALLEL = """
import sys
sys.path.insert(0, {tests!r})
from test_results import P, QuasiStatic, Scene, np, pressed
solid, contact = pressed(prescribed={{"left": (0, None)}})
Scene([solid], [contact], QuasiStatic()).run(1, 1, directory={directory!r}, fields_every=1)
assert 0 < len(solid.stress()) < 24
np.testing.assert_allclose(contact.pressure, P, rtol=1e-9)
"""


@needs_mpirun
def test_by_two_processes(tmp_path):
    """Each asks for and writes the stress of its cells; the pressure is whole on both."""
    script = PARALLEL.format(tests=str(Path(__file__).parent), directory=str(tmp_path))
    output_of(mpirun(script, 2))
    stress = [meshio.read(file).cell_data["stress"][0] for file in written(tmp_path, "block")]
    assert len(stress) == 2
    exact = np.tile(uniaxial(-P, -NU * P).ravel(), (24, 1))
    np.testing.assert_allclose(np.concatenate(stress), exact, atol=1e-9 * P)
    (surface,) = written(tmp_path, "floor")
    np.testing.assert_allclose(meshio.read(surface).point_data["pressure"], P, rtol=1e-9)


def test_a_run_that_stops_says_why_and_gives_advice(tmp_path):
    """In memory and read from its directory."""
    mesh = rectangle((1, 1), (1.0, 1.0))
    block = RigidSolid(mesh, mass=1.0)
    roof = LevelSet(lambda x, t: 1.0 - 0.1 * t - x[1], dim=2)  # which comes down on it
    contacts = [Contact(block, "base", FLOOR, "gap"), Contact(block, "top", roof, "gap")]
    history = Scene([block], contacts).run(1, 0.1, directory=tmp_path, shortest=0.5)
    assert history.reason.endswith("(see: when it stops, 'jammed')")
    assert history.advice.startswith("jammed: what moves as it is told leaves rigid bodies no room")
    assert read_history(tmp_path).advice == history.advice
    assert read_history(tmp_path).reason == history.reason
    whole = Scene([RigidSolid(mesh, mass=1.0)], [], allow_free=True).run(1, 1)
    assert whole.reason == "finished" and whole.advice == ""


def late(time):
    if time > 0.05:
        raise ZeroDivisionError("no pump")
    return (0.0, 0.0)


@pytest.mark.parametrize("where", ["load", "motion"])
def test_a_function_that_raises_is_named_with_advice(where):
    solid = RigidSolid(
        rectangle((1, 1), (1.0, 1.0)), mass=1.0, force=late if where == "load" else None
    )
    floor = Moved(FLOOR, late) if where == "motion" else FLOOR
    history = Scene([solid], [Contact(solid, "base", floor, "gap")]).run(0.1, 0.01, shortest=0.5)
    assert "its function late at test_results.py" in history.reason and "no pump" in history.reason
    assert history.advice.startswith("function raises: a load or a motion")
