# SPDX-License-Identifier: LGPL-3.0-or-later
"""Supports at points, edges and facets, springs to the ground, plane stress, axisymmetry: exact."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import dolfinx
import numpy as np
import pytest
import ufl
from mpi4py import MPI
from processes import mpirun, needs_mpirun, output_of
from scenes import FLOOR, box, check_energies, rates, rectangle, total_energy
from scipy.optimize import brentq

from fenicsx_contact import (
    Compliance,
    Contact,
    ElasticSolid,
    EnergyMomentum,
    GeneralisedAlpha,
    HalfSpace,
    HyperelasticSolid,
    InputError,
    Moved,
    QuasiStatic,
    Rayleigh,
    RigidSolid,
    Scene,
    ThetaScheme,
    ciarlet,
    mesh_from_gmsh,
    name_facets,
    name_points,
    neo_hookean,
    st_venant_kirchhoff,
)
from fenicsx_contact.contact.candidates import Candidates

E, NU, RHO, WIDTH, HEIGHT = 1e6, 0.3, 1000.0, 0.4, 0.8
CELLS = ("triangle", "quadrilateral")


def elastic(mesh, **others):
    numbers = {"youngs_modulus": E, "poisson_ratio": NU, "density": RHO}
    return ElasticSolid(mesh, **{**numbers, **others})


def block(cell="quadrilateral", n=(3, 4)):
    return rectangle(n, (WIDTH, HEIGHT), cell)


def settled(solid):
    """Its displacement in equilibrium at the nodes of the mesh, and where these are."""
    history = Scene([solid], [], QuasiStatic()).run(1.0, 1.0)
    assert history.finished, history.reason
    assert history["certificate"].max() < 1e-9
    d = solid.dim
    return solid.fields()["displacement"], solid.mesh.mesh.geometry.x[:, :d]


# -- where --

PULL = 1e4


@pytest.mark.parametrize("plane", ["strain", "stress"])
@pytest.mark.parametrize("cell", CELLS)
def test_rollers_and_a_point_leave_uniform_tension(cell, plane):
    """A patch test: a roller along the left, one corner held, by each way of naming it."""
    named = name_points(block(cell), {"corner": (-WIDTH / 2, 0.0)})
    stiffness = E / (1 - NU**2) if plane == "strain" else E
    ratio = NU / (1 - NU) if plane == "strain" else NU
    for corner in ("corner", ("left", "base"), (-WIDTH / 2, 0.0)):
        solid = elastic(
            named,
            plane=plane,
            prescribed={"left": (0.0, None)},
            fixed=[corner],
            tractions={"right": (PULL, 0.0)},
        )
        u, x = settled(solid)
        strain = PULL / stiffness
        exact = np.stack([strain * (x[:, 0] + WIDTH / 2), -ratio * strain * x[:, 1]], axis=1)
        np.testing.assert_allclose(u, exact, rtol=0, atol=1e-13)
        np.testing.assert_allclose(solid.reaction("left"), [-PULL * HEIGHT, 0], atol=1e-8)


def test_edges_and_corners_in_space():
    """A box that three edges hold as little as need be, pressed on its top."""
    size = (0.4, 0.5, 0.6)
    x = name_facets(
        box((2, 2, 3), size).mesh,
        {
            "base": lambda x: np.isclose(x[2], 0),
            "top": lambda x: np.isclose(x[2], 0.6),
            "left": lambda x: np.isclose(x[0], -0.2),
            "front": lambda x: np.isclose(x[1], -0.25),
        },
    )
    solid = elastic(
        x,
        prescribed={
            "base": (None, None, 0.0),
            ("left", "base"): (0.0, None, 0.0),
            ("left", "front", "base"): (0.0, 0.0, None),
        },
        tractions={"top": (0, 0, -PULL)},
    )
    assert len(solid.supports.unknowns) == 9 + 3 + 1
    u, places = settled(solid)
    exact = (
        PULL
        / E
        * np.stack([NU * (places[:, 0] + 0.2), NU * (places[:, 1] + 0.25), -places[:, 2]], axis=1)
    )
    np.testing.assert_allclose(u, exact, rtol=0, atol=1e-13)
    np.testing.assert_allclose(solid.reaction("base")[2], PULL * 0.2, rtol=1e-10)


def test_contradictory_supports_name_both():
    for supports, words in (
        ({"fixed": ["base", "top"], "prescribed": {"left": (0.01, None)}}, ["'left'", "'base'"]),
        (
            {"prescribed": {"base": (0.0, 0.0), (-WIDTH / 2, 0.0): (0.0, 0.1)}},
            ["(-0.2, 0.0)", "'base'"],
        ),
        (
            {"prescribed": {("left", "base"): (0.1, None), "left": (0.0, None)}},
            ["('left', 'base')", "'left'"],
        ),
    ):
        with pytest.raises(InputError) as caught:
            elastic(block(), **supports)
        assert all(word in str(caught.value) for word in [*words, "contradicts"]), caught.value


@pytest.mark.parametrize(
    ("where", "message"),
    [
        ((0.011, 0.0), "nearest one is"),
        ((0.0, 0.0, 0.0), "2 finite numbers"),
        ((np.nan, 0.0), "2 finite numbers"),
        (("left", "right"), "share no point"),
        (("left", "nowhere"), "nowhere"),
        ("nowhere", "nowhere"),
        (3.0, "2 finite numbers"),
        ((), "2 finite numbers"),
    ],
)
def test_locations_that_are_none_are_refused(where, message):
    for others in (
        {"fixed": [where]},
        {"prescribed": {where: (0.0, None)}},
        {"springs": {where: 1.0}},
    ):
        with pytest.raises(InputError, match=message) as caught:
            elastic(block(), **others)
        assert next(iter(others)) in str(caught.value)


def test_points_that_gmsh_names(tmp_path):
    script = tmp_path / "triangle.geo"
    script.write_text(
        "Point(1) = {0, 0, 0, 1}; Point(2) = {1, 0, 0, 1}; Point(3) = {0, 1, 0, 1};"
        "Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 1};"
        "Curve Loop(1) = {1, 2, 3}; Plane Surface(1) = {1};"
        'Physical Surface("solid") = {1}; Physical Curve("base") = {1};'
        'Physical Point("top") = {3}; Physical Point("both") = {1, 2};'
    )
    mesh = mesh_from_gmsh(script)
    assert mesh.points == {"top": [0.0, 1.0]}
    solid = elastic(mesh, fixed=["top"], prescribed={"base": (None, 0.0)})
    assert solid.supports.directions.all()


def test_names_of_points_are_checked():
    with pytest.raises(InputError, match=r"points\['a'\].*2 finite"):
        name_points(block(), {"a": (1.0,)})
    with pytest.raises(InputError, match=r"points\['base'\].*facets"):
        name_points(block(), {"base": (1.0, 0.0)})


# -- springs to the ground --


def hyper(mesh, **others):
    """Nearly linear under small loads; nu = 0 as St. Venant's bar wants it."""
    return HyperelasticSolid(mesh, energy=neo_hookean(E, 0.0), density=RHO, **others)


