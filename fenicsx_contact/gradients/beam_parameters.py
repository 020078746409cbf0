# SPDX-License-Identifier: LGPL-3.0-or-later
"""Parameters of beams and of the guides around them; see also :class:`~.obstacles.Bend`."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import Any

import numpy as np

from ..base import checks
from ..base.constants import SAME
from ..contact.contact import Contact
from ..rods import GuideContact
from ..rods.beam import BeamSolid
from ..rods.drive import AxialLaw
from ..solids import Solid
from .duals import Dual, Sided
from .parameters import OfSolid, Parameter, among


class DriveLaw(OfSolid):
    """A number of the law that drives a beam along its axis, which an own law must read whenever it
    is asked: of what a constructor made of it nothing is known.

    Args:
        solid: the beam.
        name: of the number, in the law or in what the law has: ``"drive_friction"``,
            ``"water.before"``.

    Raises:
        InputError: no such number stands in the law.
    """

    def __init__(self, solid: BeamSolid, name: str) -> None:
        self.solid = checks.instance("solid", solid, BeamSolid, "a BeamSolid")
        of, path = solid.law, checks.label("name", name).split(".")
        self._laws: list[AxialLaw] = [_with_dual(of, name, path, side) for side in (0, 1, -1)]

    def law(self, solid: Solid, side: int = 0) -> AxialLaw | None:
        return self._laws[side] if solid is self.solid else None


def _with_dual(thing: Any, name: str, path: Sequence[str], side: int) -> Any:
    """A copy of a thing, in which the number at the end of a path carries its derivative."""
    value = getattr(thing, path[0], None)
    if len(path) > 1:
        value = _with_dual(value, name, path[1:], side)
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        value = Sided(float(value), np.full(1, side)) if side else Dual(float(value), np.ones(1))
    else:
        raise checks.InputError(f"name = {name!r}: must be that of a number of {thing!r}")
    result = copy(thing)
    object.__setattr__(result, path[0], value)  # of frozen ones, too, and without their checks
    return result


class Stiffness(OfSolid):
    """The stiffness of a beam against bending, as a multiple of what it is: of all its sections,
    and of their shear.

    Raises:
        InputError: a beam with springs or tension, which stay the same: in impacts nodes without
            mass follow by the ratio of both.
    """

    def __init__(self, solid: BeamSolid) -> None:
        self.solid: BeamSolid = checks.instance("solid", solid, BeamSolid, "a BeamSolid")
        k = solid.matrices
        rigid = np.zeros((2, len(k.bending_mass)))
        rigid[:, ::2], rigid[1, 1::2] = [np.ones(len(k.s)), k.s], 1.0
        if np.abs(k.bending_stiffness @ rigid.T).max() > SAME * np.abs(k.bending_stiffness).max():
            raise checks.InputError(f"Stiffness: solid {solid.name!r} has springs or tension")

    def internal(self, solid: Solid, displacement: np.ndarray) -> np.ndarray | float:
        return self.solid.unknowns.stiffness @ displacement if solid is self.solid else 0.0


class Widening(Parameter):
    """The clearances of a guide, all wider by as much, m.

    Args:
        contact: of a beam with the guide.

    Raises:
        InputError: no guide.
    """

    def __init__(self, contact: GuideContact) -> None:
        self.contact = checks.instance("contact", contact, GuideContact, "a GuideContact")

    def widened(self, contact: Contact, depth: np.ndarray) -> np.ndarray | float:
        return np.ones(len(depth)) if contact is self.contact else 0.0

    def check(self, solids: Sequence[Solid], contacts: Sequence[Contact]) -> None:
        among("Widening", self.contact, contacts)
