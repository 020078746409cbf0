# SPDX-License-Identifier: LGPL-3.0-or-later
"""Reference cases on a rigid obstacle: impact, sliding, sticking, rest; exact values and orders."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scenes import (
    FLOOR,
    FLOOR_3D,
    G,
    box,
    check_energies,
    energy_size,
    rates,
    rectangle,
    rigid_box,
    total_energy,
)
from scipy.spatial.transform import Rotation

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    RigidSolid,
    Scene,
    ThetaScheme,
    Velocity,
)

MASS = 417.6
WEIGHT = MASS * G


def finished(scene, until, dt, **others):
    history = scene.run(until, dt, **others)
    assert history.finished, history.reason
    return history


# -- a mass dropped on a floor --


def span(history):
    """What turns the column of a force into impulses: percussions, in rows of no length, are."""
    return np.where(history["dt"] > 0, history["dt"], 1.0)


def drop(solid, height, steps, formulation, theta, friction=0.0, duration=1.5):
    """History of a drop from ``height``, at steps of the exact time of fall over ``steps``."""
    d = solid.dim
    up = np.eye(d)[-1]
    contact = Contact(solid, "base", HalfSpace(-height * up, up), formulation, friction, name="c")
    scene = Scene([solid], [contact], ThetaScheme(theta))
    fall = np.sqrt(2 * height / G)
    dt = fall / steps
    probes = {"v": lambda: solid.velocity[d - 1]}
    history = finished(scene, round(duration * steps) * dt, dt, probes=probes)
    return history, contact, dt


@pytest.mark.parametrize(
    ("formulation", "theta"),
    [("velocity", 0.5), ("velocity", 1.0), ("gap", 1.0), ("lagrange", 1.0)],
)
@pytest.mark.parametrize("dim", [2, 3])
def test_percussion_of_a_dropped_mass(formulation, theta, dim):
    """``m sqrt(2 g h)``, to first order in dt, then the weight. The impact falls in the same place
    of a step at each refinement: 0.4 after its start."""
    height, errors = 0.05, []
    exact = MASS * np.sqrt(2 * G * height)
    for n in (50, 100, 200):
        gravity = -G * np.eye(dim)[-1]
        solid = RigidSolid(rectangle() if dim == 2 else box(), mass=MASS, gravity=gravity)
        history, _, dt = drop(solid, height, n + 0.4, formulation, theta)
        force = history["c.force_" + "xyz"[dim - 1]]
        first = np.flatnonzero(force)[0]
        stop = first + np.flatnonzero(np.abs(history["v"][first:]) < 1e-9)[0]
        percussion = (force * span(history))[first : stop + 1].sum()
        errors.append(abs(percussion / exact - 1))
        # slowed down to touch at the end of the step, then stopped: rows of their own by velocity
        assert stop - first <= (2 if formulation == "velocity" else 1)
        assert errors[-1] * exact < 2 * WEIGHT * dt
        np.testing.assert_allclose(force[-n // 10 :], WEIGHT, rtol=1e-10)
        if theta == 0.5 or formulation != "velocity":  # else it stops up to v dt above the floor
            np.testing.assert_allclose(force[stop + 1 :], WEIGHT, rtol=1e-10)
        assert np.abs(solid.velocity).max() < 1e-10
        assert history["c.penetration"].max() < dt * np.sqrt(2 * G * height)
        check_energies(history)
    np.testing.assert_allclose(rates(errors), 1, atol=0.05)


@pytest.mark.parametrize("steps", [37.13, 41.55, 46.87, 53.99])
def test_percussion_wherever_the_impact_falls_in_a_step(steps):
    """One step of weight is all that the percussion may be off."""
    solid = RigidSolid(rectangle(), mass=MASS, gravity=(0, -G))
    history, _, dt = drop(solid, 0.05, steps, "velocity", 0.5)
    force = history["c.force_y"]
    bearing = np.abs(force - WEIGHT) > 1e-6 * WEIGHT
    percussion = (force * span(history))[bearing].sum()
    assert abs(percussion - MASS * np.sqrt(2 * G * 0.05)) <= 1.0001 * WEIGHT * dt


@pytest.mark.parametrize("friction", [0.0, 0.5])
@pytest.mark.parametrize("formulation", ["velocity", "gap", "lagrange"])
def test_flat_drop_on_eleven_nodes(formulation, friction):
    """All points close at once: the rigid solid stops dead, without turning."""
    solid = RigidSolid(rectangle((10, 1)), mass=MASS, gravity=(0, -G))
    theta = 0.5 if formulation == "velocity" else 1.0
    history, contact, _ = drop(solid, 0.05, 40.4, formulation, theta, friction)
    assert len(contact.force) == 11 and history["c.bearing"][-1] > 0
    np.testing.assert_allclose(solid.velocity, 0, atol=1e-12)
    assert history["kinetic"][-1] < 1e-20
    assert solid.rotation == pytest.approx(0, abs=1e-14)
    assert history["c.force_y"][-1] == pytest.approx(WEIGHT, rel=1e-10)
    assert abs(history["c.force_x"]).max() < 1e-10 * history["c.force_y"].max()
    assert total_energy(history).argmax() < 40
    assert history["impact"][-1] == pytest.approx(-WEIGHT * 0.05, rel=0.1)
    check_energies(history)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_flat_drop_in_3d_on_sixteen_nodes(friction):
    solid = RigidSolid(box((3, 3, 1)), mass=MASS, gravity=(0, 0, -G))
    history, contact, _ = drop(solid, 0.05, 40.4, "velocity", 0.5, friction)
    assert len(contact.force) == 16
    np.testing.assert_allclose(solid.velocity, 0, atol=1e-11)
    assert history["c.force_z"][-1] == pytest.approx(WEIGHT, rel=1e-10)
    check_energies(history)


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_oblique_flat_drop_without_tipping(friction):
    """Coulomb's law in the impact: the tangential velocity loses mu times the percussion."""
    solid = RigidSolid(rectangle((10, 1), (0.8, 0.36)), mass=MASS, gravity=(0, -G), velocity=(2, 0))
    history, _, _ = drop(solid, 0.05, 40.4, "velocity", 0.5, friction, duration=1.2)
    impulse = (history["c.force_y"] * span(history)).sum()
    np.testing.assert_allclose(
        solid.velocity, [2 - friction * impulse / MASS, 0, 0], rtol=0, atol=1e-11
    )
    assert solid.rotation == pytest.approx(0, abs=1e-13)
    check_energies(history)


