# SPDX-License-Identifier: LGPL-3.0-or-later
"""On which facets of the master the corners of a slave stand.

Two surfaces touch where their gap is least. Between facets that are not parallel that is at a
corner of one of them, and what presses there is normal to the face that the corner touches, not to
the facet that it belongs to. So a facet of the slave that meets the master with a sharp corner
looks along the normal of the facet below that corner, and so do its gaps and jumps; one that lies
flat, or bends only as a mesh of something round does, looks along its own. Facets in one plane are
one face here, however it is meshed.
"""

from __future__ import annotations

import numpy as np

from ...base.constants import ROUND_OFF, SAME, SHARP
from ...base.vectors import largest
from .partners import EDGE, facing, intersect, inverses
from .ridges import Ridges
from .search import FACETS, Near, Spheres, first_of_each, in_tubes
from .side import Side, unit_and_length
from .stance import Stance
from .walls import admission


def edges(side: Side) -> np.ndarray:
    """Between which nodes the sharp edge of a side runs on which a corner of it lies, (n, 2), in
    the reference placement: a corner itself where such edges end, meet, or bend; -1 where there
    are none."""
    ridges, nodes = Ridges.of(side), side.nodes
    juts = np.ones(len(ridges.ends), dtype=bool)
    juts[ridges.inner] = ridges.juts
    ends = ridges.ends[juts]

    result = np.full((int(side.corners.max()) + 1, 2), -1)
    result[ends.ravel()] = ends.ravel()[:, None]
    if side.dim == 3:  # those on two of them that are nearly parallel
        both = np.concatenate([ends, ends[:, ::-1]])
        both = both[np.argsort(both[:, 0], kind="stable")]
        at, first, count = np.unique(both[:, 0], return_index=True, return_counts=True)
        at, first = at[count == 2], first[count == 2]
        a, b = both[first, 1], both[first + 1, 1]
        back, on = (
            unit_and_length(each)[0] for each in (nodes[at] - nodes[a], nodes[b] - nodes[at])
        )
        straight = (back * on).sum(axis=1) > SHARP
        result[at[straight]] = np.stack([a, b], axis=1)[straight]
    return result


