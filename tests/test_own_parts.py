# SPDX-License-Identifier: LGPL-3.0-or-later
"""Own parts without touching the package: a stranger's class for each protocol that there is.

None of the classes here inherits from the package; each is passed where the package's own would be.
(A stranger's drive of a rod: tests/test_beam.py.)
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np
import pytest
import ufl
from scenes import FLOOR, FLOOR_3D, G, box, rectangle
from test_obstacles import Own

from fenicsx_contact import (
    Circle,
    Contact,
    Discrete,
    ElasticSolid,
    HalfSpace,
    InputError,
    Moved,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
)
from fenicsx_contact.steps.certificate import Certificate
from fenicsx_contact.theory.weak_form import weak_form

IMPLICIT = ThetaScheme(1.0)


def thrown(formulation="gap", master=FLOOR, scheme=IMPLICIT, friction=0.0):
    """An elastic block of one facet at its base, thrown on the floor; its heights and scene."""
    solid = ElasticSolid(
        rectangle((1, 2)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        gravity=(0, -G),
        displacement=lambda x: np.stack([0 * x[0], 0.01 + 0 * x[0]]),
        velocity=lambda x: np.stack([0.5 + 0 * x[0], -1.0 + 0 * x[0]]),
    )
    contact = Contact(solid, "base", master, formulation, friction, name="c")
    scene = Scene([solid], [contact], scheme)
    history = scene.run(
        until=0.06, dt=1e-3, probes={"y": lambda: solid.mean(solid.displacement)[1]}
    )
    assert history.reason == "finished"
    assert history["c.force_y"].max() > 0
    return history


# -- a formulation -------------------------------------------------------------------------------


class Penalty:
    """A pressure that grows with the penetration at the end of the step: no multipliers."""

    name = "penalty"
    multipliers = percussive = at_points = False
    pushes = True
    points = None
    gap_share = 1.0  # the gap of the form is that of the end of the step

    def __init__(self, stiffness):
        self.stiffness = stiffness  # Pa/m

    def form(self, k):
        pressure = self.stiffness * ufl.max_value(k.gap + k.gap_rate * k.jump_n, 0.0)
        bears = ufl.conditional(ufl.gt(pressure, 0), 1.0, 0.0)
        form = k.integral(pressure * k.test_jump_n)
        if k.friction is not None:  # regularised: creeps where Coulomb sticks
            speed = ufl.sqrt(ufl.dot(k.jump_t, k.jump_t) + 0.05**2)  # m/s
            b = k.friction.bound(k, pressure, bears)
            form += k.integral(b / speed * ufl.dot(k.jump_t, k.test_jump_t))
        return form, bears

    def limit(self, data):
        return None


@pytest.mark.parametrize(
    "form, why",
    [
        (lambda k: k.integral(k.jump_nn * k.test_jump_n), "AttributeError"),
        (lambda k: k.integral(k.jump_n * k.test_jump_n), "must give a form in UFL and the status"),
        (lambda k: (k.jump_n, 1.0), "must give a form in UFL and the status"),
    ],
)
def test_a_formulation_that_writes_no_form_is_refused(form, why):
    class Wrong(Penalty):
        def form(self, k):
            return form(k)

    with pytest.raises(InputError, match=f"formulation = .*{why}"):
        thrown(Wrong(1e8))


class Shim:
    """The law of displacements before a floor that has a shim on it: with multipliers."""

    name = "shim"
    multipliers = True
    percussive = at_points = False
    points = None
    gap_share = 1.0

    def __init__(self, thickness):
        self.thickness = thickness  # m

    def form(self, k):
        return weak_form(k, k.jump_n + (k.gap + self.thickness) / k.gap_rate)

    def limit(self, data):
        return -(data.gap + self.thickness) / data.gap_rate


def test_a_formulation_without_multipliers():
    """At the two nodes of one facet a penalty is two springs; implicit, they are the same."""
    stiffness, width = 1e8, 0.36
    penalty, springs = thrown(Penalty(stiffness)), thrown(Discrete(stiffness * width / 2))
    np.testing.assert_allclose(penalty["y"], springs["y"], rtol=0, atol=1e-11)
    exact = thrown("gap")
    errors = [np.abs(thrown(Penalty(s))["y"] - exact["y"]).max() for s in (1e7, 1e8, 1e9)]
    assert errors[0] > errors[1] > errors[2] and errors[2] < 2e-4


def test_a_formulation_with_friction_of_its_own():
    """No tangential springs, no memory: only what its form says."""
    rubbed, free = thrown(Penalty(1e8), friction=0.3), thrown(Penalty(1e8))
    assert rubbed["c.force_x"].min() < 0 and not free["c.force_x"].any()
    share = rubbed["c.force_x"][1:] / np.maximum(rubbed["c.force_y"][1:], 1e-9)
    assert share.min() == pytest.approx(-0.3, rel=0.02)
    energy = rubbed["kinetic"][0]
    assert np.abs(rubbed["balance"]).max() < 1e-10 * energy
    assert np.diff(rubbed["friction"]).max() < 1e-10 * energy


def test_a_formulation_with_multipliers():
    shim = thrown(Shim(0.002), friction=0.3)
    raised = thrown("gap", HalfSpace((0, 0.002), (0, 1)), friction=0.3)
    np.testing.assert_allclose(shim["y"], raised["y"], rtol=0, atol=1e-12)


# -- a law of friction ---------------------------------------------------------------------------


class Glue:
    """Tresca's friction with a stress that depends on the place."""

    def __init__(self, stress):
        self.stress = stress  # of the reference coordinates, Pa

    def bound(self, k, pressure, S):
        return self.stress(k.x) * S

    def describe(self):
        return "glue"


