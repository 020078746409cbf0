# SPDX-License-Identifier: LGPL-3.0-or-later
"""What is prescribed on the boundary of a solid, and constants of UFL as numbers."""

from __future__ import annotations

import sys

import dolfinx
import numpy as np
import pytest
import ufl
from dolfinx import fem
from scenes import FLOOR, rectangle

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    EnergyMomentum,
    HyperelasticSolid,
    InputError,
    NamedMesh,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    name_facets,
    st_venant_kirchhoff,
)
from fenicsx_contact.base import compat

ELASTIC = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}


def solid(**others):
    return ElasticSolid(rectangle((2, 3)), **{**ELASTIC, **others})


# -- supports --


@pytest.mark.parametrize(
    "supports",
    [
        {"fixed": ["left"], "prescribed": {"top": [0.0, -0.01]}},
        {"prescribed": {"left": [0.0, 0.0], "top": [0.01, None]}},
        {"fixed": "left", "prescribed": {"top": lambda t: [0.0, -0.01 * t]}},
    ],
)
def test_contradictory_supports_are_refused(supports):
    """The corner that the two share cannot follow both."""
    with pytest.raises(InputError, match=r"'top' contradicts.*'left'"):
        solid(**supports)


def test_supports_that_contradict_each_other_later_end_the_run_then():
    def late(t):
        return [0.0, -0.01 if t > 0.5 else 0.0]

    scene = Scene([solid(fixed=["left"], prescribed={"top": late})], [], QuasiStatic())
    history = scene.run(1.0, 0.2)
    assert not history.finished and "'top' contradicts" in history.reason
    assert history.time[-1] == pytest.approx(0.5, rel=1e-3)


@pytest.mark.parametrize("free", [[None, -0.01], [1e-14, -0.01]])
def test_supports_that_agree_are_taken(free):
    """Where a direction is free, or round-off away from what another one says."""
    made = solid(prescribed={"left": [0.0, None], "top": free})
    assert Scene([made], [], QuasiStatic()).run(0.1, 0.1).finished


SIDES = "left", "right", "base", "top"


def stretched(mesh, kind):
    """A linear motion in each of the ways in which it can be written; its size at a time t is t."""
    x = ufl.SpatialCoordinate(mesh.mesh)
    shape = np.array([[0.01, 0.003], [-0.002, 0.005]])
    if kind == "function of x and t":
        return lambda x, t: [t * sum(shape[i, j] * x[j] for j in range(2)) for i in range(2)]
    if kind == "of numpy":
        return lambda x, t: t * np.tensordot(shape, np.asarray(x)[:2], 1)
    vector = ufl.as_vector([sum(shape[i, j] * x[j] for j in range(2)) for i in range(2)])
    if kind == "expression":
        return vector
    function = fem.Function(compat.lagrange_space(mesh.mesh, 1, (2,)))
    function.interpolate(lambda x: shape @ x[:2])
    return function


@pytest.mark.parametrize("kind", ["function of x and t", "of numpy", "expression", "Function"])
@pytest.mark.parametrize("degree", [1, 2])
def test_motions_that_differ_from_point_to_point(kind, degree):
    """A linear motion of the whole boundary is that of the inside, too."""
    mesh = rectangle((2, 3), cell="triangle")
    motion = stretched(mesh, kind)
    made = ElasticSolid(mesh, prescribed={side: motion for side in SIDES}, degree=degree, **ELASTIC)
    assert Scene([made], [], QuasiStatic()).run(1.0, 0.5).finished
    expected = made.vectors.places @ np.array([[0.01, 0.003], [-0.002, 0.005]]).T
    np.testing.assert_allclose(made.displacement.reshape(-1, 2), expected, rtol=0, atol=1e-12)


def test_a_motion_in_a_function_is_read_anew():
    mesh = rectangle((2, 3))
    size = fem.Constant(mesh.mesh, 0.0)
    made = ElasticSolid(
        mesh, prescribed={s: size * stretched(mesh, "expression") for s in SIDES}, **ELASTIC
    )
    scene = Scene([made], [], QuasiStatic())
    scene.run(1.0, 1.0)
    assert not made.displacement.any()
    size.value = 1.0
    scene.run(2.0, 1.0)
    expected = made.vectors.places @ np.array([[0.01, 0.003], [-0.002, 0.005]]).T
    np.testing.assert_allclose(made.displacement.reshape(-1, 2), expected, rtol=0, atol=1e-12)


