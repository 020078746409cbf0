# SPDX-License-Identifier: LGPL-3.0-or-later
"""Derivatives of runs of rigid solids in space: finite rotations, impacts, friction."""

from __future__ import annotations

from math import cos, sin

import numpy as np
import pytest
from mpi4py import MPI
from scenes import FLOOR_3D, G, box
from scipy.spatial import ConvexHull
from test_gradients import LONG, check, friction, refused, solid_of

from fenicsx_contact import (
    Contact,
    HalfSpace,
    InputError,
    RigidSolid,
    Scene,
    Sphere,
    ThetaScheme,
    name_facets,
)
from fenicsx_contact.base import compat
from fenicsx_contact.gradients import (
    Centre,
    Force,
    Gravity,
    Kinetic,
    Mass,
    NoDerivative,
    ObstacleShift,
    Start,
    Turn,
    adjoints,
    tangents,
)
from fenicsx_contact.solids.rotations import rotation_matrix, turning

AXES = dict(zip("xyz", np.eye(3)))
LOCATED = {"locate_impacts": True, "geometry": "newton"}


def everything(scene):
    """Places, velocities, rotations, spins, energy."""
    solid = solid_of(scene)
    result = {"energy": Kinetic(solid)}
    for name, axis in AXES.items():
        result[name] = Centre(solid, axis)
        result[f"v{name}"] = Centre(solid, axis, "velocity")
        result[f"turn {name}"] = Turn(solid, about=axis)
        result[f"spin {name}"] = Turn(solid, "velocity", axis)
    return result


def down(scene):
    return Gravity(solid_of(scene), (0, 0, -1))


def along(scene):
    return Start(solid_of(scene), velocity=(1, 0.2, 0))


def tumbling(scene):
    return Start(solid_of(scene), turn=(1, 0.5, 0), about=(0, 0, 0))


def spinning(scene):
    return Start(solid_of(scene), spin=(0, 0.3, 1))


def mass_of(scene):
    return Mass(solid_of(scene))


# -- formulas --


@pytest.mark.second
@pytest.mark.parametrize("scene", [{}, {"locate_impacts": True}])
def test_a_cube_launched_along_the_floor(scene):
    """0.1 m, 6 m/s, friction 0.5: d(distance)/dmu = -v²/(2 mu² g). The distance of n steps and the
    one in which the cube stops is dt v (n + 1/2) - mu g dt² n (n + 1)/2: by mu it is exact where
    n (n + 1) dt² is the square of the time to stop."""
    mu, v, steps = 0.5, 6.0, 100
    cube = RigidSolid(box(size=(0.1,) * 3), mass=1.0, gravity=(0, 0, -G), velocity=(v, 0, 0))
    scene = Scene([cube], [Contact(cube, "base", FLOOR_3D, friction=mu, name="c")], **scene)
    stop = v / (mu * G)
    dt = stop / np.sqrt(steps * (steps + 1))
    asked = {"mu": friction(scene), "v": Start(cube, velocity=(1, 0, 0)), "g": down(scene),
             "m": mass_of(scene)}  # fmt: skip
    result = tangents(scene, 1.1 * stop, dt, asked, everything(scene))
    exact = [-(v**2) / (2 * mu**2 * G), (steps + 0.5) * dt, -(v**2) / (2 * mu * G**2)]
    np.testing.assert_allclose(result["x"][-1, :3], exact, rtol=1e-10)
    assert result["x"][-1, 1] == pytest.approx(stop, rel=2e-5)  # of second order in dt
    assert abs(result["x"][-1, 3]) < 1e-10
    while_sliding = result.history.time < 0.9 * stop
    force = result["c.force_x"][while_sliding][2:]
    np.testing.assert_allclose(force, [[-G, 0, -mu, -mu * G]] * len(force), atol=1e-9)
    for name in ("y", "z", "turn z", "spin x"):
        assert np.abs(result[name]).max() < 1e-10


