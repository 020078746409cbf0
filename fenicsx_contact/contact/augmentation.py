# SPDX-License-Identifier: LGPL-3.0-or-later
"""The augmentation of the points of a contact: any positive numbers, which change no solution.

A point that slips one way and is told to slip the other comes by stick. A correction that turns
its slip round, though friction is against it, tells of rho_t w_t beyond the ball of (4') on its
other side: what slips together then goes to and fro. With

    rho_t = |tau|^2 / -(tau . w_t)

tau + rho_t w_t is orthogonal to tau, and along a line the middle of the ball: the point sticks.
(Not points of a rigid body, whose forces would push against each other.)
"""

from __future__ import annotations

import numpy as np

from ..base.constants import RIGHT


class Augmentation:
    """rho_n and rho_t.

    Args:
        factors: pure numbers that multiply the natural ones.
        n: how many points.

    Attributes:
        rho: the present ones, (2, n).
        tresca: what multiplies the natural ones where bounds are known; 0: they are not.
    """

    def __init__(self, factors: tuple[float, float], n: int) -> None:
        self._factors = np.array(factors)
        self.units = self.rho = np.ones((2, n))
        self.tresca = self._of = 0.0

    def _usual(self) -> np.ndarray:
        return (self.tresca or self._factors[:, None]) * self.units

    def take_up(self, units: np.ndarray) -> bool:
        """Take up natural ones (2, n), and whether bounds are known; whether that changes them."""
        if units is self.units and self.tresca == self._of:
            return False
        self.units, self._of = units, self.tresca
        self.rho = self._usual()
        return True

    def turn(
        self, traction: np.ndarray, slip: np.ndarray, before: np.ndarray, careful: bool
    ) -> bool:
        """Let slips that turned, from one iteration to the next, against tractions, all (d - 1, n),
        stick before they go the other way, but for what hardly resists them; none if not
        ``careful``. Whether that changes rho."""
        rho, usual = self.rho[1], self._usual()[1]
        against, size = -(traction * slip).sum(axis=0), (traction**2).sum(axis=0)
        turned = careful & ((slip * before).sum(axis=0) < 0) & (usual * against > 2 * size)
        turned &= size > RIGHT * usual * against
        new = np.where(turned, size / np.where(turned, against, 1.0), usual)
        if np.array_equal(new, rho):
            return False
        self.rho = np.stack([self.rho[0], new])
        return True

    def shares(self) -> np.ndarray | None:
        """Of the natural ones, (2, n), or None: all are 1, or bounds are known."""
        plain = self.tresca or np.array_equal(self.rho, self.units)
        return None if plain else self.rho / self.units