def test_oblique_flat_drop_that_tips_makes_energy_only_by_the_time_step():
    """Where a point in contact turns, its mean force works on a mean velocity of second order."""
    gains = []
    for n in (50, 100, 200):
        solid = RigidSolid(rectangle((10, 1)), mass=MASS, gravity=(0, -G), velocity=(2, 0))
        history, _, _ = drop(solid, 0.05, n + 0.4, "velocity", 0.5, 0.9, duration=1.2)
        assert solid.velocity[2] < -1
        gains.append(np.maximum(np.diff(history["impact"]), 0).sum())
        check_energies(history, slack=gains[-1])
        total = total_energy(history)
        assert np.diff(total).max() < 1e-6 * total[0]
        assert history["friction"][-1] < -0.01 * history["kinetic"].max()
    assert gains[0] < 1e-6 * WEIGHT
    np.testing.assert_allclose(rates(gains), 2, atol=0.3)


@pytest.mark.parametrize("dt", [1e-3, 5e-4])
def test_box_thrown_at_the_floor_makes_no_energy(dt):
    """Edges and corners strike, slip turns round in a percussion: in sum it only loses."""
    history = finished(rigid_box(), 0.2, dt)
    assert history["impact"][-1] + history["friction"][-1] < -0.5 * energy_size(history)
    check_energies(history, together=True)


# -- sliding --


def slide(theta, steps, velocity=(2.0, 0.0), friction=0.3):
    """A block thrown along the floor, at steps of the exact stopping time over ``steps``."""
    d = len(velocity)
    solid = RigidSolid(
        rectangle((2, 1)) if d == 2 else box(),
        mass=MASS,
        gravity=-G * np.eye(d)[-1],
        velocity=velocity,
    )
    contact = Contact(solid, "base", FLOOR if d == 2 else FLOOR_3D, friction=friction, name="c")
    scene = Scene([solid], [contact], ThetaScheme(theta))
    stop = np.linalg.norm(velocity) / (friction * G)
    dt = stop / steps
    start = solid.place
    probes = {f"v{i}": lambda i=i: solid.velocity[i] for i in range(d)}
    history = finished(scene, round(1.2 * steps) * dt, dt, probes=probes)
    return history, solid, solid.place - start, stop