@dataclass(frozen=True)
class Stribeck:
    """Coulomb's friction, less of it when fast: kinetic + (static - kinetic) exp(-|w_t|/speed)."""

    static: float
    kinetic: float
    speed: float

    def bound(self, k, pressure, S):
        slip = ufl.sqrt(ufl.max_value(ufl.dot(k.jump_t, k.jump_t), 1e-20))  # smooth at rest
        mu = self.kinetic + (self.static - self.kinetic) * ufl.exp(-slip / self.speed)
        return mu * pressure

    def describe(self):
        return f"friction from {self.static} to {self.kinetic} at {self.speed} m/s"


@pytest.mark.parametrize("law", ["velocity", "printed", "gap"])
def test_a_friction_that_depends_on_the_place(law):
    """What a sliding block feels is the integral of the stress."""
    solid = RigidSolid(rectangle((8, 1)), mass=500.0, gravity=(0, -G), velocity=(3.0, 0))
    friction = Glue(lambda x: 1000 * (1 + x[0]))
    scene = Scene([solid], [Contact(solid, "base", FLOOR, law, friction, name="c")], IMPLICIT)
    history = scene.run(until=0.05, dt=1e-3)
    assert history.reason == "finished"
    np.testing.assert_allclose(history["c.force_x"][2:], -1000 * 0.36, rtol=1e-9)
    assert "glue" in scene.describe()


@pytest.mark.parametrize(
    "bound, why",
    [
        (lambda k, p, S: None, "its bound is a NoneType: must be a scalar in UFL"),
        (lambda k, p, S: (p, S), "its bound is a tuple: must be a scalar in UFL"),
        (lambda k, p, S: k.jump_t, r"its bound is of the shape \(1,\): must be a scalar in UFL"),
        (lambda k, p, S: max(p, 1.0), "its bound raises"),
        (lambda k, p, S: k.slip * p, "its bound raises AttributeError"),
        (lambda k, p, S: np.exp(p), "its bound raises"),
        (lambda k, p, S: math.exp(-k.slip_speed) * p, "its bound raises TypeError: .*ufl.exp"),
    ],
)
def test_a_law_of_friction_that_gives_no_bound_is_refused(bound, why):
    class Wrong:
        def bound(self, k, pressure, S):
            return bound(k, pressure, S)

        def describe(self):
            return "wrong"

    with pytest.raises(InputError, match=rf"friction = .*Wrong.*{why}"):
        thrown(friction=Wrong())


@pytest.mark.parametrize(
    ("asked", "why"),
    [
        (lambda k: k.state("s", 0.0, lambda old, t: None), r"state 's': evolve\(.* is a NoneType"),
        (lambda k: k.state("s", 0.0, lambda old, t: k.jump_t), r"evolve\(.* of the shape \(1,\)"),
        (lambda k: k.state("s", 0.0, lambda old: old), r"state 's': evolve\(.* raises TypeError"),
        (lambda k: k.state("s", np.inf, lambda old, t: old), "s = inf: must be a finite number"),
        (lambda k: k.field("a", -1.0), "a = -1.0: must be a finite number >= 0"),
        (lambda k: k.field("a", np.nan), "a = nan: must be a finite number >= 0"),
    ],
)
def test_a_law_that_remembers_or_reads_nonsense_is_refused(asked, why):
    """By the name of the field; numbers below 0 and NaN passed, and a run stopped at its start."""

    class Wrong:
        def bound(self, k, pressure, S):
            return asked(k) * pressure

        def describe(self):
            return "wrong"

    with pytest.raises(InputError, match=why):
        thrown(friction=Wrong())


