# SPDX-License-Identifier: LGPL-3.0-or-later
"""Derivatives of drops in guides: against formulas and central differences, adjoints against
tangents, and what is refused."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pytest
from test_demos import load
from test_gradients import check

from fenicsx_contact import (
    BeamSolid,
    Contact,
    Discrete,
    Driven,
    Fall,
    GuideTubeWater,
    HalfSpace,
    InputError,
    Scene,
    Section,
    ThetaScheme,
    Tresca,
    Velocity,
    axis_mesh,
)
from fenicsx_contact.gradients import (
    Bend,
    DriveLaw,
    Gravity,
    Instant,
    Kinetic,
    Law,
    Mass,
    NoDerivative,
    ObstacleShift,
    Start,
    Stiffness,
    Strain,
    Travel,
    Widening,
    adjoints,
    passing,
    tangents,
)
from fenicsx_contact.gradients.duals import value_of, variables
from fenicsx_contact.output.crossing import crossing
from fenicsx_contact.rods import AnyCurve, Card, Guide, GuideContact, RodInTube, Sine, Tube
from fenicsx_contact.rods.drive import AxialForce
from fenicsx_contact.rods.drop import time_at
from fenicsx_contact.rods.sections import Support
from fenicsx_contact.rods.settle import settle

G = 9.81
WAVE = 1.2  # m
WATER = GuideTubeWater(0.5, 1.5, 2.0, 5.0, -0.5, 5.0, 50.0, 0.6, 0.2)


def beam(cells=12, gravity=(0, -G), law=None, length=1.2, **others):
    axis = axis_mesh((0, -0.1), (0, 1), rods=(length, cells))
    sections = others.pop("sections", Section(mass=3.0, bending=40.0))
    return BeamSolid(axis, sections, gravity=gravity, law=law, name="rod", **others)


def drop(
    mu=0.3,
    amplitude=5e-3,
    aside=0.0,
    inlet="tangent",
    theta=0.6,
    formulation=None,
    stiffness=1.0,
    wider=0.0,
    drag=WATER.before,
    added=WATER.mass,
    buoyancy=WATER.buoyancy,
    mass=4.6,
    height=0.0,
    line=0.0,
    **scene,
):
    """A short rod that falls in water through two cards into an S with a dashpot."""
    water = replace(WATER, before=drag, mass=added, buoyancy=buoyancy)
    rod = beam(
        law=Fall(water, drive_friction=line),
        sections=Section(mass=3.0 * mass / 4.6, bending=40.0 * stiffness),
        masses=[(1.2, mass / 4.6)],
        displacement=lambda s: aside + 0 * s[None],
    )
    state = rod.state()
    state["displacement"] = state["displacement"] + np.append(
        np.zeros(rod.unknowns.bending), height
    )
    rod.restore(state)
    clear = (np.array([0.5, 0.8, 0.4]) * 1e-3 + wider).tolist()
    narrow = [(0, clear[1]), (1.0, clear[1]), (1.1, clear[2]), (2.0, clear[2])]
    bent = Tube(0.0, 2.0, narrow, Sine(amplitude, WAVE, inlet))
    corridor = Guide([Card(-0.6, clear[0]), Card(-0.3, clear[0]), bent])
    law = () if formulation is None else (formulation,)
    contact = GuideContact(rod, "rods", corridor, *law, friction=mu, name="g")
    return Scene([rod], [contact], ThetaScheme(theta), **scene)


def of_rod(scene):
    (rod,) = scene.solids
    return {
        "z": Travel(rod),
        "v": Travel(rod, "velocity"),
        "kinetic energy": Kinetic(rod),
        "strain energy": Strain(rod),
    }


def grows(history):
    """Steps in which a point bears only because others do: its candidates were added."""
    return (history["geometry"] > 1).sum()


def bow(scene, inlet="tangent"):
    return Bend(scene.contacts[0], Sine(1.0, WAVE, inlet), (0.0, np.inf))


def evenly(s):
    return np.ones((1, len(s)))


#: What is not in the contact: the rod, its water, its guide's width, where it starts.
OTHERS = {
    "stiffness": (1.0, lambda s: Stiffness(s.solids[0])),
    "wider": (1e-4, lambda s: Widening(s.contacts[0])),
    "drag": (WATER.before, lambda s: DriveLaw(s.solids[0], "water.before")),
    "added": (WATER.mass, lambda s: DriveLaw(s.solids[0], "water.mass")),
    "line": (1.0, lambda s: DriveLaw(s.solids[0], "drive_friction")),
    "buoyancy": (WATER.buoyancy, lambda s: DriveLaw(s.solids[0], "water.buoyancy")),
    "mass": (4.6, lambda s: Mass(s.solids[0])),
    "height": (1e-2, lambda s: Start(s.solids[0], place=(0, 1))),
}
PARAMETERS = {
    "mu": (0.3, lambda s: Law(s.contacts[0])),
    "amplitude": (5e-3, bow),
    "aside": (1e-5, lambda s: Start(s.solids[0], place=evenly)),
}


# -- formulas --


def test_a_rod_that_slides_down_a_wall():
    """Gravity presses it on the wall all along, a = g - mu g_x: the instant of a depth is
    T = sqrt(2 z/a), and the steps and the parabola between them are exact."""
    mu, aside, depth, clearance = 0.4, 2.0, 0.3, 1e-3
    rod = beam(gravity=(aside, -G), displacement=lambda s: clearance + 0 * s[None], law=Fall())
    contact = GuideContact(rod, "rods", Guide([Tube(-1.5, 1.0, clearance)]), friction=mu, name="g")
    asked = {
        "mu": Law(contact),
        "down": Gravity(rod, (0, -1)),
        "aside": Gravity(rod, (1, 0)),
        "mass": Mass(rod),
        "speed": Start(rod, velocity=(0, -1)),
    }
    run = tangents(Scene([rod], [contact]), 0.4, 1e-2, asked, of_rod(Scene([rod], [contact])))
    assert run.history["g.bearing"][1:].min() >= 12
    a, t = G - mu * aside, run.history.time[-1]
    by = np.array([-aside, 1, -mu, 0])  # of a
    np.testing.assert_allclose(run["v"][-1], [*by * t, 1], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(run["z"][-1], [*by * t**2 / 2, t], rtol=1e-9, atol=1e-9)
    force = [0, 0, -rod.mass, -aside, 0]
    np.testing.assert_allclose(run["g.force_x"][-1], force, rtol=1e-9, atol=1e-9)
    time, gradient = passing(run, "z", "v", depth)
    assert time == pytest.approx(np.sqrt(2 * depth / a), rel=1e-9)
    np.testing.assert_allclose(gradient, [*-by * time / (2 * a), -1 / a], rtol=1e-9, atol=1e-9)
    with pytest.raises(ValueError, match="does not rise"):
        passing(run, "z", "v", 10.0)


@pytest.mark.parametrize("way", [tangents, adjoints])
def test_a_rod_that_starts_on_its_wall(way):
    """A guide that is wider does not hold it at first, a narrower one does as before; what it
    touches before a step has decided anything bears nothing. The wall opposite says nothing."""

    def lying(side):
        lies = {"gravity": (1, -G), "displacement": lambda s: side * 1e-3 + 0 * s[None]}
        rod = beam(law=Fall(), **lies)
        contact = GuideContact(rod, "rods", Guide([Tube(-2.0, 2.0, 1e-3)]), Velocity(), 0.3)
        assert np.abs(contact.gap).min() == 0
        return way(
            Scene([rod], [contact]), 0.05, 5e-3, {"w": Widening(contact)}, {"z": Travel(rod)}
        )

    assert {k.what for k in lying(1).kinks} == {"begins the step exactly where it touches"}
    assert not lying(-1).kinks


# -- central differences --


def test_a_drop_through_an_s():
    """By friction, the amplitude of the S, and where the rod starts."""
    asked = dict(PARAMETERS, amplitude=(8e-3, bow))
    run = check(drop, asked, 0.4, 5e-3, of_rod, shares=(2e-5,))
    assert run.history["g.bearing"].max() >= 3 and (run.history["dt"] == 0).sum() > 2
    assert grows(run.history) > 1
    # the run itself is the same to the bit
    scene = drop(amplitude=8e-3, aside=1e-5)
    probes = {name: quantity.value for name, quantity in of_rod(scene).items()}
    plain = scene.run(0.4, 5e-3, probes=probes)
    for column in plain.columns:
        np.testing.assert_array_equal(plain[column], run.history[column])


@pytest.mark.second
def test_a_drop_by_rod_water_and_width():
    """By stiffness, mass, water, the guide's clearances, and the height of the release."""
    run = check(drop, dict(OTHERS, amplitude=(8e-3, bow)), 0.4, 5e-3, of_rod, shares=(2e-5, 3e-6))
    assert run.history["g.bearing"].max() >= 3 and grows(run.history)
    assert (np.abs(run["z"][-1]) > 0).all()


