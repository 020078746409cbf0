# SPDX-License-Identifier: LGPL-3.0-or-later
"""The state of a beam: where it is, its energies, what of it is written."""

from __future__ import annotations

from math import sqrt

import numpy as np

from ..base.quoted import quoted
from ..solids.base import Solid
from .axial_motion import AxialMotion
from .unknowns import BeamUnknowns


class BeamState(Solid):
    """The displacement and velocity of a beam, its unknowns' order that of BeamUnknowns."""

    displacement: np.ndarray
    unknowns: BeamUnknowns
    axial: AxialMotion
    mass: float
    gravity: float
    weight: np.ndarray
    _masses: np.ndarray
    _momentum: np.ndarray
    _internal: np.ndarray

    @property
    def travel(self) -> float:
        """How far the beam has moved against the direction of its axis, m."""
        return self.unknowns.along(self.displacement)

    @property
    def speed(self) -> float:
        """Rate of the travel, m/s."""
        return self.unknowns.along(self.velocity)

    def root_mean_square(self, velocity: np.ndarray) -> float:
        return sqrt(float(velocity @ (self._masses * velocity)) / self.mass)

    def energies(self) -> tuple[float, float, float]:
        """Kinetic (with the water that moves along), strain, and of weight plus ``taken``, J."""
        kinetic = 0.5 * float(self.velocity @ self._momentum)
        kinetic += self.axial.added_energy(self.travel, self.speed)
        weight = -float(self.weight @ self.displacement)
        return kinetic, self.strain_energy(), sum(self.axial.taken.values()) + weight

    def strain_energy(self) -> float:
        """Of the state, J."""
        return 0.5 * float(self.displacement @ self._internal)

    def lateral_energy(self) -> float:
        """Kinetic and strain energy of bending, J."""
        n = self.unknowns.bending
        kinetic = self.velocity[:n] @ self._momentum[:n]
        return 0.5 * float(kinetic + self.displacement[:n] @ self._internal[:n])

    def state(self) -> dict[str, np.ndarray]:
        return {
            "displacement": self.displacement,
            "velocity": self.velocity,
            **self.axial.state(),
            **self.memories(),
        }

    def fields(self) -> dict[str, np.ndarray]:
        at_mesh = self.unknowns.at_mesh
        return {"displacement": at_mesh(self.displacement), "velocity": at_mesh(self.velocity)}

    def describe(self) -> str:
        given = f"gravity {self.gravity:.9g}, {quoted(self.axial.law)}"
        return f"{self.unknowns.describe()}, {given}, {len(self.weight)} unknowns"