def test_motions_in_ufl_that_are_none():
    x = ufl.SpatialCoordinate(rectangle().mesh)
    mesh = rectangle((2, 3))
    here = ufl.SpatialCoordinate(mesh.mesh)
    for wrong in (
        here[0],
        x,
        ufl.as_vector([here[0]] * 3),
        ufl.grad(here),
        ufl.ln(-1 - here[1]) * here,
    ):
        with pytest.raises(InputError, match=r"prescribed\['top'\].* must give 2 components"):
            ElasticSolid(mesh, prescribed={"top": wrong}, **ELASTIC)
    with pytest.raises(InputError, match="'top' contradicts"):
        ElasticSolid(mesh, prescribed={"top": here}, fixed=["left"], **ELASTIC)


def test_supports_start_with_the_speed_of_their_motion():
    """Whatever the unit of time: the solid knows it."""
    for unit in (1e-9, 1.0, 1e9):
        E = ELASTIC["youngs_modulus"] / unit**2
        made = solid(
            youngs_modulus=E,
            prescribed={"top": lambda t, unit=unit: [0.0, -1e-3 * np.sin(3 * t / unit)]},
        )
        speed = made.velocity[made.fixed_unknowns][1::2] * unit
        np.testing.assert_allclose(speed, -3e-3, rtol=1e-6)


@pytest.mark.parametrize("argument", ["fixed", "prescribed", "tractions", "mass_redistribution"])
@pytest.mark.parametrize("name", ["nowhere", "unknown"])
def test_names_that_match_nothing_are_refused_by_their_argument(argument, name):
    mesh = rectangle((2, 3))
    tags = {"top": lambda x: np.isclose(x[1], 0.8), "nowhere": lambda x: x[1] > 99}
    given = [name] if argument in ("fixed", "mass_redistribution") else {name: [0.0, 1.0]}
    with pytest.raises(InputError, match=rf"{argument}: .*'{name}'"):
        ElasticSolid(name_facets(mesh.mesh, tags), **ELASTIC, **{argument: given})


def test_traction_inside_the_mesh_is_refused():
    """It would be no load at all."""
    mesh = rectangle((2, 2)).mesh
    inside = dolfinx.mesh.locate_entities(mesh, 1, lambda x: np.isclose(x[0], 0.0))
    tags = dolfinx.mesh.meshtags(mesh, 1, inside, np.ones(len(inside), dtype=np.int32))
    with pytest.raises(InputError, match=r"tractions\['inside'\].*boundary"):
        ElasticSolid(
            NamedMesh(mesh, tags, {"inside": 1}), **ELASTIC, tractions={"inside": [0.0, 1.0]}
        )


# -- constants --


def test_constants_of_ufl_are_numbers():
    mesh = rectangle((2, 3))
    constants = {name: fem.Constant(mesh.mesh, value) for name, value in ELASTIC.items()}
    gravity = fem.Constant(mesh.mesh, np.array([0.0, -9.81]))
    made = ElasticSolid(mesh, **constants, gravity=gravity)
    assert made.describe() == solid(gravity=[0.0, -9.81]).describe()
    assert RigidSolid(mesh, density=constants["density"]).mass == pytest.approx(288.0)


@pytest.mark.parametrize("name", ELASTIC)
def test_other_expressions_are_refused(name):
    """At once: float() of them recurses until the stack is full."""
    mesh = rectangle((2, 3))
    x, limit = ufl.SpatialCoordinate(mesh.mesh), sys.getrecursionlimit()
    sys.setrecursionlimit(300)
    try:
        for value in (1e6 * x[0], x, fem.Constant(mesh.mesh, np.array([1.0, 2.0]))):
            with pytest.raises(InputError, match=name):
                ElasticSolid(mesh, **{**ELASTIC, name: value})
    finally:
        sys.setrecursionlimit(limit)


