# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whether what a scheme says of itself is one scheme: its numbers are held against its functions,
for what disagrees runs, keeps its own books, and falls at half the acceleration.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import checks
from ..base.constants import RIGHT
from ..base.quoted import quoted
from .scheme import Scheme


def consistent(scheme: Any) -> Scheme:
    """The scheme, if its members agree.

    Raises:
        InputError: it is none, or a member is none of what the others are, by name.
    """
    if isinstance(scheme, type) or not isinstance(scheme, Scheme):
        raise checks.InputError(
            f"scheme = {quoted(scheme)}: must be a scheme, such as ThetaScheme()"
        )
    dt, (old, new) = 0.5, np.random.default_rng(0).normal(size=(2, 9))  # any would do
    force = np.ones(len(old))
    before, after = scheme.linear_weights
    rest, memory = scheme.first(0 * force), scheme.first(force)

    def increment(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.asarray(scheme.increment(dt, a, b, rest))

    def summed(points: Any, of: Any = lambda share: 1.0) -> float:
        return float(sum(weight * of(share) for share, weight in points))

    rate, told = dt * scheme.position_rate, "linear_weights"
    for name, got, want, what in (
        ("increment", increment(old, old), dt * old, "dt v where v- = v+ = v and nothing acts"),
        (
            "increment",
            increment(old, new) - increment(old, old),
            rate * (new - old),
            "affine in v+, by position_rate dt",
        ),
        (
            told,
            (before + after) * force + scheme.carried(memory),
            force,
            "with what is carried 1, of a force that stays",
        ),
        ("force_points", summed(scheme.force_points), before + after, f"of weights as {told}"),
        ("force_points", summed(scheme.force_points, float), after, f"as {told}, of an affine F"),
        ("load_points", summed(scheme.load_points), before + after, f"of weights as {told}"),
        ("inertia", scheme.inertia * (scheme.inertia - 1), 0.0, "0 or 1"),
    ):
        if not np.abs(np.asarray(got) - want).max() <= RIGHT:
            raise checks.InputError(f"scheme = {quoted(scheme)}: its {name} must be {what}")
    return scheme
