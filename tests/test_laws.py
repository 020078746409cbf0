# SPDX-License-Identifier: LGPL-3.0-or-later
"""The laws (1)-(5) and (4') point by point, and the tangents of the weak form (7) by finite
differences."""

import itertools

import numpy as np
import pytest
import ufl

from fenicsx_contact import GAP, VELOCITY, Discrete, Lagrange, Velocity
from fenicsx_contact.contact.equations import SurfaceEquations
from fenicsx_contact.contact.surface import Surface
from fenicsx_contact.theory import laws
from fenicsx_contact.theory.formulations import PRINTED, Printed
from fenicsx_contact.theory.friction import Coulomb, Tresca
from fenicsx_contact.theory.step_data import StepData

SURFACES = {
    2: (np.array([[0.0, 0.0], [1.0, 0.0], [2.5, 0.0]]), np.array([[0, 1], [1, 2]]), "interval"),
    3: (
        np.array([[0.0, 0, 0], [1.0, 0, 0], [0.0, 1, 0], [1.0, 1.2, 0]]),
        np.array([[0, 1, 2], [1, 3, 2]]),
        "triangle",
    ),
}
FORMULATIONS = {
    "velocity": VELOCITY,
    "velocity, corrected": Velocity(drift_correction=0.5),
    "printed": PRINTED,
    "printed, corrected": Printed(drift_correction=0.5),
    "gap": GAP,
    "lagrange": Lagrange(),
    "discrete": Discrete(stiffness=3.0, damping=0.4, tangential_stiffness=2.0),
}
FRICTION = {"coulomb": Coulomb(0.3), "tresca": Tresca(0.4), "none": None}
RHO_N, RHO_T, MU = 2.0, 5.0, 0.3
#: For each state: w_n, w_t, lam, |tau|, gap.
STATES = {
    "stick": (0.01, 0.01, -1.0, 0.1, 0.05),
    "slip": (0.01, 0.7, -1.0, 0.25, 0.05),
    "open": (-1.0, 0.3, -0.1, 0.01, 0.02),
    "grazing": (0.02, 0.03, -1e-6, 1e-7, 0.03),
    "zero velocity": (0.0, 0.0, -1.0, 0.0, 0.05),
    "nothing": (-0.4, 0.0, 0.0, 0.0, -0.3),
    "first touch": (0.02, 0.0, 0.0, 0.0, 0.03),
}


def equations(dim, formulation, friction=None):
    """Equations on a small surface, normal down the last axis, with awkward parameters."""
    surface = Surface(*SURFACES[dim])
    n = surface.size
    weight = np.ones(n) if formulation.at_points else surface.area
    eq = SurfaceEquations(surface, formulation, friction, np.ones(n, bool), weight, (1.0, 1.0))
    normal = np.zeros((n, dim))
    normal[:, -1] = -1.0
    k = eq.fields
    k.set_normal(normal)
    rho = np.array([[RHO_N], [RHO_T]]) * np.ones(n)
    eq.set_scale(rho, rho, 1.0)
    k.start_jump_n.x.array[:] = -0.03
    if not formulation.multipliers:
        k.mean_share.value, k.force_rate.value = 0.5, 0.05
        k.start_gap.x.array[:] = 0.01
        k.elongation.x.array[::dim] = 0.02
    eq.set_rates(0.1, 0.2, 0.5, 0.2)
    return eq


def tangents_of(eq):
    """Unit tangents (d - 1, n, d), along the axes."""
    n, d = eq.fields.surface.points.shape
    tangents = eq.fields.frame()[1]
    return tangents if len(tangents) else np.eye(d)[:-1, None] * np.ones((1, n, 1))


def values_of(eq, w_n, w_t, lam, tau):
    """Unknowns from w_n (n,), w_t (d - 1, n), lam (n,), tau (d - 1, n), as far as there are any."""
    normal = eq.fields.frame()[0]
    values = np.zeros(eq.size)
    jump = w_n[:, None] * normal + np.einsum("in,ind->nd", w_t, tangents_of(eq))
    values[: eq.jumps] = jump.ravel()
    values[eq.jumps : eq.tractions] = lam[: eq.tractions - eq.jumps]
    values[eq.tractions :] = tau.ravel()[: eq.size - eq.tractions]
    return values


