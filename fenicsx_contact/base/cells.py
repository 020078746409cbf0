# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cells of first and second degree: their nodes, those of their facets, which way round they are.

The nodes of a cell stand in basix's order: corners, middles of edges, of faces, of the cell.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import basix
import numpy as np

from . import compat
from .constants import SAME

#: Of each cell its facet, and how many nodes it has by degree.
FACET = {
    "triangle": "interval",
    "quadrilateral": "interval",
    "tetrahedron": "triangle",
    "hexahedron": "quadrilateral",
}
NODES = {
    "interval": (2, 3),
    "triangle": (3, 6),
    "quadrilateral": (4, 9),
    "tetrahedron": (4, 10),
    "hexahedron": (8, 27),
}
#: What a solid may be made of, for messages.
ALLOWED = (
    "triangles (of 3 or 6 nodes) or quadrilaterals (4 or 9) in 2D, tetrahedra (4 or 10) or "
    "hexahedra (8 or 27) in 3D, of one type"
)
#: The straight facets between all nodes of one of second degree, in the order of the first.
PIECES = {
    "interval": [[0, 2], [2, 1]],
    "triangle": [[0, 5, 4], [5, 1, 3], [4, 3, 2], [3, 4, 5]],
    "quadrilateral": [[0, 4, 5, 8], [4, 1, 8, 6], [5, 8, 2, 7], [8, 6, 7, 3]],
}
#: Of a cell of so many nodes meshio's name, and which of meshio's nodes basix's are.
TO_MESHIO: dict[str, dict[int, tuple[str, list[int]]]] = {
    "interval": {2: ("line", [0, 1]), 3: ("line3", [0, 1, 2])},
    "triangle": {3: ("triangle", [0, 1, 2]), 6: ("triangle6", [0, 1, 2, 4, 5, 3])},
    "quadrilateral": {
        4: ("quad", [0, 1, 3, 2]),
        9: ("quad9", [0, 1, 3, 2, 4, 7, 5, 6, 8]),
    },
    "tetrahedron": {
        4: ("tetra", [0, 1, 2, 3]),
        10: ("tetra10", [0, 1, 2, 3, 9, 8, 5, 7, 6, 4]),
    },
    "hexahedron": {
        8: ("hexahedron", [0, 1, 3, 2, 4, 5, 7, 6]),
        27: (
            "hexahedron27",
            [
                *(0, 1, 3, 2, 4, 5, 7, 6),
                *(8, 11, 16, 9, 17, 10, 19, 18, 12, 15, 13, 14),
                *(24, 22, 20, 21, 23, 25, 26),
            ],
        ),
    },
}


@cache
def lagrange(cell: str, degree: int) -> basix.finite_element.FiniteElement:
    """The Lagrange element of a cell, its nodes evenly spaced."""
    kind, variant = getattr(basix.CellType, cell), basix.LagrangeVariant.equispaced
    return basix.create_element(basix.ElementFamily.P, kind, degree, variant)


def degree_of(cell: str, nodes: int) -> int:
    """The degree of a cell of so many nodes; 0 if there is none such."""
    return NODES[cell].index(nodes) + 1 if nodes in NODES[cell] else 0


def facet_nodes(mesh: Any, facets: np.ndarray, degree: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Of facets of a mesh, by local numbers, the geometry nodes, (m, k): all of a geometry of a
    degree, or the corners; and those of a cell behind each, (m, nodes). Local indices."""
    tdim, nodes, cell = mesh.topology.dim, compat.cell_geometry(mesh), compat.cell_name(mesh)
    mesh.topology.create_connectivity(tdim - 1, tdim)
    mesh.topology.create_connectivity(tdim, tdim - 1)
    up, down = (mesh.topology.connectivity(*dims) for dims in ((tdim - 1, tdim), (tdim, tdim - 1)))
    own = np.array(lagrange(cell, degree).entity_closure_dofs[tdim - 1])
    behind = up.array[up.offsets[facets]]
    which = (down.array.reshape(-1, len(own))[behind] == facets[:, None]).argmax(axis=1)
    return nodes[behind[:, None], own[which]], nodes[behind]


def for_meshio(cell: str, nodes: np.ndarray) -> tuple[str, np.ndarray]:
    """Cells of these nodes, (m, k), as meshio wants them: its name of them, and in its order."""
    kind, order = TO_MESHIO[cell][nodes.shape[1]]
    return kind, nodes[:, np.argsort(order)]


def mirrored(cell: str, nodes: int) -> np.ndarray:
    """The nodes of a cell of the other orientation, (nodes,)."""
    places = lagrange(cell, degree_of(cell, nodes)).points
    swapped = places.copy()
    swapped[:, [0, 1]] = places[:, [1, 0]]
    return np.linalg.norm(swapped[:, None] - places, axis=2).argmin(axis=1)


def orientations(x: np.ndarray, cell: str) -> np.ndarray:
    """The signs of the volume at the nodes of cells whose nodes are at x (m, k, d), (m, k); 0 where
    it is flat."""
    element = lagrange(cell, degree_of(cell, x.shape[1]))
    slopes = element.tabulate(1, element.points)[1:, ..., 0]
    edges = np.einsum("tqk,mkj->mqtj", slopes, x)
    volume = np.linalg.det(edges)
    long = np.linalg.norm(edges, axis=3)
    # of nodes at one place round-off would be an edge that points somewhere
    flat = np.abs(volume) <= SAME * long.prod(axis=2)
    flat |= (long <= SAME * long.max(axis=(1, 2), keepdims=True)).any(axis=2)
    return np.sign(np.where(flat, 0.0, volume))
