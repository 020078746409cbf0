# SPDX-License-Identifier: LGPL-3.0-or-later
"""Derivatives by the numbers of interface laws, own ones included, of springs, and through what
laws remember: against central differences, formulas, and one another."""

from __future__ import annotations

import numpy as np
import pytest
from dolfinx import fem
from scenes import FLOOR, FLOOR_3D, G, box, rectangle
from test_gradients import centre, solid_of, weight
from test_gradients import check as checked

from fenicsx_contact import (
    Adhesive,
    Archard,
    Compliance,
    Contact,
    Discrete,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    InputError,
    Moved,
    Newton,
    QuasiStatic,
    RateState,
    Restitution,
    RigidSolid,
    Scene,
    StaticKinetic,
    Stribeck,
    ThetaScheme,
    Tresca,
    neo_hookean,
)
from fenicsx_contact.gradients import (
    At,
    Centre,
    Force,
    Kinetic,
    Law,
    Pressure,
    Remembered,
    adjoints,
    tangents,
)


def check(build, parameters, until, dt, quantities=centre):
    """As there; of what changes by hardly anything only long differences tell anything."""
    return checked(build, parameters, until, dt, quantities, (1e-2, 1e-3, 1e-4, 1e-5))


class Falling:
    """Friction that falls with the slip and rises with the way, of a user's own."""

    def __init__(self, mu, speed):
        self.mu, self.speed = mu, speed

    def bound(self, k, pressure, S):
        slip = 1 + k.slip_speed / k.field("v", self.speed)
        return k.field("mu", self.mu) * (1 + 0.3 * k.place[0] ** 2) * pressure / slip

    def describe(self):
        return "falls"


class Heals:
    """Friction that grows with time, whatever moves, of a user's own."""

    def __init__(self, mu, rate, start=1.0):
        self.mu, self.rate, self.start = mu, rate, start

    def bound(self, k, pressure, S):
        rate, start = k.field("rate", self.rate), k.field("start", self.start)
        age = k.state("age", start, lambda old, time: old + rate * time)
        return k.field("mu", self.mu) * age * pressure

    def describe(self):
        return "heals"


def body(kind, mesh, velocity, **more):
    """Light and soft, or rigid."""
    dim = mesh.mesh.geometry.dim
    more = {"density": 5.0, "gravity": (0,) * (dim - 1) + (-G,), **more}
    if kind is RigidSolid:
        return RigidSolid(mesh, velocity=velocity, **more)
    start = np.array(velocity, dtype=float)[:, None]
    more["velocity"] = lambda x: start + 0 * x[:dim]
    if kind is ElasticSolid:
        return ElasticSolid(mesh, youngs_modulus=2e5, poisson_ratio=0.3, **more)
    return HyperelasticSolid(mesh, energy=neo_hookean(2e5, 0.3), **more)


def slides(friction, kind=RigidSolid, formulation="velocity", theta=0.5, speed=0.5, **scene):
    """A flat block on a floor."""
    block = body(kind, rectangle(size=(1.0, 0.2)), (speed, 0.0))
    contact = Contact(block, "base", FLOOR, friction=friction, formulation=formulation, name="c")
    return Scene([block], [contact], scheme=ThetaScheme(theta), **scene)


def number(name, contact=-1):
    """A parameter that stands in a law."""
    return lambda scene: Law(scene.contacts[contact], name)


#: Laws of friction by their numbers, and what these are.
FRICTION = {
    "Stribeck": (
        lambda s, k, v, c: Stribeck(s, k, v, viscosity=c),
        {"static": 0.4, "kinetic": 0.2, "speed": 0.3, "viscosity": 2.0},
    ),
    "own": (Falling, {"mu": 0.3, "v": 0.4}),
    "by the clock": (Heals, {"mu": 0.2, "rate": 4.0, "start": 1.0}),
    "StaticKinetic": (lambda k: StaticKinetic(0.5, k), {"kinetic": 0.2}),
    "RateState": (
        RateState,
        {"a": 0.02, "b": 0.03, "distance": 0.05, "mu": 0.3, "speed": 0.1},
    ),
    "RateState, slip": (
        lambda b, D, theta: RateState(0.02, b, D, 0.3, 0.1, theta, "slip"),
        {"b": 0.03, "distance": 0.05, "theta": 0.4},
    ),
}
#: Formulations likewise.
LAWS = {
    "Discrete": (
        Discrete,
        {"stiffness": 400.0, "damping": 2.0, "tangential_stiffness": 300.0},
    ),
    "Discrete, one stiffness": (Discrete, {"stiffness": 400.0}),
    "Compliance": (lambda c: Compliance(c, 2.0, 500.0), {"coefficient": 4e4}),
    "Adhesive": (Adhesive, {"adhesive stress": 3.0}),
}


