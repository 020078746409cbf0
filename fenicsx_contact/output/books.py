# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whether the energies and works of a run add up."""

from __future__ import annotations

import numpy as np

from ..base.constants import MADE
from .history import History

_WORKS = ("kinetic", "strain", "impact", "friction", "drive", "damping", "scheme")


def unexplained(history: History, moved: float) -> str:
    """What to say of a run whose column ``balance`` is more than round-off of what took part, or of
    what forces of contacts might at most do in a step, ``moved`` in J; or nothing.

    All that moves works on the velocities that the scheme takes, and what works is told where it
    works: for the parts of the package the sum is zero, whatever the steps. A part of one's own
    that says one thing in its forces and another in its works is seen here alone.
    """
    potential = history["potential"] - history["potential"][0]  # a constant of it takes no part
    terms = [potential, *(history[name] for name in _WORKS)]
    size = max(moved, float(np.abs(terms).max()))
    off = np.abs(history["balance"])
    if not off.max() > MADE * size:
        return ""
    first = history["time"][int((off > MADE * size).argmax())]
    return (
        f"the energy balance leaves {off.max():.3g} J unexplained, {off.max() / (size or 1.0):.3g} "
        f"of what took part, from t = {first:.6g} s on: a part of one's own has forces that work "
        "otherwise than its works, or its jump, say"
    )
