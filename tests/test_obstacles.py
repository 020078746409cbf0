# SPDX-License-Identifier: LGPL-3.0-or-later
"""Obstacles: level sets and their derivatives, curvature in Newton's method, walls that move."""

from __future__ import annotations

import re
import sys
from threading import Thread

import numpy as np
import pytest
import ufl
from corpus_meshes import moved
from dolfinx import fem
from scenes import FLOOR, G, box, energy_size, rectangle, total_energy

from fenicsx_contact import (
    Box,
    Circle,
    Contact,
    Cylinder,
    Discrete,
    ElasticSolid,
    GeneralisedAlpha,
    HalfSpace,
    InputError,
    LevelSet,
    Moved,
    Obstacle,
    QuasiStatic,
    Restitution,
    RigidSolid,
    Scene,
    Sphere,
    ThetaScheme,
    Turned,
    Union,
    name_facets,
)
from fenicsx_contact.base import compat
from fenicsx_contact.contact.leaps import leap
from fenicsx_contact.contact.wall import Wall


def away(x, t, center, axis=None):
    """Distance from a centre or an axis, in UFL."""
    q = x - ufl.as_vector(center)
    if axis is not None:
        q -= ufl.dot(q, ufl.as_vector(axis)) * ufl.as_vector(axis)
    return ufl.sqrt(ufl.dot(q, q))


AXIS = (2 / 3, -1 / 3, 2 / 3)
CENTER = (0.1, -0.2, 0.3)
SAME = {
    "plane": (
        HalfSpace((0.1, -0.2), (3, 4)),
        lambda x, t: 0.6 * (x[0] - 0.1) + 0.8 * (x[1] + 0.2),
    ),
    "plane 3D": (
        HalfSpace(CENTER, AXIS),
        lambda x, t: ufl.dot(x - ufl.as_vector(CENTER), ufl.as_vector(AXIS)),
    ),
    "circle": (Circle((0.1, -0.2), 0.4), lambda x, t: away(x, t, (0.1, -0.2)) - 0.4),
    "ring": (
        Circle((0.1, -0.2), 0.4, inside=True),
        lambda x, t: 0.4 - away(x, t, (0.1, -0.2)),
    ),
    "sphere": (Sphere(CENTER, 0.4), lambda x, t: away(x, t, CENTER) - 0.4),
    "shell": (Sphere(CENTER, 0.4, inside=True), lambda x, t: 0.4 - away(x, t, CENTER)),
    "cylinder": (Cylinder(CENTER, AXIS, 0.4), lambda x, t: away(x, t, CENTER, AXIS) - 0.4),
    "pipe": (
        Cylinder(CENTER, AXIS, 0.4, inside=True),
        lambda x, t: 0.4 - away(x, t, CENTER, AXIS),
    ),
}


@pytest.mark.parametrize("name", SAME)
def test_a_level_set_is_what_its_formula_says(name):
    """Distances, normals and curvature of the ready-made obstacles and of the same in UFL."""
    given, phi = SAME[name]
    level = LevelSet(phi, given.dim)
    points = np.random.default_rng(1).standard_normal((7, given.dim))
    np.testing.assert_allclose(level.distance(points), given.distance(points), atol=1e-14)
    np.testing.assert_allclose(level.normals(points), given.normals(points), atol=1e-14)
    curvature = 0.0 if given.flat else given.curvature(points)
    np.testing.assert_allclose(level.curvature(points) - curvature, 0.0, atol=1e-13)
    assert not level.moving and isinstance(level, Obstacle) and isinstance(given, Obstacle)


def wave(x, t):
    """A wave that travels, no distance: its gradient is not a unit vector."""
    return 2 * x[1] - 0.3 * ufl.sin(3 * x[0] - 2 * t)


OBSTACLES = {
    "ellipse": LevelSet(lambda x, t: x[0] ** 2 / 4 + x[1] ** 2 - 1, 2),
    "wave": LevelSet(wave, 2),
    "wedge": LevelSet(lambda x, t: ufl.max_value(x[0] + x[1], x[0] - 2 * x[1]) + t * x[0], 2),
    "circle": Circle((0.1, -0.2), 0.4),
    "pipe": Cylinder(CENTER, (1, 2, 3), 2.0, inside=True),
    "moved": Moved(Sphere(CENTER, 0.4), lambda t: (t, 0.3 * np.sin(t), -(t**2))),
    "turned": Turned(Cylinder(CENTER, AXIS, 0.4), (1.0, 0.5, 0.2), np.sin, (3, -1, 2)),
    "turned wave": Moved(Turned(LevelSet(wave, 2), (0.3, 0.1), lambda t: 2 * t), lambda t: (t, t)),
    "union": Union([Circle((0.1, -0.2), 0.4), LevelSet(wave, 2), Circle((0.4, 1.9), 0.3)]),
    "moved wave": Moved(LevelSet(wave, 2), lambda t: (ufl.sin(t), 0.2 * t)),
}


def test_a_level_set_is_asked_from_several_threads():
    """Each got distances of the other's points now and then."""
    level, rng = LevelSet(wave, 2), np.random.default_rng(5)
    points = [rng.random((50, 2)) for _ in range(4)]
    here = [level.distance(x) for x in points]
    before, wrong = sys.getswitchinterval(), []

    def asking(x, right):
        wrong.extend(1 for _ in range(1000) if not np.array_equal(level.distance(x), right))

    threads = [Thread(target=asking, args=each) for each in zip(points, here)]
    sys.setswitchinterval(1e-6)
    try:
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    finally:
        sys.setswitchinterval(before)
    assert not wrong