def by_numbers(values):
    """Parameters with their values, by names that Python takes."""
    return {f"p{i}": (value, number(name)) for i, (name, value) in enumerate(values.items())}


@pytest.mark.parametrize("theta", [0.5, 1.0])
@pytest.mark.parametrize("kind", [RigidSolid, ElasticSolid, HyperelasticSolid])
@pytest.mark.parametrize("law", [*FRICTION])
def test_by_the_numbers_of_a_law_of_friction(law, kind, theta):
    make, values = FRICTION[law]
    check(
        lambda **p: slides(make(*p.values()), kind, theta=theta, geometry="newton"),
        by_numbers(values), 0.06, 1e-2,
    )  # fmt: skip


@pytest.mark.parametrize("friction", [0.0, 0.1, 3.0], ids=["smooth", "slips", "sticks"])
@pytest.mark.parametrize("theta", [0.5, 1.0])
@pytest.mark.parametrize("kind", [RigidSolid, ElasticSolid, HyperelasticSolid])
@pytest.mark.parametrize("law", [*LAWS])
def test_by_the_numbers_of_a_formulation(law, kind, theta, friction):
    make, values = LAWS[law]
    if law == "Adhesive" and (friction != 0.1 or kind is RigidSolid):
        pytest.skip("nothing depends on what draws a solid that rests and sticks")
    if not friction:
        values = {n: v for n, v in values.items() if not n.startswith("tangential")}
    asked = by_numbers(values)

    def build(mu=friction, g=None, **p):
        given = [*p.values()] + [300.0] * (law == "Discrete" and not friction)
        return slides(mu, kind, make(*given), theta, geometry="newton")

    if friction == 0.1:
        asked["mu"] = (friction, number("friction"))
    check(build, asked, 0.12, 1e-2)


@pytest.mark.parametrize("tilt", [0.0, 0.05])
@pytest.mark.parametrize("located", [False, True])
def test_by_a_coefficient_of_restitution(located, tilt):
    def build(e, mu, g):
        block = RigidSolid(
            rectangle(size=(1.0, 0.2)), mass=1.0, gravity=(0, -g), velocity=(1.0, 0.0),
            rotation=tilt,
        )  # fmt: skip
        contact = Contact(
            block, "base", HalfSpace((0, -0.1), (0, 1)), friction=mu,
            formulation=Restitution(e), name="c",
        )  # fmt: skip
        return Scene([block], [contact], locate_impacts=located)

    asked = {"e": (0.5, number("restitution")), "mu": (0.1, number("friction")), "g": (G, weight)}
    check(build, asked, 0.25, 1e-2)


def test_the_rebound_of_a_ball():
    """It falls by h, and leaves with e sqrt(2 g h)."""
    e, h = 0.7, 0.5
    ball = RigidSolid(rectangle(size=(0.1, 0.1)), mass=1.0, gravity=(0, -G))
    contact = Contact(
        ball, "base", HalfSpace((0, -h), (0, 1)), formulation=Restitution(e), name="c"
    )
    scene = Scene([ball], [contact], locate_impacts=True)
    t, fall = 0.45, (2 * h / G) ** 0.5
    asked = {"e": Law(contact, "restitution"), "g": weight(scene)}
    rises = {"y": Centre(ball, (0, 1)), "v": Centre(ball, (0, 1), "velocity")}
    result = tangents(scene, t, 1e-2, asked, rises)
    speed = (2 * G * h) ** 0.5
    # y = e speed (t - fall) - g (t - fall)²/2, where fall depends on g, too
    since, by_g = t - fall, -fall / (2 * G)
    np.testing.assert_allclose(result["v"][-1, 0], speed, rtol=1e-8)
    np.testing.assert_allclose(result["y"][-1, 0], speed * since, rtol=1e-8)
    exact = e * speed / (2 * G) - since + G * by_g
    np.testing.assert_allclose(result["v"][-1, 1], exact, rtol=1e-8)


