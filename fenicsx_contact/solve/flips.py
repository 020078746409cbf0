# SPDX-License-Identifier: LGPL-3.0-or-later
"""Why a contact problem does not settle: the points whose status changes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..contact.part import Part


def flips(history: Sequence[np.ndarray], parts: Sequence[Part], names: Sequence[str]) -> str:
    """Which points of these contacts changed their status in the course of a history."""
    if not history:
        return "no status changes"
    recent = np.array(history[-6:])
    flipping = np.flatnonzero((recent != recent[-1]).any(axis=0))
    if not len(flipping):
        return "no status changes"
    texts, offset = [], 0
    for n, name in zip((len(p.statuses()) for p in parts), names):
        mine = [int(p - offset) for p in flipping if offset <= p < offset + n]
        if mine:
            shown = ", ".join(map(str, mine[:8])) + (", ..." if len(mine) > 8 else "")
            texts.append(f"points {shown} of contact {name!r}")
        offset += n
    return "statuses flip at " + " and ".join(texts)
