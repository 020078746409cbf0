# SPDX-License-Identifier: LGPL-3.0-or-later
"""The natural scales of the points of a contact: what stops one of them alone."""

from __future__ import annotations

from collections.abc import Sequence
from math import frexp

import numpy as np

from ..base.constants import SAME
from ..base.vectors import largest
from ..solids import Solid
from ..solids.base import Trace
from ..theory.formulations import Formulation
from ..theory.scheme import Step
from .equations import SurfaceEquations
from .jump import Coupling
from .surface import Surface

#: Weight of gaps and jumps between two solids beside the multipliers in what decides who bears and
#: who slips: those of a point that bears and sticks are not quite zero before the last iteration.
MEETING = 0.1


class Scales:
    """Pressures that stop 1 m/s, and speeds that forces stand for.

    Args:
        coupling: of the points.
        points: how many.

    Attributes:
        alone: the pressures that stop 1 m/s of each point alone, (2, n), and
        mobility: the speed that 1 N would give to the lightest one, m/s; within the step when units
            were asked for last.
    """

    def __init__(self, coupling: Coupling, points: int) -> None:
        self._coupling = coupling
        self._span, self._octave, self.mobility = 0.0, -np.inf, 0.0
        self._units = self.alone = np.ones((2, points))

    def units(
        self, normal: np.ndarray, weight: np.ndarray, area: np.ndarray, step: Step
    ) -> np.ndarray:
        """By which multipliers are scaled: the pressures that stop 1 m/s of each point alone within
        the step, along its normal and its tangents, (2, n). Points of rigid solids, that yield
        alike over the area, share what they bear evenly: all have the median one. Kept while the
        length of the step does not change by much, until they are renewed."""
        if step.span == self._span:
            return self._units
        octave, self._span = float(frexp(step.span)[1]), step.span
        if self._octave != octave:
            mobility = self._coupling.mobility()
            along = (mobility * normal**2).sum(axis=1)
            across = (mobility.sum(axis=1) - along) / (normal.shape[1] - 1)
            along, across = _or(along, across), _or(across, along)
            alone = np.array([inverse(each * weight) for each in (along, across)])
            if len(self._coupling.solids) > 1:
                alone *= MEETING
            self._units = self.alone = alone
            if self._coupling.shares and all(s.shiftable for s in self._coupling.solids):
                evenly = inverse(weight) * area
                evenly /= np.median(evenly)
                self._units = np.median(alone, axis=1, keepdims=True) * evenly
            self._octave, self.mobility = octave, float(mobility.max())
        return self._units

    def renew(self) -> None:
        """The points weigh otherwise than before, or meet something else."""
        self._span, self._octave = 0.0, -np.inf

    def state(self) -> dict[str, np.ndarray]:
        """The arrays from which :meth:`restore` continues identically."""
        return {
            "units": self._units,
            "alone": self.alone,
            "octave": np.array([self._octave, self.mobility]),
        }

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Take up a state that :meth:`state` gave."""
        self._units = np.array(state["units"])
        self.alone = np.array(state.get("alone", state["units"]))
        self._span = 0.0
        self._octave, self.mobility = map(float, state["octave"])


class Scaled:
    """What a contact says of its scales.

    Attributes:
        scales: of its points.
        force_of: how long the step took of which its forces are, s; 0 of a percussion.
    """

    scales: Scales
    solids: Sequence[Solid]
    surface: Surface
    formulation: Formulation
    force_of: float
    normal: np.ndarray
    force: np.ndarray
    equations: SurfaceEquations

    def units(self, step: Step) -> np.ndarray:
        """By which the multipliers of the points are scaled within the step, (2, n)."""
        weight = self.equations.weight
        if len(self.solids) > 1:  # what meets nothing yet may before the step ends
            weight = np.where(weight > 0, weight, self.surface.nodal_area)
        return self.scales.units(self.normal, weight, self.areas(weight), step)

    def areas(self, weight: np.ndarray) -> np.ndarray:
        """Over which points of such weights share what they bear, (n,) in m² (m)."""
        area = self.surface.nodal_area if self.formulation.at_points else weight
        return np.where(area > 0, area, np.where(weight > 0, weight, 1.0))

    def push(self, force: np.ndarray | float, step: Step) -> float:
        """The speed that forces on the points (N) would give to one alone, m/s."""
        if size := largest(np.asarray(force)):
            self.units(step)
        return size * self.scales.mobility

    def pushed(self, step: Step) -> float:
        """That of the forces of the last step; those of a percussion are impulses."""
        last = self.force_of if bool(self.force_of) != bool(step.dt) else step.span
        return (last or 1.0) / step.span * self.push(self.force, step)


def mobilities(solids: Sequence[Solid], traces: Sequence[Trace]) -> np.ndarray:
    """Those of the points of two solids, flat, by which they are scaled. Of a rigid and a soft one
    the rigid one has none: all but six of the forces between them move nothing but the other,
    however light it is."""
    soft = [not solid.shiftable for solid in solids]
    counts = [mine or not any(soft) for mine in soft]
    return np.concatenate([trace.mobility().ravel() * c for trace, c in zip(traces, counts)])


def _or(mobility: np.ndarray, other: np.ndarray) -> np.ndarray:
    """The mobilities of points (n,), or where no point has any but round-off the other ones."""
    return mobility if largest(mobility) > SAME * largest(other) else other


def inverse(flexible: np.ndarray) -> np.ndarray:
    """1 over these, (n,); where they vanish (held points, points without area) as at the median of
    the others, or 1."""
    there = flexible > 0
    usual = float(np.median(flexible[there])) if there.any() else 1.0
    return 1 / np.where(there, flexible, usual)
