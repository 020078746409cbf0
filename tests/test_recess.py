# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rods whose surface stands back from the one that the clearances of guides are for."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fenicsx_contact import (
    BeamSolid,
    Driven,
    Fall,
    InputError,
    Scene,
    Section,
    Support,
    ThetaScheme,
    Velocity,
    axis_mesh,
)
from fenicsx_contact.rods import Card, Guide, GuideContact, RodInTube, Sine, Tube, settle

L, EI, C = 3.66, 850.0, 0.775e-3
ROD = Section(mass=16.662, bending=EI)


def half_wave(recess, clearance, dim=2, tube=False):
    """Half a wavelength of an endless beam, held at the inflexions, in a sine, at rest."""
    half, zero = L / 2, (0.0,) * (dim - 1)
    pins = [Support(0, lateral=math.inf, axial=math.inf), Support(half, lateral=math.inf)]

    def beam(name, cells, **section):
        axis = axis_mesh((*zero, -half), (*zero, 1), **{name: (half, cells)})
        return BeamSolid(axis, replace(ROD, **section), supports=pins, name=name)

    rod = beam("rod", 38, recess=recess)
    guide = Guide([Tube(-0.01, half + 0.01, clearance, Sine(0.005, L, "kinked"))], (*zero, 0.0))
    return settle(RodInTube(rod, beam("tube", 22)) if tube else rod, "rod", guide)


@pytest.mark.parametrize("tube", [False, True], ids=["rigid", "elastic"])
@pytest.mark.parametrize("dim", [2, 3])
def test_an_even_recess_is_clearance(dim, tube):
    wide = half_wave(0.0, 1.2 * C, dim, tube)
    for recess in (0.2 * C, lambda s: 0.2 * C + 0 * s):
        back = half_wave(recess, C, dim, tube)
        np.testing.assert_allclose(back.force, wide.force, atol=1e-6 * wide.normal_force())


def test_a_taper_at_three_cards():
    """Three point loads bend a rod by what its tapered surface leaves, exactly."""

    def recess(s):
        return 0.4e-3 * s - 0.3e-3

    rod = BeamSolid(axis_mesh((0, -2), (0, 1), rod=(2.0, 46)), replace(ROD, recess=recess))
    places = np.array([0.31, 1.03, 1.77])
    cards = [Card(places[0], C), Card(places[1], C, centre=5e-3), Card(places[2], C)]
    contact = settle(rod, "rod", Guide(cards))
    (first, middle, last), (a, b) = C + recess(2 - places), np.diff(places)
    bent = 5e-3 - middle - (b * first + a * last) / (a + b)
    load = 3 * EI * (a + b) / (a * b) ** 2 * bent
    exact = load * np.array([-b / (a + b), 1.0, -a / (a + b)])
    np.testing.assert_allclose(contact.force[contact.stations, 0], exact, rtol=1e-3)
    assert abs(contact.gap[contact.stations]).max() < 1e-6 * C


@pytest.mark.parametrize("dim", [2, 3])
def test_a_wedge_that_falls_past_cards(dim):
    """A flow holds a falling rod to two cards: its taper k lets it aside at k times its speed, and
    ``(1 + k²) z'' = g + k Q/m``, as a wedge's on a slope."""
    k, flow, length, until = 5e-3, 40.0, 3.0, 0.3
    section = Section(mass=16.662, bending=1e8, recess=lambda s: k * s)
    zero = (0.0,) * (dim - 1)
    rod = BeamSolid(
        axis_mesh((*zero, -length), (*zero, 1), rod=(length, 30)),
        section,
        gravity=(*zero, -9.81),
        law=Fall(),
        lateral_load=lambda s: np.array([[flow], [0.0]])[: dim - 1] + 0 * s,
    )
    # holes at which it lies upright
    guide = Guide([Card(1.0, C), Card(2.0, C + k * 1.0)], (*zero, 0.0))
    side = rod.frame[0] @ guide.lateral[0]
    lies = np.full(31, (C + k * (length - 1.0)) * side)
    rod.deflect(np.stack([lies, 0 * lies], axis=1)[:, : dim - 1])
    contact = GuideContact(rod, "rod", guide, Velocity(0.1), name="c")
    assert contact.gap[contact.stations] == pytest.approx(0, abs=1e-12)
    history = Scene([rod], [contact], ThetaScheme(0.6)).run(until, 1e-3, progress=False)
    assert history.finished, history.reason
    pull = flow / section.mass
    assert rod.speed == pytest.approx((9.81 + k * pull) / (1 + k**2) * until, rel=1e-6)
    aside = rod.split(rod.velocity)[0][0, ::2] * side
    assert aside == pytest.approx(k * rod.speed, rel=3e-4)
    assert np.abs(history["balance"]).max() < 1e-9
    assert abs(contact.gap[contact.stations]).max() < 0.05 * C


