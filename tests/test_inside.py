# SPDX-License-Identifier: LGPL-3.0-or-later
"""A solid that starts inside another is refused, however far from the surfaces."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest
from corpus_meshes import ring_mesh
from processes import HANGS, mpirun, needs_mpirun
from scenes import G, box, rectangle
from test_self_contact import round_ring

from fenicsx_contact import (
    Circle,
    Contact,
    Curve,
    ElasticSolid,
    HalfSpace,
    InputError,
    LevelSet,
    RigidSolid,
    Scene,
    name_facets,
)
from fenicsx_contact.contact.inside import deepest, within
from fenicsx_contact.contact.mortar import Pairing
from fenicsx_contact.contact.simplices import nearest

SKIN = {"skin": lambda x: x[0] < np.inf}
CELLS = ["triangle", "quadrilateral", "tetrahedron", "hexahedron"]


def cube(cell, n, size, *middle):
    """A square or a cube of some cells, all its facets of one name."""
    d = 2 if cell in CELLS[:2] else 3
    block = (rectangle if d == 2 else box)((n,) * d, (size,) * d, cell).mesh
    low, high = block.geometry.x.min(axis=0), block.geometry.x.max(axis=0)
    block.geometry.x[:, :d] += np.array(middle[:d]) - (low + high)[:d] / 2
    return name_facets(block, SKIN)


def solid(kind, mesh, name, **given):
    if kind == "rigid":
        return RigidSolid(mesh, density=1000.0, name=name, **given)
    return ElasticSolid(
        mesh, youngs_modulus=1e9, poisson_ratio=0.3, density=1000.0, name=name, **given
    )


def scene(slave, master, law="velocity", **given):
    contact = Contact(slave, "skin", (master, "skin"), law, name="c", **given)
    return Scene([slave, master], [contact])


@pytest.mark.parametrize(
    ("cell", "kind"), [(cell, kind) for cell, kind in product(CELLS, ["rigid", "elastic"])]
)
@pytest.mark.parametrize("turned", [False, True], ids=["slave", "master"])
def test_a_body_inside_another(cell, kind, turned):
    """It is refused by names and depth, whichever of the two is the slave; beside, it is not."""
    middle = 0.03, 0.0, -0.01
    small = solid(kind, cube(cell, 2, 0.02, *middle), "small")
    large = solid("elastic" if kind == "rigid" else "rigid", cube(cell, 10, 1.0, 0, 0, 0), "large")
    pair = (large, small) if turned else (small, large)
    with pytest.raises(InputError, match=r"contacts: 'c' starts with 'small' 0\.48 inside 'large'"):
        scene(*pair)
    small = solid(kind, cube(cell, 2, 0.02, 0.511, 0, 0), "small")
    assert scene(*((large, small) if turned else (small, large)))


def test_a_body_that_is_moved_into_another():
    """By a displacement, or by a rotation about another place; not where it was."""
    shift = lambda x: np.outer([0.4, 0.0], np.ones(x.shape[1]))  # noqa: E731
    mesh = cube("triangle", 8, 1.0, 0, 0)
    large = solid("rigid", mesh, "large")
    small = solid("elastic", cube("triangle", 2, 0.02, 0.4, 0), "small", displacement=shift)
    assert scene(small, large)
    back = solid(
        "elastic", cube("triangle", 2, 0.02, 0.7, 0), "small", displacement=lambda x: -shift(x)
    )
    with pytest.raises(InputError, match=r"'small' 0\.21 inside 'large'"):
        scene(back, large)
    thin = rectangle((20, 2), (4.0, 0.2)).mesh
    bar = name_facets(thin, SKIN)
    small = solid("rigid", cube("triangle", 2, 0.02, 0, 1), "small")
    assert scene(small, solid("rigid", bar, "bar"))
    upright = solid("rigid", bar, "bar", rotation=np.pi / 2, about=(0.0, 0.1))
    with pytest.raises(InputError, match=r"'small' 0\.1 inside 'bar'"):
        scene(small, upright)


def test_what_lies_in_a_hole_is_not_inside():
    """But what lies in the wall around it is."""
    ring = name_facets(ring_mesh(1.0, 0.5, 100).mesh, SKIN)
    wall = solid("rigid", ring, "wall")
    assert scene(solid("rigid", cube("triangle", 2, 0.02, 0.1, 0), "small"), wall)
    with pytest.raises(InputError, match=r"'small' 0\.2.* inside 'wall'"):
        scene(solid("rigid", cube("triangle", 2, 0.02, 0.75, 0), "small"), wall)


@pytest.mark.parametrize("kind", ["rigid", "elastic"])
def test_a_round_body(kind):
    ring = name_facets(round_ring(24), SKIN)
    given = {"degree": 2} if kind == "elastic" else {}
    wall = solid(kind, ring, "wall", **given)
    inside = solid("rigid", cube("triangle", 1, 0.002, 0.0, 0.96), "small")
    with pytest.raises(InputError, match=r"'small' 0\.03.* inside 'wall'"):
        scene(inside, wall)
    assert scene(solid("rigid", cube("triangle", 1, 0.002, 0.0, 0.9), "small"), wall)


@pytest.mark.parametrize("d", [2, 3])
def test_within_a_ball(d):
    """Points anywhere, and a closed surface: by their distance from its middle."""
    generator = np.random.default_rng(d)
    if d == 2:
        angle = np.linspace(0, 2 * np.pi, 200, endpoint=False)
        corners = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        simplices = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    else:
        from shapes import ball

        mesh = ball(2000)
        simplices = mesh.points[mesh.cells_dict["triangle"]]
    x = generator.uniform(-1.1, 1.1, (4000, d))
    r = np.linalg.norm(x, axis=1)
    clear = (r < 0.97) | (r > 1.0)
    np.testing.assert_array_equal(within(x[clear], simplices), r[clear] < 0.97)


TWO = """
import sys
sys.path.insert(0, {tests!r})
import numpy as np
from mpi4py import MPI
from processes import HANGS, mpirun
from scenes import box
from fenicsx_contact import Contact, ElasticSolid, InputError, NamedMesh, Scene, name_facets

