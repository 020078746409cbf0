# SPDX-License-Identifier: LGPL-3.0-or-later
"""Derivatives of runs in which rigid solids meet deformable ones, or each other."""

from __future__ import annotations

import numpy as np
import pytest
from corpus_meshes import moved
from scenes import FLOOR, G, box, rectangle
from test_gradients import LONG, check, friction, refused, solid_of

from fenicsx_contact import Contact, ElasticSolid, RigidSolid, Scene, ThetaScheme
from fenicsx_contact.contact.mortar_jump import MortarJump
from fenicsx_contact.gradients import (
    Centre,
    Force,
    Gravity,
    Kinetic,
    Law,
    Mass,
    Modulus,
    NoDerivative,
    Start,
    Turn,
    adjoints,
    tangents,
)

BY_GAP = {"formulation": "gap", "theta": 1.0, "geometry": "newton"}
AT_REST = [f"{what} {axis}" for what in ("turn", "spin") for axis in "xyz"] + ["y", "vy", "z", "vz"]
HELD = {2: ("x", "y", "turning"), 3: ("x", "y", "z", *(f"turning about {a}" for a in "xyz"))}


def measured(scene, still=()):
    """Places, velocities, energies and rotations of what is not held, but for what stays at rest;
    the force of the last contact."""
    result = {"force": Force(scene.contacts[-1], (1, 0.3, 0.2)[: solid_of(scene).dim])}
    for solid in scene.solids:
        if len(getattr(solid, "held", ())) == len(HELD[solid.dim]):
            continue
        name, axes = solid.name, np.eye(solid.dim)
        result[f"energy of {name}"] = Kinetic(solid)
        for axis, way in zip("xyz", axes):
            result[f"{axis} of {name}"] = Centre(solid, way)
            result[f"v{axis} of {name}"] = Centre(solid, way, "velocity")
        if isinstance(solid, RigidSolid):
            for axis, way in zip("xyz", axes) if solid.dim == 3 else [("", None)]:
                result[f"turn {axis} of {name}"] = Turn(solid, about=way)
                result[f"spin {axis} of {name}"] = Turn(solid, "velocity", way)
    return {name: each for name, each in result.items() if name not in still}


# -- formulas --


def sliding(mu=0.3, v=2.0, m=1.0, M=4.0, steps=100, held=False, **scene):
    """A block that slides on a slab, which is held or free; with it the step after which, in the
    midst of one, it moves along with the slab."""
    slab = RigidSolid(
        rectangle((6, 1), (6.0, 0.2)),
        mass=M,
        held=HELD[2] if held else ("y", "turning"),
        name="slab",
    )
    block = RigidSolid(
        moved(rectangle(size=(0.5, 0.2)), -1.03, 0.2),
        mass=m, gravity=(0, -G), velocity=(v, 0), name="block",
    )  # fmt: skip
    contact = Contact(block, "base", (slab, "top"), friction=mu, name="c")
    a = mu * G * (1 if held else 1 + m / M)
    return Scene([block, slab], [contact], **scene), a, v / a / np.sqrt(steps * (steps + 1))


@pytest.mark.parametrize("scene", [{}, {"geometry": "newton"}])
def test_a_block_stops_on_a_held_slab(scene):
    scene, a, dt = sliding(held=True, **scene)
    block, mu, v = solid_of(scene), 0.3, 2.0
    asked = {"mu": friction(scene), "g": Gravity(block, (0, -1)), "m": Mass(block),
             "v": Start(block, velocity=(1, 0))}  # fmt: skip
    result = tangents(scene, 1.2 * v / a, dt, asked, measured(scene))
    by_mu, by_g, by_m, by_v = result["x of block"][-1]
    assert by_mu == pytest.approx(-(v**2) / (2 * mu**2 * G), rel=1e-10)
    assert by_g == pytest.approx(-(v**2) / (2 * mu * G**2), rel=1e-10)
    assert abs(by_m) < 1e-10
    assert by_v == pytest.approx(100.5 * dt, rel=1e-10)
    assert by_v == pytest.approx(v / (mu * G), rel=2e-5)  # of second order in dt