@pytest.mark.parametrize("points", [2, 5, 20, 60])
@pytest.mark.parametrize("height", [0.05, 0.2, 1.0])
def test_sliding_block_that_stops_where_a_step_ends(height, points):
    """Nothing moves then, but all points bear what they may: together they give way more than each
    alone, and Newton's method would turn all of them round in every step."""
    mu, v, g, steps = 0.3, 1.0, 1.0, 20
    block = RigidSolid(
        rectangle((points - 1, 1), (2.0, height)), mass=10.0, gravity=(0, -g), velocity=(v, 0)
    )
    contact = Contact(block, "base", FLOOR, friction=mu)
    start, stop = float(block.place[0]), v / (mu * g)
    history = finished(Scene([block], [contact]), 1.5 * stop, stop / steps)
    assert float(block.place[0]) - start == pytest.approx(v * stop / 2, rel=1e-12)
    assert np.abs(block.velocity).max() < 1e-14 and not history.remarks[20:]


@pytest.mark.parametrize(("theta", "order", "coarsest"), [(1.0, 1, 300), (0.5, 2, 75)])
def test_sliding_block_stops(theta, order, coarsest):
    """After v0/(mu g) at v0²/(2 mu g), having dissipated m v0²/2."""
    distance, errors = 2.0**2 / (2 * 0.3 * G), []
    for n in (coarsest, 2 * coarsest, 4 * coarsest):
        history, solid, way, stop = slide(theta, n + 0.4)
        errors.append(abs(way[0] / distance - 1))
        moving = np.abs(history["v0"]) > 1e-10
        assert moving[: n + 1].all() and not moving[n + 1 :].any()
        np.testing.assert_allclose(
            history["v0"][: n + 1], 2.0 - 0.3 * G * history.time[: n + 1], atol=1e-10
        )
        assert history.time[n + 1] == pytest.approx(stop, rel=1 / n)
        assert history["friction"][-1] == pytest.approx(-MASS * 2.0**2 / 2, rel=1e-11)
        assert abs(history["impact"]).max() < 1e-11 * MASS
        # Newton's tolerance, 1e-10 of the slip speed, as a share of g dt
        share = 1e-10 * 2 * 2.0 / (G * history["dt"][1])
        np.testing.assert_allclose(history["c.force_y"][1:], WEIGHT, rtol=share)
        np.testing.assert_allclose(history["c.force_x"][1 : n + 1], -0.3 * WEIGHT, rtol=share)
        np.testing.assert_allclose(history["c.force_x"][n + 2 :], 0, atol=share * WEIGHT)
        assert abs(way[1]) < 1e-12 and abs(solid.rotation) < 1e-11  # Newton's tolerance, likewise
        check_energies(history)
    assert errors[-1] < 1e-3
    np.testing.assert_allclose(rates(errors), order, atol=0.02)


def test_oblique_sliding_in_3d_keeps_its_direction():
    """Friction is opposite to the velocity, at any angle to the tangents of the surface."""
    velocity = np.array([1.2, -0.9, 0.0])
    direction = velocity / 1.5
    history, solid, way, _ = slide(0.5, 200.4, velocity)
    v = np.stack([history[f"v{i}"] for i in range(3)], axis=1)
    exact = np.maximum(1.5 - 0.3 * G * history.time, 0)[:, None] * direction
    np.testing.assert_allclose(v[:201], exact[:201], atol=1e-9)
    np.testing.assert_allclose(v[202:], 0, atol=1e-10)
    force = np.stack([history[f"c.force_{a}"] for a in "xyz"], axis=1)[1:201]
    expected = WEIGHT * np.array([-0.3 * direction[0], -0.3 * direction[1], 1.0])
    np.testing.assert_allclose(force, np.broadcast_to(expected, force.shape), atol=1e-8 * WEIGHT)
    np.testing.assert_allclose(way, 1.5**2 / (2 * 0.3 * G) * direction, rtol=1e-4, atol=1e-9)
    assert np.linalg.norm(np.atleast_1d(solid.rotation)) < 1e-9
    assert history["friction"][-1] == pytest.approx(-MASS * 1.5**2 / 2, rel=1e-9)
    check_energies(history, 1e-8)


