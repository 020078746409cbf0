# SPDX-License-Identifier: LGPL-3.0-or-later
"""Points at which rigid bodies meet: their gaps, normals and jumps.

A point is a place for a corner before a face, or for two edges that cross, and keeps it from step
to step. Its gap is their distance, exactly; the velocities at both ends of that are those of the
nodes, for a body that is rigid moves each of its points as a mean of its nodes does, with weights
that may be negative:

    w = sum_a alpha_a v_a - sum_b beta_b v_b,    d_n = n . (sum_a alpha_a x_a - sum_b beta_b x_b)

with n out of the body whose corner it is, or that comes first. So n . w is the rate of d_n.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from ...base.checks import StepFailed
from ...base.constants import SAME
from ...base.vectors import dot
from ..mortar.matrices import DENSE, Matrix, used_columns
from ..simplices import shares
from .faces import within
from .search import Features
from .shape import Shape

#: Cost: places of points for each node of a body in the plane and in space: so many others may meet
#: in a corner where all are squares or cubes; if there are more the step stops.
PLACES = {2: 3, 3: 7}


class Alone:
    """What one process that has all points shares with others: nothing; see
    :class:`~fenicsx_contact.contact.mortar.shares.Shares`."""

    def __init__(self, points: int) -> None:
        self.node_here = np.ones(points, dtype=bool)

    def anywhere(self, truth: bool) -> bool:
        """Whether that holds."""
        return bool(truth)

    def sum(self, values: np.ndarray) -> np.ndarray:
        """The same."""
        return values

    def whole(self, share: Matrix) -> Matrix:
        """The same."""
        return share

    def columns(self, matrices: Sequence[Matrix]) -> np.ndarray:
        """Columns that have an entry in any of these matrices."""
        return used_columns(matrices)


class Meetings:
    """Places for points, and what meets there; what a part of the equations asks of a pairing.

    Args:
        shape: of the bodies.
        homes: for each point the node at which it is drawn, if it can: (n,).
        area: of the surface that belongs to it there, (n,).

    Attributes:
        n, total, dense, operator, gap, area, shared: see
            :class:`~fenicsx_contact.contact.mortar.Pairing`; here every process has all.
        slots: the points of each body.
        normal: out of the body whose point it is, (n, d).
        there: points at which something meets, (n,) of bool.
        features: what meets at each point.
    """

    def __init__(self, shape: Shape, homes: np.ndarray, area: np.ndarray) -> None:
        self._shape, self._homes, self.area = shape, homes, area
        of = shape.body[homes]
        self.slots = [np.flatnonzero(of == body) for body in range(len(shape.slices))]
        self.n, self.total = len(area), len(shape.nodes)
        self.dense = self.n * self.total * shape.dim**2 <= DENSE
        self.shared = Alone(self.n)
        none = np.full(self.n, -1)
        nodes = np.zeros((self.n, 3), dtype=np.int64)
        self.features = Features(none, nodes[:, :2], nodes, none, np.ones(self.n), np.zeros(self.n))
        self.features.mine[:] = self.features.theirs[:] = homes[:, None]  # where nothing meets
        self.normal, self.gap = np.empty((self.n, shape.dim)), np.full(self.n, -np.inf)
        self.there = np.zeros(self.n, dtype=bool)
        self.alpha, self.beta = np.zeros((self.n, 2)), np.zeros((self.n, 3))

    def take(self, found: Features, busy: np.ndarray) -> np.ndarray:
        """Let these meet, those that did in their old places, others where nothing is ``busy``,
        (n,) of bool, as far as possible; which points are others now."""
        now = self.features
        source = np.full(self.n, -1)  # which of those found meets at each point
        order = np.argsort(found.key, kind="stable")
        at = np.searchsorted(found.key[order], now.key)
        known = np.flatnonzero((now.key >= 0) & (at < len(order)))
        known = known[found.key[order[at[known]]] == now.key[known]]
        source[known] = order[at[known]]
        free = source < 0
        new = np.ones(len(found.key), dtype=bool)
        new[source[known]] = False
        fresh = np.zeros(self.n, dtype=bool)
        where, more = np.flatnonzero(new), found.key >= self._shape.keys
        # the nearest first, more faces that one corner is as far from last, if there is room
        where = where[np.lexsort((found.height[where], more[where]))]
        for k in where:
            node = found.mine[k, 0]
            mine = self.slots[self._shape.body[node]]
            mine = mine[free[mine]]
            if not len(mine):
                if more[k]:
                    continue
                most = PLACES[self._shape.dim]
                raise StepFailed(
                    f"a body meets others at more than {most} points for each of its nodes"
                )
            place = mine[np.lexsort((self._homes[mine] != node, busy[mine]))[0]]
            source[place], free[place], fresh[place] = k, False, True
        gone = (now.key >= 0) & (source < 0)
        taken = np.flatnonzero(source >= 0)
        for name, values in vars(now).items():
            mine = values.copy()
            mine[taken] = getattr(found, name)[source[taken]]
            if name in ("key", "face"):
                mine[source < 0] = -1
            setattr(self.features, name, mine)
        self.there = self.features.key >= 0
        return fresh | gone

    def depths(self, x: np.ndarray) -> np.ndarray:
        """How deep each body is in others, at most, (B,) in m, at these places of the nodes, which
        have been taken up: what lies beside what it was to meet is not."""
        result, f = np.zeros(len(self.slots)), self.features
        deep = np.flatnonzero(self.there & (self.gap > 0))
        deep = deep[~self.beside(x, deep)]
        for nodes in (f.mine, f.theirs):
            np.maximum.at(result, self._shape.body[nodes[deep, 0]], self.gap[deep])
        return result

    def update(self, x: np.ndarray) -> None:
        """Take up new places (N, d) of the nodes."""
        f, s = self.features, self._shape
        on = np.flatnonzero(self.there & (f.face >= 0))
        cross = np.flatnonzero(self.there & (f.face < 0))
        alpha, beta = np.zeros((self.n, 2)), np.zeros((self.n, 3))
        if len(on):
            corner, face = f.mine[on, 0], f.theirs[on]
            normal = s.units(x, f.face[on])
            alpha[on, 0] = 1.0
            arm, first = x[corner] - x[face[:, 0]], x[face[:, 1]] - x[face[:, 0]]
            if s.dim == 2:
                beta[on, 1] = dot(arm, first) / dot(first, first)
            else:
                second = x[face[:, 2]] - x[face[:, 0]]
                aa, bb, ab = dot(first, first), dot(second, second), dot(first, second)
                pa, pb, det = dot(arm, first), dot(arm, second), aa * bb - ab**2
                beta[on, 1], beta[on, 2] = (bb * pa - ab * pb) / det, (aa * pb - ab * pa) / det
            beta[on, 0] = 1.0 - beta[on, 1] - beta[on, 2]
            self.normal[on], self.gap[on] = -normal, -dot(arm, normal)
        if len(cross):
            a, b = (x[f.mine[cross, i]] for i in (0, 1))
            c, d = (x[f.theirs[cross, i]] for i in (0, 1))
            normal = np.cross(b - a, d - c)
            normal *= (f.turn[cross] / np.sqrt(dot(normal, normal)))[:, None]
            mine, theirs = shares(a, b - a, c, d - c)
            alpha[cross] = np.stack([1 - mine, mine], axis=1)
            beta[cross, 0], beta[cross, 1] = 1 - theirs, theirs
            self.normal[cross], self.gap[cross] = normal, dot(a - c, normal)
        none = ~self.there
        self.gap[none], self.normal[none] = -np.inf, np.eye(s.dim)[-1]
        self.alpha, self.beta = alpha, beta
        self.places = (alpha[:, :, None] * x[f.mine]).sum(axis=1)
        self.places[none] = x[self._homes[none]]
        self._operator: Matrix | None = None

    def beside(self, x: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Whether at such places the corners of points (k,) lie beside their faces, and all that
        goes on in the planes of these, or their edges do not cross, (k,) of bool."""
        f = self.features
        both = np.concatenate([self.alpha[points], self.beta[points, :2]], axis=1)
        result, on = both.min(axis=1) < -SAME, np.flatnonzero(f.face[points] >= 0)
        corner, face = x[f.mine[points[on], 0]], f.face[points[on]]
        result[on] = ~within(self._shape, corner, face, x)
        return np.asarray(result)

    @property
    def operator(self) -> Matrix:
        """J, (n d, N d)."""
        if self._operator is None:
            d, f = self._shape.dim, self.features
            nodes = np.concatenate([f.mine, f.theirs], axis=1)
            weight = np.concatenate([self.alpha, -self.beta], axis=1)
            row = np.repeat(np.arange(self.n), nodes.shape[1])
            size = self.n * d, self.total * d
            there = np.flatnonzero(weight.ravel())
            rows, columns = (
                (each[there, None] * d + np.arange(d)).ravel() for each in (row, nodes.ravel())
            )
            J = sp.csr_matrix((weight.ravel()[there].repeat(d), (rows, columns)), size)
            self._operator = J.toarray() if self.dense else J
        return self._operator

    def jumps(self, velocities: np.ndarray) -> np.ndarray:
        """J v of all nodes, flat."""
        v, f = velocities.reshape(self.total, -1), self.features
        jump = (self.alpha[:, :, None] * v[f.mine]).sum(axis=1)
        return np.asarray((jump - (self.beta[:, :, None] * v[f.theirs]).sum(axis=1)).ravel())

    def apart(self, changes: np.ndarray) -> np.ndarray:
        """How much changes of the velocities of all nodes, flat, change speeds of approach, of
        both bodies each for itself, (n,)."""
        v, f, n = changes.reshape(self.total, -1), self.features, self.normal
        mine = (self.alpha[:, :, None] * v[f.mine]).sum(axis=1)
        theirs = (self.beta[:, :, None] * v[f.theirs]).sum(axis=1)
        return np.asarray(np.abs(dot(mine, n)) + np.abs(dot(theirs, n)))
