# SPDX-License-Identifier: LGPL-3.0-or-later
"""Beams that their own axial force bends, against exact solutions: columns that a drive pushes,
strings that it pulls, chains, stops that are struck, rods that buckle in tubes."""

import math

import numpy as np
import pytest
from scenes import rates

from fenicsx_contact import (
    BeamSolid,
    Driven,
    Fall,
    Scene,
    Section,
    Support,
    ThetaScheme,
    axis_mesh,
)
from fenicsx_contact.rods import (
    Guide,
    GuideContact,
    RodDrop,
    RodInTube,
    Sine,
    Tube,
    VonKarmanBeam,
    settle,
)
from fenicsx_contact.theory.scheme import Step

EI, EA, L, MASS = 70.0, 1e6, 2.0, 1.0
FAST, STATIC = math.inf, ThetaScheme(1.0, forces="end")
PIN, CLAMP = {"lateral": FAST}, {"lateral": FAST, "rotational": FAST}


def rod(cells=20, dim=2, axial=EA, bending=EI, kind=VonKarmanBeam, **others):
    up = [0.0] * (dim - 1) + [1.0]
    axis = axis_mesh([0.0] * dim, up, all=(L, cells))
    return kind(axis, Section(MASS, bending, axial=axial), **others)


def axial(beam):
    return beam.split(beam.displacement)[1]


@pytest.mark.parametrize(
    ("low", "high", "length", "dim"),
    [
        (PIN, PIN, 1.0, 2),
        (PIN, PIN, 1.0, 3),
        (CLAMP, CLAMP, 0.5, 2),
        (CLAMP, PIN, 0.699155660, 2),
        (CLAMP, {}, 2.0, 2),
    ],
    ids=["pinned", "in space", "clamped", "propped", "free"],
)
def test_a_pushed_column_bears_eulers_load(low, high, length, dim):
    """The force of the drive that pushes it comes to rest there, whatever the way: pi² EI/(KL)²,
    and the column bows by what its ends have come nearer: e = N/EA + mean w'^2/2."""
    euler, errors = math.pi**2 * EI / (length * L) ** 2, []
    for cells in (8, 16):
        end = [Support(L, **high)] if high else []
        push = 4 * euler * L / EA
        beam = rod(
            cells,
            dim,
            supports=[Support(0.0, axial=FAST, **low), *end],
            law=Driven(push),
            lateral_load=lambda s: np.full((dim - 1, len(s)), 1e-9 * euler / L),
        )
        # it is pushed at once, then left to swing to rest
        first = Scene([beam], [], STATIC).run(1.0, 2e-2)
        beam.law = Driven(0.0)
        swings = Scene([beam], [], STATIC).run(2.0, 2e-2)
        last = Scene([beam], [], STATIC).run(4e3, 1e3)
        force = beam.axial.drive_force
        np.testing.assert_allclose(beam.axial_force(), -force, rtol=1e-6)
        bending = beam.split(beam.displacement)[0][:, ::2]
        slope = np.diff(bending) * cells / L
        assert 0.5 * (slope**2).sum() / cells == pytest.approx((push - force * L / EA) / L, 1e-6)
        assert last.finished
        for history in (first, swings):  # steps are solved to 1e-8
            assert history.finished
            assert np.abs(history["balance"]).max() < 1e-7 * history["strain"].max()
        errors.append(abs(force / euler - 1))
    assert errors[-1] < 0.015 and rates(errors)[0] == pytest.approx(2, abs=0.15)


def test_steps_are_cut_where_a_column_buckles():
    """Straight on is a solution of a long step, too, but no one that it moves to."""
    pins = [Support(0.0, axial=FAST, **PIN), Support(L, **PIN)]
    euler = math.pi**2 * EI / L**2
    law, aside = Driven(1.3 * euler * L / EA / 1e6), {"lateral_load": lambda s: 1e-6 + 0 * s[None]}
    beam = rod(supports=pins, law=law, **aside)
    history = Scene([beam], [], STATIC).run(1e6, 1e4)
    assert history.finished and len(history.time) > 102
    assert beam.axial.drive_force == pytest.approx(euler, rel=0.01)
    assert np.abs(beam.split(beam.displacement)[0][0, ::2]).max() > 5e-3