def test_a_block_that_stops_on_a_slope():
    """Up a slope: v²/(2 a), a = g (mu cos + sin), by the friction and by the angle; it stays."""
    mu, angle, v, steps = 0.6, 0.3, 1.0, 80
    a = G * (mu * cos(angle) + sin(angle))
    gravity = (0, -G * sin(angle), -G * cos(angle))
    block = RigidSolid(box(size=(0.3, 0.4, 0.1)), mass=3.0, gravity=gravity, velocity=(0, v, 0))
    scene = Scene([block], [Contact(block, "base", FLOOR_3D, friction=mu)])
    turned = Gravity(block, (0, -G * cos(angle), G * sin(angle)))
    dt = v / a / np.sqrt(steps * (steps + 1))
    asked = {"mu": friction(scene), "angle": turned}
    by = tangents(scene, 1.1 * v / a, dt, asked, everything(scene))["y"][-1]
    by_a = -(v**2) / (2 * a**2)
    exact = [by_a * G * cos(angle), by_a * G * (cos(angle) - mu * sin(angle))]
    np.testing.assert_allclose(by, exact, rtol=1e-10)


def test_a_free_flight_about_a_principal_axis():
    """It turns by w t about z; a small spin about x, beside it, turns by what Euler's equations
    say: with k = (C - B)/A and l = (C - A)/B it has the frequency w sqrt(k l) in the solid."""
    w, dt, until = 2.0, 1e-3, 0.5
    solid = RigidSolid(box(), mass=2.0, spin=(0, 0, w))
    scene = Scene([solid], [], allow_free=True)
    asked = {"w": Start(solid, spin=(0, 0, 1)), "side": Start(solid, spin=(1, 0, 0))}
    result = tangents(scene, until, dt, asked, everything(scene))
    t = result.history.time
    np.testing.assert_allclose(result["turn z"][:, 0], t, atol=1e-12)
    A, B, C = np.diag(solid.inertia)
    np.testing.assert_allclose(result["energy"][:, 0], C * w, rtol=1e-9)
    k, m = (C - B) / A, (C - A) / B  # A p' = (B - C) q w, B q' = (C - A) w p
    omega = w * np.sqrt(k * m + 0j)
    exact = np.stack([np.cos(omega * t), m * w * np.sin(omega * t) / omega], axis=1).real
    turn, spin = (
        np.stack([result[f"{what} {axis}"][:, 1] for axis in "xyz"], axis=1)
        for what in ("turn", "spin")
    )
    for i, each in enumerate(exact):
        way = np.array([0, 0, w * t[i]])
        further = np.cross(turning(way) @ turn[i], (0, 0, w))
        inside = rotation_matrix(way).T @ (spin[i] - further)
        np.testing.assert_allclose(inside[:2], each, atol=1e-6)


# -- plateaus of central differences --


def tilted(mu=0.3, speed=0.5, g=G, mass=2.0, height=0.03, tilt=0.1, formulation="velocity",
           scheme=None, springs=None, **scene):  # fmt: skip
    """A tilted block that falls on a slope, on a corner: it slips, tips and falls on others."""
    block = RigidSolid(
        box(size=(0.2, 0.3, 0.4)),
        mass=mass,
        gravity=(0, 0, -g),
        rotation=(tilt, 0.2, 0.05),
        about=(0.1, 0, 0),
        velocity=(speed, 0.2 * speed, -0.5),
        spin=(0.3, -0.2, 1.5),
        springs=springs,
    )
    floor = HalfSpace((0, 0, -0.04 - height), (0.05, 0.1, 1))
    contact = Contact(block, "base", floor, formulation, friction=mu, gap_tolerance=1e-13, name="c")
    return Scene([block], [contact], scheme, **scene)


def tilting(scene):
    """A change of the first number of the rotation vector turns by what T says, in space."""
    return Start(solid_of(scene), turn=turning(np.array([0.1, 0.2, 0.05]))[:, 0], about=(0.1, 0, 0))


