# SPDX-License-Identifier: LGPL-3.0-or-later
"""The scheme protocol, by a scheme that is no theta-scheme: generalised alpha, with contact."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import scenes
from scenes import (
    FLOOR,
    FLOOR_3D,
    G,
    box,
    check_energies,
    elastic_block,
    rates,
    rectangle,
    rigid_box,
    rocking_block,
    soft_block,
    total_energy,
)

import fenicsx_contact
from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    InputError,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    neo_hookean,
)
from fenicsx_contact.references.bars import ThrownBar
from fenicsx_contact.theory.generalised_alpha import GeneralisedAlpha
from fenicsx_contact.theory.scheme import Scheme, Step

RADII = [0.0, 0.5, 0.8, 1.0]
LENGTH, WAVE = 10.0, 30.0  # m, m/s


def bar(cells, **others):
    """A bar of 10 m along x."""
    mesh = rectangle((cells, 1), (LENGTH, 1.0))
    material = {"youngs_modulus": WAVE**2, "poisson_ratio": 0.0, "density": 1.0}
    return ElasticSolid(mesh, **material, **others)


# -- the scheme alone --


@pytest.mark.parametrize("scheme", [ThetaScheme(0.7), ThetaScheme(0.5, "end"), GeneralisedAlpha()])
def test_schemes_fulfil_the_protocol(scheme):
    assert isinstance(scheme, Scheme)
    for points in (scheme.force_points, scheme.load_points):
        shares, weights = np.array(points).T
        assert weights.sum() == pytest.approx(sum(scheme.linear_weights), abs=1e-14)
        assert weights @ shares == pytest.approx(scheme.linear_weights[1], abs=1e-14)


def amplification(scheme, z):
    """Eigenvalues of a step of ``x'' = -z² x`` of length 1, from (x, v, M a) with A = a."""

    def advance(state):
        x, v, a = (np.array([value]) for value in state)
        memory = np.stack([a, a])
        step = Step(1.0, scheme)
        before, after = scheme.linear_weights
        known = x + step.drift(v, memory)
        carried = step.carried(memory)
        rhs = v - z**2 * (before * x + after * known) + carried
        new = rhs / (1 + z**2 * after * step.gap_rate)
        end = x + step.increment(v, new, memory)
        force = carried - z**2 * step.linear_mean(x, end)
        return np.concatenate([end, new, step.remember(v, new, force, memory)[0]])

    return np.linalg.eigvals(np.array([advance(unit) for unit in np.eye(3)]).T)


@pytest.mark.parametrize("rho", RADII)
def test_spectral_radius_is_rho_inf_at_high_frequencies(rho):
    scheme = GeneralisedAlpha(rho)
    radii = [np.abs(amplification(scheme, z)).max() for z in np.geomspace(1e-3, 1e3, 200)]
    assert max(radii) < 1 + 1e-7
    assert radii[-1] == pytest.approx(rho, abs=0.011)
    low = 1 - np.abs(amplification(scheme, 0.1)).max()
    assert 0 <= low + 1e-12 < 1e-4  # of third order


def test_rho_inf_outside_its_range_is_refused():
    for rho in (-0.1, 1.1, np.nan, "high"):
        with pytest.raises(InputError, match="rho_inf"):
            GeneralisedAlpha(rho)


def test_rho_inf_1_is_theta_one_half_for_linear_solids():
    ends = []
    for scheme in (ThetaScheme(), GeneralisedAlpha(1.0)):
        scene = elastic_block(scheme=scheme)
        assert scene.run(0.05, 1e-3).finished
        ends.append(scene.solids[0].velocity)
    np.testing.assert_allclose(ends[1], ends[0], rtol=0, atol=1e-10)


# -- free motion --


@pytest.mark.parametrize("rho", RADII)
def test_free_vibration_is_of_second_order_and_makes_no_energy(rho):
    errors, k, h = [], np.pi / 2 / LENGTH, LENGTH / 8
    omega = WAVE * np.sqrt(6 / h**2 * (1 - np.cos(k * h)) / (2 + np.cos(k * h)))
    for steps in (80, 160, 320):
        solid = bar(
            8,
            fixed=["left"],
            displacement=lambda x: np.stack([0.1 * np.sin(k * (x[0] + LENGTH / 2)), 0 * x[1]]),
        )
        shape = solid.displacement.copy()
        probes = {"q": lambda s=solid, m=shape: s.displacement @ m / (m @ m)}
        dt = 2 * np.pi / omega / steps
        history = Scene([solid], [], GeneralisedAlpha(rho)).run(2 * steps * dt, dt, probes=probes)
        errors.append(np.abs(history["q"] - np.cos(omega * history.time)).max())
        total = total_energy(history)
        assert total.max() < (1 + 1e-12) * total[0]
        check_energies(history)
    assert errors[-1] < 0.01
    np.testing.assert_allclose(rates(errors), 2, atol=0.05)
    assert total[-1] > 0.997 * total[0]
    if rho == 1:
        np.testing.assert_allclose(total, total[0], rtol=1e-11)


def test_high_frequencies_are_damped():
    """A wave as long as four cells, at a step of five crossings of a cell."""
    kept = []
    for rho in RADII:
        solid = bar(40, velocity=lambda x: np.stack([np.cos(2 * np.pi * x[0]), 0 * x[1]]))
        scene = Scene([solid], [], GeneralisedAlpha(rho), allow_free=True)
        total = total_energy(scene.run(20 * 5 / 120, 5 / 120))
        kept.append(total[-1] / total[0])
    assert kept[0] < 1e-8 and kept[1] < 1e-4 and kept[2] < 0.2
    assert kept[3] == pytest.approx(1, rel=1e-10)
    assert np.all(np.diff(kept) > 0)


def test_loads_in_time_are_of_second_order():
    """A traction that rises on a free bar: momentum is its impulse."""
    errors = []
    for steps in (20, 40, 80):
        solid = bar(4, tractions={"right": lambda t: [np.sin(2 * t), 0.0]})
        Scene([solid], [], GeneralisedAlpha(0.5), allow_free=True).run(1.0, 1.0 / steps)
        errors.append(abs(solid.mean(solid.velocity)[0] * LENGTH - np.sin(1.0) ** 2))
    np.testing.assert_allclose(rates(errors), 2, atol=0.1)


@pytest.mark.parametrize("rho", [0.5, 0.9])
def test_finite_vibration_is_of_second_order(rho):
    ends = []
    for steps in (50, 100, 200, 400):
        solid = HyperelasticSolid(
            rectangle((2, 3)),
            energy=neo_hookean(1e6, 0.3),
            density=1000.0,
            velocity=lambda x: 4 * np.stack([x[1] ** 2, 0.7 * x[0] ** 2 - 0.4 * x[1]]),
        )
        history = Scene([solid], [], GeneralisedAlpha(rho), allow_free=True).run(0.05, 0.05 / steps)
        assert history.finished, history.reason
        check_energies(history, 1e-7)
        ends.append(solid.displacement)
    changes = [np.abs(a - b).max() for a, b in zip(ends[:-1], ends[1:])]
    np.testing.assert_allclose(rates(changes), 2, atol=0.2)


@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_a_load_that_gives_its_mean_loses_no_pulse(theta):
    """3 N s within 3 ms and a step of 10 ms, as the guide says."""
    dt, ahead = 1e-2, 1e-2 * (1 - theta)

    def impulse(t):
        return 1000 * min(max(t - 0.1, 0), 3e-3)

    def mean(t):
        return (impulse(t + ahead) - impulse(t + ahead - dt)) / dt, 0.0

    solid = RigidSolid(rectangle((1, 1), (1.0, 1.0)), mass=3.0, force=mean)
    Scene([solid], [], ThetaScheme(theta), allow_free=True).run(0.2, dt)
    assert 3 * solid.velocity[0] == pytest.approx(3.0, rel=1e-12)


def test_free_flight_of_a_rigid_solid_is_exact():
    """But for the first step, in which A begins: (r - 1/2) h² g once."""
    scheme, dt = GeneralisedAlpha(0.5), 0.01
    solid = RigidSolid(rectangle(), mass=3.0, gravity=(0, -G), velocity=(3.0, 2.0))
    place = solid.place
    history = Scene([solid], [], scheme, allow_free=True).run(0.8, dt)
    once = (scheme.position_rate - 0.5) * dt**2 * scheme.gamma * G
    exact = place + np.array([0.8 * 3.0, 0.8 * 2.0 - 0.32 * G])
    assert np.abs(solid.place - exact).max() <= 2 * once
    assert solid.velocity[1] == pytest.approx(2.0 - 0.8 * G, rel=1e-12)
    check_energies(history)


# -- contact --


@pytest.mark.parametrize("rho", RADII)
@pytest.mark.parametrize("law", ["velocity", pytest.param("gap", marks=pytest.mark.second)])
def test_bar_thrown_at_a_wall(law, rho):
    """Times, impulse and energy of the exact solution, and no ripples of its reaction."""
    exact, cells = ThrownBar(WAVE**2, 1.0, LENGTH, 5.0, 10.0), 200
    solid = bar(cells, velocity=lambda x: np.stack([-10 + 0 * x[0], 0 * x[1]]))
    contact = Contact(solid, "left", HalfSpace((-10.0, 0), (1, 0)), law, name="c")
    history = Scene([solid], [contact], GeneralisedAlpha(rho)).run(2.0, LENGTH / cells / WAVE)
    assert history.finished, history.reason
    # the gap law's mean force works in the step in which a point arrives
    check_energies(history, slack=0.01 * exact.energy if law == "gap" else 0.0)
    total, force, time = total_energy(history), history["c.force_x"], history.time
    assert total.max() < (1 + 1e-11) * total[0]
    assert total[-1] > 0.97 * exact.energy
    np.testing.assert_allclose(time[force > 1][[0, -1]], exact.contact, atol=0.006)
    impulse = history.impulse("c")[-1, 0]
    assert impulse == pytest.approx(2 * LENGTH * exact.speed, rel=0.01)
    inside = (time > 0.6) & (time < 1.0)
    if rho < 1:  # nothing damps the gap law's oscillation with rho_inf = 1
        np.testing.assert_allclose(force[inside], exact.force, rtol=1e-3)


@pytest.mark.parametrize("rho", RADII)
@pytest.mark.parametrize(
    "kind",
    ["rigid", *(pytest.param(kind, marks=pytest.mark.second) for kind in ("elastic", "box"))],
)
def test_block_that_is_dropped_stays(kind, rho):
    """The velocity law, e = 0: it stops, bears its weight, and does not drift."""
    dt, drop = 1e-3, 0.01
    if kind == "box":
        solid = RigidSolid(box(), mass=100.0, gravity=(0, 0, -G), velocity=(0, 0, -0.1))
    elif kind == "rigid":
        solid = RigidSolid(rectangle((3, 1)), mass=100.0, gravity=(0, -G), velocity=(0, -0.1))
    else:
        solid = ElasticSolid(
            rectangle((3, 4)),
            youngs_modulus=1e6,
            poisson_ratio=0.3,
            density=1000.0,
            gravity=(0, -G),
            velocity=lambda x: np.stack([0 * x[0], -0.1 + 0 * x[0]]),
        )
    d = solid.dim
    floor = HalfSpace([0.0] * (d - 1) + [-drop], (FLOOR_3D if d == 3 else FLOOR).normal)
    contact = Contact(solid, "base", floor, friction=0.3, name="c")
    history = Scene([solid], [contact], GeneralisedAlpha(rho)).run(1.0, dt)
    assert history.finished, history.reason
    total = total_energy(history)
    slack = 1e-3 * np.ptp(total) if kind == "elastic" else 0.0  # where a point lifts in a step
    check_energies(history, 1e-9, slack=slack, together=True)
    assert total.max() - total[0] < 1e-9 * np.ptp(total)
    if kind == "elastic":  # it bounces as elastic bodies do
        return
    late = history.time > 0.2
    np.testing.assert_allclose(history["c.force_y" if d == 2 else "c.force_z"][late], 100 * G)
    assert np.abs(history["kinetic"][late]).max() < 1e-20
    depth = history["potential"][late] / (-100 * G)
    assert np.ptp(depth) < 1e-13
    speed = np.sqrt(0.1**2 + 2 * G * drop)
    assert np.abs(contact.gap).max() < 1.5 * speed * dt


@pytest.mark.parametrize(
    "make, until, dt",
    [(rocking_block, 0.4, 2e-3), (rigid_box, 0.2, 2e-3), (elastic_block, 0.1, 1e-3)],
)
def test_scenes_of_theta_one_half_come_out_alike(make, until, dt):
    """To the order of the step, with friction; energies are explained."""
    ends = []
    for scheme in (ThetaScheme(), GeneralisedAlpha(0.9)):
        history = make(scheme=scheme).run(until, dt)
        assert history.finished, history.reason
        assert np.abs(history["balance"]).max() < 1e-9 * total_energy(history).max()
        ends.append(history["kinetic"][-1])
    assert ends[1] == pytest.approx(ends[0], rel=0.05)


def test_impacts_are_located():
    """A rigid block, then rest: to the second order of the scheme."""
    solid = RigidSolid(rectangle(), mass=1.0, gravity=(0, -G))
    contact = Contact(solid, "base", HalfSpace((0, -0.1), (0, 1)), name="c")
    scheme, dt = GeneralisedAlpha(0.8), 0.02
    history = Scene([solid], [contact], scheme, locate_impacts=True).run(0.5, dt)
    assert history.finished, history.reason
    once = (scheme.position_rate - 0.5) * dt**2 * G
    assert np.abs(contact.gap).max() < 3 * once
    assert history["kinetic"][-1] < 1e-20
    instant = history.time[1:][history["dt"][1:] == 0][0]
    assert instant == pytest.approx(np.sqrt(0.2 / G), abs=0.01 * dt)


def test_adaptive_steps_keep_their_error():
    history = elastic_block(scheme=GeneralisedAlpha(0.8)).run(0.05, 1e-2, step_error=1e-2)
    assert history.finished, history.reason
    assert len(np.unique(np.round(history["dt"][1:], 9))) > 2


@pytest.mark.parametrize("make", [elastic_block, soft_block, rocking_block])
def test_memory_is_part_of_the_state(make):
    whole, half = (make(scheme=GeneralisedAlpha(0.7)) for _ in range(2))
    assert whole.run(0.02, 1e-3).finished and half.run(0.01, 1e-3).finished
    again = make(scheme=GeneralisedAlpha(0.7))
    again.restore(half.state())
    assert again.run(0.02, 1e-3).finished
    np.testing.assert_array_equal(again.solids[0].velocity, whole.solids[0].velocity)
    np.testing.assert_array_equal(again.solids[0].memory, whole.solids[0].memory)


@pytest.mark.parametrize(
    ("make", "others"),
    [(elastic_block, {"scheme": QuasiStatic()}), (soft_block, {"solver": "monolithic"})],
)
def test_a_scene_that_is_made_changes_no_other(make, others):
    """Only contact holds a solid in one of them, or its old tangents serve: not in the other."""
    runs = []
    for alone in (True, False):
        scene = make(solver="condensed", geometry="newton")
        if not alone:
            Scene(scene.solids, scene.contacts, geometry="newton", **others)
        runs.append(scene.run(0.05, 2e-3))
        assert runs[-1].finished, runs[-1].reason
    for name in runs[0].columns:
        np.testing.assert_array_equal(runs[0][name], runs[1][name], name)


# -- the house --


def test_solids_write_no_scheme():
    """Nor does anything but the schemes know theta."""
    package = Path(fenicsx_contact.__file__).parent
    for folder in ("solids", "contact", "steps", "solve", "rods"):
        for file in (package / folder).glob("*.py"):
            assert not re.search(r"scheme\.(theta|forces)\b", file.read_text()), file
    assert not re.search(r"scheme\.(theta|forces)\b", (package / "scene.py").read_text())
    for file in (package / "solids").glob("*.py"):
        code = [line for line in file.read_text().splitlines() if "step.dt" in line]
        assert all("def turn" in line or "float(np.abs" in line for line in code), (file, code)


# -- friction in space --


@pytest.mark.parametrize("formulation", ["velocity", "gap", "lagrange"])
def test_friction_that_turns_in_space_is_of_second_order(formulation):
    """Across a slope, by theta = 1/2."""
    start, errors = np.array([2.0, 0, 0]), []
    _, velocity = scenes.exact_slide(0.35, start, 0.5)
    for dt in (0.02, 0.01):
        body, scene = scenes.slide(0.35, start, formulation=formulation)
        assert scene.run(0.5, dt).finished
        errors.append(np.abs(body.velocity[:3] - velocity).max())
    assert errors[1] < 5e-5 and 3.5 < errors[0] / errors[1] < 4.5


@pytest.mark.parametrize("theta", [0.5, 0.7])
def test_what_slides_in_space_comes_to_rest(theta):
    """Whatever the step it rests, and friction took all that moved it, and gave nothing."""
    for dt in (0.013, 0.1, 0.7):
        body, scene = scenes.slide(0.6, np.array([1.5, 1.0, 0]), theta=theta)
        before = body.place.copy()
        history = scene.run(3.0 + 2 * dt, dt)
        assert history.finished and not history.remarks
        assert np.abs(body.velocity[:3]).max() < 1e-12
        assert np.diff(history["friction"]).max() < 1e-14
        fallen = scenes.ON_A_SLOPE @ (body.place - before)
        if theta == 0.5:  # which takes nothing itself
            moved = history["kinetic"][0] + fallen
            assert history["friction"][-1] == pytest.approx(-moved, rel=1e-12)