def set_state(eq, state):
    """The same state at each point, a little different each, so that nothing cancels."""
    w_n, w_t, lam, tau, gap = STATES[state]
    n, d = eq.fields.surface.points.shape
    vary = 1 + 0.1 * np.arange(n)
    direction = np.array([1.0] if d == 2 else [0.8, 0.6])[:, None]
    values = values_of(eq, w_n * vary, direction * w_t * vary, lam * vary, direction * tau * vary)
    eq.values = values
    eq.fields.gap.x.array[:] = gap * vary
    return values


@pytest.mark.parametrize("friction", FRICTION)
@pytest.mark.parametrize("name", FORMULATIONS)
@pytest.mark.parametrize("dim", [2, 3])
def test_tangent_of_each_block(dim, name, friction):
    eq = equations(dim, FORMULATIONS[name], FRICTION[friction])
    blocks = {
        "w": slice(0, eq.jumps),
        "lam": slice(eq.jumps, eq.tractions),
        "tau": slice(eq.tractions, None),
    }
    for state in STATES:
        base = set_state(eq, state)
        exact = eq.tangents.dense().copy()
        assert np.isfinite(exact).all()
        if state == "first touch" and name != "discrete":
            continue  # a kink in lam; its tangent stands in test_first_touch_is_regular
        scale = np.abs(exact).max()
        step = 1e-7 if state != "grazing" else 1e-8
        numeric = np.zeros_like(exact)
        for j in range(eq.size):
            sides = []
            for sign in (1, -1):
                moved = base.copy()
                moved[j] += sign * step
                eq.values = moved
                sides.append(eq.residual().copy())
            numeric[:, j] = (sides[0] - sides[1]) / (2 * step)
        for (a, rows), (b, columns) in itertools.product(blocks.items(), repeat=2):
            difference = np.abs(exact[rows, columns] - numeric[rows, columns]).max(initial=0.0)
            assert difference <= 1e-6 * max(scale, 1e-3), f"{state}: d F_{a} / d {b}"


@pytest.mark.parametrize("dim", [2, 3])
def test_stick_tangent_is_symmetric(dim):
    """Coulomb's bound depends on lam, but while a point sticks nothing does on the bound."""
    eq = equations(dim, VELOCITY, Coulomb(MU))
    set_state(eq, "stick")
    K = eq.tangents.dense()
    np.testing.assert_allclose(K, K.T, atol=1e-14 * np.abs(K).max())


@pytest.mark.parametrize("dim", [2, 3])
def test_first_touch_is_regular(dim):
    """At lam = 0, S = 1, where the printed row says nothing of Lam, (4') says tau = 0."""
    eq = equations(dim, VELOCITY, Coulomb(MU))
    set_state(eq, "first touch")
    eq.fields.start_jump_n.x.array[:] = 0.0
    values = eq.values
    values[: eq.jumps] = 0.0  # as fast as allowed: g_n = 0
    eq.values = values
    K, n, d = eq.tangents.dense(), *eq.fields.surface.points.shape
    tau = slice(eq.tractions, None)
    area = np.tile(eq.fields.surface.area, d - 1)
    np.testing.assert_allclose(K[tau, tau], np.diag(-area / RHO_T), atol=1e-15)
    assert not K[tau, : eq.jumps].any()
    assert np.linalg.matrix_rank(K[eq.jumps :, :]) == n * d
    # tau = 0 solves the row, nothing else does
    assert not eq.residual()[tau].any()
    values = eq.values
    values[tau] = 1e-3
    eq.values = values
    np.testing.assert_allclose(eq.residual()[tau], -1e-3 * area / RHO_T)


def number(expression):
    """The values of a UFL expression without coefficients."""
    shape = expression.ufl_shape
    return np.array([expression[i](()) for i in range(shape[0])] if shape else expression(()))


