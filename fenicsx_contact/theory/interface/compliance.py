# SPDX-License-Identifier: LGPL-3.0-or-later
"""Normal compliance: asperities that yield, by a power law."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from ...base import checks
from ..parameter import Parameter, keep_parameter
from ..scheme import gauss
from ..springs import Springs
from ..weak_form import ContactFields

#: Exact for exponents up to 5.
_GAUSS = gauss(3)


@dataclass(frozen=True)
class Compliance(Springs):
    """``p = c <d_n>^m``, a pressure that grows with the penetration: no multipliers.

    The force of a step is the mean over its way (see :mod:`fenicsx_contact.theory.springs`), so
    that with theta = 1/2 the contact gives back what it stored. Friction is an elastic stretch of
    the asperities and Coulomb's slip.

    J.T. Oden, J.A.C. Martins, Comput. Methods Appl. Mech. Engrg. 52, 527-634, 1985; A. Klarbring,
    A. Mikelić, M. Shillor, Int. J. Engng. Sci. 26, 811-832, 1988.

    Args:
        coefficient: c, Pa/m^m, > 0; it may vary, see
            :data:`~fenicsx_contact.theory.parameter.Parameter`.
        exponent: m >= 1.
        tangential_stiffness: of the asperities against friction, which needs it, Pa/m, > 0.
        damping: of a dashpot beside, Pa s/m, >= 0.

    Raises:
        InputError: a parameter out of its range.
    """

    coefficient: Parameter
    exponent: float = 1.0
    tangential_stiffness: float | None = None
    damping: float = 0.0
    name: ClassVar[str] = "compliance"
    at_points: ClassVar[bool] = False
    points: ClassVar[None] = None

    def __post_init__(self) -> None:
        keep_parameter(self, "coefficient", above=0)
        if self.tangential_stiffness is not None:
            checks.keep(self, "tangential_stiffness", above=0)
        checks.keep(self, "exponent", at_least=1)
        checks.keep(self, "damping", at_least=0)

    @property
    def stiffness_t(self) -> float:
        """Tangential stiffness, Pa/m."""
        if self.tangential_stiffness is None:
            raise checks.InputError(
                "tangential_stiffness = None: friction needs it of asperities; a number > 0, Pa/m"
            )
        return self.tangential_stiffness

    def reaction(self, k: ContactFields, depth: Any) -> Any:
        """Pressure at a depth."""
        return k.field("coefficient", self.coefficient) * depth**self.exponent

    def mean_reaction(self, k: ContactFields, a: Any, b: Any) -> Any:
        """Its mean over the way from one depth to another."""
        mean = sum(w * (a + s * (b - a)) ** self.exponent for s, w in _GAUSS)
        return k.field("coefficient", self.coefficient) * mean
