# SPDX-License-Identifier: LGPL-3.0-or-later
"""The momentum balance of a deformable solid in a step: its terms, what is left, what they work."""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from ..base.constants import ROUND_OFF, SAME
from ..base.vectors import largest, worst
from ..theory.scheme import Step
from .base import MonolithicSolid
from .boundary import Supports
from .damping import Damper, Damping, damped_springs
from .factor import Factorisation
from .foundation import Foundation
from .free_factor import FreeFactorisation
from .loads import Loads
from .locations import Location
from .mass import Mass
from .motions import Motions
from .vector_space import VectorSpace


class BalancedSolid(MonolithicSolid):
    """The balance of a solid with a displacement field."""

    vectors: VectorSpace
    comm: MPI.Comm
    owned: int
    supports: Supports
    fixed_unknowns: np.ndarray
    trial_displacement: np.ndarray
    displacement: np.ndarray
    damping: Damping
    dampers: list[Damper]
    foundations: list[Foundation]
    inertia: Mass
    applied: Loads | None
    weight: np.ndarray
    #: How far nodes of a cell are apart, m, where forces tell a deformation from 1 by what it is.
    grain: float = 0.0
    #: The largest of the forces at a node that act in the trial state, N.
    acts: float = 0.0
    #: Of the imbalance of loads without inertia, over what acts, what was forgiven as round-off of
    #: K u, and the whole with it.
    forgiven: float = 0.0
    whole: float = 0.0
    #: Displacements of what is held at the end of the step, m; None where nothing moves it.
    _target: np.ndarray | None
    _pull: np.ndarray
    _momentum: np.ndarray
    _trial_momentum: np.ndarray
    _force: np.ndarray
    _reaction: np.ndarray

    @property
    @abstractmethod
    def last_stiffness(self) -> PETSc.Mat:
        """The newest of ``stiffness``."""

    @abstractmethod
    def internal_force(self, displacement: np.ndarray) -> np.ndarray:
        """Internal forces at a displacement, for the owned unknowns."""

    @abstractmethod
    def _internal_forces(self, step: Step) -> np.ndarray:
        """The mean of the internal forces in the step, as the scheme takes them."""

    def factored(self, matrix: PETSc.Mat, step: Step) -> Factorisation:
        """The factorisation of the matrix of a step, which is its from now on."""
        motions = self._free_motions[0]
        stands = step.scheme.inertia or self._stands
        if not (stands and motions.shape[1]):
            return Factorisation(matrix, self.name)
        return FreeFactorisation(matrix, self.name, self.comm, motions, self.resisting(step))

    def resisting(self, step: Step) -> np.ndarray:
        """What its inertia and springs to ground, and their damping, resist its free motions with
        in a step, (owned, k)."""
        _, momenta, pulls = self._free_motions
        beta = self.damping.beta if damped_springs(self) else 0.0
        inertia = step.inertia_rate + step.rate_weight * self.damping.alpha
        return inertia * momenta + (step.force_rate + step.rate_weight * beta) * pulls

    def floats(self, step: Step) -> bool:
        """Whether only contact holds it in the step: its matrix is singular."""
        return not step.scheme.inertia and not self._stands

    @cached_property
    def _stands(self) -> bool:
        return Motions(self).stand()

    @cached_property
    def _free_motions(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The rigid motions that nothing but springs holds, at this process's unknowns, their
        momenta, and the forces of springs against them, (owned, k)."""
        motions = Motions(self)
        rows = motions.at_nodes() @ motions.free(springs=False)
        rows[self.fixed_unknowns] = 0.0
        if self.linear:  # straight shapes on curved cells have no rotations
            forces = [self.internal_force(row) - self._springs(row) for row in rows.T.copy()]
            own = [largest(each) for each in (*forces, self.vectors.diagonal(self.last_stiffness))]
            *strained, stiffest = np.max(self.comm.allgather(own), axis=0)
            rows = rows[:, np.array(strained) <= SAME * stiffest]
        momenta, pulls = np.zeros(rows.shape), np.zeros(rows.shape)
        for k, row in enumerate(rows.T.copy()):
            momenta[:, k], pulls[:, k] = self.inertia.times(row), self._springs(row)
        for each in (momenta, pulls):
            each[self.fixed_unknowns] = 0.0  # whose rows say where they are
        return rows, momenta, pulls

    def _springs(self, displacement: np.ndarray) -> np.ndarray:
        """The force of springs to ground against a displacement, (owned,)."""
        return sum((f.times(displacement) for f in self.foundations), np.zeros(self.owned))

    def _force_at_start(self, step: Step) -> np.ndarray:
        """Loads less internal forces at the start of a step, (owned,) in N."""
        applied = self.applied.total(step.start) if self.applied else 0.0
        force = self.weight + applied - self.internal_force(self.displacement)
        u = self.displacement
        return force - sum(damper.force(step, u, u, self.velocity) for damper in self.dampers)

    def _loads(self, step: Step) -> np.ndarray:
        """Gravity and applied loads where the scheme takes forces, and what it carries along."""
        loads = step.load_weight * self.weight
        if self.applied:
            applied = step.mean_load(self.applied.total)
            self._pull = applied / step.load_weight
            loads += applied
        return loads if self.memory is None else loads + step.carried(self.memory)

    def _balance(self, step: Step) -> list[np.ndarray]:
        """The terms of the momentum balance in the trial state, for the owned unknowns; their sum
        vanishes but at the supports, where it is the reaction."""
        self._trial_momentum = np.zeros(self.owned)
        if step.scheme.inertia:
            self._trial_momentum = self.inertia.times(self.trial_velocity)
        inertia = step.inertia_force(self._momentum, self._trial_momentum)
        if not step.loaded:
            return [-self._force, inertia]
        internal = self._internal_forces(step)
        for damper in self.dampers:
            rate = step.rate(self.velocity, self.trial_velocity)
            internal = internal + self._damping(damper, step, rate)
        return [-self._force, inertia, internal, -self._loads(step)]

    def _damping(self, damper: Damper, step: Step, rate: np.ndarray) -> np.ndarray:
        return damper.force(step, self.displacement, self.trial_displacement, rate)

    @property
    def rounded_work(self) -> float:
        """What round-off of K u may have worked along u so far, J."""
        own = largest(self.vectors.diagonal(self.last_stiffness)), largest(self.displacement)
        stiffest, way = np.max(self.comm.allgather(own), axis=0)
        return ROUND_OFF * float(stiffest) * float(way) ** 2

    def imbalance(self, step: Step, noise: float = 0.0) -> float:
        terms = self._balance(step)
        # a stress-free body in flight has no forces but round-off, of its momentum and of K u, or
        # of K x where strains are differences from 1; one that only contact holds may not fly
        moved = self.grain + np.abs(self.trial_displacement)
        for damper in self.dampers:
            moved = moved + damper.time * np.abs(self.trial_velocity)
        stiffness = np.abs(self.vectors.diagonal(self.last_stiffness))
        strained = stiffness * moved
        strained = strained[self.fixed_unknowns] if self.floats(step) else strained
        # nor is it less than where the step starts, to which velocities add what they change
        strained = np.append(strained, stiffness * np.abs(self.displacement))
        # M v of the whole rounds that of any node
        momentum = max(self.comm.allgather(largest(self._momentum)))
        round_off = ROUND_OFF * momentum / step.span
        bent = ROUND_OFF * strained.max(initial=0.0) if step.loaded else 0.0
        left = np.sum(terms, axis=0)
        reaction = left[self.fixed_unknowns]
        off = np.abs(left)
        off[self.fixed_unknowns] = 0.0
        total = np.maximum(off - (round_off + bent), 0.0)
        # against what acts, not against internal forces, which may be absurd
        contact, inertia, *others = terms
        acting = [reaction, contact, inertia, *others[1:]]
        at = self.vectors.places.ravel()[: self.owned] + self.trial_displacement
        own = [largest(term) for term in (total, off, *acting)]
        touch = ROUND_OFF * largest(stiffness) * largest(at)
        residual, whole, *sizes, bent, touch = np.max(
            self.comm.allgather([*own, bent, touch]), axis=0
        )
        self.acts = worst(sizes)
        if self.acts <= noise and residual < np.inf:  # NaN is neither
            self.forgiven = self.whole = 0.0
            return float(residual > noise)  # internal forces that nothing balances
        # without loads what supports move is in balance to round-off, whatever acts, also by what
        # just touches, where round-off of places presses
        loaded = not step.scheme.inertia and max(sizes[1] - touch, *sizes[2:]) > noise
        self.forgiven, self.whole = loaded * bent / self.acts, whole / self.acts
        return float(residual / self.acts)

    def works(self, step: Step) -> tuple[float, float, float, float]:
        mean, held = step.mean(self.velocity, self.trial_velocity), self.fixed_unknowns
        moved = mean.copy()  # what is moved goes its way whatever its velocities at both ends
        if self._target is not None:
            moved[held] = (self.trial_displacement - self.displacement)[held] / step.span
        contact, inertia, *others = self._balance(step)
        self._acting = -(others[0] + others[1]) if others else np.zeros(self.owned)
        self._reaction = (contact + (inertia - self._acting))[held]
        way = self.trial_displacement - self.displacement
        pulled = step.loaded * float(way @ self._pull) if self.applied else 0.0
        driven = step.work(mean[held], self._reaction)
        driven += step.work((mean - moved)[held], self._acting[held])
        return (
            self.vectors.sum(step.work(mean, inertia)),
            self.vectors.sum(step.work(moved, self._acting)),
            self.vectors.sum(driven),
            self.vectors.sum(pulled),
        )

    def taken(self, step: Step) -> float:
        """Kinetic energy that the scheme takes in the step, J, in the trial state: what a change of
        momentum works on the way less what it does on the mean velocity, where nothing is held.
        Of theta-schemes it is (theta - 1/2) dv' M dv."""
        way = self.trial_displacement - self.displacement
        lead = way - step.span * step.mean(self.velocity, self.trial_velocity)
        lead[self.fixed_unknowns] = 0.0  # supports move what they hold
        return self.vectors.sum(float(lead @ (self._trial_momentum - self._momentum)) / step.span)

    def damped(self, step: Step) -> float:
        mean = step.mean(self.velocity, self.trial_velocity)
        rate = step.rate(mean, mean) / step.load_weight
        taken = [step.work(mean, self._damping(damper, step, rate)) for damper in self.dampers]
        return -self.vectors.sum(sum(taken)) if taken else 0.0

    def reaction(self, where: Location) -> np.ndarray:
        """Force of the support at a location on the solid in the last step, (d,) in N."""
        return self.supports.total(where, self._reaction)
