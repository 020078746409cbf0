# SPDX-License-Identifier: LGPL-3.0-or-later
"""Interface laws where their numbers are extreme, and what they read or remember is none."""

from __future__ import annotations

import numpy as np
import pytest
import ufl
from dolfinx import fem
from scenes import FLOOR, G, rectangle

from fenicsx_contact import (
    Archard,
    Compliance,
    Contact,
    ElasticSolid,
    InputError,
    QuasiStatic,
    RateState,
    RigidSolid,
    Scene,
    ThetaScheme,
)
from fenicsx_contact.base import compat


def thrown(friction, formulation="velocity", until=0.1, dt=1e-3, theta=0.5):
    """The speed that a block is left with that begins with 1 m/s."""
    mesh = rectangle(size=(1.0, 0.1))
    if not isinstance(formulation, str):  # springs bear its weight
        mesh.mesh.geometry.x[:, 1] -= 10 * G / 1e7
    block = RigidSolid(mesh, mass=10.0, gravity=(0, -G), velocity=(1, 0))
    contact = Contact(block, "base", FLOOR, formulation, friction=friction)
    scene = Scene([block], [contact], ThetaScheme(theta), deepest=1.0)
    history = scene.run(until, dt)
    assert history.finished, history.reason
    assert not history.remarks
    return block.velocity[0], contact


@pytest.mark.parametrize("formulation", ["velocity", Compliance(1e7, 1.0, 1e9)])
@pytest.mark.parametrize("a", [1e-2, 1.6e-3, 1e-4, 1e-6])
def test_a_small_direct_effect_is_coulombs_friction(a, formulation):
    """exp(mu/a) is no number from mu/a = 710 on, and its square from 355."""
    speed, _ = thrown(RateState(a, a, 1.0, 0.6, 1.0), formulation)
    assert speed == pytest.approx(1 - 0.6 * G * 0.1, abs=0.4 * a + 1e-5)


@pytest.mark.parametrize("theta", [0.5, 1.0])
@pytest.mark.parametrize("law", ["ageing", "slip"])
@pytest.mark.parametrize("D", [1e-4, 6e-6, 1e-9])
def test_contacts_that_are_renewed_often_in_a_step(D, law, theta):
    """By slips of many D their age is D/V: exp(V dt/D) is no number."""
    dt = 1e-2
    speed, contact = thrown(RateState(1e-2, 1e-2, D, 0.6, 1.0, law=law), dt=dt, theta=theta)
    assert speed == pytest.approx(1 - 0.6 * G * 0.1, rel=1e-4)
    middle = speed + (1 - theta) * 0.6 * G * dt
    np.testing.assert_allclose(contact.memory.values["theta"], D / middle, rtol=0.03)


@pytest.mark.parametrize("formulation", ["gap", Compliance(1e8, 1.0, 1e8)])
def test_wear_about_an_axis_on_which_a_point_has_no_area(formulation):
    """A disc of second degree that is pressed and grows on the floor."""
    mesh = rectangle((4, 2), (1.0, 0.5))
    mesh.mesh.geometry.x[:, 0] += 0.5
    disc = ElasticSolid(
        mesh, youngs_modulus=1e6, poisson_ratio=0.0, density=1.0, plane="axisymmetric", degree=2,
        prescribed={
            "top": lambda x, t: np.stack(
                [0.02 * x[0] * max(t - 1, 0), -0.005 * min(t, 1) + 0 * x[0]]
            )
        },
    )  # fmt: skip
    contact = Contact(disc, "base", FLOOR, formulation, friction=Archard(0.3, 1e-3, 1e6), name="c")
    history = Scene([disc], [contact], QuasiStatic()).run(2.0, 0.1)
    assert history.finished, history.reason
    soft = 0.0 if formulation == "gap" else 1e-8
    exact = np.pi * 0.005 / (0.5 / 1e6 + soft)
    assert history["c.force_y"][-1] == pytest.approx(exact, rel=1e-4)
    worn = contact.memory.values["worn"]
    assert np.isfinite(worn).all()
    assert worn[contact.surface.points[:, 0] > 0.2].min() > 0


class Overflows:
    """A law of a user's own whose memory becomes no number."""

    def bound(self, k, pressure, S):
        grown = k.state("grown", 1.0, lambda old, time: ufl.exp(1e3 * old))
        return 0.1 * pressure + 0 * grown

    def describe(self):
        return "grows"


def test_what_is_remembered_and_no_number_stops_the_run():
    block = RigidSolid(rectangle(), mass=1.0, gravity=(0, -G))
    contact = Contact(block, "base", FLOOR, friction=Overflows())
    history = Scene([block], [contact]).run(0.01, 1e-3)
    assert not history.finished
    assert "what a law remembers as 'grown' is not finite; at [" in history.reason


@pytest.mark.parametrize("what", ["function", "coordinate"])
def test_what_is_painted_on_the_master_is_no_field_of_the_slave(what):
    """It was read at the reference places of the slave, whatever it slid on."""
    below, above = rectangle((5, 2), (2.0, 0.3)), rectangle((3, 2), (0.4, 0.3))
    above.mesh.geometry.x[:, 1] += 0.3
    floor = ElasticSolid(
        below, youngs_modulus=1e9, poisson_ratio=0.3, density=1e3, name="lo", fixed=["base"]
    )
    block = RigidSolid(above, mass=100.0, gravity=(0, -G), name="up")

    def painted(mesh):
        if what == "coordinate":
            return 0.1 + 0.4 * (ufl.SpatialCoordinate(mesh.mesh)[0] + 1)
        field = fem.Function(compat.lagrange_space(mesh.mesh))
        field.interpolate(lambda x: 0.1 + 0.4 * (x[0] + 1))
        return field

    Contact(block, "base", (floor, "top"), friction=painted(above))
    with pytest.raises(InputError, match=r"friction: reads .* mesh of the master 'lo'; must"):
        Contact(block, "base", (floor, "top"), friction=painted(below))
    number = fem.Constant(below.mesh, 0.3)  # is the same everywhere
    Contact(block, "base", (floor, "top"), friction=number)