def test_a_friction_that_depends_on_the_speed():
    """A rigid block slides to rest: v' = -mu(v) g. No stress turns it: it is flat."""
    friction = Stribeck(0.4, 0.2, 0.5)
    errors = []
    for dt in (4e-3, 2e-3, 1e-3):
        solid = RigidSolid(
            rectangle((1, 1), (1.0, 0.1)), mass=10.0, gravity=(0, -G), velocity=(1.0, 0)
        )
        contact = Contact(solid, "base", FLOOR, "velocity", friction, name="c")
        history = Scene([solid], [contact]).run(
            until=0.2, dt=dt, probes={"v": lambda s=solid: s.velocity[0]}
        )
        v, fine = 1.0, 1e-5
        for _ in range(round(0.2 / fine)):
            v -= fine * G * (0.2 + 0.2 * np.exp(-v / 0.5))
        errors.append(abs(history["v"][-1] - v))
    assert errors[2] < 1e-3 and errors[1] / errors[2] > 1.7  # first order
    history = Scene([solid], [contact]).run(
        until=1.0, dt=dt, probes={"v": lambda: solid.velocity[0]}
    )
    assert abs(history["v"][-1]) < 1e-12  # and it stops


# -- an obstacle ---------------------------------------------------------------------------------


class Plane:
    """A floor at a height."""

    flat = True

    def __init__(self, dim, height):
        self.dim, self.height = dim, height

    def distance(self, points):
        return points[:, -1] - self.height

    def normals(self, points):
        return np.tile(np.eye(self.dim)[-1], (len(points), 1))


class Hill:
    """What is below y = height - x²/2r: its distances are right to first order near it."""

    dim = 2
    flat = False

    def __init__(self, radius, height=0.0):
        self.radius, self.height = radius, height

    def _slope(self, points):
        return np.stack([points[:, 0] / self.radius, np.ones(len(points))], axis=1)

    def distance(self, points):
        above = points[:, 1] - self.height + points[:, 0] ** 2 / (2 * self.radius)
        return above / np.linalg.norm(self._slope(points), axis=1)

    def normals(self, points):
        slope = self._slope(points)
        return slope / np.linalg.norm(slope, axis=1)[:, None]


@pytest.mark.parametrize("dim", [2, 3])
def test_an_obstacle_that_is_flat(dim):
    """It is the package's own half-space, to the last digit."""
    runs = []
    for master in (Plane(dim, 0.0), FLOOR if dim == 2 else FLOOR_3D):
        up = np.eye(dim)[-1]
        solid = RigidSolid(
            rectangle() if dim == 2 else box(),
            mass=10.0,
            gravity=-G * up,
            velocity=0.3 * np.eye(dim)[0] - 0.5 * up,
            rotation=0.01 if dim == 2 else (0.02, -0.03, 0.01),
            about=-0.3 * up,
        )
        contact = Contact(solid, "base", master, friction=0.3, name="c")
        runs.append(Scene([solid], [contact], deepest=1.0).run(until=0.1, dt=1e-3).rows())
    np.testing.assert_array_equal(*runs)


@pytest.mark.parametrize("geometry", ["fixed point", "newton"])
@pytest.mark.parametrize("law", ["velocity", "gap"])
def test_an_obstacle_that_is_curved(law, geometry):
    """A block dropped on the side of a hill slides down, and never into it."""
    hill = Hill(0.5)
    solid = RigidSolid(
        rectangle((2, 1), (0.2, 0.1)), mass=10.0, gravity=(0, -G), velocity=(0.3, 0.0)
    )
    contact = Contact(solid, "base", hill, law, friction=0.1, name="c")
    scene = Scene([solid], [contact], IMPLICIT, geometry=geometry)
    history = scene.run(until=0.3, dt=1e-3)
    assert history.reason == "finished"
    assert history["c.force_x"].max() > 0  # the hill pushes it to its side
    assert history["c.penetration"].max() < (1e-12 if law == "gap" else 1e-3)
    assert "Hill" in repr(scene.contacts[0].coupling.describe())


# -- a solid -------------------------------------------------------------------------------------