@pytest.mark.parametrize(
    "formulation",
    [pytest.param(None, marks=pytest.mark.second), pytest.param("gap", marks=pytest.mark.long)],
)
def test_the_instant_of_a_passing_from_one_adjoint(formulation):
    """Against the tangents of the same run, and against central differences of the instant."""
    values = {name: value for name, (value, _) in {**PARAMETERS, **OTHERS}.items()}
    values["amplitude"], until, dt, levels = 8e-3, 0.4, 5e-3, (0.2, 0.35)

    def asked(scene):
        return {name: of(scene) for name, (_, of) in {**PARAMETERS, **OTHERS}.items()}

    scene = drop(formulation=formulation, **values)
    run = tangents(scene, until, dt, asked(scene), of_rod(scene))
    scene = drop(formulation=formulation, **values)
    instants = {f"t{level}": Instant("z", "v", level) for level in levels}
    kept = {} if formulation is None else {"every": 7, "room": 0}  # or run once more
    back = adjoints(scene, until, dt, asked(scene), of_rod(scene), functionals=instants, **kept)
    np.testing.assert_array_equal(back.history["z"], run.history["z"])
    for name in of_rod(scene):
        np.testing.assert_allclose(back[name], run[name][-1], rtol=1e-8)
    for level in levels:
        time, gradient = passing(run, "z", "v", level)
        assert back.values[f"t{level}"] == pytest.approx(time, rel=1e-14)  # parts of a run
        np.testing.assert_allclose(back[f"t{level}"], gradient, rtol=1e-8)

    def late(**changed):
        scene = drop(formulation=formulation, **{**values, **changed})
        probes = {name: quantity.value for name, quantity in of_rod(scene).items()}
        history = scene.run(until, dt, probes=probes)
        return np.array([instant(history)[0] for instant in instants.values()])

    slopes = np.array([back[name] for name in instants]) * list(values.values())
    for i, (name, value) in enumerate(values.items()):
        h = 2e-5 * value
        found = (late(**{name: value + h}) - late(**{name: value - h})) / (2 * h) * value
        np.testing.assert_allclose(found, slopes[:, i], atol=1e-6 * np.abs(slopes).max(), rtol=0)


