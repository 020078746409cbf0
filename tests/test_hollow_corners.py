# SPDX-License-Identifier: LGPL-3.0-or-later
"""Hollow corners of a curve: what lies in one, or slides into one, meets both faces."""

import numpy as np
import pytest

from fenicsx_contact import (
    Contact,
    Curve,
    ElasticSolid,
    HalfSpace,
    InputError,
    QuasiStatic,
    RigidSolid,
    Scene,
    mesh_from_gmsh,
)

GROOVE = [(-2, 0), (-1, 0), (-1, -1), (1, -1), (1, 0), (2, 0)]
ROOM = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2), (0, 0)]
ROUND = np.radians(np.arange(-100, 101, 10))
DROP = [(-3.0, 0.0), *np.column_stack([np.cos(ROUND), np.sin(ROUND)]), (-3.0, 0.0)]
KEY = [(-9, 0.18), (-0.1, 0), (-1, 1), (1, 1), (0.1, 0), (9, 0.18)]  # undercut
LEVEL, STEP = [(-1, 0), (0.05, 0)], [(0.05, 0), (0.05, 1)]


@pytest.mark.quick
@pytest.mark.parametrize(
    "points, corners, lines",
    [
        (GROOVE, [2, 3], [2, 1, 2]),
        (ROOM, [0, 1, 2, 4, 5], [1, 1, 2, 1, 1]),
        (ROOM[1:-1] + ROOM[:2], [0, 1, 3, 4, 5], [1, 2, 1, 1, 1]),
        (ROOM[3:-1] + ROOM[:4], [1, 2, 3, 4, 5], [1, 1, 1, 1, 2]),
        (LEVEL + STEP[1:], [1], [1, 1]),
        (LEVEL, [], [1]),
        ([(0, 0), (0, 1), (1, 1), (1, 0), (0, 0)], [], [4]),  # a body that fills its corners
        ([(-1, 0), (0, 0), (1, 0.4)], [], [2]),  # not sharp
    ],
)
def test_what_lies_behind_any_face_is_the_body(points, corners, lines):
    curve = Curve(points)
    faces = curve.faces()
    assert curve.hollow().tolist() == corners
    assert [len(face._along) for face in faces] == lines
    assert bool(curve.remark) == bool(corners)
    x = np.stack(np.meshgrid(*2 * [np.linspace(-1.97, 2.96, 70)]), axis=2).reshape(-1, 2)
    each = np.array([face.distance(x) for face in faces])
    whole = curve.distance(x)
    np.testing.assert_array_equal((each < 0).any(axis=0), whole < 0)
    # outside the nearest face is as far as the body is
    np.testing.assert_allclose(each.min(axis=0)[whole > 0], whole[whole > 0], atol=1e-14)


@pytest.mark.quick
@pytest.mark.parametrize(
    "points, words",
    [
        ([(0, 0), (0, 2), (1, 2), (1, 1), (2, 1), (2, 0), (0, 0)], ("points[3]", "points[5:7]")),
        ([(-1, 0), (0, 0), (0, 1), (2, 1), (2, -1), (3, -1)], ("points[1]", "points[3:5]")),
        ([(-1, 1), (-1, 0), (0, 0), (0, 1), (2, 1), (2, -1), (3, -1)], ("points[2]", "before")),
        (DROP, ("points[0]", "only")),
        (KEY, ("[-0.1, 0.0]", "[0.1, 0.0]", "narrower")),
    ],
)
def test_faces_that_leave_the_body_are_refused(points, words):
    with pytest.raises(InputError) as refusal:
        Curve(points).faces()
    for word in words:
        assert word in str(refusal.value)


def room_or_body(rng):
    """A polygon with some corners, around the origin."""
    angles = np.sort(rng.uniform(0, 2 * np.pi, rng.integers(3, 9)))
    points = np.column_stack([np.cos(angles), np.sin(angles)])
    points *= rng.uniform(0.3, 1.0, len(points))[:, None] * [rng.uniform(0.3, 3), 1]
    return np.vstack([points, points[:1]])[:: rng.choice([-1, 1])]


def ground(rng):
    """With overhangs, between two ends that rise or fall a little."""
    n = rng.integers(3, 9)
    x, y = np.cumsum(rng.uniform(-0.3, 1.0, n)), rng.uniform(-1, 1, n)
    first, last = y[[0, -1]] + rng.uniform(-0.3, 0.3, 2)
    return [(x.min() - 1, first), *zip(x, y), (x.max() + 1, last)]


