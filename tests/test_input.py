# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bad input is refused before the first step, by a message that names argument and value."""

from __future__ import annotations

import math
import re
from pathlib import Path

import dolfinx
import meshio
import numpy as np
import pytest
import ufl
from mpi4py import MPI
from scenes import FLOOR, FLOOR_3D, box, rectangle

from fenicsx_contact import (
    BeamSolid,
    Circle,
    Contact,
    Cylinder,
    Discrete,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    InputError,
    Lagrange,
    LevelSet,
    Moved,
    NamedMesh,
    Newton,
    QuasiStatic,
    RigidSolid,
    Scene,
    Section,
    ThetaScheme,
    Velocity,
    axis_mesh,
    gradients,
    mesh_from_file,
    mesh_from_gmsh,
    name_facets,
    name_points,
    neo_hookean,
    st_venant_kirchhoff,
)
from fenicsx_contact.base import compat
from fenicsx_contact.base.quoted import quoted
from fenicsx_contact.base.shown import exactly

NAN, INF = float("nan"), float("inf")
BLOCK = Path(__file__).parents[1] / "meshes" / "block.geo"


def rigid(**others):
    return RigidSolid(rectangle(), **{"mass": 1.0, **others})


def rigid_3d(**others):
    return RigidSolid(box(), **{"mass": 1.0, **others})


def elastic(**others):
    numbers = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1e3}
    return ElasticSolid(rectangle(), **{**numbers, **others})


def hyperelastic(**others):
    return HyperelasticSolid(
        rectangle(), **{"energy": neo_hookean(1e6, 0.3), "density": 1e3, **others}
    )


def contact(formulation="velocity", **others):
    return Contact(rigid(), "base", FLOOR, formulation, **others)


def scene(scheme=None, formulation="velocity", obstacle=FLOOR, **others):
    solid = rigid(gravity=(0, -9.81))
    return Scene([solid], [Contact(solid, "base", obstacle, formulation)], scheme, **others)


def run(**others):
    return scene().run(**{"until": 0.01, "dt": 1e-3, **others})


def refused(make, *words):
    """``make`` raises an InputError, which is a ValueError, whose message has all the words."""
    with pytest.raises(InputError) as caught:
        make()
    assert isinstance(caught.value, ValueError)
    for word in words:
        assert word in str(caught.value), f"{word!r} not in {caught.value}"


# -- numbers: where, name, values that must be refused --

BAD = (NAN, INF, -INF, 1e300, 1e-300, None, "much", "0.3", True, (1.0, 2.0), 1j)
NUMBERS = [
    (contact, "friction", (-0.1, *BAD)),
    (contact, "normal_augmentation", (0.0, -1.0, *BAD)),
    (contact, "tangential_augmentation", (0.0, -1.0, *BAD)),
    (contact, "gap_tolerance", (-1e-9, *BAD)),
    (rigid, "mass", (0.0, -1.0, *(b for b in BAD if b is not None))),
    (rigid, "rotation", BAD),
    (rigid, "spin", BAD),
    (rigid_3d, "spin", ((1.0, NAN, 0.0), (1.0, 2.0), 0.5, "fast", (0.0, 0.0, 1e300))),
    (rigid_3d, "rotation", ((1.0, INF, 0.0), (1.0, 2.0), 0.5, "much", (0.0, 0.0, 1e300))),
    (elastic, "density", (0.0, -7800.0, *BAD)),
    (elastic, "youngs_modulus", (0.0, -1.0, *BAD)),
    (elastic, "poisson_ratio", (0.5, 0.7, -1.0, *BAD)),
    (elastic, "degree", (3, 0, -1, 1.5, "2", None, NAN)),
    (hyperelastic, "density", (0.0, -7800.0, *BAD)),
    (lambda **k: neo_hookean(1e6, **k), "poisson_ratio", (0.5, -1.0, *BAD)),
    (lambda **k: st_venant_kirchhoff(poisson_ratio=0.3, **k), "youngs_modulus", (0.0, *BAD)),
    (Discrete, "stiffness", (0.0, -1.0, *BAD)),
    (lambda **k: Discrete(1e6, **k), "damping", (-1.0, *BAD)),
    (lambda **k: Discrete(1e6, **k), "tangential_stiffness", (0.0, NAN, INF, 1e300)),
    (Velocity, "drift_correction", (-0.1, 1.1, *BAD)),
    (ThetaScheme, "theta", (-0.1, 1.1, *BAD)),
    (Newton, "tolerance", (0.0, -1e-8, 0.1, *BAD)),
    (Newton, "max_iterations", (0, -3, 2.5, *BAD)),
    (scene, "deepest", (-1e-3, *BAD)),
    (run, "dt", (0.0, -1e-3, *BAD)),
    (run, "until", (0.0, -1.0, *BAD)),
    (run, "shortest", (0.0, -0.5, 2.0, *BAD)),
]


