# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where something holds a solid: named facets, named points, edges, points by their coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import Any

import numpy as np

from ..base import checks
from ..base.constants import SAME
from ..base.vectors import largest
from .vector_space import VectorSpace

#: A name of facets or of a point; several names of facets for the points that they share, an edge
#: or a corner; or the coordinates of a point.
Location = str | Sequence[str] | Sequence[float]


def is_surface(vectors: VectorSpace, where: Location) -> bool:
    """Whether it is one name of facets."""
    return isinstance(where, str) and where not in vectors.mesh.points


def nodes_at(vectors: VectorSpace, where: Any, what: str) -> np.ndarray:
    """The nodes there that this process owns, sorted.

    Args:
        vectors: the space.
        where: the location.
        what: the argument that gave it, for messages.

    Raises:
        InputError: a name that the mesh lacks or no facet bears, facets that share no point, a
            point that is no node.
    """
    if is_surface(vectors, where):
        return vectors.nodes_of([where], what)
    if isinstance(where, str):
        return _node(vectors, vectors.mesh.points[where], what, f"point {where!r}")
    names = list(where) if np.iterable(where) else []
    if names and all(isinstance(name, str) for name in names):
        shared = reduce(np.intersect1d, [vectors.nodes_of([name], what) for name in names])
        if not vectors.comm.allreduce(len(shared)):
            raise checks.InputError(f"{what} = {where!r}: these facets share no point")
        return shared
    return _node(vectors, where, what, f"{where!r}")


def _node(vectors: VectorSpace, point: Any, what: str, shown: str) -> np.ndarray:
    place, comm = checks.vector(what, point, vectors.dim), vectors.comm
    far = np.linalg.norm(vectors.sites - place, axis=1)
    nearest = min(comm.allgather((float(far.min(initial=np.inf)), comm.rank)))
    size = max(comm.allgather(largest(vectors.sites)))
    if nearest[0] > SAME * size:
        own = vectors.sites[far.argmin()].tolist() if comm.rank == nearest[1] else None
        raise checks.InputError(
            f"{what} = {shown}: must be a node; the nearest one is {comm.bcast(own, nearest[1])}"
        )
    return np.unique(vectors.site_nodes[far <= SAME * size])
