# SPDX-License-Identifier: LGPL-3.0-or-later
"""A solid that touches itself: two of its surfaces before each other, or one before itself."""

from functools import cache

import dolfinx
import numpy as np
import pytest
from corpus_meshes import ring_mesh
from mpi4py import MPI
from scenes import check_energies, total_energy

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HyperelasticSolid,
    InputError,
    LevelSet,
    NamedMesh,
    QuasiStatic,
    RigidSolid,
    Scene,
    mesh_from_gmsh,
    name_facets,
    neo_hookean,
)
from fenicsx_contact.base import compat
from fenicsx_contact.contact.mortar.ridges import smooth_parts
from fenicsx_contact.contact.surfaces import side_of

R, THICK = 1.0, 0.08


def round_ring(n):
    """A ring of cells of nine nodes."""
    k, across = np.arange(2 * n), R - THICK * np.array([1.0, 0.5, 0.0])
    way = np.stack([np.sin(np.pi * k / n), -np.cos(np.pi * k / n)], axis=1)
    points = (across[:, None] * way[:, None]).reshape(-1, 2)
    # in basix's order: corners, edges, the middle; around and across
    at = [(0, 0), (0, 2), (2, 0), (2, 2), (0, 1), (1, 0), (1, 2), (2, 1), (1, 1)]
    cells = [[3 * ((i + a) % (2 * n)) + b for a, b in at] for i in range(0, 2 * n, 2)]
    return compat.create_mesh(MPI.COMM_SELF, np.array(cells), points, "quadrilateral", 2)


def ring(n=40, layers=0, halves=True, degree=1):
    """Mesh of a ring, or of so many layers of it in space; its inner side whole or in halves."""
    flat = ring_mesh(R, THICK, n).mesh if degree == 1 else round_ring(n)
    rim = R * np.cos(np.pi / n)

    def outer(p):
        return np.hypot(p[0], p[1]) > rim - THICK / 2

    names = {
        "top": lambda p: outer(p) & (p[1] > 0.95 * R),
        "bottom": lambda p: outer(p) & (p[1] < -0.95 * R),
    }
    if halves:
        names["above"] = lambda p: ~outer(p) & (p[1] > 0)
        names["below"] = lambda p: ~outer(p) & (p[1] < 0)
    else:
        names["inner"] = lambda p: ~outer(p)
    if not layers:
        return name_facets(flat, names)
    # in the plane of x and z, layers along y
    deep, k, i = 0.1 * layers, np.arange(layers + 1), np.arange(n)
    around = 2 * np.pi * i / n
    at = [np.stack([r * np.sin(around), -r * np.cos(around)], axis=1) for r in (R - THICK, R)]
    points = np.array([[p[0], 0.1 * j, p[1]] for j in k for pair in zip(*at) for p in pair])
    ends = np.stack([2 * i, 2 * i + 1, 2 * ((i + 1) % n), 2 * ((i + 1) % n) + 1], axis=1)
    cells = [np.hstack([ends + 2 * n * j, ends + 2 * n * (j + 1)]) for j in k[:-1]]
    mesh = compat.create_mesh(MPI.COMM_SELF, np.concatenate(cells), points, "hexahedron")

    def inside(name):
        return lambda p: names[name](p[[0, 2]])

    sides = {"front": lambda p: np.isclose(p[1], 0), "back": lambda p: np.isclose(p[1], deep)}
    return name_facets(mesh, {**{name: inside(name) for name in names}, **sides})


