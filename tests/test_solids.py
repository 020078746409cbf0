# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solids without contact: exact solutions, and the orders with which errors fall."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
import ufl
from mpi4py import MPI
from problems import bar_at_wall
from scenes import G, box, check_energies, rates, rectangle, total_energy
from scipy.spatial.transform import Rotation

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    InputError,
    RigidSolid,
    Scene,
    ThetaScheme,
    ciarlet,
    mesh_from_gmsh,
    name_facets,
    neo_hookean,
    st_venant_kirchhoff,
)
from fenicsx_contact.solids.factor import Direct
from fenicsx_contact.solids.neighbourhood import ABOUT, yielding
from fenicsx_contact.solve.solid_rows import petsc_matrix
from fenicsx_contact.theory.scheme import Step

CELLS_2D, CELLS_3D = ("triangle", "quadrilateral"), ("tetrahedron", "hexahedron")
CELLS = CELLS_2D + CELLS_3D


def fly(solid, until, dt, theta=0.5, forces="theta", probes=None):
    """A run of one solid without contact."""
    scheme = ThetaScheme(theta, forces)
    scene = Scene([solid], [], scheme, allow_free=True, allow_growth=True)
    history = scene.run(until, dt, probes=probes)
    assert history.finished, history.reason
    return history


def mesh_of(cell, n, size):
    """A rectangle or box of ``size`` with n cells along x and one or two across."""
    if cell in CELLS_2D:
        return rectangle((n, 2), size[:2], cell)
    return box((n, 2, 1), size, cell)


def sheared(mesh, matrix):
    """The mesh under an affine map."""
    d = len(matrix)
    mesh.mesh.geometry.x[:, :d] = mesh.mesh.geometry.x[:, :d] @ np.transpose(matrix)
    return mesh


# -- rigid solids --


@pytest.mark.parametrize("cell", CELLS)
def test_mass_centre_and_inertia_are_those_of_a_parallelepiped(cell):
    size, rho = np.array([0.36, 0.50, 0.80]), 1450.0
    d = 2 if cell in CELLS_2D else 3
    A = np.array([[1.0, 0.3, -0.2], [0.1, 1.2, 0.4], [0.2, -0.3, 0.9]])[:d, :d]
    mesh = rectangle((2, 1), size[:2], cell) if d == 2 else box((2, 1, 1), size, cell)
    solid = RigidSolid(sheared(mesh, A), density=rho)

    mass = rho * size[:d].prod() * np.linalg.det(A)
    centre = A @ (size[:d] / 2 * np.eye(d)[-1])  # the base is centred, the block stands on it
    second = mass / 12 * A @ np.diag(size[:d] ** 2) @ A.T
    inertia = np.trace(second) * np.eye(3) - second if d == 3 else [[np.trace(second)]]
    assert solid.mass == pytest.approx(mass, rel=1e-13)
    np.testing.assert_allclose(solid.place, centre, rtol=0, atol=1e-14)
    np.testing.assert_allclose(solid.inertia, inertia, rtol=0, atol=1e-13 * np.trace(second))

    same = RigidSolid(sheared(mesh, np.eye(d)), mass=mass)
    np.testing.assert_allclose(same.inertia, solid.inertia, rtol=1e-12)


@pytest.mark.parametrize("theta", [0.0, 0.5, 0.75, 1.0])
def test_free_flight_is_exact_for_one_half_and_off_by_g_t_dt_else(theta):
    start, v, g, spin, until, dt = (0.2, 1.5), (3.0, 2.0), (0.5, -G), -4.0, 0.8, 0.01
    solid = RigidSolid(
        rectangle(), mass=3.0, gravity=g, velocity=v, spin=spin, rotation=0.3, about=start
    )
    place = solid.place
    history = fly(solid, until, dt, theta)
    exact = place + until * np.array(v) + until**2 / 2 * np.array(g)
    error = (theta - 0.5) * until * dt * np.array(g)
    np.testing.assert_allclose(solid.place, exact + error, rtol=0, atol=1e-13)
    np.testing.assert_allclose(solid.velocity, [*(np.array(v) + until * np.array(g)), spin])
    assert solid.spin == solid.velocity[2]
    turn = solid.rotation - 0.3 - spin * until
    assert turn == pytest.approx(2 * np.pi * round(turn / (2 * np.pi)), abs=1e-13)
    assert np.abs(history["balance"]).max() < 1e-12 * history["kinetic"][0]
    if theta == 0.5:
        total = total_energy(history)
        np.testing.assert_allclose(total, total[0], rtol=1e-13)


def test_initial_rotation_turns_about_the_pivot():
    solid = RigidSolid(rectangle(), mass=1.0, rotation=np.pi / 2, about=(-0.18, 0.0))
    np.testing.assert_allclose(solid.place, [-0.18 - 0.4, 0.18], atol=1e-15)
    moved = solid.mesh.mesh.geometry.x[:, :2] + solid.fields()["displacement"]
    np.testing.assert_allclose(moved.max(axis=0), [-0.18, 0.36], atol=1e-15)
    np.testing.assert_allclose(moved.min(axis=0), [-0.98, 0.0], atol=1e-15)


