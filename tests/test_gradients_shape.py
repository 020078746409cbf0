# SPDX-License-Identifier: LGPL-3.0-or-later
"""Derivatives by the shape of an obstacle, of forces and pressures: against formulas, against
plateaus of central differences, and adjoints against tangents."""

from __future__ import annotations

import numpy as np
import pytest
import ufl
from dolfinx import fem
from mpi4py import MPI
from scenes import FLOOR, G, box, rectangle

from fenicsx_contact import (
    Circle,
    Contact,
    ElasticSolid,
    HyperelasticSolid,
    InputError,
    LevelSet,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    neo_hookean,
)
from fenicsx_contact.gradients import (
    Centre,
    Force,
    NoDerivative,
    ObstacleShift,
    Pressure,
    Shape,
    Start,
    adjoints,
    tangents,
)

LONG = pytest.mark.long


def constants(mesh, values):
    return [fem.Constant(mesh.mesh, float(value)) for value in values]


def wave(numbers):
    """No distance: its gradient is about 2, and not even."""
    height, amplitude, bend = numbers
    return LevelSet(
        lambda x, t: 2 * (x[1] - height - amplitude * ufl.cos(20 * x[0] + 0.3) - bend * x[0] ** 2),
        2,
    )


WAVE = np.array([-2e-3, 2e-3, 0.01])  # m, m, 1/m


def best(build, values, until, dt, measure, shares=(1e-3, 1e-4, 1e-5), size=None):
    """Derivatives of a run's columns by shapes, and how far the best central differences of each
    are off, over the largest of all. ``measure``: quantities by name, of a scene."""
    scene, numbers = build(values)
    contact = scene.contacts[0]
    asked = {f"c{i}": Shape(contact, number) for i, number in enumerate(numbers)}
    result = tangents(scene, until, dt, asked, measure(scene))
    assert result.history.finished and not result.kinks, (result.history.reason, result.kinks)
    exact = np.array([result[name][-1] for name in measure(scene)])

    def ends(changed):
        scene, _ = build(changed)
        assert scene.run(until, dt).finished
        return np.array([quantity.value() for quantity in measure(scene).values()])

    off = np.full(len(values), np.inf)
    for i, way in enumerate(np.eye(len(values))):
        for share in shares:
            h = share * (np.abs(values[i]) if size is None else size)
            difference = (ends(values + h * way) - ends(values - h * way)) / (2 * h)
            largest = np.abs(exact[:, i]).max()
            off[i] = min(off[i], np.abs(difference - exact[:, i]).max() / largest)
    return result, off


# -- the obstacle --


def test_a_level_set_by_its_numbers_and_by_the_place():
    """Distances and normals, off the surface, too; a Constant may be of any mesh."""
    mesh = rectangle()
    numbers = constants(mesh, WAVE)
    obstacle, h = wave(numbers), 1e-6
    x = np.random.default_rng(1).random((7, 2))
    slopes = obstacle.slopes(x)
    for i, way in enumerate(np.eye(2)):
        ahead, back = (obstacle.distance(x + s * h * way) for s in (1, -1))
        np.testing.assert_allclose(slopes[:, i], (ahead - back) / (2 * h), atol=1e-8)
    assert np.abs(slopes - obstacle.normals(x)).max() > 0.01
    for number in numbers:
        closer, turned = obstacle.changes(number, x)
        value, ends = float(number.value), []
        for sign in (1, -1):
            number.value = value + sign * h
            ends.append((obstacle.distance(x), obstacle.normals(x)))
        number.value = value
        np.testing.assert_allclose(closer, (ends[0][0] - ends[1][0]) / (2 * h), atol=1e-8)
        np.testing.assert_allclose(turned, (ends[0][1] - ends[1][1]) / (2 * h), atol=1e-8)


# -- statics --


def pressed(values, kind=ElasticSolid, formulation="gap", friction=0.0, cells=(8, 4)):
    """A block pressed on a wave, and drawn along a little."""
    material = {"youngs_modulus": 1e6, "poisson_ratio": 0.3}
    if kind is HyperelasticSolid:
        material = {"energy": neo_hookean(1e6, 0.3)}
    mesh = rectangle(cells, (0.4, 0.2))
    numbers = constants(mesh, values)
    block = kind(
        mesh, density=1000.0, prescribed={"top": lambda t: (1e-3 * t, -5e-3 * t)}, **material
    )
    contact = Contact(block, "base", wave(numbers), formulation, friction, name="die")
    scene = Scene([block], [contact], QuasiStatic(), geometry="newton", deepest=1.0)
    return scene, numbers


def borne(scene):
    """The force, and the pressures at all nodes, times an area."""
    contact = scene.contacts[0]
    axes = zip("xyz", np.eye(contact.surface.dim))
    result = {f"force {name}": Force(contact, axis) for name, axis in axes}
    for i, point in enumerate(contact.surface.points):
        result[f"pressure {i}"] = Pressure(contact, point)
    return result