class PointMass:
    """A body that moves without turning, in a viscous fluid: m v' = m g - drag v + f.

    Its unknowns are the d components of its velocity. It offers what
    :class:`fenicsx_contact.solids.base.Solid` asks for.
    """

    linear, supported, massless, patient, shiftable, memory = True, False, False, False, False, None
    revolution = False

    def __init__(self, mesh, mass, drag, gravity, velocity, name="mass"):
        self.mesh, self.dim, self.name = mesh, mesh.dim, name
        self.mass, self.drag, self.gravity = mass, drag, np.array(gravity)
        self.velocity = self.trial_velocity = np.array(velocity, dtype=float)
        self.place = self.trial_place = np.zeros(mesh.dim)

    def mean_velocity(self, step):
        return step.mean(self.velocity, self.trial_velocity)

    def trace(self, points):
        return PointMassTrace(self, points)

    def go(self, velocity, step):
        self.trial_velocity = velocity
        self.trial_place = self.place + step.scheme.increment(step.dt, self.velocity, velocity)

    def predict(self, step):
        self.go(self.velocity, step)

    def linearise(self, step):
        # drag at the velocity where the scheme takes forces
        share, drag = step.scheme.theta, self.drag * step.loaded
        self.a = self.mass / step.span + share * drag
        known = (self.mass / step.span - (1 - share) * drag) * self.velocity
        self.free = (known + step.loaded * self.mass * self.gravity) / self.a
        self.drop_forces()

    def drop_forces(self):
        self.force = np.zeros(self.dim)

    def correct(self, step):
        self.go(self.free + self.force / self.a, step)

    def imbalance(self, step, noise=0.0):
        return 0.0  # linear: solved by correct

    def broken(self):
        return ""

    def unsound(self, step):
        return ""

    def turn(self, step):
        return 0.0

    def shift(self, way):
        self.trial_place = self.trial_place + way

    @property
    def mobility(self):
        return np.eye(self.dim) / self.mass

    def memories(self):
        return {}

    def accept(self, step):
        self.velocity, self.place = self.trial_velocity, self.trial_place

    def energies(self):
        moving = 0.5 * self.mass * float(self.velocity @ self.velocity)
        return moving, 0.0, -self.mass * float(self.gravity @ self.place)

    def root_mean_square(self, velocity):
        return float(np.linalg.norm(velocity))

    def works(self, step):
        mean = step.scheme.mean(self.velocity, self.trial_velocity)
        share = step.scheme.theta
        dragging = -self.drag * (share * self.trial_velocity + (1 - share) * self.velocity)
        momentum = self.mass * (self.trial_velocity - self.velocity)
        acting = step.dt * (self.mass * self.gravity + dragging)
        return float(mean @ momentum), float(mean @ acting), 0.0, 0.0

    def damped(self, step):
        mean = step.scheme.mean(self.velocity, self.trial_velocity)
        return -step.dt * self.drag * float(mean @ mean)

    def state(self):
        return {"place": self.place, "velocity": self.velocity}

    def restore(self, state):
        self.place = self.trial_place = np.array(state["place"])
        self.velocity = self.trial_velocity = np.array(state["velocity"])

    def describe(self):
        return f"point mass of {self.mass} kg, drag {self.drag} N s/m"

    def fields(self):
        nodes = (len(self.mesh.mesh.geometry.x), 1)
        return {
            "displacement": np.tile(self.place, nodes),
            "velocity": np.tile(self.velocity, nodes),
        }


class PointMassTrace:
    """It, seen from n points: each moves as it does."""

    def __init__(self, solid, points):
        self.solid, self.points = solid, points
        self.J = np.tile(np.eye(solid.dim), (len(points), 1))

    def follow(self):
        pass

    def linearise(self, step):
        pass

    def accept(self):
        pass

    def positions(self):
        return self.points + self.solid.trial_place

    def jump(self, velocity):
        return self.J @ velocity

    mean_jump = jump

    def free_jump(self):
        return self.J @ self.solid.free

    def compliance(self, mine, other, theirs):
        return self.J[mine] @ other.J[theirs].T / self.solid.a

    def mobility(self):
        return np.full(self.points.size, 1 / self.solid.a)

    def spread(self, force):
        self.solid.force += self.J.T @ force


def sliding(drag=5.0, **scene):
    solid = PointMass(rectangle((2, 1)), 10.0, drag, (0, -G), (2.0, 0.0))
    contact = Contact(solid, "base", FLOOR, friction=0.2, name="c")
    return solid, Scene([solid], [contact], **scene)


def test_a_solid():
    """It slides to rest on the floor, under drag and friction, at the exact instant."""
    solid, scene = sliding()
    history = scene.run(until=1.2, dt=1e-3, probes={"v": lambda: solid.velocity[0]})
    assert history.reason == "finished"
    rate, held = 5.0 / 10.0, 0.2 * G
    t, v = history.time, history["v"]
    stop = np.log(1 + rate * 2.0 / held) / rate
    exact = (2.0 + held / rate) * np.exp(-rate * t) - held / rate
    np.testing.assert_allclose(v[t < stop], exact[t < stop], atol=1e-5)
    assert np.abs(v[t > stop + 2e-3]).max() < 1e-12
    assert history["balance"][-1] == pytest.approx(0, abs=1e-10)
    assert "point mass" in scene.describe()


def test_a_solid_on_one_of_the_package(tmp_path):
    """A point mass dropped on an elastic block; files are written and the run is resumed (forces of
    no size, after the flight began, are round-off)."""

    def make():
        low = ElasticSolid(
            rectangle((6, 2), (0.6, 0.2)),
            youngs_modulus=1e6,
            poisson_ratio=0.3,
            density=1000.0,
            fixed=["base"],
            name="low",
        )
        up = PointMass(rectangle((3, 1), (0.2, 0.1)), 50.0, 1.0, (0, -G), (0.2, -0.5), "up")
        up.place = up.trial_place = np.array([0.02, 0.201])
        contact = Contact(up, "base", (low, "top"), "gap", friction=0.3, name="c")
        return Scene([up, low], [contact], IMPLICIT)

    whole = make().run(until=0.02, dt=1e-3)
    assert whole.reason == "finished" and whole["c.force_y"].max() > 500.0
    assert np.abs(whole["balance"]).max() < 1e-8 * whole["kinetic"][0]
    make().run(until=0.01, dt=1e-3, directory=tmp_path, fields_every=5)
    resumed = make().run(until=0.02, dt=1e-3, directory=tmp_path, fields_every=5, resume=True)
    np.testing.assert_allclose(resumed.rows(), whole.rows(), rtol=1e-9, atol=1e-8)


