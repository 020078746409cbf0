# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Housner's rocking block, exact and nonlinear: no small angle, no slender block.

A rigid uniform rectangle of width 2b and height 2h rocks on a rigid half-space about one lower
corner, then the other, without slip or bouncing (G.W. Housner, "The behavior of inverted pendulum
structures during earthquakes", Bull. Seism. Soc. Am. 53(2), 403-417, 1963). With the tilt theta,
R = sqrt(b^2 + h^2), tan(alpha) = b/h and p^2 = 3g/4R,

    theta'' = -p^2 sin(alpha - theta),    V = m g R [cos(alpha - theta) - cos(alpha)].

**Impact** (theta = 0). The percussion acts at the new corner, so the angular momentum about it is
conserved: theta' is multiplied by r = 1 - 3/2 sin^2(alpha), the energy by r^2. A block with
b^2 > 2 h^2 has no such rocking impact (r would be negative): it lands flat and stays.

**Swing.** phi = alpha - theta obeys phi'' = p^2 sin(phi), a pendulum about its upper position,
released from phi_n = alpha - theta_n at the peak of swing n. With k = cos(phi_n/2), k' =
sin(phi_n/2) and Jacobi's functions of p t and modulus k, t counted from the peak (Abramowitz &
Stegun, chapters 16 and 17),

    sin(phi/2) = k'/dn,    tan(phi/2) = (k'/k)/cn,
    sin[(theta_n - theta)/2] = k k' sn^2/[(1 + cn) dn].

The first two at phi = alpha give cn and dn at the impact, so the quarter period is p T =
F(k) = sn R_F(cn^2, dn^2, 1) with Carlson's R_F. Nothing here subtracts nearly equal numbers, be
theta_n next to 0 or next to alpha.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.special import elliprf

from ..base import checks

#: Swings smaller than this fraction of the first are taken as rest.
NEGLIGIBLE = 1e-16
#: Smallest width/height of a block that rocks: half a million swings until then.
SLENDEREST = 1 / 200