def test_what_does_not_change_in_motion():
    """Pushed through a bent tube, nodes and stations: as with that much more clearance."""
    found = []
    for recess, clearance in ((0.0, C), (-0.5 * C, 1.5 * C)):
        rod = BeamSolid(axis_mesh((0, -1), (0, 1), rod=(1.0, 12)), replace(ROD, recess=recess))
        guide = Guide([Tube(-1, 1.5, clearance, Sine(0.01, 1.8)), Card(1.8, clearance)])
        settle(rod, "rod", guide)
        rod.law = Driven(1.0)
        contact = GuideContact(rod, "rod", guide, Velocity(0.1), 0.3, name="c")
        scheme = ThetaScheme(1.0, forces="end")
        history = Scene([rod], [contact], scheme).run(0.3, 1e-3, progress=False)
        assert history.finished, history.reason
        found.append([history["c.force_x"].cumsum(), history["strain"]])
    for a, b in zip(*found):
        np.testing.assert_allclose(a, b, atol=1e-6 * np.abs(a).max())


TIGHT = "recess = {}, clearance = {}: their sum must be > 0; at the depth {} m 'rod' does not fit"


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("tube", [False, True], ids=["rigid", "elastic"])
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("recess", [-2e-3, -C, lambda s: np.where(s > 1.0, 0.0, -2e-3)])
def test_a_rod_thicker_than_its_hole_does_not_settle(dim, tube, recess):
    value = recess if isinstance(recess, float) else -2e-3
    with pytest.raises(InputError, match=TIGHT.format(value, C, r"[\d.]+")):
        half_wave(recess, C, dim, tube)


def plug(low, high, guide):
    """A rod of 2 m, thick above ``low``, that is pushed down at 1 m/s from the depth 1 m on."""
    section = replace(ROD, recess=lambda s: np.where(s > low, -high, 0.0))
    axis = axis_mesh((0, -2), (0, 1), rod=(2.0, 20))
    rod = BeamSolid(axis, section, law=Driven(1.0), name="rod")
    return rod, GuideContact(rod, "rod", Guide(guide, (0, -1.0)), name="c")


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("guide", [[Tube(0.2, 6, C)], [Card(0.2, C), Card(0.7, 3 * C)]])
def test_a_thick_part_that_comes_to_a_hole_stops(guide):
    """From 1.2 m, 0.2 m above the hole, on it gets thicker within a cell of 0.1 m."""
    rod, contact = plug(1.25, 2 * C, guide)
    history = Scene([rod], [contact], ThetaScheme(0.6)).run(1.0, 2e-3, progress=False)
    assert "at the depth 0.2 m 'rod' does not fit" in history.reason, history.reason
    assert rod.travel == pytest.approx(0.4 + 0.05, abs=1e-4)
    with pytest.raises(InputError, match=TIGHT.format(-2 * C, C, 0.2)):
        plug(0.75, 2 * C, guide)


def test_a_thick_part_that_stays_out_of_holes_does_no_harm():
    rod, contact = plug(1.95, 2 * C, [Tube(0.2, 6, C)])
    history = Scene([rod], [contact], ThetaScheme(0.6)).run(1.0, 2e-3, progress=False)
    assert history.finished and rod.travel == pytest.approx(1.0)


def test_bad_input_is_refused():
    with pytest.raises(InputError, match="recess = nan: must be a finite number"):
        Section(mass=1.0, bending=1.0, recess=math.nan)
    section = Section(mass=1.0, bending=1.0, recess=lambda s: s[:1])
    with pytest.raises(InputError, match="recess = lambda at"):
        BeamSolid(axis_mesh((0, -1), (0, 1), rod=(1.0, 4)), section)
