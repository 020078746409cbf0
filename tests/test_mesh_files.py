# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes from files: shapes, names and orientation survive; bad files are refused by name."""

from __future__ import annotations

from pathlib import Path

import gmsh
import meshio
import numpy as np
import pytest
import ufl
from dolfinx import fem
from processes import mpirun, needs_mpirun, output_of

from fenicsx_contact import InputError, NamedMesh, mesh_from_file, mesh_from_gmsh
from fenicsx_contact.base import assembly
from fenicsx_contact.base.mesh_names import element_sets

MESHES = Path(__file__).parents[1] / "meshes"
SIZE = {"triangle": (2.0, 3.0), "quad": (2.0, 3.0), "tetra": (2.0, 3.0, 1.5)}
SIZE["hexahedron"] = SIZE["tetra"]
FACET = {"triangle": "line", "quad": "line", "tetra": "triangle", "hexahedron": "quad"}


def integral(expression, measure, mesh: NamedMesh) -> float:
    return assembly.assemble_scalar(fem.form(expression * measure), mesh.mesh.comm)


def volume(mesh: NamedMesh) -> float:
    one = fem.Constant(mesh.mesh, 1.0)
    return integral(one, ufl.Measure("dx", domain=mesh.mesh), mesh)


def area(mesh: NamedMesh, name: str) -> float:
    mesh.facets(name)
    ds = ufl.Measure("ds", domain=mesh.mesh, subdomain_data=mesh.facet_tags)
    return integral(fem.Constant(mesh.mesh, 1.0), ds(mesh.names[name]), mesh)


def flux(mesh: NamedMesh, name: str) -> float:
    """Integral of x.n over the named facets."""
    ds = ufl.Measure("ds", domain=mesh.mesh, subdomain_data=mesh.facet_tags)
    x, n = ufl.SpatialCoordinate(mesh.mesh), ufl.FacetNormal(mesh.mesh)
    return integral(ufl.dot(x, n), ds(mesh.names[name]), mesh)