def squashed(mesh, solver="monolithic", friction=0.0, mirror=False, steps=30):
    """A ring between two plates that come together: its last state and its history. Its halves
    meet each other, or its inner side itself; with ``mirror`` a plane half way between them."""
    d, way = mesh.dim, 2 * R - 2.2 * THICK
    free = [0.0, *[None] * (d - 2)]
    held = {"top": lambda t: [*free, -t], "bottom": [*free, 0.0]}
    if d == 3:
        held |= {"front": (None, 0.0, None), "back": (None, 0.0, None)}
    body = HyperelasticSolid(
        mesh, energy=neo_hookean(1e3, 0.3), density=1.0, prescribed=held, degree=mesh.degree
    )
    planes = {
        "above": LevelSet(lambda x, t: x[d - 1] + t / 2, d),
        "below": LevelSet(lambda x, t: -x[d - 1] - t / 2, d),
    }
    sides = [("above", "below")] if "above" in mesh.names else [("inner", "inner")]
    others = planes if mirror else {one: (body, other) for one, other in sides}
    contacts = [
        Contact(body, side, other, "gap", friction=friction, name=side)
        for side, other in others.items()
    ]
    scene = Scene([body], contacts, QuasiStatic(), geometry="newton", solver=solver)
    history = scene.run(way, way / steps, progress=False)
    assert history.finished, history.reason
    return body, contacts, history


def deepest(contacts):
    """What the law holds at its nodes, between which the cells of a fold may overlap."""
    return max(contact.gap[contact.chosen].max() for contact in contacts)


@pytest.mark.parametrize("solver", ["condensed", "monolithic", "iterative"])
@pytest.mark.parametrize(
    "friction",
    [pytest.param(0.0, marks=pytest.mark.long), pytest.param(0.3, marks=pytest.mark.second)],
)
def test_a_squashed_ring_touches_itself(solver, friction):
    """Every solver comes to the same; what is alike does not slip, and friction changes little. Its
    last folds are cut into steps by chance, and with friction another way ends elsewhere."""
    _, contacts, history = squashed(ring(), solver, friction)
    assert history["above.bearing"][-1] >= 3 and history["above.bearing"][5] == 0
    assert deepest(contacts) < 1e-9
    pressed = history["above.force_y"][-1]
    assert abs(history["above.force_x"][-1]) < 1e-6 * pressed
    _, _, expected = plain(friction)
    if not friction:
        assert pressed == pytest.approx(expected["above.force_y"][-1], rel=1e-6)
    # steps in which nothing touches yet may be others, too
    touching = [each["above.force_y"] > 0 for each in (history, expected)]
    n = min(mine.sum() for mine in touching)
    times = [each.time[mine][:n] for each, mine in zip((history, expected), touching)]
    same = np.logical_and.accumulate(times[0] == times[1])
    found, wanted = (
        each["above.force_y"][mine][:n][same] for each, mine in zip((history, expected), touching)
    )
    np.testing.assert_allclose(found, wanted, rtol=1e-6)
    assert wanted[-1] > 0


@cache
def plain(friction):
    return squashed(ring(), friction=friction)


@pytest.mark.second
def test_as_it_would_touch_a_plane_between_its_halves():
    """The mortar means of one half make it differ by the square of the size of the elements."""
    errors = []
    for n in (80, 160):
        (body, _, history), (other, _, plane) = squashed(ring(n)), squashed(ring(n), mirror=True)
        pressed = plane["above.force_y"][-1]
        assert pressed == pytest.approx(-plane["below.force_y"][-1], rel=1e-6)
        errors.append(abs(history["above.force_y"][-1] / pressed - 1))
    assert errors[0] < 0.05 and errors[1] < errors[0] / 3
    assert np.abs(body.displacement - other.displacement).max() < 0.01 * R


@pytest.mark.second
def test_in_space_it_is_the_same():
    (flat, _, plane), (deep, _, space) = squashed(ring()), squashed(ring(layers=1))
    assert space["above.force_z"][-1] == pytest.approx(0.1 * plane["above.force_y"][-1], rel=1e-6)
    assert np.abs(deep.displacement).max() == pytest.approx(
        np.abs(flat.displacement).max(), rel=1e-5
    )