@pytest.mark.parametrize(
    ("make", "name", "value"),
    [
        pytest.param(make, name, value, id=f"{i}-{name}-{value}")
        for i, (make, name, values) in enumerate(NUMBERS)
        for value in values
    ],
)
def test_number(make, name, value):
    words = [name] if isinstance(value, tuple) else [name, repr(value)]
    refused(lambda: make(**{name: value}), *words)


@pytest.mark.parametrize("fields_every", [-5, 2.5, NAN, "all"])
def test_fields_every(fields_every, tmp_path):
    refused(
        lambda: run(fields_every=fields_every, directory=tmp_path),
        "fields_every",
        str(fields_every),
    )


# -- vectors --

VECTORS = [(1.0, 2.0, 3.0), (1.0,), 9.81, (NAN, 0.0), (0.0, INF), (0.0, 1e300), "down"]
VECTORS += [("0.0", "-9.81"), (True, False), (0.0, 1j)]


@pytest.mark.parametrize("value", VECTORS, ids=str)
@pytest.mark.parametrize("make", [rigid, elastic, hyperelastic])
def test_gravity(make, value):
    refused(lambda: make(gravity=value), "gravity")


@pytest.mark.parametrize("value", VECTORS, ids=str)
@pytest.mark.parametrize("name", ["velocity", "about"])
def test_vectors_of_a_rigid_solid(name, value):
    refused(lambda: rigid(**{name: value}), name)


@pytest.mark.parametrize("value", [(0, 0), (NAN, 1), (0, 0, 1), (0, 1e300), (0, 1e-300), "up", 1])
def test_normal_of_a_half_space(value):
    refused(lambda: HalfSpace((0, 0), value), "normal")


@pytest.mark.parametrize("value", [(0,), (0, NAN), (0, 1e300), "ab", 0, (0, 0, 0, 0)])
def test_point_of_a_half_space(value):
    refused(lambda: HalfSpace(value, (0, 1)), "point")


# -- choices and kinds --


@pytest.mark.parametrize("forces", ["middle", "", None, 0.5, ["theta"]])
def test_forces(forces):
    refused(lambda: ThetaScheme(0.5, forces), "forces", repr(forces), "'theta'", "'end'")


@pytest.mark.parametrize("formulation", ["penalty", "", None, 3, Velocity, Discrete])
def test_formulation(formulation):
    refused(lambda: contact(formulation), "formulation", repr(formulation), "'velocity'")


def test_discrete_needs_a_stiffness():
    refused(lambda: contact("discrete"), "discrete", "stiffness")


@pytest.mark.parametrize("facets", ["bottom", "", None, ["base"]])
def test_facets_of_a_contact(facets):
    for solid in (rigid(), elastic()):
        refused(lambda solid=solid: Contact(solid, facets, FLOOR), repr(facets), "facets", "'base'")


def test_fixed_facets():
    refused(lambda: elastic(fixed=["bottom"]), "facets", "'bottom'", "'base'")
    refused(lambda: elastic(fixed="bottom"), "facets", "'bottom'", "'base'")


def test_facets_without_members():
    mesh = name_facets(rectangle().mesh, {"nowhere": lambda x: x[1] > 10})
    refused(lambda: Contact(RigidSolid(mesh, mass=1.0), "nowhere", FLOOR), "facets", "'nowhere'")


@pytest.mark.parametrize("mesh", [None, "block.msh", "dolfinx"])
@pytest.mark.parametrize(
    "make",
    [
        lambda mesh: RigidSolid(mesh, mass=1.0),
        lambda mesh: ElasticSolid(mesh, youngs_modulus=1e6, poisson_ratio=0.3, density=1e3),
    ],
)
def test_mesh_of_a_solid(make, mesh):
    refused(lambda: make(rectangle().mesh if mesh == "dolfinx" else mesh), "mesh", "NamedMesh")


def test_density_or_mass():
    refused(lambda: rigid(density=1.0), "density = 1.0", "mass = 1.0")
    refused(lambda: rigid(mass=None), "density = None", "mass = None")


@pytest.mark.parametrize("solid", ["block", None, FLOOR])
def test_solid_of_a_contact(solid):
    refused(lambda: Contact(solid, "base", FLOOR), "solid", repr(solid))


@pytest.mark.parametrize("obstacle", ["floor", None, (0, 1)])
def test_obstacle_of_a_contact(obstacle):
    refused(lambda: Contact(rigid(), "base", obstacle), "master", repr(obstacle))


def test_a_contact_and_a_solid_of_one_name():
    solid = rigid()
    refused(lambda: Scene([solid], [Contact(solid, "base", FLOOR, name=solid.name)]), solid.name)


