# SPDX-License-Identifier: LGPL-3.0-or-later
"""What lies inside a solid, by all facets that bound it: those of a contact see each other, or an
obstacle, only near surfaces, and what lies deeper looks as if it were apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..base import compat
from ..base.cells import NODES
from ..base.checks import StepFailed
from ..base.mesh import NamedMesh
from ..solids import Solid
from .mortar import Pairing
from .mortar.search import Near, Spheres
from .simplices import nearest, split
from .wall import Wall

#: Cost: the direction in which points look for the facets around them, which no symmetry of a mesh
#: is likely to have: what passes through an edge of two facets is not told from what misses both.
LOOK = (1.0, 0.41421356, 0.73205081)


def deepest(
    points: np.ndarray, solid: Solid, limits: np.ndarray, places: np.ndarray | None = None
) -> float:
    """How far below the boundary of a solid the deepest is of the points (n, d) that lie farther
    inside than their limits (n,), in m; 0 if none does. ``places``: where those of its skin are, if
    not in the trial state."""
    nodes, cells, cell = solid.mesh.skin()
    cells = split(cells[:, : NODES[cell][0]], cell)
    places = solid.trace(nodes).positions() if places is None else places
    low, high = places.min(axis=0), places.max(axis=0)
    near = ((points - low > limits[:, None]) & (high - points > limits[:, None])).all(axis=1)
    asked = np.flatnonzero(near)
    asked = asked[within(points[asked], places[cells])]
    if not len(asked):
        return 0.0
    bound = np.array([np.linalg.norm(places - points[i], axis=1).min() for i in asked])
    depth = 0.0
    for k in np.argsort(-bound):  # no farther from the facets than from their corners
        if bound[k] <= depth:
            break
        found = nearest(points[asked[k], None], places[cells])
        if found > limits[asked[k]]:
            depth = max(depth, found)
    return depth


def inside_each_other(
    pair: Pairing, places: np.ndarray, solids: Sequence[Solid], most: float
) -> str:
    """How far one of two solids lies inside the other, with nodes at these places (N, d), unseen by
    the pairing and by more than ``most``, m; or nothing."""
    seen, last = seen_in(pair), len(pair.slave.nodes)
    # of what faces something gaps tell, but not what lies between
    size = max(most, pair.slave.size, pair.master.size)
    limits = np.where(seen, size, most)
    for one, other, mine in ((0, 1, slice(last)), (1, 0, slice(last, None))):
        depth = deepest(places[mine], solids[other], limits[mine])
        if depth:
            return f"{solids[one].name!r} {depth:.4g} inside {solids[other].name!r}"
    return ""


def seen_in(pair: Pairing) -> np.ndarray:
    """Which nodes of both sides have partners, (N,) of bool."""
    last = len(pair.slave.nodes)
    seen = np.zeros(pair.total, dtype=bool)
    seen[: pair.n] = ~pair.alone
    here = np.asarray((abs(pair.means[:, last:]) > 0).sum(axis=0)).ravel()
    seen[last:] = pair.shared.sum(here) > 0  # each process has the rows of its nodes
    for side, first in ((pair.slave, 0), (pair.master, last)):  # middles as their corners
        faces = seen[first + side.corners].any(axis=1)
        seen[first + side.cells[faces, side.corners.shape[1] :]] = True
    return seen


def within(points: np.ndarray, simplices: np.ndarray) -> np.ndarray:
    """Whether points (n, d) lie within the closed surface of simplices (m, d, d), (n,) of bool: a
    ray to one side meets it an odd number of times."""
    return crossed(points, simplices) % 2 == 1


def crossed(points: np.ndarray, simplices: np.ndarray) -> np.ndarray:
    """How often rays from points (n, d) to one side meet simplices (m, d, d), (n,)."""
    if not len(points):
        return np.zeros(0, dtype=int)
    d = points.shape[1]
    frame = np.linalg.qr(np.column_stack([LOOK[:d], np.eye(d)[:, 1:]]))[0]
    x, corners = points @ frame, simplices @ frame  # the rays run along the first coordinate
    rays = Spheres(x[:, 1:], np.zeros(len(x)))
    ray, facet = Near()(rays, Spheres.around(corners[..., 1:]))
    arm = np.swapaxes(corners[facet] - x[ray][:, None], 1, 2)
    along = arm[:, 0].copy()
    arm[:, 0] = 1.0
    volume = np.linalg.det(arm)
    whole = volume != 0
    shares = np.zeros(along.shape)
    shares[whole] = np.linalg.inv(arm[whole])[:, :, 0]
    hit = whole & (shares > 0).all(axis=1) & ((shares * along).sum(axis=1) > 0)
    return np.bincount(ray[hit], minlength=len(x))


def swallowed(solid: Solid, wall: Wall, most: float) -> str:
    """Of a solid whose boundary, at time 0, is outside of an obstacle while nodes or middles of its
    cells are inside (it has swallowed the obstacle), or that is all inside (an obstacle told the
    wrong way round): which it is, and how deep; or nothing up to a depth of ``most``, m."""
    mesh = getattr(solid, "mesh", None)
    if not isinstance(mesh, NamedMesh):
        return ""
    skin = solid.trace(mesh.skin()[0]).positions()
    x = mesh.mesh.geometry.x[:, : mesh.dim] + solid.fields()["displacement"]
    points = np.concatenate([x, x[compat.cell_geometry(mesh.mesh)].mean(axis=1)])
    depth = 0.0
    try:
        away = wall.distance(skin, 0.0)
        outside, inside = bool((away >= 0).all()), bool((away <= most).all())
        depth = -wall.distance(points, 0.0).min(initial=0.0)
    except StepFailed:  # its distances are for points outside
        outside = inside = False
    together = mesh.mesh.comm.allgather((outside, inside, depth))
    outside, inside = (all(each) for each in list(zip(*together))[:2])
    depth = max(each for _, _, each in together)
    if not (depth > most and (outside or inside)):
        return ""
    if outside:
        return f"the obstacle, {depth:.4g} deep, inside {solid.name!r}"
    whole = f"all of {solid.name!r}, {depth:.4g} deep, inside the obstacle"
    return f"{whole} (is that told the wrong way round?)"
