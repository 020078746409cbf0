# SPDX-License-Identifier: LGPL-3.0-or-later
"""The augmentation of the points of a contact: any positive numbers, which change no solution.

A point that slips one way and is told to slip the other comes by stick. A correction that turns
its slip round, though friction is against it, tells of rho_t w_t beyond the ball of (4') on its
other side: what slips together then goes to and fro. With

    rho_t = |tau|^2 / -(tau . w_t)

tau + rho_t w_t is orthogonal to tau, and along a line the middle of the ball: the point sticks.
(Not points of a rigid body, whose forces would push against each other.)

Of these the natural rho_t, what stops one point alone, is too small where one bears for many, and
a correction leaps over the piece in which the solution is, from one of its neighbours to the other.
What the others leave a point is a line, Dtau = -Dw_t/W; with rho_t = 1/W it is told the piece
through which that goes, whatever it was in. W is told by the last correction.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

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
        self,
        tractions: Sequence[np.ndarray],
        slips: Sequence[np.ndarray],
        careful: bool,
        shared: bool,
    ) -> bool:
        """Choose rho_t by what the last correction did, both now and before, (d - 1, n); if not
        ``careful`` the usual ones. Whether that changes rho.

        Args:
            tractions, slips: of all points.
            careful: whether it gained nothing.
            shared: whether one point may bear for others.
        """
        usual, tell = self._usual()[1], self._stiffness if shared else self._opposite
        new = tell(usual, *tractions, *slips) if careful else usual
        if np.array_equal(new, self.rho[1]):
            return False
        self.rho = np.stack([self.rho[0], new])
        return True

    @staticmethod
    def _opposite(
        usual: np.ndarray, traction: np.ndarray, _: Any, slip: np.ndarray, before: np.ndarray
    ) -> np.ndarray:
        """That of slips that turned, against tractions, but for what hardly resists them."""
        against, size = -(traction * slip).sum(axis=0), (traction**2).sum(axis=0)
        turned = ((slip * before).sum(axis=0) < 0) & (usual * against > 2 * size)
        turned &= size > RIGHT * usual * against
        return np.where(turned, size / np.where(turned, against, 1.0), usual)

    @staticmethod
    def _stiffness(
        usual: np.ndarray, traction: np.ndarray, last: np.ndarray, slip: np.ndarray, before: Any
    ) -> np.ndarray:
        """What changes of tractions and slips tell of 1/W, at least the usual one; slips that
        hardly changed tell nothing."""
        change = slip - before
        against, size = -((traction - last) * change).sum(axis=0), (change**2).sum(axis=0)
        told = (against > 0) & (usual * size > RIGHT * against)
        return np.maximum(usual, np.where(told, against, 0.0) / np.where(told, size, 1.0))

    def shares(self) -> np.ndarray | None:
        """Of the natural ones, (2, n), or None: all are 1, or bounds are known."""
        plain = self.tresca or np.array_equal(self.rho, self.units)
        return None if plain else self.rho / self.units
