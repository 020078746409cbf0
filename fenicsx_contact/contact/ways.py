# SPDX-License-Identifier: LGPL-3.0-or-later
"""The ways of points past a wall in a step: how near they come, and where they get in."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..base.constants import BRIEF, SHARP
from ..base.vectors import dot
from .wall import Wall

#: Which points, by their shares of the ways, (k,) of bool.
Asked = Callable[[np.ndarray], np.ndarray]


class Ways:
    """Ways of points, along which a wall that moves is where it is at each time: its material may
    go round and not come nearer.

    Args:
        wall: that they may go through.
        ends, way: where they get, and the chord by which they get there, (n, d) in m.
        span: when they start and end, s.
        off: how far outside of the points the surface lies, (n,) in m.
        bend: of parabolas above the chords, four times their height, (n, d) in m; None: none.
    """

    def __init__(
        self,
        wall: Wall,
        ends: np.ndarray,
        way: np.ndarray,
        span: tuple[float, float],
        off: np.ndarray,
        bend: np.ndarray | None = None,
    ) -> None:
        self._wall, self._ends, self._way, self._off = wall, ends, way, off
        self._bend = np.zeros_like(way) if bend is None else bend
        self._start, self._length = span[0], span[1] - span[0]

    def depth(self, points: np.ndarray, share: np.ndarray) -> np.ndarray:
        """How deep some are within after these shares of their ways, (k,) in m."""
        distance = np.empty(len(points))
        for now, time in self._times(share):
            distance[now] = self._wall.distance(self._places(points, share)[now], time)
        return -distance - self._off[points]

    def normals(self, points: np.ndarray, share: np.ndarray) -> np.ndarray:
        """Outward normals of the wall there, (k, d)."""
        normals = np.empty((len(points), self._ends.shape[1]))
        for now, time in self._times(share):
            normals[now] = self._wall.normals(self._places(points, share)[now], time)
        return normals

    def depths(self, asked: np.ndarray, end: np.ndarray) -> np.ndarray:
        """How deep points that are asked, (n,) of bool, are where they are deepest, and others at
        the end of their ways, where all are so deep: ``end``, (n,) in m."""
        deep, share = end.copy(), self.deepest(asked)
        before = (share < 1).nonzero()[0]
        deep[before] = self.depth(before, share[before])
        return deep

    def deepest(self, asked: np.ndarray) -> np.ndarray:
        """After which shares of their ways points that are asked, (n,) of bool, are deepest: 1, but
        where they leave at the end and do not at the start; (n,)."""
        share, points = np.ones(len(asked)), asked.nonzero()[0]
        if len(points):
            ends = np.zeros(len(points)), np.ones(len(points))
            points = points[~self._leaves(points, ends[0]) & self._leaves(points, ends[1])]
            share[points] = first_of(lambda at: self._leaves(points, at), share[points])
        return share

    def entries(self, points: np.ndarray, share: np.ndarray) -> np.ndarray:
        """After which shares of their ways points get in that are within after these, (k,)."""
        return first_of(lambda at: self.depth(points, at) > 0, share)

    def _times(self, share: np.ndarray) -> list[tuple[np.ndarray, float]]:
        times = self._start + share * self._length
        return [(times == time, float(time)) for time in np.unique(times)]

    def _places(self, points: np.ndarray, share: np.ndarray) -> np.ndarray:
        gone = share[:, None]
        left = (1 - gone) * (self._way[points] - gone * self._bend[points])
        return np.asarray(self._ends[points] - left)

    def _leaves(self, points: np.ndarray, share: np.ndarray) -> np.ndarray:
        if not self._wall.moving:
            goes = self._way[points] + (1 - 2 * share)[:, None] * self._bend[points]
            return dot(self.normals(points, share), goes) > 0
        first = np.maximum(share - BRIEF, 0.0)
        return np.asarray(self.depth(points, first + BRIEF) < self.depth(points, first))


def heights(ways: np.ndarray, old: np.ndarray, new: np.ndarray) -> np.ndarray:
    """Of arcs above chords, (n, d) in m, between whose ends normals turn, (n, d); of no arc across
    an edge; (n,) in m."""
    turned = 0.5 * np.linalg.norm(new - old, axis=1)  # sine of half the angle
    # a chord times half the tangent of a quarter of the angle
    height = 0.5 * np.linalg.norm(ways, axis=1) * turned
    height /= 1 + np.sqrt(np.maximum(1 - turned**2, 0.0))
    return np.where(dot(old, new) > SHARP, height, 0.0)


def first_of(holds: Asked, last: np.ndarray) -> np.ndarray:
    """Shares from which on something holds that does at the last ones, (k,), found by halving."""
    near, far = np.zeros(len(last)), last
    if len(last):
        for _ in range(np.finfo(float).nmant // 2):  # there gaps hardly change
            middle = 0.5 * (near + far)
            here = holds(middle)
            near, far = np.where(here, near, middle), np.where(here, middle, far)
    return far