def test_obstacle_of_another_dimension():
    refused(lambda: Contact(rigid_3d(), "base", FLOOR), "master", "HalfSpace", "2", "3")
    refused(lambda: Contact(rigid(), "base", FLOOR_3D), "master", "HalfSpace", "2", "3")


@pytest.mark.parametrize("formulation", [Lagrange, lambda points: Discrete(1e6, points=points)])
@pytest.mark.parametrize(
    "points",
    [[(0.01, 0.0)], [(-0.18, 0.0), (0.18, 0.01)], [(NAN, 0.0)], [(0.18, 0.0, 0.0)], [], "corners"],
    ids=str,
)
def test_points_that_are_no_nodes(formulation, points):
    refused(lambda: contact(formulation(points=points)), "points", repr(points))


@pytest.mark.parametrize("energy", [None, 3.0, "neo-hookean", lambda F: F, lambda F: "x"])
def test_energy(energy):
    refused(lambda: hyperelastic(energy=energy), "energy", quoted(energy))


def test_an_energy_that_resists_no_strain():
    refused(lambda: hyperelastic(energy=lambda F: 1e6 * ufl.tr(F)), "energy", "linear in F")


@pytest.mark.parametrize("number", [NAN, np.inf])
def test_numbers_in_ufl_that_are_none(number):
    """The compiler of C would refuse them in its own words."""
    found = f"the number {number}"
    refused(lambda: hyperelastic(energy=lambda F: number * ufl.tr(F)), "energy", found)
    refused(lambda: LevelSet(lambda x, t: x[1] + number, 2), "phi", found)
    refused(lambda: elastic(youngs_modulus=lambda x: 1e6 + number * x[0]), "youngs_modulus", found)


@pytest.mark.parametrize("make", [elastic, hyperelastic])
@pytest.mark.parametrize("name", ["displacement", "velocity"])
@pytest.mark.parametrize(
    "field",
    [
        lambda x: np.stack([NAN * x[0], x[1]]),
        lambda x: np.stack([np.where(x[1] > 0.7, INF, 0.0), x[1]]),
        lambda x: np.stack([1e300 + 0 * x[0], x[1]]),
        lambda x: x[0],
        lambda x: x,
        (0.0, NAN),
        (0.0, 0.0, 0.0),
        "ab",
    ],
    ids=["nan", "inf", "huge", "scalar", "3D", "number", "numbers", "text"],
)
def test_initial_fields(make, name, field):
    refused(lambda: make(**{name: field}), name)


# -- names --


@pytest.mark.parametrize("name", ["a/b", "/", "", "two\nlines", 3, b"base"])
def test_names_that_cannot_be_those_of_files(name):
    for make in (rigid, elastic, hyperelastic, contact):
        refused(lambda make=make: make(name=name), f"name = {name!r}", "'/'")
    assert contact(name="base of 'a' & b <1>.x").name == "base of 'a' & b <1>.x"


def test_a_contact_named_by_facets_that_cannot_name_a_file():
    mesh = name_facets(rectangle().mesh, {"low/left": lambda x: x[1] < 1e-9})
    solid = RigidSolid(mesh, mass=1.0)
    refused(lambda: Contact(solid, "low/left", FLOOR), "name = 'rigid.low/left'")
    assert Contact(solid, "low/left", FLOOR, name="low left").name == "low left"


# -- scenes --


def test_solid_without_contact_or_support():
    for make in (rigid, elastic, hyperelastic):
        refused(lambda make=make: Scene([make(name="lost")], []), "solids", "'lost'", "allow_free")
        assert Scene([make()], [], allow_free=True).run(1e-3, 1e-3).finished
    assert Scene([elastic(fixed=["base"])], []).run(1e-3, 1e-3).finished


def test_names_that_are_taken():
    refused(lambda: Scene([rigid(), rigid()], [], allow_free=True), "solids", "'rigid'")
    solid = rigid()
    twice = [Contact(solid, "base", FLOOR), Contact(solid, "base", FLOOR)]
    refused(lambda: Scene([solid], twice), "contacts", "'rigid.base'")
    refused(lambda: Scene([solid, solid], twice[:1]), "solids", "'rigid'")


def test_contact_of_a_solid_outside_the_scene():
    inside = rigid(name="inside")
    refused(
        lambda: Scene([inside], [contact()], allow_free=True), "contacts", "'rigid.base'", "'rigid'"
    )


def test_solids_of_two_dimensions():
    solids = [rigid(name="a"), rigid_3d(name="b")]
    refused(lambda: Scene(solids, [], allow_free=True), "solids", "2D", "3D")


@pytest.mark.parametrize(
    ("solids", "contacts", "name"),
    [
        ([], [], "solids"),
        (["block"], [], "solids"),
        (None, [], "solids"),
        ([FLOOR], [], "solids"),
        ([], ["contact"], "solids"),
        (["make"], ["contact"], "contacts"),
        (["make"], None, "contacts"),
    ],
)
def test_things_of_a_scene(solids, contacts, name):
    solids = [rigid()] if solids == ["make"] else solids
    refused(lambda: Scene(solids, contacts, allow_free=True), name)


