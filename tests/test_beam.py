# SPDX-License-Identifier: LGPL-3.0-or-later
"""Beams against exact solutions: statics at any slenderness, vibrations, axial motion, flight."""

import math

import meshio
import numpy as np
import pytest
from scenes import rates

from fenicsx_contact import (
    AxisMesh,
    BeamSolid,
    Driven,
    Fall,
    GuideTubeWater,
    InputError,
    QuasiStatic,
    Scene,
    Section,
    Support,
    ThetaScheme,
    axis_mesh,
)
from fenicsx_contact.base import compat
from fenicsx_contact.rods import VonKarmanBeam
from fenicsx_contact.rods.drive import AxialForce
from fenicsx_contact.theory.scheme import Step

UNIFORM = (1.0, 8)
UNEVEN = np.array([0.0, 0.03, 0.31, 0.35, 0.36, 0.71, 0.9, 0.97, 1.0])
CLAMP = Support(0.0, lateral=math.inf, rotational=math.inf, axial=math.inf)
STATIC = ThetaScheme(1.0, forces="end")


def at_rest(beam, dt=1e6, steps=3):
    """The beam after steps so long that nothing but statics is left."""
    assert Scene([beam], [], STATIC).run(steps * dt, dt).finished
    return beam


def loaded(axis, section, load=(0.0,), **others):
    """A cantilever under lateral forces at its end, one for each plane."""
    beam = BeamSolid(axis, section, supports=[CLAMP], **others)
    bending, _ = beam.split(beam.weight)
    bending[:, -2] += load
    return at_rest(beam)


@pytest.mark.parametrize("slenderness", [10, 100, 1e4])
@pytest.mark.parametrize("nodes", [UNIFORM, UNEVEN], ids=["uniform", "uneven"])
def test_cantilever_is_exact_at_every_slenderness(slenderness, nodes):
    """Tip load, P/(3EI) + P/GA, on 8 cells: no locking, no loss, whatever the mesh."""
    h = 1 / slenderness
    EI, GA = 1.0, 5 / 6 * h * (12 / h**3) / 2.6  # a rectangle of nu = 0.3
    section = Section(mass=1e-3, bending=EI, shear=GA)
    beam = loaded(axis_mesh((0, 0), (0, 1), all=nodes), section, [1e-3])
    deflection = beam.split(beam.displacement)[0][0, ::2]
    s = beam.matrices.s
    exact = 1e-3 * (s**2 / 2 - s**3 / 6 + s * EI / GA)
    np.testing.assert_allclose(deflection, exact, rtol=0, atol=1e-9 * exact[-1])
    # and between the nodes
    places = np.linspace(0, 1, 41)
    points = np.stack([0 * places, places], axis=1)
    between = beam.trace(points).positions()[:, 0]
    exact = 1e-3 * (places**2 / 2 - places**3 / 6 + places * EI / GA)
    np.testing.assert_allclose(between, exact, rtol=0, atol=1e-9 * exact[-1])


@pytest.mark.parametrize("direction", [(0, 0, 1), (1, 2, -0.5)])
def test_in_space_both_planes_bend_alike(direction):
    axis = axis_mesh((0.3, -1, 2), direction, all=UNEVEN)
    beam = loaded(axis, Section(mass=1e-3, bending=2.0), [3e-3, -4e-3])
    tip = axis.origin + axis.direction
    moved = beam.trace(tip[None]).positions()[0] - tip
    assert np.linalg.norm(moved) == pytest.approx(5e-3 / 6, rel=1e-9)
    assert moved @ axis.direction == pytest.approx(0, abs=1e-15)
    np.testing.assert_allclose(beam.frame @ moved, [0.5e-3, -4e-3 / 6], rtol=1e-9)


