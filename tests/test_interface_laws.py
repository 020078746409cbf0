# SPDX-License-Identifier: LGPL-3.0-or-later
"""Interface laws beyond Coulomb's, each against its exact solution in a scene of one cell."""

import re
from dataclasses import dataclass
from functools import partial
from math import log, sqrt

import numpy as np
import pytest
import ufl
from corpus_meshes import moved
from dolfinx import fem
from scenes import FLOOR, FLOOR_3D, G, box, check_energies, rectangle
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fenicsx_contact import (
    Adhesive,
    Archard,
    Compliance,
    Contact,
    Coulomb,
    Discrete,
    ElasticSolid,
    HyperelasticSolid,
    InputError,
    LevelSet,
    Moved,
    QuasiStatic,
    RateState,
    Restitution,
    RigidSolid,
    Scene,
    StaticKinetic,
    Stribeck,
    ThetaScheme,
    Tresca,
    Turned,
)
from fenicsx_contact.base import compat

MASS, HEIGHT = 10.0, 0.1  # of a rigid block one metre wide, kg and m
IMPLICIT = ThetaScheme(1.0)


def block(**state):
    return RigidSolid(rectangle((1, 1), (1.0, HEIGHT)), mass=MASS, **{"gravity": (0, -G), **state})


def thrown():
    return block(velocity=(1.0, 0.0))


def slide(
    friction, until, dt=2e-3, solid=None, law="velocity", scheme=None, locate_impacts=False, **run
):
    """A block thrown along the floor: its contact, and its history with speed v and distance s."""
    solid = solid or thrown()
    master = FLOOR if solid.dim == 2 else FLOOR_3D
    contact, start = Contact(solid, "base", master, law, friction, name="c"), solid.place[0]
    probes = {"v": lambda: solid.velocity[0], "s": lambda: solid.place[0] - start}
    scene = Scene([solid], [contact], scheme, locate_impacts=locate_impacts)
    history = scene.run(until, dt, probes=probes, **run)
    assert history.reason == "finished" and not history.remarks
    return contact, history


def spring_slider(stiffness, load, mass, friction, speed, stretch, rate=0.0):
    """A mass pressed with ``load`` [N] on a belt that runs at ``speed``, on a spring: the base of
    one cell whose energy is that of shear. Probes: displacement u and velocity v of the mass."""
    mesh = rectangle((1, 1), (1.0, 1.0))
    k = fem.Constant(mesh.mesh, stiffness)
    solid = HyperelasticSolid(
        mesh,
        energy=lambda F: k / 2 * F[0, 1] ** 2,
        density=3 * mass,
        gravity=(0.0, -2 * load / (3 * mass)),
        fixed=["top"],
        displacement=lambda x: np.stack([stretch * (1 - x[1]), 0 * x[1]]),
        velocity=lambda x: np.stack([rate * (1 - x[1]), 0 * x[1]]),
    )
    belt = LevelSet(lambda x, t: x[1], 2, velocity=lambda x, t: (speed, 0.0))
    contact = Contact(solid, "base", belt, friction=friction, name="c")
    foot = contact.traces[0]
    probes = {"u": lambda: foot.jump(solid.displacement)[0]}
    probes["v"] = lambda: foot.jump(solid.velocity)[0]
    return contact, partial(Scene([solid], [contact]).run, probes=probes)


# -- friction that varies ------------------------------------------------------------------------


def test_friction_of_the_place_and_its_integral():
    """A floor with mu = m + n x. The pressure leans forward by mu h/2, so that of the block is
    (m + n x)/(1 - n h/2), and its work is what the block had."""
    m, n = 0.3, 0.2
    M, N = m / (1 - n * HEIGHT / 2), n / (1 - n * HEIGHT / 2)
    stop = (sqrt(M**2 + N / G) - M) / N  # v²/2 = g (M s + N s²/2)
    for dt, error in ((8e-3, 3e-4), (1e-3, 1e-5)):
        _, history = slide(lambda x: m + n * x[0], 0.5, dt)
        assert history["s"][-1] == pytest.approx(stop, rel=error)
        check_energies(history)


@pytest.mark.parametrize("geometry", ["fixed point", "newton"])
@pytest.mark.parametrize("law", ["friction", "stress", "springs"])
@pytest.mark.parametrize("scheme", [QuasiStatic(), IMPLICIT, ThetaScheme(0.5)], ids=repr)
def test_laws_are_read_where_points_get_to(geometry, law, scheme):
    """At each node, of an elastic block that is dragged faster and faster, in steps longer than a
    cell. In the one linearisation of a linear solid on a flat floor they were read where it had
    been predicted, in the first step where it started: mu = 0.101 in place of 0.152."""
    value = lambda x: 0.1 + 0.5 * x[0]  # noqa: E731
    laws = {
        "friction": ("gap", value),
        "stress": ("gap", Tresca(lambda x: 1e4 * value(x))),
        "springs": (Compliance(lambda x: 1e10 * value(x)), 0.0),
    }
    way = lambda t: (0.1 * t**2, -1e-4 * t)  # noqa: E731
    solid = ElasticSolid(
        rectangle((2, 1), (0.1, 0.05)), youngs_modulus=1e9, poisson_ratio=0.0, density=1000.0,
        prescribed={"top": way},
    )  # fmt: skip
    contact = Contact(solid, "base", FLOOR, *laws[law])
    scene, area = Scene([solid], [contact], scheme, geometry=geometry), contact.surface.area
    mean = lambda old, new: old + scheme.force_weight * (new - old)  # noqa: E731
    start, gap = contact.coupling.positions(), contact.gap
    for _ in range(3):
        assert len(list(scene.step(1.0))) == 1
        read = value(mean(start, contact.coupling.positions()).T)
        along, up = contact.force.T
        exact, found = {
            "friction": (read * up, -along),
            "stress": (1e4 * read * area, -along),
            "springs": (1e10 * read * area * mean(gap, contact.gap), up),
        }[law]
        np.testing.assert_allclose(found, exact, rtol=1e-6)
        start, gap = contact.coupling.positions(), contact.gap


@pytest.mark.parametrize("geometry", ["fixed point", "newton"])
def test_a_parameter_is_asked_where_points_get_to(geometry):
    """mu = 0.15 - x before a block that is dragged beyond 0.15 in a step: it had been asked where
    the step was predicted only, and friction drove the block."""
    solid = ElasticSolid(
        rectangle((2, 1), (0.1, 0.05)), youngs_modulus=1e9, poisson_ratio=0.0, density=1000.0,
        prescribed={"top": lambda t: (0.3 * t, -1e-5)},
    )  # fmt: skip
    contact = Contact(solid, "base", FLOOR, "gap", lambda x: 0.15 - x[0])
    history = Scene([solid], [contact], QuasiStatic(), geometry=geometry).run(1.0, 1.0)
    assert "friction must be finite and >= 0" in history.reason
    assert (np.diff(history["friction"]) <= 0).all()
    assert contact.start_positions[:, 0].max() <= 0.15


