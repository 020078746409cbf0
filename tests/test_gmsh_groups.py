# SPDX-License-Identifier: LGPL-3.0-or-later
"""Physical groups of gmsh: what is legal there is meshed or refused by name; a session that is open
stays as it is; facets inside a mesh bear nothing."""

from __future__ import annotations

from pathlib import Path

import dolfinx
import gmsh
import numpy as np
import pytest
from processes import mpirun, needs_mpirun, output_of
from scenes import rectangle
from test_mesh_files import area, refused, volume

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    NamedMesh,
    RigidSolid,
    mesh_from_gmsh,
    name_facets,
    name_points,
)

ELASTIC = {"youngs_modulus": 1e7, "poisson_ratio": 0.3, "density": 1e3}
LOWER, UPPER = 1, 2


@pytest.fixture
def session():
    """The user's."""
    gmsh.initialize(["gmsh", "-v", "1"])
    yield
    gmsh.finalize()


def plates(file: Path, groups, version: float = 4.1, order: int = 1) -> str:
    """Two plates of 1 by 0.5, one on the other. Groups: dimension, entities or (of curves) the
    height at which they lie, and the name."""
    gmsh.initialize(["gmsh", "-v", "1"])
    try:
        model = gmsh.model
        model.occ.addRectangle(0, 0, 0, 1, 0.5)
        model.occ.addRectangle(0, 0.5, 0, 1, 0.5)
        model.occ.fragment([(2, LOWER)], [(2, UPPER)])
        model.occ.synchronize()
        height = {t: model.occ.getCenterOfMass(1, t)[1] for _, t in model.getEntities(1)}
        for dim, where, name in groups:
            at = [t for t in height if height[t] in where] if dim == 1 else where
            model.setPhysicalName(dim, model.addPhysicalGroup(dim, at), name)
        model.mesh.setSize(model.getEntities(0), 0.25)
        model.mesh.generate(2)
        model.mesh.setOrder(order)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.write(str(file))
    finally:
        gmsh.finalize()
    return str(file)


BODY, BASE = (2, [LOWER], "body"), (1, [0.0], "base")


@pytest.mark.parametrize("version", [2.2, 4.1])
@pytest.mark.parametrize("order", [1, 2])
def test_cells_in_two_groups_are_taken_once(version, order, tmp_path):
    groups = [BODY, (2, [LOWER, UPPER], "all"), BASE]
    mesh = mesh_from_gmsh(plates(tmp_path / "two.msh", groups, version, order))
    assert mesh.degree == order and set(mesh.names) == {"base"}
    assert volume(mesh) == pytest.approx(1.0, rel=1e-12)
    assert area(mesh, "base") == pytest.approx(1.0, rel=1e-12)


def test_facets_of_what_is_left_out(tmp_path):
    groups = [BODY, BASE, (1, [1.0], "top")]
    mesh = mesh_from_gmsh(plates(tmp_path / "left.msh", groups))
    assert set(mesh.names) == {"base"} and volume(mesh) == pytest.approx(0.5, rel=1e-12)
    refused(lambda: mesh.facets("top"), "facets = 'top'", "'base'")
    file = plates(tmp_path / "part.msh", [BODY, (1, [0.0, 1.0], "ends")])
    refused(lambda: mesh_from_gmsh(file), "file", "4 of the 8 elements of 'ends'", "no facets")


def test_facets_in_two_groups(tmp_path):
    file = plates(tmp_path / "clash.msh", [BODY, BASE, (1, [0.0, 0.25, 0.5], "outer")])
    refused(lambda: mesh_from_gmsh(file), "file", "'outer' and 'base'", "same facet", "one phys")
    mesh = mesh_from_gmsh(plates(tmp_path / "same.msh", [BODY, BASE, (1, [0.0], "floor")]))
    np.testing.assert_array_equal(mesh.facets("floor"), mesh.facets("base"))


