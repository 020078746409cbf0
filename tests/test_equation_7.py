# SPDX-License-Identifier: LGPL-3.0-or-later
"""Every solver of the package against demos/equation_7.py: (7) and (8) whole, in one form on the
volume, solved by plain dolfinx and PETSc."""

import numpy as np
import pytest
from scenes import FLOOR, FLOOR_3D, G, box, rectangle
from test_demos import load

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HyperelasticSolid,
    Scene,
    ThetaScheme,
    neo_hookean,
)

demo = load("equation_7")
PATHS = [
    ("fixed point", "condensed"),
    ("newton", "condensed"),
    ("newton", "monolithic"),
    ("newton", "iterative"),
]


def both(law, theta, path, mesh=None, material="elastic", friction=0.3):
    """The same block by the package and by the oracle: thrown obliquely, turned a little."""
    mesh = mesh or rectangle((4, 4), (0.4, 0.4))
    d = mesh.dim
    up = np.eye(d)[-1]
    start = {
        "displacement": lambda x: np.stack(
            [-0.02 * x[d - 1], *[0 * x[0]] * (d - 2), 0.02 * x[0] + 0.01 * x[1] * (d - 2) + 0.006]
        ),
        "velocity": lambda x: np.stack([0.5 + 0 * x[0], 0.2 + 0 * x[0], -1.0 - 0.2 * x[0]])[
            [0, 1, 2] if d == 3 else [0, 2]
        ],
        "gravity": tuple(-G * up),
    }
    constants = demo.YOUNG, demo.POISSON
    named = dict(zip(("youngs_modulus", "poisson_ratio"), constants))
    energy = demo.small_strain if material == "elastic" else neo_hookean(*constants)
    kind, given = (
        (ElasticSolid, named) if material == "elastic" else (HyperelasticSolid, {"energy": energy})
    )
    solid = kind(mesh, density=demo.DENSITY, **given, **start)
    contact = Contact(solid, "base", FLOOR if d == 2 else FLOOR_3D, law, friction, name="c")
    geometry, solver = path
    scene = Scene([solid], [contact], ThetaScheme(theta), geometry=geometry, solver=solver)
    oracle = demo.Block(
        mesh.mesh,
        mesh.facets("base"),
        mesh.facets("top"),
        law=law,
        theta=theta,
        point=np.zeros(d),
        normal=up,
        friction=friction,
        energy=energy,
        **start,
    )
    return scene, oracle


def in_order(points, *arrays):
    """Arrays of nodal values in the order of the coordinates."""
    order = np.lexsort(np.round(points.T, 9))
    return [array[order] for array in arrays]


def by_package(scene):
    """Velocities at the nodes; pressures and friction tractions at those of the contact."""
    (solid,), (contact,), d = scene.solids, scene.contacts, scene.solids[0].dim
    eq = contact.equations
    _, tangents = eq.fields.frame()
    components = eq.values[eq.tractions :].reshape(d - 1, -1)
    traction = np.einsum("kn,knd->nd", components, tangents)
    at = contact.surface.points
    nodes = solid.space.tabulate_dof_coordinates()[:, :d]
    velocity = in_order(nodes, solid.velocity.reshape(-1, d))
    return [*velocity, *in_order(at, contact.multiplier, traction)]


def by_oracle(oracle):
    """The same."""
    base, d = oracle.base, oracle.d
    velocity = in_order(oracle.x, oracle.field(oracle.old, slice(d)))
    return [*velocity, *in_order(oracle.x[base], oracle.pressure[base], oracle.friction[base])]


