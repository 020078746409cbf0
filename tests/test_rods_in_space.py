# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rods in space: what slides along a round wall turns its normal; what leaves its guide says so."""

import numpy as np
import pytest

from fenicsx_contact import (
    BeamSolid,
    Discrete,
    Section,
    axis_mesh,
)
from fenicsx_contact.contact.arrivals import missed, went_inside
from fenicsx_contact.rods import AnyCurve, Guide, GuideContact, RodDrop, Sine, Tube, settle


def bent(dim, clearance, curve, friction, law=None):
    """A rod of 2 m in a long bent tube."""
    zero = (0.0,) * dim

    def rod():
        axis = axis_mesh(zero, (*zero[1:], 1), rod=(2.0, 20))
        return BeamSolid(axis, Section(mass=3, bending=500), gravity=(*zero[1:], -9.81), law=law)

    return RodDrop(rod, "rod", Guide([Tube(-3, 3, clearance, curve)], zero), friction=friction)


@pytest.mark.parametrize(("clearance", "step"), [(5e-4, 1e-2), (2e-4, 4e-3), (2e-4, 1e-3)])
def test_a_plane_tube_in_space_is_a_plane_problem(clearance, step):
    """A rod that is pressed on a round wall is pushed back to its lowest line, as stiffly as the
    hole is narrow: explicitly, that would throw the rod out of it."""
    flat, space = (
        bent(dim, clearance, Sine(8e-3, 2.0), 0.3).insert(0.1, step=step).history for dim in (2, 3)
    )
    assert flat.finished and space.finished and len(flat) == len(space)
    for column in ("normal", "wall", "rubbing", "guide.penetration"):
        size = np.abs(flat[column]).max()  # the start is sudden
        np.testing.assert_allclose(space[column][5:], flat[column][5:], atol=1e-3 * size)
    assert space["guide.penetration"].max() < 0.2 * clearance


def helix(radius=4e-3, pitch=2.0):
    k = 2 * np.pi / pitch
    return AnyCurve(
        lambda x: radius * np.stack([np.cos(k * x) - 1, np.sin(k * x)], axis=1),
        lambda x: radius * k * np.stack([-np.sin(k * x), np.cos(k * x)], axis=1),
    )


def test_a_helix_holds_its_rod():
    """Long steps are as those a twentieth of them."""
    drop = bent(3, 5e-4, helix(), 0.2)
    long, short = (drop.insert(0.1, step=step).history for step in (1e-2, 5e-4))
    for history in (long, short):
        assert history.finished and history["guide.penetration"].max() < 0.05 * 5e-4
        assert not history.remarks
    assert long["normal"][-1] == pytest.approx(short["normal"][-1], rel=0.02)


def test_normals_turn_as_newtons_method_is_told():
    """Roundness is the derivative of the normals by the place across the guide, up to slopes."""
    rod, guide = bent(3, 5e-4, helix(), 0.2)._rod(), Guide([Tube(-3, 3, 5e-4, helix())], (0, 0, 0))
    settle(rod, "rod", guide)
    contact = GuideContact(rod, "rod", guide)
    touch, near = contact.coupling, contact.gap > -contact.tolerance
    roundness, before = touch._roundness()[near], touch.normals()[near]
    assert near.sum() > 5
    for i, across in enumerate(rod.frame):
        moved = rod.displacement.copy()
        rod.split(moved)[0][i, ::2] += 1e-9
        rod.trial_displacement = moved
        touch.follow()
        turned = (touch.normals()[near] - before) / 1e-9
        np.testing.assert_allclose(turned, roundness @ across, atol=0.02 / 5e-4)


def test_a_rod_that_is_deep_in_its_wall_is_cut_or_told():
    """Rigid walls let none through; springs give way as they are told to."""
    for law, tells in (("velocity", True), (Discrete(1e5, 20.0), False)):
        guide = Guide([Tube(-3, 3, 5e-4)])
        rod = bent(2, 5e-4, Sine(0.0, 2.0), 0.0)._rod()
        contact = GuideContact(rod, "rod", guide, law, name="c")
        assert missed(contact, True) == "" and not went_inside(contact, 2e-5, 1e-3)
        rod.trial_displacement = rod.displacement + 2e-3
        contact.follow()
        told = missed(contact, True), went_inside(contact, 5e-5, 1e-3)
        if not tells:
            assert told == ("", "")
            continue
        assert "'beam' leaves its guide sideways at the depth" in told[0]
        assert "contact 'c' went 5e-05 m into the walls of its guide" in told[1]


def test_too_long_a_step_is_told():
    """In the plane, too, what drifts into the walls by more than a rod may start with."""
    way = bent(2, 2e-4, Sine(8e-3, 2.0), 0.3).insert(0.05, step=1e-2).history
    assert way.finished and way["guide.penetration"].max() > 0.05 * 2e-4
    assert "into the walls of its guide" in way.remarks[-1][1]
