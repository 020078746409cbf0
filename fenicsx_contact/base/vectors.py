# SPDX-License-Identifier: LGPL-3.0-or-later
"""Of arrays of numbers and vectors, what is asked for often: by few calls, for arrays are small."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isnan, sqrt

import numpy as np

_ONES = np.ones(3)


def largest(values: np.ndarray) -> float:
    """The largest absolute value; 0 of none, NaN where there is one."""
    sizes = np.abs(values)
    return float(sizes.item(sizes.argmax())) if sizes.size else 0.0


def worst(errors: Sequence[float]) -> float:
    """The largest of a few, none of them negative; 0 of none, NaN where there is one."""
    whole = sum(errors)
    return whole if isnan(whole) else float(max(errors, default=0.0))


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Scalar products of vectors (..., d), point by point, (...,)."""
    return np.asarray((a * b) @ _ONES[: a.shape[-1]])


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Vector products a x b of vectors (..., 3)."""
    result = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.subtract(a[..., j] * b[..., k], a[..., k] * b[..., j], out=result[..., i])
    return result


def longest(vectors: np.ndarray) -> float:
    """The largest length of vectors (n, d); 0 of none, NaN where there is one."""
    return sqrt(largest(dot(vectors, vectors)))


def spread(vectors: np.ndarray) -> float:
    """At least how far vectors (n, d) differ from each other, at most twice that: the same in all
    axes, and whatever they have in common."""
    return 2 * longest(vectors - vectors.mean(axis=0)) if len(vectors) else 0.0


def normalised(vectors: np.ndarray) -> np.ndarray:
    """Vectors (..., d) at length 1."""
    return np.asarray(vectors / np.sqrt(dot(vectors, vectors))[..., None])


def components(points: np.ndarray, d: int) -> np.ndarray:
    """Where the d components of points (n,) stand among those of all, (n d,)."""
    return (points[:, None] * d + np.arange(d)).ravel()


def slices(sizes: Iterable[int]) -> list[slice]:
    """Where parts of these sizes stand, one after another."""
    bounds = np.cumsum([0, *sizes])
    return [slice(a, b) for a, b in zip(bounds[:-1], bounds[1:])]


def across(normal: np.ndarray) -> np.ndarray:
    """Unit vectors (n, 3) orthogonal to these normals, by the axis that is least along each."""
    return normalised(cross(np.eye(3)[np.abs(normal).argmin(axis=1)], normal))


def orthogonal(normal: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """The parts of vectors (n, d) that are orthogonal to these normals."""
    return np.asarray(vectors - dot(vectors, normal)[:, None] * normal)


def beside(normal: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Unit vectors (n, 3) orthogonal to these normals, as near as can be to some others."""
    return normalised(orthogonal(normal, vectors))


def turned_with(vectors: np.ndarray, old: np.ndarray, new: np.ndarray) -> np.ndarray:
    """Vectors (n, d) orthogonal to old normals, turned by the least rotations that take these to
    new ones: mirrored at the planes across the sums of both. With opposite ones they stay."""
    both = old + new
    size = np.maximum(dot(both, both), np.finfo(float).tiny)
    return np.asarray(vectors - (2 * dot(vectors, both) / size)[:, None] * both)
