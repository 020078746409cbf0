# SPDX-License-Identifier: LGPL-3.0-or-later
"""Impacts located within a step: exact instants, second order, many points, rest."""

from math import radians

import numpy as np
import pytest
from scenes import FLOOR, G, rectangle

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    InputError,
    Restitution,
    RigidSolid,
    Scene,
    ThetaScheme,
    neo_hookean,
)
from fenicsx_contact.references.housner import Block, rocking
from fenicsx_contact.theory.scheme import Step

BLOCK = Block(width=0.36, height=0.80, mass=417.6)


def rock(angle, until, steps):
    """Ten impacts: errors of the kinetic energy just before each, and of its time."""
    block = RigidSolid(
        rectangle(), mass=417.6, gravity=(0, -9.81), rotation=angle, about=(-0.18, 0)
    )
    contact = Contact(block, "base", FLOOR, friction=0.9)
    history = Scene([block], [contact], locate_impacts=True).run(until, until / steps)
    assert history.finished and not history.remarks
    exact = rocking(BLOCK, angle, impacts=10)
    impacts = np.flatnonzero(history["dt"] == 0)[1:11]  # the first row is the initial state
    kinetic = history["kinetic"][impacts - 1] / exact.kinetic_before - 1
    time = history.time[impacts] / exact.impact_times - 1
    return history, np.abs(kinetic).max(), np.abs(time).max()


@pytest.mark.parametrize(("angle", "until"), [(radians(0.01), 0.0485), (0.01, 0.367)])
def test_rocking_is_of_second_order_between_located_impacts(angle, until):
    errors = np.array([rock(angle, until, n)[1:] for n in (50, 100, 200, 400)])
    assert errors[0].max() < 1e-3
    assert errors[1].max() < 1e-4
    for column in errors.T:
        assert np.polyfit(np.log([8, 4, 2, 1]), np.log(column), 1)[0] > 1.9


@pytest.mark.parametrize("tilt", [radians(0.01), 0.01, 0.1, 0.3])
@pytest.mark.parametrize("steps", [3, 8, 21])
def test_no_false_impacts_in_long_steps(tilt, steps):
    """However few steps there are to an arc: a point that bears does not strike because finite
    rotation lifted it, and one that lifts and comes back within a step does."""
    exact = rocking(BLOCK, tilt, impacts=6)
    until = exact.impact_times[3:5].mean()
    block = RigidSolid(rectangle(), mass=417.6, gravity=(0, -9.81), rotation=tilt, about=(-0.18, 0))
    contact = Contact(block, "base", FLOOR, friction=0.9)
    history = Scene([block], [contact], locate_impacts=True).run(until, until / steps)
    assert history.finished
    impacts = np.flatnonzero(history["dt"] == 0)[1:]
    assert len(impacts) >= 4  # more where so few steps let the block land early
    # each takes the energy that Housner's takes
    kept = history["kinetic"][impacts] / history["kinetic"][impacts - 1]
    np.testing.assert_allclose(kept, BLOCK.energy_ratio, rtol=1e-3 + tilt / 5)


def test_percussion_of_each_impact():
    history, _, _ = rock(0.01, 0.40, 220)
    exact = rocking(BLOCK, 0.01, impacts=10)
    impacts = np.flatnonzero(history["dt"] == 0)[1:11]
    normal = history["rigid.base.force_y"][impacts]
    np.testing.assert_allclose(normal, exact.normal_percussions, rtol=1e-3)
    # the impulse of the contact is the weight's, once it is at rest again
    total = history.impulse("rigid.base")[-1]
    np.testing.assert_allclose(total, [0, 417.6 * 9.81 * 0.40], atol=1e-6 * 1640)


def test_dropped_mass_to_round_off():
    """theta = 1/2 is exact in free fall, so the impact is: percussion m sqrt(2gh)."""
    height = 0.0123
    block = RigidSolid(rectangle(), mass=10.0, gravity=(0, -9.81))
    block.restore({**block.state(), "place": block.place + np.array([0, height])})
    contact = Contact(block, "base", FLOOR)
    history = Scene([block], [contact], locate_impacts=True).run(0.1, 0.01)
    impact = np.flatnonzero(history["dt"] == 0)[1:]
    assert len(impact) == 1
    assert history.time[impact[0]] == pytest.approx(np.sqrt(2 * height / 9.81), rel=1e-10)
    percussion = 10 * np.sqrt(2 * 9.81 * height)
    assert history["rigid.base.force_y"][impact[0]] == pytest.approx(percussion, rel=1e-10)
    np.testing.assert_allclose(history["rigid.base.force_y"][impact[0] + 1 :], 98.1, rtol=1e-9)
    assert history["kinetic"][-1] < 1e-20


