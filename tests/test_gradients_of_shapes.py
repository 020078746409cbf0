# SPDX-License-Identifier: LGPL-3.0-or-later
"""Derivatives of runs before shapes that have no numbers in UFL, by what moves and by a shift of
the shape, and how far central differences of the same are off."""

import numpy as np
import pytest
from scenes import G, box, rectangle

from fenicsx_contact import (
    Box,
    Circle,
    Contact,
    Curve,
    ElasticSolid,
    HalfSpace,
    InputError,
    Moved,
    QuasiStatic,
    Revolution,
    RigidSolid,
    Scene,
    ThetaScheme,
    Wedge,
)
from fenicsx_contact.gradients import Centre, Force, Law, ObstacleShift, Start, tangents

ALONG = np.linspace(-1.0, 1.0, 15)
BOWL = np.column_stack([ALONG, 0.5 * ALONG**2])
LINES = np.array([(-1, 0.02), (-0.13, 0), (1, 0.1)])
TOP = np.column_stack([-0.5 * ALONG**2, ALONG])[::-1]  # along z, and away from it
ASIDE = np.array([0.6, 0.3, -0.2])
#: Of shifts (x, y) and (x, y, z).
PLANE = {
    "spline": lambda s: Curve(BOWL + s, smooth=True),
    "lines": lambda s: Curve(LINES + s),
    "rounded box": lambda s: Box(np.add(s, (0, -0.5)), (2, 1), rounding=0.4),
    "rounded wedge": lambda s: Wedge(np.add(s, (0, 0.02)), (0, 1), 2.6, rounding=0.1),
}
SPACE = {
    "spline": lambda s: Revolution(Curve(TOP[:8], smooth=True), s, (0, 0, 1)),
    "circle": lambda s: Revolution(Circle((-1, 0.2), 1.0), s, (0, 0, 1)),
    "rounded box": lambda s: Box(np.add(s, (0, 0, -0.5)), (0.5, 0.5, 1), rounding=0.2),
    "rounded edge": lambda s: Wedge(s, (0, 0.1, 1), 2.6, (0, 1, 0), rounding=0.1),
}


def worst(build, by, measure, until, dt):
    """How far the best central differences by each parameter are off, over the largest derivative
    by it. ``build`` makes a scene of changes of them, ``measure`` quantities by name of a scene;
    ``by``: a size of each, and what makes it of a scene."""
    scene = build()
    asked = {name: parameter(scene) for name, (_, parameter) in by.items()}
    result = tangents(scene, until, dt, asked, measure(scene))
    assert result.history.finished and not result.kinks, (result.history.reason, result.kinks)
    exact = np.array([result[name][-1] for name in measure(scene)])

    def ends(name, change):
        scene = build(**{name: change})
        assert scene.run(until, dt, progress=False).finished
        return np.array([quantity.value() for quantity in measure(scene).values()])

    found = 0.0
    for i, (name, (size, _)) in enumerate(by.items()):
        slopes = [
            (ends(name, h) - ends(name, -h)) / (2 * h) for h in np.multiply((1e-4, 1e-5), size)
        ]
        assert exact[:, i].any()
        off = [np.abs(slope - exact[:, i]).max() for slope in slopes]
        found = max(found, min(off) / np.abs(exact[:, i]).max())
    return found


