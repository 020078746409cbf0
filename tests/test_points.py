# SPDX-License-Identifier: LGPL-3.0-or-later
"""Points change nothing: with points between the corners of its base a rigid block rocks, falls and
slides as it does without, by every law and step; a dropped bar bounces as d'Alembert says. No
contact gives energy to anything, in no row of any history."""

from __future__ import annotations

from functools import cache
from math import radians
from pathlib import Path

import numpy as np
import pytest
from corpus_motion import BAR, dropped_bar, exact_bar, landed_energies, spells, standing
from scenes import G, energy_size, total_energy

from fenicsx_contact import (
    Contact,
    Discrete,
    HalfSpace,
    RigidSolid,
    Scene,
    Velocity,
    mesh_from_gmsh,
)
from fenicsx_contact.references.housner import Block, rocking

MASS = 417.6
BASES = [(1, False), (2, False), (3, False), (4, False), (10, False), (50, False)]
BASES += [(4, True), (10, True)]
SHAPES = [(0.36, 0.80), (0.20, 1.00), (0.50, 0.80)]
#: law, theta, impacts located, steps until the first impact
WAYS = [
    ("velocity", 0.5, False, 150),
    ("velocity", 1.0, False, 150),
    ("gap", 1.0, False, 150),
    ("lagrange", 1.0, False, 150),
    ("velocity", 0.5, True, 20),
    ("velocity", 1.0, True, 150),
]
long = pytest.mark.long


def finished(scene, until, dt, **others):
    history = scene.run(until, dt, progress=False, **others)
    assert history.finished, history.reason
    assert np.isfinite(history.rows()).all()
    return history


def never_gains(history, tolerance=1e-9):
    """The total is nowhere above any that was before, by the energies that took part."""
    total = total_energy(history) - history["drive"]
    most = np.maximum.accumulate(total)
    assert (total[1:] - most[:-1]).max() <= tolerance * energy_size(history)
    assert (total - total[0]).max() <= tolerance * energy_size(history)


# -- rocking --


def rock(facets, uneven, way, size=SHAPES[0], tilt=0.01, dim=2, finer=1):
    """Relative errors of the energies after four landings, and what the order of the step allows:
    an impact rounded to a step moves the energy by some dt over the quarter swing, and they add
    up; located, only the motion has an error, of the order of its scheme."""
    law, theta, located, steps = way
    exact = rocking(Block(*size, MASS), tilt, impacts=5)
    times = exact.impact_times
    dt = times[0] / (steps * finer)
    scene = standing(
        facets, law, theta, uneven=uneven, dim=dim, size=size, tilt=tilt, located=located
    )
    history = finished(scene, times[4], dt)
    never_gains(history)
    share = dt / (np.diff(times[:4], prepend=-times[0]) / 2)
    order = 2 if located and theta == 0.5 else 1
    energies = landed_energies(history, exact)
    bound = (1 if order == 2 else 8) * np.cumsum(share**order)
    return energies / exact.block.energy_ratio ** np.arange(1, 5) - 1, bound


def few(parameters, quick):
    """The parameters, marked long but for some."""
    return [p if i in quick else pytest.param(*p, marks=long) for i, p in enumerate(parameters)]


@pytest.mark.parametrize("way", WAYS, ids=lambda way: "-".join(map(str, way)))
@pytest.mark.parametrize(("facets", "uneven"), few(BASES, {0, 1, 4, 6}))
def test_rocking(facets, uneven, way):
    errors, bound = rock(facets, uneven, way)
    assert (np.abs(errors) < bound).all(), (errors, bound)


@long
@pytest.mark.parametrize("way", WAYS, ids=lambda way: "-".join(map(str, way)))
@pytest.mark.parametrize(("facets", "uneven"), BASES)
@pytest.mark.parametrize("tilt", [radians(0.01), 0.01])
@pytest.mark.parametrize("size", SHAPES)
def test_rocking_of_three_shapes(size, tilt, facets, uneven, way):
    errors, bound = rock(facets, uneven, way, size, tilt)
    assert (np.abs(errors) < bound).all(), (errors, bound)


@pytest.mark.parametrize("size", SHAPES)
@pytest.mark.parametrize("tilt", [radians(0.01), 0.01])
@pytest.mark.parametrize(("facets", "uneven"), BASES)
def test_rocking_located(facets, uneven, tilt, size):
    """To second order, whatever the shape, the tilt and the points."""
    errors, bound = rock(facets, uneven, WAYS[4], size, tilt)
    assert (np.abs(errors) < bound).all(), (errors, bound)