def block(kind: str, stray: int = 2, z: float = 0.0) -> meshio.Mesh:
    """A distorted block [0, SIZE] in meshio's orders, 3 cells along each side; facets "low" and
    "high" at the ends of the last axis; points that no cell uses come first."""
    size = SIZE[kind]
    d, n = len(size), 3
    grid = np.stack(np.meshgrid(*[np.arange(n + 1)] * d, indexing="ij"), axis=-1).reshape(-1, d)
    inside = ((grid > 0) & (grid < n)).all(axis=1)[:, None]
    shift = 0.15 * np.sin(1.0 + 3.0 * grid + 2.0 * grid[:, ::-1])
    points = (grid + inside * shift) / n * np.array(size)
    number = {tuple(g): i + stray for i, g in enumerate(grid)}

    def corners(origin, axes):
        """The square or cube of a lattice in VTK's order."""
        steps = [np.zeros(d, int), axes[0], axes[0] + axes[1], axes[1]]
        if len(axes) == 3:
            steps += [step + axes[2] for step in steps]
        return [number[tuple(np.array(origin) + step)] for step in steps]

    unit = np.eye(d, dtype=int)
    boxes = np.array([corners(o, unit) for o in np.ndindex(*[n] * d)])
    if kind == "triangle":
        boxes = boxes[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    if kind == "tetra":
        paths = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
        boxes = boxes[:, paths].reshape(-1, 4)
    cells = [(kind, boxes)]
    for last in (0, n):
        origins = [(*o, last) for o in np.ndindex(*[n] * (d - 1))]
        if d == 2:
            facets = np.array([[number[o], number[o[0] + 1, o[1]]] for o in origins])
        else:
            facets = np.array([corners(o, unit[:2]) for o in origins])
        if kind == "tetra":
            facets = facets[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
        cells.append((FACET[kind], facets))
    sets = {
        name: [np.arange(len(c) if i == j else 0) for j, (_, c) in enumerate(cells)]
        for i, name in enumerate(("body", "low", "high"))
    }
    points = np.vstack([np.full((stray, d), 7e3), points])
    if d == 2:
        points = np.column_stack([points, np.full(len(points), z)])
    return meshio.Mesh(points, cells, cell_sets=sets)


def numbered(mesh: meshio.Mesh) -> meshio.Mesh:
    """The same, its parts told apart by an integer instead of names."""
    part = [np.full(len(cells.data), i) for i, cells in enumerate(mesh.cells)]
    return meshio.Mesh(mesh.points, mesh.cells, cell_data={"part": part})


def check_block(mesh: NamedMesh, kind: str) -> None:
    size = SIZE[kind]
    end = np.prod(size[:-1])
    assert mesh.dim == len(size) and set(mesh.names) == {"low", "high"}
    assert volume(mesh) == pytest.approx(np.prod(size), rel=1e-12)
    assert area(mesh, "low") == pytest.approx(end, rel=1e-12)
    assert area(mesh, "high") == pytest.approx(end, rel=1e-12)
    assert flux(mesh, "high") == pytest.approx(end * size[-1], rel=1e-12)
    assert flux(mesh, "low") == pytest.approx(0, abs=1e-12)
    points, _, _ = mesh.boundary("high")
    np.testing.assert_allclose(points[:, -1], size[-1], rtol=1e-14)


def save(directory: Path, mesh: meshio.Mesh, ending: str, **options) -> Path:
    file = directory / f"mesh.{ending}"
    mesh.write(file, **options)
    return file


@pytest.mark.parametrize("kind", SIZE)
def test_abaqus_file_with_element_sets(kind, tmp_path):
    mesh = mesh_from_file(save(tmp_path, block(kind), "inp"))
    check_block(mesh, kind)


@pytest.mark.parametrize("kind", SIZE)
@pytest.mark.parametrize(
    ("ending", "options"), [("vtk", {}), ("vtu", {}), ("xdmf", {"data_format": "XML"})]
)
def test_file_with_integer_data(kind, ending, options, tmp_path):
    if ending == "xdmf":
        pytest.importorskip("h5py")  # meshio's reader wants it
    file = save(tmp_path, numbered(block(kind)), ending, **options)
    check_block(mesh_from_file(file, facets={"low": 1, "high": 2}), kind)
    assert mesh_from_file(file).names == {}


@pytest.mark.parametrize("version", [2.2, 4.1])
@pytest.mark.parametrize("binary", [0, 1])
@pytest.mark.parametrize(
    ("script", "others"),
    [
        ("block.geo", {"quadrilaterals": 0}),
        ("block.geo", {"quadrilaterals": 1}),
        ("box.geo", {"hexahedra": 0}),
        ("box.geo", {"hexahedra": 1}),
    ],
)
def test_gmsh_file(version, binary, script, others, tmp_path):
    file = tmp_path / "mesh.msh"
    declared = "".join(f"{name} = {value};\n" for name, value in others.items())
    (tmp_path / "some.geo").write_text(f'{declared}Include "{MESHES / script}";\n')
    gmsh.initialize(["gmsh", "-v", "1"])
    try:
        gmsh.open(str(tmp_path / "some.geo"))
        gmsh.model.mesh.generate(gmsh.model.getDimension())
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.Binary", binary)
        gmsh.write(str(file))
    finally:
        gmsh.finalize()
    mesh, same = mesh_from_file(file), mesh_from_gmsh(MESHES / script, **others)
    assert set(mesh.names) == set(same.names) and mesh.dim == same.dim
    assert volume(mesh) == pytest.approx(volume(same), rel=1e-12)
    for name in same.names:
        assert area(mesh, name) == pytest.approx(area(same, name), rel=1e-12)
        assert flux(mesh, name) == pytest.approx(flux(same, name), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("version", [2.2, 4.1])
def test_names_that_meshio_loses(version, tmp_path):
    """Of a surface and a curve of one name it knows the first; they were taken for no facets."""
    file = tmp_path / "mesh.msh"
    gmsh.initialize(["gmsh", "-v", "1"])
    try:
        gmsh.model.occ.addRectangle(0, 0, 0, 2, 1)
        gmsh.model.occ.synchronize()
        for dim, tag, name in ((2, 1, "left"), (1, 1, "base"), (1, 3, "left")):
            group = gmsh.model.addPhysicalGroup(dim, [tag])
            gmsh.model.setPhysicalName(dim, group, name)
        gmsh.model.mesh.generate(2)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.write(str(file))
    finally:
        gmsh.finalize()
    refused(lambda: mesh_from_file(file), str(file), "loses its physical names 'left'", "_gmsh")
    assert set(mesh_from_gmsh(file).names) == {"base", "left"}
    assert set(mesh_from_file(file, facets={"low": "base"}).names) == {"low"}


@pytest.mark.parametrize("kind", SIZE)
def test_cells_that_are_all_reversed(kind, tmp_path):
    mesh = block(kind)
    turned = {"triangle": [0, 2, 1], "quad": [0, 3, 2, 1], "tetra": [0, 2, 1, 3]}
    turned["hexahedron"] = [4, 5, 6, 7, 0, 1, 2, 3]
    cells = [(kind, mesh.cells[0].data[:, turned[kind]]), *mesh.cells[1:]]
    mesh = meshio.Mesh(mesh.points, cells, cell_sets=mesh.cell_sets)
    check_block(mesh_from_file(save(tmp_path, mesh, "inp")), kind)


def test_plane_mesh_at_some_z(tmp_path):
    mesh = block("quad", stray=0, z=-4.5)
    check_block(mesh_from_file(save(tmp_path, mesh, "inp")), "quad")


def test_names_chosen_and_renamed(tmp_path):
    file = save(tmp_path, block("tetra"), "inp")
    mesh = mesh_from_file(file, facets={"roof": "high"})
    assert set(mesh.names) == {"roof"}
    np.testing.assert_allclose(mesh.boundary("roof")[0][:, 2], 1.5)


@pytest.mark.parametrize("kind", SIZE)
def test_sets_of_points(kind, tmp_path):
    """Boundary facets whose vertices are all in the set, as in Abaqus' NSET."""
    mesh = block(kind)
    nodes = {name: np.unique(mesh.cells[i].data) for i, name in enumerate(("", "low", "high"))}
    del nodes[""]
    bare = meshio.Mesh(mesh.points, mesh.cells[:1], point_sets=nodes)
    file = save(tmp_path, bare, "inp")
    assert mesh_from_file(file).names == {}
    check_block(mesh_from_file(file, facets={"low": "low", "high": "high"}), kind)


def test_one_facet_under_two_names(tmp_path):
    mesh = block("triangle")
    mesh.cell_sets["roof"] = mesh.cell_sets["high"]
    both = mesh_from_file(save(tmp_path, mesh, "inp"))
    np.testing.assert_array_equal(both.facets("roof"), both.facets("high"))
    assert len(both.facets("low")) == 3
    mesh.cell_sets["part"] = [np.arange(n) for n in (0, 0, 2)]
    file = save(tmp_path, mesh, "inp")
    refused(lambda: mesh_from_file(file), "facets", "'part'", "same facet")
    assert len(mesh_from_file(file, facets={"a": "part"}).facets("a")) == 2


def test_set_of_sets(tmp_path):
    """meshio reads but the first of the names on a line: better no set than a part of it."""
    file = save(tmp_path, block("tetra"), "inp")
    file.write_text(file.read_text() + "*ELSET, ELSET=ends\nlow, high\n")
    assert set(mesh_from_file(file).names) == {"low", "high"}
    refused(lambda: mesh_from_file(file, facets={"a": "ends"}), "'ends'", "'high', 'low'")


def two_bodies() -> meshio.Mesh:
    """Triangles and quadrilaterals side by side, in one file."""
    a, b = block("triangle"), block("quad")
    shift = len(a.points)
    cells = [*a.cells, *((c.type, c.data + shift) for c in b.cells)]
    sets = {}
    for mesh, names in ((a, ("soft", "a low", "a high")), (b, ("hard", "b low", "b high"))):
        for i, name in enumerate(names):
            k = i + 3 * (mesh is b)
            lengths = [len(mesh.cells[i].data) if j == k else 0 for j in range(6)]
            sets[name] = [np.arange(length) for length in lengths]
    return meshio.Mesh(np.vstack([a.points, b.points + np.array([9, 0, 0])]), cells, cell_sets=sets)


def test_one_solid_of_several(tmp_path):
    file = save(tmp_path, two_bodies(), "inp")
    soft, hard = mesh_from_file(file, solid="soft"), mesh_from_file(file, solid="hard")
    assert set(soft.names) == {"a low", "a high"} and set(hard.names) == {"b low", "b high"}
    assert volume(soft) == pytest.approx(6) and volume(hard) == pytest.approx(6)
    assert hard.mesh.geometry.x[:, 0].min() == pytest.approx(9)
    refused(lambda: mesh_from_file(file), "quad, triangle", "of one type", "solid")
    refused(lambda: mesh_from_file(file, solid="body"), "solid = 'body'", "'hard', 'soft'")
    refused(lambda: mesh_from_file(file, solid="soft", facets={"x": "b low"}), "'x' has no facet")


def test_groups_of_med():
    """An element of MED is in one family, which has several groups."""
    mesh = numbered(block("quad"))
    mesh.cell_data = {"cell_tags": [-np.asarray(values) for values in mesh.cell_data["part"]]}
    mesh.cell_tags = {-1: ["low", "ends"], -2: ["high", "ends"]}
    sets = element_sets(mesh, 1)
    assert {name: [len(b) for b in blocks] for name, blocks in sets.items()} == {
        "low": [0, 3, 0],
        "high": [0, 0, 3],
        "ends": [0, 3, 3],
    }


def test_a_script_is_no_mesh():
    refused(lambda: mesh_from_file("block.geo"), "file = 'block.geo'", "mesh_from_gmsh")


# -- bad files --


def refused(make, *words):
    with pytest.raises(InputError) as caught:
        make()
    for word in words:
        assert word in str(caught.value), f"{word!r} not in {caught.value}"


SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])


@pytest.mark.parametrize(
    ("points", "cells", "words"),
    [
        (SQUARE, [("line", [[0, 1], [1, 2]])], ["no cells of a solid", "hexahedra"]),
        (SQUARE, [("quad", [[0, 1, 3, 2]])], ["1 of its 1 cells", "turned over", "0.5"]),
        (SQUARE, [("quad", [[0, 1, 2, 2]])], ["1 of its 1 cells", "without volume"]),
        (SQUARE, [("triangle", [[0, 1, 2], [0, 2, 0]])], ["1 of its 2 cells"]),
        (SQUARE, [("triangle", [[0, 1, 2]]), ("quad", [[0, 1, 2, 3]])], ["quad, triangle"]),
        (SQUARE + np.eye(4, 3)[:, [1, 2, 0]], [("triangle", [[0, 1, 2]])], ["in 3D"]),
        (SQUARE * [np.nan, 1, 1], [("triangle", [[0, 1, 2]])], ["not finite"]),
        (
            np.vstack([SQUARE, SQUARE + np.array([2, 0, 0])]),
            [("quad8", [[0, 1, 2, 3, 4, 5, 6, 7]])],
            ["quad8", "quadrilaterals (4 or 9)"],
        ),
        (
            np.vstack([SQUARE, SQUARE + np.array([0, 0, 1])]),
            [("wedge", [[0, 1, 2, 4, 5, 6]])],
            ["wedge", "hexahedra"],
        ),
    ],
    ids=["line", "bow tie", "collapsed", "flat", "mixed", "shell", "nan", "eight nodes", "wedge"],
)
def test_cells_that_are_refused(points, cells, words, tmp_path):
    cells = [(kind, np.array(nodes)) for kind, nodes in cells]
    file = save(tmp_path, meshio.Mesh(points, cells), "vtu", binary=False)
    refused(lambda: mesh_from_file(file), "file", str(file), *words)


def test_facet_elements_that_lie_elsewhere(tmp_path):
    mesh = block("quad")
    mesh.cells[1].data[0] = mesh.cells[0].data[0][[0, 2]]
    file = save(tmp_path, mesh, "inp")
    refused(lambda: mesh_from_file(file), "1 of the 3 elements of 'low'", "no facets")


def test_names_and_values_that_are_not_there(tmp_path):
    named, plain = block("quad"), numbered(block("quad"))
    named.point_sets = {"corner": np.array([2])}
    file = save(tmp_path, named, "inp")
    refused(lambda: mesh_from_file(file, facets={"a": "roof"}), "'roof'", "'low'", "'corner'")
    refused(lambda: mesh_from_file(file, facets={"a": "corner"}), "'a' has no facet")
    refused(lambda: mesh_from_file(file, facets={"a": 1}), "data = None", "nothing")
    refused(lambda: mesh_from_file(file, facets=["low"]), "facets = ['low']")
    refused(lambda: mesh_from_file(file, facets={"a": 1.5}), "facets['a'] = 1.5")
    plain.cell_data["other"] = plain.cell_data["part"]
    file = save(tmp_path, plain, "vtu")
    refused(lambda: mesh_from_file(file, facets={"a": 1}), "data = None", "'other', 'part'")
    refused(lambda: mesh_from_file(file, facets={"a": 1}, data="p"), "data = 'p'", "'part'")
    refused(lambda: mesh_from_file(file, facets={"a": 7}, data="part"), "'a' = 7", "no facet")
    assert len(mesh_from_file(file, facets={"a": 1}, data="part").facets("a")) == 3


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("bad.vtu", "<VTKFile>"),
        ("bad.inp", "*NODE\n1, a, b\n"),
        ("bad.msh", "hello"),
        ("bad.xyz", "hello"),
        ("empty.vtk", ""),
    ],
)
def test_files_that_cannot_be_read(name, text, tmp_path, capfd):
    file = tmp_path / name
    file.write_text(text)
    refused(lambda: mesh_from_file(file), str(file), "meshio cannot read it: ")
    assert capfd.readouterr() == ("", "")
    refused(lambda: mesh_from_file("nowhere.vtu"), "file = 'nowhere.vtu'", "no such file")


# -- two processes --

SCRIPT = """
import sys, traceback
sys.path.insert(0, {tests!r})
from mpi4py import MPI
from fenicsx_contact import InputError, mesh_from_file
from test_mesh_files import check_block
try:
    assert MPI.COMM_WORLD.size == 2
    for kind in ("triangle", "quad", "tetra", "hexahedron"):
        mesh = mesh_from_file({directory!r} + "/" + kind + ".inp")
        cells = mesh.mesh.topology.index_map(mesh.dim).size_local
        assert min(MPI.COMM_WORLD.allgather(cells)) > 0
        check_block(mesh, kind)
    for bad in ("nowhere.inp", "clash.inp"):
        try:
            mesh_from_file({directory!r} + "/" + bad)
        except InputError:
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
    for kind in SIZE:
        block(kind).write(tmp_path / f"{kind}.inp")
    mesh = block("quad")
    mesh.cell_sets["part"] = [np.arange(n) for n in (0, 0, 2)]
    mesh.write(tmp_path / "clash.inp")
    code = SCRIPT.format(tests=str(Path(__file__).parent), directory=str(tmp_path))
    output_of(mpirun(code, 2))
