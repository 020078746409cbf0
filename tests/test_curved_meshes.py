# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes of second degree: bodies that are round have round cells, and what presses is even."""

import dolfinx
import gmsh
import matplotlib.pyplot as plt
import meshio
import numpy as np
import pytest
import ufl
from mpi4py import MPI
from processes import mpirun, needs_mpirun, output_of
from scenes import FLOOR, FLOOR_3D, half_cylinder, rates, total_energy

from fenicsx_contact import (
    Circle,
    Compliance,
    Contact,
    Discrete,
    ElasticSolid,
    EnergyMomentum,
    GeneralisedAlpha,
    HalfSpace,
    HyperelasticSolid,
    InputError,
    LevelSet,
    NamedMesh,
    Newton,
    QuasiStatic,
    RigidSolid,
    Scene,
    Sphere,
    ThetaScheme,
    mesh_from_file,
    mesh_from_gmsh,
    name_facets,
    neo_hookean,
)
from fenicsx_contact.base import compat
from fenicsx_contact.base.cells import for_meshio
from fenicsx_contact.output import pictures

E, NU = 100.0, 0.3
LAME = E * NU / (1 + NU) / (1 - 2 * NU), E / 2 / (1 + NU)
PLANE, SPACE = ["triangle", "quadrilateral"], ["tetrahedron", "hexahedron"]
DIM = {cell: 2 + (cell in SPACE) for cell in PLANE + SPACE}
AXES = "xyz"


def lattice(counts, cell, degree, comm=MPI.COMM_SELF):
    """The nodes (n, d) and cells of a unit box, of a degree."""
    d = len(counts)
    make = dolfinx.mesh.create_rectangle if d == 2 else dolfinx.mesh.create_box
    mesh = make(comm, [[0.0] * d, [1.0] * d], counts, getattr(dolfinx.mesh.CellType, cell))
    space = compat.lagrange_space(mesh, degree)
    return space.tabulate_dof_coordinates()[:, :d].copy(), compat.cell_dofs(space)