@pytest.mark.parametrize("scheme", [0.5, "end", ThetaScheme])
def test_scheme(scheme):
    refused(lambda: scene(scheme), "scheme", repr(scheme))


@pytest.mark.parametrize("newton", [1e-10, "fast", Newton])
def test_newton(newton):
    refused(lambda: scene(newton=newton), "newton", repr(newton))


def test_body_that_starts_deep_inside():
    refused(lambda: scene(obstacle=HalfSpace((0, 0.1), (0, 1))), "'rigid.base'", "0.1 inside")
    assert scene(obstacle=HalfSpace((0, 0.1), (0, 1)), deepest=0.5)
    assert scene(obstacle=HalfSpace((0, 1e-4), (0, 1)))


@pytest.mark.parametrize("value", ["no", "yes", 0, 1, None, 1.0])
@pytest.mark.parametrize("name", ["locate_impacts", "allow_free", "allow_growth"])
def test_truth(name, value):
    refused(lambda: scene(**{name: value}), f"{name} = {value!r}", "True or False")


@pytest.mark.parametrize("value", ["no", 1])
def test_resume_that_is_no_truth(value, tmp_path):
    refused(lambda: run(resume=value, directory=tmp_path), f"resume = {value!r}", "True or False")


def test_located_impacts_without_inertia():
    def pressed(**others):
        solid = elastic(fixed=["top"], gravity=(0, -9.81))
        return Scene([solid], [Contact(solid, "base", FLOOR)], QuasiStatic(), **others)

    refused(lambda: pressed(locate_impacts=True), "locate_impacts = True", "quasi-static")
    assert pressed().run(2e-3, 1e-3).finished


@pytest.mark.parametrize("formulation", ["gap", "lagrange", Discrete(1e6)])
def test_theta_0_with_a_law_of_positions(formulation):
    refused(lambda: scene(ThetaScheme(0.0), formulation), "theta = 0.0", "'rigid.base'")
    assert scene(ThetaScheme(0.0), "velocity", allow_growth=True).run(2e-3, 1e-3).finished


# -- runs --


def test_files_without_a_directory():
    refused(lambda: run(resume=True), "directory = None", "resume")
    refused(lambda: run(fields_every=1), "directory = None", "fields_every")


def test_directory(tmp_path):
    file = tmp_path / "file"
    file.write_text("mine")
    refused(lambda: run(directory=file), "directory", str(file))
    refused(lambda: run(directory=3), "directory", "3")
    refused(lambda: run(directory="a\0b"), "directory", "a\\x00b")
    assert file.read_text() == "mine"


def test_step_longer_than_the_run():
    refused(lambda: run(dt=1.0), "dt = 1.0", "0.01")


@pytest.mark.parametrize(
    "probes",
    [
        [lambda: 1.0],
        {"p": 1.0},
        {"kinetic": lambda: 1.0},
        {"rigid.base.force_x": lambda: 1.0},
        {"p": lambda: "x"},
        {"p": lambda: None},
        {"p": lambda: (1.0, 2.0)},
    ],
    ids=["list", "number", "taken", "taken by a contact", "text", "nothing", "vector"],
)
def test_probes(probes):
    refused(lambda: run(probes=probes), "probes")


# -- meshes --


def triangle_in_space():
    cells, points = np.array([[0, 1, 2]]), np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 1]])
    return compat.create_mesh(MPI.COMM_SELF, cells, points, "triangle")


def test_mesh_of_another_dimension_than_its_space():
    refused(lambda: name_facets(triangle_in_space(), {}), "mesh of dimension 2", "dimension 3")
    line = dolfinx.mesh.create_unit_interval(MPI.COMM_WORLD, 3)
    refused(lambda: name_facets(line, {}), "mesh of dimension 1")


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda x: x[0].__setitem__(0, NAN), "not finite"),
        (lambda x: x[-1].__setitem__(1, INF), "not finite"),
        (lambda x: x[:, 1].fill(0.0), "without volume"),
    ],
)
@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
def test_mesh_with_spoilt_nodes(spoil, words, cell):
    mesh = rectangle(cell=cell)
    spoil(mesh.mesh.geometry.x)
    refused(lambda: NamedMesh(mesh.mesh, mesh.facet_tags, mesh.names), "mesh", words)


def test_names_of_facets():
    mesh = rectangle().mesh
    overlap = {"a": lambda x: x[1] < 0.1, "b": lambda x: x[1] < 0.1}
    refused(lambda: name_facets(mesh, overlap), "where", "'a', 'b'")
    refused(lambda: name_facets(mesh, {"a": 3}), "where", "'a'", "3")


