# SPDX-License-Identifier: LGPL-3.0-or-later
"""One test for each trap of the formulation that bit somebody in an experiment."""

import numpy as np
import pytest
import ufl
from scenes import rectangle

from fenicsx_contact import (
    VELOCITY,
    Circle,
    Contact,
    HalfSpace,
    HyperelasticSolid,
    Newton,
    Printed,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    Velocity,
    st_venant_kirchhoff,
)
from fenicsx_contact.base import compat
from fenicsx_contact.contact.surface import Surface
from fenicsx_contact.solve import sweeps
from fenicsx_contact.solve.newton import NotConverged
from fenicsx_contact.theory.laws import ball_projection

FLOOR = HalfSpace((0, 0), (0, 1))


def dropped(height, *, mesh=None, friction=0.0, theta=1.0, formulation=VELOCITY, **solid):
    """A rigid block of 10 kg, its base at a height over the floor."""
    block = RigidSolid(mesh or rectangle(), mass=10.0, **{"gravity": (0, -9.81), **solid})
    floor = HalfSpace((0, -height), (0, 1))
    contact = Contact(block, "base", floor, formulation, friction)
    return Scene([block], [contact], ThetaScheme(theta))


def test_1_closing_within_a_step_has_a_solution():
    """Su from a prediction: the step in which a point closes converges, and arrests it."""
    scene = dropped(0.01)
    history = scene.run(0.1, 1.7e-3)
    assert history.finished and not history.remarks
    assert history["geometry"].max() <= 3
    assert abs(history["kinetic"][-1]) < 1e-20


@pytest.mark.parametrize("kappa", [0.0, 0.3])
def test_2_drift_is_bounded_and_can_be_made_to_decay(kappa):
    """As printed, theta = 1/2 catches a falling block up to half a step's way too deep."""
    deepest = 0.0
    for height in (0.0101, 0.0103, 0.0105, 0.0107):
        scene = dropped(height, theta=0.5, formulation=Printed(drift_correction=kappa))
        history = scene.run(0.2, 1e-3)
        depth = history["rigid.base.penetration"]
        assert depth.max() <= 0.5 * np.sqrt(2 * 9.81 * height) * 1e-3  # half a step's way
        deepest = max(deepest, depth.max())
        late = depth[history.time > 0.15]
        if kappa:
            assert late.max() < 1e-12
        else:
            assert np.ptp(late) < 1e-15  # held, not growing
    assert deepest > 5e-5  # the trap was there


