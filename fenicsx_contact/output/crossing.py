# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where within a step a quantity passes a level.

With z its values, v its rates at both ends of the step of length h, it is taken as the parabola
through both values whose curvature is that of the rates::

    z0 + (z1 - z0) x + h (v1 - v0)/2 x (x - 1),        x = r/h in [0, 1]

It reaches a level between the values once, depends continuously on all of them, from step to step
too, and is exact where steps with a constant acceleration are: their values, by a theta-scheme, are
those of one parabola, though their rates are not its slopes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Crossing(NamedTuple):
    """Attributes:
    after: time since the start of the step, s.
    rate: of the quantity there.
    by_value: derivatives of the quantity there by (z0, z1), at the same time.
    by_rate: by (v0, v1).
    by_length: by h.
    """

    after: float
    rate: float
    by_value: tuple[float, float]
    by_rate: tuple[float, float]
    by_length: float


def crossing(
    length: float, values: tuple[float, float], rates: tuple[float, float], level: float
) -> Crossing:
    """Where a step of ``length`` s passes a level that lies between its values."""
    (z0, z1), (v0, v1), h = values, rates, length
    way, mean, bend = level - z0, (z1 - z0) / h, v1 - v0
    start = mean - bend / 2
    rate = np.sign(z1 - z0) * np.sqrt(max(start**2 + 2 * bend / h * way, 0.0))
    # either form where its terms do not cancel: a step may turn round before it passes
    r = 2 * way / (start + rate) if start * rate >= 0 else (rate - start) * h / bend
    x = r / h
    bent = h / 2 * x * (x - 1)
    by_length = -x * (mean + bend / 2 * x)
    return Crossing(float(r), rate, (1 - x, x), (-bent, bent), by_length)
