# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a contact tells of its surface after a step: pressure and friction, node by node."""

from __future__ import annotations

import numpy as np

from ..base.vectors import dot
from ..solids import Solid
from ..theory.formulations import Formulation
from ..theory.friction import FrictionBound
from .equations import SurfaceEquations
from .jump import Coupling
from .surface import Surface


class SurfaceResults:
    """Results of the last step at the nodes of a surface, mean in the step; of a percussion, which
    has no length, impulses. They are per area of the surface as it is undeformed; where the
    formulation acts at points they are N, along the axis of a rod N/m.
    """

    equations: SurfaceEquations
    coupling: Coupling
    formulation: Formulation
    chosen: np.ndarray
    gap: np.ndarray
    force: np.ndarray
    borne: np.ndarray
    solid: Solid
    surface: Surface
    friction_law: FrictionBound | None
    #: along which its normal forces acted in the last step, (n, d)
    force_normal: np.ndarray

    @property
    def normal_forces(self) -> np.ndarray:
        """Normal forces on the solid, (n, d) in N; the rest of ``force`` is friction."""
        return dot(self.force, self.force_normal)[:, None] * self.force_normal

    @property
    def acting(self) -> np.ndarray:
        """What acts on its nodes, (n, d) in N: with the same sum as ``borne``, and with its moment
        also where facets are covered in part."""
        return self.borne if self.coupling.acting is None else self.coupling.acting

    @property
    def traction(self) -> np.ndarray:
        """Traction of the contact on its solid, (n, d) in Pa (N by formulations at points)."""
        return self._per_area(self.force)

    @property
    def pressure(self) -> np.ndarray:
        """Contact pressure, (n,) in Pa (N by formulations at points): > 0 where it presses, 0 where
        it is open (< 0 where an adhesive pulls)."""
        return 0.0 - dot(self.traction, self.force_normal)

    @property
    def friction_traction(self) -> np.ndarray:
        """Traction of friction on its solid, (n, d) in Pa (N by formulations at points), tangential
        to the surface."""
        return self._per_area(self.force - self.normal_forces)

    def _per_area(self, force: np.ndarray) -> np.ndarray:
        if self.formulation.at_points:
            return np.where(self.chosen[:, None], force, 0.0)
        force, area = self.coupling.evened(force, self.coupling.area)
        return force / np.where(area > 0, area, np.inf)[:, None]

    @property
    def multiplier(self) -> np.ndarray | None:
        """lam at the nodes in the last step, Pa (N for point multipliers), None for springs."""
        return self.equations.multiplier

    def depth(self) -> float:
        """Penetration of the deepest point, m; between two solids of the deepest at which they are
        compared, or of the mean over facets around one that is inside, if that is more."""
        if self.coupling.by_means:
            return self.coupling.inside()
        return max(0.0, float(self.gap[self.chosen].max()))

    def describe(self) -> str:
        """What is there and what was left out."""
        n = int(self.chosen.sum())
        unknowns = n * (self.equations.fields.components - self.surface.dim)
        friction = self.friction_law.describe() if self.friction_law else "no friction (no tau)"
        what = f"{unknowns} multipliers"
        what = what if self.formulation.multipliers else "springs (no multipliers)"
        where = f"{n} points of {self.solid.name!r}, before {self.coupling.describe()}"
        return f"{self.formulation.name}, {where}, {friction}, {what}"
