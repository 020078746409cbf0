# SPDX-License-Identifier: LGPL-3.0-or-later
"""What every deformable solid is: a displacement field on a mesh, with mass, load and supports.

The mesh may be distributed: arrays hold the unknowns that a process owns, and only surface data
travel between processes.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import ufl
from petsc4py import PETSc

from ..base import checks
from ..base.mesh import NamedMesh
from ..base.quoted import quoted
from ..base.told import given
from ..theory.scheme import Step
from .boundary import Motion, Supports
from .coefficients import Scalar
from .damping import Damping, MassDamper, Rayleigh
from .foundation import Foundation, Stiffness
from .loads import Load, Loads
from .locations import Location
from .mass import Mass
from .mass_redistribution import relax
from .periodic import vector_space
from .planes import PLANES, Whole
from .stress import Stressed
from .system_rows import SystemRows
from .trace import DeformableTrace
from .vector_space import Field


class DeformableSolid(SystemRows, Stressed):
    """A solid with a displacement field; see its two kinds.

    Args:
        mesh: its shape.
        density: kg/m³; a number, ``fem.Constant``, ``fem.Function``, expression in UFL, or function
            of x, see :mod:`~.coefficients`.
        degree: of the displacement, 1 or 2, not less than that of the mesh.
        periodic: pairs of names of sides that are one, a translation apart: the second moves as
            the first does, see :mod:`~.periodic`.
        plane: what a mesh in the plane stands for, see :mod:`~.planes`.
        gravity: acceleration, d numbers, m/s².
        fixed: what is held fast, by location: a name of facets or of a point, several names of
            facets in a tuple for the edge or corner that they share, or the coordinates of a node.
        prescribed: motions by location: displacements in m by direction, None where it is free (a
            roller), or a function of time that gives them; in all directions a vector in UFL (a
            Function, a Constant, an expression), or a function of x and t.
        springs: to the ground, by location: stiffness for all directions or for each, N/m³ of
            facets, N/m of each node elsewhere; their energy is strain energy.
        tractions: dead loads on named facets, Pa: d numbers, a Constant, Function, expression in
            UFL, or a function of t, of x, or of x and t; see :mod:`~.loads`.
        body_force: likewise, N/m³.
        damping: :class:`~.damping.KelvinVoigt`, :class:`~.damping.Rayleigh` or an own one.
        mass_redistribution: names of facets whose mass is moved inwards, so that their impacts
            lose no energy; for laws of positions (GAP, ...).
        displacement, velocity: initial fields in m and m/s: d numbers, functions of ``x`` (3, n)
            with values (d, n), or UFL on the mesh: a Function, a Constant, an expression.
        name: for messages, files and the prefix of PETSc options.

    Attributes:
        mass: kg (kg/m in 2D).
        joined: names of the periodic sides, which nothing can touch.
        breadth: m of the solid that a point of the mesh stands for, over 1 m, in UFL.

    Raises:
        InputError: numbers out of range, a name that the mesh lacks.
    """

    parameters: str  # for describe()
    remark = ""  # what a reader of a run should know of it
    #: Arrays of the state that hold owned unknowns.
    distributed: tuple[str, ...] = ("displacement", "velocity", "momentum", "memory")
    #: Its matrix is symmetric.
    symmetric = True
    #: What a mesh in the plane may stand for.
    planes: tuple[str, ...] = ("strain",)
    plane: Whole
    _free_velocity: np.ndarray | None = None

    def __init__(
        self,
        mesh: NamedMesh,
        *,
        density: Scalar,
        degree: int = 1,
        periodic: Sequence[tuple[str, str]] = (),
        plane: str = "strain",
        gravity: Sequence[float] | None = None,
        fixed: str | Sequence[Location] = (),
        prescribed: Mapping[Location, Motion] | None = None,
        springs: Mapping[Location, Stiffness] | None = None,
        tractions: Mapping[str, Load] | None = None,
        body_force: Load = None,
        damping: Damping | None = None,
        mass_redistribution: Sequence[str] = (),
        displacement: Field | None = None,
        velocity: Field | None = None,
        name: str = "deformable",
    ) -> None:
        checks.instance("mesh", mesh, NamedMesh, "a NamedMesh (mesh_from_gmsh, name_facets)")
        self.name, self.mesh, self.dim = checks.label("name", name), mesh, mesh.dim
        self.vectors = vector_space(mesh, degree, periodic)
        self.joined, self.degree = self.vectors.joined, self.vectors.degree
        self.comm, self.space = self.vectors.comm, self.vectors.space
        self.owned, self.unknowns = self.vectors.owned, self.vectors.unknowns
        checks.choice("plane", plane, self.planes if mesh.dim == 2 else self.planes[:1])
        self.plane = PLANES[plane]
        self.revolution = self.plane.revolution
        self.breadth = breadth = self.plane.breadth(ufl.SpatialCoordinate(mesh.mesh))
        motions = checks.mapping("prescribed", prescribed, "from locations to motions")
        tractions = checks.mapping("tractions", tractions, "from names of facets to tractions")
        springs = checks.mapping("springs", springs, "from locations to stiffness")
        self.supports = Supports(self.vectors, fixed, motions, self.plane.axis(self.vectors))
        self.fixed_unknowns, self.hold = self.supports.unknowns, self.supports.hold
        self.foundations = [Foundation(self.vectors, springs, breadth)] if springs else []
        holding = [self.supports.directions, *(f.directions for f in self.foundations)]
        self.supported = bool(np.any(holding))
        applied = tractions or body_force is not None
        self.applied = Loads(self.vectors, tractions, body_force, breadth) if applied else None
        self._pull = self.applied.total(0.0) if self.applied else np.zeros(self.owned)

        self.inertia = Mass(
            self.vectors, density, mass_redistribution, self.fixed_unknowns, breadth
        )
        self._mass, self.multiply = self.inertia.matrix, self.vectors.multiply
        self.mass, self._sum = self.inertia.total, self.vectors.sum
        self.massless = self.comm.allreduce(len(self.inertia.massless)) > 0
        self.weight = np.zeros(self.owned)
        self.parameters = f"density {self.inertia.told}{self.vectors.told}"
        held = {"fixed": fixed, "prescribed": motions}
        self.parameters += given(held | {"tractions": tractions, "body force": body_force})
        if gravity is not None:
            acceleration = checks.vector("gravity", gravity, mesh.dim)
            if self.revolution and acceleration[0]:
                raise checks.InputError(
                    f"gravity = {gravity!r}: must be along the axis of revolution, (0, g)"
                )
            self.parameters += f", gravity {acceleration.tolist()}"
            self.weight = self.inertia.weight(acceleration)

        self.damping = Rayleigh() if damping is None else damping
        checks.offers("damping", self.damping, Damping, "KelvinVoigt(eta), Rayleigh(alpha, beta)")
        for each in ("alpha", "beta"):
            checks.number(f"damping.{each}", getattr(self.damping, each), at_least=0)
        self.dampers = []
        self.parameters += "".join(f", springs {f.told}" for f in self.foundations)
        self.parameters += f", {quoted(damping)}" if damping else ""
        pieces = self.vectors.pieces.told
        self.parameters += pieces and f", {pieces}"
        self.remark = pieces and f"solid {self.name!r} is in {pieces}"
        if self.damping.alpha:
            self.dampers.append(MassDamper(self.damping.alpha, self.inertia))

        self.displacement = self.vectors.interpolate("displacement", displacement)
        self.displacement[self.fixed_unknowns] = self.supports.values(0.0)
        self.velocity = self.vectors.interpolate("velocity", velocity)
        self.velocity[self.fixed_unknowns] = 0.0
        self.trial_displacement = self.displacement.copy()
        self.trial_velocity = self.velocity.copy()
        self._force = np.zeros(self.owned)
        self._target: np.ndarray | None = None
        self._reaction = np.zeros(len(self.fixed_unknowns))
        self._momentum = self.inertia.times(self.velocity)

    def _begin(self) -> None:
        """Make the initial fields fit those behind a boundary without mass, and moving supports."""
        if self.massless:
            relax(
                np.setdiff1d(self.inertia.massless, self.fixed_unknowns),
                self.displacement,
                lambda u: self.internal_force(u) - self.weight - self._pull,
                self.stiffness,
                self.vectors.first,
            )
            self.trial_displacement = self.displacement.copy()
        if self.supports.moving:
            shortest = self.inertia.shortest_time(self.stiffness(self.displacement))
            self.velocity[self.fixed_unknowns] = self.supports.starting_speed(shortest)
            self.trial_velocity = self.velocity.copy()
            self._momentum = self.inertia.times(self.velocity)
        self._state_changed()

    def gradient(self, field: Any) -> Any:
        """Gradient of a field in UFL, with what is across the mesh where that deforms, too."""
        return self.plane.gradient(field, ufl.SpatialCoordinate(self.mesh.mesh))

    @abstractmethod
    def stiffness(self, displacement: np.ndarray) -> PETSc.Mat:
        """Derivative of the internal forces at a displacement; the solid keeps the matrix."""

    @abstractmethod
    def strain_energy(self) -> float:
        """Strain energy of the state, J."""

    @abstractmethod
    def _state_changed(self) -> None:
        """The state is new: refresh what is kept from step to step."""

    def predict(self, step: Step) -> None:
        self.memory = step.recall(self.memory, lambda: self._force_at_start(step))
        self.trial_velocity = self.velocity.copy()
        self._target = None
        if self.supports.moving and step.loaded:
            with checks.asked_at(step.end):
                self._target = self.supports.values(step.end)
                late, way = step.implicitness, self._target - self.displacement[self.fixed_unknowns]
                speed = late * way / step.span
                if late < 1:
                    speed += (1 - late) * self.supports.speed(step.end, -step.span)
            self.trial_velocity[self.fixed_unknowns] = speed
        self._move(step)

    def _move(self, step: Step) -> None:
        increment = step.increment(self.velocity, self.trial_velocity, self.memory)
        self.trial_displacement = self.displacement + increment
        if self._target is not None:
            self.trial_displacement[self.fixed_unknowns] = self._target

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

    def accept(self, step: Step) -> None:
        self.memory = step.remember(self.velocity, self.trial_velocity, self._acting, self.memory)
        self.velocity = self.trial_velocity.copy()
        self.displacement = self.trial_displacement
        self._momentum = self._trial_momentum
        self._state_changed()

    def energies(self) -> tuple[float, float, float]:
        kinetic = 0.5 * self._sum(self.velocity @ self._momentum)
        return kinetic, self.strain_energy(), -self._sum(self.weight @ self.displacement)

    def drift(self) -> tuple[float, np.ndarray] | None:
        at_rest = self.supported or self.revolution or self.damping.alpha  # something is
        momentum = self._momentum.reshape(-1, self.dim).sum(axis=0)
        return None if at_rest else (self.mass, self.comm.allreduce(momentum))

    def root_mean_square(self, velocity: np.ndarray) -> float:
        return self.inertia.root_mean_square(velocity)

    def trace(self, points: np.ndarray, means: Any = None, facets: str = "") -> DeformableTrace:
        """The solid seen from points (N, d), nodes of the named facets if any are, or from means of
        them by a sparse matrix (n, N)."""
        return DeformableTrace(self, points, means, facets)

    def twins(self, points: np.ndarray) -> np.ndarray:
        """Which of these nodes stands for each, see :meth:`~.vector_space.VectorSpace.twins`."""
        return self.vectors.twins(points)

    def state(self) -> dict[str, np.ndarray]:
        state = {"displacement": self.displacement, "velocity": self.velocity}
        return {**state, "momentum": self._momentum, **self.memories()}  # no M v without inertia

    def restore(self, state: dict[str, np.ndarray]) -> None:
        self.displacement = np.array(state["displacement"])
        self.velocity = np.array(state["velocity"])
        self.trial_displacement = self.displacement.copy()
        self.trial_velocity = self.velocity.copy()
        self._momentum = np.array(state.get("momentum", self.inertia.times(self.velocity)))
        self.memory = state.get("memory")
        self._state_changed()

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Mean over the mass of a field given by its owned unknowns, (d,): of a velocity, m/s."""
        return self.inertia.mean(values)

    def fields(self) -> dict[str, np.ndarray]:
        at_mesh = self.vectors.at_mesh
        return {"displacement": at_mesh(self.displacement), "velocity": at_mesh(self.velocity)}