# -- refusals ------------------------------------------------------------------------------------


class Incomplete:
    """Has a name and nothing else."""

    name, dim = "incomplete", 2

    def __repr__(self):
        return "Incomplete()"


class Untold:
    """A law of friction that does not say what it is."""

    def bound(self, k, pressure, S):
        return pressure

    def __repr__(self):
        return "Untold()"


class Strange(Untold):
    """A law of friction whose bound may be no number."""

    def __init__(self, factor):
        self.factor = factor

    def bound(self, k, pressure, S):
        return self.factor(k) * pressure

    def describe(self):
        return "strange"


def rigid():
    return RigidSolid(rectangle(), mass=1.0)


@pytest.mark.parametrize(
    "make, says",
    [
        (lambda: Contact(Incomplete(), "base", FLOOR), r"solid = Incomplete\(\): .*lacks accept"),
        (lambda: Contact(PointMass, "base", FLOOR), "solid = <class .*not a class"),
        (lambda: Contact(rigid(), "base", (Incomplete(), "top")), "master.*Incomplete.*lacks"),
        (lambda: Contact(rigid(), "base", Incomplete()), r"master = Incomplete\(\): must be"),
        (lambda: Contact(rigid(), "base", (rigid(),)), r"master = \('rigid',\): must be \(solid"),
        (lambda: Contact(rigid(), "base", rigid()), "master = 'rigid': must be an obstacle"),
        (lambda: Contact(rigid(), "base", FLOOR, Incomplete()), "formulation = Incomplete.*lacks"),
        (lambda: Contact(rigid(), "base", FLOOR, Penalty), "formulation = <class.*call it"),
        (lambda: Contact(rigid(), "base", FLOOR, friction=Incomplete()), "friction = Incomplete"),
        (
            lambda: Contact(rigid(), "base", FLOOR, friction=Untold()),
            r"Untold\(\): .*lacks describe",
        ),
        (lambda: Contact(rigid(), "base", FLOOR, friction=Untold), "Untold.*not a class"),
        (lambda: Contact(rigid(), "base", FLOOR, friction=Strange(lambda k: np.nan)), "number nan"),
        (lambda: Contact(rigid(), "base", FLOOR, friction=Strange(lambda k: np.inf)), "number inf"),
        (lambda: Scene([Incomplete()], []), r"solids = Incomplete\(\): must be solids; it lacks"),
        (lambda: Scene(rigid(), []), "solids = .*must be a list of solids"),
    ],
)
def test_what_lacks_a_member_is_refused_by_name(make, says):
    with pytest.raises(InputError, match=says):
        make()


@pytest.mark.parametrize("deforms", [False, True])
@pytest.mark.parametrize(
    "factor", [lambda k: ufl.sqrt(-k.slip_speed - 1), lambda k: ufl.ln(k.slip_speed - 10)]
)
def test_a_bound_that_is_no_number_is_no_friction_without_bound(factor, deforms):
    """NaN is above no bound and below none: it must not pass for a point that sticks."""
    start = {"mesh": rectangle(), "gravity": (0, -G)}
    if deforms:
        moving = lambda x: np.stack([1.0 + 0 * x[0], 0 * x[0]])  # noqa: E731
        same = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1e3, "velocity": moving}
        solid = ElasticSolid(**start, **same)
    else:
        solid = RigidSolid(**start, mass=1.0, velocity=(1.0, 0.0))
    contact = Contact(solid, "base", FLOOR, friction=Strange(factor))
    history = Scene([solid], [contact]).run(0.05, 0.01)
    assert not history.finished and "no finite solution" in history.reason
    assert np.isfinite(history.rows()).all()


def test_a_work_that_is_no_number_is_not_booked():
    assert "no finite solution" in Certificate(0.0, 0.0, np.nan).refusal


# -- what numpy tells of them --------------------------------------------------------------------


class Bound:
    """So many times the pressure, in UFL."""

    def __init__(self, factor):
        self.factor = factor

    def bound(self, k, pressure, S):
        return self.factor(k) * pressure

    def describe(self):
        return "bound"


