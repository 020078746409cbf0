# SPDX-License-Identifier: LGPL-3.0-or-later
"""A rod in an elastic guide: two beams that a scene sees as one solid.

The guide tube is a beam on its grid supports. Its walls are those of the rigid
:class:`~fenicsx_contact.rods.guide.Guide`, moved by its deflection: jump, compliance and forces
are those of the rod minus those of the tube at the depth where the rod is now.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from ..base import checks
from ..base.constants import SAME
from ..base.vectors import worst
from ..solids.base import Solid, Trace
from ..theory.scheme import Step
from .beam import BeamSolid
from .trace import BeamTrace


class RodInTube(Solid):
    """A rod and the elastic tube around it; unknowns of the rod, then of the tube.

    Args:
        rod: the beam that falls.
        tube: the beam on supports; its axis runs along the rod's and does not move along itself.

    Raises:
        InputError: axes that do not run alike, a tube that is not held along its axis.
    """

    def __init__(self, rod: BeamSolid, tube: BeamSolid) -> None:
        checks.instance("rod", rod, BeamSolid, "a BeamSolid")
        checks.instance("tube", tube, BeamSolid, "a BeamSolid")
        if rod.dim != tube.dim or np.abs(rod.axis.direction - tube.axis.direction).max() > SAME:
            raise checks.InputError("tube: its axis must run in the direction of the rod's")
        if tube.law is not None or tube.matrices.free_axial.all():
            raise checks.InputError(
                "tube: must be held along its axis (Support(axial=inf)) and driven by nothing"
            )
        self.rod, self.tube, self._both = rod, tube, (rod, tube)
        self.supported = rod.supported and tube.supported
        self.name, self.mesh, self.dim = rod.name, rod.mesh, rod.dim

    @property
    def linear(self) -> bool:  # type: ignore[override]
        """Whether both are."""
        return self.rod.linear and self.tube.linear

    def split(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The unknowns of the rod and those of the tube."""
        cut = len(self.rod.velocity)
        return values[:cut], values[cut:]

    def _of(self, what: str) -> np.ndarray:
        return np.concatenate([getattr(solid, what) for solid in self._both])

    @property
    def swift(self) -> bool:
        """As one of them."""
        return any(solid.swift for solid in self._both)

    @property
    def velocity(self) -> np.ndarray:  # type: ignore[override]
        """At the start of the step."""
        return self._of("velocity")

    @property
    def trial_velocity(self) -> np.ndarray:  # type: ignore[override]
        """At its end."""
        return self._of("trial_velocity")

    @property
    def displacement(self) -> np.ndarray:
        """Of the state."""
        return self._of("displacement")

    @displacement.setter
    def displacement(self, values: np.ndarray) -> None:
        self.rod.displacement, self.tube.displacement = map(np.array, self.split(values))

    @property
    def trial_displacement(self) -> np.ndarray:
        """Of the trial state."""
        return self._of("trial_displacement")

    def rest(self) -> None:
        """Stop every motion; the deflections stay."""
        for solid in self._both:
            solid.rest()

    def trace(self, points: np.ndarray) -> PairTrace:
        return self.around(self.rod.trace(points))

    def around(self, trace: BeamTrace) -> PairTrace:
        """A trace of the rod, seen from the tube."""
        return PairTrace(self, trace)

    def predict(self, step: Step) -> None:
        for solid in self._both:
            solid.predict(step)

    def linearise(self, step: Step) -> None:
        for solid in self._both:
            solid.linearise(step)

    def correct(self, step: Step) -> None:
        for solid in self._both:
            solid.correct(step)

    def go(self, velocity: np.ndarray, step: Step) -> None:
        for solid, part in zip(self._both, self.split(velocity)):
            solid.go(part, step)

    def drop_forces(self) -> None:
        for solid in self._both:
            solid.drop_forces()

    def mean_velocity(self, step: Step) -> np.ndarray:
        return np.concatenate([solid.mean_velocity(step) for solid in self._both])

    def imbalance(self, step: Step, noise: float = 0.0) -> float:
        return worst([solid.imbalance(step, noise) for solid in self._both])

    def unsound(self, step: Step) -> str:
        return self.rod.unsound(step) or self.tube.unsound(step)

    def accept(self, step: Step) -> None:
        for solid in self._both:
            solid.accept(step)

    def energies(self) -> tuple[float, float, float]:
        kinetic, strain, potential = np.sum([solid.energies() for solid in self._both], axis=0)
        return float(kinetic), float(strain), float(potential)

    def root_mean_square(self, velocity: np.ndarray) -> float:
        parts = zip(self._both, self.split(velocity))
        total = sum(solid.mass * solid.root_mean_square(part) ** 2 for solid, part in parts)
        return sqrt(total / sum(solid.mass for solid in self._both))

    def works(self, step: Step) -> tuple[float, float, float, float]:
        momentum, loads, held, pulled = np.sum([s.works(step) for s in self._both], axis=0)
        return float(momentum), float(loads), float(held), float(pulled)

    def state(self) -> dict[str, np.ndarray]:
        pairs = zip(("rod", "tube"), self._both)
        return {f"{name}.{key}": v for name, s in pairs for key, v in s.state().items()}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        for name, solid in zip(("rod.", "tube."), self._both):
            own = {k.removeprefix(name): v for k, v in state.items() if k.startswith(name)}
            solid.restore(own)

    def fields(self) -> dict[str, np.ndarray]:
        """Displacement and velocity of the rod."""
        return self.rod.fields()

    def describe(self) -> str:
        return f"{self.rod.describe()}; in an elastic tube: {self.tube.describe()}"


class PairTrace(Trace):
    """A rod seen from its elastic tube: everything relative to the tube's material next to it."""

    def __init__(self, solid: RodInTube, rod: BeamTrace) -> None:
        self._solid, self.rod = solid, rod
        n = len(rod.positions())
        self.tube = solid.tube.sight(
            np.zeros(n), np.arange(n), lambda: solid.tube.axis.along(rod.positions())
        )
        self._positions: np.ndarray | None = None

    def follow(self) -> None:
        self.rod.follow()
        self.tube.follow()
        self._positions = None

    def linearise(self, step: Step) -> None:
        self.rod.linearise(step)
        self.tube.linearise(step)

    def accept(self) -> None:
        self.rod.accept()
        self.tube.accept()
        self._positions = None

    def positions(self) -> np.ndarray:
        if self._positions is None:
            self._positions = self.rod.positions() - self.tube.deflections()
        return self._positions

    def jump(self, velocity: np.ndarray) -> np.ndarray:
        rod, tube = self._solid.split(velocity)
        return self.rod.jump(rod) - self.tube.jump(tube)

    def mean_jump(self, velocity: np.ndarray) -> np.ndarray:
        rod, tube = self._solid.split(velocity)
        return self.rod.mean_jump(rod) - self.tube.mean_jump(tube)

    def free_jump(self) -> np.ndarray:
        return self.rod.free_jump() - self.tube.free_jump()

    def compliance(self, mine: np.ndarray, other: Trace, theirs: np.ndarray) -> np.ndarray:
        assert isinstance(other, PairTrace)
        rod = self.rod.compliance(mine, other.rod, theirs)
        return rod + self.tube.compliance(mine, other.tube, theirs)

    def mobility(self) -> np.ndarray:
        return self.rod.mobility() + self.tube.mobility()

    def spread(self, force: np.ndarray) -> None:
        self.rod.spread(force)
        self.tube.spread(-force)
