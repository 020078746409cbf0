# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes in several pieces: blocks apart, nodes that coincide and are not the same, hinges."""

from itertools import product

import dolfinx
import numpy as np
import pytest
from mpi4py import MPI
from processes import mpirun, needs_mpirun, output_of
from scenes import FLOOR, G, rectangle

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    InputError,
    NamedMesh,
    QuasiStatic,
    Rayleigh,
    Scene,
    ThetaScheme,
    name_facets,
    neo_hookean,
)
from fenicsx_contact.base import compat

KINDS = ["linear", "soft"]


def blocks(*corners, merged=True, n=2, comm=MPI.COMM_SELF):
    """Unit squares or cubes with these lower corners, n cells along each edge; nodes at one place
    are one if merged. Facets base, on y or z = 0, and top, the highest."""
    d = len(corners[0])
    grid = np.array(list(product(range(n + 1), repeat=d)))
    number = {tuple(at): k for k, at in enumerate(grid)}
    corner = np.array(list(product((0, 1), repeat=d)))[:, ::-1]  # the first axis goes first
    low = [at for at in grid if (at < n).all()]
    one = np.array([[number[tuple(at + c)] for c in corner] for at in low])
    x = np.concatenate([grid / n + np.array(at) for at in corners])
    cells = np.concatenate([one + k * len(grid) for k in range(len(corners))])
    if merged:
        x, onto = np.unique(x, axis=0, return_inverse=True)
        cells = onto.ravel()[cells]
    if comm.rank:
        x, cells = x[:0], cells[:0]
    mesh = compat.create_mesh(comm, cells, x, "quadrilateral" if d == 2 else "hexahedron")
    high = max(at[-1] for at in corners) + 1.0
    where = {"base": lambda x: np.isclose(x[d - 1], 0), "top": lambda x: np.isclose(x[d - 1], high)}
    return name_facets(mesh, where)


def solid(kind, mesh, **others):
    d = mesh.dim
    given = {"density": 1e3, "gravity": [0.0] * (d - 1) + [-G], "name": "b", **others}
    if kind == "soft":
        return HyperelasticSolid(mesh, energy=neo_hookean(1e6, 0.3), **given)
    return ElasticSolid(mesh, youngs_modulus=1e6, poisson_ratio=0.3, **given)


APART = {
    "one": ([(0, 0), (0, 1)], True, 1, 0),
    "apart": ([(0, 0), (1.5, 0), (3, 0)], True, 3, 0),
    "not merged": ([(0, 0), (0, 1)], False, 2, 0),
    "hinge": ([(0, 0), (1, 1)], True, 2, 1),
    "edge": ([(0, 0, 0), (1, 0, 1)], True, 2, 3),
}


@pytest.mark.parametrize("case", APART)
def test_pieces_and_their_joints(case):
    corners, merged, count, joined = APART[case]
    pieces = solid("linear", blocks(*corners, merged=merged)).vectors.pieces
    assert pieces.count == count
    assert len(np.unique(pieces.joints[0])) == joined
    if count > 1:
        np.testing.assert_allclose(pieces.centres, np.array(corners) + 0.5)
        np.testing.assert_allclose(pieces.sizes, 0.5)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("case", "way"),
    [("not merged", "moving along x"), ("hinge", "turning"), ("edge", "turning about y")],
)
def test_a_piece_that_nothing_holds_is_refused(kind, case, way):
    corners, merged, *_ = APART[case]
    held = solid(kind, blocks(*corners, merged=merged), fixed=["top"])
    place = ", ".join(["0.5"] * held.dim)
    with pytest.raises(
        InputError, match=rf"nothing holds 'b' against {way} \(its piece about \[{place}\]\)"
    ):
        Scene([held], [], QuasiStatic())


def test_nodes_that_are_there_twice_are_named_where_nothing_holds():
    with pytest.raises(
        InputError, match="3 nodes of one coincide with some of others and are not the"
    ):
        held = solid("linear", blocks((0, 0), (0, 1), merged=False), fixed=["top"])
        Scene([held], [], QuasiStatic())


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("merged", [True, False])
def test_a_piece_is_held_and_another_lies(kind, merged):
    """The one hangs, the other lies on the floor with all its weight."""
    above = 1.5 if merged else 1.0
    body = solid(kind, blocks((0, 0), (0, above), merged=merged), fixed=["top"])
    scene = Scene(
        [body], [Contact(body, "base", FLOOR, "gap", friction=0.3, name="c")], QuasiStatic()
    )
    history = scene.run(1.0, 1.0)
    assert history.finished, history.reason
    np.testing.assert_allclose(history["c.force_y"][-1], 1e3 * G, rtol=1e-8)
    np.testing.assert_allclose(body.reaction("top"), [0.0, 1e3 * G], rtol=1e-8, atol=1e-4)
    assert np.abs(body.displacement).max() < 0.01


