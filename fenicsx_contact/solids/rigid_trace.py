# SPDX-License-Identifier: LGPL-3.0-or-later
"""A rigid solid seen from points of a surface."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import scipy.sparse as sp

from ..theory.scheme import Step
from .base import MonolithicTrace, Trace
from .rotations import ARMS, by_spins


class TracedSolid(Protocol):
    """What a trace asks of its solid.

    Attributes:
        dim: d, dimension of space.
        velocity: of the centre of mass and spin, (3,) in 2D, (6,) in 3D.
        free_velocity: that at the end of the step if no contact acted.
        inverse: A^-1 of ``A v+ = b + J' f``.
        trial_place: the centre of mass in the trial state, (d,) in m.
        trial_turn: the rotation there, (d, d).
        held: numbers of the components that are held.
    """

    dim: int
    velocity: np.ndarray
    free_velocity: np.ndarray
    inverse: np.ndarray
    trial_place: np.ndarray
    trial_turn: np.ndarray
    held: np.ndarray

    def push(self, force: np.ndarray) -> None:
        """Add to the forces on the solid in this step, N and N m."""


class RigidTrace(MonolithicTrace):
    """A rigid solid seen from points; the operator follows the rotation.

    Args:
        solid: the solid.
        points: from its centre of mass, in the reference placement, (n, d) in m.
    """

    def __init__(self, solid: TracedSolid, points: np.ndarray) -> None:
        self._solid, self._reference = solid, points
        self._translation = np.zeros((*points.shape, len(solid.velocity)))
        self._translation[:, range(solid.dim), range(solid.dim)] = 1.0
        self._pattern = self._may_be()
        self.held = ~self._pattern[0].any(axis=1)
        self.follow()
        self.accept()
        self._spreads: sp.csr_matrix | None = None

    def follow(self) -> None:
        self._operator = self._build(self._solid.trial_turn)
        self._sees: sp.csr_matrix | None = None

    def linearise(self, step: Step) -> None:
        # forces act through the operator at the place where the scheme takes forces
        weight = step.scheme.force_weight
        self._force_operator = weight * self._operator + (1 - weight) * self._start_operator
        self._columns = self._solid.inverse @ self._force_operator.T
        self._spreads = None

    def accept(self) -> None:
        self._start_operator = self._operator

    def _build(self, turn: np.ndarray) -> np.ndarray:
        d, n = self._solid.dim, len(self._reference)
        self._arm = self._reference @ turn.T
        operator = self._translation.copy()
        operator[:, :, d:] = by_spins(self._arm)
        if len(self._solid.held):
            operator[:, :, self._solid.held] = 0.0  # does not move
        return operator.reshape(n * d, -1)

    def _may_be(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Where the operator may have entries; their columns, and where rows begin."""
        d, n = self._solid.dim, len(self._reference)
        may = self._translation != 0
        may[:, :, d:] = ARMS[d].any(axis=0).reshape(d, -1)
        may[:, :, self._solid.held] = False
        may = may.reshape(n * d, -1)
        return may, np.nonzero(may)[1], np.append(0, may.sum(axis=1).cumsum())

    def positions(self) -> np.ndarray:
        return self._solid.trial_place + self._arm

    def jump(self, velocity: np.ndarray) -> np.ndarray:
        return self._operator @ velocity

    def start_jump(self, velocity: np.ndarray) -> np.ndarray:
        return self._start_operator @ velocity

    def mean_jump(self, velocity: np.ndarray) -> np.ndarray:
        return self._force_operator @ velocity

    def free_jump(self) -> np.ndarray:
        return self._operator @ self._solid.free_velocity

    def compliance(self, mine: np.ndarray, other: Trace, theirs: np.ndarray) -> np.ndarray:
        assert isinstance(other, RigidTrace)
        if len(mine) == len(self._operator) and len(theirs) == len(other._operator):
            return self._operator @ other._columns
        return self._operator[mine] @ other._columns[:, theirs]

    def mobility(self) -> np.ndarray:
        return np.einsum("ij,ji->i", self._operator, self._columns)

    def rows(self, which: np.ndarray) -> np.ndarray:
        return self._operator[which]

    def seeing(self) -> sp.csr_matrix:
        if self._sees is None:
            self._sees = self._sparse(self._operator)
        return self._sees

    def spreading(self) -> sp.csr_matrix:
        if self._spreads is None:
            self._spreads = self._sparse(self._force_operator)
        return self._spreads

    def _sparse(self, operator: np.ndarray) -> sp.csr_matrix:
        may, columns, ends = self._pattern
        return sp.csr_matrix((operator[may], columns, ends), operator.shape)

    def spread(self, force: np.ndarray) -> None:
        self._solid.push(force @ self._force_operator)
