# SPDX-License-Identifier: LGPL-3.0-or-later
"""The unknowns of a beam in space, one vector: deflection and slope (w, psi) node by node in each
plane, then the axial displacement, of each node or, if the axis is inextensible, of all."""

from __future__ import annotations

import numpy as np
import scipy.sparse

from .axis import AxisMesh
from .matrices import BeamMatrices


class BeamUnknowns:
    """What is the same for displacements and velocities of a beam.

    Attributes:
        planes: in which it bends, d - 1; ``bending``: how many unknowns that makes.
        mean: share of each axial unknown in the mean over the mass.
        masses: a diagonal, (n,); ``own_masses`` without the fluid that moves along.
        stiffness: sparse, (n, n).
    """

    def __init__(self, axis: AxisMesh, matrices: BeamMatrices) -> None:
        self._axis, self._matrices, k = axis, matrices, matrices
        self.planes = axis.dim - 1
        self.bending = len(k.bending_mass) * self.planes
        self.mean = k.weights / k.mass if len(k.axial_mass) > 1 else np.ones(1)
        self.masses = np.concatenate([np.tile(k.bending_mass, self.planes), k.axial_mass])
        own = k.bending_mass.copy()
        own[::2] = k.lateral_weights
        self.own_masses = np.concatenate([np.tile(own, self.planes), k.axial_mass])
        blocks = [*[k.bending_stiffness] * self.planes, k.axial_stiffness]
        self.stiffness = scipy.sparse.block_diag(blocks, format="csr")
        self.stiffness.eliminate_zeros()  # which it keeps of dense blocks

    def split(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Views of the unknowns: (w, psi) by node in each plane, (d - 1, 2m), and axial."""
        return values[: self.bending].reshape(self.planes, -1), values[self.bending :]

    def along(self, values: np.ndarray) -> float:
        """The mean axial motion, against the direction of the axis."""
        return -float(self.mean @ self.split(values)[1])

    def weight(self, acceleration: np.ndarray) -> np.ndarray:
        """The load of a uniform acceleration (d,), N."""
        k, load = self._matrices, np.zeros(len(self.masses))
        bending, axial = self.split(load)
        bending[:, ::2] = (self._axis.frame @ acceleration)[:, None] * k.lateral_weights
        axial[:] = float(acceleration @ self._axis.direction) * k.axial_mass
        return load

    def at_mesh(self, values: np.ndarray) -> np.ndarray:
        """The field at the nodes of the mesh's geometry, (nodes, d)."""
        axis, (bending, axial) = self._axis, self.split(values)
        x = axis.mesh.geometry.x[:, : axis.dim]
        node = np.abs(axis.along(x)[:, None] - self._matrices.s).argmin(axis=1)
        return (bending[:, ::2].T @ axis.frame + axial[:, None] * axis.direction)[node]
