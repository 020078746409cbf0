# SPDX-License-Identifier: LGPL-3.0-or-later
"""Mass redistribution: mass kept, boundary in equilibrium, impacts without loss."""

import numpy as np
import pytest
from scenes import FLOOR, box, rectangle, total_energy

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    GeneralisedAlpha,
    HalfSpace,
    HyperelasticSolid,
    InputError,
    Scene,
    ThetaScheme,
    neo_hookean,
)


def matrix(solid):
    return np.array([solid.multiply(solid._mass, e) for e in np.eye(solid.owned)])


@pytest.mark.parametrize(
    "mesh",
    [rectangle((4, 5)), rectangle((4, 5), cell="triangle"), box((2, 2, 3))],
    ids=["quadrilaterals", "triangles", "hexahedra"],
)
def test_mass_is_moved_not_lost(mesh):
    data = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
    plain = ElasticSolid(mesh, **data)
    moved = ElasticSolid(mesh, mass_redistribution=["base"], **data)
    d, M = mesh.dim, matrix(moved)
    np.testing.assert_allclose(M, M.T, atol=1e-12 * M.max())
    x = moved.space.tabulate_dof_coordinates()
    base = np.isclose(x[:, d - 1], 0)
    assert not M[np.repeat(base, d)].any()
    rest = M[np.ix_(~np.repeat(base, d), ~np.repeat(base, d))]
    assert np.linalg.eigvalsh(rest).min() > 0
    for k in range(d):
        uniform = np.zeros(moved.owned)
        uniform[k::d] = 1.0
        assert uniform @ M @ uniform == pytest.approx(uniform @ matrix(plain) @ uniform, rel=1e-9)


def test_a_bar_on_rollers_keeps_its_mass():
    """All its nodes are held across it, along it they take what the end loses."""
    held = {"base": (None, 0.0), "top": (None, 0.0)}
    data = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 2.0, "prescribed": held}
    data["velocity"] = lambda x: np.stack([-1 + 0 * x[0], 0 * x[0]])
    solid = ElasticSolid(rectangle((8, 1), (2.0, 0.1)), mass_redistribution=["left"], **data)
    along = np.zeros(solid.owned)
    along[::2] = 1.0
    assert along @ matrix(solid) @ along == pytest.approx(2.0 * 2.0 * 0.1)
    contact = Contact(solid, "left", HalfSpace((-1, 0), (1, 0)), "gap", name="c")
    total = total_energy(Scene([solid], [contact]).run(until=1e-2, dt=1e-4))
    assert np.abs(total / total[0] - 1).max() < 1e-6


def bar(cells, length, gap, speed, until, **state):
    solid = ElasticSolid(
        rectangle((cells, 1), (length, 1.0)),
        youngs_modulus=speed**2,
        poisson_ratio=0.0,
        density=1.0,
        mass_redistribution=["left"],
        **state,
    )
    contact = Contact(solid, "left", HalfSpace((-length / 2 - gap, 0), (1, 0)), "gap", name="c")
    history = Scene([solid], [contact]).run(until, length / cells / speed)
    assert history.finished
    return history


def test_bar_thrown_at_a_wall_keeps_its_energy():
    velocity = {"velocity": lambda x: np.stack([-10 + 0 * x[0], 0 * x[1]])}
    history = bar(200, 10.0, 5.0, 30.0, 2.0, **velocity)
    np.testing.assert_allclose(total_energy(history), 500, rtol=1e-10)
    time, force = history.time, history["c.force_x"]
    assert time[force > 1][[0, -1]] == pytest.approx([0.5, 7 / 6], rel=0.01)
    inside = (time > 0.55) & (time < 1.1)
    np.testing.assert_allclose(force[inside], 300, rtol=1e-4)  # no ripple


def test_bar_released_stretched_keeps_its_energy():
    stretched = {"displacement": lambda x: np.stack([(0.5 - x[0]) / 2, 0 * x[1]])}
    history = bar(200, 1.0, 0.0, 1.0, 9.0, fixed=["right"], **stretched)
    kept = total_energy(history)
    assert np.abs(kept / kept[0] - 1).max() < 1e-3
    assert kept[0] == pytest.approx(1 / 8, rel=0.006)  # the last cell relaxes: O(h)
    time, force = history.time, history["c.force_x"]
    for start in (1, 4, 7):
        inside = (time > start + 0.1) & (time < start + 0.9)
        assert force[inside].mean() == pytest.approx(0.5, rel=0.01)


@pytest.mark.parametrize("hyperelastic", [False, True])
def test_boundary_without_mass_starts_in_equilibrium(hyperelastic):
    common = {
        "density": 1000.0,
        "gravity": (0, -9.81),
        "mass_redistribution": ["base"],
        "displacement": lambda x: np.stack([0.01 * x[0] * x[1], 0.02 * x[1]]),
    }
    if hyperelastic:
        solid = HyperelasticSolid(rectangle((2, 4)), energy=neo_hookean(1e6, 0.3), **common)
    else:
        solid = ElasticSolid(rectangle((2, 4)), youngs_modulus=1e6, poisson_ratio=0.3, **common)
    out_of_balance = solid.internal_force(solid.displacement) - solid.weight
    base = np.isclose(solid.space.tabulate_dof_coordinates()[:, 1], 0)
    at_base = np.repeat(base, 2)
    assert np.abs(out_of_balance[at_base]).max() < 1e-9 * np.abs(out_of_balance).max()


