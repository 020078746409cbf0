# SPDX-License-Identifier: LGPL-3.0-or-later
"""Moduli, densities and loads as numbers, constants, functions, expressions and functions of x, t:
each kind gives the same result."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import ufl
from dolfinx import fem
from processes import mpirun, needs_mpirun, output_of
from scenes import FLOOR, FLOOR_3D, box, rectangle

from fenicsx_contact import (
    Contact,
    Discrete,
    ElasticSolid,
    GeneralisedAlpha,
    HalfSpace,
    HyperelasticSolid,
    InputError,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    ciarlet,
    mesh_from_gmsh,
    neo_hookean,
)
from fenicsx_contact.base import compat, compiling
from fenicsx_contact.contact.nodal_values import NodalValues

MESH = rectangle((4, 2), (1.0, 0.4))
X = ufl.SpatialCoordinate(MESH.mesh)


def function(field, degree=1, shape=()):
    made = fem.Function(compat.lagrange_space(MESH.mesh, degree, shape))
    made.interpolate(field)
    return made


def elastic(**others):
    numbers = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
    return ElasticSolid(MESH, **{**numbers, "fixed": ["left"], **others})


def pulled(**others):
    """Where its right end is drawn to, without inertia, and how long it takes to get there."""
    solid = elastic(tractions={"right": (2e4, 1e3)}, **others)
    assert Scene([solid], [], QuasiStatic()).run(1.0, 1.0).finished
    still = solid.displacement.copy()
    solid = elastic(tractions={"right": (2e4, 1e3)}, **others)
    assert Scene([solid], []).run(0.01, 1e-3).finished
    return np.concatenate([still, solid.displacement, [solid.mass]])


# -- numbers of the material --

UNIFORM = [
    lambda c: fem.Constant(MESH.mesh, c),
    lambda c: function(lambda x: c + 0 * x[0]),
    lambda c: c + 0 * X[0],
    lambda c: lambda x: c,
    lambda c: lambda x: np.full(x.shape[1], c),
]
VARYING = [
    lambda c: function(lambda x: c * (1 + 0.5 * x[0])),
    lambda c: c * (1 + X[0] / 2),
    lambda c: lambda x: c * (1 + 0.5 * x[0]),
    lambda c: lambda x: c * (1 + 0.5 * np.add(np.sin(0 * x[0]), x[0])),
    lambda c: fem.Constant(MESH.mesh, c) * ufl.exp(ufl.ln(1 + X[0] / 2)),
]
NUMBERS = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}


@pytest.mark.parametrize("name", NUMBERS)
def test_each_kind_of_number_gives_the_same(name):
    expected = pulled()
    for kind in UNIFORM:
        np.testing.assert_allclose(pulled(**{name: kind(NUMBERS[name])}), expected, rtol=1e-11)
    first = pulled(**{name: VARYING[0](NUMBERS[name])})
    assert np.abs(first - expected)[:-1].max() > 1e-2 * np.abs(expected[:-1]).max()
    for kind in VARYING[1:]:
        got = pulled(**{name: kind(NUMBERS[name])})
        np.testing.assert_allclose(got, first, rtol=0, atol=1e-6 * np.abs(first[:-1]).max())
        assert got[-1] == pytest.approx(first[-1], rel=1e-12)


def test_stiffness_and_mass_of_a_graded_bar_are_exact():
    """``E (1 + x)`` in uniform strain, ``rho (1 + x²)`` in uniform motion."""
    solid = elastic(
        youngs_modulus=lambda x: 1e6 * (1 + x[0]),
        poisson_ratio=0.0,
        density=lambda x: 1000 * (1 + x[0] ** 2),
        fixed=(),
        displacement=lambda x: np.stack([0.01 * x[0], 0 * x[1]]),
        velocity=lambda x: np.stack([2.0 + 0 * x[0], 0 * x[1]]),
    )
    mass = 0.4 * 1000 * (1 + 1 / 12)
    assert solid.mass == pytest.approx(mass, rel=1e-13)
    np.testing.assert_allclose(solid.energies()[:2], [2 * mass, 0.4 * 0.5e6 * 1e-4], rtol=1e-12)
    assert "E between 500000 and 1500000" in solid.describe()


def test_a_solid_stays_what_it_was_made_of():
    """In its stress, too, which followed what the Constant or the Function had become."""
    for kind in UNIFORM[:2]:
        moduli = [kind(number) for number in (1e6, 0.3)]
        E, nu = moduli if isinstance(moduli[0], fem.Function) else (m + 0 * X[0] for m in moduli)
        solid = elastic(youngs_modulus=E, poisson_ratio=nu, displacement=lambda x: 0.01 * x[:2])
        expected = elastic(displacement=lambda x: 0.01 * x[:2]).stress()
        for each in moduli:
            (each.x.array if isinstance(each, fem.Function) else each.value)[...] *= 1.5
        np.testing.assert_allclose(solid.stress(), expected, rtol=1e-9, atol=1e-3)


def test_stored_energies_take_fields():
    ends = []
    for E in (
        1e6,
        fem.Constant(MESH.mesh, 1e6),
        1e6 + 0 * X[0],
        function(lambda x: 1e6 + 0 * x[0]),
    ):
        solid = HyperelasticSolid(
            MESH,
            energy=neo_hookean(E, 0.3),
            density=1000.0,
            fixed=["left"],
            tractions={"right": (2e4, 1e3)},
        )
        assert Scene([solid], [], QuasiStatic()).run(1.0, 1.0).finished
        ends.append(solid.displacement)
    for other in ends[1:]:
        np.testing.assert_allclose(other, ends[0], rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "value",
    [
        lambda: -1.0 + 0 * X[0],
        lambda: X[0],
        lambda: X,
        lambda: 1 / (X[0] - X[0]),
        lambda: function(lambda x: np.where(x[0] > 0.1, np.nan, 1.0)),
        lambda: function(lambda x: x[:2], shape=(2,)),
        lambda: lambda x: np.nan,
        lambda: lambda x: np.ones((2, x.shape[1])),
        lambda: lambda x: 1.0 + 1j * np.ones(x.shape[1]),
        lambda: lambda x: "much",
        lambda: lambda x, t: 1.0,
        lambda: lambda: 1.0,
        lambda: (1 + 1j) * X[0] ** 2,
        lambda: ufl.TestFunction(compat.lagrange_space(MESH.mesh)),
        lambda: fem.Function(compat.lagrange_space(rectangle().mesh)),
        lambda: ufl.SpatialCoordinate(rectangle().mesh)[0] + 2,
        lambda: "1e6",
        lambda: None,
        lambda: 1j,
        lambda: True,
    ],
)
@pytest.mark.parametrize("name", ["youngs_modulus", "density"])
def test_what_is_no_modulus_is_refused(name, value):
    with pytest.raises(InputError, match=name):
        elastic(**{name: value()})


def test_a_modulus_that_gives_nothing_is_told_so():
    """It was told as not finite everywhere: None is NaN to numpy."""
    with pytest.raises(InputError, match="no real numbers: None"):
        elastic(youngs_modulus=lambda x: None)


@pytest.mark.parametrize("value", [lambda x: 0.5 + 0 * x[0], 0.6 * X[0] + 0.3, 0.5])
def test_poisson_ratio_is_within_its_limits_everywhere(value):
    with pytest.raises(InputError, match=r"poisson_ratio.*0\.5"):
        elastic(poisson_ratio=value)


# -- loads --

STEADY = [
    (2e4, 1e3),
    fem.Constant(MESH.mesh, (2e4, 1e3)),
    function(lambda x: np.stack([2e4 + 0 * x[0], 1e3 + 0 * x[0]]), shape=(2,)),
    ufl.as_vector([2e4, 1e3 + 0 * X[0]]),
    lambda t: (2e4, 1e3),
    lambda x: (2e4, 1e3),
    lambda x: np.stack([np.full(x.shape[1], 2e4), np.full(x.shape[1], 1e3)]),
    lambda x, t: (2e4, 1e3 + 0 * t),
]


def loaded(scheme, **load):
    solid = elastic(**load)
    history = Scene([solid], [], scheme).run(0.01, 1e-3)
    assert history.finished, history.reason
    check_books(history)
    return solid.displacement


def check_books(history):
    assert np.abs(history["balance"]).max() < 1e-10 * (1 + np.abs(history["drive"]).max())


@pytest.mark.parametrize("where", ["tractions", "body_force"])
def test_each_kind_of_load_gives_the_same(where):
    def given(load):
        return {where: {"right": load} if where == "tractions" else load}

    first = loaded(ThetaScheme(), **given(STEADY[0]))
    for load in STEADY[1:]:
        np.testing.assert_allclose(
            loaded(ThetaScheme(), **given(load)), first, rtol=0, atol=1e-13 * np.abs(first).max()
        )
    timed = [
        lambda t: (2e4 * t, 1e3 * t**2),
        lambda x, t: ufl.as_vector([2e4 * t, 1e3 * t**2 + 0 * x[0]]),
        lambda x, t: (2e4 * t, 1e3 * t**2),
        lambda x, t: (2e4 * math.atan(math.tan(t)), np.exp(np.log(1e3)) * (t * t if t > 0 else 0)),
        lambda x, t: ufl.as_vector([2e4 * t, 1e3 * t**2]),
        lambda x, t: np.array([2e4 * t + np.zeros(x.shape[1]), 1e3 * t**2 + np.zeros(x.shape[1])]),
    ]
    for scheme in (ThetaScheme(), GeneralisedAlpha(0.7)):
        first = loaded(scheme, **given(timed[0]))
        for load in timed[1:]:
            np.testing.assert_allclose(
                loaded(scheme, **given(load)), first, rtol=0, atol=1e-13 * np.abs(first).max()
            )


def test_a_pressure_along_the_normals_of_the_facets():
    """As it is written in UFL, steady and in time; facets alone have normals."""
    n = ufl.FacetNormal(MESH.mesh)
    first = loaded(ThetaScheme(), tractions={"right": (-2e4, 0.0)})
    for load in (-2e4 * n, lambda x: -2e4 * n, lambda x, t: -2e4 * (1 + 0 * t) * n):
        same = loaded(ThetaScheme(), tractions={"right": load})
        np.testing.assert_allclose(same, first, rtol=0, atol=1e-13 * np.abs(first).max())
    with pytest.raises(InputError, match="normals of facets"):
        elastic(body_force=-2e4 * n)
    with pytest.raises(InputError, match="normals of facets"):
        elastic(youngs_modulus=1e9 * n[0] ** 2)


def test_a_load_that_varies_along_the_solid():
    """Its resultant and its moment, in each way of writing it."""
    for load in (
        lambda x: (0.0, 100 * x[0] ** 2),
        ufl.as_vector([0, 100 * X[0] ** 2]),
        lambda x: np.stack([0 * x[0], 100 * np.power(x[0], 2)]),
    ):
        solid = elastic(tractions={"top": load}, fixed=["base"])
        Scene([solid], [], QuasiStatic()).run(1.0, 1.0)
        np.testing.assert_allclose(solid.reaction("base"), [0, -100 / 12], atol=1e-9)


@pytest.mark.parametrize("scheme", [ThetaScheme(), GeneralisedAlpha(0.8)])
def test_a_force_in_time_moves_a_stiff_bar_as_a_point(scheme):
    """``m v = F t²/2`` by the trapezoidal rule, which is exact for what is linear in t; and drives
    it by all of its kinetic energy."""
    F, dt = 3e3, 0.01
    for load in (
        {"tractions": {"right": lambda t: (F * t, 0.0)}},
        {"body_force": lambda t: (F * t, 0.0)},
        {"body_force": lambda x, t: (F * t, 0.0)},
    ):
        solid = elastic(youngs_modulus=1e10, poisson_ratio=0.0, fixed=(), **load)
        history = Scene([solid], [], scheme, allow_free=True).run(0.5, dt)
        assert history.finished, history.reason
        speed = F * 0.4 * 0.5**2 / 2 / solid.mass
        late = 0.0 if scheme == ThetaScheme() else F * 0.4 / solid.mass * dt**2
        assert solid.mean(solid.velocity)[0] == pytest.approx(speed, rel=1e-9, abs=late)
        if scheme == ThetaScheme():
            work = solid.mass * speed**2 / 2
            np.testing.assert_allclose(history["drive"][-1], work, rtol=1e-6)
            check_books(history)


def test_what_is_applied_works_on_the_way_gone():
    """As weight does, by theta = 1, too, in which mean velocities are not of the way."""
    G, top = 9.81, 1000.0 * 9.81 * 0.4
    loads = {"gravity": (0, -G)}, {"body_force": (0, -1000 * G)}, {"tractions": {"top": (0, -top)}}
    found = []
    for load in loads:
        solid = elastic(fixed=(), **load)
        history = Scene([solid], [], ThetaScheme(1.0), allow_free=True).run(0.1, 0.01)
        assert history.finished, history.reason
        given = history["drive"] - history["potential"]
        found.append((given, history["scheme"] - history["strain"]))
        check_books(history)
    exact = 400.0 * G**2 * 0.01 * np.arange(11) * 0.01 * (np.arange(11) + 1) / 2
    np.testing.assert_allclose(found[0][0], exact, rtol=1e-9)
    np.testing.assert_allclose(found[1], found[0], rtol=1e-9, atol=1e-9 * exact[-1])
    # what pulls at the top strains the block, too
    np.testing.assert_allclose(found[2][0][-1], exact[-1], rtol=1e-2)


@pytest.mark.parametrize(
    "value",
    [
        (1.0, 2.0, 3.0),
        1.0,
        (np.nan, 0.0),
        (1j, 0.0),
        "down",
        X[0],
        ufl.as_vector([X[0], X[0], X[0]]),
        ufl.as_vector([1 / (X[0] - X[0]), 0]),
        lambda t: (1.0,),
        lambda t: (np.nan, t),
        lambda x: 1.0,
        lambda x: (np.nan, 0.0),
        lambda x: np.ones((3, x.shape[1])),
        lambda x: (1.0 + 1j) * np.ones((2, x.shape[1])),
        lambda x, t: (x[0] + 1j, 0.0),
        lambda x, t, more: (1.0, 0.0),
    ],
)
@pytest.mark.parametrize("where", ["tractions", "body_force"])
def test_what_is_no_load_is_refused(where, value):
    with pytest.raises(InputError, match=where):
        elastic(**{where: {"right": value} if where == "tractions" else value})


def test_a_load_that_turns_bad_ends_the_run_then():
    def late(x, t):
        return np.stack([np.where(t > 0.005, np.nan, 1.0) + 0 * x[0], 0 * x[0]])

    solid = elastic(body_force=late)
    history = Scene([solid], []).run(0.01, 1e-3)
    assert (
        not history.finished and "body_force: not finite everywhere at t = 0.00" in history.reason
    )
    assert history.time[-1] == pytest.approx(0.005, rel=1e-3)


def test_no_load_is_no_load():
    solid = elastic()
    assert solid.applied is None and solid.foundations == [] and solid.dampers == []


def test_other_numbers_compile_nothing():
    """Nor do meshes from gmsh, of which elements and sides are named in another way, by 0.5.2."""

    def dropped(mesh, k):
        """A block of Ciarlet's law and an elastic one, all numbers but g multiplied."""
        energy = ciarlet(k * 1e6, 0.3 * k)
        solids = [
            HyperelasticSolid(mesh, energy=energy, density=k * 1e3, springs={"base": k * 1e5}),
            ElasticSolid(
                mesh, youngs_modulus=k * 1e6, poisson_ratio=0.3 * k, density=k * 1e3, name="other"
            ),
        ]
        floor = HalfSpace((0, -0.01 * k), (0, 1))
        contacts = [
            Contact(solid, "base", floor, Discrete(k * 1e7, k * 1e6), friction=0.3 * k)
            for solid in solids
        ]
        assert Scene(solids, contacts).run(2e-3, 1e-3, progress=False).finished

    dropped(rectangle((2, 2)), 1.0)
    known = set(compiling._known)
    dropped(rectangle((3, 2)), 0.7)
    if not compat.MODERN:
        dropped(mesh_from_gmsh("block.geo", n_width=2), 0.7)
    assert set(compiling._known) == known


