# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pressures of a rigid solid in space that are not unique: four points on a plane bear a solid in
many ways. Where it slides and turns about the normal, friction, and so the motion, hangs on them.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from .rigid import RigidMotion
from .surface import ContactRows


def hyperstatic(rows: ContactRows) -> bool:
    """Whether points slide and more bear than a solid in space has ways along one normal."""
    motion, status = rows.motion, rows.contact.equations.statuses()
    space = isinstance(motion, RigidMotion) and motion.solid.dim == 3
    return space and int((status > 0).sum()) > 3 and bool((status > 1).any())


def sliding(rows: ContactRows) -> tuple[float, ...]:
    """Reference coordinates of the first point that slides, m."""
    point = int(rows.contact.equations.statuses().argmax())
    return tuple(rows.contact.surface.points[point].tolist())


@contextmanager
def shifted(rows: ContactRows, change: np.ndarray) -> Iterator[ContactRows]:
    """The rows of a contact with other multipliers of the same statuses.

    Args:
        rows: of the contact.
        change: of the multipliers of the candidates, point by point: its direction counts.
    """
    e, points = rows.contact.equations, rows.points
    each = change.reshape(len(points), -1)
    before, values, status = e.values, e.values.copy(), e.statuses()
    kinds = e.jumps + np.arange(each.shape[1])[None] * len(rows.normal) + points[:, None]
    bears = (status[points] > 0) & (each[:, 0] != 0)
    share = 0.5 * np.abs(values[kinds][bears, 0] / each[bears, 0]).min(initial=np.inf)
    same = not np.isfinite(share)
    while not same:
        values[kinds] = before[kinds] + share * each
        e.values = values
        same, share = bool((e.statuses() == status).all()) or share == 0, 0.5 * share
    e.values = before
    with rows.other(points, values) as other:
        yield other
