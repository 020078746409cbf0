# SPDX-License-Identifier: LGPL-3.0-or-later
"""What must not matter: who looks at it, how nodes are numbered, how a surface slides in itself."""

from __future__ import annotations

import numpy as np
import pytest
from mpi4py import MPI
from scenes import G, box, rectangle

from fenicsx_contact import (
    Circle,
    Compliance,
    Contact,
    HalfSpace,
    Heap,
    HyperelasticSolid,
    Moved,
    Restitution,
    RigidSolid,
    Scene,
    ThetaScheme,
    Turned,
    name_facets,
    neo_hookean,
)
from fenicsx_contact.base import compat
from fenicsx_contact.contact.mortar.itself import Itself
from fenicsx_contact.contact.surfaces import side_of


@pytest.mark.parametrize(
    "theta, law", [(0.5, "velocity"), (1.0, "velocity"), (0.5, Restitution(0.6))]
)
def test_how_fast_a_frictionless_drum_turns_changes_nothing(theta, law):
    """It slides into itself, seen by who stands or who passes by, and drives nothing."""

    def slid(rate=None, passing=0.0):
        drum = Circle((0.0, -1.5), 1.5)
        if rate is not None:
            drum = Turned(drum, (0.0, -1.5), lambda t: rate * t + 40 * t**2)
        drum = Moved(drum, lambda t: (passing * t, 0.0)) if passing else drum
        mesh = rectangle((3, 2), (0.5, 0.3))
        x = mesh.mesh.geometry.x
        x[:, :2] = x[:, :2] @ [[np.cos(0.1), np.sin(0.1)], [-np.sin(0.1), np.cos(0.1)]] + [
            -0.1,
            0.03,
        ]
        start = {"velocity": (1.5 + passing, 0.0), "spin": 1.0}
        block = RigidSolid(mesh, density=15.0, gravity=(0, -G), **start)
        scene = Scene([block], [Contact(block, "base", drum, law)], ThetaScheme(theta))
        history = scene.run(until=0.16, dt=4e-3)
        assert history.reason == "finished"
        return block.velocity - [passing, 0, 0], history

    still, rest = slid()
    assert rest["impact"][-1] < -0.05
    for rate, passing in ((-30.0, 0.0), (30.0, 5.0)):
        velocity, history = slid(rate, passing)
        np.testing.assert_allclose(velocity, still, atol=2e-4)  # of the rounds
        np.testing.assert_allclose(history["impact"], rest["impact"], atol=1e-4)
        if not passing:
            assert np.abs(history["drive"]).max() < 1e-12


def test_tangential_springs_do_not_know_how_nodes_are_numbered():
    """An elastic brick twists while it turns about the normal of the floor."""

    def spun(seed):
        given = box((2, 2, 1), (1.0, 1.0, 0.4), "hexahedron").mesh
        cells, x = given.geometry.dofmap, given.geometry.x
        cells = cells.array.reshape(-1, 8) if hasattr(cells, "array") else cells
        order = np.random.default_rng(seed).permutation(len(x)) if seed else np.arange(len(x))
        number = np.argsort(order)
        mesh = compat.create_mesh(MPI.COMM_SELF, number[cells], x[order], "hexahedron")
        mesh = name_facets(mesh, {"base": lambda x: np.isclose(x[2], 0.0)})
        brick = HyperelasticSolid(
            mesh,
            energy=neo_hookean(3e3, 0.3),
            density=10.0,
            gravity=(0, 0, -G),
            velocity=lambda x: np.stack([-6 * x[1], 6 * x[0], 0 * x[0]]),
        )
        law = Compliance(1e4, 1.0, tangential_stiffness=2e3)
        floor = HalfSpace((0, 0, 0), (0, 0, 1))
        return Scene([brick], [Contact(brick, "base", floor, law, friction=0.8)]).run(
            until=0.1, dt=5e-3
        )

    first, *others = (spun(seed) for seed in (0, 1, 2))
    assert first["friction"][-1] < -1.0
    for other in others:
        np.testing.assert_allclose(other["friction"], first["friction"], rtol=1e-9, atol=1e-9)