@pytest.mark.parametrize("scene", [{}, {"geometry": "newton"}])
def test_a_block_on_a_free_slab(scene):
    """They exchange momentum until both move at v m/(m + M); until then the block slides
    v²/(2 mu g (1 + m/M)) on the slab. By M it is exact for the speed, and of second order in dt for
    the distance, as by v."""
    m, M, mu, v = 1.0, 4.0, 0.3, 2.0
    scene, a, dt = sliding(mu, v, m, M, **scene)
    block, slab = scene.solids
    asked = {"mu": friction(scene), "g": Gravity(block, (0, -1)), "m": Mass(block),
             "M": Mass(slab), "v": Start(block, velocity=(1, 0))}  # fmt: skip
    result = tangents(scene, 1.2 * v / a, dt, asked, measured(scene))
    for name in ("vx of block", "vx of slab"):
        exact = [0, 0, v * M / (m + M) ** 2, -v * m / (m + M) ** 2, m / (m + M)]
        np.testing.assert_allclose(result[name][-1], exact, rtol=1e-10, atol=1e-10)
    slid = result["x of block"][-1] - result["x of slab"][-1]
    s = v**2 / (2 * a)
    by_a = -s / a
    np.testing.assert_allclose(slid[:2], [by_a * a / mu, by_a * a / G], rtol=1e-10)
    exact = [by_a * mu * G / M, -by_a * mu * G * m / M**2]
    np.testing.assert_allclose(slid[2:4], exact, rtol=1e-10)
    assert slid[4] == pytest.approx(100.5 * dt, rel=1e-10)
    assert slid[4] == pytest.approx(v / a, rel=2e-5)


# -- plateaus of central differences --


def first(**by):
    return lambda scene: Start(solid_of(scene), **by)


def down(scene):
    solid = solid_of(scene)
    return Gravity(solid, (0,) * (solid.dim - 1) + (-1,))


def elastic(size=(0.4, 0.4), n=(3, 3), at=(0.013, 0.406), E=1e6, **given):
    return ElasticSolid(
        moved(rectangle(n, size), *at), youngs_modulus=E, poisson_ratio=0.3, density=1000.0, **given
    )


def thrown_on_a_rigid_floor(E=1e6, mu=0.3, g=G, speed=0.5, formulation="velocity", theta=0.5,
                            **scene):  # fmt: skip
    """A soft block thrown obliquely on a rigid one that is held: it strikes, slips, sticks."""
    up = elastic(
        E=E,
        gravity=(0, -g),
        displacement=lambda x: np.stack([-0.02 * x[1], 0.02 * x[0]]),
        velocity=lambda x: np.stack([speed + 0 * x[0], -1.0 - 0.2 * x[0]]),
        name="up",
    )
    low = RigidSolid(rectangle((4, 3), (0.8, 0.4)), mass=1.0, held=HELD[2], name="low")
    contact = Contact(up, "base", (low, "top"), formulation, friction=mu, name="c")
    return Scene([up, low], [contact], ThetaScheme(theta), **scene)


THROWN = {
    "E": (1e6, lambda s: Modulus(solid_of(s))),
    "mu": (0.3, friction),
    "g": (G, down),
    "speed": (0.5, first(velocity=lambda x: np.stack([1 + 0 * x[0], 0 * x[0]]))),
}


def sliding_on_an_elastic_slab(E=1e6, mu=0.2, speed=1.0, tilt=0.004, mass=60.0,
                               formulation="velocity", theta=0.5, **scene):  # fmt: skip
    """A rigid block that lands on a soft slab with one edge first, and slides."""
    up = RigidSolid(
        moved(rectangle(size=(0.3, 0.1)), -0.11, 0.402),
        mass=mass, gravity=(0, -G), velocity=(speed, -0.3), rotation=tilt, name="up",
    )  # fmt: skip
    low = elastic((1.2, 0.4), (7, 3), (0.0, 0.0), E, fixed=["base"], name="low")
    contact = Contact(up, "base", (low, "top"), formulation, friction=mu, name="c")
    return Scene([up, low], [contact], ThetaScheme(theta), **scene)


