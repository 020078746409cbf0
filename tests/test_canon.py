# SPDX-License-Identifier: LGPL-3.0-or-later
"""Canonical scenes of contact against exact numbers: impact, stick and slip, rolling, ironing."""

from __future__ import annotations

from math import atan, pi, sqrt

import numpy as np
import pytest
from scenes import FLOOR, FLOOR_3D, G, check_energies, rectangle
from scipy.integrate import trapezoid
from test_demos import DEMOS, load
from test_shapes import disc

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    LevelSet,
    QuasiStatic,
    RigidSolid,
    Scene,
    StaticKinetic,
    ThetaScheme,
    mesh_from_gmsh,
)
from fenicsx_contact.references.impact import HertzImpact, ObliqueImpact

MESHES = DEMOS.parent / "meshes"

# -- the references -----------------------------------------------------------------------------


def test_hertz_impact():
    """2.87 (m²/(R E*² v))^(1/5), and the energy of the deepest approach; half of the impulse 2 m v
    until then."""
    impact = HertzImpact(mass=3.0, modulus=7.0, radius=0.5, speed=0.2)
    scale = (3.0**2 / (0.5 * 7.0**2 * 0.2)) ** 0.2
    assert impact.duration == pytest.approx(2.87 * scale, rel=1e-3)
    assert 0.4 * impact.peak_force * impact.approach == pytest.approx(3.0 * 0.2**2 / 2, rel=1e-12)
    time, force = impact.course()
    impulse = trapezoid(force, time) * impact.duration * impact.peak_force
    assert impulse == pytest.approx(2 * 3.0 * 0.2, rel=1e-4)
    again = HertzImpact.of_contact_radius(impact.contact_radius, 3.0, 7.0, 0.5)
    assert again.speed == pytest.approx(0.2, rel=1e-12)


@pytest.mark.parametrize("nu", [0.0, 0.5])
def test_oblique_impact(nu):
    """From psi = 4 chi - 1 on all slips, and no sooner; before that springs give back some of what
    they took, and no more; friction counts in psi alone."""
    rough, smooth = ObliqueImpact(nu, 0.5), ObliqueImpact(nu, 0.05)
    limit = 4 * rough.chi - 1

    def after(psi, impact=rough):
        return impact.psi(impact.rebound(psi * impact.friction / impact.stiffness_ratio))

    assert after(limit) == pytest.approx(limit - 4 * rough.chi, abs=1e-6)
    assert after(0.9 * limit) > 0.9 * limit - 4 * rough.chi + 1e-3
    for psi in (0.5, 2.0):
        assert abs(after(psi)) < psi
        assert after(psi, smooth) == pytest.approx(after(psi), abs=1e-9)


# -- belt and block -----------------------------------------------------------------------------


def belt(dt, k=100.0, N=10.0, m=1.0, V=0.1, static=0.5, kinetic=0.2):
    """A rigid block on a spring on a belt: when it breaks away and is caught, and its way."""
    block = RigidSolid(
        rectangle((1, 1), (0.2, 0.1)),
        mass=m,
        gravity=(0, -N / m),
        springs={(0.0, 0.05): (k, 0.0)},
        velocity=(V, 0.0),
        held=["turning"],
    )
    moving = LevelSet(lambda x, t: x[1], 2, velocity=lambda x, t: (V, 0.0))
    contact = Contact(block, "base", moving, friction=StaticKinetic(static, kinetic), name="c")
    start = block.place[0]
    probes = {"u": lambda: block.place[0] - start, "v": lambda: block.velocity[0]}
    history = Scene([block], [contact]).run(static * N / k / V + 1.5, dt, probes=probes)
    assert history.finished, history.reason
    # it slips back only; friction turns round as it is caught, which may take the step after
    ahead = history["v"] - V > 1e-9
    assert not (ahead[1:] & ahead[:-1]).any()
    sticks = history["v"] - V > -1e-9
    turns = history.time[1:][np.diff(sticks.astype(int)) != 0]
    return turns, history["u"]


@pytest.mark.parametrize(
    ("dt", "share"), [(8e-3, 0.025), pytest.param(1e-3, 0.004, marks=pytest.mark.long)]
)
def test_stick_and_slip_times_on_a_belt(dt, share):
    """It sticks for 2 A/V and slips for 2 (pi - atan(A w/V))/w, w² = k/m, A = (mu_s - mu_k) N/k,
    time after time. Being caught is rounded up to a step; that of breaking away ends at a speed
    that is not yet another, and the next is the first that tells."""
    omega, swing, V = 10.0, 0.03, 0.1
    slip, stick = 2 * (pi - atan(swing * omega / V)) / omega, 2 * swing / V
    exact = 0.05 / V + np.cumsum([0, slip, stick, slip])  # first carried to mu_s N/k
    turns, u = belt(dt)
    late = turns - exact
    assert (late >= -1e-9).all() and (late < dt * np.array([2, 3, 5, 6])).all(), late
    np.testing.assert_allclose(turns, exact, rtol=share)
    highest = 0.02 + sqrt(swing**2 + (V / omega) ** 2)
    assert 0 <= u.max() - highest < V * late[0]  # carried so much farther


# -- a disc on a slope --------------------------------------------------------------------------


