# SPDX-License-Identifier: LGPL-3.0-or-later
"""What must not matter: who looks at it, how nodes are numbered, how a surface slides in itself."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import G, rectangle

from fenicsx_contact import (
    Circle,
    Contact,
    Moved,
    Restitution,
    RigidSolid,
    Scene,
    ThetaScheme,
    Turned,
)


@pytest.mark.parametrize(
    "theta, law", [(0.5, "velocity"), (1.0, "velocity"), (0.5, Restitution(0.6))]
)
def test_how_fast_a_frictionless_drum_turns_changes_nothing(theta, law):
    """It slides into itself, seen by who stands or who passes by, and drives nothing."""

    def slid(rate=None, passing=0.0):
        drum = Circle((0.0, -1.5), 1.5)
        if rate is not None:
            drum = Turned(drum, (0.0, -1.5), lambda t: rate * t + 40 * t**2)
        drum = Moved(drum, lambda t: (passing * t, 0.0)) if passing else drum
        mesh = rectangle((3, 2), (0.5, 0.3))
        x = mesh.mesh.geometry.x
        x[:, :2] = x[:, :2] @ [[np.cos(0.1), np.sin(0.1)], [-np.sin(0.1), np.cos(0.1)]] + [
            -0.1,
            0.03,
        ]
        start = {"velocity": (1.5 + passing, 0.0), "spin": 1.0}
        block = RigidSolid(mesh, density=15.0, gravity=(0, -G), **start)
        scene = Scene([block], [Contact(block, "base", drum, law)], ThetaScheme(theta))
        history = scene.run(until=0.16, dt=4e-3)
        assert history.reason == "finished"
        return block.velocity - [passing, 0, 0], history

    still, rest = slid()
    assert rest["impact"][-1] < -0.05
    for rate, passing in ((-30.0, 0.0), (30.0, 5.0)):
        velocity, history = slid(rate, passing)
        np.testing.assert_allclose(velocity, still, atol=2e-4)  # of the rounds
        np.testing.assert_allclose(history["impact"], rest["impact"], atol=1e-4)
        if not passing:
            assert np.abs(history["drive"]).max() < 1e-12
