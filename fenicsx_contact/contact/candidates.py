# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which points of a contact may bear in a step: only these have equations, nothing acts at others.

First all that the formulation allows and that are near what they may meet; then, so that systems
stay small, of those only what bore, or would do without contact what the law forbids. What the
contact itself drives to that is added when it shows. A law without multipliers that does not say
that it only pushes may act anywhere: all its points are asked.
"""

from __future__ import annotations

from math import inf

import numpy as np

from ..base.checks import StepFailed
from ..base.constants import ROUND_OFF
from ..base.vectors import dot, largest
from ..theory.formulations import Formulation, only_pushes
from ..theory.scheme import Step
from ..theory.step_data import StepData
from .equations import SurfaceEquations
from .jump import Coupling


class Candidates:
    """The choice among the points of a surface.

    Args:
        equations, coupling, formulation: of the contact.

    Attributes:
        anywhere: whether the law may act at points that are open.
        allowed: points that may bear in the step, if they are asked to, (n,) of bool.
    """

    def __init__(
        self, equations: SurfaceEquations, coupling: Coupling, formulation: Formulation
    ) -> None:
        self._equations, self._coupling, self._formulation = equations, coupling, formulation
        self.anywhere = not (formulation.multipliers or only_pushes(formulation))
        self.allowed = self._asked = self._found = np.ones(len(equations.weight), dtype=bool)
        self._limit: np.ndarray | None = None
        self.renew()

    def begin(self, allowed: np.ndarray, gap: np.ndarray, tolerance: float, step: Step) -> None:
        """All that are allowed, (n,) of bool, and by the formulation, once they are chosen;
        ``gap``: at the start of the step, (n,) in m, told up to a tolerance, m.

        Raises:
            StepFailed: the obstacle goes into one that supports hold.
        """
        if decide := getattr(self._formulation, "closed", None):
            allowed = allowed & decide(self._coupling.gaps(), tolerance)
        if not step.dt and not self._formulation.percussive:
            allowed = np.zeros(len(allowed), dtype=bool)
        if step.within < inf:
            approach = self._coupling.coming(self._coupling.struck_jump(), gap >= -tolerance)
            allowed = allowed & (gap + step.within * approach >= -tolerance)
        self.allowed, self._gap = allowed, gap
        self._asked, self._found = np.ones(len(allowed), dtype=bool), np.zeros(len(allowed), bool)
        if step.dt and self._formulation.multipliers:
            self._refuse_held(tolerance)

    def _refuse_held(self, tolerance: float) -> None:
        """Refuse a step, which is predicted, in which a point that is held is met by an obstacle:
        its gap is known then, and no force keeps it closed."""
        held = self.allowed & self._coupling.held()
        if not held.any():
            return
        deeper = np.where(held, self._coupling.gaps() - np.maximum(self._gap, 0.0), -inf)
        worst = int(deeper.argmax())
        if deeper[worst] > tolerance + ROUND_OFF * largest(self._coupling.positions()):
            at = ", ".join(f"{x:.4g}" for x in self._coupling.reference[worst])
            raise StepFailed(
                f"the obstacle goes {deeper[worst]:.3g} m into a held node of a contact, at ({at})"
            )

    def choose(self) -> None:
        """Take up what is near in the trial state."""
        self._equations.choose(self.allowed & self._asked & self.near())

    def near(self) -> np.ndarray:
        """Points that are near what they may meet, (n,) of bool, but those whose gaps no forces
        change: a multiplier there would be what round-off says of a row without it."""
        near = self._coupling.near()
        return near & ~self._coupling.held() if self._formulation.multipliers else near

    def narrow(self, bore: np.ndarray, free: np.ndarray, step: Step) -> None:
        """Ask only what bore, (n,) of bool, what velocities of the traces' points without contact,
        flat, ask for, and what was found earlier in this step; what falls alike meets or parts by
        round-off, and in a crowd meets once one of both is stopped."""
        noise: float | np.ndarray = ROUND_OFF * largest(free)
        if len(self._coupling.solids) > 1 and not self._coupling.by_means:
            noise = noise + self._coupling.loaded(free, self._coupling.jump("velocity"))
        self._asked = bore | self._found | self._violate(self._coupling.to_jump(free), step, noise)
        self.choose()

    def widen(self, jump: np.ndarray, step: Step) -> bool:
        """Ask what the jumps (n, d) ask for besides; whether that is any."""
        if len(self._equations.candidates) == len(jump):
            return False
        more = self._violate(jump, step) & ~self._asked
        if not more.any() or not (more & self.allowed & self.near()).any():
            return False
        self._asked, self._found = self._asked | more, self._found | more
        self.choose()
        return True

    def passed_over(self, jump: np.ndarray, step: Step) -> float:
        """By how much more than the law allows points approach that may bear and were not asked,
        m/s, from the jumps (n, d); 0 of springs, which bear where they are."""
        e, limit, others = self._equations, self.limit(step), self.allowed & self.near()
        others[e.candidates] = False
        if limit is None or not others.any():
            return 0.0
        return max(0.0, float((dot(jump, e.normal.reshape(jump.shape)) - limit)[others].max()))

    def told(self, jump: np.ndarray, step: Step) -> np.ndarray:
        """Jumps (n, d) for laws that read them at all points: where nothing could bear, none that
        would press."""
        e, limit = self._equations, self.limit(step)
        others = np.ones(len(jump), dtype=bool)
        others[e.candidates] = False
        if limit is None:
            limit = -self._coupling.gaps() / step.horizon
        normal = e.normal.reshape(jump.shape)
        off = np.where(others, np.maximum(dot(jump, normal) - limit + e.speed, 0.0), 0.0)
        return np.asarray(jump - off[:, None] * normal)

    def renew(self) -> None:
        """What the law reads of the step has changed."""
        self._limit_of: Step | None = None

    def limit(self, step: Step) -> np.ndarray | None:
        """The w_n that the law allows at each point at most, (n,) in m/s, None for springs."""
        if self._limit_of is step:
            return self._limit
        e, law, self._limit_of = self._equations, self._formulation, step
        if law.multipliers and not (step.dt or law.percussive):
            self._limit = np.full(len(e.gap), inf)  # of positions, which no percussion changes
            return self._limit
        self._limit = law.limit(
            StepData(
                gap=e.gap,
                start_jump_n=e.start_jump_n,
                gap_rate=step.gap_rate,
                limit_rate=step.limit_rate,
                horizon=step.horizon,
                loaded=step.loaded,
            )
        )
        return self._limit

    def _violate(self, jump: np.ndarray, step: Step, noise: float | np.ndarray = 0.0) -> np.ndarray:
        """Points whose jump (n, d) is more than the law allows less ``noise``, (n,) of bool."""
        e, limit = self._equations, self.limit(step)
        if self.anywhere:
            return np.ones(len(jump), dtype=bool)
        approach = dot(jump, e.normal.reshape(jump.shape)) + noise
        if limit is None:  # springs know no limit, but what they do not touch
            limit = -e.gap / step.gap_rate if step.gap_rate else np.inf * approach
            return (approach > limit) | (self._gap > 0)
        return approach > limit
