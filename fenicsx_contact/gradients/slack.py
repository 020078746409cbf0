# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whether contact holds what nothing else does, in a linearised step without inertia."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..base.constants import RIGHT


def slack(
    joints: Sequence[Any], solve: Callable[[np.ndarray], np.ndarray], unknowns: int
) -> bool | None:
    """Whether some rigid motion of solids that supports do not hold goes on for nothing: pushed by
    what little inertia makes their matrices regular it goes as far as if that alone held it.
    Contact that slips everywhere lets it, and of many solutions none has derivatives. None without
    such solids.

    Args:
        joints: solids with solvers of their own, and where their unknowns stand.
        solve: with that inertia, for columns (unknowns, k).
        unknowns: how many there are.
    """
    loose = [joint for joint in joints if getattr(joint.solid, "loose", None) is not None]
    ends = np.cumsum([0, *(joint.solid.loose.shape[1] for joint in loose)])
    if not ends[-1]:
        return None
    right, motions = np.zeros((unknowns, ends[-1])), np.zeros((unknowns, ends[-1]))
    for joint, first, end in zip(loose, ends, ends[1:]):
        motions[joint.last, first:end] = joint.solid.loose
        right[joint.at, first:end] = joint.solid.left(motions[joint.at, first:end], False)
    resisted, goes = motions.T @ right, right.T @ solve(right)
    shares = np.linalg.eigvals(np.linalg.pinv(resisted) @ goes)
    return bool(not np.abs(shares).max() < 1 - RIGHT)  # NaN, too
