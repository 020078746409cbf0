# SPDX-License-Identifier: LGPL-3.0-or-later
"""Obstacles that turn: what they drag along, what they lift."""

from __future__ import annotations

import numpy as np
import pytest
from corpus_meshes import moved
from scenes import FLOOR, G, box, rectangle

from fenicsx_contact import (
    Circle,
    Contact,
    HalfSpace,
    InputError,
    Moved,
    RigidSolid,
    Scene,
    Sphere,
    ThetaScheme,
    Turned,
    torques,
)
from fenicsx_contact.contact.wall import Wall
from fenicsx_contact.theory.scheme import Step

SPIN = 2.0


@pytest.mark.parametrize("angle", [lambda t: 3 * t, lambda t: 40 + np.sin(5 * t)])
@pytest.mark.parametrize("axis", [None, (1, -2, 2)])
def test_material_goes_round(angle, axis):
    """As a rigid body, at any rate, with what moves within it."""
    way = (lambda t: (t, t**2)) if axis is None else (lambda t: (t, t**2, -t))
    inner = Moved((Circle if axis is None else Sphere)(way(0), 1.0), way)
    about = np.arange(1.0, 1.0 + len(way(0)))
    wall = Wall(Turned(inner, about, angle, axis))
    x, start, end = np.random.default_rng(1).random((5, len(about))), 0.3, 0.42

    def place(first, time):
        """Of material of the circle that began there."""
        a, r = angle(time), first + way(time) - about
        if axis is None:
            return about + r @ np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
        k = np.array(axis) / 3
        along = np.outer(r @ k, k)
        return about + along + np.cos(a) * (r - along) + np.sin(a) * np.cross(k, r)

    moment = 1e-5
    rate = (place(x, end) - place(x, end - moment)) / moment
    np.testing.assert_allclose(wall.velocity(place(x, end), end - moment, end), rate, atol=1e-3)
    both = (wall.velocity(place(x, end), *each) for each in ((end - moment, end), (start, end)))
    for found in both:  # of one body, but for what moves within it, which is the same for all
        stretch = (found[1:] - found[0]) * (place(x, end)[1:] - place(x, end)[0])
        np.testing.assert_allclose(stretch.sum(axis=1), 0.0, atol=1e-12)


@pytest.mark.parametrize("law", ["velocity", "gap"])
@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_a_box_rides_on_a_turntable(law, theta):
    """It goes round with it as long as friction bears m r spin²: for good."""
    mesh = moved(box((2, 2, 1), (0.1, 0.1, 0.04)), 1.0, 0.0, 0.0)
    solid = RigidSolid(mesh, mass=2.0, gravity=(0, 0, -G), velocity=(0, SPIN, 0), spin=(0, 0, SPIN))
    table = Turned(HalfSpace((0, 0, 0), (0, 0, 1)), (0, 0, 0), lambda t: SPIN * t, (0, 0, 1))
    contact = Contact(solid, "base", table, law, friction=0.5, name="table")
    scene = Scene([solid], [contact], ThetaScheme(theta))
    history = scene.run(0.5, 0.01, probes=torques(contact, (0, 0, 0)))
    assert history.finished and not history.remarks
    turned = np.array([np.cos(SPIN * 0.5), np.sin(SPIN * 0.5)])
    second = theta == 0.5  # by theta = 1 it goes inwards by dt² spin²/2 of the radius a step
    np.testing.assert_allclose(solid.place[:2], turned, atol=5e-5 if second else 0.02)
    np.testing.assert_allclose(np.hypot(*solid.place[:2]), 1.0, atol=1e-9 if second else 0.011)
    size = np.hypot(history["table.force_x"], history["table.force_y"])[1:]
    np.testing.assert_allclose(size, 2.0 * SPIN**2, rtol=1e-4 if second else 0.011)


@pytest.mark.parametrize("dt", [0.007, 0.0049, 0.0045])
def test_a_table_takes_a_box_along(dt):
    """Its corners bear alike, by steps of any length: errors of the loop added up to gaps that no
    motion of a rigid box closes, and two of the corners took over the load of the others."""
    mesh = moved(box((1, 1, 1), (0.02, 0.02, 0.01)), 0.49, -0.01, 0.0)
    solid = RigidSolid(mesh, mass=0.1, gravity=(0, 0, -G))
    table = Turned(HalfSpace((0, 0, 0), (0, 0, 1)), (0, 0, 0), lambda t: 3 * t, (0, 0, 1))
    contact = Contact(solid, "base", table, friction=0.3)
    history = Scene([solid], [contact]).run(0.495, dt, probes={"spin": lambda: solid.velocity[5]})
    assert history.finished and not history.remarks
    np.testing.assert_allclose(history["spin"][-1], 2.8460, rtol=2e-3)
    assert np.ptp(contact.coupling.gaps()) < 1e-15


