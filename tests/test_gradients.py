# SPDX-License-Identifier: LGPL-3.0-or-later
"""Derivatives of runs: tangents against formulas and against plateaus of central differences,
adjoints against tangents, and where there are no derivatives."""

from __future__ import annotations

from math import atan, cos, sin

import numpy as np
import pytest
import ufl
from dolfinx import fem
from scenes import FLOOR, FLOOR_3D, G, box, rectangle, rocking_block

from fenicsx_contact import (
    Circle,
    Contact,
    ElasticSolid,
    GeneralisedAlpha,
    HalfSpace,
    HyperelasticSolid,
    InputError,
    Moved,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    Tresca,
    neo_hookean,
)
from fenicsx_contact.gradients import (
    At,
    Centre,
    Force,
    Gravity,
    Kinetic,
    Law,
    Mass,
    Material,
    Modulus,
    NoDerivative,
    ObstacleShift,
    Start,
    Turn,
    adjoints,
    tangents,
)
from fenicsx_contact.gradients.recording import ROOM
from fenicsx_contact.rods import RodInTube

LONG = pytest.mark.long


def solid_of(scene):
    return scene.solids[0]


def friction(scene):
    return Law(scene.contacts[0])


def weight(scene):
    return Gravity(solid_of(scene), (0, -1))


def centre(scene):
    """Place, velocity and energy."""
    solid = solid_of(scene)
    return {
        "x": Centre(solid, (1, 0)),
        "y": Centre(solid, (0, 1)),
        "vx": Centre(solid, (1, 0), "velocity"),
        "energy": Kinetic(solid),
    }


def check(build, parameters, until, dt, quantities=centre, shares=(1e-4, 1e-5)):
    """Tangents against central differences by the parameters ``{name: (value, Parameter)}``.

    Of differences of several steps the best counts: their truncation grows with the step, their
    round-off falls. Derivatives are compared with the largest of their quantity by all parameters,
    each parameter times its value."""
    values = {name: value for name, (value, _) in parameters.items()}
    scene = build(**values)
    asked = {name: of(scene) for name, (_, of) in parameters.items()}
    result = tangents(scene, until, dt, asked, quantities(scene))
    assert result.history.finished, result.history.reason
    assert not result.kinks, result.kinks[0]

    def ends(**changed):
        scene = build(**{**values, **changed})
        assert scene.run(until, dt).finished
        return {name: quantity.value() for name, quantity in quantities(scene).items()}

    errors = {}
    for i, (name, value) in enumerate(values.items()):
        for share in shares:
            h = share * value
            high, low = ends(**{name: value + h}), ends(**{name: value - h})
            for q in high:
                every = np.abs(result[q][-1] * list(values.values())).max()
                off = abs((high[q] - low[q]) / (2 * h) - result[q][-1, i]) * value
                if every > 1e-12:
                    key = name, q
                    errors[key] = min(errors.get(key, np.inf), off / every)
    assert errors and max(errors.values()) < 1e-6, errors
    return result


# -- formulas --


def launched(mu=0.3, speed=2.0, mass=1.0, steps=100, **scene):
    """A block launched on a floor, and a step with which it stops near the midst of one."""
    block = RigidSolid(rectangle(size=(1.0, 0.2)), mass=mass, gravity=(0, -G), velocity=(speed, 0))
    contact = Contact(block, "base", FLOOR, friction=mu, name="c")
    stop = speed / (mu * G)
    return Scene([block], [contact], **scene), stop, stop / np.sqrt(steps * (steps + 1))


def test_a_launched_block():
    """d(distance)/dmu = -v²/(2 mu² g), and by all else. The distance of n steps and the one in
    which the block stops is dt v (n + 1/2) - mu g dt² n (n + 1)/2: by mu it is exact where
    n (n + 1) dt² is the square of the time to stop."""
    scene, stop, dt = launched()
    block, mu, v = solid_of(scene), 0.3, 2.0
    asked = {
        "mu": friction(scene),
        "v": Start(block, velocity=(1, 0)),
        "g": weight(scene),
        "m": Mass(block),
    }
    result = tangents(scene, 1.2 * stop, dt, asked, centre(scene))
    by_mu, by_v, by_g, by_m = result["x"][-1]
    assert by_mu == pytest.approx(-(v**2) / (2 * mu**2 * G), rel=1e-12)
    assert by_g == pytest.approx(-(v**2) / (2 * mu * G**2), rel=1e-12)
    assert by_v == pytest.approx(100.5 * dt, rel=1e-12)
    assert by_v == pytest.approx(v / (mu * G), rel=2e-5)  # of second order in dt
    assert abs(by_m) < 1e-12
    np.testing.assert_allclose(result["vx"][-1], 0.0, atol=1e-12)
    # while it slides: k = m (v - mu g t)²/2, friction -mu m g
    t, speed = result.history.time[30], v - mu * G * result.history.time[30]
    exact = [-G * t * speed, speed, -mu * t * speed, speed**2 / 2]
    np.testing.assert_allclose(result["energy"][30], exact, rtol=1e-11)
    np.testing.assert_allclose(result["c.force_x"][30], [-G, 0, -mu, -mu * G], atol=1e-9)
    np.testing.assert_allclose(result["c.force_y"][-1], [0, 0, 1, G], atol=1e-9)


