# SPDX-License-Identifier: LGPL-3.0-or-later
"""Guides: geometry, exact static forces of rods in bent tubes, friction, stations, the third
dimension."""

import math
from dataclasses import replace

import numpy as np
import pytest
from processes import killed_after
from scenes import rates

from fenicsx_contact import (
    Archard,
    BeamSolid,
    Compliance,
    Discrete,
    Driven,
    Fall,
    Gap,
    InputError,
    Scene,
    Section,
    Stribeck,
    Support,
    ThetaScheme,
    Tresca,
    Velocity,
    axis_mesh,
)
from fenicsx_contact.references.rod import endless_insertion_force
from fenicsx_contact.rods import (
    AnyCurve,
    Bow,
    Card,
    Guide,
    GuideContact,
    RodInTube,
    Sine,
    Straight,
    Tube,
    settle,
)
from fenicsx_contact.theory.scheme import Step

L, EI, C = 3.66, 850.0, 0.775e-3
ROD = Section(mass=16.662, bending=EI)
CURVES = [
    Straight(0.01),
    Sine(0.01, L),
    Sine(0.01, L, "kinked"),
    Bow(0.02, 3.0),
    AnyCurve(lambda x: 1e-3 * x**2, lambda x: 2e-3 * x),
]


# -- geometry -----------------------------------------------------------------------------------


@pytest.mark.parametrize("curve", CURVES, ids=lambda c: type(c).__name__)
def test_slopes_are_derivatives(curve):
    x = np.linspace(0.1, 3.5, 50)
    by = (curve.offset(x + 1e-5) - curve.offset(x - 1e-5)) / 2e-5
    np.testing.assert_allclose(curve.slope(x), by, atol=1e-9)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("curve", CURVES, ids=lambda c: type(c).__name__)
def test_distance_and_normal_are_those_of_the_wall(curve, dim):
    """Against the nearest of many points of the wall; the normal is the gradient."""
    rng = np.random.default_rng(3)
    clearance = [(0, C), (1.5, C), (1.7, 0.3 * C), (3, 0.3 * C)]
    guide = Guide([Tube(0, 3.0, clearance, curve)], origin=(0.0,) * dim)
    depth = np.array([0.7, 1.3, 1.6, 2.5])
    points = guide.centre(depth) + 0.0
    off = rng.normal(size=(4, dim - 1))
    off *= 0.2 * C / np.linalg.norm(off, axis=1)[:, None]
    points[:, : dim - 1] += off
    found, normal = guide.distance(points).copy(), guide.normals(points).copy()

    fine = np.linspace(0.5, 2.7, 400001)
    wall = guide.centre(fine)
    c = np.interp(fine, *np.transpose(clearance))
    for p, d, o in zip(points, found, off / np.linalg.norm(off, axis=1)[:, None]):
        side = wall.copy()
        side[:, : dim - 1] += c[:, None] * o  # the side of the wall that the point is nearest to
        assert d == pytest.approx(np.linalg.norm(side - p, axis=1).min(), rel=3e-4, abs=1e-7)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1)
    for axis in range(dim):
        step = np.eye(dim)[axis] * 1e-8
        slope = (guide.distance(points + step) - guide.distance(points - step)) / 2e-8
        # in space the inclined wall also turns about the rod, by the square of its slope
        np.testing.assert_allclose(slope, normal[:, axis], atol=2e-5 if dim == 2 else 2e-3)


def test_outside_the_tubes_no_wall_is_near():
    guide = Guide([Tube(0, 1, C), Tube(2, 3, C), Card(-1.0, C)])
    points = np.array([[5.0, 0.5], [0.0, -1.5], [0.0, -3.5], [0.0, -2.5]])
    np.testing.assert_allclose(guide.distance(points), [guide.far] * 3 + [C])
    assert guide.far == pytest.approx(4 + C)  # more than the guide is long


def test_stations_are_where_a_guide_is_convex():
    """Ends, cards, kinks, the end of a taper (not its beginning); the tighter one of two."""
    taper = [(0, C), (1, C), (1.05, C / 4), (2, C / 4)]
    pieces = [Card(-0.9, 1e-4), Tube(-0.5, 0, C / 2), Tube(0, 2, taper, kinks=[0.3])]
    guide = Guide(pieces)
    np.testing.assert_allclose(guide.stations, [-0.9, -0.5, 0, 0.3, 1.05, 2])
    np.testing.assert_allclose(guide.clearance(), [1e-4, C / 2, C / 2, C, C / 4, C / 4])
    from_above, from_below = guide.faces
    np.testing.assert_array_equal(from_above, [True, True, False, False, False, False])
    np.testing.assert_array_equal(from_below, [True, False, True, False, False, True])


def beside(offset):
    """A curve parallel to the axis."""
    return AnyCurve(lambda x: 0 * x + offset, lambda x: 0 * x)


def test_two_holes_side_by_side_are_two_stations():
    """The tighter hole of two only if it lies within the other; its edge is a face from there."""
    for pieces in (1, -1):
        tubes = [Tube(0, 1, C), Tube(1, 2, C, beside(C / 2))]
        guide = Guide(tubes[::pieces])
        np.testing.assert_allclose(guide.stations, [0, 1, 1, 2])
        np.testing.assert_array_equal(guide.faces.sum(axis=1), [2, 2])
        guide = Guide([Tube(0, 1, C), Tube(1, 2, C / 2, beside(C / 4))][::pieces])
        np.testing.assert_allclose(guide.clearance(), [C, C / 2, C / 2])
        np.testing.assert_array_equal(guide.faces, [[True, True, False], [False, False, True]])


