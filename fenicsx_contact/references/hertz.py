# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Hertz's contact of cylinders and of spheres, pressed together and then pushed sideways.

Two elastic bodies of quadratic shape touch over a length that is small against their radii, so
that each deforms as a half-space (K.L. Johnson, *Contact Mechanics*, Cambridge 1985, chapters 4
and 7). They enter by two numbers,

    1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2,    1/R = 1/R1 + 1/R2.

**Line** (parallel cylinders, plane strain, P per unit of length): a^2 = 4 P R/(pi E*),
p = p0 sqrt(1 - x^2/a^2), p0 = 2 P/(pi a).

**Point** (spheres): a^3 = 3 P R/(4 E*), the same profile of the radius r, p0 = 3 P/(2 pi a^2),
and the bodies approach each other by a^2/R.

**Tangential force** Q < mu P afterwards (Cattaneo 1938, Mindlin 1949): an annulus slips,
q = mu p, while |x| < c sticks,

    q = mu p0 [sqrt(1 - x^2/a^2) - (c/a) sqrt(1 - x^2/c^2)],

with (c/a)^2 = 1 - Q/(mu P) for the line, (c/a)^3 for the point. Exact for the line if both bodies
have the same elastic constants (the shear then does not change the pressure); for the point the
slip is taken parallel to Q, an error of nu/(4 - 2 nu) of the slip's direction at most.

Any coherent units: m, N and Pa, or mm, N and MPa.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import checks


def effective_modulus(
    youngs_modulus: float,
    poisson_ratio: float,
    other_modulus: float | None = None,
    other_ratio: float = 0.0,
) -> float:
    """E*, Pa, of a body against another one; against a rigid one if no other modulus is given.

    Raises:
        InputError: a modulus that is not positive, a ratio outside (-1, 1/2].
    """
    first = _compliance("youngs_modulus", youngs_modulus, "poisson_ratio", poisson_ratio)
    if other_modulus is None:
        return 1 / first
    return 1 / (first + _compliance("other_modulus", other_modulus, "other_ratio", other_ratio))


def _compliance(name: str, modulus: float, ratio_name: str, ratio: float) -> float:
    """(1 - nu^2)/E."""
    modulus = checks.number(name, modulus, above=0)
    nu = checks.number(ratio_name, ratio, above=-1, at_most=0.5)
    return (1 - nu**2) / modulus


def effective_radius(radius: float, other_radius: float | None = None) -> float:
    """R, m, of a body against another one; against a plane if no other radius is given.

    Args:
        radius: of the convex body, > 0.
        other_radius: of the other; negative if that is hollow and holds the first.

    Raises:
        InputError: a radius that is not positive, a hollow that is narrower than the body.
    """
    radius = checks.number("radius", radius, above=0)
    if other_radius is None:
        return radius
    other = checks.number("other_radius", other_radius)
    if other == 0 or -radius <= other < 0:
        raise checks.InputError(
            f"other_radius = {other_radius!r}: must be > 0, or < -radius = {-radius!r} of a hollow "
            "that holds the body"
        )
    return radius / (1 + radius / other)


@dataclass(frozen=True)
class _Contact:
    """Force, elastic constant and shape, checked."""

    load: float
    modulus: float
    radius: float

    def __post_init__(self) -> None:
        for name in ("load", "modulus", "radius"):
            checks.number(name, getattr(self, name), above=0)


@dataclass(frozen=True)
class LineContact(_Contact):
    """Two parallel cylinders, or a cylinder on a plane, in plane strain.

    Args:
        load: P, per unit of length, N/m.
        modulus: E*, Pa; see :func:`effective_modulus`.
        radius: R, m; see :func:`effective_radius`.

    Raises:
        InputError: a value that is not a positive finite number.
    """

    @classmethod
    def of_half_width(cls, half_width: float, modulus: float, radius: float) -> LineContact:
        """The contact whose half width is a, m: P = pi E* a^2/(4R)."""
        for name, value in (("half_width", half_width), ("modulus", modulus), ("radius", radius)):
            checks.number(name, value, above=0)
        return cls(math.pi * modulus * half_width**2 / (4 * radius), modulus, radius)

    @property
    def half_width(self) -> float:
        """a, m."""
        return math.sqrt(4 * self.load * self.radius / (math.pi * self.modulus))

    @property
    def peak_pressure(self) -> float:
        """p0, Pa, in the middle."""
        return 2 * self.load / (math.pi * self.half_width)

    def pressure(self, x: Any) -> np.ndarray:
        """p, Pa, at the distance ``x`` (m, either sign) from the middle; 0 outside."""
        return self.peak_pressure * _dome(x, self.half_width)


