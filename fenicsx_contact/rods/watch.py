# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the contact of a rod with its guide did: where it bore and when, and the rod's shapes."""

from __future__ import annotations

import numpy as np

from ..base import checks
from .contact import GuideContact


class ForceMap:
    """Mean normal forces by depth and time, and the rod's shape now and then.

    Called with the contact after each step, for instance by a probe of the run.

    Args:
        dt: length of the steps, s.
        duration, height: of a cell of the map, s and m.
        every: time between two shapes, s.

    Attributes:
        shapes: times [s], and depths and first lateral places [m] of the guided nodes then.

    Raises:
        InputError: a number that is not positive.
    """

    def __init__(
        self, dt: float, duration: float = 0.01, height: float = 0.05, every: float = 0.04
    ) -> None:
        self.dt = checks.number("dt", dt, above=0)
        self.duration = checks.number("duration", duration, above=0)
        self.height = checks.number("height", height, above=0)
        self.every = checks.number("every", every, above=0)
        self.shapes: list[tuple[float, np.ndarray, np.ndarray]] = []
        self._cells: dict[tuple[int, int], float] = {}
        self._time = 0.0

    def __call__(self, contact: GuideContact) -> None:
        """Note what the contact did in the step that has just been accepted."""
        guide, places = contact.obstacle, contact.trace.positions()
        depth = guide.depth(places)
        if len(self.shapes) <= self._time / self.every:
            nodes = np.setdiff1d(np.arange(len(depth)), contact.stations)
            lateral = (places[nodes] - guide.origin) @ guide.lateral[0]
            self.shapes.append((self._time, depth[nodes], lateral))
        force = np.abs(np.einsum("ij,ij->i", contact.force, contact.normal))
        column = int(self._time / self.duration)
        for i in np.flatnonzero(force):
            key = column, int(np.floor(depth[i] / self.height))
            share = force[i] * self.dt / self.duration
            self._cells[key] = self._cells.get(key, 0.0) + share
        self._time += self.dt

    def picture(self) -> tuple[np.ndarray, list[float]]:
        """Forces [N] by (depth, time), and the extent of the picture: start and end [s], bottom
        and top [m]; empty if nothing bore."""
        if not self._cells:
            return np.zeros((0, 0)), [0.0, 0.0, 0.0, 0.0]
        columns, rows = np.array(list(self._cells)).T
        low = rows.min()
        image = np.zeros((rows.max() - low + 1, columns.max() + 1))
        image[rows - low, columns] = list(self._cells.values())
        bottom, top = (rows.max() + 1) * self.height, low * self.height
        return image, [0.0, (columns.max() + 1) * self.duration, bottom, top]