@pytest.mark.parametrize("formulation", ["velocity", "gap", Discrete(1e6)], ids=str)
@pytest.mark.parametrize(
    "factor",
    [lambda k: 0 * k.x[0] - 0.1, lambda k: ufl.conditional(ufl.gt(k.x[0], 0), 0.1, -0.1)],
    ids=["everywhere", "in a part"],
)
def test_a_bound_of_friction_below_zero_is_refused(formulation, factor):
    """Where half of the base had 0.1 and the other -0.1 the run finished, without friction."""
    solid = RigidSolid(rectangle(), mass=1.0, gravity=(0, -G), velocity=(1, 0))
    with pytest.raises(InputError, match=r"friction.*its bound must be >= 0.*-0.18, 0.0.*negative"):
        Contact(solid, "base", FLOOR, formulation, Bound(factor))


@pytest.mark.parametrize("formulation", ["velocity", "gap", Discrete(1e6)], ids=str)
def test_a_bound_of_friction_that_falls_below_zero_stops_the_run(formulation):
    """It went on with friction that pushes, until the contacts made energy, by which it stopped."""
    solid = RigidSolid(rectangle(), mass=1.0, gravity=(0, -G), velocity=(1, 0))
    contact = Contact(solid, "base", FLOOR, formulation, Bound(lambda k: 0.1 - 20 * k.t), name="c")
    history = Scene([solid], [contact], IMPLICIT).run(until=0.02, dt=1e-3)
    assert "the bound of friction of contact 'c' must be finite and >= 0" in history.reason
    assert "(see: when it stops, 'parameter')" in history.reason
    assert history["time"][-1] == pytest.approx(0.005, abs=1e-5)


class Shelf:
    """The floor; ``asked`` does something careless at each question, as own functions may."""

    dim, flat, moving = 2, False, True

    def __init__(self, asked=lambda: None):
        self.asked = asked

    def distance(self, points, time=0.0):
        self.asked()
        return points[:, 1].copy()

    def normals(self, points, time=0.0):
        return np.broadcast_to([0.0, 1.0], points.shape)


def careless():
    infinite = np.exp(np.array([1e3]))
    return infinite - infinite


@pytest.mark.parametrize("solver", ["condensed", "monolithic"])
@pytest.mark.parametrize("own", ["obstacle", "motion", "velocity"])
def test_numpy_warns_of_functions_of_ones_own(own, solver, monkeypatch):
    """In the midst of a step, too, where it says nothing of iterates."""
    solving = []

    def asked(*_):
        if solving:
            careless()

    def motion(time):
        return asked() or (0.0, 0.0)

    obstacle = Shelf(asked) if own == "obstacle" else FLOOR
    if own == "motion":
        obstacle = Moved(FLOOR, motion)
    if own == "velocity":
        obstacle = Shelf()
        obstacle.velocity = lambda points, time: asked() or np.zeros(points.shape)
    solid = ElasticSolid(
        rectangle(), youngs_modulus=1e6, poisson_ratio=0.3, density=1000.0, gravity=(0, -G)
    )
    scene = Scene([solid], [Contact(solid, "base", obstacle)], solver=solver)
    method = scene.stepper._method
    solve = method.solve

    def watched(*arguments):
        solving.append(True)
        try:
            return solve(*arguments)
        finally:
            solving.clear()

    monkeypatch.setattr(method, "solve", watched)
    with pytest.warns(RuntimeWarning) as told:
        scene.run(2e-3, 1e-3, progress=False)
    said = {str(each.message) for each in told}
    assert said == {"overflow encountered in exp", "invalid value encountered in subtract"}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("size", [1e160, np.inf, np.nan])
@pytest.mark.parametrize("master", [FLOOR, Circle((0.0, -1.0), 1.0)], ids=["plane", "circle"])
def test_nor_is_an_obstacle_asked_by_an_iterate_that_diverges(master, size):
    solid = ElasticSolid(rectangle(), youngs_modulus=1e6, poisson_ratio=0.3, density=1000.0)
    scene = Scene([solid], [Contact(solid, "base", master)], solver="monolithic")
    iterate = scene.stepper._method.system.iterate

    def diverge(step):
        done = iterate(step)
        solid.go(solid.trial_velocity + size, step)
        return done

    scene.stepper._method.system.iterate = diverge
    history = scene.run(1e-3, 1e-3, shortest=0.5, progress=False)
    assert not history.finished
    assert "nowhere" in history.reason or "stalls" in history.reason


class Frictionless(Penalty):
    """A penalty whose form has no friction."""

    def form(self, k):
        start, end = (ufl.max_value(d, 0.0) for d in (k.gap, k.gap + k.gap_rate * k.jump_n))
        pressure = self.stiffness * (start + end) / 2
        return k.integral(pressure * k.test_jump_n), ufl.conditional(ufl.gt(pressure, 0), 1.0, 0.0)


def test_friction_that_a_form_does_not_ask_for_is_refused():
    """It was left out, and described as if it were there."""
    assert thrown(Frictionless(1e8)).finished
    with pytest.raises(InputError, match=r"friction: .*0\.3.*never asks for its bound"):
        thrown(Frictionless(1e8), friction=0.3)


