# SPDX-License-Identifier: LGPL-3.0-or-later
"""Friction bounds: how large the friction traction of a point may be.

A law of friction is its bound b [Pa, or N at points]: the traction sticks while |tau| < b and slips
along the jump where |tau| = b, see (4') in :mod:`fenicsx_contact.theory.laws`. An own law is any
object with the two members of :class:`FrictionBound`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from ..base import checks
from .laws import Expr


@runtime_checkable
class FrictionBound(Protocol):
    """What a contact asks of its law of friction."""

    def bound(self, k: Any, pressure: Expr, S: Expr) -> Expr:
        """The bound b in UFL.

        Args:
            k: the fields of the surface, :class:`~fenicsx_contact.theory.weak_form.ContactFields`.
            pressure: S max(-lam, 0), Pa (N at points).
            S: 1 where the contact bears, else 0; b must vanish where S does.
        """

    def describe(self) -> str:
        """In a few words, with all parameters."""


@dataclass(frozen=True)
class Coulomb:
    """``b = mu |lam|`` (3).

    Args:
        mu: Coulomb's coefficient, >= 0.

    Raises:
        InputError: mu < 0 or not a number.
    """

    mu: float

    def __post_init__(self) -> None:
        checks.number("friction", self.mu, at_least=0)

    def bound(self, k: Any, pressure: Expr, S: Expr) -> Expr:
        """mu times the pressure."""
        return k.constant(self.mu) * pressure

    def describe(self) -> str:
        """The coefficient."""
        return f"friction {self.mu:g}"


@dataclass(frozen=True)
class Tresca:
    """``b = s`` wherever the contact bears, whatever its pressure.

    Args:
        stress: s, Pa (N at points), >= 0.

    Raises:
        InputError: s < 0 or not a number.
    """

    stress: float

    def __post_init__(self) -> None:
        checks.number("stress", self.stress, at_least=0)

    def bound(self, k: Any, pressure: Expr, S: Expr) -> Expr:
        """s where the contact bears."""
        return k.constant(self.stress) * S

    def describe(self) -> str:
        """The stress."""
        return f"friction up to {self.stress:g}"


def friction_bound(value: Any) -> FrictionBound | None:
    """The law that a contact was given; a number is Coulomb's coefficient, 0 is no friction.

    Raises:
        InputError: neither a number >= 0 nor a law.
    """
    if isinstance(value, FrictionBound):
        return value
    mu = checks.number("friction", value, at_least=0)
    return Coulomb(mu) if mu else None
