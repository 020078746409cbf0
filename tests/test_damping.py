# SPDX-License-Identifier: LGPL-3.0-or-later
"""Damping of deformable solids: the damped oscillator, the books, rotations, statics."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import box, check_energies, elastic_block, rates, rectangle, soft_block, total_energy
from scipy.spatial.transform import Rotation

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    GeneralisedAlpha,
    HalfSpace,
    HyperelasticSolid,
    InputError,
    KelvinVoigt,
    QuasiStatic,
    Rayleigh,
    Scene,
    ThetaScheme,
    neo_hookean,
)

LENGTH, WAVE, CELLS = 10.0, 30.0, 4  # m, m/s
K = np.pi / 2 / LENGTH
STEP = LENGTH / CELLS
#: Of the first mode of the bar's linear elements.
OMEGA = WAVE * np.sqrt(6 / STEP**2 * (1 - np.cos(K * STEP)) / (2 + np.cos(K * STEP)))
DAMPINGS = [KelvinVoigt(0.04), Rayleigh(0.6), Rayleigh(0.3, 0.03)]
ELASTIC = {"youngs_modulus": WAVE**2, "poisson_ratio": 0.0, "density": 1.0}


def bar(**others):
    mode = lambda x: np.stack([0.1 * np.sin(K * (x[0] + LENGTH / 2)), 0 * x[1]])  # noqa: E731
    mesh = rectangle((CELLS, 1), (LENGTH, 1.0))
    return ElasticSolid(mesh, **{**ELASTIC, "fixed": ["left"], "displacement": mode, **others})


def run(solid, scheme, until, steps):
    shape = solid.displacement.copy()
    size = shape @ shape or 1.0
    probes = {"q": lambda: solid.displacement @ shape / size}
    history = Scene([solid], [], scheme, allow_free=True).run(until, until / steps, probes=probes)
    assert history.finished, history.reason
    return history


def oscillator(damping, time):
    """``q'' + (alpha + beta omega²) q' + omega² q = 0``, let go from 1."""
    rate = (damping.alpha + damping.beta * OMEGA**2) / 2
    omega = np.sqrt(OMEGA**2 - rate**2)
    return np.exp(-rate * time) * (np.cos(omega * time) + rate / omega * np.sin(omega * time))


@pytest.mark.parametrize("damping", DAMPINGS, ids=repr)
@pytest.mark.parametrize(
    ("scheme", "order"),
    [
        (ThetaScheme(), 2),
        (ThetaScheme(0.8), 1),
        (ThetaScheme(0.5, "end"), 1),
        (ThetaScheme(1.0), 1),
        (GeneralisedAlpha(0.6), 2),
    ],
    ids=lambda value: value.describe() if hasattr(value, "describe") else str(value),
)
def test_free_vibration_decays_as_the_oscillator(damping, scheme, order):
    errors, until = [], 1.5 * 2 * np.pi / OMEGA
    for steps in np.array([40, 80, 160]) * (1 if order == 2 else 2):
        history = run(bar(damping=damping), scheme, until, steps)
        errors.append(np.abs(history["q"] - oscillator(damping, history.time)).max())
        check_energies(history)
        assert (np.diff(history["damping"]) <= 0).all()
        assert history["certificate"].max() < 1e-9
    assert errors[-1] < (2e-3 if order == 2 else 0.08)
    np.testing.assert_allclose(rates(errors)[-1], order, atol=0.15 if order == 1 else 0.05)
    total = total_energy(history)
    if scheme == ThetaScheme():  # what goes, goes by damping
        assert np.abs(history["scheme"]).max() < 1e-12 * total[0]
        np.testing.assert_allclose(total - history["damping"], total[0], rtol=1e-12)
    if order == 2:
        assert history["damping"][-1] == pytest.approx(total[-1] - total[0], rel=1e-3)


def test_no_damping_is_no_damper():
    """The same numbers to the last bit, and nothing assembled for it."""
    ends = []
    for damping in (None, Rayleigh(), KelvinVoigt(0.0)):
        solid = bar(damping=damping)
        assert solid.dampers == []
        history = run(solid, ThetaScheme(), 0.1, 10)
        assert not history["damping"].any()
        ends.append(history.rows()[:, 2:])
    for other in ends[1:]:
        np.testing.assert_array_equal(other, ends[0])


def test_own_damping():
    """A stranger's class is one, if it has both numbers."""

    class Mine:
        alpha, beta = 0.6, 0.01

        def __repr__(self):
            return "Mine()"

    ends = [
        run(bar(damping=d), ThetaScheme(), 0.1, 10).rows() for d in (Mine(), Rayleigh(0.6, 0.01))
    ]
    np.testing.assert_array_equal(*ends)
    assert "Mine()" in bar(damping=Mine()).describe()