def test_gmsh_parameters():
    refused(lambda: mesh_from_gmsh(BLOCK, n_hight=3), "n_hight = 3", "block.geo", "n_height")
    refused(lambda: mesh_from_gmsh(BLOCK, width=NAN), "width = nan")
    refused(lambda: mesh_from_gmsh(BLOCK, width="wide"), "width = 'wide'")
    refused(lambda: mesh_from_gmsh(BLOCK, width=0.0), "width = 0", "must be > 0")
    assert mesh_from_gmsh(BLOCK, n_width=3).dim == 2


def test_gmsh_file_that_is_not_there():
    refused(lambda: mesh_from_gmsh("nowhere.geo"), "file = 'nowhere.geo'", "no such file")
    refused(lambda: mesh_from_gmsh("nowhere.geo"), "that come along", "block.geo, box.geo")
    refused(lambda: mesh_from_gmsh("some/block.geo"), "no such file")


def test_gmsh_file_that_comes_along(tmp_path, monkeypatch):
    """A bare name means it, unless the present folder has one of the same name."""
    monkeypatch.chdir(tmp_path)
    ours = mesh_from_gmsh("block.geo", width=0.5)
    assert "base" in ours.names
    (tmp_path / "block.geo").write_text(
        'SetFactory("OpenCASCADE"); Rectangle(1) = {0, 0, 0, 1, 1};\n'
        'Physical Surface("all") = {1}; Physical Curve("under") = {1};'
    )
    assert set(mesh_from_gmsh("block.geo").names) == {"under"}
    refused(lambda: mesh_from_gmsh("block.geo", width=0.5), "block.geo declares nothing")


@pytest.mark.parametrize(
    ("script", "words"),
    [
        ("", "dimension -1"),
        ("Point(1) = {0, 0, 0};\nfoo bar;", "gmsh says"),
        ("Point(1) = {0,0,0}; Point(2) = {1,0,0}; Line(1) = {1,2};", "dimension 1"),
        ('SetFactory("OpenCASCADE"); Rectangle(1) = {0, 0, 0, 1, 1};', "Physical Surface"),
        (
            "Point(1) = {0,0,0}; Point(2) = {1,0,0}; Point(3) = {0,1,1}; Line(1) = {1,2};"
            "Line(2) = {2,3}; Line(3) = {3,1}; Curve Loop(1) = {1,2,3}; Plane Surface(1) = {1};"
            'Physical Surface("s") = {1}; Physical Curve("a") = {1};',
            "surface in 3D",
        ),
    ],
    ids=["empty", "syntax", "line", "no groups", "surface in 3D"],
)
def test_gmsh_script_that_gives_no_solid(script, words, tmp_path):
    file = tmp_path / "bad.geo"
    file.write_text(script)
    refused(lambda: mesh_from_gmsh(file), "file", str(file), words)
    assert mesh_from_gmsh(BLOCK).dim == 2  # gmsh is left as it was


# -- what the fuzz tests found --


def a_vector():
    return dolfinx.fem.Constant(rectangle().mesh, (0.0, 1.0))


@pytest.mark.parametrize("value", [10**400, np.datetime64("2020-01-01"), np.ma.masked])
def test_what_is_no_float(value):
    refused(lambda: rigid(mass=value), "mass")


def test_a_vector_with_a_masked_number():
    refused(lambda: rigid(gravity=np.ma.masked_array([0.0, 1.0], [True, False])), "gravity")


@pytest.mark.parametrize(
    ("make", "name"),
    [(rigid, "force"), (elastic, "prescribed"), (rigid, "springs"), (elastic, "springs")],
)
def test_ufl_where_floats_are_asked_for_is_refused_at_once(make, name):
    """It was asked for its components without end."""
    x = dolfinx.fem.Function(compat.lagrange_space(rectangle().mesh))
    given = x if name == "force" else {(0.0, 0.0): x} if name == "springs" else {"top": [x, x]}
    refused(lambda: make(**{name: given}), name)
    assert rigid(force=a_vector())


@pytest.mark.parametrize(
    "function", [lambda: 1.0, lambda a, b: a, lambda t: "much", len, lambda t: [a_vector()] * 2]
)
@pytest.mark.parametrize("name", ["force", "torque"])
def test_functions_of_time_that_are_none(name, function):
    refused(lambda: rigid(**{name: function}), f"{name}(0)")


@pytest.mark.parametrize("value", [3, None, {"base"}, [3], object()])
@pytest.mark.parametrize("name", ["fixed", "mass_redistribution"])
def test_lists_of_names(name, value):
    refused(lambda: elastic(**{name: value}), name)


