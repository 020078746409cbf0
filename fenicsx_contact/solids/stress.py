# SPDX-License-Identifier: LGPL-3.0-or-later
"""The stress in deformable solids, cell by cell."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import Any

import numpy as np
from dolfinx import fem

from ..base import compat
from ..base.mesh import NamedMesh
from .vector_space import VectorSpace


def von_mises(stress: np.ndarray) -> np.ndarray:
    """Equivalent stress sqrt(3/2 s:s), s the deviator, of stresses (n, 3, 3): (n,), Pa."""
    deviator = stress - np.trace(stress, axis1=1, axis2=2)[:, None, None] / 3 * np.eye(3)
    return np.sqrt(1.5 * (deviator**2).sum(axis=(1, 2)))


class Stressed(ABC):
    """A solid with a displacement field whose stress can be asked for."""

    mesh: NamedMesh
    vectors: VectorSpace
    space: Any
    displacement: np.ndarray

    @abstractmethod
    def cauchy(self, displacement: Any) -> Any:
        """Cauchy stress of a displacement field, Pa, in UFL, (3, 3): in the plane with the stress
        across it, without what damping adds."""

    @cached_property
    def _in_cells(self) -> tuple[Any, compat.PointExpression]:
        field = fem.Function(self.space)
        cells = compat.cellwise_space(self.mesh.mesh)
        return field, compat.PointExpression(self.cauchy(field), cells)

    def stress(self) -> np.ndarray:
        """Cauchy stress of the present state in the middles of the cells that this process owns,
        (cells, 3, 3) in Pa: tension is positive. In the plane the third row is that across it; of
        a solid of revolution r, y, hoop. What damping adds is left out. Every process must ask.
        """
        field, values = self._in_cells
        self.vectors.assign(field, self.displacement)
        return values().reshape(-1, 3, 3)

    def cell_fields(self) -> dict[str, np.ndarray]:
        """What is written for each cell: the nine components of the stress, von Mises' stress."""
        stress = self.stress()
        return {"stress": stress.reshape(-1, 9), "von_mises": von_mises(stress)}
