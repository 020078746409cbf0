# SPDX-License-Identifier: LGPL-3.0-or-later
"""Friction bounds: how large the friction traction of a point may be.

A law of friction is its bound b [Pa, or N at points]: the traction sticks while |tau| < b and slips
along the jump where |tau| = b, see (4') in :mod:`fenicsx_contact.theory.laws`. An own law is any
object with the two members of :class:`FrictionBound`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, runtime_checkable

import ufl

from ..base import checks
from ..base.constants import ROUND_OFF
from ..base.quoted import quoted
from .laws import Expr
from .parameter import Parameter, keep_parameter, parameter, told, varies


@runtime_checkable
class FrictionBound(Protocol):
    """What a contact asks of its law of friction.

    Where ``reads_areas`` is False in a class itself its bound is the pressure times a number, so
    that forces are the same for any areas. Where it says ``creeps = True`` nothing sticks by it,
    however slowly it slips.
    """

    def bound(self, k: Any, pressure: Expr, S: Expr) -> Expr:
        """The bound b in UFL.

        Args:
            k: the fields of the surface, :class:`~fenicsx_contact.theory.weak_form.ContactFields`.
            pressure: S max(-lam, 0), Pa (N at points).
            S: 1 where the contact bears, else 0; b must vanish where S does, and be >= 0.
        """

    def describe(self) -> str:
        """In a few words, with all parameters."""


@dataclass(frozen=True)
class Coulomb:
    """``b = mu |lam|`` (3).

    Args:
        mu: Coulomb's coefficient, >= 0; it may vary, see :data:`Parameter`.

    Raises:
        InputError: mu < 0 or not a parameter.
    """

    mu: Parameter
    reads_areas: ClassVar[bool] = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "mu", parameter("friction", self.mu))

    @property
    def slope(self) -> float | None:
        """The tangent of the angle of the cone that no force leaves, if it is one number."""
        return None if varies(self.mu) else float(self.mu)

    def bound(self, k: Any, pressure: Expr, S: Expr) -> Expr:
        """mu times the pressure."""
        return k.field("friction", self.mu) * pressure

    def describe(self) -> str:
        """The coefficient."""
        return f"friction {told(self.mu)}"


@dataclass(frozen=True)
class Tresca:
    """``b = s`` wherever the contact bears, whatever its pressure.

    So it jumps where a point lifts off. A drag that all but tips a rigid body has no solution then:
    as many points as bear drag too much, one fewer too little. A law that vanishes with the
    pressure has one, a bound of one's own min(s, mu p).

    Args:
        stress: s, Pa (N at points), >= 0; it may vary, see :data:`Parameter`.

    Raises:
        InputError: s < 0 or not a parameter.
    """

    stress: Parameter

    def __post_init__(self) -> None:
        keep_parameter(self, "stress")

    def bound(self, k: Any, pressure: Expr, S: Expr) -> Expr:
        """s where the contact bears; in an impact, which takes no time, it does nothing."""
        return k.field("stress", self.stress) * S * k.loaded

    def describe(self) -> str:
        """The stress."""
        return f"friction up to {told(self.stress)}"


def creeps(law: FrictionBound | None) -> bool:
    """Whether nothing sticks by a law."""
    return bool(getattr(law, "creeps", False))


class Asked:
    """A law that is asked for its bound, and refused by name where it gives none.

    Args:
        law: the law.

    Attributes:
        read: whether a form has asked.
        negative: whether the bound that it was given is, in UFL.

    Raises:
        InputError: the law raises something, or gives what is no scalar.
    """

    def __init__(self, law: FrictionBound) -> None:
        self._law, self.read, self.negative = law, False, ufl.lt(1, 0)

    def bound(self, k: Any, pressure: Expr, S: Expr) -> Expr:
        """That of the law."""
        self.read, k.bears = True, S
        what = f"friction = {quoted(self._law)}: its bound"
        with checks.naming(what):
            given = self._law.bound(k, pressure, S)
        b = checks.scalar(what, given)
        self.negative = ufl.lt(b, -ROUND_OFF * pressure)
        return b

    def describe(self) -> str:
        """As the law does."""
        return self._law.describe()


def friction_bound(value: Any) -> FrictionBound | None:
    """The law that a contact was given; a number, or what varies, is Coulomb's coefficient, the
    number 0 is no friction.

    Raises:
        InputError: neither a law nor a parameter >= 0.
    """
    if isinstance(value, type) or {"bound", "describe"} & set(dir(value)):
        law: FrictionBound = checks.offers("friction", value, FrictionBound, "a law of friction")
        return law
    mu = parameter("friction", value, also=", or a law of friction such as Stribeck(...)")
    return Coulomb(mu) if varies(mu) or mu else None
