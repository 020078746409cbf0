# SPDX-License-Identifier: LGPL-3.0-or-later
"""What obstacles of one's own say of their derivatives, held against what these are derivatives of.
A run needs them for its pace alone, its derivatives for being right."""

from __future__ import annotations

import numpy as np

from ..base import checks
from ..base.constants import RIGHT, SHARP
from ..contact.wall import Wall


def check_derivatives(name: str, wall: Wall, points: np.ndarray) -> None:
    """Refuse an own obstacle whose slopes or curvature are not, at these points, (n, d) in m, what
    its distances and normals change by: at a kink, on neither side of it.

    Raises:
        InputError: with what is wrong and where.
    """
    if wall.ours or wall.flat:
        return
    size = float(np.ptp(points, axis=0).max() or np.abs(points).max() or 1.0)
    reach, rounded = RIGHT * size, np.finfo(float).eps * np.abs(points).max() / (RIGHT * size)
    asked = ("slopes", wall.distance, wall.slopes), ("curvature", wall.normals, wall.curvature)
    for power, (what, value, tell) in enumerate(asked):
        told, here = tell(points, 0.0), value(points, 0.0)
        assert told is not None  # what is smooth tells both
        for axis, way in enumerate(reach * np.eye(wall.dim)):
            mine = told[..., axis].reshape(len(points), -1)
            ahead, back = value(points + way, 0.0) - here, here - value(points - way, 0.0)
            sides = [side.reshape(mine.shape) / reach for side in (ahead, back)]
            off = np.minimum(*(np.linalg.norm(side - mine, axis=1) for side in sides))
            most = np.maximum(*(np.linalg.norm(each, axis=1) for each in (mine, sides[0])))
            wrong = off > (1 - SHARP) * most + (RIGHT + rounded) / size**power
            if wrong.any():
                at = int(wrong.argmax())
                raise checks.InputError(
                    f"gradients: contact {name!r}: {what} of its obstacle along {'xyz'[axis]} at "
                    f"{points[at].tolist()} is {mine[at].tolist()}: must be {sides[0][at].tolist()}"
                )
