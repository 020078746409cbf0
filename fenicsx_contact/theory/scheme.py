# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a one-step scheme is.

A scheme says how the motion of a step follows from the velocity v+ at its end, which is what a step
solves for, and from what it remembers of earlier steps; everything else asks it::

    u+ = u- + increment(v-, v+, memory),                d u+/d v+ = position_rate dt
    inertia M (v+ - v-)/dt = sum w_i F(u- + s_i (u+ - u-)) + carried(memory) + J' f

F: internal forces and loads; f: mean forces of contacts, which no scheme remembers. Solids, of
whatever kind, write none of this themselves: they ask the :class:`Step`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import Protocol, runtime_checkable

import numpy as np

#: Shares s_i of the way of a step and weights w_i of the forces that are taken there.
Points = Sequence[tuple[float, float]]


def gauss(n: int) -> Points:
    """Gauss' n points over the way of a step, exact for polynomials of degree 2 n - 1."""
    return [(float(1 + x) / 2, float(w) / 2) for x, w in zip(*np.polynomial.legendre.leggauss(n))]


@runtime_checkable
class Scheme(Protocol):
    """A one-step scheme. Arrays are those of a solid's n unknowns; forces are means over a step.

    A class of your own needs no base class. With an attribute ``along_strain`` that is True a
    hyperelastic solid takes its stress as a mean over the way of its strain, see
    :mod:`~.energy_momentum`. It must be comparable and have a ``repr`` that tells
    its parameters (a frozen dataclass is and has), for runs are resumed only with the same one.
    """

    @property
    def inertia(self) -> float:
        """1, or 0 if momentum does not count: every step then ends in equilibrium."""

    @property
    def memory_rows(self) -> int:
        """Rows of the memory, an array (rows, n) of each solid; 0: none, it is None then."""

    @property
    def position_rate(self) -> float:
        """Derivative of the increment by v+, over dt."""

    @property
    def linear_weights(self) -> tuple[float, float]:
        """Weights of F(u-) and F(u+) in the mean force of a linear solid."""

    @property
    def force_points(self) -> Points:
        """Where a nonlinear solid takes its internal forces; of an affine F it must be the same as
        ``linear_weights``."""

    @property
    def load_points(self) -> Points:
        """Where on the way in time loads are taken that depend on it; the same sum of weights."""

    @property
    def force_weight(self) -> float:
        """Share of the way at which forces that are not remembered are taken: of contacts (their
        lever arms, springs' gaps), of drives."""

    @property
    def growth(self) -> str:
        """Why the scheme makes energy in each step, as a refusal; empty if it does not."""

    @property
    def bounds_work(self) -> bool:
        """Whether the internal forces of a step work at least as much as the stored energy rises,
        but for the quadrature over the way and for turning under pressure: a step with which it
        rises by more than they and the scheme take, turning apart, is refused."""

    @property
    def error_constant(self) -> float | None:
        """c of the error c dt³ u''' of the position in a smooth step; None if not of that order."""

    def increment(
        self, dt: float, v_old: np.ndarray, v_new: np.ndarray, memory: np.ndarray | None
    ) -> np.ndarray:
        """The displacement increment u+ - u- of a step of ``dt`` > 0 seconds, (n,) in m; affine in
        all but dt."""

    def mean(self, v_old: np.ndarray, v_new: np.ndarray) -> np.ndarray:
        """The velocity by which works are counted, (n,) in m/s: what multiplies a change of
        momentum to give that of the kinetic energy."""

    def first(self, force: np.ndarray) -> np.ndarray | None:
        """The memory at the start of a motion, from internal forces and loads there, (n,) in N."""

    def carried(self, memory: np.ndarray | None) -> np.ndarray | float:
        """The part of the mean force that earlier steps give, (n,) in N."""

    def remember(
        self,
        dt: float,
        v_old: np.ndarray,
        v_new: np.ndarray,
        force: np.ndarray,
        memory: np.ndarray | None,
    ) -> np.ndarray | None:
        """The memory at the end of a step of ``dt`` > 0 seconds. ``force``: its mean of internal
        forces, loads and what was carried, (n,) in N."""

    def describe(self) -> str:
        """Its name and parameters."""


