# SPDX-License-Identifier: LGPL-3.0-or-later
"""What every solid offers to a scene.

A step of a scene asks a solid, in this order::

    predict(step)                    trial state from the old velocity
    linearise(step)                  A and b of  A v+ = b + J' f  about the trial state
    trace.compliance(), ...          the contacts take what they need and spread their forces
    correct(step)                    v+ from these forces; the last two again if not linear
    accept(step)                     the trial state becomes the state

Velocities are arrays of the unknowns that a process holds; positions are whatever the solid needs
to know where it is. Forces are mean forces over the step, impulses divided by dt.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI

from ..base.checks import InputError
from ..base.mesh import NamedMesh
from ..theory.scheme import Step


class Trace(ABC):
    """A solid seen from n points of a surface. Jumps and forces are flat arrays of n d numbers,
    the same on every process.

    Attributes:
        held: may be told: components that supports hold fast, or lead, whatever pushes them, (n d,)
            of bool, or of all.
    """

    held: np.ndarray | bool = False

    @abstractmethod
    def follow(self) -> None:
        """Take up the solid's trial state: places and operator."""

    @abstractmethod
    def linearise(self, step: Step) -> None:
        """Take up the solid's newest linearisation."""

    @abstractmethod
    def accept(self) -> None:
        """The trial state, which was followed, is the start of the next step."""

    @abstractmethod
    def positions(self) -> np.ndarray:
        """Places of the points in the trial state, (n, d) in m."""

    @abstractmethod
    def jump(self, velocity: np.ndarray) -> np.ndarray:
        """Velocities of the points, J v."""

    def start_jump(self, velocity: np.ndarray) -> np.ndarray:
        """Velocities of the points where the step starts, wherever the solid has been tried."""
        return self.jump(velocity)

    @abstractmethod
    def mean_jump(self, velocity: np.ndarray) -> np.ndarray:
        """Velocities of the points, by the operator whose transpose spreads the forces."""

    def rows(self, which: np.ndarray) -> np.ndarray:
        """These rows of J, dense, of a shiftable solid."""
        raise AttributeError("only traces of what is shiftable have dense rows")

    @abstractmethod
    def free_jump(self) -> np.ndarray:
        """Velocities of the points that the step would end with if no contact acted."""

    @abstractmethod
    def compliance(self, mine: np.ndarray, other: Trace, theirs: np.ndarray) -> np.ndarray:
        """J A^-1 J' between components ``mine`` and ``theirs`` of ``other``, a trace of the same
        solid: the Delassus operator."""

    @abstractmethod
    def mobility(self) -> np.ndarray:
        """About the diagonal of J A^-1 J', flat: it scales, it decides nothing."""

    @abstractmethod
    def spread(self, force: np.ndarray) -> None:
        """Add point forces to the forces on the solid in this step."""


