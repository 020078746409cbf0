# SPDX-License-Identifier: LGPL-3.0-or-later
"""Obstacles between the nodes of coarse facets: told, where nothing else would say so."""

from __future__ import annotations

import numpy as np
import pytest
from corpus_meshes import moved
from scenes import FLOOR, G, box, rectangle

from fenicsx_contact import (
    Box,
    Circle,
    Contact,
    Cylinder,
    ElasticSolid,
    LevelSet,
    Moved,
    QuasiStatic,
    RigidSolid,
    Scene,
    Sphere,
)


def dropped(obstacle, cells, dim=2, law="velocity", **solid):
    """What a run says of a rigid body of 0.4 m and so many cells across that falls on an obstacle
    whose top is at z = 0."""
    mesh = (
        rectangle((cells, 1), (0.4, 0.2)) if dim == 2 else box((cells, cells, 1), (0.4, 0.4, 0.2))
    )
    body = RigidSolid(mesh, mass=1.0, gravity=-G * np.eye(dim)[-1], **solid)
    contact = Contact(body, "base", obstacle, law, friction=0.3, name="c")
    history = Scene([body], [contact]).run(until=0.3, dt=5e-3)
    assert history.finished
    return [text for _, text in history.remarks if "between the points that bear" in text], history


PEDESTALS = {
    2: Box((0.0, -0.5), (0.2, 1.0)),
    3: Box((0.0, 0.0, -0.5), (0.2, 0.2, 1.0)),
}


@pytest.mark.parametrize("law", ["velocity", "gap"])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_body_that_falls_through_is_told(dim, law):
    """One of a single cell on a narrower pedestal: it "finished", without a force, and without a
    word."""
    (told,), history = dropped(PEDESTALS[dim], 1, dim, law)
    assert not history[f"c.force_{'xyz'[dim - 1]}"].any()
    assert "'c': its obstacle was 0.1 m inside facets of 0." in told
    none, history = dropped(PEDESTALS[dim], 8, dim, law)
    assert not none
    assert history[f"c.force_{'xyz'[dim - 1]}"][-1] == pytest.approx(G, rel=1e-6)


def test_one_that_the_edge_of_a_table_cuts():
    """Its only node there stands, where the edge should bear."""
    told, _ = dropped(Box((-0.35, -0.5), (0.6, 1.0)), 1)
    assert told


@pytest.mark.parametrize(
    "obstacle",
    [
        FLOOR,
        Circle((0.0, 1.98), 2.0, inside=True),
        Circle((0.0, -0.2), 0.2),
        LevelSet(lambda x, t: x[1] + 0.1 * x[0] ** 2, dim=2),
        Moved(Circle((0.0, -0.2), 0.2), lambda t: (0.1 * t, 0.0)),
    ],
    ids=["floor", "bowl", "circle", "level set", "moved"],
)
def test_what_is_as_wide_as_facets_is_not(obstacle):
    told, _ = dropped(obstacle, 4)
    assert not told


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_soft_body_pressed_by_what_is_thin(dim, degree):
    """Facets as long as a die is wide let it pass; a quarter of that do not."""
    die = (
        Circle((0.0, -0.03), 0.03)
        if dim == 2
        else Cylinder((0.0, 0.0, -0.03), (0.0, 1.0, 0.0), 0.03)
    )

    def told(cells):
        size = (0.4,) * (dim - 1) + (0.2,)
        if dim == 2:
            mesh = moved(rectangle((cells, cells // 2), size), 0.2 / cells, 0.0)
        else:
            mesh = moved(box((cells, 1, 2), size), 0.2 / cells, 0.0, 0.0)
        down = {"top": lambda t: (0.0,) * (dim - 1) + (-0.04 * t,)}
        block = ElasticSolid(
            mesh, youngs_modulus=1e6, poisson_ratio=0.3, density=1.0, degree=degree, prescribed=down
        )
        contact = Contact(block, "base", die, "gap", name="c")
        history = Scene([block], [contact], QuasiStatic()).run(until=1.0, dt=0.25)
        return [text for _, text in history.remarks if "between the points that bear" in text]

    assert told(4)
    assert not told(64)


def test_a_ball_within_a_facet_in_space():
    (told,), _ = dropped(Sphere((0.0, 0.0, -0.05), 0.05), 1, dim=3)
    assert "inside facets" in told