def test_velocity_field_of_a_rigid_solid_is_the_rate_of_its_displacement():
    solid = RigidSolid(
        box(), mass=1.0, rotation=(0.3, -0.2, 0.5), velocity=(1, 2, 3), spin=(0.4, -0.7, 1.1)
    )
    before, dt = solid.fields(), 1e-6
    np.testing.assert_array_equal(solid.spin, (0.4, -0.7, 1.1))
    fly(solid, dt, dt)
    rate = (solid.fields()["displacement"] - before["displacement"]) / dt
    np.testing.assert_allclose(rate, before["velocity"], rtol=0, atol=1e-5)


def test_tumbling_keeps_angular_momentum_and_energy_at_second_order():
    """Spin about the middle axis, which turns over."""
    errors = []
    for steps in (400, 800, 1600):
        solid = RigidSolid(box(), mass=417.6, rotation=(0.3, 0.2, 0.1), spin=(0.2, 8.0, 2.5))

        def in_body(i, solid=solid):
            return Rotation.from_rotvec(solid.rotation).inv().apply(solid.velocity[3:])[i]

        def angular(i, solid=solid):
            R = Rotation.from_rotvec(solid.rotation).as_matrix()
            return (R @ solid.inertia @ R.T @ solid.velocity[3:])[i]

        probes = {f"L{i}": lambda i=i, f=angular: f(i) for i in range(3)}
        probes["middle"] = lambda f=in_body: f(1)
        history = fly(solid, 2.0, 2.0 / steps, probes=probes)
        momentum = np.stack([history[f"L{i}"] for i in range(3)])
        drift = np.linalg.norm(momentum - momentum[:, :1], axis=0)
        assert drift.max() < 1e-12 * np.linalg.norm(momentum[:, 0])
        assert history["middle"].max() > 6 and history["middle"].min() < -6
        kinetic = history["kinetic"]
        errors.append(np.abs(kinetic / kinetic[0] - 1).max())
    assert errors[0] < 1e-2
    np.testing.assert_allclose(rates(errors), 2, atol=0.1)


@pytest.mark.parametrize(("theta", "order"), [(0.5, 2), (1.0, 1)])
def test_symmetric_top_precesses(theta, order):
    """``R(t) = exp(t L/I1) exp(t (1 - I3/I1) w3 e3)`` is exact where two inertias are equal."""
    spin, until, errors = np.array([1.5, 0.0, 4.0]), 1.0, []
    for steps in (100, 200, 400):
        solid = RigidSolid(box(size=(0.4, 0.4, 0.9)), mass=2.0, spin=spin)
        I1, _, I3 = solid.inertia.diagonal()
        fly(solid, until, until / steps, theta)
        L = solid.inertia @ spin
        exact = Rotation.from_rotvec(until * L / I1) * Rotation.from_rotvec(
            [0, 0, until * (1 - I3 / I1) * spin[2]]
        )
        errors.append((Rotation.from_rotvec(solid.rotation) * exact.inv()).magnitude())
    assert errors[-1] < 0.02
    np.testing.assert_allclose(rates(errors), order, atol=0.1)


# -- elastic solids: space --


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("cell", CELLS)
def test_energies_of_linear_fields_are_exact(cell, degree):
    """All elastic constants at once: uniform strain and a linear velocity are in every space."""
    E, nu, rho, size = 2.1e9, 0.3, 1450.0, np.array([0.36, 0.50, 0.80])
    d = 2 if cell in CELLS_2D else 3
    H = 1e-3 * np.array([[1.0, 0.5, -0.3], [-0.2, 0.7, 0.4], [0.6, -0.8, -1.1]])[:d, :d]
    solid = ElasticSolid(
        mesh_of(cell, 2, size),
        youngs_modulus=E,
        poisson_ratio=nu,
        density=rho,
        degree=degree,
        gravity=[0.1, 0.2, -G][:d],
        displacement=lambda x: H @ x[:d],
        velocity=lambda x: H @ x[:d],
    )
    volume = size[:d].prod()
    e, mu, lmbda = (H + H.T) / 2, E / 2 / (1 + nu), E * nu / (1 + nu) / (1 - 2 * nu)
    strain = volume * (lmbda / 2 * np.trace(e) ** 2 + mu * (e * e).sum())
    half = size[:d] / 2
    centre = np.eye(d)[-1] * half
    second = rho * volume * (np.diag(half**2) / 3 + np.outer(centre, centre))
    kinetic = np.trace(H @ second @ H.T) / 2
    potential = -rho * volume * np.array([0.1, 0.2, -G][:d]) @ H @ centre
    np.testing.assert_allclose(solid.energies(), [kinetic, strain, potential], rtol=1e-12)


