# SPDX-License-Identifier: LGPL-3.0-or-later
"""Normals that turn on the way of a step: round walls, walls and solids that turn. Forces along the
mean normal make theta = 1/2 of second order there, where one normal made it of first."""

import meshio
import numpy as np
import pytest
import ufl
from scenes import G
from scipy.integrate import solve_ivp

from fenicsx_contact import (
    Circle,
    Compliance,
    Contact,
    Curve,
    HalfSpace,
    Heap,
    LevelSet,
    Moved,
    Restitution,
    RigidSolid,
    Scene,
    Sphere,
    ThetaScheme,
    Turned,
    mesh_from_file,
    name_facets,
)
from fenicsx_contact.base.compat import PointExpression
from fenicsx_contact.contact.memory import at_points
from fenicsx_contact.solids.rotations import rotation_matrix

TIP = np.array([[0.0, 0.0], [0.02, 0.05], [-0.02, 0.05]])  # m
SPIN = 3.0  # 1/s


def named(path, points, kind, cells, where=lambda x: np.full(x.shape[1], True)):
    points = np.asarray(points, dtype=float)
    points = np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))])
    meshio.Mesh(points, [(kind, np.array(cells))]).write(path)
    mesh = mesh_from_file(path).mesh
    return name_facets(mesh, {"skin": where})


def upper_side(x):
    return np.isclose(x[1], 0)


def tip(path, place, velocity=(0.0, 0.0), gravity=G, held=("turning",)):
    """A mass that touches with one corner only, and where that is."""
    mesh = named(path / "tip.vtu", np.asarray(place) + TIP, "triangle", [[0, 1, 2]])
    kept = {"held": held, "gravity": (0, -gravity)}
    return RigidSolid(mesh, mass=1.0, velocity=velocity, name="tip", **kept)


def corner(mass):
    return mass.place - TIP.mean(axis=0)


def orders(errors):
    """Orders of convergence as steps are halved."""
    errors = np.abs(np.asarray(errors))
    return np.log2(errors[:-1] / errors[1:])


def swing(angle, speed, mu, until):
    """Angle and angular speed of a point mass in a hollow of 1 m."""

    def rates(t, y):
        return y[1], -G * np.sin(y[0]) - mu * (G * np.cos(y[0]) + y[1] ** 2) * np.sign(y[1])

    return solve_ivp(rates, (0, until), (angle, speed), rtol=1e-11, atol=1e-12).y[:, -1]


@pytest.mark.parametrize("law", ["velocity", "gap", "lagrange"])
@pytest.mark.parametrize("mu", [0.0, 0.2])
def test_a_mass_swings_in_a_hollow(law, mu, tmp_path):
    """By one normal it lost 4 % of its energy in 600 steps and sank in by 5 mm."""
    angle, speed, until = 0.8, 0.0 if mu == 0 else -1.0, 1.5 if mu == 0 else 0.5
    exact = swing(angle, speed, mu, until)
    errors = []
    for dt in (1e-2, 5e-3, 2.5e-3):
        along = np.array([np.cos(angle), np.sin(angle)])
        mass = tip(tmp_path, (np.sin(angle), -np.cos(angle)), speed * along)
        contact = Contact(mass, "skin", Circle((0, 0), 1.0, inside=True), law, friction=mu)
        history = Scene([mass], [contact]).run(until=until, dt=dt)
        assert history.finished and not history.remarks
        x, v = corner(mass), mass.velocity[:2]
        assert abs(np.hypot(*x) - 1) < 1e-8
        errors.append([np.arctan2(x[0], -x[1]) - exact[0], np.hypot(*v) - abs(exact[1])])
        if not mu:
            energy = v @ v / 2 + G * (x[1] + np.cos(angle))
            assert abs(energy) < 3 * dt**2
            assert abs(contact.friction_traction).max() < 1e-12 * contact.pressure.max()
        else:
            pressure, friction = contact.pressure.max(), contact.friction_traction
            assert np.hypot(*friction.T).max() == pytest.approx(mu * pressure, rel=1e-10)
    assert np.abs(errors[-1]).max() < 3e-5
    assert (orders(errors) > 1.9).all()