def solid(n, size, middle, name):
    mesh = box((n,) * 3, (size,) * 3, "tetrahedron", MPI.COMM_WORLD).mesh
    mesh.geometry.x[:] += np.array(middle) - (0, 0, size / 2)
    mesh = name_facets(mesh, {{"skin": lambda x: x[0] < np.inf}})
    return ElasticSolid(mesh, youngs_modulus=1e9, poisson_ratio=0.3, density=1e3, name=name)

large, small = solid(10, 1.0, (0, 0, 0), "large"), solid(2, 0.02, (0.03, 0, 0), "small")
try:
    Scene([large, small], [Contact(small, "skin", (large, "skin"))])
except InputError as error:
    assert "'small' 0.48 inside 'large'" in str(error)
    print("refused")
"""


@pytest.mark.filterwarnings("error")
def test_distances_of_facets_that_are_flat():
    """They count as edges, or as points; without numbers they hid what lay beside them."""
    edge, point = [[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[1, 1, 1]] * 3
    whole = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    for place, facets, distance in (
        ([1.5, 0, 2], [edge], 2.0),
        ([1.5, 0, 2], [point], 1.5),
        ([0.2, 0.2, 0.5], [point, whole, edge], 0.5),
    ):
        found = nearest(np.array([place], dtype=float), np.array(facets, dtype=float))
        assert found == pytest.approx(distance, rel=1e-15)


@needs_mpirun
def test_on_two_processes():
    with mpirun(TWO.format(tests=str(Path(__file__).parent)), 2) as process:
        output, _ = process.communicate(timeout=HANGS)
    assert output.count("refused") == 2, output


def test_bodies_beside_each_other_that_are_thrown_aslant():
    """Nowhere does a facet lie before another, along its normal; yet they meet."""
    small = solid("rigid", cube("triangle", 2, 0.1, 0.8, 0.75), "small", velocity=(-1.0, -1.0))
    large = solid("rigid", cube("triangle", 6, 1.0, 0, 0), "large")
    history = scene(small, large, "gap").run(0.4, 0.01)
    assert history.finished and history["c.bearing"].max() > 0
    assert history["c.penetration"].max() < 1e-9
    assert small.velocity[1] > -0.1 or small.velocity[0] > -0.1


@pytest.mark.second
def test_a_long_step_that_fails_says_nothing_of_a_short_one():
    """What is sought a long way off is not, in a shorter step, what is near."""
    by = {"velocity": lambda x: np.outer([-110.3, -87.1, -782.1], np.ones(x.shape[1]))}
    small = solid("elastic", cube("tetrahedron", 2, 0.0464, *(0.296, -0.062, 0.858)), "small", **by)
    large = solid("rigid", cube("tetrahedron", 4, 1.0, 0, 0, 0), "large")
    history = scene(small, large, "lagrange").run(2e-3, 1e-3)
    assert history.finished, history.reason


@pytest.mark.second
@pytest.mark.parametrize(("d", "seed"), [*product([2], range(10)), *product([3], range(5))])
def test_no_fast_body_ends_inside_in_silence(d, seed):
    """Thrown by chance at what it crosses in a step or two: it is struck, or passes
    by, or the run stops with its reason. What is left inside by a law of velocities is remarked."""
    generator = np.random.default_rng(seed)
    cell = CELLS[2 * (d - 2) + seed % 2]
    kinds = ["rigid", "elastic"][seed % 2], ["rigid", "elastic"][seed // 2 % 2]
    way = np.append(generator.uniform(-0.7, 0.7, d - 1), -1.0)
    way /= np.linalg.norm(way)
    size, step = 10 ** generator.uniform(-1.7, -0.5), generator.uniform(0.1, 2.0)
    start = generator.uniform(-0.3, 0.3, d) - (0.8 + size + generator.uniform(0, step)) * way
    velocity = 1e3 * step * way
    thrown = {"velocity": tuple(velocity)}
    if kinds[0] == "elastic":
        thrown["velocity"] = lambda x: np.outer(velocity, np.ones(x.shape[1]))
    small = solid(kinds[0], cube(cell, 2, size, *start), "small", **thrown)
    large = solid(kinds[1], cube(cell, 4, 1.0, 0, 0, 0), "large")
    pair = (large, small) if seed % 3 == 2 else (small, large)
    history = scene(*pair, ["velocity", "gap", "lagrange"][seed % 3]).run(4e-3, 1e-3)
    deep = 0.0
    for one, other in ((small, large), (large, small)):
        places = one.trace(one.mesh.skin()[0]).positions()
        deep = max(deep, deepest(places, other, np.full(len(places), 0.01 * size)))
    remarks = " ".join(text for _, text in history.remarks)
    assert not deep or not history.finished or "inside its master" in remarks, (deep, history)


@pytest.mark.parametrize("kind", ["rigid", "elastic"])
@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        (Curve([(1, 0), (-1, 0)]), Curve([(-1, 0), (1, 0)])),
        (HalfSpace((0, 0), (0, -1)), HalfSpace((0, 0), (0, 1))),
        (Circle((0, 10), 10.0), Circle((0, 10), 10.0, inside=True)),
        # where its base is deep inside by that, too
        (HalfSpace((0, -0.01), (0, -1)), HalfSpace((0, -0.01), (0, 1))),
        (LevelSet(lambda x, t: -x[1] - 0.01, 2), LevelSet(lambda x, t: x[1] + 0.01, 2)),
    ],
    ids=["curve", "half space", "circle", "off a half space", "off a level set"],
)
def test_an_obstacle_told_the_wrong_way_round_is_refused(kind, wrong, right):
    """A body whose base lay on it was let fall away freely."""
    body = solid(kind, rectangle((4, 4), (0.02, 0.02)), "body")
    Scene([body], [Contact(body, "base", right)])
    with pytest.raises(InputError, match=r"all of 'body', 0.0[23] deep, inside .*wrong way round"):
        Scene([body], [Contact(body, "base", wrong)])


@pytest.mark.parametrize("kind", ["rigid", "elastic"])
@pytest.mark.parametrize("radius", [0.05, 0.2])
def test_an_obstacle_inside_a_body_is_refused(kind, radius):
    """No facet of the body is near it: the body fell as if nothing were there."""
    mesh = rectangle((8, 8), (1.0, 1.0))
    if kind == "rigid":
        body = RigidSolid(mesh, mass=1.0, gravity=(0, -G))
    else:
        numbers = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
        body = ElasticSolid(mesh, gravity=(0, -G), **numbers)
    contact = Contact(body, "base", Circle((0.0, 0.5), radius))
    with pytest.raises(InputError, match=r"the obstacle, .* deep, inside"):
        Scene([body], [contact])
    beside = Contact(body, "base", Circle((0.0, -radius), radius))
    Scene([body], [beside])


def test_how_deep_a_state_is_inside_is_asked_once(monkeypatch):
    """It was computed for what means say alone, and again for the history."""
    lower = solid("elastic", cube("quadrilateral", 1, 2.0, 0.0, -1.0), "lower")
    upper = solid("elastic", cube("quadrilateral", 2, 1.0, 0.0, 0.5), "upper", gravity=(0, -G))
    pair = scene(upper, lower)
    assert pair.run(until=5e-3, dt=1e-3).reason == "finished"
    (contact,) = pair.contacts
    monkeypatch.setattr(Pairing, "depths", None)
    assert 0 <= contact.depth() < 1e-6


def test_a_tip_between_the_nodes_of_a_facet_is_told_as_that():
    """It was blamed on normals, though no gap was ever inside: a tip reaches 4 cm into a facet of
    1 m before the mean over that facet is closed."""
    tip = cube("quadrilateral", 1, 0.2, 0.03, 0.15)
    tip = solid("rigid", tip, "tip", rotation=np.pi / 4, velocity=(0.0, -1.0))
    base = solid("rigid", cube("quadrilateral", 1, 1.0, 0.0, -0.5), "base")
    pair = scene(base, tip, friction=0.3)
    history = pair.run(until=0.1, dt=1e-3)
    remarks = [what for _, what in history.remarks]
    assert history.finished and history["c.penetration"].max() > 0.03
    assert any("inside its master between its nodes" in what for what in remarks), remarks
    assert not any("normals" in what for what in remarks)