@pytest.mark.parametrize("size", [1.0, 1e-3])
@pytest.mark.parametrize("square", [False, True], ids=["distance", "square"])
def test_a_bowl_whose_middle_is_a_corner(square, size):
    """A level set has no gradient in the middle of a ball: what starts with a corner there falls
    as in a `Circle`."""

    def inside(x, t):
        return 1 - ufl.dot(x, x) / size**2 if square else size - ufl.sqrt(ufl.dot(x, x))

    def fall(bowl):
        block = moved(rectangle((2, 1), (0.4 * size, 0.2 * size)), -0.2 * size, -0.2 * size)
        skin = name_facets(block.mesh, {"all": lambda x: x[0] == x[0]})
        body = RigidSolid(skin, mass=1.0, gravity=(0.0, -G), velocity=(np.sqrt(size), 0.0))
        contact = Contact(body, "all", bowl, friction=0.2)
        history = Scene([body], [contact]).run(until=0.6 * size**0.5, dt=4e-3 * size**0.5)
        assert history.finished
        return body.velocity / size**0.5

    level_set = LevelSet(inside, dim=2)
    assert np.isfinite(level_set.curvature(np.zeros((1, 2)))).all()
    assert level_set.distance(np.zeros((1, 2)))[0] > 0.9 * size
    circle = Circle((0.0, 0.0), size, inside=True)
    np.testing.assert_allclose(fall(level_set), fall(circle), atol=1e-3 if square else 1e-9)


@pytest.mark.parametrize("name", OBSTACLES)
def test_normals_and_curvature_by_differences(name):
    """Curvature everywhere, normals at the surface, where a level set is a distance."""
    obstacle, t, h = OBSTACLES[name], 0.7, 1e-6
    d = obstacle.dim
    x = 0.5 + np.random.default_rng(2).random((9, d))
    for _ in range(60):  # to the surface
        on = x = x - obstacle.distance(x, t)[:, None] * obstacle.normals(x, t)
    np.testing.assert_allclose(obstacle.distance(on, t), 0.0, atol=1e-12)
    normals = obstacle.normals(on, t)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=1e-13)
    for i, step in enumerate(h * np.eye(d)):
        slope = (obstacle.distance(on + step, t) - obstacle.distance(on - step, t)) / (2 * h)
        np.testing.assert_allclose(slope, normals[:, i], atol=1e-8)
        off = on + 0.1
        turn = (obstacle.normals(off + step, t) - obstacle.normals(off - step, t)) / (2 * h)
        np.testing.assert_allclose(obstacle.curvature(off, t)[:, :, i], turn, atol=1e-7)


def test_velocity_of_a_wall():
    """Told, by the motion, or else along the normals as fast as the surface goes."""
    x, start, end = np.random.default_rng(3).random((4, 2)), 0.5, 0.5 + 1e-5
    travelling = Wall(LevelSet(wave, 2))
    normals = travelling.normals(x, end)
    gradient = np.stack([-0.9 * np.cos(3 * x[:, 0] - 2 * end), np.full(4, 2.0)], axis=1)
    size = np.linalg.norm(gradient, axis=1)
    on = x.copy()
    on[:, 1] = 0.15 * np.sin(3 * x[:, 0] - 2 * end)
    speed = -0.6 * np.cos(3 * x[:, 0] - 2 * end) / size
    np.testing.assert_allclose(
        travelling.velocity(on, start, end), speed[:, None] * normals, atol=1e-4
    )
    drum = LevelSet(
        lambda x, t: away(x, t, (0, 0)) - 1, 2, velocity=lambda x, t: (-2 * x[1] * t, 2 * x[0] * t)
    )
    turned = Wall(drum).velocity(x, 0.4, 0.6)
    np.testing.assert_allclose(turned, np.stack([-x[:, 1], x[:, 0]], axis=1), rtol=1e-13)
    carried = Wall(Moved(drum, lambda t: (t, t**2)))
    np.testing.assert_allclose(
        carried.velocity(x, 0.4, 0.6),
        1 + Wall(drum).velocity(x - [0.6, 0.36], 0.4, 0.6),
        rtol=1e-13,
    )


def test_constants_in_the_velocity_of_a_level_set():
    """Of a user's mesh, alone and with the position, of phi and of their own; as they are now."""
    mesh = rectangle().mesh
    rise, slow, fast = (fem.Constant(mesh, value) for value in (0.1, 3.0, 7.0))
    x = np.random.default_rng(4).random((4, 2))
    level = LevelSet(lambda x, t: x[1] - rise, 2, lambda x, t: (fast * x[1] + rise, slow))
    belt = LevelSet(lambda x, t: x[1], 2, velocity=lambda x, t: (slow, 0.0))
    for fast.value, slow.value, rise.value in ((7.0, 3.0, 0.1), (-2.0, 1.0, 0.3)):
        here = np.stack([fast.value * x[:, 1] + rise.value, np.full(4, slow.value)], axis=1)
        np.testing.assert_allclose(level.velocity(x, 0.0), here, rtol=1e-13)
        np.testing.assert_allclose(belt.velocity(x, 0.0), np.outer(here[:, 1], [1, 0]), rtol=1e-13)
    assert level.numbers[0] is rise and belt.numbers == [slow]
    assert sorted(map(id, level.numbers[1:])) == sorted([id(fast), id(slow)])
    np.testing.assert_allclose(level.changes(fast, x)[0], 0.0)
    np.testing.assert_allclose(level.changes(rise, x)[0], -1.0, rtol=1e-13)
    assert not Wall(FLOOR).moving and not Wall(FLOOR).velocity(x, 0.0, 1.0).any()


class Ball:
    """A stranger's obstacle: the least that there is, nothing of it from the package."""

    dim = 2

    def __init__(self, radius):
        self.radius, self.center = radius, np.array([0.03, -radius])

    def distance(self, points):
        return np.linalg.norm(points - self.center, axis=1) - self.radius

    def normals(self, points):
        return (points - self.center) / np.linalg.norm(points - self.center, axis=1)[:, None]


