# SPDX-License-Identifier: LGPL-3.0-or-later
"""Hyperelastic solids: any stored energy in UFL, finite strain, same scene and contact.

Each linearisation is a Newton step of the solid; the scene's outer loop repeats it with the contact
until momentum is balanced. The scheme says where on a step's way the internal forces are taken: at
theta = 1/2 their mean conserves the energy, and the angular momentum to second order (the midpoint
has it the other way round); the energy-momentum scheme keeps both.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from ..base import assembly, checks, compat
from ..base.compiling import compiled
from ..base.constants import MADE, ROUND_OFF
from ..base.mesh import NamedMesh
from ..base.shown import worded
from ..base.signatures import whole
from ..base.told import name_of, written
from ..theory.scheme import Step
from .coefficients import of_a_field
from .damping import StiffnessDamper, damped_springs
from .deformable import DeformableSolid
from .energies import Energy, deformation, tangent
from .factor import Factorisation
from .planes import PLANES
from .strain_way import StrainWay
from .turning import Turning
from .viscous import ViscousStress

#: Cost: the share of the error that each correction by an old tangent may leave.
RATE = 0.1


@whole
class HyperelasticSolid(DeformableSolid):
    """A hyperelastic solid; in 2D in plane strain, plane stress, or of revolution.

    Args:
        mesh: its shape.
        energy: stored energy density, :func:`~fenicsx_contact.solids.energies.neo_hookean` (E, nu)
            say. What it stores as a Constant in it changes in a run is counted as of the scheme.
        plane: as of :class:`~.elastic.ElasticSolid`; ``"stress"`` of energies with ``across``.
        others: as for :class:`~fenicsx_contact.solids.deformable.DeformableSolid`.
    """

    linear = False
    planes = tuple(PLANES)
    distributed = (*DeformableSolid.distributed, "tangent.start", "tangent.end")

    def __init__(
        self, mesh: NamedMesh, *, energy: Energy, name: str = "hyperelastic", **others: Any
    ) -> None:
        checks.function("energy", energy, " of F, in UFL")
        super().__init__(mesh, name=name, **others)
        self._energy, self._given = self.plane.energy(energy), energy
        self._field = u = fem.Function(self.space)
        v, du = ufl.TestFunction(self.space), ufl.TrialFunction(self.space)
        F = deformation(self.gradient(u))
        self.volume = ufl.dx(mesh.mesh, degree=2 * self.degree + self.revolution)
        density = of_a_field("energy", self._energy, F, mesh)
        potential = self.breadth * density * self.volume
        residual = ufl.derivative(potential, u, v)
        self.parameters += written(f", energy {name_of(energy)}", density)
        self._volume_ratio = compat.PointExpression(ufl.det(F), compat.lagrange_space(mesh.mesh))
        self._potential_form = compiled(potential)
        self._force_form = compiled(residual)
        self._weight = fem.Constant(mesh.mesh, 1.0)
        self._tangent_form = compiled(self._weight * tangent(energy, residual, u, du))
        # force and energy are kept with the displacement that they belong to, that very array
        self._last, self._stored = (np.empty(0), np.empty(0)), (np.empty(0), 0.0)
        self._tangent = assembly.assemble_petsc_matrix(self._tangent_form)
        swelling = self.vectors.places.ravel()  # energies are differences of what it would store
        self._noise = ROUND_OFF * abs(self._sum(swelling @ self.multiply(self._tangent, swelling)))
        self.grain = mesh.grain
        if beta := self.damping.beta:
            self.dampers.append(ViscousStress(self, self._energy, beta, self.volume))
            self.dampers += [StiffnessDamper(beta, f.matrix, f.times) for f in damped_springs(self)]
        self._turning = Turning(self, self._energy, self.volume)
        self._factor: Factorisation | None = None
        self._made = False  # a tangent in this step
        self._free_load: np.ndarray | None = None
        # the way of the step whose tangent is to be used, and that of the one which was factored
        self._way = self._taken = np.zeros(self.owned), np.zeros(self.owned)
        self._key: tuple[float, ...] = ()
        self._errors: list[float] = []
        self._predicted = self.trial_velocity
        if self.broken():
            raise checks.InputError(
                f"displacement, prescribed: as the run begins an element of solid {self.name!r} is "
                "inverted; det(1 + grad u) must be > 0; what is prescribed may grow with t"
            )
        self._begin()

    def cauchy(self, displacement: Any) -> Any:
        F = ufl.variable(deformation(self.gradient(displacement)))
        return ufl.diff(self._energy(F), F) * F.T / ufl.det(self.plane.stretched(self._given, F))

    def _set(self, displacement: np.ndarray) -> None:
        self.vectors.assign(self._field, displacement)

    def internal_force(self, displacement: np.ndarray) -> np.ndarray:
        self._set(displacement)
        force = np.empty(self.owned)
        assembly.assemble_owned(self._force_form, force)
        for foundation in self.foundations:
            force += foundation.times(displacement)
        return force

    def _internal_forces(self, step: Step) -> np.ndarray:
        start, end = self.displacement, self.trial_displacement
        if self._last[0] is not end:
            if step.along_strain:
                force = self._strain_way.force(step, start, end)
                force += sum(f.times(step.linear_mean(start, end)) for f in self.foundations)
            else:
                force = step.mean_force(lambda s: self.internal_force(s * end + (1 - s) * start))
            self._last = end, force
        return self._last[1]

    @cached_property
    def _strain_way(self) -> StrainWay:
        return StrainWay(self, self._energy, self.volume)

    @property
    def symmetric(self) -> bool:  # type: ignore[override]
        """Whether the matrix of the step is."""
        return not self._linearised[0].along_strain

    def _stored_energy(self, displacement: np.ndarray) -> float:
        self._set(displacement)
        stored = assembly.assemble_scalar(self._potential_form, self.comm)
        for foundation in self.foundations:
            stored += 0.5 * self._sum(displacement @ foundation.times(displacement))
        return stored

    @property
    def last_stiffness(self) -> PETSc.Mat:
        if not self._made:
            self._make_tangent()
        return self._tangent

    def stiffness(self, displacement: np.ndarray) -> PETSc.Mat:
        self._tangent.zeroEntries()
        self.add_stiffness(self._tangent, displacement, 1.0)
        return self._tangent

    def add_stiffness(self, matrix: PETSc.Mat, displacement: np.ndarray, weight: float) -> None:
        """Add the weighted stiffness at a displacement to a matrix of its pattern."""
        self._set(displacement)
        self._weight.value = weight
        assembly.add_to_petsc_matrix(matrix, self._tangent_form)
        for foundation in self.foundations:
            foundation.add_to(matrix, weight)

    def _choose_tangent(self, step: Step) -> None:
        """The matrix of the step: an old one if it will do, else that of the trial state. It is
        made when it is first asked for: the last state of a step needs none."""
        key = (step.inertia_rate, step.gap_rate)
        slow = len(self._errors) > 1 and self._errors[-1] > RATE * self._errors[-2]
        if slow or not self.patient or not step.scheme.inertia or key != self._key:
            self._way = self.displacement, self.trial_displacement
        if self._way is not self._taken:
            self._key = key
            self.linearisation += 1
        self._linearised = step, self.trial_velocity

    def _make_tangent(self) -> None:
        """Assemble the matrix that was chosen."""
        self._made = True
        if self._way is self._taken:
            return
        (step, _), self._taken = self._linearised, self._way
        start, end = self._way
        self._tangent.zeroEntries()
        if step.along_strain:
            self._strain_way.add_tangent(self._tangent, step, start, end)
            for foundation in self.foundations:
                foundation.add_to(self._tangent, step.scheme.linear_weights[1])
        else:
            for share, weight in step.scheme.force_points:
                if share:
                    place = share * end + (1 - share) * start
                    self.add_stiffness(self._tangent, place, weight * share)
        if self._factor is None:
            self._factor = self.factored(self._tangent.copy(), step)
        matrix, structure = self._factor.matrix, PETSc.Mat.Structure
        self._tangent.copy(matrix, structure.SAME_NONZERO_PATTERN)
        matrix.scale(step.gap_rate)
        if step.scheme.inertia:
            matrix.axpy(step.inertia_rate, self._mass, structure.SUBSET_NONZERO_PATTERN)
        for damper in self.dampers:
            damper.add_to(matrix, step, start, end)
        self.hold(matrix)
        self._factor.refactor(self.resisting(step))

    @property
    def factorisation(self) -> Factorisation:  # type: ignore[override]
        """That of the matrix of the step."""
        self._make_tangent()
        assert self._factor is not None
        return self._factor

    @property
    def free_load(self) -> np.ndarray:  # type: ignore[override]
        """b of ``A v+ = b + J' f``, from ``A v+ = A v - r(v) + J' f``."""
        if self._free_load is None:
            velocity = self._linearised[1]
            load = self.multiply(self.factorisation.matrix, velocity) - self._residual
            load[self.fixed_unknowns] = velocity[self.fixed_unknowns]
            self._free_load = load
        return self._free_load

    def residual(self) -> np.ndarray:
        result = self._residual - self._force
        result[self.fixed_unknowns] = 0.0
        return result

    def predict(self, step: Step) -> None:
        self._errors, self._made = [1.0], False
        super().predict(step)
        self._predicted = self.trial_velocity
        if self._target is not None and step.gap_rate and self.broken():
            self._follow_supports(step)

    def _follow_supports(self, step: Step) -> None:
        """Let the solid yield elastically to its supports, which alone would invert elements."""
        held, way = self.fixed_unknowns, np.zeros(self.owned)
        way[held] = self._target - self.displacement[held]
        tangent = self.stiffness(self.displacement)
        pull = -self.multiply(tangent, way)
        pull[held] = way[held]
        factor = Factorisation(self.hold(tangent.copy()), self.name)
        increment = factor.solve(pull)
        factor.destroy()
        self.go((increment - step.drift(self.velocity, self.memory)) / step.gap_rate, step)

    def linearise(self, step: Step) -> None:
        self._choose_tangent(step)
        self._force = np.zeros(self.owned)
        self._residual = np.sum(self._balance(step), axis=0)
        self._free_load = self._free_velocity = None

    def imbalance(self, step: Step, noise: float = 0.0) -> float:
        error = super().imbalance(step, noise)
        if self.trial_velocity is not self._predicted:  # else nothing has been corrected yet
            self._errors.append(error)
        return error

    def state(self) -> dict[str, np.ndarray]:
        start, end = self._way
        tangent = {"tangent.key": np.array(self._key), "tangent.start": start, "tangent.end": end}
        return {**super().state(), **tangent}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        self._way = state["tangent.start"], state["tangent.end"]
        self._key = tuple(float(value) for value in state["tangent.key"])
        super().restore(state)

    def _state_changed(self) -> None:
        if self._stored[0] is not self.displacement:
            self._stored = self.displacement, self._stored_energy(self.displacement)
        self._strain = self._stored[1]

    def strain_energy(self) -> float:
        return self._strain

    def unsound(self, step: Step) -> str:
        """No more may be stored than the forces at some points of the way give and the scheme takes
        but for what they give too little where it turns, and what changed coefficients store."""
        if not step.loaded or not step.scheme.bounds_work:
            return ""
        end = self.trial_displacement
        self._stored = end, self._stored_energy(end)
        work = self._sum(self._internal_forces(step) @ (end - self.displacement))
        made = self._stored[1] - self._strain - work - self.taken(step)
        moving = max(self._sum(self.trial_velocity @ self._trial_momentum) / 2, self.energies()[0])
        size = moving + max(self._strain, self._stored[1])
        allowed, ahead = MADE * size + self._noise, step.force_share - 0.5
        if made > allowed and ahead > 0:
            made += min(self._turning.work(ahead, self.displacement, end), 0.0)
        if made > allowed:
            made += self._strain - self._stored_energy(self.displacement)
        told = f"solid {self.name!r} strains too much in a step: it would make {made:.3g} J"
        return told if made > allowed else ""

    def broken(self) -> str:
        self._set(self.trial_displacement)
        worst = min(self.comm.allgather(float(self._volume_ratio().min(initial=1.0))))
        return "" if worst > 0 else f"an element of solid {self.name!r} is inverted"

    def describe(self) -> str:
        return f"hyperelastic, {self.plane.name}{worded(self.parameters)}, {self.unknowns} unknowns"