def test_a_flat_landing_of_many_points_is_one_impact():
    block = RigidSolid(rectangle(n=(12, 1)), mass=10.0, gravity=(0, -9.81))
    block.restore({**block.state(), "place": block.place + np.array([0, 0.01])})
    contact = Contact(block, "base", FLOOR, friction=0.4)
    history = Scene([block], [contact], locate_impacts=True).run(0.1, 0.01)
    assert history.finished
    assert (history["dt"] == 0).sum() == 2
    assert history["rigid.base.bearing"][-1] > 1
    assert history["kinetic"][-1] < 1e-20


def test_an_impact_looks_ahead():
    """What touches is stopped, what does not may come out as fast as it would arrive."""
    block = RigidSolid(rectangle(), mass=10.0, rotation=0.1, about=(-0.18, 0))
    contact, step = Contact(block, "base", FLOOR), Step(0.0, ThetaScheme(), ahead=0.01)
    block.predict(step)
    block.linearise(step)
    contact.predict(step)
    contact.linearise(step)
    np.testing.assert_allclose(contact.candidates.limit(step), -contact.gap / 0.01, atol=1e-14)
    assert contact.candidates.limit(step).max() == pytest.approx(0.36 * np.sin(0.1) / 0.01)


def test_elastic_impact_keeps_the_books():
    solid = ElasticSolid(
        rectangle(n=(4, 8)),
        youngs_modulus=1e7,
        poisson_ratio=0.3,
        density=1000.0,
        gravity=(0, -9.81),
        displacement=lambda x: np.stack([0 * x[0], 0.01 + 0 * x[0]]),
        velocity=lambda x: np.stack([0 * x[0], -1 + 0 * x[0]]),
    )
    contact = Contact(solid, "base", FLOOR)
    history = Scene([solid], [contact], locate_impacts=True).run(0.03, 5e-4)
    assert history.finished
    assert (history["dt"] == 0).sum() > 1
    energy = history["kinetic"].max()
    assert np.abs(history["balance"]).max() < 1e-10 * energy
    assert np.abs(history["scheme"]).max() < 1e-10 * energy  # theta = 1/2 makes and loses none
    assert history["impact"].max() <= 1e-12 * energy


def test_only_for_the_velocity_law():
    block = RigidSolid(rectangle(), mass=10.0)
    with pytest.raises(InputError, match=r"locate_impacts = True.*gap"):
        Scene([block], [Contact(block, "base", FLOOR, "gap")], locate_impacts=True)


@pytest.mark.parametrize("solver", ["condensed", "monolithic", "iterative"])
@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_what_an_impact_stops_is_solved_by_every_solver(solver, friction):
    """A hyperelastic block that lands flat: nothing at its base moves afterwards, and errors are
    judged by the speed that it had."""

    def land(geometry, solver):
        block = HyperelasticSolid(
            rectangle((3, 3)),
            energy=neo_hookean(1e6, 0.3),
            density=1000.0,
            velocity=lambda x: np.stack([0 * x[0], 0 * x[1] - 2]),
            gravity=(0, -G),
        )
        contact = Contact(block, "base", FLOOR, friction=friction)
        scene = Scene([block], [contact], geometry=geometry, solver=solver)
        history = scene.run(0.01, 1e-3)
        assert history.reason == "finished" and not history.remarks
        return history["kinetic"]

    expected = land("fixed point", "condensed")
    found = land("newton", solver)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * expected[0])


def test_a_percussion_of_a_solid_whose_top_is_driven():
    """The held part goes on with its speed, and the mass that it shares with the rest with it: a
    linear solid is struck as one is that is linearised about any state."""
    struck = []
    for kind, material in (
        (ElasticSolid, {"youngs_modulus": 1e6, "poisson_ratio": 0.3}),
        (HyperelasticSolid, {"energy": neo_hookean(1e6, 0.3)}),
    ):
        block = kind(
            rectangle((3, 3), (0.4, 0.4)),
            density=1000.0,
            velocity=lambda x: np.stack([0.3 + 0 * x[0], -1.0 + 0 * x[0]]),
            prescribed={"top": lambda t: (0.1 * t, -0.2 * t)},
            **material,
        )
        contact = Contact(block, "base", FLOOR, friction=0.2, name="c")
        history = Scene([block], [contact]).run(until=2e-3, dt=1e-3)
        assert history.finished, history.reason
        assert history["dt"][1] == 0 and history["certificate"].max() < 1e-9
        struck.append((history["c.force_x"][1], history["c.force_y"][1]))
    np.testing.assert_allclose(*struck, rtol=1e-8)
    assert struck[0][1] > 0


