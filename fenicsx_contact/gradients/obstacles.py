# SPDX-License-Identifier: LGPL-3.0-or-later
"""Parameters of obstacles: where they stand, and what shape they have."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base import checks
from ..base.constants import SAME
from ..base.quoted import quoted
from ..contact.contact import Contact
from ..contact.level_set import LevelSet
from ..rods import CentreLine, GuideContact
from ..solids import Solid
from .parameters import Parameter, among


class ObstacleShift(Parameter):
    """A shift of a contact's obstacle.

    Args:
        contact: the contact.
        direction: of the shift, d numbers; the parameter is in multiples of it.
    """

    def __init__(self, contact: Contact, direction: Sequence[float]) -> None:
        self.contact: Contact = checks.instance("contact", contact, Contact, "a Contact")
        self.direction = checks.vector("direction", direction, contact.surface.dim)

    def wall(self, contact: Contact, places: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        if contact is not self.contact:
            return None
        wall, way = contact.coupling.wall, self.direction  # type: ignore[attr-defined]
        bend = wall.curvature(places, 0.0)
        turned = np.zeros_like(places) if bend is None else -bend @ way
        return -wall.slopes(places, 0.0) @ way, turned

    def check(self, solids: Sequence[Solid], contacts: Sequence[Contact]) -> None:
        among("ObstacleShift", self.contact, contacts)
        if len(self.contact.solids) > 1:
            raise checks.InputError(
                f"ObstacleShift: contact {self.contact.name!r} is between two solids; see Start"
            )
        if self.contact.coupling.encloses:
            raise checks.InputError("ObstacleShift: the obstacle is a guide; see Bend")


class Shape(Parameter):
    """A number that stands in the phi of a contact's obstacle: a coefficient of its shape.

    Args:
        contact: with a :class:`~fenicsx_contact.contact.level_set.LevelSet`.
        number: the ``fem.Constant``.

    Raises:
        InputError: another obstacle, a number that does not stand in its phi.
    """

    def __init__(self, contact: Contact, number: Any) -> None:
        self.contact: Contact = checks.instance("contact", contact, Contact, "a Contact")
        obstacle = getattr(contact.coupling, "obstacle", None)
        what = f"a LevelSet before contact {contact.name!r}"
        self._level = checks.instance("obstacle", obstacle, LevelSet, what)
        if not any(number is each for each in self._level.numbers):
            there = [*map(str, self._level.numbers)]
            raise checks.InputError(
                f"Shape: number = {quoted(number)}: must be a fem.Constant in phi; "
                f"these are {there}"
            )
        self.number = number

    def wall(self, contact: Contact, places: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        return self._level.changes(self.number, places) if contact is self.contact else None

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