def test_friction_of_the_time():
    """mu = c t: v = v0 - c g t²/2, exactly, for the scheme takes forces in the midst of a step."""
    _, history = slide(lambda x, t: 0.5 * t, 0.4, dt=0.02)
    np.testing.assert_allclose(history["v"], 1 - 0.25 * G * history.time**2, atol=1e-12)


@pytest.mark.parametrize("given", ["coordinates", "function"])
def test_friction_of_the_material(given):
    """A coating of the block's own base, mu = m + n X: always the same."""
    m, n, solid = 0.2, 0.1, thrown()
    mesh = solid.mesh.mesh
    if given == "coordinates":
        friction = m + n * ufl.SpatialCoordinate(mesh)[0]
    else:
        friction = fem.Function(compat.lagrange_space(mesh))
        friction.interpolate(lambda x: m + n * x[0])
    _, history = slide(friction, 0.3, solid=solid)
    mu = m / (1 - n * HEIGHT / 2)
    np.testing.assert_allclose(history["v"], 1 - mu * G * history.time, atol=1e-11)


def test_a_default_is_no_time():
    """The time took the place of what a function has a default for."""
    plain = slide(0.3, 0.1)[1]
    for friction in (lambda x, mu=0.3: mu + 0 * x[0], lambda x, t=None, mu=0.3: mu + 0 * t):
        np.testing.assert_allclose(slide(friction, 0.1)[1]["v"], plain["v"], rtol=1e-12)


@pytest.mark.parametrize("one", [True, False])
def test_friction_of_a_constant_is_read_in_each_step(one):
    """Or of a component of it."""
    solid = thrown()
    mu = fem.Constant(solid.mesh.mesh, 0.3 if one else (0.0, 0.3))
    contact = Contact(solid, "base", FLOOR, friction=mu if one else mu[1])
    scene = Scene([solid], [contact])
    scene.run(0.1, 0.01)
    mu.value = 0.1
    scene.run(0.3, 0.01)
    assert solid.velocity[0] == pytest.approx(1 - G * (0.3 * 0.1 + 0.1 * 0.2), abs=1e-12)


def test_a_finite_stress_does_nothing_in_an_impact():
    """Tresca's block lands without losing speed, then loses it steadily."""
    solid = block(velocity=(1.0, -0.5))
    _, history = slide(Tresca(20.0), 0.1, dt=0.01, solid=solid)
    assert (history["dt"] == 0).any()
    np.testing.assert_allclose(history["v"], 1 - 20 / MASS * history.time, atol=1e-12)


def test_what_no_law_asks_for_does_not_exist():
    contact, _ = slide(0.3, 0.01)
    made = vars(contact.equations.fields)
    assert not made["_constants"] and not made["_functions"] and not contact.memory.values
    assert not {"t", "place", "slip_speed", "touched", "loaded"} & made.keys()
    assert isinstance(contact.coupling.recess, float)


# -- static and kinetic ----------------------------------------------------------------------------


@pytest.mark.parametrize("dim", [2, 3])
def test_kinetic_friction_slows_and_static_friction_holds(dim):
    """Thrown it stops as by mu_k; then a slope between the two does not move it."""
    solid = thrown()
    if dim == 3:
        mesh = box((1, 1, 1), (1.0, 1.0, HEIGHT))
        solid = RigidSolid(mesh, mass=MASS, gravity=(0, 0, -G), velocity=(0.6, 0.8, 0))
    contact, history = slide(StaticKinetic(0.5, 0.25), 0.5, solid=solid)
    way = np.linalg.norm(solid.place[: dim - 1] - (0.0, 0.0)[: dim - 1])
    assert way == pytest.approx(1 / (2 * 0.25 * G), rel=1e-5)
    assert np.abs(solid.velocity).max() < 1e-12
    assert (contact.status == 1).all()
    check_energies(history)


@pytest.mark.parametrize("speed, slides", [(0.0, False), (1e-3, True)])
def test_on_a_slope_between_the_two_it_stays_or_goes_on(speed, slides):
    """Both are solutions: what is at rest stays, what slides is not caught, however slow."""
    pull = 0.4 * G
    _, history = slide(
        StaticKinetic(0.5, 0.25), 0.2, solid=block(gravity=(pull, -G), velocity=(speed, 0.0))
    )
    exact = speed + (pull - 0.25 * G) * 0.2 if slides else 0.0
    assert history["v"][-1] == pytest.approx(exact, abs=1e-12)


SPRINGS = [Compliance(1e6, tangential_stiffness=1e6), Discrete(5e5)]
PRESSED = (0.0, MASS * G / 1e6)  # by its weight: so deep those of a block are


@pytest.mark.parametrize("law", ["velocity", "gap", *SPRINGS], ids=str)
def test_static_friction_holds_until_more_pulls(law):
    """Springs that stick stretch, which is no slip: kinetic friction held what static friction
    should, and a block at rest on a slope slid off."""
    mesh = rectangle((1, 1), (1.0, HEIGHT))
    mesh.mesh.geometry.x[:, 1] -= 0.0 if isinstance(law, str) else PRESSED[1]
    solid = RigidSolid(mesh, mass=MASS, gravity=(0, -G), force=lambda t: (200 * t, 0.0))
    contact = Contact(solid, "base", FLOOR, law, StaticKinetic(0.5, 0.2), name="c")
    history = Scene([solid], [contact], IMPLICIT, deepest=1).run(
        0.3, 2e-3, probes={"v": lambda: solid.velocity[0]}
    )
    assert history.finished
    pull = np.abs(history["c.force_x"])
    # on springs the block leans as it is pulled, and points give way one by one
    rest = 1e-9 if isinstance(law, str) else 0.06
    assert pull.max() == pytest.approx(0.5 * MASS * G, rel=rest + 0.01)
    assert pull[-1] == pytest.approx(0.2 * MASS * G, rel=rest or 1e-6)
    moves = history.time[np.argmax(history["v"] > 0.05)]
    assert moves == pytest.approx(0.5 * MASS * G / 200, rel=0.1)


@pytest.mark.parametrize("points", [1, 2, 3])
@pytest.mark.parametrize("scheme", [None, IMPLICIT])
def test_static_friction_holds_on_a_table_that_spins_up(scheme, points):
    """By the geometric fixed point points that stick move by 5e-10 m/s, as it left that of the
    geometry: that was a slip, kinetic friction held them from then on, and they left at half the
    speed, or many of them stopped the run."""
    mesh = box((points, points, 1), (0.1, 0.1, 0.02))
    mesh.mesh.geometry.x[:, 0] += 1.0
    solid = RigidSolid(mesh, mass=1.0, gravity=(0, 0, -G))
    table = Turned(FLOOR_3D, (0, 0, 0), lambda t: t**2, (0, 0, 1))
    contact = Contact(solid, "base", table, friction=StaticKinetic(0.5, 0.2), name="c")
    probes = {"r": lambda: np.hypot(*solid.place[:2])}
    history = Scene([solid], [contact], scheme).run(0.7, 4e-3, probes=probes)
    assert history.finished and not history.remarks
    assert not history["c.slipping"].any()
    np.testing.assert_allclose(history["r"], 1.0, atol=1e-3 if scheme else 1e-5)