@pytest.mark.parametrize("stiffness", [2e5, (1e5, 2e5)])
def test_a_block_on_a_foundation_is_exact(stiffness):
    """``u = -p/k - p y/E``: the block goes down as a whole and is pressed."""
    p, k = 100.0, 2e5
    for make, tolerance in ((elastic, 1e-13), (hyper, 1e-7)):
        others = {} if make is hyper else {"poisson_ratio": 0.0}
        solid = make(block(), springs={"base": stiffness}, tractions={"top": (0, -p)}, **others)
        assert solid.supported
        u, x = settled(solid)
        exact = np.stack([0 * x[:, 0], -p / k - p * x[:, 1] / E], axis=1)
        np.testing.assert_allclose(u, exact, rtol=0, atol=tolerance)
        energy = WIDTH * (p**2 / k / 2 + HEIGHT * p**2 / E / 2)
        assert solid.energies()[1] == pytest.approx(energy, rel=1e-3)


def test_springs_at_points_share_the_weight():
    k, corners = 3e3, [(-WIDTH / 2, 0.0), (WIDTH / 2, 0.0)]
    mesh = name_points(block(), {"foot": corners[0]})
    for places in (corners, ["foot", ("right", "base")]):
        solid = elastic(mesh, gravity=(0, -9.81), springs=dict.fromkeys(places, k))
        u, _ = settled(solid)
        feet = [np.abs(solid.vectors.places - c).sum(axis=1).argmin() for c in corners]
        down = solid.displacement.reshape(-1, 2)[feet]
        np.testing.assert_allclose(down[:, 1], -solid.mass * 9.81 / 2 / k, rtol=1e-9)
        np.testing.assert_allclose(down[:, 0].sum(), 0, atol=1e-12)
        assert len(u)


@pytest.mark.parametrize("make", [elastic, hyper])
@pytest.mark.parametrize("scheme", [None, GeneralisedAlpha(0.9)])
def test_a_stiff_block_on_springs_is_an_oscillator(make, scheme):
    """``m q'' + k q = 0``; with damping of its stiffness the springs lose, too."""
    k, errors = 100.0, []

    def fall(x):
        return np.stack([0 * x[0], 1e-3 + 0 * x[0]])

    omega = np.sqrt(k / RHO / HEIGHT)
    for steps in (40, 80):
        solid = make(block(n=(1, 1)), springs={"base": k}, velocity=fall)
        probes = {"q": lambda s=solid: s.mean(s.displacement)[1]}
        until = 2 * np.pi / omega
        history = Scene([solid], [], scheme).run(until, until / steps, probes=probes)
        assert history.finished, history.reason
        exact = 1e-3 / omega * np.sin(omega * history.time)
        errors.append(np.abs(history["q"] - exact).max() * omega / 1e-3)
        check_energies(history, 1e-9 if make is elastic else 1e-6)
    assert errors[-1] < 5e-3
    np.testing.assert_allclose(rates(errors), 2, atol=0.2)
    solid = make(block(n=(1, 1)), springs={"base": k}, damping=Rayleigh(0.0, 0.1), velocity=fall)
    history = Scene([solid], [], scheme).run(until, until / 80)
    rate = 0.1 * omega**2 / 2
    assert history["damping"][-1] / total_energy(history)[0] == pytest.approx(
        np.exp(-2 * rate * until) - 1, rel=0.05
    )


def test_statics_ask_springs_and_hoops_what_they_hold():
    with pytest.raises(InputError, match="nothing holds 'elastic' against moving along x"):
        settled(elastic(block(), springs={"base": (0.0, 1e5)}))
    with pytest.raises(InputError, match="nothing holds 'elastic'"):
        settled(elastic(block(), springs={(-WIDTH / 2, 0.0): 1e5}))
    with pytest.raises(InputError, match="nothing holds 'elastic' against moving along y"):
        settled(elastic(ring(2), plane="axisymmetric", springs={"base": (1.0, 0.0)}))
    settled(elastic(ring(2), plane="axisymmetric", springs={"base": (0.0, 1.0)}))