@pytest.mark.long
@pytest.mark.parametrize(
    "how",
    [
        {"theta": 0.5},
        {"geometry": "newton"},
        {"formulation": "gap"},
        {"inlet": "kinked", "amplitude": 1e-3},
    ],
    ids=lambda how: next(iter(how)),
)
def test_drops_of_other_kinds(how):
    how = dict(how)
    amplitude = how.pop("amplitude", 5e-3)
    inlet = how.get("inlet", "tangent")
    asked = dict(PARAMETERS, amplitude=(amplitude, lambda s: bow(s, inlet)))
    check(
        lambda **given: drop(**given, **how), asked, 0.35, 2.5e-3, of_rod, shares=(3e-6, 2e-5, 1e-4)
    )


class Falls:
    """Friction that falls with the slip, of a user's own."""

    def __init__(self, mu, speed):
        self.mu, self.speed = mu, speed

    reads_areas = False

    def bound(self, k, pressure, S):
        return k.field("mu", self.mu) * pressure / (1 + k.slip_speed / k.field("v", self.speed))

    def describe(self):
        return "falls"


@pytest.mark.parametrize("theta", [0.6, 1.0])
def test_a_drop_under_a_law_of_ones_own(theta):
    by = {
        name: (value, lambda s, name=name: Law(s.contacts[0], name))
        for name, value in {"mu": 0.3, "v": 2.0}.items()
    }
    check(lambda mu, v: drop(Falls(mu, v), theta=theta), by, 0.5, 1e-2, of_rod)


