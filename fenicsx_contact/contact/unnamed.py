# SPDX-License-Identifier: LGPL-3.0-or-later
"""What of a solid has no name in any contact, and is inside an obstacle that the solid meets.

Only named facets meet anything. A block of which the base is named stands, rocks, and, thrown over,
falls through the floor.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base import cells
from ..base.checks import StepFailed
from ..base.mesh import NamedMesh
from .contact import Contact
from .nodal import NodalJump


def unnamed_inside(contacts: Sequence[Contact], share: float) -> list[str]:
    """What a reader should know of nodes that have come deeper into an obstacle than this share of
    their solid; all processes ask together."""
    named: dict[tuple[int, str], list[Contact]] = {}
    for contact in contacts:
        other = contact.coupling
        if isinstance(other, NodalJump) and not other.encloses:
            named.setdefault((id(contact.solid), other.wall.describe()), []).append(contact)
    told = []
    for alike in named.values():
        mesh = getattr(alike[0].solid, "mesh", None)
        if isinstance(mesh, NamedMesh):
            nodes = np.setdiff1d(*_nodes(mesh, [contact.facets for contact in alike]))
            told.append(_look(alike, mesh, nodes, share))
    return [text for text in told if text]


def _nodes(mesh: NamedMesh, names: Sequence[Any]) -> tuple[np.ndarray, np.ndarray]:
    """Local nodes of the facets that bound the mesh, and of those of these names."""
    named = [mesh.facets(name) for name in np.unique(np.hstack(names))]
    facets = mesh.skin_facets(), np.concatenate(named)
    skin, mine = (cells.facet_nodes(mesh.mesh, each, mesh.degree)[0].ravel() for each in facets)
    return skin, mine


def _look(alike: list[Contact], mesh: NamedMesh, nodes: np.ndarray, share: float) -> str:
    """The same of nodes that none of the contacts of a solid before an obstacle names."""
    contact = alike[0]
    wall, comm = contact.coupling.wall, mesh.mesh.comm  # type: ignore[attr-defined]
    rest = mesh.mesh.geometry.x[nodes, : mesh.dim]
    now = rest + contact.solid.fields()["displacement"][nodes]
    try:
        depth = -wall.distance(now, contact.coupling.time)
        depth[wall.distance(rest, 0.0) < 0] = 0.0  # it is meant to reach beyond
    except StepFailed:  # the wall knows nothing there
        depth = np.zeros(len(nodes))
    deepest = int(depth.argmax()) if len(depth) else 0
    found = (float(depth[deepest]), now[deepest].round(9).tolist()) if len(depth) else (0.0, [])
    most, where = max(comm.allgather(found))
    x = mesh.mesh.geometry.x[:, : mesh.dim]
    low, high = np.array(comm.allgather((x.min(axis=0), x.max(axis=0)))).swapaxes(0, 1)
    size = np.ptp([low.min(axis=0), high.max(axis=0)], axis=0).max()
    bears = max(each.depth() for each in alike)  # springs do where it is deep
    if not most - bears > share * size:
        return ""
    return (
        f"contact {contact.name!r}: facets of {contact.solid.name!r} that no contact names are "
        f"{most:.3g} m inside its obstacle (a node at {where}): only named facets meet anything; "
        "give names to all that may touch"
    )
