# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rods in space: what slides along a round wall turns its normal; what leaves its guide says so."""

import numpy as np
import pytest

from fenicsx_contact import (
    BeamSolid,
    Discrete,
    Driven,
    Fall,
    InputError,
    Scene,
    Section,
    ThetaScheme,
    axis_mesh,
)
from fenicsx_contact.contact.arrivals import missed, went_inside
from fenicsx_contact.rods import (
    AnyCurve,
    Card,
    Guide,
    GuideContact,
    RodDrop,
    Sine,
    Straight,
    Tube,
    settle,
)
from fenicsx_contact.theory.scheme import Step


def bent(dim, clearance, curve, friction, law=None):
    """A rod of 2 m in a long bent tube."""
    zero = (0.0,) * dim

    def rod():
        axis = axis_mesh(zero, (*zero[1:], 1), rod=(2.0, 20))
        return BeamSolid(axis, Section(mass=3, bending=500), gravity=(*zero[1:], -9.81), law=law)

    return RodDrop(rod, "rod", Guide([Tube(-3, 3, clearance, curve)], zero), friction=friction)


@pytest.mark.parametrize(("clearance", "step"), [(2e-4, 1e-2), (2e-4, 4e-3), (2e-4, 1e-3)])
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
    roundness, before = touch.roundness()[near], touch.normals()[near]
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
    step = Step(1e-3, ThetaScheme())
    for law, tells in (("velocity", True), (Discrete(1e5, 20.0), False)):
        guide = Guide([Tube(-3, 3, 5e-4)])
        rod = bent(2, 5e-4, Sine(0.0, 2.0), 0.0)._rod()
        contact = GuideContact(rod, "rod", guide, law, name="c")
        assert missed(contact, step, True) == "" and not went_inside(contact, 2e-5, 1e-3)
        rod.trial_displacement = rod.displacement + 2e-3
        contact.follow()
        told = missed(contact, step, True), went_inside(contact, 5e-5, 1e-3)
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


# -- travels -----------------------------------------------------------------------------------


def falling(stop=None, bottom=5.0, **law):
    """A rod of 2 m over a straight tube, its tip at the depth 0."""

    def rod():
        axis = axis_mesh((0, 0), (0, 1), rod=(2.0, 4))
        section = Section(mass=3.0, bending=500.0)
        return BeamSolid(axis, section, gravity=(0, -9.81), law=Fall(stop=stop, **law))

    scheme = ThetaScheme(0.5)
    return RodDrop(rod, "rod", Guide([Tube(-5, bottom, 2e-3)]), scheme=scheme)


def test_when_a_travel_is_passed():
    """From the start, between rows, next to a turning point, on the way out; NaN where never."""
    drop = falling(stop=1.0, stop_stiffness=2e4)
    fall = drop.fall(2.0, 1e-2, to=np.inf)
    for z in (0.0, 1e-5, 0.3, 0.9):
        assert fall.time_at(z) == pytest.approx(np.sqrt(2 * z / 9.81), abs=1e-9)
        assert fall.speed_at(z) == pytest.approx(np.sqrt(2 * z * 9.81), abs=1e-2)
    top, time = fall.history["travel"].max(), fall.history.time
    last = time[fall.history["travel"].argmax()]
    assert last - 1e-2 < fall.time_at(top - 1e-7) <= last == pytest.approx(fall.time_at(top))
    assert np.isnan(fall.time_at(top + 1e-3)) and np.isnan(fall.time_at(-1e-3))
    assert np.isnan(fall.speed_at(2 * top))
    out = drop.withdraw(1.0, speed=0.5, step=1e-2)
    for z in (1.0, 0.905, 0.5, 0.0):
        assert out.time_at(z) == pytest.approx(2.0 + (1.0 - z) / 0.5, abs=1e-9)
        assert out.speed_at(z) == pytest.approx(-0.5)


