# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sweeps on frozen geometry, ended by Newton's method where they gain little or find no state."""

import numpy as np
import pytest
from dolfinx.mesh import CellType, compute_midpoints, create_rectangle, create_submesh
from mpi4py import MPI
from scenes import FLOOR, rectangle

from fenicsx_contact import (
    Contact,
    Discrete,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    mesh_from_gmsh,
    name_facets,
    neo_hookean,
)

MATERIAL = neo_hookean(1e6, 0.3)


def discs(geometry, spin, dt):
    """Two elastic discs that meet aslant; what is left of them after some steps."""
    solids = []
    for i, way in enumerate((1, -1)):
        mesh = mesh_from_gmsh("disc.geo", h=0.2, coarse=0.3)
        mesh.mesh.geometry.x[:, 1] += 2.002 * i
        solids.append(
            ElasticSolid(
                mesh,
                youngs_modulus=1e6,
                poisson_ratio=0.3,
                density=1e3,
                velocity=lambda x, i=i, way=way: np.stack(
                    [-0.3 * way - spin * (x[1] - 2.002 * i), way + spin * x[0]]
                ),
                name=f"disc {i}",
            )
        )
    contact = Contact(solids[1], "under", (solids[0], "over"), friction=0.3, name="pair")
    scene = Scene(solids, [contact], geometry=geometry)
    history = scene.run(10 * dt, dt)
    assert history.finished
    return np.concatenate([solid.velocity for solid in solids]), history, scene


@pytest.mark.parametrize("spin", [0.0, 8.0])
def test_between_solids_it_is_as_newtons_method_to_its_digits(spin):
    """Where rims turn by a facet within a step sweeps would go on for long."""
    exact, slow, _ = discs("newton", spin, 1e-2)
    found, fast, scene = discs(None, spin, 1e-2)
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-8 * np.abs(exact).max())
    assert scene.geometry == "mixed"
    assert fast["geometry"].max() <= 5 and fast["newton"].sum() <= 2 * slow["newton"].sum()
    if spin:
        _, swept, _ = discs("fixed point", spin, 1e-2)
        assert swept["newton"].sum() > 1.5 * fast["newton"].sum()


def slit(geometry):
    """A hyperelastic block with a slit, whose halves clap together."""
    whole = create_rectangle(
        MPI.COMM_WORLD, [np.zeros(2), np.array([0.2, 0.07])], [10, 7], CellType.quadrilateral
    )
    cells = np.arange(70, dtype=np.int32)
    x, y, _ = compute_midpoints(whole, 2, cells).T
    kept = cells[(x < 0.06) | (np.abs(y - 0.035) > 4e-3)]
    mesh = create_submesh(whole, 2, kept)[0]
    body = HyperelasticSolid(
        name_facets(mesh, {"skin": lambda x: np.ones(x.shape[1], dtype=bool)}),
        energy=MATERIAL,
        density=1e3,
        velocity=lambda x: np.stack(
            [
                6 * (x[1] - 0.035),
                -2 * np.sign(x[1] - 0.035) * np.maximum(x[0] - 0.06, 0) / 0.14,
            ]
        ),
    )
    contact = Contact(body, "skin", (body, "skin"), "gap", friction=0.3)
    scene = Scene([body], [contact], ThetaScheme(1.0), geometry=geometry)
    history = scene.run(0.04, 1e-3)
    assert history.finished
    return history, body.displacement


def test_sweeps_that_find_no_state_hand_over():
    """Those on frozen geometry invert an element: steps were cut, seven times."""
    (newton, exact), (swept, _), (mixed, found) = map(slit, ("newton", "fixed point", None))
    assert len(swept) > len(newton) == len(mixed) == 41
    np.testing.assert_allclose(found, exact, atol=1e-8 * np.abs(exact).max())
    assert mixed["newton"].sum() < newton["newton"].sum()


@pytest.mark.parametrize("located", [False, True])
@pytest.mark.parametrize("geometry", ["fixed point", "newton"])
@pytest.mark.parametrize("lands", [RigidSolid, HyperelasticSolid])
def test_what_an_impact_does_not_touch_is_in_balance(lands, geometry, located):
    """Round-off of its momentum was judged by that of each node alone, of which some have none:
    'the momentum balance stalls', and the run stopped."""
    up, low = (rectangle((3, 2), size) for size in ((0.08, 0.05), (0.1, 0.05)))
    up.mesh.geometry.x[:, 1] += 0.06
    low.mesh.geometry.x[:, 1] += 5e-4
    x0, y0 = up.mesh.geometry.x[:, :2].mean(axis=0)
    flies = HyperelasticSolid(
        up,
        energy=MATERIAL,
        density=1e3,
        velocity=lambda x: np.stack([y0 - x[1], 0.5 + x[0] - x0]),
        name="flies",
    )
    soft = {"energy": MATERIAL} if lands is HyperelasticSolid else {}
    falls = lands(low, density=1e3, velocity=(0.1, -0.3), name="lands", **soft)
    scene = Scene(
        [flies, falls],
        [Contact(falls, "base", FLOOR)],
        geometry=geometry,
        allow_free=True,
        locate_impacts=located,
    )
    history = scene.run(0.01, 1e-3)
    assert history.finished and not history.remarks