@dataclass(frozen=True)
class Block:
    """A uniform rigid rectangle; per metre of thickness if its mass is.

    Args:
        width: 2b, m.
        height: 2h, m.
        mass: kg.
        gravity: m/s^2.

    Raises:
        InputError: a value that is not a positive finite number.
    """

    width: float
    height: float
    mass: float
    gravity: float = 9.81

    def __post_init__(self) -> None:
        for name in ("width", "height", "mass", "gravity"):
            checks.number(name, getattr(self, name), above=0)

    @property
    def R(self) -> float:
        """Distance from the centre to a corner, m."""
        return math.hypot(self.width, self.height) / 2

    @property
    def alpha(self) -> float:
        """The tilt at which the block overturns, atan(b/h), rad."""
        return math.atan2(self.width, self.height)

    @property
    def inertia_centre(self) -> float:
        """Moment of inertia about the centre, m R^2/3, kg m^2."""
        return self.mass * self.R**2 / 3

    @property
    def inertia_corner(self) -> float:
        """Moment of inertia about a corner, 4/3 m R^2, kg m^2."""
        return 4 * self.inertia_centre

    @property
    def p(self) -> float:
        """Rate of the unstable equilibrium on one corner, sqrt(3g/4R), 1/s."""
        return math.sqrt(0.75 * self.gravity / self.R)

    @property
    def restitution(self) -> float:
        """r: angular speed after an impact over the one before, without slip; 0 if b^2 > 2 h^2."""
        return max(0.0, 1 - 1.5 * math.sin(self.alpha) ** 2)

    @property
    def energy_ratio(self) -> float:
        """r^2: kinetic energy after an impact over the one before, without slip."""
        return self.restitution**2

    @property
    def smallest_friction(self) -> float:
        """Smallest coefficient of friction at which the impact does not slip.

        The ratio of the percussions m h w (1 - r) and m b w (1 + r): 3bh/(b^2 + 4h^2) if r > 0.
        Moreau's inelastic law (e = 0) then gives Housner's r. The reactions of a block that is
        upright and about to rock have the same ratio.
        """
        r = self.restitution
        return self.height / self.width * (1 - r) / (1 + r)

    @property
    def frictionless_restitution(self) -> float:
        """Angular speed after over before an inelastic impact on a corner without friction.

        A vertical percussion P stops the fall 2 b w of the new corner, P (1/m + b^2/I) = 2 b w, and
        w becomes w - P b/I = w (h^2 - 2b^2)/(h^2 + 4b^2); if h^2 < 2b^2 the block lands flat (0).
        The horizontal velocity has no part in this: the ratio is the same whether the old corner
        was fixed before or slid, the centre on a vertical line. Block 0.36 m x 0.80 m: 0.329.
        """
        b2, h2 = self.width**2, self.height**2
        return max(0.0, (h2 - 2 * b2) / (h2 + 4 * b2))

    @property
    def frictionless_energy_ratio(self) -> float:
        """Kinetic energy after over before that impact, for a block that did not slip before.

        The centre keeps its horizontal velocity h w, with which the block slides away. Block
        0.36 m x 0.80 m: 0.664. (Had the old corner slid, the centre moving vertically only, it
        would be the square of :attr:`frictionless_restitution`, 0.108.)
        """
        b2, h2 = self.width**2, self.height**2
        return (3 * h2 + (h2 + 4 * b2) * self.frictionless_restitution**2) / (4 * (b2 + h2))

    def potential(self, theta: Any) -> np.ndarray:
        """Potential energy at the tilt ``theta`` (rad, either sign), J; 0 upright."""
        half = np.abs(theta) / 2
        return 2 * self.mass * self.gravity * self.R * np.sin(half) * np.sin(self.alpha - half)

    def reactions(self, theta: Any, rate: Any = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """Normal and horizontal reaction at the corner, N, while the block rocks on it.

        Args:
            theta: tilt, rad, either sign.
            rate: angular velocity, rad/s, either sign.

        Returns:
            N, upwards (never negative in a swing from rest), and H, positive from the corner
            towards the centre: m (g + y'') and m x'' of the centre.
        """
        phi = self.alpha - np.abs(theta)
        turn = self.R * np.square(rate)
        normal = self.gravity * (1 - 0.75 * np.sin(phi) ** 2) - turn * np.cos(phi)
        horizontal = (0.75 * self.gravity * np.cos(phi) - turn) * np.sin(phi)
        return self.mass * normal, self.mass * horizontal


@dataclass(frozen=True, eq=False)
class Rocking:
    """The motion of a block released at rest; the arrays have one entry per impact.

    Attributes:
        block: the block.
        impact_times: s.
        peak_angles: largest tilt of the swing that ends with the impact, rad; all positive.
        omega_before: angular speed just before, rad/s; ``omega_after`` just after.
        kinetic_before: kinetic energy just before, J; ``kinetic_after`` just after.
        normal_percussions: N s; ``tangential_percussions`` against the motion of the centre.
        rest_time: where the infinitely many impacts accumulate, s.
    """

    block: Block
    impact_times: np.ndarray
    peak_angles: np.ndarray
    omega_before: np.ndarray
    omega_after: np.ndarray
    kinetic_before: np.ndarray
    kinetic_after: np.ndarray
    normal_percussions: np.ndarray
    tangential_percussions: np.ndarray
    rest_time: float
    #: of all swings, listed or not: peak (rad), phi_n (rad), quarter period (s), end (s)
    _swings: tuple[np.ndarray, ...] = field(repr=False)

    def angle(self, times: Any) -> np.ndarray:
        """The tilt at ``times`` (s), rad: positive in the first swing, alternating afterwards."""
        swing, peak, _, fall = self._fall(times)
        return np.where(swing % 2 == 0, 1, -1) * np.maximum(peak - fall, 0)

    def kinetic(self, times: Any) -> np.ndarray:
        """The kinetic energy at ``times`` (s), J; at an impact the one just after it."""
        _, _, phi, fall = self._fall(times)
        weight = self.block.mass * self.block.gravity * self.block.R
        return 2 * weight * np.sin(fall / 2) * np.sin(phi + fall / 2)

    def _fall(self, times: Any) -> tuple[np.ndarray, ...]:
        """The swing of each time, its peak and phi_n, and how far below the peak the tilt is."""
        t = np.asarray(times, dtype=float)
        if not (np.isfinite(t).all() and (t >= 0).all()):
            raise checks.InputError(f"times = {times!r}: must be finite numbers >= 0")
        ends = self._swings[-1]
        swing = np.searchsorted(ends, t, side="right")
        moving = swing < ends.size
        peak, phi, quarter, end = (row[np.minimum(swing, ends.size - 1)] for row in self._swings)
        from_peak = np.minimum(np.abs(t - (end - quarter)), quarter)
        sn, cn, dn = _jacobi(self.block.p * from_peak, np.sin(phi / 2))
        fall = 2 * np.arcsin(np.sin(phi) / 2 * sn**2 / ((1 + cn) * dn))
        return swing, peak * moving, phi, fall * moving


def rocking(block: Block, theta0: float, impacts: int = 12) -> Rocking:
    """The motion of ``block`` released at rest at the tilt ``theta0``.

    Args:
        block: the block.
        theta0: rad, in (0, alpha).
        impacts: how many impacts to list (one if the block lands flat, r = 0).

    Returns:
        The motion; its ``angle`` and ``kinetic`` know all impacts, listed or not.

    Raises:
        InputError: ``theta0`` outside (0, alpha), ``impacts`` not an integer in [1, 1e6], a block
            more slender than 1 to 200.
    """
    checks.instance("block", block, Block, "a Block")
    theta0 = checks.number("theta0", theta0, above=0)
    r, alpha = block.restitution, block.alpha
    if theta0 >= alpha:
        raise checks.InputError(
            f"theta0 = {theta0!r}: must be < alpha = {alpha!r}, where the block overturns"
        )
    checks.instance("impacts", impacts, (int, np.integer), "an integer")
    checks.number("impacts", impacts, at_least=1, at_most=1e6)
    checks.number("width / height", block.width / block.height, at_least=SLENDEREST)
    total = max(math.ceil(math.log(NEGLIGIBLE, r) / 2), int(impacts)) if r > 0 else 1

    # Energies, over m g R: e_n = r^(2n) e_0 = cos(phi_n) - cos(alpha), which gives k'^2 as a sum
    # of positive terms and theta_n from tan(theta_n/2) = e_n/(sin alpha + sin phi_n).
    left = r ** (2.0 * np.arange(total))
    lost = (1 - r) * (1 + r) * np.concatenate([[0.0], np.cumsum(left[:-1])])  # 1 - r^(2n)
    e = left * 2 * math.sin(theta0 / 2) * math.sin(alpha - theta0 / 2)
    s = math.sin(alpha / 2)
    k1 = np.sqrt(left * math.sin((alpha - theta0) / 2) ** 2 + lost * s**2)
    k = np.sqrt(1 - k1**2)
    peak = 2 * np.arctan(e / (math.sin(alpha) + 2 * k * k1))

    sn, cn, dn = np.sqrt(e / 2) / (s * k), k1 / k / math.tan(alpha / 2), k1 / s
    quarter = sn * elliprf(cn**2, dn**2, 1.0) / block.p
    end = np.cumsum(2 * quarter) - quarter[0]
    # The swings left out: T = w/(p^2 sin alpha), a geometric series to all digits.
    omega = block.p * np.sqrt(2 * e)
    left_out = 2 * r / (1 - r) * omega[-1] / (block.p**2 * math.sin(alpha))

    w, kinetic = omega[:impacts], block.mass * block.gravity * block.R * e[:impacts]
    return Rocking(
        block=block,
        impact_times=end[:impacts],
        peak_angles=peak[:impacts],
        omega_before=w,
        omega_after=r * w,
        kinetic_before=kinetic,
        kinetic_after=r**2 * kinetic,
        normal_percussions=block.mass * block.width / 2 * (1 + r) * w,
        tangential_percussions=block.mass * block.height / 2 * (1 - r) * w,
        rest_time=float(end[-1] + left_out),
        _swings=(peak, 2 * np.arcsin(k1), quarter, end),
    )


def _jacobi(u: np.ndarray, k1: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """sn, cn, dn of ``u`` in [0, K] and the modulus sqrt(1 - k1^2).

    By R. Bulirsch's descending Landen steps (Numer. Math. 7, 78-90, 1965), c = a cot(am). scipy's
    ellipj takes k^2 alone, which has lost the digits of k' for a block almost overturned.
    """
    a, b = np.ones_like(k1), k1
    means = [(a, b)]
    while np.any(a - b > 1e-8 * a):  # the next difference is the square of this one
        a, b = (a + b) / 2, np.sqrt(a * b)
        means.append((a, b))
    a = (a + b) / 2
    c, dn = a / np.tan(a * np.maximum(u, 1e-100)), np.ones_like(a)
    for a_n, b_n in reversed(means):
        square, c = c**2 / a, c * dn
        a, dn = a_n, (b_n + square) / (a_n + square)
    sn = 1 / np.sqrt(1 + c**2)
    return sn, c * sn, dn