@pytest.mark.parametrize("way", [WAYS[0], WAYS[2], WAYS[4]], ids=["velocity", "gap", "located"])
@pytest.mark.parametrize(("facets", "uneven"), few(BASES, {0, 1, 6}))
def test_rocking_in_space(facets, uneven, way):
    law, theta, located, steps = way
    way = law, theta, located, max(20, steps // 3)
    errors, bound = rock(facets, uneven, way, dim=3)
    assert (np.abs(errors) < bound).all(), (errors, bound)


@long
@pytest.mark.parametrize("way", WAYS, ids=lambda way: "-".join(map(str, way)))
@pytest.mark.parametrize(("facets", "uneven"), BASES)
def test_rocking_converges(facets, uneven, way):
    """The bounds halve, or fall to a quarter, with the step, and the errors stay within them."""
    for finer in (2, 4, 8):
        errors, bound = rock(facets, uneven, way, finer=finer)
        assert (np.abs(errors) < bound).all(), (finer, errors, bound)


@pytest.mark.parametrize("n_width", [1, 2, 3, 10])
def test_ten_lines_of_the_readme(n_width):
    """Just after the first impact the block keeps 4.073 J."""
    meshes = Path(__file__).parent.parent / "meshes"
    mesh = mesh_from_gmsh(meshes / "block.geo", width=0.36, height=0.80, n_width=n_width)
    block = RigidSolid(mesh, mass=MASS, gravity=(0, -G), rotation=0.01, about=(-0.18, 0))
    contact = Contact(block, "base", HalfSpace((0, 0), (0, 1)), "velocity", friction=0.9)
    history = finished(Scene([block], [contact], locate_impacts=True), 0.15, 2e-3)
    impacts = np.flatnonzero(history["dt"][1:] == 0) + 1
    impact = impacts[history.time[impacts] < history.time[impacts[0]] + 1e-3][-1]
    assert history["kinetic"][impact] == pytest.approx(4.073, abs=0.001)


# -- dropped flat --

DROPS = [(law, theta, located) for law, theta, located, _ in WAYS]
DROPS += [(Velocity(drift_correction=kappa), 0.5, False) for kappa in (0.1, 1.0)]
DROPS += [(Velocity(drift_correction=1.0), 1.0, False)]


def name_of(way):
    return f"{way[0] if isinstance(way[0], str) else way[0].drift_correction}-{way[1]}-{way[2]}"


@pytest.mark.parametrize("way", DROPS, ids=name_of)
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize(("facets", "uneven"), few(BASES, {0, 1, 4, 6}))
def test_dropped_flat_stays(facets, uneven, dim, way):
    """It lands within a step of the exact time and does not rise again: e = 0."""
    law, theta, located = way
    scene = standing(facets, law, theta, uneven=uneven, dim=dim, floor=-0.05, located=located)
    block, fall = scene.solids[0], np.sqrt(2 * 0.05 / G)
    dt = fall / 40.4
    probes = {"v": lambda: block.velocity[dim - 1], "turn": lambda: np.abs(block.rotation).max()}
    history = finished(scene, 1.6 * fall, dt, probes=probes)
    never_gains(history)
    speed = G * fall
    after = history["v"][history.time > fall + 1.5 * dt]
    # above the floor by what a step rounds, it may fall, or be drawn down by a drift correction
    assert after.max() < 1e-9 * speed
    assert history["kinetic"][-1] < 1e-4 * MASS * speed**2 / 2
    assert history["turn"].max() < 1e-9
    assert history["c.penetration"].max() <= speed * dt
    impulse = history.impulse("c")[-1]
    assert impulse[-1] == pytest.approx(MASS * G * history.time[-1], rel=0.02)
    assert np.abs(impulse[:-1]).max() < 1e-8 * impulse[-1]


# -- sliding --


@pytest.mark.parametrize("way", DROPS, ids=name_of)
@pytest.mark.parametrize(("facets", "uneven"), few(BASES, {0, 1, 4, 6}))
def test_sliding_block_stops(facets, uneven, way):
    """After v/(mu g), at v²/(2 mu g), and turns no hair, whatever is under it."""
    law, theta, located = way
    scene = standing(
        facets, law, theta, uneven=uneven, size=(2.0, 0.5), friction=0.3, located=located,
        velocity=(2.0, 0.0),
    )  # fmt: skip
    block, stop, steps = scene.solids[0], 2.0 / (0.3 * G), 100.4
    start = block.place
    history = finished(scene, 1.2 * stop, stop / steps)
    never_gains(history)
    way_made = block.place - start
    distance = 2.0**2 / (2 * 0.3 * G)
    assert way_made[0] == pytest.approx(distance, rel=(2 if theta == 1.0 else 0.1) / steps)
    assert abs(way_made[1]) < 1e-9 and abs(block.rotation) < 1e-9
    assert np.abs(block.velocity).max() < 1e-9
    assert history["friction"][-1] == pytest.approx(-MASS * 2.0**2 / 2, rel=1e-8)


# -- a bar dropped under gravity --

UNTIL = 12.6
#: law, theta, share of the energy that 400 cells may lose; None: theta = 1 damps the waves, and
#: times follow the energy
BARS = {
    "velocity": ("velocity", 0.5, 0.005),
    "drift": (Velocity(drift_correction=1.0), 0.5, 0.005),
    "gap": ("gap", 0.5, 0.003),
    "springs": (Discrete(1e4 * 900.0), 0.5, 0.01),
    "damped": ("gap", 1.0, None),
}


@cache
def exact_contacts():
    return exact_bar(UNTIL)


def bounce(name, cells, late):
    """Three landings; springs may be stopped where they would make energy, saying so."""
    law, theta, lost = BARS[name]
    scene, dt = dropped_bar(cells, law, theta)
    history = scene.run(UNTIL, dt, progress=False)
    never_gains(history, 1e-6)
    if name == "springs" and "energy" in history.reason:
        return
    assert history.finished, history.reason
    times = spells(history.time, history["c.force_y"] > 0)
    assert len(times) >= 3
    if lost is None:
        return
    np.testing.assert_allclose(times[:3], exact_contacts(), rtol=late)
    energy = BAR["length"] * BAR["gravity"] * BAR["fall"]
    total = total_energy(history)
    assert total[0] - total[-1] <= lost * 400 / cells * energy


@pytest.mark.parametrize("name", BARS)
def test_dropped_bar(name):
    bounce(name, 40, 0.03)


@long
@pytest.mark.parametrize("name", BARS)
@pytest.mark.parametrize(("cells", "late"), [(100, 0.015), (400, 0.01)])
def test_dropped_bar_fine(name, cells, late):
    """Contact times of three landings within 1 %."""
    bounce(name, cells, late)
