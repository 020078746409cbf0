# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pressures of rigid solids that are not unique: four points on a plane bear a solid in many ways,
and so do two walls between which it is wedged. Where it slides, friction and with it the motion may
hang on these: by how the friction adds up now, or by how it would after a change of the motion.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager

import numpy as np

from .edge import Edge
from .rigid import RigidMotion
from .surface import ContactRows


def rigid(rows: ContactRows) -> bool:
    """Whether a contact has candidates of a rigid solid."""
    solids = any(isinstance(m, RigidMotion) for m in rows.motions)
    return solids and len(rows.points) > 0


def sliding(rows: ContactRows) -> int | None:
    """The first point of a contact that slides, if one does."""
    slides = np.flatnonzero(rows.contact.equations.statuses() > 1)
    return int(slides[0]) if len(slides) else None


@contextmanager
def shifted(
    contacts: Sequence[ContactRows], changes: Sequence[np.ndarray]
) -> Iterator[list[ContactRows]]:
    """The rows of contacts with other multipliers of the same statuses.

    Args:
        contacts: the contacts.
        changes: of the multipliers of their candidates, point by point, all in one proportion;
            the direction counts.
    """
    ways = [_Way(rows, change) for rows, change in zip(contacts, changes)]
    share = 0.5 * min(way.reach for way in ways)
    while np.isfinite(share) and share > 0 and not all(way.keeps(share) for way in ways):
        share *= 0.5
    with ExitStack() as stack:
        edges = [(way.rows, Edge(way.rows.points, [], way.values(share))) for way in ways]
        yield [stack.enter_context(rows.other(edge)) for rows, edge in edges]


class _Way:
    """A change of the multipliers of a contact.

    Attributes:
        rows: of the contact.
        reach: by how many times of it the first pressure would vanish; infinite if none changes.
    """

    def __init__(self, rows: ContactRows, change: np.ndarray) -> None:
        self.rows, e, points = rows, rows.contact.equations, rows.points
        self._change = change.reshape(len(points), -1)
        kinds = np.arange(self._change.shape[1]) * len(rows.normal)
        self._places = e.jumps + kinds + points[:, None]
        self._values, self._statuses = e.values.copy(), e.statuses()
        pressure, by = self._values[self._places][:, 0], self._change[:, 0]
        bears = (self._statuses[points] > 0) & (by != 0)
        self.reach = float(np.abs(pressure[bears] / by[bears]).min(initial=np.inf))

    def values(self, share: float) -> np.ndarray:
        """The unknowns after as many times of it; as they are where it cannot be told."""
        result = self._values.copy()
        if np.isfinite(share):
            result[self._places] += share * self._change
        return result

    def keeps(self, share: float) -> bool:
        """Whether all statuses stay."""
        e = self.rows.contact.equations
        with e.being(self.values(share)):
            return bool((e.statuses() == self._statuses).all())
