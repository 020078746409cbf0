# SPDX-License-Identifier: LGPL-3.0-or-later
r"""A semicircular arch of rigid blocks that is tilted until it falls.

Joints bear no tension and slip by Coulomb's law. Without slip an arch stands as long as *some* set
of forces in its joints is in equilibrium with its weight (the safe theorem: J. Heyman, *The Stone
Skeleton*, Int. J. Solids Structures 2, 249-279, 1966): a linear programme. Upright, an arch of very
many blocks with the mean radius R needs the thickness 0.1075 R (M. Milankovitch, *Theorie der
Druckkurven*, Z. Math. Phys. 55, 1-27, 1907).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import linprog

from ..base import checks


def corners(blocks: int, thickness: float) -> np.ndarray:
    """Corners of the blocks of an arch of mean radius 1, from right to left, springing from y = 0:
    (blocks, 4, 2), inner and outer at the lower joint, inner and outer at the upper one.

    Args:
        blocks: two at least, alike, with straight sides.
        thickness: over the mean radius, in (0, 2).

    Raises:
        InputError: a value out of its range.
    """
    checks.whole_number("blocks", blocks, at_least=2)
    half = checks.number("thickness", thickness, above=0) / 2
    if half >= 1:
        raise checks.InputError(f"thickness = {thickness!r}: must be < 2")
    turn = np.linspace(0, np.pi, blocks + 1)
    out = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    joints = np.stack([(1 - half) * out, (1 + half) * out], axis=1)
    return np.concatenate([joints[:-1], joints[1:]], axis=1)


def collapse_tilt(blocks: int, thickness: float, friction: float) -> float:
    """The angle, rad, by which the arch can be tilted before it falls.

    The largest horizontal share of gravity for which forces at the corners of the joints, each
    pressing, all of a joint within friction's cone, hold every block. Exact where the arch falls
    by hinges; where joints slip an upper bound.

    Args:
        blocks, thickness: as of :func:`corners`.
        friction: Coulomb's coefficient, > 0.

    Raises:
        InputError: a value out of its range, an arch that does not even stand upright.
    """
    x = corners(blocks, thickness)
    mu = checks.number("friction", friction, above=0)
    turn = np.linspace(0, np.pi, blocks + 1)
    ahead = np.stack([-np.sin(turn), np.cos(turn)], axis=1)  # across the joints
    away = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    held = np.zeros((blocks, 3, blocks + 1, 4))  # normal and shear forces, inner and outer
    for i in range(2):
        for side, sign in ((0, 1.0), (1, -1.0)):
            point, joint = x[:, 2 * side + i], np.arange(blocks) + side
            for kind, direction in enumerate((ahead, away)):
                force = sign * direction[joint]
                rows = held[np.arange(blocks), :, joint, 2 * kind + i]
                rows[:, :2] = force
                rows[:, 2] = point[:, 0] * force[:, 1] - point[:, 1] * force[:, 0]
                held[np.arange(blocks), :, joint, 2 * kind + i] = rows
    area, middle = _centroids(x[:, [0, 1, 3, 2]])
    aside = area[:, None] * np.stack([np.ones(blocks), np.zeros(blocks), -middle[:, 1]], axis=1)
    weight = area[:, None] * np.stack([np.zeros(blocks), np.ones(blocks), middle[:, 0]], axis=1)
    forces = 4 * (blocks + 1)
    balance = np.hstack([held.reshape(3 * blocks, forces), aside.reshape(-1, 1)])
    cone = np.kron(np.eye(blocks + 1), [[-mu, -mu, 1, 1], [-mu, -mu, -1, -1]])
    found: Any = linprog(
        -np.eye(forces + 1)[forces],
        np.hstack([cone, np.zeros((len(cone), 1))]),
        np.zeros(len(cone)),
        balance,
        weight.ravel(),
        [*[(0, None), (0, None), (None, None), (None, None)] * (blocks + 1), (0, None)],
    )
    if found.status:
        raise checks.InputError(
            f"blocks, thickness, friction = {blocks}, {thickness:g}, {mu:g}: such an arch "
            "falls upright"
        )
    return float(np.arctan(found.x[-1]))


def _centroids(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Areas and centroids of polygons (n, k, 2)."""
    after = np.roll(x, -1, axis=1)
    cross = x[:, :, 0] * after[:, :, 1] - x[:, :, 1] * after[:, :, 0]
    area = cross.sum(axis=1) / 2
    return area, np.einsum("nk,nkd->nd", cross, x + after) / (6 * area[:, None])