class Solid(ABC):
    """A body that moves.

    Attributes:
        name: for messages and files.
        mesh: its shape.
        dim: dimension of space.
        linear: one linearisation serves a whole step.
        shiftable: rigid: can be put elsewhere without a velocity (`shift`, `mobility`).
        massless: some of its boundary has no mass, and so no velocity of its own.
        patient: an old linearisation may serve as long as corrections converge fast.
        revolution: its mesh is half a section of it, x being the radius.
        supported: something holds it even without contact.
        velocity, trial_velocity: at the start and at the end of the step.
        memory: what the scheme remembers of earlier steps, None before the first one.
    """

    name: str
    mesh: NamedMesh
    dim: int
    linear: bool
    supported: bool
    massless = False
    revolution = False
    shiftable = False
    patient = False
    velocity: np.ndarray
    trial_velocity: np.ndarray
    memory: np.ndarray | None = None

    @abstractmethod
    def trace(self, points: np.ndarray) -> Trace:
        """The solid seen from points on it, given by reference coordinates (n, d)."""

    @abstractmethod
    def predict(self, step: Step) -> None:
        """Explicit prediction of the trial state: the old velocity goes on."""

    @abstractmethod
    def linearise(self, step: Step) -> None:
        """Set up A and b of ``A v+ = b + J' f`` about the trial state, and drop old forces."""

    def shift(self, way: np.ndarray) -> None:
        """Put a shiftable solid elsewhere in its trial state, ways [m] and turns [rad] of its
        unknowns, and in all that follow in the step; its momentum stays."""
        raise AttributeError("only what is shiftable can be shifted")

    @property
    def mobility(self) -> np.ndarray:
        """Of a shiftable solid: the inverse of its mass matrix in the trial state."""
        raise AttributeError("only what is shiftable has a mobility")

    def broken(self) -> str:
        """Why the trial state is not admissible, or nothing."""
        return ""

    def unsound(self, step: Step) -> str:
        """Why the solution of the step, in the trial state, is not to be accepted, or nothing."""
        return ""

    @abstractmethod
    def correct(self, step: Step) -> None:
        """Solve for the trial velocity with the forces spread so far, and move there."""

    @abstractmethod
    def go(self, velocity: np.ndarray, step: Step) -> None:
        """Move to the trial state of a velocity."""

    @abstractmethod
    def drop_forces(self) -> None:
        """Forget the forces spread so far."""

    def mean_velocity(self, step: Step) -> np.ndarray:
        """By which the works of the step are counted, in the trial state."""
        return step.mean(self.velocity, self.trial_velocity)

    def imbalance(self, step: Step, noise: float = 0.0) -> float:
        """Residual of the momentum balance in the trial state over the size of its terms; 0 where
        none of them is more than ``noise``, N, or where each step is solved directly."""
        return 0.0

    @abstractmethod
    def accept(self, step: Step) -> None:
        """Make the trial state the state, after :meth:`works`."""

    @abstractmethod
    def energies(self) -> tuple[float, float, float]:
        """Kinetic, strain and potential energy of the state, J (J/m in 2D)."""

    @abstractmethod
    def root_mean_square(self, velocity: np.ndarray) -> float:
        """Of a velocity [m/s] or an acceleration [m/s²], over the mass."""

    @abstractmethod
    def works(self, step: Step) -> tuple[float, float, float, float]:
        """Work on the mean velocity of the step in J, in the trial state: of the change of
        momentum, of internal forces and all loads, of the supports; and of what is applied among
        the loads, weight apart, on the way really gone, as weight works."""

    def damped(self, step: Step) -> float:
        """Work of damping on the mean velocity of the step in J, in the trial state, never
        positive; :meth:`works` counts the damping forces among internal forces."""
        return 0.0

    def memories(self) -> dict[str, np.ndarray]:
        """The part of :meth:`state` that the scheme needs."""
        return {} if self.memory is None else {"memory": self.memory}

    @abstractmethod
    def state(self) -> dict[str, np.ndarray]:
        """The arrays from which :meth:`restore` continues identically."""

    @abstractmethod
    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Take up a state that :meth:`state` gave."""

    @abstractmethod
    def describe(self) -> str:
        """One line: what it is and how many unknowns it has."""

    @abstractmethod
    def fields(self) -> dict[str, np.ndarray]:
        """Displacement [m] and velocity [m/s] at the local nodes of the mesh's geometry."""


def refuse_mixed(solids: Sequence[Solid]) -> None:
    """Refuse solids that no scene can hold together.

    Raises:
        InputError: some in 2D and some in 3D, or some of revolution and some not.
    """
    if len({solid.dim for solid in solids}) > 1:
        raise InputError("solids: some are in 2D and some in 3D; use one dimension")
    kinds = {solid.revolution: solid.name for solid in solids}
    if len(kinds) > 1:
        raise InputError(
            f"solids: {kinds[True]!r} is a solid of revolution and {kinds[False]!r} is not"
        )


def communicator(solids: Sequence[Solid]) -> Any:
    """The processes of a scene: those of the solid that most have; every one of them may have
    others alone, as rigid bodies on COMM_SELF."""
    return max((solid.mesh.mesh.comm for solid in solids), key=lambda comm: comm.size)


class MonolithicTrace(Trace):
    """A trace whose operators are at hand as matrices, the same on every process."""

    @abstractmethod
    def seeing(self) -> sp.csr_matrix:
        """J, (components of the points, unknowns of the solid)."""

    def spreading(self) -> sp.csr_matrix:
        """The operator whose transpose spreads forces, likewise; J if it stays the same."""
        return self.seeing()


class MonolithicSolid(Solid):
    """A solid that can be part of a monolithic system, whose rows are shared out by process.

    Attributes:
        linearisation: counts the changes of A, for those who keep what belongs to it.
    """

    linearisation = 0

    @abstractmethod
    def trace(self, points: np.ndarray) -> MonolithicTrace: ...

    @abstractmethod
    def layout(self, comm: MPI.Comm) -> list[int]:
        """Number of unknowns that each process owns."""

    @abstractmethod
    def owned_range(self, comm: MPI.Comm) -> slice:
        """This process's unknowns among all of the solid; ``velocity`` holds them."""

    @abstractmethod
    def matrix_rows(self, comm: MPI.Comm) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """This process's rows of A: row pointers, columns, values."""

    @abstractmethod
    def residual(self) -> np.ndarray:
        """This process's rows of the momentum balance in the trial state, after `linearise`."""

    @abstractmethod
    def linear_residual(self) -> np.ndarray:
        """The same as it was linearised: ``A v - b - J' f``."""

    def load_speed(self) -> float:
        """The largest speed that the loads of the step give to a node alone, m/s: a scale."""
        return 0.0

    @abstractmethod
    def load_size(self) -> float:
        """The largest term of b and J' f, N."""