def test_a_block_that_stops_on_a_slope():
    """By the friction, and by the angle at which gravity acts: v²/(2 a), a = g (mu cos - sin)."""
    mu, angle, v, steps = 0.6, 0.3, 1.0, 80
    a = G * (mu * cos(angle) - sin(angle))
    gravity = (G * sin(angle), -G * cos(angle))
    block = RigidSolid(rectangle(size=(1.0, 0.2)), mass=3.0, gravity=gravity, velocity=(v, 0))
    scene = Scene([block], [Contact(block, "base", FLOOR, friction=mu)])
    asked = {"mu": friction(scene), "angle": Gravity(block, (G * cos(angle), G * sin(angle)))}
    dt = v / a / np.sqrt(steps * (steps + 1))
    by = tangents(scene, 1.1 * v / a, dt, asked, centre(scene))["x"][-1]
    by_a = -(v**2) / (2 * a**2)
    exact = [by_a * G * cos(angle), -by_a * G * (mu * sin(angle) + cos(angle))]
    np.testing.assert_allclose(by, exact, rtol=1e-11)


def up_the_slope(scene):
    return Start(solid_of(scene), velocity=lambda x: np.stack([-1 + 0 * x[0], 0 * x[0]]))


@pytest.mark.parametrize("kind", ["velocity", "gap"])
def test_slip_that_turns_round(kind):
    """An elastic block thrown up a slope in long steps: friction that would push is let go."""

    def build(mu=2.0, speed=0.5, E=1e6):
        solid = ElasticSolid(
            rectangle((3, 2), (1.0, 0.7)),
            youngs_modulus=E,
            poisson_ratio=0.3,
            density=1000.0,
            gravity=(0.5 * G, -0.8 * G),
            velocity=lambda x: np.stack([-speed + 0.1 * x[1], 0 * x[0]]),
        )
        contact = Contact(solid, "base", FLOOR, kind, friction=mu, name="c")
        return Scene([solid], [contact])

    parameters = {
        "mu": (2.0, friction),
        "E": (1e6, lambda scene: Modulus(solid_of(scene))),
        "speed": (0.5, up_the_slope),
    }
    result = check(build, parameters, 0.24, 0.02)
    assert result.history["c.slipping"].max() > 0


class Own:
    """A friction bound without a number that has a name."""

    def bound(self, k, pressure, S):
        return 0.3 * pressure

    def describe(self):
        return "own"


def bar(speed=0.4, E=900.0, gap=0.0, cells=20, formulation="velocity", theta=0.5, **scene):
    """A bar of unit length thrown at a wall."""
    solid = ElasticSolid(
        rectangle((1, cells), (0.05, 1.0)),
        youngs_modulus=E,
        poisson_ratio=0.0,
        density=1.0,
        velocity=lambda x: np.stack([0 * x[0], -speed + 0 * x[1]]),
    )
    wall = HalfSpace((0, -gap), (0, 1))
    contact = Contact(solid, "base", wall, formulation, name="wall")
    return Scene([solid], [contact], ThetaScheme(theta), allow_free=True, **scene)


def downwards(scene):
    return Start(solid_of(scene), velocity=lambda x: np.stack([0 * x[0], -1 + 0 * x[1]]))