def fork(skin=False):
    """Two arms of three cells each, joined at their left end; a slit of 5 mm between them. The
    two sides of the slit have names, or their four sides one."""
    cells, points = [], {}

    def corner(i, y):
        return points.setdefault((0.1 * i, y), len(points))

    for y, h, columns in ((0.0, 0.02, 4), (0.02, 0.005, 1), (0.025, 0.02, 4)):
        for i in range(columns):
            cells.append([corner(i + a, y + b * h) for b in (0, 1) for a in (0, 1)])
    mesh = compat.create_mesh(
        MPI.COMM_SELF, np.array(cells), np.array(list(points)), "quadrilateral"
    )
    side = lambda y: lambda x: np.isclose(x[1], y) & (x[0] > 0.099)  # noqa: E731
    sides = {"upper": side(0.025), "lower": side(0.02)}
    if skin:
        sides |= {"top": side(0.045), "bottom": side(0.0)}
    named = name_facets(mesh, {**sides, "end": lambda x: np.isclose(x[0], 0)})
    if not skin:
        return named
    tags = named.facet_tags
    one = np.where(tags.values == named.names["end"], 2, 1).astype(np.int32)
    tags = dolfinx.mesh.meshtags(mesh, 1, tags.indices, one)
    return NamedMesh(mesh, tags, {"skin": 1, "end": 2})


def clapping(sides, law, locate=False):
    """The arms are thrown at each other; the solid and its history."""
    fast = lambda x: np.stack([0 * x[0], np.where(x[1] > 0.0225, -1.0, 1.0) * x[0] ** 2 * 8])  # noqa: E731
    solid = ElasticSolid(
        fork("skin" in sides),
        youngs_modulus=1e8,
        poisson_ratio=0.3,
        density=1000.0,
        fixed=["end"],
        velocity=fast,
    )
    contact = Contact(solid, sides[0], (solid, sides[1]), law, name="slit")
    history = Scene([solid], [contact], locate_impacts=locate).run(0.03, 2e-4)
    assert history.finished, history.reason
    return solid, history


@pytest.mark.parametrize(
    ("law", "locate"),
    [
        ("velocity", False),
        pytest.param("velocity", True, marks=pytest.mark.second),
        ("gap", False),
    ],
)
def test_the_arms_of_a_fork_clap(law, locate):
    """Linear, condensed: what the arms do to each other goes through the one matrix of the solid.
    They meet in the middle, alike; nothing is gained, and momentum across stays none."""
    solid, history = clapping(("upper", "lower"), law, locate)
    assert history["slit.bearing"].max() >= 1 and history["slit.force_y"].max() > 0
    # arms that turn give and take a little, as two solids do
    total = total_energy(history)
    check_energies(history, 1e-9, slack=2e-4 * total[0])
    assert history["impact"][-1] < -0.1 * total[0] and total.max() < (1 + 1e-4) * total[0]
    u = solid.displacement.reshape(-1, 2)
    x = solid.space.tabulate_dof_coordinates()[:, :2].round(9)
    order = np.lexsort((x[:, 0], x[:, 1])), np.lexsort((x[:, 0], -x[:, 1]))
    mirror = u[order[0]] * [1, -1]
    np.testing.assert_allclose(u[order[1]], mirror, rtol=0, atol=0.01 * np.abs(u).max())
    assert history["slit.penetration"].max() < (1e-9 if law == "gap" else 5e-4)


@pytest.mark.filterwarnings("error::RuntimeWarning")  # nor of an iterate that diverges
@pytest.mark.parametrize("layers", [0, pytest.param(1, marks=pytest.mark.second)])
@pytest.mark.parametrize("solver", ["condensed", "monolithic"])
def test_one_surface_before_itself(solver, layers):
    """Nobody says which of its parts meet: they are found, and do what they do when named."""
    _, _, named = squashed(ring(layers=layers), solver)
    _, _, found = squashed(ring(layers=layers, halves=False), solver)
    up = f"force_{'yz'[layers]}"
    assert found["inner.bearing"][-1] == named["above.bearing"][-1] >= 3
    # the lower half is the slave
    np.testing.assert_allclose(
        found[f"inner.{up}"], -named[f"above.{up}"], rtol=1e-6, atol=1e-6 * named[f"above.{up}"][-1]
    )


@pytest.mark.second
def test_cells_of_second_degree():
    """Half before half, and one surface before itself, of round cells."""
    _, above, named = squashed(ring(degree=2))
    _, inner, found = squashed(ring(degree=2, halves=False))
    assert found["inner.bearing"][-1] == named["above.bearing"][-1] >= 3
    assert found["inner.force_y"][-1] == pytest.approx(-named["above.force_y"][-1], rel=1e-6)
    assert deepest(above + inner) < 1e-9


