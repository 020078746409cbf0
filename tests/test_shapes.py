# SPDX-License-Identifier: LGPL-3.0-or-later
"""Shapes of obstacles against formulas, and in scenes with exact answers."""

from __future__ import annotations

import re

import meshio
import numpy as np
import pytest
import ufl
from mpi4py import MPI
from scenes import FLOOR, G, box, rectangle
from shapes import ball, bricks
from test_obstacles import refused

from fenicsx_contact import (
    Box,
    Circle,
    Contact,
    Curve,
    Cylinder,
    ElasticSolid,
    HalfSpace,
    InputError,
    LevelSet,
    Moved,
    Obstacle,
    Polyhedron,
    QuasiStatic,
    Revolution,
    RigidSolid,
    Scene,
    Sphere,
    StaticKinetic,
    ThetaScheme,
    Triangulated,
    Turned,
    Wedge,
    name_facets,
    torques,
)
from fenicsx_contact.base import compat
from fenicsx_contact.contact.wall import Wall
from fenicsx_contact.references.arch import collapse_tilt, corners
from fenicsx_contact.references.hertz import LineContact, PointContact, effective_modulus

HERE, ALONG, UP = (0.1, -0.2, 0.3), (2 / 3, -1 / 3, 2 / 3), (0, 0, 1)


def around(n, radius=1.0, above=0.0):
    """A circle clockwise, its first point once more at the end."""
    turn = -2 * np.pi * np.arange(n + 1) / n
    return np.stack([radius * np.cos(turn), above + radius * np.sin(turn)], axis=1)


SMOOTH_BALL = Triangulated(ball(150, HERE), smooth=True)
ROUGH_BALL = Triangulated(ball(300, HERE, seed=1), smooth=True)
ELLIPSE = Curve(around(60) * [2, 1], smooth=True)


# -- what a formula says, too --


@pytest.mark.parametrize(
    ("shape", "formula", "error"),
    [
        (Revolution(Circle((0, 0), 0.9), HERE, ALONG), Sphere(HERE, 0.9), 1e-14),
        (
            Revolution(Box((0, 0), (50, 0.8)), HERE, ALONG),
            Cylinder(HERE, ALONG, 0.4),
            1e-14,
        ),
        (
            Revolution(HalfSpace((0, 0.4), (0, -1)), HERE, ALONG),
            Cylinder(HERE, ALONG, 0.4, inside=True),
            1e-14,
        ),
        (Triangulated(bricks((1, 2, 3))), Box((0, 0, 0), (1, 2, 3)), 1e-14),
        (SMOOTH_BALL, Sphere(HERE, 1.0), 1e-13),
        (ROUGH_BALL, Sphere(HERE, 1.0), 1e-12),
        (Curve(around(80), smooth=True), Circle((0, 0), 1.0), 1e-7),
        (Curve(around(80)[::-1], smooth=True), Circle((0, 0), 1.0, inside=True), 1e-7),
        (Curve([(-1, 0), (1, 0.5), (3, 1)]), HalfSpace((0, 0.25), (-1, 4)), 1e-15),
        (Curve([(-1, 0), (1, 0.5), (3, 1)], smooth=True), HalfSpace((0, 0.25), (-1, 4)), 1e-15),
    ],
)
def test_the_same_as_a_formula(shape, formula, error):
    assert isinstance(shape, Obstacle)
    x = np.random.default_rng(1).standard_normal((300, shape.dim))
    middle = HERE if shape.dim == 3 else (0, 0)
    size = np.linalg.norm(x - middle, axis=1)
    x = x[(size > 0.6) & (size < 2)]
    np.testing.assert_allclose(shape.distance(x), formula.distance(x), atol=10 * error)
    np.testing.assert_allclose(shape.normals(x), formula.normals(x), atol=100 * error)
    bend, exact = Wall(shape).curvature(x, 0.0), Wall(formula).curvature(x, 0.0)
    if bend is not None:
        bend = bend - (0.0 if exact is None else exact)
        np.testing.assert_allclose(bend, 0.0, atol=3e4 * error)