def ring(n, cell, degree, inner=1.0, outer=2.0):
    """A quarter of a ring, or an eighth of a shell: three patches of n x n facets."""
    d = DIM[cell]
    t, cells = lattice([max(2, n // 2), *[n] * (d - 1)], cell, degree)
    if d == 2:
        way = np.stack([np.cos(np.pi / 2 * t[:, 1]), np.sin(np.pi / 2 * t[:, 1])], axis=1)
    else:
        way = np.column_stack([np.ones(len(t)), np.tan(np.pi / 4 * t[:, 1:])])
        way /= np.linalg.norm(way, axis=1)[:, None]
    x = (inner + (outer - inner) * t[:, :1]) * way
    patches = [np.roll(x, k, axis=1) for k in range(1 if d == 2 else 3)]
    every = np.round(np.concatenate(patches), 12) + 0.0
    x, number = np.unique(every, axis=0, return_inverse=True)
    cells = number.ravel()[np.concatenate([cells + k * len(t) for k in range(len(patches))])]
    sides = {
        "inner": lambda x: np.isclose(np.linalg.norm(x, axis=0), inner),
        "outer": lambda x: np.isclose(np.linalg.norm(x, axis=0), outer),
        **{AXES[i]: (lambda x, i=i: np.isclose(x[i], 0)) for i in range(d)},
    }
    return name_facets(compat.create_mesh(MPI.COMM_SELF, cells, x, cell, degree), sides)


def elastic(mesh, **others):
    return ElasticSolid(mesh, youngs_modulus=E, poisson_ratio=NU, density=1.0, degree=2, **others)


def symmetric(mesh):
    """Rollers on the planes of symmetry."""
    d = mesh.dim
    return {AXES[i]: tuple(0.0 if i == j else None for j in range(d)) for i in range(d)}


def still(solids, contact, tolerance=1e-13):
    """The contact at rest after one load."""
    scene = Scene(solids, [contact], QuasiStatic(), Newton(tolerance=tolerance))
    history = scene.run(until=1, dt=1)
    assert history.finished, history.reason
    return history


# -- shapes --


@pytest.mark.parametrize("cell", PLANE + SPACE)
def test_mass_and_inertia(cell):
    """Of fourth order; of straight cells of second."""
    exact = {2: (3 * np.pi / 4, 15 * np.pi / 8), 3: (7 * np.pi / 6, 31 * np.pi / 10)}[DIM[cell]]

    def errors(degree, n):
        """Of the mass and of its polar moment about the origin."""
        body = RigidSolid(ring(n, cell, degree), density=1.0)
        polar = np.trace(body.inertia) / (body.dim - 1) + body.mass * (body.centre**2).sum()
        return [abs(body.mass / exact[0] - 1), abs(polar / exact[1] - 1)]

    for degree, order in ((1, 2), (2, 4)):
        found = np.array([errors(degree, n) for n in (2, 4, 8)])
        assert all(abs(rates(each)[-1] - order) < 0.1 for each in found.T), found
    assert found[-1].max() < 1e-5


DISC = """
SetFactory("OpenCASCADE");
Disk(1) = {0, 0, 0, 1, 1};
Mesh.ElementOrder = %s;
Mesh.MeshSizeMax = 0.4;
Physical Surface("disc") = {1};
Physical Curve("rim") = Boundary{ Surface{1}; };
%s
"""
BALL = """
SetFactory("OpenCASCADE");
Sphere(1) = {0, 0, 0, 1};
Mesh.ElementOrder = %s;
Mesh.MeshSizeMax = 0.4;
Physical Volume("ball") = {1};
Physical Surface("rim") = Boundary{ Volume{1}; };
%s
"""
RECOMBINED = "Recombine Surface{1};\n"


def written(tmp_path, text):
    """A script, and the mesh that gmsh makes of it, as files."""
    script = tmp_path / "body.geo"
    script.write_text(text)
    gmsh.initialize(["gmsh", "-v", "1"])
    gmsh.open(str(script))
    gmsh.model.mesh.generate(gmsh.model.getDimension())
    gmsh.write(str(tmp_path / "body.msh"))
    gmsh.finalize()
    return script, tmp_path / "body.msh"


@pytest.mark.parametrize(
    "text",
    [DISC % (2, ""), DISC % (2, RECOMBINED), BALL % (2, "")],
    ids=["triangles", "quadrilaterals", "tetrahedra"],
)
def test_from_gmsh_from_files_and_from_dolfinx(text, tmp_path):
    """The same body, round within 1e-3, and written to a file and read from it once more."""
    script, file = written(tmp_path, text)
    first = mesh_from_gmsh(script)
    vtu = tmp_path / "body.vtu"
    size = {2: np.pi, 3: 4 * np.pi / 3}[first.dim]
    meshes = [
        first,
        mesh_from_gmsh(file),
        mesh_from_file(file),
        NamedMesh(first.mesh, first.facet_tags, first.names),
    ]
    read = meshio.read(file)
    cells = [block for block in read.cells if block.dim == first.dim]
    meshio.Mesh(read.points, cells).write(vtu)
    assert mesh_from_file(vtu).degree == 2
    for mesh in meshes:
        assert mesh.degree == 2
        assert RigidSolid(mesh, density=1.0).mass == pytest.approx(size, rel=1e-3)
        for degree in (1, 2):
            points, facets, _ = mesh.boundary("rim", degree)
            np.testing.assert_allclose(np.linalg.norm(points, axis=1), 1, rtol=1e-9)
            np.testing.assert_allclose(points, first.boundary("rim", degree)[0], atol=1e-12)
            assert len(facets) == len(first.facets("rim")) * (2 ** (mesh.dim - 1)) ** (2 - degree)


# -- deformable solids before obstacles --


def crooked(cell, periodic):
    """A unit box whose nodes of second degree stand anywhere, those of a side on this side, and on
    sides that are one where they were."""
    d = DIM[cell]
    x, cells = lattice([3] * d, cell, 2)
    moved = np.random.default_rng(3).uniform(-0.02, 0.02, x.shape)
    outside = np.isclose(x, 0) | np.isclose(x, 1)
    moved[outside] = 0.0
    if periodic:
        moved[outside[:, :-1].any(axis=1)] = 0.0
    sides = {AXES[i]: (lambda x, i=i: np.isclose(x[i], 0)) for i in range(d)}
    sides |= {f"{AXES[i]} end": (lambda x, i=i: np.isclose(x[i], 1)) for i in range(d)}
    return name_facets(compat.create_mesh(MPI.COMM_SELF, cells, x + moved, cell, 2), sides)


@pytest.mark.second
@pytest.mark.parametrize("cell", PLANE + SPACE)
@pytest.mark.parametrize("periodic", [False, True], ids=["", "periodic"])
def test_patch(cell, periodic):
    """On a flat base, its facets crooked within it, what presses is even to round-off, and what
    drags, too, where its sides are one."""
    mesh = crooked(cell, periodic)
    *along, base = AXES[: mesh.dim]
    load = [1e-4 * periodic, *[0.0] * (mesh.dim - 2), -1e-3]
    held = {} if periodic else {side: symmetric(mesh)[side] for side in along}
    pairs = [(side, f"{side} end") for side in along] if periodic else []
    top = {"tractions": {f"{base} end": load}}
    solid = elastic(mesh, prescribed=held, periodic=pairs, **top)
    contact = Contact(solid, base, FLOOR if mesh.dim == 2 else FLOOR_3D, "gap", 0.3 * periodic)
    still([solid], contact)
    assert contact.surface.area.sum() == pytest.approx(1.0, rel=1e-12)
    np.testing.assert_allclose(contact.pressure, 1e-3, rtol=1e-9)
    if periodic:
        np.testing.assert_allclose(contact.friction_traction[:, 0], -1e-4, rtol=1e-9)


def shrunk(n, cell, degree, way=1e-2):
    """A ring or a shell within a round wall that shrinks: the error of its pressure in L2, after
    Lame."""
    mesh = ring(n, cell, degree)
    d, wall = mesh.dim, lambda x, t: 2.0 - way * t - ufl.sqrt(ufl.dot(x, x))
    solid = elastic(mesh, prescribed=symmetric(mesh))
    contact = Contact(solid, "outer", LevelSet(wall, dim=d), "gap")
    still([solid], contact)
    off = contact.pressure / lame_pressure(d, 1.0, 2.0, way=way) - 1
    return float(np.sqrt(contact.surface.area @ off**2 / contact.surface.area.sum()))


def lame_pressure(d, a, b, way=None, load=None, at=None):
    """Of a ring or shell a < r < b, free inside, the pressure at r, by u = A r + B/r^(d - 1)."""
    k, g = d * LAME[0] + 2 * LAME[1], 2 * (d - 1) * LAME[1]
    outer = [b, b ** (1 - d)] if load is None else [k, -g / b**d]
    given = -way if load is None else -load
    A, B = np.linalg.solve([[k, -g / a**d], outer], [0.0, given])
    return g * B / (at or b) ** d - k * A


def orders(counts, errors):
    """Of convergence, by numbers of facets."""
    return np.diff(np.log(errors)) / -np.diff(np.log(counts))


@pytest.mark.parametrize("cell", PLANE + SPACE)
def test_even_pressure_on_a_round_body(cell):
    """Of second order. In the plane straight facets bear by their corners, not by their middles,
    which do not reach the wall: what presses is off by more than it is."""
    counts = (4, 8) if cell in PLANE else (2, 3)
    found = [shrunk(n, cell, 2) for n in counts]
    assert orders(counts, found).min() > 1.8, found
    assert found[-1] < (2e-3 if cell in PLANE else 0.025)
    if cell in PLANE:
        assert shrunk(counts[-1], cell, 1) > 1


def test_hertz():
    """Half a cylinder of 9 facets over half the contact: within four fifths of it pressures are
    within 0.3 %; of straight cells on the same corners they are off by 7 %."""

    def error(order):
        contact, hertz = half_cylinder(0.005, order)
        x = contact.surface.points[:, 0]
        inside = np.abs(x) < 0.8 * hertz.half_width
        return float(np.abs(contact.pressure[inside] / hertz.pressure(x[inside]) - 1).max())

    assert error(2) < 0.003
    assert error(1) > 0.06


def towards(d):
    """The middle direction of a ring or a shell."""
    return np.ones(d) / np.sqrt(d)


LAWS = {
    "velocity": "velocity",
    "printed": "printed",
    "gap": "gap",
    "lagrange": "lagrange",
    "discrete": Discrete(1e4),
    "compliance": Compliance(1e6, tangential_stiffness=1e6),
}


def thrown(law, cell="triangle", material="linear", drum=False, **scene):
    """A quarter of a ring, or an eighth of a shell, strikes a wall or a drum, round side first."""
    mesh = ring(2, cell, 2, 0.1, 0.2)
    d, way = mesh.dim, towards(mesh.dim)
    common = {"density": 10.0, "degree": 2, "velocity": way + 0.3 * np.eye(d)[0], "name": "s"}
    if material == "linear":
        solid = ElasticSolid(mesh, youngs_modulus=1e5, poisson_ratio=NU, **common)
    else:
        solid = HyperelasticSolid(mesh, energy=neo_hookean(1e5, NU), **common)
    place = (0.2005 if d == 2 else 0.206) * way
    round_one = Circle if d == 2 else Sphere
    wall = round_one(place + way, 1.0) if drum else HalfSpace(place, -way)
    contact = Contact(
        solid, "outer", wall, LAWS[law], 0.0 if material != "linear" else 0.2, name="c"
    )
    return Scene([solid], [contact], **scene)


KINDS = {
    "triangles": {},
    "quadrilaterals": {"cell": "quadrilateral"},
    "neo-Hookean": {"material": "neo-Hookean", "geometry": "newton"},
    "on a drum": {"drum": True},
    "tetrahedra": {"cell": "tetrahedron"},
    "hexahedra on a drum": {"cell": "hexahedron", "drum": True},
    "generalised alpha": {"scheme": GeneralisedAlpha(0.8)},
    "backward Euler": {"scheme": ThetaScheme(1.0)},
    "energy and momentum": {"material": "neo-Hookean", "scheme": EnergyMomentum()},
}
#: Every law, every kind by one of velocities, some by one of positions.
EVERY = [
    *((law, "triangles") for law in LAWS),
    *(("velocity", kind) for kind in KINDS if kind != "triangles"),
    *(("gap", kind) for kind in ("on a drum", "hexahedra on a drum", "energy and momentum")),
]


@pytest.mark.second
@pytest.mark.parametrize(("law", "kind"), EVERY)
def test_thrown(law, kind):
    """Forces are those of the momentum, energy is not made."""
    scene = thrown(law, **KINDS[kind])
    (solid,), start = scene.solids, scene.solids[0].mean(scene.solids[0].velocity)
    history = scene.run(until=6e-3 if solid.dim == 2 else 1.2e-2, dt=1e-4)
    assert history.finished, history.reason
    gained = solid.mass * (solid.mean(solid.velocity) - start)
    np.testing.assert_allclose(history.impulse("c")[-1], gained, atol=1e-9 * solid.mass)
    assert -gained @ towards(solid.dim) > 0.5 * solid.mass
    energy = total_energy(history)
    assert energy.max() < energy[0] * (1 + 1e-9)


@pytest.mark.parametrize("cell", ["triangle", "hexahedron"])
def test_a_run_goes_on_where_it_stopped(cell, tmp_path):
    """To the same bits, with curved cells written, none of them turned over."""
    whole = thrown("velocity", cell).run(8e-4, 1e-4)
    thrown("velocity", cell).run(4e-4, 1e-4, directory=tmp_path, fields_every=4)
    again = {"directory": tmp_path, "fields_every": 4, "resume": True}
    resumed = thrown("velocity", cell).run(8e-4, 1e-4, **again)
    for column in whole.columns:
        np.testing.assert_array_equal(resumed[column], whole[column], column)
    files = sorted((tmp_path / "fields").glob("s_*.vtu"))
    last = meshio.read(files[-1])
    (block,) = last.cells
    assert len(files) == 3 and block.type == {"triangle": "triangle6"}.get(cell, "hexahedron27")
    solid = thrown("velocity", cell).solids[0]
    drawn = last.points[:, : solid.dim]
    np.testing.assert_array_equal(drawn, solid.mesh.mesh.geometry.x[:, : solid.dim])
    start = 0.3 * np.eye(3)[0]
    start[: solid.dim] += towards(solid.dim)
    np.testing.assert_allclose(
        meshio.read(files[0]).point_data["velocity"], np.tile(start, (len(drawn), 1))
    )
    again = mesh_from_file(files[-1])
    assert RigidSolid(again, density=10.0).mass == pytest.approx(solid.mass, rel=1e-9)
    surface = meshio.read(tmp_path / "fields" / "c_000000_0.vtu")
    np.testing.assert_allclose(surface.point_data["displacement"], 0, atol=1e-15)


@pytest.mark.second
@pytest.mark.parametrize("cell", PLANE + SPACE)
def test_pictures(cell, tmp_path):
    """Curved cells are drawn so, with edges of their own."""
    pytest.importorskip("pyvista")
    thrown("velocity", cell).run(1e-4, 1e-4, directory=tmp_path, fields_every=1)
    path = pictures.animate(tmp_path / "fields" / "s.pvd", tmp_path / "s.gif")
    assert plt.imread(path.with_suffix(".png"))[..., :3].min() < 0.1  # the black edges
    mesh = pictures.frames(tmp_path / "fields" / "s.pvd")[1](0)
    edges, topology = pictures._edges(mesh), ring(2, cell, 2).mesh.topology
    topology.create_entities(1)
    assert edges.n_cells == topology.index_map(1).size_local

    def round_one(drawn):
        """How many points of it are on the rim: straight ones would have none but nodes."""
        return np.isclose(np.linalg.norm(drawn.points, axis=1), 0.2, rtol=1e-3).sum()

    assert round_one(pictures._pieces(mesh)) > 3 * round_one(mesh)
    assert round_one(pictures._pieces(edges)) > 3 * round_one(mesh)


# -- two solids --


def fitted(counts, cell, degree):
    """A ring or a shell 2 < r < 3 about one 1 < r < 2, pressed from outside: the error of the
    pressure between them."""
    inner, outer = (ring(n, cell, degree, a, a + 1.0) for n, a in zip(counts, (1.0, 2.0)))
    x = ufl.SpatialCoordinate(outer.mesh)
    load = -0.1 / ufl.sqrt(ufl.dot(x, x)) * x
    one = elastic(inner, prescribed=symmetric(inner), name="inner")
    other = elastic(outer, prescribed=symmetric(outer), tractions={"outer": load}, name="outer")
    contact = Contact(one, "outer", (other, "inner"), "gap")
    still([one, other], contact, 1e-12)
    off = contact.pressure / lame_pressure(inner.dim, 1.0, 3.0, load=0.1, at=2.0) - 1
    return float(np.sqrt(contact.surface.area @ off**2 / contact.surface.area.sum()))


@pytest.mark.parametrize("cell", [*PLANE, pytest.param("tetrahedron", marks=pytest.mark.second)])
def test_two_round_solids_whose_meshes_do_not_match(cell):
    """Of second order. Straight facets have gaps where there are none, which have to be closed."""
    counts = [(4, 6), (8, 12)] if cell in PLANE else [(3, 4), (4, 5)]
    found = [fitted(each, cell, 2) for each in counts]
    assert orders([n for n, _ in counts], found).min() > 1.2, found
    assert found[-1] < (0.003 if cell in PLANE else 0.03)
    assert fitted(counts[-1], cell, 1) > 0.5


# -- rigid solids --


@pytest.mark.parametrize(("order", "converges"), [(1, 2), (2, 4)])
def test_a_rigid_disc_lands(order, converges, tmp_path):
    """Where it sticks it goes on with 2/3 of its velocity, of an order that its inertia has: it
    bears by all nodes of its facets, whose radius is exact."""
    file, found = tmp_path / "disc.geo", []
    for h in (0.4, 0.2, 0.1):
        file.write_text(DISC % (order, f"Mesh.MeshSizeMax = {h};\n"))
        mesh = mesh_from_gmsh(file)
        x, *_ = mesh.boundary("rim")
        up, along = -x[0], np.array([-x[0, 1], x[0, 0]])
        disc = RigidSolid(mesh, density=1.0, velocity=along - 0.1 * up)
        contact = Contact(disc, "rim", HalfSpace(x[0], up), friction=100.0)
        history = Scene([disc], [contact], locate_impacts=True).run(until=1e-4, dt=1e-4)
        assert history.finished and abs(disc.velocity[:2] @ up) < 1e-9
        found.append((len(x), abs(disc.velocity[:2] @ along - 2 / 3)))
    assert orders(*np.array(found).T) == pytest.approx(converges, abs=0.1)


def test_a_rigid_ball_rests_on_all_its_nodes(tmp_path):
    """Corners and middles bear alike: none is below the floor."""
    file = tmp_path / "ball.geo"
    file.write_text(BALL % (2, "Mesh.MeshSizeMin = 0.8; Mesh.MeshSizeMax = 0.8;\n"))
    mesh = mesh_from_gmsh(file)
    ball = RigidSolid(mesh, density=1.0, gravity=(0, 0, -9.81), spin=(1.0, 2.0, 0.0))
    contact = Contact(ball, "rim", HalfSpace((0, 0, -1.01), (0, 0, 1)), friction=0.3, name="c")
    lowest: dict = {"gap": lambda: float(contact.gap.max())}
    history = Scene([ball], [contact]).run(until=0.2, dt=5e-3, probes=lowest)
    assert history.finished, history.reason
    assert len(contact.surface.points) == len(mesh.boundary("rim", 2)[0])
    assert history["c.bearing"].max() > 0 and history["gap"].max() < 1e-2
    gained = ball.mass * (ball.velocity[:3] + np.array([0, 0, 9.81 * 0.2]))
    np.testing.assert_allclose(history.impulse("c")[-1], gained, atol=1e-9)
    energy = total_energy(history)
    assert energy.max() < energy[0] + 1e-9 * abs(energy[0])


# -- what is refused --


def refused(make, *words):
    with pytest.raises(InputError) as caught:
        make()
    for word in words:
        assert word in str(caught.value), f"{word!r} not in {caught.value}"


def test_displacements_of_first_degree():
    mesh = ring(2, "triangle", 2)
    refused(
        lambda: ElasticSolid(mesh, youngs_modulus=E, poisson_ratio=NU, density=1.0),
        "degree = 1",
        "must be 2 on a mesh of second degree",
    )


EIGHT = RECOMBINED + "Mesh.SecondOrderIncomplete = 1;\n"


@pytest.mark.parametrize(
    ("order", "more", "gmsh_says", "meshio_says"),
    [
        (3, "", "Triangle 10", "triangle10"),
        (2, EIGHT, "Quadrilateral 8", "quad8"),
    ],
    ids=["third order", "eight nodes"],
)
def test_other_cells(order, more, gmsh_says, meshio_says, tmp_path):
    script, file = written(tmp_path, DISC % (order, more))
    refused(lambda: mesh_from_gmsh(script), f"file = '{script}'", gmsh_says, "(of 3 or 6 nodes)")
    refused(lambda: mesh_from_gmsh(file), f"file = '{file}'", gmsh_says, "(of 3 or 6 nodes)")
    refused(lambda: mesh_from_file(file), f"file = '{file}'", meshio_says, "(of 3 or 6 nodes)")


def test_a_dolfinx_mesh_of_third_degree():
    x, cells = lattice([1, 1], "triangle", 3)
    mesh = compat.create_mesh(MPI.COMM_SELF, cells, x, "triangle", 3)
    refused(lambda: name_facets(mesh, {}), "mesh: has 10 nodes in each triangle", "(of 3 or 6")


@pytest.mark.parametrize("cell", PLANE + SPACE)
def test_a_middle_that_turns_its_cell_over(cell, tmp_path):
    x, cells = lattice([1] * DIM[cell], cell, 2)
    middle = np.flatnonzero(np.isclose(x[:, 0], 0.5) & np.isclose(x[:, 1:], 0).all(axis=1))
    x[middle, 1] += 0.9
    mesh = compat.create_mesh(MPI.COMM_SELF, cells, x, cell, 2)
    refused(lambda: name_facets(mesh, {}), "mesh", "turned over at a node")
    kind, nodes = for_meshio(cell, cells)
    file = tmp_path / "body.vtu"
    meshio.Mesh(np.pad(x, ((0, 0), (0, 3 - x.shape[1]))), [(kind, nodes)]).write(file)
    refused(lambda: mesh_from_file(file), f"file = '{file}'", "turned over at a node")


def test_two_middles_of_one_facet(tmp_path):
    x, cells = lattice([1, 1], "triangle", 2)
    (shared,) = (node for node in np.intersect1d(*cells) if np.allclose(x[node], 0.5))
    cells = np.where((cells == shared) & (np.arange(2)[:, None] == 1), len(x), cells)
    x = np.pad(np.vstack([x, [0.51, 0.49]]), ((0, 0), (0, 1)))
    meshio.Mesh(x, [for_meshio("triangle", cells)]).write(tmp_path / "body.vtu")
    refused(lambda: mesh_from_file(tmp_path / "body.vtu"), "share the corners", "not its middle")


# -- two processes --

SCRIPT = """
from mpi4py import MPI
from fenicsx_contact import Contact, ElasticSolid, HalfSpace, RigidSolid, Scene, mesh_from_file
mesh = mesh_from_file({file!r})
solid = ElasticSolid(
    mesh, youngs_modulus=1e4, poisson_ratio=0.3, density=1.0, degree=2, velocity={velocity}
)
contact = Contact(solid, "rim", HalfSpace({point}, {normal}), "gap", 0.2, name="c")
history = Scene([solid], [contact], geometry="newton").run(until=0.012, dt=2e-3)
assert history.finished, history.reason
moved = solid.mean(solid.displacement)
mass = RigidSolid(mesh, density=1.0).mass
if MPI.COMM_WORLD.rank == 0:
    print("found", mass, *moved, history["kinetic"][-1], history["strain"].max())
"""


@pytest.mark.second
@needs_mpirun
@pytest.mark.parametrize("d", [2, 3])
def test_two_processes(d, tmp_path):
    _, file = written(tmp_path, {2: DISC, 3: BALL}[d] % (2, ""))
    normal = (0.0,) * (d - 1) + (1.0,)
    code = SCRIPT.format(
        file=str(file),
        velocity=(0.3, *(0.0,) * (d - 2), -1.0),
        point=tuple(-1.005 * n for n in normal),
        normal=normal,
    )
    found = [
        [line.split()[1:] for line in output_of(mpirun(code, n)).splitlines() if "found" in line]
        for n in (1, 2)
    ]
    one, two = (np.array(each[0], dtype=float) for each in found)
    np.testing.assert_allclose(two, one, rtol=1e-8, atol=1e-10)
    assert one[-1] > 1e-3
