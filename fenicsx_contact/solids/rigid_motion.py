# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where a rigid solid is, how it moves, and what is seen of it."""

from __future__ import annotations

from abc import abstractmethod
from math import sqrt

import numpy as np
from scipy.spatial.transform import Rotation

from ..theory.scheme import Step
from .base import MonolithicSolid
from .rigid_forces import without
from .rigid_trace import RigidTrace
from .rotations import EYE, by_spins, rotation_matrix


class RigidMotion(MonolithicSolid):
    """The placement of a rigid solid: the centre of mass and a rotation.

    Attributes:
        mass: kg (kg/m in 2D).
        centre: of mass, in the reference placement, (d,) in m.
        inertia: about it, there, (1, 1) or (3, 3) in kg m².
        held: numbers of the components that are held.
        trial_place, trial_turn: the centre of mass and the rotation in the trial state.
        moving_velocity: with which the step has moved it there; in space :meth:`shift` changes the
            spin, not the momentum.
        balanced: `correct` leaves nothing of its momentum balance but round-off.
        shifted: what it has been shifted by in the step, beside its velocities, or None.
    """

    mass: float
    balanced: bool
    centre: np.ndarray
    inertia: np.ndarray
    held: np.ndarray
    free_velocity: np.ndarray
    inverse: np.ndarray
    trial_place: np.ndarray
    trial_turn: np.ndarray
    moving_velocity: np.ndarray
    _place: np.ndarray
    _turn: np.ndarray
    _masses: np.ndarray
    _everywhere: np.ndarray
    _mobility: np.ndarray
    _momentum: np.ndarray
    _trial_momentum: np.ndarray
    shifted: np.ndarray | None = None

    @abstractmethod
    def push(self, force: np.ndarray) -> None:
        """Add to the forces on the solid in this step, N and N m."""

    def _move(self, step: Step) -> None:
        self.moving_velocity = self.trial_velocity
        increment = step.increment(self.velocity, self.trial_velocity, self.memory)
        self.trial_place = self._place + increment[: self.dim]
        turn = rotation_matrix(increment[self.dim :]) @ self._turn
        if self.dim == 3:  # products of many rotations would lose orthogonality, momentum with it
            turn = turn @ (1.5 * EYE - 0.5 * turn.T @ turn)
        self.trial_turn = turn
        if self.shifted is not None:
            self._put(self.shifted)

    def _way(self, step: Step) -> np.ndarray:
        """The way really gone in the step: of the centre, m, and turned, rad."""
        way = step.increment(self.velocity, self.moving_velocity, self.memory)
        return way if self.shifted is None else way + self.shifted

    def _put(self, way: np.ndarray) -> None:
        self.trial_place = self.trial_place + way[: self.dim]
        self.trial_turn = rotation_matrix(way[self.dim :]) @ self.trial_turn

    def spatial(self, tensor: np.ndarray, turn: np.ndarray) -> np.ndarray:
        """A tensor of the reference placement where that has turned; in the plane a number."""
        return tensor if self.dim == 2 else turn @ tensor @ turn.T

    def _momentum_of(self, velocity: np.ndarray, turn: np.ndarray) -> np.ndarray:
        if self.dim == 2:
            return self._masses * velocity
        momentum = self.mass * velocity
        momentum[3:] = self.spatial(self.inertia, turn) @ velocity[3:]
        return momentum

    @property
    def mobility(self) -> np.ndarray:
        if self.dim == 2:
            return self._everywhere
        result = np.zeros((6, 6))
        result[range(3), range(3)] = 1 / self.mass
        result[3:, 3:] = self.spatial(self._mobility, self.trial_turn)
        return without(result, self.held)

    def shift(self, way: np.ndarray) -> None:
        d = self.dim
        self.shifted = way if self.shifted is None else self.shifted + way
        self._put(way)
        if d == 3:  # the spin that belongs to the momentum
            spin = self.spatial(self._mobility, self.trial_turn) @ self._trial_momentum[d:]
            self.trial_velocity = np.concatenate([self.trial_velocity[:d], spin])
            self.trial_velocity[self.held] = 0.0

    def trace(self, points: np.ndarray) -> RigidTrace:
        return RigidTrace(self, points - self.centre)

    def root_mean_square(self, velocity: np.ndarray) -> float:
        return sqrt(float(velocity @ self._momentum_of(velocity, self.trial_turn)) / self.mass)

    def state(self) -> dict[str, np.ndarray]:
        state = {"velocity": self.velocity, "place": self._place, "turn": self._turn}
        return state | {"momentum": self._momentum} | self.memories()

    def restore(self, state: dict[str, np.ndarray]) -> None:
        self.velocity = np.array(state["velocity"])
        self._place, self._turn = np.array(state["place"]), np.array(state["turn"])
        self.trial_velocity = self.moving_velocity = self.velocity.copy()
        self.trial_place, self.trial_turn = self._place.copy(), self._turn.copy()
        self._momentum = np.array(state["momentum"])
        self.memory = state.get("memory")

    @property
    def rotation(self) -> float | np.ndarray:
        """The rotation since the reference placement: rad in 2D, in (-pi, pi]; a rotation vector in
        3D."""
        if self.dim == 2:
            return float(np.arctan2(self._turn[1, 0], self._turn[0, 0]))
        return Rotation.from_matrix(self._turn).as_rotvec()

    @property
    def spin(self) -> float | np.ndarray:
        """How fast it turns, rad/s: a number in 2D, a vector (3,) in 3D, about axes in space."""
        return float(self.velocity[2]) if self.dim == 2 else self.velocity[3:].copy()

    @property
    def place(self) -> np.ndarray:
        """Where the centre of mass is, (d,) in m."""
        return self._place.copy()

    def fields(self) -> dict[str, np.ndarray]:
        x, spin = self.mesh.mesh.geometry.x[:, : self.dim], self.velocity[self.dim :]
        here = self.places(x)
        return {
            "displacement": here - x,
            "velocity": self.velocity[: self.dim] + by_spins(here - self._place) @ spin,
        }

    def places(self, points: np.ndarray) -> np.ndarray:
        """Where points (n, d) of the mesh are in the state, as a step begins, m."""
        return np.asarray(self._place + (points - self.centre) @ self._turn.T)