@pytest.mark.parametrize(
    ("formulation", "friction"),
    [
        pytest.param("gap", 0.0, marks=pytest.mark.second),
        pytest.param("gap", 0.3, marks=pytest.mark.second),
        pytest.param("velocity", 0.3, marks=LONG),
    ],
)
def test_force_and_pressures_of_an_elastic_block(formulation, friction):
    """All points bear, or some are open; force is what the pressures make."""

    def build(values):
        return pressed(values, formulation=formulation, friction=friction)

    result, off = best(build, WAVE, 2.0, 1.0, borne)
    assert off.max() < 1e-8, off
    np.testing.assert_array_equal(result["die.force_y"], result["force y"])
    # pressed less, some points are open, and what they see of the wave counts nowhere
    result, off = best(build, WAVE, 0.8, 0.8, borne)
    pressures = [q for name, q in borne(build(WAVE)[0]).items() if name.startswith("p")]
    ends = np.array([result.history[f"pressure {i}"][-1] for i in range(len(pressures))])
    slopes = np.array([result[f"pressure {i}"][-1] for i in range(len(pressures))])
    assert 0 < (ends == 0).sum() < len(ends) and (slopes[ends == 0] == 0).all()
    assert off.max() < 1e-8, off


@LONG
def test_force_and_pressures_of_a_hyperelastic_block():
    _, off = best(
        lambda values: pressed(values, HyperelasticSolid, friction=0.2), WAVE, 1.0, 0.5, borne
    )
    assert off.max() < 1e-7, off


@LONG
def test_a_block_in_space_on_a_saddle():
    def build(values):
        mesh = box((2, 2, 2), (0.4, 0.4, 0.2))
        numbers = constants(mesh, values)
        height, a, b = numbers
        saddle = LevelSet(lambda x, t: 2 * (x[2] - height - a * x[0] ** 2 + b * x[1] ** 2), 3)
        block = ElasticSolid(
            mesh,
            youngs_modulus=1e6,
            poisson_ratio=0.3,
            density=1000.0,
            prescribed={"top": lambda t: (1e-3 * t, 5e-4 * t, -6e-3 * t)},
        )
        contact = Contact(block, "base", saddle, "gap", 0.3, name="die")
        return Scene([block], [contact], QuasiStatic(), geometry="newton", deepest=1.0), numbers

    _, off = best(build, np.array([-2e-3, 0.03, 0.02]), 1.0, 1.0, borne)
    assert off.max() < 1e-7, off


def test_by_the_height_of_a_flat_die():
    """A block under uniaxial strain: dp/dh = E (1 - nu)/((1 + nu)(1 - 2 nu) H)."""
    E, nu, H = 1e6, 0.3, 0.2
    mesh = rectangle((4, 2), (0.4, H))
    (height,) = constants(mesh, [0.0])
    sides = {"left": (0.0, None), "right": (0.0, None), "top": lambda t: (None, -1e-3 * t)}
    block = ElasticSolid(mesh, youngs_modulus=E, poisson_ratio=nu, density=1.0, prescribed=sides)
    contact = Contact(block, "base", LevelSet(lambda x, t: x[1] - height, 2), "gap", name="die")
    scene = Scene([block], [contact], QuasiStatic())
    result = tangents(scene, 1.0, 1.0, {"h": Shape(contact, height)}, borne(scene))
    exact = E * (1 - nu) / ((1 + nu) * (1 - 2 * nu) * H)
    for i in range(5):
        assert result[f"pressure {i}"][-1, 0] == pytest.approx(exact, rel=1e-12)
    assert result["force y"][-1, 0] == pytest.approx(0.4 * exact, rel=1e-12)


# -- in motion --


def bowl(values, formulation="velocity", theta=0.5, **scene):
    """A rigid block that slides in a bowl that is no circle."""
    mesh = rectangle(size=(0.2, 0.1))
    numbers = constants(mesh, values)
    height, a, b = numbers
    shape = LevelSet(lambda x, t: x[1] - height - a * x[0] ** 2 - b * x[0] ** 3, 2)
    block = RigidSolid(mesh, mass=2.0, gravity=(0, -G), velocity=(0.6, 0), spin=0.6)
    contact = Contact(block, "base", shape, formulation, friction=0.2, name="bowl")
    settings = {"deepest": 1.0, "geometry": "newton", **scene}
    return Scene([block], [contact], ThetaScheme(theta), **settings), numbers


def centre(scene):
    solid = scene.solids[0]
    return {
        "x": Centre(solid, (1, 0)),
        "y": Centre(solid, (0, 1)),
        "vx": Centre(solid, (1, 0), "velocity"),
    }


