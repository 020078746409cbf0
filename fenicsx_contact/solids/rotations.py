# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rotations in the plane, by an angle (1,), and in space, by a rotation vector (3,)."""

from __future__ import annotations

from math import cos, factorial, isfinite, sin, sqrt
from typing import Any

import numpy as np

from ..base import checks

EYE = np.eye(3)
#: By dimension: what a unit spin about each axis makes of an arm, (spins, d, d).
GENERATORS = {
    2: np.array([[[0.0, -1.0], [1.0, 0.0]]]),
    3: np.array([[[0, 0, 0], [0, 0, -1], [0, 1, 0]],
                 [[0, 0, 1], [0, 0, 0], [-1, 0, 0]],
                 [[0, -1, 0], [1, 0, 0], [0, 0, 0]]], dtype=float),
}  # fmt: skip
#: By dimension: what an arm makes of spins, flat: ``arm @ ARMS[d]`` is (d, spins).
ARMS = {d: G.transpose(2, 1, 0).reshape(d, -1) for d, G in GENERATORS.items()}
#: (w - sin w)/w³ in powers of w², the highest first: to round-off within a turn.
CUBIC = [(-1) ** k / factorial(2 * k + 3) for k in reversed(range(20))]


def angles(name: str, value: Any, size: int) -> np.ndarray:
    """One number in 2D, a vector of three in 3D; a plain 0 is none in both."""
    plain = checks.plain(value)
    if size == 1 or (isinstance(plain, (int, float)) and plain == 0):
        return np.full(size, checks.number(name, value))
    return checks.vector(name, value, size)


def rotation_matrix(increment: np.ndarray) -> np.ndarray:
    """Rotation matrix of an angle (1,) or a rotation vector (3,)."""
    if len(increment) == 1:
        c, s = np.cos(increment[0]), np.sin(increment[0])
        return np.array([[c, -s], [s, c]])
    x, y, z = increment.tolist()
    half = 0.5 * sqrt(x * x + y * y + z * z)
    if not isfinite(half):  # of an iterate that diverges
        return np.full((3, 3), np.nan)
    once, w = 0.5 * sin(half) / half if half else 0.5, cos(half)
    x, y, z = once * x, once * y, once * z  # with w a unit quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def by_spins(arms: np.ndarray) -> np.ndarray:
    """Velocities of the ends of arms (..., d) by unit spins about each axis, (..., d, spins)."""
    d = arms.shape[-1]
    return (arms @ ARMS[d]).reshape(*arms.shape, ARMS[d].shape[-1] // d)


def cross_matrix(a: np.ndarray) -> np.ndarray:
    """A with A b = a x b for vectors (..., 3), (..., 3, 3)."""
    return -by_spins(a)


def turning(way: np.ndarray) -> np.ndarray:
    """By what rotation in space a change of a rotation vector turns further, (3, 3):
    I + (1 - cos w)/w² [w] + (w - sin w)/w³ [w]²."""
    square, W = float(way @ way), cross_matrix(way)
    half = 0.5 * sqrt(square)
    once = sin(half) / half if half else 1.0
    cubic = 0.0
    for each in CUBIC:
        cubic = cubic * square + each
    return EYE + 0.5 * once**2 * W + cubic * W @ W


def turned_tensor(tensor: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Derivative of ``tensor @ vector`` by a rotation that turns the tensor alone; (1, 1) in the
    plane, where tensors are numbers, (3, 3) in space."""
    if len(vector) == 1:
        return np.zeros((1, 1))
    return tensor @ cross_matrix(vector) - cross_matrix(tensor @ vector)