def l_shaped():
    """A step 0.15 m high and its foot, in quadrilaterals; all that faces up or right: top."""
    places = [(x, y) for y in (-0.5, -0.15, 0.0) for x in (-1.0, -0.5, 0.0, 0.5, 1.0)]
    cells = [(i, i + 1, i + 5, i + 6) for i in (0, 1, 2, 3, 5, 6)]
    used = np.unique(cells)
    cells = np.searchsorted(used, cells)
    mesh = compat.create_mesh(MPI.COMM_SELF, cells, np.array(places)[used], "quadrilateral")
    return name_facets(
        mesh,
        {
            "top": lambda x: (
                np.isclose(x[1], 0)
                | (np.isclose(x[1], -0.15) & (x[0] > -1e-9))
                | (np.isclose(x[0], 0) & (x[1] > -0.15 - 1e-9))
            )
        },
    )


@pytest.mark.parametrize("speed", [0.0, 3.0, 30.0])
def test_who_passes_by_sees_what_contacts_give(speed):
    """A block tips over the edge of a step, and its means over facets jump: 0.03 of its energy."""
    step = RigidSolid(l_shaped(), mass=1e3, velocity=(speed, 0), name="step")
    mesh = rectangle((2, 2), (0.6, 0.2), comm=MPI.COMM_SELF)
    mesh.mesh.geometry.x[:, 0] -= 0.08
    block = RigidSolid(mesh, density=10.0, gravity=(0, -G), velocity=(speed, 0), name="block")
    contact = Contact(block, "base", (step, "top"), "gap", friction=0.3)
    history = Scene([step, block], [contact]).run(until=0.1, dt=5e-3)
    assert "contacts would have given 0.026" in history.reason
    np.testing.assert_allclose(history["time"][-1], 0.05)


def test_a_heap_that_travels_takes_the_same_steps():
    """Two boxes and a thin plate that come together, and go 30 m/s beside that."""

    def met(speed):
        def slab(size, corner, **solid):
            mesh = rectangle((1, 1), size, comm=MPI.COMM_SELF).mesh
            mesh.geometry.x[:, :2] += np.add(corner, (size[0] / 2, 0.0))
            skin = name_facets(mesh, {"skin": lambda x: np.full(x.shape[1], True)})
            return RigidSolid(skin, density=10.0, **solid)

        plate = slab((2.0, 0.02), (-1.0, -0.02), velocity=(speed, 0.3), name="plate")
        one = slab((0.2, 0.2), (-0.3, 0.003), velocity=(speed, 0.0), spin=0.2, name="one")
        other = slab((0.2, 0.2), (0.1, 0.003), velocity=(speed, -0.5), name="other")
        bodies = [plate, one, other]
        heap = Heap(bodies, "skin", friction=0.3)
        history = Scene(bodies, [heap], locate_impacts=False).run(until=0.04, dt=2e-3)
        assert history.finished
        return history["time"], [body.velocity - [speed, 0, 0] for body in bodies]

    (times, still), (others, passing) = met(0.0), met(30.0)
    np.testing.assert_allclose(others, times, atol=1e-12)
    np.testing.assert_allclose(passing, still, atol=1e-9)


@pytest.mark.parametrize("angle", [1.0, 2.0, 3.1])
def test_which_facet_of_one_surface_is_the_slave_does_not_hang_on_the_world(angle):
    """The order of the facets of one surface, of a body that is turned as a whole."""

    def order(angle):
        mesh = rectangle((6, 8), (0.36, 0.80), comm=MPI.COMM_SELF).mesh
        x = mesh.geometry.x
        x[:, 0] += 0.3 * x[:, 1] ** 2 + 0.1 * x[:, 0] * x[:, 1]
        c, s = np.cos(angle), np.sin(angle)
        x[:, :2] = x[:, :2] @ [[c, s], [-s, c]]
        skin = name_facets(mesh, {"skin": lambda x: np.full(x.shape[1], True)})
        side = side_of(RigidSolid(skin, mass=1.0), "skin")
        middles = side.nodes[side.corners].mean(axis=1)
        admits, facets = Itself(side), np.arange(len(middles))
        one, other = (each.ravel() for each in np.meshgrid(facets, facets))
        may = admits(one, other, np.zeros(len(one))).reshape(len(facets), -1)
        lies = np.lexsort((middles @ [[c, -s], [s, c]]).round(9).T)  # in the turned world, too
        return may[np.ix_(lies, lies)]

    np.testing.assert_array_equal(order(angle), order(0.0))