@pytest.mark.parametrize("law", ["velocity", "gap"])
def test_static_friction_is_not_decided_by_round_off(law):
    """An elastic block rings as it is rubbed to and fro: points stop and turn round. What stops had
    a jump of 1e-17 m/s, whose sign said whether static or kinetic friction held it; other numbers
    of nodes, or processes, made another motion (5 % of the energies)."""
    energies = []
    for at in (0.0, 0.3):
        mesh = rectangle((8, 4), (0.4, 0.2))
        mesh.mesh.geometry.x[:, 0] += at
        solid = ElasticSolid(
            mesh, youngs_modulus=1e6, poisson_ratio=0.3, density=1000.0, gravity=(0, -G),
            tractions={"top": lambda t: (400 * np.sin(12 * t), -500.0)},
        )  # fmt: skip
        contact = Contact(solid, "base", FLOOR, law, StaticKinetic(0.5, 0.3))
        history = Scene([solid], [contact]).run(0.4, 5e-3)
        assert history.finished and not history.remarks
        energies.append([history[name] for name in ("kinetic", "strain", "friction")])
    np.testing.assert_allclose(*energies, rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("theta", [0.5, 0.7, 1.0])
def test_what_turns_round_is_held(theta):
    """A block thrown up a slope between both coefficients rests where it stops. With theta < 1 it
    may turn round within a step before it is held: that was a slip that goes on, and by every third
    step it slid down again."""
    slope = np.arctan(0.5)
    pull, press = G * np.sin(slope), G * np.cos(slope)
    for steps in (331, 400, 467, 523, 701, 997):
        solid = block(gravity=(-pull, -press), velocity=(1.0, 0.0))
        contact = Contact(solid, "base", FLOOR, friction=StaticKinetic(0.6, 0.35))
        history = Scene([solid], [contact], ThetaScheme(theta)).run(0.5, 0.5 / steps)
        assert history.finished and abs(solid.velocity[0]) < 1e-9
        assert solid.place[0] == pytest.approx(0.5 / (pull + 0.35 * press), rel=0.02)


def test_stick_slip_on_a_belt():
    """It is carried to mu_s N/k, swings about mu_k N/k, and is caught as fast as the belt."""
    k, N, m, V, static, kinetic = 100.0, 10.0, 1.0, 0.1, 0.5, 0.2
    high, middle, omega = static * N / k, kinetic * N / k, sqrt(k / m)
    swing = sqrt((high - middle) ** 2 + (V / omega) ** 2)
    errors = []
    for dt in (4e-3, 2e-3):
        friction = StaticKinetic(static, kinetic)
        _, run = spring_slider(k, N, m, friction, V, 0.048, V)
        u = run(0.5, dt)["u"]
        errors.append([u.max() - middle - swing, u.min() - middle + swing])
    errors = np.abs(errors) / swing
    assert errors[1].max() < 0.01
    assert (errors[0] / errors[1]).min() > 1.8  # the instant of breaking away is rounded to a step


# -- rate, and rate and state ----------------------------------------------------------------------


def test_stribeck_friction_is_of_second_order():
    law = Stribeck(0.4, 0.2, 0.5, exponent=2, viscosity=3.0)

    def rate(t, v):
        return -G * (0.2 + 0.2 * np.exp(-((v / 0.5) ** 2))) - 3.0 * v / MASS

    exact = solve_ivp(rate, (0, 0.2), [1.0], rtol=1e-12, atol=1e-14).y[0, -1]
    errors = [abs(slide(law, 0.2, dt)[1]["v"][-1] - exact) for dt in (8e-3, 4e-3)]
    assert errors[0] < 2e-5 and errors[0] / errors[1] > 3.5
    _, history = slide(law, 0.6)
    assert abs(history["v"][-1]) < 1e-12  # and it stops
    assert history["newton"].max() <= 5
    check_energies(history)


A, B, D, MU, V0, LOAD = 0.01, 0.015, 1.0, 0.6, 1.0, 10.0  # rate and state


def state_slider(law, stiffness, speed, age, mass):
    friction = RateState(A, B, D, MU, V0, theta=age, law=law)
    steady = MU + (A - B) * log(speed / V0)
    return spring_slider(stiffness, LOAD, mass, friction, speed, steady * LOAD / stiffness)


@pytest.mark.parametrize("law", ["ageing", "slip"])
def test_rate_and_state_in_steady_sliding(law):
    """mu = mu_0 + (a - b) ln(V/V_0), theta = D/V, above the critical stiffness."""
    contact, run = state_slider(law, 4 * (B - A) * LOAD / D, 3.0, 0.3, 1e-4)
    history = run(6.0, 0.05)
    assert history.reason == "finished"
    mu = history["c.force_x"][-1] / history["c.force_y"][-1]
    assert mu == pytest.approx(MU + (A - B) * log(3.0), rel=1e-6)
    np.testing.assert_allclose(contact.memory.values["theta"], D / 3.0, rtol=1e-4)


@pytest.mark.parametrize("law", [pytest.param("ageing", marks=pytest.mark.second), "slip"])
def test_critical_stiffness_of_a_spring_slider(law):
    """A disturbance grows below k_c = (b - a) sigma/D and dies out above (Ruina 1983); inertia
    M = 0.002 a sigma D/V² raises it by so much (Rice and Ruina 1983)."""
    critical, share, dt = (B - A) * LOAD / D, np.array([0.95, 1.05]), 0.05
    growth = []
    for factor in share:
        _, run = state_slider(law, factor * critical, 1.0, 1.001, 0.002 * A * LOAD)
        u = run(14.0, dt)["u"][50::8]
        # u(n + 2) = c u(n + 1) + d u(n) + e of a swing that grows or dies out
        rows = np.stack([u[1:-1], u[:-2], np.ones(len(u) - 2)], axis=1)
        c, d, _ = np.linalg.lstsq(rows, u[2:], rcond=None)[0]
        growth.append(np.log(np.roots([1, -c, -d])[0]).real / (8 * dt))
    assert growth[0] > 0 > growth[1]
    assert np.interp(0, growth[::-1], share[::-1]) == pytest.approx(1.002, abs=1e-3)
    np.testing.assert_allclose(growth, (1 - share) * (B - A) / (2 * A), rtol=0.07)


@pytest.mark.parametrize("law", ["ageing", "slip"])
def test_contacts_age_at_rest_by_dieterichs_law_alone(law):
    """Held still the ageing law's contacts grow older by the second, Ruina's do not."""
    friction = RateState(A, B, D, MU, V0, theta=2.0, law=law)
    contact, _ = slide(friction, 0.5, dt=0.05, solid=block())
    exact = 2.5 if law == "ageing" else 2.0
    np.testing.assert_allclose(contact.memory.values["theta"], exact, rtol=1e-12)
    contact.memory.reset()
    np.testing.assert_array_equal(contact.memory.values["theta"], 2.0)


@pytest.mark.parametrize("a", [0.01, 0.02])
@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_rate_and_state_holds_on_a_belt_as_on_a_floor(a, theta):
    """In hold slips of 1e-12 or 1e-24 m/s are no digit of velocities; friction is what pulls."""
    friction, reports = RateState(a, 0.005, 1e-4, 0.5, 1e-3), []
    for speed in (0.0, 0.01):
        solid = block(velocity=(speed, 0), held=["turning"], force=(10.0, 0))
        belt = Moved(FLOOR, lambda t, v=speed: (v * t, 0))
        contact = Contact(solid, "base", belt, friction=friction)
        history = Scene([solid], [contact], ThetaScheme(theta)).run(0.02, 1e-3)
        assert history.reason == "finished" and not history.remarks
        assert contact.force[:, 0].sum() == pytest.approx(-10.0, rel=1e-6)
        reports.append(solid.velocity[0] - speed)
    np.testing.assert_allclose(reports, 0, atol=1e-10)


def test_rate_and_state_turns_round():
    """A block on a spring swings on the floor, its slip turning round, and stays."""
    solid = block(velocity=(2.0, 0), held=["turning"], springs={(0.0, 0.0): (1e3, 0)})
    friction = RateState(0.01, 0.005, 1e-4, 0.5, 1e-3)
    history = Scene([solid], [Contact(solid, "base", FLOOR, friction=friction)]).run(0.3, 1e-3)
    assert history.reason == "finished" and not history.remarks
    assert history["newton"].max() <= 6
    check_energies(history)


# -- a law of one's own, and what it remembers -----------------------------------------------------


@dataclass(frozen=True)
class Warming:
    """A stranger's: friction grows with the way that has been slid."""

    mu: float
    length: float

    def bound(self, k, pressure, S):
        way = k.state("way", 0.0, lambda old, time: old + k.slip_speed * time)
        return self.mu * (1 + way / self.length) * pressure

    def describe(self):
        return f"friction {self.mu} (1 + s/{self.length})"


def test_a_law_with_memory_in_five_lines():
    """v²/2 = mu g (s + s²/2L)"""
    mu, L = 0.2, 0.1
    stop = L * (sqrt(1 + 1 / (mu * G * L)) - 1)
    distances = []
    for dt in (4e-3, 2e-3):
        contact, history = slide(Warming(mu, L), 0.6, dt)
        np.testing.assert_allclose(contact.memory.values["way"], history["s"][-1], rtol=1e-9)
        distances.append(history["s"][-1])
    assert distances[1] == pytest.approx(stop, rel=1e-4)


@pytest.mark.parametrize(
    "friction", [Archard(Warming(0.2, 0.1), 1e-2, 1e6), RateState(A, B, 0.01, 0.3, 0.1)]
)
def test_runs_with_memory_resume_to_the_same_bits(friction, tmp_path):
    contact, whole = slide(friction, 0.2)
    slide(friction, 0.1, directory=tmp_path)
    again, rest = slide(friction, 0.2, directory=tmp_path, resume=True)
    np.testing.assert_array_equal(rest.rows(), whole.rows())
    assert contact.memory.values
    for name, values in contact.memory.values.items():
        np.testing.assert_array_equal(again.memory.values[name], values)


@pytest.mark.parametrize("law", ["velocity", "gap", Compliance(1e7, tangential_stiffness=1e6)])
@pytest.mark.parametrize("friction", ["warming", "ageing", "slip"])
def test_nothing_slips_in_flight(friction, law):
    """Past a floor a metre below: the way of the flight was counted as slid, and contacts were as
    young as those that slide."""
    solid = block(gravity=(0, 0), velocity=(2.0, 0.0))
    solid.restore({**solid.state(), "place": solid.place + np.array([0, 1.0])})
    given = {"warming": Warming(0.2, 0.1)}.get(friction) or RateState(
        A, B, D, MU, V0, 0.3, friction
    )
    contact, _ = slide(given, 0.2, 0.05, solid, law)
    (found,) = contact.memory.values.values()
    exact = {"warming": 0.0, "ageing": 0.5, "slip": 0.3}[friction]
    np.testing.assert_allclose(found, exact, rtol=1e-12)


def test_the_way_slid_begins_where_it_lands():
    """Dropped from 0.1 m: friction was three times too large by the way of the fall."""
    solid, height = block(velocity=(2.0, 0.0), held=["turning"]), 0.1
    solid.restore({**solid.state(), "place": solid.place + np.array([0, height])})
    fall = sqrt(2 * height / G)
    contact, history = slide(Warming(0.2, 0.1), fall + 0.02, 1e-3, solid, locate_impacts=True)
    landed = history["s"][history.time < fall + 1e-9][-1]
    way = history["s"][-1] - landed
    assert landed == pytest.approx(2 * fall, rel=1e-9)
    np.testing.assert_allclose(contact.memory.values["way"], way, rtol=1e-9)


def test_steps_that_are_not_taken_leave_no_memory():
    solid = thrown()
    contact = Contact(solid, "base", FLOOR, friction=Warming(0.2, 0.1))
    stepper = Scene([solid], [contact]).stepper
    from fenicsx_contact.theory.scheme import Step

    step = Step(0.01, ThetaScheme())
    stepper.attempt(step)
    assert not contact.memory.values["way"].any()
    stepper.accept(stepper.attempt(step))
    assert contact.memory.values["way"].all()


@pytest.mark.parametrize("nu, speed", [(0.0, 0.1), (0.3, 0.1), (0.3, 0.0)])
@pytest.mark.parametrize("law", [Compliance(1e10, tangential_stiffness=1e10), Discrete(5e9)])
def test_stiff_springs_rub_in_few_iterations(law, nu, speed):
    """A cell pressed on a belt: Newton's steps leapt over the slip speeds at which springs stick,
    back and forth, 40 a step. By nu = 0 it bears its pressure, in series with the springs."""
    E, height, depth = 1e6, 0.5, 5e-3
    solid = ElasticSolid(
        rectangle((1, 1), (1.0, height)),
        youngs_modulus=E,
        poisson_ratio=nu,
        density=1e3,
        prescribed={"top": lambda t: (0.0, -depth * min(1.0, t / 0.02))},
    )
    belt = Moved(FLOOR, lambda t: (-speed * t, 0.0))
    contact = Contact(solid, "base", belt, law, 0.3, name="c")
    history = Scene([solid], [contact], IMPLICIT).run(0.1, 2e-3)
    assert history.finished and not history.remarks
    assert history["newton"].max() <= 5 and history["newton"][1:].mean() < 1.5
    if not nu:
        force = depth / (height / E + 1e-10)
        assert history["c.force_y"][-1] == pytest.approx(force, rel=1e-9)
        assert history["c.force_x"][-1] == pytest.approx(-0.3 * force, rel=1e-9)


# -- wear ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("law, scheme", [("velocity", None), ("gap", IMPLICIT)])
def test_worn_volume_of_a_sliding_block(law, scheme):
    """Archard: k F s/H, whatever the pressure's shape, to the vertical motion that it takes; the
    block sinks by what is worn."""
    k, H = 1e-3, 1e6
    solid = thrown()
    contact, history = slide(Archard(0.2, k, H), 1.0, 5e-3, solid, law, scheme)
    depth = contact.memory.values["worn"]
    volume = k * MASS * G * history["s"][-1] / H
    if scheme is None:
        assert history["s"][-1] == pytest.approx(1 / (2 * 0.2 * G), rel=1e-4)
    assert contact.surface.area @ depth == pytest.approx(volume, rel=1e-6)
    lean = 0.2 * HEIGHT / 2 / 0.5  # of the pressure, towards the front
    np.testing.assert_allclose(sorted(depth / volume), [1 - lean, 1 + lean], rtol=1e-4)
    assert HEIGHT / 2 - solid.place[1] == pytest.approx(volume, rel=1e-3)


@pytest.mark.parametrize("law", ["velocity", SPRINGS[0]], ids=str)
def test_what_sticks_does_not_wear(law):
    """On springs their stretch did."""
    mesh = rectangle((1, 1), (1.0, HEIGHT))
    mesh.mesh.geometry.x[:, 1] -= 0.0 if isinstance(law, str) else PRESSED[1]
    force = lambda t: (10 * np.sin(20 * t), 0.0)  # noqa: E731
    solid = RigidSolid(mesh, mass=MASS, gravity=(0, -G), force=force)
    contact = Contact(solid, "base", FLOOR, law, Archard(0.5, 1e-3, 1e4), name="c")
    history = Scene([solid], [contact], IMPLICIT, deepest=1).run(0.3, 2e-3)
    assert history.finished and (contact.status == 1).all()
    assert contact.memory.values["worn"].max() < 1e-18


def test_worn_volume_of_one_solid_on_another():
    """The slave recedes, by what its own force has worn."""
    table = ElasticSolid(
        rectangle((6, 1), (3.0, 0.2)),
        youngs_modulus=1e9,
        poisson_ratio=0.0,
        density=1000.0,
        fixed=["base"],
        name="table",
    )
    solid = thrown()
    solid.restore({**solid.state(), "place": solid.place + np.array([0, 0.2])})
    friction = Archard(0.2, 1e-3, 1e6)
    contact = Contact(solid, "base", (table, "top"), "gap", friction, name="c")
    start = solid.place[0]
    history = Scene([solid, table], [contact], IMPLICIT).run(0.2, 5e-3)
    assert history.reason == "finished"
    volume = 1e-3 * MASS * G * (solid.place[0] - start) / 1e6
    assert contact.surface.area @ contact.memory.values["worn"] == pytest.approx(volume, rel=0.01)


@pytest.mark.parametrize("cells", [1, 4])
@pytest.mark.parametrize("held", [["turning"], []], ids=["held", "free"])
@pytest.mark.parametrize("law", ["velocity", "gap", Adhesive(30.0), Restitution(0.5)], ids=str)
def test_what_wears_is_shared(law, held, cells):
    """By Tresca's friction of an area, on all of it: points that had borne were lower than others
    by what they wore and let go, and s S was that of a fifth of the area (0.91 m/s for 0.60)."""
    k, hardness, stress, until = 1e-3, 1e4, 20.0, 0.2
    mesh = rectangle((cells, 1), (1.0, HEIGHT))
    solid = RigidSolid(mesh, mass=MASS, gravity=(0, -G), velocity=(1.0, 0.0), held=held)
    contact, history = slide(Archard(Tresca(stress), k, hardness), until, 2e-3, solid, law)
    speed = 1 - stress / MASS * until
    assert solid.velocity[0] == pytest.approx(speed, rel=1e-12)
    assert history["c.slipping"][1:].min() == cells + 1
    worn, pressed = contact.memory.values["worn"], MASS * G + 30.0 * isinstance(law, Adhesive)
    volume = k / hardness * pressed * history["s"][-1]
    assert contact.surface.area @ worn == pytest.approx(volume, rel=2e-5)
    if held:
        np.testing.assert_allclose(worn, worn.mean(), rtol=1e-9)
    np.testing.assert_allclose(contact.gap, 0, atol=1e-5 * worn.mean())


@pytest.mark.parametrize(
    "law", ["velocity", "gap", Compliance(1e6, tangential_stiffness=1e6)], ids=str
)
def test_uneven_wear_of_one_solid_on_another(law):
    """A column is pressed on a slab that slides: friction bends it, and it wears unevenly, as it
    does before an obstacle, but for its normals, those at the start of a step. They were those of
    unworn facets, which tilt by the gradient of the depth: forces were 1.6 % aside, and by
    velocities pressure was lost 5 times too fast."""
    material = {"youngs_modulus": 1e3, "poisson_ratio": 0.0, "density": 1e-6}
    top = {"top": lambda t: (0.0, -5e-3 * min(t, 1.0))}

    def away(t):
        return -max(0.0, t - 1), 0.0

    slab = rectangle((30, 1), (5.0, 0.2))
    slab.mesh.geometry.x[:] += (1.5, -0.2, 0.0)
    stiff = {**material, "youngs_modulus": 1e9}
    errors = []
    for dt in (0.05, 0.025):
        plate = ElasticSolid(slab, prescribed={"base": away}, name="plate", **stiff)
        forces, worn = [], []
        for others, master in (([], Moved(FLOOR, away)), ([plate], (plate, "top"))):
            solid = ElasticSolid(rectangle((4, 4), (0.4, 0.5)), prescribed=top, **material)
            contact = Contact(solid, "base", master, law, Archard(0.2, 5e-4, 10.0), name="c")
            history = Scene([solid, *others], [contact], QuasiStatic()).run(2.0, dt)
            assert history.finished
            forces.append([history["c.force_x"], history["c.force_y"]])
            worn.append(contact.memory.values["worn"])
        assert np.ptp(worn[0]) > 0.1 * worn[0].mean()
        np.testing.assert_allclose(*worn, rtol=2e-3)
        errors.append(np.abs(np.subtract(*forces)).max() / np.max(forces))
    assert errors[0] < 1.5e-3 and errors[1] < max(0.6 * errors[0], 1e-5), errors


# -- adhesion --------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", ["gap", "velocity", "lagrange"])
def test_pull_off_force(law):
    """A cell drawn upwards holds to exactly s times its base (or s at each of its two points)."""
    stress, E, height, speed = 133.0, 1e6, 0.1, 1e-4
    solid = ElasticSolid(
        rectangle((1, 1), (1.0, height)),
        youngs_modulus=E,
        poisson_ratio=0.0,
        density=1.0,
        prescribed={"top": lambda t: [0.0, speed * t]},
    )
    contact = Contact(solid, "base", FLOOR, Adhesive(stress, law), 0.3, name="c")
    history = Scene([solid], [contact], QuasiStatic()).run(0.4, 0.01)
    assert history.reason == "finished"
    pull, most = -history["c.force_y"], stress * (2 if law == "lagrange" else 1)
    assert pull.max() == pytest.approx(most, rel=1e-12)
    closed = E * speed / height * history.time < most
    np.testing.assert_allclose(pull[closed], E * speed / height * history.time[closed], atol=1e-9)
    assert not pull[len(pull[closed]) + 1 :].any()  # and nothing once it is open
    assert contact.gap.max() == pytest.approx(-speed * 0.4)


@pytest.mark.parametrize("upwards, holds", [(9.99, True), (10.01, False)])
def test_a_block_hangs_by_adhesion(upwards, holds):
    """Of 10 kg, by 100 N; pulled off it flies freely but for the one step."""
    solid = block(gravity=(0, upwards))
    contact = Contact(solid, "base", FLOOR, Adhesive(100.0), name="c")
    history = Scene([solid], [contact]).run(0.1, 1e-3)
    lift = solid.place[1] - HEIGHT / 2
    if holds:
        assert abs(lift) < 1e-12
        np.testing.assert_allclose(history["c.force_y"][1:], -upwards * MASS)
    else:
        assert lift == pytest.approx(0.5 * upwards * 0.099**2, rel=0.01)


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("law", ["gap", "velocity", Compliance(1e8, tangential_stiffness=1e8)])
def test_what_is_pulled_off_in_statics_is_named(law, friction):
    """By 1 % more than the glue bears, or than a load that presses on springs; 1 % less is held."""
    stress = 1e3
    held = {"prescribed": {"left": (0.0, None)}} if not friction else {}
    glued, pressed = (Adhesive(stress, law), 0) if isinstance(law, str) else (law, 1)
    for share in (0.99, 1.01):
        solid = ElasticSolid(
            rectangle((3, 2), (1.0, 0.5)),
            youngs_modulus=1e6,
            poisson_ratio=0.0,
            density=1.0,
            tractions={"top": (0.0, (share - pressed) * stress)},
            name="block",
            **held,
        )
        contact = Contact(solid, "base", FLOOR, glued, friction, name="c")
        history = Scene([solid], [contact], QuasiStatic()).run(1.0, 1.0)
        if share < 1:
            assert history.finished, history.reason
            force = (pressed - share) * stress
            assert history["c.force_y"][-1] == pytest.approx(force, rel=1e-9)
        else:
            assert "contacts cannot hold 'block' against moving along y" in history.reason


# -- restitution -----------------------------------------------------------------------------------


@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_what_is_open_is_not_drawn(theta):
    """A light column pulled off a wall in steps longer than its period, which rebounds: what the
    law of velocities stopped on its way back, 1.6 mm off, was drawn, and made 1.2 % of energy."""
    solid = ElasticSolid(
        rectangle((1, 1), (1.0, 1.0)),
        youngs_modulus=100.0,
        poisson_ratio=0.0,
        density=1e-4,
        prescribed={"top": lambda t: (0, 0.01 * t)},
    )
    contact = Contact(solid, "base", FLOOR, Adhesive(0.3), name="c")
    history = Scene([solid], [contact], ThetaScheme(theta)).run(0.6, 0.01)
    assert history.finished and np.diff(history["impact"]).max() < 1e-12
    assert history["c.force_y"][history.time > 0.325].min() > -1e-12  # 0.3 is reached at 0.3 s


def test_what_has_drifted_is_held():
    """A block is glued to a floor that swings: by its curved way gaps are off by 3e-7 m."""
    solid = ElasticSolid(
        rectangle((4, 2), (0.4, 0.2)),
        youngs_modulus=1e4,
        poisson_ratio=0.3,
        density=1.0,
        velocity=(0, 0.6),
    )
    floor = Moved(FLOOR, lambda t: (0, 0.1 * np.sin(6 * t)))
    contact = Contact(solid, "base", floor, Adhesive(20.0), 1.0, name="c")
    probes = {
        "held": lambda: np.sum(contact.equations.fields.held),
        "gap": lambda: float(contact.gap.min()),
    }
    history = Scene([solid], [contact]).run(1.0, 0.005, probes=probes)
    held = history["held"][history["dt"] > 0]  # not in impacts
    assert history.finished and held.min() == 5 and history["c.bearing"][-1] == 5
    assert history["gap"].min() < -1e-7


def test_what_adheres_and_rubs_is_not_open():
    """Nothing presses but what draws it: the sum of both is none, the pressure that rubs is not."""
    solid = block(gravity=(G, 0.0), held=("turning",), velocity=(0.1, 0.0))
    contact = Contact(solid, "base", FLOOR, Adhesive(250.0), friction=0.2, name="c")
    history = Scene([solid], [contact]).run(0.02, 2e-3)
    assert history["c.slipping"][1:].min() == len(contact.status)
    assert solid.velocity[0] == pytest.approx(0.1 + (G - 0.2 * 250 / MASS) * 0.02, rel=1e-12)


def drop(law, height, until, dt, locate=True):
    solid = block()
    solid.restore({**solid.state(), "place": solid.place + np.array([0, height])})
    contact = Contact(solid, "base", FLOOR, law, name="c")
    scene = Scene([solid], [contact], locate_impacts=locate)
    return scene.run(until, dt, probes={"y": lambda: solid.place[1] - HEIGHT / 2})


@pytest.mark.parametrize("e", [0.5, 0.8, 1.0])
def test_heights_of_rebound(e):
    """e^(2n) of the first, at exact instants: t_n = t_1 (1 + 2 (e + ... + e^n))."""
    height = 0.1
    fall = sqrt(2 * height / G)
    times = fall * (1 + 2 * np.cumsum([0, *(e**n for n in range(1, 4))]))
    history = drop(Restitution(coefficient=e), height, times[-1] + 0.01, 1e-3)
    assert history.finished
    impacts = np.flatnonzero(history["dt"] == 0)[1:]
    np.testing.assert_allclose(history.time[impacts], times, rtol=1e-9)
    kinetic = history["kinetic"][impacts] / (MASS * G * height)
    np.testing.assert_allclose(kinetic, e ** (2 * np.arange(1, 5)), rtol=1e-9)


@pytest.mark.parametrize("locate", [True, False])
def test_a_blow_that_makes_energy_is_refused(locate):
    """Kane's paradox: a tilted square rebounds with e = 1 and slips, with 3.6 % more energy. That
    was measured against what the blow exchanged, accepted, and the flight after it refused."""
    square = moved(rectangle((1, 1), (0.2, 0.2)), 0.0, -0.1)
    low = 0.1 * (np.cos(0.3) + np.sin(0.3))
    square = moved(square, 0.0, low + 0.01)
    solid = RigidSolid(square, mass=2.0, rotation=0.3, velocity=(1.5, -2.0), spin=1.0)
    contact = Contact(solid, "base", FLOOR, Restitution(1.0), friction=0.1)
    history = Scene([solid], [contact], locate_impacts=locate).run(0.02, 1e-3)
    assert re.search(r"contacts would have given 0\.03\d of the energy", history.reason)
    np.testing.assert_allclose(history["kinetic"], history["kinetic"][0], rtol=1e-12)


def test_rebound_by_uniform_steps():
    """Rounded to a step, but as fast as it ought to be."""
    history = drop(Restitution(0.5), 0.1, 0.3, 2e-3, locate=False)
    impact = np.flatnonzero(history["dt"] == 0)[1]
    assert history["kinetic"][impact] / history["kinetic"][impact - 1] == pytest.approx(0.25)
    check_energies(history)


@pytest.mark.parametrize("locate", [True, False])
def test_without_restitution_it_is_the_velocity_law(locate):
    runs = [drop(law, 0.1, 0.3, 5e-3, locate) for law in ("velocity", Restitution())]
    np.testing.assert_array_equal(runs[0].rows(), runs[1].rows())


@pytest.mark.parametrize(
    ("gap", "speeds"), [(1e-6, [0, 0, 0, 0, 1]), (0.0, [-0.6, 0.4, 0.4, 0.4, 0.4])]
)
def test_a_row_of_bodies_is_struck(gap, speeds):
    """One after the other where they are apart, together where they touch; energy is kept."""
    bodies, places = [], [0.0, *(0.2 + 1e-3 + np.arange(4) * (0.2 + gap))]
    for i, at in enumerate(places):
        mesh = moved(rectangle((1, 1), (0.2, 0.2)), at, 0.0)
        bodies.append(
            RigidSolid(
                mesh, mass=1.0, held=["y", "turning"], velocity=(float(i == 0), 0.0), name=f"b{i}"
            )
        )
    contacts = [
        Contact(one, "right", (two, "left"), Restitution(1.0), name=f"{one.name} {two.name}")
        for one, two in zip(bodies, bodies[1:])
    ]
    history = Scene(bodies, contacts, locate_impacts=True).run(0.1, 1e-2)
    assert history.finished
    np.testing.assert_allclose([b.velocity[0] for b in bodies], speeds, rtol=0, atol=1e-9)
    assert history["kinetic"][-1] == pytest.approx(0.5, rel=1e-9)


@pytest.mark.parametrize("theta", [0.5, 0.75, 1.0])
def test_an_oblique_impact_does_not_depend_on_theta(theta):
    """It takes no time: laws read the mean slip of before and after, by which its work goes; they
    had read that of the scheme (1.6925 to 1.6898 m/s, and 13 % of the wear)."""
    law, impulse = Stribeck(0.4, 0.2, 0.5), MASS * 1.5
    mu = lambda v: 0.2 + 0.2 * np.exp(-v / 0.5)  # noqa: E731
    exact = brentq(lambda v: MASS * (2 - v) - impulse * mu((2 + v) / 2), 0, 2, xtol=1e-14)
    for friction in (law, Archard(law, 1e-3, 1e4)):
        solid = block(gravity=(0, 0), velocity=(2.0, -1.0), held=["turning"])
        solid.restore({**solid.state(), "place": solid.place + np.array([0, 0.033])})
        given = solid, Restitution(0.5), ThetaScheme(theta)
        contact, _ = slide(friction, 0.036, 4e-3, *given, locate_impacts=True)
        assert solid.velocity[0] == pytest.approx(exact, rel=1e-7)
    worn = 1e-7 * impulse * (2 + exact) / 2  # its base is a square metre
    np.testing.assert_allclose(contact.memory.values["worn"], worn, rtol=1e-6)


# -- compliance ------------------------------------------------------------------------------------


@pytest.mark.parametrize("exponent", [1, 2, 2.5])
def test_depth_of_normal_compliance(exponent):
    """c d^m = m g: a block let down slowly sinks so deep."""
    solid = block()
    contact = Contact(solid, "base", FLOOR, Compliance(1e8, exponent, damping=5e3), name="c")
    history = Scene([solid], [contact], IMPLICIT).run(5.0, 0.02)
    assert history.reason == "finished"
    assert contact.gap.max() == pytest.approx((MASS * G / 1e8) ** (1 / exponent), rel=1e-9)


@pytest.mark.parametrize("exponent", [1, 2, 2.5])
def test_compliance_gives_back_what_it_stored(exponent):
    """The greatest depth, by the stored energy c d^(m + 1)/(m + 1), and the speed thrown back."""
    c = 1e7
    solid = block(gravity=(0, 0), velocity=(0, -1.0))
    contact = Contact(solid, "base", FLOOR, Compliance(c, exponent), name="c")
    history = Scene([solid], [contact]).run(0.06, 2e-4)
    assert solid.velocity[1] == pytest.approx(1.0, rel=1e-8 if exponent != 2.5 else 1e-4)
    deepest = ((exponent + 1) * MASS / (2 * c)) ** (1 / (exponent + 1))
    assert history["c.penetration"].max() == pytest.approx(deepest, rel=1e-3)


def test_friction_of_normal_compliance():
    """Once the asperities are stretched, by mu p over their stiffness, Coulomb's."""
    solid = thrown()
    start = HEIGHT / 2 - MASS * G / 1e8
    solid.restore({**solid.state(), "place": np.array([0.0, start])})
    law = Compliance(1e8, tangential_stiffness=1e8)
    _, history = slide(0.25, 0.2, 2e-3, solid, law, IMPLICIT)
    assert history["v"][-1] == pytest.approx(1 - 0.25 * G * 0.2, abs=2e-3)


# -- what is refused ------------------------------------------------------------------------------


def contact_with(friction, law="velocity"):
    return Contact(block(), "base", FLOOR, law, friction)


@pytest.mark.parametrize(
    "make, says",
    [
        (lambda: Coulomb(-0.1), "friction = -0.1: must be a finite number >= 0"),
        (lambda: contact_with(lambda x: -0.1 - 0 * x[0]), "friction.*>= 0 in UFL.*it is -0.1"),
        (lambda: contact_with(lambda x: x), "friction = .*must be a scalar"),
        (lambda: contact_with(lambda x: "much"), "friction = .*must be a scalar"),
        (lambda: contact_with("much"), "friction = 'much': must be a finite number"),
        (lambda: StaticKinetic(0.2, 0.3), r"kinetic = 0.3: .*<= 0.2"),
        (lambda: Stribeck(0.3, 0.2, 0.0), "speed = 0.0: .*> 0"),
        (lambda: Stribeck(0.3, 0.2, 1.0, exponent=0.5), "exponent = 0.5: .*>= 1"),
        (lambda: RateState(A, B, 0.0, MU, V0), "distance = 0.0: .*> 0"),
        (lambda: RateState(A, B, D, MU, V0, law="linear"), "law = 'linear': must be one of"),
        (lambda: Archard(0.2, -1.0, 1e6), "coefficient = -1.0: .*>= 0"),
        (lambda: Archard(0.2, 1e-3, 0.0), "hardness = 0.0: .*> 0"),
        (lambda: Archard(0.0, 1e-3, 1e6), "friction = 0.0: must be > 0"),
        (lambda: contact_with(Archard(0.2, 1e-3, 1e6), "lagrange"), "'lagrange': forces at points"),
        (lambda: contact_with(Archard(0.2, 1e-3, 1e6), "printed"), "'printed': .*before the step"),
        (lambda: Adhesive(-1.0), "stress = -1.0: .*>= 0"),
        (lambda: Adhesive(1.0, Discrete(1e6)), "law = .*must be a formulation with multipliers"),
        (lambda: Restitution(coefficient=1.1), "coefficient = 1.1: .*<= 1"),
        (lambda: Compliance(0.0), "coefficient = 0.0: .*> 0"),
        (lambda: Compliance(1e8, 0.5), "exponent = 0.5: .*>= 1"),
        (lambda: contact_with(0.2, Compliance(1e8)), "= None: .*friction needs it.*> 0"),
    ],
)
def test_bad_parameters_are_refused(make, says):
    with pytest.raises(InputError, match=says):
        make()


@pytest.mark.parametrize("law", [StaticKinetic, partial(Stribeck, speed=1.0)])
def test_kinetic_friction_is_the_lesser_where_both_vary(law):
    """As of two numbers, at each point; in a later step, too."""
    rises = lambda x: 0.2 + 0.1 * x[0]  # noqa: E731
    for static, kinetic in ((0.2, rises), (rises, 0.2), (rises, lambda x: 0.3 + 0 * x[0])):
        says = r"static - kinetic = .*: must be a scalar >= 0 .*; at \[.* it is -0"
        with pytest.raises(InputError, match=says):
            contact_with(law(static, kinetic))
    contact_with(law(lambda x: 0.3 + 0.1 * x[0], rises))
    body = thrown()
    contact = Contact(body, "base", FLOOR, friction=law(lambda x, t: 0.3 - t + 0 * x[0], 0.25))
    history = Scene([body], [contact]).run(0.1, 2e-3)
    assert "static - kinetic must be finite and >= 0; at [" in history.reason
    assert history.time[-1] == pytest.approx(0.05, abs=4e-3)


@dataclass(frozen=True)
class Own:
    """A law that reads a parameter, or remembers from a start."""

    what: str
    value: object

    def bound(self, k, pressure, S):
        if self.what == "field":
            return k.field("own", self.value) * pressure
        return 0.1 * pressure + 0 * k.state("own", self.value, lambda old, time: old)

    def describe(self):
        return "own"


@pytest.mark.parametrize("varies", [False, True])
@pytest.mark.parametrize("value", [-1.0, 0.0, float("nan")])
def test_numbers_of_own_laws_are_asked_as_functions_are(value, varies):
    """Numbers had not been: -1 made friction that drives. What is remembered may be negative, of a
    function, too, which was refused."""
    given = (lambda x: value + 0 * x[0]) if varies else value
    refused = {"field": not value >= 0, "state": np.isnan(value)}
    for what, is_refused in refused.items():
        if is_refused:
            with pytest.raises(
                InputError, match=f"own = .*: must be a .*; at|own = {value}: must be"
            ):
                contact_with(Own(what, given))
        else:
            memory = contact_with(Own(what, given)).memory.values
            assert (memory["own"] == value).all() if what == "state" else not memory
    age = RateState(A, B, D, MU, V0, theta=lambda x: value - 1 + 0 * x[0])
    with pytest.raises(InputError, match=r"theta = .*: must be a scalar >= 0"):
        contact_with(age)


def test_a_function_of_another_mesh_is_refused():
    elsewhere = rectangle((1, 1), (0.1, 0.1)).mesh
    friction = fem.Function(compat.lagrange_space(elsewhere))
    with pytest.raises(InputError, match="outside of its mesh"):
        contact_with(friction)


@pytest.mark.parametrize("law", ["coulomb", "static-kinetic"])
def test_a_parameter_that_becomes_negative_ends_the_run(law):
    """It was asked at the start only, and friction then gave energy."""
    falling = 0.3, 10.0  # mu = 0.3 - 10 t
    mu = lambda x, t: falling[0] - falling[1] * t  # noqa: E731
    body = thrown()
    friction = mu if law == "coulomb" else StaticKinetic(mu, 0.0)
    history = Scene([body], [Contact(body, "base", FLOOR, friction=friction)]).run(0.1, 2e-3)
    assert not history.finished
    assert "must be finite and >= 0; at [" in history.reason
    assert history.time[-1] == pytest.approx(0.03, rel=0.05)
    assert np.isfinite(history["kinetic"]).all()


@pytest.mark.parametrize("plane", ["strain", "axisymmetric"])
@pytest.mark.parametrize("metre", [1.0, 1e3])
def test_wear_of_a_solid_of_revolution(plane, metre):
    """Worn depth k/H p s, in any unit of length; it was 2 pi r times that."""
    inner, outer, wear, hardness, speed = 0.1 * metre, 0.2 * metre, 1e-6, 1e9 / metre, 2.0 * metre
    mesh = rectangle((4, 2), (outer - inner, 0.05 * metre))
    mesh.mesh.geometry.x[:, 0] += 0.5 * (inner + outer)
    ring = ElasticSolid(
        mesh,
        youngs_modulus=1e8 / metre,
        poisson_ratio=0.0,
        density=1e3 / metre**3,
        plane=plane,
        tractions={"top": (0, -1e5 / metre)},
        prescribed={"left": (0, None), "right": (0, None)},
    )
    belt = LevelSet(lambda x, t: x[1], dim=2, velocity=lambda x, t: (speed, 0.0))
    contact = Contact(ring, "base", belt, "gap", friction=Archard(1e-6, wear, hardness))
    assert Scene([ring], [contact], QuasiStatic()).run(1.0, 0.1).finished
    expected = wear / hardness * contact.pressure * speed
    np.testing.assert_allclose(contact.memory.values["worn"], expected, rtol=1e-5)


def test_what_remembers_by_the_name_of_another_is_refused():
    """The first of the two stood still, and friction was 0.1 + 2 way for 0.2 + 2 way."""

    class Way:
        def bound(self, k, pressure, status):
            way = k.state("way", 0.0, lambda old, time: old + k.slip_speed * time)
            return (0.1 + way) * pressure

        def describe(self):
            return "0.1 + way"

    class Both(Way):
        def bound(self, k, pressure, status):
            return sum(Way().bound(k, pressure, status) for _ in range(2))

    slide(Way(), 0.01)
    with pytest.raises(InputError, match="name = 'way': two laws of a contact"):
        slide(Both(), 0.01)

    class Worn(Way):
        def bound(self, k, pressure, status):
            for name in ("one", "other"):
                k.wears(name, lambda depth, time: depth + 1e-9 * k.slip_speed * time)
            return 0.1 * pressure

    with pytest.raises(InputError, match="name = 'other': a law of the contact wears"):
        slide(Worn(), 0.01)


@pytest.mark.parametrize("dt, located", [(2e-3, False), (2e-4, False), (2e-2, True), (2e-3, True)])
def test_wear_does_not_hang_on_the_step(dt, located):
    """By the velocity law, whose points are struck again as they wear: impacts wore nothing, and
    points that bear nothing did, 240 times too much where impacts are located."""
    k, hardness, until = 1e-3, 1e2, 0.1
    mesh = rectangle((4, 1), (1.0, 0.02))
    solid = RigidSolid(mesh, mass=MASS, gravity=(0, -G), velocity=(2.0, 0.0))
    floor = Archard(0.1, k, hardness)
    contact = Contact(solid, "base", FLOOR, "velocity", friction=floor, name="c")
    history = Scene([solid], [contact], locate_impacts=located).run(until, dt)
    assert history.finished
    worn = (contact.memory.values["worn"] * contact.surface.area).sum()
    way = solid.place[0] - solid.centre[0]
    assert worn == pytest.approx(k * MASS * G * way / hardness, rel=0.03)
