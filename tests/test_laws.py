# SPDX-License-Identifier: LGPL-3.0-or-later
"""The laws (1)-(6) point by point, and the tangents of the weak form (7) by finite differences."""

import itertools

import numpy as np
import pytest

from fenicsx_contact import GAP, VELOCITY, Discrete, Lagrange, Velocity
from fenicsx_contact.contact.equations import SurfaceEquations
from fenicsx_contact.contact.surface import Surface

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
    "corrected": Velocity(drift_correction=0.5),
    "gap": GAP,
    "lagrange": Lagrange(),
    "discrete": Discrete(stiffness=3.0, damping=0.4, tangential_stiffness=2.0),
}
#: For each state: w_n, w_t, lam, |Lam|, gap. rho_n = 2, rho_t = 5, mu = 0.3, see below.
STATES = {
    "stick": (0.01, 0.02, -1.0, 0.4, 0.05),
    "slip": (0.01, 0.7, -1.0, 0.9, 0.05),
    "open": (-1.0, 0.3, -0.1, 0.2, 0.02),
    "grazing": (0.02, 0.03, -1e-6, 0.1, 0.03),
    "zero velocity": (0.0, 0.0, -1.0, 0.0, 0.05),
    "nothing": (-0.4, 0.0, 0.0, 0.0, -0.3),
}


def equations(dim, formulation, friction):
    """Equations on a small surface, normal down the last axis, with awkward parameters."""
    surface = Surface(*SURFACES[dim])
    n = surface.size
    points = isinstance(formulation, (Lagrange, Discrete))
    weight = np.ones(n) if points else surface.area
    eq = SurfaceEquations(surface, formulation, friction, np.ones(n, bool), weight, (1.0, 1.0))
    normal = np.zeros((n, dim))
    normal[:, -1] = -1.0
    eq.fields.set_normal(normal)
    eq.set_scale(2.0, 1.0)
    eq.fields.rho_t.value = 5.0
    eq.fields.pressure_scale.value = 1.0
    eq.set_rates(0.1, 0.2)
    return eq


def set_state(eq, state, dim):
    """The same state at each point, a little different each, so that nothing cancels."""
    w_n, w_t, lam, Lam, gap = STATES[state]
    n = eq._surface.size
    vary = 1 + 0.1 * np.arange(n)
    normal, tangents = eq.fields.frame()
    if not len(tangents):
        tangents = np.zeros((2, n, 3))
        tangents[0, :, 0], tangents[1, :, 1] = 1.0, 1.0
    direction = np.array([1.0]) if dim == 2 else np.array([0.8, 0.6])
    along = np.einsum("i,ijk->jk", direction, tangents)
    values = np.zeros(eq.size)
    jump = w_n * vary[:, None] * normal + w_t * vary[:, None] * along
    values[: eq.jumps] = jump.ravel()
    values[eq.jumps : eq.semi] = lam * vary if eq.semi > eq.jumps else 0
    if eq.size > eq.semi:
        values[eq.semi :] = np.outer(direction, Lam * vary).ravel()
    eq.values = values
    eq.fields.gap.x.array[:] = gap * vary
    return values


@pytest.mark.parametrize("friction", [0.3, 0.0])
@pytest.mark.parametrize("name", FORMULATIONS)
@pytest.mark.parametrize("dim", [2, 3])
def test_tangent_of_each_block(dim, name, friction):
    eq = equations(dim, FORMULATIONS[name], friction)
    blocks = {"w": slice(0, eq.jumps), "lam": slice(eq.jumps, eq.semi), "Lam": slice(eq.semi, None)}
    for state in STATES:
        base = set_state(eq, state, dim)
        exact = eq.tangent().copy()
        assert np.isfinite(exact).all()
        scale = np.abs(exact).max()
        step = 1e-7 if state != "grazing" else 1e-8
        numeric = np.zeros_like(exact)
        for j in range(eq.size):
            sides = []
            for sign in (1, -1):
                moved = base.copy()
                moved[j] += sign * step
                eq._z[eq._order] = moved  # the weight of the friction row stays, as in Newton
                sides.append(eq.residual())
            numeric[:, j] = (sides[0] - sides[1]) / (2 * step)
        if state == "zero velocity" and name == "discrete" and friction:
            continue  # a spring's radial return has a kink where force and limit both vanish
        for (a, rows), (b, columns) in itertools.product(blocks.items(), repeat=2):
            difference = np.abs(exact[rows, columns] - numeric[rows, columns]).max(initial=0.0)
            assert difference <= 1e-6 * scale, f"{state}: d F_{a} / d {b}"


