# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rocking block of Housner against closed formulas, integrations and published numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from fenicsx_contact import InputError
from fenicsx_contact.references.housner import Block, Rocking, rocking

PAPER = Block(0.36, 0.80, 417.6)  # Kham et al. 2009, section 3; Code_Aster SDNV105
SQUAT = Block(2.0, 0.8, 100.0)  # b^2 > 2 h^2: lands flat
BLOCKS = [PAPER, Block(0.02, 0.8, 1.0), Block(1.0, 0.8, 3.0, gravity=1.62)]


def test_constants_of_the_papers_block() -> None:
    expected = {  # reference cases, section 1, as printed
        "R": 0.438634244,
        "alpha": 0.4228539,
        "inertia_corner": 107.12832,
        "inertia_centre": 26.78208,
        "restitution": 0.7474012,
        "energy_ratio": 0.5586086,
        "smallest_friction": 0.32123736,
    }
    for name, value in expected.items():
        assert getattr(PAPER, name) == pytest.approx(value, rel=1e-7), name
    assert PAPER.p**2 == pytest.approx(16.773656, rel=1e-7)
    # angular speed 0.329 and kinetic energy 0.664 times the one before, corner without friction
    assert PAPER.frictionless_restitution == pytest.approx(0.329, abs=5e-4)
    assert PAPER.frictionless_energy_ratio == pytest.approx(0.664, abs=5e-4)
    normal, horizontal = PAPER.reactions(0.0)
    assert normal == pytest.approx(3579.25, abs=5e-3)
    assert horizontal == pytest.approx(1149.79, abs=5e-3)


TABLE = [  # reference cases, section 1: impacts (s), kinetic energy before (J), rest (s)
    (
        math.radians(0.01),
        [0.00712238, 0.01776771, 0.02572354, 0.03166952, 0.03611347, 0.03943485],
        [0.1286753, 0.0718791, 0.0401523, 0.0224294, 0.0125293, 0.0069990],
        0.049262,
    ),
    (
        0.01,
        [0.0544108, 0.1352024, 0.1953644, 0.2402380, 0.2737385, 0.2987611],
        [7.291925, 4.073333, 2.275399, 1.271057, 0.710024, 0.396625],
        0.37275,
    ),
]


@pytest.mark.parametrize(("theta0", "times", "kinetic", "rest"), TABLE)
def test_table_of_the_papers_block(
    theta0: float, times: list[float], kinetic: list[float], rest: float
) -> None:
    motion = rocking(PAPER, theta0, impacts=6)
    digit = 1e-8 if theta0 < 1e-3 else 1e-7
    np.testing.assert_allclose(motion.impact_times, times, rtol=0, atol=0.51 * digit)
    digit = 1e-7 if theta0 < 1e-3 else 1e-6
    np.testing.assert_allclose(motion.kinetic_before, kinetic, rtol=0, atol=digit)
    assert motion.rest_time == pytest.approx(rest, abs=5e-6)


def test_fifteen_digits_of_the_sixteenth_impact() -> None:
    """Long tables made independently for 0.01 degree."""
    motion = rocking(PAPER, math.radians(0.01), impacts=16)
    assert motion.impact_times[15] == pytest.approx(0.0487276529257724, rel=1e-14)
    assert motion.peak_angles[15] == pytest.approx(2.80806851678003e-08, rel=1e-13)
    assert motion.kinetic_before[15] == pytest.approx(2.07066426817573e-05, rel=1e-13)
    assert motion.normal_percussions[0] == pytest.approx(6.43777889276275, rel=1e-13)
    assert motion.tangential_percussions[0] == pytest.approx(2.06805508750261, rel=1e-13)