@pytest.mark.second
def test_cells_of_second_degree_as_before_a_plane():
    errors = []
    for n in (40, 80):
        _, _, history = squashed(ring(n, degree=2))
        _, _, plane = squashed(ring(n, degree=2), mirror=True)
        errors.append(abs(history["above.force_y"][-1] / plane["above.force_y"][-1] - 1))
    assert errors[0] < 0.2 and errors[1] < errors[0] / 3


@pytest.mark.second
@pytest.mark.parametrize("solver", ["condensed", "monolithic", "iterative"])
def test_one_surface_with_friction(solver):
    """Steps are cut where halves that fold stick and slip; then it is what the halves do."""
    _, _, named = squashed(ring(80), friction=0.3)
    _, inner, found = squashed(ring(80, halves=False), solver, friction=0.3)
    pressed = named["above.force_y"][-1]
    assert found["inner.force_y"][-1] == pytest.approx(-pressed, rel=0.02)
    assert deepest(inner) < 1e-9


@pytest.mark.parametrize("law", ["velocity", pytest.param("gap", marks=pytest.mark.second)])
def test_a_wall_does_not_meet_its_own_far_side(law):
    """Both sides of both arms are one surface, of facets five times as long as an arm is thick: the
    sides of the slit meet, the two of an arm do not."""
    solid, history = clapping(("skin", "skin"), law)
    other, expected = clapping(("lower", "upper"), law)
    assert expected["slit.bearing"].max() >= 1
    # speeds are judged by those of more points, and bounces make more of what that leaves
    for column in ("kinetic", "strain", "impact", "slit.bearing", "slit.force_y"):
        size = np.abs(expected[column]).max()
        np.testing.assert_allclose(history[column], expected[column], rtol=0, atol=1e-4 * size)
    size = np.abs(other.displacement).max()
    np.testing.assert_allclose(solid.displacement, other.displacement, rtol=0, atol=1e-4 * size)


def hook(whole):
    """A clamp of two arms and a tooth of 2 cm under the upper one, 1 cm above the lower one; its
    boundary has one name, or tooth and arm have theirs."""
    cells, points = [], {}

    def corner(i, j):
        return points.setdefault((0.02 * i, 0.01 * j), len(points))

    for i in range(10):
        for j in range(5):
            if i < 2 or j in (0, 1, 4) or (j == 3 and i == 8):
                cells.append([corner(i + a, j + b) for b in (0, 1) for a in (0, 1)])
    mesh = compat.create_mesh(
        MPI.COMM_SELF, np.array(cells), np.array(list(points)), "quadrilateral"
    )
    tooth = {
        "tooth": lambda x: np.isclose(x[1], 0.03) & (x[0] > 0.15),
        "arm": lambda x: np.isclose(x[1], 0.02) & (x[0] > 0.03),
    }
    sides = {"tooth": lambda x: x[0] > 1e-9} if whole else tooth
    return name_facets(mesh, {**sides, "end": lambda x: np.isclose(x[0], 0)})


def bitten(whole, law):
    """The clamp is closed and pressed; its history."""
    pull = lambda x, t: (0 * x[0], -2e5 * t * (x[1] > 0.035) * (x[0] > 0.05))  # noqa: E731
    body = HyperelasticSolid(
        hook(whole), energy=neo_hookean(1e6, 0.3), density=1.0, fixed=["end"], body_force=pull
    )
    contact = Contact(body, "tooth", (body, "tooth" if whole else "arm"), law, 0.3, name="c")
    scene = Scene([body], [contact], QuasiStatic(), geometry="newton")
    history = scene.run(1.0, 0.05, progress=False)
    assert history.finished, history.reason
    assert abs(history["c.force_y"][-1]) > 10 and history["c.penetration"].max() < 1e-3
    return history


