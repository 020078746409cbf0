# SPDX-License-Identifier: LGPL-3.0-or-later
"""The unknowns of a contact surface, from step to step."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from .surface import Surface


class SurfaceUnknowns:
    """w point by point, then lam and tau component by component.

    Attributes:
        jumps, tractions: where lam and where tau begins.
        idle_multipliers: indices of those of the points that are no candidates.
        order: their degrees of freedom.
        weight: of the points, (n,): what makes a force of a traction.
    """

    jumps: int
    tractions: int
    idle_multipliers: np.ndarray
    weight: np.ndarray
    _surface: Surface
    order: np.ndarray
    _z: np.ndarray  # their values, in the order of these

    @property
    def values(self) -> np.ndarray:
        """The unknowns; setting them sets the fields."""
        return self._z[self.order]

    @values.setter
    def values(self, values: np.ndarray) -> None:
        self._z[self.order] = values

    @contextmanager
    def being(self, values: np.ndarray) -> Iterator[None]:
        """Within it the unknowns are these; after it they are as they were."""
        kept = self.values
        self.values = values
        try:
            yield
        finally:
            self.values = kept

    def start(self, jump: np.ndarray, free: np.ndarray, bore: np.ndarray) -> None:
        """Starting values of a step: what bore goes on, the others start from another jump.

        Args:
            jump, free: of the last step, and of what did not bear, (n, d), m/s.
            bore: points that did, not only by round-off, (n,) of bool.
        """
        self.release()
        z = self.values
        z[: self.jumps] = np.where(bore[:, None], jump, free).ravel()
        self.values = z

    def scale_multipliers(self, ratio: float) -> None:
        """Multiply lam and tau."""
        values = self.values
        values[self.jumps :] *= ratio
        self.values = values

    def release(self) -> None:
        """Nothing acts where there are no equations, nor pulls where round-off would."""
        z = self.values
        z[self.idle_multipliers] = 0.0
        lam = slice(self.jumps, self.tractions)
        z[lam] = np.minimum(z[lam], 0.0)
        self.values = z

    @property
    def multiplier(self) -> np.ndarray | None:
        """lam at the points, Pa (N where a formulation acts at points), if there is one."""
        lam = slice(self.jumps, self.tractions)
        return self.values[lam] if self.tractions > self.jumps else None

    def pressed(self, force: np.ndarray) -> np.ndarray:
        """By how much points are pressed, (n,) in N, from the forces along their normals: where
        there is a multiplier, by what it says, which what draws them together may cancel."""
        lam, size = self.multiplier, np.abs(force)
        return size if lam is None else np.maximum(size, -lam * self.weight)


def own_multipliers(own: np.ndarray, candidates: int, multipliers: int) -> np.ndarray:
    """Numbers of the multipliers of some candidates among those of all, component by component."""
    return np.arange(multipliers).reshape(-1, max(candidates, 1))[:, own].ravel()
