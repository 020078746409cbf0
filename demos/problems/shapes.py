# SPDX-License-Identifier: LGPL-3.0-or-later
"""The one shape that the shipped problems need, in all its grids."""

from __future__ import annotations

import dolfinx
import numpy as np
from mpi4py import MPI

from fenicsx_contact import HalfSpace, NamedMesh, name_facets

FLOOR = HalfSpace((0, 0), (0, 1))
G = 9.81  # m/s²


def rectangle(
    width: float, height: float, cells: tuple[int, int] = (1, 1), low: float = 0.0
) -> NamedMesh:
    """Quadrilaterals on y = ``low``, m, centred at x = 0; facets base, top, left, right."""
    corners = [np.array([-width / 2, low]), np.array([width / 2, low + height])]
    kind = dolfinx.mesh.CellType.quadrilateral
    mesh = dolfinx.mesh.create_rectangle(MPI.COMM_SELF, corners, list(cells), kind)
    x, y = 1e-6 * width, 1e-6 * height
    return name_facets(
        mesh,
        {
            "base": lambda p: np.abs(p[1] - low) < y,
            "top": lambda p: np.abs(p[1] - low - height) < y,
            "left": lambda p: np.abs(p[0] + width / 2) < x,
            "right": lambda p: np.abs(p[0] - width / 2) < x,
        },
    )