def test_sections_vary_by_stretch_and_as_functions():
    """A stepped cantilever exactly; one whose stiffness falls linearly to second order."""
    axis = axis_mesh((0, 0), (1, 0), root=(0.4, 2), rest=(0.6, 3))
    stepped = {"root": Section(1e-3, 2.0), "rest": Section(1e-3, 0.5)}
    beam = loaded(axis, stepped, [1.0])
    exact = (1 - 0.6**3) / 3 / 2.0 + 0.6**3 / 3 / 0.5
    assert beam.split(beam.displacement)[0][0, -2] == pytest.approx(exact, rel=1e-9)
    errors = []
    for cells in (4, 8, 16):
        section = Section(1e-3, lambda s: 1 - s / 2)
        beam = loaded(axis_mesh((0, 0), (1, 0), all=(1.0, cells)), section, [1.0])
        exact = 2 * math.log(2) - 1  # int (1 - s)²/(1 - s/2) ds
        errors.append(abs(beam.split(beam.displacement)[0][0, -2] - exact))
    assert rates(errors).min() > 1.9


def test_weight_hangs_and_sags():
    """Gravity along and across: u = rho g L²/(2 EA) at the end, w = q L⁴/(8 EI) to second order."""
    section = Section(mass=2.0, bending=50.0, axial=300.0)
    axis = axis_mesh((0, 0), (0, -1), all=UNEVEN)
    beam = at_rest(BeamSolid(axis, section, supports=[CLAMP], gravity=(0, -9.81)))
    assert beam.split(beam.displacement)[1][-1] == pytest.approx(2 * 9.81 / 600, rel=1e-9)
    errors = []
    for cells in (4, 8, 16):
        axis = axis_mesh((0, 0), (1, 0), all=(1.0, cells))
        beam = at_rest(BeamSolid(axis, section, supports=[CLAMP], gravity=(0, -9.81)))
        tip = beam.trace(np.array([[1.0, 0.0]])).positions()[0, 1]
        errors.append(abs(tip + 2 * 9.81 / 8 / 50))
    assert rates(errors).min() > 1.9


def test_springs_and_point_masses():
    """A stiff beam on two springs vibrates as a body of two masses would."""
    axis = axis_mesh((0, 0), (0, 1), all=(1.0, 4))
    beam = BeamSolid(
        axis,
        Section(mass=0.0, bending=1e7),
        masses=[(0.0, 3.0), (1.0, 5.0)],
        supports=[Support(0.0, lateral=12.0), Support(1.0, lateral=20.0)],
    )
    assert beam.mass == 8.0
    assert beam.matrices.slowest_period() == pytest.approx(math.pi, rel=1e-7)


@pytest.mark.parametrize("share", [0.0, 2.0, -0.5])
def test_first_frequency_converges_at_second_order(share):
    """Under tension, as a share of Euler's load: omega² = (1 + share) (pi/L)⁴ EI/(rho A)."""
    errors, tension = [], share * 7.0 * (math.pi / 2) ** 2
    for cells in (8, 16, 32):
        axis = axis_mesh((0, 0), (0, 1), all=(2.0, cells))
        pins = [Support(0.0, lateral=math.inf), Support(2.0, lateral=math.inf)]
        beam = BeamSolid(axis, Section(mass=3.0, bending=7.0, tension=tension), supports=pins)
        exact = (math.pi / 2) ** 2 * math.sqrt((1 + share) * 7 / 3)
        errors.append(abs(2 * math.pi / beam.matrices.slowest_period() / exact - 1))
    assert errors[-1] < 1e-3
    assert rates(errors).min() > 1.9


@pytest.mark.parametrize("dim", [2, 3])
def test_water_that_moves_along_slows_vibrations_not_falls(dim):
    """The frequency is that of the mass with the water's; sag and free fall are those without."""
    first, g = np.eye(dim)[0], 9.81
    pins = [Support(0.0, lateral=math.inf), Support(2.0, lateral=math.inf)]
    dry, wet, heavy = (
        Section(mass=m, bending=7.0, lateral_added_mass=added)
        for m, added in ((3.0, 0.0), (3.0, 1.5), (4.5, 0.0))
    )

    def beam(section, supports=pins, **others):
        axis = axis_mesh([0.0] * dim, first, all=(2.0, 16))
        return BeamSolid(axis, section, supports=supports, **others)

    periods = [beam(section).matrices.slowest_period() for section in (dry, wet, heavy)]
    assert periods[1] == pytest.approx(periods[2], rel=1e-12) and periods[1] > 1.2 * periods[0]
    weight = {"gravity": -g * np.eye(dim)[1]}
    sags = [at_rest(beam(section, **weight)).displacement for section in (dry, wet)]
    np.testing.assert_allclose(sags[1], sags[0], rtol=1e-9, atol=1e-12)
    falls = [beam(section, [], gravity=g * first) for section in (dry, wet)]
    for each in falls:
        Scene([each], [], allow_free=True).run(0.1, 1e-2)
        assert each.mass == pytest.approx(6.0) and -each.speed == pytest.approx(0.1 * g)
    with pytest.raises(InputError, match="lateral_added_mass"):
        Section(mass=1.0, bending=1.0, lateral_added_mass=-1.0)