def differences(scene, oracle, steps, dt=1e-3):
    """The largest difference of velocities, pressures and tractions in a run, as shares of their
    largest values; and which statuses there were."""
    largest, worst, seen = np.zeros(3), np.zeros(3), set()
    for _ in range(steps):
        for row in scene.step(dt):
            if row[1]:
                oracle.step(dt)
            else:
                oracle.strike(dt)
            mine, theirs = by_package(scene), by_oracle(oracle)
            largest = np.maximum(largest, [np.abs(b).max() for b in theirs])
            largest[2] = largest[1]  # friction may be none
            error = [np.abs(a - b).max() for a, b in zip(mine, theirs)]
            worst = np.maximum(worst, error / np.where(largest, largest, 1.0))
            seen |= set(scene.contacts[0].status)
    return worst, seen


def check(scene, oracle, tolerance=1e-9):
    """All that can happen to a point happens, and both do the same."""
    worst, seen = differences(scene, oracle, steps=20)
    assert seen == {0, 1, 2}
    assert worst.max() < tolerance, f"velocities, pressures, tractions differ by {worst}"


@pytest.mark.parametrize("path", PATHS, ids=", ".join)
@pytest.mark.parametrize("theta", [0.5, 1.0])
@pytest.mark.parametrize("law", demo.LAWS)
def test_elastic_block_thrown_at_a_wall(law, theta, path):
    check(*both(law, theta, path))


@pytest.mark.second
@pytest.mark.parametrize("path", PATHS, ids=", ".join)
@pytest.mark.parametrize("law, theta", [("printed", 0.5), ("gap", 1.0), ("velocity", 0.5)])
def test_neo_hookean_block_thrown_at_a_wall(law, theta, path):
    # the fixed point may stop at an error of 1e-8 in each step, Newton's method at 1e-10
    tolerance = 1e-7 if path[0] == "fixed point" else 1e-9
    check(*both(law, theta, path, material="neo-Hookean"), tolerance)


@pytest.mark.second
@pytest.mark.parametrize("path", PATHS, ids=", ".join)
@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
def test_in_space(cell, path):
    check(*both("gap", 1.0, path, box((2, 2, 2), (0.4, 0.4, 0.4), cell)))


def test_the_oracle_pressed_and_dragged():
    """A load that changes within the steps: taken at the theta-point by both."""
    mesh = rectangle((8, 2), (0.4, 0.1))
    pull = lambda t: (6e4 * t, -2e4)  # noqa: E731
    solid = ElasticSolid(
        mesh,
        youngs_modulus=demo.YOUNG,
        poisson_ratio=demo.POISSON,
        density=demo.DENSITY,
        tractions={"top": pull},
    )
    scene = Scene([solid], [Contact(solid, "base", FLOOR, "gap", 0.3, name="c")])
    still = {name: lambda x: 0 * x[:2] for name in ("displacement", "velocity")}
    facets = mesh.facets("base"), mesh.facets("top")
    wall = {"point": (0, 0), "normal": (0, 1)}
    oracle = demo.Block(mesh.mesh, *facets, law="gap", theta=0.5, **wall, **still)
    worst, dt = np.zeros(3), 5e-3
    for k in range(20):
        oracle.traction.value = pull((k + 0.5) * dt)
        worst = np.maximum(worst, differences(scene, oracle, 1, dt)[0])
    assert worst.max() < 1e-9


@pytest.mark.second
def test_the_demo(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    summary = demo.main(quick=True)
    row = summary["printed row"]
    assert row["steps"] > 50 and row["found_from_no_friction"] == row["steps"]
    assert max(row["velocity_difference"], row["traction_difference"]) < 1e-12
    assert row["rank_lacking"] == {"printed": 5, "tractions": 0}  # one row for each point
    for name in demo.LAWS:
        for theta, least in ((0.5, 0.88), (1, 0.6)):
            found = summary[f"{name}, theta = {theta:g}"]
            assert least < found["energy_kept"] < 1
            assert found["statuses"] == [0, 1, 2]
    for picture in ("energy.png", "friction.png"):
        assert (demo.RESULTS / picture).stat().st_size > 5000
    assert capsys.readouterr().out.startswith("energy kept at theta = 1/2: printed 0.89")