SHAPES = {
    "rectangle": Box((0.1, 0.2), (1, 2), rotation=0.3),
    "round rectangle": Box((0.1, 0.2), (1, 2), rotation=0.3, rounding=0.2),
    "box": Box(HERE, (1, 2, 0.5), rotation=(0.1, 0.2, 0.3)),
    "round box": Box(HERE, (1, 2, 0.5), rotation=(0.1, 0.2, 0.3), rounding=0.2),
    "tip": Wedge((0.1, 0.2), (1, 2), 0.8, rounding=0.1),
    "wedge": Wedge(HERE, (1, 2, 3), 2.0, edge=(1, 0, 0)),
    "cone": Revolution(Wedge((0.3, 0), (1, 0), 0.8), HERE, ALONG),
    "torus": Revolution(Circle((0, 0.6), 0.2), HERE, ALONG),
    "hull": Polyhedron([HalfSpace(n, n) for n in np.vstack([np.eye(3), [[-1, -1, -1]]])], 0.1),
    "curve": Curve([(-1, 0.5), (-0.5, -0.3), (0.2, 0.4), (0.7, 0.3), (1.2, -1)]),
    "smooth curve": Curve([(-2, 0), (-1, 0.1), (0, 0), (1, 0.1), (2, 0)], smooth=True),
    "ellipse": ELLIPSE,
    "vase": Revolution(ELLIPSE, HERE, ALONG),
    "smooth ball": SMOOTH_BALL,
    "bricks": Triangulated(bricks((1, 2, 3))),
}
EDGED = {"rectangle", "box", "wedge", "cone", "curve"}


@pytest.mark.parametrize("name", SHAPES)
def test_a_distance_has_its_normals_and_these_their_curvature(name):
    """By differences; a distance is one everywhere: its slope is the unit normal."""
    shape, h = SHAPES[name], 1e-6
    d = shape.dim
    x = np.random.default_rng(2).standard_normal((800, d))
    near = np.abs(shape.distance(x)) < 0.3
    x, few = x[near], 3e-2  # beside the corners of what is inside slopes jump
    n, bend = shape.normals(x), Wall(shape).curvature(x, 0.0)
    assert len(x) > 20
    np.testing.assert_allclose(np.linalg.norm(n, axis=1), 1.0, rtol=1e-13)
    for i, step in enumerate(h * np.eye(d)):
        slope = (shape.distance(x + step) - shape.distance(x - step)) / (2 * h)
        assert np.mean(np.abs(slope - n[:, i]) > 1e-6) < few
        if bend is not None and name not in EDGED:
            turn = (shape.normals(x + step) - shape.normals(x - step)) / (2 * h)
            assert np.mean(np.abs(turn - bend[:, :, i]).max(axis=1) > 1e-5) < few


@pytest.mark.parametrize("name", SHAPES)
def test_no_shape_contradicts_itself(name):
    """At its surface, on edges and corners too, and from afar; moved and turned."""
    shape, draw = SHAPES[name], np.random.default_rng(3)
    d = shape.dim
    x = 2.0 * draw.standard_normal((40, d))
    on = x - shape.distance(x)[:, None] * shape.normals(x)
    axis = None if d == 2 else ALONG
    for each in (shape, Turned(Moved(shape, lambda t: d * [0.3]), d * [1], lambda t: 0.5, axis)):
        for points in (x, on, 20 * x, np.round(2 * x) / 2, HERE[:d] + 1e-3 * x):
            Wall(each).check(points)


@pytest.mark.parametrize(
    ("phi", "depth"),
    [
        (lambda x, t: x[0] ** 2 / 4 + x[1] ** 2 - 1, 0.5),
        (lambda x, t: x[1] - 0.2 * ufl.sin(5 * x[0]), 1.0),
        (lambda x, t: 1 - ufl.exp(-x[1]), 1.0),
        (lambda x, t: ufl.tanh(3 * x[1]), 1.0),
        (lambda x, t: ufl.min_value(x[1] + 9 * x[0], x[1] - 9 * x[0]), 1.0),
        (lambda x, t: ufl.max_value(x[1] + 9 * x[0], x[1] - 9 * x[0]), 1.0),
    ],
)
def test_what_is_a_distance_at_its_surface_only_does_not_contradict_itself(phi, depth):
    level = LevelSet(phi, 2)
    x = 3.0 * np.random.default_rng(4).standard_normal((60, 2))
    distance = level.distance(x)
    for points in (x[distance > -depth], x[np.abs(distance) < depth]):
        Wall(level).check(points)


