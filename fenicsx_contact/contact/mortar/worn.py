# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where a surface is that has worn back: its nodes stay, what meets the other side recedes.

Facets of these places are paired, so that gaps, normals and what slides along them are those of the
worn surface; where it wears unevenly it tilts against the facets by the gradient of the depth.
"""

from __future__ import annotations

import numpy as np

from .integration import whole
from .matrices import add_up
from .side import Side


class Receding:
    """How the nodes of a side recede as the surface wears: at the corners against the mean of the
    normals there, so that each facet goes as far as they have worn.

    Args:
        side: the slave's.
        places: of the nodes, its own before any others, (N, d) in m.
    """

    def __init__(self, side: Side, places: np.ndarray) -> None:
        self._side, self._rule = side, whole(side)
        self._among = side.linear_shape(side.element.points)  # of the nodes among the corners
        self.start(places)

    def start(self, places: np.ndarray) -> None:
        """Wear along the normals in these places from now on."""
        side, rule = self._side, self._rule
        normals = side.normals(places, rule.facet, side.shape(rule.xi)[1])
        share = (side.linear_shape(rule.xi) * rule.weight[:, None])[:, :, None]
        rows, n = side.corners[rule.facet].ravel(), int(side.corners.max()) + 1
        sizes = np.linalg.norm(normals, axis=1)[:, None]
        sums = [(share * each[:, None]).reshape(len(rows), -1) for each in (normals, sizes)]
        mean, area = (add_up(each, rows, n) for each in sums)
        self._back = -mean * area / (mean**2).sum(axis=1, keepdims=True)

    def receded(self, places: np.ndarray, depth: np.ndarray | float) -> np.ndarray:
        """Places of the nodes, (N, d), where the corners have worn by these depths, (n,) in m, and
        other nodes of a facet go with them."""
        side, moved = self._side, places.copy()
        back = np.reshape(depth, (-1, 1)) * self._back
        moved[side.cells] += self._among @ back[side.corners]
        return moved