@pytest.mark.parametrize("share", [1.1, 4.0])
def test_a_pushed_beam_lies_on_its_floor_in_long_steps(share):
    """Straight on a rigid floor its weight makes it stable under any push."""
    length, bending, weight = 5.0, 1000.0, 20.0
    euler = math.pi**2 * bending / length**2
    axis = axis_mesh((0, 0), (1, 0), beam=(length, 10))
    pins = [Support(0.0, axial=FAST, **PIN), Support(length, **PIN)]
    section = Section(weight / 9.81, bending, axial=1e6)
    beam = VonKarmanBeam(axis, section, supports=pins, gravity=(0, -9.81))
    floor = Guide([Tube(-1, length + 1, 1.0)], (length, 1.0), (-1, 0), (0, 1))
    contact = GuideContact(beam, "beam", floor, "gap")
    beam.law = Driven(share * euler * length / 1e6)
    assert Scene([beam], [contact], STATIC).run(1.0, 0.01).finished
    beam.law = Driven(0.0)
    history = Scene([beam], [contact], STATIC).run(1e4, 1e3)
    assert history.finished and history.steps == 10 and not history.remarks
    assert contact.normal_force() == pytest.approx(0.9 * weight * length, rel=1e-9)
    assert beam.axial.drive_force == pytest.approx(share * euler, rel=1e-9)
    assert np.abs(beam.split(beam.displacement)[0][0, ::2]).max() < 1e-9


@pytest.mark.parametrize("share", [0.2, 0.98, 1.02])
def test_a_pushed_beam_lies_on_the_bottom_of_a_tube_in_long_steps(share):
    """Its weight holds it in the round as a bed of w/r: up to the least of EI k² + w/(r k²)."""
    length, bending, weight, radius, n = 5.0, 1000.0, 20.0, 0.01, np.arange(1, 9)
    waves = (n * math.pi / length) ** 2
    limit = (bending * waves + weight / radius / waves).min()
    assert limit > 7 * bending * waves[0]
    axis = axis_mesh((0, 0, 0), (1, 0, 0), beam=(length, 40))
    pins = [Support(0.0, axial=FAST, **PIN), Support(length, **PIN)]
    section = Section(weight / 9.81, bending, axial=1e6)
    beam = VonKarmanBeam(axis, section, supports=pins, gravity=(0, 0, -9.81))
    tube = Guide([Tube(-1, length + 1, radius)], (length, 0, radius), (-1, 0, 0), (0, 1, 0))
    contact = GuideContact(beam, "beam", tube, "gap")
    beam.law = Driven(share * limit * length / 1e6)
    pushed = Scene([beam], [contact], STATIC).run(1.0, 1e-3)
    assert pushed.finished, pushed.reason
    beam.law = Driven(0.0)
    history = Scene([beam], [contact], STATIC).run(1e4, 1e3)
    if share > 1:
        assert "'beam' buckles faster than steps of" in history.reason
        return
    assert history.finished and history.steps == 10 and not history.remarks
    assert contact.normal_force() == pytest.approx(0.975 * weight * length, rel=1e-8)
    assert beam.axial.drive_force == pytest.approx(share * limit, rel=1e-9)


@pytest.mark.parametrize("share", [1.0, -0.5])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_drive_tunes_a_rod(share, dim):
    """Pulled by a share of Euler's load: omega² = (1 + share) (pi/L)⁴ EI/m, at second order."""
    pull, errors = share * math.pi**2 * EI / L**2, []
    for cells in (8, 16):
        pins = [Support(0.0, axial=FAST, **PIN), Support(L, **PIN)]
        beam = rod(cells, dim, supports=pins, law=Driven(-pull * L / EA))
        Scene([beam], [], STATIC).run(1.0, 0.02)
        beam.law = Driven(0.0)
        assert -beam.axial.drive_force == pytest.approx(pull, rel=1e-9)
        s, bent = beam.matrices.s, beam.displacement.copy()
        beam.split(bent)[0][0, ::2] = 1e-6 * np.sin(math.pi * s / L)
        beam.split(bent)[0][0, 1::2] = 1e-6 * math.pi / L * np.cos(math.pi * s / L)
        beam.displacement = bent
        beam.rest()
        period = 2 * math.pi / ((math.pi / L) ** 2 * math.sqrt((1 + share) * EI / MASS))
        middle = {"w": lambda beam=beam, i=cells: beam.split(beam.displacement)[0][0, i]}
        history = Scene([beam], []).run(0.3 * period, period / 400, probes=middle)
        quarter = np.interp(0.0, -history["w"], history.time)
        errors.append(abs(4 * quarter / period - 1))
    assert errors[-1] < 2e-3 and rates(errors)[0] == pytest.approx(2, abs=0.15)


