# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where a deformable solid is held, and where it is moved to."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from petsc4py import PETSc

from ..base import checks
from ..base.constants import BRIEF, SAME
from ..base.expressions import is_expression
from ..base.processes import together
from ..base.quoted import quoted
from .coefficients import arguments, field, is_field
from .locations import Location, nodes_at
from .vector_space import VectorSpace

#: Displacements of a location, one for each direction, None where it is free; or a function of time
#: that gives them; or a vector in UFL (a Function, an expression), or a function of x and t, which
#: tell those of each point in all directions.
Motion = Sequence[float | None] | Callable[[float], Sequence[float | None]] | Any
#: What a motion says of a time.
Told = Callable[[float], list[float | np.ndarray | None]]


def told(what: str, motion: Motion, vectors: VectorSpace, nodes: np.ndarray) -> Told:
    """What a motion says of a time: for each direction the displacement of all nodes, of each of
    the nodes (n,), or None.

    Args:
        what: the argument that gave it, for messages.
        motion: as given.
        vectors: the space of displacements.
        nodes: of the location that this process owns.
    """
    d = vectors.dim

    def alike(time: float) -> list[float | np.ndarray | None]:
        which, given = what, motion
        if checks.is_function(motion):
            which += f"({time:g})"
            given = checks.called(which, motion, time)
        problem = f"{which} = {quoted(given)}: must be {d} numbers, None for a free direction"
        values: Any = checks.plain(given) if is_expression(given) else given
        if isinstance(values, str) or not np.iterable(values) or len(list(values)) != d:
            raise checks.InputError(problem)
        return [None if v is None else checks.number(which, v) for v in values]

    if not is_field(motion) and not (checks.is_function(motion) and len(arguments(motion)) == 2):
        return lambda time: together(vectors.comm, lambda: alike(time), checks.InputError)
    made = field(what, motion, vectors.mesh, (d,))
    read = vectors.reader(made.expression)

    def each(time: float) -> list[float | np.ndarray | None]:
        made.at(time)
        values = read()
        if not min(vectors.comm.allgather(bool((np.abs(values) <= checks.LARGEST).all()))):
            raise checks.InputError(f"{what}: is not finite everywhere at t = {time:g} s")
        return list(values.reshape(-1, d)[nodes].T)

    return each


def _changes(motion: Motion) -> bool:
    """Whether it may tell another place at another time, or in another run: whatever is UFL may,
    Constants among the numbers included."""
    if checks.is_function(motion) or is_expression(motion):
        return True
    return np.iterable(motion) and any(is_expression(each) for each in motion)


