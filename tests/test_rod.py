# SPDX-License-Identifier: LGPL-3.0-or-later
"""The drop of a control rod against its one-dof law, against itself refined, and its energies."""

import importlib.util
import re
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from fenicsx_contact import (
    BeamSolid,
    Driven,
    Fall,
    Gap,
    GuideTubeWater,
    InputError,
    Scene,
    Section,
    ThetaScheme,
    Tresca,
    Velocity,
    axis_mesh,
)
from fenicsx_contact.references.rod import one_dof_drop
from fenicsx_contact.rods import (
    Card,
    Guide,
    GuideContact,
    RodDrop,
    Sine,
    Straight,
    Tube,
    settle,
    time_at,
)
from fenicsx_contact.rods.drive import AxialForce

DEMOS = Path(__file__).resolve().parent.parent / "demos"


def load(name):
    spec = importlib.util.spec_from_file_location(name, DEMOS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


demo, slowly = load("rod_drop"), load("rod_insertion")
STRAIGHT = demo.Assumed(amplitude=0.0, friction=0.0)
SMOOTH, KINKED = demo.Assumed(), demo.Assumed(kinked=True)
COARSE = 2e-3  # twenty times the demo's step
TRAVELS = [demo.DASHPOT, demo.BOTTOM]


def one_dof(force=0.0, mass=126.4176):
    return one_dof_drop(TRAVELS, mass=mass, water=GuideTubeWater(), force=force)[0]


def times(drop):
    return np.array([drop.time_at(travel) for travel in TRAVELS])


@pytest.fixture(scope="module")
def smooth():
    return demo.drop(SMOOTH, dt=COARSE)


@pytest.fixture(scope="module")
def kinked():
    return demo.drop(KINKED, dt=COARSE)


# -- without contact friction -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("friction", "T5", "total"),
    [
        (0, 1.30044, 1.70827),
        (100, 1.36312, 1.79061),
        (200, 1.43584, 1.88614),
        (300, 1.52160, 1.99879),
    ],
)
def test_one_dof_law(friction, T5, total):
    """The reference numbers of an independent integration."""
    np.testing.assert_allclose(one_dof(friction), [T5, total], atol=1e-5)


@pytest.mark.parametrize(
    ("friction", "T5", "total"),
    [
        pytest.param(100, 1.36312, 1.79061, marks=pytest.mark.second),
        pytest.param(0, 1.30044, 1.70827, marks=pytest.mark.long),
    ],
)
def test_straight_drop(friction, T5, total):
    drop = demo.drop(replace(STRAIGHT, drive_friction=float(friction)), dt=5e-4)
    np.testing.assert_allclose(times(drop), [T5, total], atol=1e-4)
    assert drop.history["guide.bearing"].max() == 0
    assert np.abs(drop.history["balance"]).max() < 1e-9


def test_straight_drop_is_of_second_order():
    exact = one_dof()
    scheme = ThetaScheme(0.5)
    errors = [
        np.abs(times(demo.drop(STRAIGHT, dt=dt, scheme=scheme)) - exact)[0] for dt in (8e-3, 4e-3)
    ]
    assert np.log2(errors[0] / errors[1]) > 1.7


@pytest.mark.second
def test_states_of_fdnl100():
    """Three published states, to which the water law was fitted: its own fit, 1.5 %."""
    h = demo.drop(replace(STRAIGHT, drive_friction=100.0), dt=1e-3).history
    for t, z, v in ((0.7, 1.1515, 2.6187), (1.4, 3.1558, 2.6511), (1.785, 3.6073, 0.7287)):
        assert np.interp(t, h.time, h["travel"]) == pytest.approx(z, rel=1.5e-2)
        assert np.interp(t, h.time, h["speed"]) == pytest.approx(v, rel=1.5e-2)