def test_nodes_that_no_cell_has(tmp_path):
    script = tmp_path / "orphan.geo"
    script.write_text(
        "Point(1) = {0, 0, 0, 0.2}; Point(2) = {1, 0, 0, 0.2}; Point(3) = {0, 1, 0, 0.2};"
        "Point(9) = {5, 5, 1, 0.2};"
        "Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 1}; Curve Loop(1) = {1, 2, 3};"
        'Plane Surface(1) = {1}; Physical Surface("s") = {1}; Physical Curve("a") = {1};\n'
    )
    gmsh.initialize(["gmsh", "-v", "1"])
    try:
        gmsh.open(str(script))
        gmsh.model.mesh.generate(2)
        gmsh.option.setNumber("Mesh.SaveAll", 1)
        gmsh.write(str(tmp_path / "orphan.msh"))
    finally:
        gmsh.finalize()
    for file in (script, tmp_path / "orphan.msh"):
        mesh = mesh_from_gmsh(file)
        assert volume(mesh) == pytest.approx(0.5, rel=1e-12)
        assert mesh.mesh.geometry.x.max() == pytest.approx(1.0)


def test_one_name_for_facets_and_a_point(tmp_path):
    file = plates(tmp_path / "name.msh", [BODY, BASE, (0, [1], "base")])
    refused(lambda: mesh_from_gmsh(file), "file", "points['base']", "facets of this name")
    mesh = mesh_from_gmsh(plates(tmp_path / "other.msh", [BODY, BASE, (0, [1], "corner")]))
    assert set(mesh.points) == {"corner"}
    refused(lambda: name_points(mesh, {"base": (0, 0)}), "points['base']", "facets of this name")
    given = mesh.mesh, mesh.facet_tags, mesh.names
    refused(lambda: NamedMesh(*given, points={"base": (0, 0)}), "points['base']")
    refused(lambda: NamedMesh(*given, points={"corner": (0, 0, 0)}), "points['corner']")


def test_groups_without_a_name_have_their_number(tmp_path):
    groups = [BODY, (1, [0.0], ""), (1, [0.5], ""), (0, [1], ""), (0, [2], "corner")]
    mesh = mesh_from_gmsh(plates(tmp_path / "numbers.msh", groups))
    assert len(mesh.names) == 2 and all(name.isdigit() for name in mesh.names)
    assert [area(mesh, name) for name in mesh.names] == pytest.approx([1.0, 1.0])
    assert set(mesh.points) == {"corner"}
    number = max(mesh.names)
    groups += [(1, [0.25], number)]
    file = plates(tmp_path / "clash.msh", groups)
    refused(lambda: mesh_from_gmsh(file), "file", f"two physical groups '{number}'")


def test_an_open_session_stays_as_it_is(session, tmp_path):
    gmsh.option.setNumber("General.Verbosity", 0)
    gmsh.model.add("mine")
    gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
    gmsh.model.occ.synchronize()
    gmsh.onelab.set('[{"type": "number", "name": "k", "values": [0.5]}]')
    script = tmp_path / "mine.geo"
    script.write_text(
        'Mesh.ElementOrder = 2; Mesh.MeshSizeMax = 0.4; General.GraphicsFont = "Courier";'
        'DefineConstant[k = {0.25, Name "k"}]; If(k != 0.25) Error("k is %g", k); EndIf '
        "Point(1) = {0, 0, 0}; Point(2) = {1, 0, 0}; Point(3) = {0, 1, 0};"
        "Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 1}; Curve Loop(1) = {1, 2, 3};"
        'Plane Surface(1) = {1}; Physical Surface("s") = {1}; Physical Curve("a") = {1};'
    )
    names = "General.Verbosity", "Mesh.ElementOrder", "Mesh.MeshSizeMax"
    font = gmsh.option.getString("General.GraphicsFont")
    before = [gmsh.option.getNumber(name) for name in names]
    models = gmsh.model.list()
    assert mesh_from_gmsh(script).degree == 2 and mesh_from_gmsh("block.geo").degree == 1
    refused(lambda: mesh_from_gmsh("slab.geo", n=0), "gmsh says")
    assert gmsh.model.list() == models and gmsh.model.getCurrent() == "mine"
    assert gmsh.model.getEntities(2) == [(2, 1)]
    assert [gmsh.option.getNumber(name) for name in names] == before
    assert gmsh.option.getString("General.GraphicsFont") == font
    assert list(gmsh.onelab.getNumber("k")) == [0.5]


# -- facets inside the mesh --


