# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rocking block against Housner's exact analysis, and the invariants of its scene."""

from math import radians

import numpy as np
import pytest
from scenes import rectangle

from fenicsx_contact import (
    GAP,
    VELOCITY,
    Contact,
    Discrete,
    ElasticSolid,
    HalfSpace,
    Lagrange,
    NamedMesh,
    RigidSolid,
    Scene,
    ThetaScheme,
)
from fenicsx_contact.references.housner import Block, rocking
from fenicsx_contact.references.swings import swings

BLOCK = Block(width=0.36, height=0.80, mass=417.6)
DEGREE, RADIAN = radians(0.01), 0.01
CORNERS = [(-0.18, 0.0), (0.18, 0.0)]
long = pytest.mark.long


def scene(
    angle=DEGREE,
    formulation=VELOCITY,
    friction=0.9,
    scheme=None,
    mesh=None,
    unit=(1.0, 1.0),
    located=False,
    **contact,
):
    """The paper's block, tilted about its left corner; ``unit``: metres and kilograms in the
    user's units (time in seconds)."""
    metre, kilogram = unit
    mesh = mesh or rectangle(size=(0.36 * metre, 0.80 * metre))
    block = RigidSolid(
        mesh,
        mass=417.6 * kilogram,
        gravity=(0, -9.81 * metre),
        rotation=angle,
        about=(-0.18 * metre, 0),
    )
    floor = HalfSpace((0, 0), (0, 1))
    touching = Contact(block, "base", floor, formulation, friction, **contact)
    return Scene([block], [touching], scheme, locate_impacts=located)


def run(built, until, dt):
    block = built.solids[0]
    history = built.run(until, dt, probes={"tilt": lambda: block.rotation})
    assert history.finished, history.reason
    return history


def errors(history, angle, count=6):
    """Relative errors of the kinetic-energy maxima and of the impact times."""
    exact = rocking(BLOCK, angle, impacts=count)
    when, most = swings(history.time, history["tilt"], history["kinetic"], count)
    return most / exact.kinetic_before - 1, when / exact.impact_times - 1


@pytest.mark.parametrize(
    ("law", "angle", "until", "dt", "within"),
    [
        # of first order in the step
        pytest.param("printed", DEGREE, 0.0412, 6.4e-6, 0.04, marks=pytest.mark.second),
        pytest.param("printed", DEGREE, 0.0412, 1.6e-6, 0.01, marks=long),
        pytest.param("printed", RADIAN, 0.312, 1.3e-5, 0.01, marks=long),
        pytest.param("velocity", DEGREE, 0.0412, 0.8e-6, 0.01, marks=long),
        pytest.param("velocity", RADIAN, 0.312, 0.65e-5, 0.01, marks=long),
    ],
)
def test_first_six_maxima_of_housner_by_uniform_steps(law, angle, until, dt, within):
    history = run(scene(angle, law), until, dt)
    kinetic, time = errors(history, angle)
    assert np.abs(kinetic).max() < within
    assert np.abs(time).max() < 0.2 * within
    # a few iterations a step, and the books balance
    assert history["newton"].sum() < 1.1 * len(history)
    assert np.abs(history["balance"]).max() < 1e-12 * history["kinetic"].max()


@pytest.mark.parametrize(
    ("n", "angle", "until"),
    [
        (1, DEGREE, 0.0412),
        (1, RADIAN, 0.312),
        (10, DEGREE, 0.0412),
        (10, RADIAN, 0.312),
    ],
)
def test_first_six_maxima_of_housner_by_a_hundred_steps(angle, until, n):
    """With located impacts, however many points the base has: a pivot that hovers by round-off
    comes down to the floor, not below, where its neighbours would land before the far corner."""
    history = run(scene(angle, mesh=rectangle(n=(n, 1)), located=True), until, until / 100)
    kinetic, time = errors(history, angle)
    assert np.abs(kinetic).max() < 1e-4
    assert np.abs(time).max() < 1e-4
    assert np.abs(history["balance"]).max() < 1e-12 * history["kinetic"].max()


