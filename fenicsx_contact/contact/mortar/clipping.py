# SPDX-License-Identifier: LGPL-3.0-or-later
"""Polygons in a plane, many at once: what each of two has in common, as triangles.

A polygon is an array (corners, 2) in the order of its outline, either way round; a set of polygons
has as many corners as the one with the most, and those with fewer repeat the first at the end: an
edge without length cuts nothing and holds nothing. So nothing here needs a tolerance: what only
touches has an area of round-off, and corners on edges may be taken as inside or outside.
"""

from __future__ import annotations

import basix
import numpy as np

from .matrices import add_up


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a x b of vectors (..., 2)."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def clip(subject: np.ndarray, window: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What each polygon (q, v, 2) has in common with a convex window (q, k, 2), counterclockwise:
    numbers of those that have (r,), polygons (r, w, 2), and of which edge of the subject the edges
    that begin at the corners are part, (r, w), or, as -1 - edge, of which of the window.

    Sutherland and Hodgman, Commun. ACM 17, 1974: one edge of all windows after the other.
    """
    which = np.arange(len(subject))
    edges = np.tile(np.arange(subject.shape[1]), (len(subject), 1))
    for edge in range(window.shape[1]):
        start = window[which, edge]
        along = window[which, (edge + 1) % window.shape[1]] - start
        depth = cross(along[:, None], subject - start[:, None])
        within = (depth > 0).any(axis=1)
        which, subject, edges, depth = (x[within] for x in (which, subject, edges, depth))
        if len(which):
            subject, edges = _cut(subject, edges, depth, -1 - edge)
    return which, subject, edges


def _cut(
    polygon: np.ndarray, edges: np.ndarray, depth: np.ndarray, line: int
) -> tuple[np.ndarray, np.ndarray]:
    """What lies on the inner side of a line, at whose depths (q, v) the corners (q, v, 2) are."""
    inside = depth >= 0
    after, depth_after = np.roll(polygon, -1, axis=1), np.roll(depth, -1, axis=1)
    crosses = inside != np.roll(inside, -1, axis=1)
    fraction = depth / np.where(crosses, depth - depth_after, 1.0)
    crossing = polygon + fraction[..., None] * (after - polygon)
    q, v = depth.shape
    corners = np.stack([polygon, crossing], axis=2).reshape(q, 2 * v, 2)
    edges = np.stack([edges, np.where(inside, line, edges)], axis=2).reshape(q, 2 * v)
    kept = np.stack([inside, crosses], axis=2).reshape(q, 2 * v)
    count = kept.sum(axis=1)
    order = np.argsort(~kept, axis=1, kind="stable")[:, : count.max()]
    order = np.where(np.arange(order.shape[1]) < count[:, None], order, order[:, :1])
    corners = np.take_along_axis(corners, order[..., None], axis=1)
    return corners, np.take_along_axis(edges, order, axis=1)


def corners(polygons: np.ndarray, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Corners of what :func:`clip` found, each once: numbers of polygons (r,), places (r, 2), and
    of which edges those are part that end and begin there, (r, 2)."""
    w = polygons.shape[1]
    real = (np.roll(polygons, -1, axis=1) != polygons).any(axis=2)  # with a length
    last = np.maximum.accumulate(np.where(np.tile(real, 2), np.arange(2 * w), -1), axis=1)
    before = np.take_along_axis(edges, last[:, w - 1 : -1] % w, axis=1)
    return np.nonzero(real)[0], polygons[real], np.stack([before[real], edges[real]], axis=1)


def covers(polygons: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Whether convex polygons (q, v, 2) hold points (q, 2), (q,)."""
    along = np.roll(polygons, -1, axis=1) - polygons
    depth = cross(along, points[:, None] - polygons)
    return (depth >= 0).all(axis=1) | (depth <= 0).all(axis=1)


def fans(polygons: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Triangles from the middle of each polygon (q, v, 2) to its edges, those without area left
    out: numbers of polygon and edge, (r,) each, and corners (r, 3, 2)."""
    after = np.roll(polygons, -1, axis=1)
    real = (after != polygons).any(axis=2)  # not what fills up at the end
    middle = (polygons * real[..., None]).sum(axis=1) / np.maximum(real.sum(axis=1), 1)[:, None]
    apex = np.broadcast_to(middle[:, None], polygons.shape)
    triangles = np.stack([apex, polygons, after], axis=2)
    polygon, edge = np.nonzero(areas(triangles) != 0)
    return polygon, edge, triangles[polygon, edge]


def points(
    polygon: np.ndarray, triangles: np.ndarray, degree: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points that integrate polynomials of a degree over the polygons whose :func:`fans` these are:
    numbers (r,), points (r, g, 2) and weights (r, g), for each triangle, or for each polygon."""
    if degree > 2:
        local, weight = basix.make_quadrature(basix.CellType.triangle, degree)
        places = triangles[:, :1] + local @ (triangles[:, 1:] - triangles[:, :1])
        return polygon, places, 2 * np.abs(areas(triangles))[:, None] * weight
    number, places, area = three_points(polygon, triangles)
    return number, places, area[:, None].repeat(3, axis=1) / 3


def three_points(
    polygon: np.ndarray, triangles: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of the polygons whose :func:`fans` these are: numbers (r,), points (r, 3, 2) and areas (r,).
    The points, each with a third of the area, integrate quadratic polynomials.

    They have the moments of the polygon: with its mean m and covariance L L' they are
    m + sqrt(2) L u  of three unit vectors u at 120 degrees, on an ellipse that lies within any
    convex figure (in a triangle it is Steiner's).
    """
    number, polygon = np.unique(polygon, return_inverse=True)
    area, n = np.abs(areas(triangles)), len(number)
    total = np.bincount(polygon, area, n)
    share = (area / total[polygon])[:, None]
    corners = triangles - triangles[:, :1]
    first = add_up(share * corners.sum(axis=1) / 3, polygon, n)
    # of a triangle with a corner at 0: (a a' + b b' + (a + b) (a + b)') / 12
    arms = np.concatenate([corners[:, 1:], corners.sum(axis=1, keepdims=True)], axis=1)
    second = (np.swapaxes(arms, 1, 2) @ arms).reshape(-1, 4)[:, [0, 1, 3]] / 12
    xx, xy, yy = (add_up(share * second, polygon, n) - first[:, [0, 0, 1]] * first[:, [0, 1, 1]]).T
    long = np.sqrt(np.maximum(xx, 0))
    skew = xy / np.where(long > 0, long, 1.0)
    wide = np.sqrt(np.maximum(yy - skew**2, 0))
    # turned by any angle; by this one none lies on an edge of a half square
    angle = 2 * np.pi / 3 * (np.arange(3) + 0.25)
    u = np.sqrt(2) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    factor = np.stack([long, skew, np.zeros(n), wide], axis=1).reshape(n, 2, 2)  # L'
    apex = np.zeros((n, 2))
    apex[polygon] = triangles[:, 0]
    return number, (apex + first)[:, None] + u @ factor, total


def areas(polygons: np.ndarray) -> np.ndarray:
    """Areas of polygons (..., v, 2), positive if counterclockwise."""
    arms = polygons - polygons[..., :1, :]
    return cross(arms[..., 1:-1, :], arms[..., 2:, :]).sum(axis=-1) / 2


def gauss(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss's rule on [0, 1]."""
    x, w = np.polynomial.legendre.leggauss(n)
    return (x + 1) / 2, w / 2
