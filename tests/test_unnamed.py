# SPDX-License-Identifier: LGPL-3.0-or-later
"""What no contact names goes through what its solid stands on, which is told."""

import numpy as np
import pytest
from scenes import FLOOR, rectangle

from fenicsx_contact import Contact, RigidSolid, Scene


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


def test_what_reaches_beyond_from_the_start():
    """A hook that rests on a plane by its upper part: what hangs below is meant to."""
    mesh = rectangle((2, 2), (1.0, 0.2))
    x = mesh.mesh.geometry.x
    x[:, 1] += np.where(x[:, 0] > 0.25, -0.3, 0.0)
    hook = RigidSolid(mesh, mass=1.0, velocity=(1.0, 0.0), name="hook")
    history = Scene([hook], [Contact(hook, "left", FLOOR, name="c")]).run(0.1, 1e-2)
    assert history.finished and hook.places(x[:, :2])[:, 1].min() < -0.2
    assert not told(history)
