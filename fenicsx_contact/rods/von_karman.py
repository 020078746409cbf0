# SPDX-License-Identifier: LGPL-3.0-or-later
"""Beams whose axial force bends them, and which bend shorter: von Kármán's.

The axial strain of a deflection w is ``e = u' + w'.w'/2``, the axial force ``N = T + EA e`` with
the ``tension`` T of the section; the strain energy is that of the linear beam with ``EA e²/2`` in
place of ``EA u'^2/2``. So whatever acts along the axis - weight, drag, friction of a guide,
inertia, a stop, a drive - stiffens bending or lets it buckle, and what bends pulls its ends
together (T. von Kármán (1910), Encyklopädie der mathematischen Wissenschaften IV.27, 311-385).
With linear fields both parts of the strain are constant in a cell: nothing locks.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from scipy.linalg import block_diag, null_space

from ..base import checks
from ..base.constants import ROUND_OFF
from ..base.vectors import largest, worst
from ..theory.scheme import Step
from .beam import BeamSolid
from .coupled_trace import CoupledTrace
from .drive import Place


class VonKarmanBeam(BeamSolid):
    """A beam whose axial force, as the run finds it, acts on its bending.

    Its arguments are those of :class:`~fenicsx_contact.rods.beam.BeamSolid`; its sections must
    stretch (``axial``). A :class:`~fenicsx_contact.rods.drive.Driven` holds one node of it.

    Attributes:
        inverse: of the tangent of the step, (n, n) in m/(N s).

    Raises:
        InputError: an axis that does not stretch, and what BeamSolid refuses.
    """

    linear = False
    _taken: tuple[np.ndarray, np.ndarray]  # a displacement, the mean internal force up to there

    def _share(self, place: Place) -> np.ndarray:
        return np.concatenate([np.zeros(self.unknowns.bending), super()._share(place)])

    @cached_property
    def _cells(self) -> tuple[np.ndarray, np.ndarray]:
        """Lengths [m] and axial stiffness EA [N] of the cells."""
        h = np.diff(self.matrices.s)
        if len(self.unknowns.mean) == 1:
            raise checks.InputError(
                f"sections: {self.name!r} has an axial stiffness that is infinite; the axial force "
                "of a VonKarmanBeam is that of its stretching: give Section(axial=EA)"
            )
        return h, -self.matrices.axial_stiffness.diagonal(1) * h

    @cached_property
    def _whole(self) -> np.ndarray:
        """The stiffness of the straight beam."""
        return self.unknowns.stiffness.toarray()

    @cached_property
    def _free(self) -> np.ndarray:
        k = self.matrices
        return np.concatenate([*[k.free_bending] * self.unknowns.planes, k.free_axial])

    # -- strains, forces, energy ------------------------------------------------------------------

    def _strains(self, displacement: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """In the cells: w', (planes, cells), w'.w'/2 and N - T [N]."""
        (bending, along), (h, EA) = self.split(displacement), self._cells
        slope = np.diff(bending[:, ::2]) / h
        shortened = 0.5 * (slope * slope).sum(axis=0)
        return slope, shortened, EA * (np.diff(along) / h + shortened)

    def axial_force(self) -> np.ndarray:
        """In the cells, from s = 0 on, (cells,) in N, compression negative; the ``tension`` of the
        sections is not in it."""
        return self._strains(self.displacement)[2]

    def internal_force(self, displacement: np.ndarray) -> np.ndarray:
        force = super().internal_force(displacement)
        slope, shortened, N = self._strains(displacement)
        bending, along = self.split(force)
        for values, lines in ((N * slope, bending[:, ::2]), (self._cells[1] * shortened, along)):
            lines[..., 1:] += values
            lines[..., :-1] -= values
        return force

    def strain_energy(self) -> float:
        _, q, N = self._strains(self.displacement)
        h, EA = self._cells
        straight = float(self.displacement @ super().internal_force(self.displacement))
        return 0.5 * straight + float(h @ (q * (N - 0.5 * EA * q)))

    def lateral_energy(self) -> float:
        n, u = self.unknowns.bending, self.displacement
        kinetic = self.velocity[:n] @ self._momentum[:n]
        return 0.5 * float(kinetic + u[:n] @ super().internal_force(u)[:n])

    def _way(self) -> Callable[[float], np.ndarray]:
        start, end = self.displacement, self.trial_displacement
        return lambda share: share * end + (1 - share) * start

    def _tangent(self, step: Step) -> np.ndarray:
        """Of the mean internal force by the displacement at the end."""
        h, EA = self._cells
        planes, place = self.unknowns.planes, self._way()
        blocks = np.zeros((len(h), planes + 1, planes + 1))
        for share, weight in step.scheme.force_points:
            slope, _, N = self._strains(place(share))
            r = np.concatenate([slope, np.ones((1, len(h)))])
            part = EA * (r[:, None] * r[None])
            part[range(planes), range(planes)] += N
            part[planes, planes] -= EA  # which the straight beam has
            blocks += (weight * share) * np.moveaxis(part, -1, 0)
        result = step.scheme.linear_weights[1] * self._whole
        for (a, low, high), (b, left, right) in product(self._ends, self._ends):
            part = blocks[:, a, b] / h
            result[low, left] += part
            result[high, right] += part
            result[low, right] -= part
            result[high, left] -= part
        return result

    @cached_property
    def _ends(self) -> list[tuple[int, np.ndarray, np.ndarray]]:
        """In each plane and along the axis, the unknowns at both ends of the cells."""
        m, planes = len(self.matrices.s), self.unknowns.planes
        first = np.arange(m - 1)
        low = [*(2 * (i * m + first) for i in range(planes)), 2 * planes * m + first]
        rises = [2] * planes + [1]
        return [(i, at, at + rise) for i, (at, rise) in enumerate(zip(low, rises))]

    # -- the step ---------------------------------------------------------------------------------

    def driven(self, values: np.ndarray) -> np.ndarray:
        return values

    def _mean_internal(self, step: Step) -> np.ndarray:
        if self._taken[0] is not self.trial_displacement:
            place = self._way()
            force = step.mean_force(lambda share: self.internal_force(place(share)))
            self._taken = self.trial_displacement, force
        return self._taken[1]

    def _begin(self) -> None:
        self._taken = np.empty(0), np.empty(0)
        super()._begin()

    def _balance(self, step: Step) -> list[np.ndarray]:
        """Terms of the momentum balance in a step that takes time: inertia, internal forces, loads
        and forces of contacts."""
        inertia = (self._masses * self.trial_velocity - self._momentum) / step.span
        loads = self._loads(step)
        if self.lateral_load is not None:
            self._flow = self.unknowns.flow(self.lateral_load, self.displacement)
            loads = loads + self._flow
        return [inertia, self._mean_internal(step), -loads, -self._pushed]

    def linearise(self, step: Step) -> None:
        self.drop_forces()
        if self._linear and self._about is self.trial_velocity:
            return
        self._linear, self._about = True, self.trial_velocity
        if step.dt:
            matrix = np.diag(self._masses / step.span) + step.gap_rate * self._tangent(step)
            load = matrix @ self.trial_velocity - sum(self._balance(step))
            inner = np.ix_(self._free, self._free)
            inverse = np.zeros_like(matrix)
            inverse[inner] = np.linalg.inv(matrix[inner])
            self._inner = matrix[inner]
        else:  # an impact: nothing is strained
            bending, axial = self.matrices.flexibilities(step.span, 0.0)
            inverse = block_diag(*[bending] * self.unknowns.planes, axial)
            load = self._momentum / step.span
        self.inverse, given = self.axial.drive(step, *self._states, inverse, load)
        self.free_velocity = self.inverse @ load + given

    def drop_forces(self) -> None:
        self._pushed = np.zeros_like(self.weight)
        self._held: list[Callable[[], tuple[np.ndarray, np.ndarray]]] = []

    def push(self, force: np.ndarray, held: Callable[[], tuple[np.ndarray, np.ndarray]]) -> None:
        """Take up forces of contacts on the unknowns, (n,) in N, and what gives the motions that
        they hold, (k, n), and how stiff they are against others, (n, n) in N/m."""
        self._pushed = self._pushed + force
        self._held.append(held)

    def correct(self, step: Step) -> None:
        self.go(self.free_velocity + self.inverse @ self._pushed, step)

    def imbalance(self, step: Step, noise: float = 0.0) -> float:
        if not step.dt:  # which is linear
            return 0.0
        terms = self._balance(step)
        law = self.axial.balance(step, *self._states)
        left = np.asarray(sum(terms) - law)
        held = np.where(self._free, 0.0, left) + self.axial.held(left)
        stretched = self._whole.diagonal() * np.abs(self.trial_displacement)
        round_off = np.abs(self._momentum).max() / step.span + (stretched * self._lever).max()
        inertia, _, loads, contact = terms
        sizes = [largest(self._lever * term) for term in (inertia, loads, contact, law, held)]
        wrong = largest(self._lever * (left - held)) - ROUND_OFF * round_off
        size = worst(sizes)
        if size <= noise and wrong < np.inf:  # NaN is neither
            return 0.0
        return max(wrong, 0.0) / size

    def unsound(self, step: Step) -> str:
        """Of several solutions only the one that it buckles to is one that it moves to: the energy
        of the step must be convex in what the walls that bear leave free."""
        if not step.dt or positive(self._inner):
            return ""
        rows, inner = [np.zeros((1, len(self._inner)))], self._inner
        for each in self._held:
            held, stiff = each()
            rows.append(held[:, self._free])
            inner = inner + step.force_rate * stiff[np.ix_(self._free, self._free)]
        left = null_space(np.concatenate(rows))
        if positive(left.T @ inner @ left):
            return ""
        return (
            f"{self.name!r} buckles faster than steps of {step.dt:.3g} s can tell: shorter ones can"
        )

    @cached_property
    def _lever(self) -> np.ndarray:
        """Turns moments into forces at the ends of a cell."""
        result = np.ones(len(self._masses))
        self.split(result)[0][:, 1::2] = 1 / self.matrices.lengths
        return result

    def sight(self, places: np.ndarray, *stations: Any) -> CoupledTrace:
        return CoupledTrace(self, places, *stations)


def positive(matrix: np.ndarray) -> bool:
    """Whether a symmetric matrix is positive definite."""
    try:
        np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        return False
    return True
