# SPDX-License-Identifier: LGPL-3.0-or-later
"""Interface laws do not depend on who looks: turned, shifted, in space, by every solver."""

from functools import cache

import numpy as np
import pytest
import ufl
from corpus_meshes import moved
from scenes import G, box, rectangle

from fenicsx_contact import (
    Adhesive,
    Archard,
    Compliance,
    Contact,
    ElasticSolid,
    HalfSpace,
    LevelSet,
    RateState,
    RigidSolid,
    Scene,
    StaticKinetic,
    Stribeck,
    Tresca,
)

LAWS = {
    "place": ("velocity", lambda s: lambda x: 0.3 + 0.2 * sum(a * b for a, b in zip(s, x))),
    "tresca": ("velocity", lambda s: Tresca(500.0)),
    "static and kinetic": ("velocity", lambda s: StaticKinetic(0.5, 0.25)),
    "stribeck": ("gap", lambda s: Stribeck(0.4, 0.2, speed=0.5)),
    "rate and state": ("velocity", lambda s: RateState(0.01, 0.015, 0.1, 0.3, 1.0, theta=0.1)),
    "wear": ("gap", lambda s: Archard(0.2, coefficient=1e-3, hardness=1e6)),
    "adhesion": (Adhesive(200.0), lambda s: 0.3),
    "compliance": (Compliance(1e6, exponent=1.5, tangential_stiffness=1e6), lambda s: 0.3),
}
COLUMNS = ("kinetic", "strain", "friction", "impact")


@cache
def slide(name, dim=2, turn=0.0, solver="condensed", geometry="fixed point"):
    """Energies of an elastic block that is thrown along a floor; nothing depends on the depth."""
    law, friction = LAWS[name]
    mesh = rectangle((3, 2)) if dim == 2 else box((3, 1, 2), (0.36, 1.0, 0.80))
    along, up = np.eye(dim)[0], np.eye(dim)[-1]
    R, c, s = np.eye(dim), np.cos(turn), np.sin(turn)
    R[np.ix_([0, -1], [0, -1])] = [[c, -s], [s, c]]
    if dim == 3 and turn:  # out of the plane, too
        R = R @ [[np.cos(0.7), -np.sin(0.7), 0], [np.sin(0.7), np.cos(0.7), 0], [0, 0, 1]]
    x = mesh.mesh.geometry.x
    x[:, :dim] = x[:, :dim] @ R.T
    block = ElasticSolid(
        mesh,
        youngs_modulus=1e6,
        poisson_ratio=0.0,
        density=1000.0,
        gravity=-G * R @ up,
        velocity=lambda x: np.outer(R @ along, np.ones(x.shape[1])),
    )
    floor = HalfSpace(np.zeros(dim), R @ up)
    contact = Contact(block, "base", floor, law, friction((R @ along).tolist()))
    history = Scene([block], [contact], solver=solver, geometry=geometry).run(0.03, 5e-4)
    assert history.reason == "finished"
    assert history["friction"][-1] < -1e-4 * history["kinetic"][0]
    return np.stack([history[column] for column in COLUMNS])


def same(found, expected, digits=1e-9):
    np.testing.assert_allclose(found, expected, rtol=0, atol=digits * np.abs(expected).max())


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("dim", [2, pytest.param(3, marks=pytest.mark.second)])
def test_turned(name, dim):
    same(slide(name, dim, turn=0.4), slide(name, dim))


@pytest.mark.second
@pytest.mark.parametrize("name", LAWS)
def test_in_space(name):
    same(slide(name, 3), slide(name, 2))


@pytest.mark.second
@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize(
    ("solver", "geometry"),
    [("condensed", "newton"), ("monolithic", "newton"), ("iterative", "newton")],
)
def test_solved_otherwise(name, solver, geometry):
    same(slide(name, 2, 0.0, solver, geometry), slide(name), 1e-7)


@pytest.mark.parametrize("mass", [1e-6, 1.0, 1e6])
def test_friction_on_what_only_rises_does_not_depend_on_units(mass):
    """A pin that is held in all but its height, on a turntable: its points have no mobility across
    their normals, and rows of friction were scaled by 1 Pa s/m, whatever the units."""
    held = ("x", "y", "turning about x", "turning about y", "turning about z")
    mesh = moved(box((4, 1, 1), (0.1, 0.02, 0.05)), 0.25, 0.0, 0.0)
    pin = RigidSolid(mesh, mass=mass, gravity=(0, 0, -G), held=held, name="pin")
    table = LevelSet(
        lambda x, t: x[2],
        dim=3,
        velocity=lambda x, t: ufl.as_vector((-3 * x[1], 3 * x[0], 0 * x[0])),
    )
    history = Scene([pin], [Contact(pin, "base", table, friction=0.3, name="c")]).run(0.1, 5e-3)
    assert history.finished and not history.remarks and history["newton"].max() <= 3
    force = np.hypot(history["c.force_x"][-1], history["c.force_y"][-1])
    assert force == pytest.approx(0.3 * mass * G, rel=1e-2)
