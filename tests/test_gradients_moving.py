# SPDX-License-Identifier: LGPL-3.0-or-later
"""Derivatives of runs before obstacles that move as they are told: dies, drums, bowls, waves."""

from __future__ import annotations

import numpy as np
import pytest
import ufl
from dolfinx import fem
from scenes import FLOOR, G, box, rectangle
from test_gradients import centre, solid_of
from test_gradients_laws import check

from fenicsx_contact import (
    Box,
    Circle,
    Contact,
    Cylinder,
    Discrete,
    ElasticSolid,
    HyperelasticSolid,
    InputError,
    LevelSet,
    Moved,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    Turned,
    Union,
    neo_hookean,
)
from fenicsx_contact.gradients import (
    At,
    Centre,
    Force,
    Gravity,
    Law,
    ObstacleShift,
    Parameter,
    Shape,
    adjoints,
    tangents,
)


def friction(scene):
    return Law(scene.contacts[0])


# -- a die is pressed into an elastic block, and drawn along it --


def die(mu=0.3, deep=0.05, speed=1.0, radius=0.4, *, scheme=None, shape=None, high=None, **contact):
    """The bottom of the block is held; the die's midpoint goes down and then along."""
    solid = ElasticSolid(
        rectangle((6, 4), size=(1.0, 0.5)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1e3,
        fixed=["base"],
    )
    high = high or 0.501 + radius

    def motion(t):
        return 0.1 * np.sin(3 * speed * t), high - deep * np.sin(10 * t)

    obstacle = shape(radius) if shape else Circle((-0.05, 0), radius)
    contact = Contact(solid, "top", Moved(obstacle, motion), friction=mu, **contact)
    return Scene([solid], [contact], scheme=scheme or ThetaScheme(0.5))


def pressed(scene):
    (contact,) = scene.contacts
    at = {
        name: At(contact.solid, (0.0, 0.5), way) for name, way in {"x": (1, 0), "y": (0, 1)}.items()
    }
    forces = {"fx": Force(contact, (1, 0)), "fy": Force(contact, (0, 1))}
    return {**at, **forces}


def by_stroke(scene):
    return ObstacleShift(scene.contacts[0], lambda t: (0, -np.sin(10 * t)))


def by_speed(scene):
    return ObstacleShift(scene.contacts[0], lambda t: (0.3 * t * np.cos(3 * t), 0))


@pytest.mark.parametrize("formulation", ["velocity", "gap", "lagrange", Discrete(stiffness=1e7)])
@pytest.mark.parametrize("scheme", [ThetaScheme(0.5), ThetaScheme(1.0), QuasiStatic()])
def test_a_die(formulation, scheme):
    parameters = {"mu": (0.3, friction), "deep": (0.05, by_stroke), "speed": (1.0, by_speed)}

    def build(**changed):
        return die(**changed, scheme=scheme, formulation=formulation)

    check(build, parameters, 0.12, 0.01, pressed)


def constant(value):
    """A number that obstacles read."""
    return fem.Constant(rectangle().mesh, float(value))


def number(i=0):
    """One that stands in the obstacle of the contact."""
    return lambda scene: Shape(scene.contacts[0], scene.contacts[0].coupling.obstacle.numbers[i])


def round_die(radius):
    r = constant(radius)
    return LevelSet(lambda x, t: ufl.sqrt((x[0] + 0.05) ** 2 + x[1] ** 2) - r, dim=2)


@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_a_die_of_a_shape(theta):
    """By the radius of one whose midpoint moves with it, so that its lowest point stays."""
    parameters = {"radius": (0.4, number())}

    def build(radius):
        return die(radius=radius, shape=round_die, scheme=ThetaScheme(theta), high=0.9)

    check(build, parameters, 0.12, 0.01, pressed)


# -- rigid bodies in and on what turns --


def bowl(mu=0.5, rate=3.0, g=1.0, *, theta=0.5, shape=None, kind="rigid", **contact):
    """A box that a bowl that speeds up takes along: round about its middle, or not quite."""
    obstacle = shape or Circle((0, 0.988), 1.0, inside=True)
    wall = Turned(obstacle, (0.02, 1.0), lambda t: 0.5 * rate * t**2 + 0.1 * t)
    mesh, gravity = rectangle((2, 2), size=(0.3, 0.2)), (0, -G * g)
    if kind == "rigid":
        body = RigidSolid(mesh, mass=1.0, gravity=gravity)
    else:
        body = HyperelasticSolid(mesh, energy=neo_hookean(1e5, 0.3), density=20.0, gravity=gravity)
    contact = Contact(body, "base", wall, friction=mu, **contact)
    return Scene([body], [contact], scheme=ThetaScheme(theta), geometry="newton")


def lifted(scene):
    return ObstacleShift(scene.contacts[0], (0.0, 1.0))


def heavier(scene):
    return Gravity(scene.solids[0], (0, -G))


@pytest.mark.parametrize("formulation", ["velocity", "gap"])
@pytest.mark.parametrize("kind", ["rigid", "soft"])
@pytest.mark.parametrize("theta", [0.5, 0.75, 1.0])
def test_a_bowl_that_turns(theta, kind, formulation):
    parameters = {"mu": (0.5, friction), "g": (1.0, heavier)}

    def build(mu, g):
        return bowl(mu, g=g, theta=theta, kind=kind, formulation=formulation)

    check(build, parameters, 0.2, 0.005)


def test_a_bowl_by_its_own_motion():
    """By the rate at which it speeds up, as numbers of level sets that move by themselves: of its
    material alone, and of a wave that travels below it."""

    def build(rate, depth):
        r, d = constant(rate), constant(depth)

        def phi(x, t):
            return 1 - ufl.sqrt(x[0] ** 2 + (x[1] - 0.988 - d * ufl.sin(3 * t)) ** 2)

        def velocity(x, t):
            return r * t * (0.988 - x[1]), r * t * x[0] + 3 * d * ufl.cos(3 * t)

        body = RigidSolid(rectangle((2, 2), size=(0.3, 0.2)), mass=1.0, gravity=(0, -G))
        contact = Contact(body, "base", LevelSet(phi, 2, velocity), friction=0.5)
        return Scene([body], [contact], scheme=ThetaScheme(0.5), geometry="newton")

    # those of phi come first
    check(build, {"rate": (3.0, number(1)), "depth": (0.02, number(0))}, 0.2, 0.005)


@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_a_wave_that_travels(theta):
    """Whose surface moves along its normals."""

    def build(height, speed):
        h, c = constant(height), constant(speed)
        wave = LevelSet(lambda x, t: x[1] + 5e-3 - h * ufl.sin(8 * x[0] - c * t), 2)
        body = RigidSolid(rectangle((3, 1), size=(0.3, 0.2)), mass=1.0, gravity=(0, -G))
        contact = Contact(body, "base", wave, friction=0.3, formulation="gap")
        return Scene([body], [contact], scheme=ThetaScheme(theta), geometry="newton")

    numbers = build(5e-3, 6.0).contacts[0].coupling.obstacle.numbers
    height, speed = np.argsort([float(each.value) for each in numbers])
    check(build, {"height": (5e-3, number(height)), "speed": (6.0, number(speed))}, 0.03, 0.002)


@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_a_drum_in_space(theta):
    """A soft block that a drum draws along."""

    def build(mu, rate):
        wall = Turned(
            Cylinder((0, 0, -2), (0, 1, 0), 2.0), (0, 0, -2), lambda t: rate * t * t, axis=(0, 1, 0)
        )
        body = ElasticSolid(
            box((3, 2, 2), size=(0.5, 0.3, 0.3)),
            youngs_modulus=1e5,
            poisson_ratio=0.3,
            density=100.0,
            gravity=(0, 0.3 * G, -G),
        )
        return Scene([body], [Contact(body, "base", wall, friction=mu)], scheme=ThetaScheme(theta))

    def faster(scene):
        return DrumRate(scene.contacts[0])

    check(build, {"mu": (0.6, friction), "rate": (2.0, faster)}, 0.1, 0.005, all_of)


class DrumRate(Parameter):
    """By the rate of a drum's angle, rate t², a parameter of a user's own."""

    def __init__(self, contact):
        self.contact = contact

    def wall(self, contact, places, time):
        return np.zeros(len(places)), np.zeros_like(places)

    def drive(self, contact, places, start, end):
        arm = places - contact.coupling.obstacle.about
        return (start + end) * np.cross([0, 1, 0], arm)


def all_of(scene):
    solid = solid_of(scene)
    ways = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
    return {name: Centre(solid, way) for name, way in ways.items()}


@pytest.mark.parametrize("formulation", ["velocity", "gap"])
def test_a_box_that_turns(formulation):
    """Edges, too: what rides on one of its faces."""

    def build(mu, g):
        wall = Turned(Box((0, -0.151), (1.0, 0.3)), (0.1, -0.3), lambda t: 2 * t * t)
        body = RigidSolid(rectangle(size=(0.3, 0.2)), mass=1.0, gravity=(0.2 * G, -G * g))
        contact = Contact(body, "base", wall, friction=mu, formulation=formulation)
        return Scene([body], [contact], geometry="newton")

    check(build, {"mu": (0.15, friction), "g": (1.0, heavier)}, 0.2, 0.005)


def test_adjoints_agree():
    scene = die()
    asked = {"mu": friction(scene), "deep": by_stroke(scene), "speed": by_speed(scene)}
    forward = tangents(scene, 0.12, 0.01, asked, pressed(scene))
    scene = die()
    asked = {"mu": friction(scene), "deep": by_stroke(scene), "speed": by_speed(scene)}
    back = adjoints(scene, 0.12, 0.01, asked, pressed(scene))
    for name in pressed(scene):
        assert back[name] == pytest.approx(forward[name][-1], rel=1e-9, abs=1e-12)


# -- what is refused --


class Wavy:
    """An own obstacle that moves and does not tell how its velocity changes."""

    dim, flat, moving = 2, True, True

    def distance(self, points, time):
        return points[:, 1] - 1e-3 * time

    def normals(self, points, time):
        return np.tile([0.0, 1.0], (len(points), 1))

    def velocity(self, points, start, end):
        return np.array([1.0, 1e-3]) + 0 * points


def before(obstacle):
    body = RigidSolid(rectangle(), mass=1.0, gravity=(0, -G))
    return Scene([body], [Contact(body, "base", obstacle, friction=0.3)])


def test_what_tells_no_slopes_of_its_velocity_is_refused():
    scene = before(Wavy())
    with pytest.raises(InputError, match=r"velocities are not differentiated.*velocity_slopes"):
        tangents(scene, 0.01, 0.005, {"mu": friction(scene)}, centre(scene))
    Wavy.velocity_slopes = lambda self, points, start, end: np.zeros((len(points), 2, 2))
    try:
        scene = before(Wavy())
        assert tangents(scene, 0.01, 0.005, {"mu": friction(scene)}, centre(scene)).history.finished
    finally:
        del Wavy.velocity_slopes


def test_a_wrong_slope_of_a_velocity_is_refused():
    Wavy.velocity_slopes = lambda self, points, start, end: np.ones((len(points), 2, 2))
    try:
        for obstacle in (Wavy(), Moved(Wavy(), lambda t: (t, 0)), Union([Wavy()])):
            scene = before(obstacle)
            with pytest.raises(InputError, match="velocity_slopes of its obstacle along x"):
                tangents(scene, 0.01, 0.005, {"mu": friction(scene)}, centre(scene))
    finally:
        del Wavy.velocity_slopes


def test_a_motion_of_an_obstacle_at_rest_is_refused():
    scene = before(FLOOR)
    shift = ObstacleShift(scene.contacts[0], lambda t: (t, 0))
    with pytest.raises(InputError, match=r"direction = .*must be numbers.*does not move"):
        tangents(scene, 0.01, 0.005, {"p": shift}, centre(scene))
    with pytest.raises(InputError, match=r"direction\(0\)"):
        ObstacleShift(scene.contacts[0], lambda t: (t, 0, 0))


def test_a_belt_by_its_speed():
    """What it drags along goes mu g t, whatever its speed; what sticks on it goes as it does."""

    def build(mu, speed):
        body = RigidSolid(rectangle(size=(0.4, 0.1)), mass=1.0, gravity=(0, -G))
        belt = Moved(FLOOR, lambda t: (speed * t, 0.0))
        return Scene([body], [Contact(body, "base", belt, friction=mu)])

    scene = build(0.3, 0.5)
    asked = {"mu": friction(scene), "speed": ObstacleShift(scene.contacts[0], lambda t: (t, 0.0))}
    result = tangents(scene, 0.3, 0.01, asked, centre(scene))
    assert result["vx"][10] == pytest.approx([G * 0.1, 0.0], abs=1e-10)
    assert result["vx"][-1] == pytest.approx([0.0, 1.0], abs=1e-10)