def hang(mesh, degree):
    """A bar of 1 m along x under a weight along x at rest, and its history: implicit Euler at
    large steps (a wave crosses in 0.03 s). ``u = rho g (L s - s²/2)/E`` for nu = 0."""
    d = mesh.dim
    solid = ElasticSolid(
        mesh,
        youngs_modulus=1e6,
        poisson_ratio=0.0,
        density=1000.0,
        degree=degree,
        gravity=[G, 0.0, 0.0][:d],
        fixed=["left"],
    )
    return solid, fly(solid, 400.0, 100.0, theta=1.0)


HANGING_ENERGY = (1000.0 * G) ** 2 / 6 / 1e6 * 0.4  # J in 2D, times the depth in 3D


@pytest.mark.parametrize(
    ("cell", "degree"), [("quadrilateral", 1), ("hexahedron", 1), *((cell, 2) for cell in CELLS)]
)
def test_bar_under_its_weight_is_exact(cell, degree):
    """Quadratic, so in every P2 space, and nodally exact in P1 where it is one-dimensional."""
    solid, history = hang(mesh_of(cell, 4, (1.0, 0.4, 0.3)), degree)
    s = solid.mesh.mesh.geometry.x[:, 0] + 0.5
    exact = np.zeros((len(s), solid.dim))
    exact[:, 0] = 1000.0 * G * (s - s**2 / 2) / 1e6
    u = solid.fields()["displacement"]
    np.testing.assert_allclose(u, exact, rtol=0, atol=1e-11 * exact.max())
    if degree == 2:
        energy = HANGING_ENERGY * (0.3 if solid.dim == 3 else 1.0)
        assert history["strain"][-1] == pytest.approx(energy, rel=1e-11)


@pytest.mark.parametrize("cell", ["triangle", "tetrahedron"])
def test_bar_of_linear_simplices_converges(cell):
    """The energy from below, at second order."""
    errors = []
    for n in (2, 4, 8):
        mesh = (
            rectangle((2 * n, n), (1.0, 0.4), cell)
            if cell == "triangle"
            else box((2 * n, n, n), (1.0, 0.4, 0.3), cell)
        )
        solid, history = hang(mesh, 1)
        energy = HANGING_ENERGY * (0.3 if solid.dim == 3 else 1.0)
        errors.append(1 - history["strain"][-1] / energy)
    assert 0 < errors[-1] < 0.02
    np.testing.assert_allclose(rates(errors), 2, atol=0.2)


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("cell", CELLS)
def test_first_axial_frequency_of_a_bar_converges(cell, degree):
    """The Rayleigh quotient of the interpolated mode: order 2 degree over ``pi/2L sqrt(E/rho)``."""
    E, rho, L, errors = 4e5, 1000.0, 1.0, []
    d = 2 if cell in CELLS_2D else 3
    exact = np.pi / 2 / L * np.sqrt(E / rho)
    for n in (4, 8):

        def mode(x):
            return np.stack([np.sin(np.pi / 2 * (x[0] / L + 0.5)), *(0 * x[1:d])])

        solid = ElasticSolid(
            mesh_of(cell, n, (L, 0.4, 0.3)),
            youngs_modulus=E,
            poisson_ratio=0.0,
            density=rho,
            degree=degree,
            fixed=["left"],
            displacement=mode,
            velocity=mode,
        )
        kinetic, strain, _ = solid.energies()
        errors.append(np.sqrt(strain / kinetic) / exact - 1)
    assert 0 < errors[-1] < 0.002
    assert rates(errors)[0] == pytest.approx(2 * degree, abs=0.1)


# -- elastic solids: time --

MODULUS, DENSITY, CELLS_ALONG = 4e5, 1000.0, 8


def discrete_frequency(modulus=MODULUS):
    """Of the first axial mode of ``CELLS_ALONG`` bilinear cells, rad/s."""
    h, k = 1.0 / CELLS_ALONG, np.pi / 2
    ratio = 6 / h**2 * (1 - np.cos(k * h)) / (2 + np.cos(k * h))
    return np.sqrt(modulus / DENSITY * ratio)


def vibrate(theta, forces, z, cycles, energy=None):
    """Amplitudes of a bar released in its first discrete mode, at steps of z/omega, and history."""
    others = {
        "density": DENSITY,
        "fixed": ["left"],
        "displacement": lambda x: np.stack([1e-3 * np.sin(np.pi / 2 * (x[0] + 0.5)), 0 * x[1]]),
    }
    mesh = rectangle((CELLS_ALONG, 2), (1.0, 0.4))
    solid = (
        ElasticSolid(mesh, youngs_modulus=MODULUS, poisson_ratio=0.0, **others)
        if energy is None
        else HyperelasticSolid(mesh, energy=energy, **others)
    )
    shape = solid.displacement.copy()
    dt = z / discrete_frequency()
    history = fly(
        solid,
        round(2 * np.pi * cycles / z) * dt,
        dt,
        theta,
        forces,
        probes={"q": lambda: solid.displacement @ shape / (shape @ shape)},
    )
    return history["q"], history