# -- an incline --

SLOPE = 0.3  # rad


def incline(kind, friction, velocity=0.0):
    """Scene of a block on a slope, its solid, and the unit vector down the slope."""
    tilt = {
        "plane": Rotation.from_rotvec([0, 0, -SLOPE]),
        "gravity": Rotation.identity(),
        "plane 3D": Rotation.from_rotvec(SLOPE * np.array([0.6, 0.8, 0])),
        "gravity 3D": Rotation.identity(),
    }[kind]
    d = 3 if "3D" in kind else 2
    axis = np.array([0.6, 0.8, 0]) if d == 3 else np.array([0, 0, -1.0])
    up = np.eye(3)[d - 1]
    normal = tilt.apply(up)
    down = tilt.apply(np.cross(axis, up))
    weight = -G * up if "plane" in kind else G * (np.sin(SLOPE) * down - np.cos(SLOPE) * up)
    turn = tilt.as_rotvec()
    solid = RigidSolid(
        rectangle((2, 1)) if d == 2 else box(),
        mass=MASS,
        gravity=weight[:d],
        rotation=turn if d == 3 else turn[2],
        about=np.zeros(d),
        velocity=(velocity * down)[:d],
    )
    contact = Contact(
        solid, "base", HalfSpace(np.zeros(d), normal[:d]), friction=friction, name="c"
    )
    return Scene([solid], [contact]), solid, down[:d]


KINDS = ["plane", "gravity", "plane 3D", "gravity 3D"]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("excess", [0.001, 0.5])
def test_incline_sticks_up_to_the_friction_angle(kind, excess):
    scene, solid, down = incline(kind, (1 + excess) * np.tan(SLOPE))
    place = solid.place
    history = finished(scene, 0.1, 1e-3)
    np.testing.assert_allclose(solid.velocity, 0, atol=1e-9)
    np.testing.assert_allclose(solid.place, place, atol=1e-10)
    force = [history[f"c.force_{a}"][-1] for a in "xyz"[: solid.dim]]
    np.testing.assert_allclose(force, -MASS * solid.gravity, atol=1e-9 * WEIGHT)
    assert down @ force == pytest.approx(-WEIGHT * np.sin(SLOPE), rel=1e-9)
    assert history["c.bearing"][1:].min() > 0 and not history["c.slipping"].any()
    assert not history.remarks


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("friction_share", [0.999, 0.5, 0.0])
def test_incline_slides_beyond_the_friction_angle(kind, friction_share):
    friction = friction_share * np.tan(SLOPE)
    scene, solid, down = incline(kind, friction)
    place, until = solid.place, 0.1
    history = finished(scene, until, 1e-3)
    acceleration = G * (np.sin(SLOPE) - friction * np.cos(SLOPE))
    speed = acceleration * until
    np.testing.assert_allclose(solid.velocity[: solid.dim], speed * down, atol=1e-9)
    np.testing.assert_allclose(solid.velocity[solid.dim :], 0, atol=1e-8)
    np.testing.assert_allclose(solid.place - place, speed * until / 2 * down, atol=1e-10)
    check_energies(history, 1e-8)


@pytest.mark.parametrize("kind", KINDS)
def test_block_thrown_down_a_slope_comes_to_rest_and_stays(kind):
    friction = 1.3 * np.tan(SLOPE)  # more tips the block
    scene, solid, down = incline(kind, friction, velocity=0.1)
    place = solid.place
    history = finished(scene, 0.2, 1e-3)
    braking = G * (friction * np.cos(SLOPE) - np.sin(SLOPE))
    np.testing.assert_allclose(solid.velocity, 0, atol=1e-9)
    way = 0.1**2 / 2 / braking
    np.testing.assert_allclose(solid.place - place, way * down, atol=0.5 * braking * 1e-6)
    check_energies(history, 1e-8)