def test_a_drop_between_springs():
    """Without friction: what rubs on them stretches springs that the rod slides past."""
    by = {"k": (2e3, lambda s: Law(s.contacts[0], "stiffness"))}
    build = partial(drop, 0.0, geometry="newton")
    check(lambda k: build(formulation=Discrete(k)), by, 0.5, 1e-2, of_rod)
    scene = drop(0.3, formulation=Discrete(1e5))
    with pytest.raises(InputError, match="remembers 'stretch', past which the rod slides"):
        tangents(scene, 0.01, 5e-3, {"mu": Law(scene.contacts[0])}, of_rod(scene))


def test_adjoints_are_tangents_transposed():
    scene, again = drop(amplitude=8.5e-3), drop(amplitude=8.5e-3)
    forwards = tangents(scene, 0.3, 5e-3, {n: of(scene) for n, (_, of) in PARAMETERS.items()},
                        of_rod(scene))  # fmt: skip
    back = adjoints(again, 0.3, 5e-3, {n: of(again) for n, (_, of) in PARAMETERS.items()},
                    of_rod(again))  # fmt: skip
    assert grows(forwards.history) > 0
    for name in of_rod(scene):
        assert back.values[name] == forwards.history[name][-1]
        np.testing.assert_allclose(back[name], forwards[name][-1], rtol=1e-9)


@pytest.mark.long
def test_the_time_of_a_rod_drop():
    """T5 of the demo, smooth and kinked, by friction, against central differences; on the kinked S
    T5 jumps, and the differences must be shorter than the way to the next jump."""
    demo = load("rod_drop")
    for kinked, h, geometry in ((False, 1e-5, "newton"), (True, 1e-7, "fixed point")):

        def start(friction, kinked=kinked, geometry=geometry):
            a = demo.Assumed(friction=friction, kinked=kinked)
            rod, corridor = demo.rod(a), demo.guide(a)
            settle(rod, "rods", corridor)
            contact = GuideContact(rod, "rods", corridor, demo.VELOCITY, friction, name="guide")
            return rod, contact, Scene([rod], [contact], demo.SCHEME, geometry=geometry)

        def time(friction, start=start):
            rod, _, scene = start(friction)
            probes = {"travel": lambda: rod.travel, "speed": lambda: rod.speed}
            history = scene.run(
                1.6, 1e-3, probes=probes, stop_when=lambda: rod.travel >= demo.DASHPOT
            )
            return time_at(history, demo.DASHPOT)

        rod, contact, scene = start(0.3)
        quantities = {"z": Travel(rod), "v": Travel(rod, "velocity")}
        run = tangents(scene, 1.6, 1e-3, {"mu": Law(contact)}, quantities,
                       stop_when=lambda rod=rod: rod.travel >= demo.DASHPOT)  # fmt: skip
        found, (by_friction,) = passing(run, "z", "v", demo.DASHPOT)
        assert found == time(0.3)
        assert (time(0.3 + h) - time(0.3 - h)) / (2 * h) == pytest.approx(by_friction, rel=1e-6)


# -- laws, and what is refused --


def test_a_law_is_differentiated_as_it_stands():
    """Force, rates and added mass of water and stop, against central differences."""
    law = Fall(WATER, drive_friction=2.0, stop=0.7)

    def numbers(*given):
        forces = law.forces(*given, 1e-3)
        rates = [r for f in forces for r in (f.value, f.by_speed, f.by_travel)]
        return [*rates, law.added_mass(given[0])]

    for travel in (0.3, 0.65, 0.75):
        at = travel, 1.3, 4.0, G
        found = numbers(*variables(*at))
        slopes = np.array([getattr(each, "slopes", np.zeros(4)) for each in found])
        assert [value_of(each) for each in found] == numbers(*at)
        for i, h in enumerate([1e-6] * 4):
            high, low = (np.array(numbers(*at[:i], at[i] + s * h, *at[i + 1 :])) for s in (1, -1))
            np.testing.assert_allclose(slopes[:, i], (high - low) / (2 * h), rtol=1e-6, atol=1e-4)