class Supports:
    """Where a solid is held, and where it is moved to.

    Args:
        vectors: the space of its displacements.
        fixed: locations held fast.
        prescribed: motions of locations.
        axis: nodes on an axis of revolution, which do not leave it.

    Attributes:
        unknowns: the held unknowns among those that this process owns, sorted.
        moving: whether any of them may move; ``still``: those that no support does.
        directions: whether the solid is held in each direction somewhere, (d,).

    Raises:
        InputError: a location that the mesh lacks, a motion that is not one, two motions of a point
            that contradict each other.
    """

    def __init__(
        self,
        vectors: VectorSpace,
        fixed: str | Sequence[Location],
        prescribed: Mapping[Location, Motion],
        axis: np.ndarray,
    ) -> None:
        self._vectors, self._comm, self._d = vectors, vectors.comm, vectors.dim
        single = isinstance(fixed, str)
        places: list[Any] = [fixed] if single else checks.listed("fixed", fixed, "names, or points")
        every_motion: list[tuple[Any, Any, str]]
        every_motion = [(where, [0.0] * self._d, "fixed") for where in places]
        every_motion += [(where, motion, "prescribed") for where, motion in prescribed.items()]
        given: list[tuple[Location, Told, np.ndarray]] = []
        for where, motion, what in every_motion:
            nodes = nodes_at(vectors, where, what)
            given.append((where, told(f"{what}[{where!r}]", motion, vectors, nodes), nodes))
        if self._comm.allreduce(len(axis)):
            still = told("fixed", [0.0, *[None] * (self._d - 1)], vectors, axis)
            given.append(("axis of revolution", still, axis))
        at_start = [motion(0.0) for _, motion, _ in given]
        directions = [[i for i, v in enumerate(values) if v is not None] for values in at_start]
        every = [
            (nodes[:, None] * self._d + held).astype(np.int64)
            for (_, _, nodes), held in zip(given, directions)
        ]
        self.unknowns = np.unique(
            np.concatenate([np.empty(0, dtype=np.int64), *(n.ravel() for n in every)])
        )
        self._motions = [
            (where, motion, held, np.searchsorted(self.unknowns, n))
            for (where, motion, _), held, n in zip(given, directions, every)
        ]
        led = np.zeros(len(self.unknowns), dtype=bool)
        for (_, motion, _), values, (*_, at) in zip(every_motion, at_start, self._motions):
            if _changes(motion) or any(v is not None and np.any(v) for v in values):
                led[at] = True
        self.still = self.unknowns[~led]
        there = [bool((self.unknowns % self._d == i).any()) for i in range(self._d)]
        self.directions = np.any(self._comm.allgather(there), axis=0)
        moves = any(_changes(motion) for motion in prescribed.values())
        moves |= any(v is not None and bool(np.any(v)) for values in at_start for v in values)
        self.moving = any(self._comm.allgather(moves))
        self.values(0.0)  # refuse now what can be refused

    def starting_speed(self, shortest: float) -> np.ndarray:
        """Velocities of the held unknowns at the start, m/s.

        Args:
            shortest: the shortest time that the solid knows, s; infinite: they start at rest.
        """
        if not self.moving or shortest == np.inf:
            return np.zeros(len(self.unknowns))
        return self.speed(0.0, shortest)

    def speed(self, time: float, dt: float) -> np.ndarray:
        """Velocities of the held unknowns at a time, m/s, by a share of ``dt`` seconds that follow,
        or, if they are negative, went before: of second order in that."""
        span = BRIEF * dt
        now, then, later = (self.values(time + k * span) for k in (0, 1, 2))
        return (4 * (then - now) - (later - now)) / (2 * span)

    def values(self, time: float) -> np.ndarray:
        """Displacements of the held unknowns at a time, m.

        Raises:
            InputError: directions that are free at some times only, or motions that contradict
                each other then.
        """
        result = np.full(len(self.unknowns), np.nan)
        by = np.full(len(self.unknowns), -1)
        given = [motion(time) for _, motion, *_ in self._motions]
        sizes = [np.abs(v).max(initial=0.0) for values in given for v in values if v is not None]
        largest = max(sizes, default=0.0)
        clash = ("", "")
        for k, ((where, _, directions, places), values) in enumerate(zip(self._motions, given)):
            if [i for i, v in enumerate(values) if v is not None] != directions:
                raise checks.InputError(
                    f"prescribed[{where!r}]({time:g}) = {values!r}: the same directions must be "
                    "free at all times"
                )
            held = np.array([values[i] for i in directions], dtype=float).T
            off = places[np.abs(result[places] - held) > SAME * largest]
            if len(off):
                clash = repr(where), repr(self._motions[by[off[0]]][0])
            result[places], by[places] = held, k
        clash = max(self._comm.allgather(clash))
        if clash[0]:
            raise checks.InputError(
                f"prescribed, fixed: at t = {time:g} s the motion of {clash[0]} contradicts that "
                f"of {clash[1]} at points that they share; leave one of them free, by None"
            )
        return result

    def hold(self, matrix: PETSc.Mat) -> PETSc.Mat:
        """Clear the rows and columns of the held unknowns, 1 on the diagonal."""
        rows = self._vectors.first + self.unknowns
        matrix.setOption(PETSc.Mat.Option.KEEP_NONZERO_PATTERN, True)
        matrix.zeroRowsColumns(rows.astype(np.int32), 1.0)
        return matrix

    def total(self, where: Location, reaction: np.ndarray) -> np.ndarray:
        """Sum of the forces of the held unknowns at a location, (d,)."""
        nodes, total = nodes_at(self._vectors, where, "where"), np.zeros(self._d)
        for i in range(self._d):
            mine = np.isin(self.unknowns, nodes * self._d + i)
            total[i] = self._vectors.sum(reaction[mine].sum())
        return total