def test_the_axial_budget_closes():
    """Recomputed from the course of the fall alone: (M - m_w) g z = kinetic + drag + added mass."""
    drop = demo.drop(STRAIGHT, dt=1e-3, scheme=ThetaScheme(0.5))
    h, water, M = drop.history, GuideTubeWater(), drop.rod.mass
    t, z, v = h.time, h["travel"], h["speed"]
    drag = np.array([water.drag(x)[0] for x in z]) * v**3
    added = np.array([water.added_mass(x) for x in z])
    lost = 0.5 * water.mass / water.mass_travel * v**3  # -1/2 m_a'(z) v³

    def integral(f):
        return 0.5 * (f[1:] + f[:-1]) @ np.diff(t)

    gravity = (M - water.buoyancy) * demo.G * z[-1]
    kinetic = 0.5 * (M + added[-1]) * v[-1] ** 2
    budget = gravity - kinetic - integral(drag) - integral(lost)
    assert abs(budget) < 1e-6 * M * demo.G * z[-1]


@pytest.mark.second
def test_end_stop_bounces_the_rod():
    """The energy of a spring, and the drive line brings the rod to rest."""
    rod = demo.rod(replace(STRAIGHT, drive_friction=400.0))
    guide = demo.guide(STRAIGHT)
    contact = GuideContact(rod, "rods", guide, name="guide")
    history = Scene([rod], [contact]).run(4.0, 1e-3, probes={"travel": lambda: rod.travel})
    deepest = history["travel"].max()
    assert 1e-3 < deepest - demo.BOTTOM < 0.05
    assert abs(rod.speed) < 1e-3
    held = (rod.mass - GuideTubeWater().buoyancy) * demo.G
    force = 1.7e5 * (rod.travel - demo.BOTTOM)
    assert abs(force - held) <= 400 * (1 + 1e-6)
    assert np.abs(history["balance"]).max() < 1e-9


# -- with contact -------------------------------------------------------------------------------


@pytest.mark.second
def test_formulations_agree(smooth, kinked):
    """Velocity and gap within 0.05 %, also with a kinked inlet."""
    for drop, case in ((smooth, SMOOTH), (kinked, KINKED)):
        gap = demo.drop(case, Gap(), dt=COARSE)
        np.testing.assert_allclose(times(gap), times(drop), rtol=5e-4)
        assert gap.history["guide.penetration"].max() < 0.05 * demo.DASHPOT_CLEARANCE


def test_drop_in_smooth_and_kinked_tubes(smooth, kinked):
    """Friction is mu N; the kink costs ten times what the bow does; books and walls are kept."""
    T5 = [drop.time_at(demo.DASHPOT) - one_dof()[0] for drop in (smooth, kinked)]
    assert 0.008 < T5[0] < 0.012 and 0.08 < T5[1] < 0.11
    for drop in (smooth, kinked):
        h = drop.history
        assert h.finished and not any("halved" in text for _, text in h.remarks)
        sliding = h["speed"] > 0.1
        np.testing.assert_allclose(
            -h["rubbing"][sliding], 0.3 * h["normal"][sliding], rtol=2e-3, atol=1e-6
        )
        work = drop.rod.mass * demo.G * drop.rod.travel
        assert np.abs(h["balance"]).max() < 1e-9 * work
        assert abs(h["scheme"][-1]) < 1e-4 * work


@pytest.mark.second
def test_the_drive_rod_is_guided_too(kinked):
    """A second contact on the same rod: cards around its drive rod bear, and hold it back a little
    where the cluster is slowed in the dashpot; T5 does not see them."""
    rod, guide = demo.rod(KINKED), demo.guide(KINKED)
    settle(rod, "rods", guide)
    cards = Guide([Card(depth, 2e-3) for depth in (-4.5, -6.0, -7.5, -9.0)])
    contacts = [
        GuideContact(rod, "rods", guide, friction=0.3, name="guide"),
        GuideContact(rod, "drive", cards, friction=0.3, name="drive"),
    ]
    history = Scene([rod], contacts, demo.SCHEME).run(
        4.0,
        COARSE,
        probes={"travel": lambda: rod.travel, "speed": lambda: rod.speed},
        stop_when=lambda: rod.travel >= demo.BOTTOM,
    )
    assert history.finished and np.abs(history["drive.force_y"]).max() > 1
    T5, total = (time_at(history, travel) for travel in TRAVELS)
    assert pytest.approx(times(kinked)[0], rel=1e-3) == T5
    assert 1 < total / times(kinked)[1] < 1.003
    assert np.abs(history["balance"]).max() < 1e-9 * rod.mass * demo.G * rod.travel