def test_projections():
    rng = np.random.default_rng(2)
    for _ in range(100):
        g = rng.normal(size=rng.integers(1, 3)) * 10 ** rng.uniform(-3, 3)
        b = 10 ** rng.uniform(-3, 3)
        size, vector = np.linalg.norm(g), ufl.as_vector([*map(float, g)])
        on_ball = b * g / max(b, size)
        np.testing.assert_allclose(number(laws.bounded(b, vector)), on_ball, rtol=1e-14)
        # b P(x / b) = P_b(x): (4') is (4) times b
        scaled = number(laws.ball_projection(vector / b))
        np.testing.assert_allclose(b * scaled, on_ball, rtol=1e-14)
        assert number(laws.slipping(b, vector)) == (size > b)
    for g in ([0.0, 0.0], [1e-30, 0.0], [1.0, 0.0]):
        assert not number(laws.bounded(0.0, ufl.as_vector(g))).any()


@pytest.mark.parametrize("dim", [2, 3])
def test_rows_are_the_printed_ones_times_the_bound(dim):
    """(4') of the compiled form against Lam = P(Lam + rho_t w_t), written in numpy, with
    tau = b Lam and rho_t = rho / b, at any point where there is pressure."""
    eq = equations(dim, PRINTED, Coulomb(MU))
    n, area = eq.fields.surface.size, eq.fields.surface.area
    rng = np.random.default_rng(3)
    for _ in range(30):
        lam, w_n = -(10 ** rng.uniform(-3, 3, n)), rng.uniform(0, 1, n)
        b = -MU * (lam - RHO_N * w_n)  # of the augmented pressure, which is lam in a solution
        w_t = rng.normal(size=(dim - 1, n)) * b / RHO_T
        Lam = rng.normal(size=(dim - 1, n))
        eq.values = values_of(eq, w_n, w_t, lam, b * Lam)
        g_t = Lam + RHO_T / b * w_t
        printed = Lam - g_t / np.maximum(1, np.linalg.norm(g_t, axis=0))
        row = eq.residual()[eq.tractions :].reshape(dim - 1, n)
        np.testing.assert_allclose(row, -area * b / RHO_T * printed, rtol=1e-10, atol=1e-14)


def test_no_nan_of_a_step_that_failed_is_left_in_the_bound():
    """A method of multipliers that ended without numbers left its bound, times nothing, in all
    steps after."""
    eq = equations(2, VELOCITY, Coulomb(MU))
    good = eq.values = np.random.default_rng(5).normal(size=eq.size)
    before = eq.residual()
    eq.values = good * np.nan
    eq.freeze_bound(1.0)
    eq.freeze_bound(0.0)
    eq.values = good
    np.testing.assert_array_equal(eq.residual(), before)


@pytest.mark.parametrize("friction", ["coulomb", "tresca"])
@pytest.mark.parametrize("dim", [2, 3])
def test_residual_vanishes_exactly_on_solutions_of_the_laws(dim, friction):
    """(1)-(5) hold at a point if and only if the multiplier rows of (7) vanish there."""
    eq = equations(dim, PRINTED, FRICTION[friction])
    n = eq.fields.surface.size
    rng = np.random.default_rng(1)

    def rows(w_n, w_t, lam, tau, closed):
        ones = np.ones(n)
        eq.fields.closed.x.array[:] = closed
        eq.values = values_of(eq, w_n * ones, np.outer(w_t, ones), lam * ones, np.outer(tau, ones))
        return np.abs(eq.residual()[eq.jumps :]).max()

    for _ in range(50):
        direction = rng.normal(size=dim - 1)
        direction /= np.linalg.norm(direction)
        lam, speed = -rng.uniform(0.1, 3), rng.uniform(0.1, 3)
        bound = -MU * lam if friction == "coulomb" else 0.4
        zero, full = np.zeros(dim - 1), bound * direction
        inside = 0.7 * full
        solutions = [
            (0.0, zero, lam, inside, 1),  # stick
            (0.0, speed * direction, lam, full, 1),  # slip
            (-speed, speed * direction, 0.0, zero, 1),  # separating
            (speed, speed * direction, 0.0, zero, 0),  # approaching, still open
        ]
        if friction == "coulomb":
            solutions.append((0.0, zero, 0.0, zero, 1))  # grazing
            solutions.append((0.0, speed * direction, 0.0, zero, 1))
        for solution in solutions:
            assert rows(*solution) < 1e-14
        wrong = [
            (0.1, zero, lam, inside, 1),  # penetrates
            (0.0, zero, -lam, zero, 1),  # sticks to the obstacle
            (-speed, zero, lam, inside, 1),  # pressure while separating
            (0.0, speed * direction, lam, inside, 1),  # slips below the limit
            (0.0, speed * direction, lam, -full, 1),  # friction pushes
            (0.0, zero, lam, 1.2 * full, 1),  # beyond the cone
            (0.0, zero, lam, inside, 0),  # pressure across a gap
            (-speed, zero, 0.0, inside, 1),  # friction on an open point
        ]
        for state in wrong:
            assert rows(*state) > 1e-4


