# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rows of a solid in a linearised step: how it moves, and its balance of momentum.

With q the displacement (of a rigid solid: the centre of mass and the angle, in space a small
rotation beside the one there is), v the velocity, dt the length of the step::

    q+ = q- + increment(v-, v+)            (p+ - p-)/dt + internal - loads - J' f = 0

Each row is told by its derivatives by (q+, v+), (q-, v-) and dt; the forces f of the contacts are
for those to tell.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from petsc4py import PETSc

from ..base.constants import KEPT
from ..solids import DeformableSolid
from ..solids.motions import Motions
from ..theory.scheme import Step
from ..theory.theta import ThetaScheme
from .blocks import InnerSolver
from .inner import Factor, Inner
from .kinematics import Kinematics
from .parameters import Parameter
from .said import said

#: Cost: of inertia beside stiffness where it holds what only contacts hold; how soon the iteration
#: that takes it away ends.
LITTLE = 1e-6


class Row(NamedTuple):
    """Derivatives of a residual by q+, v+, q-, v- and dt."""

    q: Any
    v: Any
    q_old: Any
    v_old: Any
    dt: np.ndarray


class Motion(ABC):
    """A solid in the step that has been solved and is not yet accepted.

    Attributes:
        solid: the solid.
        size: number of its unknowns.
        held: those that are held.
        one: the identity.
    """

    solid: Any
    size: int
    held: np.ndarray
    one: Any

    @abstractmethod
    def see(self, step: Step) -> None:
        """Take up the step."""

    def kinematics(self, step: Step) -> Row:
        """``q+ - q- - increment``."""
        one, theta = self.one, step.scheme.position_rate
        way = self.increment(step) / (step.dt or 1.0)
        early, late = (1 - theta) * step.dt, theta * step.dt
        return Row(one, -late * one, -one, -early * one, -way)

    @abstractmethod
    def balance(self, step: Step) -> Row:
        """The balance of momentum without contacts; of what is held that its velocity is given."""

    @abstractmethod
    def by(self, parameter: Parameter, step: Step) -> np.ndarray:
        """Derivative of the balance by a parameter."""

    def kinked(
        self, parameter: Parameter, step: Step, start: tuple[np.ndarray, np.ndarray] | None
    ) -> bool:
        """Whether the balance has other derivatives on either side of this step, by a parameter
        that changes (q-, v-) so, or None: anyhow."""
        return False

    def inner(self) -> InnerSolver | None:
        """Its rows among its own unknowns, after :meth:`balance`, if it has a solver of its own."""
        return None

    def seen(self, operator: Any) -> Kinematics:
        """Points seen by an operator that stays the same, as those of a solid that moves linearly;
        others are not asked for it."""
        raise NotImplementedError(f"{self.solid.name!r} does not move linearly")

    def increment(self, step: Step) -> np.ndarray:
        """q+ - q-."""
        return step.increment(self.solid.velocity, self.solid.trial_velocity, None)


