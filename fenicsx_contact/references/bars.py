# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Two elastic bars at a wall, exact (d'Alembert): rho u_tt = E u_xx with Signorini's law at x = 0.

x in [0, L] is the distance from the end that strikes, in the unstrained bar; u > 0 points away
from the wall; c = sqrt(E/rho). Forces and energies are those of a unit cross-section.

**Thrown** (D. Doyen, A. Ern, S. Piperno, SIAM J. Sci. Comput. 33(1), 223-249, 2011): it flies
rigidly over a gap, is stopped by a wave that runs to the free end and comes back, and flies off
with the same speed.

**Released** (F. Chouly, P. Hild, Y. Renard, ESAIM: M2AN 49(2), 481-528, 2015): fixed at x = L and
just touching the wall when unstrained, it is drawn back uniformly, u = strain (L - x), and let go:
contact from L/c to 2 L/c, period 3 L/c.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import checks


@dataclass(frozen=True)
class _Bar:
    youngs_modulus: float
    density: float
    length: float

    def __post_init__(self) -> None:
        for name in ("youngs_modulus", "density", "length"):
            checks.number(name, getattr(self, name), above=0)

    @property
    def wave_speed(self) -> float:
        """c, m/s."""
        return math.sqrt(self.youngs_modulus / self.density)

    @property
    def crossing(self) -> float:
        """Time that a wave takes from end to end, L/c, s."""
        return self.length / self.wave_speed

    def _where(self, x: Any, t: Any) -> tuple[np.ndarray, np.ndarray]:
        places, times = np.asarray(x, dtype=float), np.asarray(t, dtype=float)
        if not ((places >= 0) & (places <= self.length)).all():
            raise checks.InputError(f"x = {x!r}: must lie in the bar, [0, {self.length!r}]")
        if not ((times >= 0) & np.isfinite(times)).all():
            raise checks.InputError(f"t = {t!r}: must be finite numbers >= 0")
        return places, times


@dataclass(frozen=True)
class ThrownBar(_Bar):
    """A free bar thrown at a wall.

    Args:
        youngs_modulus: E, Pa.
        density: rho, kg/m^3.
        length: L, m.
        gap: distance of the wall from the end x = 0 at t = 0, m, >= 0.
        speed: towards the wall, m/s; less than that of waves, or the bar would turn inside out.

    Raises:
        InputError: values that are not as said.
    """

    gap: float
    speed: float

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.number("gap", self.gap, at_least=0)
        checks.number("speed", self.speed, above=0)
        if self.speed >= self.wave_speed:
            raise checks.InputError(
                f"speed = {self.speed!r}: must be < that of waves, {self.wave_speed!r}"
            )

    @property
    def contact(self) -> tuple[float, float]:
        """Start and end of the contact, s."""
        start = self.gap / self.speed
        return start, start + 2 * self.crossing

    @property
    def force(self) -> float:
        """The reaction of the wall during the contact, rho c v, Pa."""
        return self.density * self.wave_speed * self.speed

    @property
    def energy(self) -> float:
        """Total energy at all times, J/m^2."""
        return self.density * self.length * self.speed**2 / 2

    def displacement(self, x: Any, t: Any) -> np.ndarray:
        """u, m."""
        x, t = self._where(x, t)
        stop, back = self._arrivals(x)
        return self.speed * (np.maximum(0, t - back) - np.minimum(t, stop))

    def velocity(self, x: Any, t: Any) -> np.ndarray:
        """u_t, m/s; at a front the value after it."""
        x, t = self._where(x, t)
        stop, back = self._arrivals(x)
        return self.speed * ((t >= back) * 1.0 - (t < stop))

    def reaction(self, t: Any) -> np.ndarray:
        """Reaction of the wall, Pa."""
        _, t = self._where(0.0, t)
        start, end = self.contact
        return self.force * ((t >= start) & (t < end))

    def _arrivals(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """When the wave from the wall comes by, and when the one from the free end does."""
        start, c = self.contact[0], self.wave_speed
        return start + x / c, start + (2 * self.length - x) / c


@dataclass(frozen=True)
class ReleasedBar(_Bar):
    """A bar fixed at x = L, drawn back from the wall at x = 0 and let go.

    Args:
        youngs_modulus: E, Pa.
        density: rho, kg/m^3.
        length: L, m.
        strain: by how much of its length the bar is shortened at t = 0, in (0, 1).

    Raises:
        InputError: values that are not as said.
    """

    strain: float

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.number("strain", self.strain, above=0, at_most=1 - 1e-12)

    @property
    def period(self) -> float:
        """Time from release to the same state again, 3 L/c, s."""
        return 3 * self.crossing

    def contact(self, number: int = 0) -> tuple[float, float]:
        """Start and end of a contact, s; the first is number 0."""
        number = checks.whole_number("number", number, at_least=0)
        start = (3 * number + 1) * self.crossing
        return start, start + self.crossing

    @property
    def force(self) -> float:
        """The reaction of the wall during a contact, E strain, Pa."""
        return self.youngs_modulus * self.strain

    @property
    def energy(self) -> float:
        """Total energy at all times, J/m^2."""
        return self.force * self.strain * self.length / 2

    def displacement(self, x: Any, t: Any) -> np.ndarray:
        """u, m."""
        x, t = self._where(x, t)
        phase, s = self._phase(t)
        left = self.length - x
        out = self.length - np.maximum(x, s)
        touching = -np.minimum(np.minimum(s, self.length - s), np.minimum(x, left))
        back = np.minimum(s, left)
        return self.strain * np.choose(phase, [out, touching, back])

    def velocity(self, x: Any, t: Any) -> np.ndarray:
        """u_t, m/s; at a front the value after it."""
        x, t = self._where(x, t)
        phase, s = self._phase(t)
        left = self.length - x
        near = np.minimum(x, left)
        out = -1.0 * (s >= x)
        touching = 1.0 * (self.length - s <= near) - (s < near)
        back = 1.0 * (s < left)
        return self.strain * self.wave_speed * np.choose(phase, [out, touching, back])

    def reaction(self, t: Any) -> np.ndarray:
        """Reaction of the wall, Pa."""
        _, t = self._where(0.0, t)
        return self.force * (self._phase(t)[0] == 1)

    def _phase(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """0 on the way to the wall, 1 in contact, 2 on the way back; and the path of its wave."""
        crossings = np.mod(t, self.period) / self.crossing
        phase = np.minimum(crossings.astype(int), 2)
        return phase, (crossings - phase) * self.length
