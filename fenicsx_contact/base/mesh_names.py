# SPDX-License-Identifier: LGPL-3.0-or-later
"""The names that a mesh read by meshio has for its elements and points."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import meshio
import numpy as np

from . import checks


@dataclass(frozen=True)
class PointSet:
    """A name that the file has for points only."""

    points: np.ndarray


def element_sets(mesh: meshio.Mesh, dim: int) -> dict[str, list[np.ndarray]]:
    """The named sets that hold elements of a dimension: for each block the indices in it."""
    inside = [block.dim == dim for block in mesh.cells]
    none = np.empty(0, dtype=np.int64)
    sets: dict[str, list[np.ndarray]] = {}

    def add(name: str, blocks: list[Any]) -> None:
        if len(blocks) != len(inside) or any(isinstance(b, list) for b in blocks):
            return  # Abaqus' sets of sets, of which meshio loses members
        blocks = [none if b is None or not i else b for b, i in zip(blocks, inside)]
        blocks = [np.asarray(b, dtype=np.int64) for b in blocks]
        if any(len(b) for b in blocks) and name not in sets:
            sets[name] = blocks

    for name, blocks in mesh.cell_sets.items():
        if not name.startswith("gmsh:"):
            add(name, list(blocks))
    for name, tag in mesh.field_data.items():  # gmsh 2
        if "gmsh:physical" in mesh.cell_data and len(tag) == 2 and tag[1] == dim:
            values = mesh.cell_data["gmsh:physical"]
            add(name, [np.flatnonzero(np.asarray(v) == tag[0]) for v in values])
    families = getattr(mesh, "cell_tags", None) or {}  # MED: a family has several groups
    for name in sorted({n for names in families.values() for n in names}):
        tags = [tag for tag, names in families.items() if name in names]
        values = mesh.cell_data["cell_tags"]
        add(name, [np.flatnonzero(np.isin(v, tags)) for v in values])
    return sets


def refuse_lost_names(mesh: meshio.Mesh, content: bytes) -> None:
    """Refuse a file of gmsh with physical names that meshio loses: it keeps one of those that are
    alike, whatever their dimensions, and none of groups whose elements it does not find.

    Raises:
        InputError: there are.
    """
    section = content.partition(b"$PhysicalNames")[2].partition(b"$EndPhysicalNames")[0]
    lines = re.findall(r'^\s*([0-3])\s+-?\d+\s+"(.*)"', section.decode(errors="replace"), re.M)
    most = max((int(dim) for dim, _ in lines), default=0)
    there = {dim: element_sets(mesh, dim) for dim in range(1, most + 1)}
    lost = {
        name for dim, name in lines if int(dim) and name.replace('"', "") not in there[int(dim)]
    }
    if lost:
        raise checks.InputError(
            f"meshio loses its physical names {listed(lost)}: two of different dimensions are "
            "alike, or their groups are reversed or empty; mesh_from_gmsh reads them"
        )


def named_elements(
    mesh: meshio.Mesh, dim: int, wanted: Mapping[str, str | int] | None, data: str | None
) -> dict[str, Any]:
    """For each name the facet elements (f, v) that bear it, or the set of points."""
    sets = element_sets(mesh, dim)
    if wanted is None:
        wanted = {name: name for name in sets}
    found: dict[str, Any] = {}
    for label, what in wanted.items():
        if isinstance(what, str) and what not in sets and what in mesh.point_sets:
            found[label] = PointSet(np.asarray(mesh.point_sets[what], dtype=np.int64))
            continue
        if isinstance(what, str):
            if what not in sets:
                raise checks.InputError(
                    f"facets: no {what!r}; it has {listed(sets)} for facets, "
                    f"{listed(mesh.point_sets)} for points"
                )
            picked = sets[what]
        else:
            value = checks.whole_number(f"facets[{label!r}]", what, at_least=-(2**62))
            picked = _with_value(mesh, value, data)
        rows = [b.data[p] for b, p in zip(mesh.cells, picked) if b.dim == dim and len(p)]
        if len({row.shape[1] for row in rows}) != 1:
            problem = "elements of several types" if rows else "no facet element"
            raise checks.InputError(f"facets: {label!r} = {what!r} has {problem}")
        found[label] = np.concatenate(rows)
    return found


def _with_value(mesh: meshio.Mesh, value: int, data: str | None) -> list[np.ndarray]:
    """The elements of each block whose cell data has a value."""
    whole = {
        name: blocks
        for name, blocks in mesh.cell_data.items()
        if all(np.ndim(b) == 1 and np.array_equal(b, np.round(b)) for b in blocks)
    }
    if data is None and "gmsh:physical" in whole:
        data = "gmsh:physical"
    if data is None and len(whole) == 1:
        (data,) = whole
    if data not in whole:
        raise checks.InputError(
            f"data = {data!r}: its whole-numbered cell data are {listed(whole)}"
        )
    return [np.flatnonzero(np.asarray(block) == value) for block in whole[data]]


def listed(names: Any) -> str:
    """Names for a message."""
    return ", ".join(map(repr, sorted(names))) or "nothing"