def test_a_constant_that_a_derivative_does_not_hold():
    """The form compiler of 0.5.2 read it in place of the one that stays."""
    first, second = fem.Constant(MESH.mesh, 3.0), fem.Constant(MESH.mesh, 5.0)
    unknown = ufl.variable(function(lambda x: x[0]))
    slope = ufl.diff(first + 0.25 * second * unknown, unknown)
    values = compat.PointExpression(slope, compat.lagrange_space(MESH.mesh))()
    np.testing.assert_allclose(values, 1.25, rtol=1e-15)


def loads(mesh):
    """Pressures on the top, 1e4 Pa at first, and what doubles them."""
    p, f = fem.Constant(mesh, 1e4), fem.Function(compat.lagrange_space(mesh, 1, (2,)))
    f.x.array[1::2] = -1e4
    return {
        "normal": (-p * ufl.FacetNormal(mesh), p),
        "vector": (ufl.as_vector((0.0, -p)), p),
        "function": (f, f),
        "of x": (lambda x: (0 * x[0], -p + 0 * x[0]), p),
    }


@pytest.mark.parametrize("kind", ["normal", "vector", "function", "of x"])
def test_loads_follow_what_they_are_given_by(kind):
    """Constants and Functions in them were read once, when the solid was made."""
    named = rectangle((2, 2), (1.0, 1.0))
    load, given = loads(named.mesh)[kind]
    data = {"youngs_modulus": 1e6, "poisson_ratio": 0.0, "density": 1.0}
    solid = ElasticSolid(named, fixed=["base"], tractions={"top": load}, **data)
    scene = Scene([solid], [], QuasiStatic())
    for times in (1, 2):
        assert scene.run(float(times), 1.0).finished
        down = solid.fields()["displacement"][:, 1].min()
        assert down == pytest.approx(-0.01 * times, rel=1e-9)
        if hasattr(given, "value"):
            given.value *= 2
        else:
            given.x.array[:] *= 2


