# SPDX-License-Identifier: LGPL-3.0-or-later
"""Static and kinetic friction: what is at rest is harder to move than what slides."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import ufl

from ...base import checks
from ...base.constants import RIGHT
from ..laws import Expr
from ..parameter import Parameter, keep_parameter, static_and_kinetic, told, varies


@dataclass(frozen=True)
class StaticKinetic:
    """``b = mu_k |lam|`` while slip goes on, ``b = mu_s |lam|`` else.

    Slip goes on where w_t has, at the end of the step, not turned against what it was at its start.
    From rest it takes mu_s to break away, in that step also for its slip; what stops or would turn
    round is held by mu_s. A step may have two solutions, one that slides on and one that sticks,
    where a push lies between the two bounds. Newton's method starts from the motion as it is, so
    what slides slides on, as in continuous time: there is no speed below which it would be caught.
    With theta < 1 a slip may turn round within a step before it is held (3'): mu_s then holds it
    as long as that slows it down.

    C.A. Coulomb, Théorie des machines simples, 1785; review: B. Armstrong-Hélouvry, P. Dupont,
    C. Canudas de Wit, Automatica 30, 1083-1138, 1994.

    Args:
        static, kinetic: mu_s >= mu_k >= 0; they may vary, see
            :data:`~fenicsx_contact.theory.parameter.Parameter`.

    Raises:
        InputError: a coefficient < 0, or mu_k > mu_s.
    """

    static: Parameter
    kinetic: Parameter
    reads_areas: ClassVar[bool] = False

    def __post_init__(self) -> None:
        keep_parameter(self, "static")
        keep_parameter(self, "kinetic")
        if not varies(self.static) and not varies(self.kinetic):
            checks.number("kinetic", self.kinetic, at_least=0, at_most=self.static)

    def bound(self, k: Any, pressure: Expr, S: Expr) -> Expr:
        """By whether slip goes on."""
        now, before = k.jump_t, k.start_jump_t
        # what sticks has a jump of round-off, of any sign
        noise = RIGHT * ufl.dot(before, before)
        turned = ufl.lt(ufl.dot(now, before), -noise)
        slows = ufl.le(ufl.dot(now, now), ufl.dot(before, before))
        caught = k.memory.field("caught", 0.0)
        k.memory.rule("caught", ufl.conditional(turned, 1.0, ufl.conditional(slows, caught, 0.0)))
        goes_on = ufl.And(ufl.gt(ufl.dot(now, before), noise), ufl.lt(caught, 0.5))
        static, kinetic = static_and_kinetic(k, self)
        return ufl.conditional(goes_on, kinetic, static) * pressure

    def describe(self) -> str:
        """Both coefficients."""
        return f"friction {told(self.static)} at rest, {told(self.kinetic)} in slip"