@pytest.mark.parametrize("form", [Velocity(0.1), "gap", "lagrange"], ids=str)
@pytest.mark.parametrize(
    ("dim", "offset", "hole", "tilt", "clearance", "butts"),
    [
        (2, C / 2, 0.0, 0.0, C, False),  # the tip is in the middle
        (2, 3e-3, 0.0, 0.0, C, True),
        (3, 3e-3, 0.2, 0.0, C, True),
        (2, 0.0, 0.2, 0.0, C, False),
        (2, 0.0, 0.2, 0.01, C, True),  # sent beside it by a tube that leans
        (3, 2e-3, 0.2, 0.0, [(0.2, 4e-3), (0.7, C), (4, C)], False),  # a funnel
    ],
)
def test_a_tip_meets_the_next_tube(dim, offset, hole, tilt, clearance, butts, form):
    """Aligned or funnelled it passes, and never inside a wall; beside the hole it butts, named: by
    laws of positions it was put into the hole, or the step stalled."""
    zero = (0.0,) * dim
    pieces = [Tube(-2, 0, C, Straight(tilt)), Tube(hole, 4, clearance, beside(offset))]
    guide = Guide(pieces, zero)
    axis = axis_mesh((*zero[1:], 0.05), (*zero[1:], 1), rod=(1.8, 18))
    law = Fall(drive_friction=5.0)
    rod = BeamSolid(axis, ROD, gravity=(*zero[1:], -9.81), law=law)
    settle(rod, "rod", guide)
    contact = GuideContact(rod, "rod", guide, form, 0.1, name="c")
    scene = Scene([rod], [contact], ThetaScheme(0.6))
    history = scene.run(
        0.8, 2e-3, stop_when=lambda: rod.travel > 0.6, probes={"z": lambda: rod.travel}
    )
    assert history["c.penetration"].max() < 0.02 * C
    if butts:
        assert f"butts at the depth {hole:g} m" in history.reason
        assert 0 <= 0.05 + hole - history["z"][-1] < 1e-5  # the way of the shortest step
    else:
        assert history.finished, history.reason


@pytest.mark.parametrize(
    ("pieces", "where"),
    [
        ([Tube(-2, 0, C), Tube(0, 4, C, beside(2.1 * C))], "0 m"),
        ([Tube(-2, 4, C), Card(0.55, C / 2, centre=-1.6 * C)], "0.55 m"),
        ([Card(-2, C), Card(0.3, C), Card(0.3, C, centre=2.1 * C)], "0.3 m"),
    ],
)
def test_holes_that_leave_a_rod_no_place(pieces, where):
    """Named where the rod is; below its tip they are for the drop to meet."""
    rod = BeamSolid(axis_mesh((0, -1), (0, 1), rod=(1.8, 18)), ROD)
    with pytest.raises(InputError, match=f"holes at the depth {where} are 7.75e-05 m apart"):
        settle(rod, "rod", Guide(pieces))
    settle(rod, "rod", Guide([*pieces[:1], Card(1.1, C), Card(1.1, C, centre=2.1 * C)]))


def test_three_holes_of_which_no_two_are_apart():
    """What they have in common, if anything, only the search for their forces can tell."""

    def laid(radius):
        x, y = -radius / 2, radius * math.sqrt(0.75)
        up, down = (
            AnyCurve(lambda s, side=side: [[x, side]] + 0 * s[:, None], lambda s: 0 * s)
            for side in (y, -y)
        )
        rod = BeamSolid(axis_mesh((0, 0, -1), (0, 0, 1), rod=(1.8, 18)), ROD)
        pieces = [Tube(-2, 0, C, up), Tube(0, 4, C, down), Card(0, C, centre=radius)]
        settle(rod, "rod", Guide(pieces, (0, 0, 0)))

    laid(0.99 * C)
    with pytest.raises(InputError, match="forces of its walls were not found"):
        laid(1.1 * C)


# -- statics ------------------------------------------------------------------------------------


def half_wave(amplitude, cells, tension=0.0):
    """Half a wavelength of an endless beam: held at the inflexions."""
    axis = axis_mesh((0, -L / 2), (0, 1), rod=(L / 2, cells))
    pins = [Support(0, lateral=math.inf, axial=math.inf), Support(L / 2, lateral=math.inf)]
    rod = BeamSolid(axis, replace(ROD, tension=tension), supports=pins)
    guide = Guide([Tube(-0.01, L / 2 + 0.01, C, Sine(amplitude, L, "kinked"))])
    return settle(rod, "rod", guide)


@pytest.mark.parametrize("amplitude", [0.002, 0.004, 0.005, 0.010, 0.020, 0.030])
def test_endless_beam_in_a_sine(amplitude):
    """126.46 N at 10 mm, and the exact formula elsewhere."""
    exact = endless_insertion_force(amplitude, C, L, EI)
    if amplitude == 0.010:
        assert exact == pytest.approx(126.46, abs=0.005)
    contact = half_wave(amplitude, 37)
    assert 2 * contact.normal_force() == pytest.approx(exact, rel=1.5e-3)
    assert contact.depth() < 1e-6 * C


def test_one_contact_per_crest_is_exact():
    """c/a > 0.1775: a beam on three points, to round-off once a node stands at the crest."""
    contact = half_wave(0.004, 38)
    exact = 768 * EI * (0.004 - C) / L**3
    assert 2 * contact.normal_force() == pytest.approx(exact, rel=1e-6)


def test_compression_softens_a_rod_in_a_bow():
    """A beam-column on three points: (tan u - u)/u³ of its load bends it as much (600 N: -23 %);
    the tension in the cells is uniform, their slope is not: second order."""
    errors = []
    for cells in (38, 76):
        half, force = L / 2, half_wave(0.004, cells, tension=-600.0).normal_force()
        u = half / 2 * math.sqrt(600.0 / EI)
        exact = 48 * EI * (0.004 - C) / half**3 / (3 * (math.tan(u) - u) / u**3)
        errors.append(abs(force / exact - 1))
    assert exact < 0.78 * 48 * EI * (0.004 - C) / half**3
    assert errors[0] < 1e-3 and rates(errors) == pytest.approx([2], abs=0.1)


@pytest.mark.parametrize(
    ("amplitude", "force"), [(0.005, 75.3), (0.010, 175.9), (0.020, 390.1), (0.030, 612.6)]
)
def test_one_wavelength_with_free_ends(amplitude, force):
    rod = BeamSolid(axis_mesh((0, -L), (0, 1), rod=(L, 73)), ROD)
    guide = Guide([Tube(-1e-6, L + 1e-6, C, Sine(amplitude, L, "kinked"))])
    assert settle(rod, "rod", guide).normal_force() == pytest.approx(force, rel=5e-3)


def coiled(amplitude):
    """A helix round the axis."""
    k = 2 * np.pi / L
    return AnyCurve(
        lambda x: amplitude * np.stack([np.cos(k * x) - 1, np.sin(k * x)], axis=1),
        lambda x: amplitude * k * np.stack([-np.sin(k * x), np.cos(k * x)], axis=1),
    )


