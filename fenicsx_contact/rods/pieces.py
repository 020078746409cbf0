# SPDX-License-Identifier: LGPL-3.0-or-later
"""What guides are made of: tubes and cards."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..base import checks
from ..base.quoted import quoted
from .lines import AnyCurve, Bow, CentreLine, Sine, Straight


def _is_table(clearance: Any) -> bool:
    array = isinstance(clearance, np.ndarray) and clearance.ndim > 0
    return array or isinstance(clearance, (list, tuple))


@dataclass(frozen=True)
class Tube:
    """A continuous guide.

    Args:
        top, bottom: depths, m.
        clearance: radial, m; or pairs (depth, clearance), linear in between, constant beyond.
        curve: of its centre line.
        kinks: depths at which the curve has a kink.

    Raises:
        InputError: an empty or upside-down tube, a clearance that is not positive, a kink outside,
            an AnyCurve whose derivative is another function's.
    """

    top: float
    bottom: float
    clearance: float | Sequence[tuple[float, float]]
    curve: CentreLine = field(default_factory=Straight)
    kinks: Sequence[float] = ()

    def __post_init__(self) -> None:
        checks.keep(self, "top")
        checks.keep(self, "bottom")
        if self.top >= self.bottom:
            raise checks.InputError(
                f"top = {self.top!r}, bottom = {self.bottom!r}: the top must be above"
            )
        checks.offers("curve", self.curve, CentreLine, "a curve (Straight, Sine, Bow, ...)")
        if isinstance(self.curve, AnyCurve) and self.curve.contradicts(self.top, self.bottom):
            raise checks.InputError(
                "curve = AnyCurve(...): derivative: must be that of its function by the depth"
            )
        problem = f"kinks = {quoted(self.kinks)}: must be a list of depths, finite numbers"
        kinks = checks.table(problem, self.kinks)
        if kinks.ndim != 1:
            raise checks.InputError(problem)
        if not ((self.top <= kinks) & (kinks <= self.bottom)).all():
            raise checks.InputError(
                f"kinks = {quoted(self.kinks)}: must lie in the tube, between its top at "
                f"{self.top:g} m and its bottom at {self.bottom:g} m"
            )
        if not _is_table(self.clearance):
            checks.keep(self, "clearance", above=0)
            return
        problem = (
            f"clearance = {quoted(self.clearance)}: must be > 0, or pairs (depth, clearance) that "
            "go downwards"
        )
        table = checks.table(problem, self.clearance)
        pairs = table.ndim == 2 and len(table) > 1 and table.shape[1] == 2
        if not pairs or not (np.diff(table[:, 0]) > 0).all():
            raise checks.InputError(problem)
        for value in table[:, 1]:
            checks.number("clearance", value, above=0)

    def table(self) -> tuple[np.ndarray, np.ndarray]:
        """Depths and clearances between which the clearance is linear."""
        if not isinstance(self.clearance, float):
            depth, clearance = np.array(self.clearance, dtype=float).T
            knots = np.unique([self.top, *depth, self.bottom])
            return knots, np.interp(knots, depth, clearance)
        return np.array([self.top, self.bottom]), np.full(2, self.clearance, dtype=float)

    def stations(self) -> list[float]:
        """Its ends, kinks, and the places at which a taper ends."""
        depth, clearance = self.table()
        slope = np.diff(clearance) / np.diff(depth)
        tapers = depth[1:-1][np.diff(slope) > 0]
        inside = [x for x in (*tapers, *self.kinks) if self.top < x < self.bottom]
        return [self.top, *inside, self.bottom]

    def hole(self, depth: float) -> tuple[float, np.ndarray]:
        """Its clearance and lateral place there, m."""
        return float(np.interp(depth, *self.table())), self.curve.offset(np.array([depth]))


def joined(tubes: Sequence[Tube], same: float) -> list[Tube]:
    """Tubes from the top down, those that are one in fact as one: they adjoin, up to ``same`` [m],
    and lead on the same line with the same clearance there.

    Raises:
        InputError: they overlap.
    """
    tubes = sorted(tubes, key=lambda tube: tube.top)
    for upper, lower in zip(tubes[:-1], tubes[1:]):
        if lower.top < upper.bottom - same:
            raise checks.InputError(f"pieces: {upper} and {lower} overlap")
    whole = tubes[:1]
    for lower in tubes[1:]:
        upper = whole[-1]
        apart = lower.top - upper.bottom, lower.hole(lower.top)[0] - upper.hole(upper.bottom)[0]
        if max(map(abs, apart)) > same or not _same_line(upper.curve, lower.curve):
            whole.append(lower)
            continue
        (x, above), (z, below) = upper.table(), lower.table()
        high = (x >= upper.top) & (x < upper.bottom)
        low = (z > upper.bottom) & (z <= lower.bottom)
        clearance = [*zip(x[high], above[high]), *zip(z[low], below[low])]
        joint = upper.bottom, upper.hole(upper.bottom)[0]
        if abs(np.interp(joint[0], *np.transpose(clearance)) - joint[1]) > same:
            clearance = sorted([*clearance, joint])
        kinks = [x for x in upper.kinks if x <= upper.bottom]
        kinks += [x for x in lower.kinks if x >= lower.top]
        whole[-1] = Tube(upper.top, lower.bottom, clearance, upper.curve, kinks)
    return whole


def _same_line(one: CentreLine, other: CentreLine) -> bool:
    # own curves need not tell which are equal
    told = isinstance(one, (Straight, Sine, Bow, AnyCurve))
    return one is other or (told and one == other)


@dataclass(frozen=True)
class Card:
    """A thin plate with a hole.

    Args:
        depth: m.
        clearance: radial, m.
        centre: lateral place of the hole, m.
    """

    depth: float
    clearance: float
    centre: float = 0.0

    def __post_init__(self) -> None:
        checks.keep(self, "depth")
        checks.keep(self, "centre")
        checks.keep(self, "clearance", above=0)

    def stations(self) -> list[float]:
        """Itself."""
        return [self.depth]

    def hole(self, depth: float) -> tuple[float, np.ndarray]:
        """Its clearance and lateral place, m."""
        return self.clearance, np.array([self.centre])
