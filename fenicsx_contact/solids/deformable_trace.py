# SPDX-License-Identifier: LGPL-3.0-or-later
"""A deformable solid seen from points of a surface."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse
from scipy.spatial import cKDTree

from .. import checks
from ..theta import Step
from .base import Trace

if TYPE_CHECKING:
    from .deformable import DeformableSolid


class DeformableTrace(Trace):
    """A deformable solid seen from points that are nodes of its mesh; the operator is constant."""

    def __init__(self, solid: DeformableSolid, points: np.ndarray) -> None:
        self._solid, self._reference = solid, points
        n, d = points.shape
        nodes = solid.space.tabulate_dof_coordinates()[: solid.owned // d, :d]
        reach = 1e-8 * np.ptp(points, axis=0).max()
        mine = np.zeros(0, dtype=int)
        node = np.zeros(0, dtype=int)
        if len(nodes):
            distance, nearest = cKDTree(nodes).query(points)
            mine = np.flatnonzero(distance <= reach)
            node = nearest[mine]
        if solid.comm.allreduce(len(mine)) != n:
            raise checks.InputError("points: each point of a trace must be a node of the solid")
        rows = (mine[:, None] * d + np.arange(d)).ravel()
        columns = (node[:, None] * d + np.arange(d)).ravel()
        free = ~np.isin(columns, solid.fixed_unknowns)  # what is held fast does not move
        entries = (np.ones(free.sum()), (rows[free], columns[free]))
        self._operator = scipy.sparse.csr_matrix(entries, (n * d, solid.owned))
        self._transpose = self._operator.T.tocsr()
        self._linearisation = 0
        self._compliance: dict[int, np.ndarray] = {}

    def _sum(self, values: np.ndarray) -> np.ndarray:
        comm = self._solid.comm
        return comm.allreduce(values) if comm.size > 1 else values

    def follow(self) -> None:
        """Nothing to do: the operator is constant."""

    def accept(self) -> None:
        """Nothing to do: the operator is constant."""

    def linearise(self, step: Step) -> None:
        if self._linearisation == self._solid.linearisation:
            return
        self._linearisation = self._solid.linearisation
        self._columns = np.empty((self._operator.shape[1], self._operator.shape[0]))
        unit = np.zeros(self._operator.shape[0])
        for i in range(len(unit)):
            unit[i] = 1.0
            self._columns[:, i] = self._solid.factorisation.solve(self._transpose @ unit)
            unit[i] = 0.0
        self._compliance.clear()

    def positions(self) -> np.ndarray:
        moved = self._sum(self._operator @ self._solid.trial_displacement)
        return self._reference + moved.reshape(self._reference.shape)

    def jump(self, velocity: np.ndarray) -> np.ndarray:
        return self._sum(self._operator @ velocity)

    def mean_jump(self, velocity: np.ndarray) -> np.ndarray:
        return self.jump(velocity)

    def free_jump(self) -> np.ndarray:
        # J A^-1 b = (A^-1 J')' b, for A is symmetric: no solve
        return self._sum(self._columns.T @ self._solid.free_load)

    def compliance(self, other: Trace) -> np.ndarray:
        assert isinstance(other, DeformableTrace)
        if id(other) not in self._compliance:
            self._compliance[id(other)] = self._sum(self._operator @ other._columns)
        return self._compliance[id(other)]

    def spread(self, force: np.ndarray) -> None:
        self._solid._force += self._transpose @ force