def test_a_hanging_chain_swings_as_bessel_has_it():
    """Its weight is its tension; omega = j0/2 sqrt(g/L), j0 = 2.404826, at second order."""
    errors, step = [], Step(1.0, STATIC)
    for cells in (10, 20):
        axis = axis_mesh((0, 0), (0, -1), all=(L, cells))
        nail = [Support(0.0, lateral=FAST, axial=FAST)]
        section = Section(MASS, 1e-6, axial=EA)
        chain = VonKarmanBeam(axis, section, supports=nail, gravity=(0, -9.81))
        assert Scene([chain], [], STATIC).run(30.0, 10.0).finished
        middle = (chain.matrices.s[1:] + chain.matrices.s[:-1]) / 2
        np.testing.assert_allclose(chain.axial_force(), MASS * 9.81 * (L - middle), rtol=1e-9)
        # pulled aside and let go: an eighth of a period in steps of 1/800, by its lowest mode
        chain.predict(step)
        stiff = chain._tangent(step)[2 : 2 * cells + 2, 2 : 2 * cells + 2]
        w, psi = slice(0, None, 2), slice(1, None, 2)
        stiff = stiff[w, w] - stiff[w, psi] @ np.linalg.solve(stiff[psi, psi], stiff[psi, w])
        root = 1 / np.sqrt(chain.matrices.bending_mass[2::2])
        omega = math.sqrt(np.linalg.eigvalsh(root[:, None] * stiff * root)[0])
        errors.append(abs(omega / (2.404825558 / 2 * math.sqrt(9.81 / L)) - 1))
    assert errors[-1] < 1e-3 and rates(errors)[0] == pytest.approx(2, abs=0.2)