def test_a_mass_slides_down_a_dome(tmp_path):
    """Its velocity went to and fro about the tangent, as it may fall back as fast as it left."""
    start, errors = 0.2, []
    for dt in (1e-2, 5e-3, 2.5e-3):
        mass = tip(tmp_path, (np.sin(start), np.cos(start)))
        contact = Contact(mass, "skin", Circle((0, 0), 1.0))
        scene = Scene([mass], [contact])
        for _ in range(round(0.4 / dt)):
            list(scene.step(dt))
            assert contact.status.any()
        x, v = corner(mass), mass.velocity[:2]
        assert abs(v @ x) < 2 * dt**2
        errors.append(v @ v / 2 + G * (x[1] - np.cos(start)))
    assert abs(errors[-1]) < 2e-5
    assert (orders(errors) > 1.8).all()


@pytest.mark.parametrize("law", ["velocity", "gap"])
@pytest.mark.parametrize("theta", [0.75, 1.0])
@pytest.mark.parametrize("cam", ["turned", "moved"])
def test_a_cam_starts_from_rest(cam, theta, law, tmp_path):
    """What slides by under the follower does not drive it, and a step's share of what it has at the
    start is rounding: such runs were stopped for it, the sooner the shorter the next step was."""
    radius, off, speed = 0.5, 0.1, 4.0
    if cam == "turned":
        wall = Turned(Circle((0, off), radius), (0, 0), lambda t: speed * t)
    else:
        wall = Moved(
            Circle((0, 0), radius), lambda t: (-off * np.sin(speed * t), off * np.cos(speed * t))
        )
    mass = tip(tmp_path, (0.0, radius + off), held=("x", "turning"))
    contact = Contact(mass, "skin", wall, law)
    history = Scene([mass], [contact], ThetaScheme(theta)).run(0.5, 1e-2)
    assert history.finished and not history.remarks
    swings = off * np.sin(speed * history.time)
    place = off * np.cos(speed * history.time) + np.sqrt(radius**2 - swings**2)
    fallen = (history["potential"] - history["potential"][0]) / G
    np.testing.assert_allclose(fallen, place - place[0], atol=1e-5)


@pytest.mark.parametrize("dt", [1e-2, 5e-3])
def test_down_a_dome_by_theta_1(dt, tmp_path):
    """The chord of a step rises off the tangent of its end, along which forces act, and the scheme
    takes more than that gives: the run was stopped though its energy falls all the way."""
    mass = tip(tmp_path, (np.sin(0.2), np.cos(0.2)))
    contact = Contact(mass, "skin", Circle((0, 0), 1.0), "gap")
    history = Scene([mass], [contact], ThetaScheme(1.0)).run(0.5, dt)
    assert history.finished and not history.remarks
    assert history["impact"].max() > 0.01 * history["kinetic"].max() * dt / 1e-2
    assert (np.diff(history["kinetic"] + history["potential"]) < 1e-12).all()


