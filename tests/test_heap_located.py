# SPDX-License-Identifier: LGPL-3.0-or-later
"""Located impacts of two boxes in space: where they are struck they touch, told by their axes, as
two boxes overlap if and only if no axis separates them."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import box

from fenicsx_contact import Heap, RigidSolid, Scene, name_facets


def thrown(seed):
    """Two boxes of any shape, thrown at each other, spinning; and their half sizes."""
    rng = np.random.default_rng(seed)
    bodies, halves = [], []
    for k in range(2):
        half, middle = rng.uniform(0.05, 0.2, 3), np.zeros(3)
        middle[0] = 0.6 * k
        middle[1:] += k * rng.uniform(-0.15, 0.15, 2)
        mesh = box((1, 1, 1), 2 * half)
        x = mesh.mesh.geometry.x
        x += middle - (x.min(axis=0) + x.max(axis=0)) / 2
        velocity = rng.uniform(-0.3, 0.3, 3)
        velocity[0] += 1.0 - 2 * k
        turn, spin = rng.uniform(-1, 1, 3), rng.uniform(-3, 3, 3)
        given = {"mass": 1.0 + k, "velocity": velocity, "rotation": turn, "spin": spin}
        skin = name_facets(mesh.mesh, {"skin": lambda x: np.full(x.shape[1], True)})
        bodies.append(RigidSolid(skin, name=f"b{k}", **given))
        halves.append(half)
    return bodies, halves


def apart(bodies, halves):
    """The largest distance of the two along an axis that may separate them, m."""
    A, B = (body.trial_turn for body in bodies)
    way = bodies[1].place - bodies[0].place
    axes = [*A.T, *B.T, *(np.cross(a, b) for a in A.T for b in B.T)]
    found = []
    for axis in axes:
        if (size := np.linalg.norm(axis)) > 1e-6:
            n = axis / size
            reach = sum(h @ np.abs(turn.T @ n) for h, turn in zip(halves, (A, B)))
            found.append(abs(way @ n) - reach)
    return max(found)


def hit(seed, dt):
    bodies, halves = thrown(seed)
    scene = Scene(bodies, [Heap(bodies, "skin")], locate_impacts=True)
    history = scene.run(0.4, dt, probes={"apart": lambda: apart(bodies, halves)})
    assert history.finished, history.reason
    ends = np.concatenate([body.velocity for body in bodies])
    return history, ends


@pytest.mark.parametrize("seed", [10, 19, 26, 28, 39])
def test_boxes_are_struck_where_they_touch(seed):
    """Corners that pass beside a face, or edges beyond their ends, were struck a millimetre apart;
    and what a flight that was not taken had left behind hid edges that crossed 13 mm deep."""
    history, ends = hit(seed, 1e-2)
    fine, exact = hit(seed, 5e-4)
    for each in (history, fine):
        blows = (each["dt"][1:] == 0) & (np.diff(each["impact"]) < -1e-9)
        assert blows.any()
        assert np.abs(each["apart"][1:][blows]).max() < 1e-5
        assert each["apart"].min() > -1e-5
    np.testing.assert_allclose(ends, exact, rtol=0, atol=0.05 * np.abs(exact).max())
