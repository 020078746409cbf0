# SPDX-License-Identifier: LGPL-3.0-or-later
"""Statuses of the points of some contacts from iteration to iteration: which of them flip."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from ..contact.part import Part


class Statuses(ABC):
    """What a contact problem remembers of its points, to tell why it does not settle.

    Args:
        parts, names: of the contacts.

    Attributes:
        rounding: up to which an error that falls no more counts as round-off.
        hyperstatic: whether there may be more forces than the motion determines.
        buckles: whether something was seen to give way with springs, however soft.
    """

    buckles, rounding = False, 0.0
    hyperstatic: bool

    def __init__(self, parts: Sequence[Part], names: Sequence[str]) -> None:
        self.parts, self.names = list(parts), list(names)
        self.forget()

    def forget(self) -> None:
        """A step begins."""
        self._history: list[np.ndarray] = []

    def now(self) -> np.ndarray:
        """Statuses of all points of all contacts."""
        return np.concatenate([np.empty(0, dtype=int), *(part.statuses() for part in self.parts)])

    def turn(self, careful: bool) -> bool:
        """After a correction, if ``careful``: augment friction by what it did (augmentation.py).
        Whether that changes the rows, which are then taken up anew."""
        changed = any([part.equations.turn(careful, self.hyperstatic) for part in self.parts])
        if changed:
            self.update()
        return changed

    @abstractmethod
    def update(self) -> None:
        """Assemble the rows from the unknowns as they are."""

    def remember(self) -> np.ndarray:
        """The same, which are kept."""
        self._history.append(self.now())
        return self._history[-1]

    def flips(self) -> str:
        """Which points changed their status among the last iterations."""
        recent = np.array(self._history[-6:])
        flipping = np.flatnonzero((recent != recent[-1:]).any(axis=0)) if len(recent) else recent
        if not len(flipping):
            return "no status changes"
        texts, offset = [], 0
        for n, name in zip((len(part.statuses()) for part in self.parts), self.names):
            mine = [int(p - offset) for p in flipping if offset <= p < offset + n]
            if mine:
                shown = ", ".join(map(str, mine[:8])) + (", ..." if len(mine) > 8 else "")
                texts.append(f"points {shown} of contact {name!r}")
            offset += n
        return "statuses flip at " + " and ".join(texts)
