# SPDX-License-Identifier: LGPL-3.0-or-later
"""Parameters of materials, which stand in UFL and are differentiated there."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from ..base import assembly, checks, compat
from ..base.compiling import compiled
from ..base.constants import SAME
from ..base.quoted import quoted
from ..solids import DeformableSolid, ElasticSolid, HyperelasticSolid, Solid
from ..solids.coefficients import of_a_field
from ..solids.energies import Energy, deformation
from ..solids.viscous import ViscousStress
from ..theory.scheme import Step
from .dampings import damping
from .parameters import OfSolid


class Modulus(OfSolid):
    """A modulus of an elastic solid.

    Args:
        solid: the solid.
        name: ``"youngs_modulus"`` or ``"poisson_ratio"``, where that is a number or a
            ``fem.Constant``; or a ``fem.Constant``, wherever it stands in the two.

    Raises:
        InputError: no such number stands in a modulus, or another solid.
    """

    def __init__(self, solid: ElasticSolid, name: Any = "youngs_modulus") -> None:
        checks.instance("solid", solid, ElasticSolid, "an ElasticSolid; see Material")
        self.solid: ElasticSolid = solid
        moduli = dict(solid.moduli)
        asked = isinstance(name, str)
        value = moduli.get(name) if asked else solid.kept.get(name, name)
        fits = isinstance(value, (float, fem.Constant) if asked else fem.Constant)
        if not fits or np.ndim(checks.plain(value)):
            given = f"Modulus: name = {quoted(name)}"
            raise checks.InputError(f"{given}: must be a number among {moduli}")
        number = _number(solid, float(checks.plain(value)))
        if asked:
            moduli[name] = number
            form = solid.stiffness_form(*moduli.values())
        else:
            form = ufl.replace(solid.stiffness_form(*moduli.values()), {value: number})
        derivative = ufl.algorithms.expand_derivatives(ufl.derivative(form, number, _one(number)))
        if derivative.empty():
            raise checks.InputError(f"Modulus: {name} stands in no modulus of {solid.name!r}")
        self._matrix = assembly.assemble_petsc_matrix(derivative)

    def internal(self, solid: Solid, displacement: np.ndarray) -> np.ndarray | float:
        if solid is not self.solid:
            return 0.0
        return self.solid.multiply(self._matrix, displacement)

    def damped(self, solid: DeformableSolid, step: Step) -> np.ndarray | float:
        rate = step.rate(solid.velocity, solid.trial_velocity)
        return solid.damping.beta * self.internal(solid, rate)


class Damped(OfSolid):
    """A number of the damping of a deformable solid.

    Args:
        solid: the solid.
        name: ``"alpha"`` or ``"beta"``, which is the eta of
            :class:`~fenicsx_contact.solids.damping.KelvinVoigt`.

    Raises:
        InputError: another solid, or one that has no such damping.
    """

    def __init__(self, solid: DeformableSolid, name: str) -> None:
        checks.instance("solid", solid, DeformableSolid, "a deformable solid")
        self.solid: DeformableSolid = solid
        self._name = checks.choice("name", name, ["alpha", "beta"])
        self._value = float(getattr(solid.damping, name))
        if not self._value:
            raise checks.InputError(f"Damped: solid {solid.name!r} has no {name}: {solid.damping}")

    def damped(self, solid: DeformableSolid, step: Step) -> np.ndarray | float:
        return damping(solid, step, self._name) / self._value if solid is self.solid else 0.0


class Material(OfSolid):
    """A number of the stored energy of a hyperelastic solid.

    Args:
        solid: the solid.
        energy: from the number, in UFL, to the solid's energy, such as
            ``lambda E: neo_hookean(E, 0.3)``.
        value: the number.

    Raises:
        InputError: with this value it is not the energy of the solid.
    """

    def __init__(
        self, solid: HyperelasticSolid, energy: Callable[[Any], Energy], value: float
    ) -> None:
        checks.instance("solid", solid, HyperelasticSolid, "a HyperelasticSolid; see Modulus")
        self.solid: HyperelasticSolid = solid
        self._u = fem.Function(solid.space)
        number = _number(solid, checks.number("value", value))
        checks.function("energy", energy, " of the number")
        made = checks.called("energy", energy, number)
        energy_of = solid.plane.energy(checks.function("energy(value)", made, " of F, in UFL"))
        F = deformation(solid.gradient(self._u))
        density = of_a_field("energy(value)", energy_of, F, solid.mesh)
        potential = solid.breadth * density * solid.volume
        test = ufl.TestFunction(solid.space)
        force = ufl.derivative(potential, self._u, test)
        self._form = compiled(ufl.derivative(force, number, _one(number)))
        self._viscous: ViscousStress | None = None
        if solid.damping.beta:
            beta = solid.damping.beta
            self._viscous = ViscousStress(solid, energy_of, beta, solid.volume)
            viscous = ufl.derivative(self._viscous.form, number, _one(number))
            self._viscous_form = compiled(viscous)
        # a small strain tells materials apart that is another in each direction; at an axis none
        i = np.arange(1, solid.dim + 1)
        stretch = np.tril(1 / (i[:, None] + 2 * i))
        strained = 1e-3 * (solid.vectors.places @ stretch.T).ravel()
        solid.vectors.assign(self._u, strained)
        mine, theirs = np.empty((2, solid.owned))
        assembly.assemble_owned(compiled(force), mine)
        theirs = solid.internal_force(strained)
        theirs -= sum((f.times(strained) for f in solid.foundations), np.zeros(solid.owned))
        if np.abs(mine - theirs).max() > SAME * np.abs(theirs).max():
            raise checks.InputError(f"Material: {value:g} does not make the energy of the solid")

    def internal(self, solid: Solid, displacement: np.ndarray) -> np.ndarray | float:
        if solid is not self.solid:
            return 0.0
        self.solid.vectors.assign(self._u, displacement)
        return self._assembled(self._form)

    def damped(self, solid: DeformableSolid, step: Step) -> np.ndarray | float:
        if solid is not self.solid or self._viscous is None:
            return 0.0
        share, rate = step.force_share, step.rate(solid.velocity, solid.trial_velocity)
        place = share * solid.trial_displacement + (1 - share) * solid.displacement
        self._viscous.set(place, rate)
        return self._assembled(self._viscous_form)

    def _assembled(self, form: Any) -> np.ndarray:
        force = np.empty(self.solid.owned)
        assembly.assemble_owned(form, force)
        return force


def _number(solid: DeformableSolid, value: float) -> Any:
    """A number as a field, by which UFL can differentiate."""
    number = fem.Function(compat.cellwise_space(solid.mesh.mesh))
    number.x.array[:] = value
    return number


def _one(number: Any) -> Any:
    one = fem.Function(number.function_space)
    one.x.array[:] = 1.0
    return one
