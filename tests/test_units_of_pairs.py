# SPDX-License-Identifier: LGPL-3.0-or-later
"""Scales of pairs and their augmentation: they act on the way to a solution, not on it."""

import numpy as np
import pytest
from scenes import rectangle

from fenicsx_contact import Contact, ElasticSolid, QuasiStatic, RigidSolid, Scene


def moved(mesh, dx, dy):
    mesh.mesh.geometry.x[:, :2] += dx, dy
    return mesh


def pressed_die(modulus, beside, **scene):
    """A die comes over a slab, from beside it or not, in four steps, is pressed in and drawn: its
    force as a share of the modulus, and the history."""
    elastic = {"poisson_ratio": 0.3, "density": 1e-12 * modulus}
    slab = ElasticSolid(
        moved(rectangle((10, 4), (1.0, 0.4)), 0.0, -0.4),
        youngs_modulus=modulus,
        fixed=["base"],
        name="slab",
        **elastic,
    )
    start = -1.0 if beside else 0.0

    def way(t):
        drawn, pressed = max(t - 2, 0.0), min(max(t - 1, 0.0), 1.0)
        return (-start * min(t, 1.0) + 0.05 * drawn, -0.03 * pressed)

    die = ElasticSolid(
        moved(rectangle((6, 2), (0.37, 0.15)), start + 0.3, 0.01),
        youngs_modulus=20 * modulus,
        prescribed={"top": way},
        name="die",
        **elastic,
    )
    contact = Contact(die, "base", (slab, "top"), "gap", friction=0.3, name="c")
    scene = Scene([die, slab], [contact], QuasiStatic(), **scene)
    history = scene.run(until=3, dt=0.25, progress=False)
    assert history.finished, history.reason
    force = [history["c.force_x"][-1] / modulus, history["c.force_y"][-1] / modulus]
    return np.array(force), history


@pytest.mark.parametrize("scene", [{}, {"solver": "monolithic", "geometry": "newton"}])
def test_what_starts_beside_its_partner_has_its_own_scales(scene):
    """Scales were those of the first step, in which nothing was covered: 1 Pa s/m, whatever the
    units. Forces were 1e-6 wrong by a modulus of 1e9, and took 166 to 1094 iterations."""
    expected, usual = pressed_die(1.0, False, **scene)
    for modulus in (1e9, 1e-9):
        found, history = pressed_die(modulus, True, **scene)
        np.testing.assert_allclose(found, expected, rtol=1e-9)
        assert history["newton"].max() == usual["newton"].max() <= 6
        assert not history.remarks


def test_one_corner_bears_for_all():
    """A rigid block with a finer mesh than the slab that it slides on: where one corner bore, and
    its slip was to turn round, statuses did not change and 56 to 179 iterations leapt over the
    piece between."""
    slab = ElasticSolid(
        moved(rectangle((4, 2), (2.0, 0.4)), 0.0, -0.4),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        fixed=["base"],
        name="slab",
    )
    mesh = moved(rectangle((9, 1), (0.9, 0.3)), 0.03, 0.02)
    block = RigidSolid(mesh, mass=100.0, gravity=(0, -9.81), spin=0.3, name="block")
    contact = Contact(block, "base", (slab, "top"), "gap", friction=0.3, name="c")
    history = Scene([slab, block], [contact]).run(0.2, 2e-3, progress=False)
    assert history.finished, history.reason
    assert not any("method of multipliers" in remark for _, remark in history.remarks)
    assert history["newton"].max() < 30