@pytest.mark.parametrize("value", [-1.0, np.nan, "stiff", None, (1.0,), (1.0, -1.0), 1j, 0.0])
def test_springs_that_are_none_are_refused(value):
    with pytest.raises(InputError, match="springs"):
        elastic(block(), springs={"base": value})


def test_springs_must_be_a_dict():
    with pytest.raises(InputError, match=r"springs.*dict"):
        elastic(block(), springs=["base"])


def test_springs_bear_beside_contact():
    """A block that a spring draws to a floor: the floor bears what the spring and weight pull."""
    k, gap = 1e5, 1e-3
    solid = elastic(
        block(),
        springs={"top": (0.0, k)},
        prescribed={("left", "base"): (0.0, None), ("left", "top"): (0.0, None)},
        poisson_ratio=0.0,
    )
    contact = Contact(solid, "base", HalfSpace((0, gap), (0, 1)), "gap", name="c")
    history = Scene([solid], [contact], QuasiStatic(), deepest=0.1).run(1.0, 1.0)
    assert history.finished, history.reason
    force = gap / (1 / k + HEIGHT / E) * WIDTH
    assert history["c.force_y"][-1] == pytest.approx(force, rel=1e-9)


# -- plane stress --


@pytest.mark.parametrize("cell", CELLS)
def test_pure_bending_in_plane_stress_is_exact(cell):
    """``sigma_xx = c y``: u = c x y/E, v = -c (x² + nu y²)/2E, of degree 2."""
    c, length, height = 1e4, 1.0, 0.4
    mesh = rectangle((4, 2), (length, height), cell)
    mesh.mesh.geometry.x[:, 1] -= height / 2
    mesh.mesh.geometry.x[:, 0] += length / 2
    solid = elastic(
        mesh,
        plane="stress",
        degree=2,
        prescribed={"left": (0.0, None), (0.0, 0.0): (None, 0.0)},
        tractions={"right": lambda x: (c * x[1], 0.0)},
    )
    u, x = settled(solid)
    exact = c / E * np.stack([x[:, 0] * x[:, 1], -(x[:, 0] ** 2 + NU * x[:, 1] ** 2) / 2], axis=1)
    np.testing.assert_allclose(u, exact, rtol=0, atol=1e-12)
    energy = c**2 * height**3 / 12 * length / E / 2
    assert solid.energies()[1] == pytest.approx(energy, rel=1e-11)
    assert "plane stress" in solid.describe()


@pytest.mark.parametrize("plane", ["stresses", None, 2])
def test_planes_that_are_none_are_refused(plane):
    with pytest.raises(InputError, match=r"plane = .*'strain', 'stress', 'axisymmetric'"):
        elastic(block(), plane=plane)


def test_planes_are_of_meshes_in_2d():
    with pytest.raises(InputError, match="plane = 'stress'"):
        elastic(box(), plane="stress")
    with pytest.raises(InputError, match="plane = 'axisymmetric'"):
        hyper(box(), plane="axisymmetric")


def test_plane_stress_of_an_energy_that_does_not_know_its_stretch_across_is_refused():
    with pytest.raises(InputError, match=r"plane = 'stress': energy.*neo_hookean, ciarlet"):
        HyperelasticSolid(block(), energy=lambda F: ufl.inner(F, F), density=1.0, plane="stress")


LAWS = [neo_hookean, ciarlet, st_venant_kirchhoff]


@pytest.mark.second
@pytest.mark.parametrize("law", LAWS)
def test_hyperelastic_plane_stress_is_a_free_plate(law):
    """A square drawn to 1.3 times its length between rollers is as narrow, as strained and as
    stressed as a cube that is free across: uniform, so exact."""
    x_is = {"left": lambda x: np.isclose(x[0], -0.25), "right": lambda x: np.isclose(x[0], 0.25)}
    front = {"front": lambda x: np.isclose(x[1], -0.25), "base": lambda x: np.isclose(x[2], 0)}
    cube = name_facets(box(size=(0.5, 0.5, 0.5)).mesh, x_is | front)
    found = []
    for mesh, more in ((rectangle((2, 2), (0.5, 0.5)), {"plane": "stress"}), (cube, {})):
        others = (None,) * (mesh.dim - 1)
        rollers = {"left": (0.0, *others), "right": (0.15, *others), "base": (*others, 0.0)}
        if mesh.dim == 3:
            rollers |= {"front": (None, 0.0, None)}
        solid = HyperelasticSolid(mesh, energy=law(E, NU), density=1.0, prescribed=rollers, **more)
        u, x = settled(solid)
        thick = 1.0 if mesh.dim == 2 else 0.5
        narrower = u[x[:, -1].argmax(), -1]
        found.append([narrower, solid.reaction("right")[0] / thick, solid.energies()[1] / thick])
    np.testing.assert_allclose(found[0], found[1], rtol=1e-8)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.499])
def test_the_stretch_across_leaves_no_stress_there(nu):
    """All digits from a tenth of the area to ten times it."""
    law, s = neo_hookean(1.0, nu), np.linspace(-np.log(10), np.log(10), 41)
    lmbda, mu = nu / (1 + nu) / (1 - 2 * nu), 1 / 2 / (1 + nu)
    for area in np.exp(s):
        stretch = float(law.across(ufl.as_matrix([[area, 0.0], [0.0, 1.0]])))
        left = mu * (stretch**2 - 1) + lmbda * np.log(area * stretch)
        assert abs(left) < 1e-13 * (mu * stretch**2 + lmbda)


