# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a law of springs remembers from step to step: how far its tangential springs are stretched.

The stretch belongs to the surface and turns with it: from the start of a step to its end its
components along the tangents stay, which follow the normals, and about the normals it turns by the
angle by which the material does: that of the rotation that fits the ways to all neighbours of a
point best. Forces are taken with the share of that which the scheme takes.

Laws with multipliers remember nothing of the kind.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..base.vectors import orthogonal
from ..theory.formulations import Formulation
from ..theory.scheme import Step
from .equations import SurfaceEquations


class TangentialSprings:
    """The springs of all points of a surface.

    Args:
        equations: of the surface.
        formulation: its law.

    Attributes:
        stretch: (n, d) in m.
    """

    def __init__(self, equations: SurfaceEquations, formulation: Formulation) -> None:
        self._equations = equations
        surface = equations.fields.surface
        self._there = not formulation.multipliers
        self._slips = self._there and equations.fields.friction is not None
        # per weight of a point; a law without such a stiffness has no stretch
        self._stiffness = getattr(formulation, "stiffness_t", np.inf) if self._slips else np.inf
        self.stretch = np.zeros(surface.points.shape)
        self._sticks = np.zeros(surface.size, dtype=bool)
        self._beside = _neighbours(surface.cell_nodes) if self._slips and surface.dim == 3 else None

    def begin(self, normal: np.ndarray, places: Callable[[], np.ndarray]) -> None:
        """A step starts with these normals and at these places, (n, d)."""
        if self._slips:
            self._start = normal, places()

    def linearise(
        self, step: Step, gap: np.ndarray, jump: np.ndarray, places: Callable[[], np.ndarray]
    ) -> None:
        """Tell the law the gap (n,) [m] and jump (n, d) [m/s] with which the step starts, and take
        up where it leads, (n, d)."""
        if not self._there:
            return
        k, weight = self._equations.fields, step.scheme.force_weight
        k.start_gap.x.array[:] = gap
        k.mean_share.value = step.mean_share
        k.force_rate.value = weight * step.gap_rate
        if self._slips:
            normal, first = self._start
            frames = k.frame(normal)[1], k.frame()[1]
            angle = self._angles(frames, first, places())
            there = (1 + step.implicitness) / 2 * angle
            way = weight * (step.dt - step.gap_rate) * jump
            stretch, way = (along(frames[0], each) for each in (self.stretch, way))
            self._before, self._after = turned(stretch, there), turned(stretch, angle)
            k.elongation.x.array[:] = across(frames[1], turned(stretch + way, there)).ravel()
        self._equations.refresh()

    def _angles(
        self, frames: tuple[np.ndarray, np.ndarray], first: np.ndarray, last: np.ndarray
    ) -> np.ndarray:
        """By how much the material turns about the normals, against the frames, (n,)."""
        if self._beside is None:
            return np.zeros(len(first))
        point, other = self._beside
        old, new = (
            along(frame[:, point], places[other] - places[point])
            for frame, places in zip(frames, (first, last))
        )
        # the angle that makes the sum of old ways, turned, times new ones the largest
        products = old[0] * new[1] - old[1] * new[0], (old * new).sum(axis=0)
        return np.arctan2(*(np.bincount(point, each, len(first)) for each in products))

    def slips(self, jump: np.ndarray, normal: np.ndarray) -> np.ndarray:
        """The jumps (n, d) [m/s] of the accepted step, less those along the surface that only
        stretched springs."""
        if not self._slips:
            return jump
        return jump - np.where(self._sticks[:, None], orthogonal(normal, jump), 0.0)

    def accept(self, step: Step, friction: np.ndarray, sticks: np.ndarray) -> None:
        """Keep the stretch at the end of a step from its friction (n, d) in N: elastic where
        points stick, (n,) of bool, returned on slip."""
        self._sticks = sticks
        if not self._slips:
            return
        k = self._equations.fields
        each = self._stiffness * np.where(self._equations.weight > 0, self._equations.weight, 1.0)
        held = along(k.frame(k.mean_normal())[1], -friction / each[:, None])
        stuck = self._after + (held - self._before) / (step.scheme.force_weight or 1.0)
        self.stretch = across(k.frame()[1], np.where(sticks, stuck, held))


def _neighbours(cells: np.ndarray) -> np.ndarray:
    """All nodes of the cells (m, k) and the others of these, each pair once, (2, pairs)."""
    k = cells.shape[1]
    pairs = [cells[:, [i, j]] for i in range(k) for j in range(k) if i != j]
    return np.unique(np.concatenate(pairs), axis=0).T


def along(tangents: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Components (d - 1, n) of vectors (n, d) along tangents (d - 1, n, d)."""
    return np.asarray((tangents * vectors).sum(axis=2))


def across(tangents: np.ndarray, components: np.ndarray) -> np.ndarray:
    """The vectors of these components, (n, d)."""
    return np.asarray((tangents * components[:, :, None]).sum(axis=0))


def turned(components: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Components turned about the normal, by angles (n,)."""
    if len(components) == 1:
        return components
    (a, b), c, s = components, np.cos(angle), np.sin(angle)
    return np.stack([c * a - s * b, s * a + c * b])