@pytest.mark.parametrize("value", [0, "", [], np.eye(2)])
@pytest.mark.parametrize("name", ["springs", "tractions", "prescribed"])
def test_dicts(name, value):
    refused(lambda: elastic(**{name: value}), name, "dict")


def test_a_cylinder_without_an_axis_is_no_ball():
    refused(lambda: Cylinder((0, 0, 0), None, 1.0), "axis = None")


@pytest.mark.parametrize("value", ["no", 1, None])
def test_inside_of_a_circle(value):
    refused(lambda: Circle((0, 0), 1.0, inside=value), f"inside = {value!r}")


def test_a_motion_that_is_ufl():
    refused(lambda: Moved(FLOOR, a_vector()), "motion")


def test_a_friction_that_is_not_a_number_leaves_no_broken_compiler_cache():
    refused(lambda: contact(friction=lambda x: NAN), "friction", "nan")


def test_energies_of_other_meshes():
    x = dolfinx.fem.Constant(box().mesh, 1e6) + ufl.SpatialCoordinate(box().mesh)[0]
    refused(lambda: hyperelastic(energy=neo_hookean(x, 0.3)), "energy", "another mesh")


def test_a_run_that_no_clock_could_count():
    refused(lambda: run(until=1e59, dt=1e-3), "dt = 0.001", "round-off")


@pytest.mark.parametrize("stop_when", [lambda x: True, lambda: "yes", 3])
def test_stop_when(stop_when):
    refused(lambda: run(stop_when=stop_when), "stop_when")


def test_a_probe_that_raises():
    refused(lambda: run(probes={"p": lambda: 1 / 0}), "probes['p']", "ZeroDivisionError")
    refused(lambda: run(probes={"p": lambda: 10**400}), "probes['p']", "range of floats")
    refused(lambda: run(probes={"p": lambda: 10**9000}), "probes['p']", "range of floats")


def test_an_empty_path_is_not_the_present_directory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    refused(lambda: run(directory=""), "directory = ''", "'.' is the present")
    assert not list(tmp_path.iterdir())
    assert run(directory=".").finished and (tmp_path / "state.npz").exists()


@pytest.mark.parametrize("name", [500 * "a", 101 * "é"])
def test_names_too_long_for_files(name):
    """The run stopped where fields were to be written."""
    refused(lambda: rigid(name=name), "name = ", "at most 200 bytes")
    refused(lambda: contact(name=name), "name = ", "at most 200 bytes")


def test_the_longest_name_names_files(tmp_path):
    solid = rigid(name=200 * "a")
    scene = Scene([solid], [Contact(solid, "base", FLOOR, name=200 * "b")])
    assert scene.run(2e-3, 1e-3, directory=tmp_path, fields_every=1).finished


@pytest.mark.parametrize("make", [elastic, hyperelastic])
def test_a_degree_is_an_int(make):
    """It was kept as it was given, of which UFL makes no degree in some versions."""
    refused(lambda: make(degree=True), "degree = True", "whole number")
    solid = make(degree=np.int64(2))
    assert type(solid.degree) is type(solid.vectors.degree) is int


@pytest.mark.parametrize("name", ["geometry", "solver"])
@pytest.mark.filterwarnings("error")
def test_methods_are_named(name):
    refused(lambda: scene(**{name: np.array([1.0])}), name, "must be one of")


@pytest.mark.parametrize("value", [3, None, b"block.geo"])
@pytest.mark.parametrize("read", [mesh_from_gmsh, mesh_from_file])
def test_files_that_are_no_paths(read, value):
    refused(lambda: read(value), f"file = {value!r}", "a path")


@pytest.mark.parametrize("where", [None, {"a": lambda x: x[0]}, {"a": lambda x: 1 / 0}, {3: len}])
def test_where(where):
    mesh = rectangle().mesh
    if where is None:
        assert name_facets(mesh, where).names == {}
    else:
        refused(lambda: name_facets(mesh, where), "where")


def test_parts_of_a_named_mesh():
    mesh = rectangle()
    other = rectangle((2, 2))
    refused(lambda: NamedMesh(mesh.mesh, other.facet_tags, other.names), "of another mesh")
    refused(lambda: NamedMesh("mesh", mesh.facet_tags, mesh.names), "mesh = 'mesh'")
    refused(lambda: NamedMesh(mesh.mesh, None, mesh.names), "facet_tags = None")
    refused(lambda: NamedMesh(mesh.mesh, mesh.facet_tags, {"a": "b"}), "names['a'] = 'b'")
    refused(lambda: name_points(mesh, {"p": (NAN, 0.0)}), "points['p']")
    refused(lambda: name_points(mesh.mesh, {}), "mesh")


def quadrilaterals(cells):
    x = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [2.0, 0.0], [2.0, 1.0]])
    return compat.create_mesh(MPI.COMM_WORLD, np.array(cells), x, "quadrilateral")