@pytest.mark.parametrize("kind", KINDS)
def test_a_hinged_piece_turns_until_it_meets_the_floor(kind):
    body = solid(kind, blocks((0, 0), (1, 1)), fixed=["top"])
    floor = HalfSpace((0, -0.5), (0, 1))
    history = Scene([body], [Contact(body, "base", floor, "gap", name="c")], QuasiStatic()).run(
        1.0, 1.0
    )
    assert history.finished, history.reason
    assert 0.5 <= np.abs(body.displacement).max() < 1.2
    assert history["certificate"].max() < 1e-8


@pytest.mark.parametrize("slope", [0.0, 0.3])
def test_what_lies_on_pieces_holds_none_that_slides(slope):
    """A beam on two blocks on the floor, all of it by friction; without it they slide apart."""
    piers = solid("linear", blocks((-1.5, 0), (0.5, 0)), name="piers")
    beam = rectangle((8, 2), (3.0, 0.5), comm=MPI.COMM_SELF)
    beam.mesh.geometry.x[:, 1] += 1.0
    deck = solid("linear", beam, name="deck")
    contacts = [
        Contact(deck, "base", (piers, "top"), "gap", friction=slope, name="up"),
        Contact(piers, "base", FLOOR, "gap", friction=slope, name="down"),
    ]
    if not slope:
        with pytest.raises(
            InputError, match=r"nothing holds '(piers|deck)' against moving along x"
        ):
            Scene([piers, deck], contacts, QuasiStatic())
        return
    history = Scene([piers, deck], contacts, QuasiStatic()).run(1.0, 1.0)
    assert history.finished, history.reason
    np.testing.assert_allclose(history["up.force_y"][-1], 1.5e3 * G, rtol=1e-8)
    np.testing.assert_allclose(history["down.force_y"][-1], 3.5e3 * G, rtol=1e-8)


def seamed(**others):
    """Two halves that are one across the seam, and a piece between."""
    mesh = blocks((0, 0), (1.5, 0), (3, 0), comm=others.pop("comm", MPI.COMM_SELF)).mesh
    sides = {"left": lambda x: np.isclose(x[0], 0), "right": lambda x: np.isclose(x[0], 4)}
    where = {"base": lambda x: np.isclose(x[1], 0) & (x[0] > 1.2) & (x[0] < 2.8), **sides}
    return solid("linear", name_facets(mesh, where), periodic=[("left", "right")], **others)


def test_periodic_sides_join_the_pieces_on_them():
    joined = seamed(fixed=["base"])
    assert joined.vectors.pieces.count == 3
    with pytest.raises(InputError, match=r"nothing holds 'b' .* \(its piece about \[(0|3).5"):
        Scene([joined], [], QuasiStatic())
    assert joined._free_motions[0].shape[1] == 3  # of the halves together
    assert seamed()._free_motions[0].shape[1] == 6


def test_the_free_motions_of_each_piece_are_known_in_dynamics():
    body = solid("linear", blocks((0, 0), (1.5, 0), (3, 1.5)), fixed=["top"])
    assert body._free_motions[0].shape[1] == 6
    body = solid("linear", blocks((0, 0), (1, 1)))
    assert body._free_motions[0].shape[1] == 4


@pytest.mark.parametrize("kind", KINDS)
def test_a_run_says_that_a_solid_is_in_pieces(kind):
    told = []
    for merged in (True, False):
        body = solid(kind, blocks((0, 0), (0, 1), merged=merged), fixed=["top"])
        scene = Scene([body], [], ThetaScheme(1.0))
        told.append([text for _, text in scene.run(0.1, 0.05).remarks])
        assert ("2 pieces" in scene.describe()) is not merged
    assert told[0] == []
    assert len(told[1]) == 1
    assert "solid 'b' is in 2 pieces, which share no facet (3 nodes of one coincide" in told[1][0]