def test_a_column_buckles_beyond_eulers_load():
    """Between -0.99 and -1.01 of it the slowest vibration begins to grow; steps towards rest are
    then so short that their energy is convex."""
    pins = [Support(0.0, lateral=math.inf), Support(2.0, lateral=math.inf)]
    axis, euler = axis_mesh((0, 0), (0, 1), all=(2.0, 40)), 7.0 * (math.pi / 2) ** 2
    for share, buckles in ((-0.99, False), (-1.01, True)):
        beam = BeamSolid(axis, Section(mass=3.0, bending=7.0, tension=share * euler), supports=pins)
        k = beam.matrices
        inner = np.ix_(k.free_bending, k.free_bending)
        assert (np.linalg.eigvalsh(k.bending_stiffness[inner])[0] < 0) == buckles
        step = k.longest_step()
        np.linalg.cholesky(np.diag(k.bending_mass)[inner] / step**2 + k.bending_stiffness[inner])


def test_a_beam_pinned_at_each_node_has_no_period():
    pins = [Support(s, lateral=math.inf) for s in np.linspace(0, 2, 5)]
    axis = axis_mesh((0, 0), (0, 1), all=(2.0, 4))
    k = BeamSolid(axis, Section(mass=3.0, bending=7.0), supports=pins).matrices
    assert k.slowest_period() == k.longest_step() == math.inf
    free = BeamSolid(axis, Section(mass=3.0, bending=7.0)).matrices
    assert k.longest_step(free) == free.longest_step() < math.inf


@pytest.mark.parametrize("axial", [math.inf, 5e3])
def test_free_flight_keeps_energy_and_falls(axial):
    """Vibrating and falling by metres: theta = 1/2 conserves, the travel is g t²/2."""
    axis = axis_mesh((0, 0), (0, 1), all=(2.0, 20))
    beam = BeamSolid(
        axis,
        Section(mass=3.0, bending=70.0, axial=axial, rotary=1e-3),
        gravity=(0, -9.81),
        displacement=lambda s: 1e-3 * np.cos(3 * s)[None],
        law=Fall(),
    )
    history = Scene([beam], [], allow_free=True).run(1.0, 1e-3)
    assert beam.travel == pytest.approx(9.81 / 2, rel=1e-12)
    total = history["kinetic"] + history["strain"] + history["potential"]
    size = history["kinetic"].max()
    assert np.ptp(total) < 1e-11 * size
    assert np.abs(history["balance"]).max() < 1e-11 * size
    assert history["strain"][0] > 1e-5


def test_extensible_rod_in_water_falls_like_a_rigid_one():
    """The law acts on the mean: a stiff axial spring changes the fall by nothing that matters."""
    times = []
    for axial in (math.inf, 5.9e7):
        axis = axis_mesh((0, 0), (0, 1), all=(3.86, 20))
        beam = BeamSolid(
            axis,
            Section(mass=126.4176 / 3.86, bending=850.0, axial=axial),
            gravity=(0, -9.81),
            law=Fall(GuideTubeWater()),
        )
        history = Scene([beam], [], ThetaScheme(0.6), allow_free=True).run(0.3, 1e-3)
        assert np.abs(history["balance"]).max() < 1e-9
        times.append(beam.travel)
    assert times[1] == pytest.approx(times[0], rel=1e-9)


