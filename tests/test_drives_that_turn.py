# SPDX-License-Identifier: LGPL-3.0-or-later
"""Statics of what only contact holds, and slides, where its drive turns round: the slips of the
step before lead far off, and a step begins as if what bears were glued."""

import numpy as np
import pytest

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    Moved,
    QuasiStatic,
    Scene,
    mesh_from_gmsh,
    neo_hookean,
)

E, NU, RADIUS, SEAT = 5e6, 0.45, 0.0025, 0.02
SQUEEZE = 8e-4


def ring(kind, friction, until=1.5, augmentation=1.0):
    """An O-ring in its gland: the lid comes down in ten steps, and is drawn back. (r, z)"""
    mesh = mesh_from_gmsh("disc.geo", R=RADIUS, h=6e-4, coarse=9e-4)
    mesh.mesh.geometry.x[:, 0] += SEAT
    given = dict(density=1200.0, plane="axisymmetric", name="ring")
    if kind == "linear":
        solid = ElasticSolid(mesh, youngs_modulus=E, poisson_ratio=NU, **given)
    else:
        solid = HyperelasticSolid(mesh, energy=neo_hookean(E, NU), **given)
    lid = Moved(HalfSpace((0, RADIUS), (0, -1)), lambda t: (0.0, -SQUEEZE * min(t, 2.0 - t)))
    walls = {
        "lid": ("over", lid),
        "base": ("under", HalfSpace((0, -RADIUS), (0, 1))),
        "bore": ("left", HalfSpace((SEAT - RADIUS, 0), (1, 0))),
    }
    contacts = [
        Contact(
            solid,
            facets,
            wall,
            "gap",
            friction=friction,
            tangential_augmentation=augmentation,
            name=name,
        )
        for name, (facets, wall) in walls.items()
    ]
    return Scene([solid], contacts, QuasiStatic()).run(until=until, dt=0.1, shortest=2**-4)


@pytest.mark.parametrize("kind", ["linear", "hyperelastic"])
def test_an_o_ring_is_pressed_and_let_go(kind):
    """It took 1165 iterations where the lid turns, 29 if linear."""
    history = ring(kind, 0.2)
    assert history.finished and not history.remarks
    assert history["newton"].max() <= 8
    # all that the lid presses the others bear, and on its way back it bears less
    pressed, back = history["lid.force_y"][9], history["lid.force_y"][11]
    assert history["base.force_y"][9] + history["bore.force_y"][9] == pytest.approx(-pressed)
    assert 0.99 * pressed < back < 0
    total = history["strain"] + history["kinetic"]
    took = sum(history[name] for name in ("drive", "friction", "impact", "scheme"))
    np.testing.assert_allclose(total - total[0], took, atol=1e-6 * total.max())


def test_whatever_the_augmentation_it_ends_there():
    """With little friction it took 1117 iterations, or ended silently in another equilibrium, in
    which the ring had rolled over."""
    first, second = (ring("hyperelastic", 0.05, 1.3, augmentation) for augmentation in (0.1, 1.0))
    assert first.finished and second.finished
    np.testing.assert_allclose(second["lid.force_y"], first["lid.force_y"], rtol=1e-7)
    assert max(first["newton"].max(), second["newton"].max()) <= 60