def pressed(obstacle, friction, top=(0.03, -0.05), **scene):
    """A block pressed on something round and drawn over it, in one step."""
    block = ElasticSolid(
        rectangle((16, 8), (0.4, 0.2)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        prescribed={"top": lambda t: (top[0] * t, top[1] * t)},
    )
    # large augmentations keep points that the curvature sets free
    contact = Contact(
        block,
        "base",
        obstacle,
        "gap",
        friction=friction,
        normal_augmentation=0.5 if friction else 0.25,
        tangential_augmentation=0.5 if friction else 0.25,
        name="c",
    )
    return Scene([block], [contact], QuasiStatic(), **{"geometry": "newton", **scene})


@pytest.mark.parametrize(
    ("solver", "friction", "most"),
    [
        ("condensed", 0.0, 5),
        ("condensed", 0.3, 8),
        ("monolithic", 0.0, 5),
        # where lam = 0 exactly its bound has a corner, and round-off chooses the side
        ("monolithic", 0.3, 10),
    ],
)
def test_newton_knows_the_curvature(solver, friction, most):
    """Errors fall quadratically; without curvature linearly, to the same forces."""
    circle = LevelSet(lambda x, t: away(x, t, (0.03, -0.1)) - 0.1, 2)
    scene = pressed(circle, friction, solver=solver)
    history = scene.run(1.0, 1.0)
    assert history.finished and history["newton"].sum() <= most
    errors = np.array(scene.errors[-3:])
    assert errors[1] < 0.1 and errors[2] < 20 * errors[1] ** 2 + 1e-13
    blind = pressed(Ball(0.1), friction, solver="condensed")
    slow = blind.run(1.0, 1.0)
    assert slow.finished and slow["newton"].sum() >= 12
    np.testing.assert_allclose(scene.contacts[0].force, blind.contacts[0].force, atol=1e-3)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_newton_knows_the_curvature_in_space(friction):
    cube = ElasticSolid(
        box((4, 4, 3), (0.4, 0.4, 0.2)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        prescribed={"top": lambda t: (0.01 * t, 0.005 * t, -0.02 * t)},
    )
    ball = Sphere((0.02, 0.01, -0.3), 0.3)
    contact = Contact(cube, "base", ball, "gap", friction, normal_augmentation=0.25, name="c")
    scene = Scene([cube], [contact], QuasiStatic(), geometry="newton")
    history = scene.run(1.0, 1.0)
    assert history.finished and history["newton"].sum() <= 8
    assert scene.errors[-1] < 20 * scene.errors[-2] ** 2 + 1e-13
    assert history["c.bearing"][-1] >= 4 and contact.gap.max() < 1e-9


def thrown(obstacle, **scene):
    block = ElasticSolid(
        rectangle((4, 4), (0.4, 0.4)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        velocity=lambda x: np.stack([0.5 + 0 * x[0], -1.0 - 0.2 * x[0]]),
    )
    return Scene([block], [Contact(block, "base", obstacle, friction=0.3, name="c")], **scene)


def test_a_tilted_level_set_is_a_half_space():
    """The same course of a throw, by either."""
    point, normal = (0.0, -0.04), np.array([-0.2, 1.0]) / np.hypot(0.2, 1.0)
    planes = [
        HalfSpace(point, normal),
        LevelSet(lambda x, t: normal[0] * x[0] + normal[1] * (x[1] + 0.04), 2),
    ]
    histories = [thrown(plane).run(0.03, 5e-4) for plane in planes]
    a, b = (history.rows()[:, 2:10] for history in histories)
    np.testing.assert_allclose(a, b, atol=1e-8 * np.abs(a).max())
    assert histories[0]["c.bearing"].max() > 0


# -- walls that move --


@pytest.mark.parametrize("law", ["velocity", "gap"])
@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_a_wall_that_strikes(law, theta):
    """A floor comes up to a rigid block and drags it aside; exact velocities, no penetration."""
    block = RigidSolid(rectangle((2, 1)), mass=10.0)
    floor = Moved(HalfSpace((0, -0.01), (0, 1)), lambda t: (0.3 * t, 0.5 * t))
    contact = Contact(block, "base", floor, law, friction=0.3, name="c")
    history = Scene([block], [contact], ThetaScheme(theta)).run(0.1, 1e-3)
    assert history.finished
    if law == "gap" and theta == 0.5:  # bounces
        assert block.velocity[1] >= 0.5
    else:
        np.testing.assert_allclose(block.velocity[:3], [0.15, 0.5, 0.0], atol=1e-9)
        loss = 10 * 0.5 * (0.5**2 + (0.3**2 - 0.15**2))
        lost = history["impact"] + history["friction"] + history["scheme"]
        np.testing.assert_allclose(lost[-1], -loss, rtol=1e-8)
        np.testing.assert_allclose(history["drive"][-1], 10 * (0.5**2 + 0.15 * 0.3), rtol=1e-8)
    assert history["c.penetration"].max() < 1e-3 * 0.5 * (law == "velocity") + 1e-12
    books(history)


def books(history, tolerance=1e-11):
    """Energies change by what the books name, to round-off; contacts only dissipate."""
    size = max(energy_size(history), np.abs(history["drive"]).max())
    assert np.abs(history["balance"]).max() <= tolerance * size
    named = sum(history[each] for each in ("impact", "friction", "drive", "scheme", "balance"))
    total = total_energy(history)
    np.testing.assert_allclose(total - total[0], named, atol=tolerance * size)
    assert (history["impact"] + history["friction"]).max() <= tolerance * size


class Lift:
    """A stranger's floor, which rises by 0.1 m/s, and says so, times a factor."""

    dim, flat, moving = 2, True, True

    def __init__(self, factor, start=0.0):
        self.factor, self.start = factor, start

    def distance(self, points, time):
        return points[:, 1] - 0.1 * max(time - self.start, 0.0)

    def normals(self, points):
        return np.tile([0.0, 1.0], (len(points), 1))

    def velocity(self, points, start, end):
        rise = max(end - self.start, 0.0) - max(start - self.start, 0.0)
        return np.tile([0.0, 0.1 * self.factor * rise / (end - start)], (len(points), 1))


def rising(factor, start=0.0):
    """The same as a LevelSet."""
    return LevelSet(
        lambda x, t: x[1] - 0.1 * ufl.max_value(t - start, 0),
        2,
        lambda x, t: ufl.as_vector([0.3, 0.1 * factor * ufl.conditional(t > start, 1.0, 0.0)]),
    )


@pytest.mark.parametrize("law", ["velocity", "gap"])
@pytest.mark.parametrize("kind", [Lift, rising])
@pytest.mark.parametrize("start", [0.0, 0.031])
@pytest.mark.parametrize("factor", [1.0, 0.0, 2.0, -1.0, 1.2])
def test_an_obstacle_goes_as_its_velocity_says(factor, start, kind, law):
    """What says otherwise would throw a block, or let it sink in, without a word."""
    block = RigidSolid(rectangle(), mass=1.0, gravity=(0, -G))
    scene = Scene([block], [Contact(block, "base", kind(factor, start), law, name="c")])
    history = scene.run(0.1, 5e-3)
    told = "along its normal at" in history.reason and "by its distances" in history.reason
    if factor == 1:
        assert history.reason == "finished" and history["c.penetration"].max() < 1e-12
    else:  # or what was put back at once would have made energy
        assert told or (start and law == "gap" and "'energy'" in history.reason)


class Belt(HalfSpace):
    """A stranger's belt: it stays where it is, its material runs."""

    speed = 0.7

    def velocity(self, points):
        return np.tile([self.speed, 0.0], (len(points), 1))


@pytest.mark.parametrize("law", ["velocity", "gap"])
@pytest.mark.parametrize("elastic", [False, True])
def test_a_belt_drags_a_block_along(law, elastic):
    """mu g until it has the belt's speed."""
    mesh = rectangle((4, 2), (0.4, 0.1))
    if elastic:
        block = ElasticSolid(
            mesh, youngs_modulus=1e6, poisson_ratio=0.3, density=1000.0, gravity=(0, -G)
        )
    else:
        block = RigidSolid(mesh, mass=40.0, gravity=(0, -G))
    contact = Contact(block, "base", Belt((0, 0), (0, 1)), law, friction=0.3, name="c")
    scene = Scene([block], [contact], ThetaScheme(1.0, "end"))
    history = scene.run(0.6, 2e-3)
    assert history.finished
    speed = history.impulse("c")[:, 0] / 40.0
    slides = (history.time > 0.05) & (history.time < 0.7 / (0.3 * G) - 0.03)
    np.testing.assert_allclose(speed[slides], 0.3 * G * history.time[slides], rtol=0.05)
    np.testing.assert_allclose(speed[-1], 0.7, rtol=1e-3)
    books(history)
    # what runs the belt pays for the block's speed, and as much again for the slip
    np.testing.assert_allclose(history["drive"][-1], 40 * 0.7**2, rtol=0.01)


@pytest.mark.parametrize("theta", [0.5, 1.0])
@pytest.mark.parametrize("law", ["velocity", "gap"])
def test_a_lift(theta, law):
    """A block rides on a floor that swings: it goes its way."""
    high, pulse = 0.02, 10.0

    def lag(dt):
        block = RigidSolid(rectangle((2, 1)), mass=10.0, gravity=(0, -G))
        lift = Moved(FLOOR, lambda t: (0.0, high * (1 - np.cos(pulse * t))))
        contact = Contact(block, "base", lift, law, friction=0.3, name="c")
        history = Scene([block], [contact], ThetaScheme(theta)).run(1.0, dt)
        assert history.finished and len(history) == round(1 / dt) + 1  # no percussions
        if (law, theta) != ("gap", 0.5):  # which bounces
            books(history)
            assert history["c.bearing"][1:].min() == 3
        gap = float(np.abs(contact.gap).max())
        assert gap < dt**2 / 6 * high * pulse**2 + 1e-12
        return gap

    assert max(lag(dt) for dt in (0.02, 0.01)) < 1e-12


def test_a_circle_moved_into_a_block():
    """The same as the block moved onto the circle: forces agree, with friction, step by step."""
    circle = Circle((0.03, -0.1), 0.1)
    there = pressed(circle, 0.3)
    here = pressed(Moved(circle, lambda t: (-0.03 * t, 0.05 * t)), 0.3, top=(0.0, 0.0))
    for scene in (there, here):
        history = scene.run(1.0, 0.25)
        assert history.finished
        assert np.abs(history["balance"]).max() < 1e-10 * history["strain"].max()
    np.testing.assert_allclose(there.contacts[0].force, here.contacts[0].force, atol=1e-6 * 48190.0)
    a, b = (scene.stepper for scene in (there, here))
    np.testing.assert_allclose(a.work[:3], b.work[:3], atol=1e-6 * a.energies[1])
    assert b.work[2] > 0.9 * b.energies[1]  # what drives the circle pays


SPEED = np.array([-0.5, 1.0])


@pytest.mark.parametrize("geometry", ["newton", "fixed point"])
@pytest.mark.parametrize("law", ["velocity", "gap", "printed", Discrete(1e7, 1e3)])
@pytest.mark.parametrize("elastic", [False, True])
def test_only_relative_motion_counts(elastic, law, geometry):
    """A block thrown at a circle, and a circle thrown at a block: the same impulses."""

    def scene(moved):
        v = np.zeros(2) if moved else -SPEED
        if elastic:
            block = ElasticSolid(
                rectangle((4, 4), (0.4, 0.4)),
                youngs_modulus=1e6,
                poisson_ratio=0.3,
                density=1000.0,
                velocity=lambda x: np.outer(v, np.ones_like(x[0])),
            )
        else:
            block = RigidSolid(rectangle((3, 1), (0.4, 0.4)), mass=160.0, velocity=v, rotation=0.1)
        circle = Circle((0.03, -0.44), 0.4)
        master = Moved(circle, lambda t: SPEED * t) if moved else circle
        contact = Contact(block, "base", master, law, friction=0.3, name="c")
        return Scene([block], [contact], geometry=geometry)

    histories = [scene(moved).run(0.06, 1e-3) for moved in (False, True)]
    assert all(history.finished for history in histories)
    there, here = (history.impulse("c") for history in histories)
    np.testing.assert_allclose(here, there, atol=1e-7 * np.abs(there).max())
    books(histories[1], tolerance=1e-9)  # as far as Newton's method goes


def test_the_fallback_knows_a_moving_wall():
    """A scene in which Newton's method cycles, at rest and carried along."""

    def scene(speed):
        block = RigidSolid(
            rectangle(),
            mass=417.6,
            gravity=(0, -G),
            rotation=1.7e-4,
            about=(-0.18, 0),
            velocity=speed,
        )
        floor = Moved(FLOOR, lambda t: speed * t)
        contact = Contact(block, "base", floor, friction=0.9, tangential_augmentation=1e6, name="c")
        return Scene([block], [contact])

    histories = [scene(speed).run(0.01, 1e-4) for speed in (0 * SPEED, SPEED)]
    assert all(h.finished for h in histories)
    there, here = (history.impulse("c") for history in histories)
    np.testing.assert_allclose(here, there, atol=1e-6 * np.abs(there).max())


def test_a_sudden_start_is_a_blow():
    """A floor at rest that starts at once: the block that stands on it is struck; by theta = 1/2
    it goes with it exactly."""
    block = RigidSolid(rectangle((2, 1)), mass=10.0)
    floor = Moved(FLOOR, lambda t: (0.0, max(0.0, t - 0.01)))
    contact = Contact(block, "base", floor, name="c")
    scene = Scene([block], [contact])
    history = scene.run(0.03, 1e-3)
    np.testing.assert_allclose(block.velocity, [0, 1.0, 0], atol=1e-9)
    assert np.abs(contact.gap).max() < 1e-11
    assert np.count_nonzero(history["dt"] == 0) == 2  # the first row, and the blow
    np.testing.assert_allclose(history["drive"][-1], 10.0, rtol=1e-9)
    np.testing.assert_allclose(history["impact"][-1], -5.0, rtol=1e-9)


@pytest.mark.parametrize("share", [0.0, 1e-7, 0.01, 1 / 3, 0.5, 0.999, 1 - 1e-7])
@pytest.mark.parametrize("located", [False, True])
@pytest.mark.parametrize("ahead", [0.0, 1e-9])
@pytest.mark.parametrize("restitution", [0.5, 1.0])
def test_a_sudden_start_throws_what_rebounds(share, located, ahead, restitution):
    """In the midst of a step as at its start, what touches or is just ahead; steps saw the wall at
    rest where they start, and took the body along: 1 m/s, whatever the step."""
    dt = 1e-3
    block = RigidSolid(moved(rectangle(), 0.0, ahead), mass=10.0)
    floor = Moved(FLOOR, lambda t: (0.0, max(0.0, t - (5 + share) * dt)))
    contact = Contact(block, "base", floor, Restitution(restitution), name="c")
    history = Scene([block], [contact], locate_impacts=located).run(20 * dt, dt)
    assert history.finished and not history.remarks
    # beside an end of a step its speed there is a difference over a time in which it starts
    accuracy = 1e-3 if abs(share - round(share)) == pytest.approx(1e-7) else 1e-8
    assert block.velocity[1] == pytest.approx(1 + restitution, rel=accuracy)
    np.testing.assert_allclose(history["drive"][-1], 10 * (1 + restitution), rtol=accuracy)


@pytest.mark.parametrize("law", ["gap", "lagrange", Discrete(stiffness=1e9)])
@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("after", [0.0, 0.37])
def test_laws_without_percussions_see_a_sudden_start(law, friction, after):
    """At the end of a step, too, jumps of the next one were against the floor at rest, and its
    certificate asked who had given a quarter of the energy; within one springs stopped."""
    dt, mass, speed = 1e-4, 10.0, 0.5
    start = (100 + after) * dt
    block = RigidSolid(rectangle(), mass=mass, gravity=(0, -G))
    floor = Moved(FLOOR, lambda t: (0.0, speed * max(0.0, t - start)))
    history = Scene([block], [Contact(block, "base", floor, law, friction)]).run(0.02, dt)
    assert history.finished and not history.remarks
    if law in ("gap", "lagrange"):  # whose mean velocity is the floor's in a step
        flies = 2 * speed - G * (history.time[-1] - 101 * dt)
        assert block.velocity[1] == pytest.approx(flies, rel=1e-9)
    assert np.abs(history["balance"]).max() < 1e-9 * mass * speed**2


STAIRS = np.arange(11) / 10, 2e-3 * ((np.arange(11) + 1) // 2)
TABLE = np.arange(401) / 200, 0.01 * np.sin(np.pi / 25 * np.arange(401))
SHAKES = {
    "stops": lambda t: 0.03 * min(t, 0.1),
    "goes up in steps": lambda t: float(np.interp(t, *STAIRS)),
    "goes up and down": lambda t: 0.01 * np.sin(8 * np.pi * t),
    "table": lambda t: float(np.interp(t, *TABLE)),
}


@pytest.mark.parametrize(
    "scheme", [ThetaScheme(0.5), ThetaScheme(0.6), ThetaScheme(0.75), GeneralisedAlpha(0.8)]
)
@pytest.mark.parametrize("shake", SHAKES)
def test_nothing_sinks_into_a_floor_that_shakes(scheme, shake):
    """What leaves a floor that slows down by less than it falls back in a step came back at its end
    with as much speed, was not struck, and sank by half of it, each time."""
    dt, way = 0.01, SHAKES[shake]
    floor = Moved(FLOOR, lambda t: (0.0, way(t)))
    block = RigidSolid(rectangle(), mass=1.0, gravity=(0, -G), velocity=(0, way(dt) / dt))
    history = Scene([block], [Contact(block, "base", floor, name="c")], scheme).run(1.0, dt)
    assert history.finished
    assert history["c.penetration"].max() < 1e-9


@pytest.mark.parametrize("speed", [0.01, 0.03, 0.045, 0.06])
@pytest.mark.parametrize("scheme", [ThetaScheme(0.5), ThetaScheme(0.6), GeneralisedAlpha(0.8)])
@pytest.mark.parametrize("kind", ["rigid", "elastic"])
def test_what_is_thrown_up_slowly_lands_within_a_step(speed, scheme, kind):
    dt = 0.01
    if kind == "rigid":
        block = RigidSolid(rectangle(), mass=1.0, gravity=(0, -G), velocity=(0, speed))
    else:
        loads = {"gravity": (0, -G), "velocity": (0, speed)}
        block = ElasticSolid(
            rectangle((4, 4)), youngs_modulus=1e8, poisson_ratio=0.3, density=1e3, **loads
        )
    history = Scene([block], [Contact(block, "base", FLOOR, name="c")], scheme).run(0.1, dt)
    assert history.finished
    assert history["c.penetration"].max() < 1e-2 * speed * dt


@pytest.mark.parametrize("slide, spin", [(0.0, 0.0), (10.0, 0.0), (0.0, 10.0), (3.0, 2.0)])
def test_so_does_what_slides_and_turns_along_the_floor(slide, spin):
    plate = RigidSolid(
        box(size=(0.4, 0.4, 0.1)),
        mass=1.0,
        gravity=(0, 0, -G),
        velocity=(slide, 0, 0.015),
        spin=(0, 0, spin),
    )
    floor = HalfSpace((0, 0, 0), (0, 0, 1))
    history = Scene([plate], [Contact(plate, "base", floor, name="c")]).run(0.05, 4e-3)
    assert history.finished
    assert history["c.penetration"].max() < 1e-12
    assert history["impact"][-1] == pytest.approx(-0.5 * 0.015**2, rel=1e-6)


@pytest.mark.parametrize("theta", [0.75, 1.0])
def test_a_sudden_start_that_takes_along_is_remarked(theta):
    block = RigidSolid(rectangle(), mass=10.0)
    floor = Moved(FLOOR, lambda t: (0.0, max(0.0, t - 0.0055)))
    contact = Contact(block, "base", floor, Restitution(1.0))
    history = Scene([block], [contact], ThetaScheme(theta)).run(0.02, 1e-3)
    assert history.finished
    assert [time for time, _ in history.remarks] == pytest.approx([0.006])
    assert "does not rebound" in history.remarks[0][1]


def test_what_is_no_sudden_start():
    """Speeds that change smoothly, or away from what is there, cut no step."""
    for way in (
        lambda t: 3 * t * t,
        lambda t: 1e-3 * np.sin(300 * t),
        lambda t: min(0, 0.0105 - t),
    ):
        block = RigidSolid(rectangle(), mass=10.0, gravity=(0, -G))
        floor = Moved(FLOOR, lambda t, way=way: (0.0, way(t)))
        history = Scene([block], [Contact(block, "base", floor, Restitution(0.5))]).run(0.02, 1e-3)
        assert history.finished
        dt = history["dt"][history["dt"] > 0]
        np.testing.assert_allclose(dt, 1e-3, rtol=1e-9)


@pytest.mark.parametrize("law", ["velocity", "gap"])
@pytest.mark.parametrize("at", [0.0105, 0.01, 0.00999999, 0.0])
@pytest.mark.parametrize("drift", [0.0, 0.3])
def test_a_floor_that_jumps_is_refused(at, law, drift):
    """In the midst of a step, at its end, right before that, just after t = 0, at rest or sliding:
    by theta < 1 it would throw the block at 1 km/s; by theta = 1 it arrives within the step."""
    ends = []
    for theta in (0.5, 0.75, 1.0):
        block = RigidSolid(rectangle((2, 1)), mass=10.0, gravity=(0, -G))
        floor = Moved(FLOOR, lambda t: (drift * t, 1e-4 * (t > at)))
        scene = Scene([block], [Contact(block, "base", floor, law)], ThetaScheme(theta))
        ends.append(scene.run(0.02, 1e-3, progress=False))
    for history in ends[:-1]:
        assert history.time[-1] <= at + 1e-12
        assert history["kinetic"].max() < 1e-9
        assert f"jumps by 0.0001 m at t = {at:.9g} s" in history.reason
        assert "obstacle jumps" in history.reason
    assert ends[-1].finished


@pytest.mark.parametrize("theta", [0.5, 1.0])
@pytest.mark.parametrize("size", [1e-3, 0.5, 1000.0])
def test_a_floor_that_jumps_between_located_impacts_is_refused(theta, size):
    """While a block falls, in an instant with which a step ends: parts of steps are as short as the
    clock tells, in which it would be thrown as fast."""
    block = RigidSolid(rectangle((2, 1)), mass=10.0, gravity=(0, -G))
    below = HalfSpace([0.0, -0.0025], [0.0, 1.0])
    floor = Moved(below, lambda t: (0.0, size if t >= 0.02 else 0.0))
    contact = Contact(block, "base", floor, name="c")
    scene = Scene([block], [contact], ThetaScheme(theta), locate_impacts=True)
    history = scene.run(0.1, 1e-3, progress=False)
    assert re.search("jumps by .* m at t = 0.02 s: no velocity follows that", history.reason)
    np.testing.assert_allclose(block.velocity[1], -G * 0.02, rtol=1e-6)


@pytest.mark.parametrize("start", [0.0, 1e-17, 0.3, 1 / 3, 93 * 0.1, 1.0, 1 - 1e-13, 1 - 1e-9])
def test_what_jumps_and_what_does_not(start):
    """Starts, cusps and wiggles are continuous however near the end they are; jumps are found, of
    what stands and of what goes."""

    def found(motion):
        width = 0.01
        return leap(lambda t: np.array([motion(t)]), start - width, start + width / 3, 1e-14)

    for power in (0.3, 0.5, 1, 2):
        assert found(lambda t, power=power: 100 * max(0.0, t - start) ** power) is None
    assert found(lambda t: 100 * max(0.0, t - np.nextafter(start + 0.01 / 3, 0))) is None
    assert found(lambda t: np.sin(1e4 * t)) is None
    assert found(lambda t: 0.0) is None and found(lambda t: 3.0 * t) is None
    for pace in (0.0, 0.03):
        jump = found(lambda t, pace=pace: pace * t + 1e-3 * (t > start))
        assert jump.size == pytest.approx(1e-3, rel=1e-6)
        assert jump.time == pytest.approx(start, abs=1e-15 + 1e-15 * start)


def test_located_impacts_of_a_moving_wall():
    block = RigidSolid(rectangle((2, 1)), mass=10.0)
    floor = Moved(HalfSpace((0, -0.0123), (0, 1)), lambda t: (0.0, 0.5 * t))
    contact = Contact(block, "base", floor, name="c")
    history = Scene([block], [contact], locate_impacts=True).run(0.05, 5e-3)
    struck = history.time[np.flatnonzero(history["dt"][1:] == 0) + 1]
    np.testing.assert_allclose(struck, [0.0246], rtol=1e-6)
    assert np.abs(contact.gap).max() < 1e-9


@pytest.mark.parametrize("name", ["box", "circle", "plane"])
def test_a_step_that_failed_leaves_nothing_in_the_state(name):
    """The state after a run that stopped is that of its last good step, wherever an obstacle was
    to go in the step that failed, and asks it nothing: where the obstacle raised then, no
    checkpoint was left, and what had stopped the run was not told."""
    wall = {
        "box": Box((-0.2, -0.15), (0.6, 0.3)),
        "circle": Circle((0.0, -1.0), 1.0),
        "plane": HalfSpace((0.0, 0.0), (0.0, 1.0)),
    }[name]
    refuses = []

    def motion(t):
        if refuses and t > 0.05:
            raise ValueError("no more")
        return 0.3 * t, 0.05 * np.sin(20 * t)

    def start():
        body = rectangle((4, 2), (0.4, 0.2))
        solid = RigidSolid(body, mass=1.0, gravity=(0, -G), velocity=(0.5, -0.3))
        return Scene([solid], [Contact(solid, "base", Moved(wall, motion), friction=0.3)])

    whole, good = start(), start()
    whole.run(until=0.15, dt=5e-3)
    good.run(until=0.05, dt=5e-3)
    refuses.append(True)
    stopped = start()
    reason = stopped.run(until=0.15, dt=5e-3).reason
    assert "no more" in reason and "steps down to" in reason
    state = stopped.state()
    refuses.clear()
    for key, array in good.state().items():
        if key.split(".")[-1] not in ("units", "octave", "most"):  # of what is tried
            np.testing.assert_array_equal(state[key], array, err_msg=key)
    again = start()
    again.restore(state)
    again.run(until=0.15, dt=5e-3)
    np.testing.assert_array_equal(again.solids[0].velocity, whole.solids[0].velocity)


def test_a_run_goes_on_where_it_was():
    """State and restore know the time and the velocity of the wall."""

    def scene():
        block = RigidSolid(rectangle((2, 1)), mass=10.0, gravity=(0, -G))
        lift = Moved(FLOOR, lambda t: (0.0, 0.02 * (1 - np.cos(10 * t))))
        return Scene([block], [Contact(block, "base", lift, friction=0.3)])

    first, second = scene(), scene()
    first.run(0.05, 1e-3)
    second.restore({name: np.array(value) for name, value in first.state().items()})
    for each in (first, second):
        each.run(0.1, 1e-3)
    np.testing.assert_array_equal(first.solids[0].velocity, second.solids[0].velocity)
    np.testing.assert_array_equal(first.contacts[0].gap, second.contacts[0].gap)


# -- what is refused --


def refused(make, *words):
    with pytest.raises(InputError) as caught:
        make()
    for word in words:
        assert word in str(caught.value)


def of_mesh():
    return ufl.SpatialCoordinate(rectangle().mesh)


def scalars():
    return compat.cellwise_space(rectangle().mesh)


def on(obstacle):
    return Contact(RigidSolid(rectangle(), mass=1.0), "base", obstacle)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: LevelSet(lambda x, t: x, 2), ("phi", "scalar", "(2,)")),
        (lambda: LevelSet(lambda x, t: 1.0, 2), ("phi", "must depend on the position")),
        (lambda: LevelSet(lambda x, t: t, 2), ("phi", "must depend on the position")),
        (lambda: LevelSet(lambda x: x[0], 2), ("phi", "(x, t)")),
        (lambda: LevelSet(lambda x, t: x[2], 2), ("phi",)),
        (lambda: LevelSet(lambda x, t: x[0], 4), ("dim = 4", "2 or 3")),
        (lambda: LevelSet(lambda x, t: x[0], 2.0), ("dim = 2.0",)),
        (lambda: LevelSet(lambda x, t: x[0], 2, velocity=lambda x, t: t), ("velocity", "vector")),
        (lambda: LevelSet(lambda x, t: x[0] + 1j, 2), ("phi", "1j", "real")),
        (lambda: LevelSet(lambda x, t: x[0] + of_mesh()[0], 2), ("phi", "Coordinate", "mesh")),
        (lambda: LevelSet(lambda x, t: x[0], 2, lambda x, t: of_mesh()), ("velocity", "mesh")),
        (
            lambda: LevelSet(lambda x, t: x[0] + fem.Function(scalars(), name="g"), 2),
            ("phi", "Function g", "mesh"),
        ),
        (
            lambda: LevelSet(lambda x, t: x[0], 2, lambda x, t: (fem.Function(scalars()), 0.0)),
            ("velocity", "Function", "mesh"),
        ),
        (
            lambda: LevelSet(
                lambda x, t: x[0], 2, lambda x, t: fem.Constant(rectangle().mesh, (1.0, 0.0))
            ),
            ("velocity", "(2,)", "scalars"),
        ),
        (lambda: Circle((0, 0), 0.0), ("radius",)),
        (lambda: Circle((0, 0, 0), 1.0), ("center",)),
        (lambda: Sphere((0, 0), 1.0), ("center",)),
        (lambda: Cylinder((0, 0, 0), (0, 0, 0), 1.0), ("axis", "zero")),
        (lambda: Moved("floor", lambda t: (0, 0)), ("obstacle", "floor")),
        (lambda: Moved(FLOOR, (0, 1)), ("motion",)),
        (lambda: Moved(FLOOR, lambda t: (t, t, t)), ("motion(0)",)),
        (lambda: Moved(FLOOR, lambda t: (np.nan, 0)), ("motion(0)",)),
        (lambda: on(Sphere((0, 0, -1), 1.0)), ("master", "dimension 3")),
        (lambda: on(LevelSet(lambda x, t: ufl.sqrt(x[1] - 5), 2)), ("master", "distance", "nan")),
    ],
)
def test_bad_obstacles(make, words):
    refused(make, *words)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"distance": lambda self, p: np.full(len(p), np.nan)}, ("distance", "nan")),
        ({"distance": lambda self, p: p}, ("distance", "(2,)")),
        ({"normals": lambda self, p: 2 * Ball.normals(self, p)}, ("unit",)),
        ({"normals": lambda self, p: -Ball.normals(self, p)}, ("distance grows",)),
        ({"normals": lambda self, p: p[:, 0]}, ("normals", "(2, 2)")),
        ({"velocity": lambda self, p: np.zeros(3)}, ("velocity", "(2, 2)")),
        ({"curvature": lambda self, p: np.zeros((2, 2))}, ("curvature", "(2, 2, 2)")),
    ],
)
def test_bad_answers_of_a_strangers_obstacle(changes, words):
    refused(lambda: on(type("Strange", (Ball,), changes)(1.0)), "master", *words)


