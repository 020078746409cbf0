# SPDX-License-Identifier: LGPL-3.0-or-later
"""Step sizes controlled by an error estimate: ``Scene.run(..., step_error=...)``."""

from __future__ import annotations

from collections import Counter
from math import atan2, pi, radians, sqrt

import numpy as np
import pytest
import scenes
from processes import killed_after
from scenes import FLOOR, G, elastic_block, located_block, rectangle

import fenicsx_contact.solids.balance
import fenicsx_contact.steps.adaptive
import fenicsx_contact.steps.run
from fenicsx_contact import (
    Contact,
    Discrete,
    ElasticSolid,
    HalfSpace,
    InputError,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    read_history,
)
from fenicsx_contact.references.housner import Block, rocking

BLOCK = Block(width=0.36, height=0.80, mass=417.6)


def rock(tilt, until, dt, step_error=None, length=1.0, time=1.0, weight=1.0):
    """A rocking block, impacts located, in units so many times smaller; rows with its tilt."""
    mesh = rectangle(size=(0.36 * length, 0.80 * length))
    block = RigidSolid(
        mesh,
        mass=417.6 * weight,
        gravity=(0, -G * length / time**2),
        rotation=tilt,
        about=(-0.18 * length, 0),
    )
    scene = Scene([block], [Contact(block, "base", FLOOR, friction=0.9)], locate_impacts=True)
    history = scene.run(
        until * time,
        dt * time,
        step_error=step_error,
        probes={"tilt": lambda: block.rotation},
    )
    assert history.finished
    return history


def maxima(history, exact):
    """Worst relative error of the kinetic energies before the percussions."""
    struck = np.flatnonzero(history["dt"] == 0)[1:]
    count = len(exact.kinetic_before)
    return np.abs(history["kinetic"][struck[:count] - 1] / exact.kinetic_before - 1).max()


def slope(tolerances, errors):
    return np.polyfit(np.log(tolerances), np.log(errors), 1)[0]


# -- the error follows the tolerance --


def test_error_of_a_smooth_swing_is_proportional_to_the_tolerance():
    tolerances = np.array([1e-3, 1e-4, 1e-5, 1e-6])
    motion = rocking(BLOCK, 0.3)
    until = 0.9 * motion.impact_times[0]
    errors = []
    for tolerance in tolerances:
        history = rock(0.3, until, until / 2, tolerance)
        errors.append(abs(history["tilt"][-1] - motion.angle(until)) / (0.3 - motion.angle(until)))
    assert (errors < 3 * tolerances).all()
    assert 0.8 < slope(tolerances, errors) < 1.2


def test_error_of_a_slip_that_turns_in_space_is_what_is_asked():
    """Across a slope: friction is against the slip, whose direction turns downhill."""
    friction, until, start = 0.35, 0.6, np.array([2.0, 0, 0])
    way, _ = scenes.exact_slide(friction, start, until)
    for tolerance in (1e-3, 1e-4, 1e-5):
        body, scene = scenes.slide(friction, start)
        before = body.place.copy()
        assert scene.run(until, 0.1, step_error=tolerance).finished
        assert np.linalg.norm(body.place - before - way) < tolerance * np.linalg.norm(way)


@pytest.fixture(scope="module")
def over_impacts():
    """Tolerances, errors and numbers of rows of a block that rocks through three impacts."""
    exact = rocking(BLOCK, 0.1, impacts=3)
    until = exact.impact_times[-1] * 1.01
    tolerances = [1e-3, 1e-4, 1e-5]
    runs = [rock(0.1, until, until / 4, tolerance) for tolerance in tolerances]
    return tolerances, [maxima(h, exact) for h in runs], [len(h) for h in runs]


def test_error_over_impacts_is_proportional_to_the_tolerance(over_impacts):
    tolerances, errors, rows = over_impacts
    assert 0.8 < slope(tolerances, errors) < 1.3
    assert errors[1] < 1e-3
    assert slope(rows, errors) < -1.7  # of second order or better


def test_error_over_impacts_is_of_second_order(over_impacts):
    """Once steps are short: of the largest tolerance a swing is crossed in ten."""
    _, errors, rows = over_impacts
    assert -2.3 < slope(rows[1:], errors[1:]) < -1.7


def test_ten_impacts():
    for tilt in (radians(0.01), 0.01):
        exact = rocking(BLOCK, tilt, impacts=10)
        until = exact.impact_times[-1] * 1.01
        history = rock(tilt, until, until / 8, 1e-4)
        assert maxima(history, exact) < 1e-3
        assert len(history) < 100


