# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies whose whole skins may meet: far sides do not face each other through both bodies."""

import numpy as np
import pytest
from corpus_meshes import moved
from scenes import G, box, rectangle, skinned

from fenicsx_contact import Contact, HalfSpace, InputError, RigidSolid, Scene, name_facets
from fenicsx_contact.contact.mortar.walls import Others

SIZE = 0.08
SKIN = {"skin": lambda x: np.full(x.shape[1], True)}
HELD = ("x", "y", "z", "turning about x", "turning about y", "turning about z")


def at(dim, left, velocity=0.0, rise=0.0, up=0.0, **solid):
    middle = [0.0] * (dim - 2)
    return skinned(dim, SIZE, (left, *middle, up), velocity=(velocity, *middle, rise), **solid)


def pair(dim, gap, velocity=0.0):
    one, other = at(dim, 0.0, velocity), at(dim, SIZE + gap)
    return Scene([one, other], [Contact(one, "skin", (other, "skin"), friction=0.3)])


@pytest.mark.parametrize("gap", [1e-6, 0.1, 0.9])
@pytest.mark.parametrize("dim", [2, 3])
def test_boxes_side_by_side_leave_each_other_alone(dim, gap):
    scene = pair(dim, gap * SIZE)
    (contact,) = scene.contacts
    assert contact.gap.max() == pytest.approx(-gap * SIZE, rel=1e-9)
    history = scene.run(0.01, 1e-3, progress=False)
    assert history.finished
    assert not np.abs(contact.force).any() and not history["kinetic"].any()


@pytest.mark.parametrize("dim", [2, 3])
def test_boxes_meet_face_to_face(dim):
    """Without rebound they go on together, at half of the speed."""
    scene = pair(dim, 0.25 * SIZE, velocity=1.0)
    assert scene.run(0.05, 1e-3, progress=False).finished
    for solid in scene.solids:
        assert solid.velocity[0] == pytest.approx(0.5, rel=1e-12)
        np.testing.assert_allclose(solid.velocity[1:], 0.0, atol=1e-12)
    assert abs(scene.contacts[0].gap.max()) < 1e-12


@pytest.mark.parametrize("dim", [2, 3])
def test_boxes_that_do_not_see_each_other_at_first(dim):
    """Across a corner no facet has a partner: normals are those of all of a corner's facets, and
    friction's frames are of numbers when the bodies meet later, and slide."""
    one, other = at(dim, 0.0), at(dim, 1.3 * SIZE, -1.0, -0.5, 1.5 * SIZE)
    scene = Scene([one, other], [Contact(one, "skin", (other, "skin"), friction=0.3)])
    (contact,) = scene.contacts
    np.testing.assert_allclose(np.linalg.norm(contact.normal, axis=1), 1.0, rtol=1e-14)
    assert np.isfinite(contact.equations.fields.tangent).all()
    history = scene.run(0.1, 1e-3, progress=False)
    assert history.finished, history.reason
    assert history["impact"][-1] < 0 and history["friction"][-1] < 0
    momentum = sum(solid.mass * solid.velocity[:dim] for solid in scene.solids)
    np.testing.assert_allclose(momentum[[0, -1]], other.mass * np.array([-1.0, -0.5]), rtol=1e-12)


def test_boxes_inside_each_other_are_refused():
    with pytest.raises(InputError, match="inside its master"):
        pair(2, -0.3 * SIZE)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("tilt", [0.0, 1e-6, 1e-3])
def test_boxes_of_one_height_overlap_aside_alone(dim, tilt):
    """Top and bottom lie over each other by as little, and deep: they do not count."""
    overlap = 5e-5
    turned = {"rotation": tilt if dim == 2 else (0, tilt, 0)}
    one, other = at(dim, 0.0), at(dim, SIZE - overlap, **turned)
    contact = Contact(one, "skin", (other, "skin"))
    assert contact.gap.max() == pytest.approx(overlap, rel=1e-9, abs=tilt * SIZE)


