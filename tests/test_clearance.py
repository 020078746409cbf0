# SPDX-License-Identifier: LGPL-3.0-or-later
"""A clearance that is given in place of what the meshes say, and starts that overlap."""

from __future__ import annotations

import numpy as np
import pytest
from corpus_meshes import mapped, moved
from scenes import rates, rectangle

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    InputError,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    Velocity,
    neo_hookean,
)

E, NU, INNER, SEAT, OUTER = 2.1e11, 0.3, 0.05, 0.1, 0.2  # Pa, 1, m


def quarter(inside, outside, n, names):
    """A quarter of a ring."""

    def place(s, t):
        r, angle = inside + (outside - inside) * s, np.pi / 2 * t
        return r * np.cos(angle), r * np.sin(angle)

    return mapped(n, place, (*names, "bottom", "side"))


def fit(n, interference, given=True, law="gap"):
    """Rings of which one is too large for the other, pressed by that alone; meshes do not match."""
    rollers = {"bottom": (None, 0), "side": (0, None)}
    common = {"youngs_modulus": E, "poisson_ratio": NU, "density": 1.0, "prescribed": rollers}
    meshes = [
        quarter(INNER, SEAT + interference, (n, 2 * n), ("bore", "seat")),
        quarter(SEAT, OUTER, (n, 3 * n), ("hole", "rim")),
    ]
    shaft, hub = (ElasticSolid(m, name=name, **common) for m, name in zip(meshes, ("a", "b")))
    clearance = -interference if given else None
    contact = Contact(shaft, "seat", (hub, "hole"), law, clearance=clearance, name="fit")
    history = Scene([shaft, hub], [contact], QuasiStatic()).run(1, 1)
    assert history.finished, history.reason
    return contact, history


def lame(interference):
    """Pressure of a fit in plane strain (Timoshenko and Goodier, Theory of Elasticity, 28)."""
    plane, lateral = E / (1 - NU**2), NU / (1 - NU)
    hub = (OUTER**2 + SEAT**2) / (OUTER**2 - SEAT**2) + lateral
    shaft = (SEAT**2 + INNER**2) / (SEAT**2 - INNER**2) - lateral
    return interference * plane / SEAT / (hub + shaft)


@pytest.mark.parametrize("interference", [1e-6, 5e-5])
def test_interference_fit(interference):
    """Chords of the coarse meshes lie 2e-4 m off their circles, many times what is pressed."""
    errors = []
    for n in (4, 8, 16):
        contact, history = fit(n, interference)
        assert not history.remarks
        pressure, area = contact.pressure, contact.surface.area
        errors.append(area @ pressure / area.sum() / lame(interference) - 1)
        assert np.abs(pressure / lame(interference) - 1).max() < 0.2 / n
    assert errors[0] < 2e-3 and abs(errors[-1]) < 2e-4, errors
    # Lame's is of no deformation: what is 5e-5 too large ends 2e-4 below it
    order = rates(np.abs(np.diff(errors)))
    assert (order > 1.7).all(), order


def test_as_meshed_such_a_fit_is_loose():
    contact, _ = fit(4, 1e-5, given=False)
    assert not contact.pressure.any() and contact.gap.max() < 0


def test_a_velocity_law_that_starts_inside_says_so():
    contact, history = fit(4, 5e-5, law="velocity")
    assert not contact.pressure.any()
    assert contact.gap == pytest.approx(5e-5, rel=1e-9)
    [(time, remark)] = history.remarks
    assert time == 0 and "'fit' starts 5e-05 m inside, and 'velocity' keeps it there" in remark
    contact, history = fit(4, 5e-5, law=Velocity(drift_correction=1.0))
    assert not history.remarks
    assert contact.pressure == pytest.approx(lame(5e-5), rel=0.05)


def test_what_is_inside_is_told_once():
    """Not again when the scene runs on, whose own steps may have left more."""
    block = RigidSolid(rectangle((1, 1), (1.0, 1.0)), mass=1.0)
    floor = HalfSpace((0, 1e-4), (0, 1))
    scene = Scene([block], [Contact(block, "base", floor, name="floor")])
    [(time, remark)] = scene.run(until=0.1, dt=0.1).remarks
    assert time == 0 and "'floor' starts 0.0001 m inside" in remark
    assert not scene.run(until=0.2, dt=0.1).remarks


@pytest.mark.parametrize("law", ["gap", "lagrange"])
def test_what_a_law_of_positions_throws_out_is_told(law):
    """A block left at twice its depth by the step, 19.8 m/s, "finished", without a word."""
    depth, dt = 9.9e-4, 1e-4
    block = RigidSolid(rectangle((1, 1), (1.0, 0.1)), mass=1.0)
    scene = Scene([block], [Contact(block, "base", HalfSpace((0, depth), (0, 1)), law, name="c")])
    history = scene.run(until=5 * dt, dt=dt)
    assert block.velocity[1] == pytest.approx(2 * depth / dt)
    assert history["impact"][-1] == pytest.approx(block.velocity[1] ** 2 / 2)
    [(time, remark)] = history.remarks
    assert time == 0 and f"'c' starts {depth:g} m inside, and {law!r} takes it back" in remark


