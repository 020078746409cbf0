# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Westergaard's contact of a wavy and a flat surface, periodic, without friction (1939).

Two elastic half-spaces in plane strain, whose gap is Delta (1 - cos(2 pi x/lambda)) while they just
touch, are pressed together by a mean pressure p (K.L. Johnson, *Contact Mechanics*, Cambridge 1985,
section 13.2). With psi = pi x/lambda and

    p* = pi E* Delta/lambda,

they touch while |x| <= a in each wave,

    p/p* = sin^2(psi_a),    p(x) = 2 p cos(psi)/sin^2(psi_a) sqrt(sin^2(psi_a) - sin^2(psi)),

and everywhere from p* on, with p(x) = p + p* cos(2 psi).

Any coherent units: m, N and Pa, or mm, N and MPa.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..base import checks


@dataclass(frozen=True)
class WavyContact:
    """Waves pressed flat.

    Args:
        mean_pressure: p, Pa.
        modulus: E*, Pa, see :func:`~fenicsx_contact.references.hertz.effective_modulus`.
        wavelength, amplitude: lambda and Delta, m; from crest to trough the wave is 2 Delta.

    Raises:
        InputError: a number that is not positive.
    """

    mean_pressure: float
    modulus: float
    wavelength: float
    amplitude: float

    def __post_init__(self) -> None:
        for name in ("mean_pressure", "modulus", "wavelength", "amplitude"):
            checks.number(name, getattr(self, name), above=0)

    @property
    def full_pressure(self) -> float:
        """p*, the mean pressure from which they touch everywhere, Pa."""
        return math.pi * self.modulus * self.amplitude / self.wavelength

    @property
    def half_width(self) -> float:
        """a, m: lambda/2 where they touch everywhere."""
        share = min(1.0, self.mean_pressure / self.full_pressure)
        return self.wavelength / math.pi * math.asin(math.sqrt(share))

    def pressure(self, x: np.ndarray) -> np.ndarray:
        """Pressure at a distance from a crest, Pa."""
        psi, p, full = (
            np.pi * np.asarray(x) / self.wavelength,
            self.mean_pressure,
            self.full_pressure,
        )
        if p >= full:
            return np.asarray(p + full * np.cos(2 * psi))
        root = np.sqrt(np.maximum(p / full - np.sin(psi) ** 2, 0.0))
        return np.asarray(2 * full * np.abs(np.cos(psi)) * root)