def test_stick_tangent_is_symmetric():
    eq = equations(2, VELOCITY, 0.3)
    values = set_state(eq, "stick", 2)
    values[: eq.jumps] = 0.0  # in stick w_t = 0 and w_n = 0
    eq.values = values
    K = eq.tangent()
    tangential = np.arange(0, eq.jumps, 2)  # the normal is -y
    coupling = K[tangential][:, eq.semi :]
    np.testing.assert_allclose(coupling, K[eq.semi :][:, tangential].T, rtol=1e-12)
    normal = K[1 : eq.jumps : 2][:, eq.jumps : eq.semi]
    np.testing.assert_allclose(normal, K[eq.jumps : eq.semi][:, 1 : eq.jumps : 2].T, rtol=1e-12)


@pytest.mark.parametrize("dim", [2, 3])
def test_residual_vanishes_exactly_on_solutions_of_the_laws(dim):
    """(1)-(5) hold at a point if and only if the multiplier rows of (7) vanish there."""
    eq = equations(dim, VELOCITY, 0.3)
    n, d = eq._surface.size, dim
    normal, tangents = eq.fields.frame()
    rng = np.random.default_rng(1)

    def rows(w_n, w_t, lam, Lam, closed):
        values = np.zeros(eq.size)
        jump = w_n * normal + np.einsum("i,ijk->jk", w_t, tangents)
        values[: eq.jumps] = jump.ravel()
        values[eq.jumps : eq.semi] = lam
        values[eq.semi :] = np.repeat(Lam, n)
        eq.fields.closed.x.array[:] = closed
        eq.values = values
        return np.abs(eq.residual()[eq.jumps :]).max()

    for _ in range(50):
        direction = rng.normal(size=d - 1)
        direction /= np.linalg.norm(direction)
        lam, speed = -rng.uniform(0.1, 3), rng.uniform(0.1, 3)
        zero, inside = np.zeros(d - 1), 0.7 * direction
        solutions = [
            (0.0, zero, lam, inside, 1),  # stick
            (0.0, speed * direction, lam, direction, 1),  # slip
            (-speed, speed * direction, 0.0, zero, 1),  # separating
            (speed, speed * direction, 0.0, zero, 0),  # approaching, still open
            (0.0, zero, 0.0, zero, 1),  # grazing
        ]
        for solution in solutions:
            assert rows(*solution) < 1e-14
        wrong = [
            (0.1, zero, lam, inside, 1),  # penetrates
            (0.0, zero, -lam, zero, 1),  # sticks to the obstacle
            (-speed, zero, lam, inside, 1),  # pressure while separating
            (0.0, speed * direction, lam, inside, 1),  # slips below the limit
            (0.0, speed * direction, lam, -direction, 1),  # friction pushes
            (0.0, zero, lam, 1.2 * direction, 1),  # beyond the cone
            (0.0, zero, lam, inside, 0),  # pressure across a gap
            (-speed, zero, 0.0, inside, 1),  # semi-multiplier of an open point
        ]
        for state in wrong:
            assert rows(*state) > 1e-4


def test_frictionless_contact_has_no_semi_multiplier_and_springs_no_multiplier():
    for dim in (2, 3):
        n = len(SURFACES[dim][0])
        assert equations(dim, VELOCITY, 0.3).size == 2 * dim * n
        assert equations(dim, VELOCITY, 0.0).size == (dim + 1) * n
        assert equations(dim, Discrete(1.0), 0.3).size == dim * n


def test_power_of_contact_is_never_positive():
    """The traction of (7) works against the jump: lam w_n = 0 and mu lam Lam . w_t <= 0."""
    eq = equations(3, VELOCITY, 0.3)
    n = eq._surface.size
    normal, tangents = eq.fields.frame()
    slip = np.array([0.6, -0.8])
    values = np.zeros(eq.size)
    values[: eq.jumps] = np.einsum("i,ijk->jk", slip, tangents).ravel()
    values[eq.jumps : eq.semi] = -2.0
    values[eq.semi :] = np.repeat(slip, n)
    eq.values = values
    force = -eq.residual()[: eq.jumps]
    assert force @ values[: eq.jumps] == pytest.approx(-0.3 * 2.0 * eq._surface.area.sum())
    pushed = (force.reshape(-1, 3) * normal).sum(axis=1)
    np.testing.assert_allclose(pushed, -2.0 * eq._surface.area)