@pytest.mark.parametrize("shift", [1e-12, 0.01, 0.3])
def test_what_is_without_strain_starts_anywhere(shift):
    """Its forces are round-off, which fall no more: it was refused, without an equilibrium."""
    mesh = rectangle((4, 3), (0.5, 0.4))
    solid = ElasticSolid(
        mesh,
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        mass_redistribution=["base"],
        displacement=(0.0, shift),
    )
    np.testing.assert_allclose(solid.fields()["displacement"][:, 1], shift, rtol=1e-12)


def test_refusals():
    data = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
    solid = ElasticSolid(rectangle((2, 4)), mass_redistribution=["base"], **data)
    with pytest.raises(InputError, match=r"mass_redistribution.*law of positions"):
        Scene([solid], [Contact(solid, "base", FLOOR, "velocity")])
    with pytest.raises(InputError, match=r"mass_redistribution.*degree 1"):
        ElasticSolid(rectangle((2, 4)), mass_redistribution=["base"], degree=2, **data)
    with pytest.raises(InputError, match="'floor'"):
        ElasticSolid(rectangle((2, 4)), mass_redistribution=["floor"], **data)
    with pytest.raises(InputError, match="no free nodes"):
        ElasticSolid(rectangle((1, 1)), mass_redistribution=["base"], fixed=["top"], **data)


@pytest.mark.parametrize("where", [0.0, 0.1, 3.0])
def test_what_is_symmetric_stays_so(where):
    """Of the many ways to spread the mass a corner of them was taken, which round-off chose: a body
    elsewhere, or on two processes, had another mass, and one that fell straight turned."""
    mesh = rectangle((6, 4), (0.4, 0.4))
    mesh.mesh.geometry.x[:, 0] += where
    solid = ElasticSolid(
        mesh,
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        velocity=(0, -1.0),
        gravity=(0, -9.81),
        mass_redistribution=["base"],
    )
    x = solid.space.tabulate_dof_coordinates()[:, :2] - (where, 0)
    mirrored = [np.abs(x - (-a, b)).sum(axis=1).argmin() for a, b in x]
    mass = matrix(solid).diagonal()[::2]
    np.testing.assert_allclose(mass[mirrored], mass, rtol=1e-9)
    behind = np.isclose(x[:, 1], 0.1) & (np.abs(x[:, 0]) < 0.19)
    assert mass[behind].min() > 0.7 * mass[behind].max()
    contact = Contact(solid, "base", FLOOR, "gap", name="floor")
    history = Scene([solid], [contact]).run(0.03, 1e-3)
    assert history.finished and history["floor.force_y"].max() > 1e3
    v = solid.velocity.reshape(-1, 2)
    np.testing.assert_allclose(v[mirrored] * (-1, 1), v, atol=1e-9)


@pytest.mark.parametrize("kind", [ElasticSolid, HyperelasticSolid])
@pytest.mark.parametrize("side", ["left", "base"])
def test_a_body_falls_without_turning(kind, side):
    """Its weight acted where mass had been: it turned, and was strained from the start."""
    material = {"youngs_modulus": 1e6, "poisson_ratio": 0.3}
    if kind is HyperelasticSolid:
        material = {"energy": neo_hookean(1e6, 0.3)}
    solid = kind(
        rectangle((2, 4), (0.5, 1.0)),
        density=1000.0,
        gravity=(3.0, -10.0),
        mass_redistribution=[side],
        **material,
    )
    contact = Contact(solid, side, HalfSpace((-5, -5), (0.6, 0.8)), "gap")
    history = Scene([solid], [contact]).run(0.5, 5e-3)
    u = solid.displacement.reshape(-1, 2)
    np.testing.assert_allclose(u, np.tile((0.375, -1.25), (len(u), 1)), atol=1e-9)
    assert history["strain"].max() < 1e-9 * history["kinetic"].max()


@pytest.mark.parametrize(
    ("scheme", "told"),
    [(ThetaScheme(), True), (ThetaScheme(0.55), False), (GeneralisedAlpha(0.8), False)],
)
def test_friction_of_what_has_no_mass_and_no_damping_is_told(scheme, told):
    """By theta = 1/2 it sticks and slips by turns, and 7 % of its friction were lost silently."""
    angle, friction = 0.5, 0.2
    block = ElasticSolid(
        rectangle((8, 6), (0.4, 0.3)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=100.0,
        gravity=(9.81 * np.sin(angle), -9.81 * np.cos(angle)),
        mass_redistribution=["base"],
    )
    contact = Contact(block, "base", FLOOR, "gap", friction=friction, name="c")
    history = Scene([block], [contact], scheme).run(0.1, 1e-3)
    remarks = " ".join(remark for _, remark in history.remarks)
    assert ("'c' rubs on a boundary of 'elastic' without mass" in remarks) == told
    impulse = [(history[f"c.force_{axis}"] * history["dt"]).sum() for axis in "xy"]
    assert (abs(-impulse[0] / impulse[1] / friction - 1) < 0.01) != told
