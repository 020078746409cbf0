# SPDX-License-Identifier: LGPL-3.0-or-later
"""What would pass through another body within a step is caught, whatever its speed."""

from __future__ import annotations

import numpy as np
import pytest
from corpus_meshes import moved
from problems import stacked
from scenes import G, rectangle

from fenicsx_contact import (
    Box,
    Circle,
    Contact,
    Discrete,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    LevelSet,
    Moved,
    QuasiStatic,
    Restitution,
    RigidSolid,
    Scene,
    ThetaScheme,
    st_venant_kirchhoff,
)
from fenicsx_contact.contact.candidates import Candidates
from fenicsx_contact.contact.trial import candidate_force, violation
from fenicsx_contact.theory.scheme import Step

SIDE, DT, STEPS = 0.2, 1e-3, 4
LAWS = ["velocity", "gap", "printed", "lagrange", Discrete(stiffness=1e13)]
OBSTACLES = {
    "plane": HalfSpace((0, 0), (0, 1)),
    "disc": Circle((0, -0.05), 0.05),
    "level set": LevelSet(lambda x, t: x[0] ** 2 + (x[1] + 0.05) ** 2 - 0.05**2, dim=2),
    "wheel": Moved(Circle((0, -0.05), 0.05), lambda t: (0.0, 100.0 * t)),
}


def thrown(kind: str, speed: float, slant: float = 0.0, height: float = 0.01):
    """A block that would meet the origin with the middle of its base."""
    mesh, velocity = rectangle((2, 2), (SIDE, SIDE)), speed * np.array([slant, -1.0])
    place = height * np.array([-slant, 1.0])
    if kind == "rigid":
        block = RigidSolid(mesh, mass=40.0, velocity=velocity)
        block.restore({**block.state(), "place": block.place + place})
        return block
    return ElasticSolid(
        mesh,
        youngs_modulus=1e9,
        poisson_ratio=0.3,
        density=1000.0,
        displacement=lambda x: np.outer(place, np.ones(x.shape[1])),
        velocity=lambda x: np.outer(velocity, np.ones(x.shape[1])),
        name="block",
    )


def check(history):
    """It is struck, or the run stops with a reason; nothing is passed in silence."""
    assert history["c.bearing"].max() > 0 or not history.finished, history
    assert history["c.penetration"].max() <= SIDE


@pytest.mark.parametrize("located", [False, True], ids=["uniform", "located"])
@pytest.mark.parametrize("law", LAWS, ids=lambda law: getattr(law, "name", law))
@pytest.mark.parametrize("kind", ["rigid", "elastic"])
@pytest.mark.parametrize("obstacle", OBSTACLES)
def test_nothing_passes_through_an_obstacle(obstacle, kind, law, located):
    if located and law != "velocity":
        pytest.skip("only the velocity law locates impacts")
    block = thrown(kind, 1e4)
    contact = Contact(block, "base", OBSTACLES[obstacle], law, name="c")
    check(Scene([block], [contact], locate_impacts=located).run(STEPS * DT, DT))


def slab(width: float) -> ElasticSolid:
    """Thin, its top at y = 0, held at its ends."""
    mesh = rectangle((4, 1), (width, 0.02))
    mesh.mesh.geometry.x[:, 1] -= 0.02
    return ElasticSolid(
        mesh,
        youngs_modulus=1e9,
        poisson_ratio=0.3,
        density=8000.0,
        fixed=["left", "right"],
        name="slab",
    )


@pytest.mark.second
@pytest.mark.parametrize("seed", range(1, 10))
def test_nothing_passes_through_a_thin_solid(seed):
    """Straight or aslant, narrower than the body or wider, by any law."""
    generator = np.random.default_rng(seed)
    kind, law = ["rigid", "elastic"][seed % 2], ["velocity", "gap", "lagrange"][seed % 3]
    speed, slant = 10 ** generator.uniform(2.5, 4), generator.uniform(-0.5, 0.5)
    block = thrown(kind, speed, slant, 10 ** generator.uniform(-3, -1))
    plate = slab(float(generator.choice([0.1, 0.4])))
    contact = Contact(block, "base", (plate, "top"), law, name="c")
    located = law == "velocity" and seed % 4 == 0
    check(Scene([block, plate], [contact], locate_impacts=located).run(STEPS * DT, DT))