def test_a_reversed_half_space_is_legal():
    block = RigidSolid(rectangle(), mass=1.0, gravity=(0, G))
    contact = Contact(block, "top", HalfSpace((0, 0.8), (0, -1)))
    Scene([block], [contact]).run(0.01, 1e-3)
    np.testing.assert_allclose(contact.force.sum(axis=0), [0, -G], atol=1e-9)


def test_a_distance_that_fails_stops_the_run_with_a_reason():
    block = RigidSolid(rectangle(), mass=1.0, gravity=(0, -G))
    floor = LevelSet(lambda x, t: x[1] - 0.1 + ufl.sqrt(0.015 - t), 2)
    history = Scene([block], [Contact(block, "base", floor)]).run(0.1, 1e-2)
    assert not history.finished and "an obstacle is nan at the point" in history.reason


def test_a_time_that_has_a_default_counts():
    """A floor that rises stood still where its distance was written ``(points, time=0.0)``."""

    class Lift:
        dim = 2

        def distance(self, points, time=0.0):
            return points[:, 1] - 0.1 * time**2

        def normals(self, points, time=0.0):
            return np.tile([0.0, 1.0], (len(points), 1))

    solid = RigidSolid(rectangle(), mass=1.0, gravity=(0, -G))
    start = solid.place[1]
    history = Scene([solid], [Contact(solid, "base", Lift())]).run(0.5, 5e-3)
    assert history.finished and solid.place[1] - start == pytest.approx(0.025, rel=1e-6)