@pytest.mark.parametrize(
    ("located", "dt", "within"), [(True, 2e-4, 2e-5), pytest.param(False, 2e-6, 0.005, marks=long)]
)
def test_energy_ratio_at_each_impact(located, dt, within):
    """Kinetic energy just after over just before the impact, each extrapolated to the impact."""
    law = VELOCITY if located else "printed"
    history = run(scene(formulation=law, located=located), 0.0412, dt)
    exact = rocking(BLOCK, DEGREE, impacts=6)
    for before, after in zip(exact.impact_times[:5], exact.impact_times[1:]):
        peak = 0.5 * (before + after)
        # between impacts kinetic + potential is constant: compare it left and right of an impact
        total = history["kinetic"] + history["potential"] - history["potential"].min()
        left = np.interp(before - 0.2 * (peak - before), history.time, total)
        right = np.interp(peak, history.time, total)
        assert right / left == pytest.approx(BLOCK.energy_ratio, rel=within)


@pytest.mark.parametrize("theta", [pytest.param(0.5, marks=long), 1.0])
@pytest.mark.parametrize(
    "lengths",
    [
        pytest.param((160e-6, 40e-6), marks=pytest.mark.second),
        pytest.param((32e-6, 8e-6, 2e-6), marks=long),
    ],
    ids=["two", "three"],
)
def test_error_falls_at_first_order(theta, lengths):
    """Mean error of the first impact times and maxima; a few steps close to each length average
    out where in its step an impact falls."""
    mean = []
    for dt in lengths:
        several = [
            errors(run(scene(scheme=ThetaScheme(theta)), 0.0295, dt * f), DEGREE, count=3)
            for f in np.linspace(0.9, 1.1, 5)
        ]
        mean.append([np.mean(np.abs([e[i] for e in several])) for i in (0, 1)])
    for errors_of in np.transpose(mean):
        assert np.polyfit(np.log(lengths), np.log(errors_of), 1)[0] > 0.9


@pytest.mark.parametrize(
    ("formulation", "scheme"),
    [
        (GAP, ThetaScheme(1.0)),
        pytest.param(Lagrange(CORNERS), ThetaScheme(1.0), marks=long),
        pytest.param(Discrete(1e12, damping=6.7e7, points=CORNERS), ThetaScheme(0.5), marks=long),
    ],
    ids=["gap", "lagrange", "discrete"],
)
@pytest.mark.parametrize("dt", [8e-6, pytest.param(2e-6, marks=long)])
def test_other_formulations_in_the_same_scene(formulation, scheme, dt):
    """Of first order; two maxima are enough of the coarser step. Damped springs take more than
    Housner's blow in each landing: 1.6 % of what is left in steps of 8 us, 0.7 % of 2 us."""
    count = 6 if dt < 4e-6 else 2
    until = 0.0412 if count == 6 else 0.0235
    history = run(scene(formulation=formulation, scheme=scheme), until, dt)
    kinetic, time = errors(history, DEGREE, count)
    bound, late = np.full(count, 0.02), 0.004
    if isinstance(formulation, Discrete):
        bound, late = 0.001 + (0.005 + 2e3 * dt) * np.arange(count), 0.007
    assert (np.abs(kinetic) < bound).all()
    assert np.abs(time).max() < late


def test_point_multipliers_equal_the_gap_law_at_the_corners():
    histories = [
        run(scene(formulation=f, scheme=ThetaScheme(1.0)), 0.01, 2e-5)
        for f in (GAP, Lagrange(CORNERS), Lagrange())
    ]
    for other in histories[1:]:
        np.testing.assert_allclose(other["kinetic"], histories[0]["kinetic"], rtol=1e-9, atol=1e-15)