def test_a_cell_that_is_there_twice():
    cells = [[0, 1, 2, 3], [1, 4, 3, 5], [1, 4, 3, 5]]
    refused(lambda: name_facets(quadrilaterals(cells), {}), "mesh", "twice")


def test_a_cell_that_is_turned_over_at_a_vertex():
    mesh = quadrilaterals([[0, 1, 2, 3], [1, 4, 3, 5]])
    mesh.geometry.x[np.argmax(mesh.geometry.x @ [1, 1, 0])] = [1.2, 0.2, 0.0]
    refused(lambda: name_facets(mesh, {}), "mesh", "turned over")


def test_cells_of_a_file_that_are_there_twice(tmp_path):
    x = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [-1, 0.2, 0]])
    for cells, words in (
        ([[0, 1, 2], [2, 1, 0]], "twice"),
        ([[0, 1, 2], [1, 2, 3], [1, 2, 4]], "3 of its cells share one facet"),
    ):
        meshio.Mesh(x, [("triangle", np.array(cells))]).write(tmp_path / "m.vtk")
        refused(lambda: mesh_from_file(tmp_path / "m.vtk"), "m.vtk", words)


def test_beams():
    axis = axis_mesh((0, 0), (0, 1), rod=(1.0, 2))

    def beam(**others):
        return BeamSolid(axis, **{"sections": Section(1.0, 1.0), **others})

    refused(lambda: beam(sections=3), "sections = 3")
    refused(lambda: beam(masses=[1.0]), "masses")
    refused(lambda: beam(supports=[1.0]), "supports")
    for name in ("displacement", "lateral_load"):
        refused(lambda name=name: beam(**{name: lambda s: s}), name)
        refused(lambda name=name: beam(**{name: "much"}), name)
    refused(lambda: beam(displacement=lambda s: s[None], slope=lambda s: NAN * s[None]), "slope")
    refused(lambda: beam(sections=Section(lambda s: NAN * s, 1.0)), "mass")
    constant = dolfinx.fem.Constant(axis.mesh, 2.0)
    assert beam(sections=Section(constant, 1.0)).mass == pytest.approx(2.0)


@pytest.mark.parametrize("kind", [ElasticSolid, HyperelasticSolid])
def test_a_misspelt_argument_is_named_with_what_may_be_meant(kind):
    """By the class that was asked, also of arguments that it hands on."""
    material = {"youngs_modulus": 1.0, "poisson_ratio": 0.3}
    if kind is HyperelasticSolid:
        material = {"energy": neo_hookean(1.0, 0.3)}
    with pytest.raises(InputError, match=rf"densty: {kind.__name__} .* mean 'density'"):
        kind(rectangle(), densty=1.0, **material)
    with pytest.raises(InputError, match=rf"q: {kind.__name__} has no .* it has mesh, .*gravity"):
        kind(rectangle(), density=1.0, q=1.0, **material)


FUNCTIONS = {
    "phi": lambda f: LevelSet(lambda x, t: x[1] - f(x[0]), 2),
    "phi of time": lambda f: LevelSet(lambda x, t: x[1] - f(t), 2),
    "velocity": lambda f: LevelSet(lambda x, t: x[1], 2, velocity=lambda x, t: (f(t), 0.0)),
    "friction": lambda f: contact(friction=lambda x: 1.0 + f(x[0])),
    "energy": lambda f: hyperelastic(energy=lambda F: f(F[0, 0])),
}


@pytest.mark.parametrize("function", [math.sin, np.sin, float, lambda v: max(v, 0.0)])
@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_of_numbers_where_ufl_is_asked_for(name, function, capfd, caplog):
    """Refused at once, in one message; UFL itself says nothing."""
    refused(lambda: FUNCTIONS[name](function), name.split()[0], "UFL")
    assert not caplog.records and not "".join(capfd.readouterr())


def later(t):
    """A load, or a motion, that is no number after a while."""
    return 0.0, -10.0 * t if t < 0.01 else np.nan


@pytest.mark.parametrize("what", ["force", "tractions", "prescribed", "body_force"])
def test_a_load_that_becomes_no_number_ends_the_run(what):
    """Its reason says so, and what went before is kept: it raised out of the run."""
    if what == "force":
        body = RigidSolid(rectangle(), mass=1.0, force=later)
    else:
        given = {"tractions": {"top": later}, "prescribed": {"top": later}, "body_force": later}
        numbers = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
        body = ElasticSolid(rectangle((2, 2)), **numbers, **{what: given[what]})
    history = Scene([body], [Contact(body, "base", FLOOR)]).run(0.02, 1e-3)
    assert not history.finished and "nan" in history.reason and "(see: " in history.reason
    assert history.time[-1] == pytest.approx(0.01, abs=1e-5)
    assert np.isfinite(history.rows()).all()