class Winch:
    """Somebody else's drive: a spring that pulls a rod to a travel of 1 m."""

    prescribed = stop = None

    def check(self, mass, gravity, held):
        if held:
            raise InputError("a winch pulls free rods")

    def added_mass(self, travel):
        return 0.0

    def forces(self, travel, speed, mass, gravity, dt):
        return [AxialForce("winch", 100.0 * (1.0 - travel), 0.0, -100.0)]


def test_a_stranger_drives_a_beam():
    axis = axis_mesh((0, 0), (0, 1), all=(1.0, 4))
    beam = BeamSolid(axis, Section(mass=4.0, bending=70.0), law=Winch())
    history = Scene([beam], [], allow_free=True).run(0.2, 1e-3)
    assert beam.travel == pytest.approx(1 - math.cos(1), rel=1e-5)
    assert -beam.axial.taken["winch"] == pytest.approx(50 * math.sin(1) ** 2, rel=1e-5)
    assert np.abs(history["balance"]).max() < 1e-10
    with pytest.raises(InputError, match="winch pulls"):
        BeamSolid(axis, Section(4.0, 70.0), supports=[CLAMP], law=Winch())


@pytest.mark.parametrize("kind", [BeamSolid, VonKarmanBeam])
def test_a_flow_works_on_the_way_gone(kind):
    """As the weight does, by theta = 1, too."""
    axis, books = axis_mesh((0, 0), (1, 0), all=(1.0, 8)), []
    section = Section(4.0, 70.0, **({"axial": 1e6} if kind is VonKarmanBeam else {}))
    for load in (
        {"gravity": (0, -9.81)},
        {"lateral_load": lambda s: np.full((1, len(s)), -4.0 * 9.81)},
    ):
        beam = kind(axis, section, supports=[CLAMP], **load)
        history = Scene([beam], [], ThetaScheme(1.0)).run(0.05, 1e-3)
        books.append([history[name] for name in ("kinetic", "strain", "potential", "scheme")])
        assert np.abs(history["balance"]).max() < 1e-12
    assert books[0][-1][-1] < -1e-3
    np.testing.assert_allclose(books[1], books[0], atol=1e-9)


class Weighted(Driven):
    """A drive that lets down a rod with a weight at its tip, and water that moves along."""

    def added_mass(self, travel):
        return 0.5 + travel

    def forces(self, travel, speed, mass, gravity, dt):
        return [AxialForce("tip", 50.0 * (1 + travel), 0.0, 50.0, at=0.0)]


@pytest.mark.parametrize("kind", [BeamSolid, VonKarmanBeam])
def test_a_drive_holds_what_its_law_lists(kind):
    """It bears the weight at the tip, which pulls all of the rod, and the books have both."""
    axis = axis_mesh((0, 0), (0, 1), all=(1.0, 4))
    section = Section(0.1, 0.05, **({"axial": 1e6} if kind is VonKarmanBeam else {}))
    rod = kind(axis, section, law=Weighted(0.5))
    history = Scene([rod], [], ThetaScheme(1.0, forces="end"), allow_free=True).run(0.2, 1e-2)
    assert rod.travel == pytest.approx(0.1, rel=1e-3)
    assert rod.axial.drive_force == pytest.approx(-55.0, rel=1e-3)
    if kind is VonKarmanBeam:
        np.testing.assert_allclose(rod.axial_force(), 55.0, rtol=1e-3)
    assert -rod.axial.taken["tip"] == pytest.approx(50 * 0.1 + 25 * 0.1**2, rel=6e-3)
    assert np.abs(history["balance"]).max() < 1e-10