@pytest.mark.parametrize(
    ("theta0", "rest"),  # sums of 400 quarter periods in 40 digits (mpmath)
    [
        (math.radians(0.01), 0.0492621835650150671),
        (0.01, 0.372754308296622699),
        (0.3, 2.01580599207582569),
        (0.42285, 4.6387280024802273),  # 4e-6 rad from overturning
    ],
)
def test_rest_time(theta0: float, rest: float) -> None:
    motion = rocking(PAPER, theta0, impacts=200)
    assert motion.rest_time == pytest.approx(rest, rel=1e-14)
    assert motion.impact_times[-1] == pytest.approx(rest, rel=1e-14)
    assert motion.angle(rest) == motion.kinetic(2 * rest) == 0


@pytest.mark.parametrize("block", BLOCKS)
def test_tiny_angles_follow_the_linear_formulas(block: Block) -> None:
    """theta'' = -p^2 (sin alpha - theta cos alpha); what is left out is of order theta^2."""
    theta0 = 1e-8
    motion = rocking(block, theta0, impacts=5)
    q = block.p * math.sqrt(math.cos(block.alpha))
    edge = math.tan(block.alpha)  # where the linear block overturns
    excess = theta0 / (edge - theta0)  # cosh(q T) = 1 + excess
    assert motion.impact_times[0] == pytest.approx(2 / q * math.asinh((excess / 2) ** 0.5), 1e-13)
    n = np.arange(5)
    energies = block.energy_ratio**n * theta0 * (1 - theta0 / 2 / edge)
    peaks = 2 * energies / (1 + np.sqrt(1 - 2 * energies / edge))
    np.testing.assert_allclose(motion.peak_angles, peaks, rtol=1e-13)
    quarters = 2 / q * np.arcsinh(np.sqrt(peaks / (edge - peaks) / 2))
    np.testing.assert_allclose(
        np.diff(motion.impact_times), 2 * quarters[1:], rtol=1e-12, atol=1e-19
    )


def test_slender_block_follows_housners_formulas() -> None:
    """Housner 1963: theta_n = alpha [1 - sqrt(1 - r^2n (1 - (1 - theta_0/alpha)^2))]."""
    block = Block(0.02, 2.0, 1.0)
    motion = rocking(block, 0.4 * block.alpha, impacts=50)
    r2n = block.energy_ratio ** np.arange(50)
    peaks = block.alpha * (1 - np.sqrt(1 - r2n * (1 - 0.6**2)))
    np.testing.assert_allclose(motion.peak_angles, peaks, rtol=block.alpha**2)
    first = math.acosh(1 / 0.6) / block.p
    assert motion.impact_times[0] == pytest.approx(first, rel=block.alpha**2)


@pytest.mark.parametrize("near", [1e-1, 1e-4, 1e-8])
def test_first_quarter_near_overturning(near: float) -> None:
    """The quarter period by quadrature: theta_0 - theta = 4 phi_0 sinh^2(x)."""
    theta0 = PAPER.alpha * (1 - near)
    phi0 = PAPER.alpha - theta0

    def integrand(x: float) -> float:
        fall = 4 * phi0 * math.sinh(x) ** 2
        rate = 2 * PAPER.p * math.sqrt(math.sin(fall / 2) * math.sin(phi0 + fall / 2))
        return 8 * phi0 * math.sinh(x) * math.cosh(x) / rate

    def time(theta: float) -> float:
        until = math.asinh(math.sqrt((theta0 - theta) / phi0) / 2)
        return quad(integrand, 0, until, epsabs=0, epsrel=1e-13)[0]

    motion = rocking(PAPER, theta0)
    assert motion.impact_times[0] == pytest.approx(time(0), rel=1e-12)
    for part in (0.9, 0.5, 0.1):
        assert motion.angle(time(part * theta0)) == pytest.approx(part * theta0, rel=1e-11)


def integrated(block: Block, start: tuple[float, float], side: int, until: float) -> np.ndarray:
    """Angle and rate at ``until``, from Newton's law alone, on the corner ``side``."""

    def law(_: float, y: np.ndarray) -> list[float]:
        phi = block.alpha - side * y[0]
        weight = block.mass * block.gravity * block.R
        return [y[1], -side * weight * math.sin(phi) / block.inertia_corner]

    solution = solve_ivp(law, (0, until), start, method="DOP853", rtol=1e-13, atol=1e-15)
    return solution.y[:, -1]


