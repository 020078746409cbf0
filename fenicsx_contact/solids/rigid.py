# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rigid solids: 3 unknowns in 2D, 6 in 3D, finite rotations.

Unknowns: the velocity of the centre of mass and the spin (a number in 2D, the spatial vector in
3D). The scheme acts on the place of the centre and on the rotation, which the exponential of its
increment turns on; angular momentum is balanced in space, so that free flight keeps it exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

import numpy as np
from mpi4py import MPI
from scipy.spatial.transform import Rotation

from ..base import checks
from ..base.mesh import NamedMesh
from ..theory.theta import Step
from .base import MonolithicSolid
from .moments import moments
from .rigid_trace import RigidTrace
from .rotations import angles, cross, cross_matrix, rotation_matrix, turning


class RigidSolid(MonolithicSolid):
    """A rigid solid.

    Args:
        mesh: its shape; only facets and, for the mass, the volume are read from it.
        density: kg/m³ (kg/m² in 2D), or give ``mass``.
        mass: total mass, kg (kg/m in 2D), spread evenly.
        gravity: acceleration, d numbers, m/s².
        rotation: initial rotation, in rad (a rotation vector in 3D), about ``about``.
        about: the point, d coordinates, about which the initial rotation turns.
        velocity, spin: initial velocity of the centre of mass, m/s, and spin, rad/s.
        name: for messages and files.

    Raises:
        InputError: neither or both of density and mass, or numbers out of range.
    """

    linear = False
    shiftable = True
    supported = False

    def __init__(
        self,
        mesh: NamedMesh,
        *,
        density: float | None = None,
        mass: float | None = None,
        gravity: Sequence[float] | None = None,
        rotation: float | Sequence[float] = 0.0,
        about: Sequence[float] | None = None,
        velocity: Sequence[float] | None = None,
        spin: float | Sequence[float] = 0.0,
        name: str = "rigid",
    ) -> None:
        checks.instance("mesh", mesh, NamedMesh, "a NamedMesh (mesh_from_gmsh, name_facets)")
        self.name, self.mesh, self.dim = checks.label("name", name), mesh, mesh.dim
        if (density is None) == (mass is None):
            raise checks.InputError(f"density = {density!r}, mass = {mass!r}: give one of them")
        size, self.centre, second = moments(mesh)
        rho = (
            checks.number("density", density, above=0)
            if mass is None
            else checks.number("mass", mass, above=0) / size
        )
        self.mass = checks.number("density times the size of the mesh", rho * size, above=0)
        if self.dim == 2:
            self.inertia = np.array([[rho * np.trace(second)]])
        else:
            self.inertia = rho * (np.trace(second) * np.eye(3) - second)
        self._mobility = np.linalg.inv(self.inertia)
        d, spins = self.dim, 1 if self.dim == 2 else 3
        self.gravity = np.zeros(d) if gravity is None else checks.vector("gravity", gravity, d)
        self._load = np.concatenate([self.mass * self.gravity, np.zeros(spins)])

        turn = angles("rotation", rotation, spins)
        pivot = self.centre if about is None else checks.vector("about", about, d)
        self._turn = rotation_matrix(turn)
        self._place = pivot + self._turn @ (self.centre - pivot)
        self.velocity = np.zeros(d + spins)
        if velocity is not None:
            self.velocity[:d] = checks.vector("velocity", velocity, d)
        self.velocity[d:] = angles("spin", spin, spins)
        self.trial_velocity = self.velocity.copy()
        self.trial_place, self.trial_turn = self._place.copy(), self._turn.copy()
        self._momentum = self._momentum_of(self.velocity, self._turn)
        self._inverse_for = 0.0

    # -- the step -------------------------------------------------------------------------------

    def predict(self, step: Step) -> None:
        self.memory = step.recall(self.memory, lambda: self._load)
        carried = step.carried(self.memory)
        self._acting = step.loaded * (step.load_weight * self._load + carried)
        self.trial_velocity = self.velocity
        self._move(step)
        self._trial_momentum = self._momentum_of(self.trial_velocity, self.trial_turn)

    def linearise(self, step: Step) -> None:
        if self.dim == 3 or step.span != self._inverse_for:
            self._inverse_for = step.span
            self.linearisation += 1
            d = self.dim
            self.inverse = np.zeros((len(self.velocity),) * 2)
            self.inverse[range(d), range(d)] = step.span / self.mass
            spin = self._mobility if d == 2 else np.linalg.inv(self._spin_tangent(step))
            self.inverse[d:, d:] = step.span * spin
        self.drop_forces()
        self.free_velocity = self.trial_velocity - self.inverse @ self.residual()

    def _spin_tangent(self, step: Step) -> np.ndarray:
        """Derivative of the angular momentum J w by the spin w in space, which turns J."""
        spin, turn = self.trial_velocity[3:], self.trial_turn
        inertia = self._spatial(self.inertia, turn)
        way = step.increment(self.velocity, self.trial_velocity, self.memory)[3:]
        turned = inertia @ cross_matrix(spin) - cross_matrix(inertia @ spin)
        return inertia + step.gap_rate * turned @ turning(way)

    def correct(self, step: Step) -> None:
        self.go(self.free_velocity + self.inverse @ self._force, step)
        if self.dim == 3:
            self._balance_spin(step)
            self._trial_momentum = self._momentum_of(self.trial_velocity, self.trial_turn)

    def push(self, force: np.ndarray) -> None:
        """Add to the forces on the solid in this step, N and N m."""
        self._force += force
        self._terms += np.abs(force)

    def drop_forces(self) -> None:
        self._force = np.zeros_like(self.velocity)
        self._terms = np.zeros_like(self.velocity)  # the same without regard to signs

    def go(self, velocity: np.ndarray, step: Step) -> None:
        self.trial_velocity = velocity
        self._move(step)
        self._trial_momentum = self._momentum_of(self.trial_velocity, self.trial_turn)

    def _balance_spin(self, step: Step) -> None:
        """Turn until the spin belongs to the inertia where it leads: the outer loop, which is
        content with less, would let angular momentum drift from step to step."""
        impulse = step.span * (self._acting + self._force)
        momentum = (self._momentum + impulse)[self.dim :]
        change, falls = np.inf, True
        while falls:  # down to round-off
            old = self.trial_velocity[self.dim :].copy()
            new = self.trial_turn @ (self._mobility @ (self.trial_turn.T @ momentum))
            self.trial_velocity[self.dim :] = new
            self._move(step)
            last, change = change, float(np.abs(new - old).max())
            falls = change < last

    def layout(self, comm: MPI.Comm) -> list[int]:
        return [len(self.velocity), *[0] * (comm.size - 1)]

    def owned_range(self, comm: MPI.Comm) -> slice:
        return slice(0, len(self.velocity))  # every process has them all

    def matrix_rows(self, comm: MPI.Comm) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        n = len(self.velocity)
        if comm.rank:
            return np.zeros(1, dtype=int), np.empty(0, dtype=int), np.empty(0)
        matrix = np.linalg.inv(self.inverse)
        return np.arange(0, n * n + 1, n), np.tile(np.arange(n), n), matrix.ravel()

    def residual(self) -> np.ndarray:
        change = self._trial_momentum - self._momentum
        return change / self._inverse_for - self._acting - self._force

    def load_size(self) -> float:
        free = np.linalg.solve(self.inverse, self.free_velocity)
        return float(max(np.abs(free).max(), np.abs(self._force).max()))

    def linear_residual(self) -> np.ndarray:
        return np.linalg.solve(
            self.inverse, self.trial_velocity - self.free_velocity - self.inverse @ self._force
        )

    def imbalance(self, step: Step, noise: float = 0.0) -> float:
        rate, load = step.inertia_force(self._momentum, self._trial_momentum), self._acting
        residual = rate - load - self._force
        size = np.abs(self._momentum / step.span) + np.abs(load) + self._terms
        d, radius = self.dim, sqrt(np.trace(self.inertia) / self.mass)
        size[d:] = np.maximum(size[d:], radius * size[:d].max())  # forces at arm's length, too
        if size[:d].max() <= noise:
            return 0.0
        return max(_relative(residual[:d], size[:d]), _relative(residual[d:], size[d:]))

    @property
    def mobility(self) -> np.ndarray:
        d = self.dim
        result = np.zeros((len(self.velocity),) * 2)
        result[range(d), range(d)] = 1 / self.mass
        result[d:, d:] = self._spatial(self._mobility, self.trial_turn)
        return result

    def shift(self, way: np.ndarray) -> None:
        d = self.dim
        self.trial_place = self.trial_place + way[:d]
        self.trial_turn = rotation_matrix(way[d:]) @ self.trial_turn
        if d == 3:  # the spin that belongs to the momentum
            spin = self._spatial(self._mobility, self.trial_turn) @ self._trial_momentum[d:]
            self.trial_velocity = np.concatenate([self.trial_velocity[:d], spin])

    def accept(self, step: Step) -> None:
        self.memory = step.remember(self.velocity, self.trial_velocity, self._acting, self.memory)
        self.velocity = self.trial_velocity.copy()
        self._place, self._turn = self.trial_place, self.trial_turn
        self._momentum = self._trial_momentum

    def _move(self, step: Step) -> None:
        increment = step.increment(self.velocity, self.trial_velocity, self.memory)
        self.trial_place = self._place + increment[: self.dim]
        turn = rotation_matrix(increment[self.dim :]) @ self._turn
        if self.dim == 3:  # products of many rotations would lose orthogonality, momentum with it
            turn = turn @ (1.5 * np.eye(3) - 0.5 * turn.T @ turn)
        self.trial_turn = turn

    def _spatial(self, tensor: np.ndarray, turn: np.ndarray) -> np.ndarray:
        return tensor if self.dim == 2 else turn @ tensor @ turn.T

    def _momentum_of(self, velocity: np.ndarray, turn: np.ndarray) -> np.ndarray:
        d = self.dim
        spin = self._spatial(self.inertia, turn) @ velocity[d:]
        return np.concatenate([self.mass * velocity[:d], spin])

    # -- what it tells --------------------------------------------------------------------------

    def trace(self, points: np.ndarray) -> RigidTrace:
        return RigidTrace(self, points - self.centre)

    def energies(self) -> tuple[float, float, float]:
        kinetic = 0.5 * self.velocity @ self._momentum
        return float(kinetic), 0.0, float(-self._load[: self.dim] @ self._place)

    def root_mean_square(self, velocity: np.ndarray) -> float:
        return sqrt(float(velocity @ self._momentum_of(velocity, self.trial_turn)) / self.mass)

    def works(self, step: Step) -> tuple[float, float, float, float]:
        mean = step.mean(self.velocity, self.trial_velocity)
        change = self._trial_momentum - self._momentum
        return float(mean @ change), step.work(mean, self._acting), 0.0, 0.0

    def state(self) -> dict[str, np.ndarray]:
        state = {"velocity": self.velocity, "place": self._place, "turn": self._turn}
        return state | {"momentum": self._momentum} | self.memories()

    def restore(self, state: dict[str, np.ndarray]) -> None:
        self.velocity = np.array(state["velocity"])
        self._place, self._turn = np.array(state["place"]), np.array(state["turn"])
        self.trial_velocity = self.velocity.copy()
        self.trial_place, self.trial_turn = self._place.copy(), self._turn.copy()
        self._momentum = np.array(state["momentum"])
        self.memory = state.get("memory")

    @property
    def rotation(self) -> float | np.ndarray:
        """The rotation since the reference placement: rad in 2D, a rotation vector in 3D."""
        if self.dim == 2:
            return float(np.arctan2(self._turn[1, 0], self._turn[0, 0]))
        return Rotation.from_matrix(self._turn).as_rotvec()

    @property
    def place(self) -> np.ndarray:
        """Where the centre of mass is, (d,) in m."""
        return self._place.copy()

    def fields(self) -> dict[str, np.ndarray]:
        x = self.mesh.mesh.geometry.x[:, : self.dim]
        arm = (x - self.centre) @ self._turn.T
        spin = self.velocity[self.dim :]
        return {
            "displacement": self._place + arm - x,
            "velocity": self.velocity[: self.dim] + cross(spin, arm),
        }

    def describe(self) -> str:
        weight = f"mass {self.mass:.9g}, gravity {self.gravity.tolist()}"
        return f"rigid, {weight}, {len(self.velocity)} unknowns"


def _relative(residual: np.ndarray, size: np.ndarray) -> float:
    return float(np.abs(residual).max() / (size.max() or 1.0))