@pytest.mark.parametrize("kind", [VonKarmanBeam, BeamSolid])
def test_a_stop_sends_a_wave_up_the_rod(kind):
    """N = EA v/c (1 - exp(-k c t/EA)) behind its front, k the stop's, t since it has passed."""
    v, k, errors = 0.1, 1e7, []
    c = math.sqrt(2 * EA / MASS)
    for cells in (30, 60):
        stop = Fall(stop=0.0, stop_stiffness=k)
        beam = rod(cells, axial=2 * EA, kind=kind, law=stop, gravity=(0, -1e-9))
        start = beam.velocity.copy()
        beam.split(start)[1][:] = -v
        beam.velocity = start
        beam._begin()

        def force(beam=beam, cells=cells):
            return -2 * EA * np.diff(axial(beam))[cells // 2] * cells / L

        dt = L / c / cells / 2
        history = Scene([beam], [], allow_free=True).run(1.4 * L / c, dt, probes={"N": force})
        behind = np.maximum(history.time - (L / 2 + L / cells / 2) / c, 0)
        exact = 2 * EA * v / c * (1 - np.exp(-k * c * behind / (2 * EA)))
        errors.append(np.sqrt(np.mean((history["N"] - exact) ** 2)) / (2 * EA * v / c))
        assert np.abs(history["balance"]).max() < 1e-9 * history["kinetic"].max()
    assert errors[-1] < 0.02 and rates(errors)[0] > 0.9


@pytest.mark.second
def test_a_drop_on_a_stop_in_any_unit_and_dimension():
    """Settled, dropped through a kinked S, caught by a stop at its tip, which compresses it."""

    def caught(unit, dim):
        up = [0.0] * (dim - 1) + [1.0]
        section = Section(32.75 / unit, 850.0 * unit**3, axial=5.9e7 * unit)

        def made():
            axis = axis_mesh([0.0] * (dim - 1) + [-unit], up, all=(3.86 * unit, 12))
            law = Fall(stop=0.05 * unit, stop_stiffness=1e6)
            gravity = [0.0] * (dim - 1) + [-9.81 * unit]
            return VonKarmanBeam(axis, section, gravity=gravity, law=law)

        curve = Sine(0.008 * unit, 3.0 * unit, "kinked")
        tube = Guide([Tube(-3.5 * unit, 5.0 * unit, 1e-3 * unit, curve)], [0.0] * dim)
        drop = RodDrop(made, "all", tube, friction=0.2).fall(to=math.inf, until=0.2, dt=2e-3)
        assert drop.history.finished, drop.history.reason
        least = drop.rod.axial_force().min()
        return drop.time_at(0.05 * unit), drop.stop_impact()[0] / unit, least / unit

    plane = caught(1.0, 2)
    assert plane[1] > 5e3 and plane[2] < -0.5 * plane[1]
    for unit, dim in ((1e3, 2), (1.0, 3)):
        np.testing.assert_allclose(caught(unit, dim), plane, rtol=1e-6)


# -- in tubes -----------------------------------------------------------------------------------


def wound(turns, cells, phase):
    """A rod in a tube of radius r that a drive compresses, bent to a helix of k² = F/(2EI), or
    nearly straight; its F, r and contact."""
    stiff, k, r = 850.0, 3.0, 5e-3
    length, F = 2 * math.pi * turns / k, 2 * stiff * k**2
    axis = axis_mesh((0, 0, -length), (0, 0, 1), rod=(length, cells))
    section = Section(mass=16.662, bending=stiff, axial=5.9e6)
    beam = VonKarmanBeam(axis, section, supports=[Support(0.0, axial=FAST)])
    beam.deflect(
        phase * r * np.stack([np.cos(k * beam.matrices.s), np.sin(k * beam.matrices.s)], 1)
    )
    tube = Guide([Tube(-1, length + 1, r)], (0.0,) * 3)
    return beam, F, GuideContact(beam, "rod", tube), r * F**2 / (4 * stiff)


def pressure(beam, contact):
    """In the middle third, N/m."""
    at, s = beam.axis.along(contact.surface.points), beam.matrices.s
    middle = (at > s[-1] / 3) & (at < 2 * s[-1] / 3)
    middle[contact.stations] = False
    pressed = -np.einsum("ij,ij->i", contact.force, contact.normal)[middle]
    return pressed * (len(s) - 1) / s[-1]


def test_a_helix_presses_as_a_drive_compresses_it():
    """r F²/(4EI) per length (Lubinski, Althouse, Logan 1962), F being what the drive bears."""
    errors = []
    for cells in (60, 120):
        beam, F, contact, exact = wound(4, cells, 1.0)
        start = beam.displacement.copy()
        h = beam.matrices.s[-1] / cells
        slope = np.diff(beam.split(start)[0][:, ::2]) / h
        strain = -F / 5.9e6 - 0.5 * (slope**2).sum(axis=0)
        beam.split(start)[1][1:] = np.cumsum(strain) * h
        beam.displacement = start
        beam.rest()
        beam.law = Driven(0.0)
        list(Scene([beam], [contact], ThetaScheme(1.0)).step(1e-4))
        assert beam.axial.drive_force == pytest.approx(F, rel=2e-4)
        force = pressure(beam, contact)
        assert np.ptp(force) < 1e-6 * force.mean()
        errors.append(abs(force.mean() / exact - 1))
    assert errors[1] < 0.01 and rates(errors) == pytest.approx([2], abs=0.1)


@pytest.mark.long
def test_a_drive_winds_a_straight_rod_into_a_helix():
    """Pushed in its tube it buckles by itself, and comes to rest as a helix of k² = F/(2EI) with
    r F²/(4EI) per length; F is what the drive finds. Of the 2.2 % that it presses less 1.1 are the
    24 cells of a turn (as above), the rest its ends, which are a turn away."""
    beam, F, contact, exact = wound(2, 72, 0.02)
    length = beam.matrices.s[-1]
    beam.law = Driven((F / 5.9e6 + 0.5 * (5e-3 * 3.0) ** 2) * length)
    assert Scene([beam], [contact], STATIC).run(1.0, 1e-2).finished
    beam.law = Driven(0.0)
    assert Scene([beam], [contact], STATIC).run(0.2, 5e-3).finished
    force = beam.axial.drive_force
    x, y = beam.split(beam.displacement)[0][:, ::2]
    turned = np.abs(np.diff(np.unwrap(np.arctan2(y, x)))) * 72 / length
    assert turned[24:48] == pytest.approx(math.sqrt(force / 2 / 850.0), rel=0.05)
    assert pressure(beam, contact).mean() == pytest.approx(exact * (force / F) ** 2, rel=0.02)


@pytest.mark.parametrize("bending", [1000.0, 10.0])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_rod_that_stands_settles_in_its_tube(bending, dim):
    """On its foot it falls over, or buckles under its weight: it lies on the wall, and stays."""
    up, aside = [0.0] * (dim - 1), [0.05] + [0.0] * (dim - 2)
    axis, foot = axis_mesh([*up, 0.0], [*up, 1.0], rod=(3.0, 15)), [Support(0.0, axial=FAST)]
    weight = [*aside, -9.81]
    beam = VonKarmanBeam(axis, Section(8.0, bending, axial=EA), supports=foot, gravity=weight)
    guide = Guide([Tube(-4.0, 1.0, 2e-3)], [0.0] * dim)
    settle(beam, "rod", guide)
    start = beam.displacement
    contact = GuideContact(beam, "rod", guide)
    assert Scene([beam], [contact], STATIC).run(1.0, 0.05).finished
    np.testing.assert_allclose(beam.displacement, start, atol=1e-9)
    assert contact.normal_force() == pytest.approx(beam.mass * 0.05, rel=1e-6)


def in_tube(beam, kind):
    """The beam in a tube that hardly gives way, of a kind; None: in a rigid guide."""
    if kind is None:
        return beam
    axis = axis_mesh([0.0, -1.0], [0.0, 1.0], tube=(4.0, 10))
    grids = [Support(s, lateral=FAST, axial=0.0 if s else FAST) for s in np.linspace(0, 4, 6)]
    stiff = Section(1e4, 1e9, axial=1e9)
    return RodInTube(beam, kind(axis, stiff, supports=grids, name="tube"))


@pytest.mark.parametrize("kind", [BeamSolid, VonKarmanBeam])
def test_a_string_swings_in_an_elastic_tube(kind):
    """Its steps are solved as well as without a tube; books closed, walls that it strikes too."""
    found = []
    for around in (None, kind):
        ends = [Support(s, axial=FAST, **PIN) for s in (0.0, L)]
        bow = {"displacement": lambda s: 0.15 * np.sin(math.pi * s / L)[None]}
        beam = rod(8, axial=1e5, supports=ends, **bow)
        solid = in_tube(beam, around)
        contact = GuideContact(solid, "all", Guide([Tube(-3.0, 1.0, 0.16)]), "gap")
        history = Scene([solid], [contact], ThetaScheme(0.5)).run(0.1, 4e-3)
        assert history.finished
        assert np.abs(history["balance"]).max() < 1e-8 * history["strain"][0]
        found.append(beam.displacement)
    np.testing.assert_allclose(*found, atol=1e-7)


@pytest.mark.parametrize("kind", [BeamSolid, VonKarmanBeam])
def test_a_rod_buckles_in_an_elastic_tube(kind):
    """Where steps are too long to tell how it buckles they are cut, in a tube as in a guide."""
    found = []
    for around in (None, kind):
        pins = [Support(0.0, axial=FAST, **PIN), Support(L, **PIN)]
        aside = {"lateral_load": lambda s: 1e-3 + 0 * s[None]}
        beam = rod(10, supports=pins, law=Driven(4e-3), **aside)
        solid = in_tube(beam, around)
        contact = GuideContact(solid, "all", Guide([Tube(-3.0, 1.0, 0.05)]), "gap")
        history = Scene([solid], [contact], STATIC).run(0.5, 5e-2)
        assert history.finished and "buckles faster" in history.remarks[0][1]
        found.append(beam.axial.drive_force)
    assert found[1] == pytest.approx(found[0], rel=1e-4)
