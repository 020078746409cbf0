# SPDX-License-Identifier: LGPL-3.0-or-later
"""What contacts remember, as a quantity."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..base import checks
from ..base.constants import SAME
from ..base.quoted import quoted
from ..contact.contact import Contact
from .parameters import Parameter


class Remembered:
    """What the law of a contact remembers: the integral of a field over its surface, at rest; of
    Archard's ``"worn"`` the volume that is worn (m³; m² in 2D), or the field at a node.

    Args:
        contact: the contact.
        name: of the field, as in ``contact.memory.values``.
        point: reference coordinates of a node, d numbers in m.

    Raises:
        InputError: no such field or node.
    """

    def __init__(self, contact: Contact, name: str, point: Sequence[float] | None = None) -> None:
        self.contact: Contact = checks.instance("contact", contact, Contact, "a Contact")
        self.solid, self.name, surface = contact.solid, name, contact.surface
        if name not in contact.memory.values:
            there = [*contact.memory.values]
            raise checks.InputError(f"name = {quoted(name)}: must be one of {there}")
        self.weights = np.array(surface.nodal_area)
        if point is not None:
            place = checks.vector("point", point, surface.dim)
            (at,) = surface.nodes_at(place[None], SAME * surface.extent)
            if at < 0:
                raise checks.InputError(
                    f"Remembered: point = {list(point)}: is no node of contact {contact.name!r}"
                )
            self.weights = (np.arange(surface.size) == at).astype(float)

    def value(self) -> float:
        """Now."""
        return float(self.weights @ self.contact.memory.values[self.name])

    def gradient(self) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives by q and v: nothing."""
        nothing = np.zeros(())
        return nothing, nothing

    def explicit(self, parameter: Parameter) -> float:
        """None."""
        return 0.0