@pytest.mark.parametrize("way", [tangents, adjoints])
def test_a_drive_friction_of_zero_has_a_derivative(way):
    """z = (g - F/M) t²/2, at F = 0 as beyond."""
    for friction in (0.0, 1.0):
        rod = beam(law=Fall(drive_friction=friction))
        by = {"F": DriveLaw(rod, "drive_friction")}
        scene = Scene([rod], [], ThetaScheme(0.5), allow_free=True)
        run = way(scene, 0.5, 1e-2, by, {"z": Travel(rod)})
        assert run["z"].ravel()[-1] == pytest.approx(-(0.5**2) / (2 * rod.mass), rel=1e-12)


def bounce(stop=0.4, stiffness=2e3, line=1.0, mass=4.6, height=1e-2, mu=0.2, theta=0.5):
    """A rod that slides down its wall, in water, on its stop, and back."""
    law = Fall(WATER, line, stop, stiffness)
    sections = Section(mass=3.0 * mass / 4.6, bending=40.0)
    lies = {"gravity": (2.0, -G), "displacement": lambda s: 1e-3 + 0 * s[None]}
    rod = beam(law=law, sections=sections, masses=[(1.2, mass / 4.6)], **lies)
    state = rod.state()
    state["displacement"] = state["displacement"] + np.append(
        np.zeros(rod.unknowns.bending), height
    )
    rod.restore(state)
    contact = GuideContact(rod, "rods", Guide([Tube(-3.0, 3.0, 1e-3)]), friction=mu, name="g")
    return Scene([rod], [contact], ThetaScheme(theta))


@pytest.mark.parametrize("theta", [0.5, 0.6, 1.0])
def test_a_bounce_on_a_stop(theta):
    """By where the stop is, its stiffness, and what brings the rod to it; an adjoint agrees."""
    asked = {
        "stop": (0.4, lambda s: DriveLaw(s.solids[0], "stop")),
        "stiffness": (2e3, lambda s: DriveLaw(s.solids[0], "stop_stiffness")),
        "line": (1.0, OTHERS["line"][1]),
        "mass": (4.6, OTHERS["mass"][1]),
        "height": (1e-2, OTHERS["height"][1]),
        "mu": (0.2, lambda s: Law(s.contacts[0])),
    }

    build = partial(bounce, theta=theta)

    def quantities(scene):
        return {name: q for name, q in of_rod(scene).items() if name != "strain energy"}  # of none

    run = check(build, asked, 0.6, 1e-2, quantities)
    assert run.history["v"][-1] < -0.3 and run.history["z"].max() > 0.45
    scene = build()
    by = {name: of(scene) for name, (_, of) in asked.items()}
    back = adjoints(scene, 0.6, 1e-2, by, quantities(scene))
    for name in quantities(scene):
        np.testing.assert_allclose(back.one_sided(name), run[name][-1], rtol=1e-8, atol=1e-12)


def test_a_stop_that_just_touches_has_a_derivative():
    """The step is smooth in where the stop is, and no kink is told."""

    def late(stop):
        rod = beam(law=Fall(stop=stop, stop_stiffness=2e3))
        return Scene([rod], [], ThetaScheme(0.6), allow_free=True), rod

    scene, rod = late(0.0)
    run = tangents(scene, 0.05, 5e-3, {"s": DriveLaw(rod, "stop")}, {"z": Travel(rod)})
    ends = []
    for stop in (-1e-6, 1e-6):
        scene, rod = late(stop)
        assert scene.run(0.05, 5e-3).finished
        ends.append(rod.travel)
    assert run["z"][-1, 0] == pytest.approx((ends[1] - ends[0]) / 2e-6, rel=1e-3)


