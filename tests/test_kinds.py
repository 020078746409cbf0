# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers as they come in FEniCSx: wherever a number is taken, a Constant, a Function, an
expression in UFL, a function, and the scalars of numpy and of the standard library give the same
as the number, or are refused by the name of the argument."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
import ufl
from dolfinx import fem
from scenes import FLOOR, rectangle

import fenicsx_contact as fc
from fenicsx_contact.base import compat

MESH = rectangle((2, 2), (0.4, 0.4))
X = ufl.SpatialCoordinate(MESH.mesh)
NUMBERS = {
    "float64": np.float64,
    "float32": np.float32,
    "0-d array": np.array,
    "Fraction": Fraction,
    "Decimal": Decimal,
    "Constant": lambda c: fem.Constant(MESH.mesh, c),
}


def function(c):
    """The number as a Function."""
    made = fem.Function(compat.lagrange_space(MESH.mesh))
    made.x.array[:] = c
    return made


FIELDS = {
    "Function": function,
    "expression": lambda c: c * (1 + X[0] ** 2) / (1 + X[0] ** 2),
    "expression of a Constant": lambda c: fem.Constant(MESH.mesh, c) * (X[0] + 9) / (X[0] + 9),
    "function in UFL": lambda c: lambda x: c + 0 * x[0],
}


def vector(c):
    """Two numbers, the second as large against the first as in all vectors here."""
    return (c, -2 * c)


def vector_function(c):
    """Two numbers as a Function."""
    made = fem.Function(compat.lagrange_space(MESH.mesh, 1, (2,)))
    made.x.array.reshape(-1, 2)[:] = vector(c)
    return made


#: Of vectors.
VECTORS = {
    "list": lambda c: list(vector(c)),
    "array": lambda c: np.array(vector(c)),
    "float32": lambda c: np.array(vector(c), dtype=np.float32),
    "of Constants": lambda c: [fem.Constant(MESH.mesh, x) for x in vector(c)],
    "Constant": lambda c: fem.Constant(MESH.mesh, vector(c)),
}
VECTOR_FIELDS = {
    "Function": vector_function,
    "expression": lambda c: ufl.as_vector([c + 0 * X[0], -2 * c]),
    "function of x": lambda c: lambda x: np.outer(vector(c), np.ones(x.shape[1])),
}


def ends(solid, contact=None, scheme=None, until=3e-3, dt=1e-3, **scene):
    """Where a short run leaves a solid, and what bears it then: in sum, as a rigid solid is borne
    by its points in many ways."""
    contacts = [contact] if contact else []
    made = fc.Scene([solid], contacts, scheme, allow_free=True, **scene)
    history = made.run(until, dt)
    assert history.finished, history.reason
    fields = solid.fields()
    forces = [contact.force.sum(axis=0)] if contact else []
    return np.concatenate([fields["displacement"].ravel(), fields["velocity"].ravel(), *forces])


def elastic(**others):
    given = {"youngs_modulus": 1e6, "poisson_ratio": 0.25, "density": 1000.0, "gravity": (0, -10)}
    return fc.ElasticSolid(MESH, **{**given, **others})


def hyperelastic(**others):
    return fc.HyperelasticSolid(MESH, density=1000.0, gravity=(0, -10), **others)


def rigid(**others):
    given = {"gravity": (0, -10), "velocity": (0.5, 0)}
    given |= {} if "density" in others else {"mass": 8.0}
    return fc.RigidSolid(MESH, **{**given, **others})


def block(solid=None, scheme=None, **contact):
    """A block that slides on a floor, by a law that is asked."""
    solid = rigid() if solid is None else solid
    return ends(solid, fc.Contact(solid, "base", FLOOR, **contact), scheme)


def held(**others):
    """A plate that hangs at its top."""
    return ends(elastic(**{"fixed": ["top"], **others}))


def law(kind, name, where="friction", **others):
    """A parameter of a law of the interface."""
    return lambda c: block(**{where: kind(**{name: c, **others})})