@pytest.mark.parametrize(("law", "theta"), [("velocity", 0.5), ("gap", 0.5), ("velocity", 0.8)])
def test_friction_that_sticks_gives_nothing(law, theta):
    """An elastic block on a slope, let go, and thrown up it, in steps of 1 to 100 of its shortest
    periods; by theta = 1/2 none is cut."""
    shortest, steps = 0.0117, 8  # s
    for friction, speed, periods in product([0.3, 3, 10], [0, -0.5], [1, 4, 25, 100]):
        solid = ElasticSolid(
            rectangle((3, 3)),
            youngs_modulus=1e6,
            poisson_ratio=0.3,
            density=1000.0,
            gravity=(0.5 * G, -0.8 * G),
            velocity=lambda x, speed=speed: np.stack([speed + 0 * x[0], 0 * x[1]]),
        )
        contact = Contact(solid, "base", FLOOR, law, friction=friction, name="c")
        scene = Scene([solid], [contact], ThetaScheme(theta))
        history = finished(scene, steps * periods * shortest, periods * shortest)
        size, total = energy_size(history), total_energy(history)
        assert (total - np.minimum.accumulate(total)).max() <= 1e-9 * size
        if theta == 0.5:  # else the scheme takes what friction gives by the mean of both ends
            assert np.count_nonzero(history["dt"]) == steps, history.remarks
            assert np.diff(history["friction"]).max() <= 1e-7 * size


# -- a friction oscillator --


def oscillator(steps):
    """Code_Aster SDND100 (m = 1, k = 1e4, mu = 0.1, N = 10, x0 = 0.85 mm), made of one cell that
    resists shear only, fixed at its top: m = rho/3, N = rho g/2, k the shear modulus."""
    solid = HyperelasticSolid(
        rectangle((1, 1), (1.0, 1.0)),
        energy=lambda F: 1e4 / 2 * F[0, 1] ** 2,
        density=3.0,
        gravity=(0.0, -20 / 3),
        fixed=["top"],
        displacement=lambda x: np.stack([0.85e-3 * (1 - x[1]), 0 * x[1]]),
    )
    contact = Contact(solid, "base", FLOOR, friction=0.1, name="c")
    foot = np.flatnonzero(solid.displacement)[0]
    half = np.pi / 100
    history = finished(
        Scene([solid], [contact]),
        6 * half,
        half / steps,
        probes={"x": lambda: solid.displacement[foot]},
    )
    return history


def test_friction_oscillator():
    """Turning points -0.65, 0.45, -0.25, 0.05 mm every 31.4159 ms, then it sticks for ever."""
    errors = []
    for steps in (20, 40, 80):
        history = oscillator(steps)
        x = 1e3 * history["x"][::steps]
        np.testing.assert_allclose(history["c.force_y"][1:], 10, rtol=1e-9)
        errors.append(np.abs(x - [0.85, -0.65, 0.45, -0.25, 0.05, 0.05, 0.05]).max())
        still = history["x"][4 * steps + 2 :]
        np.testing.assert_allclose(still, still[0], atol=1e-12)
        lost = 1e4 / 2 * (0.85e-3**2 - still[0] ** 2)
        assert history["friction"][-1] == pytest.approx(-lost, rel=1e-6)
        # stopped, it is still pulled back in the step that brings it to rest
        check_energies(history, 1e-7, slack=0.5 * (0.5 * history["dt"][1]) * history["dt"][1] / 2)
    # where in a step the last slip ends is chance, but never worth more than its square
    assert (np.array(errors) < 0.001 * np.array([1, 1 / 4, 1 / 16])).all(), errors


# -- bars --


def bar(cells, length, gap, wave_speed, until, theta=0.5, forces="theta", law="velocity", **others):
    """A bar of density and cross-section 1 along x, which may touch a wall ``gap`` to its left; in
    a step a wave crosses one cell."""
    solid = ElasticSolid(
        rectangle((cells, 1), (length, 1.0)),
        youngs_modulus=wave_speed**2,
        poisson_ratio=0.0,
        density=1.0,
        **others,
    )
    contact = Contact(solid, "left", HalfSpace((-length / 2 - gap, 0), (1, 0)), law, name="c")
    scene = Scene([solid], [contact], ThetaScheme(theta, forces))
    history = finished(scene, until, length / cells / wave_speed)
    check_energies(history)
    return history


