# SPDX-License-Identifier: LGPL-3.0-or-later
"""Over which faces of a body a corner of another lies, and which of several it is before."""

from __future__ import annotations

import numpy as np

from ...base.constants import SAME, SHARP
from ...base.vectors import dot, normalised
from ..mortar.search import counted
from .between import apart
from .crossing import THROUGH
from .shape import Ragged, Shape


def over_faces(
    s: Shape,
    corner: np.ndarray,
    face: np.ndarray,
    x: np.ndarray,
    goes: tuple[np.ndarray, np.ndarray],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """How high corners are above the planes of faces, and whether they lie over these with the
    bodies behind them; and whether they do if those may lie over what is beside the faces.

    Args:
        s: the bodies.
        corner, face: each before the other, (k,).
        x: places of the nodes.
        goes: how far each may go, and how deep its body is in others, (k,) in m.
    """
    (far, inside), p = goes, x[corner]
    normal = s.units(x, face)
    height = dot(p - x[s.outline[face, 0]], normal)
    over = s.holds(p, face, x)
    on = np.flatnonzero(~over & (s.hollow[face] >= 0).any(axis=1))
    on = on[s.reaches(p[on], face[on], x)]  # and nothing is between
    ways = p[on], s.roots(p[on], face[on], x)
    over[on] = ~apart(s, x, ways, s.owner[face[on]])
    row, node = s.beside.of(corner[over])
    which = np.flatnonzero(over)[row]
    arm = x[node] - p[which]
    size = np.sqrt(dot(arm, arm))
    arm = normalised(arm)
    rise = -dot(arm, normal[which])
    over[which[rise > THROUGH]] = False
    beyond = over.copy()
    # what reaches through a little is what goes on over the face
    little = np.flatnonzero((rise > SAME + inside[which] / size) & over[which])
    which, level = which[little], arm[little] + rise[little, None] * normal[which[little]]
    level = far[which, None] * normalised(level)
    over[which[~within(s, p[which] + level, face[which], x)]] = False
    return height, over, beyond


def within(s: Shape, p: np.ndarray, face: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Whether places (k, d) lie over or below faces, or others in the planes of these."""
    result = np.zeros(len(face), dtype=bool)
    row, facet = s.level.of(s.plane[face])
    result[row[s.reaches(p[row], facet, x)]] = True
    return result


def at_edge(
    s: Shape,
    corner: np.ndarray,
    face: np.ndarray,
    ends: tuple[np.ndarray, np.ndarray],
    x: np.ndarray,
    inside: np.ndarray,
    next_to: tuple[np.ndarray, np.ndarray],
) -> np.ndarray:
    """Of which of these faces each corner, in front of it, meets no more than the very edge, as it
    goes on over the next face: (k,) of bool.

    Where two bodies lie flush, or their faces meet at an angle, what slides from one to the other
    would else meet a wall there: as high as it is ``inside`` of what it slides on, (k,) in m, or as
    round-off.

    Args:
        s: the bodies.
        corner, face: each before the other, (k,).
        ends: how high corners are above the planes of faces, now and where they go, m.
        x: places of the nodes.
        inside: see above.
        next_to: whether it goes over the face, though not all that is behind it may do, and whether
            all does: else it goes on over that face if it goes no deeper.
    """
    result, same = np.zeros(len(face), dtype=bool), SAME * s.sizes[s.owner[face]]
    (height, ahead), (beyond, over) = ends, next_to
    on = np.flatnonzero(beyond & (over | (ahead >= np.minimum(height, 0.0) - same)))
    group = corner * len(s.slices) + s.owner[face]
    front = np.flatnonzero((height >= -same) & (ahead < height) & np.isin(group, group[on]))
    row, other = Ragged(group[on], on, len(x) * len(s.slices)).of(group[front])
    one = front[row]
    # how high above the other plane it comes through that of the face
    share = height[one] / (height[one] - ahead[one])
    off = height[other] + share * (ahead[other] - height[other])
    least = (off >= -same[one] - inside[one]) & (ahead[other] > ahead[one] + same[one])
    one, other = one[least], other[least]
    result[one[_rise(s, face[one], face[other], x) <= same[one]]] = True
    return result


def as_far(
    s: Shape,
    order: np.ndarray,
    key: np.ndarray,
    face: np.ndarray,
    heights: tuple[np.ndarray, np.ndarray],
    x: np.ndarray,
    known: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """The first of each key, and those in other planes from which the corner is and will be as far,
    each with a key of its own: rows, and keys of all.

    Where a corner comes straight to a corner, and as long as it stays there, no face alone is on
    both sides alike; so at one of what is round by its facets. At rest at a sharp one, as where
    blocks lie flush, it may still go along either.

    Args:
        s: the bodies.
        order: all rows, the nearest of each key first.
        key, face: of which key each is, and before which face, (k,).
        heights: how high corners are above the planes of faces, now and where they go, (k,) in m.
        x: places of the nodes.
        known: keys of what met before.
    """
    now, then = heights
    _, first, which = np.unique(key[order], return_index=True, return_inverse=True)
    best, same = order[first][which.ravel()], SAME * s.sizes[s.owner[face[order]]]
    tied = np.abs(now[order] - now[best]) <= same
    tied &= np.abs(then[order] - then[best]) <= same
    order, best, same = order[tied], best[tied], same[tied]
    several = np.stack([key[order], s.plane[face[order]]], axis=1)
    one = np.unique(several, axis=0, return_index=True)[1]
    order, best, same = order[one], best[one], same[one]
    own, rank = key.copy(), counted(np.unique(key[order], return_counts=True)[1])
    own[order] += rank * s.keys
    normals = s.units(x, np.concatenate([face[order], face[best]])).reshape(2, -1, s.dim)
    comes = now[order] - then[order] > same
    stays = comes | (dot(*normals) > SHARP) | np.isin(own[order], known) | (rank == 0)
    return order[stays], own


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
    foot, normal = x[s.outline[other, 0]], s.units(x, other)
    each = [dot(x[node] - foot, normal) for node in s.outline[face].T]
    return np.asarray(np.stack(each).max(axis=0, initial=0.0))