#: Numbers: what takes them, as functions of the value, and a value that is exact in all kinds.
SCALARS = {
    "youngs_modulus": (lambda c: held(youngs_modulus=c), 2.0**20),
    "poisson_ratio": (lambda c: held(poisson_ratio=c), 0.25),
    "density": (lambda c: held(density=c), 1024.0),
    "energy: youngs_modulus": (
        lambda c: ends(hyperelastic(energy=fc.neo_hookean(c, 0.25), fixed=["top"])),
        2.0**20,
    ),
    "springs": (lambda c: ends(elastic(springs={"top": c})), 1024.0),
    "springs of a point": (lambda c: ends(rigid(springs={(0.0, 0.0): c})), 1024.0),
    "prescribed": (lambda c: held(fixed=(), prescribed={"top": (None, c)}), 0.0009765625),
    "eta": (lambda c: held(damping=fc.KelvinVoigt(c)), 0.0078125),
    "alpha": (lambda c: held(damping=fc.Rayleigh(c, 0.0)), 0.5),
    "beta": (lambda c: held(damping=fc.Rayleigh(0.0, c)), 0.0078125),
    "mass": (lambda c: block(rigid(mass=c)), 8.0),
    "density of a rigid solid": (lambda c: block(rigid(density=c)), 8.0),
    "rotation": (lambda c: ends(rigid(rotation=c)), 0.125),
    "spin": (lambda c: ends(rigid(spin=c)), 0.5),
    "torque": (lambda c: ends(rigid(torque=c)), 0.5),
    "friction": (lambda c: block(friction=c), 0.25),
    "normal_augmentation": (lambda c: block(normal_augmentation=c), 2.0),
    "gap_tolerance": (lambda c: block(gap_tolerance=c), 2.0**-30),
    "stress": (law(fc.Tresca, "stress"), 4.0),
    "static": (law(fc.StaticKinetic, "static", kinetic=0.125), 0.5),
    "kinetic": (law(fc.StaticKinetic, "kinetic", static=0.5), 0.25),
    "speed": (law(fc.Stribeck, "speed", static=0.5, kinetic=0.25), 0.125),
    "exponent": (law(fc.Stribeck, "exponent", static=0.5, kinetic=0.25, speed=0.1), 2.0),
    "viscosity": (law(fc.Stribeck, "viscosity", static=0.5, kinetic=0.25, speed=0.1), 0.5),
    "distance": (law(fc.RateState, "distance", a=0.01, b=0.015, mu=0.5, speed=0.1), 0.0078125),
    "theta": (
        law(fc.RateState, "theta", a=0.01, b=0.015, mu=0.5, speed=0.1, distance=0.01),
        0.125,
    ),
    "a": (law(fc.RateState, "a", b=0.015, mu=0.5, speed=0.1, distance=0.01), 0.0078125),
    "hardness": (law(fc.Archard, "hardness", friction=0.25, coefficient=1e-3), 1024.0),
    "drift_correction": (law(fc.Velocity, "drift_correction", "formulation"), 0.25),
    "coefficient of Restitution": (law(fc.Restitution, "coefficient", "formulation"), 0.5),
    "stress of Adhesive": (law(fc.Adhesive, "stress", "formulation"), 4.0),
    "coefficient of Compliance": (law(fc.Compliance, "coefficient", "formulation"), 4096.0),
    "exponent of Compliance": (
        law(fc.Compliance, "exponent", "formulation", coefficient=4096.0),
        2.0,
    ),
    "stiffness": (law(fc.Discrete, "stiffness", "formulation"), 4096.0),
    "damping": (law(fc.Discrete, "damping", "formulation", stiffness=4096.0), 4.0),
    "theta of the scheme": (lambda c: block(scheme=fc.ThetaScheme(c)), 0.75),
    "rho_inf": (lambda c: block(scheme=fc.GeneralisedAlpha(c)), 0.5),
    "tolerance": (lambda c: ends(rigid(), newton=fc.Newton(tolerance=c)), 2.0**-30),
    "deepest": (lambda c: ends(rigid(), deepest=c), 0.125),
    "dt": (lambda c: ends(rigid(), dt=c, until=0.001953125), 0.0009765625),
    "radius": (
        lambda c: fc.Circle((0, -1), c).distance(np.array([[1.0, 2.0]])),
        0.5,
    ),
    "rounding": (
        lambda c: fc.Box((0, 0), (1, 1), rounding=c).distance(np.array([[1.0, 2.0]])),
        0.125,
    ),
    "angle": (
        lambda c: fc.Wedge((0, 0), (0, 1), c).distance(np.array([[1.0, 2.0]])),
        1.0,
    ),
}
#: Vectors likewise, by their first component.
DIRECTED = {
    "gravity": (lambda g: held(gravity=g), 8.0),
    "gravity of a rigid solid": (lambda g: ends(rigid(gravity=g)), 8.0),
    "tractions": (lambda p: held(tractions={"base": p}), 16.0),
    "body_force": (lambda f: held(body_force=f), 16.0),
    "velocity of a rigid solid": (lambda v: ends(rigid(velocity=v)), 0.5),
    "about": (lambda p: ends(rigid(rotation=0.125, about=p)), 0.5),
    "force": (lambda f: ends(rigid(force=f)), 0.5),
    "prescribed": (lambda u: held(fixed=(), prescribed={"top": u}), 0.0009765625),
    "normal": (lambda n: fc.HalfSpace((0, 0), n).distance(np.array([[1.0, 2.0]])), 0.5),
    "center": (lambda p: fc.Circle(p, 1.0).distance(np.array([[1.0, 2.0]])), 0.5),
}
#: Numbers that only numbers can be: what they are of knows no mesh, or has one for all its points.
PARAMETERS = {
    "youngs_modulus", "poisson_ratio", "density", "energy: youngs_modulus", "friction", "stress",
    "static", "kinetic", "speed", "viscosity", "distance", "theta", "a", "hardness",
    "stress of Adhesive", "coefficient of Compliance",
}  # fmt: skip
LOADS = {"tractions", "body_force"}