class DeformableMotion(Motion):
    """An elastic solid, whose matrices come again."""

    def __init__(self, solid: DeformableSolid) -> None:
        self.solid, self.size, self.held = solid, solid.owned, solid.fixed_unknowns
        self._mass = scipy_of(solid.inertia.matrix)
        hold = np.zeros(self.size)
        hold[self.held] = 1.0
        self.one = sp.identity(self.size, format="csr")
        self._holding, self._freeing = (sp.diags(each, format="csr") for each in (hold, 1 - hold))
        self._massive = self._freeing @ self._mass
        self._kept: dict[tuple[float, ...], tuple[Row, Row, Inner]] = {}
        self._seen: dict[int, Kinematics] = {}
        self._none = sp.csr_matrix(self._mass.shape)
        self._viscous: Any = None
        self._stiffness: Any = None

    def see(self, step: Step) -> None:
        solid = self.solid
        self._ends = start, end = solid.displacement, solid.trial_displacement
        points = step.scheme.force_points if step.loaded else ()
        self._places = [(weight, share * end + (1 - share) * start) for share, weight in points]
        self._momentum = solid.inertia.times(solid.trial_velocity - solid.velocity)

    def seen(self, operator: Any) -> Kinematics:
        return self._seen.setdefault(id(operator), Kinematics(operator))

    def kinematics(self, step: Step) -> Row:
        row, self._balance, self._inner = self._rows(step)
        return row._replace(dt=-self.increment(step) / (step.dt or 1.0))

    def balance(self, step: Step) -> Row:
        """The balance of the step whose kinematics were asked last."""
        by_dt = np.zeros(self.size)
        if step.dt and step.scheme.inertia:
            by_dt = -self._momentum / step.dt**2
            by_dt[self.held] = 0.0
        return self._balance._replace(dt=by_dt)

    def _rows(self, step: Step) -> tuple[Row, Row, Inner]:
        """Kinematics, balance and the solver."""
        rates = step.inertia_rate, step.gap_rate, step.rate_weight
        key = step.dt, step.loaded, *rates, step.force_share, *step.scheme.linear_weights
        if key not in self._kept:
            if len(self._kept) >= KEPT:
                self._kept.clear()
            self._kept[key] = self._make_rows(step)
        return self._kept[key]

    def _make_rows(self, step: Step) -> tuple[Row, Row, Inner]:
        before, after = step.scheme.linear_weights
        inertia = self._massive * step.inertia_rate
        old = new = self._none
        if step.loaded:
            if self._stiffness is None:
                self._stiffness = self._freeing @ scipy_of(self.solid.last_stiffness)
            old, new = before * self._stiffness, after * self._stiffness
        early, late = -inertia, inertia
        if step.loaded and step.scheme.inertia and self.solid.dampers:
            viscous = self._damping(step)
            early, late = early + before * viscous, late + after * viscous
        matrix = sp.csr_matrix((late + step.gap_rate * new) @ self._freeing + self._holding)
        near = self._near(step, matrix)
        factor = Factor(near, self.solid.name, True, self.held)
        inner = Inner(factor, new, step.gap_rate, self.held, matrix, self._loose(step))
        balance = Row(new, late + self._holding, old, early, np.empty(0))
        return super().kinematics(step), balance, inner

    def _near(self, step: Step, matrix: sp.csr_matrix) -> sp.csr_matrix:
        """The matrix of a step, or, where only contacts or springs hold the solid, one that can be
        factored: a little inertia holds it, which iteration takes away again."""
        if self._loose(step) is None:
            return matrix
        mass = self._massive @ self._freeing
        share = LITTLE * np.abs(matrix.diagonal()).max() / np.abs(mass.diagonal()).max()
        return sp.csr_matrix(matrix + share * mass)

    def _loose(self, step: Step) -> np.ndarray | None:
        """The rigid motions of what no supports hold without inertia, (n, k)."""
        if step.scheme.inertia or self._stands:
            return None
        rows: np.ndarray = Motions(self.solid).at_nodes().toarray()
        rows[self.held] = 0.0
        return rows

    @cached_property
    def _stands(self) -> bool:
        return Motions(self.solid).stand(springs=False)

    def _damping(self, step: Step) -> Any:
        """Derivative of the damping forces by the velocity."""
        if self._viscous is None:
            whole = replace(step, scheme=ThetaScheme(1.0))  # whose velocity is that at the end
            matrix = self.solid.last_stiffness.duplicate()
            matrix.zeroEntries()
            for damper in self.solid.dampers:
                damper.add_to(matrix, whole, *self._ends)
            self._viscous = self._freeing @ scipy_of(matrix)
            matrix.destroy()
        return self._viscous

    def inner(self) -> Inner:
        return self._inner

    def by(self, parameter: Parameter, step: Step) -> np.ndarray:
        solid = self.solid
        change = parameter.momentum(solid, solid.trial_velocity - solid.velocity)
        rows = np.zeros(self.size) + change * step.inertia_rate
        if step.loaded:
            rows -= step.load_weight * said(parameter, "load", self.size, solid)
            for weight, place in self._places:
                rows += weight * parameter.internal(solid, place)
            rows += parameter.damped(solid, step)
        rows[self.held] = 0.0
        return rows


def scipy_of(matrix: PETSc.Mat) -> sp.csr_matrix:
    """A copy of it."""
    pointers, columns, values = matrix.getValuesCSR()
    return sp.csr_matrix((values, columns, pointers), matrix.getSize())
