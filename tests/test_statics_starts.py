# SPDX-License-Identifier: LGPL-3.0-or-later
"""From where Newton's method starts a step in equilibrium: what bears goes on, the rest is at rest,
and what only contact holds is glued where that takes it, and nowhere else."""

import numpy as np
import pytest
from scenes import FLOOR, box, rectangle

from fenicsx_contact import (
    Archard,
    Box,
    Circle,
    Contact,
    Discrete,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    Moved,
    QuasiStatic,
    Scene,
    ThetaScheme,
    name_facets,
    neo_hookean,
)
from fenicsx_contact.solve.grip import Grip
from fenicsx_contact.solve.least_work import least_work

E, LENGTH, THICKNESS, GAP = 1e6, 1.0, 0.02, 0.005


@pytest.mark.parametrize("law", ["gap", "velocity"])
@pytest.mark.parametrize("steps", [1, 10])
def test_a_cantilever_comes_to_lie_on_a_stop(law, steps):
    """Without what bore its whole underside would be inside: corrections peeled off two points
    each, and it stopped. R = 3 E I (w - g)/L^3, of the deflection w without the stop, as no shear
    of so thin a beam counts."""
    stiffness = E * THICKNESS**3 / 12
    load = 0.01 * 8 * stiffness / LENGTH**4
    mesh = rectangle((80, 2), (LENGTH, THICKNESS))
    strip = ElasticSolid(
        mesh,
        youngs_modulus=E,
        poisson_ratio=0.0,
        density=1.0,
        degree=2,
        fixed=["left"],
        tractions={"top": lambda t: (0.0, -load * t)},
    )
    stop = Contact(strip, "base", HalfSpace((0.0, -GAP), (0.0, 1.0)), law, name="stop")
    history = Scene([strip], [stop], QuasiStatic()).run(1.0, 1.0 / steps)
    assert history.finished, history.reason
    exact = 3 * stiffness * (0.01 - GAP) / LENGTH**3
    assert history["stop.force_y"][-1] == pytest.approx(exact, rel=1e-3)
    assert history["newton"].max() <= 3


def disc(n=10):
    """Of radius 1, of a square of n by n cells."""
    mesh = rectangle((n, n), (2.0, 2.0)).mesh
    X = mesh.geometry.x
    x, y = X[:, 0].copy(), X[:, 1] - 1.0
    X[:, 0], X[:, 1] = x * np.sqrt(1 - y**2 / 2), y * np.sqrt(1 - x**2 / 2)
    return name_facets(mesh, {"skin": lambda x: np.isclose(x[0] ** 2 + x[1] ** 2, 1.0)})


@pytest.mark.parametrize("geometry", [None, "fixed point"])
def test_a_wall_that_is_never_met_changes_nothing(geometry):
    """A disc that plates squeeze, a wall four radii away: it was glued to that, too, and took up to
    673 iterations back."""

    def squeezed(walls):
        solid = HyperelasticSolid(disc(), energy=neo_hookean(1.0, 0.3), density=1.0)
        lid = Moved(HalfSpace((0, 1), (0, -1)), lambda t: (0.0, -0.3 * t))
        planes = [lid, HalfSpace((0, -1), (0, 1)), HalfSpace((5, 0), (-1, 0))][: 2 + walls]
        contacts = [
            Contact(solid, "skin", plane, "gap", friction=0.2, name=f"plane {i}")
            for i, plane in enumerate(planes)
        ]
        scene = Scene([solid], contacts, QuasiStatic(), geometry=geometry)
        return scene.run(0.3, 0.1)

    alone, beside = squeezed(0), squeezed(1)
    assert alone.finished and beside.finished and not beside.remarks
    np.testing.assert_allclose(beside["plane 0.force_y"], alone["plane 0.force_y"], rtol=1e-9)
    assert beside["newton"].max() <= alone["newton"].max() <= 6