@pytest.mark.second
@pytest.mark.parametrize(
    ("formulation", "theta"), [("velocity", 0.5), pytest.param("gap", 1.0, marks=LONG)]
)
def test_a_rigid_block_in_a_bowl(formulation, theta):
    """Distances that are none between the points, gaps that are kept, normals that turn."""
    values = np.array([-0.006, 0.5, 0.3])  # m, 1/m, 1/m²

    def build(values):
        return bowl(values, formulation, theta)

    _, off = best(build, values, 0.15, 5e-3, centre, (1e-4, 1e-5))
    assert off.max() < 1e-6, off


@pytest.mark.second
def test_a_block_dropped_in_a_bowl():
    """By located impacts, whose instants depend on the shape."""
    values = np.array([-0.03, 0.5, 0.3])

    def build(values):
        return bowl(values, locate_impacts=True)

    result, off = best(build, values, 0.13, 1e-2, centre, (1e-4, 1e-5))
    assert off.max() < 1e-6, off
    first = np.flatnonzero(result.history["dt"] == 0)[1]
    assert result["time"][first, 0] < 0  # a higher bowl is met earlier


def round_bowl(obstacle, x0=None):
    """A rigid block in it, and its tangents by its speed, a shift of the bowl, and by ``x0``."""
    block = RigidSolid(
        rectangle(size=(0.2, 0.1)), mass=2.0, gravity=(0, -G), velocity=(0.6, 0), spin=0.6
    )
    contact = Contact(block, "base", obstacle, friction=0.2, name="c")
    scene = Scene([block], [contact], deepest=1.0, geometry="newton")
    by = {"v": Start(block, velocity=(1, 0)), "shift": ObstacleShift(contact, (1, 0))}
    by |= {"x0": Shape(contact, x0)} if x0 is not None else {}
    result = tangents(scene, 0.1, 5e-3, by, centre(scene))
    return np.array([result[name][-1] for name in centre(scene)])


