# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies whose whole skins may meet: far sides do not face each other through both bodies."""

import numpy as np
import pytest
from corpus_meshes import moved
from scenes import G, box, skinned

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
