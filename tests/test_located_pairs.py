# SPDX-License-Identifier: LGPL-3.0-or-later
"""Located impacts between two solids, and what solutions that diverge leave behind."""

import warnings

import numpy as np
import pytest
from corpus_meshes import moved
from scenes import FLOOR, FLOOR_3D, box, rectangle, total_energy

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HyperelasticSolid,
    Restitution,
    RigidSolid,
    Scene,
    neo_hookean,
)
from fenicsx_contact.theory.scheme import Step

DT = 1e-3


def solid(kind, mesh, **more):
    if kind is RigidSolid:
        return RigidSolid(mesh, density=1000.0, **more)
    if kind is HyperelasticSolid:
        return HyperelasticSolid(mesh, energy=neo_hookean(1e6, 0.3), density=1000.0, **more)
    return ElasticSolid(mesh, youngs_modulus=1e6, poisson_ratio=0.3, density=1000.0, **more)


def thrown(kinds=(ElasticSolid, ElasticSolid), *, tilt=0.1, across=1.0, friction=0.0, **scene):
    """A tilted block that flies onto the middle of another, which floats."""
    mesh = rectangle((3, 3), (0.36, 0.8))
    (c, s), x = (np.cos(tilt), np.sin(tilt)), mesh.mesh.geometry.x
    x[:, :2] = x[:, :2] @ np.array([[c, s], [-s, c]])
    low = rectangle((4, 3), (1.0, 0.6))
    ground = low.mesh.geometry.x[:, 1].max()
    moved(mesh, 0.0, ground + 0.01 - x[:, 1].min())
    block = solid(kinds[0], mesh, velocity=(across, -3.0), name="block")
    other = solid(kinds[1], low, velocity=(0.0, 0.0), name="other")
    contact = Contact(block, "base", (other, "top"), friction=friction, name="c")
    return Scene([block, other], [contact], locate_impacts=True, **scene)


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize(
    "kinds",
    [
        (RigidSolid, RigidSolid),
        (RigidSolid, ElasticSolid),
        (ElasticSolid, RigidSolid),
        (ElasticSolid, ElasticSolid),
        (HyperelasticSolid, HyperelasticSolid),
    ],
    ids=lambda kinds: "-".join(kind.__name__.removesuffix("Solid") for kind in kinds),
)
def test_impacts_of_a_pair_are_located(kinds, friction):
    """A point that leaves from inside, where the mortar's means leave it, does not arrive."""
    history = thrown(kinds, friction=friction).run(0.03, DT, progress=False)
    assert history.finished, history.reason
    told = ("method of multipliers", "inside its master")  # between nodes
    assert all(any(each in what for each in told) for _, what in history.remarks)  # none was cut
    impacts = history["dt"][1:] == 0
    assert impacts.any() and len(history) < 6 * 30
    assert history["dt"][1:][~impacts].min() > 1e-8 * DT
    energy = total_energy(history)
    assert np.diff(energy).max() < 1e-3 * energy[0]


@pytest.mark.parametrize("master", [RigidSolid, ElasticSolid])
def test_slips_that_turn_round_need_newtons_method_alone(master):
    history = thrown((ElasticSolid, master), friction=0.3).run(0.03, DT, progress=False)
    assert not [what for _, what in history.remarks if "method of multipliers" in what]


@pytest.mark.parametrize("inside", [1e-5, 0.0, -1e-5])
def test_who_is_inside_is_not_open(inside):
    """Leaving or not: it may bear in a flight, in which only open points may not close."""
    mesh = moved(rectangle(), 0.0, -inside)
    contact = Contact(RigidSolid(mesh, mass=1.0, velocity=(0.0, 0.1)), "base", FLOOR)
    assert contact.touching().any() == (inside > 0)


def test_flights_scale_multipliers_once():
    """After an impact, of which multipliers are impulses, a step may be tried many times."""
    block = RigidSolid(rectangle(), mass=1.0, velocity=(0.0, -1.0), gravity=(0, -9.81))
    contact = Contact(block, "base", FLOOR)
    scene = Scene([block], [contact])
    rows = scene.step(DT)
    next(rows)  # the impact
    impulse = contact.equations.multiplier.copy()
    assert impulse.min() < 0 and contact.moved == 0
    for _ in range(3):
        step = Step(DT, scene.scheme, scene.time)
        block.predict(step)
        contact.begin(step)
        contact.predict(step)
        np.testing.assert_allclose(contact.equations.multiplier, impulse / DT)


@pytest.mark.parametrize("size", [1e9, 1e80, 1e160, np.inf, np.nan])
def test_an_iterate_that_diverges_is_told(size):
    """Whatever its places are: by a reason, no bare exception, nor with warnings."""
    scene = thrown(solver="monolithic")
    block, system = scene.solids[0], scene.stepper._method.system
    iterate = system.iterate

    def diverge(step):
        done = iterate(step)
        block.go(block.trial_velocity + size, step)
        return done

    system.iterate = diverge
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        history = scene.run(DT, DT, shortest=0.5, progress=False)
    assert not history.finished
    assert "stalls" in history.reason or "nowhere" in history.reason


@pytest.mark.second
def test_a_percussion_whose_points_contradict_each_other_by_how_they_lie():
    """Two points that stick between rigid solids are as far from each other on either as they lie,
    to 3e-10 of the speeds: the run stopped there, as any shorter step begins with the same."""

    def flung(name, n, size, low, mass, **motion):
        mesh = box(n, size)
        x = mesh.mesh.geometry.x
        x[:] += (-size[0] / 2, -size[1] / 2, low) - x.min(axis=0)
        return RigidSolid(mesh, mass=mass, gravity=(0, 0, -9.81), name=name, **motion)

    first = flung(
        "first",
        (3, 1, 2),
        (0.176, 0.251, 0.546),
        0.01158275,
        0.12,
        rotation=(-0.0503592933, -0.0719418475, 0.0),
    )
    second = flung(
        "second",
        (1, 4, 3),
        (0.304, 0.245, 0.141),
        0.57167449,
        2.62,
        velocity=(-0.2710187734, -0.1479508046, -0.4548696134),
        rotation=(-0.0074046384, -0.0105780549, 0.0),
    )
    third = flung(
        "third",
        (1, 3, 4),
        (0.5, 0.147, 0.54),
        0.71518347,
        9.35,
        spin=(2.4658842883, 0.806192101, -2.80395367),
    )
    law, friction = Restitution(0.2), 1.5
    contacts = [
        Contact(first, "base", FLOOR_3D, law, friction),
        Contact(second, "base", (first, "top"), law, friction),
        Contact(third, "base", (second, "top"), law, friction),
    ]
    history = Scene([first, second, third], contacts, locate_impacts=True).run(0.096, 2e-3)
    energy = history["kinetic"] + history["potential"]
    assert history.finished and np.diff(energy).max() < 1e-6 * energy[0]