@pytest.mark.parametrize("load", [lambda x: (0 * x[0], 0 * x[0]), ufl.zero(2)])
def test_a_load_that_is_zero_in_ufl(load):
    given = {"youngs_modulus": 1e6, "poisson_ratio": 0.0, "density": 1.0, "fixed": ["base"]}
    solid = ElasticSolid(rectangle(), tractions={"top": load}, body_force=load, **given)
    assert Scene([solid], [], QuasiStatic()).run(1.0, 1.0).finished
    assert not solid.fields()["displacement"].any()


def test_a_load_whose_time_has_a_default_follows_it():
    named = rectangle((2, 2), (1.0, 1.0))
    data = {"youngs_modulus": 1e6, "poisson_ratio": 0.0, "density": 1.0}
    load = {"top": lambda x, t=1.0: (0 * x[0], -1e4 * t + 0 * x[0])}
    solid = ElasticSolid(named, fixed=["base"], tractions=load, **data)
    assert Scene([solid], [], QuasiStatic()).run(2.0, 1.0).finished
    assert solid.fields()["displacement"][:, 1].min() == pytest.approx(-0.02, rel=1e-9)


# -- on a contact surface --


def uneven(mesh, degree=0):
    """Of one number in each cell, or of values that jump between cells."""
    made = fem.Function(compat.cellwise_space(mesh, degree=degree))
    made.x.array[:] = 0.2 + 0.1 * np.sin(7.0 * np.arange(len(made.x.array)))
    return made