@pytest.mark.parametrize("law", ["velocity", "gap"])
@pytest.mark.parametrize("turns", ["wall", "bar"])
def test_a_mass_rides_on_what_turns(turns, law, tmp_path):
    """Without friction it is driven outwards: r = r0 cosh(w t) + v0/w sinh(w t). By one normal it
    sank by 5 mm into a bar, steps of 10 ms, and was 5 mm behind."""
    first, speed, until, errors = 0.3, 1.0, 0.25, []
    for dt in (1e-2, 5e-3, 2.5e-3):
        mass = tip(tmp_path, (first, 0), (speed, SPIN * first), gravity=0.0)
        solids = [mass]
        if turns == "wall":
            master = LevelSet(
                lambda x, t: x[1] * ufl.cos(SPIN * t) - x[0] * ufl.sin(SPIN * t), dim=2
            )
        else:
            corners = [(-1, -0.1), (1, -0.1), (1, 0), (-1, 0)]
            mesh = named(tmp_path / "bar.vtu", corners, "quad", [[0, 1, 2, 3]], upper_side)
            drift = np.array([0.05 * SPIN, 0])  # the middle of the upper side stays where it is
            bar = RigidSolid(mesh, mass=1e9, spin=SPIN, velocity=drift, name="bar")
            solids, master = [mass, bar], (bar, "skin")
        contact = Contact(mass, "skin", master, law)
        scene = Scene(solids, [contact])
        history = scene.run(until=until, dt=dt)
        assert history.finished and not history.remarks
        turned = SPIN * until
        along = np.array([np.cos(turned), np.sin(turned)])
        across = np.array([-along[1], along[0]])
        x = corner(mass) - (bar.place if turns == "bar" else 0)
        top = 0.05 if turns == "bar" else 0.0
        assert abs(x @ across - top) < 1e-8
        exact = first * np.cosh(turned) + speed / SPIN * np.sinh(turned)
        errors.append(x @ along - exact)
    assert abs(errors[-1]) < 5e-6
    assert (orders(errors) > 1.9).all()


@pytest.mark.parametrize("law", ["velocity", "gap"])
def test_a_mass_slides_down_a_seesaw(law, tmp_path):
    """Forces act on both where the slave is in the mean of a step: on the bar they acted where it
    was at the end, with a torque that turned 1 % too slowly and gave 1.5 % of the energy."""
    m, M, first, speed, half, until = 1.0, 3.0, 0.2, 1.0, 0.1, 0.4
    inertia = M * (2**2 + 0.2**2) / 12

    def rates(t, y):  # s, s', angle, w of a mass at s along the bar, half of it above its middle
        s, along, angle, w = y
        matrix = m * np.array([[1, -half], [-half, s * s + half**2 + inertia / m]])
        c, d = G * np.sin(angle), G * (s * np.cos(angle) - half * np.sin(angle))
        change = np.linalg.solve(matrix, m * np.array([s * w * w - c, -2 * s * along * w - d]))
        return along, change[0], w, change[1]

    start = (first, speed, 0, 0)
    exact = solve_ivp(rates, (0, until), start, rtol=1e-11, atol=1e-12).y[:, -1]
    errors = []
    for dt in (1e-2, 5e-3, 2.5e-3):
        corners = [(-1, -half), (1, -half), (1, half), (-1, half)]
        mesh = named(
            tmp_path / "bar.vtu", corners, "quad", [[0, 1, 2, 3]], lambda x: np.isclose(x[1], half)
        )
        bar = RigidSolid(mesh, mass=M, gravity=(0, -G), held=["x", "y"], name="bar")
        mass = tip(tmp_path, (first, half), (speed, 0.0))
        scene = Scene([mass, bar], [Contact(mass, "skin", (bar, "skin"), law)])
        history = scene.run(until=until, dt=dt)
        assert history.finished and not history.remarks
        assert abs(history["balance"][-1]) < 1e-6
        given = history["impact"][-1]
        errors.append([bar.velocity[2] - exact[3], bar.rotation - exact[2], given])
    assert np.abs(errors[-1]).max() < 2e-5
    assert (orders(errors) > 1.9).all()