@pytest.mark.second
@pytest.mark.parametrize("scheme", [None, EnergyMomentum()])
def test_a_free_membrane_in_plane_stress_keeps_its_energy(scheme):
    """It spins and breathes."""
    solid = HyperelasticSolid(
        rectangle((2, 2), (0.5, 0.5)),
        energy=neo_hookean(E, NU),
        density=RHO,
        plane="stress",
        displacement=lambda x: 0.1 * x[:2],
        velocity=lambda x: np.stack([-x[1], x[0]]),
    )
    more = {} if scheme is None else {"scheme": scheme}
    history = Scene([solid], [], allow_free=True, **more).run(0.02, 1e-3)
    assert history.finished, history.reason
    total = total_energy(history)
    assert np.ptp(total) < 1e-5 * total[0]
    assert "plane stress" in solid.describe()


# -- axisymmetry --

INNER, OUTER = 1.0, 2.0


def ring(n, cell="quadrilateral", inner=INNER):
    corners, kind = [[inner, 0.0], [OUTER, 0.5]], getattr(dolfinx.mesh.CellType, cell)
    mesh = dolfinx.mesh.create_rectangle(MPI.COMM_WORLD, corners, [2 * n, n], kind)
    return name_facets(
        mesh,
        {
            "inner": lambda x: np.isclose(x[0], inner),
            "outer": lambda x: np.isclose(x[0], OUTER),
            "base": lambda x: np.isclose(x[1], 0.0),
            "top": lambda x: np.isclose(x[1], 0.5),
        },
    )


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("cell", CELLS)
def test_lame_cylinder_converges(cell, degree):
    """A thick-walled cylinder under inner pressure, its ends held: G. Lamé (1852)."""
    p, errors = 1e4, []
    factor = p * INNER**2 / (OUTER**2 - INNER**2)
    for n in (2, 4, 8):
        mesh = ring(n, cell)
        solid = elastic(
            mesh,
            plane="axisymmetric",
            degree=degree,
            prescribed={"base": (None, 0.0), "top": (None, 0.0)},
            tractions={"inner": (p, 0.0)},
        )
        settled(solid)
        x = ufl.SpatialCoordinate(mesh.mesh)
        radial = (1 + NU) / E * factor * ((1 - 2 * NU) * x[0] + OUTER**2 / x[0])
        off = solid.vectors.function(solid.displacement) - ufl.as_vector([radial, 0])
        form = dolfinx.fem.form(ufl.dot(off, off) * x[0] * ufl.dx(degree=6))
        errors.append(np.sqrt(mesh.mesh.comm.allreduce(dolfinx.fem.assemble_scalar(form))))
    assert errors[-1] < 1e-3 * factor * (1 + NU) / E * OUTER**2
    np.testing.assert_allclose(rates(errors)[-1], degree + 1, atol=0.15)


@pytest.mark.parametrize("cell", CELLS)
def test_uniform_states_of_revolution_are_exact(cell):
    """A solid cylinder under pressure from all sides; its axis holds itself."""
    p = 1e4
    solid = elastic(
        ring(3, cell, inner=0.0),
        plane="axisymmetric",
        prescribed={"base": (None, 0.0)},
        tractions={"outer": (-p, 0.0), "top": (0.0, -p)},
    )
    u, x = settled(solid)
    np.testing.assert_allclose(u, -p * (1 - 2 * NU) / E * x, rtol=0, atol=1e-13)
    volume = np.pi * OUTER**2 * 0.5
    assert solid.mass == pytest.approx(RHO * volume, rel=1e-12)
    assert solid.energies()[1] == pytest.approx(volume * 1.5 * p**2 * (1 - 2 * NU) / E, rel=1e-11)
    np.testing.assert_allclose(solid.reaction("base")[1], p * np.pi * OUTER**2, rtol=1e-10)


def test_a_thin_hoop_breathes():
    """``omega² = E/(rho r²)``, plane stress round it and nothing across."""
    thin = 0.01
    corners = [[1.0, 0.0], [1.0 + thin, thin]]
    mesh = dolfinx.mesh.create_rectangle(MPI.COMM_WORLD, corners, [1, 1])
    solid = elastic(
        name_facets(mesh, {}),
        poisson_ratio=0.0,
        plane="axisymmetric",
        velocity=lambda x: np.stack([1.0 + 0 * x[0], 0 * x[1]]),
    )
    omega = np.sqrt(E / RHO) / (1 + thin / 2)
    period = 2 * np.pi / omega
    probes = {"q": lambda: solid.mean(solid.displacement)[0] * omega}
    scene = Scene([solid], [], allow_free=True)
    history = scene.run(period, period / 200, probes=probes)
    assert history.finished, history.reason
    check_energies(history)
    np.testing.assert_allclose(history["q"], np.sin(omega * history.time), atol=1e-3)