@pytest.mark.parametrize("axial", [math.inf, 1e8], ids=["inextensible", "extensible"])
def test_rest_in_space(axial):
    """A kinked bow lies in any plane as in its own; a helix presses as much in all planes."""

    def force(dim, curve, plane=None):
        zero = (0.0,) * dim
        axis = axis_mesh((*zero[1:], -L), (*zero[1:], 1), rod=(L, 74))
        rod = BeamSolid(axis, Section(mass=16.662, bending=EI, axial=axial))
        contact = settle(rod, "rod", Guide([Tube(-2, 4, C, curve)], zero, plane=plane))
        assert contact.depth() < 1e-6 * C
        return contact

    bow = Sine(0.01, L, "kinked")
    flat, turned = force(2, bow), force(3, bow, (math.cos(0.5), math.sin(0.5), 0))
    assert flat.normal_force() > 100
    assert turned.normal_force() == pytest.approx(flat.normal_force(), rel=1e-6)
    coil = force(3, coiled(0.01))
    assert coil.normal_force() > flat.normal_force()
    assert np.abs(coil.force[:, :2].sum(axis=0)).max() < 1e-3 * coil.normal_force()


def test_no_contact_below_the_clearance():
    contact = half_wave(0.9 * C, 20)
    assert contact.normal_force() == 0
    assert endless_insertion_force(0.9 * C, C, L, EI) == 0


def test_a_rod_is_interpolated_at_cards():
    """Three cards, none at a node, bend a rod as three point loads do, whatever its mesh."""
    forces = []
    for cells in (8, 23):
        rod = BeamSolid(axis_mesh((0, -2), (0, 1), rod=(2.0, cells)), ROD)
        cards = [Card(0.31, C), Card(1.03, C, centre=5e-3), Card(1.77, C)]
        contact = settle(rod, "rod", Guide(cards))
        forces.append(contact.force[contact.stations, 0])
        assert np.abs(contact.force[:, 1]).max() < 0.02 * np.abs(contact.force).max()
    a, b = 1.03 - 0.31, 1.77 - 1.03
    exact = 3 * EI * (a + b) / (a * b) ** 2 * (5e-3 - 2 * C)
    np.testing.assert_allclose(
        forces[1], [-exact * b / (a + b), exact, -exact * a / (a + b)], rtol=1e-3
    )
    # a load inside a cell deflects it by a little more than its nodes know
    np.testing.assert_allclose(forces[0], forces[1], rtol=3e-3)


# -- buckling in a tube -------------------------------------------------------------------------


def test_a_helix_presses_as_it_is_compressed():
    """A weightless rod under F, wound with k² = F/(2EI): r F²/(4EI) per length (A. Lubinski,
    W. S. Althouse, J. L. Logan (1962), J. Petrol. Technol. 14, 655-670), at second order."""
    k, r, errors = 3.0, 5e-3, []
    F, length = 2 * EI * k**2, 8 * math.pi / k
    for cells in (60, 120):
        rod = BeamSolid(
            axis_mesh((0, 0, -length), (0, 0, 1), rod=(length, cells)),
            Section(mass=16.662, bending=EI, tension=-F),
        )
        s = rod.matrices.s
        rod.deflect(r * np.stack([np.cos(k * s), np.sin(k * s)], axis=1))
        contact = GuideContact(rod, "rod", Guide([Tube(-1, length + 1, r)], (0.0,) * 3))
        list(Scene([rod], [contact], ThetaScheme(1.0)).step(1e-4))
        at = rod.axis.along(contact.surface.points)
        middle = (at > length / 3) & (at < 2 * length / 3)
        middle[contact.stations] = False
        pressed = -np.einsum("ij,ij->i", contact.force, contact.normal)[middle]
        assert np.ptp(pressed) < 1e-9 * pressed.mean()
        errors.append(abs(pressed.mean() * cells / length / (r * F**2 / (4 * EI)) - 1))
    assert errors[1] < 0.01 and rates(errors) == pytest.approx([2], abs=0.1)


def test_a_rod_on_the_floor_of_a_tube_buckles_as_a_sine():
    """At F = 2 sqrt(EI w / r), w the weight per length (R. Dawson, P. R. Paslay (1984), J. Petrol.
    Technol. 36, 1734-1738): the square of its frequency along the wall falls to 0 there."""
    weight, r = 160.0, 5e-3
    k, critical = (weight / (r * EI)) ** 0.25, 2 * math.sqrt(EI * weight / r)
    length, down = 2 * math.pi / k, (0, 0, -weight / ROD.mass)

    def square(share):
        axis = axis_mesh((-length, 0, 0), (1, 0, 0), rod=(length, 48))
        pins = [Support(0, lateral=math.inf, axial=math.inf), Support(length, lateral=math.inf)]
        section = replace(ROD, tension=-share * critical)
        rod = BeamSolid(axis, section, supports=pins, gravity=down)
        s, side = rod.matrices.s, 1e-4 * np.sin(k * rod.matrices.s)
        place = np.stack([0 * s, side, r - np.sqrt(r**2 - side**2)], axis=1)
        rod.deflect(place @ rod.frame.T)
        tube = Guide([Tube(-0.1, length + 0.1, r)], (0, 0, r), direction=(-1, 0, 0))
        contact = GuideContact(rod, "rod", tube)
        slow = 2 * math.pi * math.sqrt(ROD.mass * r / (2 * weight * (1 - share)))

        def swing():
            sideways = rod.split(rod.displacement)[0][:, ::2].T @ rod.frame[:, 1]
            return float(sideways @ side / (side @ side))

        history = Scene([rod], [contact]).run(0.3 * slow, slow / 100, probes={"swing": swing})
        assert history.finished, history.reason
        zero = np.interp(0.0, -history["swing"], history.time)
        return (math.pi / 2 / zero) ** 2

    half, most = square(0.5), square(0.8)
    assert 0.8 + 0.3 * most / (half - most) == pytest.approx(1, abs=0.02)


# -- sliding ------------------------------------------------------------------------------------


def pushed(friction, formulation="velocity", dim=2, speed=0.05, steps=160, **place):
    """A rod driven through a sine that is 10 mm high, by half its wavelength."""
    axis = axis_mesh((0,) * (dim - 1) + (-1.2,), (0,) * (dim - 1) + (1,), rod=(2.4, 48))
    curve = place.pop("curve", Sine(0.01, 1.8))
    guide = Guide([Tube(-2, 4, C, curve)], origin=(0.0,) * dim, **place)
    rod = BeamSolid(axis, ROD)
    settle(rod, "rod", guide)
    rod.law = Driven(speed)
    contact = GuideContact(rod, "rod", guide, formulation, friction, name="c")
    scene = Scene([rod], [contact], ThetaScheme(1.0, forces="end"))

    def rubbing():
        normal = np.einsum("ij,ij->i", contact.force, contact.normal)[:, None] * contact.normal
        return np.linalg.norm(contact.force - normal, axis=1).sum()

    probes = {
        "normal": contact.normal_force,
        "tangential": rubbing,
        "wall": lambda: contact.axial_force()[0],
        "rubbing": lambda: contact.axial_force()[1],
        "driving": lambda: rod.axial.drive_force,
    }
    history = scene.run(0.9 / speed, 0.9 / speed / steps, probes=probes)
    assert history.finished, history.reason
    # the sudden start finds points that are not predicted; what they penetrate decays
    assert history["c.penetration"][20:].max() < 0.05 * C
    return history, contact


