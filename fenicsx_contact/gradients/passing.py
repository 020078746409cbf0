# SPDX-License-Identifier: LGPL-3.0-or-later
"""When a quantity of a run reaches a level, and the derivatives of that instant.

Within the step that passes the level the quantity is the parabola of
:mod:`~fenicsx_contact.output.crossing`. The derivative of the instant is that of an implicit
function: what the parameters change of the quantity there, over the rate at which it passes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..base import checks
from ..output.crossing import crossing
from ..output.history import History
from .results import Tangents


class Passing(NamedTuple):
    """An instant.

    Attributes:
        time: s.
        gradient: its derivatives by the parameters, (parameters,).
    """

    time: float
    gradient: np.ndarray


@dataclass(frozen=True)
class Instant:
    """The instant at which a quantity first rises to a level, as a functional of a run.

    Args:
        place, rate: names of the quantity and of its rate among those of the run.
        level: of the quantity.
    """

    place: str
    rate: str
    level: float

    def __post_init__(self) -> None:
        checks.label("place", self.place)
        checks.label("rate", self.rate)
        checks.keep(self, "level")

    def __call__(self, history: History) -> tuple[float, dict[str, np.ndarray]]:
        """Its value, s, and its derivatives by the rows of columns of the history, (rows,) each.

        Raises:
            ValueError: the quantity does not get there.
        """
        z, v, t = (history[name] for name in (self.place, self.rate, "time"))
        above = np.flatnonzero(z >= self.level)
        if not len(above) or not above[0]:
            raise ValueError(f"{self.place!r} does not rise to {self.level!r} in the run")
        i = int(above[0])
        place, speed = (z[i - 1], z[i]), (v[i - 1], v[i])
        at = crossing(t[i] - t[i - 1], place, speed, self.level)
        by_z, by_v, by_t = np.zeros((3, len(t)))
        by_z[i - 1 : i + 1] = np.array(at.by_value) / -at.rate
        by_v[i - 1 : i + 1] = np.array(at.by_rate) / -at.rate
        by_t[i - 1 : i + 1] = 1 + at.by_length / at.rate, -at.by_length / at.rate
        return float(t[i - 1] + at.after), {self.place: by_z, self.rate: by_v, "time": by_t}


def passing(run: Tangents, place: str, rate: str, level: float) -> Passing:
    """The instant at which a quantity first rises to a level; see :class:`Instant`.

    Args:
        run: with its tangents.
        place, rate: names of the quantity and of its rate among those of the run.
        level: of the quantity.

    Raises:
        ValueError: it does not get there.
        NoDerivative: there is none; with contact, point and time.
    """
    time, weights = Instant(place, rate, level)(run.history)
    return Passing(time, sum(weight @ run[name] for name, weight in weights.items()))