@pytest.mark.parametrize("kind", NUMBERS)
@pytest.mark.parametrize("name", SCALARS)
def test_every_kind_of_number_gives_what_the_number_gives(name, kind):
    give, number = SCALARS[name]
    np.testing.assert_allclose(give(NUMBERS[kind](number)), give(number), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("kind", FIELDS)
@pytest.mark.parametrize("name", SCALARS)
def test_a_field_gives_what_the_number_gives_or_is_refused_by_name(name, kind):
    give, number = SCALARS[name]
    if name in PARAMETERS and (name, kind) != ("energy: youngs_modulus", "function in UFL"):
        got, expected = give(FIELDS[kind](number)), give(number)
        np.testing.assert_allclose(got, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
        return
    with pytest.raises(fc.InputError, match=name.split(" ")[0].removeprefix("energy:")):
        give(FIELDS[kind](number))


@pytest.mark.parametrize("kind", VECTORS)
@pytest.mark.parametrize("name", DIRECTED)
def test_every_kind_of_vector_gives_what_the_numbers_give(name, kind):
    give, number = DIRECTED[name]
    got, expected = give(VECTORS[kind](number)), give(vector(number))
    np.testing.assert_allclose(got, expected, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("kind", VECTOR_FIELDS)
@pytest.mark.parametrize("name", DIRECTED)
def test_a_vector_field_gives_what_the_vector_gives_or_is_refused_by_name(name, kind):
    give, number = DIRECTED[name]
    motion = name == "prescribed" and kind != "function of x"  # which it would take for time
    if name in LOADS or motion:
        got, expected = give(VECTOR_FIELDS[kind](number)), give(vector(number))
        np.testing.assert_allclose(got, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
        return
    with pytest.raises(fc.InputError, match=name.split(" ")[0]):
        give(VECTOR_FIELDS[kind](number))


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("name", ["displacement", "velocity"])
def test_initial_fields_are_functions_of_x_or_ufl(name, degree):
    def start(field):
        return getattr(elastic(degree=degree, **{name: field}), name)

    linear = vector_function(0.0)
    linear.interpolate(lambda x: np.stack([0.1 * x[0], -0.2 * x[1]]))
    expected = start(lambda x: np.stack([0.1 * x[0], -0.2 * x[1]]))
    for field in (linear, ufl.as_vector([0.1 * X[0], -0.2 * X[1]]), 0.5 * (linear + linear)):
        np.testing.assert_allclose(start(field), expected, rtol=0, atol=1e-15)
    uniform = start(lambda x: np.outer((0.5, -1.0), np.ones(x.shape[1])))
    np.testing.assert_array_equal(start(fem.Constant(MESH.mesh, (0.5, -1.0))), uniform)
    for field in (X[0], fem.Constant(MESH.mesh, 1.0), function(1.0), 1 / (X - X)[0] * X):
        with pytest.raises(fc.InputError, match=name):
            start(field)


def test_motions_of_obstacles():
    moved = fc.Moved(FLOOR, lambda t: fem.Constant(MESH.mesh, (t, 2 * t)))
    np.testing.assert_allclose(moved.displacement(0.5), (0.5, 1.0))