def exponent(q):
    """``log(root)`` of the recursion ``q[n+1] = a q[n] + b q[n-1]`` that a vibration obeys."""
    (a, b), *_ = np.linalg.lstsq(np.stack([q[1:-1], q[:-2]], axis=1), q[2:], rcond=None)
    np.testing.assert_allclose(q[2:], a * q[1:-1] + b * q[:-2], rtol=0, atol=1e-9)
    return np.log(a / 2 + 1j * np.sqrt(-b - a**2 / 4))


@pytest.mark.parametrize(
    ("theta", "forces", "order"),
    [(0.5, "theta", 2), (1.0, "theta", 1), (0.5, "end", 1), (1.0, "end", 1)],
)
def test_order_of_the_time_scheme(theta, forces, order):
    errors = []
    for steps in (80, 160, 320):
        q, _ = vibrate(theta, forces, 2 * np.pi / steps, 1)
        errors.append(np.abs(q - np.cos(2 * np.pi / steps * np.arange(len(q)))).max())
    assert errors[-1] < 0.07  # pi z/2 for implicit Euler: the damping ratio times 2 pi
    np.testing.assert_allclose(rates(errors), order, atol=0.1)


def test_one_half_is_the_trapezoidal_rule():
    """``omega dt`` turns into ``2 atan(omega dt/2)``; amplitude and energy stay."""
    z = 0.3
    q, history = vibrate(0.5, "theta", z, 20)
    np.testing.assert_allclose(q, np.cos(2 * np.arctan(z / 2) * np.arange(len(q))), atol=1e-10)
    total = total_energy(history)
    np.testing.assert_allclose(total, total[0], rtol=1e-12)
    assert np.abs(history["scheme"]).max() < 1e-12 * total[0]


@pytest.mark.parametrize(
    ("theta", "forces", "slope"),
    [
        (0.5, "end", 0.25),
        (0.75, "theta", 0.25),
        (0.6, "theta", 0.1),
        (1.0, "theta", 0.5),
        (1.0, "end", 0.5),
    ],
)
def test_damping_ratio(theta, forces, slope):
    """theta omega dt/2 as printed, (theta - 1/2) omega dt at the theta-point, to second order."""
    assert slope == (theta / 2 if forces == "end" else pytest.approx(theta - 0.5))
    errors = []
    for z in (0.08, 0.04, 0.02):
        s = exponent(vibrate(theta, forces, z, 1)[0])
        errors.append(abs(-s.real / abs(s) / (slope * z) - 1))
    assert errors[-1] < 0.01
    assert rates(errors).min() > 0.9


@pytest.mark.parametrize(("fixed", "round_off"), [((), 1e-11), (("base",), 1e-12)])
def test_energy_of_an_elastic_block_is_kept(fixed, round_off):
    """Free, it also moves away: K times a large rigid displacement leaves more round-off."""
    solid = ElasticSolid(
        rectangle((3, 4), cell="triangle"),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        fixed=fixed,
        velocity=lambda x: np.stack([0.1 - x[1] + x[0] ** 2, x[0] - 2 * x[1] ** 2]),
    )

    def momentum():
        return solid._momentum.reshape(-1, 2).sum(axis=0)

    before = momentum()
    history = fly(solid, 0.5, 1e-3)
    total = total_energy(history)
    assert history["strain"].max() > 0.01 * total[0]
    np.testing.assert_allclose(total, total[0], rtol=round_off)
    if not fixed:
        np.testing.assert_allclose(momentum(), before, rtol=1e-11)
    check_energies(history)


def test_weight_gives_the_momentum_of_free_fall():
    solid = ElasticSolid(
        box((1, 2, 2)), youngs_modulus=1e6, poisson_ratio=0.3, density=1000.0, gravity=(0, 0, -G)
    )
    fly(solid, 0.3, 0.01)
    u, v = solid.fields()["displacement"], solid.fields()["velocity"]
    np.testing.assert_allclose(v, np.broadcast_to([0, 0, -G * 0.3], v.shape), atol=1e-10)
    np.testing.assert_allclose(u, np.broadcast_to([0, 0, -G * 0.045], u.shape), atol=1e-10)


# -- hyperelastic solids --

YOUNG, POISSON = 1e6, 0.3
ENERGIES = {
    "st_venant_kirchhoff": st_venant_kirchhoff(YOUNG, POISSON),
    "neo_hookean": neo_hookean(YOUNG, POISSON),
    "ciarlet": ciarlet(YOUNG, POISSON),
}


