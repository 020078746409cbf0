# SPDX-License-Identifier: LGPL-3.0-or-later
"""A scene that takes up a state goes on from it as the one that gave it: to the last bit."""

import dolfinx
import numpy as np
import pytest
from mpi4py import MPI
from scenes import FLOOR_3D, box

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    EnergyMomentum,
    Heap,
    HyperelasticSolid,
    RigidSolid,
    Scene,
    ThetaScheme,
    name_facets,
    neo_hookean,
)


def everywhere(x):
    return np.full(x.shape[1], True)


def ring(kind, law, scheme=None, **options):
    """An open ring whose ends clap together."""
    corners, cell = [np.zeros(2), np.array([1, 0.05])], dolfinx.mesh.CellType.quadrilateral
    mesh = dolfinx.mesh.create_rectangle(MPI.COMM_SELF, corners, [24, 2], cell)
    x = mesh.geometry.x
    angle, radius = -np.pi / 2 + (x[:, 0] - 0.5) * 5.6, 0.2 + x[:, 1]
    x[:, 0], x[:, 1] = radius * np.cos(angle), radius * np.sin(angle)
    soft = {"youngs_modulus": 1e6, "poisson_ratio": 0.3}
    solid = kind(
        name_facets(mesh, {"skin": everywhere}),
        **(soft if kind is ElasticSolid else {"energy": neo_hookean(1e6, 0.3)}),
        density=1e3,
        velocity=lambda x: np.stack([-20 * x[0] * (x[1] > 0), 0 * x[0]]),
    )
    contact = Contact(solid, "skin", (solid, "skin"), law, friction=0.3, name="own")
    return Scene([solid], [contact], scheme, **options)


def boxes(law):
    """Four thrown on the ground in space."""

    def body(low, high, **solid):
        corners, cell = [np.array(low), np.array(high)], dolfinx.mesh.CellType.hexahedron
        mesh = dolfinx.mesh.create_box(MPI.COMM_SELF, corners, [1, 1, 1], cell)
        return RigidSolid(name_facets(mesh, {"skin": everywhere}), density=1e3, **solid)

    solids = [
        body(
            (0.31 * i, 0.0, 0.32 * j + 0.01),
            (0.31 * i + 0.3, 0.3, 0.32 * j + 0.31),
            gravity=(0, 0, -9.81),
            rotation=(0.02 * i, 0.01, 0.03 * j),
            about=(0.31 * i + 0.1, 0.15, 0.3 * j + 0.1),
            velocity=(0.3 * (-1) ** (i + j), 0.1, -0.1),
            name=f"box {i} {j}",
        )
        for i in range(2)
        for j in range(2)
    ]
    held = ["x", "y", "z", *(f"turning about {axis}" for axis in "xyz")]
    ground = body((-1.0, -1.0, -0.2), (2.0, 1.0, -0.02), held=held, name="ground")
    return Scene([*solids, ground], [Heap([*solids, ground], "skin", law, friction=0.4)])


def table(law, **options):
    """It comes down by a corner, an edge and its base, and spins on."""
    mesh = box((3, 3, 1), (1.0, 1.0, 0.1))
    mesh.mesh.geometry.x[:, :2] -= mesh.mesh.geometry.x[:, :2].mean(axis=0)
    start = {"rotation": (0.004, -0.003, 0.0), "about": (-0.5, -0.5, 0.0)}
    free = {"mass": 1.0, "gravity": (0.0, 0.0, -9.81), "spin": (0.0, 0.0, 5.0)}
    solid = RigidSolid(mesh, **free, **start)
    contact = Contact(solid, "base", FLOOR_3D, law, friction=0.3, name="own")
    return Scene([solid], [contact], **options)


@pytest.mark.parametrize(
    ("make", "steps", "dt"),
    [
        (lambda: ring(HyperelasticSolid, "gap"), 16, 2e-3),
        (lambda: ring(ElasticSolid, "velocity"), 16, 2e-3),
        (lambda: ring(ElasticSolid, "velocity", locate_impacts=True), 16, 2e-3),
        (lambda: ring(ElasticSolid, "gap", ThetaScheme(1.0)), 16, 2e-3),
        (lambda: ring(HyperelasticSolid, "velocity", EnergyMomentum()), 16, 2e-3),
        (lambda: boxes("velocity"), 24, 4e-3),
        (lambda: boxes("gap"), 24, 4e-3),
        (lambda: table("velocity"), 80, 2e-3),
        (lambda: table("gap"), 80, 2e-3),
        (lambda: table("velocity", locate_impacts=True), 80, 2e-3),
    ],
    ids=[
        "own gap",
        "own velocity",
        "own located",
        "own theta",
        "own energy",
        "heap",
        "heap gap",
        "table",
        "table gap",
        "table located",
    ],
)
def test_every_state_is_all_that_follows_from(make, steps, dt):
    """Facets that sought partners as far as a fresh scene is from the state found others than the
    run that gave it, and points at which nothing met any more had the normals of the start."""
    scene, states = make(), []
    for _ in range(steps):
        list(scene.step(dt))
        states.append(scene.state())
    force = f"contact.{scene.contacts[0].name}.force"
    assert any(state[force].any() for state in states)
    for before, after in zip(states, states[1:]):
        again = make()
        again.restore(before)
        list(again.step(dt))
        found = again.state()
        differ = [name for name in after if not np.array_equal(after[name], found[name])]
        assert not differ, differ
    for before, after in list(zip(states, states[1:]))[::-3]:
        scene.restore(before)  # by what has gone on
        list(scene.step(dt))
        found = scene.state()
        differ = [name for name in after if not np.array_equal(after[name], found[name])]
        assert not differ, differ
