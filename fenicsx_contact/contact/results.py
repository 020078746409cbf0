# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a contact tells of its surface after a step: pressure and friction, node by node."""

from __future__ import annotations

import numpy as np

from ..base.vectors import dot
from ..theory.formulations import Formulation
from .equations import SurfaceEquations
from .jump import Coupling


class SurfaceResults:
    """Results of the last step at the nodes of a surface, mean in the step; of a percussion, which
    has no length, impulses. They are per area of the surface as it is undeformed; where the
    formulation acts at points they are N, along the axis of a rod N/m; of solids of revolution
    2 pi r times as much.
    """

    equations: SurfaceEquations
    coupling: Coupling
    formulation: Formulation
    chosen: np.ndarray
    gap: np.ndarray
    force: np.ndarray

    @property
    def traction(self) -> np.ndarray:
        """Traction of the contact on its solid, (n, d) in Pa."""
        area = self.chosen.astype(float) if self.formulation.at_points else self.coupling.area
        return self.force / np.where(area > 0, area, np.inf)[:, None]

    @property
    def pressure(self) -> np.ndarray:
        """Contact pressure, (n,) in Pa: > 0 where it presses, 0 where it is open (< 0 where an
        adhesive pulls)."""
        return 0.0 - dot(self.traction, self.coupling.normals())

    @property
    def friction_traction(self) -> np.ndarray:
        """Traction of friction on its solid, (n, d) in Pa: what of the traction is tangential."""
        normals = self.coupling.normals()
        return self.traction - dot(self.traction, normals)[:, None] * normals

    @property
    def multiplier(self) -> np.ndarray | None:
        """lam at the nodes in the last step, Pa (N for point multipliers), None for springs."""
        return self.equations.multiplier

    def depth(self) -> float:
        """Penetration of the deepest point, m."""
        return max(0.0, float(self.gap[self.chosen].max()))