def test_a_solid_of_revolution_rests_on_a_floor():
    """Forces are those of the whole solid; what is not of revolution is refused beside it."""
    solid = elastic(ring(3, inner=0.0), plane="axisymmetric", gravity=(0, -9.81))
    contact = Contact(solid, "base", HalfSpace((0, 0), (0, 1)), "gap", name="c")
    history = Scene([solid], [contact], QuasiStatic(), deepest=0.1).run(1.0, 1.0)
    assert history.finished, history.reason
    assert history["c.force_y"][-1] == pytest.approx(solid.mass * 9.81, rel=1e-9)
    with pytest.raises(InputError, match="'elastic' is a solid of revolution and 'flat' is not"):
        Scene([solid, elastic(block(), fixed=["base"], name="flat")], [contact], QuasiStatic())


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree", [1, 2])
def test_pressures_of_a_solid_of_revolution_are_per_area(degree, cell):
    """A cylinder pressed evenly on a floor bears evenly, from its axis outwards; and pressed on a
    compliance it sinks by the pressure over its stiffness."""
    p, k = 1e4, 1e8
    floor = HalfSpace((0, 0), (0, 1))
    for law, sunk in (("gap", 0.0), (Compliance(k), p / k)):
        solid = elastic(
            ring(3, cell, inner=0.0),
            plane="axisymmetric",
            degree=degree,
            tractions={"top": (0.0, -p)},
        )
        contact = Contact(solid, "base", floor, law, name="c")
        history = Scene([solid], [contact], QuasiStatic()).run(1.0, 1.0)
        assert history.finished, history.reason
        assert history["c.force_y"][-1] == pytest.approx(p * np.pi * OUTER**2, rel=1e-9)
        bears = contact.surface.area > 1e-9 * contact.surface.area.max()
        assert bears.sum() >= len(bears) - 1
        np.testing.assert_allclose(contact.pressure[bears], p, rtol=1e-8)
        base = solid.mesh.mesh.geometry.x[:, 1] == 0
        np.testing.assert_allclose(solid.fields()["displacement"][base, 1], -sunk, atol=1e-11)


@pytest.mark.parametrize("degree", [1, 2])
def test_pressures_between_solids_of_revolution_are_per_area(degree):
    """So are Tresca's bound and a compliance, whichever way round the two face each other."""
    p, k = 1e4, 1e8
    below = lambda x: np.isclose(x[1], -0.5)  # noqa: E731
    for law, sunk in (("gap", 0.0), (Compliance(k), p / k)):
        for swapped in (False, True):
            upper = elastic(
                ring(3, "triangle", inner=0.0),
                plane="axisymmetric",
                degree=degree,
                tractions={"top": (0.0, -p)},
                name="upper",
            )
            mesh = ring(2, inner=0.0).mesh
            mesh.geometry.x[:, 1] -= 0.5
            lower = elastic(
                name_facets(mesh, {"base": below, "top": lambda x: np.isclose(x[1], 0.0)}),
                plane="axisymmetric",
                degree=degree,
                prescribed={"base": (None, 0.0)},
                name="lower",
            )
            sides = [(upper, "base"), (lower, "top")]
            (slave, facets), master = sides[swapped], sides[not swapped]
            contact = Contact(slave, facets, master, law, name="c")
            scene = Scene([upper, lower], [contact], QuasiStatic())
            history = scene.run(1.0, 1.0)
            assert history.finished, history.reason
            force = history["c.force_y"][-1] * (-1 if swapped else 1)
            assert force == pytest.approx(p * np.pi * OUTER**2, rel=1e-9)
            np.testing.assert_allclose(contact.pressure, p, rtol=1e-8)
            base = upper.mesh.mesh.geometry.x[:, 1] == 0
            lowered = upper.fields()["displacement"][base, 1]
            squashed = 0.5 * p / E
            np.testing.assert_allclose(lowered, -sunk - squashed, atol=1e-11)


def rubber(mesh, **others):
    given = {"energy": neo_hookean(E, NU), "density": RHO, "plane": "axisymmetric"}
    return HyperelasticSolid(mesh, **{**given, **others})


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("cell", CELLS)
def test_a_cylinder_is_stretched_by_half(cell, degree):
    """Uniform large strain: the stretch across makes the stress across vanish."""
    lmbda, mu, stretch = E * NU / (1 + NU) / (1 - 2 * NU), E / 2 / (1 + NU), 1.5
    across = brentq(lambda a: mu * (a**2 - 1) + lmbda * np.log(a**2 * stretch), 0.3, 2.0)
    axial = mu * (stretch - 1 / stretch) + lmbda * np.log(across**2 * stretch) / stretch
    solid = rubber(
        ring(3, cell, inner=0.0),
        degree=degree,
        prescribed={"base": (None, 0.0), "top": lambda t: (None, (stretch - 1) * 0.5 * t)},
    )
    history = Scene([solid], [], QuasiStatic()).run(1.0, 0.25)
    assert history.finished, history.reason
    u, x = solid.displacement.reshape(-1, 2), solid.vectors.places
    np.testing.assert_allclose(u, x * [across - 1, stretch - 1], rtol=0, atol=1e-8)
    assert solid.reaction("top")[1] == pytest.approx(axial * np.pi * OUTER**2, rel=1e-7)
    stress = np.diag([0.0, axial / across**2, 0.0])  # r, y, hoop
    np.testing.assert_allclose(solid.stress()[0], stress, rtol=0, atol=1e-7 * axial)


def breathing(make, size, **others):
    """A cylinder that swells at its top."""
    return make(
        ring(6, inner=0.0),
        velocity=lambda x: size * np.stack([x[0] * x[1], x[0] * x[1]]),
        **others,
    )


