# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a run leaves behind for going back through it: its linearised steps as long as there is room
for them, and states from which the others are run once more."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..solids.factor import Factorisation
from ..steps.trial import Trial
from .blocks import LinearStep
from .kinks import Kink
from .seeds import Row

#: Cost: bytes of linearised steps that are kept; what is beyond them is run once more.
ROOM = 2**29


@dataclass
class Part:
    """Steps between two states.

    Attributes:
        start: the first one.
        end: when the other one is, s.
        row: of the history at its start.
        steps: the steps that were linearised.
        seeds: what quantities are in their rows, the start's first.
        kinks: of these steps.
    """

    start: dict[str, np.ndarray]
    end: float
    row: int
    steps: list[tuple[Trial, LinearStep]] = field(default_factory=list)
    seeds: list[Row] = field(default_factory=list)
    kinks: list[Kink] = field(default_factory=list)


class Room:
    """Counts the bytes of what is kept.

    Args:
        most: bytes.
    """

    def __init__(self, most: float) -> None:
        self._left = most
        self._known: set[int] = set()  # what steps have in common counts once

    def take(self, things: list[Any]) -> bool:
        """Take room for arrays, and for what is made of such; whether some is left."""
        asked = list(things)
        while asked:
            thing = asked.pop()
            if id(thing) in self._known:
                continue
            self._known.add(id(thing))
            if isinstance(thing, np.ndarray):
                if thing.base is None:
                    self._left -= thing.nbytes
                else:
                    asked.append(thing.base)
            elif isinstance(thing, Factorisation):
                self._left -= thing.bytes
            elif isinstance(thing, (list, tuple)):
                asked += thing
            elif isinstance(thing, dict):
                asked += thing.values()
            elif sp.issparse(thing) or type(thing).__module__.startswith(_HERE):
                asked += vars(thing).values()
        return self._left > 0


_HERE = __name__.rpartition(".")[0]
