# SPDX-License-Identifier: LGPL-3.0-or-later
"""How far apart two surfaces are at the start, where the user knows it better than their meshes.

Straight facets of two round bodies whose meshes do not match overlap and gape by h²/(8 R), which is
more than the interference of most fits.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..base import checks
from ..base.quoted import quoted

#: In m, < 0: an interference; a number, a function of the places x (d, n), or None: as meshed.
Clearance = float | Callable[[np.ndarray], np.ndarray] | None


def apart_at(places: np.ndarray, clearance: Clearance) -> np.ndarray:
    """The clearance at places (n, d), (n,) in m.

    Raises:
        InputError: no number, or not one for each place, or one that is not finite.
    """
    if not checks.is_function(clearance):
        return np.full(len(places), checks.number("clearance", clearance))
    given = checks.called("clearance(x)", clearance, places.T)
    try:
        values = np.broadcast_to(checks.floats(given), len(places))
    except (TypeError, ValueError):
        values = np.array([np.nan])
    if not np.isfinite(values).all():
        raise checks.InputError(
            f"clearance(x) = {quoted(given)}: must be {len(places)} finite numbers, "
            "one for each column"
        )
    return np.array(values)