@pytest.mark.parametrize("law", ["velocity", "gap"])
def test_a_table_is_tilted(law):
    """What lies on it slips at the angle of friction, however far it is from what that turns about;
    it is lifted by the way, and the work of that is in the books."""
    friction, rate, arm = 0.3, 0.05, 0.5
    block = RigidSolid(
        moved(rectangle((2, 1), (0.1, 0.02)), arm, 0.0), mass=1.0, gravity=(0, -G),
        velocity=(-0.01 * rate, rate * arm), spin=rate,
    )  # fmt: skip
    table = Turned(FLOOR, (0, 0), lambda t: rate * t)
    contact = Contact(block, "base", table, law, friction=friction, name="table")
    slips = np.arctan(friction) / rate
    probes = {"along": lambda: np.hypot(*block.place)}
    history = Scene([block], [contact]).run(1.05 * slips, 0.05, probes=probes)
    assert history.finished
    gone = history["along"] - np.hypot(arm, 0.01)
    rests = history.time < 0.99 * slips
    # what it is held with turns, and m r rate² is 1.4e-4 of its weight
    np.testing.assert_allclose(gone[rests], 0.0, atol=1e-8)
    late = history.time[-1] - slips
    np.testing.assert_allclose(
        gone[-1], -G * rate * late**3 / (6 * np.cos(np.arctan(0.3))), rtol=0.1
    )


@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_a_cam_lifts_its_follower(theta):
    """A round disc about a point off its centre. Turned or moved it is one cam, but for what it
    rubs, and nothing does that here."""
    radius, off, speed, runs = 0.1, 0.02, 6.0, []
    ways = (
        Turned(Circle((off, 0), radius), (0, 0), lambda t: speed * t),
        Moved(
            Circle((off, 0), radius),
            lambda t: (off * (np.cos(speed * t) - 1), off * np.sin(speed * t)),
        ),
    )
    for cam in ways:
        follower = RigidSolid(
            moved(rectangle((1, 1), (0.02, 0.05)), 0.0, radius),
            mass=0.3, gravity=(0, -G), velocity=(0, off * speed), held=("x", "turning"),
        )  # fmt: skip
        contact = Contact(follower, "base", cam, "gap", name="cam")
        runs.append(Scene([follower], [contact], ThetaScheme(theta)).run(0.5, 1e-3))
        assert runs[-1].finished
    # what the wall rubs with counts across normals that turn in a step: of second order
    for column in ("kinetic", "potential"):
        np.testing.assert_allclose(runs[0][column], runs[1][column], atol=1e-5)
    np.testing.assert_allclose(runs[0]["cam.force_y"], runs[1]["cam.force_y"], atol=0.1)


def test_a_step_that_was_tried_leaves_nothing():
    """Jumps at the start of a step were those of velocities there and of arms where the last try
    had turned the body: what touched in a heap let go in flights to an impact, by their number."""

    def tried(*lengths):
        block = RigidSolid(
            rectangle((2, 1), (0.1, 0.02)), mass=1.0, gravity=(0, -G), velocity=(0.1, -1), spin=5.0
        )
        table = Turned(FLOOR, (0, 0), lambda t: 0.3 * t)
        contact = Contact(block, "base", table, friction=0.3)
        scene = Scene([block], [contact])
        for length in lengths:
            scene.stepper.attempt(Step(length, scene.scheme, 0.0))
        return np.concatenate([block.trial_velocity, contact.jump.ravel(), contact.start_jump_n])

    np.testing.assert_allclose(tried(0.05, 1e-3), tried(1e-3), rtol=1e-12, atol=1e-14)


def test_what_turns_no_table():
    """Refused, with what is wrong."""
    for made, message in (
        (lambda: Turned("floor", (0, 0), np.sin), "obstacle = 'floor'"),
        (lambda: Turned(FLOOR, (0, 0), 1.0), "angle = 1.0: must be a function of the time"),
        (lambda: Turned(FLOOR, (0, 0, 0), np.sin), "about"),
        (lambda: Turned(FLOOR, (0, 0), np.sin, (0, 0, 1)), "axis = .*None for an obstacle in the"),
        (lambda: Turned(Sphere((0, 0, 0), 1.0), (0, 0, 0), np.sin), "axis = None: must be 3"),
        (lambda: Turned(Sphere((0, 0, 0), 1.0), (0, 0, 0), np.sin, (0, 0, 0)), "axis"),
        (lambda: Turned(FLOOR, (0, 0), lambda t: (t, t)), r"angle\(0\)"),
        (lambda: Turned(FLOOR, (0, 0), lambda t: np.nan), r"angle\(0\)"),
    ):
        with pytest.raises(InputError, match=message):
            made()


@pytest.mark.parametrize("law", ["velocity", "gap"])
@pytest.mark.parametrize("theta", [0.5, 1.0])
@pytest.mark.parametrize("clearance", [0.0, 1e-6])
def test_a_block_slides_out_of_a_slot_that_turns(clearance, theta, law):
    """r = r0 cosh(spin t), in whole steps: chords of what Coriolis turns aside dip deeper into both
    faces than those of what goes round with them."""
    spin, half, start, dt = 3.0, 5e-3, 0.8, 0.01
    place, speed = 0.1 * np.cosh(spin * start), 0.1 * spin * np.sinh(spin * start)
    block = RigidSolid(
        moved(rectangle((1, 1), (0.04, 2 * half)), place, -half),
        mass=1.0, velocity=(speed, spin * place), spin=spin,
    )  # fmt: skip
    faces = {"base": ((0, -half), (0, 1)), "top": ((0, half + clearance), (0, -1))}
    contacts = [
        Contact(block, side, Turned(HalfSpace(*face), (0, 0), lambda t: spin * t), law)
        for side, face in faces.items()
    ]
    history = Scene([block], contacts, ThetaScheme(theta)).run(3 * dt, dt)
    assert history.finished and not [told for _, told in history.remarks if "through" in told]
    exact = 0.1 * np.cosh(spin * (start + 3 * dt))
    np.testing.assert_allclose(np.hypot(*block.place), exact, rtol=2e-5 if theta < 1 else 3e-4)
