# SPDX-License-Identifier: LGPL-3.0-or-later
"""The solutions on paper, against published numbers and against what defines them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipk

from fenicsx_contact import InputError
from fenicsx_contact.references.bars import ReleasedBar, ThrownBar
from fenicsx_contact.references.hertz import (
    LineContact,
    PointContact,
    ShearedLine,
    ShearedPoint,
    effective_modulus,
    effective_radius,
)
from fenicsx_contact.references.westergaard import WavyContact

LINE = LineContact(load=2.0, modulus=30.0, radius=0.7)
POINT = PointContact(load=0.2, modulus=30.0, radius=0.7)
MU = 0.4


# -- Hertz --


def test_benchmark_of_fenet():
    """Cylinder R = 50 mm on a block, 35 kN/mm; N, mm, MPa."""
    modulus = effective_modulus(210e3, 0.3, 70e3, 0.3)
    assert modulus == pytest.approx(57692, abs=0.5)
    contact = LineContact(35e3, modulus, effective_radius(50.0))
    assert contact.half_width == pytest.approx(6.2146, abs=5e-5)
    assert contact.peak_pressure == pytest.approx(3585.36, abs=5e-3)


def test_effective_values():
    assert effective_modulus(10.0, 0.0, 10.0, 0.0) == pytest.approx(5.0, rel=1e-14)
    assert effective_modulus(3.0, 0.5) == pytest.approx(4.0, rel=1e-14)
    assert effective_modulus(1.0, 2**-30 - 1) == pytest.approx(2.0**29, rel=1e-8)
    assert effective_radius(2.0, 2.0) == pytest.approx(1.0, rel=1e-14)
    assert effective_radius(2.0, -4.0) == pytest.approx(4.0, rel=1e-14)
    assert effective_radius(2.0, 1e30) == pytest.approx(effective_radius(2.0), rel=1e-14)


def cauchy(traction, a, x):
    """Principal value of the integral of traction(s)/(x - s), for x inside (-a, a)."""
    return -quad(traction, -a, a, weight="cauchy", wvar=x, epsabs=1e-9, limit=400)[0]


def test_line_pressure_bears_the_load_and_flattens_the_cylinder():
    """Slope of the surfaces: (2/(pi E*)) PV int p/(x - s) = x/R in contact, less outside."""
    a = LINE.half_width
    assert quad(LINE.pressure, -a, a)[0] == pytest.approx(LINE.load, rel=1e-8)
    for x in np.array([-0.9, -0.3, 0.2, 0.7]) * a:
        slope = 2 / (math.pi * LINE.modulus) * cauchy(LINE.pressure, a, x)
        assert slope == pytest.approx(x / LINE.radius, rel=1e-5)
    for x in (1.01 * a, 2 * a):
        outside = quad(lambda s, x=x: LINE.pressure(s) / (x - s), -a, a)[0]
        assert 2 / (math.pi * LINE.modulus) * outside < x / LINE.radius
    assert (LINE.pressure([-1.1 * a, a, 3 * a]) == 0).all()


def ring_displacement(contact, r):
    """Indentation at r under the pressure, by rings: (4/(pi E*)) int p t/(t + r) K(k) dt."""

    def ring(t):
        return contact.pressure(t) * t / (t + r) * ellipk(4 * t * r / (t + r) ** 2)

    a = contact.contact_radius
    total = quad(ring, 0, min(r, a), limit=200)[0] + quad(ring, min(r, a), a, limit=200)[0]
    return 4 / (math.pi * contact.modulus) * total


def test_point_pressure_bears_the_load_and_flattens_the_sphere():
    a = POINT.contact_radius
    load = quad(lambda r: 2 * math.pi * r * POINT.pressure(r), 0, a)[0]
    assert load == pytest.approx(POINT.load, rel=1e-8)
    for r in np.array([1e-6, 0.4, 0.8, 0.99]) * a:
        sphere = POINT.approach - r**2 / (2 * POINT.radius)
        assert ring_displacement(POINT, r) == pytest.approx(sphere, rel=1e-6)
    for r in (1.05 * a, 2 * a):
        assert ring_displacement(POINT, r) > POINT.approach - r**2 / (2 * POINT.radius) + 1e-6


def test_inverse_ways_to_a_contact():
    line = LineContact.of_half_width(LINE.half_width, LINE.modulus, LINE.radius)
    assert line.load == pytest.approx(LINE.load, rel=1e-14)
    point = PointContact.of_approach(POINT.approach, POINT.modulus, POINT.radius)
    assert point.load == pytest.approx(POINT.load, rel=1e-14)


# -- Cattaneo and Mindlin --


@pytest.mark.parametrize("share", [0.0, 0.25, 0.75, 1.0])
def test_line_shear(share):
    """It carries Q, slips with q = mu p, and strains both surfaces alike where they stick."""
    sheared = ShearedLine(LINE, share * MU * LINE.load, MU)
    a, c = LINE.half_width, sheared.stick_half_width
    assert c == pytest.approx(a * math.sqrt(1 - share), abs=1e-15)
    force = quad(sheared.shear, -a, a, points=[-c, c], epsabs=1e-9, limit=200)[0]
    assert force == pytest.approx(sheared.tangential_load, abs=1e-7)
    x = np.linspace(-1.2 * a, 1.2 * a, 1001)
    slack = MU * LINE.pressure(x) - sheared.shear(x)
    assert np.abs(slack[np.abs(x) >= c]).max() < 1e-14
    assert (slack[np.abs(x) < 0.999 * c] > 0).all()
    scale = math.pi * MU * LINE.peak_pressure
    if 0 < share < 1:
        for s in np.array([-0.8, 0.1, 0.6]) * c:
            assert abs(cauchy(sheared.shear, a, s)) < 1e-4 * scale
        slipping = (a + c) / 2
        assert cauchy(sheared.shear, a, slipping) > 0.1 * scale


def cerruti(sheared, x, shear_modulus, nu):
    """Displacement along Q at (x, 0) of a half-space under the shear, in polar coordinates about
    that point: (1/(2 pi G)) int int q [(1 - nu) + nu cos^2(phi)] ds dphi."""
    a, c = sheared.contact.contact_radius, sheared.stick_radius
    nodes, weights = np.polynomial.legendre.leggauss(60)
    angles = (np.arange(200) + 0.5) * math.pi / 200

    def chords(radius):
        """int sqrt(1 - r^2/radius^2) along the whole chord at each angle; x inside."""
        half = np.sqrt(radius**2 - (x * np.sin(angles)) ** 2)
        s = half[:, None] * np.sin(nodes * math.pi / 2)[None, :] - (x * np.cos(angles))[:, None]
        r2 = x**2 + s**2 + 2 * x * s * np.cos(angles)[:, None]
        dome = np.sqrt(np.maximum(0, 1 - r2 / radius**2))
        measure = half[:, None] * np.cos(nodes * math.pi / 2) * math.pi / 2 * weights
        return (dome * measure).sum(axis=1)

    peak = sheared.friction * sheared.contact.peak_pressure
    total = peak * (chords(a) - c / a * chords(c))
    kernel = (1 - nu) + nu * np.cos(angles) ** 2
    return (total * kernel).sum() * math.pi / 200 / (2 * math.pi * shear_modulus)


@pytest.mark.parametrize("share", [0.25, 0.75])
def test_point_shear(share):
    """It carries Q, slips with q = mu p, and shifts the part that sticks as one."""
    sheared = ShearedPoint(POINT, share * MU * POINT.load, MU)
    a, c = POINT.contact_radius, sheared.stick_radius
    assert c == pytest.approx(a * (1 - share) ** (1 / 3), rel=1e-14)
    force = quad(lambda r: 2 * math.pi * r * sheared.shear(r), 0, a, points=[c])[0]
    assert force == pytest.approx(sheared.tangential_load, rel=1e-7)
    r = np.linspace(c, 1.2 * a, 101)
    np.testing.assert_allclose(sheared.shear(r), MU * POINT.pressure(r), atol=1e-14)
    shear_modulus, nu = 11.0, 0.3
    # a second body that is rigid adds nothing
    shift = sheared.shift((2 - nu) / shear_modulus)
    for x in np.array([0.0, 0.3, 0.6, 0.95]) * c:
        assert cerruti(sheared, x, shear_modulus, nu) == pytest.approx(shift, rel=1e-6)


def test_limits_of_shear():
    point = ShearedPoint(POINT, MU * POINT.load, MU)
    assert point.stick_radius == 0
    np.testing.assert_allclose(point.shear([0.0, 0.1]), MU * POINT.pressure([0.0, 0.1]))
    assert ShearedPoint(POINT, 0.0, MU).shift(1.0) == 0


# -- bars --

THROWN = ThrownBar(youngs_modulus=900.0, density=1.0, length=10.0, gap=5.0, speed=10.0)
RELEASED = ReleasedBar(youngs_modulus=1.0, density=1.0, length=1.0, strain=0.5)


def test_numbers_of_the_bars():
    assert THROWN.contact == pytest.approx((0.5, 7 / 6), rel=1e-14)
    assert (THROWN.force, THROWN.energy) == pytest.approx((300, 500), rel=1e-14)
    assert RELEASED.contact() == pytest.approx((1, 2)) and RELEASED.contact(1) == (4, 5)
    assert (RELEASED.force, RELEASED.energy, RELEASED.period) == pytest.approx((0.5, 0.125, 3))


@pytest.mark.parametrize(
    ("bar", "until"),
    [(THROWN, 2.0), (RELEASED, 7.0), (ReleasedBar(5.0, 0.3, 2.0, 0.1), 4.0)],
    ids=["thrown", "released", "other units"],
)
def test_bar_obeys_waves_momentum_energy_and_the_wall(bar, until):
    cells = 400
    edges = np.linspace(0, bar.length, cells + 1)
    middle = (edges[1:] + edges[:-1]) / 2
    # no front is ever in the first or last cell, nor at an edge or a middle of one
    times = np.arange(3.3, until / bar.crossing * cells, 8) * bar.crossing / cells
    h, step = bar.length / cells, 0.05 * bar.crossing / cells
    fixed = isinstance(bar, ReleasedBar)
    for t in times:
        u = bar.displacement(edges, t)
        strain, v = np.diff(u) / h, bar.velocity(middle, t)
        energy = h * (bar.density * v @ v + bar.youngs_modulus * strain @ strain) / 2
        assert energy == pytest.approx(bar.energy, rel=8 / cells)  # cells that hold a front
        later = bar.displacement(middle, t + step) - bar.displacement(middle, t)
        np.testing.assert_allclose(later / step, v, atol=1e-9 * bar.wave_speed)
        # u_tt = c^2 u_xx on d'Alembert's diamond, away from the ends
        after = bar.displacement(edges[1:-1], t + bar.crossing / cells)
        before = bar.displacement(edges[1:-1], t - bar.crossing / cells)
        np.testing.assert_allclose(after + before, u[2:] + u[:-2], atol=1e-12 * bar.length)
        reaction, gap = bar.reaction(t), u[0] + (0.0 if fixed else bar.gap)
        assert gap >= -1e-12 and reaction >= 0 and abs(gap * reaction) < 1e-9
        assert reaction == pytest.approx(-bar.youngs_modulus * strain[0], abs=1e-9 * bar.force)
        far = u[-1] if fixed else strain[-1]
        assert far == pytest.approx(0, abs=1e-12)
    assert sum(bar.reaction(times) > 0) > 0.2 * len(times)


def test_bar_starts_as_said():
    x = np.linspace(0, 1, 11)
    np.testing.assert_allclose(RELEASED.displacement(x, 0.0), (1 - x) / 2)
    np.testing.assert_allclose(RELEASED.displacement(x, 6.0), (1 - x) / 2)
    np.testing.assert_allclose(THROWN.velocity(x, 0.4), -10)
    np.testing.assert_allclose(THROWN.velocity(x, 1.2), 10)


# -- bad input --


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, math.inf, "much", None])
def test_values_that_are_refused(bad):
    for make, name in (
        (lambda v: LineContact(v, 1.0, 1.0), "load"),
        (lambda v: PointContact(1.0, v, 1.0), "modulus"),
        (lambda v: LineContact(1.0, 1.0, v), "radius"),
        (lambda v: LineContact.of_half_width(v, 1.0, 1.0), "half_width"),
        (lambda v: PointContact.of_approach(v, 1.0, 1.0), "approach"),
        (lambda v: effective_modulus(v, 0.3), "youngs_modulus"),
        (effective_radius, "radius"),
        (lambda v: ShearedLine(LINE, 0.0, v), "friction"),
        (lambda v: ShearedPoint(POINT, 0.01, MU).shift(v), "compliance"),
        (lambda v: ThrownBar(1.0, 1.0, 1.0, 1.0, v), "speed"),
        (lambda v: ReleasedBar(1.0, v, 1.0, 0.5), "density"),
        (lambda v: ReleasedBar(1.0, 1.0, 1.0, v), "strain"),
    ):
        with pytest.raises(InputError, match=f"{name} = "):
            make(bad)


def test_combinations_that_are_refused():
    for make, words in (
        (lambda: ShearedLine(LINE, 1.001 * MU * LINE.load, MU), "tangential_load = .* slide"),
        (lambda: ShearedLine(LINE, -1.0, MU), "tangential_load"),
        (lambda: ShearedLine(POINT, 0.0, MU), "contact = .* LineContact"),
        (lambda: ShearedPoint(LINE, 0.0, MU), "contact = .* PointContact"),
        (lambda: effective_radius(1.0, -0.9), "other_radius = -0.9"),
        (lambda: effective_radius(1.0, 0.0), "other_radius = 0.0"),
        (lambda: effective_modulus(1.0, 0.6), "poisson_ratio = 0.6"),
        (lambda: effective_modulus(1.0, -1.0), "poisson_ratio = -1.0.* > -1"),
        (lambda: effective_modulus(1.0, 0.3, 0.0), "other_modulus = 0.0"),
        (lambda: ThrownBar(1.0, 1.0, 1.0, 1.0, 1.0), "speed = 1.0.* waves"),
        (lambda: ReleasedBar(1.0, 1.0, 1.0, 1.0), "strain = 1.0"),
        (lambda: THROWN.displacement(11.0, 0.0), "x = 11.0"),
        (lambda: RELEASED.velocity(0.5, -1.0), "t = -1.0"),
        (lambda: RELEASED.contact(-1), "number = -1"),
    ):
        with pytest.raises(InputError, match=words):
            make()


# -- Westergaard --


@pytest.mark.parametrize("share", [0.01, 0.4, 0.99, 1.0, 2.5])
def test_waves_bear_what_presses_them(share):
    """The pressure bears the mean pressure and levels the waves: with a mean slope of the surface
    by Hilbert's transform (K.L. Johnson 1985, 13.2) the gap is flat where they touch."""
    unit = WavyContact(1.0, 30.0, 2.0, 0.01)
    assert unit.full_pressure == pytest.approx(math.pi * 30 * 0.01 / 2)
    waves = WavyContact(share * unit.full_pressure, 30.0, 2.0, 0.01)
    n = 1 << 16
    x = (np.arange(n) + 0.5) / n * 2.0 - 1.0
    p = waves.pressure(x)
    assert p.mean() == pytest.approx(waves.mean_pressure, rel=1e-6)
    assert (p[np.abs(x) > waves.half_width] == 0).all()
    assert (p[np.abs(x) < 0.999 * waves.half_width] > 0).all()
    # displacements of a half-space: those of a wave of pressure are 2/(E* k) times as high
    k = 2 * np.pi * np.fft.rfftfreq(n, 2.0 / n)
    inverse = np.divide(2.0, 30.0 * k, out=np.zeros_like(k), where=k > 0)
    gap = 0.01 * (1 - np.cos(np.pi * x)) + np.fft.irfft(inverse * np.fft.rfft(p), n)
    touching = np.abs(x) <= waves.half_width
    assert np.ptp(gap[touching]) < 1e-4 * 0.01
    assert gap[~touching].min(initial=1.0) > gap[touching].mean() - 1e-6


def test_waves_lightly_pressed_are_cylinders():
    """Crests of radius lambda²/(4 pi² Delta), Hertz's line."""
    light = WavyContact(1e-3, 30.0, 2.0, 0.01)
    hertz = LineContact(load=2e-3, modulus=30.0, radius=4.0 / (4 * math.pi**2 * 0.01))
    assert light.half_width == pytest.approx(hertz.half_width, rel=1e-3)
    assert light.pressure(np.zeros(1))[0] == pytest.approx(hertz.peak_pressure, rel=1e-3)


@pytest.mark.parametrize("i", range(4))
def test_waves_of_positive_numbers(i):
    numbers = [1.0, 30.0, 2.0, 0.01]
    numbers[i] = 0.0
    with pytest.raises(InputError, match="must be a finite number > 0"):
        WavyContact(*numbers)