@pytest.mark.parametrize("theta", [0.5, 1.0])
@pytest.mark.parametrize("kind", [RigidSolid, ElasticSolid])
def test_friction_of_places(kind, theta):
    """Constants in UFL of where points are."""

    def build(a, b):
        mesh = rectangle(size=(1.0, 0.2))
        A, B = (fem.Constant(mesh.mesh, value) for value in (a, b))
        block = body(kind, mesh, (0.5, 0.0))
        law = {"friction": lambda x: A * (1 + B * x[0] ** 2)}
        scene = Scene(
            [block], [Contact(block, "base", FLOOR, name="c", **law)],
            scheme=ThetaScheme(theta), geometry="newton",
        )  # fmt: skip
        scene.constants = A, B
        return scene

    asked = {
        name: (value, lambda scene, i=i: Law(scene.contacts[0], scene.constants[i]))
        for i, (name, value) in enumerate({"a": 0.3, "b": 0.5}.items())
    }
    check(build, asked, 0.06, 1e-2)


@pytest.mark.parametrize("kind", [ElasticSolid, HyperelasticSolid])
@pytest.mark.parametrize("law", ["gap", "lagrange"])
def test_worn_by_laws_of_positions(law, kind):
    """What wears bears less; its volume is k F s / H."""
    at_points = law == "lagrange"
    asked = {"k": (0.1, number("coefficient")), "H": (100.0, number("hardness"))}
    if at_points:
        with pytest.raises(InputError, match="points"):
            slides(Archard(0.2, 0.1, 100.0), kind, "lagrange")
        return

    def worn(scene):
        (contact,) = scene.contacts
        at = contact.surface.points[0]
        return {
            **centre(scene), "volume": Remembered(contact, "worn"),
            "depth": Remembered(contact, "worn", at),
        }  # fmt: skip

    check(
        lambda k, H: slides(Archard(0.2, k, H), kind, law, 1.0, geometry="newton"),
        asked, 0.06, 1e-2, worn,
    )  # fmt: skip


def drawn(law, formulation="velocity"):
    """A column pressed on a floor, whose top is drawn along it, in statics."""
    mesh = rectangle((1, 2), (0.2, 0.4))
    column = ElasticSolid(
        mesh, youngs_modulus=1e4, poisson_ratio=0.3, density=1.0,
        prescribed={"top": lambda t: (0.1 * t, -0.01)},
    )  # fmt: skip
    contact = Contact(column, "base", FLOOR, friction=law, formulation=formulation, name="c")
    return Scene([column], [contact], scheme=QuasiStatic(), geometry="newton")


def borne(scene):
    """Forces of the contact, and a displacement."""
    contact, solid = scene.contacts[0], solid_of(scene)
    return {
        "N": Force(contact, (0, 1)), "T": Force(contact, (1, 0)),
        "u": At(solid, (0.1, 0.0), (1, 0)),
    }  # fmt: skip


def test_wear_in_statics_by_velocities():
    def both(scene):
        return {**borne(scene), "volume": Remembered(scene.contacts[0], "worn")}

    asked = {"k": (0.2, number("coefficient")), "H": (1e3, number("hardness"))}
    check(lambda k, H: drawn(Archard(0.2, k, H)), asked, 1.0, 0.1, both)


def test_springs_in_statics():
    asked = {
        "k": (2e4, number("stiffness")), "t": (1e4, number("tangential_stiffness")),
        "mu": (0.2, number("friction")),
    }  # fmt: skip
    check(
        lambda k, t, mu: drawn(mu, formulation=Discrete(k, 0.0, t)), asked, 1.0, 0.1, borne
    )  # fmt: skip


def two(law, lower, upper, theta, formulation="velocity"):
    """A block that slides on another one."""
    mesh = rectangle((3, 2), (0.4, 0.2))
    mesh.mesh.geometry.x[:, :2] += (0.03, 0.3)
    below = body(lower, rectangle((8, 2), (1.6, 0.3)), (0.0, 0.0), name="lower")
    above = body(upper, mesh, (1.0, 0.0), name="upper")
    sides = ((below, "top"), (above, "base"))
    slave, master = sides[::-1] if upper is ElasticSolid else sides
    floor = Contact(below, "base", FLOOR, friction=0.5, name="floor")
    pair = Contact(*slave, master, friction=law, formulation=formulation, name="pair")
    fine = {"geometry": "newton", "newton": Newton(tolerance=1e-12)}  # for the differences
    return Scene([below, above], [floor, pair], scheme=ThetaScheme(theta), **fine)


def of_two(scene):
    below, above = scene.solids
    return {
        "x": Centre(above, (1, 0)), "v": Centre(above, (1, 0), "velocity"),
        "below": Centre(below, (1, 0)), "energy": Kinetic(above),
    }  # fmt: skip