def bent(amplitude):
    """A displacement without symmetry."""
    return lambda x: (
        amplitude
        * np.stack([x[1] ** 2 + 0.5 * x[0] * x[1], 0.7 * x[0] ** 2 - 0.4 * x[1] - 0.3 * x[0]])
    )


@pytest.mark.parametrize("energy", ENERGIES)
def test_small_motions_are_those_of_the_elastic_solid(energy):
    others = {"density": 1000.0, "fixed": ["base"], "gravity": (0.0, 0.0)}
    errors = []
    for amplitude in (1e-2, 1e-3, 1e-4):
        motion = {**others, "displacement": bent(amplitude)}
        linear = ElasticSolid(
            rectangle((2, 3)), youngs_modulus=YOUNG, poisson_ratio=POISSON, **motion
        )
        solid = HyperelasticSolid(rectangle((2, 3)), energy=ENERGIES[energy], **motion)
        fly(linear, 0.02, 1e-3)
        history = fly(solid, 0.02, 1e-3)
        assert history["geometry"].max() <= 5
        size = np.abs(linear.displacement).max()
        assert size > 0.1 * amplitude
        errors.append(np.abs(solid.displacement - linear.displacement).max())
    assert errors[0] < 0.05 * 1e-2
    np.testing.assert_allclose(rates(errors, 10.0), 2, atol=0.1)


@pytest.mark.parametrize("energy", ENERGIES)
@pytest.mark.parametrize("cell", ["quadrilateral", "tetrahedron"])
def test_rotation_strains_nothing(energy, cell):
    d = 2 if cell in CELLS_2D else 3
    R = Rotation.from_rotvec([0.0, 0.0, 1.2] if d == 2 else [0.8, -0.5, 0.9]).as_matrix()[:d, :d]
    mesh = rectangle((2, 3)) if d == 2 else box(cell=cell)
    solid = HyperelasticSolid(
        mesh,
        energy=ENERGIES[energy],
        density=1000.0,
        displacement=lambda x: R @ x[:d] - x[:d] + 0.4,
    )
    size = YOUNG * 0.36 * 0.8
    assert abs(solid.energies()[1]) < 1e-14 * size
    assert np.abs(solid.internal_force(solid.displacement)).max() < 1e-13 * size


@pytest.mark.parametrize("energy", ENERGIES)
def test_uniaxial_stretch_energy(energy):
    """In plane strain F = diag(a, b, 1): the printed formulas, on quadratic triangles."""
    a, b, nu = 1.3, 0.8, POISSON
    solid = HyperelasticSolid(
        rectangle((1, 2), cell="triangle"),
        energy=ENERGIES[energy],
        density=1000.0,
        degree=2,
        displacement=lambda x: np.stack([(a - 1) * x[0], (b - 1) * x[1]]),
    )
    lmbda, mu = YOUNG * nu / (1 + nu) / (1 - 2 * nu), YOUNG / 2 / (1 + nu)
    e, J = np.array([a**2 - 1, b**2 - 1]) / 2, a * b
    expected = {
        "st_venant_kirchhoff": lmbda / 2 * e.sum() ** 2 + mu * (e**2).sum(),
        "neo_hookean": mu / 2 * (a**2 + b**2 - 2 - 2 * np.log(J)) + lmbda / 2 * np.log(J) ** 2,
        "ciarlet": mu / 2 * (a**2 + b**2 - 2 - 2 * np.log(J))
        + lmbda / 4 * (J**2 - 1 - 2 * np.log(J)),
    }[energy]
    assert solid.energies()[1] == pytest.approx(0.36 * 0.8 * expected, rel=1e-12)


def swinging(energy, steps, until=0.1):
    """A free block in large strain and rotation, its history, and its momenta before and after."""
    solid = HyperelasticSolid(
        rectangle((2, 3)), energy=energy, density=1000.0, velocity=lambda x: 4 * bent(1.0)(x)
    )
    x = solid.space.tabulate_dof_coordinates()[:, :2]

    def momenta():
        p, at = solid._momentum.reshape(-1, 2), x + solid.displacement.reshape(-1, 2)
        return np.array([*p.sum(axis=0), (at[:, 0] * p[:, 1] - at[:, 1] * p[:, 0]).sum()])

    before = momenta()
    history = fly(solid, until, until / steps)
    assert history["strain"].max() > 0.1 * total_energy(history)[0]
    return solid, history, before, momenta()


@pytest.mark.parametrize("energy", ENERGIES)
def test_finite_vibration_keeps_momentum_and_energy(energy):
    """Angular momentum at second order."""
    errors = []
    for steps in (50, 100, 200):
        _, history, before, after = swinging(ENERGIES[energy], steps)
        check_energies(history, 1e-7)  # the outer loop ends at 1e-8
        total = total_energy(history)
        np.testing.assert_allclose(total, total[0], rtol=1e-7)
        np.testing.assert_allclose(after[:2], before[:2], rtol=1e-7)
        errors.append(abs(after[2] / before[2] - 1))
    assert errors[0] < 0.01
    np.testing.assert_allclose(rates(errors), 2, atol=0.25)