def eigenmode():
    """The lowest mode of an elastic block that hangs from its top, and its frequency, rad/s."""
    solid = ElasticSolid(
        rectangle((2, 2), (1.0, 1.0)),
        youngs_modulus=1e4,
        poisson_ratio=0.0,
        density=1.0,
        fixed=["top"],
    )
    free = np.setdiff1d(np.arange(solid.owned), solid.fixed_unknowns)
    unit = np.eye(solid.owned)[free]
    mass, stiffness = (
        np.array([solid.multiply(matrix, column)[free] for column in unit])
        for matrix in (solid._mass, solid.last_stiffness)
    )
    values, vectors = np.linalg.eig(np.linalg.solve(mass, stiffness))
    lowest = int(np.argmin(values.real))
    mode = np.zeros(solid.owned)
    mode[free] = vectors[:, lowest].real
    solid.restore({"displacement": 1e-3 * mode, "velocity": 0 * mode})
    return solid, 1e-3 * mode, sqrt(values[lowest].real)


def test_elastic_vibration():
    """Five periods of one mode and a quarter: the error, that of the phase, follows the tolerance,
    and each length of step is factored once."""
    tolerances = np.array([1e-2, 1e-3, 1e-4])
    errors = []
    for tolerance in tolerances:
        solid, mode, omega = eigenmode()
        dt = 1.05 * 2 * pi / omega
        history = Scene([solid], []).run(5 * dt, dt, step_error=tolerance)
        errors.append(np.linalg.norm(solid.displacement) / np.linalg.norm(mode))
        lengths = np.unique(np.round(np.log2(dt / history["dt"][1:]), 9))
        np.testing.assert_allclose(lengths, np.round(lengths))  # halves of halves
        # as many factors as lengths accepted, refused, and halved to begin with
        assert solid._made <= lengths.max() + 2
    assert 0.8 < slope(tolerances, errors) < 1.2
    # of the largest speed times the time, over the amplitude; of place and speed
    assert (errors < 2 * 5.25 * 2 * pi * tolerances).all()


def bounce(dt, step_error=None):
    """A block on springs, dropped on them again and again, and where it is after 1 s exactly."""
    height, stiffness, mass = 0.1, 2e5, 10.0
    block = RigidSolid(rectangle(size=(0.36, 0.36)), mass=mass, gravity=(0, -G))
    start = block.place
    block.restore({**block.state(), "place": start + np.array([0, height])})
    scene = Scene([block], [Contact(block, "base", FLOOR, Discrete(stiffness / 2))])
    history = scene.run(1.0, dt, step_error=step_error)
    assert history.finished
    v, w = sqrt(2 * G * height), sqrt(stiffness / mass)
    sag = G / w**2
    contact = 2 / w * (pi - atan2(v / w, sag))
    since = (1.0 - v / G) % (2 * v / G + contact)  # the last landing
    exact = -sag + sag * np.cos(w * since) - v / w * np.sin(w * since)
    if since > contact:
        exact = v * (since - contact) - G * (since - contact) ** 2 / 2
    return len(history) - 1, abs(block.place[1] - start[1] - exact) / height


def test_fewer_steps_than_uniform_ones_for_a_smaller_error():
    """Long flights, short contacts with springs, which no flight announces."""
    uniform, error = bounce(2.0**-11)
    steps, adaptive = bounce(2.0**-5, 1e-4)
    assert adaptive < error < 1e-2
    assert steps < uniform / 4


# -- impacts --


@pytest.mark.parametrize("located", [True, False])
def test_impacts_do_not_drive_steps_to_zero(located):
    """Neither located ones nor others, of which the last ones, as it comes to rest, are small."""
    scene = scenes.rocking_block(locate_impacts=located)
    history = scene.run(0.35, 0.05, step_error=1e-2, shortest=2.0**-30)
    assert history.finished and history["c.bearing"].max() > 0
    assert len(history) < 150
    smallest = history["dt"][history["dt"] > 0].min()
    assert smallest > (1e-3 if located else 1e-4) * 0.05


def test_an_impact_that_is_not_located_is_resolved_to_the_tolerance():
    exact = rocking(BLOCK, 0.01, impacts=3)
    errors = []
    for tolerance in (1e-2, 1e-3, 1e-4):
        history = scenes.rocking_block().run(0.236, 0.02, step_error=tolerance, shortest=2.0**-20)
        kinetic = history["kinetic"]
        swing = np.searchsorted(exact.impact_times[:2], history.time - 0.01)
        most = [kinetic[swing == i].max() for i in range(3)]
        errors.append(np.abs(most / exact.kinetic_before - 1).max())
    assert errors[2] < 3e-3 < errors[1] < 3e-2 < errors[0]
    assert len(history) < 400


def test_a_body_at_rest_takes_the_longest_steps():
    block = RigidSolid(rectangle(), mass=10.0, gravity=(0, -G))
    for located in (True, False):
        scene = Scene([block], [Contact(block, "base", FLOOR)], locate_impacts=located)
        history = scene.run(1.0, 0.1, step_error=1e-6)
        assert history.finished and not history.remarks
        np.testing.assert_allclose(history["dt"][1:], 0.1)