def test_before_a_plane_newtons_method_ends_what_sweeps_cannot():
    """A neo-Hookean bar thrown at a wall as fast as its waves, by a tenth of a cell a step: once it
    springs back sweeps on frozen elasticity may find no state, as round-off has it."""
    length, c, cells = 10.0, 30.0, 20
    bar = HyperelasticSolid(
        rectangle((cells, 1), (length, length / cells)),
        energy=neo_hookean(c**2, 0.0),
        density=1.0,
        velocity=lambda x: np.stack([-c + 0 * x[0], 0 * x[1]]),
    )
    wall = HalfSpace((-length / 2 - 0.2 * length, 0), (1, 0))
    scene = Scene([bar], [Contact(bar, "left", wall)])
    assert scene.geometry == "mixed"
    history = scene.run(0.9, 0.1 * length / cells / c)  # later its cells turn over
    assert history.finished, history.reason


def dragged(stiffness, geometry=None):
    """A block over a softer one, on springs with friction."""
    solids = []
    for i, (cells, size, up) in enumerate([((23, 6), (2.0, 0.5), -0.5), ((9, 7), (0.6, 0.5), 0.0)]):
        mesh = rectangle(cells, size, "triangle")
        mesh.mesh.geometry.x[:, 1] += up
        drawn = {"top": lambda t: (0.2 * max(0, t - 0.4), -0.05 * min(1, 2.5 * t))}
        held = {"prescribed": drawn} if i else {"fixed": ["base"]}
        energy = neo_hookean((1 + i) * 1e6, 0.3)
        solids.append(HyperelasticSolid(mesh, energy=energy, density=1.0, name=f"{i}", **held))
    law = Discrete(stiffness)
    contact = Contact(solids[1], "base", (solids[0], "top"), law, friction=0.3, name="pair")
    scene = Scene(solids, [contact], QuasiStatic(), geometry=geometry)
    return scene, scene.run(until=1, dt=0.2)


@pytest.mark.parametrize("stiffness", [1e6, 1e7])
def test_in_statics_it_ends_what_springs_between_solids_begin(stiffness):
    """Sweeps alone stall at 5e-8 on the stiffer ones."""
    scene, history = dragged(stiffness)
    assert scene.geometry == "mixed"
    assert history.finished and not history.remarks, history.reason
    _, exact = dragged(stiffness, "newton")
    for force in ("pair.force_x", "pair.force_y"):
        np.testing.assert_allclose(history[force], exact[force], rtol=0, atol=1e-6 * 5e4)


ROUND = """
Point(1) = {0, 0, 0}; Point(2) = {R, 0, 0}; Point(3) = {0, R, 0}; Point(4) = {-R, 0, 0};
Point(5) = {0, -R, 0};
Circle(1) = {2, 1, 3}; Circle(2) = {3, 1, 4}; Circle(3) = {4, 1, 5}; Circle(4) = {5, 1, 2};
Curve Loop(1) = {1:4}; Plane Surface(1) = {1}; Recombine Surface{1};
Mesh.MeshSizeMax = h; Mesh.MeshSizeMin = h; Mesh.ElementOrder = order;
Physical Surface("disc") = {1}; Physical Curve("skin") = {1:4};
"""


@pytest.mark.parametrize(("law", "tells"), [("gap", True), ("velocity", False)])
def test_what_contacts_give_in_sum_is_told(law, tells, tmp_path):
    """Discs of 25 facets that meet off centre, one of second degree: each step may give a share of
    what its forces might do in it, and some gave 3 % of all without a word."""
    script = tmp_path / "round.geo"
    solids = []
    for i, (radius, h, order, E) in enumerate([(0.1, 0.025, 1, 9.7e6), (0.08, 0.02, 2, 8.4e7)]):
        script.write_text(f"R = {radius}; h = {h}; order = {order};" + ROUND)
        mesh = mesh_from_gmsh(script)
        mesh.mesh.geometry.x[:, :2] += [0.03 * i, 0.186 * i]
        material = {"youngs_modulus": E, "poisson_ratio": 0.3, "density": 1e3, "degree": order}
        solids.append(ElasticSolid(mesh, **material, velocity=(0, 0.7 - 1.4 * i), name=f"{i}"))
    contact = Contact(solids[1], "skin", (solids[0], "skin"), law, name="pair")
    history = Scene(solids, [contact]).run(0.02, 5e-4)
    assert history.finished
    told = [text for _, text in history.remarks if "of the energy in sum" in text]
    assert bool(told) == tells
    gained = history["kinetic"] + history["strain"]
    assert (gained[-1] > 1.01 * gained[0]) == tells
