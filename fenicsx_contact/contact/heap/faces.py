# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which of several faces of one body a corner of another is before."""

from __future__ import annotations

import numpy as np

from ...base.constants import SAME
from ...base.vectors import dot
from .shape import Ragged, Shape


def heights(s: Shape, node: np.ndarray, face: np.ndarray, x: np.ndarray) -> np.ndarray:
    """How high nodes are above the planes of faces, m."""
    return dot(x[node] - x[s.outline[face, 0]], s.units(x, face))


def at_edge(
    s: Shape, corner: np.ndarray, face: np.ndarray, height: np.ndarray, x: np.ndarray
) -> np.ndarray:
    """Of which of these faces each corner, in front of it, is at the very edge, being on the plane
    of the next one, on which it goes over that edge: (k,) of bool.

    Where two bodies lie flush, what slides from one to the other would else meet, by round-off, a
    wall there.
    """
    result, same = np.zeros(len(face), dtype=bool), SAME * s.sizes[s.owner[face]]
    group = corner * len(s.slices) + s.owner[face]
    on = np.flatnonzero(np.abs(height) <= same)
    front = np.flatnonzero(np.isin(group, group[on]) & (height > same))
    row, other = Ragged(group[on], on, len(x) * len(s.slices)).of(group[front])
    result[front[row[_rise(s, face[front[row]], face[other], x) <= same[other]]]] = True
    return result


def not_aside(
    s: Shape, corner: np.ndarray, face: np.ndarray, height: np.ndarray, x: np.ndarray
) -> np.ndarray:
    """Which of these faces of bodies in several parts, each below a corner, see all others of the
    same body from which it is farther."""
    which = np.arange(len(corner))
    if s.parts == len(s.slices):  # all are convex
        return which
    group = corner * len(s.slices) + s.owner[face]
    one, other = Ragged(group, which, len(x) * len(s.slices)).of(group)
    farther = height[other] > height[one]
    one, other = one[farther], other[farther]
    aside = _rise(s, face[one], face[other], x) <= SAME * s.sizes[s.owner[face[one]]]
    return np.setdiff1d(which, one[aside])


def _rise(s: Shape, face: np.ndarray, other: np.ndarray, x: np.ndarray) -> np.ndarray:
    """How far faces reach above the planes of others, (k,) in m."""
    each = [heights(s, node, other, x) for node in s.outline[face].T]
    return np.asarray(np.stack(each).max(axis=0, initial=0.0))
