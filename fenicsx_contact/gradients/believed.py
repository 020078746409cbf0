# SPDX-License-Identifier: LGPL-3.0-or-later
"""What obstacles of one's own say of their derivatives, held against what these are derivatives of.
A run needs them for its pace alone, its derivatives for being right."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..base import checks
from ..base.constants import RIGHT, SHARP
from ..base.vectors import largest
from ..contact.wall import Wall

#: Cost: how long, s, an obstacle's velocity is asked for: any moment will do, but for round-off.
MOMENT = 2.0**-10


def check_derivatives(name: str, wall: Wall, points: np.ndarray) -> None:
    """Refuse an own obstacle whose slopes, curvature or slopes of velocities are not, at these
    points, (n, d) in m, what its distances, normals and velocities change by: at a kink, on neither
    side of it.

    Raises:
        InputError: with what is wrong and where.
    """
    for each in getattr(wall.obstacle, "walls", ()):  # of what it is made
        check_derivatives(name, each, points)
    if wall.ours:
        return
    size = float(np.ptp(points, axis=0).max() or np.abs(points).max() or 1.0)
    reach, rounded = RIGHT * size, np.finfo(float).eps * np.abs(points).max() / (RIGHT * size)
    asked: list[tuple[str, Callable, Callable, float]] = []
    if not wall.flat:
        asked.append(("slopes", wall.distance, wall.slopes, 1.0))
        asked.append(("curvature", wall.normals, wall.curvature, 1 / size))
    if wall.told:

        def velocity(x: np.ndarray, time: float) -> np.ndarray:
            return wall.velocity(x, time, time + MOMENT)

        def slopes(x: np.ndarray, time: float) -> np.ndarray:
            return wall.velocity_slopes(x, time, time + MOMENT)

        asked.append(("velocity_slopes", velocity, slopes, largest(velocity(points, 0.0)) / size))
    for what, value, tell, scale in asked:
        told, here = tell(points, 0.0), value(points, 0.0)
        assert told is not None  # what is smooth tells both
        for axis, way in enumerate(reach * np.eye(wall.dim)):
            mine = told[..., axis].reshape(len(points), -1)
            ahead, back = value(points + way, 0.0) - here, here - value(points - way, 0.0)
            sides = [side.reshape(mine.shape) / reach for side in (ahead, back)]
            off = np.minimum(*(np.linalg.norm(side - mine, axis=1) for side in sides))
            most = np.maximum(*(np.linalg.norm(each, axis=1) for each in (mine, sides[0])))
            wrong = off > (1 - SHARP) * most + (RIGHT + rounded) * scale
            if wrong.any():
                at = int(wrong.argmax())
                raise checks.InputError(
                    f"gradients: contact {name!r}: {what} of its obstacle along {'xyz'[axis]} at "
                    f"{points[at].tolist()} is {mine[at].tolist()}: must be {sides[0][at].tolist()}"
                )
