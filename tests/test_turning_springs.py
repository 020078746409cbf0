# SPDX-License-Identifier: LGPL-3.0-or-later
"""What sticks across a gap, on springs or by a clearance, turns with its solids: where these turn
together nothing slips, the stretch of springs and the forces turn along."""

import numpy as np
import pytest
from corpus_meshes import moved
from scenes import G, box, rectangle
from scipy.integrate import solve_ivp

from fenicsx_contact import (
    Compliance,
    Contact,
    Discrete,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    neo_hookean,
)


def turned(dim, angle, x, way=(0.0, 0.0, 0.0)):
    """Displacements of what first goes a way, then turns about z, or the origin."""
    c, s = np.cos(angle), np.sin(angle)
    a, b = x[0] + way[0], x[1] + way[1]
    return (c * a - s * b - x[0], s * a + c * b - x[1], way[2] + 0 * x[0])[:dim]


def pressed(dim, law, steps, apart=0.0, clearance=None):
    """Two blocks, pressed and sheared, then turned by 90 degrees: energy and forces before and
    after, these in the frame that turns."""
    down, along = (np.eye(3)[1 if dim == 2 else 2], np.eye(3)[0])
    sizes = ((5, 2), (0.6, 0.2)), ((3, 2), (0.3, 0.2))
    if dim == 3:
        sizes = ((2, 2, 1), (0.4, 0.4, 0.2)), ((2, 2, 1), (0.2, 0.2, 0.2))
    low, high = (rectangle(*size) if dim == 2 else box(*size) for size in sizes)
    moved(low, *(-(0.2 + apart) * down)[:dim])

    def angle(t):
        return np.pi / 2 * max(t - 1, 0)

    def way(t):
        return 4e-3 * min(max(2 * t - 1, 0), 1) * along - (0.01 + apart) * min(2 * t, 1) * down

    solids = [
        HyperelasticSolid(
            mesh, energy=neo_hookean(E, 0.3), density=1.0, prescribed={side: motion}, name=name
        )
        for mesh, E, side, motion, name in (
            (low, 1e6, "base", lambda x, t: turned(dim, angle(t), x), "low"),
            (high, 5e5, "top", lambda x, t: turned(dim, angle(t), x, way(t)), "high"),
        )
    ]
    lower, upper = solids
    contact = Contact(
        upper, "base", (lower, "top"), law, friction=0.5, name="c", clearance=clearance
    )
    history = Scene(solids, [contact], QuasiStatic(), deepest=1).run(2.0, 1 / steps)
    assert history.finished and not history["c.slipping"][steps:].any()
    forces = np.stack([history[f"c.force_{a}"] for a in "xyz"[:dim]], axis=1)
    first, last = forces[steps].copy(), forces[-1].copy()
    last[:2] = last[1], -last[0]  # turned back
    return history["strain"][[steps, -1]], first, last


LAWS = [
    pytest.param(Discrete(stiffness=5e5), {}, id="springs"),
    pytest.param(Compliance(1e7, 1.0, 1e7), {}, id="compliance"),
    pytest.param("gap", {"apart": 0.01, "clearance": 0.0}, id="clearance"),
]


@pytest.mark.parametrize("law, given", LAWS)
def test_what_is_pressed_and_sheared_turns_with_its_forces(law, given):
    """Tangential forces became twice as large on springs, whatever the step, and changed their
    sign across a clearance."""
    off = []
    for steps in (10, 20):
        (before, after), first, last = pressed(2, law, steps, **given)
        assert abs(after - before) < 3e-3 * before
        off.append(np.abs(last - first).max() / np.abs(first).max())
    assert off[0] < 2e-3 and off[1] < max(0.6 * off[0], 1e-4)


def test_in_space_forces_turn_about_the_normal():
    """A fifth of the tangential force stayed where it was."""
    (before, after), first, last = pressed(3, Discrete(stiffness=2e4), 8)
    assert abs(after - before) < 1e-3 * before
    np.testing.assert_allclose(last, first, atol=1e-3 * np.abs(first).max())


SPIN = 3.0  # 1/s


@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_a_box_on_springs_stays_on_a_bar_that_turns(theta):
    """It is pressed on from inside, a metre away from the axis. It crept by spin x depth, 28 mm."""
    spring, mass = Discrete(stiffness=2e3, damping=20.0), 1e6
    upper, lower = rectangle((2, 1), (0.2, 0.1)), rectangle((5, 1), (1.5, 0.2))
    moved(upper, 0.0, -1.0)
    moved(lower, 0.0, -1.2)

    def outwards(size):
        return lambda t: (size * np.sin(SPIN * t), -size * np.cos(SPIN * t))

    block = RigidSolid(
        upper, mass=1.0, velocity=(0.95 * SPIN, 0), spin=SPIN, force=outwards(20.0), name="box"
    )
    bar = RigidSolid(
        lower,
        mass=mass,
        velocity=(1.1 * SPIN, 0),
        spin=SPIN,
        force=outwards(-mass * SPIN**2 * 1.1),
        name="bar",
    )
    contact = Contact(block, "base", (bar, "top"), spring, friction=1.0, name="c")
    history = Scene([block, bar], [contact], ThetaScheme(theta), deepest=1).run(2.0, 1e-2)
    assert history.finished and history["c.penetration"].max() > 4e-3
    along = np.array([np.cos(bar.rotation), np.sin(bar.rotation)])
    assert abs((block.place - bar.place) @ along) < 3e-4


