# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rate-and-state friction of rocks: it depends on the speed of slip and on the age of contacts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import ufl

from ...base import checks
from ..laws import Expr, magnitude
from ..parameter import Parameter, keep_parameter, told


def ageing(theta: Expr, V: Expr, D: Expr, time: Expr) -> Expr:
    """Dieterich's law, ``theta' = 1 - V theta/D``, exact for a V that is constant in that time:
    contacts age also at rest. (1 - e^-x)/x is written without the difference where x is small.
    """
    x = V * time / D
    moves, far = ufl.gt(x, 0), ufl.gt(x, 1)
    h = ufl.conditional(moves, ufl.min_value(x, 1.0), 1.0) / 2
    near = ufl.conditional(moves, ufl.exp(-h) * ufl.sinh(h) / h, 1.0)
    grown = ufl.conditional(far, (1 - ufl.exp(-x)) / ufl.max_value(x, 1.0), near)
    return theta * ufl.exp(-x) + time * grown


def slip(theta: Expr, V: Expr, D: Expr, time: Expr) -> Expr:
    """Ruina's law, ``theta' = -(V theta/D) ln(V theta/D)``, likewise: at rest nothing changes."""
    x = V * theta / D
    return theta * ufl.exp((ufl.exp(-V * time / D) - 1) * ufl.ln(ufl.conditional(x > 0, x, 1.0)))


def _asinh(V: Expr, ln_c: Expr) -> Expr:
    """asinh(V/c) for V >= 0 from ln c, which may be of any size."""
    there = ufl.gt(V, 0)
    L = ufl.ln(ufl.conditional(there, V, 1.0)) - ln_c
    z = ufl.exp(ufl.min_value(L, 30.0))
    near = ufl.conditional(there, ufl.ln(z + ufl.sqrt(z**2 + 1)), 0.0)
    return ufl.conditional(ufl.And(there, ufl.gt(L, 30)), L + ufl.ln(2), near)


LAWS = {"ageing": ageing, "slip": slip}


@dataclass(frozen=True)
class RateState:
    """``b = mu |lam|``, ``mu = mu_0 + a ln(V/V_0) + b ln(V_0 theta/D)``, V the speed of slip.

    In the form that is regular at rest, ``a asinh(V/2V_0 exp((mu_0 + b ln(V_0 theta/D))/a))``,
    which is the same unless mu is as small as a. Nothing sticks by this law: it creeps, however
    slowly. A step has one solution, for friction rises with V at the given age, but in steps
    longer than about D/V, in which contacts are renewed; shorter ones are needed for the age, too.
    In hold V is V_0 exp(-mu/a), below the last digit of any velocity, and tells nothing of
    friction. So where ``rho V < a |lam|`` the bound is told by what is borne: one step of Newton's
    method for y of ``a |lam| y + rho c sinh y = |tau| + rho V``, the resolvent, which has c sinh y
    = V where ``|tau| = a |lam| y``, for any rho, and nowhere else. (Springs read V alone.)

    What touches nothing does not slip: contacts that are open age as those at rest.

    In steady sliding mu = mu_0 + (a - b) ln(V/V_0). A slider that a spring pulls steadily is
    stable above the stiffness k_c = (b - a) sigma/D (1 + M V²/(a sigma D)), per area. ``theta``
    [s] is remembered as "theta".

    J.H. Dieterich, J. Geophys. Res. 84, 2161-2168, 1979; A. Ruina, ibid. 88, 10359-10370, 1983;
    stability: J.R. Rice, A. Ruina, J. Appl. Mech. 50, 343-349, 1983; regular form: J.R. Rice, N.
    Lapusta, K. Ranjith, J. Mech. Phys. Solids 49, 1865-1898, 2001.

    Args:
        a, b: direct and evolution effect, > 0 and >= 0; all parameters may vary, see
            :data:`~fenicsx_contact.theory.parameter.Parameter`.
        distance: D, the slip over which contacts are renewed, m, > 0.
        mu: mu_0, friction in steady sliding at the speed V_0.
        speed: V_0, m/s, > 0.
        theta: age of the contacts at the start, s; default: D/V_0.
        law: "ageing" or "slip".

    Raises:
        InputError: a parameter out of its range, or an unknown law.
    """

    a: Parameter
    b: Parameter
    distance: Parameter
    mu: Parameter
    speed: Parameter
    theta: Parameter = None
    law: str = "ageing"
    reads_areas: ClassVar[bool] = False
    creeps: ClassVar[bool] = True

    def __post_init__(self) -> None:
        for name in ("a", "distance", "speed"):
            keep_parameter(self, name, above=0)
        for name in ("b", "mu"):
            keep_parameter(self, name)
        checks.choice("law", self.law, LAWS)
        if self.theta is not None:
            keep_parameter(self, "theta", above=0)

    def bound(self, k: Any, pressure: Expr, S: Expr) -> Expr:
        """By the speed of slip and the age that it leaves; in hold by what is borne."""
        given = {name: k.field(name, getattr(self, name)) for name in ("a", "b", "mu", "speed")}
        a, b, mu, V0 = given.values()
        V, D = k.slip_speed, k.field("distance", self.distance)
        start = D / V0 if self.theta is None else self.theta
        evolve = LAWS[self.law]
        theta = k.state("theta", start, lambda old, time: evolve(old, V, D, time), at_least=0.0)
        ln_c, A = ufl.ln(2 * V0) - (mu + b * ufl.ln(V0 * theta / D)) / a, a * pressure
        fast = A * _asinh(V, ln_c)
        if k.multiplier is None:  # springs stretch by V, too
            return fast
        borne, R = magnitude(k.traction), k.rho_t
        most = _asinh(borne / R + V, ln_c)  # y is less
        y = ufl.min_value(borne / ufl.conditional(ufl.gt(A, 0), A, R * V0), most)
        half, back = ufl.exp(ln_c + y) / 2, ufl.exp(-2 * y)  # of c sinh y and c cosh y
        left = borne - A * y + R * (V - half * (1 - back))
        slow = A * y + A * left / (A + R * half * (1 + back))
        return ufl.conditional(ufl.lt(R * V, A), slow, fast)

    def describe(self) -> str:
        """All parameters."""
        names = ("a", "b", "distance", "mu", "speed")
        values = ", ".join(f"{name} {told(getattr(self, name))}" for name in names)
        return f"rate and state, {self.law} law: {values}"
