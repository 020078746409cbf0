# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact points without solids: the equations of a surface, and any compliance that joins them.

The laws are those of a scene, compiled from the same UFL on a surface whose nodes are the points;
where these lie means nothing. Coordinates of space are those of the points' own frames, so that
the normal of the slave, which points at the obstacle, is minus the first one.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..base.vectors import components, largest
from ..contact.equations import SurfaceEquations
from ..contact.scales import inverse
from ..contact.surface import Surface
from ..solve.newton import Newton, NotConverged, Solution
from ..solve.problem import scale_of
from ..solve.surface_problem import SurfaceSystem
from ..theory.formulations import PRINTED
from ..theory.friction import Coulomb

#: Cost: surfaces of so many sizes are kept; a new one takes as long as some ten steps.
KEPT = 16


class Points:
    """At least so many points, forces at them in N, by laws (1)-(4') without gaps.

    Args:
        size: how many; more nodes are there, which bear nothing.
        dim: of space, 2 or 3.
    """

    def __init__(self, size: int, dim: int) -> None:
        node = np.arange(max(size, dim))
        # a line of intervals, or a strip of triangles
        places = np.zeros((len(node), dim))
        places[:, 0] = node
        if dim == 3:
            places[:, 1] = node % 2
        cells = np.arange(len(node) - dim + 1)[:, None] + np.arange(dim)
        surface = Surface(places, cells, "interval" if dim == 2 else "triangle")
        self._contact = surface.points[:, 0].round().astype(int)  # of each node
        self._dim, self._mu = dim, surface.scalar()
        everywhere = np.ones(surface.size, dtype=bool)
        self._equations = SurfaceEquations(
            surface, PRINTED, Coulomb(self._mu), everywhere, np.ones(surface.size), (1.0, 1.0)
        )
        normal = np.zeros((surface.size, dim))
        normal[:, 0] = -1.0
        self._equations.fields.set_normal(normal)

    def solve(
        self, W: np.ndarray, q: np.ndarray, mu: np.ndarray, newton: Newton
    ) -> tuple[np.ndarray, Solution, str]:
        """Forces (n dim,), what was found, and why it is no solution, or nothing; see
        :class:`~fenicsx_contact.frictional.problem.FrictionalProblem`."""
        e, d, n = self._equations, self._dim, len(mu)
        e.freeze_bound(0.0)  # as the method of multipliers may have left it, if it was stopped
        e.choose(self._contact < n)
        mine = self._contact[e.candidates]
        order = components(mine, d)
        W, q = W[np.ix_(order, order)], q[order]
        self._mu.x.array[e.candidates] = mu[mine]
        yields = W.diagonal().reshape(n, d)
        units = np.ones((2, len(self._contact)))
        units[:, e.candidates] = inverse(yields[:, 0]), inverse(yields[:, 1:].mean(axis=1))
        e.set_scale(units, units, scale_of(largest(q)))
        e.values = np.zeros(e.size)
        e.set_places(q)
        system = SurfaceSystem([e], ["points"], hyperstatic=np.linalg.matrix_rank(W) < len(W))
        system.arrange()
        system.begin(q, W)
        try:
            solution, reason = _solved(system, newton), ""
        except NotConverged as failure:
            solution, reason = Solution(system.force(), 0, system.worst), str(failure)
        force = np.zeros(len(q))
        force[order] = solution.force.reshape(-1, d)[e.candidates].ravel()
        return force, solution, reason


def _solved(system: SurfaceSystem, newton: Newton) -> Solution:
    """As in a step; where that ends without a solution once more from there: the method of
    multipliers is slow, and Newton's method ends what it came near. A step would be halved."""
    try:
        return newton.solve(system)
    except NotConverged as failure:
        found = newton.solve(system)
        found.remarks.insert(0, str(failure))
        return found


@lru_cache(maxsize=KEPT)
def points(size: int, dim: int) -> Points:
    """Points of a size that is a power of two: surfaces are kept, and there are few sizes."""
    return Points(size, dim)