def dropped(stop, theta, kind=BeamSolid, axial=None, dt=1e-2, **law):
    """A rod of 2 kg that falls on a spring, k = 1e4 N/m (omega dt = 0.7): the history with its
    energies, that of the spring by where its tip is, over that of the fall; and the rod."""
    k, section = 1e4, Section(2.0, 100.0) if axial is None else Section(2.0, 100.0, axial=axial)
    axis = axis_mesh((0, 0), (0, 1), all=(1.0, 4))
    fall = Fall(stop=stop, stop_stiffness=k, **law)
    beam = kind(axis, section, gravity=(0, -9.81), law=fall)

    def energy():
        tip = -beam.split(beam.displacement)[1][0]
        weight = -2 * 9.81 * beam.travel
        kinetic, strain, _ = beam.energies()
        return kinetic + strain + weight + k / 2 * max(tip - stop, 0.0) ** 2

    def taken():
        tip = -beam.split(beam.displacement)[1][0]
        return beam.axial.taken.get("stop", 0.0) - k / 2 * max(tip - stop, 0.0) ** 2

    probes = {"energy": energy, "taken": taken, "z": lambda: beam.travel, "v": lambda: beam.speed}
    scene = Scene([beam], [], ThetaScheme(theta), allow_free=True)
    history = scene.run(0.5, dt, probes=probes)
    assert history.finished, history.reason
    return history, beam


@pytest.mark.parametrize("stop", [0.4, 0.413, 0.426])
@pytest.mark.parametrize(
    ("kind", "axial"), [(BeamSolid, None), (BeamSolid, 1e5), (VonKarmanBeam, 1e5)]
)
def test_a_stop_gives_back_what_it_took(kind, axial, stop):
    """By theta = 1/2 exactly, wherever in a step it is met; the books have its energy; implicit
    steps lose energy, and never make any."""
    fall = 2 * 9.81 * stop
    history, beam = dropped(stop, 0.5, kind, axial)
    assert beam.speed < -1.0 and history["z"].max() > stop + 0.02
    for name in ("energy", "taken", "balance"):
        assert np.abs(history[name]).max() < 1e-8 * fall
    history, beam = dropped(stop, 1.0, kind, axial)
    assert np.diff(history["energy"]).max() < 1e-8 * fall
    assert history["energy"].min() < -0.1 * fall and np.abs(history["balance"]).max() < 1e-8 * fall


def test_a_step_is_continuous_in_where_the_stop_is():
    """A rod at rest that just touches it, or not quite."""
    ends = [dropped(stop, 0.5, dt=5e-3)[0]["z"] for stop in (-1e-9, 0.0, 1e-9)]
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-8)
    np.testing.assert_allclose(ends[2], ends[1], rtol=0, atol=1e-8)


def test_trace_is_consistent():
    """Free jump, compliance and spread forces belong to one operator, also between traces."""
    axis = axis_mesh((0, 0, 0), (1, 2, 2), all=UNEVEN)
    beam = BeamSolid(axis, Section(2.0, 3.0, axial=40.0), supports=[CLAMP], gravity=(1, 2, 3))
    places = np.array([0.2, 0.31, 0.8])
    one = beam.trace(places[:, None] * axis.direction)
    two = beam.trace(np.array([0.5, 1.0])[:, None] * axis.direction)
    step = Step(1e-2, ThetaScheme(0.7))
    force = np.random.default_rng(0).normal(size=6)
    beam.predict(step)
    beam.linearise(step)
    for trace in (one, two):
        trace.follow()
        trace.linearise(step)
    two.spread(force)
    beam.correct(step)

    def whole(a, b):
        return a.compliance(np.arange(a.mobility().size), b, np.arange(b.mobility().size))

    expected = one.free_jump() + whole(one, two) @ force
    np.testing.assert_allclose(one.jump(beam.trial_velocity), expected, rtol=1e-12)
    np.testing.assert_allclose(whole(one, two), whole(two, one).T, atol=1e-12)
    own = whole(one, one)
    np.testing.assert_allclose(one.mobility(), own.diagonal(), rtol=1e-12)
    some = np.array([0, 4, 5, 8])
    np.testing.assert_allclose(one.compliance(some, one, some), own[np.ix_(some, some)], rtol=1e-12)
    np.testing.assert_allclose(own, own.T, atol=1e-12)
    assert np.linalg.eigvalsh(own).min() > 0