@pytest.mark.second
def test_finite_vibration_converges_at_second_order():
    ends = [
        swinging(ENERGIES["neo_hookean"], steps)[0].displacement for steps in (100, 200, 400, 800)
    ]
    changes = [np.abs(a - b).max() for a, b in zip(ends[:-1], ends[1:])]
    assert changes[-1] < 1e-3 * np.abs(ends[-1]).max()
    np.testing.assert_allclose(rates(changes), 2, atol=0.1)


@pytest.mark.parametrize("theta", [0.0, 0.3, 0.5, 0.8, 1.0])
@pytest.mark.parametrize("forces", ["theta", "end"])
def test_points_of_the_forces_are_a_mean(theta, forces):
    """Of weight 1, about the theta-point: so a linear solid has its force there."""
    scheme = ThetaScheme(theta, forces)
    shares, weights = np.array(scheme.force_points).T
    assert weights.sum() == pytest.approx(1, abs=1e-15) and weights.min() > 0
    assert weights @ shares == pytest.approx(scheme.force_weight, abs=1e-15)
    assert len(shares) == (1 if forces == "end" or theta in (0, 1) else 3 if theta == 0.5 else 4)


@pytest.mark.parametrize(
    ("theta", "forces"), [(0.5, "theta"), (0.8, "theta"), (0.3, "theta"), (1.0, "end")]
)
def test_tangent_of_a_step(theta, forces):
    """Against central differences of the momentum balance."""
    solid = HyperelasticSolid(
        rectangle((2, 3)),
        energy=ENERGIES["neo_hookean"],
        density=1000.0,
        displacement=bent(0.3),
        fixed=["base"],
        velocity=bent(20.0),
    )
    step = Step(0.01, ThetaScheme(theta, forces))
    solid.predict(step)
    start, way = solid.trial_velocity, np.zeros(solid.owned)
    free = np.setdiff1d(np.arange(solid.owned), solid.fixed_unknowns)
    way[free] = np.random.default_rng(1).standard_normal(len(free))
    solid.linearise(step)
    computed = solid.multiply(solid.factorisation.matrix, way)[free]
    ends, h = [], 1e-4
    for sign in (1, -1):
        solid.go(start + sign * h * way, step)
        ends.append(np.sum(solid._balance(step), axis=0)[free])
    np.testing.assert_allclose(
        computed, (ends[0] - ends[1]) / (2 * h), rtol=0, atol=1e-7 * np.abs(computed).max()
    )


@pytest.mark.parametrize(
    ("speed", "cfl", "until"),
    [(1 / 3, 1.0, 1.0), pytest.param(1.0, 0.3, 0.6, marks=pytest.mark.second)],
)
def test_violent_impact_makes_no_energy(speed, cfl, until, monkeypatch):
    """A bar thrown at a wall at a third of its wave speed and at all of it; the forces of the
    midpoint make 0.5 and 9 % of its energy. By the second it is torn about: an element of it may
    turn over long after it has left the wall, which the machine decides."""

    def made():
        bar = bar_at_wall(cells=20, hyperelastic=True, speed=speed, cfl=cfl)
        history = bar.scene.run(until, bar.dt)
        assert not history["wall.bearing"][-1]
        total = total_energy(history)
        rise = (total - total[0]).max() / total[0]
        return history, history["scheme"].max() / total[0], rise

    history, scheme, rise = made()
    assert history.finished, history.reason
    assert np.abs(history["balance"]).max() < 1e-7 * history["kinetic"][0]
    assert history["strain"].max() > 0.5 * history["kinetic"][0]
    assert scheme < 5e-6 and rise < 1e-12

    monkeypatch.setattr(ThetaScheme, "force_points", [(0.5, 1.0)])
    monkeypatch.setattr("fenicsx_contact.solids.hyperelastic.MADE", np.inf)
    assert made()[1] > 0.005 * (1 if speed < 1 else 16)


def test_a_step_is_not_cut_for_energy_that_the_scheme_takes():
    """A wheel rolls by theta = 1: quadrature on the way makes less than the scheme takes; 123 cuts
    were for what no step had made."""
    mesh = mesh_from_gmsh("disc.geo", R=0.1, h=0.02, coarse=0.02).mesh
    wheel = HyperelasticSolid(
        name_facets(mesh, {"rim": lambda x: np.ones(x.shape[1], bool)}),
        energy=neo_hookean(1e7, 0.3),
        density=1000.0,
        body_force=(0, -9810.0),
        velocity=lambda x: np.stack([1 + 10 * x[1], -10 * x[0]]),
    )
    floor = Contact(wheel, "rim", HalfSpace((0, -0.1), (0, 1)), friction=0.5, name="c")
    history = Scene([wheel], [floor], ThetaScheme(1.0)).run(0.1, 4e-3)
    assert history.finished and not history.remarks
    energy = history["kinetic"] + history["strain"] - history["drive"]
    assert np.diff(energy).max() < 1e-7 * energy[0]