def test_a_circle_in_ufl_is_a_circle():
    """A shift of the ready-made one, and of the centre that stands in phi: the same tangents."""
    y0 = float(np.sqrt(0.99))
    (x0,) = constants(rectangle(), [1e-3])
    level = LevelSet(lambda x, t: 1.0 - ufl.sqrt((x[0] - x0) ** 2 + (x[1] - y0) ** 2), 2)
    ready = round_bowl(Circle((1e-3, y0), 1.0, inside=True))
    written = round_bowl(level, x0)
    np.testing.assert_allclose(written[:, :2], ready, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(written[:, 2], ready[:, 1], rtol=1e-9, atol=1e-12)


class Bump:
    """A parabola in numpy, whose distances are none but at its surface."""

    dim = 2

    def __init__(self, x0=0.0):
        self.x0 = x0

    def _up(self, points):
        """The gradient of y - (x - x0)²/2, and its length."""
        up = np.stack([self.x0 - points[:, 0], np.ones(len(points))], axis=1)
        return up, np.linalg.norm(up, axis=1)

    def distance(self, points):
        return (points[:, 1] - 0.5 * (points[:, 0] - self.x0) ** 2) / self._up(points)[1]

    def normals(self, points):
        up, size = self._up(points)
        return up / size[:, None]

    def slopes(self, points):
        up, size = self._up(points)
        return (up - (self.distance(points) * up[:, 0] / size * [[-1.0], [0.0]]).T) / size[:, None]

    def curvature(self, points):
        n, size = self.normals(points), self._up(points)[1]
        bend = np.zeros((len(points), 2, 2))
        bend[:, :, 0] = -(np.array([1.0, 0.0]) - n[:, :1] * n) / size[:, None]
        return bend


@pytest.mark.parametrize(
    ("formulation", "theta", "located"),
    [("velocity", 0.5, False), ("velocity", 0.5, True), ("gap", 1.0, False)],
)
def test_an_own_obstacle_has_derivatives(formulation, theta, located):
    """Those of the same in UFL, and central differences by the start and by a shift."""

    def build(obstacle, speed=0.6):
        block = RigidSolid(
            rectangle(size=(0.2, 0.1)), mass=2.0, gravity=(0, -G), velocity=(speed, 0), spin=0.6
        )
        block.restore({**block.state(), "place": np.add(block.place, (0, 0.02))})
        contact = Contact(block, "base", obstacle, formulation, friction=0.2, name="c")
        scheme = ThetaScheme(theta)
        return Scene([block], [contact], scheme, deepest=1.0, locate_impacts=located)

    def of(obstacle):
        scene = build(obstacle)
        v = Start(scene.solids[0], velocity=(1, 0))
        by = {"v": v, "shift": ObstacleShift(scene.contacts[0], (1, 0))}
        result = tangents(scene, 0.1, 5e-3, by, centre(scene))
        assert result.history.finished and not result.kinks
        return np.array([result[name][-1] for name in centre(scene)])

    def end(scene):
        assert scene.run(0.1, 5e-3).finished
        solid = scene.solids[0]
        return np.array([*solid.place, solid.velocity[0]])

    mine, h = of(Bump()), 1e-5
    ufls = of(LevelSet(lambda x, t: x[1] - 0.5 * x[0] ** 2, 2))
    np.testing.assert_allclose(mine, ufls, rtol=1e-8, atol=1e-10)
    differences = [
        (end(build(Bump(), 0.6 + h)) - end(build(Bump(), 0.6 - h))) / (2 * h),
        (end(build(Bump(h))) - end(build(Bump(-h)))) / (2 * h),
    ]
    np.testing.assert_allclose(mine.T, differences, rtol=1e-5, atol=1e-6)


# -- adjoints --


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_adjoints_of_forces_and_pressures(friction):
    """To round-off those of tangents; points that are open in the end among them."""

    def made():
        scene, numbers = pressed(WAVE, friction=friction)
        contact = scene.contacts[0]
        return scene, {f"c{i}": Shape(contact, number) for i, number in enumerate(numbers)}

    scene, by = made()
    forward = tangents(scene, 0.8, 0.2, by, borne(scene))
    scene, by = made()
    asked = borne(scene)
    back = adjoints(scene, 0.8, 0.2, by, asked)
    size = max(np.abs(forward[name][-1]).max() for name in asked)
    for name in asked:
        np.testing.assert_allclose(back.one_sided(name), forward[name][-1], atol=1e-10 * size)
        assert back.values[name] == pytest.approx(forward.history[name][-1], rel=1e-10, abs=1e-6)


# -- where there is none, and what is refused --


def test_a_point_that_touches_and_bears_nothing_is_named():
    """A flat die that is just met: pushed up it bears, lowered it does not."""
    mesh = rectangle((2, 2), (0.4, 0.2))
    (height,) = constants(mesh, [0.0])
    block = ElasticSolid(
        mesh, youngs_modulus=1e6, poisson_ratio=0.3, density=1.0, prescribed={"top": (0.0, 0.0)}
    )
    die = LevelSet(lambda x, t: x[1] - height, 2)
    contact = Contact(block, "base", die, "gap", name="die")
    scene = Scene([block], [contact], QuasiStatic())
    result = tangents(scene, 1.0, 1.0, {"h": Shape(contact, height)}, borne(scene))
    assert {kink.place for kink in result.kinks} == {(-0.2, 0.0), (0.0, 0.0), (0.2, 0.0)}
    with pytest.raises(NoDerivative, match=r"contact 'die', point .*: .*, on the edge of"):
        result["force y"]
    assert np.isfinite(result.one_sided("force y")).all()


def test_what_is_refused():
    scene, (height, *_) = pressed(WAVE)
    contact = scene.contacts[0]
    stranger = fem.Constant(rectangle().mesh, 1.0)
    with pytest.raises(InputError, match=r"number = .* must be a fem.Constant in the obstacle"):
        Shape(contact, stranger)
    with pytest.raises(InputError, match=r"number = 0\.3: must be a fem\.Constant"):
        Shape(contact, 0.3)
    plane = Contact(contact.solid, "base", FLOOR, name="plane")
    with pytest.raises(InputError, match=r"obstacle = .*LevelSet before contact 'plane'"):
        Shape(plane, height)
    other = pressed(WAVE)[0].contacts[0]
    with pytest.raises(InputError, match="Shape: 'die' is not in the scene"):
        tangents(scene, 1.0, 1.0, {"h": Shape(other, other.coupling.obstacle.numbers[0])})
    by = {"h": Shape(contact, height)}
    with pytest.raises(InputError, match=r"quantities\['p'\]: 'plane' is not in the scene"):
        tangents(scene, 1.0, 1.0, by, {"p": Force(plane, (0, 1))})
    with pytest.raises(InputError, match=r"point = \[0.01, 0.0\]: is no node of contact 'die'"):
        Pressure(contact, [0.01, 0.0])
    with pytest.raises(InputError, match=r"point = .* 2"):
        Pressure(contact, [0.01, 0.0, 0.0])
    with pytest.raises(InputError, match="direction"):
        Force(contact, (0, 1, 0))
    block = RigidSolid(rectangle(), mass=1.0, name="rigid")
    with pytest.raises(InputError, match="'rigid' is not deformable"):
        Pressure(Contact(block, "base", FLOOR), (-0.18, 0.0))
    pair = fem.Constant(rectangle(comm=MPI.COMM_SELF).mesh, (1.0, 2.0))
    with pytest.raises(InputError, match=r"Constant of shape \(2,\)"):
        LevelSet(lambda x, t: x[1] - pair[0], 2)