@pytest.mark.parametrize("jumps", [0, 1], ids=["constant", "linear"])
@pytest.mark.parametrize("cell", ["quadrilateral", "triangle", "hexahedron", "tetrahedron"])
def test_of_what_jumps_between_facets_a_surface_has_all(cell, jumps):
    """A node read the first cell that it met, on whichever side: cells' numbers decided. The mean
    over its facets keeps the integral over the surface."""
    plane = cell in ("quadrilateral", "triangle")
    named = (rectangle if plane else box)((5, 2) if plane else (4, 3, 2), cell=cell)
    x = named.mesh.geometry.x
    x[:, 0] += 0.8 * x[:, 0] ** 2  # facets of several sizes
    field = uneven(named.mesh, jumps)
    solid = RigidSolid(named, mass=1.0)
    surface = Contact(solid, "base", FLOOR if plane else FLOOR_3D, friction=field).surface
    tag = named.names["base"]
    ds = ufl.Measure("ds", named.mesh, subdomain_data=named.facet_tags)(tag)
    whole = fem.assemble_scalar(fem.form(field * ds))
    assert surface.area @ NodalValues(field, surface)() == pytest.approx(whole, rel=1e-12)


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("cells", [2, 8])
@pytest.mark.parametrize("cell", ["quadrilateral", "triangle"])
def test_half_of_a_block_rubs(cell, cells, mirrored):
    """0.4 on one half, none on the other: 0.2 in all, from the left and from the right. A node in
    the middle had 0.1025 of two facets, or 0.3015."""
    named = rectangle((cells, 1), (1.0, 1e-3), cell)
    friction = fem.Function(compat.cellwise_space(named.mesh))
    side = -1.0 if mirrored else 1.0
    friction.interpolate(lambda x: np.where(side * x[0] > 0, 0.4, 0.0))
    top = {"top": lambda t: (0.1 * t * side, -2e-6)}
    material = {"youngs_modulus": 1e6, "poisson_ratio": 0.0, "density": 1.0}
    slab = ElasticSolid(named, **material, prescribed=top)
    contact = Contact(slab, "base", FLOOR, "gap", friction=friction)
    assert Scene([slab], [contact], QuasiStatic()).run(1.0, 0.5).finished
    drag, pressed = contact.force.sum(axis=0)
    assert -side * drag / pressed == pytest.approx(0.2, rel=1e-3)


