# SPDX-License-Identifier: LGPL-3.0-or-later
"""The energy-momentum scheme: theta = 1/2 with stresses that are means over the way of the strain.

With C = F' F the stored energy is W(C). In a step from F- to F+, F = (F- + F+)/2 in its middle,::

    P = F S,        S = 2 mean of W_C over the straight way from C- to C+

Then ``P : (F+ - F-) = S : (C+ - C-)/2`` is the change of W, for C+ - C- is twice the symmetric part
of ``F' (F+ - F-)``: no energy is made; and P F' is symmetric, so forces without a moment: angular
momentum is kept, too. (J. C. Simo, N. Tarnow, ZAMP 43, 757-792, 1992, whose stress for a W that is
quadratic in C this is; O. Gonzalez, J. Nonlinear Sci. 6, 449-467, 1996, of whose discrete gradients
it is that which needs no division.) The mean over the way of F, that of theta = 1/2, keeps the
angular momentum to second order only.

Two solids act on each other in the middle of a step, too, where what is equal and opposite on one
line has no moment (``Step.place_share``).

C of a way lies between those of its ends: no element inverts on it, however large the step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..base import checks
from .scheme import Points, gauss
from .theta import ThetaScheme

# C of a way is farther from linear than F
_GAUSS = gauss(5)


@dataclass(frozen=True)
class EnergyMomentum(ThetaScheme):
    """The scheme; for all but hyperelastic solids it is theta = 1/2.

    Raises:
        InputError: theta other than 1/2 or forces at the end.
    """

    along_strain: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        if checks.number("theta", self.theta) != 0.5:
            raise checks.InputError(f"theta = {self.theta}: must be 1/2, or take ThetaScheme")
        checks.choice("forces", self.forces, ["theta"])

    @property
    def force_points(self) -> Points:
        """Places on the way from C- to C+ and their weights, for a mean."""
        return _GAUSS

    def describe(self) -> str:
        """Its name."""
        return "energy-momentum"
