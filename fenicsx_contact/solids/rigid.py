# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rigid solids: 3 unknowns in 2D, 6 in 3D, finite rotations.

Unknowns: the velocity of the centre of mass and the spin (a number in 2D, the spatial vector in
3D). The scheme acts on the place of the centre and on the rotation, which the exponential of its
increment turns on; angular momentum is balanced in space, so that free flight keeps it exactly.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf, isfinite, sqrt
from typing import Any

import numpy as np
from mpi4py import MPI
from scipy.linalg import lapack

from ..base import checks
from ..base.mesh import NamedMesh
from ..base.shown import worded
from ..base.told import given
from ..base.vectors import largest
from ..theory.scheme import Step
from .moments import moments
from .rigid_forces import Applied, Load, components, held_components, pull, stiffened, without
from .rigid_forces import springs as to_ground
from .rigid_motion import RigidMotion
from .rotations import EYE, angles, rotation_matrix, turned_tensor, turning


class RigidSolid(RigidMotion):
    """A rigid solid.

    Args:
        mesh: its shape; only facets and, for the mass, the volume are read from it.
        density: kg/m³, or give ``mass``.
        mass: total mass, kg (kg/m in 2D), spread evenly.
        gravity: acceleration, d numbers, m/s².
        rotation: initial rotation, in rad (a rotation vector in 3D), about ``about``.
        about: the point, d coordinates, about which the initial rotation turns.
        force, torque: at the centre of mass, N and N m (a number in 2D), in fixed directions, or
            functions of time that give them.
        springs: to the ground, by points of the solid: stiffness for all directions or for each,
            N/m; without a force in the reference placement. Their energy is strain energy.
        held: components that do not move: ``"x"``, ``"y"``, ``"z"`` of the centre of mass,
            ``"turning"`` in 2D, ``"turning about x"`` ... in 3D.
        velocity, spin: initial velocity of the centre of mass, m/s, and spin, rad/s.
        name: for messages and files.

    Raises:
        InputError: neither or both of density and mass, numbers out of range, a held component
            that starts with a velocity.
    """

    linear = False
    shiftable = True
    given: np.ndarray  # what loads and memory give in the step, as a mean force, N and N m
    _driving: np.ndarray  # the mean of what is applied, if anything is

    def __init__(
        self,
        mesh: NamedMesh,
        *,
        density: float | None = None,
        mass: float | None = None,
        gravity: Sequence[float] | None = None,
        rotation: float | Sequence[float] = 0.0,
        about: Sequence[float] | None = None,
        force: Load | None = None,
        torque: Load | None = None,
        springs: Mapping[Sequence[float], Any] | None = None,
        held: Sequence[str] = (),
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
        self._masses = np.array([*[self.mass] * self.dim, *np.diag(self.inertia)])  # for d = 2
        self._radius = sqrt(np.trace(self.inertia) / self.mass)
        d, spins = self.dim, 1 if self.dim == 2 else 3
        self.gravity = np.zeros(d) if gravity is None else checks.vector("gravity", gravity, d)
        self._load = np.concatenate([self.mass * self.gravity, np.zeros(spins)])
        applied = force is not None or torque is not None
        self.applied = [Applied(force, torque, d)] if applied else []
        self.springs = to_ground({} if springs is None else springs, self.centre)
        self.held = held_components(held, d)
        names = [components(d)[i] for i in self.held]
        self._held_by = "".join(f", spring {spring.told}" for spring in self.springs)
        self._held_by += given({"held": names, "force": force, "torque": torque})
        self._holding = np.zeros(d + spins)
        self._holding[self.held] = 1.0
        self._kept = 1.0 - self._holding  # 0 of what is held, whose balance is not asked for
        if d == 2:
            self._everywhere = np.diag(self._kept / self._masses)  # its mobility
        self.supported = bool(self.springs) or len(self.held) > 0
        self._steady = d == 2 and not self.springs  # one matrix for steps of one length
        self._spinning = d == 3 and not self.springs and not self._holding[d:].any()
        self.balanced = self._steady or self._spinning

        turn = angles("rotation", rotation, spins)
        pivot = self.centre if about is None else checks.vector("about", about, d)
        self._turn = rotation_matrix(turn)
        self._place = pivot + self._turn @ (self.centre - pivot)
        self.velocity = np.zeros(d + spins)
        if velocity is not None:
            self.velocity[:d] = checks.vector("velocity", velocity, d)
        self.velocity[d:] = angles("spin", spin, spins)
        if self.velocity[self.held].any():
            raise checks.InputError(f"held = {names}: what is held must start without a velocity")
        self.trial_velocity = self.moving_velocity = self.velocity.copy()
        self.trial_place, self.trial_turn = self._place.copy(), self._turn.copy()
        self._momentum = self._momentum_of(self.velocity, self._turn)
        self._inverse_for = 0.0

    # -- the step -------------------------------------------------------------------------------

    def predict(self, step: Step) -> None:
        self.memory = step.recall(self.memory, lambda: self._force_at_start(step))
        carried = step.carried(self.memory)
        self.given = step.loaded * (step.load_weight * self._load + carried)
        self.shifted = None
        for applied in self.applied:
            self._driving = step.mean_load(applied.at) / step.load_weight
            self.given = self.given + step.loaded * step.load_weight * self._driving
        self.go(self.velocity, step)

    def _force_at_start(self, step: Step) -> np.ndarray:
        acting = [spring.force(self._place, self._turn) for spring in self.springs]
        acting += [applied.at(step.start) for applied in self.applied]
        return self._kept * np.sum([self._load, *acting], axis=0)

    def linearise(self, step: Step) -> None:
        if not self._steady or step.span != self._inverse_for:
            self._inverse_for = step.span
            self.linearisation += 1
            d, n = self.dim, len(self.velocity)
            self.inverse = np.zeros((n, n))
            self.inverse.flat[: d * (n + 1) : n + 1] = step.span / self.mass
            spin = self._mobility if d == 2 else lapack.dgesv(self._spin_tangent(step), EYE)[2]
            self.inverse[d:, d:] = step.span * spin
            if self.springs:
                added = np.sum([spring.matrix(self.trial_turn) for spring in self.springs], axis=0)
                self.inverse = stiffened(self.inverse, step.force_rate * added)
            self.inverse = without(self.inverse, self.held)
            self._matrix: np.ndarray | None = None
        self.drop_forces()
        self.free_velocity = self.trial_velocity - self.inverse @ self.residual()

    def _spin_tangent(self, step: Step) -> np.ndarray:
        """Derivative of the angular momentum J w by the spin w in space, which turns J."""
        spin, turn = self.trial_velocity[3:], self.trial_turn
        inertia = self.spatial(self.inertia, turn)
        way = step.increment(self.velocity, self.trial_velocity, self.memory)[3:]
        return inertia + step.gap_rate * turned_tensor(inertia, spin) @ turning(way)

    def correct(self, step: Step) -> None:
        self.go(self.free_velocity + self.inverse @ self._force, step)
        if self._spinning:
            self._balance_spin(step)
            self._trial_momentum = self._momentum_of(self.trial_velocity, self.trial_turn)

    def push(self, force: np.ndarray) -> None:
        self._force += force
        self._terms += np.abs(force)

    def drop_forces(self) -> None:
        n = len(self.velocity)
        self._force, self._terms = np.zeros(n), np.zeros(n)  # the latter without regard to signs

    def go(self, velocity: np.ndarray, step: Step) -> None:
        self.trial_velocity = velocity
        self._move(step)
        self._trial_momentum = self._momentum_of(self.trial_velocity, self.trial_turn)
        self._acting = self.given
        if self.springs:
            old, new = (self._place, self._turn), (self.trial_place, self.trial_turn)
            self._acting = self.given + pull(self.springs, step, old, new)

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
            last, change = change, largest(new - old)
            falls = change < last

    def layout(self, comm: MPI.Comm) -> list[int]:
        return [len(self.velocity), *[0] * (comm.size - 1)]

    def owned_range(self, comm: MPI.Comm) -> slice:
        return slice(0, len(self.velocity))  # every process has them all

    @property
    def _tangent(self) -> np.ndarray:
        """A of ``A v+ = b + J' f``, made where a solver needs it."""
        if self._matrix is None:
            try:
                self._matrix = np.linalg.inv(self.inverse + np.diag(self._holding))
            except np.linalg.LinAlgError:  # a try that spins beyond all reason has no next one
                self._matrix = np.full_like(self.inverse, np.nan)
        return self._matrix

    def matrix_rows(self, comm: MPI.Comm) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        n = len(self.velocity)
        if comm.rank:
            return np.zeros(1, dtype=int), np.empty(0, dtype=int), np.empty(0)
        return np.arange(0, n * n + 1, n), np.tile(np.arange(n), n), self._tangent.ravel()

    def residual(self) -> np.ndarray:
        change = self._trial_momentum - self._momentum
        return self._kept * (change / self._inverse_for - self._acting - self._force)

    def load_size(self) -> float:
        free = self._tangent @ self.free_velocity
        return float(max(np.abs(free).max(), np.abs(self._force).max()))

    def linear_residual(self) -> np.ndarray:
        off = self.trial_velocity - self.free_velocity - self.inverse @ self._force
        return np.asarray(self._tangent @ off)

    def imbalance(self, step: Step, noise: float = 0.0) -> float:
        rate = step.inertia_force(self._momentum, self._trial_momentum)
        load, d = self._acting, self.dim
        residual = np.abs(self._kept * (rate - load - self._force)).tolist()
        size = (np.abs(self._momentum / step.span) + np.abs(load) + self._terms).tolist()
        if not isfinite(sum(residual)):  # max may pass over NaN
            return inf
        arm = self._radius  # moments are those of forces there
        force = max(*size[:d], max(size[d:]) / arm)
        off = max(*residual[:d], max(residual[d:]) / arm)
        return off / force if force > noise else 0.0

    def accept(self, step: Step) -> None:
        self.memory = step.remember(self.velocity, self.trial_velocity, self._acting, self.memory)
        self.velocity = self.trial_velocity.copy()
        self._place, self._turn = self.trial_place, self.trial_turn
        self._momentum = self._trial_momentum

    def energies(self) -> tuple[float, float, float]:
        kinetic = 0.5 * self.velocity @ self._momentum
        strain = sum(spring.energy(self._place, self._turn) for spring in self.springs)
        return float(kinetic), strain, float(-self._load[: self.dim] @ self._place)

    def drift(self) -> tuple[float, np.ndarray] | None:
        """Its mass, kg, and momentum, (d,) in kg m/s, where no support holds it."""
        return None if self.supported else (self.mass, self._momentum[: self.dim])

    def works(self, step: Step) -> tuple[float, float, float, float]:
        mean = step.mean(self.velocity, self.trial_velocity)
        change = self._trial_momentum - self._momentum
        driven = [step.loaded * float(self._way(step) @ self._driving) for _ in self.applied]
        return float(mean @ change), step.work(mean, self._acting), 0.0, sum(driven)

    def describe(self) -> str:
        weight = f"mass {self.mass:.9g}, gravity {self.gravity.tolist()}{worded(self._held_by)}"
        return f"rigid, {weight}, {len(self.velocity)} unknowns"