@pytest.mark.parametrize(
    ("formulation", "speed", "steps"), [(Velocity(0.1), 1.0, 900), (Gap(), 0.05, 160)]
)
def test_friction_is_mu_times_normal_force_in_sliding(formulation, speed, steps):
    """And the drive supplies what walls and friction resist with, fast or slowly."""
    history, _ = pushed(0.3, formulation, speed=speed, steps=steps)
    later = np.flatnonzero(history["dt"] > 0)[20:]  # in impacts the forces are percussions
    normal = history["normal"][later]
    assert normal.min() > 50
    np.testing.assert_allclose(history["tangential"][later], 0.3 * normal, rtol=1e-6)
    # it acts along inclined walls: its axial part is the cosine of their slope, >= 0.997, of it
    np.testing.assert_allclose(-history["rubbing"][later], 0.3 * normal, rtol=3e-3)
    resistance = -(history["wall"] + history["rubbing"])[later]
    np.testing.assert_allclose(history["driving"][later], resistance, atol=1e-9 * normal.max())


def test_walls_push_along_the_axis_what_the_rod_stores():
    """Without friction, slowly: the work of the drive is the strain energy."""
    history, _ = pushed(0.0, Gap(), steps=320)
    work = 0.9 / 320 * np.cumsum(history["driving"])
    stored = history["strain"] - history["strain"][0]
    assert np.ptp(stored) > 0.3
    np.testing.assert_allclose(work, stored, atol=0.01 * np.ptp(stored))


@pytest.mark.second
def test_in_space_a_plane_bow_is_a_plane_problem():
    """The annular gap gives the forces of two walls, in any plane."""
    fast = {"speed": 1.0, "steps": 900}
    flat, _ = pushed(0.3, Velocity(0.1), **fast)
    plane = (0.6, 0.8, 0)
    round_, contact = pushed(0.3, Velocity(0.1), dim=3, plane=plane, **fast)
    for column in ("normal", "rubbing", "wall"):
        size = np.abs(flat["normal"]).max()
        impulse = np.cumsum(round_[column] - flat[column]) / len(flat)
        assert np.abs(impulse).max() < 5e-3 * size
    across = np.cross(plane, (0, 0, 1))
    assert np.abs(contact.force @ across).max() < 1e-2 * np.abs(contact.force).max()


@pytest.mark.long
def test_a_helix_bears_all_around():
    """A curve in space: both lateral components of the forces, friction mu N."""
    k = 2 * np.pi / 1.8
    helix = AnyCurve(
        lambda x: 0.01 * np.stack([np.cos(k * x) - 1, np.sin(k * x)], axis=1),
        lambda x: 0.01 * k * np.stack([-np.sin(k * x), np.cos(k * x)], axis=1),
    )
    history, contact = pushed(0.2, Velocity(0.1), dim=3, curve=helix, speed=1.0, steps=1800)
    assert np.abs(contact.force[:, 0]).max() > 10 and np.abs(contact.force[:, 1]).max() > 10
    np.testing.assert_allclose(history["tangential"][2:], 0.2 * history["normal"][2:], rtol=1e-6)


def test_a_wall_moves_for_a_falling_rod():
    """An inclined straight tube: the rod is guided sideways at tilt times its speed."""
    tilt = 0.02
    rod = BeamSolid(axis_mesh((0, -1), (0, 1), rod=(1.0, 10)), ROD, gravity=(0, -9.81), law=Fall())
    guide = Guide([Tube(-1, 3, C, Straight(tilt))])
    settle(rod, "rod", guide)
    contact = GuideContact(rod, "rod", guide, Velocity(0.1), name="c")
    history = Scene([rod], [contact], ThetaScheme(0.6)).run(0.4, 1e-3)
    bending, _ = rod.split(rod.velocity)
    assert bending[0, ::2].mean() == pytest.approx(tilt * rod.speed, rel=1e-3)
    # a bead on an inclined wire
    assert rod.speed == pytest.approx(9.81 / (1 + tilt**2) * 0.4, rel=1e-4)
    assert np.abs(history["balance"]).max() < 1e-9
    assert history["c.penetration"].max() < 0.05 * C


def test_what_slides_along_a_bend_is_not_struck_without_end():
    """Located: what a bend adds to w_n on the way of a step is no blow at its start."""
    guide = Guide([Tube(-2.5, 0, 8e-4), Tube(0, 2.5, 8e-4, Sine(0.015, 2.6))])

    def run(located):
        axis = axis_mesh((0, -0.2), (0, 1), rod=(2.0, 20))
        rod = BeamSolid(axis, Section(mass=3.0, bending=60.0), gravity=(0, -9.81), law=Fall())
        settle(rod, "rod", guide)
        contact = GuideContact(rod, "rod", guide)
        scene = Scene([rod], [contact], ThetaScheme(0.5), locate_impacts=located)
        times = []

        def row():
            times.append(scene.time)
            assert times.count(scene.time) < 20
            return 0.0

        assert scene.run(0.3, 5e-3, probes={"row": row}).finished
        return rod.travel

    assert run(True) == pytest.approx(run(False), rel=2e-4)


def test_a_guide_that_moves_changes_sides_within_a_step():
    """A rod on springs bounces from wall to wall: what its guide does that is pulled sideways by
    a t²/2 is what the weight -a does in one at rest, and what is lost is the same."""

    def run(weight, motion):
        axis = axis_mesh((0, 0), (0, 1), rod=(1.0, 4))
        section = Section(mass=3.0, bending=60.0)
        rod = BeamSolid(axis, section, gravity=(weight, -9.81), law=Fall())
        guide = Guide([Tube(-3, 2, 1e-3)], motion=motion)
        contact = GuideContact(rod, "rod", guide, Discrete(1e4), 0.3)
        return rod, Scene([rod], [contact], ThetaScheme(0.5)).run(0.4, 2e-3)

    rod, moved = run(0.0, lambda t: (2.0 * t * t, 0.0))
    other, still = run(-4.0, None)
    assert moved.finished and still.finished
    assert rod.travel == pytest.approx(other.travel, rel=1e-9)
    for lost in ("impact", "friction"):
        size = np.abs(still[lost]).max()
        np.testing.assert_allclose(moved[lost], still[lost], atol=1e-8 * size)