@pytest.mark.parametrize("dt", [0.3, 1.0, 3.0])
@pytest.mark.parametrize("ratio", [1e2, 1e3, 1e4])
def test_what_falls_alike_without_contact_stays_together(ratio, dt):
    """Round-off alone would tell which points of two blocks on a floor are to be asked first; one
    of them would let the upper block swing round in a long step, to where it meets nothing."""
    problem = stacked(mass_ratio=ratio, dt=dt, steps=3)
    history = problem.run()
    assert history.finished and not history.remarks
    assert problem.error(history) < problem.bound
    assert history["newton"].max() <= 10


@pytest.mark.parametrize("point", range(4))
def test_what_meets_nothing_bears_nothing(point, monkeypatch):
    """The same with one point, asked once: that step is not accepted, and the next one is right.

    Asked in every step, short ones too, the block would tip round the point: a solution of a coarse
    step, wrong only by what is not asked.
    """
    narrow, asked = Candidates.narrow, []

    def first(self, bore, *others):
        narrow(self, bore, *others)
        if len(bore) == 4 and not asked:  # the seam
            asked.append(point)
            self._asked = np.arange(4) == point
            self.choose()

    monkeypatch.setattr(Candidates, "narrow", first)
    problem = stacked(mass_ratio=1e4, dt=1.0, steps=2)
    history = problem.run()
    assert asked and len(history.remarks) == 1
    assert history.remarks[0][1].startswith("step halved to 0.5 s")
    assert history.finished and problem.error(history) < problem.bound


def test_forces_where_nothing_is_faced_are_no_solution(monkeypatch):
    """The certificate counts as an error what a point bears that has no partner."""
    lower = RigidSolid(rectangle(size=(0.4, 0.2)), mass=1.0, gravity=(0, -9.81), name="lower")
    mesh = rectangle(size=(0.2, 0.2))
    mesh.mesh.geometry.x[:, 1] += 0.2
    upper = RigidSolid(mesh, mass=1.0, gravity=(0, -9.81), name="upper")
    seam = Contact(upper, "base", (lower, "top"), name="seam")
    scene = Scene([lower, upper], [Contact(lower, "base", OBSTACLES["plane"], name="floor"), seam])
    trial = scene.stepper.attempt(Step(0.1, scene.scheme))
    force = candidate_force(seam)
    assert np.abs(force).max() > 0 and trial.certificate < 1e-10
    assert violation(seam, trial.step, force) < 1e-10
    monkeypatch.setattr(seam.coupling, "near", lambda: np.zeros(seam.surface.size, dtype=bool))
    assert violation(seam, trial.step, force) > 1e-2


@pytest.mark.parametrize("passes", [0.099, 0.101])
def test_what_passes_beside_is_not_held_up(passes):
    """A block that flies past a disc: no step is cut, but where it goes through."""
    block = thrown("rigid", 1e3)
    obstacle = Circle((passes + 0.05, -0.5), 0.05)
    contact = Contact(block, "base", obstacle, name="c")
    history = Scene([block], [contact]).run(STEPS * DT, DT)
    struck = passes < 0.5 * SIDE
    assert bool(history["c.bearing"].max()) is struck
    assert bool(history.remarks) is struck


@pytest.mark.parametrize("law", ["velocity", "gap"])
def test_what_touches_does_not_fly_through_what_it_presses_on(law):
    """A steel block that touches a slab, 10 MPa on it: in one long step it got to 12.7 m below
    it, without a force, "finished"."""
    size, steel = 0.01, {"youngs_modulus": 200e9, "poisson_ratio": 0.3, "density": 7850.0}
    upper, lower = rectangle((6, 6), (size, size)), rectangle((10, 3), (3 * size, size))
    moved(lower, 0.0, -size)
    block = ElasticSolid(upper, tractions={"top": (1e5, -1e7)}, name="block", **steel)
    slab = ElasticSolid(lower, fixed=["base"], name="slab", **steel)
    contact = Contact(block, "base", (slab, "top"), law, friction=0.5, name="c")
    scene = Scene([block, slab], [contact], ThetaScheme(1.0), solver="monolithic")
    history = scene.run(0.01, 0.01)
    assert history.finished, history.reason
    assert history["c.force_y"][-1] == pytest.approx(1e7 * size, rel=1e-6)
    assert np.abs(block.displacement).max() < 1e-6