@pytest.mark.parametrize("drawn", [room_or_body, ground])
def test_faces_of_anything_are_its_body_or_refused(drawn):
    """Near and far."""
    rng, kept = np.random.default_rng(7), 0
    for _ in range(400):
        try:
            curve = Curve(drawn(rng))
            faces = curve.faces()
        except InputError:
            continue
        kept += len(faces) > 1
        x = rng.normal(size=(500, 2)) * rng.choice([0.5, 2, 10], (500, 1))
        each, whole = np.array([face.distance(x) for face in faces]), curve.distance(x)
        np.testing.assert_array_equal((each < 0).any(axis=0), whole < 0)
    assert kept > 50


def soft(**others):
    """A block of 0.1 m whose lower right corner is in that of level and step."""
    mesh = mesh_from_gmsh("block.geo", width=0.1, height=0.1, n_width=2, n_height=2)
    elastic = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
    return ElasticSolid(mesh, **elastic, gravity=(0.0, -9.81), **others)


def in_the_corner(walls, law, **others):
    block = soft(velocity=lambda x: np.array([[1.5], [0.0]]) + 0 * x[:2])
    contacts = [
        Contact(block, side, wall, law, friction=0.1, name=f"{side} {i}")
        for i, wall in enumerate(walls)
        for side in ("base", "right")
    ]
    return block, Scene([block], contacts, **others).run(0.04, 2e-3)


@pytest.mark.parametrize("law, located", [("velocity", False), ("velocity", True), ("gap", False)])
def test_a_block_is_thrown_into_a_corner(law, located):
    """By the faces of a curve as by two half-spaces, to the last digits, and nothing goes inside;
    of the curve as one obstacle such a run stops, or stays inside, which is remarked."""
    curve = Curve(LEVEL + STEP[1:])
    planes = HalfSpace((0, 0), (0, 1)), HalfSpace((0.05, 0), (-1, 0))
    block, history = in_the_corner(curve.faces(), law, locate_impacts=located)
    other, expected = in_the_corner(planes, law, locate_impacts=located)
    assert history.reason == expected.reason == "finished"
    np.testing.assert_allclose(history["kinetic"], expected["kinetic"], rtol=1e-9)
    np.testing.assert_allclose(
        block.fields()["displacement"], other.fields()["displacement"], atol=1e-12
    )
    deepest = [history[name].max() for name in history.columns if name.endswith("penetration")]
    assert max(deepest) < 1e-10
    _, alone = in_the_corner([curve], law)
    assert "faces()" in alone.remarks[0][1]


def test_a_seal_fills_its_groove():
    """A block that is pressed into a groove as wide as it is: nu / (1 - nu) of the pressure bears
    on the walls, exactly, in plane strain without friction."""
    mesh = mesh_from_gmsh("block.geo", width=0.1, height=0.1, n_width=4, n_height=4)
    block = ElasticSolid(
        mesh,
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1.0,
        tractions={"top": (0.0, -1e4)},
    )
    groove = Curve([(-1, 0.2), (-0.05, 0.2), (-0.05, 0), (0.05, 0), (0.05, 0.2), (1, 0.2)])
    contacts = [
        Contact(block, side, face, name=side)
        for side, face in zip(("left", "base", "right"), groove.faces())
    ]
    history = Scene([block], contacts, QuasiStatic()).run(1.0, 1.0)
    assert history.reason == "finished"
    base, *sides = (contacts[i].force.sum(axis=0) for i in (1, 0, 2))
    np.testing.assert_allclose(base, (0, 1e3), atol=1e-6)
    for force, sign in zip(sides, (1, -1)):
        np.testing.assert_allclose(force, (sign * 1e3 * 0.3 / 0.7, 0), atol=1e-6)


def test_a_rigid_block_stands_in_a_room():
    """One contact with each face of a room, all sides of the block before all of them."""
    mesh = mesh_from_gmsh("block.geo", width=0.2, height=0.1, n_width=1, n_height=1)
    mesh.mesh.geometry.x[:, :2] += 0.1, 0.0
    block = RigidSolid(mesh, density=1000.0, gravity=(0.0, -9.81), velocity=(-1.0, 0.0))
    contacts = [
        Contact(block, side, face, friction=0.2, name=f"{side} {i}")
        for i, face in enumerate(Curve(ROOM).faces())
        for side in ("base", "left")
    ]
    history = Scene([block], contacts).run(0.1, 5e-3)
    assert history.reason == "finished"
    np.testing.assert_allclose(block.fields()["displacement"], 0.0, atol=1e-12)
    weight = sum(contact.force.sum(axis=0) for contact in contacts)
    np.testing.assert_allclose(weight, (0, 0.2 * 0.1 * 1000 * 9.81), rtol=1e-9, atol=1e-7)