@pytest.mark.parametrize("cuts", [(), (-0.5,), (-0.62, -0.33)])
@pytest.mark.parametrize("top", [-2.0, -20.0])
def test_laws_of_areas_see_the_length_of_the_rod(cuts, top):
    """One tube or several, and wherever they begin: 7 N/m on a rod of 1 m are 7 N."""

    def slid(friction):
        lying = {"displacement": lambda s: np.full((1, len(s)), 1e-3)}
        axis = axis_mesh((0, 0), (0, 1), rod=(1.0, 10))
        section = Section(mass=2.0, bending=40.0)
        rod = BeamSolid(axis, section, gravity=(3.0, 0), law=Driven(0.5), **lying)
        ends = [top, *cuts, 2.0]
        line = lambda: AnyCurve(lambda x: 0 * x, lambda x: 0 * x)  # noqa: E731  # another for each
        guide = Guide([Tube(a, b, 1e-3, line()) for a, b in zip(ends[:-1], ends[1:])])
        assert len(guide.stations) == len(ends)
        soft = Compliance(1e6, tangential_stiffness=1e8)  # so that all of it bears
        contact = GuideContact(rod, "rod", guide, soft, friction)
        rubs = {"rubbing": lambda: contact.axial_force()[1]}
        history = Scene([rod], [contact], ThetaScheme(1.0)).run(0.4, 2e-2, probes=rubs)
        assert history.finished
        return history["rubbing"][2:], contact

    np.testing.assert_allclose(slid(Tresca(7.0))[0], -7.0, rtol=1e-9)
    np.testing.assert_allclose(slid(Stribeck(0, 0, 0.1, 1, 5.0))[0], -2.5, rtol=1e-9)
    _, contact = slid(Archard(0.3, 1e-4, 1e6))
    assert contact.gap.max() == pytest.approx(6e-6, rel=2e-2)
    worn = np.delete(contact.memory.values["worn"], contact.stations)
    assert worn.mean() == pytest.approx(1e-4 / 1e6 * 6.0 * 0.2, rel=0.05)


@pytest.mark.parametrize("law", ["gap", "velocity"])
@pytest.mark.parametrize("cut", [-0.5, -1.01])
def test_a_joint_of_no_effect_has_none(cut, law):
    """5 N/m on 2 m of a rod that lies in a straight tube are 10 N, wherever it is divided."""
    guide = Guide([Tube(cut, 3, 1e-3), Tube(-3, cut, 1e-3)])
    section = Section(mass=3.0, bending=60.0)
    axis = axis_mesh((0, 0), (0, 1), rod=(2.0, 10))
    rod = BeamSolid(axis, section, gravity=(-4, -9.81), law=Fall())
    settle(rod, "rod", guide)
    contact = GuideContact(rod, "rod", guide, law, Tresca(5.0))
    assert Scene([rod], [contact], ThetaScheme(0.5)).run(0.05, 2e-3).finished
    assert rod.speed == pytest.approx(0.05 * (9.81 - 10 / 6), rel=1e-12)


def test_tubes_that_are_one_are_one():
    table = [(0.2, C), (0.9, 0.6 * C), (1.5, C), (1.8, C)]
    whole = Tube(0, 2, table, Sine(0.01, L, "kinked"), [0.4])

    def part(a, b, curve=whole.curve, clearance=table):
        return Tube(a, b, clearance, curve, [0.4] if a < 0.4 else [])

    one, parts = Guide([whole]), Guide([part(1.2, 2), part(0, 0.7), part(0.7, 1.2)])
    np.testing.assert_array_equal(parts.stations, one.stations)
    x = np.stack([np.linspace(-2e-3, 2e-3, 501), -np.linspace(-0.1, 2.1, 501)], axis=1)
    np.testing.assert_allclose(parts.distance(x), one.distance(x), rtol=1e-12)
    np.testing.assert_allclose(parts.normals(x), one.normals(x), rtol=1e-12)
    for other in (
        part(0.7, 2, Sine(0.01, L)),
        part(0.7, 2, clearance=2 * C),
        part(0.7, 2, clearance=[(0.7, np.interp(0.7, *np.transpose(table))), (2, 2 * C)]),
        part(0.8, 2),
    ):
        assert 0.7 in Guide([part(0, 0.7), other]).stations


def test_what_is_between_tubes_has_no_length():
    """A rod that leaves one tube and enters the next, and a card between them."""
    axis = axis_mesh((0, 0), (0, 1), rod=(1.0, 10))
    rod = BeamSolid(axis, Section(mass=2.0, bending=40.0), law=Driven(0.5))
    guide = Guide([Tube(-3.0, -0.27, C), Card(-0.1, C), Tube(0.13, 4.0, C)])
    contact = GuideContact(rod, "rod", guide, friction=Tresca(7.0))
    probes = {"length": lambda: np.sum(contact.coupling.area), "travel": lambda: rod.travel}
    history = Scene([rod], [contact], ThetaScheme(1.0)).run(1.0, 1e-2, probes=probes)
    z = history["travel"][1:]
    tubes = np.maximum(0.73 - z, 0) + np.maximum(z - 0.13, 0)
    card = np.where(z <= 0.9, 0.5 * (0.17 + 0.23), 0)
    np.testing.assert_allclose(history["length"][1:], tubes + card, atol=1e-12)


@pytest.mark.parametrize("theta", [0.5, 0.6, 1.0])
def test_friction_of_a_card_is_that_of_its_depth(theta):
    """The rod slides past the cards, which stay: mu = 0.1 + 0.5 depth had been read where what they
    touch had been in the midst of the step, by theta = 1/2 6 mm higher."""
    rod = BeamSolid(axis_mesh((0, -2), (0, 1), rod=(2.0, 10)), ROD, law=Driven(0.5))
    guide = Guide([Card(0.31, C), Card(1.03, C, centre=5e-3), Card(1.77, C)])
    settle(rod, "rod", guide)
    contact = GuideContact(rod, "rod", guide, friction=lambda x: 0.1 - 0.5 * x[1])
    assert Scene([rod], [contact], ThetaScheme(theta)).run(0.1, 0.025).finished
    cards = contact.stations
    pressed = np.linalg.norm(contact.normal_forces[cards], axis=1)
    rubbed = np.linalg.norm((contact.force - contact.normal_forces)[cards], axis=1)
    np.testing.assert_allclose(rubbed / pressed, 0.1 + 0.5 * guide.stations, rtol=1e-9)


# -- elastic guides -----------------------------------------------------------------------------