def test_corners_and_edges():
    square, wedge = Box((0, 0), (2, 2)), Wedge((0, 0, 0), (0, 0, 1), np.pi / 2, edge=UP[::-1])
    at = np.array([[2, 2], [0.5, 0.9], [3, 0], [1, 1]], dtype=float)
    np.testing.assert_allclose(square.distance(at), [2**0.5, -0.1, 2, 0], atol=1e-15)
    np.testing.assert_allclose(square.normals(at[:2]), [[0.5**0.5] * 2, [0, 1]], atol=1e-15)
    at = np.array([[5, 0, 3], [-7, 2, -2], [1, 0, -1]], dtype=float)
    np.testing.assert_allclose(wedge.distance(at), [3, 0, -(0.5**0.5)], atol=1e-14)
    corner = np.array([[1.5, 2.0, 2.5]])
    np.testing.assert_allclose(Box((0, 0, 0), (2, 2, 2)).distance(corner), (0.25 + 1 + 2.25) ** 0.5)
    round_ = Box((0, 0), (2, 2), rounding=0.5)
    np.testing.assert_allclose(round_.distance(np.array([[1.0, 1.0]])), 0.5 * (2**0.5 - 1))


def test_a_smooth_surface_is_of_higher_order():
    """An ellipsoid by ever more points: errors of the distance, of faces and smooth."""
    phi = LevelSet(lambda x, t: ufl.sqrt(x[0] ** 2 / 4 + x[1] ** 2 + x[2] ** 2) - 1, 3)
    errors = {False: [], True: []}
    for n in (200, 800, 3200):
        mesh = ball(n)
        x = ball(150, seed=2).points * [2, 1, 1]
        mesh.points = mesh.points * [2, 1, 1]
        for smooth, found in errors.items():
            distance = Triangulated(mesh, smooth).distance(x) - phi.distance(x)
            found.append(np.sqrt(np.mean(distance**2)))
    flat, curved = (np.log2(np.array(e[:-1]) / e[1:]) for e in errors.values())
    assert flat.min() > 1.8 and curved.min() > 2.5
    assert errors[True][-1] < 0.03 * errors[False][-1]


@pytest.mark.parametrize("size", [(3, 3, 3), (1, 2, 0.01)])
def test_smooth_bricks_keep_their_edges(size):
    """What is flat stays flat, inside and out, and beside a plate thinner than its faces."""
    smooth, sharp = Triangulated(bricks(size), smooth=True), Box((0, 0, 0), size)
    x = np.random.default_rng(0).uniform(-0.8, 0.8, (2000, 3)) * size
    np.testing.assert_allclose(smooth.distance(x), sharp.distance(x), rtol=0, atol=1e-14)
    outside = sharp.distance(x) > 0
    x = x[outside]
    np.testing.assert_allclose(smooth.normals(x), sharp.normals(x), rtol=0, atol=1e-12)
    assert "12 edges sharp" in repr(smooth)


def test_a_smooth_drum_has_sharp_rims():
    """Round before its side, flat before its ends, and a polygon beyond its rims."""
    n, high = 48, 0.4
    x = np.concatenate([np.column_stack([around(n)[:-1], np.full(n, z)]) for z in (-high, 0, high)])
    drum = Triangulated(triangulated_drum(x, n), smooth=True)
    exact = Revolution(Box((0, 0), (2 * high, 2)), (0, 0, 0), UP)
    assert f"{2 * n} edges sharp" in repr(drum)
    p = np.random.default_rng(5).uniform(-1.4, 1.4, (4000, 3)) * [1, 1, 0.5]
    off, above = np.hypot(p[:, 0], p[:, 1]) - 1, np.abs(p[:, 2]) - high
    chord = 1 - np.cos(np.pi / n)
    beyond = (off > -chord) & (above > 0)
    between = (np.maximum(off, above) < 0) & (np.abs(off - above) < chord)
    near = np.abs(exact.distance(p)) < 0.3
    error = np.abs(drum.distance(p) - exact.distance(p))
    assert error[near & ~beyond & ~between].max() < 1e-12
    assert error[near].max() < 1.01 * chord
    assert f"bulges by up to {chord:.3g} m over sharp edges" in drum.remark
    assert not Triangulated(bricks((1, 1, 1)), smooth=True).remark
    rim = np.array([0.0, 0.0, high]) + x[:n] * [1, 1, 0]
    beside = rim + chord * np.random.default_rng(1).uniform(-1, 1, (20, n, 3))
    with pytest.raises(InputError, match=r"its distance grows.*\(a smooth surface bulges"):
        Wall(drum).check(beside.reshape(-1, 3))


