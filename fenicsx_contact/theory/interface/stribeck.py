# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stribeck's friction: it falls with the speed of slip, and may rise again by viscosity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import ufl

from ...base import checks
from ..laws import Expr
from ..parameter import Parameter, keep_parameter, static_and_kinetic, told, varies


@dataclass(frozen=True)
class Stribeck:
    """``b = (mu_k + (mu_s - mu_k) exp(-(|w_t|/v)^m)) |lam| + c |w_t|``.

    The speed is the unknown of the step. Where friction falls with it a step has one solution if it
    is shorter than the fall is fast, of a block of mass M pressed by N: ``dt N |mu'| < M``, for
    which ``dt < v / ((mu_s - mu_k) g)`` does on a floor. In a longer one there may be two;
    Newton's method starts from the motion as it is and takes the one next to it.

    R. Stribeck, Z. VDI 46, 1341-1348, 1902; the form: L.C. Bo, D. Pavelescu, Wear 82, 277-289,
    1982; review: B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30, 1994.

    Args:
        static, kinetic: mu_s >= mu_k >= 0; they may vary, as the others, see
            :data:`~fenicsx_contact.theory.parameter.Parameter`.
        speed: v, m/s, > 0.
        exponent: m >= 1, a number.
        viscosity: c, Pa s/m (N s/m at points), >= 0.

    Raises:
        InputError: a parameter out of its range, or mu_k > mu_s.
    """

    static: Parameter
    kinetic: Parameter
    speed: Parameter
    exponent: float = 1.0
    viscosity: Parameter = 0.0

    def __post_init__(self) -> None:
        keep_parameter(self, "static")
        keep_parameter(self, "kinetic")
        keep_parameter(self, "speed", above=0)
        keep_parameter(self, "viscosity")
        checks.keep(self, "exponent", at_least=1)
        if not varies(self.static) and not varies(self.kinetic):
            checks.keep(self, "kinetic", at_least=0, at_most=self.static)

    def bound(self, k: Any, pressure: Expr, S: Expr) -> Expr:
        """By the speed of slip."""
        V, v = k.slip_speed, k.field("speed", self.speed)
        static, kinetic = static_and_kinetic(k, self)
        mu = kinetic + (static - kinetic) * ufl.exp(-((V / v) ** self.exponent))
        return mu * pressure + k.field("viscosity", self.viscosity) * V * S * k.loaded

    def describe(self) -> str:
        """All parameters."""
        return (
            f"friction {told(self.static)} at rest, {told(self.kinetic)} above {told(self.speed)} "
            f"m/s (exponent {self.exponent:g}), viscosity {told(self.viscosity)}"
        )
