# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rows of a hyperelastic solid in a linearised step.

Its matrix is another in each step. As in the run, a factor serves until the run finds its own too
old; what it leaves out then comes back by iteration (:mod:`~.blocks`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from petsc4py import PETSc

from ..solids import HyperelasticSolid
from ..theory.scheme import Step
from ..theory.theta import ThetaScheme
from .inner import Factor, Inner
from .motion import DeformableMotion, Motion, Row, scipy_of


class HyperelasticMotion(DeformableMotion):
    """A hyperelastic solid; its matrices have one pattern, and are sums of their entries.

    Args:
        solid: the solid.
    """

    def __init__(self, solid: HyperelasticSolid) -> None:
        super().__init__(solid)
        self._own: PETSc.Mat = solid.last_stiffness.duplicate()
        pattern = scipy_of(self._own)
        self._pattern = pattern.indices, pattern.indptr
        rows = np.repeat(np.arange(self.size), np.diff(pattern.indptr))
        places = rows.astype(np.int64) * self.size + pattern.indices
        mass = self._mass.tocoo()
        mass.sum_duplicates()
        asked = mass.row.astype(np.int64) * self.size + mass.col
        order = np.argsort(places)
        at = order[np.searchsorted(places, asked, sorter=order)]
        hold = np.isin(np.arange(self.size), self.held)
        self._free_rows = (~hold[rows]).astype(float)
        self._free = self._free_rows * ~hold[pattern.indices]
        self._hold = (hold[rows] & (rows == pattern.indices)).astype(float)
        self._inertia = np.zeros(len(places))
        self._inertia[at] = mass.data
        self._inertia *= self._free_rows
        self._key: tuple[float, ...] = ()
        self._solver: Inner | None = None

    def _matrix(self, entries: np.ndarray) -> sp.csr_matrix:
        return sp.csr_matrix((entries, *self._pattern), (self.size, self.size), copy=False)

    def _rows(self, step: Step) -> tuple[Row, Row, Inner]:
        late = step.inertia_rate * self._inertia
        early, old, new = -late, np.zeros_like(late), np.zeros_like(late)
        if step.loaded:
            old, new = self._stiffnesses(step)
        if step.loaded and step.scheme.inertia and self.solid.dampers:
            before, after = step.scheme.linear_weights
            viscous, bent = self._dampers(step)
            early, late = early + before * viscous, late + after * viscous
            old, new = old + (1 - step.force_share) * bent, new + step.force_share * bent
        q, v, q_old, v_old = map(self._matrix, (new, late + self._hold, old, early))
        balance = Row(q, v, q_old, v_old, np.empty(0))
        whole = (late + step.gap_rate * new) * self._free + self._hold
        return Motion.kinematics(self, step), balance, self._inner_of(step, whole, balance.q)

    def _inner_of(self, step: Step, whole: np.ndarray, stiffness: sp.csr_matrix) -> Inner:
        """Its solver: the last one's factor, as long as the run keeps its own."""
        key = (self.solid.linearisation, step.inertia_rate, step.gap_rate, step.loaded)
        matrix = self._matrix(whole)
        if self._solver is None or key != self._key:
            self._key = key
            near, symmetric = self._near(step, matrix), not self.solid.dampers
            factor = Factor(near, self.solid.name, symmetric, self.held)
        else:
            factor = self._solver.factor
        rest = stiffness, step.gap_rate, self.held, matrix, self._loose(step)
        self._solver = Inner(factor, *rest)
        return self._solver

    def _stiffnesses(self, step: Step) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the mean internal force by the displacements at both ends."""
        old = new = np.zeros(len(self._free))
        for (share, _), (weight, place) in zip(step.scheme.force_points, self._places):
            matrix = self._empty()
            self.solid.add_stiffness(matrix, place, weight)
            entries = self._entries(matrix)
            old, new = old + (1 - share) * entries, new + share * entries
        return old, new

    def _dampers(self, step: Step) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the damping forces by the velocity, and by the displacement at which they
        are taken."""
        solid, (start, end), share = self.solid, self._ends, step.force_share
        place = share * end + (1 - share) * start
        rate = step.rate(solid.velocity, solid.trial_velocity)
        whole = replace(step, scheme=ThetaScheme(1.0))  # of which the velocity is that at the end
        matrix = self._empty()
        for damper in solid.dampers:
            damper.add_to(matrix, whole, place, place)
        viscous = self._entries(matrix)
        matrix = self._empty()
        for damper in solid.dampers:
            damper.add_bent(matrix, place, rate)
        return viscous, self._entries(matrix)

    def _entries(self, matrix: PETSc.Mat) -> np.ndarray:
        """Its entries, without the rows of what is held."""
        entries: np.ndarray = matrix.getValuesCSR()[2]
        return entries * self._free_rows

    def _empty(self) -> PETSc.Mat:
        """A matrix of the solid's pattern without values, always the same."""
        self._own.zeroEntries()
        return self._own