@pytest.mark.parametrize("theta", [0.6, 1.0])
def test_the_instant_of_a_passing_is_continuous_from_step_to_step(theta):
    """A fall from rest by a theta-scheme: z = g t (t + (2 theta - 1) dt)/2 at its rows, between
    which the instant is that of this parabola, with its derivative."""
    dt = 1e-2
    late = (theta - 0.5) * dt

    def exact(z):
        return np.sqrt(late**2 + 2 * z / G) - late

    rod = beam(law=Fall())
    asked = {"g": Gravity(rod, (0, -1))}
    scene = Scene([rod], [], ThetaScheme(theta), allow_free=True)
    run = tangents(scene, 0.1, dt, asked, {"travel": Travel(rod), "speed": Travel(rod, "velocity")})
    rows = run.history["travel"][1:-1]
    for z in (*(rows - 1e-10), *rows, *(rows + 1e-10), *(1.1 * rows), 1e-6):
        time, (by_gravity,) = passing(run, "travel", "speed", z)
        assert time == pytest.approx(exact(z), rel=1e-7)
        assert time_at(run.history, z) == pytest.approx(time, rel=1e-8)
        assert by_gravity == pytest.approx(-z / (G**2 * (exact(z) + late)), rel=1e-6)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_passing_after_a_turn_within_the_step(sign):
    """z = 3/4 r² - r, or its mirror image: terms that cancel for levels near the start."""
    for level in (1e-20, 1e-12, 0.5):
        at = crossing(2.0, (0.0, sign * 1.0), (sign * -1.0, sign * 2.0), sign * level)
        assert at.after == pytest.approx((1 + np.sqrt(1 + 3 * level)) / 1.5, rel=1e-14)
        assert at.rate == pytest.approx(sign * np.sqrt(1 + 3 * level), rel=1e-14)


@dataclass(frozen=True)
class Catch(Fall):
    """Somebody else's: beyond a travel it holds with a force that rises as a power."""

    caught: float = 0.0
    power: float = 1.0

    def forces(self, travel, speed, mass, gravity, dt):
        beyond = max(0.0, travel - self.caught)
        rate = self.power * beyond ** (self.power - 1) if self.power > 1 else travel > self.caught
        return [AxialForce("catch", -1e3 * beyond**self.power, 0.0, -1e3 * rate)]


@pytest.mark.parametrize("way", [tangents, adjoints])
def test_a_law_on_the_edge_of_two_branches_is_told(way):
    """Where its slopes, or those of its rates, differ, and along the parameter only."""

    def asked(of, **law):
        rod = beam(law=Catch(**law))
        scene = Scene([rod], [], ThetaScheme(1.0, forces="end"), allow_free=True)
        return way(scene, 5e-3, 5e-3, {"p": of(rod)}, {"z": Travel(rod)})

    run = asked(lambda rod: DriveLaw(rod, "caught"), caught=0.0)
    assert "solid 'rod', t = 0.005 s: the law of its drive" in str(run.kinks[0])
    with pytest.raises(NoDerivative, match="another branch"):
        run["z"]
    assert not asked(lambda rod: DriveLaw(rod, "caught"), caught=0.0, power=3.0).kinks
    assert not asked(Mass, caught=0.0).kinks
    assert not asked(lambda rod: DriveLaw(rod, "caught"), caught=-1e-9).kinks


class Thick(GuideTubeWater):
    """Its drag is not written in plain arithmetic."""

    def drag(self, travel):
        return float(np.exp(travel)), float(np.exp(travel))


def refused(rod, contact=None, words="", parameter=None, **scene):
    contacts = [contact] if contact else []
    scene = Scene([rod], contacts, ThetaScheme(0.6), **scene)
    by = parameter or Mass(rod.rod)
    with pytest.raises(InputError, match=words):
        tangents(scene, 0.02, 0.01, {"p": by}, {})