def test_small_motions_of_revolution_are_those_of_the_linear_solid():
    """With damping; but for the quadrature."""
    ends = []
    for make in (lambda mesh, **o: elastic(mesh, plane="axisymmetric", **o), rubber):
        solid = breathing(make, 1e-6, fixed=["base"], damping=Rayleigh(1.0, 1e-4))
        history = Scene([solid], []).run(0.05, 1e-3)
        assert history.finished and history["damping"][-1] < 0
        ends.append(solid.displacement)
    np.testing.assert_allclose(ends[1], ends[0], rtol=0, atol=1e-3 * np.abs(ends[0]).max())


@pytest.mark.second
@pytest.mark.parametrize("law", ["velocity", "gap"])
def test_energy_of_revolution_through_an_impact(law):
    """EnergyMomentum keeps it in large motion, exactly where the energy is quadratic in C; on a
    floor with friction none is gained."""
    solid = breathing(rubber, 20.0, energy=st_venant_kirchhoff(E, NU))
    scene = Scene([solid], [], EnergyMomentum(), allow_free=True, geometry="newton")
    total = total_energy(history := scene.run(0.1, 5e-3))
    assert history.finished and history["strain"].max() > 0.3 * total[0]
    assert np.abs(total - total[0]).max() < 1e-9 * total[0]
    solid = rubber(ring(3, inner=0.0), velocity=(0.0, -2.0))
    contact = Contact(solid, "base", HalfSpace((0, 0), (0, 1)), law, friction=0.3, name="c")
    scene = Scene([solid], [contact], EnergyMomentum(), geometry="newton")
    total = total_energy(history := scene.run(0.02, 1e-3))
    assert history.finished and history["c.force_y"].max() > 0
    assert (total - total[0]).max() < 1e-9 * total[0]


