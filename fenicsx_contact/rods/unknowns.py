# SPDX-License-Identifier: LGPL-3.0-or-later
"""The unknowns of a beam in space, one vector: deflection and slope (w, psi) node by node in each
plane, then the axial displacement, of each node or, if the axis is inextensible, of all."""

from __future__ import annotations

import numpy as np
import scipy.sparse

from ..base import checks
from ..base.compat import cell_geometry
from ..base.constants import SAME
from ..base.vectors import largest
from .axis import AxisMesh
from .drive import LENGTH, MASS, Place
from .matrices import BeamMatrices
from .sections import Lateral, values_of


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

    def share(self, place: Place) -> np.ndarray:
        """What each axial unknown bears of a force along the axis; its end lies at infinity.

        Raises:
            InputError: a place beside the axis.
        """
        k = self._matrices
        if len(self.mean) == 1 or place == MASS:
            return self.mean
        if place == LENGTH:
            return k.lengths / k.lengths.sum()
        s = k.s[-1] if place == np.inf else place
        if isinstance(s, str) or not s <= k.s[-1] * (1 + SAME):
            raise checks.InputError(
                f"at = {place!r}: must be {MASS!r}, {LENGTH!r} or a place on the axis of the beam, "
                f"0 to {k.s[-1]:.6g} m"
            )
        cell, xi, _ = k.interpolate(np.array([s]))
        result = np.zeros(len(k.s))
        result[cell], result[cell + 1] = 1 - xi, xi
        return result

    def carried(self, share: np.ndarray) -> np.ndarray:
        """The axial motion of least strain whose sum by these shares, their last ones, is 1.

        Raises:
            InputError: a support holds it fast there.
        """
        k = self._matrices
        free, share = k.free_axial, share[-len(self.mean) :]
        if not share[free].any():
            raise checks.InputError("law: a drive cannot move what a support holds along the axis")
        borne = share[free][None]
        system = np.block([[k.axial_stiffness[np.ix_(free, free)], borne.T], [borne, 0]])
        result = np.zeros(len(free))
        result[free] = np.linalg.solve(system, np.append(0 * borne, 1.0))[:-1]
        return result

    def flow(self, load: Lateral, displacement: np.ndarray) -> np.ndarray:
        """The load of a flow, N/m, on the nodes where they are, N."""
        k, force = self._matrices, np.zeros_like(displacement)
        bending, along = self.split(force)[0], self.split(displacement)[1]
        bending[:, ::2] = values_of("lateral_load", load, k.s + along, len(bending)) * k.lengths
        return force

    def weight(self, acceleration: np.ndarray) -> np.ndarray:
        """The load of a uniform acceleration (d,), N."""
        k, load = self._matrices, np.zeros(len(self.masses))
        bending, axial = self.split(load)
        bending[:, ::2] = (self._axis.frame @ acceleration)[:, None] * k.lateral_weights
        axial[:] = float(acceleration @ self._axis.direction) * k.axial_mass
        return load

    def bend(
        self, values: np.ndarray, deflection: Lateral | None, slope: Lateral | None = None
    ) -> None:
        """Set the deflection among the unknowns, if there is one, and its slope (default: by
        differences, and none where a support holds it).

        Raises:
            InputError: one that is not zero where a support holds it fast.
        """
        if deflection is None:
            if slope is not None:
                raise checks.InputError("slope: is that of a displacement, and none is given")
            return
        k = self._matrices
        w = values_of("displacement", deflection, k.s, self.planes)
        turned = slope and values_of("slope", slope, k.s, self.planes)
        for kind, (what, given) in enumerate((("displacement", w), ("slope", turned))):
            held = ~k.free_bending[kind::2]
            if given is not None and np.abs(given[:, held]).max(initial=0) > SAME * largest(given):
                at = k.s[held][np.abs(given[:, held]).max(axis=0).argmax()]
                raise checks.InputError(
                    f"{what}: must be zero at s = {at:.6g} m, where a support holds it fast"
                )
        self.split(values)[0][:] = k.bent(w, turned)

    def describe(self) -> str:
        """What there is of the beam."""
        kind = "inextensible" if len(self.mean) == 1 else "extensible"
        return (
            f"beam, {kind}, {len(cell_geometry(self._axis.mesh))} cells, mass "
            f"{self._matrices.mass:.9g}, stiffness {self.stiffness.diagonal().sum():.9g}"
        )

    def at_mesh(self, values: np.ndarray) -> np.ndarray:
        """The field at the nodes of the mesh's geometry, (nodes, d)."""
        axis, (bending, axial) = self._axis, self.split(values)
        x = axis.mesh.geometry.x[:, : axis.dim]
        node = np.abs(axis.along(x)[:, None] - self._matrices.s).argmin(axis=1)
        return (bending[:, ::2].T @ axis.frame + axial[:, None] * axis.direction)[node]