SLIDING = {
    "E": (1e6, lambda s: Modulus(s.solids[1])),
    "mu": (0.2, friction),
    "speed": (1.0, first(velocity=(1, 0))),
    "tilt": (0.004, first(turn=1)),
    "mass": (60.0, lambda s: Mass(solid_of(s))),
}


def tilted(mu=0.3, speed=0.3, tilt=0.05, mass=3.0, formulation="velocity", theta=0.5, **scene):
    """A rigid block that lands tilted on another, which lies on a floor and is pushed along."""
    up = RigidSolid(
        moved(rectangle(size=(0.2, 0.3)), 0.0, 0.21),
        mass=mass, gravity=(0, -G), velocity=(speed, -0.2), rotation=tilt, name="up",
    )  # fmt: skip
    low = RigidSolid(
        rectangle(size=(1.0, 0.2)), mass=2.0, gravity=(0, -G), velocity=(-0.1, 0), name="low"
    )
    contacts = [
        Contact(low, "base", FLOOR, formulation, friction=0.02, name="floor"),
        Contact(up, "base", (low, "top"), formulation, friction=mu, name="c"),
    ]
    return Scene([up, low], contacts, ThetaScheme(theta), **scene)


TILTED = {
    "mu": (0.3, lambda s: Law(s.contacts[1])),
    "speed": (0.3, first(velocity=(1, 0))),
    "tilt": (0.05, first(turn=1)),
    "mass": (3.0, lambda s: Mass(solid_of(s))),
}


def in_space(mu=0.3, speed=0.3, tilt=0.1, mass=3.0, theta=0.5, **scene):
    """A rigid box that lands with a corner on a rigid slab, which it drags along."""
    up = RigidSolid(
        moved(box(size=(0.2, 0.3, 0.25)), 0.01, 0.02, 0.225),
        mass=mass, gravity=(0, 0, -G), velocity=(speed, 0.1, -0.2), spin=(0.2, -0.3, 0.5),
        rotation=(0.6 * tilt, tilt, 0.0), name="up",
    )  # fmt: skip
    slab = box((2, 2, 1), (1.0, 1.0, 0.2))
    low = RigidSolid(slab, mass=2.0, held=HELD[3][1:], name="low")
    contact = Contact(up, "base", (low, "top"), friction=mu, name="c")
    return Scene([up, low], [contact], ThetaScheme(theta), **scene)


IN_SPACE = {
    "mu": (0.3, friction),
    "speed": (0.3, first(velocity=(1, 0, 0))),
    "tilt": (0.1, first(turn=(0.6, 1, 0))),
    "mass": (3.0, lambda s: Mass(solid_of(s))),
}


def pressed(E=3e5, mu=0.3, speed=0.3, tilt=0.3, theta=0.5, **scene):
    """A rigid block lands tilted on a floor, and a soft one on it."""
    low = RigidSolid(
        moved(rectangle(size=(0.4, 0.2)), 0.0, 0.07),
        mass=40.0, gravity=(0, -G), velocity=(speed, -0.3), rotation=tilt, name="low",
    )  # fmt: skip
    up = elastic(
        (0.2, 0.2), (2, 2), (0.013, 0.29), E, gravity=(0, -G), name="up",
        displacement=lambda x: np.stack([0.1 - 0.3 * x[1], 0.3 * x[0]]),
        velocity=lambda x: np.stack([0 * x[0], -1.0 + 0 * x[0]]),
    )  # fmt: skip
    contacts = [
        Contact(low, "base", FLOOR, friction=0.1, name="floor"),
        Contact(up, "base", (low, "top"), friction=mu, name="c"),
    ]
    return Scene([low, up], contacts, ThetaScheme(theta), **scene)


PRESSED = {
    "E": (3e5, lambda s: Modulus(s.solids[1])),
    "mu": (0.3, lambda s: Law(s.contacts[1])),
    "speed": (0.3, first(velocity=(1, 0))),
    "tilt": (0.3, first(turn=1)),
}