def thrown(cells, *scheme, law="velocity"):
    """Doyen, Ern & Piperno (2011): 500 J, contact from 0.5 s to 1.1667 s with 300 N."""
    return bar(
        cells,
        10.0,
        5.0,
        30.0,
        2.0,
        *scheme,
        law=law,
        velocity=lambda x: np.stack([-10 + 0 * x[0], 0 * x[1]]),
    )


@pytest.mark.parametrize(
    ("law", "theta", "forces", "kept"),
    [
        ("printed", 0.5, "theta", 0.991),
        pytest.param("printed", 0.5, "end", 0.906, marks=pytest.mark.long),
        pytest.param("printed", 1.0, "end", 0.867, marks=pytest.mark.long),
        ("velocity", 0.5, "theta", 0.9986),
        ("velocity", 0.5, "end", 0.906),
        ("velocity", 1.0, "end", 0.867),
    ],
)
def test_bar_thrown_at_a_wall(law, theta, forces, kept):
    """The continuous bar keeps its energy, these schemes the shares that formulation.md tells; the
    impact of the last node alone, as a percussion, costs less than its stop by the whole step."""
    history = thrown(200, theta, forces, law=law)
    force, t = history["c.force_x"], history.time
    start, end = t[force > 150][[0, -1]]
    assert start == pytest.approx(0.5, abs=0.002)
    assert end == pytest.approx(7 / 6, abs=0.025)
    assert force[(t > 0.6) & (t < 1.1)].mean() == pytest.approx(300, rel=0.002)
    assert not force[(t < 0.498) | (t > 1.175)].any()
    assert total_energy(history)[-1] / 500 == pytest.approx(kept, abs=0.002)
    scheme = 0 if (theta, forces) == (0.5, "theta") else kept - 1
    assert history["scheme"][-1] / 500 == pytest.approx(scheme, abs=0.02)


@pytest.mark.second
def test_bar_thrown_at_a_wall_converges():
    """All that is lost is the impact of the last node, whose mass is that of half a cell."""
    errors = []
    for cells in (50, 100, 200):
        history = thrown(cells, law="printed")
        impulse = (history["c.force_x"] * span(history)).sum()
        errors.append([1 - total_energy(history)[-1] / 500, 1 - impulse / 200])
        assert abs(history["scheme"][-1]) < 1e-9 * 500
    lost, momentum = np.transpose(errors)
    np.testing.assert_allclose(rates(lost), 1, atol=0.01)
    np.testing.assert_allclose(rates(momentum), 1, atol=0.25)
    struck = thrown(200)
    assert 1 - total_energy(struck)[-1] / 500 < 0.25 * lost[-1]
    assert abs(1 - (struck["c.force_x"] * span(struck)).sum() / 200) < momentum[-1]


def test_bar_released_stretched():
    """Chouly, Hild & Renard: contact in [1, 2] and [4, 5] with 1/2, energy 1/8, period 3."""
    history = bar(
        200,
        1.0,
        0.0,
        1.0,
        6.0,
        fixed=["right"],
        displacement=lambda x: np.stack([(0.5 - x[0]) / 2, 0 * x[1]]),
    )
    t, force = history.time, history["c.force_x"]
    assert history["strain"][0] == pytest.approx(1 / 8, rel=1e-12)
    for start in (1, 4):
        inside = (t > start + 0.1) & (t < start + 0.9)
        assert force[inside].mean() == pytest.approx(0.5, rel=2e-3)
    open_ = (t < 0.99) | ((t > 2.03) & (t < 3.97)) | (t > 5.03)
    assert not force[open_].any()
    assert 0.98 < total_energy(history)[-1] * 8 < 1


# -- elastic blocks at rest --