TILTED = {
    "tilt": (0.1, tilting),
    "mu": (0.3, friction),
    "speed": (0.5, along),
    "g": (G, down),
    "mass": (2.0, mass_of),
    "height": (0.03, lambda s: ObstacleShift(s.contacts[0], (0, 0, -1))),
}


@pytest.mark.parametrize(
    ("formulation", "theta", "scene"),
    [
        pytest.param("velocity", 0.5, {}, marks=LONG),
        pytest.param("velocity", 0.5, {"geometry": "newton"}, marks=LONG),
        ("velocity", 0.5, LOCATED),
        pytest.param("velocity", 1.0, {"geometry": "newton"}, marks=LONG),
        pytest.param("gap", 1.0, {"geometry": "newton"}, marks=LONG),
        pytest.param(
            "velocity",
            0.5,
            {"geometry": "newton", "springs": {(0.1, 0.15, 0.4): (100.0, 50.0, 80.0)}},
            marks=LONG,
        ),
    ],
)
def test_a_tilted_block_that_falls_on_a_slope(formulation, theta, scene):
    def build(**values):
        return tilted(formulation=formulation, scheme=ThetaScheme(theta), **values, **scene)

    until = 0.18 if scene is LOCATED else 0.15  # before it rattles
    asked = dict(list(TILTED.items())[:4]) if scene is LOCATED else TILTED  # to be short
    shares = [1e-5] if scene is LOCATED else [1e-5, 1e-6]
    result = check(build, asked, until, 6e-3, everything, shares=shares)
    assert result.history["c.slipping"].max() >= 1
    impacts = (result.history["dt"] == 0).sum()
    assert scene is not LOCATED or impacts >= 6  # of one corner after the other


def filled(points):
    """A convex solid of tetrahedra about the mean of its corners; its facets are its skin."""
    corners = np.vstack([points, np.mean(points, axis=0)])
    outside = ConvexHull(points).simplices
    cells = np.column_stack([outside, np.full(len(outside), len(points))])
    mesh = compat.create_mesh(MPI.COMM_SELF, cells, corners, "tetrahedron")
    return name_facets(mesh, {"skin": lambda x: np.full(x.shape[1], True)})


def dropped(points, mu=0.3, speed=1.0, spin=4.0, tilt=0.2, **scene):
    """A convex solid thrown on a level floor."""
    solid = RigidSolid(
        filled(points),
        mass=1.0,
        gravity=(0, 0, -G),
        rotation=(tilt, 0.1, 0.0),
        velocity=(speed, 0.1, -0.4),
        spin=(0.5, 0.2, spin),
    )
    lowest = solid.fields()["displacement"][:, 2] + solid.mesh.mesh.geometry.x[:, 2]
    floor = HalfSpace((0, 0, lowest.min() - 0.01), (0, 0, 1))
    return Scene([solid], [Contact(solid, "skin", floor, friction=mu, name="c")], **scene)


DROPPED = {
    "mu": (0.3, friction),
    "speed": (1.0, lambda s: Start(solid_of(s), velocity=(1, 0, 0))),
    "spin": (4.0, lambda s: Start(solid_of(s), spin=(0, 0, 1))),
}
TETRAHEDRON = 0.1 * np.array([[1.0, 0, 0], [-0.5, 0.9, 0], [-0.5, -0.9, 0], [0, 0, 0.5]])


@pytest.mark.second
def test_a_tetrahedron_that_comes_to_slide_on_a_face():
    """Three points bear it in one way only, though it turns about the normal."""

    def build(**values):
        return dropped(TETRAHEDRON, geometry="newton", **values)

    def level(scene):
        there = everything(scene)
        return {name: there[name] for name in ("x", "y", "vx", "vy", "turn z", "spin z", "energy")}

    result = check(build, DROPPED, 0.2, 5e-3, level, shares=[1e-5])
    assert result.history["spin z"][result.history["c.slipping"] == 3].max() > 0.5