# -- the house --


# -- what is held and touches, what moves --


@pytest.mark.parametrize(
    "solver, scheme",
    [
        ("monolithic", QuasiStatic()),
        ("condensed", ThetaScheme(0.5)),
        ("monolithic", ThetaScheme(0.5)),
        ("condensed", ThetaScheme(1.0)),
        ("monolithic", ThetaScheme(1.0)),
    ],
)
def test_supports_bear_what_acts_on_their_nodes(scheme, solver):
    """A block is drawn over a floor by its sides, the corners of which rub: forces on what is held
    were missing from reactions, from the drive and from the books."""
    drawn = {side: lambda t: (0.1 * t, None) for side in ("left", "right")}
    block = ElasticSolid(
        rectangle((2, 2), (1.0, 1.0)),
        youngs_modulus=1e7,
        poisson_ratio=0.0,
        density=10.0,
        tractions={"top": (0, -1e3)},
        prescribed=drawn,
    )
    contact = Contact(block, "base", FLOOR, "gap", friction=0.2, name="c")
    scene = Scene([block], [contact], scheme, solver=solver)
    history = scene.run(1.0, 0.1 if not scheme.inertia else 0.02)
    assert history.finished
    assert np.abs(history["balance"]).max() < 1e-8 * history["drive"][-1]
    assert history["drive"][-1] == pytest.approx(-history["friction"][-1], rel=0.02)
    if not scheme.inertia or scheme.theta == 1:
        reaction = (block.reaction("left") + block.reaction("right"))[0]
        assert reaction == pytest.approx(-history["c.force_x"][-1], rel=1e-6)
        assert reaction == pytest.approx(200, rel=1e-3)


def test_what_is_pressed_by_its_own_contact_surface():
    """A die whose surface in contact is what is moved bears what it presses with."""
    below = rectangle((4, 2), (0.4, 0.2))
    below.mesh.geometry.x[:, 1] -= 0.2
    die, slab = (
        ElasticSolid(mesh, **ELASTIC, prescribed=held, name=name)
        for mesh, held, name in (
            (rectangle((2, 2), (0.2, 0.2)), {"base": lambda t: (0, -0.01 * t)}, "die"),
            (below, {"base": (0, 0)}, "slab"),
        )
    )
    contact = Contact(die, "base", (slab, "top"), "gap", name="c")
    history = Scene([die, slab], [contact], QuasiStatic()).run(1.0, 0.25)
    assert history.finished
    assert slab.reaction("base")[1] > 1e3
    np.testing.assert_allclose(die.reaction("base"), -slab.reaction("base"), rtol=1e-6, atol=1e-3)
    assert abs(history["balance"][-1]) < 1e-6 * history["strain"][-1]
    assert history["drive"][-1] > history["strain"][-1]


def test_a_node_of_the_contact_may_be_held():
    """The usual way to hold what else only contact holds: refused, for a point that wedges."""
    for held in ({"fixed": [(0.0, 0.0)]}, {"prescribed": {(0.0, 0.0): (0, None)}}):
        block = solid(tractions={"top": (0, -1e3)}, **held)
        scene = Scene([block], [Contact(block, "base", FLOOR, "gap", name="c")], QuasiStatic())
        history = scene.run(1.0, 0.5)
        assert history.finished and not history.remarks
        width = np.ptp(block.mesh.mesh.geometry.x[:, 0])
        up = history["c.force_y"][-1] + block.reaction((0.0, 0.0))[1]
        assert up == pytest.approx(1e3 * width, rel=1e-6)