def test_walls_are_as_thick_as_a_body():
    """What is not so deep as half of it is a penetration."""
    scene = pair(2, 0.1)
    pairing = scene.contacts[0].coupling.pairing
    admits = Others(pairing.slave, pairing.master)
    away = np.array([1.0, -0.49 * SIZE, -0.51 * SIZE])
    for facet in range(4):
        where = np.full(3, facet), np.full(3, facet)
        assert admits(*where, away).tolist() == [True, True, False]


@pytest.mark.parametrize("facets", [1, 2, 8])
@pytest.mark.parametrize("tilt", [(0.0, -0.3, 0.0), (0.2, 0.4, 0.0)])
def test_a_tilted_box_falls_on_a_plate_of_few_facets(facets, tilt):
    """Seen along a tilted facet the middle of a large one is elsewhere, and was taken for a far
    side: a box in the air was "0.3 m inside", or it went 3 mm through the plate, "finished"."""
    ends = []
    for plate in (None, facets):
        body = RigidSolid(
            moved(name_facets(box((1, 1, 1), (0.2, 0.1, 0.1)).mesh, SKIN), 1.1, 0.7, 0.07),
            mass=1.0, gravity=(0.0, 0.0, -G), rotation=tilt, name="box",
        )  # fmt: skip
        below, solids = HalfSpace((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), [body]
        if plate:
            mesh = name_facets(box((plate, plate, 1), (4.0, 4.0, 0.1)).mesh, SKIN)
            solids.append(RigidSolid(moved(mesh, 0.0, 0.0, -0.1), mass=1.0, held=HELD))
            below = solids[1], "skin"
        scene = Scene(solids, [Contact(body, "skin", below)])
        history = scene.run(0.2, 2e-3, progress=False)
        assert history.finished, history.reason
        ends.append(body.place)
    np.testing.assert_allclose(ends[1], ends[0], atol=2e-5)


def named(dim, size, middle, **solid):
    """A rigid box of one cell on a place, all of its facets named skin."""
    make, keep = (rectangle, [0, 2]) if dim == 2 else (box, [0, 1, 2])
    mesh = name_facets(make((1,) * dim, np.array(size)[keep]).mesh, SKIN)
    return RigidSolid(moved(mesh, *np.array(middle)[keep]), mass=1.0, **solid)


@pytest.mark.parametrize("below", [1e-9, 1e-5])
@pytest.mark.parametrize("dim", [2, 3])
def test_what_lies_on_a_long_plank_is_not_inside_from_its_end(dim, below):
    """Its side looks back through the plank at the end, 0.6 m away: once round-off had brought a
    corner below the top it was "0.6 m inside", as half of the mean of both walls is 0.8 m."""
    plank = named(dim, (3.0, 0.2, 0.1), (0.0, 0.0, -0.1), name="plank")
    block = named(dim, (0.2, 0.2, 0.2), (0.8, 0.0, -below), name="block")
    for slave, master in ((block, plank), (plank, block)):
        contact = Contact(slave, "skin", (master, "skin"))
        assert contact.gap.max() == pytest.approx(below, rel=1e-6)


@pytest.mark.parametrize("step", [0.1, 1.0, 3.0])
@pytest.mark.parametrize("small_is_slave", [True, False])
def test_a_small_body_does_not_change_places_with_a_large_one(step, small_is_slave):
    """Across a corner no facet faces another at first. In the mean both are thick, and the small
    one was inside the other, or behind it, after one step, and never struck."""
    size, dt = 10.0, 1e-3
    small = named(2, (0.1, 0.0, 0.1), (0.0, 0.0, 0.0), held=("turning",), name="small")
    large = named(2, (size, 0.0, size), (-size / 2 - 0.06, 0.0, 0.11), held=("turning",),
                  velocity=(step / dt, -step / dt), name="large")  # fmt: skip
    slave, master = (small, large) if small_is_slave else (large, small)
    scene = Scene([small, large], [Contact(slave, "skin", (master, "skin"))])
    assert scene.run(5 * dt, dt, progress=False).finished
    assert small.velocity[1] == pytest.approx(-step / dt / 2, rel=1e-9)
