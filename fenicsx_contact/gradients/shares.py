# SPDX-License-Identifier: LGPL-3.0-or-later
"""How contacts share what they bear together, a corner between two walls or a solid wedged between
them, is not unique: neither is the derivative of what one of them bears, that of their sum is."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .bearing import OfContact
from .kinks import alike
from .linearise import Linearisation
from .quantities import Quantity
from .seeds import gradient


class Shares:
    """Tells what hangs on such shares, of the step that was linearised last.

    Args:
        linear: linearises the steps.
        quantities: by name.
        forces: for each contact, names for what it bears along the axes.
    """

    def __init__(
        self,
        linear: Linearisation,
        quantities: Mapping[str, Quantity],
        forces: list[list[str]] | None = None,
    ) -> None:
        self._linear, self._forces = linear, forces or []
        self._of = {n: q for n, q in quantities.items() if isinstance(q, OfContact)}

    def __call__(self) -> dict[str, tuple[float, float]]:
        """By how much each of them changes by another way to share, which no row tells, and what
        that adds up from; of what contacts bear only, if there is one."""
        linear = self._linear
        idle = linear.last.idle() if len(linear.contacts) > 1 else None
        if idle is None:
            return {}
        rows = {n: gradient(linear, q, len(idle)) for n, q in self._of.items()}
        for names, at in zip(self._forces, linear.last.forces):
            for i, name in enumerate(names):  # point by point
                rows[name] = np.zeros(len(idle))
                rows[name][at][i :: len(names)] = 1.0
        return {n: (float(by @ idle), float(np.abs(by) @ np.abs(idle))) for n, by in rows.items()}


def hangs(change: float, terms: float) -> bool:
    """Whether something hangs on it."""
    return not alike(np.array([change]), np.array([terms])).all()