@pytest.mark.second
@pytest.mark.parametrize(
    ("formulation", "theta", "located"),
    [("velocity", 0.5, False), ("velocity", 0.5, True), ("gap", 1.0, False)],
)
@pytest.mark.parametrize("shape", PLANE)
def test_a_rigid_block_slides_on_a_shape(shape, formulation, theta, located):
    def build(speed=0.0, shift=0.0):
        block = RigidSolid(
            rectangle(size=(0.2, 0.1)),
            mass=2.0,
            gravity=(0, -G),
            velocity=(0.6 + speed, 0),
            spin=0.3,
        )
        block.restore({**block.state(), "place": np.add(block.place, (0, 0.05))})
        contact = Contact(
            block, "base", PLANE[shape](shift * ASIDE[:2]), formulation, friction=0.2, name="c"
        )
        settings = {"deepest": 1.0, "locate_impacts": located, "geometry": "newton"}
        return Scene([block], [contact], ThetaScheme(theta), **settings)

    def measure(scene):
        solid = scene.solids[0]
        return {"x": Centre(solid, (1, 0)), "y": Centre(solid, (0, 1))}

    by = {
        "speed": (0.6, lambda s: Start(s.solids[0], velocity=(1, 0))),
        "shift": (0.1, lambda s: ObstacleShift(s.contacts[0], ASIDE[:2])),
    }
    assert worst(build, by, measure, 0.15, 5e-3) < 1e-6


@pytest.mark.second
@pytest.mark.parametrize("shape", SPACE)
def test_a_block_is_pressed_on_a_shape_in_space(shape):
    def build(shift=0.0):
        block = ElasticSolid(
            box((3, 3, 2), (0.4, 0.4, 0.2)),
            youngs_modulus=1e6,
            poisson_ratio=0.3,
            density=1000.0,
            prescribed={"top": lambda t: (1e-3 * t, 5e-4 * t, -2e-2 * t)},
        )
        contact = Contact(block, "base", SPACE[shape](shift * ASIDE), "gap", 0.3, name="die")
        return Scene([block], [contact], QuasiStatic(), geometry="newton", deepest=1.0)

    def measure(scene):
        return {c: Force(scene.contacts[0], way) for c, way in zip("xyz", np.eye(3))}

    by = {"shift": (0.1, lambda s: ObstacleShift(s.contacts[0], ASIDE))}
    assert worst(build, by, measure, 1.0, 1.0) < 1e-6


def plate(height, way):
    """A plane that moves as it is told."""
    return Moved(HalfSpace((0.0, height), (0.0, 1.0)), way)


@pytest.mark.parametrize(("formulation", "theta"), [("velocity", 0.5), ("gap", 1.0), ("gap", 0.75)])
def test_a_block_on_a_table_that_shakes(formulation, theta):
    """It is thrown up, lands and slides; by friction, the start and the place of the table."""

    def build(friction=0.0, speed=0.0, shift=0.0):
        block = RigidSolid(
            rectangle(size=(0.2, 0.1)), mass=2.0, gravity=(0, -G), velocity=(0.4 + speed, 0.0)
        )
        table = plate(-0.01 + shift, lambda t: (0.02 * np.sin(9 * t), 0.01 * np.sin(31 * t)))
        contact = Contact(block, "base", table, formulation, friction=0.2 + friction, name="c")
        return Scene([block], [contact], ThetaScheme(theta), deepest=1.0, geometry="newton")

    def measure(scene):
        solid = scene.solids[0]
        each = {"x": Centre(solid, (1, 0)), "y": Centre(solid, (0, 1))}
        return each | {"v": Centre(solid, (1, 0), "velocity")}

    by = {
        "friction": (0.2, lambda s: Law(s.contacts[0], "friction")),
        "speed": (0.4, lambda s: Start(s.solids[0], velocity=(1, 0))),
        "shift": (0.1, lambda s: ObstacleShift(s.contacts[0], (0, 1))),
    }
    assert worst(build, by, measure, 0.36, 4e-3) < 1e-6