def half_wave_in_tube(amplitude, bending, cells=38):
    """Half a wavelength of a rod in a tube of its own, both held at the inflexions."""
    half = L / 2
    axis = axis_mesh((0, -half), (0, 1), rod=(half, cells))
    pins = [Support(0, lateral=math.inf, axial=math.inf), Support(half, lateral=math.inf)]
    rod = BeamSolid(axis, ROD, supports=pins)
    around = axis_mesh((0, -half), (0, 1), tube=(half, 22))
    tube = BeamSolid(around, Section(mass=20.0, bending=bending), supports=pins, name="tube")
    guide = Guide([Tube(-0.01, half + 0.01, C, Sine(amplitude, L, "kinked"))])
    pair = RodInTube(rod, tube)
    return settle(pair, "rod", guide), pair


@pytest.mark.parametrize("bending", [400.0, 5e3])
def test_rod_and_tube_share_the_deflection(bending):
    """Two beams on three points in series; the tube bends against the rod."""
    contact, pair = half_wave_in_tube(0.004, bending)
    flexible = (L / 2) ** 3 / 48 * (1 / EI + 1 / bending)
    force = (0.004 - C) / flexible
    assert contact.normal_force() == pytest.approx(force, rel=1e-4)
    w, _ = pair.tube.split(pair.tube.displacement)
    assert np.abs(w[0, ::2]).max() == pytest.approx(force * (L / 2) ** 3 / 48 / bending, rel=1e-3)


def test_a_stiff_tube_is_a_rigid_guide():
    contact, _ = half_wave_in_tube(0.010, 1e9, cells=37)
    assert contact.normal_force() == pytest.approx(half_wave(0.010, 37).normal_force(), rel=1e-3)


@pytest.mark.second
@pytest.mark.parametrize("bending", [2e3, 1e8])
def test_a_rod_falls_through_an_elastic_tube(bending):
    """On four grids; books closed, gaps kept, a stiff tube like a rigid guide."""
    curve = Sine(0.01, 1.8)
    guide = Guide([Tube(-2, 4, C, curve)])
    grids = [Support(s, lateral=1e6, axial=math.inf) for s in (0.0, 1.0, 2.0, 3.0)]
    around = axis_mesh((0, -3), (0, 1), tube=(3.0, 30))
    speeds = []
    for elastic in (True, False):
        rod = BeamSolid(
            axis_mesh((0, -1), (0, 1), rod=(2.4, 48)), ROD, gravity=(0, -9.81), law=Fall()
        )
        tube = BeamSolid(around, Section(mass=5.0, bending=bending), supports=grids, name="tube")
        solid = RodInTube(rod, tube) if elastic else rod
        settle(solid, "rod", guide)
        contact = GuideContact(solid, "rod", guide, Velocity(0.1), 0.1, name="c")
        history = Scene([solid], [contact], ThetaScheme(0.6)).run(0.5, 5e-4)
        assert history.finished
        assert history["c.penetration"].max() < 0.05 * C
        assert np.abs(history["balance"]).max() < 1e-8
        speeds.append(rod.speed)
    if bending == 1e8:
        assert speeds[0] == pytest.approx(speeds[1], rel=5e-3)
    else:  # what gives way holds back less
        assert speeds[0] > 1.02 * speeds[1]


@pytest.mark.parametrize("tension", [0.0, -64.0])
def test_a_tube_settles_that_swings_more_slowly_than_its_rod(tension):
    """Compressed beyond Euler's load, 61.7 N, too: the rod holds it."""
    weighs = {"gravity": (0.5, -9.81), "supports": [Support(1.8, axial=math.inf)]}
    rod = BeamSolid(axis_mesh((0, 0), (0, 1), rod=(1.8, 12)), Section(8.0, 400.0), **weighs)
    ends = [Support(0, lateral=math.inf, axial=math.inf), Support(4, lateral=math.inf)]
    around = axis_mesh((0, -1), (0, 1), tube=(4.0, 16))
    tube = BeamSolid(around, Section(5.0, 100.0, tension=tension), supports=ends, name="tube")
    pair, guide = RodInTube(rod, tube), Guide([Tube(-4, 4, 1e-3, Sine(4e-3, 1.8))])
    pressed = settle(pair, "rod", guide).normal_force()
    start = pair.displacement
    contact = GuideContact(pair, "rod", guide)
    assert Scene([pair], [contact], ThetaScheme(1.0, forces="end")).run(0.5, 5e-2).finished
    np.testing.assert_allclose(pair.displacement, start, atol=1e-3 * C)
    assert contact.normal_force() == pytest.approx(pressed, rel=1e-4)


def test_a_tube_must_be_held():
    rod, free = rod_at(1.0), rod_at(1.0)
    with pytest.raises(InputError, match="held along its axis"):
        RodInTube(rod, free)
    other = BeamSolid(axis_mesh((0, 0), (0, -1), rod=(1.0, 2)), ROD)
    with pytest.raises(InputError, match="direction of the rod"):
        RodInTube(rod, other)


def test_a_rod_and_tube_that_are_held_need_no_contact():
    pins = [Support(s, lateral=math.inf, axial=math.inf) for s in (0.0, 1.0)]
    held, tube = rod_at(1.0, supports=pins), rod_at(1.0, supports=pins)
    assert Scene([RodInTube(held, tube)], []).run(1e-2, 1e-3).finished
    with pytest.raises(InputError, match="neither contact nor support"):
        Scene([RodInTube(rod_at(1.0), tube)], [])


# -- bad input ----------------------------------------------------------------------------------