def triangulated_drum(x, n):
    """Rings of n points, (3 n, 3), clockwise as seen from above, and what closes them."""
    k = np.arange(n)
    after = (k + 1) % n
    sides = [
        np.stack(t, axis=1)
        for low in (0, n)
        for t in ((low + after, low + k, low + n + k), (low + n + after, low + after, low + n + k))
    ]
    fan = np.arange(1, n - 1)
    ends = [np.stack([0 * fan, fan, fan + 1], 1), 2 * n + np.stack([0 * fan, fan + 1, fan], 1)]
    return mesh_of(np.concatenate([*sides, *ends]), x)


def test_a_hole_of_triangles():
    mesh = ball(100)
    mesh = meshio.Mesh(mesh.points, [("triangle", mesh.cells[0].data[:, ::-1])])
    hole, x = Triangulated(mesh, smooth=True), np.array([[0.7, 0.2, 0.1]])
    np.testing.assert_allclose(hole.distance(x), Sphere((0, 0, 0), 1.0, True).distance(x))
    np.testing.assert_allclose(hole.curvature(x), Sphere((0, 0, 0), 1.0, True).curvature(x))


# -- Hertz --


def quarter(n, power=2.2):
    """A quarter of a block of unit sides, its elements smaller towards the corner at the origin."""
    mesh = box((n, n, n), (1, 1, 1)).mesh
    x = mesh.geometry.x
    x[:, :2] = (x[:, :2] + 0.5) ** power
    x[:, 2] = -((1 - x[:, 2]) ** power)
    names = {"top": (2, 0), "base": (2, -1), "x": (0, 0), "y": (1, 0)}
    return name_facets(
        mesh, {k: lambda x, i=i, v=v: np.isclose(x[i], v) for k, (i, v) in names.items()}
    )


def ball_on_block(shape):
    """A rigid ball of radius 1 pressed into it: pressures, and Hertz' for the same force."""
    block = ElasticSolid(
        quarter(8),
        youngs_modulus=1.0,
        poisson_ratio=0.3,
        density=1.0,
        fixed=["base"],
        prescribed={"x": (0, None, None), "y": (None, 0, None)},
    )
    contact = Contact(block, "top", Moved(shape, lambda t: (0, 0, -0.01 * t)), "gap", name="c")
    history = Scene([block], [contact], QuasiStatic(), geometry="newton").run(1.0, 1.0)
    assert history.finished and history["newton"].sum() <= 5
    hertz = PointContact(-4 * contact.force[:, 2].sum(), effective_modulus(1.0, 0.3), 1.0)
    radii = np.linalg.norm(contact.surface.points[:, :2], axis=1)
    return -contact.multiplier, hertz.pressure(radii), contact.surface.area


@pytest.mark.second
def test_hertz_by_a_ball_in_four_ways(tmp_path):
    """By formula, in UFL, turned and as an STL of 400 points, smooth: the same to round-off."""
    file = tmp_path / "ball.stl"
    ball(400, UP).write(file)
    shapes = [
        Sphere(UP, 1.0),
        LevelSet(lambda x, t: ufl.sqrt(x[0] ** 2 + x[1] ** 2 + (x[2] - 1) ** 2) - 1, 3),
        Revolution(Circle((0, 0), 1.0), UP, UP),
        Triangulated(file, smooth=True),
    ]
    found, exact, area = ball_on_block(shapes[0])
    assert found.max() == pytest.approx(exact.max(), rel=0.06)
    assert (area * (found - exact) ** 2).sum() < 0.2**2 * (area * exact**2).sum()
    for shape in shapes[1:]:
        np.testing.assert_allclose(ball_on_block(shape)[0], found, atol=1e-10 * found.max())
    facets = ball_on_block(Triangulated(file))
    assert np.abs(facets[0] - facets[1]).max() > facets[1].max()  # they are no ball


def cylinder_on_block(shape):
    """A rigid cylinder of radius 1 pressed into a strip: pressures, Hertz', and areas."""
    mesh = rectangle((80, 24), (2, 1)).mesh
    x = mesh.geometry.x
    x[:, 0] = np.sign(x[:, 0]) * np.abs(x[:, 0]) ** 2.2
    x[:, 1] = -((1 - x[:, 1]) ** 2.2)
    sides = {"top": lambda x: np.isclose(x[1], 0), "base": lambda x: np.isclose(x[1], -1)}
    block = ElasticSolid(
        name_facets(mesh, sides), youngs_modulus=1.0, poisson_ratio=0.3, density=1.0, fixed=["base"]
    )
    contact = Contact(block, "top", Moved(shape, lambda t: (0, -0.01 * t)), "gap", name="c")
    history = Scene([block], [contact], QuasiStatic(), geometry="newton").run(1.0, 1.0)
    assert history.finished and history["newton"].sum() <= 8, history.reason
    hertz = LineContact(-contact.force[:, 1].sum(), effective_modulus(1.0, 0.3), 1.0)
    return -contact.multiplier, hertz.pressure(contact.surface.points[:, 0]), contact.surface.area