def falls(obstacle, law, theta, lift, place=0.0, aside=0.0):
    """A block of 0.2 m, thrown down at 20 m/s, 0.1 m a step, to where it stands or turns round."""
    block = RigidSolid(rectangle((2, 1), (SIDE, SIDE)), mass=1.0, velocity=(aside, -20.0))
    block.restore({**block.state(), "place": block.place + np.array([place, lift])})
    contact = Contact(block, "base", obstacle, law, name="c")
    probes = {"base": lambda: block.place[1] - 0.5 * SIDE}
    history = Scene([block], [contact], ThetaScheme(theta)).run(0.04, 5e-3, probes=probes)
    return history, block.velocity[1]


@pytest.mark.parametrize("theta", [0.5, 1.0])
@pytest.mark.parametrize(
    "law", ["gap", "lagrange", Discrete(1e7)], ids=["gap", "lagrange", "springs"]
)
@pytest.mark.parametrize("thick", [0.1, 0.02])
@pytest.mark.parametrize("lift", [0.3, 0.337, 0.373])
def test_what_lands_with_speed_left_stays_above(lift, thick, law, theta):
    """A law of positions may end a step exactly on a plate, its speed left, or throw a point out at
    the far side: by a plate of 0.1 m it was at -0.1 m after the next step, without a remark."""
    history, speed = falls(Box((0, -thick / 2), (2.0, thick)), law, theta, lift)
    assert history.finished, history.reason
    # springs give way by v sqrt(m / k)
    assert history["base"].min() > -0.007 and speed > -1e-9


@pytest.mark.parametrize("law", ["velocity", "gap", "printed"])
@pytest.mark.parametrize("aside", [0.0, -0.1])
def test_a_post_is_struck_from_above(aside, law):
    """0.02 m wide, 1 m high: at the end of the step the nearest side was one along which a point
    slides, and it flew down within the post."""
    post = Box((0, -0.5), (0.02, 1.0))
    history, speed = falls(post, law, 0.5, 0.35, 0.002, aside)
    assert history.finished and history["base"].min() > -1e-12 and speed > -1e-9


def test_a_step_may_end_beside_the_centre_of_a_disc():
    """0.05 m below its top: there the normal was across the velocity."""
    history, speed = falls(Circle((0, -0.05), 0.05), "velocity", 0.5, 0.35)
    assert history["base"].min() == pytest.approx(0, abs=1e-12) and abs(speed) < 1e-9


def bent_strip(**solid):
    """A strip without transverse contraction, 1 m long, its base on a drum of radius 1 m."""
    mesh = rectangle((10, 1), (1.0, 0.02))
    x = mesh.mesh.geometry.x
    angle, radius = 0.5 * x[:, 0], 1 + x[:, 1]
    x[:, 0], x[:, 1] = radius * np.cos(angle), radius * np.sin(angle)
    energy = st_venant_kirchhoff(1e9, 0.0)
    return HyperelasticSolid(mesh, energy=energy, density=1000.0, name="strip", **solid)