def test_two_solids_of_revolution_press_each_other():
    """Meshes that do not match, large strain: forces are those of a column."""
    down = {"top": lambda t: (None, -0.3 * t)}
    for n in (2, 4):
        upper, lower = ring(n, inner=0.0), ring(3 * n // 2, "triangle", inner=0.0)
        upper.mesh.geometry.x[:, 1] += 0.5
        bodies = [
            rubber(upper, prescribed=down, name="upper"),
            rubber(lower, prescribed={"base": (None, 0.0)}, name="lower"),
        ]
        contact = Contact(bodies[0], "base", (bodies[1], "top"), "gap", name="c")
        history = Scene(bodies, [contact], QuasiStatic(), geometry="newton").run(1.0, 0.25)
        assert history.finished, history.reason
        pressed = history["c.force_y"][-1]
        reactions = [-bodies[0].reaction("top")[1], bodies[1].reaction("base")[1]]
        np.testing.assert_allclose(reactions, pressed, rtol=1e-9)
        column = rubber(
            ring(2, inner=0.0),
            prescribed={"base": (None, 0.0), "top": lambda t: (None, -0.15 * t)},
        )
        assert Scene([column], [], QuasiStatic()).run(1.0, 0.25).finished
        assert pressed == pytest.approx(-column.reaction("top")[1], rel=1e-8)


def test_negative_radii_are_refused():
    with pytest.raises(InputError, match=r"axisymmetric.*radius.*-0\.2"):
        elastic(block(), plane="axisymmetric")


# -- processes --

SCRIPT = """
import sys
sys.path.insert(0, {tests!r})
import numpy as np
from test_supports import *
from fenicsx_contact import Rayleigh
mesh = name_points(rectangle((4, 8), (WIDTH, HEIGHT)), {{"corner": (-WIDTH / 2, 0.0)}})
out = []
for make in (elastic, hyper):
    solid = make(
        mesh, fixed=["corner"], prescribed={{("right", "base"): (None, 0.0)}},
        springs={{"left": 1e5, (WIDTH / 2, HEIGHT): (0.0, 1e4)}}, damping=Rayleigh(1.0, 1e-3),
        tractions={{"top": lambda x, t: (1e3 * t, -1e3 * (1 + x[0]))}},
        body_force=lambda x: np.stack([np.sin(x[0]), 0 * x[0]]), density=lambda x: RHO * (1 + x[1]),
    ) if make is elastic else make(
        mesh, fixed=["corner"], springs={{"left": 1e5}}, damping=Rayleigh(1.0, 1e-3),
        tractions={{"top": lambda t: (1e3 * t, -1e3)}},
    )
    history = Scene([solid], []).run(0.02, 1e-3)
    assert history.finished, history.reason
    out.append(history.rows()[-1, 2:11])
try:
    elastic(mesh, fixed=[(0.01, 0.0)])
except InputError as refused:
    assert "nearest" in str(refused)
if MPI.COMM_WORLD.rank == 0:
    np.save({file!r}, np.array(out))
"""


@pytest.mark.second
@needs_mpirun
def test_two_processes_give_the_numbers_of_one(tmp_path):
    found = []
    for n in (1, 2):
        file = str(tmp_path / f"{n}.npy")
        code = SCRIPT.format(tests=str(Path(__file__).parent), file=file)
        output_of(mpirun(code, n))
        found.append(np.load(file))
    size = np.abs(found[0][:, :8]).max(axis=1, keepdims=True)
    assert size.min() > 0
    np.testing.assert_allclose(found[1] / size, found[0] / size, rtol=0, atol=1e-9)


@pytest.mark.parametrize("law", ["velocity", "gap"])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_a_floor_that_rises_into_a_held_node_is_named(law, friction):
    """It was a row that stalls, after 295 steps of the method of multipliers. A node that is led
    along with the floor asks for nothing that cannot be."""
    pressed = {"youngs_modulus": 1e3, "poisson_ratio": 0.3, "density": 1.0}
    pressed["tractions"] = {"top": (0.0, -1.0)}
    rises, histories = (lambda t: (0.0, 0.01 * t)), []
    for support in ({"fixed": ["right"]}, {"prescribed": {"right": rises}}):
        block = ElasticSolid(rectangle((4, 2), (1.0, 0.4)), **pressed, **support)
        contact = Contact(block, "base", Moved(FLOOR, rises), law, friction)
        histories.append(Scene([block], [contact], QuasiStatic()).run(1.0, 0.5))
    assert "m into a held node of a contact, at (0.5, 0)" in histories[0].reason
    assert "held in the way" in histories[0].advice
    assert histories[1].finished


def lap(below, angle, law="gap", geometry=None):
    """A plate that is held on its left lies on something, under another that is pressed on it."""
    R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    stiff = {"youngs_modulus": 2e9, "poisson_ratio": 0.3, "density": 1000.0}

    def placed(n, size, x, y):
        mesh = rectangle(n, size)
        mesh.mesh.geometry.x[:, :2] = (mesh.mesh.geometry.x[:, :2] + (x, y)) @ R.T
        return mesh

    plate = ElasticSolid(placed((8, 2), (1.0, 0.1), 0.0, 0.0), fixed="left", **stiff)
    press = {"top": lambda t: tuple(R @ (0.0, -1e6 * min(t, 1.0)))}
    upper = ElasticSolid(
        placed((7, 2), (0.7, 0.1), 0.35, 0.1),
        prescribed={"right": (0.0, 0.0)}, tractions=press, name="upper", **stiff,
    )  # fmt: skip
    solids = [plate, upper]
    if below == "obstacle":
        contact = Contact(plate, "base", HalfSpace((0.0, 0.0), tuple(R[:, 1])), law)
    else:
        block = placed((8, 1), (1.0, 0.2), 0.0, -0.2)
        solids.append(RigidSolid(block, mass=1.0, held=("x", "y", "turning")))
        sides = (plate, "base"), (solids[2], "top")
        (slave, facets), master = sides if below == "master" else sides[::-1]
        contact = Contact(slave, facets, master, law)
    contacts = [contact, Contact(plate, "top", (upper, "base"), law, name="between")]
    history = Scene(solids, contacts, ThetaScheme(1.0), geometry=geometry).run(3.0, 1.0)
    assert history.finished, history.reason
    x = (contact.coupling.positions() @ R)[:, 0]
    return np.abs(contact.borne @ R[:, 1])[np.argsort(x)]


@pytest.mark.parametrize("law", ["gap", "velocity"])
@pytest.mark.parametrize("below", ["obstacle", "master", "slave"])
@pytest.mark.parametrize(("geometry", "digits"), [("newton", 1e-9), ("mixed", 1e-8)])
def test_a_held_node_that_touches_bears_nothing(geometry, digits, below, law):
    """No motion depends on such a force, and round-off decided it: 573 N by the angle of the
    scene, more in each step; between two solids up to 1e31 N, or rows stalled."""
    expected, forces = (lap(below, angle, law, geometry) for angle in (0.0, 0.6))
    assert forces[0] == 0
    np.testing.assert_allclose(forces, expected, rtol=0, atol=digits * expected.max())


@pytest.mark.parametrize(
    ("degree", "cells"), [(1, (54, 40)), (1, (40, 54)), (2, (40, 54)), (2, (80, 80))]
)
@pytest.mark.parametrize("law", ["gap", "velocity"])
def test_of_two_cantilevers_each_bears_half(law, degree, cells):
    """Two beams on each other, held at one edge, the upper one pressed: they bend alike, so the
    contact hands on half of the load (to what shear and the mesh near the edge change). The node
    at the edge bore 30 times the load where the lower mesh was the finer one, and contact settled
    on frozen geometry by a tangent that was not frozen: rows stalled at 1e78."""
    plates = []
    for y, n in zip((0.0, 0.05), cells):
        mesh = rectangle((n, 2), (1.0, 0.05), "triangle")
        mesh.mesh.geometry.x[:, 1] += y
        stiff = {"youngs_modulus": 2e9, "poisson_ratio": 0.0, "density": 1000.0}
        press = {"tractions": {"top": (0.0, -1e5)}, "name": "upper"} if y else {}
        plates.append(ElasticSolid(mesh, fixed=["left"], degree=degree, **stiff, **press))
    contact = Contact(plates[1], "base", (plates[0], "top"), law)
    history = Scene(plates, [contact], QuasiStatic()).run(1.0, 0.5)
    assert history.finished, history.reason
    assert contact.force[:, 1].sum() == pytest.approx(5e4, rel=0.5 if degree == 1 else 0.1)


@pytest.mark.parametrize("solver", ["condensed", "monolithic"])
@pytest.mark.parametrize("amplitude", [0.25, 1.5], ids=["stick", "slip"])
def test_a_leaf_spring_takes_few_iterations(solver, amplitude):
    """What slips together went to and fro: 50 to 116 iterations for a step in which all sticks, or
    none was found. A slip that is turned round sticks first, and the solution is the same."""

    def bent(**scene):
        plates, shear = [], amplitude * 0.3 * 1e4 / 1.5  # all slip at 1.0
        for y, press in ((0.0, 1e4), (0.05, -1e4)):
            mesh = rectangle((80, 2), (1.0, 0.05))
            mesh.mesh.geometry.x[:, 1] += y
            given = {"youngs_modulus": 1e9, "poisson_ratio": 0.0, "density": 1.0, "plane": "stress"}
            given["tractions"] = {"base" if y == 0 else "top": (0, press), "right": (0, -shear)}
            plates.append(ElasticSolid(mesh, fixed=["left"], name=f"at {y}", **given))
        contact = Contact(plates[1], "base", (plates[0], "top"), "gap", friction=0.3)
        history = Scene(plates, [contact], QuasiStatic(), **scene).run(1.0, 1.0)
        assert history.finished, history.reason
        return history["newton"].max(), plates[1].fields()["displacement"]

    most, moved = bent(solver=solver)
    assert most <= 25
    np.testing.assert_allclose(moved, bent(geometry="fixed point")[1], atol=1e-3 * abs(moved).max())


HELD_ALONG = [("quadrilateral", (4, 1)), ("triangle", (4, 2)), ("hexahedron", (4, 2, 1))]


@pytest.mark.parametrize("law", ["gap", "velocity"])
@pytest.mark.parametrize("scheme", [QuasiStatic(), ThetaScheme(1.0)], ids=["static", "theta"])
@pytest.mark.parametrize(("cell", "n"), HELD_ALONG)
def test_simply_supported_layers_each_bear_half(cell, n, scheme, law):
    """Ends that are held along the normal at rest, and not across, turn as the layers bend: by as
    small a lever their nodes pushed 2e4 times the load, or rows stalled."""
    d, up = len(n), (0.0,) * (len(n) - 1)
    layers = []
    for z in (0.0, 0.1):
        mesh = (rectangle if d == 2 else box)(n, (1.0, *(0.4,) * (d - 2), 0.1), cell)
        mesh.mesh.geometry.x[:, d - 1] += z
        ends = dict.fromkeys(("left", "right"), (*(None,) * (d - 1), 0.0))
        middle = {(0.0, *(-0.2,) * (d - 2), 2 * z): (0.0,) * (d - 1) + (None,)}
        if d == 3:
            middle[0.0, 0.2, 2 * z] = (0.0, None, None)
        press = {"tractions": {"top": (*up, -1e3)}, "name": "upper"} if z else {}
        stiff = {"youngs_modulus": 1e9, "poisson_ratio": 0.3, "density": 1e3}
        layers.append(ElasticSolid(mesh, prescribed={**ends, **middle}, **stiff, **press))
    contact = Contact(layers[1], "base", (layers[0], "top"), law)
    history = Scene(layers, [contact], scheme).run(0.02, 2e-3)
    assert history.finished, history.reason
    load = 1e3 * (0.4 if d == 3 else 1.0)
    assert contact.force[:, d - 1].sum() == pytest.approx(0.5 * load, rel=0.08)
    assert contact.pressure.max() < 1e3


@pytest.mark.parametrize("law", ["gap", "velocity"])
@pytest.mark.parametrize("scheme", [QuasiStatic(), ThetaScheme(1.0)], ids=["static", "theta"])
def test_points_that_nothing_asked_are_certified(monkeypatch, scheme, law):
    """A solution without candidates, of bodies through each other, was certified: a state of 1e33 m
    on the way had lost them all."""
    stiff = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1e3}
    lower = ElasticSolid(rectangle(), fixed=["base"], name="lower", **stiff)
    mesh = rectangle()
    mesh.mesh.geometry.x[:, 1] += 0.8
    upper = ElasticSolid(mesh, prescribed={"top": lambda t: (0.0, -1e-2 * t)}, **stiff)
    contact = Contact(upper, "base", (lower, "top"), law)
    nobody = np.zeros(2, dtype=bool)
    monkeypatch.setattr(Candidates, "choose", lambda self: self._equations.choose(nobody))
    history = Scene([upper, lower], [contact], scheme).run(1.0, 0.25)
    assert not history.finished and "certificate" in history.reason


