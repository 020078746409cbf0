# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the solver tells of the step that was attempted last."""

from __future__ import annotations

from ..solve.condensed import Condensed
from ..solve.krylov import Krylov
from ..solve.loop import StepSolver
from ..solve.surface_problem import SurfaceSystem


class Insight:
    """Of a stepper, whose solver it looks into."""

    _method: StepSolver

    @property
    def krylov(self) -> list[int]:
        """Iterations of the last linear solves, at most 100, if the solver is iterative."""
        system = self._method.system
        return list(system.counts) if isinstance(system, Krylov) else []

    @property
    def solve_times(self) -> dict[str, float]:
        """Seconds of the linear solves by part, if the solver is iterative."""
        system = self._method.system
        return dict(system.times) if isinstance(system, Krylov) else {}

    @property
    def surfaces(self) -> SurfaceSystem:
        """The surface problem; the solver is condensed."""
        system = self._method.system
        assert isinstance(system, Condensed)
        return system.surfaces

    @property
    def errors(self) -> list[float]:
        """Relative errors in the course of the step."""
        return self._method.errors
