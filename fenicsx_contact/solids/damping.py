# SPDX-License-Identifier: LGPL-3.0-or-later
"""Damping of deformable solids: what a solid loses, and the dampers that it then has.

A damper's force is linear in a velocity, its matrix symmetric and never negative, so what it takes
from the mean velocity of a step is a loss, whatever the scheme. Without damping a solid has no
damper, and nothing of this file is computed. Statics know no velocity, and so no damping.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Protocol, TypeVar, runtime_checkable

import numpy as np
from petsc4py import PETSc

from ..base import checks
from ..theory.scheme import Step
from .mass import Mass

T = TypeVar("T")


@runtime_checkable
class Damping(Protocol):
    """How a solid is damped: a class of your own needs these and a ``repr`` with its parameters.
    Where it says ``of_springs = False`` springs to ground are not among K."""

    @property
    def alpha(self) -> float:
        """Of a force ``alpha M v``, 1/s."""

    @property
    def beta(self) -> float:
        """Of a force ``beta K v``, s, springs to ground among K; of a hyperelastic solid see
        :class:`KelvinVoigt`."""


class OnSprings(Protocol[T]):
    """A solid that is damped, on springs to ground."""

    damping: Damping
    foundations: list[T]


def damped_springs(solid: OnSprings[T]) -> list[T]:
    """The springs to ground that what it takes by the stiffness counts: all or none."""
    return solid.foundations if getattr(solid.damping, "of_springs", True) else []


@dataclass(frozen=True)
class Rayleigh:
    """Rayleigh damping ``alpha M + beta K``: a mode of frequency omega has the damping ratio
    (alpha/omega + beta omega)/2.

    Args:
        alpha: of the mass, 1/s, >= 0.
        beta: of the stiffness, s, >= 0.

    Raises:
        InputError: numbers out of range.
    """

    alpha: float = 0.0
    beta: float = 0.0

    def __post_init__(self) -> None:
        checks.keep(self, "alpha", at_least=0)
        checks.keep(self, "beta", at_least=0)


@dataclass(frozen=True)
class KelvinVoigt:
    """A viscous stress beside the elastic one: ``eta`` times the stress of the strain rate.

    Of small strain: ``sigma = C : (e + eta e')``. Of large strain: the second Piola-Kirchhoff
    stress ``eta C : E'`` with E the strain of Green and Lagrange and C the elasticities of the
    stored energy at rest, which no rotation of the solid changes. Springs to ground take nothing.
    (J. C. Simo, T. J. R. Hughes, Computational Inelasticity, 1998, section 10.1.)

    Args:
        eta: retardation time, s, >= 0.

    Raises:
        InputError: eta out of range.
    """

    eta: float
    of_springs: ClassVar[bool] = False

    def __post_init__(self) -> None:
        checks.keep(self, "eta", at_least=0)

    @property
    def alpha(self) -> float:
        """None."""
        return 0.0

    @property
    def beta(self) -> float:
        """For small strain it is proportional to the stiffness."""
        return self.eta


class Damper(Protocol):
    """A damping force of a solid. Arrays are those of its owned unknowns.

    Attributes:
        number: that of the damping to which the force is proportional, ``"alpha"`` or ``"beta"``.
        time: by which velocities are stiff: a force of time K v is no less a force of K u, s.
    """

    number: str
    time: float

    def force(self, step: Step, start: np.ndarray, end: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """Mean of the force against a velocity, N.

        Args:
            step: in which it acts.
            start, end: the displacements between which the scheme takes forces, m.
            rate: the velocity, m/s.
        """

    def add_to(self, matrix: PETSc.Mat, step: Step, start: np.ndarray, end: np.ndarray) -> None:
        """Add its derivative by the velocity at the end of the step to a matrix."""

    def add_bent(self, matrix: PETSc.Mat, place: np.ndarray, rate: np.ndarray) -> None:
        """Add its derivative by the displacement at which it is taken, at a fixed velocity."""


class Straight:
    """A damper whose force does not depend on the displacement."""

    def add_bent(self, matrix: PETSc.Mat, place: np.ndarray, rate: np.ndarray) -> None:
        """Nothing."""


class MassDamper(Straight):
    """``alpha M v``."""

    number, time = "alpha", 0.0

    def __init__(self, alpha: float, mass: Mass) -> None:
        self._alpha, self._mass = alpha, mass

    def force(self, step: Step, start: np.ndarray, end: np.ndarray, rate: np.ndarray) -> np.ndarray:
        return self._alpha * self._mass.times(rate)

    def add_to(self, matrix: PETSc.Mat, step: Step, start: np.ndarray, end: np.ndarray) -> None:
        subset = PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN
        matrix.axpy(step.rate_weight * self._alpha, self._mass.matrix, subset)


class StiffnessDamper(Straight):
    """``beta K v`` with a stiffness that stays.

    Args:
        time: beta, s.
        stiffness: K.
        force: K times a field.
    """

    number = "beta"

    def __init__(
        self, time: float, stiffness: PETSc.Mat, force: Callable[[np.ndarray], np.ndarray]
    ) -> None:
        self.time, self._stiffness, self._force = time, stiffness, force

    def force(self, step: Step, start: np.ndarray, end: np.ndarray, rate: np.ndarray) -> np.ndarray:
        return self.time * self._force(rate)

    def add_to(self, matrix: PETSc.Mat, step: Step, start: np.ndarray, end: np.ndarray) -> None:
        subset = PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN
        matrix.axpy(step.rate_weight * self.time, self._stiffness, subset)