PARALLEL = """
import sys; sys.path.insert(0, {here!r})
from mpi4py import MPI
from processes import mpirun, needs_mpirun, output_of
from scenes import FLOOR, FLOOR_3D, box, rectangle
from dolfinx import fem
import numpy as np
from fenicsx_contact import Contact, ElasticSolid, HalfSpace
from fenicsx_contact.base import compat
from fenicsx_contact.contact.nodal_values import NodalValues

named = rectangle((6, 2), (1.0, 0.4), "triangle")
friction = fem.Function(compat.cellwise_space(named.mesh))
friction.interpolate(lambda x: np.where(x[0] > 0, 0.4, 0.0))
block = ElasticSolid(named, youngs_modulus=1e6, poisson_ratio=0.3, density=1e3)
surface = Contact(block, "base", HalfSpace((0, 0), (0, 1)), friction=friction).surface
values = NodalValues(friction, surface)()[np.argsort(surface.points[:, 0])]
np.testing.assert_allclose(values, [0, 0, 0, 0.2, 0.4, 0.4, 0.4])
"""


@needs_mpirun
def test_nor_do_processes_decide():
    output_of(mpirun(PARALLEL.format(here=str(Path(__file__).parent)), 2))


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
@pytest.mark.parametrize("timed", [False, True])
def test_what_jumps_along_lines_of_the_mesh_is_as_told(cell, timed):
    """Two layers, half loads: arrays are asked within each cell, not where two share a node."""
    data = {"poisson_ratio": 0.0, "density": lambda x: np.where(x[1] < 0.2, 1000.0, 10.0)}

    def load(x):
        return 0 * x[0], np.where(x[0] < 0.0, -1e6, 0.0)

    def load_then(x, t):
        return load(x)

    solid = ElasticSolid(
        rectangle((4, 2), (1.0, 0.4), cell=cell),
        youngs_modulus=1e9,
        tractions={"top": load_then if timed else load},
        **data,
    )
    contact = Contact(solid, "base", FLOOR, "gap", friction=1.0)
    Scene([solid], [contact], QuasiStatic()).run(1.0, 1.0)
    np.testing.assert_allclose(contact.force.sum(axis=0)[1], 5e5, rtol=1e-9)
    assert solid.mass == pytest.approx(202.0, rel=1e-12)

    layered = ElasticSolid(
        rectangle((4, 2), (1.0, 0.4), cell=cell),
        youngs_modulus=lambda x: np.where(x[1] < 0.2, 1e9, 1e6),
        prescribed={"base": (0.0, 0.0)},
        tractions={"top": (0.0, -1e3)},
        **data,
    )
    contact = Contact(layered, "left", HalfSpace((-9, 0), (1, 0)))
    Scene([layered], [contact], QuasiStatic()).run(1.0, 1.0)
    exact = -1e3 * 0.2 * (1e-9 + 1e-6)
    assert layered.displacement.min() == pytest.approx(exact, rel=1e-9)
