# SPDX-License-Identifier: LGPL-3.0-or-later
"""What every deformable solid is: a displacement field on a mesh, with mass, load and supports.

The mesh may be distributed: arrays hold the unknowns that a process owns, and only surface data
travel between processes.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from math import sqrt

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from ..base import checks
from ..base.mesh import NamedMesh
from ..theory.theta import Step
from .base import MonolithicSolid
from .boundary import Motion, Supports, Traction, Tractions
from .factor import Factorisation
from .mass import Mass
from .mass_redistribution import relax
from .trace import DeformableTrace
from .vector_space import Field, VectorSpace

#: Forces below this share of the terms that they are the difference of are noise.
ROUND_OFF = 1e-14


class DeformableSolid(MonolithicSolid):
    """A solid with a displacement field; see its two kinds.

    Args:
        mesh: its shape.
        density: kg/m³.
        degree: of the displacement, 1 or 2.
        gravity: acceleration, d numbers, m/s².
        fixed: names of facets held fast.
        prescribed: motions of named facets: displacements in m by direction, None where it is
            free, or a function of time that gives them.
        tractions: dead loads on named facets, Pa, or functions of time that give them.
        mass_redistribution: names of facets whose mass is moved inwards, so that their impacts
            lose no energy; for laws of positions (GAP, ...).
        displacement, velocity: initial fields in m and m/s, functions of ``x`` (3, n) with values
            (d, n).
        name: for messages, files and the prefix of PETSc options.

    Raises:
        InputError: numbers out of range, a name that the mesh lacks.
    """

    parameters: str  # for describe()
    factorisation: Factorisation
    free_load: np.ndarray
    _free_velocity: np.ndarray | None = None

    def __init__(
        self,
        mesh: NamedMesh,
        *,
        density: float,
        degree: int = 1,
        gravity: Sequence[float] | None = None,
        fixed: Sequence[str] = (),
        prescribed: Mapping[str, Motion] | None = None,
        tractions: Mapping[str, Traction] | None = None,
        mass_redistribution: Sequence[str] = (),
        displacement: Field | None = None,
        velocity: Field | None = None,
        name: str = "deformable",
    ) -> None:
        checks.instance("mesh", mesh, NamedMesh, "a NamedMesh (mesh_from_gmsh, name_facets)")
        self.name, self.mesh, self.dim = name, mesh, mesh.dim
        self.vectors = VectorSpace(mesh, degree)
        self.comm, self.space, self.degree = self.vectors.comm, self.vectors.space, degree
        self.owned, self.unknowns = self.vectors.owned, self.vectors.unknowns
        self.multiply = self.vectors.multiply
        self.supports = Supports(self.vectors, fixed, {} if prescribed is None else prescribed)
        self.fixed_unknowns, self.hold = self.supports.unknowns, self.supports.hold
        self.supported = bool(self.supports.directions.any())
        self._tractions = Tractions(self.vectors, tractions) if tractions else None
        self._traction = self._tractions.total(0.0) if self._tractions else 0.0

        self._inertia = Mass(self.vectors, density, mass_redistribution, self.fixed_unknowns)
        self._mass, self._sum = self._inertia.matrix, self.vectors.sum
        self.massless = self.comm.allreduce(len(self._inertia.massless)) > 0
        self._load = np.zeros(self.owned)
        self.parameters = f"density {self._inertia.density!r}"
        if gravity is not None:
            acceleration = checks.vector("gravity", gravity, mesh.dim)
            self.parameters += f", gravity {acceleration.tolist()}"
            self._load = self._inertia.weight(acceleration)

        self.displacement = self.vectors.interpolate("displacement", displacement)
        self.displacement[self.fixed_unknowns] = self.supports.values(0.0)
        self.velocity = self.vectors.interpolate("velocity", velocity)
        self.velocity[self.fixed_unknowns] = 0.0
        self.trial_displacement = self.displacement.copy()
        self.trial_velocity = self.velocity.copy()
        self._force = np.zeros(self.owned)
        self._target: np.ndarray | None = None
        self._reaction = np.zeros(len(self.fixed_unknowns))
        self._momentum = self._inertia.times(self.velocity)

    def _begin(self) -> None:
        """Make the initial fields fit: a boundary without mass is in equilibrium with what is
        behind it, supports start as they go on."""
        if self.massless:
            relax(
                np.setdiff1d(self._inertia.massless, self.fixed_unknowns),
                self.displacement,
                lambda u: self.internal_force(u) - self._load - self._traction,
                self.stiffness,
                self.vectors.first,
            )
            self.trial_displacement = self.displacement.copy()
        if self.supports.moving:
            self.velocity[self.fixed_unknowns] = self.supports.starting_speed(self._shortest_time())
            self.trial_velocity = self.velocity.copy()
            self._momentum = self._inertia.times(self.velocity)
        self._state_changed()

    def _shortest_time(self) -> float:
        """1/omega of the unknown that its neighbours hold most stiffly at rest, s."""
        mass = self.vectors.diagonal(self._mass)
        stiffness = self.vectors.diagonal(self.stiffness(self.displacement))
        squares = np.where(mass > 0, stiffness, 0.0) / np.where(mass > 0, mass, 1.0)
        square = max(self.comm.allgather(float(squares.max(initial=0.0))))
        return 1 / sqrt(square) if square else np.inf

    @property
    @abstractmethod
    def last_stiffness(self) -> PETSc.Mat:
        """The newest of :meth:`stiffness`."""

    @abstractmethod
    def stiffness(self, displacement: np.ndarray) -> PETSc.Mat:
        """Derivative of the internal forces at a displacement; the solid keeps the matrix."""

    @abstractmethod
    def strain_energy(self) -> float:
        """Strain energy of the state, J."""

    @abstractmethod
    def internal_force(self, displacement: np.ndarray) -> np.ndarray:
        """Internal forces at a displacement, for the owned unknowns."""

    @abstractmethod
    def _state_changed(self) -> None:
        """The state is new: refresh what is kept from step to step."""

    def predict(self, step: Step) -> None:
        self.trial_velocity = self.velocity.copy()
        self._target = None
        if self.supports.moving and step.dt:
            self._target = self.supports.values(step.end)
            way = self._target - self.displacement[self.fixed_unknowns]
            self.trial_velocity[self.fixed_unknowns] = way / step.dt
        self._move(step)

    def _move(self, step: Step) -> None:
        increment = step.scheme.increment(step.dt, self.velocity, self.trial_velocity)
        self.trial_displacement = self.displacement + increment
        if self._target is not None:
            self.trial_displacement[self.fixed_unknowns] = self._target

    def _loads(self, step: Step) -> np.ndarray:
        """Gravity and tractions where the scheme takes the forces."""
        if self._tractions:
            self._traction = self._tractions.total(step.force_time)
        return self._load + self._traction

    def _at(self, share: float) -> np.ndarray:
        """The displacement at a share of the way of the step."""
        return share * self.trial_displacement + (1 - share) * self.displacement

    def _internal_forces(self, step: Step) -> np.ndarray:
        """The internal forces of the step, as the scheme takes them."""
        return self.internal_force(self._at(step.scheme.force_weight))

    def free_velocity(self) -> np.ndarray:
        """Velocity at the end of the step if no contact acted."""
        if self._free_velocity is None:
            self._free_velocity = self.factorisation.solve(self.free_load)
        return self._free_velocity

    def correct(self, step: Step) -> None:
        load = self.free_load + self._force
        load[self.fixed_unknowns] = self.free_load[self.fixed_unknowns]
        self.go(self.factorisation.solve(load), step)

    def go(self, velocity: np.ndarray, step: Step) -> None:
        self.trial_velocity = velocity
        self._move(step)

    def push(self, force: np.ndarray) -> None:
        """Add to the forces on the solid in this step, (owned,) in N."""
        self._force += force

    def drop_forces(self) -> None:
        self._force = np.zeros(self.owned)

    def layout(self, comm: MPI.Comm) -> list[int]:
        return list(comm.allgather(self.owned))

    def owned_range(self, comm: MPI.Comm) -> slice:
        return slice(self.vectors.first, self.vectors.first + self.owned)

    def matrix_rows(self, comm: MPI.Comm) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return self.factorisation.matrix.getValuesCSR()

    def residual(self) -> np.ndarray:
        moved = self.multiply(self.factorisation.matrix, self.trial_velocity)
        result = moved - self.free_load - self._force
        result[self.fixed_unknowns] = 0.0
        return result

    def _balance(self, step: Step) -> list[np.ndarray]:
        """The terms of the momentum balance in the trial state, for the owned unknowns; their sum
        vanishes but at the supports, where it is the reaction."""
        terms = [-self._force]
        if step.scheme.inertia:
            self._trial_momentum = self._inertia.times(self.trial_velocity)
            terms.append((self._trial_momentum - self._momentum) / step.span)
        else:
            self._trial_momentum = self._momentum
        if step.dt:
            terms += [self._internal_forces(step), -self._loads(step)]
        return terms

    def imbalance(self, step: Step, noise: float = 0.0) -> float:
        terms = self._balance(step)
        # a stress-free body in flight has no forces but round-off, of its momentum and of K u
        stiffness = self.vectors.diagonal(self.last_stiffness)
        round_off = ROUND_OFF * (np.abs(self._momentum) / step.span)
        if step.dt and step.scheme.inertia:  # without inertia nothing may fly
            strained = np.abs(stiffness * self.trial_displacement)
            round_off += ROUND_OFF * strained.max(initial=0.0)
        total = np.maximum(np.abs(np.sum(terms, axis=0)) - round_off, 0.0)
        total[self.fixed_unknowns] = 0.0
        own = np.array([[np.abs(t).max(initial=0.0) for t in (total, *terms)]])
        largest = np.max(self.comm.allgather(own), axis=0).ravel()
        size = largest[1:].max()
        return float(largest[0] / size) if size > noise else 0.0

    def accept(self) -> None:
        self.velocity = self.trial_velocity.copy()
        self.displacement = self.trial_displacement
        self._momentum = self._trial_momentum
        self._state_changed()

    def works(self, step: Step) -> tuple[float, float, float, float]:
        mean = step.scheme.mean(self.velocity, self.trial_velocity)
        contact, *terms = self._balance(step)
        held = self.fixed_unknowns
        self._reaction = (contact + np.sum(terms, axis=0))[held] if terms else -contact[held]
        acting = -step.dt * float(mean @ np.sum(terms[-2:], axis=0)) if step.dt else 0.0
        driven = step.span * float(mean[held] @ self._reaction)
        pulled = step.dt * float(mean @ (self._traction + np.zeros(self.owned)))
        return (
            self._sum(mean @ (self._trial_momentum - self._momentum)),
            self._sum(acting),
            self._sum(driven),
            self._sum(pulled),
        )

    def reaction(self, name: str) -> np.ndarray:
        """Force of the support of the named facets on the solid in the last step, (d,) in N."""
        return self.supports.total(name, self._reaction)

    def energies(self) -> tuple[float, float, float]:
        kinetic = 0.5 * self._sum(self.velocity @ self._momentum)
        return kinetic, self.strain_energy(), -self._sum(self._load @ self.displacement)

    @property
    def mass(self) -> float:
        """kg (kg/m in 2D)."""
        return self._inertia.total

    def root_mean_square(self, velocity: np.ndarray) -> float:
        return self._inertia.root_mean_square(velocity)

    def trace(self, points: np.ndarray) -> DeformableTrace:
        return DeformableTrace(self, points)

    def state(self) -> dict[str, np.ndarray]:
        # without inertia the momentum is not M v
        state = {"displacement": self.displacement, "velocity": self.velocity}
        return {**state, "momentum": self._momentum}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        self.displacement = np.array(state["displacement"])
        self.velocity = np.array(state["velocity"])
        self.trial_displacement = self.displacement.copy()
        self.trial_velocity = self.velocity.copy()
        given = state.get("momentum")
        moving = self._inertia.times(self.velocity)
        self._momentum = moving if given is None else np.array(given)
        self._state_changed()

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Mean of a field over the mass, (d,), from its owned unknowns: of the displacement [m],
        that of the centre of mass; of the velocity [m/s], momentum over mass."""
        return self._inertia.mean(values)

    def fields(self) -> dict[str, np.ndarray]:
        at_mesh = self.vectors.at_mesh
        return {"displacement": at_mesh(self.displacement), "velocity": at_mesh(self.velocity)}