def test_a_bar_at_a_wall():
    """All is proportional to the speed; the mean reaction is A sqrt(E rho) v, which by E is half as
    much over E."""
    scene, speed = bar(), 0.4
    asked = {"v": downwards(scene), "E": Modulus(solid_of(scene))}
    result = tangents(scene, 0.06, 1 / 30 / 20, asked, centre(scene))
    history = result.history
    force = history["wall.force_y"]
    np.testing.assert_allclose(result["wall.force_y"][:, 0], force / speed, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(result["energy"][:, 0], 2 * history["kinetic"] / speed, rtol=1e-9)
    span = history.span[:, None]
    reach = 0.05  # s, before the wave is back
    impulse = (result["wall.force_y"] * span)[history.time <= reach].sum(axis=0)
    exact = 0.05 * np.sqrt(900.0) * speed * reach
    assert impulse[0] * speed == pytest.approx(exact, rel=0.05)
    assert impulse[1] * 2 * 900 == pytest.approx(exact, rel=0.05)


# -- plateaus of central differences --


def test_a_rocking_block_with_located_impacts():
    """Through several impacts, whose instants depend on everything."""

    def build(tilt, g):
        block = RigidSolid(
            rectangle(), mass=417.6, gravity=(0, -g), rotation=tilt, about=(-0.18, 0)
        )
        contact = Contact(block, "base", FLOOR, friction=0.9, name="c")
        return Scene([block], [contact], locate_impacts=True, geometry="newton")

    def turn(scene):
        return {**centre(scene), "turn": Turn(solid_of(scene))}

    asked = {"tilt": (0.01, lambda s: Start(solid_of(s), turn=1, about=(-0.18, 0))),
             "g": (G, weight)}  # fmt: skip
    result = check(build, asked, 0.2, 2e-3, turn)
    times = result["time"][result.history["dt"] == 0]
    assert len(times) >= 4 and (times[1:, 0] > 0).all() and (times[1:, 1] < 0).all()


def test_a_block_dropped_on_a_slope():
    """Height and place of the floor, tilt, speed, mass: it strikes, slips and turns."""

    def build(height, tilt, speed, mass):
        block = RigidSolid(
            rectangle(size=(0.2, 0.3)),
            mass=mass,
            gravity=(0, -G),
            rotation=tilt,
            velocity=(speed, 0),
        )
        floor = HalfSpace((0, -height), (0.1, 1))
        contact = Contact(block, "base", floor, friction=0.3, name="c")
        return Scene([block], [contact], locate_impacts=True, geometry="newton")

    asked = {
        "height": (0.05, lambda s: ObstacleShift(s.contacts[0], (0, -1))),
        "tilt": (0.1, lambda s: Start(solid_of(s), turn=1)),
        "speed": (0.3, lambda s: Start(solid_of(s), velocity=(1, 0))),
        "mass": (3.0, lambda s: Mass(solid_of(s))),
    }
    result = check(build, asked, 0.16, 1e-2)
    first = np.flatnonzero(result.history["dt"] == 0)[1]  # after the start
    fall = result.history.time[first]
    # the corner falls until it meets the slope: dt/dh = 1/(g t - 0.1 speed)
    assert result["time"][first, 0] == pytest.approx(1 / (G * fall - 0.1 * 0.3), rel=1e-9)


def round_bowl(speed, mu, x, formulation="velocity", theta=0.5):
    block = RigidSolid(
        rectangle(size=(0.2, 0.1)), mass=2.0, gravity=(0, -G), velocity=(speed, 0), spin=speed
    )
    bowl = Circle((x, np.sqrt(0.99)), 1.0, inside=True)
    contact = Contact(block, "base", bowl, formulation, friction=mu, name="c")
    return Scene([block], [contact], ThetaScheme(theta), deepest=1.0, geometry="newton")


@pytest.mark.parametrize(
    ("formulation", "theta"), [("velocity", 0.5), pytest.param("gap", 1.0, marks=LONG)]
)
def test_a_block_that_slides_in_a_round_bowl(formulation, theta):
    """Normals that turn, gaps that are kept, an obstacle that is shifted."""

    def build(speed, mu, x):
        return round_bowl(speed, mu, x, formulation, theta)

    asked = {
        "speed": (0.6, lambda s: Start(solid_of(s), velocity=(1, 0), spin=1)),
        "mu": (0.2, friction),
        "x": (1e-3, lambda s: ObstacleShift(s.contacts[0], (1, 0))),
    }
    check(build, asked, 0.15, 5e-3)


@LONG
def test_a_rigid_block_on_a_spring():
    def build(mass, speed, mu):
        block = RigidSolid(
            rectangle(size=(0.2, 0.1)),
            mass=mass,
            gravity=(0, -G),
            velocity=(speed, 0),
            springs={(0.1, 0.1): (100.0, 20.0)},
        )
        return Scene([block], [Contact(block, "base", FLOOR, friction=mu, name="c")])

    asked = {
        "mass": (2.0, lambda s: Mass(solid_of(s))),
        "speed": (1.0, lambda s: Start(solid_of(s), velocity=(1, 0))),
        "mu": (0.1, friction),
    }
    check(build, asked, 0.5, 5e-3)


def thrown(kind, mu, E=1e6, nu=0.3, g=G, speed=0.5, formulation="velocity", theta=0.5, **scene):
    """A soft block thrown obliquely on a floor: it strikes, slips, sticks."""
    material = {"youngs_modulus": E, "poisson_ratio": nu}
    if kind is HyperelasticSolid:
        material = {"energy": neo_hookean(E, nu)}
    block = kind(
        rectangle((4, 4), (0.4, 0.4)),
        density=1000.0,
        gravity=(0, -g),
        displacement=lambda x: np.stack([-0.02 * x[1], 0.02 * x[0] + 0.006]),
        velocity=lambda x: np.stack([speed + 0 * x[0], -1.0 - 0.2 * x[0]]),
        **material,
    )
    contact = Contact(block, "base", FLOOR, formulation, friction=mu, name="c")
    return Scene([block], [contact], ThetaScheme(theta), **scene)


def sideways(scene):
    return Start(solid_of(scene), velocity=lambda x: np.stack([1 + 0 * x[0], 0 * x[0]]))


ELASTIC = {
    "E": (1e6, lambda s: Modulus(solid_of(s))),
    "nu": (0.3, lambda s: Modulus(solid_of(s), "poisson_ratio")),
    "mu": (0.3, friction),
    "g": (G, weight),
    "speed": (0.5, sideways),
}


@pytest.mark.parametrize(
    ("formulation", "theta", "scene"),
    [
        pytest.param("velocity", 0.5, {}, marks=LONG),
        pytest.param("gap", 1.0, {}, marks=LONG),
        pytest.param("velocity", 0.5, {"locate_impacts": True}, marks=pytest.mark.second),
    ],
)
def test_a_thrown_elastic_block(formulation, theta, scene):
    def build(**values):
        return thrown(ElasticSolid, formulation=formulation, theta=theta, **values, **scene)

    check(build, ELASTIC, 0.01 if scene else 0.02, 5e-4)


def test_a_thrown_hyperelastic_block():
    def build(**values):
        return thrown(HyperelasticSolid, **values)

    def modulus(scene):
        return Material(solid_of(scene), lambda E: neo_hookean(E, 0.3), 1e6)

    asked = {"E": (1e6, modulus), "mu": ELASTIC["mu"]}
    check(build, asked, 0.01, 5e-4, shares=[1e-4])


def oscillator(mu=0.1, k=1e4, press=20 / 3):
    """The friction oscillator of Code_Aster's SDND100: m = 1 kg, released at 0.85 mm."""
    solid = HyperelasticSolid(
        rectangle(size=(1.0, 1.0)),
        energy=lambda F: k / 2 * F[0, 1] ** 2,
        density=3.0,
        gravity=(0.0, -press),
        fixed=["top"],
        displacement=lambda x: np.stack([0.85e-3 * (1 - x[1]), 0 * x[1]]),
    )
    return Scene([solid], [Contact(solid, "base", FLOOR, friction=mu, name="c")])


def foot(scene):
    return {"x": At(solid_of(scene), (-0.5, 0.0), (1, 0))}


def test_a_friction_oscillator():
    """It turns at x0 - 2 n mu N/k: exact to first order by mu after each half period; then it
    sticks, and the derivative stays."""
    steps, N = 20, 10.0
    half = np.pi / 100
    asked = {
        "mu": (0.1, friction),
        "k": (1e4, lambda s: Material(solid_of(s), lambda k: lambda F: k / 2 * F[0, 1] ** 2, 1e4)),
        "press": (20 / 3, weight),
    }
    result = check(oscillator, asked, 4.4 * half, half / steps, foot, shares=[1e-4])
    x, by_mu = result.history["x"], result["x"][:, 0]
    for n, turn in ((1, np.argmin), (2, np.argmax)):
        swing = slice(int((n - 0.5) * steps), int((n + 0.5) * steps))
        at = swing.start + turn(x[swing])
        assert by_mu[at] == pytest.approx((-1) ** (n + 1) * 2 * n * N / 1e4, rel=0.01)
    assert by_mu[-3:] == pytest.approx(by_mu[-1], rel=1e-9)


def test_statics_and_tresca():
    """A block that is pressed and drawn without inertia, under a bound of its own."""

    def build(stress, E):
        block = ElasticSolid(
            rectangle((4, 2), (0.4, 0.2)),
            youngs_modulus=E,
            poisson_ratio=0.3,
            density=1000.0,
            prescribed={"top": lambda t: (1e-3 * t, -1e-3)},
        )
        contact = Contact(block, "base", FLOOR, "gap", Tresca(stress), name="c")
        return Scene([block], [contact], QuasiStatic())

    def inside(scene):
        return {"x": At(solid_of(scene), (0.1, 0.1), (1, 0)), "y": Centre(solid_of(scene), (0, 1))}

    asked = {
        "stress": (1.5e3, lambda s: Law(s.contacts[0], "stress")),
        "E": (1e6, lambda s: Modulus(solid_of(s))),
    }
    check(build, asked, 3.0, 1.0, inside)


def test_constants_that_stand_in_ufl():
    """Of a friction and a modulus that vary over the block."""

    def build(mu, E):
        mesh = rectangle((3, 3), (0.4, 0.4))
        x = ufl.SpatialCoordinate(mesh.mesh)
        build.mu, build.E = (fem.Constant(mesh.mesh, each) for each in (mu, E))
        block = ElasticSolid(
            mesh,
            youngs_modulus=build.E * (1 + x[1]),
            poisson_ratio=0.3,
            density=1000.0,
            gravity=(0, -G),
            displacement=lambda x: np.stack([0 * x[0], 0.002 + 0.01 * x[0]]),
            velocity=lambda x: np.stack([0.5 + 0 * x[0], -1.0 + 0 * x[0]]),
        )
        friction = build.mu * (1 + x[0])
        return Scene([block], [Contact(block, "base", FLOOR, friction=friction, name="c")])

    asked = {
        "mu": (0.3, lambda s: Law(s.contacts[0], build.mu)),
        "E": (1e6, lambda s: Modulus(solid_of(s), build.E)),
    }
    check(build, asked, 0.01, 5e-4, shares=[1e-4])


@pytest.mark.parametrize("E, nu", [(1.0, lambda n: n), (lambda n: 1 + n, lambda n: 1 * n)])
def test_a_constant_that_is_a_modulus(E, nu):
    """Alone it was no part of any: its derivative lacked it, or was refused."""

    def build(n):
        mesh = rectangle((3, 3), (0.4, 0.4))
        build.n = fem.Constant(mesh.mesh, n)
        moduli = {
            "youngs_modulus": 1e6 * (E(build.n) if callable(E) else E),
            "poisson_ratio": nu(build.n),
        }
        block = ElasticSolid(mesh, density=700.0, gravity=(0, -G), fixed=["base"], **moduli)
        return Scene([block], [])

    def top(scene):
        return {"y": At(solid_of(scene), (0.2, 0.4), (0, 1))}

    asked = {"n": (0.25, lambda s: Modulus(solid_of(s), build.n))}
    check(build, asked, 0.02, 1e-3, top, shares=[1e-4])


def test_moduli_are_those_of_when_the_solid_was_made():
    """A Constant that has become another since made a derivative that of no solid."""

    def derivatives(of, now):
        mesh = rectangle((3, 3), (0.4, 0.4))
        n, x = fem.Constant(mesh.mesh, of), ufl.SpatialCoordinate(mesh.mesh)
        moduli = {"youngs_modulus": 1e6 * n * n * (1 + x[1]), "poisson_ratio": n / 4}
        block = ElasticSolid(mesh, density=700.0, gravity=(0, -G), fixed=["base"], **moduli)
        scene, y = Scene([block], []), {"y": Centre(block, (0, 1))}
        n.value = now
        return tangents(scene, 0.02, 1e-3, {"n": Modulus(block, n)}, y)["y"]

    np.testing.assert_array_equal(derivatives(1.0, 1.9), derivatives(1.0, 1.0))


KINDS = {
    "second degree": {"degree": 2},
    "plane stress": {"plane": "stress"},
    "springs": {"springs": {"top": (1e4, 2e4)}},
    "driven": {
        "prescribed": {"top": lambda t: (0.2 * t, -0.2 * t)},
        "displacement": None,
        "velocity": None,
    },
    "revolution": {"plane": "axisymmetric"},
}


@LONG
@pytest.mark.parametrize("kind", KINDS)
def test_kinds_of_elastic_solids(kind):
    """What is held and touches, too: on the axis of a solid of revolution."""

    def build(mu, E):
        mesh = rectangle((3, 3), (0.4, 0.4))
        mesh.mesh.geometry.x[:, 0] += 0.2  # the axis of revolution is x = 0
        given = {
            "displacement": lambda x: np.stack([0 * x[0], 0.002 + 0.01 * x[0]]),
            "velocity": lambda x: np.stack([x[0], -1.0 + 0 * x[0]]),
            **KINDS[kind],
        }
        moduli = {"youngs_modulus": E, "poisson_ratio": 0.3, "density": 1000.0}
        block = ElasticSolid(mesh, gravity=(0, -G), **moduli, **given)
        return Scene([block], [Contact(block, "base", FLOOR, friction=mu, name="c")])

    def corner(scene):
        solid = solid_of(scene)
        return {"x": At(solid, (0.4, 0.0), (1, 0)), "vy": Centre(solid, (0, 1), "velocity")}

    asked = {"mu": (0.3, friction), "E": (1e6, lambda s: Modulus(solid_of(s)))}
    check(build, asked, 0.01, 5e-4, corner)


@LONG
def test_a_block_in_space():
    def build(mu, E):
        block = ElasticSolid(
            box((2, 2, 2), (0.4, 0.4, 0.4)),
            youngs_modulus=E,
            poisson_ratio=0.3,
            density=1000.0,
            gravity=(0, 0, -G),
            displacement=lambda x: np.stack([0 * x[0], 0 * x[0], 0.02 * x[0] + 0.005]),
            velocity=lambda x: np.stack([0.5 + 0 * x[0], 0.2 + 0 * x[0], -1.0 + 0 * x[0]]),
        )
        return Scene([block], [Contact(block, "base", FLOOR_3D, friction=mu, name="c")])

    def spatial(scene):
        axes = zip("xyz", np.eye(3))
        return {name: Centre(solid_of(scene), axis, "velocity") for name, axis in axes}

    asked = {"mu": (0.3, friction), "E": (1e6, lambda s: Modulus(solid_of(s)))}
    check(build, asked, 0.02, 1e-3, spatial)


# -- adjoints --


@pytest.mark.parametrize(
    "every, room",
    [(None, ROOM), (7, 0), (7, 2e5), pytest.param(1000, 0, marks=LONG)],
)
def test_adjoints_are_tangents(every, room):
    """To round-off, whatever is kept on the way, linearised steps or states from which they are run
    once more; the scene is left where the run ends."""

    def made():
        scene = thrown(ElasticSolid, mu=0.3)
        return scene, {name: of(scene) for name, (_, of) in ELASTIC.items()}

    scene, asked = made()
    forward = tangents(scene, 0.02, 5e-4, asked, centre(scene))
    scene, asked = made()
    steps = []
    scene.stepper.watchers.append(lambda trial: steps.append(trial.step.dt))
    back = adjoints(scene, 0.02, 5e-4, asked, centre(scene), every=every, room=room)
    once = len(back.history) - 1
    assert len(steps) == 2 * once if not room else once <= len(steps) < 2 * once
    assert (len(steps) == once) == (room == ROOM)
    assert back.kept == {None: 6, 7: 6, 1000: 1}[every]
    for name in ("x", "y", "vx", "energy"):
        np.testing.assert_allclose(back.one_sided(name), forward[name][-1], rtol=1e-10)
        assert back.values[name] == pytest.approx(forward.history[name][-1], rel=1e-12)
        assert centre(scene)[name].value() == pytest.approx(back.values[name], rel=1e-12)
    assert scene.time == pytest.approx(0.02)
    np.testing.assert_allclose(back.history.time, forward.history.time, atol=1e-15)


def test_adjoints_through_located_impacts():
    def made():
        scene = rocking_block(locate_impacts=True)
        block = solid_of(scene)
        return scene, {"tilt": Start(block, turn=1, about=(-0.18, 0)), "g": weight(scene)}

    scene, asked = made()
    forward = tangents(scene, 0.2, 2e-3, asked, centre(scene))
    scene, asked = made()
    back = adjoints(scene, 0.2, 2e-3, asked, centre(scene))
    for name in ("x", "y", "vx", "energy"):
        np.testing.assert_allclose(back.one_sided(name), forward[name][-1], rtol=1e-10)


# -- where there is none --


def test_a_block_on_the_edge_of_sliding():
    """At the angle of friction the derivative does not exist, and the result says where."""
    angle = atan(0.5)
    for mu, there in ((0.5, False), (0.5 + 1e-6, True), (0.5 - 1e-6, True)):
        gravity = (G * sin(angle), -G * cos(angle))
        block = RigidSolid(rectangle(size=(1.0, 0.2)), mass=1.0, gravity=gravity)
        scene = Scene([block], [Contact(block, "base", FLOOR, friction=mu, name="floor")])
        result = tangents(scene, 0.1, 0.01, {"mu": friction(scene)}, centre(scene))
        one_sided = result.one_sided("x")[-1, 0]
        assert np.isfinite(one_sided)
        if there:
            expected = 0.0 if mu > 0.5 else -G * cos(angle) * 0.1**2 / 2
            assert result["x"][-1, 0] == pytest.approx(expected, rel=1e-9, abs=1e-15)
        else:
            assert result.kinks[0].contact == "floor" and result.kinks[0].time == 0.01
            with pytest.raises(NoDerivative, match=r"contact 'floor', point .* t = 0.01 s"):
                result["x"]


def test_corners_that_arrive_together():
    """Level, both corners arrive at once: by the height that has a derivative, by the tilt none."""

    def dropped():
        block = RigidSolid(rectangle(size=(0.4, 0.2)), mass=1.0, gravity=(0, -G))
        floor = HalfSpace((0, -0.05), (0, 1))
        contact = Contact(block, "base", floor, friction=0.3, name="c")
        return Scene([block], [contact], locate_impacts=True)

    scene = dropped()
    higher = {"height": ObstacleShift(scene.contacts[0], (0, -1))}
    result = tangents(scene, 0.15, 0.01, higher, centre(scene))
    assert result["y"][-1, 0] == pytest.approx(-1, rel=1e-9)
    scene = dropped()
    tilted = {"tilt": Start(solid_of(scene), turn=1.0)}
    result = tangents(scene, 0.15, 0.01, tilted, centre(scene))
    assert "at the same instant" in result.kinks[0].what
    assert np.isfinite(result.one_sided("y")).all()
    with pytest.raises(NoDerivative, match="contact 'c'"):
        result["y"]


@pytest.mark.parametrize("depth", [1e-13, -1e-13])
def test_a_block_that_just_touches_a_ceiling(depth):
    """Thrown up, it turns where the ceiling is: with a little more speed there is an impact."""
    steps, dt = 20, 0.01
    speed = G * steps * dt
    block = RigidSolid(
        rectangle(size=(0.4, 0.2)), mass=1.0, gravity=(0, -G), velocity=(0, speed), rotation=0.1
    )
    turned = np.array([[np.cos(0.1), -np.sin(0.1)], [np.sin(0.1), np.cos(0.1)]])
    corner = block.place + turned @ [0.2, 0.1]
    ceiling = HalfSpace((0, corner[1] + speed**2 / (2 * G) - depth), (0, -1))
    scene = Scene([block], [Contact(block, "top", ceiling, name="c")], locate_impacts=True)
    asked = {"speed": Start(block, velocity=(0, 1))}
    with pytest.raises(NoDerivative, match=r"contact 'c', point .*0\.2, 0\.2.*: .*and no more"):
        tangents(scene, 2 * steps * dt, dt, asked, centre(scene))["y"]


def test_a_block_that_comes_to_rest_by_impacts_without_end():
    """The last of them arrive without a speed that gaps tell; they were said to graze."""
    scene = rocking_block(locate_impacts=True, geometry="newton")
    asked = {"tilt": Start(solid_of(scene), turn=1.0, about=(-0.18, 0))}
    with pytest.raises(NoDerivative, match=r"t = 0\.37.* comes to rest by impacts without end"):
        tangents(scene, 0.4, 2e-3, asked, {"energy": Kinetic(solid_of(scene))})


# -- what is not supported --


def refused(scene, parameters=None, match=""):
    with pytest.raises(InputError, match=match):
        asked = parameters or {"v": Start(solid_of(scene), velocity=(1, 0))}
        tangents(scene, 0.1, 0.01, asked)


def on_floor(contact=None, scene=None, solid=None, obstacle=FLOOR):
    block = RigidSolid(rectangle(), mass=1.0, gravity=(0, -G), **(solid or {}))
    return Scene(
        [block], [Contact(block, "base", obstacle, **{"name": "c", **(contact or {})})],
        **(scene or {}),
    )  # fmt: skip


class Bench:
    """That tells no slopes."""

    dim = 2

    def distance(self, points):
        return points[:, 1]

    def normals(self, points):
        return np.broadcast_to((0.0, 1.0), points.shape)


def test_what_is_not_supported_is_refused_by_name():
    still = Moved(Bench(), lambda t: (0.0, 0.0))
    table = on_floor(
        {"friction": 0.2}, {"locate_impacts": True}, None, Moved(FLOOR, lambda t: (t, 0))
    )
    refused(on_floor(obstacle=Bench()), match="'c' has a Bench, .* slopes and curvature")
    refused(on_floor(obstacle=still), match="'c' has a Moved, whose distances are not")
    refused(table, match="contact 'c' has an obstacle that moves, in a scene with located impacts")
    refused(on_floor(scene={"scheme": GeneralisedAlpha(0.8)}), match="scheme")
    pushed = {"force": lambda t: (t, 0.0)}
    refused(on_floor(solid=pushed, scene={"locate_impacts": True}), match="forces in time")
    scene = bar()
    with pytest.raises(InputError, match="not in the scene"):
        tangents(scene, 0.1, 0.01, {"v": downwards(bar())})
    with pytest.raises(InputError, match="by what"):
        tangents(scene, 0.1, 0.01, {})
    with pytest.raises(InputError, match="must be a parameter"):
        tangents(scene, 0.1, 0.01, {"E": 900.0})
    with pytest.raises(InputError, match=r"'wall' has no law .* friction = 0 leaves"):
        Law(scene.contacts[0])  # it has none
    with pytest.raises(InputError, match="'own' has no law with a number that has a name"):
        Law(Contact(solid_of(scene), "base", HalfSpace((0, 0), (0, 1)), friction=Own(), name="own"))
    with pytest.raises(InputError, match="does not make the energy"):
        soft = thrown(HyperelasticSolid, mu=0.3)
        Material(solid_of(soft), lambda E: neo_hookean(E, 0.3), 2e6)
    # no energy: TypeErrors, or for ever
    for energy in (lambda E: None, lambda E: neo_hookean, lambda E: E):
        with pytest.raises(InputError, match=r"energy\(value\)"):
            Material(solid_of(soft), energy, 1e6)
    only = "RodInTube, is not supported; only deformable solids, beams and rigid solids"
    with pytest.raises(InputError, match=only):
        Start(RodInTube.__new__(RodInTube), velocity=(1, 0))
    with pytest.raises(InputError, match="Start: must be given a place, velocity, turn or spin"):
        Start(solid_of(scene))
    light = ElasticSolid(
        rectangle(), youngs_modulus=1e6, poisson_ratio=0.3, density=1.0, name="light",
        mass_redistribution=["base"],
    )  # fmt: skip
    scene = Scene([light], [Contact(light, "base", FLOOR, "gap")])
    refused(scene, {"g": weight(scene)}, "'light' has a boundary without mass")
    held = Scene([ElasticSolid(rectangle(), youngs_modulus=1e6, poisson_ratio=0.3, density=1.0,
                               fixed=["top"], name="held")], [])  # fmt: skip
    with pytest.raises(InputError, match="stands in no modulus"):
        Modulus(solid_of(held), fem.Constant(solid_of(held).mesh.mesh, 1.0))


def test_a_run_with_tangents_is_the_run():
    """Row by row, to the bit."""
    rows = []
    for watched in (False, True):
        scene = thrown(ElasticSolid, mu=0.3)
        if watched:
            history = tangents(scene, 0.01, 5e-4, {"mu": friction(scene)}).history
        else:
            history = scene.run(0.01, 5e-4)
        rows.append(history.rows())
    np.testing.assert_array_equal(*rows)


# -- without inertia, and what is asked --


def drawn(E=1e4, speed=0.0):
    mesh = rectangle((4, 2), (1.0, 0.5))
    block = ElasticSolid(
        mesh,
        youngs_modulus=E,
        poisson_ratio=0.3,
        density=100.0,
        velocity=(speed, 0.0),
        fixed=["base"],
        prescribed={"top": lambda t: (0.01 * np.sin(t), 0.0)},
    )
    return Scene([block], [], QuasiStatic())


@pytest.mark.parametrize("speed", [0.0, 10.0])
def test_without_inertia_nothing_has_kinetic_energy(speed):
    """It was half the velocity times the momentum at the start: negative, or 1 J; its derivative by
    the mass was that of v M v / 2."""
    scene = drawn(speed=speed)
    (block,) = scene.solids
    quantities = {"own": Kinetic(block)}
    result = tangents(scene, 6.0, 0.5, {"mass": Mass(block)}, quantities)
    history = result.history
    assert history.finished and not history["kinetic"][1:].any()
    assert not result["own"][1:].any()
    assert np.abs(history["balance"]).max() < 1e-12 * history["strain"].max()


def test_the_time_alone_may_be_asked_of_an_adjoint():
    scene = drawn()
    (block,) = scene.solids
    end = {"end": lambda history: (history.time[-1], {"time": np.eye(len(history))[-1]})}
    asked = {"E": Modulus(block)}
    result = adjoints(scene, 1.0, 0.5, asked, {}, functionals=end)
    assert result.values["end"] == 1.0 and not np.any(result["end"])
    with pytest.raises(InputError, match="of what"):
        adjoints(drawn(), 1.0, 0.5, asked, {})
    with pytest.raises(InputError, match="functionals = 'end': must be a dict"):
        adjoints(drawn(), 1.0, 0.5, asked, {}, functionals="end")


def test_what_is_no_solid_contact_or_name_is_refused():
    block = solid_of(drawn())
    for make, word in (
        (lambda: Gravity(3, (0, 1)), "solid = 3"),
        (lambda: Centre(None, (0, 1)), "solid = None"),
        (lambda: ObstacleShift("floor", (0, 1)), "contact = 'floor'"),
        (lambda: Force(block, (0, 1)), "contact = "),
        (lambda: Modulus(block, 1e4), "name = 10000.0"),
        (lambda: Start(block, turn="1"), "has no turn"),
        (lambda: tangents(None, 1.0, 0.5, {"E": Modulus(block)}), "scene = None"),
        (lambda: tangents(drawn(), 1.0, 0.5, {None: Modulus(block)}), "a name = None"),
    ):
        with pytest.raises(InputError, match=word):
            make()


@pytest.mark.parametrize("value", [1e5, 2.1e5, 0.0])
def test_in_space_an_energy_of_other_moduli_is_refused(value):
    """Where all strains are alike shear moduli of an energy without volume tell nothing."""

    def split(mu):
        def energy(F):
            J = ufl.det(F)
            return mu / 2 * (J ** (-2 / 3) * ufl.tr(F.T * F) - 3) + 1e6 * (J - 1) ** 2

        return energy

    block = HyperelasticSolid(box((1, 1, 1)), energy=split(2e5), density=1e3)
    Material(block, split, 2e5)
    with pytest.raises(InputError, match=f"{value:g} does not make the energy"):
        Material(block, split, value)


@pytest.mark.parametrize("theta", [0.5, 0.6, 1.0])
@pytest.mark.parametrize("law", ["gap", "velocity"])
@pytest.mark.parametrize(("law_of", "h"), [(None, 1e-7), (Tresca, 1e-4)])
def test_from_no_friction_at_all(law_of, h, law, theta):
    """Of a block that spreads and springs back some slips turn round: there a small friction does
    nothing, and none at all has no direction but that of round-off."""

    def build(bound):
        mesh = rectangle((3, 3), (0.4, 0.4))
        build.bound = fem.Constant(mesh.mesh, bound)
        block = ElasticSolid(
            mesh, youngs_modulus=1e6, poisson_ratio=0.3, density=1000.0, gravity=(1.0, -G)
        )
        friction = law_of(build.bound) if law_of else build.bound
        contact = Contact(block, "base", FLOOR, law, friction=friction)
        return Scene([block], [contact], ThetaScheme(theta))

    def asked(scene):
        return {"x": Centre(scene.solids[0], (1, 0)), "F": Force(scene.contacts[0], (1, 0))}

    def ends(bound):
        scene = build(bound)
        scene.run(0.015, 5e-3)
        return np.array([each.value() for each in asked(scene).values()])

    scene = build(0.0)
    found = tangents(
        scene, 0.015, 5e-3, {"bound": Law(scene.contacts[0], build.bound)}, asked(scene)
    )
    found = [found[name][-1, 0] for name in ("x", "F")]
    plateau = (ends(h) - ends(0.0)) / h
    np.testing.assert_allclose(found[0], plateau[0], rtol=1e-5)
    np.testing.assert_allclose(found[1], plateau[1], rtol=1e-5, atol=1e-4)