def ball(n=30, radius=0.1):
    k = np.arange(n) + 0.5
    z, turn = 1 - 2 * k / n, np.pi * (1 + 5**0.5) * k
    flat = np.sqrt(1 - z**2)
    return radius * np.stack([np.cos(turn) * flat, np.sin(turn) * flat, z], axis=1)


@pytest.mark.second
def test_a_ball_that_bounces():
    def build(**values):
        return dropped(ball(), **values, **LOCATED)

    result = check(build, DROPPED, 0.06, 4e-3, everything, shares=[1e-5])
    impacts = result.history["dt"] == 0
    assert impacts.sum() >= 2 and result.history["c.slipping"].max() > 0
    assert result["time"][impacts][-1].any()


@LONG
@pytest.mark.parametrize(("formulation", "theta"), [("velocity", 0.5), ("gap", 1.0)])
def test_a_block_that_slides_in_a_round_bowl(formulation, theta):
    """Normals that turn, an obstacle that is shifted."""

    def build(speed, mu, x):
        block = RigidSolid(
            box(size=(0.2, 0.3, 0.1)),
            mass=2.0,
            gravity=(0, 0, -G),
            rotation=(0.2, 0.1, 0),
            velocity=(speed, 0.2 * speed, 0),
            spin=(0, 0, 1.5),
        )
        bowl = Sphere((x, 0, 0.94), 1.0, inside=True)
        contact = Contact(block, "base", bowl, formulation, friction=mu, name="c")
        return Scene([block], [contact], ThetaScheme(theta), geometry="newton")

    asked = {
        "speed": (0.5, along),
        "mu": (0.3, friction),
        "x": (1e-3, lambda s: ObstacleShift(s.contacts[0], (1, 0, 0))),
    }
    check(build, asked, 0.1, 5e-3, everything)


@pytest.mark.second
@pytest.mark.parametrize("formulation", ["velocity", "gap"])
@pytest.mark.parametrize("theta", [0.5, 0.75])
def test_a_mass_that_slides_in_a_bowl(formulation, theta):
    """By theta < 1 a ten-thousandth of the derivatives was missing: tangents were held still."""
    way, tip = np.array([0.1, 1.0, 0.075]), np.array([0.6, 0.0, -0.8])
    above = np.array([[0.3, 0, 1], [-0.15, 0.26, 1], [-0.15, -0.26, 1]])

    def build(speed, mu):
        mass = RigidSolid(
            filled(tip + 0.05 * np.vstack([np.zeros(3), above])),
            mass=1.0,
            gravity=(0, 0, -G),
            held=[f"turning about {axis}" for axis in "xyz"],
            velocity=speed * way,
        )
        bowl = Sphere((0, 0, 0), 1.0, inside=True)
        contact = Contact(mass, "skin", bowl, formulation, friction=mu, name="c")
        return Scene([mass], [contact], ThetaScheme(theta), geometry="newton")

    asked = {"speed": (1.5, lambda s: Start(solid_of(s), velocity=way)), "mu": (0.1, friction)}
    check(build, asked, 0.4, 1e-2, everything)


def test_a_hinged_block_on_a_spring():
    """Held about two axes, far from contacts; the spring pulls where its point has turned to."""

    def build(mass, spin):
        block = RigidSolid(
            box(),
            mass=mass,
            spin=(0, spin, 0),
            held=["x", "y", "z", "turning about x", "turning about z"],
            springs={(0.1, 0.2, 0.8): (50.0, 20.0, 80.0)},
        )
        return Scene([block], [], geometry="newton", allow_free=True)

    asked = {"mass": (2.0, mass_of), "spin": (3.0, lambda s: Start(solid_of(s), spin=(0, 1, 0)))}

    def turned(scene):
        block = solid_of(scene)
        about = {"about": (0, 1, 0)}
        return {"turn": Turn(block, **about), "spin": Turn(block, "velocity", **about),
                "energy": Kinetic(block)}  # fmt: skip

    check(build, asked, 0.5, 2e-2, turned)


