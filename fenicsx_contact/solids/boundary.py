# SPDX-License-Identifier: LGPL-3.0-or-later
"""What is prescribed on the boundary of a deformable solid: motions and tractions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import ufl
from dolfinx import fem

from ..base import checks, compat

if TYPE_CHECKING:
    from .deformable import DeformableSolid

#: Displacements of facets, one for each direction, None where it is free; or a function of time
#: that gives them.
Motion = Sequence[float | None] | Callable[[float], Sequence[float | None]]
#: Force per reference area (Pa, or N/m per thickness in 2D), or a function of time that gives it.
Traction = Sequence[float] | Callable[[float], Sequence[float]]


class Supports:
    """Where a solid is held, and where it is moved to.

    Args:
        solid: the solid.
        fixed: names of facets held fast.
        prescribed: motions of named facets.

    Attributes:
        unknowns: the held unknowns among those that this process owns, sorted.
        moving: whether any of them may move.
        directions: whether the solid is held in each direction somewhere, (d,).

    Raises:
        InputError: a name that the mesh lacks, a motion that is not one, two motions of a point
            that contradict each other.
    """

    def __init__(
        self, solid: DeformableSolid, fixed: Sequence[str], prescribed: Mapping[str, Motion]
    ) -> None:
        self._solid, d = solid, solid.dim
        names = [fixed] if isinstance(fixed, str) else list(fixed)
        if not isinstance(prescribed, Mapping):
            raise checks.InputError(
                f"prescribed = {prescribed!r}: must be a dict from names of facets to motions"
            )
        self._motions: list[tuple[str, Motion, np.ndarray, list[int]]] = []
        held = [np.empty(0, dtype=np.int64)]
        for name, motion in [*((name, [0.0] * d) for name in names), *prescribed.items()]:
            nodes = solid.nodes_of([name])
            directions = [i for i, v in enumerate(self._at(name, motion, 0.0)) if v is not None]
            self._motions.append((name, motion, nodes, directions))
            held += [nodes * d + i for i in directions]
        self.unknowns = np.unique(np.concatenate(held))
        there = [bool((self.unknowns % d == i).any()) for i in range(d)]
        self.directions = np.any(solid.comm.allgather(there), axis=0)
        self.moving = any(
            callable(motion) or any(self._at(name, motion, 0.0)[i] for i in directions)
            for name, motion, _, directions in self._motions
        )

    def _at(self, name: str, motion: Motion, time: float) -> list[float | None]:
        values = motion(time) if callable(motion) else motion
        d = self._solid.dim
        what = f"prescribed[{name!r}]" + (f"({time:g})" if callable(motion) else "")
        problem = f"{what} = {values!r}: must be {d} numbers, None for a free direction"
        if isinstance(values, str) or not np.iterable(values) or len(list(values)) != d:
            raise checks.InputError(problem)
        return [None if v is None else checks.number(what, v) for v in values]

    def values(self, time: float) -> np.ndarray:
        """Displacements of the held unknowns at a time, m."""
        d = self._solid.dim
        result = np.zeros(len(self.unknowns))
        for name, motion, nodes, directions in self._motions:
            values = self._at(name, motion, time)
            if [i for i, v in enumerate(values) if v is not None] != directions:
                raise checks.InputError(
                    f"prescribed[{name!r}]({time:g}) = {values!r}: the same directions must be "
                    "free at all times"
                )
            for i in directions:
                result[np.searchsorted(self.unknowns, nodes * d + i)] = values[i]
        return result


class Tractions:
    """Dead loads on named facets: given per reference area, in fixed directions.

    Raises:
        InputError: a name that the mesh lacks, a traction that is not one.
    """

    def __init__(self, solid: DeformableSolid, tractions: Mapping[str, Traction]) -> None:
        if not isinstance(tractions, Mapping):
            raise checks.InputError(
                f"tractions = {tractions!r}: must be a dict from names of facets to tractions"
            )
        self._solid = solid
        self._loads: list[tuple[str, Traction, np.ndarray]] = []
        test = ufl.TestFunction(solid.space)
        tags = solid.mesh.facet_tags
        ds = ufl.Measure("ds", domain=solid.mesh.mesh, subdomain_data=tags)
        for name, traction in tractions.items():
            solid.mesh.facets(name)
            loads = np.empty((solid.dim, solid.owned))
            for i, load in enumerate(loads):
                direction = fem.Constant(solid.mesh.mesh, np.eye(solid.dim)[i])
                form = ufl.dot(direction, test) * ds(int(solid.mesh.names[name]))
                compat.assemble_owned(fem.form(form), load)
            self._loads.append((name, traction, loads))
        self.total(0.0)  # refuse now what can be refused

    def total(self, time: float) -> np.ndarray:
        """The load at a time, for the owned unknowns, N."""
        result = np.zeros(self._solid.owned)
        for name, traction, loads in self._loads:
            given: Any = traction(time) if callable(traction) else traction
            what = f"tractions[{name!r}]" + (f"({time:g})" if callable(traction) else "")
            result += checks.vector(what, given, self._solid.dim) @ loads
        return result
