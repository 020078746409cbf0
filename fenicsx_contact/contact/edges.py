# SPDX-License-Identifier: LGPL-3.0-or-later
"""Faces of a wall that has edges by which points meet it.

Beside an edge the nearest face is another one as soon as a point is farther inside than from the
edge, and on it round-off chooses. But what comes to a face is borne by it, and so is what lies on
it up to its very edge, however deep it is by then; what slides over the edge is so until beyond.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..base.constants import RIGHT, SAME, SHARP
from ..base.vectors import dot, largest
from .wall import Wall
from .ways import first_of


class _Now(NamedTuple):
    """Points (n, d) in m and their ways, as seen from the wall where it started, at a time, s; what
    is nearest there: normals, (n, d), and distances, (n,) in m."""

    points: np.ndarray
    ways: np.ndarray
    time: float
    normals: np.ndarray
    distance: np.ndarray


class Faces:
    """Distances and normals of the points of a surface: of faces, where those by which they came
    tell.

    Args:
        wall: that they may touch.
        cells: nodes of each facet, (m, k).
        size: of the surface, m.

    Attributes:
        kept: where these are of the plane of a face, not of what is nearest, (n,) of bool.
    """

    def __init__(self, wall: Wall, cells: np.ndarray, size: float) -> None:
        self._wall, self._cells, self._near = wall, cells, SAME * size
        self._start: tuple[np.ndarray, np.ndarray] | None = None
        self.kept = np.zeros(0, dtype=bool)

    def start(self, normals: np.ndarray, distance: np.ndarray) -> None:
        """Keep what there is where a step starts, (n, d) and (n,) in m."""
        self._start = normals, distance

    def state(self) -> dict[str, np.ndarray]:
        """The same, as arrays: not what a step that failed may have met."""
        return dict(zip(("outward", "distance"), self._start or ()))

    def restore(self, state: Mapping[str, np.ndarray]) -> np.ndarray:
        """Take up what :meth:`state` gave; these normals."""
        self.start(np.array(state["outward"]), np.array(state["distance"]))
        return np.array(state["outward"])

    def meet(
        self, points: np.ndarray, ways: np.ndarray, time: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Outward normals, (n, d), and distances, (n,) in m.

        Args:
            points: (n, d) in m.
            ways: by which they got there, as seen from the wall where it started, (n, d) in m.
            time: s.
        """
        normals, distance = self._wall.normals(points, time), self._wall.distance(points, time)
        self.kept = np.zeros(len(points), dtype=bool)
        if self._start is None:
            return self._lain_on(points, normals, distance, time), distance
        grazes, normals = self._grazed(_Now(points, ways, time, normals, distance))
        now = _Now(points, ways, time, normals, distance)
        start, was = self._start
        other = ~grazes & (np.abs(normals - start) > RIGHT).any(axis=1)
        if not other.any():
            return normals, distance
        plane = was + dot(ways, start)  # as far above that of the face, wherever that is now
        old = self._carried(points, plane, time)
        turned = other & (plane <= self._near)
        if turned.any():
            self.kept = turned & self._by(now, old, plane)
        enters = other & ~self.kept & (was > self._near) & (distance < -self._near)
        if enters.any():
            enters, old, plane = self._entered(points, ways, time, enters, (old, plane))
            self.kept = self.kept | (enters & (np.abs(normals - old) > RIGHT).any(axis=1))
        if not self.kept.any():
            return normals, distance
        distance = np.where(self.kept, plane, distance)
        return np.where(self.kept[:, None], old, normals), distance

    def ahead(
        self, points: np.ndarray, ways: np.ndarray, time: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """The same as :meth:`meet` of points about to go such ways, (n, d) in m: before an edge it
        is the face that they come to."""
        old, was = self.meet(points, np.zeros_like(points), time)
        ends = points + ways
        normals, distance = self._wall.normals(ends, time), self._wall.distance(ends, time)
        asked = (was > self._near) & (distance < -self._near)
        if asked.any():
            plane = was + dot(ways, old)
            asked &= ~self._by(_Now(ends, ways, time, normals, distance), old, plane)
        if not asked.any():
            return old, was
        enters, old, plane = self._entered(ends, ways, time, asked, (old, was))
        return old, np.where(enters, plane - dot(ways, old), was)

    def _carried(self, points: np.ndarray, plane: np.ndarray, time: float) -> np.ndarray:
        """The normals where the step started, (n, d), as the wall has turned them since, from how
        far points are above their planes, (n,) in m."""
        start, _ = self._start  # type: ignore[misc]
        if not self._wall.moving:
            return start
        # just over the face, and not over its very edge
        above = points + (self._near - plane)[:, None] * start + self._near * self._inward(points)
        carried = self._wall.normals(above, time)
        return np.where((dot(carried, start) > SHARP)[:, None], carried, start)

    def _by(self, now: _Now, old: np.ndarray, plane: np.ndarray) -> np.ndarray:
        """Whether points get inside by the faces before which they were, are on them, or slide as
        far as their edges or rest there, (n,)."""
        (points, ways, time, normals, distance), (_, was) = now, self._start  # type: ignore[misc]
        outside = was > self._near
        ahead = np.where(outside, plane / np.where(plane < was, plane - was, 1.0), 0.0)
        foot = points - np.clip(ahead, 0.0, 1.0)[:, None] * ways
        foot -= np.where(outside, 0.0, plane)[:, None] * old
        # over the face, and not beside it, is that whose facets go back from its edge, in the mean
        # or, where they go to both sides alike, one of them
        lowest, size = self._lowest(points, normals)
        mean = dot(self._inward(points), normals)
        over = (mean < -RIGHT) | ((np.abs(mean) <= RIGHT) & (lowest < -RIGHT * size))
        aside = np.where(over, -1.0, 1.0)[:, None] * normals
        beside = foot + self._near * (old + aside)
        on = np.abs(self._wall.distance(foot, time)) <= self._near
        on &= (np.abs(self._wall.normals(beside, time) - old) <= RIGHT).all(axis=1)
        # what goes along an edge may be beyond it by round-off
        there = self._wall.normals(points - SAME * ways, time)
        goes = (np.abs(there - old) <= RIGHT).all(axis=1)
        goes |= (np.abs(distance) <= self._near) & (np.abs(ways).max(axis=1) <= self._near)
        return np.asarray(on | (goes & (plane >= -self._near)))

    def _entered(
        self,
        points: np.ndarray,
        ways: np.ndarray,
        time: float,
        asked: np.ndarray,
        known: tuple[np.ndarray, np.ndarray],
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Which of the points that are asked get inside by a plane that they are still behind, (n,)
        of bool; there its normals, (n, d), and distances, (n,) in m, elsewhere those known."""

        def places(share: np.ndarray) -> np.ndarray:
            return points - (1 - share)[:, None] * ways

        share = first_of(lambda at: self._wall.distance(places(at), time) < 0, np.ones(len(points)))
        entry, off = (of(places(share), time) for of in (self._wall.normals, self._wall.distance))
        deep = off + (1 - share) * dot(ways, entry)
        foot = points - deep[:, None] * entry
        level = np.abs(self._wall.distance(foot, time)) <= self._near  # what is round is not
        there = self._wall.normals(foot + self._near * entry, time)
        level &= (np.abs(there - entry) <= RIGHT).all(axis=1)
        enters, (old, plane) = asked & level, known
        return enters, np.where(enters[:, None], entry, old), np.where(enters, deep, plane)

    def _grazed(self, now: _Now) -> tuple[np.ndarray, np.ndarray]:
        """Where points come to an edge within the plane of the face behind it, and no facet beside
        them reaches below that, (n,) of bool; there its normals, elsewhere those given, (n, d): so
        no joint of flush faces is a wall."""
        points, ways, time, normals, distance = now
        far = RIGHT * np.sqrt(dot(ways, ways))
        if not (asked := (np.abs(distance) <= self._near) & (dot(ways, normals) < -far)).any():
            return asked, normals
        ahead = points + SAME * ways
        behind, level = self._wall.normals(ahead, time), self._wall.distance(ahead, time)
        lowest, _ = self._lowest(points, behind)
        asked &= (np.abs(level) <= self._near) & (dot(ways, behind) >= -far)
        asked &= lowest >= -self._near
        return asked, np.where(asked[:, None], behind, normals)

    def _lowest(self, points: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, float]:
        """How far the middles of the facets around nodes are above their planes, the least of each,
        (n,) in m, or 0; and how far any is from its nodes."""
        corners, lowest = points[self._cells], np.zeros(len(points))
        into = corners.mean(axis=1)[:, None] - corners
        np.minimum.at(lowest, self._cells, (into * normals[self._cells]).sum(axis=2))
        return lowest, largest(into)

    def _inward(self, points: np.ndarray) -> np.ndarray:
        """From nodes into the facets around them, (n, d), at most of length 1."""
        corners = points[self._cells]
        ways, inward = corners.mean(axis=1)[:, None] - corners, np.zeros_like(points)
        np.add.at(inward, self._cells, ways)
        return inward / max(largest(inward), np.finfo(float).tiny)

    def _lain_on(
        self, points: np.ndarray, normals: np.ndarray, distance: np.ndarray, time: float
    ) -> np.ndarray:
        """Normals where nothing has come yet: at an edge of the face on which a facet lies."""
        ways = points[self._cells].mean(axis=1)[:, None] - points[self._cells]
        size = np.linalg.norm(ways, axis=2)
        cell, corner = (np.abs(distance[self._cells]) <= SAME * size).nonzero()
        if not len(cell):
            return normals
        node = self._cells[cell, corner]
        beside = points[node] + SAME * ways[cell, corner]
        order = np.lexsort((self._wall.distance(beside, time), node))  # the nearest of each first
        first = order[np.unique(node[order], return_index=True)[1]]
        node, there = node[first], self._wall.normals(beside[first], time)
        edge = (np.abs(there - normals[node]) > RIGHT).any(axis=1)
        normals = normals.copy()
        normals[node[edge]] = there[edge]
        return normals