def rod_at(tip, **others):
    return BeamSolid(axis_mesh((0, -tip), (0, 1), rod=(1.0, 10)), ROD, gravity=(0, -9.81), **others)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Tube(0, 1, -C), "clearance"),
        (lambda: Tube(0, 1, [(0, C), (1, -C)]), "clearance"),
        (lambda: Tube(0, 1, [(1, C), (0, C)]), "downwards"),
        (lambda: Tube(1, 0, C), "top"),
        (lambda: Tube(0, 1, C, curve="S"), "curve"),
        (lambda: Tube(0, 1, C, kinks=[0, 0.5, 1, 5]), "kinks = .*must lie in the tube"),
        (lambda: Card(0, 0), "clearance"),
        (lambda: Sine(0.01, 0.0), "wavelength"),
        (lambda: Sine(0.01, 1.0, "sharp"), "inlet"),
        (lambda: Bow(math.nan, 1.0), "sagitta"),
        (lambda: Guide([]), "pieces"),
        (lambda: Guide([Tube(0, 1, C), Tube(0.5, 2, C)]), "overlap"),
        (lambda: Guide([Tube(0, 1, C)], direction=(0, 0)), "direction"),
        (lambda: Guide([Tube(0, 1, C)], origin=(0, 0, 0), plane=(0, 0, 1)), "perpendicular"),
        (lambda: GuideContact(rod_at(1.0), "tip", Guide([Tube(-1, 2, C)])), "no such stretch"),
        (lambda: GuideContact(rod_at(1.0), "rod", "tube"), "a Guide"),
        (lambda: GuideContact(rod_at(1.0), "rod", Guide([Card(0, C)])), "two stations"),
        (
            lambda: GuideContact(rod_at(1.0), "rod", Guide([Tube(-1, 2, C)], direction=(1, 0))),
            "down the rod's axis",
        ),
        (
            lambda: GuideContact(rod_at(1.0), "rod", Guide([Tube(-1, 2, C)], origin=(0, 0, 0))),
            "dimension 3",
        ),
    ],
)
def test_bad_input_is_refused(build, message):
    with pytest.raises(InputError, match=message):
        build()


def test_a_rod_longer_than_its_guide_allows_is_refused():
    with pytest.raises(InputError, match="longer than its guide"):
        GuideContact(rod_at(3.0), "rod", Guide([Tube(-1, 2, C)]))
    rod = rod_at(1.0, law=Fall(stop=1.5))
    with pytest.raises(InputError, match=r"depth 2.5 m, beyond the end"):
        GuideContact(rod, "rod", Guide([Tube(-1, 2, C)]))


def stretched():
    """A rod that hangs from s = 2 and stretches by a tenth, s = 1 going down by 0.1."""
    axis = axis_mesh((0, 0), (0, 1), low=(1.0, 10), high=(1.0, 10))
    rod = BeamSolid(axis, Section(mass=1.0, bending=EI, axial=1e3))
    rod.displacement = rod.displacement.copy()
    rod.split(rod.displacement)[1][:] = 0.1 * (rod.matrices.s - 2)
    rod.rest()
    return rod


def test_a_station_sees_a_stretch_where_it_has_come_to():
    cards = [Card(-1.5, C), Card(-0.95, C), Card(-0.85, C), Card(0.1, C)]
    high = np.array([True, True, False, False])
    for stretch, seen in (("low", ~high), ("high", high)):
        contact = GuideContact(stretched(), stretch, Guide(cards))
        np.testing.assert_array_equal(~contact.trace.void[contact.stations], seen)
        found = contact.trace.material[contact.stations]
        np.testing.assert_allclose(found, [1.5454545454, 1.0454545454, 0.9545454545, 0.0909090909])


def test_a_tip_is_as_deep_as_its_axis_stretches():
    GuideContact(stretched(), "low", Guide([Tube(-1, 0.21, C)]))
    with pytest.raises(InputError, match=r"depth 0.2 m, beyond the end"):
        GuideContact(stretched(), "low", Guide([Tube(-1, 0.19, C)]))
    GuideContact(stretched(), "high", Guide([Tube(-2, -0.89, C)]))
    with pytest.raises(InputError, match=r"depth -0.9 m, beyond the end"):
        GuideContact(stretched(), "high", Guide([Tube(-2, -0.91, C)]))


def test_a_guide_too_bent_for_its_clearance_is_refused():
    """A straight rod in a bow would start inside the wall; laid in first, it may start."""
    rod, guide = rod_at(1.0), Guide([Tube(-1, 3, C, Bow(0.01, 1.0))])
    with pytest.raises(InputError, match="too bent for its clearance"):
        GuideContact(rod, "rod", guide)
    settle(rod, "rod", guide)
    GuideContact(rod, "rod", guide)


# -- killed and resumed -------------------------------------------------------------------------


def falling(formulation, dim=2, elastic=False, axial=math.inf, friction=0.2):
    """A rod falls from a straight tube into a bent one, over a kink."""
    down = (0.0,) * (dim - 1)
    curve = Straight() if axial < math.inf else Sine(0.005, 1.8, "kinked")
    guide = Guide([Tube(-2, 0, C), Card(-0.11, C / 2), Tube(0, 4, C, curve)], (0.0,) * dim)
    rod = BeamSolid(
        axis_mesh((*down, -0.9), (*down, 1), rod=(1.8, 18)),
        Section(mass=16.662, bending=EI, axial=axial),
        gravity=(0.0 if axial == math.inf else 3.0, *down[1:], -9.81),
        law=Fall(drive_friction=5.0),
        displacement=lambda s: np.outer(np.eye(dim - 1)[0], 1e-4 * np.cos(3 * s)),
    )
    grids = [Support(s, lateral=1e5, axial=math.inf) for s in (0.0, 1.5, 3.0)]
    around = axis_mesh((*down, -3), (*down, 1), tube=(3.0, 12))
    tube = BeamSolid(around, Section(mass=5.0, bending=2e3), supports=grids, name="tube")
    solid = RodInTube(rod, tube) if elastic else rod
    if axial == math.inf:
        settle(solid, "rod", guide)
    contact = GuideContact(solid, "rod", guide, formulation, friction, name="c")
    return Scene([solid], [contact], ThetaScheme(0.6))


@pytest.mark.parametrize(
    ("formulation", "others"),
    [
        (Velocity(0.1), {}),
        (Gap(), {}),
        (Discrete(1e5, 20.0), {}),
        (Compliance(1e6, tangential_stiffness=1e6), {}),
        (Velocity(0.1), {"friction": Tresca(3.0)}),
        (Velocity(0.1), {"elastic": True}),
        (Velocity(0.1), {"axial": 1e7}),
        (Velocity(0.1), {"dim": 3}),
    ],
    ids=["velocity", "gap", "springs", "areas", "stress", "tube", "extensible", "space"],
)
def test_killed_and_resumed_to_the_same_bits(formulation, others, tmp_path):
    """What a rod keeps between steps is a function of its state."""
    dt = 5e-4
    whole = falling(formulation, **others).run(60 * dt, dt)
    assert whole.finished and whole["c.bearing"].max() > 0
    with killed_after(23):
        falling(formulation, **others).run(60 * dt, dt, directory=tmp_path)
    rest = falling(formulation, **others).run(60 * dt, dt, directory=tmp_path, resume=True)
    for column in whole.columns:
        np.testing.assert_array_equal(rest[column], whole[column], err_msg=column)


