# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the stability maps found to be wrong, each mended and held by a test."""

from dataclasses import replace

import numpy as np
import pytest
from corpus_meshes import moved
from problems import bar_at_wall, rocking, sliding_elastic, squeezed, stacked
from scenes import FLOOR, G, box, rectangle

from fenicsx_contact import (
    Contact,
    Discrete,
    ElasticSolid,
    GeneralisedAlpha,
    HalfSpace,
    Heap,
    HyperelasticSolid,
    InputError,
    Moved,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    name_facets,
    neo_hookean,
)
from fenicsx_contact.solve.equilibrium import unbearable
from fenicsx_contact.theory.scheme import Step


def test_free_jumps_that_are_round_off():
    # a node that the wall has stopped, behind it a bar that still moves at 10 m/s: without
    # contact nothing would happen to it in an explicit step, but for 1e-13 m/s
    problem = bar_at_wall(cells=20, cfl=0.1, theta=0.0, allow_growth=True)
    # until the growth that is allowed, 1e8 of the energy, throws the bar through the wall
    history = replace(problem, until=0.5).run()
    assert history.finished
    assert all("no contact names" in remark for _, remark in history.remarks)  # it is thrown


@pytest.mark.parametrize(
    "setting",
    [
        {"youngs_modulus": 1e16, "poisson_ratio": 0.4999},
        {"aspect": 1e3},
        {"periods": 1e3},
    ],
)
def test_forces_that_balance_each_other(setting):
    problem = squeezed(**setting)
    history = problem.run()
    assert history.finished and not history.remarks
    assert history["newton"].max() <= 10
    assert problem.error(history) < problem.bound


@pytest.mark.parametrize("speed", [1e-6, 1.0, 1e6])
def test_hyperelastic_solid_in_flight_without_forces(speed):
    solid = HyperelasticSolid(
        rectangle((2, 2)),
        energy=neo_hookean(1e6, 0.3),
        density=1000.0,
        velocity=lambda x: np.stack([0.3 * speed + 0 * x[0], speed + 0 * x[1]]),
    )
    contact = Contact(solid, "base", HalfSpace((0, -1), (0, 1)))
    history = Scene([solid], [contact]).run(0.1, 0.01)
    assert history.finished and not history.remarks
    np.testing.assert_allclose(solid.velocity.reshape(-1, 2), [[0.3 * speed, speed]] * 9, rtol=1e-9)


def test_a_tilt_of_10_nanoradians():
    # the corner is lifted by 4 nm: less than ten of the former gap tolerances
    problem = rocking(tilt=1e-8, share=0.01)
    history = problem.run()
    assert history.finished
    assert problem.error(history) < problem.bound < 0.2


def test_a_stiff_solid_that_travels_keeps_its_digits():
    # K u of a translation u of 1 m is 1 N of round-off at 1e16 Pa; it made 7 J of strain energy
    history = sliding_elastic(youngs_modulus=1e16, share=0.01).run()
    assert history.finished
    assert history["strain"].max() < 1e-8 * history["kinetic"][0]


@pytest.mark.parametrize("forces", ["theta", "end"])
def test_a_scheme_that_makes_energy_is_refused(forces):
    with pytest.raises(InputError, match=r"theta = 0\.49.*allow_growth"):
        bar_at_wall(cells=4, theta=0.49, forces=forces)
    assert bar_at_wall(cells=4, theta=0.49, forces=forces, allow_growth=True).run().finished


@pytest.mark.parametrize("share", [1 / 8, 0.12498])
def test_an_impact_at_the_end_of_a_step_is_located(share):
    # a step ends with the corner 1 µm above the floor, where finite rotation counts it as closed;
    # the next one took it through its whole length, and 57 % of the third maximum were lost
    problem = rocking(tilt=1e-2, share=share, located=True)
    assert problem.error(problem.run()) < 0.01


@pytest.mark.parametrize("dt", [1e-4, 1e-6])
@pytest.mark.parametrize("mass_ratio", [1e-3, 1.0, 1e2])
def test_blocks_that_rest_on_each_other_in_short_steps(dt, mass_ratio):
    # gaps of 1e-16 m open faster, in steps of 1 µs, than weights close them: forces were off by
    # 4e-7, relative speeds of 1e-12 m/s were taken for impacts, and runs stopped
    problem = stacked(mass_ratio=mass_ratio, dt=dt)
    history = problem.run()
    assert history.finished and not history.remarks
    assert (history["dt"][1:] > 0).all()
    assert problem.error(history) < problem.bound