@pytest.mark.parametrize("goes_on", [True, False])
def test_only_an_end_of_the_rod_butts_on_the_way_out(goes_on):
    """What was pushed through a card comes back into it from below, sent beside its hole by a tube
    that leans: where the rod goes on it is as bent again as it was, where it ends it butts."""
    guide = Guide([Card(-0.5, 1e-3), Tube(0, 3, 1e-4, Straight(0.0032))])

    def rod():
        above = {"above": (1.0, 5)} if goes_on else {}
        axis = axis_mesh((0, -0.4), (0, 1), guided=(1.0, 5), **above)
        return BeamSolid(axis, Section(mass=1.0, bending=100.0))

    out = RodDrop(rod, "guided", guide).withdraw(0.12).history
    if goes_on:
        assert out.finished, out.reason
        bent = RodDrop(rod, "guided", guide).insert(0.12).history["lateral"]
        assert bent.min() < 0.1 * bent[0]
        assert out["lateral"][-1] == pytest.approx(bent[0], rel=1e-3)
    else:
        assert "the tip of 'beam' butts at the depth -0.5 m" in out.reason


def test_a_travel_beyond_the_stop_is_not_reached():
    drop = falling(stop=0.2, stop_stiffness=2e4)
    back = drop.fall(2.0, 1e-3, to=3.0).history
    assert "the stop turned 'beam' back at the travel 0.23" in back.reason and not back.finished
    assert "before to = 3 m" in back.reason
    assert drop.fall(2.0, 1e-3, to=0.21).history.finished


def test_a_rod_leaves_its_guide():
    """It is refused where its way is known, and told where it falls."""
    short = falling(bottom=0.3)
    for go in (lambda: short.insert(0.4), lambda: short.withdraw(0.4), lambda: short.fall(to=0.4)):
        with pytest.raises(
            InputError, match=r"depth 0\.4 m, beyond the end of its guide at 0\.3 m"
        ):
            go()
    fall = short.fall(0.3, 1e-2).history
    ((time, remark),) = fall.remarks
    assert remark == "'beam' leaves its guide at the lower end"
    assert time == pytest.approx(np.sqrt(2 * 0.3 / 9.81), abs=1e-9)
    assert not falling().fall(0.3, 1e-2).history.remarks


def test_a_rod_that_hangs_low_is_pushed_in_from_there():
    """Its axis stretches by its own weight: so much nearer it is to the end of its guide."""

    def hanging():
        axis, section = axis_mesh((0, 0), (0, 1), rod=(2.0, 10)), Section(4.0, 300.0, axial=1e3)
        return BeamSolid(axis, section, gravity=(0, -9.81), law=Fall())

    low = 4.0 * 9.81 * 2.0**2 / (2 * 1e3)
    for bottom in (low + 0.049, low + 0.051):
        drop = RodDrop(hanging, "rod", Guide([Tube(-5, bottom, 2e-3)]))
        if bottom < low + 0.05:
            with pytest.raises(InputError, match=f"depth {low + 0.05:.6g} m, beyond the end"):
                drop.insert(0.05, step=1e-2)
        else:
            assert not drop.insert(0.05, step=1e-2).history.remarks


def test_cards_below_the_last_tube_are_of_the_guide():
    drop = falling(bottom=0.3)
    drop.guide = Guide([Tube(-5, 0.3, 2e-3), Card(0.5, 2e-3)], drop.guide.origin)
    fall = drop.fall(2.0, 1e-2, to=0.4).history
    assert fall.finished and not fall.remarks and drop.guide.bottom == np.inf
    assert Guide([Tube(-5, 0.3, 2e-3), Card(0.3, 1e-3)]).bottom == 0.3


def test_a_table_that_ends_within_its_tube():
    """The clearance goes on as it ends, and the throat is a station."""
    short = Tube(-3, 3, [(-0.5, 5e-3), (0.0, 1e-3)])
    whole = Tube(-3, 3, [(-3, 5e-3), (-0.5, 5e-3), (0.0, 1e-3), (3, 1e-3)])
    assert short.stations() == whole.stations() == [-3, 0, 3]
    x = np.stack([np.full(50, 3e-4), np.linspace(-3.1, 3.1, 50)], axis=1)
    np.testing.assert_array_equal(Guide([short]).distance(x), Guide([whole]).distance(x))
    pressed = BeamSolid(
        axis_mesh((0, -0.3), (0, 1), rod=(2.0, 3)),
        Section(mass=3.0, bending=500.0),
        law=Driven(),
        lateral_load=lambda s: np.full((1, len(s)), 20.0),
    )
    guide = Guide([short])
    settle(pressed, "rod", guide)
    contact = GuideContact(pressed, "rod", guide, name="c")
    history = Scene([pressed], [contact], ThetaScheme(1.0, forces="end")).run(1.0, 2e-2)
    throat = contact.stations[1]
    assert history.finished and contact.trace.positions()[throat, 0] == pytest.approx(1e-3)