@pytest.mark.parametrize(
    ("whole", "law"),
    [
        pytest.param(False, "velocity", id="named-velocity"),
        pytest.param(False, "gap", id="named-gap"),
        pytest.param(True, "velocity", id="whole-velocity", marks=pytest.mark.open),
        pytest.param(True, "gap", id="whole-gap"),
    ],
)
def test_a_tooth_with_sharp_edges_bites(whole, law):
    """Nobody need name the parts that meet: sharp edges divide them, and it comes to the same. By
    velocities it sinks in by 1.2 mm on the way, where the side of the tooth sees the arm, too."""
    history = bitten(whole, law)
    assert history["c.force_y"][-1] == pytest.approx(65.28, rel=1e-3)


def test_parts_of_a_surface():
    """Each straight side of a clamp is one; what is round is one."""
    side = side_of(RigidSolid(hook(True), density=1.0), "tooth")
    part = smooth_parts(side)
    assert len(set(part)) == 11
    for one in set(part):
        assert np.ptp(side.nodes[side.corners[part == one]].reshape(-1, 2), axis=0).min() < 1e-12
    whole = side_of(RigidSolid(ring(halves=False), density=1.0), "inner")
    assert set(smooth_parts(whole)) == {0}


def test_what_folds_far_away_touches_nothing_yet():
    """A flat strip faces itself nowhere; that is no reason to refuse it."""
    mesh = mesh_from_gmsh("block.geo", width=1.0, height=0.01, n_width=10, n_height=1)
    body = ElasticSolid(
        mesh, youngs_modulus=1e6, poisson_ratio=0.3, density=1.0, fixed=["left"], gravity=(0, -9.81)
    )
    contact = Contact(body, "top", (body, "top"), name="top")
    history = Scene([body], [contact]).run(0.02, 1e-3)
    assert history.finished and not history["top.bearing"].any()


def test_what_is_rigid_cannot_touch_itself():
    mesh = mesh_from_gmsh("block.geo", width=1.0, height=0.1)
    body = RigidSolid(mesh, mass=1.0)
    with pytest.raises(InputError, match=r"master = \('rigid', 'base'\): what is rigid"):
        Contact(body, "base", (body, "base"))


@pytest.mark.parametrize("law", ["velocity", "gap"])
@pytest.mark.parametrize("n", [2, 4])
def test_a_hollow_corner_that_closes_presses_on_nothing(law, n):
    """An L whose arm is bent down: both faces of its corner are one surface, and meet at the corner
    alone. By means over the facets beside it they pushed each other off."""

    def bent(contacts):
        corners = [np.zeros(2), np.full(2, 2.0)]
        kind = dolfinx.mesh.CellType.quadrilateral
        whole = dolfinx.mesh.create_rectangle(MPI.COMM_SELF, corners, [2 * n, 2 * n], kind)
        cells = whole.topology.index_map(2).size_local
        nodes = whole.geometry.x[compat.cell_geometry(whole)[:cells], :2]
        stays = ~(nodes.mean(axis=1) @ np.diag((1, -1)) > (1, -1)).all(axis=1)
        x, cells = np.unique(np.round(nodes[stays].reshape(-1, 2), 9), axis=0, return_inverse=True)
        mesh = compat.create_mesh(MPI.COMM_SELF, cells.reshape(-1, 4), x, "quadrilateral")
        named = name_facets(
            mesh,
            {
                "base": lambda p: np.isclose(p[1], 0),
                "top": lambda p: np.isclose(p[1], 2),
                "corner": lambda p: (
                    (np.isclose(p[0], 1) & (p[1] < 1 + 1e-6))
                    | (np.isclose(p[1], 1) & (p[0] > 1 - 1e-6))
                ),
            },
        )
        body = ElasticSolid(
            named,
            youngs_modulus=1e3,
            poisson_ratio=0.3,
            density=1.0,
            fixed=["base"],
            tractions={"top": lambda t: (0.0, -20.0 * t)},
        )
        made = [Contact(body, "corner", (body, "corner"), law)] if contacts else []
        history = Scene([body], made, QuasiStatic()).run(until=1.0, dt=0.25)
        assert history.finished
        return history["strain"], made

    free, _ = bent(False)
    energy, (contact,) = bent(True)
    np.testing.assert_allclose(energy, free, rtol=1e-9)
    assert not contact.force.any()
