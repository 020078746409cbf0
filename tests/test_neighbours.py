# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pairs of rigid bodies that stay apart sleep, and leaving them out changes nothing."""

import numpy as np
import pytest
from mpi4py import MPI
from scenes import skinned

from fenicsx_contact import Contact, HalfSpace, Restitution, RigidSolid, Scene, name_facets
from fenicsx_contact.base import compat
from fenicsx_contact.steps.neighbours import Neighbours

SIZE = 0.08


def moved(x, y, **motion):
    """A box of which the whole skin may meet others."""
    return skinned(2, SIZE, (x - SIZE / 2, y), **motion)


def columns(n=6, **scene):
    """Boxes that fall on each other, each of which may meet all others and the floor."""
    boxes = [
        moved(0.1 * (i % 3) + 0.003 * (i % 2), 0.02 + 0.12 * (i // 3), gravity=(0, -9.81))
        for i in range(n)
    ]
    floor = HalfSpace((0, 0), (0, 1))
    contacts = [Contact(b, "skin", floor, friction=0.4, name=f"floor {b.name}") for b in boxes]
    contacts += [
        Contact(b, "skin", (a, "skin"), friction=0.4, name=f"{b.name} {a.name}")
        for i, b in enumerate(boxes)
        for a in boxes[:i]
    ]
    return Scene(boxes, contacts, **scene)


@pytest.mark.second
def test_boxes_fall_alike_whether_pairs_sleep_or_not(monkeypatch):
    scene = columns()
    with_sleep, most = scene.run(0.2, 2e-3, progress=False), len(scene.contacts)
    assert with_sleep.finished and len(scene.stepper.contacts) < most
    monkeypatch.setattr(Neighbours, "look", lambda *_: False)
    waking = columns().run(0.2, 2e-3, progress=False)
    assert len(waking) == len(with_sleep)
    for name in ("kinetic", "potential", "impact", "friction"):
        size = np.ptp(waking["potential"])
        np.testing.assert_allclose(with_sleep[name], waking[name], atol=1e-9 * size)


def shot(force, gap, velocity=0.0):
    """A body at rest, and another that is driven to it; neither turns, which pushed from behind it
    would."""
    drive = {"force": lambda t: (-force * (t > 0.01), 0.0), "velocity": (-velocity, 0.0)}
    target = moved(0.0, 0.0, held=["turning"])
    bullet = moved(SIZE + gap, 0.0, held=["turning"], **drive)
    return Scene([target, bullet], [Contact(target, "skin", (bullet, "skin"))])


@pytest.mark.parametrize("force", [1e3, 1e4, 1e5, 3e5, 1e6])
@pytest.mark.parametrize("gap", [0.02, 1.0])
def test_what_is_driven_across_within_a_step_wakes_what_it_meets(force, gap):
    """At 1e6 N it would be 7 m beyond the body by the end of the first step in which it moves, from
    rest, and no step so long may let them change places unseen."""
    scene = shot(force, gap)
    history = scene.run(0.15, 1e-2, progress=False)
    assert history.finished, history.reason
    target, bullet = scene.solids
    assert target.velocity[0] == pytest.approx(bullet.velocity[0], rel=1e-9)
    # the step stops what loads bring within it: that went half of its way, at most half a body
    apart = (bullet.place[0] - target.place[0]) / SIZE
    assert 0.75 < apart < 1 + 1e-9
    impulse = target.mass * (target.velocity[0] + bullet.velocity[0])
    assert impulse == pytest.approx(-force * 0.14, rel=0.04)


@pytest.mark.parametrize("velocity", [1.0, 30.0, 1e3, 1e5])
def test_a_fast_body_does_not_pass_through_another(velocity):
    scene = shot(0.0, 0.5, velocity)
    history = scene.run(1.0 / velocity, 0.1 / velocity, progress=False)
    assert history.finished, history.reason
    for solid in scene.solids:
        assert solid.velocity[0] == pytest.approx(-velocity / 2, rel=1e-9)


@pytest.mark.second
def test_boxes_resume_bit_for_bit(tmp_path):
    whole = columns().run(0.2, 2e-3, directory=tmp_path / "whole", progress=False)
    scene, count = columns(), iter(range(1000))
    scene.run(
        0.2, 2e-3, directory=tmp_path / "cut", progress=False, stop_when=lambda: next(count) > 60
    )
    rest = columns().run(0.2, 2e-3, directory=tmp_path / "cut", resume=True, progress=False)
    assert np.array_equal(rest.rows(), whole.rows())


@pytest.mark.parametrize("solver", ["condensed", "monolithic"])
def test_columns_of_boxes_come_to_rest(solver):
    """Boxes that fall on each other and stop, by no method but Newton's; bodies that rest already
    are not asked for digits of a momentum that they do not have."""
    scene = columns(solver=solver)
    boxes, ground = scene.solids, [c for c in scene.contacts if len(c.solids) == 1]
    history = scene.run(0.2, 2e-3, progress=False)
    assert history.finished and not history.remarks, history.reason
    fallen = -np.ptp(history["potential"])
    assert history["kinetic"][-1] < 1e-12 * history["kinetic"].max()
    assert history["impact"][-1] + history["friction"][-1] == pytest.approx(fallen, rel=1e-9)
    weight = sum(box.mass for box in boxes) * 9.81
    assert sum(contact.force[:, 1].sum() for contact in ground) == pytest.approx(weight, rel=1e-9)
    assert max(contact.depth() for contact in scene.contacts) < 1e-3 * SIZE


@pytest.mark.parametrize("gap", [1e-4, 5e-4, 9.5e-4, 5e-3])
def test_a_pair_that_a_blow_wakes_is_struck(gap):
    """Three discs tip to tip, e = 1: the next pair woke up when the blow before it was known, and
    was not asked: it lost half of the energy, without a word."""
    angles = 2 * np.pi * np.arange(24) / 24
    ring = 0.05 * np.column_stack([np.cos(angles), np.sin(angles)])
    fan = np.array([[0, 1 + i, 1 + (i + 1) % 24] for i in range(24)])
    discs = []
    for k in range(3):
        points = np.vstack([np.zeros(2), ring]) + np.array([k * (0.1 + gap), 0.0])
        mesh = compat.create_mesh(MPI.COMM_SELF, fan, points, "triangle")
        skin = name_facets(mesh, {"skin": lambda x: np.full(x.shape[1], True)})
        start = {"velocity": (1.0 if k == 0 else 0.0, 0.0), "held": ("y", "turning")}
        discs.append(RigidSolid(skin, mass=1.0, name=f"disc {k}", **start))
    contacts = [
        Contact(a, "skin", (b, "skin"), Restitution(1.0), name=f"before {b.name}")
        for a, b in zip(discs, discs[1:])
    ]
    history = Scene(discs, contacts).run(0.04, 1e-3, progress=False)
    assert history.finished, history.reason
    np.testing.assert_allclose([disc.velocity[0] for disc in discs], [0, 0, 1], atol=1e-9)
    assert history["kinetic"][-1] == pytest.approx(0.5, rel=1e-9)
