# SPDX-License-Identifier: LGPL-3.0-or-later
"""The other side of a decision on whose edge points are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Edge(NamedTuple):
    """Points that a small change takes to the other side of a decision.

    Attributes:
        points: their numbers, (k,).
        what: is undecided, (k,).
        values: the unknowns of the other side, where they are others.
        told: arrays of what the step is told of its start, and what they are there.
        here: the same of this side, where they differ by an error.
    """

    points: np.ndarray
    what: list[str]
    values: np.ndarray | None = None
    told: tuple[tuple[np.ndarray, np.ndarray], ...] = ()
    here: tuple[tuple[np.ndarray, np.ndarray], ...] = ()