def test_unknowns_are_what_is_needed():
    """A frictionless contact has no traction, springs have no normal multiplier."""
    for dim in (2, 3):
        n = len(SURFACES[dim][0])
        assert equations(dim, VELOCITY, Coulomb(MU)).size == 2 * dim * n
        assert equations(dim, VELOCITY).size == (dim + 1) * n
        assert equations(dim, Discrete(1.0), Coulomb(MU)).size == (2 * dim - 1) * n
        assert equations(dim, Discrete(1.0)).size == dim * n


def test_power_of_contact_is_never_positive():
    """The traction of (7) works against the jump: lam w_n = 0 and -tau . w_t <= 0."""
    eq = equations(3, VELOCITY, Coulomb(MU))
    n, area = eq.fields.surface.size, eq.fields.surface.area
    slip = np.outer([0.6, -0.8], np.ones(n))
    eq.fields.start_jump_n.x.array[:] = 0.0
    eq.values = values_of(eq, np.zeros(n), slip, np.full(n, -2.0), MU * 2.0 * slip)
    force = -eq.residual()[: eq.jumps]
    assert force @ eq.values[: eq.jumps] == pytest.approx(-MU * 2.0 * area.sum())
    pushed = (force.reshape(-1, 3) * eq.fields.frame()[0]).sum(axis=1)
    np.testing.assert_allclose(pushed, -2.0 * area)


@pytest.mark.parametrize("dim", [2, 3])
def test_friction_does_no_work_on_the_mean_slip(dim):
    """Whatever the slip at the start: what solves (4') with a given w is against theta w_t + (1 -
    theta) w_t^-, along that where the slip goes on and is not slowed down, and Coulomb's where it
    goes on in the plane."""
    eq, rng = equations(dim, VELOCITY, Coulomb(MU)), np.random.default_rng(5)
    n, k, d = eq.fields.surface.size, eq.fields, dim - 1
    k.start_jump_n.x.array[:] = 0.0
    tangents, turned, rho = tangents_of(eq), 0, 1e9
    k.rho_t.x.array[:] = rho  # with which the row's own fixed point is soon reached
    for _ in range(40):
        theta = rng.uniform(0.5, 1)
        rate = (1 - theta) / theta
        before, slip = rng.normal(size=(2, d, n))
        # at -a, between it and 0, at 0, anywhere
        slip[:, 0], slip[:, 1], slip[:, 2] = -rate * before[:, 0], -0.4 * rate * before[:, 1], 0
        k.start_slip.x.array[:] = np.einsum("dn,dni->ni", before, tangents).ravel()
        eq.set_rates(0.1, 0.2, rate, 0.2)
        tau = rng.normal(size=(d, n))
        for _ in range(20):
            eq.values = values_of(eq, np.zeros(n), slip, np.full(n, -1.0), tau)
            row = rho * eq.residual()[eq.tractions :].reshape(d, n) / eq.weight
            tau = tau + row
        assert np.abs(row).max() < 1e-6
        mean = theta * slip + (1 - theta) * before
        assert (np.linalg.norm(tau, axis=0) <= MU * (1 + 1e-12)).all()
        assert ((tau * mean).sum(axis=0) >= -1e-6).all()
        on = (slip * before).sum(axis=0) > 0
        back = rate * before
        share = (slip * back).sum(axis=0) / np.maximum((back**2).sum(axis=0), 1e-300)
        along = slip + np.clip(share, 0, 1) * back  # which is the mean where share >= 1
        along /= np.maximum(np.linalg.norm(along, axis=0), 1e-300)
        if dim == 2:
            np.testing.assert_allclose(along[:, on], np.sign(slip[:, on]))
        np.testing.assert_allclose(tau[:, on], (MU * along)[:, on], atol=1e-6)
        turned += (~on).sum()
        np.testing.assert_allclose((tau * before).sum(axis=0)[1], 0, atol=1e-6)
    assert turned > 50


