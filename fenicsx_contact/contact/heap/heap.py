# SPDX-License-Identifier: LGPL-3.0-or-later
"""Many rigid bodies that may all meet each other, as one contact."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...base import checks, compat
from ...base.quoted import quoted
from ...solids import RigidSolid, Solid
from ...theory.formulations import Formulation
from ...theory.friction import Coulomb, FrictionBound
from ...theory.interface.adhesion import Adhesive
from ...theory.scheme import Step
from ..contact import Contact
from ..inside import deepest
from ..jump import Coupling
from ..mortar import Side
from ..mortar.walls import WALL
from ..pair_equations import PairedEquations
from ..simplices import split
from ..surface import Surface
from ..surfaces import side_of
from .meetings import PLACES, Meetings
from .search import Features, Search
from .shape import Shape, nodes_at


class HeapJump(Coupling):
    """Corners of rigid bodies before faces of others, and edges that cross.

    Args:
        contact: the heap.
        sides: the facets of each body.
    """

    fixed_normal = shares = False

    def __init__(self, contact: Heap, sides: Sequence[Side]) -> None:
        self.bodies = contact.bodies
        self.solids = [*self.bodies]
        self.equations = contact.equations
        self._shape = shape = Shape(sides)
        whole = {2: 3, 3: 6}[shape.dim]
        self._search = Search(shape, np.array([len(s.held) == whole for s in self.bodies]))
        homes = nodes_at(shape, contact.surface.points, contact.owners)
        self.meetings = Meetings(shape, homes, contact.surface.area)
        # these ask of a pairing what meetings have, too
        self.part = self._part = PairedEquations(self.equations, self.meetings)  # type: ignore[arg-type]
        self.traces = [s.trace(shape.nodes[at]) for s, at in zip(self.solids, shape.slices)]
        self._start = self._end = self._places()
        self.fresh = np.zeros(self.meetings.n, dtype=bool)
        self._meet(np.zeros_like(self._start), self.fresh)
        self.meetings.update(self._start)
        self._first = self._last = self.meetings.operator  # where a step starts, and forces act

    def _places(self) -> np.ndarray:
        return np.concatenate([trace.positions() for trace in self.traces])

    def _meet(self, way: np.ndarray, busy: np.ndarray) -> None:
        known = self.meetings.features.key
        self._inside = self.meetings.depths(self._start)
        self._foreseen, found = way, self._search(self._start, way, self._inside, known)
        self.fresh = self.meetings.take(found, busy)

    def stand(self, bears: np.ndarray, step: Step) -> bool:
        way = step.horizon * self.velocities("velocity").reshape(self._start.shape)
        self.meetings.update(self._start)  # a step that was not taken left it elsewhere
        self._meet(way, bears)
        self.meetings.update(self._start)
        self._first = self.meetings.operator
        return True  # before the next face of a body what touched may be open

    def follow(self) -> None:
        for trace in self.traces:
            trace.follow()
        self._end = self._places()
        self.meetings.update(self._end)

    def _depths(self) -> np.ndarray:
        far = -self.equations.fields.surface.extent
        return np.where(self.meetings.there, self.meetings.gap, far)

    def beside(self, point: int) -> bool:
        """Whether a point lies beside what it is to meet, in the followed state."""
        return bool(self.meetings.beside(self._end, np.array([point]))[0])

    @property
    def blocked(self) -> str:
        depths = np.maximum(self._inside, self.meetings.depths(self._end))
        if self._search.blind(self._start, self._end - self._start, self._foreseen, depths):
            return (
                "bodies go farther than it was known what they may meet, or than half of a thin one"
            )
        return ""

    def swallowed(self, most: float) -> str:
        s = self._shape
        for a, b in self._search.near(self._start):
            for one, other in ((a, b), (b, a)):
                x = self._start[s.slices[one]]
                limit = max(most, WALL * min(s.thin[one], s.thin[other]))
                depth = deepest(x, self.solids[other], np.full(len(x), limit))
                if depth:
                    inside, around = self.solids[one].name, self.solids[other].name
                    return f"{inside!r} {depth:.4g} inside {around!r}"
        return ""

    def normals(self) -> np.ndarray:
        return self.meetings.normal.copy()

    def to_jump(self, velocities: np.ndarray) -> np.ndarray:
        return self.meetings.jumps(velocities).reshape(self.meetings.n, -1)

    def loaded(self, free: np.ndarray, start: np.ndarray) -> np.ndarray:
        # bodies that fall alike are stopped by each other, once one of them stands
        before = [t.jump(s.velocity) for s, t in zip(self.solids, self.traces)]
        change = free - np.concatenate(before)
        return self.meetings.apart(change)

    def force(self, force: np.ndarray) -> np.ndarray:
        return self.equations.forces()

    def linearise(self, step: Step, exact: bool, share: float, kept: bool = False) -> None:
        # how normals turn is second to what moves: found in the next round
        velocities, self._last = self.velocities("trial_velocity"), self.meetings.operator
        self._part.linearise(velocities, False, step.gap_rate, share, start=self._first)

    def mean_jump(self, means: Mapping[int, np.ndarray], step: Step) -> np.ndarray:
        velocities = self.mean_velocities(means)
        share = self.equations.fields.end_share.x.array[:, None]
        start, end = ((J @ velocities).reshape(len(share), -1) for J in (self._first, self._last))
        return np.asarray(share * end + (1 - share) * start)

    def accept(self) -> None:
        super().accept()
        self._start = self._end

    def jump_rows(self, rows: np.ndarray) -> list[np.ndarray]:
        J, d = self.meetings.operator[rows], self._shape.dim
        result = []
        for trace, at in zip(self.traces, self._shape.slices):
            mine = J[:, at.start * d : at.stop * d]
            result.append(mine @ trace.rows(np.arange(mine.shape[1])))
        return result

    @property
    def area(self) -> np.ndarray:
        return self.meetings.area

    def near(self) -> np.ndarray:
        return self.meetings.there

    def mobility(self) -> np.ndarray:
        each = np.concatenate([trace.mobility() for trace in self.traces])
        of_nodes = each.reshape(len(self._start), -1)
        own = np.array([of_nodes[at].mean(axis=0) for at in self._shape.slices])
        mobility = np.empty((self.meetings.n, self._shape.dim))
        for body, mine in enumerate(self.meetings.slots):
            mobility[mine] = 2 * own[body]
        return mobility

    def positions(self) -> np.ndarray:
        return self.meetings.places

    def state(self) -> dict[str, np.ndarray]:
        return {f"heap_{name}": value for name, value in vars(self.meetings.features).items()}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        names = vars(self.meetings.features)
        self.meetings.features = Features(*(np.array(state[f"heap_{name}"]) for name in names))
        self.meetings.there = self.meetings.features.key >= 0
        super().restore(state)

    def describe(self) -> str:
        return f"each other ({len(self.solids)} rigid bodies)"


class Heap(Contact):
    """Rigid bodies that may all meet each other, by corners before faces and edges that cross.

    Where two rigid bodies meet is known exactly, whatever their meshes are: a corner of one lies on
    a face of the other, or two edges cross. One contact of all costs less than one of each pair
    (:class:`Contact`), which takes means over facets, as deformable bodies need them. A floor or a
    wall is a body that is held, or an obstacle in a :class:`Contact` of its own.

    Args:
        solids: the bodies, two at least.
        facets: the name of the facets of each that may meet others, flat ones: of curved ones
            their corners count.
        formulation: a law with multipliers: "velocity", "gap", "printed", "lagrange".
        friction: Coulomb's coefficient.
        normal_augmentation, tangential_augmentation, gap_tolerance, name: see :class:`Contact`.

    Attributes:
        bodies: the solids.
        owners: whose each point is, (n,): that of the corner, or of the first of two edges.

    Its columns in the history are sums over these points.

    Raises:
        InputError: what is not rigid, one body, or one twice, different dimensions, more that meet
            in one corner than there is room for; a law without multipliers, with a memory or that
            pulls, friction that is not one number.
    """

    def __init__(
        self,
        solids: Sequence[RigidSolid],
        facets: str,
        formulation: Formulation | str = "velocity",
        friction: float | FrictionBound = 0.0,
        *,
        normal_augmentation: float = 1.0,
        tangential_augmentation: float = 1.0,
        gap_tolerance: float = 1e-11,
        name: str = "heap",
    ) -> None:
        self.bodies = checks.sequence("solids", solids, RigidSolid, "rigid solids")
        _check(self.bodies)
        super().__init__(
            self.bodies[0],
            facets,
            self.bodies,  # type: ignore[arg-type]
            formulation,
            friction,
            normal_augmentation=normal_augmentation,
            tangential_augmentation=tangential_augmentation,
            gap_tolerance=gap_tolerance,
            name=name,
        )
        law = self.friction_law
        if law is not None and (not isinstance(law, Coulomb) or law.slope is None):
            raise checks.InputError(
                f"friction = {quoted(friction)}: between many bodies it is Coulomb's, "
                "with one number"
            )
        by_area = isinstance(self.formulation, Adhesive) or self.memory.values
        if by_area or not self.formulation.multipliers:
            raise checks.InputError(
                f"formulation = {self.formulation.name!r}: corners have no areas for a law that "
                "gives way, pulls or remembers; use 'velocity', 'gap', 'printed' or 'lagrange'"
            )

    def _meant(self, solid: Solid, facets: str, master: Any) -> Any:
        return tuple(self.bodies)

    def _make_surface(self) -> Surface:
        """Points of all bodies, so many times as each may meet something."""
        self._sides = sides = [side_of(body, self.facets) for body in self.bodies]
        points, cells, owner, last = [], [], [], 0
        for body, side in enumerate(sides):
            for _ in range(PLACES[side.dim]):
                points.append(side.nodes)
                cells.append(split(side.corners, side.cell) + last)
                owner.append(np.full(len(cells[-1]), body))
                last += len(side.nodes)
        kind = "interval" if sides[0].dim == 2 else "triangle"
        surface = Surface(np.concatenate(points), np.concatenate(cells), kind)
        of_node = np.empty(surface.size, dtype=np.int64)
        of_cell = np.concatenate(owner)[compat.given_cells(surface.mesh)]
        of_node[surface.cell_nodes] = of_cell[:, None]
        self.owners = of_node
        surface.extent = min(float(np.ptp(side.nodes, axis=0).max()) for side in sides)
        return surface

    def _couple(self, other: Any, clearance: Any) -> Coupling:
        try:
            return HeapJump(self, self._sides)
        except checks.StepFailed as failure:  # more meet than there is room for
            raise checks.InputError(f"solids: {failure}") from None

    def begin(self, step: Step) -> None:
        super().begin(step)
        fresh = self.coupling.fresh  # type: ignore[attr-defined]
        if fresh.any():  # what bore there was another meeting
            self.status = np.where(fresh, 0.0, self.status)
            self.blows.forget(fresh)
            values, first = self.equations.values, self.equations.jumps
            values[first:].reshape(-1, len(fresh))[:, fresh] = 0.0
            self.equations.values = values


def _check(bodies: Sequence[RigidSolid]) -> None:
    """Refuse what is no heap."""
    if len(bodies) < 2 or len({id(body) for body in bodies}) < len(bodies):
        names = [body.name for body in bodies]
        raise checks.InputError(f"solids = {names}: must be two bodies or more, each once")
    dims = [body.dim for body in bodies]
    if len(set(dims)) > 1:
        raise checks.InputError(f"solids: have dimensions {sorted(set(dims))}; all need the same")
