# SPDX-License-Identifier: LGPL-3.0-or-later
"""What of many rigid bodies may meet in a step: corners and faces, and edges that cross.

A corner meets a face if it lies over it, and if the body behind it does not reach through the plane
of the face (else the corner is not what is nearest). Of several faces of one body that counts from
which it is farthest: where bodies touch, the others lie aside, however deep the corner is behind
them; from which it will be, where it is as far from several. But faces that see each other, as
those in an inner corner do, count each for itself. Two edges meet if they cross, and if both bodies
lie on their sides of the plane that they span. Who is over what may change in the step: it is asked
at its start and where velocities lead.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from ...base.constants import SAME
from ...base.vectors import dot
from ..mortar.search import counted
from ..mortar.walls import WALL
from .between import apart, distances, unseen
from .crossing import crossing, nearest
from .faces import as_far, at_edge, not_aside, over_faces
from .shape import Ragged, Shape

#: Cost: bodies are asked that are nearer than this share of the smaller, and than so many times
#: their ways to each other in the step; what goes farther stops the step.
CLOSE, AHEAD = 0.05, 4.0


@dataclass
class Features:
    """Corners before faces, and crossing edges.

    Attributes:
        key: one for each, (k,), that stays while the same corner meets the same part of a body, or
            the same two edges each other.
        mine: the nodes of the edge, or the corner twice, (k, 2), and ``theirs``: of the other edge
            twice or the face, (k, 3), of which the plane has two.
        face: number of the face, or -1 for edges, (k,).
        turn: +1 where the cross product of the edges shows from the first to the other, else -1.
        height: how far they are apart, (k,) in m.
    """

    key: np.ndarray
    mine: np.ndarray
    theirs: np.ndarray
    face: np.ndarray
    turn: np.ndarray
    height: np.ndarray

    @classmethod
    def together(cls, several: list[Features]) -> Features:
        """All of these."""
        return cls(*(np.concatenate(each) for each in zip(*(vars(f).values() for f in several))))


class Places:
    """Where nodes are and lead, and the boxes around bodies.

    Args:
        start, end: of the nodes, (N, d) in m.
        starts: the first node of each body.
        reach, goes: how near counts, and how far they may go, of each pair, (p,) in m; ``inside``:
            how deep either is in something.
        known: the keys of what met before.
    """

    def __init__(
        self,
        start: np.ndarray,
        end: np.ndarray,
        starts: list[int],
        reach: Any = None,
        goes: Any = None,
        inside: Any = None,
        known: Any = None,
    ) -> None:
        self.start, self.end = start, end
        self.reach, self.goes, self.inside, self.known = reach, goes, inside, known
        self.least, self.most = np.minimum(start, end), np.maximum(start, end)
        low = np.minimum.reduceat(self.least, starts)
        self.boxes = low, np.maximum.reduceat(self.most, starts)


class Search:
    """Finds the features.

    Args:
        shape: of the bodies.
        fixed: bodies that cannot move, (B,) of bool: they do not meet each other.
    """

    def __init__(self, shape: Shape, fixed: np.ndarray) -> None:
        self._shape, self._fixed = shape, fixed
        self._starts = [at.start for at in shape.slices]
        self._sizes = np.array([at.stop - at.start for at in shape.slices])

    def __call__(
        self, x: np.ndarray, way: np.ndarray, depths: np.ndarray, known: np.ndarray
    ) -> Features:
        """Those of nodes at x (N, d) that are about to go a ``way`` (N, d), of bodies that are so
        deep in others (B,), all in m; of keys that are ``known`` something met before."""
        way = self._seen(way)
        pairs, reach = self._pairs(x, way)
        goes = AHEAD * self._apart(way, pairs)
        each = reach, goes, depths[pairs].max(axis=1, initial=0.0)
        wide, far, inside = np.tile(each, 2)  # of either body before the other
        places = Places(x, x + way, self._starts, wide, far, inside, known)
        found = [self._corners(np.concatenate([pairs, pairs[:, ::-1]]), places)]
        if self._shape.dim == 3:
            found.append(self._edges(pairs, places))
        return self._nearest_only(Features.together(found), x)

    def _nearest_only(self, found: Features, x: np.ndarray) -> Features:
        """Without those by which convex bodies are deeper in each other than they are."""
        s = self._shape
        pairs = np.sort(s.body[np.stack([found.mine[:, 0], found.theirs[:, 0]], axis=1)], axis=1)
        same = SAME * s.sizes[pairs].min(axis=1)
        behind = np.flatnonzero((found.height < -same) & s.convex[pairs].all(axis=1))
        asked, which = np.unique(pairs[behind], axis=0, return_inverse=True)
        least = np.minimum(distances(s, x, asked), 0.0)[which.ravel()] - same[behind]
        few = behind[found.height[behind] < least]
        return Features(*(np.delete(each, few, axis=0) for each in vars(found).values()))

    def near(self, x: np.ndarray) -> np.ndarray:
        """Bodies at rest that are near each other, (p, 2)."""
        return self._pairs(x, np.zeros_like(x))[0]

    def blind(
        self,
        x: np.ndarray,
        way: np.ndarray,
        foreseen: np.ndarray,
        depths: np.ndarray,
    ) -> bool:
        """Whether two bodies went so far, by the ways (N, d) of their nodes, that they might have
        met otherwise than was asked for those that were ``foreseen``, or where they came near each
        other gone through a thin one, or are deeper in each other than it is known that they are in
        anything, (B,) in m."""
        s, way = self._shape, self._seen(way)
        pairs, _ = self._pairs(x, way)
        gone, known = (self._apart(each, pairs) for each in (way, foreseen))
        size, thin = (each[pairs].min(axis=1) for each in (s.sizes, s.thin))
        boxes = Places(x, x + way, self._starts).boxes
        low, high = boxes[0][pairs].max(axis=1), boxes[1][pairs].min(axis=1)
        meets = (low <= high).all(axis=1)
        far = gone > CLOSE * size + AHEAD * known
        deep = meets & (gone > WALL * thin)
        if deep.any():  # where both are, a body that spins may hardly go
            gone = self._between(x, way, pairs[deep], (low[deep], high[deep]))
            deep[deep] = gone > WALL * thin[deep]
        return bool((far | deep).any() or unseen(s, x, x + way, pairs[meets], depths).any())

    def _between(
        self, x: np.ndarray, way: np.ndarray, pairs: np.ndarray, box: tuple[np.ndarray, np.ndarray]
    ) -> np.ndarray:
        """The longest ways of bodies of pairs (p, 2) to each other within boxes (p, d) that both
        may be in, (p,): those of what is rigid change with the place as an affine function does,
        and are longest at a corner."""
        d = self._shape.dim
        longest, ends = np.zeros(len(pairs)), np.stack(box, axis=2)
        rigid = {body: self._affine(x, way, body) for body in np.unique(pairs)}
        for i, (one, other) in enumerate(pairs):
            corners = np.array(list(product(*ends[i]))).reshape(-1, d)
            ways = [w + (corners - m) @ G for m, w, G in (rigid[one], rigid[other])]
            longest[i] = np.linalg.norm(ways[0] - ways[1], axis=1).max()
        return longest

    def _affine(self, x: np.ndarray, way: np.ndarray, body: int) -> tuple[np.ndarray, ...]:
        """The middle of a body, the way of that, and how ways differ elsewhere, (d, d)."""
        at = self._shape.slices[body]
        middle, mean = x[at].mean(axis=0), way[at].mean(axis=0)
        return middle, mean, np.linalg.lstsq(x[at] - middle, way[at] - mean, rcond=None)[0]

    def _means(self, way: np.ndarray) -> np.ndarray:
        """The mean way of each body, (B, d)."""
        return np.asarray(np.add.reduceat(way, self._starts) / self._sizes[:, None])

    def _seen(self, way: np.ndarray) -> np.ndarray:
        """Ways as they are seen by who moves along, unless something stands."""
        return way if self._fixed.any() else way - self._means(way).mean(axis=0)

    def _apart(self, way: np.ndarray, pairs: np.ndarray) -> np.ndarray:
        """The longest ways, at most, of nodes of the bodies of pairs (p, 2) to each other, (p,)."""
        means = self._means(way)
        off = way - np.repeat(means, self._sizes, axis=0)
        around = np.maximum.reduceat(np.sqrt(dot(off, off)), self._starts)
        a, b = pairs.T
        between = means[a] - means[b]
        return np.asarray(np.sqrt(dot(between, between)) + around[a] + around[b])

    def _pairs(self, x: np.ndarray, way: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Bodies whose boxes are near each other, (p, 2), and how near counts, (p,) in m."""
        s, ways = self._shape, np.maximum.reduceat(np.sqrt(dot(way, way)), self._starts)
        low, high = Places(x, x + way, self._starts).boxes
        grown = CLOSE * s.sizes + AHEAD * ways
        low, high = low - grown[:, None], high + grown[:, None]
        order = np.argsort(low[:, 0], kind="stable")  # along the first axis one after the other
        last = np.searchsorted(low[order, 0], high[order, 0], side="right")
        count = last - np.arange(len(order)) - 1
        first = np.repeat(np.arange(len(order)), count)
        second = first + 1 + counted(count)
        a, b = order[first], order[second]
        near = ((low[a] <= high[b]) & (low[b] <= high[a])).all(axis=1)
        near &= ~(self._fixed[a] & self._fixed[b])
        pairs = np.sort(np.stack([a[near], b[near]], axis=1), axis=1)
        pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
        reach = CLOSE * s.sizes[pairs].min(axis=1) + AHEAD * self._apart(way, pairs)
        return pairs, reach

    def _around(
        self, lists: Ragged, nodes: np.ndarray, mine: np.ndarray, others: np.ndarray, places: Places
    ) -> tuple[np.ndarray, np.ndarray]:
        """The entries of the lists of bodies ``mine`` (p,) whose nodes (entries, k) come near the
        boxes of the ``others``: number of the pair, and entry."""
        pair, entry = lists.of(mine)
        at, wide = nodes[entry], places.reach[pair][:, None]
        least = places.least[at].min(axis=1)
        most = places.most[at].max(axis=1)
        low, high = (bound[others[pair]] for bound in places.boxes)
        near = ((least <= high + wide) & (most >= low - wide)).all(axis=1)
        return pair[near], entry[near]

    def _corners(self, pairs: np.ndarray, places: Places) -> Features:
        s, every, x = self._shape, np.arange(len(places.start))[:, None], places.start
        pair, corner = self._around(s.corners, every, pairs[:, 0], pairs[:, 1], places)
        of, face = s.faces.of(pairs[pair, 1])
        pair, corner = pair[of], corner[of]
        far = places.goes[pair] + SAME * s.sizes[s.owner[face]]
        inside = places.inside[pair]
        height, over, beyond = over_faces(s, corner, face, x, (far, inside))
        ahead, then, goes_on = over_faces(s, corner, face, places.end, (far, inside))
        over |= then
        bodies = pairs[pair]
        deep = -WALL * s.thin[bodies].min(axis=1)
        over &= height >= deep
        next_to = beyond | goes_on, over
        over &= ~at_edge(s, corner, face, (height, ahead), x, inside, next_to)
        pair, corner, face, height, ahead = (a[over] for a in (pair, corner, face, height, ahead))
        behind = np.flatnonzero((height < 0) & ~s.convex[pairs[pair]].all(axis=1))
        start, to = x[corner[behind]], face[behind]
        foot = start - height[behind, None] * s.units(x, to)
        over = np.ones(len(face), dtype=bool)
        over[behind[apart(s, x, (start, foot), s.owner[to])]] = False
        pair, corner, face, height, ahead = (a[over] for a in (pair, corner, face, height, ahead))
        key = corner * s.parts + s.part[face]
        same = SAME * s.sizes[s.owner[face]]
        # of those as far the one that will be farther: where corners meet it is not known
        order = np.lexsort((face, -ahead, -np.round(height / same), key))
        order, key = as_far(s, order, key, face, (height, ahead), x, places.known)
        order = order[height[order] <= places.reach[pair[order]]]  # beside the others, if farther
        order = order[not_aside(s, corner[order], face[order], height[order], x)]
        corner, face = corner[order], face[order]
        none = np.ones(len(order))
        theirs = s.outline[face][:, [0, 1, -1 if s.dim == 2 else 2]]
        mine = np.stack([corner, corner], axis=1)
        return Features(key[order], mine, theirs, face, none, height[order])

    def _edges(self, pairs: np.ndarray, places: Places) -> Features:
        s, x = self._shape, places.start
        one, mine = self._around(s.edges, s.ends, pairs[:, 0], pairs[:, 1], places)
        other, theirs = self._around(s.edges, s.ends, pairs[:, 1], pairs[:, 0], places)
        of_pair = Ragged(other, theirs, len(pairs))
        of, theirs = of_pair.of(one)
        pair, mine = one[of], mine[of]
        goes = places.goes[pair]
        inside = places.inside[pair]
        height, turn, cross = crossing(s, mine, theirs, x, goes, inside)
        cross |= crossing(s, mine, theirs, places.end, goes, inside)[2]
        bodies = pairs[pair]
        deep = -WALL * s.thin[bodies].min(axis=1)
        cross &= (height <= places.reach[pair]) & (height >= deep)
        behind = np.flatnonzero(cross & (height < 0) & ~s.convex[bodies].all(axis=1))
        ends = nearest(s, mine[behind], theirs[behind], x)
        for body in bodies[behind].T:
            cross[behind[apart(s, x, ends, body)]] = False
        mine, theirs, height, turn = (a[cross] for a in (mine, theirs, height, turn))
        key = len(x) * s.parts + mine * len(s.ends) + theirs
        ends = s.ends[theirs][:, [0, 1, 1]]
        return Features(key, s.ends[mine], ends, np.full(len(key), -1), turn, height)
