# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rows of a rigid solid in a linearised step, in the plane and in space.

Rotations are finite, their changes small: with ``R+ = exp(w) R-`` and w the increment of the
rotation, changes phi in space, ``dR = [phi] R``, go on as ``phi+ = exp(w) phi- + T(w) dw``
(:func:`~fenicsx_contact.solids.rotations.turning`). In the plane both are 1.
"""

from __future__ import annotations

import numpy as np

from ..solids import RigidSolid
from ..solids.rigid_forces import without
from ..solids.rotations import rotation_matrix, turned_tensor, turning
from ..theory.scheme import Step
from .motion import Motion, Row
from .parameters import Parameter
from .said import said


class RigidMotion(Motion):
    """A rigid solid with d translations and 1 or 3 spins.

    Attributes:
        about: by what it had been put back to its gaps when the step was solved, which is more than
            once where what it meets moves along, (size,).
        place, turn: at the start and at the end, before what bears was put back after that.
        velocity: at both, (size,).
    """

    def __init__(self, solid: RigidSolid) -> None:
        self.solid, self.held, self.size = solid, solid.held, len(solid.velocity)
        self.one = np.eye(self.size)
        self._holding = np.diag(np.isin(np.arange(self.size), self.held).astype(float))
        self._spins = slice(solid.dim, self.size)
        self.about = self._put = np.zeros(self.size)

    @property
    def hinged(self) -> bool:
        """Whether it turns about some axes in space and about others not."""
        spins = self.size - self.solid.dim
        return 0 < int((self.held >= self.solid.dim).sum()) < spins

    def begin(self, again: bool) -> None:
        """A step was solved, or solved again from where the last solution was put."""
        self.about = self._put if again else np.zeros(self.size)
        shifted = self.solid.shifted
        self._put = np.zeros(self.size) if shifted is None else shifted

    def see(self, step: Step) -> None:
        solid, d = self.solid, self.solid.dim
        state = solid.state()
        self.velocity = state["velocity"], solid.moving_velocity
        self._way = step.increment(*self.velocity, None)
        turn = rotation_matrix(self.about[d:]) @ rotation_matrix(self._way[d:]) @ state["turn"]
        self.turn = state["turn"], turn
        self.place = state["place"], state["place"] + self._way[:d] + self.about[:d]
        self._inertia = [self.inertia(turn) for turn in self.turn]
        momenta = [m @ v for m, v in zip(self._inertia, self.velocity)]
        self._momentum = momenta[1] - momenta[0]

    def increment(self, step: Step) -> np.ndarray:
        return self._way

    def inertia(self, turn: np.ndarray) -> np.ndarray:
        """Momentum by velocity where it has turned, (size, size)."""
        return self._block(self.solid.mass, self.solid.spatial(self.solid.inertia, turn))

    def mobility(self, turn: np.ndarray) -> np.ndarray:
        """The inverse over what is not held."""
        return without(np.linalg.inv(self.inertia(turn)), self.held)

    def _block(self, translation: float, rotation: np.ndarray) -> np.ndarray:
        result = translation * self.one
        result[self._spins, self._spins] = rotation
        return result

    def turned(self, matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
        """Derivative by q of a matrix that turns along, such as the inertia, times a vector."""
        s = self._spins
        return self._block(0.0, turned_tensor(matrix[s, s], vector[s]))

    def onwards(self, way: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of where a way leads by q before it, and by the way."""
        if self.solid.dim == 2:
            return self.one, self.one
        w = way[self._spins]
        return self._block(1.0, rotation_matrix(w)), self._block(1.0, turning(w))

    def kinematics(self, step: Step) -> Row:
        before, further = self.onwards(self._way)
        on, _ = self.onwards(self.about)
        before, further = on @ before, on @ further
        row = super().kinematics(step)
        return Row(row.q, further @ row.v, -before, further @ row.v_old, row.dt)

    def put(self) -> np.ndarray:
        """Derivative of the place by ``about``."""
        return self.onwards(self.about)[1]

    def balance(self, step: Step) -> Row:
        rate = step.inertia_rate
        turned = [rate * self.turned(m, v) for m, v in zip(self._inertia, self.velocity)]
        new, old = turned[1], -turned[0]
        if step.loaded:
            before, after = step.scheme.linear_weights
            for spring in self.solid.springs:
                old = old + before * spring.stiffness(self.place[0], self.turn[0])
                new = new + after * spring.stiffness(self.place[1], self.turn[1])
        inertia = [rate * m for m in self._inertia]
        rows = [self._hold(each) for each in (new, inertia[1], old, -inertia[0])]
        by_dt = -self._momentum / step.dt**2 if step.dt else np.zeros(self.size)
        return Row(rows[0], rows[1] + self._holding, rows[2], rows[3], self._hold(by_dt))

    def kept(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The rows of a momentum that stays where the solid is put back: derivatives by q and v
        there, and by those before."""
        velocities = self.solid.moving_velocity, self.solid.trial_velocity
        before, after = self._inertia[1], self.inertia(self.solid.trial_turn)
        turned = [self.turned(m, v) for m, v in zip((before, after), velocities)]
        rows = [self._hold(each.copy()) for each in (turned[1], after, -turned[0], -before)]
        return rows[0], rows[1] + self._holding, rows[2], rows[3] - self._holding

    def _hold(self, rows: np.ndarray) -> np.ndarray:
        """Without those of what is held."""
        rows[self.held] = 0.0
        return rows

    def by(self, parameter: Parameter, step: Step) -> np.ndarray:
        solid, rows = self.solid, np.zeros(self.size)
        for sign, turn, velocity in zip((-1, 1), self.turn, self.velocity):
            rows += sign * step.inertia_rate * self.heavier(parameter, turn, velocity)
        if step.loaded:
            rows = rows - step.load_weight * said(parameter, "load", self.size, solid)
        return self._hold(rows)

    def heavier(self, parameter: Parameter, turn: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """Change of the momentum of a velocity by a parameter, where it has turned."""
        R = self._block(1.0, turn if self.solid.dim == 3 else np.eye(1))
        change = parameter.momentum(self.solid, R.T @ velocity)
        return np.asarray(R @ (np.zeros(self.size) + change))