def test_what_turns_by_small_strain_is_said_to_swell():
    """Of what spins, by the exact swelling; not of what turns by little, is held, or is not
    linear."""
    spin, until = 2.0, 0.1  # 0.2 rad
    kinds = {"youngs_modulus": 1e7, "poisson_ratio": 0.3}, {"energy": neo_hookean(1e7, 0.3)}

    def remarks(mesh, turn, held=(), kind=ElasticSolid, **material):
        def velocity(x):
            return np.array([-turn * x[1], turn * x[0], *[0 * x[0]] * (mesh.dim - 2)])

        moving = {"gravity": (turn, 0)} if held else {"velocity": velocity}
        solid = kind(mesh, density=1000.0, fixed=held, **moving, **material)
        history = Scene([solid], [], allow_free=True).run(until, until / 8)
        assert history.finished
        return [text for _, text in history.remarks]

    for mesh in (rectangle((2, 2), (0.2, 0.2)), box((2, 2, 2), (0.2, 0.2, 0.2))):
        (told,) = remarks(mesh, spin, **kinds[0])
        assert "turned by 0.2 rad" in told and f"by {np.hypot(1, 0.2) - 1:.2g} of" in told
        assert not remarks(mesh, 0.2 * spin, **kinds[0])
        assert not remarks(mesh, spin, kind=HyperelasticSolid, **kinds[1])
    assert not remarks(rectangle((2, 2), (0.2, 0.2)), 1e4, ["base"], **kinds[0])  # is bent


def test_step_that_would_make_energy_is_refused():
    bar = bar_at_wall(cells=20, hyperelastic=True, speed=1.0).scene
    history = bar.run(0.9, 0.02, shortest=1.0)
    assert "strains too much in a step" in history.reason
    check_energies(history, 1e-7)


def turned_in_clamps(energy, theta, strain=-0.03, plane="strain", dt=0.05, **run):
    """A block strained between clamps until 0.1 s, and turned with them until 0.4 s."""

    def clamp(x, t):
        X, Y, a = (1 + strain * min(t / 0.1, 1.0)) * x[0], x[1], 0.25 * t
        turned = np.cos(a) * X - np.sin(a) * Y, np.sin(a) * X + np.cos(a) * Y
        return np.stack(turned) - x[:2]

    block = HyperelasticSolid(
        rectangle((4, 4), (0.04, 0.04)),
        energy=energy,
        plane=plane,
        density=1000.0,
        prescribed={"left": clamp, "right": clamp},
    )
    return Scene([block], [], ThetaScheme(theta)).run(0.4, dt, **run)


@pytest.mark.parametrize("plane", ["strain", "stress"])
@pytest.mark.parametrize("theta", [0.6, 1.0])
def test_what_turns_under_pressure_is_not_cut(theta, plane):
    """Forces at the end of a step work less than nothing where what is compressed turns: that is no
    fault of the material; the steps were cut 762 times. What that makes is of first order."""
    made = []
    for dt in (0.05, 0.025):
        history = turned_in_clamps(neo_hookean(1e8, 0.3), theta, plane=plane, dt=dt)
        assert history.finished and not history.remarks
        assert len(history) - 1 == round(0.4 / dt)
        size = history["strain"].max()
        assert np.abs(history["balance"]).max() < 1e-8 * size  # what Newton's method leaves
        turned = history["time"] > 0.1 - dt / 2
        assert np.ptp(history["strain"][turned]) < 1e-5 * size
        made.append(np.ptp(history["scheme"][turned]) / size)
    assert made[0] < 0.036 * (2 * theta - 1)
    assert made[1] == pytest.approx(made[0] / 2, rel=0.01)


@pytest.mark.parametrize("theta", [0.6, 1.0])
def test_what_turns_under_pressure_is_cut_for_its_material(theta):
    """Of an energy that saturates at a strain of 1 % the end of a step bears less than its way."""

    def energy(F):
        E = (F.T * F - ufl.Identity(3)) / 2
        return 1e4 * (1 - ufl.exp(-ufl.inner(E, E) / 1e-4))

    history = turned_in_clamps(energy, theta, shortest=0.05)
    assert "strains too much in a step" in history.reason


def test_energy_of_the_user():
    """``c/2 |F - 1|²`` makes each component obey a wave equation: one linearisation a step."""

    def energy(F):
        H = F - ufl.Identity(3)
        return MODULUS / 2 * ufl.inner(H, H)

    z = 0.3
    q, history = vibrate(0.5, "theta", z, 3, energy)
    np.testing.assert_allclose(q, np.cos(2 * np.arctan(z / 2) * np.arange(len(q))), atol=1e-10)
    assert history["geometry"].max() == 1


