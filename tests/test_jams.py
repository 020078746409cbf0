# SPDX-License-Identifier: LGPL-3.0-or-later
"""Walls that close on what cannot give way: a run says so, and only then."""

import numpy as np
import pytest
from scenes import FLOOR, box, rectangle

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    Moved,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
)

G = 10.0


def lid(dim, height, motion):
    """Above, level, carried along."""
    up = np.eye(dim)[-1]
    return Moved(HalfSpace(height * up, -up), lambda t: motion(t) * up)


@pytest.mark.parametrize("law, theta", [("velocity", 0.5), ("velocity", 1.0), ("gap", 1.0)])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_lid_that_closes_on_a_rigid_block_is_told(dim, law, theta):
    block = RigidSolid((rectangle if dim == 2 else box)((1,) * dim, (0.4,) * dim), mass=1.0)
    below = HalfSpace(np.zeros(dim), np.eye(dim)[-1])
    contacts = [
        Contact(block, "base", below, law, name="floor"),
        Contact(block, "top", lid(dim, 0.5, lambda t: -0.5 * t), law, name="lid"),
    ]
    history = Scene([block], contacts, ThetaScheme(theta)).run(until=0.4, dt=1e-2)
    assert "contacts 'floor' and 'lid' close on 'rigid', which cannot give way" in history.reason
    assert history["time"][-1] == pytest.approx(0.2, abs=1e-2)
    assert "what moves as it is told leaves rigid bodies no room" in history.advice


def test_so_it_is_of_a_stack():
    low, up = (RigidSolid(rectangle((1, 1), (0.4, 0.4)), mass=1.0, name=n) for n in ("low", "up"))
    up.mesh.mesh.geometry.x[:, 1] += 0.4
    up = RigidSolid(up.mesh, mass=1.0, name="up")
    contacts = [
        Contact(low, "base", FLOOR, name="floor"),
        Contact(up, "base", (low, "top"), name="joint"),
        Contact(up, "top", lid(2, 0.9, lambda t: -0.5 * t), name="lid"),
    ]
    history = Scene([low, up], contacts).run(until=0.4, dt=1e-2)
    assert "contacts 'floor' and 'joint' and 'lid' close on 'low' and 'up'" in history.reason


def test_what_gives_way_is_not_jammed():
    """A block that a wall pushes along, one that is soft, one that turns out of the way."""
    pushed = RigidSolid(rectangle((1, 1), (0.4, 0.4)), mass=1.0, gravity=(0, -G))
    wall = Moved(HalfSpace((-0.3, 0), (1, 0)), lambda t: (0.5 * t, 0))
    contacts = [Contact(pushed, "base", FLOOR), Contact(pushed, "left", wall, name="wall")]
    assert Scene([pushed], contacts).run(until=0.4, dt=1e-2).finished
    assert pushed.velocity[0] == pytest.approx(0.5)

    soft = ElasticSolid(
        rectangle((1, 1), (0.4, 0.4)), youngs_modulus=1e6, poisson_ratio=0.0, density=1e3
    )
    top = lid(2, 0.4, lambda t: -0.5 * t)
    contacts = [Contact(soft, "base", FLOOR, "gap"), Contact(soft, "top", top, "gap", name="lid")]
    assert Scene([soft], contacts, ThetaScheme(1.0)).run(until=0.1, dt=1e-2).finished

    rod = rectangle((1, 1), (0.05, 0.8))
    turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    rod.mesh.geometry.x[:, :2] = rod.mesh.geometry.x[:, :2] @ turn.T
    rod.mesh.geometry.x[:, 1] -= rod.mesh.geometry.x[:, 1].min()
    top = lid(2, rod.mesh.geometry.x[:, 1].max(), lambda t: -0.2 * t)
    leaning = RigidSolid(rod, mass=1.0)
    contacts = [
        Contact(leaning, "base", FLOOR, "gap"),
        Contact(leaning, "top", top, "gap", name="lid"),
    ]
    history = Scene([leaning], contacts, ThetaScheme(1.0)).run(until=0.5, dt=5e-3)
    assert history.finished and abs(leaning.velocity[2]) > 0.1


@pytest.mark.parametrize("velocity", [(0, 0), (0, 1), (0, -3), (1, 0), (0.3, 2)])
@pytest.mark.parametrize("traction, falls", [(750.0, False), (2500.0, True)])
def test_whether_friction_bears_a_load_does_not_depend_on_how_the_floor_moves(
    velocity, traction, falls
):
    block = ElasticSolid(
        rectangle((2, 2), (0.4, 0.4)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1e3,
        gravity=(0, -G),
        tractions={"top": (traction, 0)},
    )
    floor = Moved(FLOOR, lambda t: (velocity[0] * t, velocity[1] * t))
    contact = Contact(block, "base", floor, "gap", friction=0.5, name="floor")
    history = Scene([block], [contact], QuasiStatic()).run(until=0.01, dt=5e-3)
    if falls:
        assert "contacts cannot hold 'elastic' against turning" in history.reason
    else:
        np.testing.assert_allclose(contact.force.sum(axis=0), (-300, 1600), rtol=1e-9)