@pytest.mark.parametrize("inertia", [False, True])
def test_a_plate_presses_a_block_and_draws_it(inertia):
    def build(friction=0.0, shift=0.0):
        block = ElasticSolid(
            rectangle((3, 2), (0.2, 0.1)),
            youngs_modulus=1e6,
            poisson_ratio=0.3,
            density=1000.0,
            fixed=["base"],
        )
        lid = Moved(HalfSpace((0.0, 0.1 + shift), (0.0, -1.0)), lambda t: (1e-3 * t * t, -2e-3 * t))
        contact = Contact(block, "top", lid, "gap", friction=0.3 + friction, name="c")
        scheme = ThetaScheme(1.0) if inertia else QuasiStatic()
        return Scene([block], [contact], scheme, deepest=1.0)

    def measure(scene):
        return {c: Force(scene.contacts[0], way) for c, way in zip("xy", np.eye(2))}

    by = {
        "friction": (0.3, lambda s: Law(s.contacts[0], "friction")),
        "shift": (1e-3, lambda s: ObstacleShift(s.contacts[0], (0, 1))),
    }
    assert worst(build, by, measure, 1.0, 0.1) < 1e-6


class Bowl:
    """A round one of one's own, whose slopes and curvature are told so many times too large."""

    dim = 2

    def __init__(self, slope=1.0, bend=1.0):
        self.slope, self.bend = slope, bend

    def _out(self, points):
        off = points - [0.0, 1.0]
        size = np.linalg.norm(off, axis=1)
        return off / size[:, None], size

    def distance(self, points):
        return 1.0 - self._out(points)[1]

    def normals(self, points):
        return -self._out(points)[0]

    def slopes(self, points):
        return -self.slope * self._out(points)[0]

    def curvature(self, points):
        out, size = self._out(points)
        return -self.bend * (np.eye(2) - out[:, :, None] * out[:, None, :]) / size[:, None, None]


@pytest.mark.parametrize(
    ("told", "words"),
    [
        ({}, ""),
        ({"slope": 2.0}, "slopes"),
        ({"bend": 0.0}, "curvature"),
        ({"bend": 2}, "curvature"),
    ],
)
def test_what_own_obstacles_say_of_themselves_is_not_believed(told, words):
    """Derivatives were wrong by half of what they are, and said nothing; runs are not."""
    mesh = rectangle(size=(0.2, 0.1))
    mesh.mesh.geometry.x[:, 1] += 0.02
    block = RigidSolid(mesh, mass=2.0, gravity=(0, -G), velocity=(0.6, 0.0))
    contact = Contact(block, "base", Bowl(**told), friction=0.2, name="bowl")
    scene = Scene([block], [contact], deepest=1.0)
    by = {"v": Start(block, velocity=(1, 0))}
    if not words:
        assert tangents(scene, 0.05, 5e-3, by, {"x": Centre(block, (1, 0))}).history.finished
        return
    assert scene.run(0.05, 5e-3, progress=False).finished
    with pytest.raises(InputError, match=f"'bowl': {words} of its obstacle along .* must be"):
        tangents(scene, 0.05, 5e-3, by)


@pytest.mark.parametrize("law, theta", [("velocity", 0.5), ("velocity", 1.0), ("gap", 1.0)])
def test_over_joints_of_flush_boxes(law, theta):
    """What meets another face than where the step started depends on the places by that one."""

    def slides(speed):
        mesh = rectangle((1, 1), (0.2, 0.1))
        mesh.mesh.geometry.x[:, 1] += 0.02
        block = RigidSolid(mesh, mass=2.0, gravity=(0, -10.0), velocity=(speed, 0))
        contacts = [
            Contact(block, "base", Box((0.8 * i - 0.4, -0.2), (0.8, 0.4)), law, name=f"box {i}")
            for i in range(-1, 3)
        ]
        return block, Scene([block], contacts, ThetaScheme(theta))

    block, scene = slides(1.0)
    by, of = {"v": Start(block, velocity=(1, 0))}, {"x": (1, 0), "y": (0, 1)}
    quantities = {name: Centre(block, way) for name, way in of.items()}
    found = tangents(scene, 0.6, 7e-3, by, quantities)
    assert found["x"][-1][0] == pytest.approx(0.602, rel=1e-9)
    assert abs(found["y"][-1][0]) < 1e-12
