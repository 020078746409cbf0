# SPDX-License-Identifier: LGPL-3.0-or-later
"""When a quantity of a run reaches a level, and the derivatives of that instant.

Within the step of length h that passes the level the quantity z is taken as a parabola, by its
rate v at both ends::

    z0 + v0 r + (v1 - v0)/h r²/2 = level

The derivative of the instant is that of an implicit function: what the parameters change of the
left side, over the rate at which it is passed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

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
        h = t[i] - t[i - 1]
        bend, way = (v[i] - v[i - 1]) / h, self.level - z[i - 1]
        r = 2 * way / (v[i - 1] + np.sqrt(v[i - 1] ** 2 + 2 * bend * way))
        slow, share = 1 / (v[i - 1] + bend * r), r**2 / (2 * h)
        by_z, by_v, by_t = np.zeros((3, len(t)))
        by_z[i - 1] = -slow
        by_v[i - 1 : i + 1] = -slow * (r - share), -slow * share
        by_t[i - 1 : i + 1] = 1 - slow * share * bend, slow * share * bend
        return float(t[i - 1] + r), {self.place: by_z, self.rate: by_v, "time": by_t}


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
