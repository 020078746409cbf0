# SPDX-License-Identifier: LGPL-3.0-or-later
"""What is kept while two surfaces move changes nothing but the time."""

import numpy as np
import pytest
from scenes import pressed_blocks, rectangle

from fenicsx_contact import Contact, HyperelasticSolid, Scene, neo_hookean
from fenicsx_contact.base.checks import StepFailed
from fenicsx_contact.contact.mortar import Pairing, Side
from fenicsx_contact.contact.mortar.search import Near, Spheres, candidates
from fenicsx_contact.solve import sparse as direct
from fenicsx_contact.solve.condensed import Condensed


def line(n: int, left: float, right: float, y: float, inside: float, degree: int) -> Side:
    """A line of n facets, whose solid is on the side of ``inside``."""
    x = np.linspace(left, right, n + 1)
    points = np.stack([x, np.full(n + 1, y)], axis=1)
    cells = np.stack([np.arange(n), np.arange(1, n + 1)], axis=1)
    middles = points[cells].mean(axis=1)
    behind = middles + np.array([0, inside])
    return Side(points, cells, "interval", np.stack([middles, behind], axis=1), degree)


@pytest.mark.parametrize("degree", [1, 2])
def test_a_pairing_does_not_depend_on_where_it_was_before(degree):
    sides = line(9, -0.5, 0.6, 0.02, 1.0, degree), line(31, -2.0, 2.0, 0.0, -1.0, degree)
    places = np.concatenate([side.nodes for side in sides])
    slave = len(sides[0].nodes)
    moved, rng = Pairing(*sides), np.random.default_rng(1)
    for step in range(40):
        places = places + rng.normal(scale=1e-3, size=places.shape)
        places[:slave, 0] += 0.03 * np.sin(0.2 * step)
        moved.update(places, 0.01)
        fresh = Pairing(*sides)
        fresh.update(places, 0.01)
        assert fresh.paired.all()
        np.testing.assert_array_equal(moved.operator, fresh.operator)
        np.testing.assert_array_equal(moved.gap, fresh.gap)


def test_all_spheres_that_meet_are_found():
    rng, near = np.random.default_rng(2), Near()
    ones, others = rng.uniform(size=(40, 3)), rng.uniform(size=(60, 3))
    radii = rng.uniform(0.02, 0.05, 40), 10 ** rng.uniform(-3, -1, 60)
    for _ in range(30):
        ones, others = (x + rng.normal(scale=2e-3, size=x.shape) for x in (ones, others))
        found = set(zip(*near(Spheres(ones, radii[0]), Spheres(others, radii[1]))))
        distance = np.linalg.norm(ones[:, None] - others, axis=2)
        assert found >= set(zip(*np.nonzero(distance <= radii[0][:, None] + radii[1])))


@pytest.mark.parametrize("what", [np.nan, np.inf, 1e200])
def test_what_is_nowhere_is_no_neighbour_but_an_error(what):
    """An iterate that diverges must not seem to be far apart."""
    here, there = np.zeros((2, 3)), np.array([[0.0, 0.0, 0.0], [what, 0.0, 0.0]])
    for ones, others in ((here, there), (there, here)):
        with pytest.raises(StepFailed, match="nowhere"):
            Near()(Spheres(ones, np.ones(2)), Spheres(others, np.ones(2)))


def thrown_blocks():
    """A hyperelastic block thrown on another one."""
    law = {"energy": neo_hookean(1e6, 0.3), "density": 1000.0}
    low = HyperelasticSolid(rectangle((5, 3), (0.6, 0.3)), fixed=["base"], name="low", **law)
    up = HyperelasticSolid(
        rectangle((4, 3), (0.4, 0.3)),
        displacement=lambda x: np.stack([0 * x[0], 0.3005 + 0 * x[0]]),
        velocity=lambda x: np.stack([0.3 + 0 * x[0], -0.5 + 0 * x[0]]),
        name="up",
        **law,
    )
    return Scene([low, up], [Contact(up, "base", (low, "top"), friction=0.3)])


@pytest.mark.parametrize(
    ("build", "dt", "steps"), [(pressed_blocks, 0.25, 12), (thrown_blocks, 5e-4, 30)]
)
def test_what_is_kept_does_not_outlive_an_interruption(build, dt, steps, tmp_path):
    """Patterns, tangents and partners: a run in two parts is that in one, to the same bits."""
    whole = build().run(steps * dt, dt)
    build().run(steps // 2 * dt, dt, directory=tmp_path)
    resumed = build().run(steps * dt, dt, directory=tmp_path, resume=True)
    assert whole.finished and len(resumed) == len(whole)
    for column in set(whole.columns) - {"kinetic", "scheme"}:  # undefined without inertia
        np.testing.assert_array_equal(resumed[column], whole[column], column)


def test_a_pattern_serves_for_a_step(monkeypatch):
    made, make = [], direct.Sparse._make
    monkeypatch.setattr(
        direct.Sparse, "_make", lambda self, *args: made.append(1) or make(self, *args)
    )
    history = pressed_blocks().run(3.0, 0.25)
    assert history.finished and len(made) <= 14 < history["newton"].sum()


def test_tangents_in_motion_serve_for_many_steps():
    scene = thrown_blocks()
    assert isinstance(scene.stepper._method.system, Condensed)
    history = scene.run(0.02, 5e-4)
    assert history.finished and history["up.base.bearing"].max() > 0
    assert max(solid.linearisation for solid in scene.solids) < history["newton"].sum() / 4


def test_no_facet_that_a_ray_meets_is_missed():
    """Facets of all sizes, rays short and long: against all pairs."""
    rng = np.random.default_rng(1)
    met = 0
    for d in (2, 3) * 50:
        bundles, facets = rng.integers(1, 30), rng.integers(1, 60)
        size = 0.1 * 10.0 ** rng.uniform(-1, 1, (facets, 1, 1))
        there = Spheres.around(3 * rng.random((facets, 1, d)) + size * rng.random((facets, d, d)))
        corners = 3 * rng.random((bundles, 1, d)) + 0.05 * rng.random((bundles, d, d))
        bundle = np.repeat(np.arange(bundles), 3)
        x = corners.mean(axis=1)[bundle] + 0.01 * rng.standard_normal((len(bundle), d))
        n = rng.standard_normal((bundles, d))[bundle] + 0.05 * rng.standard_normal(x.shape)
        n /= np.linalg.norm(n, axis=1)[:, None]
        far = 10.0 ** rng.uniform(-3, 0.5, bundles)
        found = candidates(x, n, bundle, far, Spheres.around(corners), there, Near())
        pairs = set(zip(*(each.tolist() for each in found)))
        assert len(pairs) == len(found[0])  # each once

        arm = there.middles - x[:, None]
        along = np.einsum("qfi,qi->qf", arm, n)
        along = np.clip(along, -far[bundle, None], far[bundle, None])
        distance = np.linalg.norm(arm - along[..., None] * n[:, None], axis=2)
        needed = set(zip(*(each.tolist() for each in np.nonzero(distance <= there.radii))))
        assert needed <= pairs
        met += len(needed)
    assert met > 500
