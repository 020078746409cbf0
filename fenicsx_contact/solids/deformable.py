# SPDX-License-Identifier: LGPL-3.0-or-later
"""What every deformable solid is: a displacement field on a mesh, with mass, load and supports.

The mesh may be distributed: arrays hold the unknowns that a process owns, and only surface data
travel between processes.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from .. import checks, compat
from ..linear import Factorisation
from ..meshing import NamedMesh
from ..theta import Step
from .base import Solid
from .deformable_trace import DeformableTrace
from .redistribution import move_mass_inwards, relax

#: A field given as a function of ``x`` (3, n) with values (d, n).
Field = Callable[[np.ndarray], np.ndarray]


class DeformableSolid(Solid):
    """A solid with a displacement field; see its two kinds.

    Args:
        mesh: its shape.
        density: kg/m³.
        degree: of the displacement, 1 or 2.
        gravity: acceleration, d numbers, m/s².
        fixed: names of facets held fast.
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
        self._bcs = self._supports(fixed)

        u, v = ufl.TrialFunction(self.space), ufl.TestFunction(self.space)
        self._dx = ufl.Measure("dx", domain=mesh.mesh)
        rho = fem.Constant(mesh.mesh, density)
        self._mass = self._assemble(rho * ufl.dot(u, v) * self._dx, diagonal=1.0)
        self._x, self._y = self._mass.createVecs()
        massless = self._nodes(mass_redistribution)
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
            self._load[self.fixed_unknowns] = 0.0

        self.displacement = self._initial("displacement", displacement)
        self.velocity = self._initial("velocity", velocity)
        self.trial_displacement = self.displacement.copy()
        self.trial_velocity = self.velocity.copy()
        self._force = np.zeros(self.owned)
        self._momentum = self.multiply(self._mass, self.velocity)
        self.linearisation = 0  # counts the changes of A, for those who keep columns of A^-1

    def _nodes(self, names: Sequence[str]) -> np.ndarray:
        """The nodes of the named facets that this process owns."""
        blocks = [np.empty(0, dtype=np.int32)]
        for name in [names] if isinstance(names, str) else names:
            facets = self.mesh.facets(name)
            blocks.append(fem.locate_dofs_topological(self.space, self.dim - 1, facets))
        nodes = np.unique(np.concatenate(blocks))
        return nodes[nodes < self.owned // self.dim]

    def _supports(self, names: Sequence[str]) -> list[Any]:
        zero = fem.Function(self.space)
        bcs = []
        for name in [names] if isinstance(names, str) else names:
            facets = self.mesh.facets(name)
            dofs = fem.locate_dofs_topological(self.space, self.dim - 1, facets)
            bcs.append(fem.dirichletbc(zero, dofs))
        nodes = self._nodes(names)
        self.fixed_unknowns = (nodes[:, None] * self.dim + np.arange(self.dim)).ravel()
        self.supported = self.comm.allreduce(len(nodes)) > 0
        return bcs

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
        values[self.fixed_unknowns] = 0.0
        return values

    def _assemble(self, form: ufl.Form, diagonal: float) -> PETSc.Mat:
        return compat.assemble_petsc_matrix(form, self._bcs, diagonal)

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
                lambda u: self.internal_force(u) - self._load,
                self.stiffness,
                self.first_unknown,
            )
            self.trial_displacement = self.displacement.copy()

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
        self._move(step)

    def _move(self, step: Step) -> None:
        increment = step.scheme.increment(step.dt, self.velocity, self.trial_velocity)
        self.trial_displacement = self.displacement + increment

    def _force_point(self, step: Step) -> np.ndarray:
        """The displacement at which the scheme takes the internal forces."""
        weight = step.scheme.force_weight
        return weight * self.trial_displacement + (1 - weight) * self.displacement

    def free_velocity(self) -> np.ndarray:
        """Velocity at the end of the step if no contact acted."""
        if self._free_velocity is None:
            self._free_velocity = self.factorisation.solve(self.free_load)
        return self._free_velocity

    def correct(self, step: Step) -> None:
        self.trial_velocity = self.factorisation.solve(self.free_load + self._force)
        self._move(step)

    def accept(self) -> None:
        self.velocity = self.trial_velocity.copy()
        self.displacement = self.trial_displacement
        self._momentum = self._trial_momentum
        self._state_changed()

    def works(self, step: Step) -> tuple[float, float]:
        mean = 0.5 * (self.velocity + self.trial_velocity)
        self._trial_momentum = self.multiply(self._mass, self.trial_velocity)
        internal = self.internal_force(self._force_point(step))
        return (
            self._sum(mean @ (self._trial_momentum - self._momentum)),
            self._sum(step.dt * mean @ (self._load - internal)),
        )

    def energies(self) -> tuple[float, float, float]:
        kinetic = 0.5 * self._sum(self.velocity @ self._momentum)
        return kinetic, self.strain_energy(), -self._sum(self._load @ self.displacement)

    def trace(self, points: np.ndarray) -> DeformableTrace:
        return DeformableTrace(self, points)

    def state(self) -> dict[str, np.ndarray]:
        return {"displacement": self.displacement, "velocity": self.velocity}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        self.displacement = np.array(state["displacement"])
        self.velocity = np.array(state["velocity"])
        self.trial_displacement = self.displacement.copy()
        self.trial_velocity = self.velocity.copy()
        self._momentum = self.multiply(self._mass, self.velocity)
        self._state_changed()

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Mean of a field over the mass, (d,), from its owned unknowns: of the displacement [m],
        that of the centre of mass; of the velocity [m/s], momentum over mass."""
        weighted, total = self.multiply(self._mass, values), np.zeros(self.dim)
        uniform = np.zeros(self.owned)
        uniform[:: self.dim] = 1.0
        for k in range(self.dim):
            total[k] = self._sum(weighted[k :: self.dim].sum())
        return total / self._sum(uniform @ self.multiply(self._mass, uniform))

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