@pytest.mark.parametrize("wrong", ["raises", "none", "short"])
def test_a_motion_that_fails_later_stops_the_run(wrong):
    """It raised out of the run, and what was computed was lost; loads stop it with their reason."""

    def motion(t):
        if t > 0.015:
            if wrong == "raises":
                raise ValueError("mine")
            return None if wrong == "none" else (0.0,)
        return (0.0, 0.0)

    block = RigidSolid(rectangle(), mass=1.0, gravity=(0, -G))
    history = Scene([block], [Contact(block, "base", Moved(FLOOR, motion))]).run(0.03, 5e-3)
    assert not history.finished and len(history) == 4
    assert "an obstacle raises InputError: motion(" in history.reason


class Own:
    """A floor that may be given other members."""

    dim = 2

    def __init__(self, **members):
        vars(self).update(members)

    def distance(self, points, time):
        return points[:, 1]

    def normals(self, points, time):
        return np.tile([0.0, 1.0], (len(points), 1))


NONE = "is complex, masked, text, .*: must be"


@pytest.mark.parametrize(
    ("members", "said"),
    [
        ({"distance": lambda x, t: x[:, 1] + 1j}, rf"the distance of .* {NONE} \(2,\) real"),
        ({"distance": lambda x, t: ["a"] * len(x)}, rf"the distance of .* {NONE} \(2,\) real"),
        ({"normals": lambda x, t: x > 0}, rf"the normals of .* {NONE} \(2, 2\) real"),
        ({"velocity": lambda x, t: np.ma.masked_less(x, 1)}, rf"the velocity of .* {NONE}"),
        ({"velocity": lambda x, t: x[0]}, r"velocity .* is of the shape \(2,\): must be \(2, 2\)"),
        ({"dim": "2"}, "has dimension '2', the solid 2"),
        ({"flat": "no"}, "obstacle.flat = 'no': must be True or False"),
        ({"moving": "x"}, "obstacle.moving = 'x': must be True or False"),
    ],
)
def test_what_an_own_obstacle_gives_is_refused_by_its_name(members, said):
    """It said "no real numbers", or that the obstacle raised, or took a text for True."""
    block = RigidSolid(rectangle((1, 1), (0.2, 0.1)), mass=1.0)
    with pytest.raises(InputError, match=said) as refused:
        Contact(block, "base", Own(**members))
    assert "raises" not in str(refused.value)


