# SPDX-License-Identifier: LGPL-3.0-or-later
"""Obstacles bounded by triangles, as they come in STL files: with flat faces, or smooth."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import meshio
import numpy as np
import scipy.sparse as sp

from ...base import checks
from ...base.constants import ROUND_OFF, SAME, SHARP
from ...base.mesh_files import read_mesh
from ...base.shown import marked
from ...base.vectors import cross, normalised
from ..mortar.matrices import add_up
from .last import Last
from .triangles import Triangles, first_of_each


class _Beside(NamedTuple):
    """What is beside points: distances (n,), normals (n, 3), their derivatives (n, 3, 3)."""

    distance: np.ndarray
    normals: np.ndarray
    curvature: np.ndarray


class Triangulated:
    """What a closed surface of triangles encloses; all but that if they are clockwise.

    **Flat faces** have exact distances. **Smooth**, the surface is curved through the same points:
    its normals are those of the points, between them their means, and it bulges over a face by

        h = sum b_i n_i (x_i - q) / (1 + |sum b_i n_i|),     q = sum b_i x_i,

    which is exact for spheres and elsewhere of nearly third order in the size of the triangles;
    flat faces are of second. A point lies above the q from which the mean normal leads to it.
    Distance and normals are continuous across edges. Normals of points are N. Max's sums (J.
    Graphics Tools 4(2), 1-6, 1999), exact for spheres too. Where two faces meet at more than 26
    degrees the edge stays sharp, and as straight as it is given: a point there has a normal on each
    side. The nearest face tells the side; beyond such edges, and inside, deeper than the surface is
    curved, flat faces take over.

    Args:
        surface: path of an STL file, or of any other that meshio reads, or a ``meshio.Mesh``, with
            triangles; lengths in m. Equal points are one.
        smooth: curved between its points.

    Raises:
        InputError: not readable, no triangles or others too, triangles without area, a surface
            that is not closed or not of one orientation; smooth and folded up at a point.
    """

    flat = False
    dim = 3

    def __init__(self, surface: str | Path | meshio.Mesh, smooth: bool = False) -> None:
        self.smooth = checks.truth("smooth", smooth)
        self._triangles = Triangles(*_read(surface))
        self._extent = float(np.ptp(self._triangles.points, axis=0).max())
        self._beside = Last(self._find)
        if self.smooth:
            fans, bent = self._triangles.fans(SHARP)
            self._sharp = int(bent.sum()) // 2
            self._normals = self._point_normals(fans)
            self._juts = self._out_of_edges(bent)
            rows = np.repeat(np.arange(len(fans)), 3)
            meets = sp.csr_matrix((np.ones(fans.size), (rows, fans.ravel())))
            self._ring = (meets @ meets.T).tocsr()  # the triangles that share a fan with each
            self.curvature = self._curvature

    def _point_normals(self, fans: np.ndarray) -> np.ndarray:
        """Unit normals at the corners of the triangles by their fans, (m, 3, 3)."""
        t = self._triangles
        square = (t.edges**2).sum(axis=2)
        area = cross(t.edges[:, 0], t.edges[:, 1])
        weight = 1 / (square * np.roll(square, 1, axis=1))  # of the two edges that meet there
        total = add_up(weight[:, :, None] * area[:, None], fans, int(fans.max()) + 1)[fans]
        folded = (np.einsum("mid,md->mi", total, t.normals) <= 0).any(axis=1)
        if folded.any():
            at = t.corners[folded][0].mean(axis=0).tolist()
            raise checks.InputError(
                f"smooth = True: the surface is folded up near {at}, its points have no normals; "
                "smooth=False takes its faces as they are"
            )
        return normalised(total)

    def _out_of_edges(self, bent: np.ndarray) -> float:
        """How far curved faces are from sharp edges, (m, 3) of bool, which are straight, m."""
        x, n = self._triangles.corners, self._normals
        ends, sums = x - np.roll(x, -1, axis=1), n + np.roll(n, -1, axis=1)
        along = np.einsum("mid,mid->mi", n - np.roll(n, -1, axis=1), ends) / 4
        bulge = along / (1 + np.linalg.norm(sums, axis=2) / 2)
        return float(np.abs(bulge[bent]).max(initial=0.0))

    @property
    def remark(self) -> str:
        """What a reader of a run should know of it."""
        if not self.smooth or self._juts <= SAME * self._extent:
            return ""
        return (
            f"a smooth surface bulges by up to {self._juts:.3g} m over sharp edges, which are as "
            "straight as they are given: distances jump there. smooth=False has no jumps, nor has "
            "a formula (Revolution, LevelSet)"
        )

    # -- beside points --------------------------------------------------------------------------

    def _find(self, points: np.ndarray) -> _Beside:
        """What is beside the points."""
        cells, shares = self._triangles.nearest(points)
        flat = self._beside_faces(points, cells, shares)
        return self._beside_curved(points, cells, flat) if self.smooth else flat

    def _beside_faces(self, points: np.ndarray, cells: np.ndarray, shares: np.ndarray) -> _Beside:
        t = self._triangles
        off, pseudo = points - t.at(cells, shares), t.pseudo_normals(cells, shares)
        size = np.linalg.norm(off, axis=1)
        sign = np.where((off * pseudo).sum(axis=1) < 0, -1.0, 1.0)
        # before a face its own normal, which round-off cannot turn
        turned = ((shares == 0).any(axis=1)) & (size > ROUND_OFF * self._extent)
        away = (sign / np.where(turned, size, 1.0))[:, None] * off
        normals = np.where(turned[:, None], away, pseudo)
        return _Beside(sign * size, normals, np.zeros((len(points), 3, 3)))

    def _beside_curved(self, points: np.ndarray, cells: np.ndarray, flat: _Beside) -> _Beside:
        """By the face about the nearest one over which each point lies, if there is one."""
        ring = self._ring[cells]
        owner = np.repeat(np.arange(len(points)), np.diff(ring.indptr))
        shares, height, slopes = self._above(points[owner], ring.indices)
        over, shares, height, slopes, cells = first_of_each(
            owner, -shares.min(axis=1), -shares.min(axis=1), shares, height, slopes, ring.indices
        )
        x, n = self._triangles.corners[cells], self._normals[cells]
        mean = np.einsum("ni,nid->nd", shares, n)
        size = np.linalg.norm(mean, axis=1)
        unit = mean / size[:, None]
        q = np.einsum("ni,nid->nd", shares, x)
        bulge = np.einsum("ni,nid,nid->n", shares, n, x - q[:, None]) / (1 + size)
        turn = np.einsum("nid,nij->ndj", n[:, 1:] - n[:, :1], slopes) / size[:, None, None]
        turn = turn - unit[:, :, None] * np.einsum("nd,ndj->nj", unit, turn)[:, None]
        here = over <= SAME
        return _Beside(
            np.where(here, height * size - bulge, flat.distance),
            np.where(here[:, None], unit, flat.normals),
            np.where(here[:, None, None], turn, flat.curvature),
        )

    def _above(
        self, points: np.ndarray, cells: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Shares b and heights D with p = sum b_i (x_i + D n_i), by Newton's method, and the
        derivatives of b_1 and b_2 by p, (n, 2, 3)."""
        x, n = self._triangles.corners[cells], self._normals[cells]
        b = self._triangles.shares(points, cells)
        q, mean = np.einsum("ni,nid->nd", b, x), np.einsum("ni,nid->nd", b, n)
        D = ((points - q) * mean).sum(axis=1) / (mean**2).sum(axis=1)
        change, falls = np.full(len(points), np.inf), np.ones(len(points), dtype=bool)
        while falls.any():  # each down to round-off
            level = x + D[:, None, None] * n
            mean = np.einsum("ni,nid->nd", b, n)
            first, second = level[:, 1] - level[:, 0], level[:, 2] - level[:, 0]
            rows = np.stack([cross(second, mean), cross(mean, first), cross(first, second)], axis=1)
            det = (rows[:, 0] * first).sum(axis=1)
            rows = rows / np.where(det == 0, np.inf, det)[:, None, None]
            way = np.einsum("nij,nj->ni", rows, points - np.einsum("ni,nid->nd", b, level))
            last, change = change, np.abs(way[:, :2]).max(axis=1)
            change = change + np.abs(way[:, 2]) / self._extent
            falls = falls & (change < last)
            way = np.where(falls[:, None], way, 0.0)
            b = b + np.stack([-way[:, 0] - way[:, 1], way[:, 0], way[:, 1]], axis=1)
            D = D + way[:, 2]
        lost = ~np.isfinite(b).all(axis=1) | (det == 0)
        b = np.where(lost[:, None], -1.0, b)  # over no face
        return b, D, rows[:, :2]

    def distance(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Signed distance of the points (n, 3), positive outside."""
        return self._beside(points).distance

    def normals(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Outward unit normals, (n, 3)."""
        return self._beside(points).normals

    def _curvature(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Derivatives of the normals, (n, 3, 3), if the surface is smooth."""
        return self._beside(points).curvature

    def __repr__(self) -> str:
        sharp = f", {self._sharp} edges sharp" if self.smooth else ""
        t = self._triangles
        many = marked(f"{len(t.cells)} triangles", t.points, t.cells)
        return f"Triangulated({many}, smooth={self.smooth}{sharp})"


def _read(surface: Any) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles of a file or a mesh."""
    name = f"surface = {str(surface)!r}"
    checks.instance("surface", surface, (str, Path, meshio.Mesh), "a path or a meshio.Mesh")
    if not isinstance(surface, meshio.Mesh):
        try:
            surface = read_mesh(Path(surface))
        except checks.InputError as problem:
            raise checks.InputError(f"{name}: {problem}") from None
    kinds = {block.type for block in surface.cells}
    points = np.asarray(surface.points, dtype=float)
    if not np.isfinite(points).all():
        at = int(np.argmin(np.isfinite(points).all(axis=1)))
        raise checks.InputError(
            f"{name}: its points must be finite; point {at} is {points[at].tolist()}"
        )
    if kinds != {"triangle"} or points.shape[1:] != (3,):
        raise checks.InputError(
            f"{name}: must hold triangles in space and nothing else, it has {sorted(kinds)}"
        )
    return points, np.concatenate([block.data for block in surface.cells]).astype(int)