@dataclass(frozen=True)
class Step:
    """One time step: its length in seconds and the scheme that crosses it; what solids ask.

    An impact is a step of no length. Its forces are percussions: impulses over a ``span`` of 1 s
    instead of over dt, with which nothing moves and no load acts. It looks ``ahead`` over the step
    that follows it: no point may come out of it faster than it would arrive then. A part of a step
    looks ahead over the whole of it: what may arrive in an instant is fast, and other parts follow.
    An impact may be of those points only that touch, or would arrive ``within`` a time.
    """

    dt: float
    scheme: Scheme
    start: float = 0.0
    ahead: float = 0.0
    within: float = inf

    @property
    def end(self) -> float:
        """Time at which it ends, s."""
        return self.start + self.dt

    @cached_property
    def span(self) -> float:
        """The time over which the forces of the step are spread, s."""
        return self.dt or 1.0

    @property
    def loaded(self) -> float:
        """1 where loads and internal forces act, 0 in an impact."""
        return 1.0 if self.dt else 0.0

    @property
    def coming(self) -> Step:
        """The step in which time passes: that which follows an impact, or the step itself."""
        return self if self.dt else replace(self, dt=self.ahead, ahead=0.0, within=inf)

    @property
    def is_part(self) -> bool:
        """Whether it is a part of a step, as short as what is met in it asks for."""
        return self.dt > 0 and self.ahead > 0

    # -- position --------------------------------------------------------------------------------

    @cached_property
    def gap_rate(self) -> float:
        """Derivative of the end position by the end velocity, s."""
        return self.scheme.position_rate * self.dt

    @property
    def horizon(self) -> float:
        """The time by whose end no point may pass its obstacle, s."""
        return self.ahead or self.dt or 1.0

    @property
    def implicitness(self) -> float:
        """How far the velocity at the end of a step is the mean over it: 1 for theta = 1, 0 for
        theta = 1/2."""
        return max(0.0, 2 * self.scheme.position_rate - 1)

    @property
    def limit_rate(self) -> float:
        """How fast a point may fall back, over how fast it left, so that it is back at the end of
        the step: (1 - theta)/theta; 0 in an impact."""
        rate = self.scheme.position_rate
        return max(1 - rate, 0.0) / rate if self.dt and rate else 0.0

    def increment(
        self, v_old: np.ndarray, v_new: np.ndarray, memory: np.ndarray | None
    ) -> np.ndarray:
        """The displacement increment u+ - u-, (n,) in m."""
        if not self.dt:
            return np.zeros_like(v_new)
        return self.scheme.increment(self.dt, v_old, v_new, memory)

    def drift(self, v_old: np.ndarray, memory: np.ndarray | None) -> np.ndarray:
        """The part of the increment that does not depend on v+, (n,) in m."""
        return self.increment(v_old, np.zeros_like(v_old), memory)

    # -- momentum --------------------------------------------------------------------------------

    @property
    def inertia_rate(self) -> float:
        """Derivative of the inertia force by the momentum at the end, 1/s."""
        return self.scheme.inertia / self.span

    def inertia_force(self, p_old: np.ndarray, p_new: np.ndarray) -> np.ndarray:
        """The mean rate of the momentum, (n,) in N."""
        return (p_new - p_old) / self.span if self.scheme.inertia else np.zeros_like(p_new)

    def mean(self, v_old: np.ndarray, v_new: np.ndarray) -> np.ndarray:
        """The velocity by which works are counted, (n,) in m/s."""
        return self.scheme.mean(v_old, v_new)

    def work(self, velocity: np.ndarray, force: np.ndarray) -> float:
        """Work of a mean force of the step on a velocity, J."""
        return self.span * float(velocity @ force)

    # -- forces ----------------------------------------------------------------------------------

    @property
    def force_rate(self) -> float:
        """Derivative of the displacement at which a linear solid takes its forces by v+, s."""
        return self.scheme.linear_weights[1] * self.gap_rate

    @property
    def force_share(self) -> float:
        """The share of the way at which forces are taken in the mean."""
        return self.scheme.linear_weights[1] / self.load_weight

    @property
    def rate_weight(self) -> float:
        """Derivative of :meth:`rate` by v+; 0 in statics and impacts."""
        return self.scheme.inertia * self.loaded * self.scheme.linear_weights[1]

    def rate(self, v_old: np.ndarray, v_new: np.ndarray) -> np.ndarray:
        """The velocity by which a force that is linear in it, C v, stands in the mean force."""
        return self.scheme.inertia * self.loaded * self.linear_mean(v_old, v_new)

    @property
    def mean_share(self) -> float:
        """How much of the forces that are not remembered is taken in the mean over the way, the
        rest at its end."""
        weight = self.scheme.force_weight
        return 2 * min(weight, 1 - weight)

    @property
    def along_strain(self) -> bool:
        """Whether stresses of nonlinear solids are means over the way of the strain, with the
        ``force_points`` as places on it, in place of means over that of the displacement."""
        return bool(getattr(self.scheme, "along_strain", False))

    @property
    def place_share(self) -> float:
        """The share of the way at which solids act on each other: in its midst what is equal and
        opposite there has no moment, where angular momentum is kept; else at the end."""
        return 0.5 if self.along_strain else 1.0

    @property
    def force_time(self) -> float:
        """Time from its start until contacts take their forces, s."""
        return self.scheme.force_weight * self.dt

    def linear_mean(self, old: np.ndarray, new: np.ndarray) -> np.ndarray:
        """Of values at both ends, as they enter the mean force of a linear solid."""
        before, after = self.scheme.linear_weights
        return after * new + before * old

    def mean_force(self, at: Callable[[float], np.ndarray]) -> np.ndarray:
        """Mean of the internal forces ``at`` shares of the way."""
        return np.sum([weight * at(share) for share, weight in self.scheme.force_points], axis=0)

    @property
    def load_weight(self) -> float:
        """Weight of a constant force in the mean force; the rest of it is carried."""
        return sum(self.scheme.linear_weights)

    def mean_load(self, at: Callable[[float], np.ndarray]) -> np.ndarray:
        """Mean of the loads ``at`` times, N."""
        times = [(self.start + share * self.dt, w) for share, w in self.scheme.load_points]
        return np.sum([weight * at(time) for time, weight in times], axis=0)

    # -- memory ----------------------------------------------------------------------------------

    def recall(
        self, memory: np.ndarray | None, force: Callable[[], np.ndarray]
    ) -> np.ndarray | None:
        """The memory with which the step begins: the given one, or that of a motion that begins
        here, with ``force()``: internal forces and loads, (n,) in N."""
        rows = 0 if memory is None else len(memory)
        return memory if rows == self.scheme.memory_rows else self.scheme.first(force())

    def carried(self, memory: np.ndarray | None) -> np.ndarray | float:
        """The part of the mean force that earlier steps give, (n,) in N."""
        return self.scheme.carried(memory)

    def remember(
        self, v_old: np.ndarray, v_new: np.ndarray, force: np.ndarray, memory: np.ndarray | None
    ) -> np.ndarray | None:
        """The memory at the end; an impact changes none."""
        if not self.dt:
            return memory
        return self.scheme.remember(self.dt, v_old, v_new, force, memory)