@pytest.mark.parametrize("theta", [0.5, 1.0])
@pytest.mark.parametrize(
    ("lower", "upper"), [(ElasticSolid, RigidSolid), (ElasticSolid, ElasticSolid)]
)
@pytest.mark.parametrize("law", ["Stribeck", "own", "RateState"])
def test_between_two_solids(law, lower, upper, theta):
    make, values = FRICTION[law]
    check(
        lambda **p: two(make(*p.values()), lower, upper, theta),
        by_numbers(values), 0.02, 5e-3, of_two,
    )  # fmt: skip


def in_space(friction, kind, theta, formulation="velocity"):
    block = body(kind, box((2, 2, 1)), (0.5, 0.2, 0.0))
    contact = Contact(block, "base", FLOOR_3D, friction=friction, formulation=formulation, name="c")
    return Scene([block], [contact], scheme=ThetaScheme(theta), geometry="newton")


def space(scene):
    solid = solid_of(scene)
    return {
        "x": Centre(solid, (1, 0, 0)), "vy": Centre(solid, (0, 1, 0), "velocity"),
        "energy": Kinetic(solid),
    }  # fmt: skip


@pytest.mark.parametrize("theta", [0.5, 1.0])
@pytest.mark.parametrize("law", ["Stribeck", "RateState"])
def test_in_space(law, theta):
    make, values = FRICTION[law]
    check(
        lambda **p: in_space(make(*p.values()), ElasticSolid, theta),
        by_numbers(values), 0.03, 5e-3, space,
    )  # fmt: skip


@pytest.mark.parametrize("kind", [RigidSolid, ElasticSolid])
def test_springs_in_space(kind):
    check(
        lambda k: in_space(0, kind, 0.5, Discrete(k)), {"k": (400.0, number("stiffness"))},
        0.04, 5e-3, space,
    )  # fmt: skip


def test_the_numbers_of_two_laws_of_one_name():
    """Tresca's stress is not that by which the surfaces adhere."""
    check(
        lambda s, t: slides(Tresca(t), ElasticSolid, Adhesive(s), geometry="newton"),
        {"s": (3.0, number("adhesive stress")), "t": (3.0, number("stress"))}, 0.1, 1e-2,
    )  # fmt: skip


@pytest.mark.parametrize("law", ["Compliance", "Stribeck", "RateState"])
def test_a_constant_that_a_law_reads_twice(law):
    """Once for each place where it is asked for; the last one alone counted."""

    def build(a):
        mesh = rectangle(size=(1.0, 0.2))
        A = fem.Constant(mesh.mesh, a)
        friction, form = {
            "Compliance": (0.1, Compliance(lambda x: 4e4 * A, 1.5, 500.0)),
            "Stribeck": (Stribeck(lambda x: 2 * A, lambda x: A, 0.3), "velocity"),
            "RateState": (RateState(lambda x: A, lambda x: 1.5 * A, 0.05, 0.3, 0.1), "velocity"),
        }[law]
        block = body(ElasticSolid, mesh, (0.5, 0.0))
        contact = Contact(block, "base", FLOOR, friction=friction, formulation=form, name="c")
        scene = Scene([block], [contact], geometry="newton")
        scene.constant = A
        return scene

    value = {"Compliance": 1.0, "Stribeck": 0.2, "RateState": 0.02}[law]
    check(build, {"a": (value, lambda s: Law(s.contacts[0], s.constant))}, 0.06, 1e-2)


@pytest.mark.parametrize("formulation", ["lagrange", "gap"])
def test_forces_at_points_do_not_grow_with_areas(formulation):
    """A wide slave below a narrow block, which ends within its facets."""

    def build(s):
        mesh = rectangle((3, 2), (0.4, 0.2))
        mesh.mesh.geometry.x[:, :2] += (0.03, 0.3)
        below = body(ElasticSolid, rectangle((8, 2), (1.6, 0.3)), (0.0, 0.0), name="lower")
        above = body(ElasticSolid, mesh, (1.0, 0.0), name="upper")
        floor = Contact(below, "base", FLOOR, friction=0.5, name="floor")
        law = {"friction": Tresca(s), "formulation": formulation}
        pair = Contact(below, "top", (above, "base"), name="pair", **law)
        return Scene([below, above], [floor, pair], ThetaScheme(1.0), geometry="newton")

    stress = 0.5 if formulation == "lagrange" else 5.0
    check(build, {"s": (stress, number("stress"))}, 0.03, 5e-3, of_two)