def test_a_pin_that_only_its_load_holds_is_worn():
    """Glue pressed it 7e7 times too much, in a row of wear that is of pressure times slip: 400
    iterations a step."""
    pressure, slide, hardness = 1e3, 0.5, 1e3
    pin = ElasticSolid(
        rectangle((2, 2), (0.1, 0.1)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1.0,
        prescribed={"top": (0.0, None)},
        tractions={"top": lambda t: (0.0, -pressure * min(t, 1.0))},
    )
    belt = Moved(FLOOR, lambda t: (slide * max(0.0, t - 1), 0.0))
    law = Archard(friction=0.2, coefficient=1e-5, hardness=hardness)
    contact = Contact(pin, "base", belt, "gap", friction=law, name="c")
    history = Scene([pin], [contact], QuasiStatic()).run(1.3, 0.1)
    assert history.finished
    depth = contact.coupling.recess
    area = contact.surface.area
    # V = K F s / H, of what is left of the way by the pin that is sheared
    exact = 1e-5 * pressure * 0.1 * slide * 0.3 / hardness
    assert 0.998 * exact < depth @ area < exact
    assert history["newton"].max() <= 12 and history["newton"][-2:].max() <= 4


@pytest.mark.parametrize("steps", [10, 40])
def test_what_bears_nothing_any_more_is_as_good_as_at_rest(steps):
    """A block lifted off another: what was left on that, 1e-44 N in the end, had to be balanced to
    1e-10 of itself, by one more iteration in each step."""
    kind = {"youngs_modulus": 1e6, "poisson_ratio": 0.0, "density": 1.0}
    low = ElasticSolid(rectangle((1, 1), (1.0, 1.0)), fixed=["base"], name="low", **kind)
    mesh = rectangle((1, 1), (1.0, 1.0))
    mesh.mesh.geometry.x[:, 1] += 1.0
    up = ElasticSolid(
        mesh,
        prescribed={"left": (0.0, None)},
        body_force=lambda t: (0.0, 1e4 * t),
        name="up",
        **kind,
    )
    contacts = [
        Contact(up, "base", (low, "top"), "gap", name="joint"),
        Contact(up, "top", HalfSpace((0, 2), (0, -1)), "gap", name="head"),
    ]
    history = Scene([low, up], contacts, QuasiStatic()).run(1.0, 1.0 / steps)
    assert history.finished
    assert history["head.force_y"][-1] == pytest.approx(-1e4, rel=1e-9)
    assert history["newton"].max() <= 3


def test_what_takes_the_least_way_holds_first(monkeypatch):
    """Of a block 1 mm above a floor and 0.1 m beside a wall: with friction the floor alone, if
    that is enough for its load."""
    mesh = rectangle((2, 2), (0.2, 0.2))
    mesh.mesh.geometry.x[:, 1] += 1e-3
    glued, taken = [], Grip.taken
    monkeypatch.setattr(Grip, "taken", lambda *a: glued.append(taken(*a)) or glued[-1])
    for friction, leans, walls in ((0.3, 0.2, False), (0.3, 0.4, True), (0.0, 0.2, True)):
        solid = ElasticSolid(
            mesh, youngs_modulus=1e6, poisson_ratio=0.3, density=1.0, gravity=(9.81 * leans, -9.81)
        )
        contacts = [
            Contact(solid, "base", FLOOR, "gap", friction=friction, name="floor"),
            Contact(solid, "right", HalfSpace((0.2, 0), (-1, 0)), "gap", name="wall"),
        ]
        scene = Scene([solid], contacts, QuasiStatic())
        scene.run(1.0, 1.0)
        floor, wall = glued.pop(0)
        glued.clear()
        assert (floor > 0).any() and (wall > 0).any() == walls


def block(hyperelastic=False, height=0.0, **others):
    mesh = rectangle((3, 3), (1.0, 1.0))
    mesh.mesh.geometry.x[:, 1] += height
    if hyperelastic:
        return HyperelasticSolid(mesh, energy=neo_hookean(1e6, 0.3), density=1000.0, **others)
    others |= {"youngs_modulus": 1e6, "poisson_ratio": 0.3}
    return ElasticSolid(mesh, density=1000.0, **others)


@pytest.mark.parametrize("law", ["gap", "velocity"])
@pytest.mark.parametrize("hyperelastic", [False, True])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_a_block_is_lifted_to_the_ceiling_and_falls(friction, hyperelastic, law):
    """Its load turns round, and one step ends without any, where every place between is one of
    equilibrium: what bore stays where it was. It stopped there."""
    held = {} if friction else {"prescribed": {(-0.5, 0.0): (0.0, None)}}
    solid = block(
        hyperelastic, tractions={"top": lambda t: (0.0, -3e3 * np.cos(2 * np.pi * t))}, **held
    )
    contacts = [
        Contact(solid, "base", FLOOR, law, friction=friction, name="floor"),
        Contact(solid, "top", HalfSpace((0, 1.05), (0, -1)), law, friction=friction, name="lid"),
    ]
    history = Scene([solid], contacts, QuasiStatic()).run(1.0, 0.05)
    assert history.finished and not history.remarks
    load = 3e3 * np.cos(2 * np.pi * history["time"][1:])
    borne = (history["floor.force_y"] + history["lid.force_y"])[1:]
    np.testing.assert_allclose(borne, load, atol=1e-5)
    assert (history["floor.force_y"] >= 0).all() and (history["lid.force_y"] <= 0).all()
    assert history["newton"].max() <= 10


@pytest.mark.parametrize(("friction", "gap"), [(0.0, 0.0), (0.0, 0.01), (0.3, 0.01), (0.8, 0.01)])
def test_a_block_is_pushed_to_and_fro_between_walls(friction, gap):
    """To one wall, across the gap to the other, and on: as symmetric as the load."""
    solid = block(tractions={"top": lambda t: (2e3 * np.sin(2 * np.pi * t), -3e3)})
    contacts = [
        Contact(solid, "base", FLOOR, "gap", friction=friction, name="floor"),
        Contact(solid, "left", HalfSpace((-0.5 - gap, 0), (1, 0)), friction=friction, name="left"),
        Contact(
            solid, "right", HalfSpace((0.5 + gap, 0), (-1, 0)), friction=friction, name="right"
        ),
    ]
    history = Scene([solid], contacts, QuasiStatic()).run(1.0, 0.05)
    assert history.finished and not history.remarks
    across = sum(history[f"{name}.force_x"] for name in ("floor", "left", "right"))[1:]
    np.testing.assert_allclose(across, -2e3 * np.sin(2 * np.pi * history["time"][1:]), atol=1e-5)
    to, fro = -history["right.force_x"].min(), history["left.force_x"].max()
    assert to == pytest.approx(fro, rel=1e-9 if not friction else 1e-2)
    assert history["newton"].max() <= 10


@pytest.mark.parametrize("law", ["gap", "velocity"])
@pytest.mark.parametrize("hyperelastic", [False, True])
@pytest.mark.parametrize("below", ["lifted", "heavy"])
def test_two_blocks_are_lifted_off_what_bore_them_in_one_step(below, hyperelastic, law):
    """The upper one strikes the ceiling 1 cm above; the lower is lifted with it, or stays by its
    weight. All that may bear was glued, and blocks hung between floor and ceiling: 44 to 123
    iterations in that step, and steps of a thousandth."""
    up = {"low": (0.0, 2e3) if below == "lifted" else (0.0, 0.0), "high": (150.0, 5e3)}

    def load(name, before):
        return lambda t: before if t <= 0.5 else up[name]

    weight = 1.0 if below == "heavy" else 0.0
    low = block(
        hyperelastic, tractions={"base": load("low", (0, 0))}, gravity=(0, -weight), name="low"
    )
    high = block(hyperelastic, 1.0, tractions={"top": load("high", (150.0, -3e3))}, name="high")
    lid = HalfSpace((0, 2.01), (0, -1))
    contacts = [
        Contact(low, "base", FLOOR, law, friction=0.3, name="floor"),
        Contact(high, "base", (low, "top"), law, friction=0.3, name="joint"),
        Contact(high, "top", lid, law, friction=0.3, name="lid"),
    ]
    history = Scene([low, high], contacts, QuasiStatic()).run(1.0, 0.1)
    assert history.finished and history["newton"].max() <= 8
    lifted = 2e3 if below == "lifted" else 0.0
    for name, force in {"floor": 1e3 * weight, "joint": lifted, "lid": -5e3 - lifted}.items():
        assert history[f"{name}.force_y"][-1] == pytest.approx(force, rel=1e-6, abs=1e-4)


@pytest.mark.parametrize("steps", [20, 40])
def test_what_round_off_alone_lets_bear_begins_open(steps):
    """A block that is pushed, lifted and set down: 40 steps took 32 iterations where 20 took 4."""
    solid = block(
        tractions={
            "top": lambda t: (1e2 * np.cos(2 * np.pi * t), -3e3 * np.cos(2 * np.pi * t)),
        }
    )
    contacts = [
        Contact(solid, "base", FLOOR, "gap", friction=0.3, name="floor"),
        Contact(solid, "top", HalfSpace((0, 1.05), (0, -1)), "gap", friction=0.3, name="lid"),
    ]
    history = Scene([solid], contacts, QuasiStatic()).run(1.0, 1.0 / steps)
    assert history.finished and history["newton"].max() <= 8
    borne = (history["floor.force_y"] + history["lid.force_y"])[1:]
    np.testing.assert_allclose(borne, 3e3 * np.cos(2 * np.pi * history["time"][1:]), atol=1e-5)


def test_springs_behind_gaps_find_their_least_work():
    """Forces that push balance the load; springs that say the same, few springs, and stiffnesses
    and gaps of three decades do not matter."""
    rng = np.random.default_rng(1)
    for _ in range(500):
        n, m = rng.integers(1, 40), rng.integers(1, 13)
        rows = np.repeat(rng.normal(size=(n, m)), rng.integers(1, 4), axis=0)
        springs = 10.0 ** rng.uniform(-3, 0, len(rows))
        room = rng.integers(2) * rng.normal(size=len(rows)).clip(0) * 10.0 ** rng.uniform(-3, 3)
        load = -rows.T @ rng.uniform(-1, 1, len(rows)).clip(0)
        load /= max(np.abs(load).max(), 1e-300)
        motion = least_work(rows, springs / springs.max(), room, load)
        force = springs / springs.max() * (rows @ motion - room).clip(0)
        np.testing.assert_allclose(rows.T @ force, -load, atol=1e-8)
    assert least_work(np.eye(2), np.ones(2), np.zeros(2), np.array([1.0, 0.0])) is None


def test_stiff_springs_rub_on_a_drum():
    """A block is pressed on it and sheared: by default all at once was solved, of which one spring
    of 1e10 Pa/m that turned round made the first step that slides stop."""

    def sheared(law):
        mesh = rectangle((8, 12), (0.02, 0.03))
        motion = {"top": lambda t: (0.004 * max(0.0, t - 0.2), -0.001 * min(1.0, 5 * t))}
        solid = ElasticSolid(
            mesh, youngs_modulus=1e6, poisson_ratio=0.4, density=1e3, prescribed=motion
        )
        contact = Contact(solid, "base", Circle((0, -0.05), 0.05), law, friction=0.3, name="c")
        history = Scene([solid], [contact], QuasiStatic()).run(1.0, 0.1)
        assert history.finished and not history.remarks and history["newton"].max() <= 25
        return np.array([history["c.force_x"][-1], history["c.force_y"][-1]])

    gap, soft, stiff = (sheared(law) for law in ("gap", Discrete(1e8), Discrete(1e10)))
    np.testing.assert_allclose(stiff, gap, rtol=1e-4)
    np.testing.assert_allclose(soft, gap, rtol=1e-2)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("spring", [1e-8, 1e-6, 1e-4, 1e-2])
def test_weak_springs_change_nothing_where_friction_holds(dim, spring):
    """A block that is pressed and drawn aside, so that it sticks, on a slab twice as wide: without
    friction the springs would let it go off that, to which a step does not leap."""

    def drawn(springs):
        size = (2.0,) * (dim - 1)
        low = (rectangle if dim == 2 else box)((4,) * (dim - 1) + (2,), (*size, 1.0))
        up = (rectangle if dim == 2 else box)((2,) * dim, (1.0,) * dim)
        up.mesh.geometry.x[:, dim - 1] += 1.0
        load = 2e-2 * (0.1 * np.eye(dim)[0] - np.eye(dim)[-1])
        data = {"poisson_ratio": 0.3, "density": 1.0}
        slab = ElasticSolid(
            low, youngs_modulus=1.0, prescribed={"base": (0.0,) * dim}, name="slab", **data
        )
        held = {"springs": {"top": springs}} if springs else {}
        block = ElasticSolid(
            up, youngs_modulus=3.0, tractions={"top": load}, name="block", **held, **data
        )
        contact = Contact(block, "base", (slab, "top"), "gap", friction=0.3, name="c")
        history = Scene([slab, block], [contact], QuasiStatic()).run(until=1.0, dt=1.0)
        assert history.finished and not history.remarks
        assert history["newton"].max() <= 15
        return contact.force.sum(axis=0)

    np.testing.assert_allclose(drawn(spring), drawn(0.0), rtol=10 * spring, atol=10 * spring * 2e-2)


@pytest.mark.parametrize(
    ("wall", "law", "theta", "geometry"),
    [
        (Circle((0, -0.1), 0.1), "gap", None, "newton"),
        (Circle((0, -0.1), 0.1), "velocity", None, "newton"),
        (Circle((0, -0.1), 0.1), Discrete(1e10), None, "fixed point"),
        (Circle((0, -0.1), 0.1), "gap", 1.0, "mixed"),
        (HalfSpace((0, 0), (0, 1)), "gap", None, "fixed point"),
        (Box((0, -0.5), (0.4, 1.0)), "gap", None, "mixed"),
        (Box((0, -0.5), (0.4, 1.0), rounding=0.1), "gap", None, "mixed"),
    ],
    ids=["gap", "velocity", "springs", "in motion", "flat", "edges", "round edges"],
)
def test_geometry_within_newtons_method_where_statics_are_before_what_is_curved(
    wall, law, theta, geometry
):
    block = ElasticSolid(
        rectangle((4, 2)), youngs_modulus=1e6, poisson_ratio=0.3, density=1.0, fixed="top"
    )
    scheme = QuasiStatic() if theta is None else ThetaScheme(theta)
    assert Scene([block], [Contact(block, "base", wall, law)], scheme).geometry == geometry


def test_a_block_drawn_over_a_drum_takes_few_iterations():
    """By fixed point it took 2584, or stopped."""
    solid = HyperelasticSolid(
        rectangle((24, 12), (1.0, 0.5)),
        energy=neo_hookean(1e6, 0.3),
        density=1e-3,
        prescribed={"top": lambda t: (0.3 * max(0.0, t - 0.2), -0.08 * min(1.0, 5 * t))},
    )
    contact = Contact(solid, "base", Circle((0.0, -0.1), 0.1), "gap", friction=0.3)
    history = Scene([solid], [contact], QuasiStatic()).run(until=1.0, dt=0.02)
    assert history.finished and history["newton"].sum() < 250


@pytest.mark.parametrize("law", ["gap", "velocity"])
@pytest.mark.parametrize("gap, exchanged", [(0.08, False), (0.2, False), (1.0, False), (0.2, True)])
def test_what_is_held_by_another_solid_alone_comes_from_afar(gap, law, exchanged):
    """Partners were sought over one and a half facets: "no equilibrium", beyond."""

    def block(cells, size, up, name, **solid):
        mesh = rectangle(cells, size)
        mesh.mesh.geometry.x[:, 1] += up
        return ElasticSolid(
            mesh, youngs_modulus=1e6, poisson_ratio=0.3, density=1.0, name=name, **solid
        )

    low = block((40, 5), (2.0, 0.5), -0.5, "low", fixed=["base"])
    up = block((10, 10), (0.5, 0.5), gap, "up", body_force=lambda t: (0, -1e3 * t))
    sides = [(up, "base"), (low, "top")][:: -1 if exchanged else 1]
    contact = Contact(*sides[0], sides[1], law, friction=0.3, name="pair")
    history = Scene([low, up], [contact], QuasiStatic()).run(until=1, dt=0.2)
    assert history.finished, history.reason
    assert abs(history["pair.force_y"][-1]) == pytest.approx(250.0, rel=1e-9)


#: Blocks from below: where the middle is, width, height, lowest point, cells, Young's modulus,
#: Poisson's ratio, degree, whether hyperelastic, weight by volume; traction on the last; law, mu.
STACKS = {
    "apart": (
        [
            (0.0, 0.5713, 0.62588, 0.0, (2, 3), "quadrilateral", 8.38e8, 0.3, 1, False, 1e4),
            (-0.1695, 0.6578, 0.60559, 0.62598, (5, 2), "triangle", 6.886e5, 0.45, 1, True, 0.0),
            (0.0, 0.7724, 0.77249, 1.23167, (5, 1), "quadrilateral", 5.77e6, 0.3, 2, False, 0.0),
        ],
        (277.032, -4617.2),
        "gap",
        0.2,
    ),
    "in touch": (
        [
            (0.0, 0.6594, 0.3226, 0.0, (1, 3), "quadrilateral", 2.07e5, 0.45, 1, True, 1e4),
            (0.0, 0.8240, 0.3325, 0.3226, (1, 5), "triangle", 6.117e6, 0.3, 1, False, 0.0),
            (0.0, 0.9100, 0.7490, 0.6551, (3, 1), "quadrilateral", 5.346e8, 0.45, 1, True, 0.0),
        ],
        (0.0, -7930.1),
        "lagrange",
        0.2,
    ),
    "on a soft one": (
        [
            (0.0, 1.0797, 0.7885, 0.0, (3, 4), "quadrilateral", 8.76e5, 0.3, 2, False, 876.0),
            (0.0, 0.5245, 0.3566, 0.7885, (5, 5), "triangle", 1.794e5, 0.3, 1, False, 0.0),
            (0.0, 1.0731, 0.3717, 1.1451, (4, 2), "triangle", 4.11e6, 0.3, 1, False, 179.4),
            (0.0979, 1.1066, 0.4440, 1.5169, (3, 1), "triangle", 3.806e8, 0.45, 2, False, 0.0),
        ],
        (0.0, -183.7),
        "gap",
        0.1,
    ),
    "slender": (
        [
            (0.0, 0.5286, 0.75385, 0.0, (1, 3), "triangle", 3.183e5, 0.0, 1, False, 0.0),
            (0.06764, 0.9094, 0.57279, 0.75395, (5, 5), "triangle", 1.463e5, 0.45, 2, False, 0.0),
            (0.001, 1.2550, 0.36481, 1.32684, (1, 5), "quadrilateral", 4.048e7, 0.0, 1, False, 0.0),
            (
                0.0,
                1.0985,
                0.78234,
                1.69175,
                (5, 1),
                "quadrilateral",
                4.589e8,
                0.45,
                2,
                False,
                146.3,
            ),
            (0.0525, 0.6733, 0.5446, 2.47409, (2, 5), "triangle", 1.572e7, 0.0, 1, False, 146.3),
        ],
        (133.0, -4433.4),
        "velocity",
        0.1,
    ),
}


@pytest.mark.parametrize("which", STACKS)
def test_stacks_that_nothing_but_contact_holds(which):
    """Corrections after contact had settled led astray what it held, until surfaces saw each other
    no more; from there no equilibrium was found, and none was said to be. Or the method of
    multipliers asked of each of its problems more digits than there were."""
    blocks, traction, law, friction = STACKS[which]
    solids, contacts, weight = [], [], 0.0
    for i, (middle, width, height, low, n, cell, E, nu, degree, large, heavy) in enumerate(blocks):
        mesh = rectangle(n, (width, height), cell)
        mesh.mesh.geometry.x[:, :2] += (middle, low)
        last = {"tractions": {"top": traction}} if i == len(blocks) - 1 else {}
        more = {"density": 1e3, "degree": degree, "body_force": (0.0, -heavy), "name": f"{i}"}
        if large:
            solid = HyperelasticSolid(mesh, energy=neo_hookean(E, nu), **more, **last)
        else:
            solid = ElasticSolid(mesh, youngs_modulus=E, poisson_ratio=nu, **more, **last)
        below = (solids[-1], "top") if solids else FLOOR
        contacts.append(Contact(solid, "base", below, law, friction, name=f"below {i}"))
        solids.append(solid)
        weight += heavy * width * height
    history = Scene(solids, contacts, QuasiStatic()).run(1.0, 1.0)
    assert history.finished, history.reason
    area = blocks[-1][1]
    assert history["below 0.force_y"][-1] == pytest.approx(weight - area * traction[1], rel=1e-6)
    assert history["below 0.force_x"][-1] == pytest.approx(-area * traction[0], abs=1e-6 * weight)