@dataclass(frozen=True)
class PointContact(_Contact):
    """Two spheres, or a sphere on a plane.

    Args:
        load: P, N.
        modulus: E*, Pa; see :func:`effective_modulus`.
        radius: R, m; see :func:`effective_radius`.

    Raises:
        InputError: a value that is not a positive finite number.
    """

    @classmethod
    def of_approach(cls, approach: float, modulus: float, radius: float) -> PointContact:
        """The contact whose bodies have approached by d, m: P = 4/3 E* sqrt(R) d^(3/2)."""
        for name, value in (("approach", approach), ("modulus", modulus), ("radius", radius)):
            checks.number(name, value, above=0)
        return cls(4 / 3 * modulus * math.sqrt(radius) * approach**1.5, modulus, radius)

    @property
    def contact_radius(self) -> float:
        """a, m."""
        return (3 * self.load * self.radius / (4 * self.modulus)) ** (1 / 3)

    @property
    def peak_pressure(self) -> float:
        """p0, Pa, in the middle."""
        return 3 * self.load / (2 * math.pi * self.contact_radius**2)

    @property
    def approach(self) -> float:
        """By how much points of the two bodies far from the contact come closer, a^2/R, m."""
        return self.contact_radius**2 / self.radius

    def pressure(self, r: Any) -> np.ndarray:
        """p, Pa, at the distance ``r`` (m) from the middle; 0 outside."""
        return self.peak_pressure * _dome(r, self.contact_radius)


@dataclass(frozen=True)
class _Sheared:
    """What Cattaneo's and Mindlin's solutions share."""

    contact: Any
    tangential_load: float
    friction: float

    def __post_init__(self) -> None:
        kind = LineContact if isinstance(self, ShearedLine) else PointContact
        checks.instance("contact", self.contact, kind, f"a {kind.__name__}")
        friction = checks.number("friction", self.friction, above=0)
        tangential = checks.number("tangential_load", self.tangential_load, at_least=0)
        if tangential > friction * self.contact.load:
            raise checks.InputError(
                f"tangential_load = {self.tangential_load!r}: must be <= friction * load = "
                f"{friction * self.contact.load!r}, at which the bodies slide"
            )

    @property
    def utilisation(self) -> float:
        """Q/(mu P), in [0, 1]."""
        return min(1.0, self.tangential_load / (self.friction * self.contact.load))

    def _shear(self, x: Any, a: float, c: float) -> np.ndarray:
        inner = c / a * _dome(x, c) if c > 0 else 0.0
        return self.friction * self.contact.peak_pressure * (_dome(x, a) - inner)


@dataclass(frozen=True)
class ShearedLine(_Sheared):
    """A line contact pressed by P, then pushed sideways by Q, across its axis.

    Args:
        contact: the line contact.
        tangential_load: Q, per unit of length, N/m, in [0, mu P].
        friction: mu.

    Raises:
        InputError: a force beyond mu P, or not what is said above.
    """

    contact: LineContact

    @property
    def stick_half_width(self) -> float:
        """c, m; 0 when the whole contact slips."""
        return self.contact.half_width * math.sqrt(1 - self.utilisation)

    def shear(self, x: Any) -> np.ndarray:
        """q, Pa, at the distance ``x`` (m, either sign) from the middle; 0 outside."""
        return self._shear(x, self.contact.half_width, self.stick_half_width)


@dataclass(frozen=True)
class ShearedPoint(_Sheared):
    """A point contact pressed by P, then pushed sideways by Q.

    Args:
        contact: the point contact.
        tangential_load: Q, N, in [0, mu P].
        friction: mu.

    Raises:
        InputError: a force beyond mu P, or not what is said above.
    """

    contact: PointContact

    @property
    def stick_radius(self) -> float:
        """c, m; 0 when the whole contact slips."""
        return self.contact.contact_radius * (1 - self.utilisation) ** (1 / 3)

    def shear(self, r: Any) -> np.ndarray:
        """q, Pa, in the direction of Q at the distance ``r`` (m) from the middle; 0 outside."""
        return self._shear(r, self.contact.contact_radius, self.stick_radius)

    def shift(self, compliance: float) -> float:
        """By how much points of the two bodies far from the contact shift sideways, m.

        Args:
            compliance: (2 - nu1)/G1 + (2 - nu2)/G2 with the shear moduli G, 1/Pa; a rigid body
                adds nothing.
        """
        compliance = checks.number("compliance", compliance, above=0)
        grip = 3 * self.friction * self.contact.load / (16 * self.contact.contact_radius)
        return grip * compliance * (1 - (1 - self.utilisation) ** (2 / 3))


def _dome(x: Any, a: float) -> np.ndarray:
    """sqrt(1 - x^2/a^2), 0 outside."""
    return np.sqrt(np.maximum(0.0, 1 - np.square(np.asarray(x, dtype=float) / a)))