def free_pair(dt, law, tmp_path, heap=False):
    """A box slides along a bar, both spin freely: changes of momenta and energy."""
    spin = 2.0

    def moves(x, y):
        return np.array([-spin * y, spin * x])

    low = [(-1, -0.1), (1, -0.1), (1, 0), (-1, 0)]
    mesh = named(tmp_path / "bar.vtu", low, "quad", [[0, 1, 2, 3]], upper_side)
    bar = RigidSolid(mesh, mass=3.0, velocity=moves(0, -0.05), spin=spin, name="bar")
    high = [(0.3, 0), (0.5, 0), (0.5, 0.1), (0.3, 0.1)]
    mesh = named(tmp_path / "box.vtu", high, "quad", [[0, 1, 2, 3]], upper_side)
    velocity = moves(0.4, 0.05) + np.array([0.5, 0.0])
    box = RigidSolid(mesh, mass=1.0, velocity=velocity, spin=spin, name="box")

    def momenta():
        angular = sum(
            b.mass * (b.place[0] * b.velocity[1] - b.place[1] * b.velocity[0])
            + b.inertia[0, 0] * b.velocity[2]
            for b in (bar, box)
        )
        linear = sum(b.mass * b.velocity[:2] for b in (bar, box))
        return np.array([*linear, angular])

    before = momenta()
    contact = Heap([bar, box], "skin", law) if heap else Contact(box, "skin", (bar, "skin"), law)
    history = Scene([bar, box], [contact]).run(until=0.3, dt=dt)
    assert history.finished and not history.remarks
    energy = history["kinetic"]
    return [*(momenta() - before), energy[-1] - energy[0]]


@pytest.mark.parametrize("heap", [False, True])
@pytest.mark.parametrize("law", ["velocity", "gap"])
def test_a_free_pair_keeps_its_momenta(law, heap, tmp_path):
    """The angular momentum was lost with the step, 1.8e-3 of it by steps of 10 ms."""
    coarse, fine = (free_pair(dt, law, tmp_path, heap) for dt in (1e-2, 5e-3))
    assert np.abs(coarse[:2]).max() < 1e-12 and np.abs(fine[:2]).max() < 1e-12
    assert abs(coarse[2]) < 1e-5 and abs(coarse[3]) < 5e-5
    assert abs(fine[2]) < abs(coarse[2]) / 3.8 and abs(fine[3]) < abs(coarse[3]) / 3.8


NEEDLE = np.array([[0, 0, 0], [0.02, 0, 0.05], [-0.01, 0.02, 0.05], [-0.01, -0.02, 0.05]])  # m


def needle(path, place, velocity, turn=None):
    """A mass in space that touches with one corner only, and does not turn; in a scene turned."""
    R = np.eye(3) if turn is None else turn
    mesh = named(path / "tip.vtu", (place + NEEDLE) @ R.T, "tetra", [[0, 1, 2, 3]])
    held = [f"turning about {axis}" for axis in "xyz"]
    given = {"gravity": R @ [0, 0, -G], "velocity": R @ velocity}
    return RigidSolid(mesh, mass=1.0, held=held, name="tip", **given)


def test_a_mass_goes_round_in_a_bowl(tmp_path):
    """At constant height, by v² = g R sin² a / cos a: in space."""
    angle = 0.7
    radius, speed = np.sin(angle), np.sqrt(G * np.sin(angle) ** 2 / np.cos(angle))
    until, errors = 0.5, []
    for dt in (1e-2, 5e-3, 2.5e-3):
        mass = needle(tmp_path, [radius, 0, -np.cos(angle)], (0, speed, 0))
        contact = Contact(mass, "skin", Sphere((0, 0, 0), 1.0, inside=True))
        history = Scene([mass], [contact]).run(until=until, dt=dt)
        assert history.finished and not history.remarks
        x = mass.place - NEEDLE.mean(axis=0)
        turned = speed / radius * until
        exact = radius * np.array([np.cos(turned), np.sin(turned)])
        errors.append(np.linalg.norm(x[:2] - exact))
        assert abs(x[2] + np.cos(angle)) < 2 * dt**2
    assert errors[-1] < 3e-4
    assert (orders(errors) > 1.9).all()