@pytest.mark.parametrize("tangential", [1e-6, 1e-4])
def test_friction_rows_that_are_augmented_by_next_to_nothing(tangential):
    # the certificate took a row that says what a multiplier is for a speed: times 1e8 and more
    problem = sliding_elastic(normal_augmentation=1e4, tangential_augmentation=tangential)
    assert problem.error(problem.run()) < problem.bound


@pytest.mark.parametrize("ratio", [1e4, 1e5])
@pytest.mark.parametrize("friction", [0.0, 0.5])
@pytest.mark.parametrize("heap", [False, True])
def test_a_heavy_block_on_a_light_one(ratio, friction, heap):
    """How forces through the light one change says little of it and all of the heavy one: careful
    steps, which yield, came no nearer, and runs stopped as they began."""
    skin = {"skin": lambda x: np.full(x.shape[1], True)}
    meshes = [moved(rectangle((1, 1), (1.0, 1.0)), *at) for at in ((0, 0), (0.1, 1))]
    meshes = [name_facets(mesh.mesh, skin) for mesh in meshes] if heap else meshes
    given = zip(meshes, (1.0, ratio), ("light", "heavy"))
    below, above = (RigidSolid(m, mass=w, gravity=(0, -G), name=n) for m, w, n in given)
    contacts = [Contact(below, "skin" if heap else "base", FLOOR, friction=friction, name="floor")]
    if heap:
        contacts.append(Heap([below, above], "skin", friction=friction))
    else:
        contacts.append(Contact(above, "base", (below, "top"), friction=friction, name="pair"))
    history = Scene([below, above], contacts, ThetaScheme(1.0)).run(until=0.05, dt=2e-3)
    assert history.finished, history.reason
    assert max(np.abs(body.velocity).max() for body in (below, above)) < 1e-6 * G * 2e-3
    assert history["floor.force_y"][-1] == pytest.approx((1 + ratio) * G, rel=1e-6)


@pytest.mark.parametrize(
    ("light", "heavy", "belt", "pressing"),
    [(1e-3, 1.0, 1e-4, 1e4), (1.0, 1e3, 1e-6, 1e6), (1e-2, 10.0, 1e-4, 1e4)],
)
def test_a_shim_between_a_belt_and_a_plate(light, heavy, belt, pressing):
    """It rides on the belt and slides below the plate. Points of it that stuck to both contradict
    each other, slowly over the speeds of this step: taken for round-off, half of the friction."""
    shim = RigidSolid(rectangle((1, 1), (1.0, 0.01)), mass=light, held=["turning"], name="shim")
    over = moved(rectangle((1, 1), (1.0, 0.1)), 0, 0.01)
    held = {"held": ["x", "turning"], "name": "plate"}
    plate = RigidSolid(over, mass=heavy, force=(0, -pressing), **held)
    moving = Moved(FLOOR, lambda t: (belt * t, 0.0))
    below = Contact(shim, "base", moving, friction=0.2, name="belt")
    above = Contact(shim, "top", (plate, "base"), friction=0.1, name="pair")
    history = Scene([shim, plate], [below, above], ThetaScheme(1.0)).run(until=10.0, dt=1.0)
    assert history.finished, history.reason
    assert history["belt.force_x"][1:] == pytest.approx(0.1 * pressing, rel=1e-8)
    resolved = 1e-10 * pressing / heavy  # speeds, m/s, of those without contact
    assert shim.place[0] == pytest.approx(10 * belt, rel=1e-9, abs=10 * resolved)


@pytest.mark.parametrize("law", ["velocity", "gap"])
@pytest.mark.parametrize("master", ["die", "block"])
def test_a_die_of_hardly_any_mass_on_a_soft_block(law, master):
    """What holds it is what the block yields, whatever it weighs: multipliers were scaled by what
    would stop it alone, by which 1e-6 kg had no end in two minutes, and 1e-10 were 5 % off."""
    held = ["x", "y", "turning about x", "turning about y", "turning about z"]
    depths, works = [], []
    for mass in (1.0, 1e-2, 1e-6, 1e-9):
        mesh = box((4, 4, 2), (1.0, 1.0, 0.4))
        block = ElasticSolid(
            mesh, youngs_modulus=2e6, poisson_ratio=0.3, density=1e3, fixed="base", name="block"
        )
        shape = box((2, 2, 1), (0.44, 0.44, 0.2))
        shape.mesh.geometry.x[:, 2] += 0.4
        force = lambda t: (0.0, 0.0, -2e3 * min(2 * t, 1.0))  # noqa: E731
        die = RigidSolid(shape, mass=mass, force=force, held=held, name="die")
        sides = [(block, "top"), (die, "base")]
        slave, other = sides if master == "die" else sides[::-1]
        contact = Contact(*slave, other, law, friction=0.4, name="c")
        history = Scene([block, die], [contact], ThetaScheme(1.0)).run(1.0, 0.25, progress=False)
        assert history.finished and not history.remarks, history.reason
        assert history["c.force_z"][-1] == pytest.approx((1, -1)[master == "die"] * 2e3, rel=1e-8)
        depths.append(die.place[2])
        works.append(history["newton"].sum())
    start = depths[0]
    assert depths == pytest.approx([start] * 4, abs=1e-6 * (0.5 - start))
    assert max(works) <= 3 * min(works)


