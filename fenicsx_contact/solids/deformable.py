# SPDX-License-Identifier: LGPL-3.0-or-later
"""What every deformable solid is: a displacement field on a mesh, with mass, load and supports.

The mesh may be distributed: arrays hold the unknowns that a process owns, and only surface data
travel between processes.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from math import sqrt
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc

from ..base import checks, compat
from ..base.mesh import NamedMesh
from ..theory.theta import Step
from .base import MonolithicSolid
from .boundary import Motion, Supports, Traction, Tractions
from .factor import Factorisation
from .mass_redistribution import move_mass_inwards, relax
from .trace import DeformableTrace

#: A field given as a function of ``x`` (3, n) with values (d, n).
Field = Callable[[np.ndarray], np.ndarray]

#: Forces below this share of what they are the difference of are noise.
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
        self.comm, d = mesh.mesh.comm, mesh.dim
        density = checks.number("density", density, above=0)
        if degree not in (1, 2):
            raise checks.InputError(f"degree = {degree!r}: must be 1 or 2")
        self.degree = degree
        self.space = compat.lagrange_space(mesh.mesh, degree, shape=(d,))
        self._output = compat.lagrange_space(mesh.mesh, 1, shape=(d,))
        self.displacement_field = fem.Function(self.space)
        index_map = self.space.dofmap.index_map
        self.owned = index_map.size_local * d
        self.unknowns = index_map.size_global * d
        self.first_unknown = index_map.local_range[0] * d
        self.supports = Supports(self, fixed, {} if prescribed is None else prescribed)
        self.fixed_unknowns = self.supports.unknowns
        self.supported = bool(self.supports.directions.any())
        self._tractions = Tractions(self, tractions) if tractions else None
        self._traction = self._tractions.total(0.0) if self._tractions else 0.0

        u, v = ufl.TrialFunction(self.space), ufl.TestFunction(self.space)
        self._dx = ufl.Measure("dx", domain=mesh.mesh)
        rho = fem.Constant(mesh.mesh, density)
        self._mass = compat.assemble_petsc_matrix(rho * ufl.dot(u, v) * self._dx)
        self._x, self._y = self._mass.createVecs()
        massless = self.nodes_of(mass_redistribution)
        self.massless = self.comm.allreduce(len(massless)) > 0
        if self.massless:
            move_mass_inwards(self, self._mass, massless)
        self._massless = (massless[:, None] * d + np.arange(d)).ravel()
        self._load = np.zeros(self.owned)
        self.parameters = f"density {density!r}"
        if gravity is not None:
            acceleration = checks.vector("gravity", gravity, d)
            self.parameters += f", gravity {acceleration.tolist()}"
            g = fem.Constant(mesh.mesh, acceleration)
            compat.assemble_owned(fem.form(rho * ufl.dot(g, v) * self._dx), self._load)

        self.displacement = self._initial("displacement", displacement)
        self.velocity = self._initial("velocity", velocity)
        self.trial_displacement = self.displacement.copy()
        self.trial_velocity = self.velocity.copy()
        self._force = np.zeros(self.owned)
        self._target: np.ndarray | None = None
        self._reaction = np.zeros(len(self.fixed_unknowns))
        self._momentum = self.multiply(self._mass, self.velocity)

    def nodes_of(self, names: Sequence[str]) -> np.ndarray:
        """The nodes of the named facets that this process owns."""
        blocks = [np.empty(0, dtype=np.int32)]
        for name in [names] if isinstance(names, str) else names:
            facets = self.mesh.facets(name)
            blocks.append(fem.locate_dofs_topological(self.space, self.dim - 1, facets))
        nodes = np.unique(np.concatenate(blocks)).astype(np.int64)
        return nodes[nodes < self.owned // self.dim]

    def _initial(self, what: str, field: Field | None) -> np.ndarray:
        function = fem.Function(self.space)

        def values_at(x: np.ndarray) -> np.ndarray:
            values = np.asarray(field(x), dtype=float)  # type: ignore[misc]
            if values.shape != (self.dim, x.shape[1]):
                raise checks.InputError(
                    f"{what}: gives values of shape {values.shape} at x of shape {x.shape}; must "
                    f"be a function of x (3, n) with values ({self.dim}, n)"
                )
            return values

        if field is not None:
            if not callable(field):
                raise checks.InputError(f"{what} = {field!r}: must be a function of x (3, n)")
            compat.interpolate(function, values_at)
        values = function.x.array[: self.owned].copy()
        if not min(self.comm.allgather(bool((np.abs(values) <= checks.LARGEST).all()))):
            raise checks.InputError(
                f"{what}: the initial field is not finite everywhere, or above {checks.LARGEST:g}"
            )
        starts = {"displacement": self.supports.values, "velocity": self._held_speed}
        values[self.fixed_unknowns] = starts[what](0.0)
        return values

    def _held_speed(self, time: float, span: float = 1e-6) -> np.ndarray:
        """Velocity of the held unknowns at the start."""
        if not self.supports.moving:
            return np.zeros(len(self.fixed_unknowns))
        return (self.supports.values(time + span) - self.supports.values(time)) / span

    def hold(self, matrix: PETSc.Mat) -> PETSc.Mat:
        """Clear the rows and columns of the held unknowns, 1 on the diagonal."""
        rows = self.first_unknown + self.fixed_unknowns
        matrix.setOption(PETSc.Mat.Option.KEEP_NONZERO_PATTERN, True)
        matrix.zeroRowsColumns(rows.astype(np.int32), 1.0)
        return matrix

    def multiply(self, matrix: PETSc.Mat, values: np.ndarray) -> np.ndarray:
        """A matrix of the solid times values of the owned unknowns."""
        self._x.setArray(values)
        matrix.mult(self._x, self._y)
        return self._y.array_r.copy()

    def _sum(self, value: float) -> float:
        return float(self.comm.allreduce(value)) if self.comm.size > 1 else float(value)

    def _relax(self) -> None:
        """Bring a boundary without mass into equilibrium with what is behind it."""
        if self.massless:
            relax(
                np.setdiff1d(self._massless, self.fixed_unknowns),
                self.displacement,
                lambda u: self.internal_force(u) - self._load - self._traction,
                self.stiffness,
                self.first_unknown,
            )
            self.trial_displacement = self.displacement.copy()

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

    def drop_forces(self) -> None:
        self._force = np.zeros(self.owned)

    def layout(self, comm: MPI.Comm) -> list[int]:
        return list(comm.allgather(self.owned))

    def owned_range(self, comm: MPI.Comm) -> slice:
        return slice(self.first_unknown, self.first_unknown + self.owned)

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
            self._trial_momentum = self.multiply(self._mass, self.trial_velocity)
            terms.append((self._trial_momentum - self._momentum) / step.span)
        else:
            self._trial_momentum = self._momentum
        if step.dt:
            terms += [self._internal_forces(step), -self._loads(step)]
        return terms

    def imbalance(self, step: Step, noise: float = 0.0) -> float:
        terms = self._balance(step)
        # a stress-free body in flight has no forces but round-off, of its momentum and of K u
        self.last_stiffness.getDiagonal(self._y)
        round_off = ROUND_OFF * (np.abs(self._momentum) / step.span)
        if step.dt and step.scheme.inertia:  # without inertia nothing may fly
            strained = np.abs(self._y.array_r * self.trial_displacement)
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
        nodes, d = self.nodes_of([name]), self.dim
        total = np.zeros(d)
        for i in range(d):
            mine = np.isin(self.fixed_unknowns, nodes * d + i)
            total[i] = self._sum(self._reaction[mine].sum())
        return total

    def energies(self) -> tuple[float, float, float]:
        kinetic = 0.5 * self._sum(self.velocity @ self._momentum)
        return kinetic, self.strain_energy(), -self._sum(self._load @ self.displacement)

    @cached_property
    def mass(self) -> float:
        """kg (kg/m in 2D)."""
        uniform = np.zeros(self.owned)
        uniform[:: self.dim] = 1.0
        return self._sum(uniform @ self.multiply(self._mass, uniform))

    def root_mean_square(self, velocity: np.ndarray) -> float:
        square = self._sum(velocity @ self.multiply(self._mass, velocity)) / self.mass
        return sqrt(max(square, 0.0))  # not a round-off of zero

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
        moving = self.multiply(self._mass, self.velocity)
        self._momentum = moving if given is None else np.array(given)
        self._state_changed()

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Mean of a field over the mass, (d,), from its owned unknowns: of the displacement [m],
        that of the centre of mass; of the velocity [m/s], momentum over mass."""
        weighted, total = self.multiply(self._mass, values), np.zeros(self.dim)
        for k in range(self.dim):
            total[k] = self._sum(weighted[k :: self.dim].sum())
        return total / self.mass

    def field(self, values: np.ndarray) -> Any:
        """A function of the solid's space from the values of its owned unknowns."""
        function = fem.Function(self.space)
        function.x.array[: self.owned] = values
        function.x.scatter_forward()
        return function

    def fields(self) -> dict[str, np.ndarray]:
        nodes = compat.cell_geometry(self.mesh.mesh)
        dofs = compat.cell_dofs(self._output)
        result = {}
        for what, values in (("displacement", self.displacement), ("velocity", self.velocity)):
            function = fem.Function(self._output)
            function.interpolate(self.field(values))
            at_nodes = np.zeros((len(self.mesh.mesh.geometry.x), self.dim))
            at_nodes[nodes.ravel()] = function.x.array.reshape(-1, self.dim)[dofs.ravel()]
            result[what] = at_nodes
        return result