@pytest.mark.parametrize("theta", [0.5, 0.75, 1.0])
@pytest.mark.parametrize("law", ["velocity", "gap", Compliance(1e6, 1.0, 1e6)])
def test_friction_in_a_bowl_does_not_ask_how_the_scene_lies(law, theta, tmp_path):
    """By theta < 1 places differed by up to 3e-5 m, speeds by 7e-5 m/s: between the normal at the
    end and the mean one friction turned by axes and history. A mass that lands, too, and one that
    turns round."""
    bowl = Sphere((0, 0, 0), 1.0, inside=True)
    for place, velocity in (
        ((0.6, 0, -0.8), (0, 1.5, 0)),
        ((0.55, 0, -0.8), (0.2, 1.0, 0)),
        ((0.6, 0, -0.8), (0.8, 0.1, 0.6)),
    ):
        ends = []
        for axis in ((0, 0, 0), (0, 0, 0.7), (0.6, 0.6, 0.6)):
            R = rotation_matrix(np.array(axis))
            mass = needle(tmp_path, place, velocity, R)
            contact = Contact(mass, "skin", bowl, law, friction=0.2)
            scene = Scene([mass], [contact], ThetaScheme(theta), geometry="newton")
            history = scene.run(0.4, 2e-2)
            assert history.finished and history["friction"][-1] < -0.1
            ends.append(np.concatenate([R.T @ mass.place, R.T @ mass.velocity[:3]]))
        np.testing.assert_allclose(ends[1:], [ends[0]] * 2, rtol=0, atol=1e-9)


def test_tangents_turn_with_the_normals(tmp_path):
    """By the least rotation, in which what is across both normals stays: in UFL as in numpy."""
    mass = needle(tmp_path, [0.6, 0, -0.8], (0, 1.5, 0))
    contact = Contact(mass, "skin", Sphere((0, 0, 0), 1.0, inside=True), friction=0.2)
    scene = Scene([mass], [contact])
    for _ in range(3):
        list(scene.step(2e-2))
    e, k, at = contact.equations, contact.equations.fields, contact.status.argmax()
    normals = k.old_normal(), k.mean_normal(), k.normal.x.array.reshape(-1, 3)
    frames = [np.stack([n, *k.frame(n)[1]], axis=1)[at] for n in normals]
    axis = np.cross(normals[0], normals[2])[at]
    assert np.linalg.norm(axis) > 0.02
    for frame in frames:
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-14)
        np.testing.assert_allclose(frame @ axis, frames[-1] @ axis, atol=1e-15)
    for told, vectors, frame in (
        (k.start_jump_t, k.start_slip.x.array, frames[0]),
        (k.jump_t, e.values[: e.jumps], frames[2]),
    ):
        values = [
            at_points(contact.surface, PointExpression(t, contact.surface.scalars))[at]
            for t in told
        ]
        expected = frame[1:] @ vectors.reshape(-1, 3)[at]
        np.testing.assert_allclose(values, expected, rtol=1e-14)


def test_by_theta_1_forces_act_along_the_normal_of_the_end(tmp_path):
    mass = tip(tmp_path, (np.sin(0.5), -np.cos(0.5)), (-np.cos(0.5), -np.sin(0.5)))
    contact = Contact(mass, "skin", Circle((0, 0), 1.0, inside=True))
    scene = Scene([mass], [contact], ThetaScheme(1.0))
    for _ in range(5):
        list(scene.step(1e-2))
        at = contact.status > 0
        pushed, normal = contact.force[at][0], contact.normal[at][0]
        assert abs(pushed[0] * normal[1] - pushed[1] * normal[0]) < 1e-9 * np.hypot(*pushed)