@pytest.mark.second
@pytest.mark.parametrize("case", ["smooth", "kinked"])
def test_one_dof_law_fed_with_static_forces(case, smooth, kinked):
    """Lateral dynamics hardly matter: mu N(z) and the walls' push of a slow insertion give T5."""
    drop, a = {"smooth": (smooth, SMOOTH), "kinked": (kinked, KINKED)}[case]
    slow = slowly.insertion(replace(a, friction=0.0), step=3e-3).history
    assert slow.finished
    steps = slow["dt"] > 0  # in impacts the forces are percussions
    travel, normal, wall = (slow[name][steps] for name in ("travel", "normal", "wall"))

    def held(z):
        return a.friction * np.interp(z, travel, normal) - np.interp(z, travel, wall)

    T5 = one_dof(held)[0]
    assert drop.time_at(demo.DASHPOT) == pytest.approx(T5, rel=5e-4)


@pytest.mark.second
def test_the_lateral_budget_closes_at_theta_one_half():
    """Work of the walls = stored + lost in impacts (+ nothing: the scheme conserves)."""
    drop = demo.drop(SMOOTH, Velocity(), dt=1e-3, scheme=ThetaScheme(0.5))
    h = drop.history
    middle = 0.5 * (h["speed"][1:] + h["speed"][:-1])
    axial = np.cumsum((h["wall"] + h["rubbing"])[1:] * middle * h.span[1:])
    lateral = (h["impact"] + h["friction"])[1:] - axial
    stored = h["lateral"][1:] - h["lateral"][0]
    assert np.ptp(stored) > 0.5
    np.testing.assert_allclose(lateral, stored, atol=1e-3 * np.ptp(stored))
    assert np.abs(h["scheme"]).max() < 1e-3 * np.ptp(stored)
    assert h["guide.penetration"].max() < 0.1 * demo.TUBE_CLEARANCE


@pytest.fixture(scope="module")
def damped():
    return over_a_kink(Velocity(), 1.0)


def over_a_kink(formulation, theta):
    """A rod driven at 2.5 m/s over a kink of 17 mrad, one station; without friction."""
    clearance = demo.TUBE_CLEARANCE
    rod = BeamSolid(axis_mesh((0, -0.9), (0, 1), rod=(2.4, 24)), demo.RODS)
    guide = Guide([Tube(-4, 0, clearance), Tube(0, 4, clearance, Straight(0.017))])
    settle(rod, "rod", guide)
    rod.law = Driven(2.5)
    contact = GuideContact(rod, "rod", guide, formulation, name="guide")
    scene = Scene([rod], [contact], ThetaScheme(theta))
    probes = {
        "lateral": rod.lateral_energy,
        "pushed": lambda: np.abs(contact.force).sum(),
        "resolved": lambda: contact.resolution,
    }
    history = scene.run(0.12, 4e-4, probes=probes)
    assert history.finished, history.reason
    return history


def test_no_contact_makes_energy_at_a_kink_at_theta_one_half(damped):
    """Nothing damps the rattling, and each node is struck as it passes: all of it is loss."""
    h = over_a_kink(Velocity(), 0.5)
    assert (h["dt"] == 0).sum() > 5
    work = np.diff(h["impact"])
    # none, but of speeds at the start that the step before did not resolve
    assert work.min() < 0 and (work <= h["resolved"][:-1] * h["pushed"][1:] * h["dt"][1:]).all()
    assert abs(h["scheme"][-1]) < 1e-9 * h["lateral"].max()
    assert h["lateral"].max() == pytest.approx(damped["lateral"].max(), rel=0.05)


@pytest.mark.parametrize("kappa", [0.1, 1.0])
def test_drift_is_corrected_at_a_kink_at_theta_one_half(kappa, damped):
    """What the law works to push a node out of the wall is little, and lost again."""
    h = over_a_kink(Velocity(drift_correction=kappa), 0.5)
    work = np.diff(h["impact"])
    assert h["impact"][-1] < 0 and work.clip(0).sum() < 0.3 * np.abs(work).sum()
    assert h["lateral"].max() == pytest.approx(damped["lateral"].max(), rel=0.05)
    assert h["guide.penetration"].max() < 0.01 * demo.TUBE_CLEARANCE