def test_a_place_that_is_held():
    """The centre stays where it starts; the higher it does, the later a corner turns to the floor,
    by one over the corner's speed."""
    spin, half = 1.0, (0.18, 0.4)
    block = RigidSolid(box(), mass=1.0, spin=(0, spin, 0), held=["z"])
    floor = HalfSpace((0, 0, -0.02), (0, 0.05, 1))  # lower there than beside one corner
    scene = Scene([block], [Contact(block, "base", floor)], **LOCATED)
    result = tangents(scene, 0.06, 0.03, {"z": Start(block, place=(0, 0, 1))})
    first = np.flatnonzero(result.history["dt"] == 0)[-1]
    angle = spin * result.history.time[first]
    speed = spin * (half[0] * cos(angle) - half[1] * sin(angle))
    assert result["time"][first, 0] == pytest.approx(1 / speed, rel=1e-9)


# -- adjoints --


@pytest.mark.parametrize("scene", [pytest.param({}, marks=LONG), LOCATED])
def test_adjoints_are_tangents(scene):
    def made():
        made = tilted(**scene)
        asked = {name: of(made) for name, (_, of) in TILTED.items()}
        asked |= {"turn": tumbling(made), "spin": spinning(made)}
        push = Force(made.contacts[0], (0.2, 0.1, 1))
        return made, asked, {**everything(made), "force": push}

    made_scene, asked, quantities = made()
    forward = tangents(made_scene, 0.15, 5e-3, asked, quantities)
    made_scene, asked, quantities = made()
    back = adjoints(made_scene, 0.15, 5e-3, asked, quantities)
    for name in quantities:
        np.testing.assert_allclose(back.one_sided(name), forward[name][-1], rtol=1e-9, atol=1e-12)


# -- where there is none, and what is not supported --


def test_a_cube_that_spins_on_four_corners():
    """They bear it in many ways; while it turns friction hangs on which, and with it the motion.
    Without spin the four slide alike, and by the spin, too, there is a derivative."""

    def run(spin):
        cube = RigidSolid(
            box(size=(0.1,) * 3),
            mass=1.0,
            gravity=(0, 0, -G),
            velocity=(2.0, 0, 0),
            spin=(0, 0, spin),
        )
        scene = Scene([cube], [Contact(cube, "base", FLOOR_3D, friction=0.5, name="c")])
        asked = {"mu": friction(scene), "spin": Start(cube, spin=(0, 0, 1))}
        return tangents(scene, 0.1, 0.01, asked, everything(scene))

    result = run(5.0)
    told = result.kinks[0]
    assert told.contact == "c" and told.time == 0.01 and "not unique" in told.what
    with pytest.raises(NoDerivative, match="contact 'c'"):
        result["x"]
    straight = run(0.0)["turn z"][-1]
    little = run(1e-2).history["turn z"][-1] / 1e-2  # odd in the spin
    np.testing.assert_allclose(straight, [0.0, little], rtol=1e-6, atol=1e-12)


def test_what_is_not_supported_is_refused_by_name():
    def block(**given):
        solid = RigidSolid(box(), mass=1.0, gravity=(0, 0, -G), name="block", **given)
        return Scene([solid], [Contact(solid, "base", FLOOR_3D, name="c")])

    scene = block(held=["turning about x"])
    refused(scene, {"m": mass_of(scene)}, "contact 'c' puts back solid 'block', which is held")
    scene = block(held=["y"])
    with pytest.raises(InputError, match="'block' is held where it gets a velocity"):
        Start(solid_of(scene), velocity=(0, 1, 0))
    with pytest.raises(InputError, match="an axis in space"):
        Turn(solid_of(scene))
    scene = block(force=lambda t: (t, 0, 0))
    late = Scene(scene.solids, scene.contacts, locate_impacts=True)
    refused(late, {"m": mass_of(late)}, "'block' has forces in time and located impacts")