@pytest.mark.parametrize("law", ["gap", "velocity"])
@pytest.mark.parametrize("cells", [(6, 4), (8, 6), (4, 6), (4, 4)])
def test_of_two_clamped_plates_each_bears_half(law, cells):
    """Two corners of each are facets of which all nodes are held, beside ones of which one is
    free: with multipliers of their own they pushed 63 and 918 times the load."""
    plates, sides = [], {"left": (0, -0.5), "right": (0, 0.5), "front": (1, -0.5), "back": (1, 0.5)}
    for z, n in zip((0.0, 0.05), cells):
        mesh = box((n, n, 1), (1.0, 1.0, 0.05), "tetrahedron").mesh
        places = {name: partial(lambda x, i, c: np.isclose(x[i], c), i=i, c=c)
                  for name, (i, c) in sides.items()}  # fmt: skip
        places |= {"base": lambda x: np.isclose(x[2], 0.0), "top": lambda x: np.isclose(x[2], 0.05)}
        named = name_facets(mesh, places)
        mesh.geometry.x[:, 2] += z
        stiff = {"youngs_modulus": 1e9, "poisson_ratio": 0.3, "density": 1e3}
        press = {"tractions": {"top": (0, 0, -1e3)}, "name": "upper"} if z else {}
        plates.append(ElasticSolid(named, fixed=[*sides], **stiff, **press))
    contact = Contact(plates[1], "base", (plates[0], "top"), law)
    history = Scene(plates, [contact], QuasiStatic()).run(1.0, 0.5)
    assert history.finished, history.reason
    assert history["newton"].max() <= 6
    assert contact.force[:, 2].sum() == pytest.approx(500.0, rel=0.25)
    assert contact.pressure.max() < 1.1e3