@pytest.mark.parametrize("formulation", ["gap", Velocity(drift_correction=0.1)])
@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
def test_signorini_block(formulation, cell):
    """A unit square squeezed by d between frictionless planes: ``lam = -E d/(1 - nu²)``."""
    E, nu, d = 1e6, 0.3, 0.01
    solid = ElasticSolid(
        rectangle((3, 3), (1.0, 1.0), cell), youngs_modulus=E, poisson_ratio=nu, density=1000.0
    )
    contacts = [
        Contact(solid, "base", FLOOR, formulation),
        Contact(solid, "top", HalfSpace((0, 1 - d), (0, -1)), formulation),
    ]
    scene = Scene([solid], contacts, ThetaScheme(1.0), deepest=0.02)
    history = finished(scene, 3.0, 0.01)
    pressure = E * d / (1 - nu**2)
    for contact in contacts:
        np.testing.assert_allclose(contact.multiplier, -pressure, rtol=1e-9)
        np.testing.assert_allclose(contact.gap, 0, atol=1e-12)
    assert history["strain"][-1] == pytest.approx(pressure * d / 2, rel=1e-9)
    x, u = solid.mesh.mesh.geometry.x[:, 0], solid.fields()["displacement"]
    np.testing.assert_allclose(np.ptp(u[:, 0]), nu / (1 - nu) * d, rtol=1e-9)
    np.testing.assert_allclose(np.diff(u[np.argsort(x, kind="stable"), 0]).min(), 0, atol=1e-10)


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize(("degree", "cell"), [(1, "quadrilateral"), (2, "triangle")])
def test_elastic_block_comes_to_rest_under_its_weight(friction, degree, cell):
    """The reaction is the weight, the pressure integrates to it, the two sides are alike."""
    solid = ElasticSolid(
        rectangle((6, 3), (1.0, 0.5), cell),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        degree=degree,
        gravity=(0, -G),
    )
    contact = Contact(solid, "base", FLOOR, friction=friction, name="c")
    history = finished(Scene([solid], [contact], ThetaScheme(1.0)), 2.0, 0.01)
    weight = 1000.0 * 0.5 * G
    assert history["c.force_y"][-1] == pytest.approx(weight, rel=1e-9)
    assert abs(history["c.force_x"][-1]) < 1e-9 * weight
    assert history["kinetic"][-1] < 1e-15 * history["kinetic"].max()
    assert -(contact.multiplier @ contact.surface.area) == pytest.approx(weight, rel=1e-9)
    assert contact.multiplier.max() <= 0
    if cell == "quadrilateral":
        pressure = contact.multiplier[np.argsort(contact.surface.points[:, 0])]
        np.testing.assert_allclose(pressure, pressure[::-1], rtol=1e-8)
    assert history["strain"][-1] > 0
    check_energies(history)


def test_elastic_block_of_zero_poisson_ratio_bears_its_weight_evenly():
    """``sigma_yy = -rho g (H - y)`` exactly."""
    solid = ElasticSolid(
        box((2, 2, 3)), youngs_modulus=1e6, poisson_ratio=0.0, density=1000.0, gravity=(0, 0, -G)
    )
    contact = Contact(solid, "base", FLOOR_3D, name="c")
    history = finished(Scene([solid], [contact], ThetaScheme(1.0)), 40.0, 1.0)
    np.testing.assert_allclose(contact.multiplier, -1000.0 * G * 0.8, rtol=1e-9)
    sink = 1000.0 * G * 0.8**2 / 2 / 1e6
    u, z = solid.fields()["displacement"][:, 2], solid.mesh.mesh.geometry.x[:, 2]
    np.testing.assert_allclose(u[z > 0.79] - u[z < 0.01], -sink, rtol=1e-9)
    # the forces work on what the Newton tolerance, 1e-10 of g dt = 9.81 m/s, leaves of the jumps
    check_energies(history, tolerance=1e-10)


@pytest.mark.parametrize("solver", ["condensed", "monolithic"])
@pytest.mark.parametrize("facets", [1, 2, 5])
def test_a_rigid_block_stands_from_the_first_step(facets, solver):
    """Nothing moves, and nothing has: speeds are measured by what its weight would give."""
    block = RigidSolid(rectangle((facets, 1)), density=1000.0, gravity=(0, -G))
    contact = Contact(block, "base", FLOOR, friction=0.3, name="c")
    scene = Scene([block], [contact], geometry="newton", solver=solver)
    history = scene.run(3e-3, 1e-3, progress=False)
    assert history.finished and history["newton"].max() <= 2
    assert history["c.force_y"][-1] == pytest.approx(block.mass * G, rel=1e-9)
