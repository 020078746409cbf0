# SPDX-License-Identifier: LGPL-3.0-or-later
"""Forces, torques, springs and held components of rigid solids, against exact motions."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import FLOOR, G, box, check_energies, rates, rectangle, total_energy
from scipy.integrate import solve_ivp

from fenicsx_contact import (
    Contact,
    GeneralisedAlpha,
    InputError,
    RigidSolid,
    Scene,
    ThetaScheme,
)

MASS, K = 3.0, 50.0


def rigid(dim=2, **others):
    mesh = rectangle() if dim == 2 else box()
    return RigidSolid(mesh, **{"mass": MASS, **others})


def run(solid, until, steps, scheme=None, **probes):
    history = Scene([solid], [], scheme, allow_free=True).run(until, until / steps, probes=probes)
    assert history.finished, history.reason
    size = np.abs(total_energy(history)).max() + history["kinetic"].max()
    assert np.abs(history["balance"]).max() < 1e-7 * size  # the outer loop ends at 1e-8
    return history


@pytest.mark.parametrize("dim", [2, 3])
def test_a_spring_makes_an_oscillator(dim):
    """About where it hangs; the trapezoidal rule has tan(w'dt/2) = w dt/2."""
    down, start = np.eye(dim)[-1], 0.2
    centre = rigid(dim).centre
    solid = rigid(dim, springs={tuple(centre): K}, gravity=-G * down, velocity=start * down)
    omega, dt = np.sqrt(K / MASS), 0.05
    history = run(solid, 3.0, 60, y=lambda: (solid.place - centre)[-1])
    phase = 2 * np.arctan(omega * dt / 2) / dt * history.time
    rest = -MASS * G / K
    exact = rest * (1 - np.cos(phase)) + start / omega * np.sin(phase)
    np.testing.assert_allclose(history["y"], exact, rtol=0, atol=1e-7)
    total = total_energy(history)
    np.testing.assert_allclose(total, total[0], rtol=0, atol=1e-9 * np.ptp(history["potential"]))
    check_energies(history, 1e-9)


@pytest.mark.parametrize("scheme", [ThetaScheme(), GeneralisedAlpha(0.8)])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_hinged_solid_swings(dim, scheme):
    """Its centre is held, a spring at its top draws it back: ``I a'' = (arm x f)(a)``, large."""
    names = ["x", "y"] if dim == 2 else ["x", "y", "z", "turning about x", "turning about z"]
    top = np.eye(dim)[-1] * 0.8
    solid = rigid(dim, held=names, springs={tuple(top): K}, spin=3.0 if dim == 2 else (0, 3.0, 0))
    inertia = solid.inertia[0, 0] if dim == 2 else solid.inertia[1, 1]
    arm = 0.4

    def rate(_, state):
        # the top moves by arm (sin a, cos a - 1): energy K arm² (1 - cos a)
        return [state[1], -K * arm**2 * np.sin(state[0]) / inertia]

    exact = solve_ivp(rate, (0, 2.0), [0.0, 3.0], rtol=1e-11, atol=1e-11).y[0, -1]
    errors = []
    for steps in (100, 200, 400):
        solid = rigid(
            dim, held=names, springs={tuple(top): K}, spin=3.0 if dim == 2 else (0, 3.0, 0)
        )
        place = solid.place
        history = run(solid, 2.0, steps, scheme)
        end = solid.rotation if dim == 2 else solid.rotation[1]
        errors.append(abs(end - exact))
        np.testing.assert_array_equal(solid.place, place)
        assert np.ptp(total_energy(history)) < 0.02 * total_energy(history)[0]
    assert errors[-1] < 1e-3
    np.testing.assert_allclose(rates(errors), 2, atol=0.2)


def test_a_pendulum_hangs_by_a_stiff_spring():
    """A physical pendulum: period of ``I_o a'' = -m g l sin a`` by small swings."""
    inertia = rigid().inertia[0, 0] + MASS * 0.4**2
    omega, start = np.sqrt(MASS * G * 0.4 / inertia), {"spin": 0.02, "velocity": (0.008, 0.0)}
    errors = []
    for steps in (200, 400):
        solid = rigid(gravity=(0, -G), springs={(0.0, 0.8): 1e7}, **start)
        period = 2 * np.pi / omega
        history = run(solid, period, steps, a=lambda s=solid: s.rotation)
        exact = 0.02 / omega * np.sin(omega * history.time)
        errors.append(np.abs(history["a"] - exact).max() * omega / 0.02)
    assert errors[-1] < 2e-3


def test_what_spins_about_a_held_centre_keeps_its_energy():
    """The weight of a held centre counts for nothing, but without it moments were not balanced:
    one iteration a step, a certificate of 0, and 2 % of the energy unexplained."""
    spins = []
    for weight in (0.0, 1e-6):
        solid = RigidSolid(
            box((1, 1, 1), (0.2, 0.4, 0.8)),
            mass=5.0,
            spin=(3.0, 6.0, 0.0),
            rotation=(0.4, 0.3, 0.2),
            gravity=(0, 0, -weight),
            held=["x", "y", "z", "turning about z"],
        )
        history = run(solid, 5.0, 50)
        assert history["kinetic"].max() < 1.001 * history["kinetic"][0]
        spins.append(solid.velocity)
    np.testing.assert_allclose(*spins, atol=1e-6)


@pytest.mark.parametrize("dim", [2, 3])
def test_moments_of_opposite_springs(dim):
    """Their forces balance but for round-off, against which nothing is to be measured: steps were
    cut for "a relative error of 0.07"."""
    mesh = rectangle((1, 1), (0.1, 1.0)) if dim == 2 else box((1, 1, 1), (0.1, 0.1, 1.0))
    middle = RigidSolid(mesh, mass=1.0).centre
    up, spin = np.eye(dim)[-1] / 2, 12.0 if dim == 2 else (0, 12.0, 0)
    springs = {tuple(middle + up): 100.0, tuple(middle - up): 100.0}
    history = run(RigidSolid(mesh, mass=1.0, spin=spin, springs=springs), 5.0, 500)
    assert not history.remarks and history["geometry"].max() <= 3


@pytest.mark.parametrize("scheme", [ThetaScheme(), GeneralisedAlpha(1.0)])
def test_forces_and_torques_in_time(scheme):
    """Exact for what is linear in t; their works stand under drive."""
    solid = rigid(force=lambda t: (2.0 * t, 1.0), torque=lambda t: 0.3 * t)
    place = solid.place
    history = run(solid, 1.0, 20, scheme)
    inertia = solid.inertia[0, 0]
    np.testing.assert_allclose(solid.velocity, [1 / MASS, 1 / MASS, 0.15 / inertia], rtol=1e-12)
    moved = np.array([1 / 3, 1 / 2]) / MASS
    np.testing.assert_allclose(solid.place - place, moved, atol=1e-3)
    kinetic = history["kinetic"][-1]
    assert history["drive"][-1] == pytest.approx(kinetic, rel=1e-12)
    assert np.abs(history["scheme"]).max() < 1e-12 * kinetic
    steady = rigid(3, force=(1.0, 0.0, 2.0), torque=(0.0, 0.0, 0.1), held=["y", "turning about x"])
    run(steady, 0.5, 20)
    np.testing.assert_allclose(steady.velocity[:4], [0.5 / MASS, 0, 1 / MASS, 0], atol=1e-12)
    assert steady.velocity[5] == pytest.approx(0.05 / steady.inertia[2, 2], rel=1e-9)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("scheme", [ThetaScheme(), ThetaScheme(1.0), GeneralisedAlpha(0.8)])
def test_what_is_applied_works_on_the_way_gone(scheme, dim):
    """As weight does: what else the mean velocities would tell is of the scheme."""
    pull, turn = 5.0 * np.eye(dim)[0], 2.0 if dim == 2 else (0.0, 0.0, 2.0)
    held = ["y", "turning about x", "turning about y"] if dim == 3 else []
    drawn, turned = rigid(dim, force=pull), rigid(dim, torque=turn, held=held)
    weighted, start = rigid(dim, gravity=pull / MASS), rigid(dim).place
    by_weight = run(weighted, 0.5, 25, scheme)
    for solid, way in (
        (drawn, lambda: 5.0 * (drawn.place - start)[0]),
        (turned, lambda: 2.0 * np.atleast_1d(turned.rotation)[-1]),
    ):
        history = run(solid, 0.5, 25, scheme)
        assert history["drive"][-1] == pytest.approx(way(), rel=1e-12)
        books = history["drive"] + history["scheme"] - history["kinetic"]
        np.testing.assert_allclose(books, 0.0, atol=1e-12 * history["drive"][-1])
        if solid is drawn:
            for column in ("scheme", "kinetic"):
                np.testing.assert_allclose(history[column], by_weight[column], atol=1e-12)


def test_what_is_applied_works_on_the_way_that_bodies_are_put_back():
    """A block turns about its corner on another one, which keeps its gap by shifts."""
    below = rectangle((4, 1), (2.0, 0.2))
    below.mesh.geometry.x[:, 1] -= 0.2
    found = []
    for load in ({"gravity": (0, -G)}, {"force": (0, -MASS * G)}):
        solid = rigid(rotation=-0.5, about=(0.18, 0.0), **load)
        ground = RigidSolid(below, mass=1.0, held=["x", "y", "turning"], name="ground")
        contact = Contact(solid, "base", (ground, "top"), friction=0.9, name="c")
        history = Scene([solid, ground], [contact]).run(0.2, 1e-2)
        assert history.finished, history.reason
        found.append((history, history["drive"] - history["potential"] + history["potential"][0]))
    (by_weight, fallen), (by_force, driven) = found
    assert np.abs(by_weight["scheme"]).max() > 1e-6 * fallen[-1]  # by what was put back
    np.testing.assert_allclose(driven, fallen, atol=1e-12 * fallen[-1])
    np.testing.assert_allclose(by_force["scheme"], by_weight["scheme"], atol=1e-12 * fallen[-1])


@pytest.mark.parametrize("solver", ["condensed", "monolithic"])
def test_a_held_block_on_the_floor(solver):
    """Held against turning and along x it is dropped, pushed, and stays; the floor bears all."""
    solid = rigid(
        gravity=(0, -G), held=["x", "turning"], force=(7.0, -5.0), velocity=(0, -0.5), torque=2.0
    )
    contact = Contact(solid, "base", FLOOR, "gap", friction=0.3, name="c")
    scene = Scene([solid], [contact], ThetaScheme(1.0), geometry="newton", solver=solver)
    history = scene.run(0.2, 1e-2)
    assert history.finished, history.reason
    assert history["c.force_y"][-1] == pytest.approx(MASS * G + 5.0, rel=1e-9)
    np.testing.assert_allclose(solid.velocity, 0.0, atol=1e-12)
    assert solid.rotation == 0.0


def test_springs_bear_beside_contact_and_resume():
    """A block on springs dips into a floor; its state continues to the last bit."""

    def scene():
        solid = rigid(gravity=(0, -G), springs={(-0.18, 0.0): K, (0.18, 0.0): (0.0, 2 * K)})
        return Scene([solid], [Contact(solid, "base", FLOOR, "gap", friction=0.2, name="c")])

    whole, half = scene(), scene()
    history = whole.run(0.2, 1e-3)
    assert history.finished, history.reason
    assert history["c.force_y"].max() > 0
    half.run(0.1, 1e-3)
    again = scene()
    again.restore(half.state())
    again.run(0.2, 1e-3)
    np.testing.assert_array_equal(again.solids[0].velocity, whole.solids[0].velocity)


def test_what_is_not_asked_for_is_not_there():
    solid = rigid()
    assert not solid.applied and not solid.springs and not len(solid.held)
    assert not solid.supported and "spring" not in solid.describe()
    held = rigid(held=["x"], springs={(0.0, 0.0): 1.0})
    assert "held ['x']" in held.describe() and "spring (0.0, 0.0): [1.0, 1.0]" in held.describe()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"force": (1.0,)}, "force = "),
        ({"force": lambda t: (np.nan, t)}, r"force\(0\) = "),
        ({"force": "hard"}, "force = "),
        ({"torque": (1.0, 0.0)}, "torque = "),
        ({"torque": lambda t: 1j}, r"torque\(0\) = "),
        ({"springs": [(0.0, 0.0)]}, "springs = .*dict"),
        ({"springs": {(0.0,): 1.0}}, r"springs: the point = \(0.0,\): must be 2"),
        ({"springs": {"base": 1.0}}, r"springs: the point = 'base': must be 2"),
        ({"springs": {(0.0, 0.0): -1.0}}, r"springs\[\(0.0, 0.0\)\] = -1.0: .*>= 0"),
        ({"springs": {(0.0, 0.0): (1.0, np.inf)}}, r"springs\[\(0.0, 0.0\)\]"),
        ({"held": ["z"]}, "held = 'z': must be one of 'x', 'y', 'turning'"),
        ({"held": 3}, "held = 3"),
        ({"held": "x", "velocity": (1.0, 0.0)}, r"held = \['x'\].*without a velocity"),
    ],
)
def test_bad_input_is_refused(given, message):
    with pytest.raises(InputError, match=message):
        rigid(**given)