def test_runs_resume_identically(tmp_path):
    def scene():
        axis = axis_mesh((0, 0), (0, 1), all=(2.0, 10))
        beam = BeamSolid(
            axis,
            Section(3.0, 70.0),
            gravity=(0, -9.81),
            displacement=lambda s: 1e-3 * s[None] ** 2,
            law=Fall(GuideTubeWater(buoyancy=0.5), drive_friction=3.0),
        )
        return Scene([beam], [], allow_free=True)

    whole = scene().run(0.05, 1e-3)
    scene().run(0.02, 1e-3, directory=tmp_path)
    rest = scene().run(0.05, 1e-3, directory=tmp_path, resume=True)
    np.testing.assert_array_equal(whole.rows(), rest.rows())


def test_fields_are_written(tmp_path):
    """For ParaView: the axis as lines, moved by the fall."""
    axis = axis_mesh((0, 0, 0), (0, 0, 1), all=(2.0, 4))
    beam = BeamSolid(axis, Section(3.0, 70.0), gravity=(0, 0, -9.81), law=Fall(), name="beam")
    Scene([beam], [], allow_free=True).run(0.1, 1e-2, directory=tmp_path, fields_every=5)
    files = sorted((tmp_path / "fields").glob("beam_*.vtu"))
    assert len(files) == 3
    grid = meshio.read(files[-1])
    assert grid.cells[0].type == "line" and len(grid.cells[0].data) == 4
    np.testing.assert_allclose(grid.point_data["displacement"][:, 2], -9.81 * 0.005, rtol=1e-12)


# -- bad input ----------------------------------------------------------------------------------


def test_an_axis_must_be_a_line():
    line = np.array([[0, 0], [0, 1.0], [0, 2.0]])
    for points, cells in (
        ([[0, 0], [0, 1.0], [0.1, 2.0]], [[0, 1], [1, 2]]),  # bent
        (line, [[0, 1], [0, 2]]),  # folded
    ):
        mesh = compat.create_mesh(
            compat.MPI.COMM_SELF, np.array(cells), np.array(points, dtype=float), "interval"
        )
        with pytest.raises(InputError, match=r"line|follow each other"):
            AxisMesh(mesh, np.zeros(2), np.array([0.0, 1.0]), {"all": (0, 2)})
    surface = compat.create_mesh(
        compat.MPI.COMM_SELF,
        np.array([[0, 1, 2]]),
        np.array([[0, 0], [1.0, 0], [0, 1]]),
        "triangle",
    )
    with pytest.raises(InputError, match="mesh of intervals"):
        AxisMesh(surface, np.zeros(2), np.array([0.0, 1.0]), {})


