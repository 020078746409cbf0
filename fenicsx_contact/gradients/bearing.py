# SPDX-License-Identifier: LGPL-3.0-or-later
"""What contacts bear, as quantities: forces and pressures of the last step."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..base import checks
from ..base.constants import SAME
from ..contact.contact import Contact
from ..solids import DeformableSolid, Solid
from .parameters import Parameter


class OfContact:
    """What a contact bears in the last step, a mean over it; no quantity of the state, and 0 before
    the first step."""

    contact: Contact
    solid: Solid

    def gradient(self) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives by q and v: nothing."""
        nothing = np.zeros(())
        return nothing, nothing

    def explicit(self, parameter: Parameter) -> float:
        """None."""
        return 0.0

    def borne(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives by the pressures (k,) and by the forces on the solid (k, d) at points of the
        contact, given by their numbers."""
        d = self.contact.surface.dim
        return np.zeros(len(points)), np.zeros((len(points), d))


class Force(OfContact):
    """The force of a contact on its solid along a direction, N (N/m in 2D).

    Args:
        contact: the contact.
        direction: d numbers.
    """

    def __init__(self, contact: Contact, direction: Sequence[float]) -> None:
        self.contact: Contact = checks.instance("contact", contact, Contact, "a Contact")
        self.solid = contact.solid
        self._direction = checks.vector("direction", direction, contact.surface.dim)

    def value(self) -> float:
        """Of the last step."""
        return float(self._direction @ self.contact.force.sum(axis=0))

    def borne(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        pressures, forces = super().borne(points)
        return pressures, forces + self._direction


class Pressure(OfContact):
    """The pressure of a contact on a deformable solid at a node, Pa: -lam of the node.

    Args:
        contact: the contact.
        point: reference coordinates of the node, d numbers in m.

    Raises:
        InputError: no such node, or a rigid solid, whose pressures are not unique.
    """

    def __init__(self, contact: Contact, point: Sequence[float]) -> None:
        self.contact: Contact = checks.instance("contact", contact, Contact, "a Contact")
        self.solid = contact.solid
        if not isinstance(contact.solid, DeformableSolid):
            raise checks.InputError(
                f"Pressure: solid {contact.solid.name!r} is not deformable; its pressures are not "
                "unique, see Force"
            )
        if contact.multiplier is None:
            raise checks.InputError(
                f"Pressure: contact {contact.name!r} is of springs and has none; see Force"
            )
        surface = contact.surface
        place = checks.vector("point", point, surface.dim)
        (self._point,) = surface.nodes_at(place[None], SAME * surface.extent)
        if self._point < 0 or not contact.chosen[self._point]:
            raise checks.InputError(
                f"Pressure: point = {list(point)}: is no node of contact {contact.name!r}"
            )

    def value(self) -> float:
        """Of the last step."""
        multiplier = self.contact.multiplier
        return 0.0 if multiplier is None else 0.0 - float(multiplier[self._point])

    def borne(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        pressures, forces = super().borne(points)
        return pressures + (points == self._point), forces
