# SPDX-License-Identifier: LGPL-3.0-or-later
"""Wear: what slides under pressure is worn away."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...base import checks
from ...base.quoted import quoted
from ..friction import FrictionBound, creeps, friction_bound
from ..laws import Expr
from ..parameter import Parameter, keep_parameter, told


@dataclass(frozen=True)
class Archard:
    """Archard's law, ``h' = k/H |lam| |w_t|``, beside any friction: the slave recedes by h.

    The worn volume is k F s/H, of the normal force F on the way s. The depth is remembered as
    "worn" [m]. That of a step is in the gap which its law reads, ``d_n - k/H |lam| |w_t| dt``, a
    compliance: points share what they bear so that they wear together, as in continuous time.
    Springs wear after the step. Laws that act at points have no pressure, and so no depth;
    "printed" chooses its closed points before the step, and lets go of what wears.

    J.F. Archard, J. Appl. Phys. 24, 981-988, 1953; with contact: N. Strömberg, L. Johansson, A.
    Klarbring, Int. J. Solids Struct. 33, 1817-1836, 1996.

    Args:
        friction: Coulomb's coefficient, or a law of friction.
        coefficient: k, a pure number >= 0; it and H may vary, see
            :data:`~fenicsx_contact.theory.parameter.Parameter`.
        hardness: H, Pa, > 0.

    Raises:
        InputError: a parameter out of its range, no friction.
    """

    friction: Any
    coefficient: Parameter
    hardness: Parameter

    def __post_init__(self) -> None:
        keep_parameter(self, "coefficient")
        keep_parameter(self, "hardness", above=0)
        if isinstance(self.friction, Archard):
            raise checks.InputError(f"friction = {quoted(self.friction)}: wears already")
        if friction_bound(self.friction) is None:
            raise checks.InputError(
                f"friction = {quoted(self.friction)}: must be > 0, or a law: without "
                "friction a contact "
                "does not follow the slip that wears it"
            )

    @property
    def law(self) -> FrictionBound:
        """The law of friction."""
        law = friction_bound(self.friction)
        assert law is not None
        return law

    @property
    def creeps(self) -> bool:
        """Whether nothing sticks by it."""
        return creeps(self.law)

    def bound(self, k: Any, pressure: Expr, S: Expr) -> Expr:
        """That of the friction; the wear beside it."""
        rate = k.field("coefficient", self.coefficient) / k.field("hardness", self.hardness)
        k.wears("worn", lambda depth, time: depth + rate * pressure * k.slip_speed * time)
        return self.law.bound(k, pressure, S)

    def describe(self) -> str:
        """The friction and the wear."""
        wear = f"{told(self.coefficient)}, hardness {told(self.hardness)}"
        return f"{self.law.describe()}, worn by Archard's law with coefficient {wear}"
