# SPDX-License-Identifier: LGPL-3.0-or-later
"""What is prescribed on the boundary of a deformable solid: motions and tractions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from ..base import assembly, checks
from ..base.constants import BRIEF, SAME
from .vector_space import VectorSpace

#: Displacements of facets, one for each direction, None where it is free; or a function of time
#: that gives them.
Motion = Sequence[float | None] | Callable[[float], Sequence[float | None]]
#: Force per reference area (Pa, or N/m per thickness in 2D), or a function of time that gives it.
Traction = Sequence[float] | Callable[[float], Sequence[float]]


class Supports:
    """Where a solid is held, and where it is moved to.

    Args:
        vectors: the space of its displacements.
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
        self, vectors: VectorSpace, fixed: Sequence[str], prescribed: Mapping[str, Motion]
    ) -> None:
        self._vectors, self._comm, self._d = vectors, vectors.comm, vectors.dim
        if not isinstance(prescribed, Mapping):
            raise checks.InputError(
                f"prescribed = {prescribed!r}: must be a dict from names of facets to motions"
            )
        names = [fixed] if isinstance(fixed, str) else list(fixed)
        given: list[tuple[str, str, Motion]] = []  # argument, name, motion
        given += [("fixed", name, [0.0] * self._d) for name in names]
        given += [("prescribed", name, motion) for name, motion in prescribed.items()]
        directions = [self._held(name, motion, 0.0) for _, name, motion in given]
        numbers = [
            vectors.nodes_of([name], argument)[:, None] * self._d + held
            for (argument, name, _), held in zip(given, directions)
        ]
        every = [n.ravel() for n in numbers]
        self.unknowns = np.unique(np.concatenate([np.empty(0, dtype=np.int64), *every]))
        self._motions = [
            (name, motion, held, np.searchsorted(self.unknowns, n))
            for (_, name, motion), held, n in zip(given, directions, numbers)
        ]
        there = [bool((self.unknowns % self._d == i).any()) for i in range(self._d)]
        self.directions = np.any(self._comm.allgather(there), axis=0)
        self.moving = any(
            callable(motion) or any(self._at(name, motion, 0.0)[i] for i in held)
            for _, name, motion in given
            for held in [self._held(name, motion, 0.0)]
        )
        self.values(0.0)  # refuse now what can be refused

    def _at(self, name: str, motion: Motion, time: float) -> list[float | None]:
        values = motion(time) if callable(motion) else motion
        what = f"prescribed[{name!r}]" + (f"({time:g})" if callable(motion) else "")
        problem = f"{what} = {values!r}: must be {self._d} numbers, None for a free direction"
        if isinstance(values, str) or not np.iterable(values) or len(list(values)) != self._d:
            raise checks.InputError(problem)
        return [None if v is None else checks.number(what, v) for v in values]

    def _held(self, name: str, motion: Motion, time: float) -> list[int]:
        """The directions in which a motion holds its facets."""
        return [i for i, v in enumerate(self._at(name, motion, time)) if v is not None]

    def starting_speed(self, shortest: float) -> np.ndarray:
        """Velocities of the held unknowns at the start, m/s: a one-sided difference of second
        order.

        Args:
            shortest: the shortest time that the solid knows, s; infinite: they start at rest.
        """
        if not self.moving or shortest == np.inf:
            return np.zeros(len(self.unknowns))
        span = BRIEF * shortest
        now, then, later = (self.values(k * span) for k in (0, 1, 2))
        return (4 * (then - now) - (later - now)) / (2 * span)

    def values(self, time: float) -> np.ndarray:
        """Displacements of the held unknowns at a time, m.

        Raises:
            InputError: directions that are free at some times only, or motions that contradict
                each other then.
        """
        result = np.full(len(self.unknowns), np.nan)
        given = [self._at(name, motion, time) for name, motion, *_ in self._motions]
        largest = max((abs(v) for values in given for v in values if v is not None), default=0.0)
        clash = ""
        for (name, _, directions, places), values in zip(self._motions, given):
            if [i for i, v in enumerate(values) if v is not None] != directions:
                raise checks.InputError(
                    f"prescribed[{name!r}]({time:g}) = {values!r}: the same directions must be "
                    "free at all times"
                )
            held = np.array([values[i] for i in directions], dtype=float)
            if (np.abs(result[places] - held) > SAME * largest).any():
                clash = name
            result[places] = held
        if clash := max(self._comm.allgather(clash)):
            others = [name for name, *_ in self._motions if name != clash]
            raise checks.InputError(
                f"prescribed, fixed: at t = {time:g} s the motion of {clash!r} contradicts that of "
                f"facets it shares points with (among {others}); leave one of them free, by None"
            )
        return result

    def hold(self, matrix: PETSc.Mat) -> PETSc.Mat:
        """Clear the rows and columns of the held unknowns, 1 on the diagonal."""
        rows = self._vectors.first + self.unknowns
        matrix.setOption(PETSc.Mat.Option.KEEP_NONZERO_PATTERN, True)
        matrix.zeroRowsColumns(rows.astype(np.int32), 1.0)
        return matrix

    def total(self, name: str, reaction: np.ndarray) -> np.ndarray:
        """Sum of the forces of the held unknowns over the named facets, (d,)."""
        nodes, total = self._vectors.nodes_of([name], "name"), np.zeros(self._d)
        for i in range(self._d):
            mine = np.isin(self.unknowns, nodes * self._d + i)
            total[i] = self._vectors.sum(reaction[mine].sum())
        return total


class Tractions:
    """Dead loads on named facets: given per reference area, in fixed directions.

    Raises:
        InputError: a name that the mesh lacks, facets inside it, a traction that is not one.
    """

    def __init__(self, vectors: VectorSpace, tractions: Mapping[str, Traction]) -> None:
        if not isinstance(tractions, Mapping):
            raise checks.InputError(
                f"tractions = {tractions!r}: must be a dict from names of facets to tractions"
            )
        self._dim, self._owned = vectors.dim, vectors.owned
        self._loads: list[tuple[str, Traction, np.ndarray]] = []
        test, mesh = ufl.TestFunction(vectors.space), vectors.mesh
        ds = ufl.Measure("ds", domain=mesh.mesh, subdomain_data=mesh.facet_tags)
        for name, traction in tractions.items():
            vectors.facets(name, "tractions")
            loads = np.empty((self._dim, self._owned))
            for i, load in enumerate(loads):
                direction = fem.Constant(mesh.mesh, np.eye(self._dim)[i])
                form = ufl.dot(direction, test) * ds(int(mesh.names[name]))
                assembly.assemble_owned(fem.form(form), load)
            if not max(vectors.comm.allgather(bool(loads.any()))):
                raise checks.InputError(
                    f"tractions[{name!r}]: none of these facets is on the boundary of the mesh"
                )
            self._loads.append((name, traction, loads))
        self.total(0.0)  # refuse now what can be refused

    def total(self, time: float) -> np.ndarray:
        """The load at a time, for the owned unknowns, N."""
        result = np.zeros(self._owned)
        for name, traction, loads in self._loads:
            given: Any = traction(time) if callable(traction) else traction
            what = f"tractions[{name!r}]" + (f"({time:g})" if callable(traction) else "")
            result += checks.vector(what, given, self._dim) @ loads
        return result