@pytest.mark.long
def test_a_disc_of_many_corners_rolls_down_a_slope():
    """With 2/3 g sin a, the better the rounder it is."""
    slope, errors = 0.1, []
    for corners in (180, 720):
        solid = RigidSolid(disc(corners), mass=1.0, gravity=(G * np.sin(slope), -G * np.cos(slope)))
        contact = Contact(solid, "rim", FLOOR, friction=0.3)
        history = Scene([solid], [contact], ThetaScheme(1.0)).run(0.5, 1e-2)
        assert history.finished, history.reason
        errors.append(solid.velocity[0] / 0.5 / (2 / 3 * G * np.sin(slope)) - 1)
        assert solid.velocity[0] == pytest.approx(-0.1 * solid.velocity[2], rel=1e-3)
    assert abs(errors[1]) < 0.005 and abs(errors[1]) < 0.5 * abs(errors[0]), errors


# -- spheres that strike ------------------------------------------------------------------------


@pytest.mark.second
@pytest.mark.parametrize("law", ["velocity", "gap"])
def test_slip_that_grows_from_the_edge_takes_no_shorter_steps(law):
    """A coarse ball strikes obliquely: many points slip together, and yield more than each alone.
    Augmented for that, Newton's method would go round in every other step."""
    mesh = mesh_from_gmsh(MESHES / "half_ball.geo", h=0.05, half_width=0.12, coarse=0.4)
    exact = HertzImpact.of_contact_radius(0.1, 4 / 3 * pi, 1 / (1 - 0.49**2), 1.0)
    ball = ElasticSolid(
        mesh,
        youngs_modulus=1.0,
        poisson_ratio=0.49,
        density=1.0,
        prescribed={"y0": (None, 0.0, None)},
        velocity=lambda x: exact.speed * np.array([[0.6], [0.0], [-1.0]]) + 0 * x,
    )
    contact = Contact(ball, "near", FLOOR_3D, law, friction=0.2, name="c")
    scene = Scene([ball], [contact])
    history = scene.run(1.05 * exact.duration, exact.duration / 20)
    assert history.finished and not history.remarks
    assert history["c.slipping"].max() > 5
    check_energies(history, together=True, slack=1e-4 * history["kinetic"][0])


@pytest.mark.long
@pytest.mark.parametrize("psi", [1.0, 2.0, 3.0, 5.0])
def test_oblique_impact_of_a_ball(psi):
    """Tangential speed, spin and angle of rebound are those of Maw, Barber and Fawcett."""
    found = load("elastic_impact").oblique(psi, small=0.003, n=4, steps=60)
    assert found["steps_shortened"] == 0
    assert abs(found["tangential_error"]) < 0.02 and abs(found["spin_error"]) < 0.02
    assert found["rebound_degree"] == pytest.approx(found["rebound_degree_exact"], rel=0.02)


def test_rubber_between_plates_takes_few_iterations():
    """Nearly incompressible: a point alone among held ones is stopped by the volume of its
    elements, 25 times as hard as with its neighbours. Augmented for that, 99 iterations and a
    shorter step."""
    history = load("canon").o_ring(0.1, 0.04, 2)
    assert history["newton"].max() <= 12 and not history.remarks


# -- an arch, ironing in space ------------------------------------------------------------------


@pytest.mark.long
def test_an_arch_of_thirty_blocks_falls_where_statics_says():
    """It stands 1 % below the tilt of its limit analysis, and falls 1 % above."""
    found = load("rigid_shapes").tilted(30)
    assert found["tilt_degree"] == pytest.approx(8.289, abs=1e-3)
    assert found["below"] < 1e-9 and found["above"] > 1e-4


def ironed(space, steps, n=2):
    """Forces on the die of demos/ironing.py in the plane or, between rollers, 0.5 wide in space."""
    demo, wide = load("ironing"), {"width": 0.5, "n_width": 1} if space else {}
    meshes = [mesh_from_gmsh(MESHES / f"{name}.geo", n=n, **wide) for name in ("die", "slab")]

    def motion(t):
        along = 0.1 * max(0.0, t - 5)
        return (along, -demo.DEPTH * min(t / 5, 1.0), 0.0)[: 3 if space else 2]

    rollers = {side: (None, None, 0.0) for side in ("front", "back")} if space else {}
    die = demo.solid("neo-Hookean", meshes[0], 10.0, prescribed={"top": motion, **rollers})
    held = {"fixed": ["bottom"], "prescribed": rollers, "name": "slab"}
    slab = demo.solid("neo-Hookean", meshes[1], 1.0, **held)
    contact = Contact(die, "bottom", (slab, "top"), "gap", friction=0.3, name="c")
    history = Scene([die, slab], [contact], QuasiStatic()).run(5.0 + steps, 1.0)
    assert history.finished, history.reason
    return np.array([history["c.force_x"], history["c.force_y"]])


@pytest.mark.parametrize(
    "steps",
    [pytest.param(2, marks=pytest.mark.second), pytest.param(15, marks=pytest.mark.long)],
)
def test_ironing_in_space_between_rollers_is_that_in_the_plane(steps):
    plane, space = ironed(False, steps), ironed(True, steps) / 0.5
    assert plane[1, -1] > 0.1 and abs(plane[0, -1]) > 0.2 * plane[1, -1]
    np.testing.assert_allclose(space, plane, rtol=0, atol=1e-9 * plane[1].max())
