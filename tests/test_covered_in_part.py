# SPDX-License-Identifier: LGPL-3.0-or-later
"""Facets of a slave that reach beyond their master: they bear and are struck where both are."""

from __future__ import annotations

import numpy as np
import pytest
from corpus_meshes import moved
from scenes import G, rectangle

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
)


def plank(aside, facets, law="velocity", theta=0.5, slave="plank", **scene):
    """A plank of 2 m on a pedestal of 0.4 m, its middle beside that of the latter; its spin after
    0.2 s, and the scene."""
    upper = moved(rectangle((facets, 1), (2.0, 0.1)), aside, 0.0)
    above = RigidSolid(upper, mass=3.0, gravity=(0, -G), name="plank")
    lower = moved(rectangle((1, 1), (0.4, 0.4)), 0.0, -0.4)
    below = RigidSolid(lower, mass=1.0, held=["x", "y", "turning"], name="pedestal")
    both = [(above, "base", (below, "top")), (below, "top", (above, "base"))]
    contact = Contact(*both[slave != "plank"], law, name="c")
    scene = Scene([above, below], [contact], ThetaScheme(theta), **scene)
    history = scene.run(0.2, 5e-3, progress=False)
    assert history.finished and not history.remarks, (history.reason, history.remarks)
    return float(above.velocity[2])


@pytest.mark.parametrize(
    ("law", "theta"), [("velocity", 0.5), ("velocity", 1.0), ("gap", 1.0), ("lagrange", 1.0)]
)
def test_a_plank_tips_about_the_edge_of_what_bears_it(law, theta):
    """However few its facets are: it lay in equilibrium with its weight beside its support, or
    tipped about the next of its nodes; the pedestal as the slave knows the edge by its own node."""
    known = plank(0.5, 1, law, theta, slave="pedestal")
    assert known == pytest.approx(-1.3767, rel=1e-3)
    for facets in (1, 2, 5, 13):
        assert plank(0.5, facets, law, theta) == pytest.approx(known, rel=1e-5)
        assert abs(plank(0.19, facets, law, theta)) < 1e-9
        assert plank(0.21, facets, law, theta) < -0.03


@pytest.mark.parametrize("facets", [1, 2, 5, 10])
def test_a_box_that_lands_on_a_lever(facets):
    """A box that cannot turn, 0.1 m wide, lands at 2 m/s beside the pivot of a lever whose top is
    the slave: it is struck at the inner corner of the box, r = 0.75 m: w = v m r/(I + m r²)."""
    bar = moved(rectangle((facets, 1), (2.0, 0.1)), 0.0, -0.05)
    lever = RigidSolid(bar, mass=3.0, held=["x", "y"], name="lever")
    box = moved(rectangle((1, 1), (0.1, 0.1)), 0.8, 0.15)
    drop = RigidSolid(box, mass=1.0, velocity=(0, -2.0), held=["turning"], name="drop")
    contact = Contact(lever, "top", (drop, "base"), name="c")
    scene = Scene([lever, drop], [contact], locate_impacts=True)
    spin = {"spin": lambda: float(lever.velocity[2])}
    history = scene.run(0.055, 5e-3, progress=False, probes=spin)
    struck = np.argmax(history["kinetic"] < 1.9)
    inertia, arm = 3.0 / 12 * (2.0**2 + 0.1**2), 0.75
    turns = -2.0 * arm / (inertia + arm**2)
    assert history["spin"][struck] == pytest.approx(turns, rel=1e-9)
    after = 0.5 * (inertia + arm**2) * turns**2
    assert history["kinetic"][struck] == pytest.approx(after, rel=1e-9)


@pytest.mark.parametrize("facets", [1, 4, 16])
def test_statics_of_a_plank_that_nothing_holds_are_refused(facets):
    """Its weight beside its support: some meshes found forces at a node in the air."""
    stuff = {"youngs_modulus": 1e8, "poisson_ratio": 0.3, "density": 15.0}
    reasons = []
    for aside in (0.1, 0.5):
        upper = moved(rectangle((facets, 1), (2.0, 0.1)), aside, 0.0)
        above = ElasticSolid(upper, gravity=(0, -G), name="plank", **stuff)
        lower = moved(rectangle((2, 2), (0.4, 0.4)), 0.0, -0.4)
        below = ElasticSolid(lower, fixed=["base"], name="pedestal", **stuff)
        contact = Contact(above, "base", (below, "top"), "gap", friction=0.3, name="c")
        history = Scene([above, below], [contact], QuasiStatic()).run(1.0, 1.0, progress=False)
        reasons.append(history.reason)
    assert reasons[0] == "finished"
    assert "contacts cannot hold 'plank' against turning" in reasons[1]