def test_what_bears_within_the_tolerance_does_not_arrive():
    """A block that slid had impacts at 5e-13 m, each after half of what was left of a step."""
    block = RigidSolid(
        rectangle((4, 2), (0.4, 0.2)), mass=2.0, gravity=(0, -G), velocity=(1.0, -0.3),
        rotation=0.1, about=(-0.2, 0.0),
    )  # fmt: skip
    scene = Scene([block], [Contact(block, "base", FLOOR, friction=0.3)], locate_impacts=True)
    history = scene.run(0.32, 2e-2, step_error=1e-4)
    assert history.finished and not history.remarks
    impacts = history.time[history["dt"] == 0]
    assert 0.049 < impacts[-1] < 0.051 and len(history) < 60


# -- it does not depend on units, nor on being killed --


def test_units_do_not_matter():
    one = rock(0.05, 0.5, 0.1, 1e-4)
    other = rock(0.05, 0.5, 0.1, 1e-4, length=1e3, time=1e6, weight=1e-3)
    assert len(one) == len(other)
    np.testing.assert_allclose(other.time, 1e6 * one.time, rtol=1e-9)
    np.testing.assert_allclose(other["tilt"], one["tilt"], atol=1e-9)


@pytest.mark.parametrize(
    ("build", "until", "dt"), [(located_block, 0.15, 0.015), (elastic_block, 0.05, 2e-3)]
)
def test_killed_and_resumed_to_the_same_bits(build, until, dt, tmp_path):
    whole = build().run(until, dt, step_error=1e-3)
    assert len(np.unique(whole["dt"][whole["dt"] > 0])) > 3

    with killed_after(5) as saves:
        build().run(until, dt, step_error=1e-3, directory=tmp_path)
    assert len(read_history(tmp_path)) == saves[-1] < len(whole)
    with pytest.raises(InputError, match="another scene"):
        build().run(until, dt, step_error=1e-4, directory=tmp_path, resume=True)
    resumed = build().run(until, dt, step_error=1e-3, directory=tmp_path, resume=True)
    np.testing.assert_array_equal(resumed.rows(), whole.rows())


def test_fields_and_stops_come_at_multiples_of_dt(tmp_path):
    asked = []

    def stop():
        asked.append(scene.time)
        return len(asked) == 6

    scene = elastic_block()
    history = scene.run(
        0.05, 2e-3, step_error=1e-3, directory=tmp_path, fields_every=2, stop_when=stop
    )
    np.testing.assert_allclose(asked, 2e-3 * np.arange(1, 7))
    assert history.time[-1] == asked[-1] and len(history) > 7
    assert len(list((tmp_path / "fields").glob("elastic_*.vtu"))) == 4


def test_each_length_of_step_is_factored_once(monkeypatch):
    made = Counter()
    original = fenicsx_contact.solids.balance.FreeFactorisation

    def counted(matrix, *others):
        made[matrix.norm()] += 1
        return original(matrix, *others)

    monkeypatch.setattr(fenicsx_contact.solids.balance, "FreeFactorisation", counted)
    history = elastic_block().run(0.05, 2e-3, step_error=1e-3)
    assert max(made.values()) == 1
    assert sum(made.values()) < len(history) / 5


# -- off, and refused --


def test_without_a_step_error_nothing_of_it_is_there(monkeypatch):
    def refuse(*_):
        raise AssertionError("made")

    monkeypatch.setattr(fenicsx_contact.steps.run, "ErrorControl", refuse)
    history = located_block().run(0.05, 1e-3)
    assert history.finished and "error" not in history.times
    with pytest.raises(AssertionError, match="made"):
        located_block().run(0.05, 1e-3, step_error=1e-3)


@pytest.mark.parametrize("value", [0.0, -1e-3, 2.0, np.nan, np.inf, "small"])
def test_bad_errors_are_refused(value):
    with pytest.raises(InputError, match="step_error = "):
        located_block().run(0.1, 1e-2, step_error=value)


@pytest.mark.parametrize("scheme", [ThetaScheme(0.6), ThetaScheme(1.0), ThetaScheme(0.5, "end")])
def test_schemes_of_first_order_are_refused(scheme):
    block = RigidSolid(rectangle(), mass=1.0)
    scene = Scene([block], [Contact(block, "base", FLOOR)], scheme)
    with pytest.raises(InputError, match=r"step_error = 0\.001: .*second order"):
        scene.run(0.1, 1e-2, step_error=1e-3)


def test_without_inertia_it_is_refused():
    solid = ElasticSolid(
        rectangle(), youngs_modulus=1.0, poisson_ratio=0.0, density=1.0, fixed=["top"]
    )
    contact = Contact(solid, "base", HalfSpace((0, -1), (0, 1)), "gap")
    with pytest.raises(InputError, match="without inertia"):
        Scene([solid], [contact], QuasiStatic()).run(1.0, 0.1, step_error=1e-3)


def test_a_shortest_step_is_taken_with_a_remark():
    history = located_block().run(0.1, 0.05, step_error=1e-9, shortest=2.0**-3)
    assert history.finished and len(history) > 10
    (_, remark), *_ = history.remarks
    assert remark.startswith("shortest step: error ") and remark.endswith("above 1e-09")