def test_hertz_by_a_cylinder_in_four_ways():
    """By formula, in UFL, by a spline and by lines through points: pressures against Hertz'."""
    shapes = [
        Circle((0, 1), 1.0),
        LevelSet(lambda x, t: ufl.sqrt(x[0] ** 2 + (x[1] - 1) ** 2) - 1, 2),
        Curve(around(90, above=1), smooth=True),
        Curve(around(90, above=1)),
    ]
    pressures, errors = [], []
    for shape in shapes:
        found, exact, area = cylinder_on_block(shape)
        error = (area * (found - exact) ** 2).sum() / (area * exact**2).sum()
        pressures.append(found)
        errors.append(np.sqrt(error))
    assert max(errors[:3]) < 0.012 and errors[3] > 0.2
    np.testing.assert_allclose(pressures[1], pressures[0], atol=1e-10 * exact.max())
    np.testing.assert_allclose(pressures[2], pressures[0], atol=1e-3 * exact.max())


# -- rolling, torques, what is driven by a force --


def disc(n=360, radius=0.1):
    """A disc of n corners that stands on y = 0."""
    rim = around(n, radius, above=radius)[:-1]
    k = np.arange(n)
    cells = np.stack([0 * k, k + 1, (k + 1) % n + 1], axis=1)
    mesh = compat.create_mesh(MPI.COMM_WORLD, cells, np.vstack([[0, radius], rim]), "triangle")
    return name_facets(mesh, {"rim": lambda x: np.full(x.shape[1], True)})


def roll(slope, law, friction=0.3, until=0.3):
    """A disc let go on a slope: its acceleration, that of its rim about its centre, the history.
    By theta = 1 its corners, on which it would stop a little, cost nearly nothing."""
    solid = RigidSolid(disc(), mass=1.0, gravity=(G * np.sin(slope), -G * np.cos(slope)))
    contact = Contact(solid, "rim", FLOOR, law, friction=friction, name="c")
    probes = torques(contact, lambda: solid.place)
    history = Scene([solid], [contact], ThetaScheme(1.0)).run(until, 1e-2, probes=probes)
    assert history.finished, history.reason
    turned = (history["c.torque"] * history.span).sum()
    assert turned == pytest.approx(solid.inertia[0, 0] * solid.velocity[2], rel=1e-4)
    return solid.velocity[0] / until, -0.1 * solid.velocity[2] / until, history


def test_a_disc_rolls_down_a_slope():
    """With 2/3 g sin a, by the torque of friction."""
    acceleration, turning, _ = roll(0.1, "velocity")
    exact = 2 / 3 * G * np.sin(0.1)
    assert acceleration == pytest.approx(exact, rel=0.015)
    assert turning == pytest.approx(acceleration, rel=1e-3)


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_a_disc_slips_down_a_steep_slope(share):
    """From tan a = 3 mu on: g (sin a - mu cos a), and turns with twice mu g cos a."""
    slope = np.arctan(share * 3 * 0.3)
    acceleration, turning, history = roll(slope, "gap")
    slips = share > 1
    pull, grip = G * np.sin(slope), 0.3 * G * np.cos(slope)
    assert acceleration == pytest.approx(pull - grip if slips else 2 / 3 * pull, rel=0.01)
    assert turning == pytest.approx(2 * grip if slips else 2 / 3 * pull, rel=0.02)
    assert (history["c.slipping"][1:].mean() > 0.5) == slips