def test_what_creeps_is_on_no_edge():
    """By rate and state nothing sticks, nor on a table that it follows."""
    block = RigidSolid(rectangle(size=(1.0, 0.2)), mass=1.0, gravity=(0, -G), velocity=(0.1, 0.0))
    table = Moved(FLOOR, lambda t: (0.01 * t, 0.0))
    friction = RateState(0.02, 0.03, 0.05, 0.3, 0.1)
    contact = Contact(block, "base", table, friction=friction, name="c")
    by = {"a": Law(contact, "a"), "mu": Law(contact, "mu")}
    result = tangents(Scene([block], [contact]), 0.3, 1e-2, by, centre_of(block))
    assert result.history["vx"][-1] == pytest.approx(0.01, abs=1e-4)
    assert not result.kinks


def centre_of(block):
    return {"x": Centre(block, (1, 0)), "vx": Centre(block, (1, 0), "velocity")}


@pytest.mark.parametrize("law", ["RateState", "Discrete"])
def test_adjoints_through_what_is_remembered(law):
    make, values = (FRICTION | LAWS)[law]

    def made():
        friction, form = (
            (make(*values.values()), "velocity")
            if law in FRICTION
            else (0.1, make(*values.values()))
        )
        scene = slides(friction, ElasticSolid, form)
        return scene, {name: number(name)(scene) for name in values}

    scene, asked = made()
    quantities = centre(scene)
    forward = tangents(scene, 0.1, 1e-2, asked, quantities)
    scene, asked = made()
    back = adjoints(scene, 0.1, 1e-2, asked, centre(scene), every=3, room=0)
    for name in quantities:
        np.testing.assert_allclose(back.one_sided(name), forward[name][-1], rtol=1e-9, atol=1e-14)


def test_an_age_that_has_begun_is_given():
    """Only at the very start of a scene it is D/V."""
    scene = slides(RateState(0.02, 0.03, 0.05, 0.3, 0.1), ElasticSolid)
    by = {"D": Law(scene.contacts[0], "distance")}
    age = {"age": Remembered(scene.contacts[0], "theta", (-0.5, 0.0))}
    first = tangents(scene, 1e-9, 1e-9, by, age)
    np.testing.assert_allclose(first.one_sided("age")[0], 1 / 0.1, rtol=1e-6)
    again = tangents(scene, 2e-9, 1e-9, by, age)
    np.testing.assert_allclose(again.one_sided("age"), 0.0, atol=1e-6)


def test_what_is_not_differentiated():
    def refused(scene, match):
        with pytest.raises(InputError, match=match):
            tangents(scene, 0.1, 1e-2, {"g": weight(scene)}, centre(scene))

    ages = RateState(0.02, 0.03, 0.05, 0.3, 0.1)
    refused(slides(0.1, formulation="printed"), "Printed, which chooses its closed points")
    refused(slides(lambda x, t: 0.1 + t, locate_impacts=True), "a law of time, in a scene with loc")
    refused(slides(ages, locate_impacts=True), "remembers 'theta', in a scene with located")
    refused(slides(ages, formulation=Discrete(400.0)), "Discrete and a law that remembers")
    refused(slides(Archard(0.2, 0.1, 100.0), ElasticSolid), "wears by a law of velocities")
    refused(two(0.1, ElasticSolid, ElasticSolid, 0.5, Discrete(400.0)), "jumps across open gaps")
    refused(
        two(Archard(0.2, 0.1, 100.0), ElasticSolid, ElasticSolid, 1.0, "gap"),
        "two solids, and wears",
    )
    spatial = in_space(0.1, RigidSolid, 0.5, Discrete(400.0))
    with pytest.raises(InputError, match="Discrete and friction in space"):
        tangents(spatial, 0.1, 1e-2, {"mu": Law(spatial.contacts[0])}, space(spatial))
    with pytest.raises(InputError, match="name = 'mu': must be one of"):
        Law(slides(0.1).contacts[0], "mu")
    with pytest.raises(InputError, match="is of springs and has none"):
        Pressure(slides(0, ElasticSolid, Discrete(400.0)).contacts[0], (0.5, 0.0))
    with pytest.raises(InputError, match="name = 'worn': must be one of"):
        Remembered(slides(0.1).contacts[0], "worn")
    scene = slides(StaticKinetic(0.5, 0.2))
    with pytest.raises(InputError, match="'caught' of contact 'c' does not change"):
        tangents(
            scene, 0.1, 1e-2, {"k": Law(scene.contacts[0], "kinetic")},
            {"c": Remembered(scene.contacts[0], "caught")},
        )  # fmt: skip