def test_a_jammed_rod_says_so():
    """A kink of 43 mrad holds the rod for ever: a result with a reason."""
    drop = demo.drop(replace(KINKED, amplitude=0.025), dt=2e-3, until=0.2)
    assert not drop.history.finished
    assert "did not happen by t = 0.2 s" in drop.history.reason
    assert np.isnan(drop.time_at(demo.DASHPOT))
    # it sticks, after it has slipped by some 10 µm: a hyperstatic grip has many states of rest
    assert abs(drop.rod.travel) < 1e-4 and abs(drop.rod.speed) < 1e-9


@pytest.mark.second
def test_a_flow_pushes_the_rod_against_the_wall():
    """A lateral load of 20 N/m below the inlet: the walls bear it, whatever the rod does."""
    rod, guide = demo.rod(STRAIGHT), demo.guide(STRAIGHT)
    rod = type(rod)(
        rod.axis,
        {"rods": demo.RODS, "drive": demo.DRIVE_ROD},
        gravity=(0, -demo.G),
        law=Fall(GuideTubeWater()),
        lateral_load=lambda along: np.where(along < demo.INSIDE, 20.0, 0.0)[None],
        name="rod",
    )
    settle(rod, "rods", guide)
    contact = GuideContact(rod, "rods", guide, Velocity(0.1), 0.3, name="guide")
    scene = Scene([rod], [contact], ThetaScheme(0.6))
    history = scene.run(1.2, 1e-3, probes={"normal": contact.normal_force, "z": lambda: rod.travel})
    wet = 20.0 * (demo.INSIDE + history["z"])
    late = history.time > 0.5
    assert history["normal"][late].mean() == pytest.approx(wet[late].mean(), rel=0.02)
    assert np.abs(history["balance"]).max() < 1e-8


# -- refined ------------------------------------------------------------------------------------


@pytest.mark.long
@pytest.mark.parametrize("case", [SMOOTH, KINKED], ids=["smooth", "kinked"])
def test_convergence_at_the_full_step(case):
    """T5 within 0.03 % when dt = 1e-4 is halved, 0.1 % when the cells are, 0.05 % by gap."""
    base = demo.drop(case, dt=1e-4)
    T5 = base.time_at(demo.DASHPOT)
    assert base.history["guide.penetration"].max() < 0.05 * demo.DASHPOT_CLEARANCE
    assert demo.drop(case, dt=5e-5).time_at(demo.DASHPOT) == pytest.approx(T5, rel=3e-4)
    assert demo.drop(case, dt=1e-4, cell=0.025).time_at(demo.DASHPOT) == pytest.approx(T5, rel=1e-3)
    gap = demo.drop(case, Gap(), dt=1e-4)
    assert gap.time_at(demo.DASHPOT) == pytest.approx(T5, rel=5e-4)


@pytest.mark.parametrize(
    "case",
    [pytest.param(SMOOTH, marks=pytest.mark.second), pytest.param(KINKED, marks=pytest.mark.long)],
    ids=["smooth", "kinked"],
)
def test_convergence_of_coarse_drops(case, smooth, kinked):
    """The same at twenty times the step: half of it, and cells of half the length."""
    T5 = {SMOOTH: smooth, KINKED: kinked}[case].time_at(demo.DASHPOT)
    assert demo.drop(case, dt=COARSE / 2).time_at(demo.DASHPOT) == pytest.approx(T5, rel=3e-4)
    fine = demo.drop(case, dt=COARSE, cell=0.025)
    assert fine.time_at(demo.DASHPOT) == pytest.approx(T5, rel=1e-3)


def test_stop_when_must_be_a_function():
    rod = demo.rod(STRAIGHT)
    scene = Scene([rod], [GuideContact(rod, "rods", demo.guide(STRAIGHT))])
    with pytest.raises(InputError, match="stop_when = 3"):
        scene.run(0.1, 1e-3, stop_when=3)


def test_a_rod_passes_stations_that_it_bore_on():
    """Its upper end leaves a card while it bears there: the card then meets nothing."""
    drop = demo.drop(replace(KINKED, amplitude=0.004, friction=0.0), dt=4e-3)
    assert drop.history.finished, drop.history.reason


# -- a drop in one piece --


