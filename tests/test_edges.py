# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edges of obstacles at which a step ends to the last digit, as nice numbers let it do."""

from itertools import product

import numpy as np
import pytest
from scenes import box, rectangle

from fenicsx_contact import (
    Contact,
    Curve,
    ElasticSolid,
    HalfSpace,
    Polyhedron,
    RigidSolid,
    Scene,
    ThetaScheme,
    Union,
    Wedge,
)

G, V = 10.0, 1.0


def ground(kind, at, way, fall):
    """Level up to x = ``at``, as one goes along ``way`` (1 or -1); it falls by an angle from there
    on, or rises."""
    out = way * np.sin(fall), np.cos(fall)
    faces = [HalfSpace((at, 0), (0, 1)), HalfSpace((at, 0), out)]
    if kind == "curve":
        points = [(at - way, 0), (at, 0), (at + way * np.cos(fall), -np.sin(fall))]
        return Curve(points[::way])
    if kind == "wedge":
        return Wedge((at, 0), (way * np.sin(fall / 2), np.cos(fall / 2)), np.pi - fall)
    return (
        Polyhedron(faces)
        if kind == "faces"
        else Union([Polyhedron(faces), Curve([(-9, -1), (9, -1)])])
    )


def crosses(obstacle, way, dt, law="velocity", theta=0.5, mu=0.0, **options):
    block = RigidSolid(
        rectangle((1, 1), (0.2, 0.1)), mass=2.0, gravity=(0, -G), velocity=(way * V, 0)
    )
    contact = Contact(block, "base", obstacle, law, friction=mu)
    history = Scene([block], [contact], ThetaScheme(theta), **options).run(until=0.25, dt=dt)
    assert history.reason == "finished"
    return block, history


@pytest.mark.quick
@pytest.mark.parametrize("kind", ["curve", "faces", "wedge", "union"])
@pytest.mark.parametrize("way, fall", [(1, 0.05), (-1, 0.05), (1, 0.8), (-1, 0.01)])
def test_what_ends_a_step_on_an_edge_goes_over_it(kind, way, fall):
    for options in ({}, {"locate_impacts": True}):
        block, history = crosses(ground(kind, way * 0.2, way, fall), way, 1e-2, **options)
        beside, _ = crosses(ground(kind, way * (0.2 + 1e-7), way, fall), way, 1e-2, **options)
        np.testing.assert_allclose(block.velocity, beside.velocity, atol=1e-6 * V)
        assert history["newton"].max() <= 5


@pytest.mark.parametrize("kind, way", product(["curve", "union"], [1, -1]))
@pytest.mark.parametrize(
    "law, theta, mu", [("velocity", 1.0, 0.0), ("gap", 1.0, 0.1), ("velocity", 0.5, 0.1)]
)
def test_so_by_other_laws_and_schemes(kind, way, law, theta, mu):
    at = way * (0.2 - mu * G * 0.1**2 / 2)  # where it is after ten steps
    obstacle = ground(kind, at, way, 0.05)
    _, history = crosses(obstacle, way, 1e-2, law, theta, mu)
    total = history["kinetic"] + history["potential"]
    assert (np.diff(total) <= 1e-9 * total[0]).all()


@pytest.mark.parametrize("rise", [0.05, 0.3])
def test_into_what_rises_as_a_hair_beside_it(rise):
    block, _ = crosses(ground("curve", 0.2, 1, -rise), 1, 1e-2)
    beside, _ = crosses(ground("curve", 0.2 - 1e-7, 1, -rise), 1, 1e-2)
    np.testing.assert_allclose(block.velocity, beside.velocity, atol=1e-4 * V)


@pytest.mark.parametrize("soft", [False, True])
def test_in_space(soft):
    def crosses(at):
        mesh = box((1, 1, 1), (0.2, 0.2, 0.1))
        motion = {"gravity": (0, 0, -G), "velocity": (V, 0, 0)}
        if soft:
            block = ElasticSolid(mesh, youngs_modulus=1e6, poisson_ratio=0.3, density=1e3, **motion)
        else:
            block = RigidSolid(mesh, mass=4.0, **motion)
        out = np.sin(0.025), 0, np.cos(0.025)
        tip = Wedge((at, 0, 0), out, np.pi - 0.05, edge=(0, 1, 0))
        history = Scene([block], [Contact(block, "base", tip)]).run(until=0.15, dt=1e-2)
        assert history.reason == "finished"
        return history["kinetic"]

    np.testing.assert_allclose(crosses(0.2), crosses(0.2 + 1e-7), rtol=1e-6)


def test_a_run_resumed_on_an_edge_is_the_same(tmp_path):
    def begun():
        block = RigidSolid(
            rectangle((1, 1), (0.2, 0.1)), mass=2.0, gravity=(0, -G), velocity=(V, 0)
        )
        return block, Scene([block], [Contact(block, "base", ground("curve", 0.2, 1, 0.05))])

    whole, scene = begun()
    scene.run(until=0.25, dt=1e-2, directory=tmp_path / "whole")
    _, scene = begun()
    scene.run(until=0.1, dt=1e-2, directory=tmp_path / "parts")
    again, scene = begun()
    scene.run(until=0.25, dt=1e-2, directory=tmp_path / "parts", resume=True)
    np.testing.assert_array_equal(again.velocity, whole.velocity)
