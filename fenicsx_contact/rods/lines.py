# SPDX-License-Identifier: LGPL-3.0-or-later
"""Centre lines of tubes: the lateral offset [m] as a function of the depth [m]."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np

from ..base import checks
from ..base.constants import RIGHT, SAME, SHARP

#: Cost: places at which the derivative of a curve is held against its function.
SAMPLES = 64


@runtime_checkable
class CentreLine(Protocol):
    """A centre line. Arrays (n,) in its plane, or (n, d - 1) for a curve in space.

    Derivatives of runs (:mod:`fenicsx_contact.gradients`) ask for ``curvature``, the second
    derivative by the depth, too."""

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

    def __post_init__(self) -> None:
        checks.keep(self, "tilt")

    def offset(self, depth: np.ndarray) -> np.ndarray:
        """At depths (n,), m."""
        return self.tilt * depth

    def slope(self, depth: np.ndarray) -> np.ndarray:
        """Of the line at depths (n,)."""
        return np.full_like(depth, self.tilt)

    def curvature(self, depth: np.ndarray) -> np.ndarray:
        """Of the line at depths (n,), its second derivative, 1/m."""
        return np.zeros_like(depth)


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
        checks.keep(self, "amplitude")
        checks.keep(self, "wavelength", above=0)
        checks.choice("inlet", self.inlet, ["tangent", "kinked"])

    def offset(self, depth: np.ndarray) -> np.ndarray:
        """At depths (n,), m."""
        x = 2 * np.pi / self.wavelength * depth
        return self.amplitude * (np.sin(x) - x * (self.inlet == "tangent"))

    def slope(self, depth: np.ndarray) -> np.ndarray:
        """Of the line at depths (n,)."""
        k = 2 * np.pi / self.wavelength
        return self.amplitude * k * (np.cos(k * depth) - (self.inlet == "tangent"))

    def curvature(self, depth: np.ndarray) -> np.ndarray:
        """Of the line at depths (n,), its second derivative, 1/m."""
        k = 2 * np.pi / self.wavelength
        return -self.amplitude * k**2 * np.sin(k * depth)


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
        checks.keep(self, "sagitta")
        checks.keep(self, "length", above=0)

    def offset(self, depth: np.ndarray) -> np.ndarray:
        """At depths (n,), m."""
        return 0.5 * self.sagitta * (1 - np.cos(2 * np.pi / self.length * depth))

    def slope(self, depth: np.ndarray) -> np.ndarray:
        """Of the line at depths (n,)."""
        k = 2 * np.pi / self.length
        return 0.5 * self.sagitta * k * np.sin(k * depth)

    def curvature(self, depth: np.ndarray) -> np.ndarray:
        """Of the line at depths (n,), its second derivative, 1/m."""
        k = 2 * np.pi / self.length
        return 0.5 * self.sagitta * k**2 * np.cos(k * depth)


@dataclass(frozen=True)
class AnyCurve:
    """A curve given by functions. Where it has a kink, its tube must be told: ``Tube(kinks=...)``.

    Args:
        function: the lateral offset at depths (n,), m: (n,), or (n, d - 1) of a curve in space.
        derivative: of that by the depth, of the same shape.
        second: derivative, 1/m; only where runs are differentiated.
    """

    function: Callable[[np.ndarray], np.ndarray] = field(repr=False)
    derivative: Callable[[np.ndarray], np.ndarray] = field(repr=False)
    second: Callable[[np.ndarray], np.ndarray] | None = field(default=None, repr=False)

    def offset(self, depth: np.ndarray) -> np.ndarray:
        """At depths (n,), m."""
        return self.function(depth)

    def slope(self, depth: np.ndarray) -> np.ndarray:
        """Of the line at depths (n,)."""
        return self.derivative(depth)

    def contradicts(self, top: float, bottom: float) -> bool:
        """Whether its derivative is not that of its function between two depths, on the whole, but
        leans by more than a sharp edge does."""
        ends = np.linspace(top, bottom, SAMPLES + 1)
        depth, short = 0.5 * (ends[1:] + ends[:-1]), RIGHT * (bottom - top)
        above, below, slope = (
            np.asarray(each, dtype=float)
            for each in (
                self.function(depth - short),
                self.function(depth + short),
                self.derivative(depth),
            )
        )
        rise = (below - above) / (2 * short)
        size = max(np.linalg.norm(rise), np.linalg.norm(slope))
        off = np.linalg.norm(rise - slope) if rise.shape == slope.shape else 0.0  # told by a guide
        return bool(off > np.sqrt(1 - SHARP**2) * size + SAME)

    def curvature(self, depth: np.ndarray) -> np.ndarray:
        """Of the line at depths (n,), its second derivative, 1/m.

        Raises:
            InputError: none was given.
        """
        if self.second is None:
            raise checks.InputError("AnyCurve: second = None: must be its second derivative")
        return self.second(depth)
