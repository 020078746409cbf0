# SPDX-License-Identifier: LGPL-3.0-or-later
"""Every public constructor with right values of all its arguments, and values that are seldom
right: what the fuzz tests draw from."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from hypothesis import strategies as st
from scenes import FLOOR, box, rectangle

import fenicsx_contact as fc
from fenicsx_contact.base import compat
from fenicsx_contact.rods.contact import GuideContact
from fenicsx_contact.rods.guide import Guide
from fenicsx_contact.rods.lines import Bow, Sine, Straight
from fenicsx_contact.rods.pieces import Card, Tube
from fenicsx_contact.rods.tube import RodInTube

MESHES = Path(__file__).parents[1] / "meshes"
PLANE, SPACE = rectangle(), box()

# -- right values --


def sized(low: int, high: int) -> st.SearchStrategy[float]:
    """Numbers > 0 of all sizes between two powers of ten."""
    return st.floats(low, high).map(lambda e: 10.0**e)


def numbers(d: int, size: float = 1.0) -> st.SearchStrategy[tuple[float, ...]]:
    """Vectors."""
    return st.tuples(*[st.floats(-size, size)] * d)


def directions(d: int) -> st.SearchStrategy[tuple[float, ...]]:
    """Vectors that are not zero."""
    return numbers(d).filter(lambda v: max(map(abs, v)) > 1e-3)


#: Numbers >= 0, in the kinds in which they come.
POSITIVE = sized(-3, 3).flatmap(
    lambda x: st.sampled_from([x, np.float64(x), np.array(x), Fraction(x), np.float32(x)])
)
SHARE = st.floats(0.0, 1.0)
TRUTH = st.booleans()
NAME = st.sampled_from(["a", "a b", "&<>'", "ä"])
NONE = st.none()


def fixed(*values: Any) -> st.SearchStrategy[Any]:
    """One of these."""
    return st.sampled_from(values)


# -- wrong ones, of most arguments --


class Raises:
    """Looks like a number and is none."""

    def __float__(self) -> float:
        raise RuntimeError("no")

    def __repr__(self) -> str:
        return "Raises()"


NAN, INF = float("nan"), float("inf")
#: Values by what they are called in a report; few of them are right for any argument.
JUNK: dict[str, Any] = {
    "nan": NAN,
    "inf": INF,
    "-inf": -INF,
    "0": 0,
    "-1": -1,
    "-0.5": -0.5,
    "2.5": 2.5,
    "1e300": 1e300,
    "-1e300": -1e300,
    "1e-300": 1e-300,
    "1e59": 1e59,
    "10**400": 10**400,
    "5e-324": 5e-324,
    "True": True,
    "None": None,
    "text": "text",
    "empty text": "",
    "number as text": "0.3",
    "bytes": b"0.3",
    "1j": 1j,
    "Decimal(NaN)": Decimal("NaN"),
    "[]": [],
    "()": (),
    "{}": {},
    "set": {1.0},
    "dict": {"a": 1.0},
    "dict of text": {"base": "much"},
    "dict by number": {3: 4},
    "dict by place": {(0.0, 0.0): -1.0},
    "1 nan": [NAN],
    "2": (1.0, 2.0),
    "2 with nan": (1.0, NAN),
    "2 huge": (1e300, 0.0),
    "2 zeros": (0.0, 0.0),
    "3": (1.0, 2.0, 3.0),
    "3 with inf": (1.0, 2.0, INF),
    "3 zeros": (0.0, 0.0, 0.0),
    "4": [1.0, 2.0, 3.0, 4.0],
    "2 texts": ("base", "top"),
    "3 Nones": (None, None, None),
    "ragged": [[1.0], [1.0, 2.0]],
    "2 x 2": np.eye(2),
    "rows of nan": np.full((3, 2), NAN),
    "rows of huge": np.array([[0.0, 0.0], [1e300, 1.0]]),
    "no rows": np.zeros((0, 2)),
    "empty array": np.zeros(0),
    "0-d object": np.array(None),
    "0-d text": np.array("a"),
    "array of objects": np.array([object(), 1.0], dtype=object),
    "masked": np.ma.masked_array([1.0, 2.0], [True, False]),
    "time": np.datetime64("2020-01-01"),
    "nested": [[[[]]]],
    "range": range(3),
    "generator": "a generator",  # made anew by junk()
    "object": object(),
    "a number that raises": Raises(),
    "class": float,
    "own class": fc.Velocity,
    "module": np,
    "function": lambda: 1.0,
    "function of nan": lambda *a: NAN,
    "function of text": lambda *a: "much",
    "function of None": lambda *a: None,
    "function of -1": lambda *a: -1.0,
    "function of two": lambda a, b: (a, b),
    "function of many": lambda a, b, c, d: 1.0,
    "function of itself": lambda x: x,
    "built-in": len,
    "path": Path("nowhere/at/all"),
    "solid": fc.RigidSolid(PLANE, mass=1.0, name="other"),
    "obstacle": FLOOR,
    "scheme": fc.ThetaScheme(),
    "mesh": PLANE,
    "dolfinx mesh": PLANE.mesh,
    "Constant nan": fem.Constant(PLANE.mesh, NAN),
    "Constant of two": fem.Constant(PLANE.mesh, (1.0, NAN)),
    "Constant -1": fem.Constant(PLANE.mesh, -1.0),
    "Function": fem.Function(compat.lagrange_space(PLANE.mesh)),
    "Function of two": fem.Function(compat.lagrange_space(PLANE.mesh, 1, (2,))),
    "expression": ufl.SpatialCoordinate(PLANE.mesh)[0] - 1.0,
    "vector expression": ufl.SpatialCoordinate(PLANE.mesh),
    "expression of another mesh": ufl.SpatialCoordinate(SPACE.mesh)[0],
    "test function": ufl.TestFunction(compat.lagrange_space(PLANE.mesh)),
}


def junk(which: str) -> Any:
    """A wrong value; a generator is used up by the first who looks."""
    return (x for x in (1.0, 2.0)) if which == "generator" else JUNK[which]


# -- constructors --


@dataclass(frozen=True)
class Subject:
    """A constructor and right values of its arguments.

    Attributes:
        make: called by keywords.
        arguments: right values, by name.
        others: names by which a refusal of an argument may call it, by argument.
    """

    make: Callable[..., Any]
    arguments: Mapping[str, st.SearchStrategy[Any]]
    others: Mapping[str, tuple[str, ...]]


SUBJECTS: dict[str, Subject] = {}


def subject(
    name: str,
    make: Callable[..., Any],
    others: Mapping[str, tuple[str, ...]] | None = None,
    /,
    **arguments: st.SearchStrategy[Any],
) -> None:
    """One more."""
    SUBJECTS[name] = Subject(make, arguments, others or {})


def beam(**others: Any) -> fc.BeamSolid:
    """A short rod that falls along y, or hangs."""
    axis = fc.axis_mesh((0, 0), (0, 1), rod=(1.0, 2))
    given = {"axis": axis, "sections": fc.Section(1.0, 10.0), "gravity": (0, -9.81)}
    return fc.BeamSolid(**{**given, **others})


@cache
def scene() -> fc.Scene:
    """One that is not stepped."""
    solid = fc.RigidSolid(PLANE, mass=1.0)
    return fc.Scene([solid], [fc.Contact(solid, "base", FLOOR, name="c")])


def contact(**others: Any) -> fc.Contact:
    """A rigid block on a floor."""
    solid = fc.RigidSolid(PLANE, mass=1.0)
    return fc.Contact(**{"solid": solid, "facets": "base", "master": FLOOR, **others})


def law(kind: Callable[..., Any], where: str = "friction") -> Callable[..., Any]:
    """A law in a contact, which reads its parameters: both are asked."""
    return lambda **given: (made := kind(**given), contact(**{where: made}))[0]


def two(**given: Any) -> fc.Scene:
    """A scene, with solids and contacts of its own where others are not given."""
    solid = fc.RigidSolid(PLANE, mass=1.0)
    made = {"solids": [solid], "contacts": [fc.Contact(solid, "base", FLOOR)]}
    return fc.Scene(**{**made, "allow_free": True, **given})


def whole(**given: Any) -> fc.History:
    """A run of a step or two."""
    solid = fc.RigidSolid(PLANE, mass=1.0, gravity=(0, -9.81))
    made = fc.Scene([solid], [fc.Contact(solid, "base", FLOOR, name="c")])
    return made.run(**{"until": 2e-3, "dt": 1e-3, "progress": False, **given})


SOLID = {
    "gravity": NONE | numbers(2, 10),
    "name": NAME,
}
DEFORMABLE = {
    **SOLID,
    "density": POSITIVE,
    "degree": fixed(1, 2),
    "periodic": fixed((), [("left", "right")]),
    "fixed": fixed((), ["top"], "top", [("top", "left")], [(0.18, 0.80)]),
    "prescribed": fixed(None, {}, {"top": (None, 0.0)}, {"left": lambda t: (t, None)}),
    "springs": fixed(None, {}, {"base": 1e3}, {("top", "left"): (1.0, 0.0)}),
    "tractions": fixed(None, {}, {"top": (1.0, 2.0)}, {"right": lambda t: (t, 0.0)}),
    "body_force": NONE | numbers(2),
    "damping": fixed(None, fc.KelvinVoigt(1e-3), fc.Rayleigh(1.0, 1e-3)),
    "mass_redistribution": fixed((), ["base"]),
    "displacement": fixed(None, lambda x: 1e-3 * x[:2]),
    "velocity": fixed(None, lambda x: 0 * x[:2] + 1.0),
}
subject(
    "RigidSolid",
    lambda **k: fc.RigidSolid(**{"mesh": PLANE, "mass": 1.0, **k}),
    {"springs": ("springs",)},
    **SOLID,
    mesh=fixed(PLANE),
    mass=POSITIVE,
    rotation=st.floats(-7, 7),
    about=NONE | numbers(2),
    force=NONE | numbers(2) | fixed(lambda t: (t, 1.0)),
    torque=NONE | st.floats(-1, 1) | fixed(lambda t: t),
    springs=fixed(None, {}, {(0.0, 0.0): 1.0}, {(0.0, 0.1): (1.0, 2.0)}),
    held=fixed((), "x", ["y"], ["turning"]),
    velocity=NONE,
    spin=fixed(0.0),
)
subject(
    "RigidSolid in space",
    lambda **k: fc.RigidSolid(**{"mesh": SPACE, "density": 1.0, **k}),
    density=POSITIVE,
    gravity=NONE | numbers(3, 10),
    rotation=numbers(3, 7) | fixed(0.0),
    about=NONE | numbers(3),
    force=NONE | numbers(3) | fixed(lambda t: (t, 1.0, 0.0)),
    torque=NONE | numbers(3),
    springs=fixed(None, {(0.0, 0.0, 0.0): 1.0}),
    held=fixed((), "x", ["turning about x"]),
    velocity=NONE,
    spin=fixed(0.0, (0.0, 0.0, 0.0)),
)
subject(
    "ElasticSolid",
    lambda **k: fc.ElasticSolid(
        **{"mesh": PLANE, "youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1e3, **k}
    ),
    {"fixed": ("fixed", "facets"), "mass_redistribution": ("mass_redistribution", "facets")},
    **DEFORMABLE,
    mesh=fixed(PLANE),
    youngs_modulus=POSITIVE,
    poisson_ratio=st.floats(-0.9, 0.49),
    plane=fixed("strain", "stress"),
)
subject(
    "HyperelasticSolid",
    lambda **k: fc.HyperelasticSolid(**{"mesh": PLANE, "energy": ENERGY, "density": 1e3, **k}),
    {"fixed": ("fixed", "facets"), "mass_redistribution": ("mass_redistribution", "facets")},
    **DEFORMABLE,
    energy=fixed(fc.neo_hookean(1e6, 0.3)),
)
ENERGY = fc.neo_hookean(1e6, 0.3)
for energy in (fc.neo_hookean, fc.ciarlet, fc.st_venant_kirchhoff):
    subject(
        energy.__name__,
        lambda energy=energy, **k: fc.HyperelasticSolid(
            PLANE, energy=energy(**{"youngs_modulus": 1e6, "poisson_ratio": 0.3, **k}), density=1.0
        ),
        {
            "youngs_modulus": ("youngs_modulus", "energy"),
            "poisson_ratio": ("poisson_ratio", "energy"),
        },
        youngs_modulus=POSITIVE,
        poisson_ratio=st.floats(-0.9, 0.49),
    )
subject("KelvinVoigt", lambda **k: fc.KelvinVoigt(**{"eta": 1.0, **k}), eta=POSITIVE)
subject("Rayleigh", fc.Rayleigh, alpha=POSITIVE, beta=POSITIVE)

subject(
    "Contact",
    contact,
    {"master": ("master",), "friction": ("friction",)},
    solid=fixed(fc.RigidSolid(PLANE, mass=1.0)),
    facets=fixed("base", "left"),
    master=fixed(FLOOR, fc.Circle((0, -2), 1.0)),
    formulation=fixed("velocity", "gap", "lagrange", "printed", fc.Discrete(1e6), fc.GAP),
    friction=POSITIVE | fixed(fc.Tresca(1.0), lambda x: 0.1 + 0 * x[0]),
    normal_augmentation=POSITIVE,
    tangential_augmentation=POSITIVE,
    gap_tolerance=SHARE,
    name=NONE | NAME,
)
subject(
    "Heap",
    lambda **k: fc.Heap(
        **{"solids": [fc.RigidSolid(PLANE, mass=1.0, name=n) for n in "ab"], "facets": "base", **k}
    ),
    {"friction": ("friction",)},
    facets=fixed("base", "left"),
    formulation=fixed("velocity", "gap", "lagrange", "printed", fc.GAP),
    friction=POSITIVE,
    normal_augmentation=POSITIVE,
    tangential_augmentation=POSITIVE,
    gap_tolerance=SHARE,
    name=NAME,
)
for d, ball in ((2, fc.Circle), (3, fc.Sphere)):
    zero, up = (0.0,) * d, tuple(np.eye(d)[-1])
    subject(
        f"HalfSpace {d}",
        lambda zero=zero, up=up, **k: fc.HalfSpace(**{"point": zero, "normal": up, **k}),
        {"point": ("point", "normal")},
        point=numbers(d),
        normal=directions(d),
    )
    subject(
        ball.__name__,
        lambda ball=ball, zero=zero, **k: ball(**{"center": zero, "radius": 1.0, **k}),
        center=numbers(d),
        radius=POSITIVE,
        inside=TRUTH,
    )
    subject(
        f"Box {d}",
        lambda zero=zero, d=d, **k: fc.Box(**{"center": zero, "size": (1.0,) * d, **k}),
        {"center": ("center", "size")},
        center=numbers(d),
        size=st.tuples(*[sized(-1, 1)] * d),
        rotation=st.floats(-7, 7) if d == 2 else numbers(3, 7),
        rounding=fixed(0.0, 1e-3),
    )
subject(
    "Cylinder",
    lambda **k: fc.Cylinder(**{"center": (0, 0, 0), "axis": (0, 1, 0), "radius": 1.0, **k}),
    center=numbers(3),
    axis=directions(3),
    radius=POSITIVE,
    inside=TRUTH,
)
subject(
    "Wedge",
    lambda **k: fc.Wedge(**{"tip": (0, 0), "direction": (0, 1), "angle": 1.0, **k}),
    {"tip": ("tip", "edge", "direction")},
    tip=numbers(2),
    direction=directions(2),
    angle=st.floats(0.1, 3.0),
    rounding=fixed(0.0, 1e-3),
    edge=NONE,
)
subject(
    "Wedge in space",
    lambda **k: fc.Wedge(
        **{"tip": (0, 0, 0), "direction": (0, 0, 1), "angle": 1.0, "edge": (1, 0, 0), **k}
    ),
    {"edge": ("edge", "direction"), "direction": ("edge", "direction")},
    direction=fixed((0, 0, 1), (0.3, 1, 1)),
    edge=fixed((1, 0, 0), (1, 0.2, 0)),
    rounding=fixed(0.0, 0.1),
)
subject(
    "Polyhedron",
    lambda **k: fc.Polyhedron(
        **{"half_spaces": [fc.HalfSpace((0, 0), (0, 1)), fc.HalfSpace((0, 0), (1, 0))], **k}
    ),
    half_spaces=fixed([fc.HalfSpace((0, 0), (0, 1)), fc.HalfSpace((0, 0), (1, 1))]),
    rounding=POSITIVE,
)
subject(
    "Curve",
    lambda **k: fc.Curve(**{"points": [(0, 0), (1, 0.2), (2, 0)], **k}),
    points=st.lists(numbers(2), min_size=3, max_size=6, unique=True).map(
        lambda p: [(i, 0.3 * y) for i, (_, y) in enumerate(p)]
    ),
    smooth=TRUTH,
)
subject(
    "Revolution",
    lambda **k: fc.Revolution(
        **{"section": fc.Circle((0, 0.3), 0.1), "center": (0, 0, 0), "axis": (0, 0, 1), **k}
    ),
    section=fixed(fc.Circle((0, 0.3), 0.1), fc.Box((0, 0), (1, 2))),
    center=numbers(3),
    axis=directions(3),
)
subject(
    "Moved",
    lambda **k: fc.Moved(**{"obstacle": FLOOR, "motion": lambda t: (0, t), **k}),
    obstacle=fixed(FLOOR, fc.Circle((0, -2), 1.0)),
    motion=fixed(lambda t: (t, t**2), lambda t: np.zeros(2)),
)
subject(
    "Turned",
    lambda **k: fc.Turned(
        **{"obstacle": FLOOR, "about": (0, -1), "angle": lambda t: t, "axis": None, **k}
    ),
    obstacle=fixed(FLOOR, fc.Circle((0, -2), 1.0)),
    about=numbers(2),
    angle=fixed(lambda t: 2 * t, lambda t: np.float64(0.1)),
    axis=fixed(None),
)
subject(
    "Union",
    lambda **k: fc.Union(**{"obstacles": [FLOOR], **k}),
    obstacles=fixed([FLOOR, fc.Circle((0, -2), 1.0)], (fc.Circle((0, -2), 1.0),)),
)
subject(
    "LevelSet",
    lambda **k: fc.LevelSet(**{"phi": lambda x, t: x[1], "dim": 2, **k}),
    {"dim": ("dim", "phi")},
    phi=fixed(lambda x, t: x[1] + 0.1 * x[0] * t),
    dim=fixed(2, 3),
    velocity=fixed(None),
)
subject(
    "Triangulated",
    lambda **k: fc.Triangulated(**{"surface": MESHES / "none.stl", **k}),
    {"smooth": ("smooth", "surface")},
    surface=st.nothing(),
    smooth=st.nothing(),
)
subject(
    "torques",
    lambda **k: fc.torques(**{"contact": scene().contacts[0], "about": (0, 0), **k}),
    contact=fixed(scene().contacts[0]),
    about=numbers(2) | fixed(lambda: (0.0, 0.0)),
)

subject("Velocity", law(fc.Velocity, "formulation"), drift_correction=SHARE)
subject("Printed", law(fc.Printed, "formulation"), drift_correction=SHARE)
subject(
    "Lagrange",
    law(fc.Lagrange, "formulation"),
    points=fixed(None, [(-0.18, 0.0)], np.array([(-0.18, 0.0), (0.18, 0.0)])),
)
subject(
    "Discrete",
    law(lambda **k: fc.Discrete(**{"stiffness": 1.0, **k}), "formulation"),
    stiffness=POSITIVE,
    damping=POSITIVE,
    tangential_stiffness=NONE | POSITIVE,
    points=fixed(None, [(-0.18, 0.0)]),
)
subject(
    "Restitution",
    law(fc.Restitution, "formulation"),
    coefficient=SHARE,
    drift_correction=SHARE,
)
subject(
    "Adhesive",
    law(lambda **k: fc.Adhesive(**{"stress": 1.0, **k}), "formulation"),
    {"law": ("law", "formulation")},
    stress=POSITIVE,
    law=fixed("velocity", "gap", fc.LAGRANGE),
)
subject(
    "Compliance",
    law(lambda **k: fc.Compliance(**{"coefficient": 1.0, **k}), "formulation"),
    coefficient=POSITIVE,
    exponent=fixed(1.0, 1.5, 3),
    tangential_stiffness=NONE | POSITIVE,
    damping=POSITIVE,
)
subject(
    "Coulomb",
    law(lambda **k: fc.Coulomb(**{"mu": 0.3, **k})),
    {"mu": ("friction", "mu")},
    mu=POSITIVE,
)
subject("Tresca", law(lambda **k: fc.Tresca(**{"stress": 0.3, **k})), stress=POSITIVE)
subject(
    "StaticKinetic",
    law(lambda **k: fc.StaticKinetic(**{"static": 0.3, "kinetic": 0.2, **k})),
    {"static": ("static", "kinetic")},
    static=st.floats(0.5, 2.0),
    kinetic=st.floats(0.0, 0.3),
)
subject(
    "Stribeck",
    law(lambda **k: fc.Stribeck(**{"static": 0.3, "kinetic": 0.2, "speed": 0.1, **k})),
    {"static": ("static", "kinetic")},
    static=st.floats(0.5, 2.0),
    kinetic=st.floats(0.0, 0.3),
    speed=POSITIVE,
    exponent=st.floats(1.0, 3.0),
    viscosity=POSITIVE,
)
subject(
    "RateState",
    law(
        lambda **k: fc.RateState(
            **{"a": 0.01, "b": 0.015, "distance": 1e-3, "mu": 0.6, "speed": 0.01, **k}
        )
    ),
    {"distance": ("distance", "theta"), "speed": ("speed", "theta")},
    a=st.floats(0.01, 0.1),
    b=st.floats(0.0, 0.1),
    distance=POSITIVE,
    mu=SHARE,
    speed=POSITIVE,
    theta=NONE | POSITIVE,
    law=fixed("ageing", "slip"),
)
subject(
    "Archard",
    law(lambda **k: fc.Archard(**{"friction": 0.3, "coefficient": 1.0, "hardness": 1.0, **k})),
    friction=POSITIVE,
    coefficient=POSITIVE,
    hardness=POSITIVE,
)

subject(
    "ThetaScheme",
    lambda **k: two(scheme=fc.ThetaScheme(**k), allow_growth=True),
    theta=st.floats(0.5, 1.0),
    forces=fixed("theta", "end"),
)
subject("GeneralisedAlpha", lambda **k: two(scheme=fc.GeneralisedAlpha(**k)), rho_inf=SHARE)
subject(
    "EnergyMomentum",
    lambda **k: two(scheme=fc.EnergyMomentum(**k)),
    theta=fixed(0.5),
    forces=fixed("theta"),
)
subject(
    "Newton",
    lambda **k: two(newton=fc.Newton(**k)),
    tolerance=sized(-12, -3),
    max_iterations=st.integers(1, 50),
)
subject(
    "Scene",
    two,
    solids=st.nothing(),
    contacts=fixed([]),
    scheme=fixed(None, fc.GeneralisedAlpha(), fc.EnergyMomentum()),
    newton=fixed(None, fc.Newton()),
    locate_impacts=TRUTH,
    geometry=fixed(None, "newton", "fixed point", "mixed"),
    solver=fixed(None),
    allow_free=fixed(True),
    allow_growth=TRUTH,
    deepest=SHARE,
)
subject(
    "run",
    whole,
    {"until": ("until", "dt"), "resume": ("resume", "directory")},
    until=sized(-3, -2),
    dt=sized(-5, -3),
    step_error=NONE | sized(-6, -3),
    directory=NONE,
    resume=fixed(False),
    fields_every=fixed(0),
    progress=fixed(None, False),
    shortest=st.floats(0.01, 1.0),
    probes=fixed(None, {}, {"p": lambda: 1.0}),
    stop_when=fixed(None, lambda: False),
)

AXIS = fc.axis_mesh((0, 0), (0, 1), rod=(1.0, 2))
subject(
    "axis_mesh",
    lambda **k: fc.axis_mesh(**{"origin": (0, 0), "direction": (0, 1), "rod": (1.0, 2), **k}),
    {"origin": ("origin", "direction")},
    origin=numbers(2),
    direction=directions(2),
    rod=st.tuples(sized(-3, 3), st.integers(1, 5)) | fixed([0.0, 0.1, 0.5]),
)
subject(
    "Section",
    lambda **k: beam(sections=fc.Section(**{"mass": 1.0, "bending": 10.0, **k})),
    mass=POSITIVE,
    bending=POSITIVE,
    shear=POSITIVE | fixed(INF),
    axial=POSITIVE | fixed(INF),
    rotary=POSITIVE,
    tension=sized(-3, 3),
)
subject(
    "Support",
    lambda **k: beam(supports=[fc.Support(**{"at": 0.0, **k})]),
    {"at": ("at", "supports")},
    at=fixed(0.0, 0.5, 1.0),
    lateral=POSITIVE | fixed(INF),
    rotational=POSITIVE | fixed(INF),
    axial=POSITIVE | fixed(INF),
)
subject(
    "BeamSolid",
    beam,
    axis=fixed(AXIS),
    sections=fixed(fc.Section(1.0, 1.0), {"rod": fc.Section(2.0, 3.0)}),
    masses=fixed((), [(1.0, 2.0)]),
    supports=fixed((), [fc.Support(0.0)]),
    gravity=NONE | numbers(2, 10),
    law=fixed(None, fc.Driven(1.0)),
    lateral_load=fixed(None, lambda s: np.zeros((1, len(s)))),
    displacement=fixed(None, lambda s: 0.01 * s[None] ** 2),
    slope=fixed(None, lambda s: 0.02 * s[None]),
    name=NAME,
)
subject("Driven", lambda **k: beam(law=fc.Driven(**k)), speed=st.floats(-1, 1))
subject(
    "Fall",
    lambda **k: beam(law=fc.Fall(**k)),
    {"drive_friction": ("drive_friction", "friction"), "water": ("water", "buoyancy")},
    water=NONE,
    drive_friction=st.floats(0, 1),
    stop=NONE | st.floats(0, 1),
    stop_stiffness=POSITIVE,
)
subject(
    "GuideTubeWater",
    fc.GuideTubeWater,
    **{n: POSITIVE for n in ("buoyancy", "mass", "mass_travel", "before", "inside", "dashpot")},
    ramp=POSITIVE,
    before_slope=st.floats(-1, 1),
    inside_slope=st.floats(-1, 1),
)
subject(
    "Tube",
    lambda **k: Guide([Tube(**{"top": 0.0, "bottom": 2.0, "clearance": 0.1, **k})]),
    top=st.floats(-2, 1),
    bottom=st.floats(2, 3),
    clearance=POSITIVE | fixed([(0.0, 0.1), (1.0, 0.2)]),
    curve=fixed(Straight(), Straight(0.1), Sine(0.01, 1.0), Bow(0.01, 2.0)),
    kinks=fixed((), [1.5]),
)
subject(
    "Card",
    lambda **k: Guide([Card(**{"depth": 0.0, "clearance": 0.1, **k}), Card(1.0, 0.1)]),
    depth=st.floats(-2, 0),
    clearance=POSITIVE,
    centre=st.floats(-1, 1),
)
subject("Straight", lambda **k: Guide([Tube(0.0, 1.0, 0.1, Straight(**k))]), tilt=st.floats(-1, 1))
subject(
    "Sine",
    lambda **k: Guide([Tube(0.0, 1.0, 0.1, Sine(**{"amplitude": 0.1, "wavelength": 1.0, **k}))]),
    amplitude=st.floats(-1, 1),
    wavelength=POSITIVE,
    inlet=fixed("tangent", "kinked"),
)
subject(
    "Bow",
    lambda **k: Guide([Tube(0.0, 1.0, 0.1, Bow(**{"sagitta": 0.1, "length": 1.0, **k}))]),
    sagitta=st.floats(-1, 1),
    length=POSITIVE,
)
subject(
    "Guide",
    lambda **k: Guide(**{"pieces": [Tube(0.0, 2.0, 0.1)], **k}),
    {
        "plane": ("plane", "direction"),
        "direction": ("plane", "direction"),
        "origin": ("origin", "direction"),
    },
    pieces=fixed([Tube(0.0, 2.0, 0.1)], [Card(0.0, 0.1), Card(1.0, 0.1)]),
    origin=numbers(2),
    direction=NONE | directions(2),
    plane=NONE,
)
subject(
    "GuideContact",
    lambda **k: GuideContact(
        **{
            "solid": beam(),
            "facets": "rod",
            "obstacle": Guide([Tube(-2.0, 2.0, 0.1)]),
            **k,
        }
    ),
    {"facets": ("facets", "stretch")},
    solid=st.builds(beam),
    facets=fixed("rod"),
    obstacle=fixed(Guide([Tube(-2.0, 2.0, 0.1)])),
    formulation=fixed("velocity", "gap"),
    friction=st.floats(0, 1),
    deepest=SHARE,
)
subject(
    "RodInTube",
    lambda **k: RodInTube(
        **{"rod": beam(), "tube": beam(supports=[fc.Support(0.0, axial=INF)], name="t"), **k}
    ),
    rod=st.builds(beam),
    tube=st.builds(lambda: beam(supports=[fc.Support(0.0, axial=INF)], name="t")),
)

subject(
    "mesh_from_gmsh",
    lambda **k: fc.mesh_from_gmsh(**{"file": MESHES / "block.geo", **k}),
    {"width": ("width", "mesh"), "n_width": ("n_width", "file", "mesh")},
    file=fixed(MESHES / "block.geo"),
    width=sized(-2, 2),
    n_width=st.integers(1, 3),
)
subject(
    "mesh_from_file",
    lambda **k: fc.mesh_from_file(**{"file": MESHES / "none.vtk", **k}),
    {"file": ("file",)},
    file=st.nothing(),
)
subject(
    "name_facets",
    lambda **k: fc.name_facets(**{"mesh": PLANE.mesh, "where": {}, **k}),
    mesh=fixed(PLANE.mesh),
    where=fixed({}, {"a": lambda x: x[0] < 0}),
)
subject(
    "name_points",
    lambda **k: fc.name_points(**{"mesh": PLANE, "points": {"p": (0, 0)}, **k}),
    mesh=fixed(PLANE),
    points=fixed({}, {"p": (0.1, 0.2)}),
)
subject(
    "NamedMesh",
    lambda **k: fc.NamedMesh(
        **{"mesh": PLANE.mesh, "facet_tags": PLANE.facet_tags, "names": PLANE.names, **k}
    ),
    mesh=fixed(PLANE.mesh),
    facet_tags=fixed(PLANE.facet_tags),
    names=fixed({"base": 1}),
    points=fixed({}, {"p": (0.0, 0.0)}),
)
subject(
    "read_history",
    lambda **k: fc.read_history(**{"path": MESHES / "none", **k}),
    {"path": ("path", "history.json")},
    path=st.nothing(),
)

PROBLEM = fc.FrictionalProblem(np.eye(6), np.ones(6), [0.1, 0.2])
SOLUTION = PROBLEM.solve()
subject(
    "FrictionalProblem",
    lambda **k: fc.FrictionalProblem(
        **{"W": np.eye(6), "q": np.ones(6), "mu": [0.1, 0.2], "dim": 3, **k}
    ),
    {"dim": ("dim", "W"), "W": ("W", "q", "mu")},
    W=fixed(np.eye(6), 2 * np.ones((6, 6))),
    q=numbers(6),
    mu=st.tuples(SHARE, SHARE),
    dim=fixed(3),
    title=NAME,
    description=NAME,
    frames=fixed(None, np.stack([np.eye(3)] * 2)),
    points=fixed({}, {"a": np.arange(2)}),
)
subject(
    "FrictionalSolution",
    lambda **k: fc.FrictionalSolution(**{"u": SOLUTION.u, "r": SOLUTION.r, "error": 0.0, **k}),
    u=fixed(SOLUTION.u),
    r=fixed(SOLUTION.r),
    error=SHARE,
)
subject(
    "frictional_problem",
    lambda **k: fc.frictional_problem(**{"scene": None, "dt": 1e-3, **k}),
    {"dt": ("dt", "scene")},
    scene=st.nothing(),
    dt=sized(-4, 0),
)
subject(
    "read_fclib",
    lambda **k: fc.read_fclib(**{"path": MESHES / "none", **k}),
    {"path": ("path",)},
    path=st.nothing(),
)
subject(
    "write_fclib",
    lambda **k: fc.write_fclib(**{"path": "a.hdf5", "problem": PROBLEM, **k}),
    {"guesses": ("guesses",)},
    path=fixed("a.hdf5"),
    problem=fixed(PROBLEM),
    solution=fixed(None, SOLUTION),
    guesses=fixed([], [SOLUTION]),
)