def in_tube(lean=0.0, friction=0.0, stop=None, scheme=None, **law):
    """A rod of 1 m and 2 kg in a straight tube that leans, let go in air."""
    gravity = (9.81 * np.sin(lean), -9.81 * np.cos(lean))
    section = Section(mass=2.0, bending=10.0)

    def rod():
        axis = axis_mesh((0, -0.5), (0, 1), rod=(1.0, 10))
        return BeamSolid(axis, section, gravity=gravity, law=Fall(stop=stop, **law), name="rod")

    return RodDrop(rod, "rod", Guide([Tube(-1.0, 2.0, 1e-3)]), friction=friction, scheme=scheme)


def test_a_leaning_tube_resists_inward_and_outward_alike():
    lean, mu = 0.2, 0.3
    exact = mu * 2.0 * 9.81 * np.sin(lean)
    drop = in_tube(lean, mu)
    for way in (drop.insert(0.4, step=1e-2), drop.withdraw(0.4, step=1e-2)):
        assert way.history.finished
        travel, resistance, friction = way.resistance()
        np.testing.assert_allclose(resistance[2:], exact, rtol=1e-8)
        np.testing.assert_allclose(friction, resistance, rtol=1e-8)
    assert travel[0] > travel[-1] == pytest.approx(0.0, abs=1e-12)


def test_a_slow_way_is_in_equilibrium_all_along():
    """What it takes does not depend on the mass of what sways above the guide."""

    def resistance(mass):
        def rod():
            axis = axis_mesh((0, -0.2), (0, 1), guided=(1.0, 10), above=(4.0, 10))
            sections = {"guided": Section(1.0, 500.0), "above": Section(mass, 500.0)}
            return BeamSolid(axis, sections)

        way = RodDrop(rod, "guided", guide, "gap", 0.3).insert(0.3, step=1e-2)
        assert way.history.finished
        return np.interp(np.arange(0.05, 0.3, 0.05), *way.resistance()[:2])

    guide = Guide([Tube(-0.8, 0, 1e-3), Tube(0, 2, 1e-3, Sine(5e-3, 2.0, "kinked"))])
    np.testing.assert_allclose(resistance(1.0), resistance(100.0), rtol=3e-3)


@pytest.mark.second
def test_the_force_of_the_end_stop():
    """m g + sqrt((m g)² + k m v²); theta = 0.6 damps it by the first order of the step."""
    weight, k, way = 2.0 * 9.81, 1e5, 0.5
    exact = weight + np.sqrt(weight**2 + 2 * k * weight * way)
    met = np.sqrt(2 * way / 9.81)

    def error(dt, theta):
        drop = in_tube(stop=way, scheme=ThetaScheme(theta), stop_stiffness=k).fall(
            1.0, dt, to=np.inf
        )
        force, time = drop.stop_impact()
        assert drop.history.finished and drop.rod.speed <= 0
        assert time - met == pytest.approx(0.5 * np.pi * np.sqrt(2.0 / k), rel=0.1)
        assert drop.time_at(way) == pytest.approx(met, rel=1e-6 if theta == 0.5 else 1e-3)
        assert drop.speed_at(way) == pytest.approx(9.81 * met, rel=1e-3)
        return force / exact - 1

    assert abs(error(4e-4, 0.5)) < 2e-4
    damped = error(4e-4, 0.6), error(1e-4, 0.6)
    assert damped[0] < 0 and 3.5 < damped[0] / damped[1] < 4.5
    short = in_tube(stop=way).fall(1.0, 1e-3)
    assert short.stop_impact()[0] < 0.5 * exact and short.rod.travel >= way


@pytest.mark.parametrize("lean", [0.2, 1.0])
def test_a_stuck_rod_says_where_and_by_what(lean):
    """In a tube that leans by less than the angle of friction; one that slides says nothing."""
    drop = in_tube(np.pi / 2 - lean, 1.0).fall(0.1, 1e-2)
    weight = 2.0 * 9.81
    if np.tan(lean) > 1.0:
        assert drop.stuck() == "" and drop.rod.travel > 1e-3
        return
    assert abs(drop.rod.travel) < 1e-12 and abs(drop.rod.speed) < 1e-12
    borne = f"friction {weight * np.sin(lean):.4g} N of its weight"
    assert "'rod' is stuck at the travel" in drop.stuck() and borne in drop.stuck()