def one_on_another(kind, gap, **others):
    """Two blocks in one mesh, the upper one on the lower, with facets up and low where they meet:
    nodes of both may be at one place."""
    mesh = blocks((0, 0), (0, 1 + gap), merged=False).mesh
    mesh.topology.create_connectivity(1, 2)
    facets = dolfinx.mesh.locate_entities_boundary(mesh, 1, lambda x: np.full(x.shape[1], True))
    cells = mesh.topology.connectivity(1, 2)
    middle = dolfinx.mesh.compute_midpoints(mesh, 1, facets)[:, 1]
    behind = np.array([cells.links(facet)[0] for facet in facets], dtype=np.int32)
    above = dolfinx.mesh.compute_midpoints(mesh, 2, behind)[:, 1] > 1
    tags = np.select([np.isclose(middle, 0), abs(middle - 1) <= gap + 1e-9], [1, 2 + above])
    tags = dolfinx.mesh.meshtags(mesh, 1, facets[tags > 0], tags[tags > 0].astype(np.int32))
    named = NamedMesh(mesh, tags, {"base": 1, "low": 2, "up": 3})
    return solid(kind, named, fixed=["base"], **others)


@pytest.mark.parametrize("slope", [0.3, 0.6])
@pytest.mark.parametrize("gap", [0.0, 1e-3])
@pytest.mark.parametrize("kind", KINDS)
def test_a_piece_lies_on_another_of_the_same_solid(kind, gap, slope):
    """Of nodes that coincide those of the named facets bear."""
    body = one_on_another(kind, gap)
    contact = Contact(body, "up", (body, "low"), "gap", friction=slope, name="c")
    history = Scene([body], [contact], QuasiStatic()).run(1.0, 1.0)
    assert history.finished, history.reason
    np.testing.assert_allclose(history["c.force_y"][-1], 1e3 * G, rtol=1e-6)
    assert abs(np.abs(body.displacement).max() - gap) < 0.025


def test_a_piece_goes_on_resting_on_another_whose_nodes_are_at_the_same_places():
    """It had been found at rest with 70 times its weight, of springs through the other's nodes."""
    body = one_on_another("linear", 0.0, damping=Rayleigh(20.0, 0.0))
    contact = Contact(body, "up", (body, "low"), "gap", friction=0.3, name="c")
    history = Scene([body], [contact], ThetaScheme(1.0)).run(1.0, 0.02)
    assert history.finished, history.reason
    np.testing.assert_allclose(history["c.force_y"][-1], 1e3 * G, rtol=0.01)


def test_facets_two_of_whose_nodes_are_at_one_place_are_refused():
    body = solid("linear", blocks((0, 0), (1, 0), merged=False))
    with pytest.raises(InputError, match="facets = 'base': 1 of their nodes coincide"):
        Contact(body, "base", FLOOR, "gap")


PARALLEL = """
import sys
sys.path.insert(0, {path!r})
import numpy as np
from mpi4py import MPI
from test_pieces import *
for corners, merged, count, joined in APART.values():
    mesh = blocks(*corners, merged=merged, n=4, comm=MPI.COMM_WORLD)
    pieces = solid("linear", mesh).vectors.pieces
    assert pieces.count == count, pieces.count
    joints = mesh.mesh.comm.allreduce(len(np.unique(pieces.joints[0])))
    # of what shares no facet dolfinx may make nodes of their own on each process
    assert joints in (0, 5 if joined == 3 else joined)
    if count > 1:
        np.testing.assert_allclose(pieces.centres, np.array(corners) + 0.5)
    where = solid("linear", mesh, fixed=["top"])
    try:
        Scene([where], [], QuasiStatic())
    except InputError as told:
        assert "nothing holds 'b'" in str(told)
        assert merged or "5 nodes of one" in str(told)
    else:
        assert all(at[-1] == corners[-1][-1] for at in corners) or count == 1
for held, free in ((["base"], 3), ([], 6)):
    body = seamed(fixed=held, comm=MPI.COMM_WORLD)
    assert body._free_motions[0].shape[1] == free
mesh = blocks((0, 0), (0, 1), merged=False, n=4, comm=MPI.COMM_WORLD)
body = solid("linear", mesh, fixed=["top"])
contact = Contact(body, "base", FLOOR, "gap", friction=0.3, name="c")
history = Scene([body], [contact], QuasiStatic()).run(1.0, 1.0)
assert history.finished, history.reason
np.testing.assert_allclose(history["c.force_y"][-1], 1e3 * G, rtol=1e-8)
"""


@needs_mpirun
@pytest.mark.second
@pytest.mark.parametrize("processes", [2, 3])
def test_several_processes_find_the_same_pieces(processes):
    output_of(mpirun(PARALLEL.format(path=str(__file__).rsplit("/", 1)[0]), processes))
