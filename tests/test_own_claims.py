# SPDX-License-Identifier: LGPL-3.0-or-later
"""What own parts say of themselves is held against what they do."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
import pytest
import ufl
from scenes import FLOOR, G, rectangle
from test_beam import axis_mesh
from test_own_parts import PointMass, PointMassTrace

from fenicsx_contact import (
    BeamSolid,
    Contact,
    ElasticSolid,
    EnergyMomentum,
    GeneralisedAlpha,
    HalfSpace,
    InputError,
    QuasiStatic,
    RigidSolid,
    Scene,
    Section,
    ThetaScheme,
)
from fenicsx_contact.gradients import Centre, Gravity, adjoints, tangents
from fenicsx_contact.rods.drive import AxialForce
from fenicsx_contact.theory.consistent import consistent
from fenicsx_contact.theory.weak_form import weak_form


def rigid(kind=RigidSolid, **others):
    mesh = rectangle((1, 1), (0.2, 0.2))
    return kind(mesh, mass=2.0, gravity=(0, -G), name="block", **others)


def changed(name, value):
    """A theta-scheme of one's own of which a member is another."""
    body = {name: value if callable(value) else property(lambda self: value)}
    return dataclass(frozen=True)(type("Own", (ThetaScheme,), body))(0.5)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("linear_weights", (0.0, 0.5)),
        ("linear_weights", (0.5, 1.0)),
        ("force_points", [(0.5, 2.0)]),
        ("force_points", [(1.0, 1.0)]),
        ("load_points", [(0.5, 2.0)]),
        ("position_rate", 1.0),
        ("inertia", 0.5),
        ("increment", lambda self, dt, old, new, memory: 2 * dt * (0.5 * old + 0.5 * new)),
        ("increment", lambda self, dt, old, new, memory: dt * old * np.sign(old * new)),
    ],
)
def test_a_scheme_whose_members_disagree_is_refused(name, value):
    """Bodies fell at half the acceleration, or upwards, and the books were right."""
    with pytest.raises(InputError, match=r"scheme = .*must be"):
        Scene([rigid()], [], changed(name, value))


@pytest.mark.parametrize(
    "scheme",
    [
        *(ThetaScheme(theta) for theta in (0.5, 0.7, 1.0)),
        *(GeneralisedAlpha(radius) for radius in (0.0, 0.8, 1.0)),
        QuasiStatic(),
        EnergyMomentum(),
        changed("force_points", [(0.0, 0.5), (1.0, 0.5)]),
    ],
    ids=repr,
)
def test_schemes_agree_with_themselves(scheme):
    assert consistent(scheme) is scheme


@pytest.mark.parametrize(
    ("alpha", "beta", "said"),
    [(-20.0, 0.0, "alpha = -20"), (0.0, -1e-3, "beta"), ("1", 0.0, "alpha")],
)
def test_a_damping_of_ones_own_damps(alpha, beta, said):
    """3e-4 J became 1e16 J."""

    @dataclass(frozen=True)
    class Own:
        alpha: float
        beta: float

    with pytest.raises(InputError, match=rf"damping.{said}"):
        ElasticSolid(
            rectangle((1, 1), (0.2, 0.2)),
            youngs_modulus=1e6,
            poisson_ratio=0.3,
            density=1e3,
            damping=Own(alpha, beta),
        )


@pytest.mark.parametrize("law", ["velocity", "gap"])
def test_an_obstacle_whose_arguments_nobody_knows_may_move(law):
    """A lift told by functions of ``*places`` stood still for the law, 0.1 m inside the block."""

    class Lift:
        dim, flat = 2, True

        def distance(self, *places):
            points, time = places
            return points[:, 1] - 0.1 * time

        def normals(self, points):
            return np.tile([0.0, 1.0], (len(points), 1))

    block = rigid(velocity=(0.0, 0.1))
    history = Scene([block], [Contact(block, "base", Lift(), law, name="lift")]).run(1.0, 0.02)
    assert history.finished
    assert block.place[1] - 0.1 == pytest.approx(0.1, abs=1e-9)