def test_a_top_whose_tip_sticks_flies_in_whole_steps(tmp_path):
    """A flight was not solved again about where the top was put back, and halved for the error that
    this left: unequal steps, seven times the error in the tilt."""
    a = 0.5 * np.pi * np.arange(4)
    x = np.vstack([np.zeros(3), np.column_stack([0.05 * np.cos(a), 0.05 * np.sin(a), 0.1 + 0 * a])])
    cells, tilted = [[0, 1, 2, 3], [0, 1, 3, 4]], {"rotation": (0, 0.4, 0), "about": (0, 0, 0)}
    mesh = named(tmp_path / "top.vtu", x, "tetra", cells)
    axis, ends = np.array([np.sin(0.4), 0.0, np.cos(0.4)]), []
    for located in (True, False):
        top = RigidSolid(mesh, mass=0.5, gravity=(0, 0, -G), spin=400 * axis, **tilted)
        contact = Contact(top, "skin", HalfSpace((0, 0, 0), (0, 0, 1)), friction=5.0)
        history = Scene([top], [contact], locate_impacts=located).run(0.02, 1e-3)
        assert history.finished and not history.remarks and len(history.time) == 21
        ends.append(top.rotation)
    np.testing.assert_allclose(*ends, atol=1e-5)


def test_results_are_those_of_the_step_after_a_restart(tmp_path):
    def made():
        mass = tip(tmp_path, (np.sin(0.5), -np.cos(0.5)), (-np.cos(0.5), -np.sin(0.5)))
        hollow = Circle((0, 0), 1.0, inside=True)
        contact = Contact(mass, "skin", hollow, friction=0.3)
        return Scene([mass], [contact]), contact

    first, contact = made()
    for _ in range(7):
        list(first.step(1e-2))
    second, again = made()
    second.restore(first.state())
    np.testing.assert_array_equal(again.pressure, contact.pressure)
    np.testing.assert_array_equal(again.friction_traction, contact.friction_traction)
    for scene in (first, second):
        list(scene.step(1e-2))
    np.testing.assert_array_equal(again.force, contact.force)


@pytest.mark.parametrize("angle", [45, 90, 135, 170])
def test_at_an_edge_normals_turn_by_any_angle(angle, tmp_path):
    """A mass goes over the edge of a wedge; what its forces act along is always a direction."""
    slope = np.deg2rad(angle) / 2
    n = np.array([np.sin(slope), np.cos(slope)])
    wedge = LevelSet(lambda x, t: n[1] * x[1] + n[0] * abs(x[0]), dim=2)
    along = np.array([n[1], n[0]])
    mass = tip(tmp_path, -0.05 * along, 2.0 * along)
    contact = Contact(mass, "skin", wedge)
    history = Scene([mass], [contact]).run(until=0.1, dt=1e-2)
    assert history.finished
    assert np.isfinite(mass.velocity).all() and np.isfinite(contact.pressure).all()


def folded(angle, how):
    """A floor that goes on as a ramp, one wall."""
    c, s = float(np.cos(angle)), float(np.sin(angle))
    if how == "curve":
        return Curve([(-1, 0), (0, 0), (1, s / c)])
    return LevelSet(lambda x, t: ufl.min_value(x[1], c * x[1] - s * x[0]), dim=2)


@pytest.mark.parametrize("how", ["curve", "level set"])
@pytest.mark.parametrize("angle", [10, 30, 45, 60, 80])
@pytest.mark.parametrize(
    ("law", "located"), [("velocity", False), ("velocity", True), ("e", False)]
)
def test_a_fold_is_no_turn(how, angle, law, located, tmp_path):
    """What comes along a floor strikes the ramp, though both are one wall: a mean normal would let
    it go up as fast as it came."""
    angle, speed = np.deg2rad(angle), 2.0
    mass = tip(tmp_path, (-0.0987, 0.0), (speed, 0.0), gravity=0.0)
    contact = Contact(mass, "skin", folded(angle, how), Restitution(0.0) if law == "e" else law)
    scene = Scene([mass], [contact], locate_impacts=located)
    history = scene.run(until=0.1, dt=5e-3)
    assert history.finished
    along = np.array([np.cos(angle), np.sin(angle)])
    np.testing.assert_allclose(mass.velocity[:2], speed * along[0] * along, atol=1e-9)
    lost = -0.5 * mass.mass * (speed * along[1]) ** 2
    assert history["impact"][-1] == pytest.approx(lost, rel=1e-9)