@pytest.mark.parametrize("ratio", [1e-5, 1e-6, 1e-8])
def test_a_light_die_is_thrown_on_a_soft_block(ratio):
    """Full Newton leapt: by 1e-6 of its mass "momentum balance stalls" after 50 s."""
    block = ElasticSolid(
        box((3, 3, 2), (0.6, 0.6, 0.3)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1e3,
        fixed="base",
        name="block",
    )
    shape = box((2, 2, 1), (0.3, 0.3, 0.1))
    shape.mesh.geometry.x[:] += 0.02, 0.01, 0.3
    die = RigidSolid(shape, mass=108 * ratio, velocity=(0.2, 0, -0.5), name="die")
    contact = Contact(die, "base", (block, "top"), "gap", friction=1.0, name="c")
    history = Scene([block, die], [contact], ThetaScheme(1.0)).run(6e-4, 1e-4, progress=False)
    assert history.finished and history["newton"].sum() < 80, history.reason


@pytest.mark.parametrize("kind", [ElasticSolid, HyperelasticSolid])
@pytest.mark.parametrize(
    "scheme", [ThetaScheme(1.0), GeneralisedAlpha(0.8)], ids=["theta", "alpha"]
)
def test_a_stiff_block_that_friction_holds_does_not_creep(kind, scheme):
    """Steel, 10 mm, 10 MPa on it, pushed by 40 % of what friction bears, by steps of (omega dt)² =
    1e10: round-off of its rigid motion made it creep by 23 µm in 0.7 s, 45 times its compression,
    and friction took 0.6 J, "finished"."""
    material = {"youngs_modulus": 200e9, "poisson_ratio": 0.3}
    if kind is HyperelasticSolid:
        material = {"energy": neo_hookean(200e9, 0.3)}
    load = lambda t: (2e6 * min(1.0, t / 0.2), -1e7)  # noqa: E731
    block = kind(
        rectangle((6, 6), (0.01, 0.01)), density=7850.0, tractions={"top": load}, **material
    )
    contact = Contact(block, "base", FLOOR, friction=0.5, name="c")
    base = np.isclose(block.vectors.places[:, 1], 0.0)
    probes = {"x": lambda: np.mean(block.displacement.reshape(-1, 2)[base, 0])}
    history = Scene([block], [contact], scheme).run(0.6, 0.01, probes=probes)
    assert history.finished and not history.remarks
    held = history["x"][history.time > 0.25]  # its loads alone give it 2e-9 m a step of 1e-10
    assert np.ptp(held) < 5e-9 and abs(history["friction"][-1]) < 2e4 * 5e-9  # of 20 kN


@pytest.mark.parametrize("share", [1.0, 0.1])
@pytest.mark.parametrize("kind", [ElasticSolid, HyperelasticSolid])
def test_what_rests_and_is_pressed_elsewhere(kind, share):
    """A block at rest on a floor, pressed at its top from t = 0: each implicit step brings its base
    a speed below the round-off of its own solves, by which alone residuals were judged."""
    material = {"youngs_modulus": 210e9, "poisson_ratio": 0.3}
    if kind is HyperelasticSolid:
        material = {"energy": neo_hookean(210e9, 0.3)}
    block = kind(
        rectangle((20, 20), (0.1, 0.1)), density=7800.0, tractions={"top": (0, -1e6)}, **material
    )
    speed = np.sqrt(210e9 * 0.7 / 1.3 / 0.4 / 7800)
    contact = Contact(block, "base", FLOOR, name="c")
    history = Scene([block], [contact]).run(8 * share * 0.005 / speed, share * 0.005 / speed)
    assert history.finished and not history.remarks


@pytest.mark.parametrize(
    "form, scheme, geometry",
    [
        ("velocity", ThetaScheme(0.5), "newton"),
        ("velocity", ThetaScheme(1.0), "newton"),
        ("velocity", ThetaScheme(0.5), "fixed point"),
        ("gap", GeneralisedAlpha(0.8), "newton"),
        (Discrete(stiffness=10.0), ThetaScheme(0.5), "newton"),
    ],
)
def test_a_pulse_crosses_from_bar_to_bar(form, scheme, geometry):
    """Bars that touch, at rest, one pushed at its far end from t = 0. By forces at the contact that
    were round-off of gaps the second one was out of balance."""
    given = {"youngs_modulus": 1.0, "poisson_ratio": 0.0, "density": 1.0}
    push = {"tractions": {"left": (0.01, 0.0)}}
    bars = [
        ElasticSolid(moved(rectangle((50, 1), (1.0, 0.1)), x, 0.0), name=name, **given, **load)
        for x, name, load in ((0.0, "first", push), (1.0, "second", {}))
    ]
    contact = Contact(bars[0], "right", (bars[1], "left"), form, name="c")
    history = Scene(bars, [contact], scheme, geometry=geometry).run(1.8, 0.02)
    assert history.finished and not history.remarks and len(history) == 91
    pressure = -history["c.force_x"] / 0.1
    assert np.abs(pressure[history.time < 0.6]).max() < 1e-4
    assert abs(pressure[history.time > 1.3].mean() / 0.01 - 1) < 0.02


@pytest.mark.parametrize("held", [(), "base"])
def test_a_balance_that_is_not_a_number_does_not_hold(held):
    """Of an element that is inverted: terms, or the reactions only, that are NaN."""
    solid = HyperelasticSolid(
        rectangle(), energy=neo_hookean(1e6, 0.3), density=1000.0, fixed=held, gravity=(0, -1e-9)
    )
    step = Step(0.01, ThetaScheme(1.0))
    solid.predict(step)
    solid.go(np.tile([0.0, -200.0], 4) * (solid.vectors.places[:, 1] > 0).repeat(2), step)
    assert solid.broken()
    for noise in (0.0, 1e9):
        assert np.isnan(solid.imbalance(step, noise))


def test_a_horseshoe_bent_beyond_itself_stops():
    """Its ends are moved past each other, which nothing could: an inverted element, all strains
    NaN, was a row, certified with an error of 2e-21. Nodes beside them bear for them, and tell."""
    mesh = rectangle((24, 2), (1.0, 1.0), "triangle")
    x, turn = mesh.mesh.geometry.x, 0.5 * np.pi
    s, r = (x[:, 0] + 0.5) * (3 + turn), 0.5 + 0.3 * x[:, 1]
    angle = np.clip(2 * (s - 1.5), 0, np.pi)
    straight = np.where(s < 1.5, 1.5 - s, s - 1.5 - turn)
    x[:, 0] = np.where((angle > 0) & (angle < np.pi), -r * np.sin(angle), straight)
    x[:, 1] = r * np.cos(angle)
    ends = {"left": lambda t: (0, -0.5 * t), "right": lambda t: (0, 0.5 * t)}
    solid = HyperelasticSolid(mesh, energy=neo_hookean(100.0, 0.3), density=1.0, prescribed=ends)
    contact = Contact(solid, "base", (solid, "base"), "gap", friction=0.2)
    history = Scene([solid], [contact], QuasiStatic()).run(1.5, 0.05)
    assert "is inverted" in history.reason or "goes through what it meets" in history.reason
    assert np.isfinite(history.rows()).all() and 1.0 < history.time[-1] < 1.2
    assert history["hyperelastic.base.penetration"].max() < 0.1  # half of a facet


@pytest.mark.parametrize("load", [0.0, 1e-6])
def test_round_off_is_no_load(load):
    """A strained block on a smooth floor: internal forces of 1e3 N sum up to 1e-13 N, against which
    no floor was said to hold it; what really acts along it is named, however small."""
    block = HyperelasticSolid(
        rectangle((4, 4), (1.0, 1.0)),
        energy=neo_hookean(1e5, 0.3),
        density=1.0,
        gravity=(load, 0.0),
        displacement=lambda x: 0.03 * np.stack([np.sin(5 * x[0] + x[1]), np.cos(7 * x[1] - x[0])]),
        name="block",
    )
    contact, step = Contact(block, "base", FLOOR, "gap"), Step(0.1, QuasiStatic())
    block.predict(step)
    contact.begin(step)
    contact.predict(step, True)
    block.linearise(step)
    contact.linearise(step)
    said = unbearable([block], [contact], step)
    assert said == (
        bool(load) * "no equilibrium: contacts cannot hold 'block' against moving along x"
    )