def test_what_is_refused_in_guides():
    corridor = Guide([Tube(-2.0, 2.0, 1e-3)])

    def inside(rod, **others):
        return GuideContact(rod, "rods", corridor, name="g", **others)

    rod = beam(law=Driven(0.1))
    refused(rod, inside(rod), "prescribed")
    rod = beam(law=Fall(Thick(0.0, 0.0)))
    refused(rod, inside(rod), "not differentiated")
    rod = beam(sections=Section(mass=3.0, bending=40.0, axial=1e6))
    refused(rod, inside(rod), "stretches")
    rod = beam(lateral_load=lambda s: 0 * s[None])
    refused(rod, inside(rod), "lateral_load")
    rod = beam(sections=Section(mass=3.0, bending=40.0, recess=lambda s: 1e-5 * s))
    refused(rod, inside(rod), "sections of solid 'rod' have a recess")
    rod = beam()
    refused(rod, Contact(rod, "rods", HalfSpace((1, 0), (-1, 0)), name="c"), "one of a beam")
    rod = beam()
    contact = inside(rod)
    refused(rod, contact, "see Bend", ObstacleShift(contact, (1, 0)))
    rod = beam()
    refused(rod, inside(rod, friction=Tresca(1.0)), "law of areas")
    rod = beam()
    refused(rod, inside(rod), "located impacts", locate_impacts=True)
    rod = beam()
    bent = Tube(-2.0, 2.0, 1e-3, AnyCurve(lambda x: 0 * x, lambda x: 0 * x))
    refused(rod, GuideContact(rod, "rods", Guide([bent]), name="g"), "second = None")
    with pytest.raises(InputError, match="GuideContact"):
        Bend(Contact(rod, "rods", HalfSpace((1, 0), (-1, 0))), Sine(1.0, 1.0))
    with pytest.raises(InputError, match="must be that of a number"):
        DriveLaw(beam(law=Fall(WATER)), "water.temperature")
    with pytest.raises(InputError, match="springs or tension"):
        Stiffness(beam(sections=Section(mass=3.0, bending=40.0, tension=5.0)))
    rod = beam()
    with pytest.raises(InputError, match="no quantity"):
        adjoints(
            Scene([rod], [inside(rod)], ThetaScheme(0.6)), 0.02, 0.01, {"m": Mass(rod)}, {},
            functionals={"t": lambda history: (0.0, {"z": np.zeros(len(history))})},
        )  # fmt: skip
    with pytest.raises(InputError, match="no turn"):
        Start(rod, turn=1.0)
    across = axis_mesh((0, 0, 0), (0, 0, 1), rods=(1.0, 4))
    refused(BeamSolid(across, Section(mass=1.0, bending=1.0)), None, "in space", allow_free=True)
    rod = beam()
    held = Support(0.0, lateral=np.inf, axial=np.inf)
    pair = RodInTube(beam(), beam(supports=[held]))
    contact = GuideContact(pair, "rods", corridor, friction=0.1)
    refused(pair, contact, "RodInTube", Law(contact))
    rod = beam()
    scene = Scene([rod], [inside(rod), GuideContact(rod, "rods", corridor, name="h")])
    with pytest.raises(InputError, match="one contact"):
        tangents(scene, 0.02, 0.01, {"m": Mass(rod)}, {})


@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_a_rod_in_a_bent_guide_meets_its_stop(mu):
    """It does so within a step, which is then linearised twice: the second time about other
    normals, of which derivatives knew nothing (7 % off, without a kink)."""
    asked = {"stop": 0.4, "line": 0.2}

    def scene(stop, line):
        rod = BeamSolid(
            axis_mesh((0, -0.1), (0, 1), rods=(1.2, 10)),
            Section(mass=4.0, bending=40.0),
            gravity=(0, -9.81),
            law=Fall(drive_friction=line, stop=stop),
            name="rod",
        )
        guide = Guide([Tube(0.0, 2.0, 0.8e-3, Sine(8e-3, 1.2, "tangent"))])
        contact = GuideContact(rod, "rods", guide, "velocity", friction=mu, name="g")
        return Scene([rod], [contact], ThetaScheme(0.5)), rod

    def of(rod):
        return {"z": Travel(rod), "v": Travel(rod, "velocity"), "bent": Strain(rod)}

    def ends(**changed):
        moved, rod = scene(**{**asked, **changed})
        assert moved.run(0.32, 5e-3).finished
        return np.array([each.value() for each in of(rod).values()])

    first, rod = scene(**asked)
    by = {"stop": DriveLaw(rod, "stop"), "line": DriveLaw(rod, "drive_friction")}
    found = tangents(first, 0.32, 5e-3, by, of(rod))
    assert not found.kinks
    for i, (name, value) in enumerate(asked.items()):
        h = 1e-5 * value
        known = (ends(**{name: value + h}) - ends(**{name: value - h})) / (2 * h)
        for quantity, exact in zip(of(rod), known):
            assert found[quantity][-1, i] == pytest.approx(exact, rel=2e-5), (name, quantity)
