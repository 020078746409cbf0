# SPDX-License-Identifier: LGPL-3.0-or-later
"""Linear elastic solids of small strain and rotation.

Mass and stiffness are assembled once; the matrix of a step, ``A = M/dt + force_rate K``, is
factored once for each step length.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from petsc4py import PETSc

from ..base import assembly
from ..base.constants import KEPT
from ..base.mesh import NamedMesh
from ..base.shown import worded
from ..base.signatures import whole
from ..base.vectors import largest
from ..theory.scheme import Step
from .coefficients import Scalar, constant, scalar
from .damping import StiffnessDamper, damped_springs
from .deformable import DeformableSolid
from .energies import in_space
from .factor import Factorisation
from .foundation import Foundation
from .motions import FREE, Motions
from .planes import PLANES


def hooke(lmbda: Any, mu: Any, strain: Any) -> Any:
    """Stress of a strain, (k, k), in UFL."""
    return 2 * mu * strain + lmbda * ufl.tr(strain) * ufl.Identity(strain.ufl_shape[0])


@whole
class ElasticSolid(DeformableSolid):
    """A linear elastic solid; in 2D in plane strain, in plane stress, or of revolution.

    Args:
        mesh: its shape.
        youngs_modulus: E, Pa: a number, ``fem.Constant``, ``fem.Function``, expression in UFL, or
            function of x, see :mod:`~.coefficients`.
        poisson_ratio: nu, in (-1, 1/2), likewise.
        plane: in 2D ``"strain"``, ``"stress"`` (both 1 m thick) or ``"axisymmetric"``: x is the
            radius, y the axis; forces, energies and masses are those of the whole solid.
        others: as for :class:`~fenicsx_contact.solids.deformable.DeformableSolid`.

    Attributes:
        moduli: the two by name: numbers, or UFL that stays as it was then.
        kept: what stands there for the Constants and Functions that were given, by these.

    Raises:
        InputError: numbers out of range, a name that the mesh lacks.
    """

    linear = True
    planes = tuple(PLANES)

    def __init__(
        self,
        mesh: NamedMesh,
        *,
        youngs_modulus: Scalar,
        poisson_ratio: Scalar,
        name: str = "elastic",
        **others: Any,
    ) -> None:
        super().__init__(mesh, name=name, **others)
        self.kept: dict[Any, Any] = {}
        E, modulus = scalar("youngs_modulus", youngs_modulus, mesh, self.kept, above=0)
        nu, ratio = scalar("poisson_ratio", poisson_ratio, mesh, self.kept, above=-1, below=0.5)
        self.moduli = {"youngs_modulus": E, "poisson_ratio": nu}
        self.parameters = f"E {modulus}, nu {ratio}, {self.parameters}"
        self._stiffness = assembly.assemble_petsc_matrix(self.stiffness_form(E, nu))
        damped = self._stiffness
        if self.foundations and not damped_springs(self):
            damped = self._stiffness.copy()
        for foundation in self.foundations:
            foundation.add_to(self._stiffness, 1.0)
        pulling = damped_springs(self)
        if beta := self.damping.beta:
            self.dampers.append(
                StiffnessDamper(beta, damped, lambda v: self._resists(damped, v, pulling))
            )
        resisted = np.isin(np.arange(self.dim), list(self.plane.resisted))
        # directions that strain nothing
        self._drifting = np.array(~(resisted | self.supports.directions), dtype=float)
        self._factors: dict[tuple[float, ...], tuple[int, Factorisation]] = {}
        self._made = 0
        self._begin()

    def stiffness_form(self, E: Any, nu: Any) -> ufl.Form:
        """The stiffness of a solid of these moduli, a bilinear form."""
        lmbda, mu = (constant(self.mesh, value) for value in self.plane.lame(E, nu))
        u, v = ufl.TrialFunction(self.space), ufl.TestFunction(self.space)
        strain, virtual = (ufl.sym(self.gradient(w)) for w in (u, v))
        stress = hooke(lmbda, mu, strain)
        return self.breadth * ufl.inner(stress, virtual) * ufl.dx(self.mesh.mesh)

    def cauchy(self, displacement: Any) -> Any:
        lmbda, mu = (constant(self.mesh, m) for m in self.plane.lame(*self.moduli.values()))
        strain = ufl.sym(self.gradient(displacement))
        return in_space(hooke(lmbda, mu, strain), self.plane.across(lmbda, strain))

    def _state_changed(self) -> None:
        self._internal = self.internal_force(self.displacement)

    def predict(self, step: Step) -> None:
        super().predict(step)
        self._linearised: Step | None = None

    def linearise(self, step: Step) -> None:
        self.drop_forces()
        if step is self._linearised:  # one linearisation serves a step
            return
        self._linearised = step
        key = (step.inertia_rate, step.force_rate, step.rate_weight)
        if key not in self._factors:
            if len(self._factors) >= KEPT:
                self._factors.pop(next(iter(self._factors)))[1].destroy()
            matrix = self._mass.copy()
            matrix.scale(step.inertia_rate)
            matrix.axpy(step.force_rate, self._stiffness)
            for damper in self.dampers:
                damper.add_to(matrix, step, self.displacement, self.displacement)
            self._made += 1
            factor = self.factored(self.hold(matrix), step)
            self._factors[key] = (self._made, factor)
        self._factors[key] = self._factors.pop(key)  # the last to be dropped
        self.linearisation, self.factorisation = self._factors[key]
        self.free_load = step.inertia_rate * self._momentum
        if self.supports.moving:  # in an impact, too
            self._drive(step)
        if step.loaded:
            drift = step.drift(self.velocity, self.memory)
            before, after = step.scheme.linear_weights
            self.free_load += self._loads(step) - (before + after) * self._internal
            if after:  # not where the drift vanishes: every process must take part
                self.free_load -= after * self.internal_force(drift)
            for damper in self.dampers:
                known = np.zeros(self.owned)
                known[self.fixed_unknowns] = self.trial_velocity[self.fixed_unknowns]
                self.free_load -= self._damping(damper, step, step.rate(self.velocity, known))
        self.free_load[self.fixed_unknowns] = self.trial_velocity[self.fixed_unknowns]
        self._free_velocity = None

    def _drive(self, step: Step) -> None:
        """What the motion of the supports pulls along."""
        held, after = self.fixed_unknowns, step.scheme.linear_weights[1]
        speed, way = np.zeros(self.owned), np.zeros(self.owned)
        speed[held] = step.inertia_rate * self.trial_velocity[held]
        self.free_load -= self.multiply(self._mass, speed)
        if self._target is not None:
            drift = step.drift(self.velocity, self.memory)
            way[held] = after * (self._target - self.displacement[held] - drift[held])
            self.free_load -= self.multiply(self._stiffness, way)

    @property
    def last_stiffness(self) -> PETSc.Mat:
        return self._stiffness

    def stiffness(self, displacement: np.ndarray) -> PETSc.Mat:
        return self._stiffness

    def internal_force(self, displacement: np.ndarray) -> np.ndarray:
        return self._resists(self._stiffness, displacement, self.foundations)

    def _resists(
        self, stiffness: PETSc.Mat, field: np.ndarray, springs: list[Foundation]
    ) -> np.ndarray:
        """The stiffness times a field, without what a translation costs it: of that springs to
        ground among it alone know."""
        strained = self._strained(field)
        force = self.multiply(stiffness, strained)
        return force + self._springs(field - strained) if springs else force

    def _internal_forces(self, step: Step) -> np.ndarray:
        return self.internal_force(step.linear_mean(self.displacement, self.trial_displacement))

    def _strained(self, displacement: np.ndarray) -> np.ndarray:
        """The displacement less a translation, which strains nothing but costs K u its digits."""
        if not self._drifting.any():
            return displacement
        own = displacement[: self.dim] if self.owned else np.zeros(self.dim)
        first = self.comm.bcast(own) if self.comm.size > 1 else own
        return (displacement.reshape(-1, self.dim) - first * self._drifting).ravel()

    def strain_energy(self) -> float:
        return 0.5 * self._sum(self.displacement @ self._internal)

    def swollen(self, most: float) -> str:
        """What a reader should know of a solid that has turned so far that it swells by more than a
        share of its size, ``|X + theta x X| = sqrt(1 + theta²) |X|``; or nothing."""
        motions, d = Motions(self), self.dim
        turns = np.arange(len(motions.names)) % motions.each >= d
        if largest(motions.free()[turns]) <= FREE:  # held
            return ""
        turned = largest(np.linalg.norm(motions.amounts(self.displacement)[:, d:], axis=1))
        if (swells := np.hypot(1.0, turned) - 1) <= most:
            return ""
        return (
            f"solid {self.name!r} has turned by {turned:.3g} rad: of small strain, it swells by "
            f"that, by {swells:.2g} of its size, and presses on what it meets; a HyperelasticSolid "
            "does not"
        )

    def describe(self) -> str:
        kind = f"small strain, {self.plane.name}{worded(self.parameters)}"
        return f"elastic, {kind}, {self.unknowns} unknowns"
