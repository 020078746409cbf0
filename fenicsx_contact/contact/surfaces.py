# SPDX-License-Identifier: LGPL-3.0-or-later
"""The surfaces of solids: the same facets are one surface, whatever they may touch.

A surface has a mesh of its own, and with it a dozen communicators, of which a machine has some ten
thousands: bodies of a heap that may all meet each other would need more.
"""

from __future__ import annotations

from weakref import WeakKeyDictionary

from ..base.cells import NODES
from ..solids import Solid
from .mortar import Side
from .surface import Surface

_MADE: WeakKeyDictionary[Solid, dict[tuple[str, int], Surface]] = WeakKeyDictionary()


def surface_of(solid: Solid, facets: str, paired: bool) -> Surface:
    """The surface of the named facets, made once for each solid.

    Args:
        solid: the slave.
        facets: the name.
        paired: before another solid; before obstacles middles of facets of second degree in the
            plane bear, too.

    Raises:
        InputError: no facets of that name, or some inside the mesh.
    """
    degree = getattr(solid, "degree", 1)
    fields = degree if solid.dim == 2 and not paired else 1
    made, key = _MADE.setdefault(solid, {}), (str(facets), fields)  # what is no name has none
    if key not in made:
        plane = getattr(solid, "plane", None)
        breadth = plane.breadth if plane and plane.revolution else None
        boundary = solid.mesh.boundary(facets, degree)
        made[key] = Surface(*boundary, fields, getattr(solid, "twins", None), breadth)
    return made[key]


def side_of(solid: Solid, facets: str, surface: Surface | None = None) -> Side:
    """The side that the named facets of a solid are, in the numbers of the sites of the surface, if
    given."""
    degree = getattr(solid, "degree", 1)
    points, cells, cell = solid.mesh.boundary(facets, degree)
    inside, places = solid.mesh.behind(facets, degree), points[cells]
    if surface is not None:
        points, cells, places = surface.sites, surface.cell_sites, surface.places
    corners = cells[:, : NODES[cell][0]]
    return Side(points, corners, cell, inside, degree, places, solid.revolution, facets)