def moving(scene, rest):
    """What is measured but for what of the last solid stays at rest."""
    return measured(scene, [f"{what} of {scene.solids[1].name}" for what in rest])


#: How a scene is built, by what, until, dt, and what of the last solid stays at rest.
SCENES = {
    "thrown": (thrown_on_a_rigid_floor, THROWN, 0.012, 1e-3, ()),
    "sliding": (sliding_on_an_elastic_slab, SLIDING, 0.05, 2e-3, ()),
    "tilted": (tilted, TILTED, 0.08, 2e-3, ("y", "vy", "turn ", "spin ")),
    "pressed": (pressed, PRESSED, 0.06, 2e-3, ()),
    "in space": (in_space, IN_SPACE, 0.03, 3e-3, AT_REST),
}
#: Those that the second tier takes.
SLOW = dict.fromkeys(("tilted", "pressed", "in space"), pytest.mark.second)
SOLVED_AGAIN = {"thrown": 0, "sliding": 0, "tilted": 1, "pressed": 1, "in space": 1}


@pytest.mark.second
@pytest.mark.parametrize(
    ("name", "scene"),
    [
        *(pytest.param(name, {}, marks=SLOW.get(name, ())) for name in SCENES),
        *(pytest.param(name, {"geometry": "newton"}, marks=LONG) for name in SCENES),
        pytest.param("sliding", BY_GAP, marks=LONG),
        pytest.param("tilted", BY_GAP, marks=LONG),
        pytest.param("thrown", {"theta": 1.0}, marks=LONG),
        pytest.param("in space", {"theta": 1.0, "geometry": "newton"}, marks=LONG),
        pytest.param("tilted", {"solver": "monolithic"}, marks=LONG),
    ],
    ids=str,
)
def test_a_plateau(name, scene):
    build, by, until, dt, rest = SCENES[name]
    rounds = []

    def built(**values):
        scene_ = build(**values, **scene)
        scene_.stepper.rounds.append(lambda trial: rounds.append(1 + trial.again))
        return scene_

    result = check(built, by, until, dt, lambda s: moving(s, rest), shares=[1e-5])
    assert result.history["c.bearing"].max() > 0 and result.history["c.slipping"].max() > 0
    if not scene:  # steps that are solved again about where solids were put
        assert max(rounds, default=0) >= SOLVED_AGAIN[name]


@pytest.mark.second
def test_steps_that_are_solved_again_twice(monkeypatch):
    """As all were before corners stood on faces: the chain of rounds is differentiated, too."""
    monkeypatch.setattr(MortarJump, "stand", lambda *_: False)
    build, by, until, dt, rest = SCENES["tilted"]
    rounds = []

    def built(**values):
        scene = build(**values)
        scene.stepper.rounds.append(lambda trial: rounds.append(1 + trial.again))
        return scene

    check(built, by, until, dt, lambda s: moving(s, rest), shares=[1e-5])
    assert max(rounds) >= 2


# -- adjoints, kinks, refusals --


@pytest.mark.parametrize("name", [pytest.param(name, marks=SLOW.get(name, ())) for name in SCENES])
def test_adjoints_are_tangents(name):
    build, by, until, dt, rest = SCENES[name]
    found = []
    for way in (tangents, adjoints):
        scene = build()
        asked = {each: of(scene) for each, (_, of) in by.items()}
        found.append(way(scene, until, dt, asked, moving(scene, rest)))
    forward, back = found
    values = [value for value, _ in by.values()]
    for each in back.values:
        off = (back.one_sided(each) - forward.one_sided(each)[-1]) * values
        most = np.abs(forward.one_sided(each) * values).max()
        assert np.abs(off).max() <= 1e-10 * most, each