AXIS = axis_mesh((0, 0), (0, 1), low=(1.0, 4), high=(1.0, 4))
GOOD = Section(1.0, 1.0)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: axis_mesh((0, 0), (0, 0), all=(1.0, 2)), "direction"),
        (lambda: axis_mesh((0, 0), (0, 1)), "at least one"),
        (lambda: axis_mesh((0, 0), (0, 1), all=(-1.0, 2)), "length"),
        (lambda: axis_mesh((0, 0), (0, 1), all=(1.0, 0)), "cells"),
        (lambda: axis_mesh((0, 0), (0, 1), all=[0.0, 1.0, 0.5]), "rise"),
        (lambda: axis_mesh((0,), (1,), all=(1.0, 2)), "2 or 3"),
        (lambda: BeamSolid(AXIS, Section(0.0, 1.0)), "mass of 0.0 kg"),
        (lambda: BeamSolid(AXIS, {"low": GOOD}), "no section at s = 1"),
        (lambda: BeamSolid(AXIS, {"low": GOOD, "top": GOOD}), "no such stretch"),
        (lambda: BeamSolid(AXIS, {"low": GOOD, "high": Section(1, 1, axial=1)}), "all or none"),
        (lambda: BeamSolid(AXIS, Section(1.0, lambda s: s - 1)), "bending"),
        (lambda: BeamSolid("axis", GOOD), "AxisMesh"),
        (lambda: BeamSolid(AXIS, GOOD, masses=[(0.1, 1.0)]), "no node"),
        (lambda: BeamSolid(AXIS, GOOD, masses=[(0.0, -1.0)]), "masses = -1.0"),
        (lambda: BeamSolid(AXIS, GOOD, law="fall"), "law = 'fall'"),
        (lambda: BeamSolid(AXIS, GOOD, supports=[CLAMP], law=Driven()), "inextensible"),
        (lambda: BeamSolid(AXIS, Section(1, 1, axial=1), law=Driven(at=2.1)), "at = 2.1"),
        (
            lambda: BeamSolid(AXIS, Section(1, 1, axial=1), supports=[CLAMP], law=Driven(at=0.0)),
            "support holds",
        ),
        (lambda: VonKarmanBeam(AXIS, GOOD), "axial stiffness that is infinite"),
        (lambda: Fall(stop=1.0, stop_at=-1.0), "stop_at = -1.0"),
        (lambda: BeamSolid(AXIS, GOOD, displacement=lambda s: s), "displacement"),
        (lambda: Section(-1.0, 1.0), "mass = -1.0"),
        (lambda: Section(1.0, 0.0), "bending = 0.0"),
        (lambda: Section(1.0, math.inf), "bending = inf"),
        (lambda: Support(0.0, lateral=-1.0), "lateral"),
        (lambda: Driven(math.nan), "speed"),
        (lambda: Fall(water="wet"), "water = 'wet'"),
        (lambda: Fall(drive_friction=-1), "drive_friction"),
        (lambda: GuideTubeWater(ramp=0), "ramp"),
    ],
)
def test_bad_input_is_refused(build, message):
    with pytest.raises(InputError, match=message):
        build()


@pytest.mark.parametrize(
    "law", [Fall(GuideTubeWater(buoyancy=2.5)), Fall(drive_friction=30.0), Fall()]
)
def test_a_rod_that_would_never_fall_is_refused(law):
    """2 kg: buoyancy carries it, the drive line holds it, or there is no gravity."""
    gravity = (0, -9.81) if law != Fall() else None
    with pytest.raises(InputError, match="never fall") as caught:
        BeamSolid(AXIS, GOOD, law=law, gravity=gravity)
    assert ("no gravity acts along" in str(caught.value)) == (gravity is None)


def test_no_part_of_a_monolithic_system():
    beam = BeamSolid(axis_mesh((0, 0), (0, 1), all=UNIFORM), Section(1.0, 1.0), supports=[CLAMP])
    with pytest.raises(InputError, match=r"solver = 'monolithic'.*'condensed'"):
        Scene([beam], [], geometry="newton", solver="monolithic")


def test_no_part_of_a_quasi_static_scene():
    """Said as what it is, and what does as well: a long step by theta = 1."""
    beam = BeamSolid(AXIS, GOOD, supports=[CLAMP])
    with pytest.raises(
        InputError, match=r"'beam' is a BeamSolid, .*long steps of ThetaScheme\(1.0\)"
    ):
        Scene([beam], [], QuasiStatic())


def test_a_support_holds_nothing_that_is_given_elsewhere():
    """A rigid shift had a strain energy: the node that is held was put to zero without a word."""
    axis, section = axis_mesh((0, 0), (0, 1), r=(1.0, 4)), Section(mass=1.0, bending=1.0)

    def beam(support, **given):
        return BeamSolid(axis, section, supports=[support], **given)

    held, clamped = Support(0.0, lateral=math.inf), Support(1.0, rotational=math.inf)
    with pytest.raises(InputError, match="displacement: must be zero at s = 0 m"):
        beam(held, displacement=lambda s: 0.01 + 0 * s[None])
    with pytest.raises(InputError, match="slope: must be zero at s = 1 m"):
        beam(clamped, displacement=lambda s: 0.01 * s[None], slope=lambda s: 0.01 + 0 * s[None])
    # what is zero there but for round-off is taken, and what turns about a pin has no strain
    beam(held, displacement=lambda s: 0.01 * np.sin(np.pi * (s[None] - 1)))
    turned = beam(held, displacement=lambda s: 0.01 * s[None])
    assert turned.energies()[1] < 1e-20
