# SPDX-License-Identifier: LGPL-3.0-or-later
"""When a quantity of a run reaches a level, and the derivatives of that instant.

Within the step of length h that passes the level the quantity z is taken as a parabola, by its
rate v at both ends::

    z0 + v0 r + (v1 - v0)/h r²/2 = level

The derivative of the instant is that of an implicit function: what the parameters change of the
left side, over the rate at which it is passed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .results import Tangents


class Passing(NamedTuple):
    """An instant.

    Attributes:
        time: s.
        gradient: its derivatives by the parameters, (parameters,).
    """

    time: float
    gradient: np.ndarray


def passing(run: Tangents, place: str, rate: str, level: float) -> Passing:
    """The instant at which a quantity first rises to a level.

    Args:
        run: with its tangents.
        place, rate: names of the quantity and of its rate among those of the run.
        level: of the quantity.

    Raises:
        ValueError: it does not get there.
        NoDerivative: there is none; with contact, point and time.
    """
    z, v, t = (run.history[name] for name in (place, rate, "time"))
    above = np.flatnonzero(z >= level)
    if not len(above) or not above[0]:
        raise ValueError(f"{place!r} does not rise to {level!r} in the run")
    i = int(above[0])
    by_z, by_v, by_t = (run[name][i - 1 : i + 1] for name in (place, rate, "time"))
    h = t[i] - t[i - 1]
    bend, way = (v[i] - v[i - 1]) / h, level - z[i - 1]
    r = 2 * way / (v[i - 1] + np.sqrt(v[i - 1] ** 2 + 2 * bend * way))
    by_bend = (by_v[1] - by_v[0] - bend * (by_t[1] - by_t[0])) / h
    missing = by_z[0] + by_v[0] * r + by_bend * r**2 / 2
    return Passing(float(t[i - 1] + r), by_t[0] - missing / (v[i - 1] + bend * r))
