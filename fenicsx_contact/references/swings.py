# SPDX-License-Identifier: LGPL-3.0-or-later
"""The swings of a computed rocking motion, to be held against Housner's."""

from __future__ import annotations

import numpy as np


def swings(
    time: np.ndarray, tilt: np.ndarray, kinetic: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """When and how large the kinetic energy is at its maximum in each half-cycle.

    A half-cycle goes from one peak of the tilt to the next one on the other side; its kinetic
    energy is largest just before the impact.

    Args:
        time, tilt, kinetic: the computed motion, s, rad and J, one entry a step.
        count: half-cycles wanted.

    Returns:
        Times [s] and kinetic energies [J] of the maxima, NaN for half-cycles that did not end.
    """
    rate = np.sign(np.diff(tilt))
    # in an impact of no length, which may stand at a turn, it is what it was before
    rate = rate[np.maximum.accumulate(np.where(rate != 0, np.arange(len(rate)), 0))]
    turns = np.flatnonzero(rate[1:] * rate[:-1] < 0) + 1
    peaks = [0]
    for turn in turns:
        if tilt[turn] * tilt[peaks[-1]] < 0:
            peaks.append(int(turn))
        elif abs(tilt[turn]) > abs(tilt[peaks[-1]]):
            peaks[-1] = int(turn)  # a shiver on the way
    when, most = np.full(count, np.nan), np.full(count, np.nan)
    for i, (a, b) in enumerate(zip(peaks[:-1], peaks[1:])):
        if i == count:
            break
        at = a + int(np.argmax(kinetic[a:b]))
        when[i], most[i] = time[at], kinetic[at]
    return when, most