@pytest.mark.parametrize("block", BLOCKS)
@pytest.mark.parametrize("part", [0.02, 0.95])
def test_against_an_independent_integration(block: Block, part: float) -> None:
    motion = rocking(block, part * block.alpha, impacts=4)
    small = 1e-10 * block.alpha
    start, began, side = (part * block.alpha, 0.0), 0.0, 1
    for n, ends in enumerate(motion.impact_times):
        for t in began + np.array([0.2, 0.5, 0.9]) * (ends - began):
            angle, rate = integrated(block, start, side, t - began)
            assert motion.angle(t) == pytest.approx(angle, abs=small)
            kinetic = block.inertia_corner * rate**2 / 2
            assert motion.kinetic(t) == pytest.approx(
                kinetic, rel=1e-9, abs=1e-10 * motion.kinetic_before[0]
            )
        angle, rate = integrated(block, start, side, ends - began)
        assert angle == pytest.approx(0, abs=small)
        assert rate == pytest.approx(-side * motion.omega_before[n], rel=1e-10)
        assert motion.omega_after[n] == block.restitution * motion.omega_before[n]
        start, began, side = (0.0, -side * motion.omega_after[n]), ends, -side


@pytest.mark.parametrize("block", BLOCKS)
def test_balance_of_energy(block: Block) -> None:
    motion = rocking(block, 0.7 * block.alpha, impacts=5)
    times = np.linspace(0, motion.impact_times[-1] * 0.999, 400)
    total = motion.kinetic(times) + block.potential(motion.angle(times))
    swing = np.searchsorted(motion.impact_times, times, side="right")
    np.testing.assert_allclose(total, motion.kinetic_before[swing], rtol=1e-12)
    np.testing.assert_allclose(
        motion.kinetic_before, block.potential(motion.peak_angles), rtol=1e-12
    )
    np.testing.assert_allclose(
        motion.kinetic_before, block.inertia_corner * motion.omega_before**2 / 2, rtol=1e-12
    )
    np.testing.assert_allclose(motion.kinetic_after[:-1], motion.kinetic_before[1:], rtol=1e-12)


def test_angle_is_continuous_and_changes_sides() -> None:
    motion = rocking(PAPER, 0.2, impacts=8)
    around = motion.impact_times[:, None] + np.array([-1e-9, 0, 1e-9])
    assert np.abs(motion.angle(around)).max() < 1e-8
    kinetic = motion.kinetic(around)
    np.testing.assert_allclose(kinetic[:, 0], motion.kinetic_before, rtol=1e-6)
    np.testing.assert_allclose(kinetic[:, 1], motion.kinetic_after, rtol=1e-12)
    peaks = (motion.impact_times[1:] + motion.impact_times[:-1]) / 2
    signed = motion.peak_angles[1:] * (-1.0) ** np.arange(1, 8)
    np.testing.assert_allclose(motion.angle(peaks), signed, rtol=1e-12)
    assert motion.angle(0) == pytest.approx(0.2, rel=1e-15)
    times = np.linspace(0, 1.1 * motion.rest_time, 20_001)
    fastest = motion.omega_before[0] * times[1]
    assert np.abs(np.diff(motion.angle(times))).max() <= fastest * (1 + 1e-9)


def inelastic(block: Block, corners: list[int], friction: bool, before: np.ndarray) -> np.ndarray:
    """Velocities (u, v, w) of the centre after a percussion that stops the given corners.

    ``corners``: +1 the right one, -1 the left one; without friction only their fall is stopped.
    """
    b, h = block.width / 2, block.height / 2
    rows = [[0, 1, side * b] for side in corners]
    rows += [[1, 0, h] for _ in corners[:1] if friction]
    jump, mass = np.array(rows), np.diag([block.mass, block.mass, block.inertia_centre])
    flexibility = np.linalg.inv(mass) @ jump.T
    return before - flexibility @ np.linalg.solve(jump @ flexibility, jump @ before)