def test_a_drop_of_something_else():
    guide = Guide([Tube(-1.0, 2.0, 1e-3)])
    with pytest.raises(InputError, match="rod = 3: must be a function"):
        RodDrop(3, "rod", guide)
    with pytest.raises(InputError, match=r"rod\(\) = 3: must be a BeamSolid"):
        RodDrop(lambda: 3, "rod", guide).fall()
    with pytest.raises(InputError, match="rod: its function"):
        RodDrop(lambda a: 3, "rod", guide).fall()
    with pytest.raises(InputError, match="guide"):
        RodDrop(lambda: 3, "rod", "guide")
    with pytest.raises(InputError, match="watch = 3: must be a function"):
        in_tube().fall(watch=3)
    one = in_tube()._rod()
    again = RodDrop(lambda: one, "rod", guide)
    again.fall(0.01, 1e-3)
    with pytest.raises(InputError, match="must make a rod each time"):
        again.fall(0.01, 1e-3)
    with pytest.raises(InputError, match="guide: is 3D, as its origin is, and 'rod' 2D"):
        RodDrop(in_tube()._rod, "rod", Guide([Tube(-1.0, 2.0, 1e-3)], (0, 0, 0))).fall()


@pytest.mark.parametrize("to", [np.nan, -1.0, 0.0, "1", [1.0]])
def test_a_drop_to_nowhere_is_refused(to):
    """By NaN it "finished" elsewhere, below the rod's travel after one step."""
    with pytest.raises(InputError, match="to = "):
        in_tube().fall(0.1, 1e-2, to=to)


def test_a_drop_without_a_stop_ends_with_its_time():
    drop = in_tube(friction=Tresca(0.0), scheme=ThetaScheme(0.5)).fall(0.2, 1e-2)
    assert drop.history.finished and drop.stop_impact() == (0.0, 0.0)
    assert drop.rod.travel == pytest.approx(0.5 * 9.81 * 0.2**2)


# -- an earthquake --


def shaken(motion, friction=0.3, **law):
    """A stiff rod at one wall of a straight tube that moves, and the contact."""
    axis = axis_mesh((0, -0.5), (0, 1), rod=(1.0, 10))
    lying = {"displacement": lambda s: np.full((1, len(s)), -1e-3)}
    rod = BeamSolid(
        axis, Section(mass=2.0, bending=1e4), gravity=(0, -9.81), law=Fall(), name="rod", **lying
    )
    guide = Guide([Tube(-1.0, 2.0, 1e-3)], motion=motion)
    return rod, GuideContact(rod, "rod", guide, friction=friction, name="guide")


@pytest.mark.parametrize("a", [5.0, 20.0])
def test_a_guide_that_accelerates_holds_the_rod_back(a):
    """It bears m a, so the rod falls with g - mu a."""
    rod, contact = shaken(lambda t: (0.5 * a * t**2, 0.0))
    probes = {"travel": lambda: rod.travel, "normal": contact.normal_force}
    history = Scene([rod], [contact], ThetaScheme(0.5)).run(0.3, 1e-3, probes=probes)
    t = history.time
    assert history.finished
    np.testing.assert_allclose(history["travel"], 0.5 * (9.81 - 0.3 * a) * t**2, atol=1e-6)
    # a velocity is a difference of places over a thousandth of a step: drift, a tenth a step less
    normal = history["normal"][history["dt"] > 0][1:]
    np.testing.assert_allclose(normal, 2.0 * a, rtol=1e-4)
    np.testing.assert_allclose(normal[-100:], 2.0 * a, rtol=1e-6)
    place = rod.fields()["displacement"][:, 0]
    np.testing.assert_allclose(place, 0.5 * a * t[-1] ** 2 - 1e-3, atol=1e-6)
    assert np.abs(history["balance"]).max() < 1e-8 * history["kinetic"].max()


def test_an_earthquake_is_resumed_to_the_bit(tmp_path):
    def scene():
        rod, contact = shaken(lambda t: (2e-3 * np.sin(40 * t), 0.0))
        return Scene([rod], [contact], ThetaScheme(0.6))

    whole = scene().run(0.2, 1e-3)
    assert whole.finished and whole["guide.bearing"].max() > 0
    scene().run(0.1, 1e-3, directory=tmp_path)
    rest = scene().run(0.2, 1e-3, directory=tmp_path, resume=True)
    np.testing.assert_array_equal(rest.rows()[-1], whole.rows()[-1])


