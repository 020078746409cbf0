# SPDX-License-Identifier: LGPL-3.0-or-later
"""What no contact names goes through what its solid stands on, which is told."""

import numpy as np
import pytest
from scenes import FLOOR, rectangle

from fenicsx_contact import Compliance, Contact, Discrete, HalfSpace, RigidSolid, Scene


def told(history):
    return [text for _, text in history.remarks if "no contact names" in text]


@pytest.mark.parametrize("named", [["base"], ["base", "right", "top", "left"]])
def test_a_block_that_falls_over(named):
    """It went through the floor up to its middle, finished, without a word."""
    mesh = rectangle((1, 1), (0.36, 0.8))
    mesh.mesh.geometry.x[:, 0] -= 0.36
    block = RigidSolid(
        mesh, mass=417.6, gravity=(0, -9.81), rotation=-0.6, about=(0, 0), name="block"
    )
    contacts = [Contact(block, side, FLOOR, friction=0.9, name=side) for side in named]
    history = Scene([block], contacts).run(1.2, 2e-3, progress=False)
    assert history.finished
    y = block.places(mesh.mesh.geometry.x[:, :2])[:, 1].min()
    assert bool(told(history)) == (y < -0.1) == (len(named) == 1)


@pytest.mark.parametrize("formulation", [Compliance(1e5), Discrete(1e4)])
def test_what_rests_deep_on_springs_has_names_enough(formulation):
    """The sides of its first cells are in the floor, less deep than its base."""
    block = RigidSolid(rectangle((2, 80), (0.4, 0.4)), mass=100.0, gravity=(0, -9.81), name="block")
    history = Scene([block], [Contact(block, "base", FLOOR, formulation, name="c")]).run(0.2, 1e-2)
    assert history["c.penetration"].max() > 0.01 and not told(history)


@pytest.mark.parametrize("other", [FLOOR, HalfSpace((0, -50), (0, 1))])
def test_names_count_before_the_obstacle_that_they_meet(other):
    """Sides that are named for a wall far away meet nothing else."""
    mesh = rectangle((1, 1), (0.36, 0.8))
    mesh.mesh.geometry.x[:, 0] -= 0.36
    given = {"rotation": -0.6, "about": (0, 0), "name": "block"}
    block = RigidSolid(mesh, mass=417.6, gravity=(0, -9.81), **given)
    contacts = [Contact(block, "base", FLOOR, friction=0.9, name="base")]
    for side in ("right", "left", "top"):
        contacts.append(Contact(block, side, other, friction=0.9, name=side))
    history = Scene([block], contacts).run(1.2, 2e-3, progress=False)
    assert bool(told(history)) == (other is not FLOOR)


def test_what_reaches_beyond_from_the_start():
    """A hook that rests on a plane by its upper part: what hangs below is meant to."""
    mesh = rectangle((2, 2), (1.0, 0.2))
    x = mesh.mesh.geometry.x
    x[:, 1] += np.where(x[:, 0] > 0.25, -0.3, 0.0)
    hook = RigidSolid(mesh, mass=1.0, velocity=(1.0, 0.0), name="hook")
    history = Scene([hook], [Contact(hook, "left", FLOOR, name="c")]).run(0.1, 1e-2)
    assert history.finished and hook.places(x[:, :2])[:, 1].min() < -0.2
    assert not told(history)