def leaning(angle):
    """Normals that lean by an angle, rad, from those of a floor."""
    return lambda x, t: np.tile([np.sin(angle), np.cos(angle)], (len(x), 1))


@pytest.mark.parametrize("height", [0.0, 1e-3, 1.0])
@pytest.mark.parametrize(
    ("members", "said"),
    [
        ({"normals": leaning(1.0)}, "grows by 0.54 of a way along"),
        ({"normals": leaning(0.5 * np.pi)}, r"grows by (0|6.12e-17) of a way along \[1.0, "),
        ({"distance": lambda x, t: 2 * x[:, 1]}, "grows by 2 of a way along"),
        (
            {
                "distance": lambda x, t: np.where(x[:, 0] > 0.05, 0.5, 1) * x[:, 1],
                "velocity": lambda x, t: 0 * x,
            },
            "grows by 0.5 of a way along",
        ),
    ],
)
def test_distances_and_normals_that_contradict_each_other_are_refused(height, members, said):
    """Where they do at some points, and of one that flies, too; it fell through such a floor."""
    block = RigidSolid(rectangle((2, 1), (0.2, 0.1)), mass=1.0, gravity=(0, -G))
    place = np.add(block.place, (0, height))
    block.restore({**block.state(), "place": place})
    with pytest.raises(InputError, match=said):
        Contact(block, "base", Own(**members))


def test_what_is_flat_has_one_normal():
    """A parabola told as flat took the block along another way."""
    block = RigidSolid(rectangle((1, 1), (0.2, 0.1)), mass=1.0)
    bowl = Own(
        distance=lambda x, t: (x[:, 1] + x[:, 0] ** 2) / np.sqrt(1 + 4 * x[:, 0] ** 2),
        normals=lambda x, t: (
            np.stack([2 * x[:, 0], 1 + 0 * x[:, 0]], axis=1) / np.sqrt(1 + 4 * x[:, :1] ** 2)
        ),
    )
    Contact(block, "base", bowl)
    bowl.flat = True
    with pytest.raises(InputError, match="flat = True: its normals must be the same everywhere"):
        Contact(block, "base", bowl)


@pytest.mark.parametrize("moved", [False, True])
def test_normals_that_are_no_unit_vectors_later_stop_the_run(moved):
    """By springs the block span under a force of the double."""
    block = RigidSolid(rectangle((1, 1), (0.2, 0.1)), mass=1.0, gravity=(0, -G))
    late = Own(normals=lambda x, t: np.tile([0.0, 1.0 if t < 5e-3 else 2.0], (len(x), 1)))
    master = Moved(late, lambda t: (0, 0)) if moved else late
    contact = Contact(block, "base", master, Discrete(1e5))
    history = Scene([block], [contact]).run(0.01, 2e-3)
    assert history.time[-1] < 5e-3 and "'obstacle')" in history.reason
    assert "the normals of an obstacle is [0.0, 2.0] at the point" in history.reason


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (lambda n: np.full((n, 2, 2), np.nan), "is nan at the point"),
        (lambda n: np.zeros((n, 2)), r"is of the shape \(2, 2\): must be \(2, 2, 2\)"),
    ],
    ids=["nan", "shape"],
)
def test_a_curvature_that_is_none_later_stops_the_run(wrong, said):
    """It was asked for at the start only; later it led Newton's method astray, or raised."""
    block = RigidSolid(rectangle((1, 1), (0.2, 0.1)), mass=1.0, gravity=(0, -G))
    right = lambda n: np.zeros((n, 2, 2))  # noqa: E731
    late = Own(curvature=lambda x, t: (right if t < 5e-3 else wrong)(len(x)))
    contact = Contact(block, "base", late, friction=0.5)
    history = Scene([block], [contact], geometry="newton").run(0.01, 2e-3)
    assert history.time[-1] < 5e-3 and "'obstacle')" in history.reason
    assert re.search(f"the curvature of an obstacle {said}", history.reason), history.reason


@pytest.mark.parametrize("error", [ZeroDivisionError, KeyError, AttributeError, RuntimeError])
@pytest.mark.parametrize("member", ["distance", "normals", "velocity", "curvature", "slopes"])
def test_what_an_own_obstacle_raises_names_it(member, error):
    """Of some kinds it came bare, without a word on the obstacle."""

    def fails(x, t):
        raise error("mine")

    block = RigidSolid(rectangle((1, 1), (0.2, 0.1)), mass=1.0)
    said = f"master = .*: an obstacle raises {error.__name__}: '?mine"
    with pytest.raises(InputError, match=said) as refused:
        Contact(block, "base", Own(**{member: fails}))
    assert isinstance(refused.value.__cause__, error)


# -- formulations that pull ----------------------------------------------------------------------