@pytest.mark.parametrize("angle", [20.0, 30.0, 45.0, 60.0])
def test_a_guide_that_moves_across_stays_as_deep(angle):
    """Next to the ends of its tubes, too, however it is turned and wherever it stands."""
    c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    down, across = np.array([s, -c]), np.array([c, s])

    def motion(t):
        return 5e-4 * np.sin(30 * t) * across

    tubes = [Tube(-1.5, 0.0, 1e-3), Tube(0.5, 3.0, 1e-3)]
    for origin in (np.zeros(2), np.full(2, 3.3)):
        guide = Guide(tubes, origin, down, across, motion)
        points = origin + np.outer([-1.5, 0.0, 0.5, 3.0], down)
        still = guide.distance(points).copy()
        for time in np.arange(0.0, 0.2, 2e-3):
            moved = guide.distance(points, time) + np.abs(motion(time) @ across)
            inside = still < guide.far
            np.testing.assert_allclose(moved[inside], still[inside], atol=1e-12)
            assert (guide.distance(points, time) == guide.far)[~inside].all()


def test_motions_of_a_guide_that_make_no_sense():
    for motion, told in {
        3: "must be a function",
        lambda t: (1.0, 0.0): "must be zero at time 0",
        lambda t: (0.0,): "2 ",
        lambda t: (np.nan, 0.0): "nan",
    }.items():
        with pytest.raises(InputError, match=told):
            Guide([Tube(-1.0, 2.0, 1e-3)], motion=motion)
    rod, contact = shaken(lambda t: (0.0, t))
    history = Scene([rod], [contact]).run(0.1, 1e-3)
    assert not history.finished and "across the guide" in history.reason


@pytest.mark.parametrize(
    ("forces", "told"),
    [
        (None, "law.forces(0, ...) = None: must be AxialForces"),
        (3.0, "= 3.0: must be AxialForces"),
        ([("a", 1.0)], "must be AxialForces"),
        ([AxialForce("a", np.nan)], "force 'a'(0)"),
        ([AxialForce("a", "x")], "must be 3 finite numbers"),
        ([AxialForce("a", 1.0, at="nowhere")], "acts at 'nowhere'"),
    ],
)
def test_forces_of_an_own_law_that_are_none(forces, told):
    class Own(Fall):
        def forces(self, travel, speed, mass, gravity, dt):
            return forces

    axis = axis_mesh((0, -0.2), (0, 1), rod=(4.0, 2))
    with pytest.raises(InputError, match=re.escape(told)):
        BeamSolid(axis, Section(mass=2.0, bending=850.0), gravity=(0, -9.81), law=Own(), name="r")


def test_a_drive_that_gives_no_number_stops_the_run():
    """A row of NaN was accepted, and the rod then "left its guide"."""

    class Lost(Fall):
        def forces(self, travel, speed, mass, gravity, dt):
            return [AxialForce("lost", 0.0 if travel < 0.02 else np.nan)]

    axis = axis_mesh((0, -0.2), (0, 1), rod=(4.0, 20))
    section = Section(mass=2.0, bending=850.0)
    rod = BeamSolid(axis, section, gravity=(0, -9.81), law=Lost(), name="rod")
    guide = Guide([Tube(-6.0, 6.0, 8e-4)])
    scene = Scene([rod], [GuideContact(rod, "rod", guide, name="g")])
    history = scene.run(0.2, 5e-3)
    assert not history.finished and "force 'lost'" in history.reason
    assert "3 finite numbers" in history.reason and np.isfinite(history.rows()).all()


@pytest.mark.parametrize("drag", [lambda z: 3.0, lambda z: (1.0, "x"), lambda z: 1 / 0])
def test_water_whose_drag_is_no_pair_is_refused_at_once(drag):
    """A rod's own function was blamed, in the run."""
    water = SimpleNamespace(buoyancy=0.0, added_mass=lambda z: 0.0, drag=drag)
    with pytest.raises(InputError, match=r"water\.drag\(0\)"):
        Fall(water=water)