def test_a_step_sees_its_start_as_its_forces_act():
    """A rod slides past: works are sums of forces and jumps by one operator."""
    scene = falling(Velocity())
    (rod,), (contact,) = scene.solids, scene.contacts
    for _ in range(40):
        list(scene.step(1e-3))
    step = Step(1e-3, scene.scheme, scene.time)
    before = contact.coupling.jump("velocity")
    for part in (rod, contact):
        part.predict(step)
    for part in (rod, contact):
        part.linearise(step)
    np.testing.assert_array_equal(contact.jump.ravel(), contact.trace.mean_jump(rod.velocity))
    assert np.abs(contact.jump - before)[contact.stations].max() > 0


@pytest.mark.quick
def test_a_slope_that_is_that_of_another_line_is_refused():
    right = AnyCurve(lambda x: 1e-3 * np.sin(x), lambda x: 1e-3 * np.cos(x))
    Tube(-2.0, 2.0, 1e-3, right)
    with np.errstate(all="raise"):
        Tube(-2.0, 2.0, 1e-3, AnyCurve(lambda x: 0.01 + 0 * x, lambda x: 0 * x))
    Tube(-1.0, 2.0, 1e-3, AnyCurve(np.abs, np.sign))  # told at its kink or not
    for slope in (
        lambda x: -1e-3 * np.cos(x),
        lambda x: 0 * x,
        lambda x: np.degrees(1e-3 * np.cos(x)),
    ):
        with pytest.raises(InputError, match="derivative: must be that of its function"):
            Tube(-2.0, 2.0, 1e-3, AnyCurve(right.function, slope))


@pytest.mark.parametrize("law", ["velocity", "gap"])
def test_one_rod_falls_alike_by_every_geometry(law):
    """By Newton's method a rod alone, of whose momentum balance nothing was known, stopped within
    the package."""
    ends = []
    for geometry in ("newton", "fixed point"):
        mesh = axis_mesh((0, -0.2), (0, 1), a=(2.0, 12))
        rod = BeamSolid(mesh, Section(3.0, 200.0), gravity=(0.3, -9.81), law=Fall())
        contact = GuideContact(rod, "a", Guide([Tube(-3.0, 3.0, 1e-3)]), law, friction=0.2)
        history = Scene([rod], [contact], ThetaScheme(0.6), geometry=geometry).run(0.2, 1e-3)
        assert history.finished, history.reason
        ends.append([rod.travel, rod.speed])
    np.testing.assert_allclose(ends[0], ends[1], rtol=1e-6)


def test_located_impacts_let_a_rod_fall():
    """Slopes have no mass: where a contact ends they are at once elsewhere, and in a flight of
    1e-17 s turned by 1e8 rad/s. What looked ahead by that met walls across the way, and a rod that
    nothing holds stopped dead, "finished"."""
    for cards in (1, 2):
        mesh = axis_mesh((0, -0.1), (0, 1), a=(1.0, 8))
        rod = BeamSolid(mesh, Section(2.0, 50.0), gravity=(0.2, -9.81), law=Fall())
        above = [Card(-0.6, 8e-4), Card(-0.4, 8e-4)][:cards]
        guide = Guide([*above, Tube(-0.3, 2.0, 8e-4)])
        settle(rod, "a", guide)
        contact = GuideContact(rod, "a", guide, "velocity", name="g")
        scene = Scene([rod], [contact], ThetaScheme(0.5), locate_impacts=True)
        history = scene.run(0.3, 1e-3)
        assert history.finished, history.reason
        assert rod.travel == pytest.approx(9.81 * 0.3**2 / 2, rel=1e-5)
        assert np.abs(history["balance"]).max() < 1e-9
        flights = history["dt"][history["dt"] > 0]
        assert flights.min() > 1e-13


def test_a_rod_held_bent_that_is_nudged_makes_no_energy():
    """So its velocities became what round-off of such flights left: all its strain as a motion."""
    mesh = axis_mesh((0, -0.1), (0, 1), a=(1.0, 8))
    rod = BeamSolid(mesh, Section(2.0, 100.0), law=Driven(0.0))
    guide = Guide([Card(-0.75, 1e-4), Card(-0.4, 1e-4, 1e-3), Card(-0.05, 1e-4)])
    settle(rod, "a", guide)
    state = rod.state()
    rod.unknowns.split(state["velocity"])[0][0, ::2] = 1e-3
    rod.restore(state)
    contact = GuideContact(rod, "a", guide, "velocity")
    history = Scene([rod], [contact], ThetaScheme(0.5), locate_impacts=True).run(0.02, 2e-3)
    assert history.finished, history.reason
    total = history["kinetic"] + history["strain"]
    assert total.max() < total[0] * (1 + 1e-6)
    assert np.abs(history["balance"]).max() < 1e-9 * total[0]


@pytest.mark.parametrize(("length", "stiffness"), [(0.5, 3.5e4), (0.3, 850.0), (2.0, 1e6)])
def test_a_stiff_rod_that_has_far_to_go_settles(length, stiffness):
    """Steps as long as its period, each from rest, came a ten-thousandth of the way: it found no
    rest in a straight tube."""
    mesh = axis_mesh((0, 0), (0, 1), a=(length, 16))
    rod = BeamSolid(mesh, Section(3.0, stiffness), gravity=(0.3, -9.81))
    contact = settle(rod, "a", Guide([Tube(-4.0, 4.0, 1e-3)]))
    np.testing.assert_allclose(contact.force[:, 0].sum(), -3.0 * length * 0.3, rtol=1e-6)
    w = rod.split(rod.displacement)[0][0, ::2]
    np.testing.assert_allclose(np.abs(w), 1e-3, rtol=1e-2)


@pytest.mark.parametrize("error", [3e-4, 1e-4])
def test_a_rod_pressed_at_two_nodes_by_turns_goes_on(error):
    """Where two nodes side by side touch a bent wall one throws the other back, at once: blows and
    flights of 1e-10 s went on for ever."""
    mesh = axis_mesh((0, -0.1), (0, 1), a=(1.0, 10))
    rod = BeamSolid(mesh, Section(2.0, 50.0), gravity=(0.2, -9.81), law=Fall())
    guide = Guide([Tube(-1.4, 0.0, 8e-4), Tube(0.0, 2.0, 8e-4, Sine(0.01, 1.3))])
    settle(rod, "a", guide)
    contact = GuideContact(rod, "a", guide)
    scene = Scene([rod], [contact], ThetaScheme(0.5), locate_impacts=True)
    history = scene.run(0.3, 4e-3, step_error=error)
    assert history.finished and len(history) < 2000
    assert rod.travel == pytest.approx(0.43876, rel=1e-4)
    assert np.abs(history["balance"]).max() < 1e-9