@pytest.mark.parametrize("name", [n for n in FORMULATIONS if n != "discrete"])
def test_limit_is_that_of_the_form(name):
    """What a law says in numpy of the speeds that it allows is what its form does."""
    law = FORMULATIONS[name]
    eq = equations(2, law)
    n, k, rng = eq.fields.surface.size, eq.fields, np.random.default_rng(4)
    fast = 1e3  # pressed whatever the limit is
    for _ in range(50):
        gap, start = rng.normal(size=n), rng.normal(size=n)
        gap_rate, dt, limit_rate = rng.uniform(0.1, 2, 3)
        k.gap.x.array[:], k.start_jump_n.x.array[:] = gap, start
        eq.set_rates(gap_rate, 2 * dt, limit_rate, dt)
        eq.values = values_of(eq, np.full(n, fast), np.zeros((1, n)), np.full(n, -1.0), np.empty(0))
        row = eq.residual()[eq.jumps :] / eq.weight  # -(w_n - limit)
        data = StepData(gap, start, gap_rate, limit_rate, dt)
        np.testing.assert_allclose(fast + row, law.limit(data), rtol=0, atol=1e-10)
    decides = getattr(law, "closed", None)
    assert bool(decides) == isinstance(law, Printed)
    if decides:
        assert decides(np.array([-1.0, 1.0]), 0.0).tolist() == [False, True]


def spring_work(spring, a, b, mean_share, dt=0.3):
    """Work [J] that springs take up on the way of their gaps from a to b (n,), in a step."""
    eq = equations(2, spring)
    k = eq.fields
    k.start_gap.x.array[:], k.gap.x.array[:] = a, b  # w = 0: b is where the step ends
    k.mean_share.value = mean_share
    eq.set_rates(0.1, dt, 0.0, dt)
    eq.values = np.zeros(eq.size)
    force = (eq.residual().reshape(-1, 2) * k.frame()[0]).sum(axis=1)
    return force * (b - a)


def test_springs_conserve_energy_in_the_mean_and_dissipate_at_the_end():
    """Over any way, penetrated or not at its ends: at theta = 1/2 their work is the change of
    k d+^2/2, else, and with dashpots, at least that."""
    stiffness, rng = 3.0, np.random.default_rng(5)
    stored = lambda d: 0.5 * stiffness * np.maximum(d, 0.0) ** 2  # noqa: E731
    for _ in range(6):
        a, b = rng.normal(size=(2, 3)) * 10 ** rng.uniform(-6, 1)
        change, size = stored(b) - stored(a), stored(np.abs(a)) + stored(np.abs(b))
        plain, damped = Discrete(stiffness), Discrete(stiffness, damping=0.4)
        np.testing.assert_allclose(spring_work(plain, a, b, 1.0), change, atol=1e-14 * size.max())
        for share in (0.0, 0.6):
            assert (spring_work(plain, a, b, share) >= change - 1e-14 * size).all()
        for share in (0.0, 0.6, 1.0):
            assert (spring_work(damped, a, b, share) >= change - 1e-14 * size).all()