@pytest.mark.parametrize("restitution", [0.0, 0.5])
@pytest.mark.parametrize("located", [False, True], ids=["uniform", "located"])
@pytest.mark.parametrize("height, dt", [(0.02, 0.02), (1.9e-3, 0.01), (0.3, 0.02), (0.3, 0.01)])
def test_what_comes_to_rest_does_not_do_so_inside(height, dt, located, restitution):
    """A step may stop what its loads can stop, but by the trapezoidal rule that takes a way: up to
    g dt²/2 (1.2 mm of 20 mm) the block came to rest inside the floor, and stayed there."""
    block = RigidSolid(rectangle((1, 1), (0.1, 0.1)), mass=1.0, gravity=(0, -G))
    block.restore({**block.state(), "place": block.place + np.array([0.0, height])})
    law = Restitution(restitution) if restitution else "velocity"
    contact = Contact(block, "base", FLOOR, law, name="c")
    history = Scene([block], [contact], locate_impacts=located).run(1.0, dt)
    assert history.finished and not history.remarks
    # of blows that grow smaller and smaller uniform steps stop what is slower than errors
    rest = 1e-11 if restitution and not located else 1e-12
    assert history["c.penetration"].max() < rest
    assert abs(block.place[1] - 0.05) < max(rest, 1e-12 if located else 1e-6)


def rubbed(second=1.0, angle=0.0):
    """An elastic block is pressed on another one and rubbed to and fro; kinetic energies before and
    after each percussion and step, whatever a second is and however the scene lies."""
    c, s = np.cos(angle), np.sin(angle)
    turn, solids = np.array([[c, -s], [s, c]]), []

    def top(t):
        t = t / second
        return turn @ [0.03 * np.sin(1.7 * max(0.0, t - 1)), -0.02 * min(t, 1.0)]

    driven, held = {"prescribed": {"top": top}}, {"fixed": ["base"], "name": "b"}
    sides = [(7, 1.0, 0.0, 1e3, driven), (9, 2.05, -0.4, 2e3, held)]
    for n, width, below, modulus, support in sides:
        mesh = rectangle((n, 4), (width, 0.4))
        x = mesh.mesh.geometry.x
        x[:, 1] += below
        x[:, :2] = x[:, :2] @ turn.T
        material = {"youngs_modulus": modulus, "poisson_ratio": 0.3, "density": second**2}
        solids.append(ElasticSolid(mesh, **material, **support))
    contact = Contact(solids[0], "base", (solids[1], "top"), friction=0.3, name="c")
    history = Scene(solids, [contact], ThetaScheme(0.5)).run(3 * second, 0.1 * second)
    assert history.finished
    return history["dt"] == 0, history["kinetic"]


def test_percussions_do_not_depend_on_the_unit_of_time_nor_on_directions():
    """A threshold on them was built from the power of two above the largest component of a speed:
    6 to 13 of them by the unit, and energies apart by 70 %."""
    struck, kinetic = rubbed()
    assert struck[1:].sum() > 6
    others = [{"second": 1.25}, {"second": 1.5}, {"second": 1.75}, {"angle": 0.7}, {"angle": 1.1}]
    for other in others:
        again, energies = rubbed(**other)
        np.testing.assert_array_equal(again, struck)
        np.testing.assert_allclose(energies, kinetic, rtol=0, atol=1e-7 * kinetic.max())


def squares(n, masses, places, velocities=None, gravity=(0.0, 0.0)):
    solids = []
    for i in range(n):
        square = RigidSolid(
            rectangle((1, 1), (1.0, 1.0)),
            mass=masses[i],
            velocity=(velocities[i], 0.0) if velocities else None,
            gravity=gravity,
            name=f"s{i}",
        )
        square.restore({**square.state(), "place": square.place + np.array(places[i])})
        solids.append(square)
    return solids


