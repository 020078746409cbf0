# SPDX-License-Identifier: LGPL-3.0-or-later
"""Water around a falling rod: buoyancy, drag, and what moves along with the rod."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from ..base import checks


@runtime_checkable
class Water(Protocol):
    """What a fluid does to a falling rod; write another one and pass it in its place."""

    @property
    def buoyancy(self) -> float:
        """Mass of the displaced fluid, kg."""
        ...

    def added_mass(self, travel: float) -> float:
        """Mass m_a of fluid that moves with the rod, kg: (M + m_a(z)) z'' is what forces give, so
        that what the rod leaves behind, or takes up, on its way z does so with its speed."""
        ...

    def drag(self, travel: float) -> tuple[float, float]:
        """C in the drag C v|v|, and its derivative by the travel: N s²/m², N s²/m³."""
        ...


@dataclass(frozen=True)
class GuideTubeWater:
    """Water in guide tubes with a dashpot at their end.

    The drag ``C(z) v|v|`` falls a little as the rod leaves the upper guides and rises steeply in
    the dashpot, into which a cubic ramp leads. The default numbers reproduce the three published
    states of EDF's test FDNL100 (900 MWe, Code_Aster), to which they were fitted.

    Args:
        buoyancy: mass of the displaced water, kg.
        mass: added mass at the start, kg; it falls to nothing at ``mass_travel`` [m].
        before, before_slope: C before the dashpot is ``before + before_slope z``.
        inside, inside_slope: and in it ``inside + inside_slope (z - dashpot)``.
        dashpot: travel at which the tip enters it, m.
        ramp: length over which the one passes into the other, m.
    """

    buoyancy: float = 12.974984653305937
    mass: float = 37.603056594168685
    mass_travel: float = 5.0
    before: float = 126.92754331492887
    before_slope: float = -6.602723046996193
    inside: float = 120.44864895931809
    inside_slope: float = 3389.1263120481217
    dashpot: float = 3.05
    ramp: float = 0.05

    def __post_init__(self) -> None:
        for name in ("buoyancy", "mass", "before", "inside"):
            checks.keep(self, name, at_least=0)
        for name in ("mass_travel", "dashpot", "ramp"):
            checks.keep(self, name, above=0)
        for name in ("before_slope", "inside_slope"):
            checks.keep(self, name)

    def added_mass(self, travel: float) -> float:
        """Mass of water that moves with the rod, kg."""
        return self.mass * max(0.0, 1 - travel / self.mass_travel)

    def drag(self, travel: float) -> tuple[float, float]:
        """C and its derivative by the travel."""
        deep = travel - self.dashpot
        outer, inner = (
            self.before + self.before_slope * travel,
            self.inside + self.inside_slope * deep,
        )
        x = min(max(deep / self.ramp, 0.0), 1.0)
        share, rise = x * x * (3 - 2 * x), 6 * x * (1 - x) / self.ramp
        slope = (1 - share) * self.before_slope + share * self.inside_slope + rise * (inner - outer)
        return outer + share * (inner - outer), slope