def test_statics_know_no_damping():
    ends = []
    for damping in (None, Rayleigh(5.0, 5.0)):
        for make in (
            lambda **o: ElasticSolid(rectangle((2, 3)), **{**ELASTIC, **o}),
            lambda **o: HyperelasticSolid(
                rectangle((2, 3)), energy=neo_hookean(900.0, 0.0), density=1.0, **o
            ),
        ):
            solid = make(damping=damping, fixed=["base"], tractions={"top": [9.0, 5.0]})
            history = Scene([solid], [], QuasiStatic()).run(1.0, 0.5)
            assert history.finished and not history["damping"].any()
            ends.append(solid.displacement)
    np.testing.assert_allclose(ends[2], ends[0], rtol=0, atol=1e-15)
    np.testing.assert_allclose(ends[3], ends[1], rtol=0, atol=1e-9)


# -- large strain --


def bent(amplitude):
    return lambda x: (
        amplitude
        * np.stack([x[1] ** 2 + 0.5 * x[0] * x[1], 0.7 * x[0] ** 2 - 0.4 * x[1] - 0.3 * x[0]])
    )


def soft(**others):
    return HyperelasticSolid(
        rectangle((2, 3)), energy=neo_hookean(1e6, 0.3), density=1000.0, **others
    )


def test_small_motions_are_those_of_the_elastic_solid():
    errors, damping = [], Rayleigh(3.0, 2e-3)
    for amplitude in (1e-2, 1e-3, 1e-4):
        others = {"fixed": ["base"], "displacement": bent(amplitude), "damping": damping}
        linear = ElasticSolid(
            rectangle((2, 3)), youngs_modulus=1e6, poisson_ratio=0.3, density=1000.0, **others
        )
        solid = soft(**others)
        histories = [run(each, ThetaScheme(), 0.02, 20) for each in (linear, solid)]
        lost = [history["damping"][-1] for history in histories]
        errors.append(abs(lost[1] / lost[0] - 1))
        assert lost[0] < -0.3 * total_energy(histories[0])[0]
    assert errors[0] < 0.05
    np.testing.assert_allclose(rates(errors, 10.0), 1, atol=0.2)


def test_rotation_is_not_damped():
    """A rigid spin at a large rotation strains at no rate."""
    R = Rotation.from_euler("z", 1.2).as_matrix()[:2, :2]
    spin = np.array([[0.0, -3.0], [3.0, 0.0]])
    solid = soft(
        damping=KelvinVoigt(0.1),
        displacement=lambda x: R @ x[:2] - x[:2],
        velocity=lambda x: spin @ R @ x[:2],
    )
    (viscous,) = solid.dampers
    from fenicsx_contact.theory.scheme import Step

    step = Step(1e-3, ThetaScheme())
    force = viscous.force(step, solid.displacement, solid.displacement, solid.velocity)
    other = viscous.force(
        step, solid.displacement, solid.displacement, bent(1.0)(solid.vectors.places.T).T.ravel()
    )
    assert np.abs(force).max() < 1e-12 * np.abs(other).max()


def test_a_spinning_block_is_not_damped():
    """Not by its way along the chord in a step, at a viscosity that would take 60 J for it."""
    solid = soft(damping=KelvinVoigt(1.0), velocity=lambda x: np.stack([0.4 - x[1], x[0]]))
    history = run(solid, ThetaScheme(), 1.0, 20)
    assert abs(history["damping"][-1]) < 5e-3 * history["kinetic"][0]


@pytest.mark.parametrize("scheme", [ThetaScheme(), ThetaScheme(0.7), GeneralisedAlpha(0.7)])
def test_finite_vibration_loses_what_is_damped(scheme):
    solid = soft(damping=Rayleigh(2.0, 1e-3), velocity=lambda x: 4 * bent(1.0)(x))
    history = run(solid, scheme, 0.1, 100)
    check_energies(history, 1e-7)
    assert (np.diff(history["damping"]) <= 0).all()
    total = total_energy(history)
    assert history["damping"][-1] < -0.3 * total[0]
    if scheme == ThetaScheme():
        np.testing.assert_allclose(total - history["damping"], total[0], rtol=1e-6)


def test_damped_flight_keeps_the_momentum():
    """Viscosity is an internal force; of a body that flies it takes nothing but vibration."""
    for make in (soft, lambda **o: bar(fixed=(), displacement=None, **o)):
        solid = make(damping=KelvinVoigt(1e-2), velocity=lambda x: np.stack([3.0 + 0 * x[0], x[1]]))
        before = solid.mean(solid.velocity)
        history = run(solid, ThetaScheme(), 0.05, 20)
        np.testing.assert_allclose(solid.mean(solid.velocity), before, rtol=1e-9)
        assert history["damping"][-1] < 0


# -- with contact --