def impact(friction, slipping_before):
    """Angular-velocity and kinetic-energy ratios of one impact, seen one tiny step apart."""
    block = RigidSolid(
        rectangle(),
        mass=417.6,
        velocity=(0.0 if slipping_before else -0.4 * -0.05, -0.18 * 0.05),
        spin=-0.05,
    )
    contact = Contact(block, "base", HalfSpace((0, 0), (0, 1)), friction=friction)
    built = Scene([block], [contact], ThetaScheme(1.0))
    before = built.solids[0].energies()[0]
    built.run(1e-9, 1e-9)
    return block.velocity[2] / -0.05, block.energies()[0] / before


def test_impact_without_slip_is_housners():
    spin, energy = impact(0.9, slipping_before=False)
    assert spin == pytest.approx(BLOCK.restitution, rel=1e-6)
    assert energy == pytest.approx(BLOCK.energy_ratio, rel=1e-6)


def test_impact_without_friction():
    """0.329 and 0.664: the block that did not slip until then lands on a frictionless corner."""
    spin, energy = impact(0.0, slipping_before=False)
    assert spin == pytest.approx(0.329, abs=5e-4)
    assert energy == pytest.approx(0.664, abs=5e-4)
    assert spin == pytest.approx(BLOCK.frictionless_restitution, rel=1e-6)
    assert energy == pytest.approx(BLOCK.frictionless_energy_ratio, rel=1e-6)
    # a motion without friction from the start: the centre of mass moves vertically only
    spin, energy = impact(0.0, slipping_before=True)
    assert spin == pytest.approx(BLOCK.frictionless_restitution, rel=1e-6)
    assert energy == pytest.approx(BLOCK.frictionless_restitution**2, rel=1e-6)


def test_impact_slips_below_the_limit_friction():
    for friction, slips in ((1.001, False), (0.999, True)):
        spin, _ = impact(friction * BLOCK.smallest_friction, slipping_before=False)
        assert (spin < BLOCK.restitution * (1 - 1e-9)) == slips


@pytest.mark.parametrize("steps", [1000, pytest.param(10_000, marks=long)])
def test_thousands_of_steps_at_rest(steps):
    built = scene(angle=0.0, mesh=rectangle(n=(4, 1)))
    height = built.solids[0].place[1]
    history = run(built, steps * 1e-3, 1e-3)
    assert len(history) == steps + 1
    assert abs(built.solids[0].place[1] - height) < 1e-9 * 0.8
    assert history["kinetic"].max() < 1e-25
    assert abs(history["impact"][-1]) + abs(history["friction"][-1]) < 1e-12
    # the reaction is the weight throughout
    np.testing.assert_allclose(history["rigid.base.force_y"][1:], 417.6 * 9.81, rtol=1e-12)


@pytest.mark.parametrize("located", [False, True])
@pytest.mark.parametrize("unit", [(2.0**10, 2.0**-10), (2.0**-20, 2.0**30), (2.0**10, 2.0**-60)])
def test_units_do_not_matter(unit, located):
    """In units that are powers of two of SI's, through an impact, to the last bit: nothing that is
    compared with anything has a dimension."""
    si = run(scene(located=located), 0.02, 4e-5)
    other = run(scene(unit=unit, located=located), 0.02, 4e-5)
    metre, kilogram = unit
    force, energy = kilogram * metre, kilogram * metre**2
    scale = {"force_x": force, "force_y": force, "penetration": metre}
    scale |= dict.fromkeys(("kinetic", "potential", "impact", "friction"), energy)
    scale |= dict.fromkeys(("scheme", "balance"), energy)
    for column in si.columns:
        expected = scale.get(column.split(".")[-1], 1.0) * si[column]
        np.testing.assert_array_equal(other[column], expected, err_msg=column)


def renumbered(mesh: NamedMesh) -> NamedMesh:
    """The same mesh with its nodes and cells in another order."""
    from mpi4py import MPI

    from fenicsx_contact import name_facets
    from fenicsx_contact.base import compat

    x = mesh.mesh.geometry.x[:, :2]
    cells = compat.cell_geometry(mesh.mesh)
    order = np.random.default_rng(3).permutation(len(x))
    place = np.argsort(order)
    new = compat.create_mesh(MPI.COMM_SELF, place[cells][::-1], x[order], "quadrilateral")
    return name_facets(new, {"base": lambda x: np.isclose(x[1], 0)})


