# SPDX-License-Identifier: LGPL-3.0-or-later
"""The iterative solver: the results of the direct one, in as many iterations on every mesh."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import box, elastic_block, pressed_boxes, pressed_cube, rigid_box, soft_block

from fenicsx_contact import Contact, ElasticSolid, HalfSpace, InputError, QuasiStatic, Scene
from fenicsx_contact.solve import choose as methods
from fenicsx_contact.solve import krylov


@pytest.mark.parametrize(
    "scene, until, dt",
    [
        (pressed_boxes, 3.0, 1.0),
        (pressed_cube, 2.0, 1.0),
        (elastic_block, 0.015, 5e-4),
        (soft_block, 0.015, 5e-4),
    ],
    ids=["pair of hyperelastic solids", "elastic on a table", "impact", "hyperelastic impact"],
)
def test_it_finds_what_the_direct_solver_finds(scene, until, dt):
    runs = {}
    for solver in ("monolithic", "iterative"):
        made = scene(
            **{"geometry": "newton", "solver": solver} if until < 1 else {"solver": solver}
        )
        history = made.run(until, dt)
        assert history.finished, history.reason
        runs[solver] = np.concatenate([made.solids[0].displacement, made.contacts[0].force.ravel()])
        assert not history.remarks and bool(made.krylov) == (solver == "iterative")
    direct, iterative = runs["monolithic"], runs["iterative"]
    n = made.solids[0].owned
    for part in (slice(0, n), slice(n, None)):
        size = np.abs(direct[part]).max()
        assert size > 0
        assert np.abs(iterative[part] - direct[part]).max() < 1e-8 * size


def test_iterations_do_not_grow_with_the_mesh(monkeypatch):
    monkeypatch.setattr(krylov, "EARLY", krylov.TOLERANCE)  # all solves to the same share
    counts = []
    for n in (8, 16):
        scene = pressed_cube(n, solver="iterative")
        assert scene.run(1.0, 1.0).finished
        counts.append(np.mean(scene.krylov))
        bearing = np.count_nonzero(scene.contacts[0].status)
        assert 0 < bearing < scene.contacts[0].surface.size
    assert counts[1] < 1.3 * counts[0], counts  # unpreconditioned they double


def pressed_pair(n: int) -> Scene:
    """A cube with a rounded base, pressed on a wider block: where they touch they may slide."""
    elastic = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
    upper = box((n, n, n), (1.0, 1.0, 1.0), "tetrahedron")
    x = upper.mesh.geometry.x
    x[:, 2] += 0.1 * (x[:, 0] ** 2 + x[:, 1] ** 2) * (1 - x[:, 2])
    lower = box((n + 1, n + 1, n), (1.4, 1.4, 1.0), "tetrahedron")
    lower.mesh.geometry.x[:, 2] -= 1.0
    down = {"top": lambda t: [0.0, 0.0, -0.005 * t]}
    cube = ElasticSolid(upper, prescribed=down, name="cube", **elastic)
    block = ElasticSolid(lower, fixed=["base"], name="block", **elastic)
    contact = Contact(cube, "base", (block, "top"), "gap", name="c")
    return Scene([cube, block], [contact], QuasiStatic(), geometry="newton", solver="iterative")


def test_two_solids_take_hardly_more_iterations_than_one(monkeypatch):
    monkeypatch.setattr(krylov, "EARLY", krylov.TOLERANCE)
    scene = pressed_pair(10)
    assert scene.run(1.0, 1.0).finished
    assert np.count_nonzero(scene.contacts[0].status) > 1
    # with the springs in the graph of the aggregates 24, and growing
    assert np.mean(scene.krylov) < 18, scene.krylov


@pytest.mark.parametrize("slope", [0.0, 0.3])
def test_what_only_contact_holds_takes_no_more_of_newtons_iterations(slope):
    """Who bears is told by huge multipliers: a share of them is more than all else (87 and 129
    iterations once, for 5)."""
    counts = []
    for solver in ("monolithic", "iterative"):
        cube = ElasticSolid(
            box((4, 4, 4), (1.0, 1.0, 1.0), "tetrahedron"),
            youngs_modulus=1e6,
            poisson_ratio=0.3,
            density=1000.0,
            gravity=(9.81 * np.sin(slope), 0.0, -9.81 * np.cos(slope)),
        )
        floor = HalfSpace((0, 0, 0), (0, 0, 1))
        contact = Contact(cube, "base", floor, "gap", friction=0.5)
        history = Scene([cube], [contact], QuasiStatic(), solver=solver).run(1.0, 1.0)
        assert history.finished and not history.remarks
        counts.append(history["newton"][-1])
    assert counts[1] <= counts[0] <= 6


def test_large_scenes_in_space_choose_it(monkeypatch):
    assert pressed_cube(2).solver == "condensed"
    monkeypatch.setattr(methods, "LARGE_SURFACE", 10)
    assert pressed_cube(2).solver == "monolithic"
    monkeypatch.setattr(methods, "LARGE_SOLIDS", 10)
    assert pressed_cube(2).solver == "iterative"


def test_what_stays_is_condensed_longer(monkeypatch):
    """The compliance of linear solids in space that move stays: 12 steps of two blocks with 1950
    components of points between them took 38 s as one sparse system, and take 16 s."""
    cube = ElasticSolid(box((2, 2, 2)), youngs_modulus=1e6, poisson_ratio=0.3, density=1e3)
    contact = Contact(cube, "base", HalfSpace((0, 0, 0), (0, 0, 1)), "gap")
    monkeypatch.setattr(methods, "LARGE_SURFACE", 10)
    assert Scene([cube], [contact]).solver == "condensed"
    monkeypatch.setattr(methods, "LARGE_KEPT", 10)
    assert Scene([cube], [contact]).solver == "monolithic"


@pytest.mark.parametrize("geometry", [None, "newton", "fixed point"])
def test_rigid_solids_are_refused(geometry):
    with pytest.raises(InputError, match=r"solver = 'iterative'.*'monolithic'"):
        rigid_box(geometry=geometry, solver="iterative")


def test_what_it_cannot_solve_it_stops_at_with_a_reason(monkeypatch):
    for limit in ("MAX_ITERATIONS", "PATIENCE"):
        monkeypatch.setattr(f"fenicsx_contact.solve.krylov.{limit}", 2)
    cube = ElasticSolid(
        box((2, 2, 2)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        fixed=["top"],
        gravity=(0, 0, -9.81),
    )
    table = HalfSpace(point=(0, 0, 0), normal=(0, 0, 1))
    contact = Contact(cube, "base", table, "gap", name="c")
    scene = Scene([cube], [contact], QuasiStatic(), geometry="newton", solver="iterative")
    history = scene.run(1.0, 1.0)
    assert not history.finished and "GMRES does not end" in history.reason
    assert np.isfinite(history.rows()).all() and not cube.displacement.any()


@pytest.mark.parametrize("solver", ["monolithic", "iterative"])
def test_what_nothing_touches_takes_several_iterations(solver):
    """On weak springs a solution is corrected once more; there are no contacts to be asked."""
    springs, E = {"base": 100.0}, {"youngs_modulus": 1e6, "poisson_ratio": 0.3}
    body = ElasticSolid(box((2, 2, 2)), density=1e3, gravity=(0, 0, -9.81), springs=springs, **E)
    history = Scene([body], [], QuasiStatic(), solver=solver).run(2.0, 1.0)
    assert history.finished, history.reason
    way = 1e3 * 9.81 * 0.8 / 100
    np.testing.assert_allclose(body.mean(body.displacement), [0, 0, -way], rtol=1e-4, atol=1e-6)
