# SPDX-License-Identifier: LGPL-3.0-or-later
"""Parameters of obstacles: where they stand, and what shape they have."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..base import checks
from ..base.constants import SAME
from ..base.quoted import quoted
from ..contact.contact import Contact
from ..rods import CentreLine, GuideContact
from ..solids import Solid
from .parameters import Parameter, among


class ObstacleShift(Parameter):
    """A shift of a contact's obstacle, or a motion that is added to its own.

    Args:
        contact: the contact.
        direction: of the shift, d numbers, the parameter is in multiples of it; or, of an obstacle
            that moves, a function of the time [s] that gives them: ``lambda t: (t, 0)`` makes it
            the speed of a belt.

    Raises:
        InputError: what gives no such numbers; a function, and an obstacle at rest.
    """

    def __init__(
        self, contact: Contact, direction: Sequence[float] | Callable[[float], Any]
    ) -> None:
        self.contact: Contact = checks.instance("contact", contact, Contact, "a Contact")
        self.direction = direction
        self._way(0.0)

    def _way(self, time: float) -> np.ndarray:
        """At a time, (d,)."""
        what, way = "direction", self.direction
        if checks.is_function(way):
            what = f"direction({time:g})"
            way = checks.called(what, way, time)
        return checks.vector(what, way, self.contact.surface.dim)

    def wall(
        self, contact: Contact, places: np.ndarray, time: float
    ) -> tuple[np.ndarray, np.ndarray] | None:
        if contact is not self.contact:
            return None
        wall, way = contact.coupling.wall, self._way(time)  # type: ignore[attr-defined]
        bend = wall.curvature(places, time)
        turned = np.zeros_like(places) if bend is None else -bend @ way
        return -wall.slopes(places, time) @ way, turned

    def drive(self, contact: Contact, places: np.ndarray, start: float, end: float) -> np.ndarray:
        if contact is not self.contact:
            return super().drive(contact, places, start, end)
        wall, first, last = contact.coupling.wall, self._way(start), self._way(end)  # type: ignore[attr-defined]
        return (last - first) / (end - start) - wall.velocity_slopes(places, start, end) @ last

    def check(self, solids: Sequence[Solid], contacts: Sequence[Contact]) -> None:
        among("ObstacleShift", self.contact, contacts)
        if len(self.contact.solids) > 1:
            raise checks.InputError(
                f"ObstacleShift: contact {self.contact.name!r} is between two solids; see Start"
            )
        if self.contact.coupling.encloses:
            raise checks.InputError("ObstacleShift: the obstacle is a guide; see Bend")
        if checks.is_function(self.direction) and not self.contact.coupling.driven:
            raise checks.InputError(
                f"ObstacleShift: direction = {quoted(self.direction)}: must be numbers, as the "
                f"obstacle of contact {self.contact.name!r} does not move"
            )


class Shape(Parameter):
    """A number that stands in a contact's obstacle: a coefficient of its shape, or of its velocity.

    Args:
        contact: with a :class:`~fenicsx_contact.contact.level_set.LevelSet`, moved or turned or
            not.
        number: the ``fem.Constant``.

    Raises:
        InputError: another obstacle, a number that does not stand in it.
    """

    def __init__(self, contact: Contact, number: Any) -> None:
        self.contact: Contact = checks.instance("contact", contact, Contact, "a Contact")
        self._obstacle = getattr(contact.coupling, "obstacle", None)
        there = getattr(self._obstacle, "numbers", None)
        if there is None:
            raise checks.InputError(
                f"obstacle = {quoted(self._obstacle)}: must be a LevelSet before contact "
                f"{contact.name!r}, moved or turned or not"
            )
        if not any(number is each for each in there):
            raise checks.InputError(
                f"Shape: number = {quoted(number)}: must be a fem.Constant in the obstacle; "
                f"these are {[*map(str, there)]}"
            )
        self.number = number

    def wall(
        self, contact: Contact, places: np.ndarray, time: float
    ) -> tuple[np.ndarray, np.ndarray] | None:
        if contact is not self.contact:
            return None
        return self._obstacle.changes(self.number, places, time)  # type: ignore[union-attr]

    def drive(self, contact: Contact, places: np.ndarray, start: float, end: float) -> np.ndarray:
        if contact is not self.contact:
            return super().drive(contact, places, start, end)
        return self._obstacle.velocity_changes(self.number, places, start, end)  # type: ignore[union-attr]

    def check(self, solids: Sequence[Solid], contacts: Sequence[Contact]) -> None:
        among("Shape", self.contact, contacts)


class Bend(Parameter):
    """A displacement of the centre line of a guide; clearances stay the same.

    All that is at these depths moves along: the tubes, and the holes of cards, whose places are
    numbers of their own where a guide is made. ``within`` leaves those out that stay.

    Where the rod starts is a parameter of its own (:class:`~.parameters.Start`): what both change
    adds up.

    Args:
        contact: of a beam with the guide.
        curve: the displacement; the parameter is in multiples of it. ``Sine(1.0, 3.66)`` makes it
            the amplitude of a tube's ``Sine(amplitude, 3.66)``.
        within: depths between which the centre line moves, m; of tubes and cards alike.

    Raises:
        InputError: no guide, no curve.
    """

    def __init__(
        self,
        contact: GuideContact,
        curve: CentreLine,
        within: tuple[float, float] = (-np.inf, np.inf),
    ) -> None:
        checks.instance("contact", contact, GuideContact, "a GuideContact")
        checks.offers("curve", curve, CentreLine, "a curve (Straight, Sine, Bow, ...)")
        self.contact, self.curve = contact, curve
        top, bottom = checks.listed("within", within, "two depths, m")
        same = SAME * float(np.ptp(contact.obstacle.stations))
        self._within = top - same, bottom + same

    def bend(
        self, contact: Contact, depth: np.ndarray
    ) -> tuple[np.ndarray | float, np.ndarray | float]:
        if contact is not self.contact:
            return 0.0, 0.0
        inside = (depth >= self._within[0]) & (depth <= self._within[1])
        curve = self.curve
        offset, slope = np.zeros((2, len(depth)))
        offset[inside], slope[inside] = curve.offset(depth[inside]), curve.slope(depth[inside])
        return offset, slope

    def check(self, solids: Sequence[Solid], contacts: Sequence[Contact]) -> None:
        among("Bend", self.contact, contacts)
