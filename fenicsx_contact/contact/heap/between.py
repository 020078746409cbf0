# SPDX-License-Identifier: LGPL-3.0-or-later
"""What lies between bodies: the surface of one between two places, and how far they are apart.

What is inside a body comes out of it straight: between a corner and the face that it is behind,
or between two edges that passed each other, there is nothing but the bodies. Where a surface lies
between, the corner is outside of the body, or it is another arm that the face belongs to, and
nothing has met there.
"""

from __future__ import annotations

import numpy as np

from ...base.constants import SAME
from ...base.vectors import dot
from .shape import Shape


def apart(
    shape: Shape, x: np.ndarray, ends: tuple[np.ndarray, np.ndarray], bodies: np.ndarray
) -> np.ndarray:
    """Which ways from one end to the other, (p, d) each, go through the surface of a body, (p,) of
    bool.

    Args:
        shape: of all bodies.
        x: places of their nodes, (N, d) in m.
        ends: of the ways, m.
        bodies: of which each is asked, (p,).
    """
    result = np.zeros(len(bodies), dtype=bool)
    arm = ends[1] - ends[0]
    # what is as short as round-off goes through nothing
    asked = np.flatnonzero(dot(arm, arm) > (SAME * shape.sizes[bodies]) ** 2)
    row, face = shape.faces.of(bodies[asked])
    way, same = asked[row], SAME * shape.sizes[bodies[asked]][row]
    normal, first = shape.units(x, face), x[shape.outline[face, 0]]
    one, other = (dot(end[way] - first, normal) for end in ends)
    sides = (one * other < 0) & (np.minimum(abs(one), abs(other)) > same)
    way, face, one, other = (each[sides] for each in (way, face, one, other))
    share = (one / (one - other))[:, None]
    at = ends[0][way] * (1 - share) + ends[1][way] * share
    result[way[shape.holds(at, face, x)]] = True
    return result


def distances(shape: Shape, x: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """How far pairs of convex bodies are apart, at least, (p,) in m, if negative how deep they
    overlap: the largest of their distances along normals of faces, and of edges that cross.

    Args:
        shape: of all bodies.
        x: places of their nodes, (N, d) in m.
        pairs: of bodies, (p, 2).
    """
    result = np.full(len(pairs), -np.inf)
    for mine, theirs in (pairs.T, pairs.T[::-1]):
        row, face = shape.faces.of(mine)
        far = _beyond(shape, x, theirs[row], x[shape.outline[face, 0]], shape.units(x, face))
        np.maximum.at(result, row, far)
    if shape.dim == 3 and len(asked := np.flatnonzero(result < 0)):  # else they are apart
        row, normal = _across(shape, x, pairs[asked])
        row = asked[row]
        one, other = pairs[row].T
        none = np.zeros_like(normal)
        far = _beyond(shape, x, other, none, normal) + _beyond(shape, x, one, none, -normal)
        np.maximum.at(result, row, far)
    return result


def _beyond(
    shape: Shape, x: np.ndarray, bodies: np.ndarray, first: np.ndarray, normal: np.ndarray
) -> np.ndarray:
    """How far all of bodies (k,) lies beyond planes through places, of these normals, (k,) in m."""
    row, corner = shape.corners.of(bodies)
    height = dot(x[corner] - first[row], normal[row])
    return np.asarray(np.minimum.reduceat(height, np.flatnonzero(np.diff(row, prepend=-1))))


def _across(shape: Shape, x: np.ndarray, pairs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of pairs, and normals, out of the first body, of planes along an edge of either that
    have the bodies on their sides."""
    pair, mine = shape.edges.of(pairs[:, 0])
    row, theirs = shape.edges.of(pairs[pair, 1])
    pair, mine = pair[row], mine[row]
    (a, b), (c, d) = (shape.ends[edge].T for edge in (mine, theirs))
    normal = np.cross(x[b] - x[a], x[d] - x[c])
    size = np.sqrt(dot(normal, normal))
    rises = [
        dot(x[shape.wings[edge, i]] - x[first], way)
        for edge, first, way in ((mine, a, normal), (theirs, c, -normal))
        for i in (0, 1)
    ]
    turn = np.where(np.max(rises, axis=0) <= 0, 1.0, -1.0)
    sides = (np.max(turn * rises, axis=0) <= 0) & (size > 0)
    return pair[sides], normal[sides] * (turn / np.where(size > 0, size, 1.0))[sides, None]


def unseen(
    shape: Shape, start: np.ndarray, end: np.ndarray, pairs: np.ndarray, depths: np.ndarray
) -> np.ndarray:
    """Which pairs of convex bodies, (p,) of bool, overlap at the end of a step by more than at its
    start, and than either is known to be inside of anything.

    Args:
        shape: of all bodies.
        start, end: places of their nodes, (N, d) in m.
        pairs: of bodies, (p, 2).
        depths: of each body in others, where they are known to meet, (B,) in m.
    """
    starts = [at.start for at in shape.slices]
    low, high = (of.reduceat(end, starts)[pairs] for of in (np.minimum, np.maximum))
    same = SAME * shape.sizes[pairs].min(axis=1) + depths[pairs].max(axis=1)
    overlap = (low.max(axis=1) <= high.min(axis=1) - same[:, None]).all(axis=1)
    result = overlap & shape.convex[pairs].all(axis=1)
    asked = np.flatnonzero(result)
    deep = -distances(shape, end, pairs[asked])
    result[asked] = more = deep > same[asked]
    asked = asked[more]
    if len(asked):
        result[asked] = deep[more] + distances(shape, start, pairs[asked]) > same[asked]
    return result