@pytest.mark.parametrize("mass", [10.0, 1e-3])
def test_a_punch_driven_by_a_force(mass):
    """A rigid punch of some mass, or hardly any, pressed on an elastic base comes to rest where
    its force is borne, as deep as a table that is driven there."""
    base = ElasticSolid(
        rectangle((12, 6), (0.6, 0.3)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        fixed=["base"],
        name="base",
    )
    mesh = rectangle((4, 2), (0.2, 0.1)).mesh
    mesh.geometry.x[:, 1] += 0.3
    mesh = name_facets(mesh, {"under": lambda x: np.isclose(x[1], 0.3)})
    punch = RigidSolid(mesh, mass=mass, force=(0, -2000.0), held=["x", "turning"], name="punch")
    contact = Contact(base, "top", (punch, "under"), "gap", name="c")
    about = (0.1, 0.3)
    scene = Scene([base, punch], [contact], ThetaScheme(1.0))
    history = scene.run(0.4, 1e-2, probes=torques(contact, about))
    assert history.finished, history.reason
    assert history["c.force_y"][-1] == pytest.approx(-2000.0, rel=1e-9)
    assert history["c.torque"][-1] == pytest.approx(200.0, rel=0.01)
    sunk = 0.35 - punch.place[1]
    held = Moved(Box((0, 0.35), (0.202, 0.1), rounding=1e-3), lambda t: (0, -sunk * t))
    same = ElasticSolid(
        rectangle((12, 6), (0.6, 0.3)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        fixed=["base"],
    )
    driven = Contact(same, "top", held, "gap", name="d")
    assert Scene([same], [driven], QuasiStatic()).run(1.0, 1.0).finished
    assert driven.force[:, 1].sum() == pytest.approx(-2000.0, rel=0.05)


def test_torques_in_space():
    """A box that lies on the floor, pushed by a force beside its middle: what the floor bears."""
    solid = RigidSolid(
        box(), mass=3.0, gravity=(0, 0, -G), torque=(0.5, 0.2, 0.1), force=(1.0, 0, 0)
    )
    contact = Contact(solid, "base", HalfSpace((0, 0, 0), UP), friction=0.5, name="c")
    probes = torques(contact, lambda: solid.place)
    history = Scene([solid], [contact]).run(0.02, 1e-3, probes=probes)
    found = [history[f"c.torque_{axis}"][-1] for axis in "xyz"]
    np.testing.assert_allclose(found, [-0.5, -0.2, -0.1], atol=1e-6)


def test_stick_and_slip_on_a_belt():
    """A block on a belt, drawn back by a spring: it sticks for 2a/V, a = (mu_s - mu_k) N/k, and
    slips for (2 pi - 2 arctan(a w/V))/w, until it is as fast as the belt."""
    mass, stiffness, speed, static, kinetic = 2.0, 200.0, 0.2, 0.5, 0.3
    solid = RigidSolid(
        rectangle(),
        mass=mass,
        gravity=(0, -G),
        springs={(0.0, 0.4): (stiffness, 0.0)},
        held=["turning"],
        velocity=(speed, 0.0),
    )
    belt = Moved(FLOOR, lambda t: (speed * t, 0.0))
    contact = Contact(solid, "base", belt, friction=StaticKinetic(static, kinetic), name="c")
    dt, omega = 2.5e-3, np.sqrt(stiffness / mass)
    a = (static - kinetic) * mass * G / stiffness
    stick, slip = 2 * a / speed, (2 * np.pi - 2 * np.arctan(a * omega / speed)) / omega
    history = Scene([solid], [contact]).run(1.45, dt)
    assert history.finished, history.reason
    slips = history["c.slipping"] > 0
    turns = history.time[1:][slips[1:] != slips[:-1]]
    first = static * mass * G / (stiffness * speed)
    exact = [first, slip, stick, slip]
    # each turn is rounded to a step
    np.testing.assert_allclose(np.diff(turns, prepend=0.0), exact, atol=2 * dt)


# -- an arch of rigid blocks --


def arch(blocks, thickness, tilt, law="gap"):
    """Its greatest speed after 0.03 s."""
    gravity = (G * np.sin(tilt), -G * np.cos(tilt))
    ground, joint = HalfSpace((0, 0), (0, 1)), {"formulation": law, "friction": 0.8}
    solids = []
    for i, x in enumerate(corners(blocks, thickness)):
        mesh = compat.create_mesh(MPI.COMM_WORLD, [[0, 1, 2, 3]], x, "quadrilateral")
        ends = {
            name: lambda x, a=a, b=b: np.isclose(
                (x[0] - a[0]) * (b[1] - a[1]), (x[1] - a[1]) * (b[0] - a[0]), rtol=0, atol=1e-9
            )
            for name, (a, b) in {"low": x[:2], "high": x[2:]}.items()
        }
        mesh = name_facets(mesh, ends)
        solids.append(RigidSolid(mesh, density=1000.0, gravity=gravity, name=f"block {i}"))
    contacts = [
        Contact(solids[0], "low", ground, name="right", **joint),
        Contact(solids[-1], "high", ground, name="left", **joint),
    ]
    for one, other in zip(solids[:-1], solids[1:]):
        contacts.append(Contact(one, "high", (other, "low"), name=f"under {other.name}", **joint))
    history = Scene(solids, contacts, ThetaScheme(1.0)).run(0.03, 1e-2)
    assert history.finished, history.reason
    return max(np.abs(solid.velocity).max() for solid in solids)


@pytest.mark.parametrize("law", ["velocity", "gap"])
def test_an_arch_is_tilted_until_it_falls(law):
    """6 blocks; 0.3 % below the angle of limit analysis it stands, 0.3 % above it falls."""
    tilt = collapse_tilt(6, 0.15, 0.8)
    assert arch(6, 0.15, 0.997 * tilt, law) < 1e-9
    assert arch(6, 0.15, 1.003 * tilt, law) > 1e-4


def test_limit_analysis_of_arches():
    """Milankovitch's thickness 0.1075 R."""
    assert 0 < collapse_tilt(200, 0.1075, 0.8) < 1e-3
    with pytest.raises(InputError, match="falls upright"):
        collapse_tilt(200, 0.1073, 0.8)
    with pytest.raises(InputError, match="blocks = 1"):
        collapse_tilt(1, 0.2, 0.8)
    with pytest.raises(InputError, match="thickness = 2"):
        collapse_tilt(8, 2, 0.8)


# -- in Newton's method --


@pytest.mark.parametrize(
    "shape",
    [
        Box((0, 0, 0.3), (0.5, 0.5, 0.6), rotation=(0, 0, 0.3), rounding=0.1),
        Revolution(Curve(around(40) * [0.6, 0.2], smooth=True), (0, 0, 0.2), (1, 0, 0)),
    ],
)
def test_newton_knows_the_curvature_of_shapes(shape):
    """Pressed into a block and drawn along it."""
    block = ElasticSolid(
        quarter(5, 1.0),
        youngs_modulus=1.0,
        poisson_ratio=0.3,
        density=1.0,
        fixed=["base"],
    )
    contact = Contact(block, "top", Moved(shape, lambda t: (0, 0, -0.02 * t)), "gap", name="c")
    scene = Scene([block], [contact], QuasiStatic(), geometry="newton")
    history = scene.run(1.0, 1.0)
    assert history.finished and history["newton"].sum() <= 8
    assert scene.errors[-1] < 1e-9 and contact.force[:, 2].sum() < 0


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("place", [0.0, 0.0103])
@pytest.mark.parametrize("shape", ["wedge", "box"])
def test_a_sharp_edge_pressed_in(shape, place, friction):
    """Under a node of the mesh or between two, drawn along: not refused, what is inside bears."""
    sharp = Wedge((place, 0), (0, 1), 1.5) if shape == "wedge" else Box((place, -1), (0.15, 2))
    block = ElasticSolid(
        rectangle((16, 8), (0.4, 0.2)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        prescribed={"top": lambda t: (0.03 * t, -0.02 * t)},
    )
    contact = Contact(block, "base", sharp, "gap", friction=friction, name="c")
    history = Scene([block], [contact], QuasiStatic(), geometry="newton").run(1.0, 1.0)
    assert history.finished, history.reason
    assert contact.gap.max() < 1e-8 and history["c.force_y"][-1] > 2000


# -- what is refused --

PLANE = HalfSpace((0, 0), (0, 1))
CELLS = [[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]]
SHARP = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])


def mesh_of(cells, points=SHARP, kind="triangle"):
    return meshio.Mesh(points, [(kind, np.asarray(cells))])


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Polyhedron([PLANE]), ("half_spaces", "two at least")),
        (lambda: Polyhedron([PLANE, HalfSpace((0, 0, 0), UP)]), ("half_spaces", "all in 2D")),
        (lambda: Polyhedron(PLANE), ("half_spaces", "list")),
        (lambda: Polyhedron([PLANE, HalfSpace((0, 1), (0, -1))]), ("in common",)),
        (lambda: Polyhedron([PLANE, HalfSpace((0, 0), (0, -1))]), ("in common",)),
        (lambda: Box((0, 0), (1, 0)), ("size[1]", "> 0")),
        (lambda: Box((0, 0), (1, 1, 1)), ("size",)),
        (lambda: Box((0, 0), (1, 1), rounding=0.5), ("rounding", "0.5")),
        (lambda: Box((0, 0), (1, 1), rounding=-0.1), ("rounding", ">= 0")),
        (lambda: Box((0, 0, 0), (1, 1, 1), rotation=0.1), ("rotation",)),
        (lambda: Wedge((0, 0), (0, 1), np.pi), ("angle", "< pi")),
        (lambda: Wedge((0, 0), (0, 0), 1.0), ("direction", "zero")),
        (lambda: Wedge((0, 0), (0, 1), 1.0, edge=UP), ("edge", "None in 2D")),
        (lambda: Wedge((0, 0, 0), (0, 1, 0), 1.0), ("edge", "3 finite numbers")),
        (lambda: Wedge((0, 0, 0), UP, 1.0, edge=UP), ("edge", "along the direction")),
        (lambda: Revolution(Sphere(UP, 1.0), HERE, UP), ("section", "plane")),
        (lambda: Revolution("vase", HERE, UP), ("obstacle", "vase")),
        (lambda: Revolution(PLANE, HERE, (0, 0, 0)), ("axis", "zero")),
        (lambda: Curve([(0, 0)]), ("points", "two or more")),
        (lambda: Curve([(0, 0, 0), (1, 1, 1)]), ("points", "plane")),
        (lambda: Curve([(0, 0), (1, np.nan)]), ("points",)),
        (
            lambda: Triangulated(mesh_of(CELLS, np.where(SHARP == 1, np.nan, SHARP))),
            ("points must be finite", "point 1 is [nan"),
        ),
        (lambda: Curve("hill"), ("points", "hill")),
        (lambda: Curve([(0, 0), (0, 0), (1, 1)]), ("points[0], points[1]", "the same")),
        (lambda: Curve([(0, 0), (1, 0), (0, 0)]), ("points", "four")),
        (lambda: Triangulated("nowhere.stl"), ("nowhere.stl", "no such file")),
        (lambda: Triangulated(3), ("surface = 3", "path")),
        (lambda: Triangulated(mesh_of(CELLS), smooth=1), ("smooth = 1",)),
        (lambda: Triangulated(mesh_of([[0, 1]], kind="line")), ("surface", "['line']")),
        (lambda: Triangulated(mesh_of(CELLS[:3])), ("must be closed", "3 edges")),
        (lambda: Triangulated(mesh_of([*CELLS[:3], [1, 3, 2]])), ("one orientation",)),
        (lambda: Triangulated(mesh_of([*CELLS, *CELLS])), ("one orientation",)),
        (lambda: Triangulated(mesh_of([*CELLS, [1, 1, 2]])), ("1 of its triangles", "no area")),
        (lambda: Triangulated(mesh_of(CELLS, SHARP * np.inf)), ("surface",)),
        (lambda: Triangulated(folded(100), smooth=True), ("smooth = True", "folded")),
    ],
)
def test_what_is_refused(make, words):
    with np.errstate(invalid="ignore"):
        refused(make, *words)


