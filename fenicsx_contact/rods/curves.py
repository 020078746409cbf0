# SPDX-License-Identifier: LGPL-3.0-or-later
"""Centre lines of guides: the lateral offset [m] as a function of the depth [m]."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np

from ..base import checks


@runtime_checkable
class Curve(Protocol):
    """A centre line. Arrays (n,) in its plane, or (n, d - 1) for a curve in space."""

    def offset(self, depth: np.ndarray) -> np.ndarray:
        """Lateral offset at depths (n,), m."""
        ...

    def slope(self, depth: np.ndarray) -> np.ndarray:
        """Its derivative by the depth."""
        ...


@dataclass(frozen=True)
class Straight:
    """A straight line, inclined by ``tilt`` (slope)."""

    tilt: float = 0.0

    def offset(self, depth: np.ndarray) -> np.ndarray:
        """Lateral offset at depths (n,), m."""
        return self.tilt * depth

    def slope(self, depth: np.ndarray) -> np.ndarray:
        """Its derivative by the depth."""
        return np.full_like(depth, self.tilt)


@dataclass(frozen=True)
class Sine:
    """An S: ``a sin kx``, with k = 2 pi / wavelength.

    Args:
        amplitude: a, m.
        wavelength: m.
        inlet: ``"tangent"`` subtracts ``a k x``, so that a straight guide leads smoothly into it;
            ``"kinked"`` keeps the slope a k at depth 0.
    """

    amplitude: float
    wavelength: float
    inlet: str = "tangent"

    def __post_init__(self) -> None:
        checks.number("amplitude", self.amplitude)
        checks.number("wavelength", self.wavelength, above=0)
        checks.choice("inlet", self.inlet, ["tangent", "kinked"])

    def offset(self, depth: np.ndarray) -> np.ndarray:
        """Lateral offset at depths (n,), m."""
        x = 2 * np.pi / self.wavelength * depth
        return self.amplitude * (np.sin(x) - x * (self.inlet == "tangent"))

    def slope(self, depth: np.ndarray) -> np.ndarray:
        """Its derivative by the depth."""
        k = 2 * np.pi / self.wavelength
        return self.amplitude * k * (np.cos(k * depth) - (self.inlet == "tangent"))


@dataclass(frozen=True)
class Bow:
    """A C: ``a (1 - cos 2 kx) / 2`` with k = pi / length; tangent at both ends of its length.

    Args:
        sagitta: a, m.
        length: m.
    """

    sagitta: float
    length: float

    def __post_init__(self) -> None:
        checks.number("sagitta", self.sagitta)
        checks.number("length", self.length, above=0)

    def offset(self, depth: np.ndarray) -> np.ndarray:
        """Lateral offset at depths (n,), m."""
        return 0.5 * self.sagitta * (1 - np.cos(2 * np.pi / self.length * depth))

    def slope(self, depth: np.ndarray) -> np.ndarray:
        """Its derivative by the depth."""
        k = 2 * np.pi / self.length
        return 0.5 * self.sagitta * k * np.sin(k * depth)


@dataclass(frozen=True)
class AnyCurve:
    """A curve given by two functions of the depth (n,)."""

    function: Callable[[np.ndarray], np.ndarray] = field(repr=False)
    derivative: Callable[[np.ndarray], np.ndarray] = field(repr=False)

    def offset(self, depth: np.ndarray) -> np.ndarray:
        """Lateral offset at depths (n,), m."""
        return self.function(depth)

    def slope(self, depth: np.ndarray) -> np.ndarray:
        """Its derivative by the depth."""
        return self.derivative(depth)
