# SPDX-License-Identifier: LGPL-3.0-or-later
"""Formulations of one's own without multipliers that act where a point is open, too: a bilateral
bed, a cohesive law, against exact solutions."""

from dataclasses import dataclass
from math import atan

import numpy as np
import pytest
import ufl
from scenes import FLOOR, rectangle

from fenicsx_contact import (
    Adhesive,
    Contact,
    Discrete,
    ElasticSolid,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
)
from fenicsx_contact.theory.formulations import only_pushes

STIFFNESS, MASS = 1e3, 10.0  # Pa/m on one square metre; kg
DT = 2e-3
#: Of the bed and the mass in continuous time, and by the mean of both ends of a step, 1/s.
OMEGA = 10.0
DISCRETE = 2 / DT * atan(OMEGA * DT / 2)


@dataclass(frozen=True)
class Bed:
    """A bed of springs that pull as they push, p = k d_n in the mean of both ends of a step."""

    pulls: float  # the status of what is pulled
    name = "bed"
    multipliers = percussive = at_points = False
    points = None
    gap_share = 1.0

    def form(self, k):
        pressure = STIFFNESS * (k.start_gap + k.gap + k.gap_rate * k.jump_n) / 2
        return k.integral(pressure * k.test_jump_n), self.status(pressure)

    def status(self, pressure):
        return ufl.conditional(ufl.gt(pressure, 0), 1.0, self.pulls)

    def limit(self, data):
        return None


@dataclass(frozen=True)
class Cohesive:
    """A bilinear cohesive law with memory: it dissipates Gc = K d0 d1/2."""

    stiffness: float = 1e7  # K, Pa/m
    start: float = 1e-3  # d0, m
    end: float = 1e-2  # d1, m
    name = "cohesive"
    multipliers = percussive = at_points = False
    points = None
    gap_share = 1.0

    def form(self, k):
        depth = k.gap + k.gap_rate * k.jump_n
        worst = k.state("worst", self.start, lambda old, time: ufl.max_value(old, -depth))
        damage = self.end * (worst - self.start) / (worst * (self.end - self.start))
        left = ufl.conditional(ufl.gt(depth, 0), 1.0, 1 - ufl.min_value(damage, 1.0))
        pressure = left * self.stiffness * depth
        bears = ufl.conditional(ufl.gt(left, 0), 1.0, 0.0)
        return k.integral(pressure * k.test_jump_n), bears

    def limit(self, data):
        return None


def block(lift, velocity=0.0):
    """A rigid block, one metre wide, so high above the floor, m."""
    solid = RigidSolid(rectangle((2, 1), (1.0, 0.1)), mass=MASS, velocity=(0, velocity))
    solid.restore({**solid.state(), "place": solid.place + np.array([0, lift])})
    return solid


@pytest.mark.parametrize("pulls", [0.0, 1.0])
@pytest.mark.parametrize("lift, velocity", [(0.05, 0.0), (0.0, 1.0), (0.0, -1.0), (-0.05, 0.0)])
def test_a_bed_that_pulls_as_it_pushes(lift, velocity, pulls):
    """Started outside, thrown off as it touches, thrown on, inside: a harmonic motion."""
    solid = block(lift, velocity)
    scene = Scene([solid], [Contact(solid, "base", FLOOR, Bed(pulls), name="c")], deepest=1.0)
    rest = solid.place[1] - lift
    probes = {"y": lambda: solid.place[1] - rest}
    history = scene.run(0.6, DT, probes=probes, progress=False)
    assert history.reason == "finished"
    angle = DISCRETE * history.time
    exact = lift * np.cos(angle) + velocity / OMEGA * np.sin(angle)
    np.testing.assert_allclose(history["y"], exact, rtol=0, atol=1e-11)
    # what it stores is in the column of the contacts
    stored = STIFFNESS / 2 * (exact**2 - lift**2)
    np.testing.assert_allclose(history["impact"], -stored, rtol=0, atol=1e-9)
    np.testing.assert_allclose(history["balance"], 0, atol=1e-10)


@pytest.mark.parametrize("pressed", [0.0, 1e-4])
def test_a_cohesive_law_dissipates_what_it_should(pressed):
    """A block just touching, or pressed on first, is drawn off: the drive has spent Gc."""

    def top(t):
        return (0.0, -pressed if t <= 0.02 else 0.03 * t)

    solid = ElasticSolid(
        rectangle((1, 1), (1, 1)),
        youngs_modulus=1e7,
        poisson_ratio=0.0,
        density=1e-3,
        prescribed={"top": top},
    )
    law, steps = Cohesive(), 200
    contact = Contact(solid, "base", FLOOR, law, name="c")
    history = Scene([solid], [contact], QuasiStatic()).run(1.0, 1 / steps, progress=False)
    assert history.reason == "finished"
    way, force = [top(t)[1] for t in history.time], history["c.force_y"]
    work = np.diff(way) @ (force[1:] + force[:-1]) / 2
    gc = law.stiffness * law.start * law.end / 2
    assert -work == pytest.approx(gc, rel=2 / steps)


@pytest.mark.parametrize("dt", [0.02, 0.1])
def test_two_solids_are_not_let_go_in_silence(dt):
    """A bed between two squares that are drawn apart pulls as springs in a row do, or the run
    stops: partners are sought over some facets only."""
    modulus, facet, speed = 1e6, 0.25, 2.0
    material = {"youngs_modulus": modulus, "poisson_ratio": 0.0, "density": 1.0}
    lower = ElasticSolid(rectangle((4, 4), (1, 1)), prescribed={"base": (0.0, 0.0)}, **material)
    mesh = rectangle((4, 4), (1, 1))
    mesh.mesh.geometry.x[:, 1] += 1.0
    led = {"top": lambda t: (0.0, speed * t)}
    upper = ElasticSolid(mesh, prescribed=led, name="upper", **material)
    contact = Contact(upper, "base", (lower, "top"), Bed(1.0), name="c")
    scene = Scene([lower, upper], [contact], ThetaScheme(1.0))
    history = scene.run(1.0, dt, progress=False)
    assert "'c' pulls from farther than its partners are sought" in history.reason
    assert history.advice.startswith("pulls from afar")
    assert speed * history.time[-1] > 1.5 * facet
    assert (history["c.force_y"][1:] < 0).all()


class Pushing(Bed):
    """One that says that it only pushes."""

    pushes = True


class Derived(Discrete):
    """One that says nothing of its own form."""

    def form(self, k):
        return k.integral(self.stiffness * k.gap * k.test_jump_n), 1.0


def test_who_is_believed_to_push_only():
    """Only who says so, and wrote the form of which that is said, or took it as it is."""
    assert only_pushes(Pushing(0.0)) and only_pushes(Discrete(1.0))
    assert only_pushes(Adhesive(1.0, "gap"))  # beside its glue, which it tells apart
    assert not only_pushes(Bed(0.0)) and not only_pushes(Derived(1.0))