def test_gravity_across_an_axis_of_revolution_is_refused():
    numbers = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
    with pytest.raises(InputError, match=r"gravity = .* along the axis of revolution"):
        mesh = rectangle((2, 2), (0.2, 0.1))
        mesh.mesh.geometry.x[:, 0] += 0.3
        ElasticSolid(mesh, plane="axisymmetric", gravity=(1.0, -9.81), **numbers)


def test_an_obstacle_that_moves_beyond_all_bounds_is_refused():
    class Floor:
        dim, flat = 2, True

        def distance(self, x, t):
            return x[:, 1].copy()

        def normals(self, x, t):
            return np.tile([0.0, 1.0], (len(x), 1))

        def velocity(self, x, t):
            return np.full(x.shape, 1e200)

    block = RigidSolid(rectangle(), mass=1.0, name="block")
    with pytest.raises(InputError, match="the velocity of an obstacle is 1e\\+200 at the point"):
        Contact(block, "base", Floor(), friction=0.2)


# -- what messages quote --


class Ceiling:
    """An obstacle without a repr of its own, whose normals point the wrong way."""

    def __init__(self, dim=2):
        self.dim = dim

    def distance(self, points):
        return points[:, 1]

    def normals(self, points):
        return np.tile([0.0, -1.0], (len(points), 1))


class Mute:
    def bound(self, k, pressure, S):
        return "much"

    def describe(self):
        return "mute"


@pytest.mark.parametrize(
    "make",
    [
        lambda: Contact(rigid(), "base", Ceiling()),
        lambda: Contact(rigid(), "base", Ceiling(dim=3)),
        lambda: Contact(rigid(), "base", object()),
        lambda: Contact(rigid(), "base", (object(), "top")),
        lambda: contact(friction=lambda x: 0 * x[0] - 1),
        lambda: contact(friction=Mute()),
        lambda: contact(friction=object()),
        lambda: contact(formulation=object()),
        lambda: Moved(FLOOR, object()),
        lambda: Moved(FLOOR, lambda t: 1 / t),
        lambda: LevelSet(lambda x, t: x, dim=2),
        lambda: Scene([rigid()], [lambda: 1]),
        lambda: ThetaScheme(theta=lambda: 1),
        lambda: elastic(youngs_modulus=lambda x: -1e6),
        lambda: elastic(tractions={"base": lambda x, y, z: 1.0}),
        lambda: hyperelastic(energy=lambda F: F),
        lambda: rigid(force=object()),
        lambda: run(stop_when=object()),
    ],
)
def test_messages_show_no_addresses(make):
    with pytest.raises(InputError) as caught:
        make()
    assert "0x" not in str(caught.value), caught.value


@pytest.mark.parametrize("friction", ["0.3", [0.3, 0.2], -0.1])
def test_no_friction_tells_all_that_it_may_be(friction):
    words = "friction = ", "a finite number >= 0", "a function of x", "UFL", "a law of friction"
    refused(lambda: contact(friction=friction), *words)


def test_a_spring_at_no_point_is_no_stiffness():
    refused(lambda: rigid(springs={"base": 1e4}), "springs: the point = 'base': must be 2 finite")
    refused(lambda: rigid(springs={(0, 0): "a"}), "springs[(0, 0)] = 'a': must be a finite number")


def test_what_ufl_refuses_is_told_once(caplog):
    """(UFL logged it, too.)"""
    refused(lambda: LevelSet(lambda x, t: x[1], 2, velocity=lambda x, t: 1.0), "2 components")
    assert not caplog.records


def test_functions_are_quoted_by_name_and_place():
    refused(lambda: contact(friction=lambda x: 0 * x[0] - 1), "friction = lambda at test_input.py:")


def test_a_vector_is_no_modulus():
    """It raised a TypeError of numpy's."""
    solid = elastic()
    pair = dolfinx.fem.Constant(solid.mesh.mesh, (1.0, 2.0))
    refused(lambda: gradients.Modulus(solid, pair), "Modulus: name = Constant [1.0, 2.0]")


def test_descriptions_of_solids_have_no_digits_without_meaning():
    """They told functions and UFL by eight digits; by these a run knows them, and nobody else."""
    solids = (
        elastic(youngs_modulus=lambda x: 1e6 * (1 + x[0]), body_force=lambda x, t: (0, t)),
        hyperelastic(),
        rigid(force=lambda t: (t, 0)),
    )
    with exactly():
        texts = [solid.describe() for solid in solids]
    assert all(re.search(r" #[0-9a-f]{8}\b", text) for text in texts), texts
    assert [re.sub(r" #[0-9a-f]{8}\b", "", text) for text in texts] == [
        solid.describe() for solid in solids
    ]
    assert "E between 820000 and 1180000, nu" in solids[0].describe()
    assert "E 10000000.0" in elastic(youngs_modulus=1e7).describe()
