# SPDX-License-Identifier: LGPL-3.0-or-later
"""What of a solid has no name in any contact, and is inside an obstacle that the solid meets.

Only named facets meet anything. A block of which the base is named stands, rocks, and, thrown over,
falls through the floor.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
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
    found: tuple[float, list[float]] = 0.0, []
    with suppress(StepFailed):  # of a wall that knows nothing there
        if len(nodes):
            depth = -wall.distance(now, contact.coupling.time)
            depth[wall.distance(rest, 0.0) < 0] = 0.0  # it is meant to reach beyond
            deepest = int(depth.argmax())
            found = float(depth[deepest]), now[deepest].round(9).tolist()
    most, where = max(comm.allgather(found))
    x = mesh.mesh.geometry.x[:, : mesh.dim]
    own = x.min(axis=0, initial=np.inf), -x.max(axis=0, initial=-np.inf)
    size = -np.sum(np.min(comm.allgather(own), axis=0), axis=0).min()
    bears = max(each.depth() for each in alike)  # springs do where it is deep
    if not most - bears > share * size:
        return ""
    return (
        f"contact {contact.name!r}: facets of {contact.solid.name!r} that no contact names are "
        f"{most:.3g} m inside its obstacle (a node at {where}): only named facets meet anything; "
        "give names to all that may touch"
    )
