# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where a rod bore on its guide, and when."""

from __future__ import annotations

import numpy as np

from ..base import checks
from .contact import GuideContact


class ForceMap:
    """Mean normal forces by depth and time, and the rod's shape now and then.

    Called with the contact after each step, for instance by a probe of the run.

    Args:
        duration, height: of a cell of the map, s and m.
        every: time between two shapes, s.

    Attributes:
        shapes: times [s], and depths and first lateral places [m] of the guided nodes then.

    Raises:
        InputError: a number that is not positive.
    """

    def __init__(self, duration: float = 0.01, height: float = 0.05, every: float = 0.04) -> None:
        self.duration = checks.number("duration", duration, above=0)
        self.height = checks.number("height", height, above=0)
        self.every = checks.number("every", every, above=0)
        self.shapes: list[tuple[float, np.ndarray, np.ndarray]] = []
        self._cells: dict[tuple[int, int], float] = {}

    def __call__(self, contact: GuideContact) -> None:
        """Note what the contact did in the step that has just been accepted."""
        guide, places = contact.obstacle, contact.trace.positions()
        depth, step = guide.depth(places), contact.step
        if step is None:
            return
        if len(self.shapes) <= step.start / self.every:
            nodes = np.setdiff1d(np.arange(len(depth)), contact.stations)
            lateral = (places[nodes] - guide.origin) @ guide.lateral[0]
            self.shapes.append((step.end, depth[nodes], lateral))
        force = np.linalg.norm(contact.normal_forces, axis=1)
        column = int(step.start / self.duration)
        for i in np.flatnonzero(force):
            key = column, int(np.floor(depth[i] / self.height))
            share = force[i] * step.span / self.duration
            self._cells[key] = self._cells.get(key, 0.0) + share

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
