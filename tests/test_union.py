# SPDX-License-Identifier: LGPL-3.0-or-later
"""Many obstacles as one are what they are one by one."""

import numpy as np
import pytest
from scenes import FLOOR, FLOOR_3D, G, rectangle

from fenicsx_contact import (
    Circle,
    Contact,
    HalfSpace,
    InputError,
    LevelSet,
    Moved,
    RigidSolid,
    Scene,
    Sphere,
    ThetaScheme,
    Turned,
    Union,
    name_facets,
)
from fenicsx_contact.contact.wall import Wall
from fenicsx_contact.gradients import Centre, Start, tangents

PINS = [
    Circle((0.03 * i - 0.03 + 0.015 * j, -0.03 * (1 + j)), 4e-3) for i in (0, 1) for j in (0, 1)
]
BENT = LevelSet(lambda x, t: x[1] + 0.1 - 0.02 * x[0] ** 2, dim=2)


def dropped(masters, law="velocity", start=0.1):
    """A small block that falls through a board of pins, and its height and way."""
    mesh = name_facets(rectangle((1, 1), (0.01, 0.012)).mesh, {"all": lambda x: x[0] == x[0]})
    falls = {"gravity": (0, -G), "rotation": 0.2, "velocity": (start, 0)}
    block = RigidSolid(mesh, density=1000.0, **falls)
    contacts = [
        Contact(block, "all", each, law, friction=0.2, name=f"c{k}")
        for k, each in enumerate(masters)
    ]
    return Scene([block], contacts, ThetaScheme(0.5)), block


@pytest.mark.parametrize("law", ["velocity", "gap"])
def test_a_board_of_pins_is_one_contact(law):
    """Over a floor that goes up and down."""
    floor = Moved(HalfSpace((0, -0.09), (0, 1)), lambda t: (0.0, 0.005 * np.sin(40 * t)))
    histories = []
    for masters in ([*PINS, floor], [Union([*PINS, floor])]):
        scene, block = dropped(masters, law)
        probes = {"x": Centre(block, (1, 0)).value, "y": Centre(block, (0, 1)).value}
        histories.append(scene.run(0.2, 1e-3, probes=probes))
    each, one = histories
    assert each.finished and one.finished
    assert each["friction"][-1] < -1e-3 * each["kinetic"].max()  # it met some
    assert np.abs(each["drive"]).max() > 1e-3 * each["kinetic"].max()
    for name in ("x", "y", "kinetic", "friction", "impact", "drive"):
        np.testing.assert_allclose(one[name], each[name], atol=1e-7 * np.abs(each[name]).max())


def test_what_it_answers_is_of_the_nearest():
    parts = [
        Sphere((0, 0, 0), 1.0),
        Moved(FLOOR_3D, lambda t: (0, t, -3 + t)),
        Turned(Sphere((2, 0, 0), 0.8), (0, 0, 0), lambda t: t, (0, 0, 1)),
    ]
    union, walls = Wall(Union(parts)), [Wall(each) for each in parts]
    points = 6 * np.random.default_rng(3).random((60, 3)) - 3
    assert union.smooth and union.moving and not union.flat
    for t in (0.0, 1.3):
        every = np.array([wall.distance(points, t) for wall in walls])
        which = every.argmin(axis=0)
        assert len(np.unique(which)) == 3
        np.testing.assert_array_equal(union.distance(points, t), every.min(axis=0))
        for k, wall in enumerate(walls):
            mine, there = points[which == k], which == k
            for what in ("normals", "slopes"):
                of_all, of_one = (getattr(each, what) for each in (union, wall))
                np.testing.assert_array_equal(of_all(points, t)[there], of_one(mine, t))
            bend = wall.curvature(mine, t)
            bend = np.zeros((len(mine), 3, 3)) if bend is None else bend
            np.testing.assert_array_equal(union.curvature(points, t)[there], bend)
            known = wall.velocity(mine, t - 0.1, t)
            np.testing.assert_array_equal(union.velocity(points, t - 0.1, t)[there], known)


def test_without_curvature_it_has_none():
    """Not even of those that tell theirs: a derivative of a run would be wrong."""

    class Bare:
        dim = 2

        def distance(self, points):
            return points[:, 1]

        def normals(self, points):
            return np.tile([0.0, 1.0], (len(points), 1))

    union = Wall(Union([Bare(), *PINS]))
    assert not union.smooth and union.curvature(np.zeros((1, 2)), 0.0) is None
    assert not union.moving and Wall(Union(PINS)).smooth


def test_derivatives_through_a_board():
    def ends(start):
        scene, block = dropped([Union([*PINS, BENT])], "velocity", start)
        return scene, {"x": Centre(block, (1, 0)), "y": Centre(block, (0, 1))}, block

    scene, asked, block = ends(0.1)
    found = tangents(scene, 0.06, 1e-3, {"v": Start(block, velocity=(1, 0))}, asked)
    h, values = 1e-7, []
    for start in (0.1 - h, 0.1 + h):
        scene, asked, _ = ends(start)
        assert scene.run(0.06, 1e-3).finished
        values.append([each.value() for each in asked.values()])
    expected = (np.array(values[1]) - values[0]) / (2 * h)
    for each, number in zip(asked, expected):
        assert found[each][-1, 0] == pytest.approx(number, rel=1e-5)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (lambda: Union([]), r"obstacles = \[\]: must be a list of at least one"),
        (lambda: Union(FLOOR), "must be a list of at least one"),
        (lambda: Union([FLOOR, "wall"]), r"obstacles\[1\] = 'wall'"),
        (lambda: Union([FLOOR, FLOOR_3D]), r"obstacles\[1\].dim = 3: must be 2"),
        (lambda: Union(5), "obstacles = 5: must be a list"),
    ],
)
def test_refused(given, told):
    with pytest.raises(InputError, match=told):
        given()