@pytest.mark.parametrize("kappa", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_2_a_law_that_looks_ahead_does_not_drift(theta, kappa):
    """Nor does it throw up what it caught, however its drift is corrected."""
    for height in (0.0101, 0.0103, 0.0105, 0.0107):
        scene = dropped(height, theta=theta, formulation=Velocity(drift_correction=kappa))
        history = scene.run(0.2, 1e-3)
        assert history["rigid.base.penetration"].max() < 1e-12
        late = history.time > 0.06
        assert history["kinetic"][late].max() < 1e-20 * history["kinetic"].max() + 1e-25


@pytest.mark.parametrize("kappa", [0.1, 0.5, 1.0])
@pytest.mark.parametrize("theta", [0.5, 0.7, 1.0])
def test_2_what_has_drifted_comes_back_and_rests(theta, kappa):
    """Of the depth at the start 1 - kappa is left by each step, after the first, which moves by a
    share theta of that; with kappa = 1 a heavy block is at rest after two."""
    deep = 1e-4
    law = Velocity(drift_correction=kappa)
    scene = dropped(-deep, theta=theta, formulation=law, gravity=(0, -1e3))  # or it would fly
    depth = scene.run(0.01, 1e-3)["rigid.base.penetration"]
    left = deep * (1 - theta * kappa) * (1 - kappa) ** np.arange(10)
    np.testing.assert_allclose(depth, [deep, *left], rtol=1e-9, atol=1e-14)


def test_3_ball_projection_is_exact_and_differentiable_at_zero():
    points = np.array([[0.0, 0.0], [1.0, 0.0]])
    surface = Surface(points, np.array([[0, 1]]), "interval")
    g = surface.vector()
    direction = ufl.as_vector((1.0, 0.5))
    form = ufl.dot(ball_projection(g), ufl.TestFunction(surface.vectors)) * surface.dx
    value, slope = (
        compat.VectorAssembler(form),
        compat.VectorAssembler(
            ufl.derivative(form, g, direction * ufl.dot(direction, direction) / 1.25)
        ),
    )
    g.x.array[:] = [0.0, 0.0, 3.0, 4.0]
    np.testing.assert_allclose(value(), 0.5 * np.array([0, 0, 0.6, 0.8]), atol=1e-16)
    at_zero, outside = slope().reshape(2, 2)
    np.testing.assert_allclose(at_zero, 0.5 * np.array([1.0, 0.5]), rtol=1e-14)
    # (I - n n) d / |g| outside the ball
    n, d = np.array([0.6, 0.8]), np.array([1.0, 0.5])
    np.testing.assert_allclose(outside, 0.5 * (d - n * (n @ d)) / 5, rtol=1e-14)


def test_4_grazing_contact_is_not_singular():
    """S = 1 and lam = 0: a block that touches without weight, sliding, then pushed."""
    scene = dropped(0.0, friction=0.5, gravity=(0, 0), velocity=(0.3, 0))
    history = scene.run(0.05, 1e-3)
    assert history.finished and not history.remarks
    np.testing.assert_allclose(history["kinetic"], 0.5 * 10 * 0.09, rtol=1e-12)
    assert history["newton"].max() <= 2


def test_5_augmentation_is_scaled_by_the_scene():
    """The same pure numbers serve a block of a gram and one of a thousand tonnes."""
    counts = []
    for mass in (1e-3, 1e6):
        block = RigidSolid(rectangle(), mass=mass, gravity=(0.5, -9.81), velocity=(1.0, -0.5))
        contact = Contact(block, "base", HalfSpace((0, -0.01), (0, 1)), friction=0.3)
        history = Scene([block], [contact]).run(0.1, 1e-3)
        assert history.finished
        counts.append(history["newton"])
    np.testing.assert_array_equal(counts[0], counts[1])


def test_6_nodal_quadrature_puts_a_corner_reaction_at_the_corner():
    """A tilted block stands on its corner node alone, whatever the mesh of its base."""
    for n in (1, 7):
        block = RigidSolid(
            rectangle(n=(n, 1)), mass=10.0, gravity=(0, -9.81), rotation=0.01, about=(-0.18, 0)
        )
        contact = Contact(block, "base", FLOOR, friction=0.9)
        Scene([block], [contact]).run(1e-4, 1e-4)
        pushed = contact.force[:, 1] > 1e-9
        np.testing.assert_allclose(contact.surface.points[pushed], [[-0.18, 0.0]], atol=1e-12)


def test_7_normals_are_coefficients_and_oriented():
    """A floor given by a normal of any length and direction pushes along its outside."""
    for normal in ((0, 2.0), (0.0, 1e-3)):
        block = RigidSolid(rectangle(), mass=10.0, gravity=(0, -9.81))
        contact = Contact(block, "base", HalfSpace((0, 0), normal))
        Scene([block], [contact]).run(1e-3, 1e-3)
        np.testing.assert_allclose(contact.force.sum(axis=0), [0, 98.1], atol=1e-9)


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_8_unknowns_are_scaled(size):
    """Scenes of a micrometre and of a thousand kilometres stick without a sliding pivot."""
    mesh = rectangle(size=(0.36 * size, 0.80 * size))
    block = RigidSolid(
        mesh, mass=4.0, gravity=(0, -9.81 * size), rotation=0.01, about=(-0.18 * size, 0)
    )
    contact = Contact(block, "base", FLOOR, friction=0.9)
    scene = Scene([block], [contact])
    history = scene.run(0.05, 1e-3)
    assert history.finished
    pivot = contact.coupling.positions()[np.argmin(contact.surface.points[:, 0])]
    np.testing.assert_allclose(pivot, [-0.18 * size, 0], atol=1e-7 * size)


def test_9_first_contact_with_friction_converges_in_few_iterations():
    """What will press decides at once what it may hold; a corner lands in about three."""
    tilted = {"rotation": 0.01, "about": (-0.18, 0)}
    scene = dropped(1e-3, friction=0.9, velocity=(0.2, -0.1), **tilted)
    history = scene.run(0.05, 1e-3)
    assert history.finished and not history.remarks
    assert (history["newton"] <= 3 * np.maximum(history["geometry"], 1)).all()


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_10_hyperstatic_landing(friction):
    """21 nodes of a rigid base land at once: the velocity is unique, the forces balance."""
    scene = dropped(0.02, mesh=rectangle(n=(20, 1)), friction=friction, velocity=(0.3, 0))
    contact = scene.contacts[0]
    history = scene.run(0.3, 1e-3)
    assert history.finished
    vertical = 98.1
    assert contact.force[:, 1].sum() == pytest.approx(vertical, rel=1e-9)
    arm = contact.coupling.positions() - scene.solids[0].place
    moment = arm[:, 0] @ contact.force[:, 1] - arm[:, 1] @ contact.force[:, 0]
    assert abs(moment) < 1e-9 * vertical * 0.36
    assert (contact.force[:, 1] >= -1e-9 * vertical).all()
    left = Newton().tolerance * 9.81 * 1e-3  # of what gravity does in a step
    assert abs(scene.solids[0].velocity[2]) * 0.18 < left
    left = 0.0 if friction else 0.3
    assert scene.solids[0].velocity[0] == pytest.approx(left, abs=1e-12)


def test_11_finite_rotation_does_not_open_a_closed_point():
    """Rocking by large angles: the pivot bears in every step of a swing."""
    block = RigidSolid(rectangle(), mass=10.0, gravity=(0, -9.81), rotation=0.2, about=(-0.18, 0))
    contact = Contact(block, "base", FLOOR, friction=2.0)
    history = Scene([block], [contact]).run(0.25, 1e-3)
    assert history.finished
    assert history["rigid.base.bearing"][1:].min() >= 1
    assert np.abs(contact.coupling.positions()[:, 1].min()) < 1e-5


@pytest.mark.parametrize("friction", [1.0, 3.0, 10.0])
def test_12_large_friction_lands_or_says_why(friction):
    """A rod thrown obliquely at the floor (Painlevé's neighbourhood): never a silent cycle."""
    rod = RigidSolid(
        rectangle(size=(0.02, 1.0)),
        mass=1.0,
        gravity=(0, -9.81),
        rotation=-0.5,
        velocity=(3.0, 0.0),
    )
    lowest = Contact(rod, "base", FLOOR).coupling.positions()[:, 1].min()
    contact = Contact(rod, "base", HalfSpace((0, lowest - 1e-3), (0, 1)), friction=friction)
    history = Scene([rod], [contact], ThetaScheme(1.0)).run(0.3, 1e-3)
    assert history.finished or history.reason.startswith("stopped at")
    energy = history["kinetic"] + history["potential"]
    assert np.isfinite(energy).all()
    assert np.diff(energy).max() < 1e-9 * np.ptp(energy)


@pytest.mark.parametrize("anew", [True, False])
def test_ping_pong_is_named_and_ends(anew, monkeypatch):
    """With an exaggerated rho Newton alone cycles: it begins anew from cones of friction; where
    there is nothing to begin from, and shorter steps do not help, a remark names the points."""
    if not anew:
        monkeypatch.setattr(sweeps, "begin_from_cones", lambda *a: False)
        monkeypatch.setattr(Newton, "_damped", lambda *a: 0)
    block = RigidSolid(
        rectangle(), mass=417.6, gravity=(0, -9.81), rotation=1.7e-4, about=(-0.18, 0)
    )
    rho = {"normal_augmentation": 1e6, "tangential_augmentation": 1e6}
    contact = Contact(block, "base", FLOOR, friction=0.9, **rho)
    history = Scene([block], [contact]).run(0.01, 8e-5)
    assert history.finished
    named = [text for _, text in history.remarks if "statuses flip at points" in text]
    assert not named if anew else "method of multipliers took over" in named[0]


def test_bounds_that_follow_each_other_along_a_belt_are_ended():
    """All of it slips, each bound by what its neighbour pulls: the method of multipliers gained a
    tenth in a round, and twice 418 steps later the step was cut. Euler and Eytelwein's forces."""
    turn, friction, pull, thick = np.pi / 2, 0.3, 1e3, 0.004
    mesh = rectangle((20, 1), (1.0, thick))
    x = mesh.mesh.geometry.x
    angle, radius = turn * x[:, 0], 1 + x[:, 1]
    x[:, 0], x[:, 1] = radius * np.cos(angle), radius * np.sin(angle)

    def drawn(x, t):
        cos, sin = np.cos(3e-4 * t), np.sin(3e-4 * t)
        return np.array([[cos - 1, -sin], [sin, cos - 1]]) @ x[:2]

    belt = HyperelasticSolid(
        mesh,
        energy=st_venant_kirchhoff(1e9, 0.0),
        density=1000.0,
        prescribed={"right": drawn},
        tractions={"left": tuple(-pull / thick * np.sqrt(0.5) * np.ones(2))},
    )
    contact = Contact(belt, "base", Circle((0, 0), 1.0), "gap", friction)
    history = Scene([belt], [contact], QuasiStatic()).run(2.0, 1.0)
    assert history.finished and len(history.time) == 3
    assert not any("halved" in text for _, text in history.remarks)
    assert history["newton"].max() < 100
    places, forces = contact.coupling.positions(), contact.borne
    moment = float((places[:, 0] * forces[:, 1] - places[:, 1] * forces[:, 0]).sum())
    ratio = 1 - moment / (pull * (1 + 0.5 * thick))
    assert ratio == pytest.approx(np.exp(friction * turn), rel=2e-2)  # by 20 cells


def test_a_hopeless_step_stops_with_a_reason():
    scene = dropped(0.01, friction=0.3, velocity=(0.3, 0))
    strict = Scene(scene.solids, scene.contacts, newton=Newton(tolerance=1e-30))
    history = strict.run(0.1, 1e-3)
    assert not history.finished
    assert "stalls at a scaled residual" in history.reason and "steps down to" in history.reason
    assert np.isfinite(history.rows()).all()
    assert history.time[-1] > 0.04  # the free fall before it is kept


def test_what_is_not_a_number_has_not_converged():
    """An error of NaN is above no tolerance."""

    class Endless:
        size, worst = 1, np.nan
        hyperstatic = crowded = buckles = False
        rounding = 0.0

        def iterate(self, enough=0.0):
            return True

        def error(self):
            return np.inf  # as an error that is no number is told

        def state(self):
            return []

        def go_back(self, state, share=1.0):
            pass

        def turn(self, careful):
            return False

        def soften(self, compliance):
            pass

        def begin_again(self):
            return True

        def remember(self):
            return np.zeros(1)

        def flips(self):
            return "nothing flips"

        def stall(self):
            return "no finite solution"

        def force(self):
            return np.full(1, np.nan)

    with pytest.raises(NotConverged, match="no finite solution"):
        Newton().solve(Endless())


def test_augmentation_where_a_contact_has_no_candidates():
    """One block stands, the other has nothing near: it has no rows to be scaled."""
    blocks, contacts = [], []
    for height in (0.0, 1.0):
        block = RigidSolid(rectangle(), mass=10.0, gravity=(0, -9.81), name=f"over {height}")
        floor = HalfSpace((0, -height), (0, 1))
        blocks.append(block)
        contacts.append(
            Contact(
                block,
                "base",
                floor,
                "gap",
                0.3,
                name=f"under {height}",
                normal_augmentation=0.5,
                tangential_augmentation=2.0,
            )
        )
    history = Scene(blocks, contacts, ThetaScheme(1.0)).run(0.01, 1e-3)
    assert history.finished
    assert history["under 0.0.force_y"][-1] == pytest.approx(98.1, rel=1e-9)
    assert not history["under 1.0.force_y"].any()


@pytest.mark.parametrize(
    ("formulation", "theta"),
    [("velocity", 0.5), ("velocity", 1.0), ("gap", 1.0), ("lagrange", 1.0)],
)
def test_a_drawer_jams_where_friction_says_so(formulation, theta):
    """Pulled by F at a lever a a drawer of length L presses by N = F a/L at two corners, where
    friction is 2 mu N: with a = L it jams from mu = 1/2 on. The corners then ask of its three
    freedoms for four, which geometry that is yet to be renewed cannot give."""
    force, clearance = 10.0, 1e-3
    walls = {
        "base": HalfSpace((0, -clearance), (0, 1)),
        "top": HalfSpace((0, 2 + clearance), (0, -1)),
    }
    tilt = 2 * clearance  # of a length of 1 m that is 2 m wide
    for friction in (0.3, 0.55, 0.8, 2.0):
        drawer = RigidSolid(rectangle(size=(1.0, 2.0)), mass=1.0, force=(force, 0), torque=-force)
        contacts = [
            Contact(drawer, name, wall, formulation, friction) for name, wall in walls.items()
        ]
        scene = Scene([drawer], contacts, ThetaScheme(theta))
        places = []
        for end in (0.12, 0.16, 0.2):
            history = scene.run(end, 0.01)
            assert history.finished, history.reason
            places.append([*drawer.place, drawer.rotation])
        acceleration = np.diff(places, 2, axis=0)[0, 0] / 0.04**2
        if friction < 0.5:
            pressed = force / (1 - 2 * tilt)
            assert acceleration == pytest.approx(force - 2 * friction * pressed, rel=1e-3)
        else:
            assert np.ptp(places, axis=0).max() < 1e-8
