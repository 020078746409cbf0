# SPDX-License-Identifier: LGPL-3.0-or-later
"""Newton's step by the forces of the points: the same as by all unknowns together."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import FLOOR, G, box, elastic_block, light_footed_block, rectangle, soft_block

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    Scene,
    neo_hookean,
)
from fenicsx_contact.contact.tangent import PointRows
from fenicsx_contact.solve import surface_problem as system
from fenicsx_contact.solve.paired import PairedSolver, PairedSystem, Points
from fenicsx_contact.solve.pointwise import PointwiseSolver, PointwiseStep


def compliance(n, d, rng):
    """Symmetric positive definite, coupling all points."""
    A = rng.standard_normal((n * d, n * d))
    return A @ A.T / (n * d) + np.eye(n * d)


def joined(blocks):
    n, d, _ = blocks.shape
    result = np.zeros((n, d, n, d))
    result[np.arange(n), :, np.arange(n), :] = blocks
    return result.reshape(n * d, n * d)


@pytest.mark.parametrize(("d", "m"), [(2, 2), (2, 1), (3, 3), (3, 0)])
def test_step_without_multipliers_is_that_of_the_whole_system(d, m):
    rng = np.random.default_rng(d + 10 * m)
    n = 7
    K = rng.standard_normal((n, d + m, d + m))
    r_w, r_m, W = rng.standard_normal((n, d)), rng.standard_normal((n, m)), compliance(n, d, rng)
    step = PointwiseStep(K, r_m, d)
    right = step.c + np.einsum("pij,pj->pi", step.C, r_w)
    sizes = rng.uniform(0.5, 2, (n, d))
    scaled = W / sizes.ravel()  # columns in other units
    df = PointwiseSolver(1e-8).solve(step.C, step.D, scaled, sizes, right)
    dw = (W @ df.ravel()).reshape(n, d) - r_w
    dm = step.multipliers(dw, df)
    for k, x, f, r in zip(K, np.concatenate([dw, dm], axis=1), df, r_m):
        np.testing.assert_allclose(k @ x, [*-f, *-r], rtol=0, atol=1e-9)


def test_factors_of_rounded_blocks_serve_for_others():
    """The solution is exact whatever is kept, and the same bits if nothing was."""
    rng = np.random.default_rng(3)
    n, d = 40, 2
    W, b, sizes = compliance(n, d, rng), rng.standard_normal((n, d)), np.ones((n, d))
    C, D = np.tile(np.eye(d), (n, 1, 1)), np.zeros((n, d, d))
    keeps = PointwiseSolver(1e-8)
    for _ in range(6):
        C = C + 0.01 * rng.standard_normal(C.shape)
        x = keeps.solve(C, D, W, sizes, b)
        exact = np.linalg.solve(joined(C) @ W + joined(D), b.ravel()).reshape(n, d)
        np.testing.assert_allclose(x, exact, rtol=0, atol=1e-10 * np.abs(exact).max())
        np.testing.assert_array_equal(x, PointwiseSolver(1e-8).solve(C, D, W, sizes, b))
    assert len(keeps._kept) < 6


def test_hyperstatic_points_share_their_load():
    """W of rank 2: a solution all the same."""
    rng = np.random.default_rng(4)
    J = rng.standard_normal((8, 2))
    W, x = J @ J.T, rng.standard_normal((4, 2))
    b = (W @ x.ravel()).reshape(4, 2)
    C, D = np.tile(np.eye(2), (4, 1, 1)), np.zeros((4, 2, 2))
    found = PointwiseSolver(1e-8).solve(C, D, W, np.ones((4, 2)), b)
    np.testing.assert_allclose(W @ found.ravel(), b.ravel(), rtol=0, atol=1e-8 * np.abs(b).max())


def paired_system(rng, kinds=(2, 2), turn=0.2):
    """Five points that see two solids, four before an obstacle; the dense matrix beside it. Points
    of kind 0 are open (their forces are told), the others bear (what they read is)."""
    n, m, d, seen = 5, 4, 2, 12
    v = seen + m * d
    W = compliance(v // d, d, rng)
    J, S = rng.standard_normal((n * d, seen)), rng.standard_normal((n * (2 * d + 1), seen))
    G = turn * rng.standard_normal((seen, seen)) / seen
    whole = np.zeros((v + (n + m) * d,) * 2)
    q, points = v, []
    for mine, count, r, look, spread, turning, kind in (
        (slice(0, seen), n, 2 * d + 1, S, J, G, kinds[0]),
        (slice(seen, v), m, d, np.eye(m * d), np.eye(m * d), None, kinds[1]),
    ):
        own = turning is not None
        C = np.zeros((count, d, r))
        C[:, :, :d] = np.eye(d)
        C = (C + 0.1 * rng.standard_normal(C.shape)) * (np.arange(count) < kind)[:, None, None]
        D = np.tile(np.eye(d), (count, 1, 1)) * (np.arange(count) >= kind)[:, None, None]
        sizes = rng.uniform(0.5, 2.0, (count, d))
        rows = PointRows(C, S if own else None, J if own else None, turning)
        points.append(Points(mine, rows, C, D, sizes))
        forces = slice(q, q + count * d)
        whole[:v, forces] = -W[:, mine] @ (spread.T * sizes.ravel())
        whole[forces, mine] = joined_rows(C) @ look
        whole[forces, forces] = joined(D)
        q += count * d
    whole[:v, :v] = np.eye(v)
    whole[:v, :seen] += W[:, :seen] @ G
    return PairedSystem(W, points), whole


def joined_rows(blocks):
    n, d, r = blocks.shape
    result = np.zeros((n, d, n, r))
    result[np.arange(n), :, np.arange(n), :] = blocks
    return result.reshape(n * d, n * r)


def test_paired_points():
    """Whatever an inverse was made for: the same system, other statuses, another geometry."""
    solver = PairedSolver()
    for kinds in ((5, 4), (5, 4), (3, 4), (3, 2), (0, 0)):
        system, whole = paired_system(np.random.default_rng(5), kinds)
        b = np.random.default_rng(6).standard_normal(len(whole))
        dy, dq = solver.solve(system, b)
        np.testing.assert_allclose(system.rows(dy, dq), whole @ [*dy, *dq], rtol=0, atol=1e-12)
        np.testing.assert_allclose(whole @ [*dy, *dq], b, rtol=0, atol=1e-11)
    for seed in range(7, 10):
        system, whole = paired_system(np.random.default_rng(seed))
        b = np.random.default_rng(6).standard_normal(len(whole))
        np.testing.assert_allclose(
            np.concatenate(solver.solve(system, b)), np.linalg.solve(whole, b), rtol=1e-9
        )


def test_forces_that_make_a_solid_unstable_are_none():
    """1 + W G singular: the step is refused, not nonsense."""
    system, _ = paired_system(np.random.default_rng(5), turn=0.0)
    mine, forces, spread, look, G = system.parts[0]
    G = np.zeros_like(G)
    G[0, 0] = -1 / system.W[0, 0]
    system.parts[0] = (mine, forces, spread, look, G)
    system.W[1:, 0] = system.W[0, 1:] = 0.0
    assert PairedSolver().solve(system, np.ones(len(system.W) + 18)) is None


def sliding_box():
    """An elastic box in space, thrown obliquely: its points slip in turning directions."""
    solid = ElasticSolid(
        box((3, 3, 2), (0.4, 0.4, 0.3)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        gravity=(0, 0, -G),
        velocity=lambda x: np.stack([0.5 - 2 * x[1], 0.3 + 2 * x[0], -0.5 - 0.2 * x[0]]),
    )
    floor = HalfSpace((0, 0, -0.003), (0, 0, 1))
    return Scene([solid], [Contact(solid, "base", floor, friction=0.3, name="c")])


def two_contacts():
    """A block between two planes, with friction on one and without on the other."""
    scene = elastic_block()
    (solid,), (contact,) = scene.solids, scene.contacts
    assert contact.coupling.obstacle is FLOOR
    wall = Contact(solid, "right", HalfSpace((0.215, 0), (-1, 0)), name="wall")
    return Scene([solid], [contact, wall])


def two_solids(kind, mesh, size):
    """A solid that slides on another, which slides on the floor."""
    dim, solids = len(size), []
    for name, cells, lift, slide in (("lower", 4, -0.003, 0.0), ("upper", 3, 0.0, 0.4)):
        velocity = np.eye(dim)[0] * slide - np.eye(dim)[-1] * 0.1
        body = mesh((cells, cells - 2, 2)[:: 4 - dim][:dim], size)
        body.mesh.geometry.x[:, dim - 1] += lift + (size[-1] if slide else 0.0)
        if kind is HyperelasticSolid:
            others = {"energy": neo_hookean(1e6, 0.3)}
        else:
            others = {"youngs_modulus": 1e6, "poisson_ratio": 0.3}
        solids.append(
            kind(
                body,
                density=1000.0,
                gravity=-G * np.eye(dim)[-1],
                velocity=lambda x, v=velocity: v[:, None] + 0 * x[: len(v)],
                name=name,
                **others,
            )
        )
    floor = HalfSpace([0.0] * (dim - 1) + [-0.003], np.eye(dim)[-1])
    lower, upper = solids
    contacts = [
        Contact(lower, "base", floor, friction=0.3, name="floor"),
        Contact(upper, "base", (lower, "top"), friction=0.2, name="c"),
    ]
    return Scene(solids, contacts, geometry="newton", solver="condensed")


def elastic_pair():
    return two_solids(ElasticSolid, rectangle, (0.4, 0.2))


def soft_pair():
    return two_solids(HyperelasticSolid, rectangle, (0.4, 0.2))


def elastic_pair_in_space():
    return two_solids(ElasticSolid, box, (0.4, 0.3, 0.2))


#: A base without mass amplifies round-off, tenfold in some ten steps that stick and slip.
UNTIL = {elastic_pair_in_space: 0.02, light_footed_block: 0.013}


@pytest.mark.parametrize(
    "make",
    [
        elastic_block,
        light_footed_block,
        soft_block,
        sliding_box,
        two_contacts,
        elastic_pair,
        pytest.param(soft_pair, marks=pytest.mark.second),
        pytest.param(elastic_pair_in_space, marks=pytest.mark.second),
    ],
)
def test_runs_are_the_same(make, monkeypatch):
    histories = []
    for many in (10**9, 0):
        monkeypatch.setattr(system, "MANY", (many, many))
        history = make().run(UNTIL.get(make, 0.025), 2e-4)
        assert history.finished and history["c.bearing"].max() > 1
        histories.append(history)
    all_together, by_points = histories
    assert by_points["c.slipping"].max() > 0
    for what in ("kinetic", "strain", "friction", "c.force_x", "c.bearing", "c.slipping"):
        a, b = all_together[what], by_points[what]
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-6 * np.abs(a).max())