@pytest.mark.parametrize("way", [tangents, adjoints])
def test_derivatives_of_a_solid_of_ones_own_are_refused(way):
    """They were those of the class that it is made from: 0.3 for 0.23, without a word."""

    class Dragged(RigidSolid):
        def accept(self, step):
            super().accept(step)

    block = rigid(Dragged)
    scene = Scene([block], [Contact(block, "base", FLOOR, friction=0.3)])
    asked = {"g": Gravity(block, (1.0, 0.0))}, {"x": Centre(block, (1.0, 0.0))}
    with pytest.raises(InputError, match=r"'block' is of a class of your own, which has .*accept"):
        way(scene, 0.1, 0.05, *asked)


def test_an_obstacle_that_asks_for_no_time_stands_still():
    scene = Scene([block := rigid()], [Contact(block, "base", HalfSpace((0, 0), (0, 1)))])
    assert not scene.contacts[0].coupling.driven


@pytest.mark.parametrize(
    ("kind", "reason"),
    [("listed", "finished"), ("late", r"force 'brake'\(0.2.*acts at 0"), ("heavy", "added_mass")],
)
def test_what_drives_a_beam_is_asked_for_where_it_is_listed(kind, reason):
    """A brake that was listed from 0.2 m on was never taken; negative masses fell, too."""

    class Law:
        prescribed = stop = None

        def check(self, mass, gravity, held):
            pass

        def added_mass(self, travel):
            return -5.0 if kind == "heavy" else 0.0

        def forces(self, travel, speed, mass, gravity, dt):
            yield AxialForce("spring", 100 * (1 - travel), 0.0, -100.0)
            if kind != "late" or travel > 0.2:
                yield AxialForce("brake", -300.0 if travel > 0.2 else 0.0, at=0.0)

    mesh = axis_mesh((0, 0), (0, 1), all=(1.0, 4))
    beam = BeamSolid(mesh, Section(mass=4.0, bending=70.0), law=Law())
    history = Scene([beam], [], allow_free=True).run(0.2, 1e-3, progress=False)
    assert re.search(reason, history.reason)
    if kind == "listed":
        assert beam.travel == pytest.approx(0.27264, abs=1e-4)


def test_a_law_of_velocities_of_ones_own_does_not_take_back_what_starts_inside():
    """Unless it says so: it was believed to, and nothing was remarked."""

    class Own:
        name, multipliers, percussive, at_points = "own", True, True, False
        points, gap_share = None, 0.0

        def form(self, k):
            return weak_form(k, k.jump_n - ufl.max_value(-k.gap, 0.0) / k.horizon)

        def limit(self, data):
            return np.maximum(-data.gap, 0.0) / data.horizon

    block = rigid()
    block.mesh.mesh.geometry.x[:, 1] -= 1e-4
    block = RigidSolid(block.mesh, mass=2.0, gravity=(0, -G), name="block")
    history = Scene([block], [Contact(block, "base", FLOOR, Own(), name="c")]).run(0.02, 0.01)
    assert history.finished
    assert any("starts 0.0001 m inside" in text for _, text in history.remarks)


class Twice(PointMassTrace):
    def mean_jump(self, velocity):
        return 2 * self.J @ velocity


class Wrong(PointMass):
    """It tells twice the work of what moves it, or a jump on which nothing works."""

    def works(self, step):
        momentum, acting, *others = super().works(step)
        return momentum, acting * self.factor, *others

    def trace(self, *surface):
        seen = super().trace(*surface)
        return Twice(self, seen.points) if self.doubled else seen


@pytest.mark.parametrize(("factor", "doubled"), [(1.0, False), (2.0, False), (1.0, True)])
def test_books_that_do_not_add_up_are_told(factor, doubled):
    """The column "balance" alone had seen it, and nobody that."""
    solid = Wrong(rectangle((2, 1)), 10.0, 5.0, (0, -G), (2.0, 0.0))
    solid.factor, solid.doubled = factor, doubled
    contact = Contact(solid, "base", FLOOR, friction=0.2, name="c")
    history = Scene([solid], [contact]).run(0.05, 0.01)
    assert history.finished
    told = [text for _, text in history.remarks if text.startswith("the energy balance leaves")]
    assert len(told) == (factor != 1 or doubled)