class Turntable:
    dim, moving, flat = 3, True, True

    def distance(self, points, time):
        return points[:, 2]

    def normals(self, points, time):
        return np.tile([0.0, 0.0, 1.0], (len(points), 1))

    def velocity(self, points, time):
        return SPIN * np.stack([-points[:, 1], points[:, 0], 0 * points[:, 2]], axis=1)


def test_a_box_on_springs_goes_round_with_a_turntable():
    """Their stretch stayed where it was in space: it went ahead by 0.028 rad each second."""
    mesh = box((1, 1, 1), (0.2, 0.2, 0.1))
    moved(mesh, 1.0, 0.0, -G / 2e4)
    solid = RigidSolid(mesh, mass=1.0, gravity=(0, 0, -G), velocity=(0, SPIN, 0), spin=(0, 0, SPIN))
    springs = Discrete(stiffness=5e3, tangential_stiffness=250.0, damping=20.0)
    contact = Contact(solid, "base", Turntable(), springs, friction=5.0)
    scene, ahead = Scene([solid], [contact], deepest=1), []
    for until in (2.0, 4.0):
        assert scene.run(until, 5e-3).finished
        angle = np.arctan2(solid.place[1], solid.place[0])
        ahead.append((angle - SPIN * until + np.pi) % (2 * np.pi) - np.pi)
    assert np.abs(ahead).max() < 3e-3


@pytest.mark.parametrize("dim, degree", [(2, 1), (2, 2), (3, 1)])
def test_supports_bear_what_springs_are_said_to(dim, degree):
    """Across a wavy surface the history told the forces of the law, along the mean normals, 5 % off
    the sum of those that act, along the gradients of the gaps."""
    sizes = ((9, 2), (1.0, 0.2)), ((4, 2), (0.3, 0.2))
    if dim == 3:
        sizes = ((6, 2, 2), (1.0, 0.4, 0.2)), ((3, 2, 1), (0.3, 0.2, 0.2))
    low, high = (rectangle(*size) if dim == 2 else box(*size) for size in sizes)
    x, up = low.mesh.geometry.x, dim - 1
    x[:, up] += np.where(x[:, up] > 0.19, 0.01 * np.sin(9 * x[:, 0]), 0.0)
    moved(high, 0.31, *((0.0,) if dim == 3 else ()), 0.2101)
    given = {"poisson_ratio": 0.3, "density": 1.0, "degree": degree}
    down = lambda t: (0.05 * t, *(0.0,) * (dim - 2), -0.02 * t)  # noqa: E731
    lower = ElasticSolid(low, youngs_modulus=1e6, fixed=["base"], name="low", **given)
    upper = ElasticSolid(high, youngs_modulus=3e6, prescribed={"top": down}, name="up", **given)
    springs = Discrete(stiffness=1e6)
    contact = Contact(upper, "base", (lower, "top"), springs, friction=0.2, name="c")
    history = Scene([lower, upper], [contact], QuasiStatic()).run(1.0, 0.25)
    told = np.array([history[f"c.force_{a}"][-1] for a in "xyz"[:dim]])
    assert history.finished and told[-1] > 10.0
    for solid, side, sign in ((upper, "top", -1), (lower, "base", 1)):
        np.testing.assert_allclose(solid.reaction(side), sign * told, atol=1e-7 * told[-1])
    assert np.abs(contact.force.sum(axis=0) - told).max() > 1e-3 * told[-1]


@pytest.mark.parametrize("rests", [False, True], ids=["rings", "rests"])
def test_what_slides_across_a_slope_on_springs(rests):
    """In space, aslant to the fall: its speed is that of a point mass, but for the friction of what
    rings on springs that start unstretched, mu N/(m omega)."""
    slope, mu, mass, stiffness, until = 0.4, 0.3, 2.0, 1e6, 0.1
    falls, presses = G * np.sin(slope), G * np.cos(slope)

    def rate(_, v):
        return np.array([0.0, -falls]) - mu * presses * v / np.linalg.norm(v)

    start = np.array([1.0, 0.3])
    exact = solve_ivp(rate, (0, until), start, rtol=1e-11, atol=1e-13, dense_output=True).sol
    deep = mass * presses / (4 * stiffness) if rests else 0.0
    block = RigidSolid(
        moved(box((1, 1, 1), (0.2, 0.2, 0.1)), 0.0, 0.0, -deep),
        mass=mass,
        gravity=(0, -falls, -presses),
        velocity=(*start, 0.0),
        held=[f"turning about {axis}" for axis in "xyz"],
    )
    floor = HalfSpace((0, 0, 0), (0, 0, 1))
    contact = Contact(block, "base", floor, Discrete(stiffness), friction=mu)
    probes = {"x": lambda: block.velocity[0], "y": lambda: block.velocity[1]}
    history = Scene([block], [contact], deepest=1.0).run(until, 5e-4, probes=probes)
    off = np.hypot(*(history[name] - exact(history.time)[i] for i, name in enumerate("xy")))
    rings = mu * presses * np.sqrt(mass / (4 * stiffness))
    if rests:
        assert off.max() < 0.01 * rings
    else:
        assert off.max() == pytest.approx(rings, rel=0.01)
