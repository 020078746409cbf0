# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a beam is made of: round sections, and supports."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..base import checks

#: A number, or a function of s [m] (n,) with values (n,), taken at the middle of each cell.
Value = float | Callable[[np.ndarray], np.ndarray]
#: A lateral field: of places along the axis [m] (n,), values (d - 1, n).
Lateral = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Section:
    """The section of a stretch of a beam; every number may vary along it as a function of s.

    Args:
        mass: rho A, kg/m.
        bending: E I, N m².
        shear: k G A, N; infinite (default) leaves shear out (Bernoulli).
        axial: E A, N; infinite (default) makes the axis inextensible.
        rotary: rho I, kg m.

    Raises:
        InputError: a number out of range.
    """

    mass: Value
    bending: Value
    shear: Value = math.inf
    axial: Value = math.inf
    rotary: Value = 0.0

    def __post_init__(self) -> None:
        for name in ("mass", "bending", "shear", "axial", "rotary"):
            value = getattr(self, name)
            if callable(value) or (value == math.inf and name in ("shear", "axial")):
                continue
            if name in ("mass", "rotary"):
                checks.number(name, value, at_least=0)
            else:
                checks.number(name, value, above=0)

    def at(self, name: str, s: np.ndarray) -> np.ndarray:
        """One of the numbers at places s."""
        value = getattr(self, name)
        values = np.broadcast_to(value(s) if callable(value) else value, s.shape).astype(float)
        least = 0.0 if name in ("mass", "rotary") else np.finfo(float).tiny
        if not (values >= least).all():
            raise checks.InputError(f"{name}: its function of s gives {values.min()!r}")
        return values


@dataclass(frozen=True)
class Support:
    """Grounds a node of a beam; infinite stiffness holds it fast.

    Args:
        at: place s on the axis, m; must be a node.
        lateral: N/m.
        rotational: N m/rad.
        axial: N/m.
    """

    at: float
    lateral: float = 0.0
    rotational: float = 0.0
    axial: float = 0.0

    def __post_init__(self) -> None:
        checks.number("at", self.at)
        for name in ("lateral", "rotational", "axial"):
            if getattr(self, name) != math.inf:
                checks.number(name, getattr(self, name), at_least=0)