@pytest.mark.parametrize("restitution", [0.2, 0.8, 1.0])
def test_every_one_of_many_bodies_that_land_in_one_step_rebounds(restitution):
    """From the ninth impact of a scene in a step on all that arrived was stopped dead."""
    n, until = 12, 0.5
    heights = 1.0 + 0.002 * np.arange(n)
    solids = squares(n, np.ones(n), [(2.0 * i, h) for i, h in enumerate(heights)], None, (0, -10.0))
    contacts = [
        Contact(s, "base", FLOOR, Restitution(restitution), name=f"{s.name} floor") for s in solids
    ]
    history = Scene(solids, contacts, locate_impacts=True).run(until, 0.1)
    assert history.finished and not history.remarks
    arrives = np.sqrt(2 * heights / 10)
    exact = restitution * 10 * arrives - 10 * (until - arrives)
    np.testing.assert_allclose([s.velocity[1] for s in solids], exact, atol=1e-13)
    np.testing.assert_allclose(np.sort(history.time[history["dt"] == 0][1:]), arrives, rtol=1e-12)


def bounces(height, restitution, until):
    """Height and velocity of a ball of restitution e at a time, and the instants of its impacts."""
    instants, speed = [np.sqrt(2 * height / 10)], np.sqrt(20 * height) * restitution
    while instants[-1] + speed / 5 < until and speed > 1e-12:
        instants.append(instants[-1] + speed / 5)
        speed *= restitution
    if speed <= 1e-12:
        return 0.0, 0.0, np.array(instants)
    flown = until - instants[-1]
    return speed * flown - 5 * flown**2, speed - 10 * flown, np.array(instants)


@pytest.mark.parametrize("restitution", [0.2, 0.5, 0.8, 0.9, 0.95, 1.0])
@pytest.mark.parametrize("dt", [0.01, 0.05])
def test_a_ball_bounces_and_comes_to_rest_exactly(restitution, dt):
    """However many of its bounces fall into one step: from the second of them on they were stopped
    by the step, 0.23 m/s too slow, or 1 um inside."""
    (ball,) = squares(1, [1.0], [(0.0, 1e-3)], None, (0, -10.0))
    contact = Contact(ball, "base", FLOOR, Restitution(restitution), name="c")
    history = Scene([ball], [contact], locate_impacts=True).run(0.5, dt)
    assert history.finished and not history.remarks
    height, velocity, instants = bounces(1e-3, restitution, 0.5)
    assert ball.place[1] - 0.5 == pytest.approx(height, abs=1e-12)
    assert ball.velocity[1] == pytest.approx(velocity, abs=1e-11)
    assert history["c.penetration"].max() < 1e-15
    found = history.time[history["dt"] == 0][1:]
    assert len(found) >= min(8, len(instants))
    np.testing.assert_allclose(found, instants[: len(found)], rtol=1e-10)


def bounces_by(theta, height, restitution, dt, n):
    """Instants of the first n impacts, as the scheme itself has them: over a length W of a step the
    height changes by v W - theta g W**2, and v by -g W."""
    instants, now, left, speed = [], 0.0, dt, 0.0
    while len(instants) < n:
        way = left
        if height + speed * left <= theta * G * left**2:
            way = (speed + np.sqrt(speed**2 + 4 * theta * G * height)) / (2 * theta * G)
        height, speed = height + speed * way - theta * G * way**2, speed - G * way
        now, left = now + way, left - way
        if left:
            instants.append(now)
            height, speed = 0.0, -restitution * speed
            if speed < 1e-12:  # by theta = 1 what leaves and returns in a step has lost its speed
                break
        left = left or dt
    return instants


@pytest.mark.parametrize("theta", [0.5, 0.55, 0.75, 1.0])
@pytest.mark.parametrize("restitution", [0.3, 0.5])
def test_a_ball_bounces_by_any_scheme(theta, restitution):
    """By theta > 1/2 what left the floor arrived as it left, without end: the speed at the end of a
    flight is not the rate of the gap by its length."""
    (ball,) = squares(1, [1.0], [(0.0, 0.5)], None, (0, -G))
    contact = Contact(ball, "base", FLOOR, Restitution(restitution), name="c")
    scene = Scene([ball], [contact], ThetaScheme(theta), locate_impacts=True)
    rows = iter(range(300))
    history = scene.run(1.0, 0.01, probes={"row": lambda: next(rows)})
    assert history.finished and not history.remarks
    exact = bounces_by(theta, 0.5, restitution, 0.01, 5)
    found = history.time[history["dt"] == 0][1:]
    np.testing.assert_allclose(found[: len(exact)], exact, rtol=1e-10)
    assert history["c.penetration"].max() < 1e-11


