# SPDX-License-Identifier: LGPL-3.0-or-later
"""The kinetic energy that contacts can know of: that of what moves in common is none of theirs.

Bodies that may touch each other form a group. One that only contacts hold, and that meets no
obstacle, has as much energy for them as it has relative to its common velocity: whoever moves along
sees no more. An obstacle says what is at rest, and so does a support.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from ..contact.contact import Contact
from ..solids import Solid


class Frames:
    """Groups of solids, and how they move in common.

    Args:
        solids, contacts: all of a scene.

    Attributes:
        most: the largest energy so far that was asked for, J.
    """

    def __init__(self, solids: Sequence[Solid], contacts: Sequence[Contact]) -> None:
        number = {id(solid): i for i, solid in enumerate(solids)}
        links = [[number[id(s)] for s in contact.solids] for contact in contacts]
        ends = np.array([(of[0], each) for of in links for each in of], dtype=int).reshape(-1, 2).T
        graph = coo_matrix((np.ones(ends.shape[1]), tuple(ends)), (len(solids),) * 2)
        of_solid = connected_components(graph, directed=False)[1]
        groups = range(of_solid.max(initial=-1) + 1)
        bodies = [[s for s, at in zip(solids, of_solid) if at == k] for k in groups]
        met = [[c for c, of in zip(contacts, links) if of_solid[of[0]] == k] for k in groups]
        self._groups = [each for each in zip(bodies, met) if _may_drift(*each)]
        self.most = 0.0

    def energy(self, energies: tuple[float, float, float]) -> float:
        """The largest kinetic and strain energy that contacts knew of, up to the start of the begun
        step, J, from the kinetic, strain and potential energy there."""
        kinetic, strain, _ = energies
        kinetic -= sum(self._common(bodies, contacts) for bodies, contacts in self._groups)
        self.most = max(self.most, kinetic + abs(strain))
        return self.most

    @staticmethod
    def _common(bodies: Sequence[Solid], contacts: Sequence[Contact]) -> float:
        mass, momentum = 0.0, np.zeros(bodies[0].dim)
        for body in bodies:
            if (drift := _drift(body)) is None:
                return 0.0
            mass, momentum = mass + drift[0], momentum + drift[1]
        told = [v for c in contacts if (v := c.coupling.drift()) is not None]
        velocities = told or [momentum / mass]
        return min(float(momentum @ v - 0.5 * mass * (v @ v)) for v in velocities)


def _may_drift(bodies: Sequence[Solid], contacts: Sequence[Contact]) -> bool:
    """Whether something is at rest for a group that is not at rest for all."""
    walls = [contact.coupling for contact in contacts if contact.coupling.drift() is not None]
    standing = walls and not any(wall.driven for wall in walls)
    return not standing and all(_drift(body) is not None for body in bodies)


def _drift(body: Any) -> tuple[float, np.ndarray] | None:
    """Mass [kg] and momentum (d,) [kg m/s] of a solid, or None where it does not tell them, or
    where it is not only contacts that hold it: it can tell then what is at rest."""
    return body.drift() if hasattr(body, "drift") else None