def test_inverted_element_at_the_start_is_refused():
    with pytest.raises(InputError, match=r"displacement.*inverted"):
        HyperelasticSolid(
            rectangle((2, 3)),
            energy=ENERGIES["neo_hookean"],
            density=1000.0,
            displacement=lambda x: np.stack([0 * x[0], -2 * x[1]]),
        )


def test_inverted_element_stops_the_run_with_a_reason():
    solid = HyperelasticSolid(
        rectangle((2, 3)),
        energy=ENERGIES["st_venant_kirchhoff"],
        density=1000.0,
        fixed=["base"],
        velocity=lambda x: np.stack([0 * x[0], -300 * x[1]]),
        name="crushed",
    )
    history = Scene([solid], []).run(0.1, 1e-3)
    assert not history.finished
    assert "an element of solid 'crushed' is inverted" in history.reason
    assert "stopped at t" in history.reason
    assert len(history) > 1 and np.isfinite(history.rows()).all()
    assert np.isfinite(solid.displacement).all()
    check_energies(history, 1e-6)


def test_round_off_of_a_stored_energy_stops_no_slow_solid():
    """At 1e-6 of the wave speed the stored energy is 1e-12 of the terms it is the difference of."""
    bar = bar_at_wall(cells=20, hyperelastic=True, speed=1e-6, cfl=1.0)
    history = bar.run()
    assert history.finished and not history.remarks, history.reason
    assert bar.error(history) < bar.bound < 0.2


@pytest.mark.parametrize("package", ["mumps", "petsc"])
def test_a_singular_matrix_has_no_solution(package):
    """Newton's method may come by one; who asks MUMPS all the same gets an error of PETSc's."""
    rows = sp.csr_matrix([[2.0, 1, 0], [1, 1, 0], [0, 0, 1]])
    matrix = petsc_matrix(rows, MPI.COMM_SELF)
    solver = Direct(matrix, "singular", package)
    left, right = matrix.createVecs()
    right.setArray([1.0, 0.0, 0.0])
    assert solver.solve(right, left)
    np.testing.assert_allclose(left.array_r, [1, -1, 0], atol=1e-15)
    for _ in range(2):
        matrix.setValue(0, 0, 1.0)
        matrix.assemble()
        solver.refactor()
        assert not solver.solve(right, left)


def test_how_far_an_unknown_yields_with_its_neighbours():
    """Springs in a row: held m + 1 places off on both sides, (m + 1)/2 of what one spring gives,
    which alone is 1/2. At most half of the unknowns go along, and at most a bounded number."""
    for n, m in ((1, 0), (7, 1), (101, 24), (10_000, (ABOUT - 1) // 2)):
        row = sp.diags([-1.0, 2.0, -1.0], [-1, 0, 1], shape=(n, n)).tocsr()
        found = yielding(petsc_matrix(row, MPI.COMM_SELF), np.array([n // 2]), n)
        assert found == pytest.approx(m + 1, rel=1e-10)
    loose = sp.csr_matrix(np.kron(np.eye(4), [[1.0, -1.0], [-1.0, 1.0]]))
    assert yielding(petsc_matrix(loose, MPI.COMM_SELF), np.array([0, 1]), 2) == np.inf


def test_how_far_a_node_yields_is_the_same_in_any_axes():
    """Nodes in a row, which yield far across it and hardly along it: the lesser one counts,
    however the row is turned."""
    along, across = (
        sp.diags([-1.0, 2.0 + held, -1.0], [-1, 0, 1], shape=(31, 31)) for held in (1e2, 0.0)
    )
    row = (sp.kron(along, np.diag([1.0, 0.0])) + sp.kron(across, np.diag([0.0, 1.0]))).toarray()
    found = []
    for angle in (0.0, 0.3, np.pi / 4, np.pi / 2):
        turn = np.kron(
            np.eye(31), [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        )
        turned = petsc_matrix(sp.csr_matrix(turn @ row @ turn.T), MPI.COMM_SELF)
        found.append(yielding(turned, np.array([30, 31]), turned.getSize()[0]))
    assert found == pytest.approx(4 * [found[0]], rel=1e-10)
    assert 1.0 < found[0] < 1.001


def test_an_initial_field_may_be_numbers():
    material = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1.0}
    solid = ElasticSolid(rectangle(), **material, velocity=(1.0, -2.0), displacement=[0.1, 0.0])
    np.testing.assert_array_equal(solid.velocity.reshape(-1, 2), [[1.0, -2.0]] * 4)
    np.testing.assert_array_equal(solid.displacement.reshape(-1, 2), [[0.1, 0.0]] * 4)
    with pytest.raises(InputError, match=r"velocity = .*must be 2 finite numbers"):
        ElasticSolid(rectangle(), **material, velocity=(1.0, -2.0, 0.0))