def test_numbering_of_nodes_does_not_matter():
    mesh = rectangle(n=(5, 2))
    one, two = (run(scene(mesh=m), 0.01, 2e-5) for m in (mesh, renumbered(mesh)))
    scale = one["kinetic"].max()
    np.testing.assert_allclose(two["kinetic"], one["kinetic"], rtol=1e-9, atol=1e-9 * scale)
    np.testing.assert_allclose(two["tilt"], one["tilt"], atol=1e-9 * DEGREE)


@pytest.mark.parametrize("which", ["normal_augmentation", "tangential_augmentation"])
def test_augmentation_acts_on_the_way_not_on_the_result(which):
    reference = run(scene(), 0.01, 4e-5)
    for factor in (1e-6, 1e-3, 1e3, 1e6):
        other = run(scene(**{which: factor}), 0.01, 4e-5)
        scale = reference["kinetic"].max()
        assert np.abs(other["kinetic"] - reference["kinetic"]).max() < 1e-8 * scale
        assert np.abs(other["tilt"] - reference["tilt"]).max() < 1e-8 * DEGREE
        # the Newton count may depend on it, within reason
        assert other["newton"].sum() < 3 * reference["newton"].sum()


@pytest.mark.parametrize(
    ("lengths", "within"), [((8e-5, 2e-5), 0.04), pytest.param((1e-5, 2.5e-6), 0.01, marks=long)]
)
def test_base_of_many_nodes_gives_the_same_motion(lengths, within):
    """Housner's ratio holds however many points the base has; the path differs by O(dt), or not."""
    distance = []
    for dt in lengths:
        two, many = (run(scene(mesh=rectangle(n=(n, 1))), 0.0295, dt) for n in (1, 10))
        distance.append(np.abs(errors(two, DEGREE, 3)[0] - errors(many, DEGREE, 3)[0]).max())
    assert distance[1] < max(0.5 * distance[0], 1e-7)
    assert np.abs(errors(many, DEGREE, 3)[0]).max() < within


@pytest.mark.parametrize("dt", [1e-5, pytest.param(2e-6, marks=long)])
def test_elastic_block_approaches_the_rigid_one(dt):
    """Energy left after the first impact, as a share: towards Housner's as E grows. In steps that
    are shorter than waves take through the block (4 us) what vibrates is left, too."""
    left = []
    for E in (1e11, 1e13, 1e15):
        solid = ElasticSolid(
            rectangle(n=(3, 6)),
            youngs_modulus=E,
            poisson_ratio=0.2,
            density=417.6 / 0.36 / 0.80,
            gravity=(0, -9.81),
            displacement=lambda x: DEGREE * np.stack([-x[1], x[0] + 0.18]),
        )
        contact = Contact(solid, "base", HalfSpace((0, 0), (0, 1)), friction=0.9)
        built = Scene([solid], [contact], ThetaScheme(1.0, "end"))
        history = built.run(0.012, dt)
        assert history.finished
        total = history["kinetic"] + history["strain"] + history["potential"]
        left.append(total[-1] / total[0])
    rigid = BLOCK.energy_ratio
    distance = np.abs(np.array(left) - rigid)
    assert distance[2] < distance[1] < distance[0]
    assert distance[2] < (0.002 if dt > 4e-6 else 0.003)


def test_restored_scene_goes_on_identically():
    """Also where a bearing point is put back on the floor from which finite rotation takes it."""

    whole = run(scene(0.05, located=True), 0.3, 1e-3).rows()[-100:, 2:]
    first = scene(0.05, located=True)
    first.run(0.2, 1e-3)
    contact = first.contacts[0]
    assert np.abs(contact.gap[contact.status > 0]).max() < contact.tolerance
    again = scene(0.05, located=True)
    again.restore(first.state())
    np.testing.assert_array_equal(run(again, 0.3, 1e-3).rows()[-100:, 2:], whole)