def test_what_means_do_not_see_is_not_said_to_start_inside():
    """After statics by "gap" a law of velocities said that "gap" would take back what is deep
    between the nodes of both meshes, where gaps, which are means, are none."""
    soft = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
    low = moved(rectangle((7, 3), (2.0, 0.5)), 0.0, -0.5)
    solids = [
        ElasticSolid(rectangle((6, 3), (1.0, 0.5)), tractions={"top": (2e3, -1e4)}, **soft),
        ElasticSolid(low, fixed=["base"], name="low", **soft),
    ]
    for law, scheme, until in (("gap", QuasiStatic(), 1.0), ("velocity", ThetaScheme(), 4e-3)):
        contact = Contact(solids[0], "base", (solids[1], "top"), law, friction=0.3)
        assert law == "gap" or contact.depth() > 1e4 * contact.tolerance > 0
        history = Scene(solids, [contact], scheme).run(until, until / 2)
        assert history.finished and not history.remarks


def blocks(clearance):
    upper = RigidSolid(rectangle((4, 1), (1.0, 1.0)), mass=1.0, name="upper")
    lower = RigidSolid(moved(rectangle((3, 1), (1.4, 1.0)), 0, -1), mass=1.0, name="lower")
    return upper, Contact(upper, "base", (lower, "top"), clearance=clearance)


@pytest.mark.parametrize("slope", [0.0, 0.1])
def test_of_the_place(slope):
    _, contact = blocks(lambda x: 0.5 + slope * x[0])
    assert contact.gap == pytest.approx(-0.5 - slope * contact.surface.points[:, 0], abs=1e-14)


def test_they_meet_when_they_have_crossed_it():
    mesh = rectangle((4, 1), (1.0, 1.0))
    upper = RigidSolid(mesh, mass=1.0, velocity=(0, -1), name="upper")
    slab = ElasticSolid(
        moved(rectangle((3, 1), (1.4, 1.0)), 0, -1),
        youngs_modulus=1e12,
        poisson_ratio=0.3,
        density=1e9,
        fixed=["base"],
        name="slab",
    )
    contact = Contact(upper, "base", (slab, "top"), clearance=0.25, name="face")
    scene = Scene([upper, slab], [contact])
    history = scene.run(0.2, 0.01)
    assert not history["face.force_y"].any()
    assert contact.gap == pytest.approx(-0.05, abs=1e-12)
    assert scene.run(0.3, 0.01)["face.force_y"].any()


@pytest.mark.parametrize(
    ("clearance", "problem"),
    [
        (np.nan, "clearance = nan: must be a finite number"),
        ("loose", "clearance = 'loose': must be a finite number"),
        (lambda x: x, "must be 5 finite numbers"),
        (lambda x: np.nan * x[0], "must be 5 finite numbers"),
        (lambda x: 1 / 0, "raises ZeroDivisionError"),
    ],
)
def test_refused(clearance, problem):
    with pytest.raises(InputError, match=problem):
        blocks(clearance)


def test_an_obstacle_has_none():
    upper = RigidSolid(rectangle(), mass=1.0)
    with pytest.raises(InputError, match=r"clearance = 0.1: .* move the obstacle instead"):
        Contact(upper, "base", HalfSpace((0, 0), (0, 1)), clearance=0.1)


@pytest.mark.parametrize("overlap", [0.3, 0.6, 0.9])
def test_what_fits_though_its_meshes_end_far_apart_stays(overlap):
    """Partners were sought as far as facets are large, from surfaces that touch when their meshes
    are this far apart: in the third step none was found, and the run stopped."""

    def block(up, cells, held, name):
        mesh = rectangle(cells, (1.0, 1.0))
        mesh.mesh.geometry.x[:, 1] += up
        return HyperelasticSolid(
            mesh, energy=neo_hookean(1e6, 0.3), density=1.0, fixed=[held], name=name
        )

    low, up = block(0.0, (3, 3), "base", "low"), block(1.0, (4, 4), "top", "up")
    contact = Contact(up, "base", (low, "top"), "gap", clearance=-overlap, name="fit")
    scene = Scene([low, up], [contact], QuasiStatic(), deepest=1.0)
    history = scene.run(until=1.0, dt=0.1)
    assert history.finished, history.reason
    force = history["fit.force_y"]
    np.testing.assert_allclose(force[2:], force[1], rtol=1e-6)
    assert force[1] > 1e5 * overlap and history["newton"][4:].max() <= 2
