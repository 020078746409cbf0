# SPDX-License-Identifier: LGPL-3.0-or-later
"""What turning under stress adds to the work of a step.

A step from F- to F+ whose forces are taken at a share s of its way H = F+ - F- works P : H. With
P = F S and the strain E = (F' F - 1)/2 this is::

    P : H = S : (E+ - E-) + (s - 1/2) S : H' H

The first is of the material: no rotation changes it, and where the stored energy is convex in E, S
at the end works no less than is stored. The second is of the straight way, which leaves the arc of
a rotation: by an angle a under Cauchy's stress sigma it is (s - 1/2) a² tr sigma per volume,
negative in what is compressed, however little that is strained in the step. Of forces that are
partly a mean over the way, which works what is stored, and for the rest taken at the end, s is the
mean of the shares.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from ..base import assembly
from ..base.compiling import compiled
from .deformable import DeformableSolid
from .energies import Energy, deformation, in_space


class Turning:
    """That second part.

    Args:
        solid: whose it is.
        energy: its stored energy density.
        measure: of the volume.
    """

    def __init__(self, solid: DeformableSolid, energy: Energy, measure: ufl.Measure) -> None:
        self._solid, self._energy, self._measure = solid, energy, measure

    @cached_property
    def _form(self) -> tuple[fem.Function, fem.Function, Any]:
        """The way, its end, ``S : H' H`` of them: compiled where a step is in doubt."""
        solid = self._solid
        way, end = fem.Function(solid.space), fem.Function(solid.space)
        H, F = in_space(solid.gradient(way), 0), ufl.variable(deformation(solid.gradient(end)))
        S = ufl.inv(F) * ufl.diff(self._energy(F), F)
        return way, end, compiled(solid.breadth * ufl.inner(H * S, H) * self._measure)

    def work(self, ahead: float, start: np.ndarray, end: np.ndarray) -> float:
        """It, J, of a step between two displacements that takes its stress at the end, but of this
        only what lies ``ahead`` of the middle of the way: s - 1/2."""
        (way, place, form), vectors = self._form, self._solid.vectors
        vectors.assign(way, end - start)
        vectors.assign(place, end)
        return ahead * assembly.assemble_scalar(form, self._solid.comm)