@pytest.mark.parametrize("make", [elastic_block, soft_block])
def test_damped_impact_keeps_its_books(make, monkeypatch):
    from fenicsx_contact.solids.damping import KelvinVoigt as Viscous

    undamped = make().run(0.02, 5e-4)
    for kind in (ElasticSolid, HyperelasticSolid):
        create = kind.__init__
        monkeypatch.setattr(
            kind,
            "__init__",
            lambda self, mesh, create=create, **o: create(self, mesh, **o, damping=Viscous(1e-3)),
        )
    history = make().run(0.02, 5e-4)
    assert history.finished, history.reason
    check_energies(history, 1e-6, slack=0.01 * np.ptp(total_energy(history)), together=True)
    assert history["damping"][-1] < -1e-3 * total_energy(history)[0]
    assert (history["dt"] > 0).sum() == (undamped["dt"] > 0).sum()  # none was cut


@pytest.mark.parametrize("make", [soft, lambda **o: bar(fixed=(), displacement=None, **o)])
def test_a_damped_run_continues_to_the_last_bit(make):
    def scene():
        solid = make(
            damping=Rayleigh(1.0, 1e-3), velocity=lambda x: np.stack([-1 - x[1], x[0] * 0.1])
        )
        wall = HalfSpace((solid.vectors.places[:, 0].min() - 1e-3, 0), (1, 0))
        return Scene([solid], [Contact(solid, "left", wall, "gap")], GeneralisedAlpha(0.8))

    whole, half, again = (scene() for _ in range(3))
    history = whole.run(0.02, 1e-3)
    assert history.finished and history["impact"].any()
    half.run(0.01, 1e-3)
    again.restore(half.state())
    again.run(0.02, 1e-3)
    np.testing.assert_array_equal(again.solids[0].velocity, whole.solids[0].velocity)
    np.testing.assert_array_equal(again.stepper.work, whole.stepper.work)


@pytest.mark.parametrize("solver", ["condensed", "monolithic"])
def test_damped_boxes_in_space_strike(solver):
    """Each solver finds the same, linear and not, and the books close."""
    for kind, material in (
        (ElasticSolid, {"youngs_modulus": 1e6, "poisson_ratio": 0.3}),
        (HyperelasticSolid, {"energy": neo_hookean(1e6, 0.3)}),
    ):
        solid = kind(
            box((1, 1, 2)),
            **material,
            density=1000.0,
            damping=KelvinVoigt(1e-3),
            springs={"top": 1e4},
            velocity=lambda x: np.stack([0.3 + 0 * x[0], 0 * x[0], -1 + 0.1 * x[0]]),
        )
        floor = HalfSpace((0, 0, -1e-3), (0, 0, 1))
        contact = Contact(solid, "base", floor, friction=0.3, name="c")
        scene = Scene([solid], [contact], geometry="newton", solver=solver)
        history = scene.run(0.02, 1e-3)
        assert history.finished, history.reason
        assert history["damping"][-1] < -1e-3 * history["kinetic"][0]
        assert history["c.bearing"].max() > 0
        assert np.abs(history["balance"]).max() < 1e-6 * history["kinetic"][0]
        assert np.abs(history["scheme"]).max() < 1e-4 * history["kinetic"][0]


# -- bad input --


@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf, "much", None, 1j, True])
def test_bad_numbers_are_refused(value):
    for make in (KelvinVoigt, Rayleigh, lambda v: Rayleigh(0.0, v)):
        with pytest.raises(InputError, match=r"eta|alpha|beta"):
            make(value)


@pytest.mark.parametrize("value", [0.1, "Rayleigh", Rayleigh])
def test_bad_dampings_are_refused(value):
    with pytest.raises(InputError, match=r"damping = .*KelvinVoigt\(eta\)"):
        bar(damping=value)


def test_damping_is_described():
    assert "KelvinVoigt(eta=0.1)" in bar(damping=KelvinVoigt(0.1)).describe()
    assert "damp" not in bar().describe()


@pytest.mark.parametrize("kind", ["elastic", "hyperelastic"])
@pytest.mark.parametrize("damping", [KelvinVoigt(0.02), Rayleigh(0.0, 0.02)], ids=repr)
def test_springs_to_ground_are_damped_by_rayleigh_alone(damping, kind):
    """A stiff block on soft springs strains nothing; a viscous stress takes nothing of that."""
    given = {
        "density": 1.0, "damping": damping, "springs": {"base": (100.0, 100.0)},
        "velocity": lambda x: np.stack([0.1 + 0 * x[0], 0 * x[0]]),
        "prescribed": {"left": (None, 0.0), "right": (None, 0.0)},
    }  # fmt: skip
    mesh = rectangle((1, 1), (1.0, 1.0))
    if kind == "elastic":
        block = ElasticSolid(mesh, youngs_modulus=1e6, poisson_ratio=0.0, **given)
    else:
        block = HyperelasticSolid(mesh, energy=neo_hookean(1e6, 0.0), **given)
    history = Scene([block], []).run(1.0, 5e-3)
    assert history.finished, history.reason
    kept = (history["kinetic"] + history["strain"])[-1] / history["kinetic"][0]
    # eta k/m = 2/s of the energy, more or less by the phase of the swing of 10/s
    takes = isinstance(damping, Rayleigh)
    assert kept == pytest.approx(np.exp(-2.0) if takes else 1.0, rel=0.1 if takes else 1e-3)