def chain(masses, restitution, gap, until, dt):
    """Three squares in line, of which the first comes with 1 m/s."""
    solids = squares(3, masses, [((1 + gap) * i, 0.0) for i in range(3)], (1.0, 0.0, 0.0))
    contacts = [
        Contact(a, "right", (b, "left"), Restitution(restitution), name=f"{a.name} {b.name}")
        for a, b in zip(solids, solids[1:])
    ]
    history = Scene(solids, contacts, locate_impacts=True).run(until, dt)
    return np.array([s.velocity[0] for s in solids]), history


def beads(masses, gap, restitution):
    """Velocities after all impacts of three bodies in line of which the first comes with 1 m/s."""
    v, gaps, impacts = np.array([1.0, 0.0, 0.0]), np.array([gap, gap]), 0
    m = np.array(masses)
    while (near := -np.diff(v)).max() > 1e-14:
        time = np.min(np.where(near > 1e-14, gaps / np.where(near > 1e-14, near, 1.0), np.inf))
        gaps = gaps - time * near
        i = int(np.where(near > 1e-14, gaps, np.inf).argmin())
        gaps[i], percussion = 0.0, (1 + restitution) * near[i] / (1 / m[i] + 1 / m[i + 1])
        v[i], v[i + 1] = v[i] - percussion / m[i], v[i + 1] + percussion / m[i + 1]
        impacts += 1
    return v, impacts


@pytest.mark.parametrize("dt", [0.25, 0.02, 0.01])
def test_a_light_body_between_two_heavy_ones(dt):
    """22 impacts without loss; of those of one step only eight were solved: 49 % of the energy
    went."""
    exact, impacts = beads([100.0, 1.0, 100.0], 0.01, 1.0)
    velocities, history = chain([100.0, 1.0, 100.0], 1.0, 0.01, 0.5, dt)
    assert history.finished and not history.remarks
    assert (history["dt"][1:] == 0).sum() == impacts == 22
    np.testing.assert_allclose(velocities, exact, atol=1e-10)


@pytest.mark.parametrize("middle, restitution", [(1.0, 0.05), (0.1, 0.3)])
def test_impacts_without_end_come_to_an_end(middle, restitution):
    """Inelastic collapse: infinitely many impacts in a finite time, after which all go together."""
    masses = [1.0, middle, 1.0]
    velocities, history = chain(masses, restitution, 0.01, 0.5, 0.25)
    assert history.finished
    assert "without end" in history.remarks[0][1]
    np.testing.assert_allclose(velocities, 1.0 / sum(masses), atol=1e-5)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("law", ["gap", "lagrange"])
def test_a_law_of_positions_limits_nothing_in_a_percussion(law):
    """Nothing moves in it: its gaps over a time of none were a warning of numpy's."""
    solids = []
    for place, velocity in ((0.2, 0.0), (0.7015, -1.0)):
        mesh = rectangle((1, 1), (1.0, 0.5))
        mesh.mesh.geometry.x[:, 1] += place
        solids.append(RigidSolid(mesh, mass=1.0, velocity=(0.0, velocity), name=f"at {place}"))
    lower, upper = solids
    contacts = [
        Contact(lower, "base", FLOOR, law, name="floor"),
        Contact(upper, "base", (lower, "top"), name="between"),
    ]
    history = Scene(solids, contacts, ThetaScheme(0.6)).run(0.01, 1e-3, progress=False)
    assert history.finished
    assert history["impact"][-1] == pytest.approx(-0.25, rel=1e-12)
    for solid in solids:
        assert solid.velocity[1] == pytest.approx(-0.5, rel=1e-12)


@pytest.mark.parametrize("play", [0.0, 1e-3])
def test_what_rebounds_without_play_has_no_state(play):
    """Between walls that it fits exactly it was struck for ever, at one instant."""
    block = RigidSolid(rectangle(), mass=1.0, velocity=(1.0, 0.0), held=["y", "turning"])
    contacts = [
        Contact(block, side, HalfSpace((sign * (0.18 + play), 0), (-sign, 0)), Restitution(1.0))
        for side, sign in (("left", -1), ("right", 1))
    ]
    history = Scene([block], contacts, locate_impacts=True).run(until=0.01, dt=0.01)
    if play:
        assert history.finished and abs(abs(block.velocity[0]) - 1) < 1e-12
    else:
        assert "rebounds without end within one instant, by 1 m/s" in history.reason
        assert "no state there" in history.advice