def test_what_an_own_obstacle_gives_later_is_told_by_its_name():
    block = RigidSolid(rectangle((1, 1), (0.2, 0.1)), mass=1.0, gravity=(0, -G))
    late = Own(distance=lambda x, t: x[:, 1] if t < 5e-3 else x[:, 1] + 1j)
    history = Scene([block], [Contact(block, "base", late)]).run(0.01, 2e-3)
    assert "the distance of an obstacle is complex" in history.reason
    assert "raises" not in history.reason and "'obstacle')" in history.reason


@pytest.mark.parametrize("mu", [0.4, 1.0])
def test_a_box_on_a_wave_that_travels(mu):
    """Its corners strike, and steps are cut where they do: into parts so short that the velocity of
    the wave, which is told by where it is, was round-off in the brief time over which it was asked;
    the fixed point stalled, and the run stopped."""
    mesh = box((1, 1, 1), (0.1, 0.2, 0.05), "tetrahedron")
    mesh.mesh.geometry.x[:, 2] += 1e-3
    solid = RigidSolid(mesh, mass=2.0, gravity=(0, 0, -9.81))

    def phi(x, t):
        return x[2] - 0.05 * ufl.sin(5 * x[0] + 0.3 + 2 * t) * ufl.cos(4 * x[1] + 0.5) + 0.0263

    contact = Contact(solid, "base", LevelSet(phi, 3), friction=mu)
    history = Scene([solid], [contact], ThetaScheme(0.5), locate_impacts=True).run(0.4, 2e-3)
    assert history.finished, history.reason
    assert history["newton"].max() < 40
