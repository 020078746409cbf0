# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a law of springs remembers from step to step: how far its tangential springs are stretched.

Laws with multipliers remember nothing of the kind.
"""

from __future__ import annotations

import numpy as np

from ..theory.formulations import Formulation
from ..theory.theta import Step
from .equations import SurfaceEquations


class TangentialSprings:
    """The springs of all points of a surface.

    Args:
        equations: of the surface.
        formulation: its law.

    Attributes:
        stretch: (n, d) in m.
    """

    def __init__(self, equations: SurfaceEquations, formulation: Formulation) -> None:
        self._equations = equations
        self._there = not formulation.multipliers
        self._slips = self._there and equations.fields.friction is not None
        # per weight of a point; a law without such a stiffness has no stretch
        self._stiffness = getattr(formulation, "stiffness_t", np.inf) if self._slips else np.inf
        self.stretch = np.zeros(equations.fields.surface.points.shape)

    def linearise(self, step: Step, gap: np.ndarray, jump: np.ndarray) -> None:
        """Tell the law the gap (n,) [m] and jump (n, d) [m/s] with which the step starts."""
        if not self._there:
            return
        k, weight = self._equations.fields, step.scheme.force_weight
        way = weight * (step.dt - step.gap_rate) * jump
        k.elongation.x.array[:] = (self.stretch + way).ravel()
        k.start_gap.x.array[:] = gap
        k.mean_share.value = step.mean_share
        k.force_rate.value = weight * step.gap_rate
        self._equations.refresh()

    def accept(self, step: Step, friction: np.ndarray, sticks: np.ndarray) -> None:
        """Keep the stretch at the end of a step from its friction (n, d) in N: elastic where
        points stick, (n,) of bool, returned on slip."""
        if not self._slips:
            return
        each = self._stiffness * np.where(self._equations.weight > 0, self._equations.weight, 1.0)
        held = -friction / each[:, None]
        stuck = self.stretch + (held - self.stretch) / (step.scheme.force_weight or 1.0)
        self.stretch = np.where(sticks[:, None], stuck, held)