def folded(n):
    """A bipyramid whose upper tip leans out over its base."""
    k = np.arange(n)
    x = np.vstack([np.hstack([around(n)[:-1][::-1], np.zeros((n, 1))]), [[0, 0, -1], [2, 0, 0.3]]])
    upper = np.stack([k, (k + 1) % n, 0 * k + n + 1], axis=1)
    lower = np.stack([(k + 1) % n, k, 0 * k + n], axis=1)
    return mesh_of(np.vstack([upper, lower]), x)


@pytest.mark.parametrize(
    "points, lines",
    [
        ([(-1, 0), (-1, 0.2), (1, 0), (1, 0.2), (-1, 0)], (1, 3)),
        ([(-1, 0), (0.3, 0), (0.3, 0.15), (-0.3, 0.15), (-0.3, -0.2), (1, -0.2)], (0, 3)),
        ([(-1, 0), (1, 0), (0.5, 0)], (0, 1)),
        ([(-1, 0), (1, 0), (1, 1), (0, 0)], (0, 2)),  # an end on a line
        ([(0, 0), (1, 0), (1, 1), (2, 1), (2, 0), (0.5, 0)], (0, 4)),  # along each other
    ],
)
@pytest.mark.parametrize("smooth", [False, True])
def test_curves_that_cross_themselves_are_refused(points, lines, smooth):
    """They were accepted, and a block lay 27 mm inside one."""
    (a, b) = lines
    match = re.escape(f"points[{a}:{a + 2}], points[{b}:{b + 2}]") + ".*must not meet"
    with pytest.raises(InputError, match=match):
        Curve(points, smooth)


def test_curves_whose_lines_only_follow_each_other_are_not():
    around_twice = [(0, 0), (1, 0), (1, 1), (-1, 1), (-1, -1), (2, -1), (2, 2)]
    for points in (around_twice, [(0, 0), (0, 1), (1, 1), (1, 0), (0, 0)], around(500)):
        Curve(points)