def test_facets_inside_bear_nothing(tmp_path):
    groups = [BODY, (2, [UPPER], "upper"), (1, [0.5], "middle")]
    mesh = mesh_from_gmsh(plates(tmp_path / "inside.msh", groups))
    solid, floor = ElasticSolid(mesh, **ELASTIC), HalfSpace((0, 0.499), (0, 1))
    words = "facets = 'middle'", "4 of these 4 facets", "boundary"
    refused(lambda: Contact(solid, "middle", floor), *words)
    other = rectangle()
    refused(lambda: Contact(RigidSolid(other, mass=1.0), "base", (solid, "middle")), *words)
    assert len(ElasticSolid(mesh, **ELASTIC, fixed=["middle"]).fixed_unknowns) == 10


def test_facets_partly_inside_are_no_place_for_loads(tmp_path):
    groups = [BODY, (2, [UPPER], "upper"), (1, [0.0, 0.5], "mixed")]
    mesh = mesh_from_gmsh(plates(tmp_path / "mixed.msh", groups))
    words = "facets = 'mixed'", "4 of these 8 facets", "boundary"
    refused(lambda: ElasticSolid(mesh, **ELASTIC, tractions={"mixed": (0, 1.0)}), *words)
    refused(lambda: ElasticSolid(mesh, **ELASTIC, springs={"mixed": 1.0}), *words)
    refused(lambda: Contact(RigidSolid(mesh, mass=1.0), "mixed", HalfSpace((0, 0), (0, 1))), *words)


def test_tags_that_are_not_of_facets():
    mesh = name_facets(rectangle().mesh, {}).mesh
    for dim in (0, 2):
        few = np.arange(3, dtype=np.int32)
        tags = dolfinx.mesh.meshtags(mesh, dim, few, np.full(3, 7, np.int32))
        refused(lambda: NamedMesh(mesh, tags, {"a": 7}), "facet_tags", f"dimension {dim}", "1")  # noqa: B023
    far = np.array([3, 10**6], dtype=np.int32)
    tags = dolfinx.mesh.meshtags(mesh, 1, far, np.full(2, 7, np.int32))
    refused(lambda: NamedMesh(mesh, tags, {"a": 7}), "facet_tags", "1 of them")
    refused(lambda: NamedMesh(mesh, "tags", {"a": 7}), "facet_tags = 'tags'")


# -- two processes --

SCRIPT = """
import sys, traceback
sys.path.insert(0, {tests!r})
from mpi4py import MPI
from fenicsx_contact import Contact, HalfSpace, InputError, RigidSolid, mesh_from_gmsh
from test_mesh_files import area, volume
try:
    assert MPI.COMM_WORLD.size == 2
    for name, size in (("two", 1.0), ("left", 0.5)):
        mesh = mesh_from_gmsh({directory!r} + "/" + name + ".msh")
        cells = mesh.mesh.topology.index_map(2).size_local
        assert min(MPI.COMM_WORLD.allgather(cells)) > 0
        assert abs(volume(mesh) - size) < 1e-12 and abs(area(mesh, "base") - 1.0) < 1e-12
        Contact(RigidSolid(mesh, mass=1.0), "base", HalfSpace((0, 0), (0, 1)))
    for bad in ("clash", "part", "name", "inside"):
        try:
            mesh = mesh_from_gmsh({directory!r} + "/" + bad + ".msh")
            Contact(RigidSolid(mesh, mass=1.0), "middle", HalfSpace((0, 0), (0, 1)))
        except InputError as problem:
            assert bad == "inside" or "file" in str(problem)
            continue
        raise AssertionError("accepted " + bad)
except BaseException:
    traceback.print_exc()
    sys.stderr.flush()
    MPI.COMM_WORLD.Abort(1)
"""


@pytest.mark.second
@needs_mpirun
def test_two_processes(tmp_path):
    whole = 2, [LOWER, UPPER], "all"
    files = {
        "two": [BODY, whole, BASE],
        "left": [BODY, BASE, (1, [1.0], "top")],
        "clash": [BODY, BASE, (1, [0.0, 0.5], "outer")],
        "part": [BODY, (1, [0.0, 1.0], "ends")],
        "name": [BODY, BASE, (0, [1], "base")],
        "inside": [whole, (1, [0.5], "middle")],
    }
    for name, groups in files.items():
        plates(tmp_path / f"{name}.msh", groups)
    code = SCRIPT.format(tests=str(Path(__file__).parent), directory=str(tmp_path))
    output_of(mpirun(code, 2))
