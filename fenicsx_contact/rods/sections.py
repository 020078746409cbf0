# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a beam is made of: round sections, and supports."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..base import checks
from ..base.quoted import quoted

#: A number, or a function of s [m] (n,) with values (n,), taken at the middle of each cell.
Value = float | Callable[[np.ndarray], np.ndarray]
#: A lateral field: of places along the axis [m] (n,), values (d - 1, n).
Lateral = Callable[[np.ndarray], np.ndarray]
# what need not be positive
LEAST: dict[str, float | None] = {
    "tension": None,
    "recess": None,
    "mass": 0.0,
    "rotary": 0.0,
    "lateral_added_mass": 0.0,
}


@dataclass(frozen=True)
class Section:
    """The section of a stretch of a beam; every number may vary along it as a function of s.

    Args:
        mass: rho A, kg/m.
        bending: E I, N m².
        shear: k G A, N; infinite (default) leaves shear out (Bernoulli).
        axial: E A, N; infinite (default) makes the axis inextensible.
        rotary: rho I, kg m.
        tension: axial force that it carries, N, compression negative: it stiffens bending by
            1/2 int tension w'^2 ds. It is given; what the run adds bends a VonKarmanBeam only.
        lateral_added_mass: of the fluid that it moves along when it moves sideways, kg/m.
        recess: how far its surface stands back from the one that the clearances of guides are
            for, m, < 0: out; read at the nodes, and linear between them.

    Raises:
        InputError: a number out of range.
    """

    mass: Value
    bending: Value
    shear: Value = math.inf
    axial: Value = math.inf
    rotary: Value = 0.0
    tension: Value = 0.0
    lateral_added_mass: Value = 0.0
    recess: Value = 0.0

    def __post_init__(self) -> None:
        for name in vars(self):
            value = getattr(self, name)
            if checks.is_function(value) or (name in ("shear", "axial") and _endless(value)):
                continue
            if name in LEAST:
                checks.keep(self, name, at_least=LEAST[name])
            else:
                checks.keep(self, name, above=0)

    def at(self, name: str, s: np.ndarray) -> np.ndarray:
        """One of the numbers at places s."""
        value = getattr(self, name)
        if not checks.is_function(value):
            return np.full(s.shape, value, dtype=float)
        problem = f"{name} = {quoted(value)}: must be a function of s (n,) with finite values (n,)"
        values = checks.table(problem, checks.called(name, value, s))
        if values.shape not in ((), s.shape):
            raise checks.InputError(f"{problem}, they are {values.shape}")
        least = LEAST.get(name, np.finfo(float).tiny)
        if least is not None and not (values >= least).all():
            raise checks.InputError(f"{name}: its function of s gives {values.min()!r}")
        return np.broadcast_to(values, s.shape)


def values_of(what: str, field: Lateral, s: np.ndarray, planes: int) -> np.ndarray:
    """A lateral field at places s, (planes, n).

    Raises:
        InputError: no function, or values that are not finite or of another shape.
    """
    problem = (
        f"{what} = {quoted(field)}: must be a function of s (n,) with finite values ({planes}, n)"
    )
    if not checks.is_function(field):
        raise checks.InputError(problem)
    values = checks.table(problem, checks.called(what, field, s))
    if values.shape != (planes, len(s)):
        raise checks.InputError(f"{problem}; they are of shape {values.shape}")
    return values


def _endless(value: Value) -> bool:
    """Whether it is infinity: what it would make soft is left out."""
    return isinstance(value, (float, int)) and value == math.inf


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
        checks.keep(self, "at")
        for name in ("lateral", "rotational", "axial"):
            if not _endless(getattr(self, name)):
                checks.keep(self, name, at_least=0)