@pytest.mark.second
def test_a_turning_box_on_a_rigid_slab_has_no_derivative():
    """How four corners share its weight is not unique."""
    up = RigidSolid(
        moved(box(size=(0.2, 0.3, 0.25)), 0.0, 0.0, 0.2),
        mass=3.0, gravity=(0, 0, -G), velocity=(1, 0, 0), spin=(0, 0, 1), name="up",
    )  # fmt: skip
    low = RigidSolid(box((1, 1, 1), (1.0, 1.0, 0.2)), mass=1.0, held=HELD[3], name="low")
    scene = Scene([up, low], [Contact(up, "base", (low, "top"), friction=0.3, name="c")])
    with pytest.raises(NoDerivative, match="slides under pressures that are not unique"):
        tangents(scene, 0.02, 2e-3, {"mu": friction(scene)}, measured(scene))["vx of up"]


def test_what_is_not_supported_is_refused_by_name():
    located = tilted(locate_impacts=True)
    refused(located, {"g": down(located)}, "contact 'c' is between two solids, in a scene with l")
    low = RigidSolid(box(), mass=1.0, held=("turning about x",), name="low")
    up = RigidSolid(moved(box(), 0.0, 0.0, 0.8), mass=1.0, name="up")
    for law in ("velocity", "gap"):
        contact = Contact(up, "base", (low, "top"), law, name="c")
        scene = Scene([up, low], [contact], ThetaScheme(1.0), allow_free=True)
        if law == "velocity":
            refused(scene, {"g": down(scene)}, "'c' puts back solid 'low', which is held about one")
        else:
            tangents(scene, 0.01, 0.01, {"g": down(scene)})
    curved = elastic(degree=2, name="up")
    low = RigidSolid(rectangle(), mass=1.0, held=HELD[2], name="low")
    scene = Scene([curved, low], [Contact(curved, "base", (low, "top"), name="c")], deepest=1.0)
    refused(scene, {"g": down(scene)}, "contact 'c' is between two solids, and one is of sec")


@pytest.mark.parametrize("formulation", ["velocity", "gap"])
def test_a_plank_slides_on_a_pedestal_and_tips(formulation):
    """Its facets reach beyond the pedestal at both ends: what is covered changes."""

    def build(speed, mu):
        low = RigidSolid(
            moved(rectangle(size=(0.4, 0.2)), 0.0, -0.2), mass=1.0, held=HELD[2], name="low"
        )
        up = RigidSolid(
            moved(rectangle((1, 1), (1.0, 0.1)), 0.13, 0.0),
            mass=2.0, velocity=(speed, 0), gravity=(0, -G), name="up",
        )  # fmt: skip
        contact = Contact(up, "base", (low, "top"), formulation, friction=mu, name="c")
        return Scene([up, low], [contact], geometry="newton")  # to round-off: differences of runs

    asked = {
        "speed": (1.0, lambda s: Start(solid_of(s), velocity=(1, 0))),
        "mu": (0.2, friction),
    }
    result = check(build, asked, 0.2, 5e-3, measured)
    assert abs(result.history["spin  of up"][-1]) > 0.1


@pytest.mark.parametrize("mu", [0.0, 0.1])
@pytest.mark.parametrize("formulation", ["velocity", "gap"])
def test_a_block_slides_along_a_bar_that_turns(formulation, mu):
    """Forces act by the mean of what both see of each other at the two ends of a step."""

    def build(speed, mu, m):
        bar = RigidSolid(
            moved(rectangle((4, 1), (2.0, 0.1)), 0.0, -0.1), mass=3.0, spin=1.0, name="bar"
        )
        block = RigidSolid(
            moved(rectangle(size=(0.2, 0.1)), 0.3, 0.0),
            mass=m, velocity=(speed - 0.05, 0.3), spin=1.0, gravity=(0, -G), name="block",
        )  # fmt: skip
        contact = Contact(block, "base", (bar, "top"), formulation, friction=mu, name="c")
        return Scene([block, bar], [contact], geometry="newton")

    asked = {
        "speed": (0.4, lambda s: Start(solid_of(s), velocity=(1, 0))),
        "m": (1.0, lambda s: Mass(solid_of(s))),
    }
    if mu:
        asked["mu"] = (mu, friction)
        check(build, asked, 0.06, 2e-3, measured)
    else:
        check(lambda speed, m: build(speed, 0.0, m), asked, 0.06, 2e-3, measured)