class Standing:
    """Finds the facets of a slave that stand on a corner.

    Args:
        slave, master: the sides.
    """

    def __init__(self, slave: Side, master: Side) -> None:
        self._edges, self._rivals = edges(slave), edges(master)[:, 0] >= 0
        self._facets = np.flatnonzero((self._edges[slave.corners, 0] >= 0).any(axis=1))
        self._none, self._slave, self._master = Stance.none(slave), slave.flat, master.flat
        self._admits, self._near = admission(slave, master), Near()

    def find(self, places: np.ndarray, way: float, bears: np.ndarray) -> Stance:
        """On which facets of the master the slave's stand.

        Args:
            places: of the nodes of both, the slave's first, (N, d).
            way: that they are about to go, at most, m.
            bears: corners of the slave that bear, (n,): a flat face lies on those that span it.
        """
        side, master, d = self._slave, self._master, self._slave.dim
        asked = self._facets[bears[side.corners[self._facets]].sum(axis=1) < d]
        if not len(asked):
            return self._none
        corners = side.corners[asked]
        xs, xm = places[: len(side.nodes)], places[len(side.nodes) :]
        reach = np.fmin(FACETS * side.sizes[asked] + 4 * way, np.ptp(places, axis=0).sum())
        unit, _ = unit_and_length(side.middle_normals(xs, asked))
        mine, theirs = Spheres.around(xs[corners]), Spheres.around(xm[master.cells])
        facet, other = in_tubes(unit, reach, mine.radii, mine, theirs, self._near)
        faces = facing(unit[facet], master.middle_normals(xm)[other])
        faces &= self._admits(asked[facet], other, np.full(len(facet), np.inf))  # anywhere
        facet, other = facet[faces], other[faces]

        # how high its corners are above the other side, the nearest of it
        c = corners.shape[1]
        ray, below = (facet[:, None] * c + np.arange(c)).ravel(), other.repeat(c)
        of = ray // c
        xi, height, *_ = intersect(xs[corners.ravel()[ray]], unit[of], master, xm, below)
        meets = master.holds(xi, EDGE) & self._admits(asked[of], below, height)
        hits = np.flatnonzero(meets & (np.abs(height) <= reach[of]))
        hits = hits[np.lexsort((below[hits], np.abs(height[hits]), ray[hits]))]
        nearest = hits[first_of_each(ray[hits])]
        heights, noise = np.full(corners.size, np.inf), ROUND_OFF * largest(places)
        heights[ray[nearest]] = height[nearest]
        hits = hits[np.abs(height[hits] - heights[ray[hits]]) <= noise]  # several, where they meet
        feet = np.column_stack([asked[of[hits]], corners.ravel()[ray[hits]], below[hits]])
        heights = heights.reshape(-1, c)
        # whose corners are level to round-off lies on all of them, unless it stands on one already
        low = np.sort(heights, axis=1)
        bent = bears[corners].any(axis=1) | (low[:, d - 1] > low[:, 0] + noise)
        sharp = ((heights <= low[:, :1] + noise) & (self._edges[corners, 0] >= 0)).any(axis=1)

        # and sharp corners of that above it
        c = master.corners.shape[1]
        point, of, its = master.corners[other].ravel(), facet.repeat(c), other.repeat(c)
        rival = self._rivals[point]
        point, of, its = point[rival], of[rival], its[rival]
        xi, height, *_ = intersect(xm[point], unit[of], side, xs, asked[of])
        over = side.holds(xi, EDGE) & self._admits(asked[of], its, -height)
        rivals = np.full(len(asked), np.inf)
        np.minimum.at(rivals, of[over], -height[over])

        stands = bent & sharp & (low[:, 0] < rivals - EDGE * side.sizes[asked])
        return self._stance(xs, asked[stands], heights[stands], feet, noise, bears)

    def _stance(
        self,
        xs: np.ndarray,
        facet: np.ndarray,
        height: np.ndarray,
        feet: np.ndarray,
        noise: float,
        bears: np.ndarray,
    ) -> Stance:
        """That of facets (q,) that stand, their corners (q, c) so high, and of those in one plane
        with them: a flat face stands, or lies, as a whole. ``feet``: facets of the slave, a corner
        of each, and a facet of the master below it, (k, 3)."""
        side, nobody = self._slave, self._none
        if not len(facet):
            return nobody
        g, across = side.middle_tangents(side.nodes), side.middle_normals(side.nodes)
        unit, _ = unit_and_length(side.middle_normals(xs))
        middle = xs[side.corners].mean(axis=1)
        done, along = np.zeros(len(side.cells), dtype=bool), nobody.along.copy()
        stood: list[tuple[np.ndarray, np.ndarray]] = []
        for i in np.argsort(height.min(axis=1), kind="stable"):
            one = facet[i]
            if done[one]:
                continue
            level = ~done & (np.abs((middle - middle[one]) @ unit[one]) <= SAME * side.size)
            level &= (np.abs(unit - unit[one]) <= SAME).all(axis=1)
            done |= level
            which, mine, its = np.flatnonzero(level), level[facet], feet[level[feet[:, 0]]]
            bearing = np.unique(side.corners[which])
            bearing = bearing[bears[bearing]]
            low = height[mine] <= height[mine].min() + noise
            on = np.unique(side.corners[facet[mine]][low])
            if bears[on].any():  # it stands there already
                on = np.intersect1d(bearing, its[:, 1])
            elif len(bearing) and not np.isin(bearing, its[:, 1]).any():
                continue  # an edge of the master bears it, between its corners
            if self._lies(xs[bearing]) or self._lies(xs[on]):
                continue
            outer = self._outermost(on)
            basis = np.moveaxis(np.concatenate([g[:, which], across[None, which]]), 0, 2)
            share = inverses(basis) @ self._edge(on, outer)  # of the facets, to go with them
            along[which] = share[:, :-1] @ side.middle_slopes
            stood.append((which, np.unique(its[np.isin(its[:, 1], outer), 2])))
        many = max((len(below) for _, below in stood), default=1)
        result = Stance(np.full((len(side.cells), many), -1), along)
        for which, below in stood:
            result.feet[which, : len(below)] = below
        return result

    def _lies(self, places: np.ndarray) -> bool:
        """Whether a flat face does, on corners at places (n, d): on two of them in the plane, on
        three that are not in line in space."""
        d = places.shape[1]
        if len(places) < d:
            return False
        apart = places - places.mean(axis=0)
        return int(np.linalg.matrix_rank(apart, tol=SAME * self._slave.size)) >= d - 1

    def _edge(self, on: np.ndarray, outer: np.ndarray) -> np.ndarray:
        """That on which a face stands by such corners (n,), (d,) in m: that on which they lie, as
        those of a base that bends smoothly do, or, of true corners, between the outer two."""
        ends = self._edges[on]
        along = self._slave.nodes[ends[:, 1]] - self._slave.nodes[ends[:, 0]]
        along = along[ends[:, 0] != ends[:, 1]]
        if len(along):
            return np.asarray((along * np.sign(along @ along[0])[:, None]).sum(axis=0))
        return np.asarray(self._slave.nodes[outer[1]] - self._slave.nodes[outer[0]])

    def _outermost(self, on: np.ndarray) -> np.ndarray:
        """The outer two of corners (n,) in line, of one itself twice: no axes of space choose."""
        x = self._slave.nodes[on]
        one = ((x - x[0]) ** 2).sum(axis=1).argmax()
        return on[[one, ((x - x[one]) ** 2).sum(axis=1).argmax()]]