@pytest.mark.parametrize("scheme", [ThetaScheme(0.5), EnergyMomentum()])
def test_supports_that_move_are_of_the_order_of_the_scheme(scheme):
    """A bar is shaken at its end: what is held went at the mean velocity of a step, half a step
    behind the rest, which was of first order, and gave energy."""
    E, rho, size, omega, until = 1e4, 100.0, 0.01, 7.0, 0.5
    last, works = [], []
    for steps in (50, 100, 200):
        shaken = {"left": lambda t: (size * (1 - np.cos(omega * t)), 0), "base": (None, 0)}
        if scheme.describe() == ThetaScheme(0.5).describe():
            bar = ElasticSolid(
                rectangle((1, 1), (1.0, 0.1)),
                youngs_modulus=E,
                poisson_ratio=0.0,
                density=rho,
                prescribed={**shaken, "top": (None, 0)},
            )
        else:
            bar = HyperelasticSolid(
                rectangle((1, 1), (1.0, 0.1)),
                energy=st_venant_kirchhoff(E, 0.0),
                density=rho,
                prescribed={**shaken, "top": (None, 0)},
            )
        history = Scene([bar], [], scheme).run(until, until / steps)
        assert history.finished
        last.append(bar.fields()["displacement"][:, 0].max())
        works.append(history["drive"][-1])
        assert abs(history["scheme"][-1]) < 1e-9 * abs(works[-1])
    for values in (last, works):
        one, two = np.abs(np.diff(values))
        assert two < one / 3


@pytest.mark.parametrize("stiffness", [1e2, 1.0])
def test_what_stands_on_weak_springs_is_pressed(stiffness):
    """Their compliance hid that of the points: a jump row stalled, by the solver of the default."""
    above = rectangle((3, 2), (0.3, 0.2))
    below = rectangle((5, 2), (0.6, 0.2))
    below.mesh.geometry.x[:, 1] -= 0.2
    upper = solid_of(above, "upper", springs={"top": stiffness}, tractions={"top": (0, -500.0)})
    lower = solid_of(below, "lower", fixed=["base"])
    contact = Contact(upper, "base", (lower, "top"), "gap", name="c")
    history = Scene([upper, lower], [contact], QuasiStatic()).run(1.0, 0.5)
    assert history.finished and not history.remarks
    assert history["c.force_y"][-1] == pytest.approx(150.0, rel=1e-2)


def solid_of(mesh, name, **others):
    return ElasticSolid(mesh, **{**ELASTIC, "name": name, **others})


@pytest.mark.parametrize("kind", ["kink", "leap"])
def test_motions_that_are_not_smooth_close_the_books(kind):
    """What is moved goes its way, whatever its velocities are at both ends of a step."""
    motion = {"kink": lambda t: 0.1 * max(t - 0.1037, 0), "leap": lambda t: 1e-3 * (t > 0.1037)}
    bar = ElasticSolid(
        rectangle((4, 1), (1.0, 0.1)),
        youngs_modulus=1e4,
        poisson_ratio=0.0,
        density=100.0,
        prescribed={"left": lambda t: (motion[kind](t), 0), "base": (None, 0), "top": (None, 0)},
    )
    history = Scene([bar], []).run(0.5, 5e-3)
    assert history.finished and history["drive"][-1] > 1e-3
    assert np.abs(history["scheme"]).max() < 1e-9 * history["drive"][-1]
    assert np.abs(history["balance"]).max() < 1e-9 * history["drive"][-1]


@pytest.mark.parametrize("scheme", [QuasiStatic(), ThetaScheme(1.0)])
@pytest.mark.parametrize("given", [lambda k: k, lambda k: 1.0 * k, lambda k: (0.0, k)])
def test_a_support_by_a_constant_that_is_zero_at_first(given, scheme):
    """It moves once the Constant does: what was 0 when the solid was made stayed there."""
    mesh = rectangle((1, 2), (0.2, 0.4))
    constant = fem.Constant(mesh.mesh, 0.0 if isinstance(given(0.0), tuple) else np.zeros(2))
    solid = ElasticSolid(
        mesh,
        youngs_modulus=1e6,
        poisson_ratio=0.0,
        density=1e-3,
        prescribed={"top": given(constant)},
    )
    contact = Contact(solid, "base", FLOOR, "gap", name="c")
    scene = Scene([solid], [contact], scheme)
    assert scene.run(1.0, 1.0).finished
    constant.value[...] = -1e-3 if constant.value.ndim == 0 else (0.0, -1e-3)
    history = scene.run(2.0, 1.0)
    assert history.finished and history["c.force_y"][-1] == pytest.approx(500.0, rel=1e-6)