@pytest.mark.parametrize("block", [*BLOCKS, SQUAT])
@pytest.mark.parametrize("friction", [True, False])
def test_ratios_of_the_inelastic_impact(block: Block, friction: bool) -> None:
    b, h = block.width / 2, block.height / 2
    before = np.array([h, -b, -1.0])  # turning about the left corner, clockwise, 1 rad/s
    after = inelastic(block, [1], friction, before)
    if after[1] - b * after[2] < 0:  # the left corner would enter the ground
        after = inelastic(block, [1, -1], friction, before)
    ratio = block.restitution if friction else block.frictionless_restitution
    assert -after[2] == pytest.approx(ratio, abs=1e-14)
    energy = np.array([block.mass, block.mass, block.inertia_centre])
    expected = block.energy_ratio if friction else block.frictionless_energy_ratio
    assert energy @ after**2 / (energy @ before**2) == pytest.approx(expected, abs=1e-14)
    if friction:
        percussion = block.mass * (after - before)
        assert -percussion[0] / percussion[1] == pytest.approx(block.smallest_friction, rel=1e-12)
        motion = rocking(block, block.alpha / 2, impacts=1)
        w = motion.omega_before
        np.testing.assert_allclose(motion.normal_percussions, percussion[1] * w, rtol=1e-12)
        np.testing.assert_allclose(motion.tangential_percussions, -percussion[0] * w, rtol=1e-12)
    else:  # the centre on a vertical line: the same angular velocity
        before[0] = 0.0
        still = inelastic(block, [1] if ratio else [1, -1], friction, before)
        assert -still[2] == pytest.approx(ratio, abs=1e-14)


def test_reactions_hold_the_centre_on_its_circle() -> None:
    theta, rate, small = 0.1, 0.7, 1e-4
    accel = -(PAPER.p**2) * math.sin(PAPER.alpha - theta)
    phi = PAPER.alpha - (theta + rate * small * np.array([-1, 0, 1]) + accel * small**2 / 2)
    x, y = PAPER.R * np.sin(phi), PAPER.R * np.cos(phi)
    phi0 = PAPER.alpha - theta
    x[1], y[1] = PAPER.R * math.sin(phi0), PAPER.R * math.cos(phi0)
    normal, horizontal = PAPER.reactions(-theta, -rate)
    second = np.array([1, -2, 1]) / small**2
    assert horizontal == pytest.approx(PAPER.mass * (second @ x), rel=1e-5)
    assert normal == pytest.approx(PAPER.mass * (PAPER.gravity + second @ y), rel=1e-5)


def test_squat_block_stays_at_the_first_impact() -> None:
    motion = rocking(SQUAT, 0.3)
    assert motion.impact_times.size == 1
    assert motion.rest_time == motion.impact_times[0]
    assert motion.kinetic_after[0] == motion.angle(motion.rest_time) == 0


@pytest.mark.parametrize("field", ["width", "height", "mass", "gravity"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, "wide"])
def test_bad_block(field: str, value: object) -> None:
    good = {"width": 0.36, "height": 0.8, "mass": 417.6, "gravity": 9.81}
    with pytest.raises(InputError, match=field):
        Block(**(good | {field: value}))  # type: ignore[arg-type]


@pytest.mark.parametrize("theta0", [0.0, -0.01, math.nan, PAPER.alpha, 1.0])
def test_bad_angle(theta0: float) -> None:
    with pytest.raises(InputError, match="theta0"):
        rocking(PAPER, theta0)


def test_other_bad_input() -> None:
    with pytest.raises(InputError, match="impacts"):
        rocking(PAPER, 0.01, impacts=0)
    with pytest.raises(InputError, match="impacts"):
        rocking(PAPER, 0.01, impacts=2.5)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="a Block"):
        rocking(0.36, 0.01)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="width / height"):
        rocking(Block(0.001, 1.0, 1.0), 1e-4)
    motion: Rocking = rocking(PAPER, 0.01)
    for times in (-1.0, [0.0, math.nan], math.inf):
        with pytest.raises(InputError, match="times"):
            motion.angle(times)