@pytest.mark.parametrize("step", [1e-3, 3e-2])
@pytest.mark.parametrize("scheme", [QuasiStatic(), ThetaScheme(1.0)], ids=["statics", "dynamics"])
@pytest.mark.parametrize("lift, law", [(1e-9, "gap"), (1e-6, "gap"), (0.0, "velocity")])
def test_what_is_drawn_along_a_drum_goes_round_it(lift, law, scheme, step):
    """Its end turns about the axis; just above the drum the chords of its ways were said to go
    through: five steps of a mrad took 206, of 30 mrad none went."""

    def drawn(x, t):
        cos, sin = np.cos(step * t), np.sin(step * t)
        ends = (1 + lift * min(t, 1.0) / np.linalg.norm(x[:2], axis=0)) * (
            np.array([[cos, -sin], [sin, cos]]) @ x[:2]
        )
        return ends - x[:2]

    strip = bent_strip(
        prescribed={"right": drawn}, tractions={"left": (-1e3 * np.sin(0.25), -1e3 * np.cos(0.25))}
    )
    contact = Contact(strip, "base", Circle((0, 0), 1.0), law, name="c")
    history = Scene([strip], [contact], scheme).run(2.0, 1.0)
    # by theta = 1 a step of 30 mrad gives twice what moves, for which it may be halved
    told = [text for _, text in history.remarks if "certificate: contacts would" not in text]
    # a velocity law tells that it sinks, which takes more than 1 % of so little energy; after a
    # long step nothing presses
    sinks = [text for text in told if "inside its obstacle: 'velocity'" in text]
    assert len(sinks) == (law == "velocity" and step < 1e-2)
    told = [text for text in told if text not in sinks]
    assert history.finished and not told and (len(history.time) == 3 or history.remarks)
    # by a velocity law each step goes along a tangent, off by its height above the arc; of a way
    # Newton's method leaves 1e-10
    off = np.linalg.norm(contact.coupling.positions(), axis=1) - 1
    within = step**2 if law == "velocity" else max(1e-12, 1e-10 * step)
    assert -within < off.min() and off.max() < 1.1 * lift + within


@pytest.mark.parametrize("chord", [0.1, 0.4])
def test_what_grazes_a_drum_does_not_go_round_it(chord):
    """Straight through its top, with normals at both ends as of what goes round: struck."""
    speed, top = 10.0, 0.5 * chord
    body = RigidSolid(rectangle((1, 1), (0.01, 0.02)), mass=1.0, velocity=(speed, 0.0))
    corner = np.array([-top - 1e-3, np.sqrt(1 - top**2) - 1])
    body.restore({**body.state(), "place": body.place + corner - (0.005, 0.0)})
    contact = Contact(body, "base", Circle((0, -1.0), 1.0), name="c")
    dt = (chord + 2e-3) / speed
    history = Scene([body], [contact]).run(dt, dt)
    assert history.finished and history.remarks and history["c.bearing"].max() > 0


@pytest.mark.parametrize("way", [lambda t: 0.02 * np.sin(12 * t), lambda t: -G / 4 * t**2])
@pytest.mark.parametrize("shape", ["disc", "box"])
def test_bounces_on_what_accelerates_are_those_on_a_plane(shape, way):
    """Chords of hops dip into what moves on a curve, by as much of their length as they are short:
    no step was short enough."""

    def bounces(wall):
        tip = RigidSolid(
            moved(rectangle((1, 1), (1e-3, 1e-3)), 0.0, 0.01),
            mass=0.5, gravity=(0, -G), held=("x", "turning"),
        )  # fmt: skip
        contact = Contact(tip, "base", Moved(wall, lambda t: (0, way(t))), Restitution(0.5))
        history = Scene([tip], [contact], locate_impacts=True).run(0.25, 4e-3)
        assert history.finished and not [told for _, told in history.remarks if "through" in told]
        return tip.place[1], tip.velocity[1]

    walls = {"disc": Circle((0, -1.0), 1.0), "box": Box((0, -0.5), (2, 1))}
    # the corners of what is round are lower
    exact, near = (bounces(wall) for wall in (HalfSpace((0, 0), (0, 1)), walls[shape]))
    np.testing.assert_allclose(near, exact, atol=1e-5 if shape == "disc" else 1e-9)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: getattr(law, "name", law))
@pytest.mark.parametrize("theta", [0.5, 1.0])
@pytest.mark.parametrize("thick", [1e-3, 0.05])
def test_nothing_passes_through_what_accelerates(thick, theta, law):
    """A bar that is driven up against a block that turns: what is through by its chord and its
    parabola is caught, thin or thick."""
    bar = Moved(Box((0, -thick / 2), (0.5, thick)), lambda t: (0.0, 0.5e5 * t**2))
    block = thrown("rigid", 1e2)
    block.restore({**block.state(), "velocity": np.array([0.0, -1e2, 50.0])})
    contact = Contact(block, "base", bar, law, name="c")
    check(Scene([block], [contact], ThetaScheme(theta)).run(STEPS * DT, DT))