@dataclass(frozen=True)
class Bed:
    """Springs that push and pull, linear, until they break at a stretch, if they do; the mean of
    the forces at both ends. The status is 1 where it presses, or wherever it acts."""

    stiffness: float
    telling: bool = False
    breaks: float = np.inf
    name = "bed"
    multipliers = percussive = at_points = False
    points = None
    gap_share = 1.0

    def form(self, k):
        start, end = k.start_gap, k.gap + k.gap_rate * k.jump_n
        p = self.stiffness * (start + end) / 2
        if self.breaks < np.inf:
            p = ufl.conditional(ufl.gt(end, -self.breaks), p, 0.0)
        return k.integral(p * k.test_jump_n), ufl.conditional(
            ufl.gt(abs(p) if self.telling else p, 0.0), 1.0, 0.0
        )

    def limit(self, data):
        """None."""


@pytest.mark.parametrize("telling", [False, True])
@pytest.mark.parametrize(("depth", "speed"), [(0.0, 1.0), (0.05, 0.0), (0.0, -1.0)])
def test_an_own_bed_pulls(depth, speed, telling):
    """A form that pulls was not asked where points were open: what was thrown off a bed flew off,
    0.63 m wrong, "finished"."""
    body = RigidSolid(rectangle((2, 1), (1.0, 0.1)), mass=10.0, velocity=(0, speed))
    body.restore({**body.state(), "place": body.place - np.array([0, depth])})
    contact = Contact(body, "base", FLOOR, Bed(1000.0, telling), name="c")
    probes = {"y": lambda: body.place[1] - 0.05}
    history = Scene([body], [contact], deepest=1.0).run(0.6, 1e-3, probes=probes, progress=False)
    assert history.finished, history.reason
    t = 10 * history.time
    np.testing.assert_allclose(history["y"], 0.1 * speed * np.sin(t) - depth * np.cos(t), atol=1e-5)
    assert history["newton"].max() <= 3


@pytest.mark.parametrize("breaks", [np.inf, 0.0105])
def test_an_own_bed_holds_what_is_pulled_at_rest(breaks):
    """Without inertia, just touching at the start: 0 N, "finished"."""
    drive = {"top": lambda t: (0.0, 0.02 * t)}
    stiff = {"youngs_modulus": 1e9, "poisson_ratio": 0.0, "density": 1.0}
    block = ElasticSolid(rectangle((2, 1), (1.0, 0.1)), prescribed=drive, **stiff)
    contact = Contact(block, "base", FLOOR, Bed(1e4, breaks=breaks), name="c")
    history = Scene([block], [contact], QuasiStatic(), deepest=1.0).run(1.0, 0.05, progress=False)
    assert history.finished, history.reason
    stretch = 0.02 * (history.time - 0.025)[1:]  # the mean of the step
    expected = np.where(0.02 * history.time[1:] < breaks, -1e4 * stretch, 0.0)
    np.testing.assert_allclose(history["c.force_y"][1:], expected, atol=1e-3 * 200)


# -- a bound that depends on direction -----------------------------------------------------------


@dataclass(frozen=True)
class Grooved:
    """Grooves along x: 0.1 of the pressure along them, 0.4 across."""

    def bound(self, k, pressure, S):
        x = k.tangential(ufl.as_vector((1.0, 0.0, 0.0)))
        along, slip2 = ufl.dot(k.jump_t, x) ** 2 / ufl.dot(x, x), ufl.dot(k.jump_t, k.jump_t)
        share = ufl.conditional(ufl.gt(slip2, 0.0), along / (slip2 + 1e-300), 0.0)
        return (0.4 - 0.3 * share) * pressure

    def describe(self):
        return "grooves"


@pytest.mark.parametrize("normal", [(0, 0, 1), (0.01, 0, 1), (0, 0.01, 1), (0.3, 0.31, 1)])
@pytest.mark.parametrize(("way", "expected"), [((1, 0, 0), 0.1), ((0, 1, 0), 0.4)])
def test_a_bound_by_direction_follows_no_axes_of_the_solver(normal, way, expected):
    """The components of the slip have axes that turn with the normal."""
    n = np.array(normal) / np.linalg.norm(normal)
    t = np.array(way) - (np.array(way) @ n) * n
    t /= np.linalg.norm(t)
    mesh = box((1, 1, 1), (0.3, 0.3, 0.1))
    frame = np.column_stack([t, np.cross(n, t), n])
    mesh.mesh.geometry.x[:] = mesh.mesh.geometry.x @ frame.T
    held = ["turning about x", "turning about y", "turning about z"]
    body = RigidSolid(mesh, mass=1.0, gravity=tuple(-G * n), velocity=tuple(t), held=held)
    floor = HalfSpace((0.0, 0.0, 0.0), tuple(n))
    Scene([body], [Contact(body, "base", floor, friction=Grooved())]).run(0.1, 1e-3, progress=False)
    assert (1 - body.velocity[:3] @ t) / (0.1 * G) == pytest.approx(expected, rel=0.03)
