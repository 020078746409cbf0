# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the points of a contact surface meet: an obstacle, or another solid.

Both give gaps, normals and jumps at the nodes of the slave, and the part of the surface system in
which they enter. Nothing else in a contact knows which of the two it is.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping

import numpy as np

from ..solids import Solid, Trace
from ..solve.surface_problem import Part
from ..theory.theta import Step
from .equations import SurfaceEquations
from .mortar import Pairing, Side
from .mortar.matrices import square
from .pair_equations import PairedEquations
from .surface import Surface
from .wall import Obstacle, Wall

#: Share of a step over which the velocity of an obstacle that moves is taken at the ends of it.
BRIEF = 2.0**-10


class Coupling(ABC):
    """Traces of the solids on their points, and what they mean for the slave's nodes.

    Attributes:
        solids, traces: the slave's first.
        part: the equations, in the velocities of the traces' points.
        fixed_normal: whether the normals never change.
        driven: whether the other side moves as it is told.
        time: of the trial state, s.
    """

    solids: list[Solid]
    traces: list[Trace]
    part: Part
    fixed_normal: bool
    driven = False
    time = 0.0

    def begin(self, step: Step) -> None:
        """Take up what is given of the other side in a step; of a solid nothing is."""
        self.time = step.end

    @abstractmethod
    def follow(self) -> None:
        """Take up the trial states of the solids."""

    @abstractmethod
    def gaps(self) -> np.ndarray:
        """Gaps d_n in the followed state, positive: penetration, (n,) in m."""

    @abstractmethod
    def normals(self) -> np.ndarray:
        """Outward unit normals of the slave, (n, d)."""

    @abstractmethod
    def to_jump(self, velocities: np.ndarray) -> np.ndarray:
        """Nodal jumps (n, d) from velocities of the traces' points, flat."""

    @abstractmethod
    def linearise(self, step: Step, exact: bool, share: float) -> None:
        """Take up the geometry where it is; see :class:`PairedEquations`."""

    @property
    @abstractmethod
    def area(self) -> np.ndarray:
        """Area of the slave that belongs to each node, where it meets something, (n,) in m²."""

    @abstractmethod
    def near(self) -> np.ndarray:
        """Whether each node of the slave may meet anything in the step, (n,)."""

    def accept(self) -> None:
        """The followed state is the start of the next step."""
        for trace in self.traces:
            trace.accept()

    def velocities(self, which: str) -> np.ndarray:
        """Velocities of the traces' points: of the solids' ``velocity`` or ``trial_velocity``."""
        parts = [t.jump(getattr(s, which)) for s, t in zip(self.solids, self.traces)]
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def jump(self, which: str) -> np.ndarray:
        """Nodal jumps (n, d), likewise."""
        return self.to_jump(self.velocities(which))

    def struck_jump(self) -> np.ndarray:
        """Nodal jumps (n, d) at the start of the begun step, if it starts with a percussion."""
        return self.jump("velocity")

    def mean_jump(self, means: Mapping[int, np.ndarray], step: Step) -> np.ndarray:
        """Nodal jumps from mean velocities of the solids, by id, by the operators whose
        transposes spread the forces."""
        parts = [t.mean_jump(means[id(s)]) for s, t in zip(self.solids, self.traces)]
        return self.to_jump(parts[0] if len(parts) == 1 else np.concatenate(parts))

    def carried(self, step: Step) -> np.ndarray | float:
        """Mean velocities in the step of what moves as it is told, (n, d)."""
        return 0.0

    def state(self) -> dict[str, np.ndarray]:
        """The arrays from which :meth:`restore` continues identically, beside the solids'."""
        return {}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Take up a state that :meth:`state` gave; the solids have been restored before."""
        self.follow()
        self.accept()

    @abstractmethod
    def mobility(self) -> np.ndarray:
        """What a unit force moves the slave's nodes against the other side, about, (n, d)."""

    @abstractmethod
    def describe(self) -> str:
        """The master in a few words."""

    def positions(self) -> np.ndarray:
        """Places of the slave's nodes, (n, d) in m."""
        return self.traces[0].positions()


class NodalJump(Coupling):
    """Nodes of a solid before an obstacle: their velocities less the obstacle's are the jumps.

    An obstacle that moves ends a step with a velocity that suits the scheme: by theta = 1 with its
    mean velocity in the step, with which a point that sticks goes exactly the obstacle's way; by
    theta = 1/2 with that of the very end. A step starts with the velocity with which the last one
    ended; where the motion has a corner there, a percussion sees the new one.
    """

    def __init__(
        self,
        solid: Solid,
        equations: SurfaceEquations,
        obstacle: Obstacle,
        trace: Trace | None = None,
    ) -> None:
        self.obstacle, self.wall = obstacle, Wall(obstacle)
        self.part = self.equations = equations
        self.solids = [solid]
        self.traces = [trace or solid.trace(equations.fields.surface.points)]
        self.fixed_normal, self.driven = self.wall.flat, self.wall.moving
        self._shape = equations.fields.surface.points.shape
        self._step: Step | None = None
        # velocities of the obstacle: before the begun step, in it at the start and at the end
        self._before: np.ndarray | None = None
        self._start = self._end = np.zeros(self._shape)
        self._start_positions = self.traces[0].positions()

    def begin(self, step: Step) -> None:
        if not self.driven:
            return
        super().begin(step)
        self._step, x = step, self._start_positions
        new = self.wall.velocity(x, step.start, step.start + BRIEF * step.horizon)
        self._before = new if self._before is None else self._before
        late = step.implicitness
        self._struck = (1 - late) * new + late * self._before
        self._start = self._before if step.dt else self._struck
        self._end = self._last_velocity(x)

    def _last_velocity(self, x: np.ndarray) -> np.ndarray:
        """Velocities of the obstacle beside these places at the end of the begun step."""
        step = self._step
        assert step is not None
        if not step.dt:
            return self._struck
        late, end = step.implicitness, step.end
        velocity = np.zeros(self._shape)
        if late < 1:
            velocity += (1 - late) * self.wall.velocity(x, end - BRIEF * step.dt, end)
        if late:
            velocity += late * self.wall.velocity(x, step.start, end)
        return velocity

    def follow(self) -> None:
        self.traces[0].follow()
        if self._step:
            self._end = self._last_velocity(self.positions())

    def accept(self) -> None:
        super().accept()
        if self.driven:
            self._start_positions = self.positions()
            self._before = self._end if self._step else self._before

    def gaps(self) -> np.ndarray:
        return -self.wall.distance(self.traces[0].positions(), self.time)

    def normals(self) -> np.ndarray:
        return -self.wall.normals(self.traces[0].positions(), self.time)

    def to_jump(self, velocities: np.ndarray) -> np.ndarray:
        jump = velocities.reshape(self._shape)
        return jump - self._end if self.driven else jump

    def jump(self, which: str) -> np.ndarray:
        jump = self.velocities(which).reshape(self._shape)
        if not self.driven:
            return jump
        return jump - (self._start if which == "velocity" else self._end)

    def struck_jump(self) -> np.ndarray:
        jump = self.velocities("velocity").reshape(self._shape)
        return jump - self._struck if self.driven else jump

    def mean_jump(self, means: Mapping[int, np.ndarray], step: Step) -> np.ndarray:
        jump = self.traces[0].mean_jump(means[id(self.solids[0])]).reshape(self._shape)
        return jump - self.carried(step)

    def carried(self, step: Step) -> np.ndarray | float:
        return step.scheme.mean(self._start, self._end) if self.driven else 0.0

    def linearise(self, step: Step, exact: bool, share: float) -> None:
        e = self.equations
        if self.driven:
            e.carried[:] = self._end.ravel()
        e.turn()
        if not exact:
            return
        jump, values = self.jump("trial_velocity"), e.values
        values[: e.jumps] = jump.ravel()
        e.values = values
        curvature = self.wall.curvature(self.traces[0].positions(), self.time)
        if curvature is not None:
            # n = -(outward normal); the gap read is that of the end less gap_rate w . n
            turn = -step.gap_rate * curvature
            e.turn(-share * step.gap_rate * np.einsum("pi,pij->pj", jump, turn), turn)

    @property
    def area(self) -> np.ndarray:
        return self.equations.fields.surface.area

    def near(self) -> np.ndarray:
        return np.ones(self._shape[0], dtype=bool)

    def mobility(self) -> np.ndarray:
        return self.traces[0].mobility().reshape(self._shape)

    def state(self) -> dict[str, np.ndarray]:
        if self._before is None:
            return {}
        return {"time": np.array(self.time), "carried": self._before}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        self._step = None
        if "time" in state:
            self.time, self._before = float(state["time"]), np.array(state["carried"])
            self._start = self._end = self._before
        super().restore(state)

    def describe(self) -> str:
        return self.wall.describe()


class MortarJump(Coupling):
    """The facets of a solid before those of another."""

    fixed_normal = False

    def __init__(
        self, solids: tuple[Solid, Solid], sides: tuple[Side, Side], equations: SurfaceEquations
    ) -> None:
        self.solids, self.equations = list(solids), equations
        self.pairing = Pairing(*sides)
        self.traces = [solid.trace(side.nodes) for solid, side in zip(solids, sides)]
        self.part = self._part = PairedEquations(equations, self.pairing)
        self._shape = (self.pairing.total, sides[0].dim)
        self._n = self.pairing.n
        self._start = self._places()
        self.faces = self._find()
        self.follow()

    def _places(self) -> np.ndarray:
        return np.concatenate([trace.positions() for trace in self.traces])

    def _find(self) -> bool:
        """Whether the sides face each other anywhere, near or, at last, far apart."""
        way, farthest = 0.0, float(np.ptp(self._start, axis=0).sum())
        while True:
            self.pairing.update(self._start, way)
            if self.pairing.paired.any() or way > farthest:
                return bool(self.pairing.paired.any())
            way = max(4 * way, 0.01 * farthest)

    def follow(self) -> None:
        for trace in self.traces:
            trace.follow()
        places = self._places()
        moved = float(np.abs(places - self._start).max())
        self.pairing.update(places, moved)

    def gaps(self) -> np.ndarray:
        return self.pairing.gap

    def normals(self) -> np.ndarray:
        return self.pairing.normal

    def to_jump(self, velocities: np.ndarray) -> np.ndarray:
        return self.pairing.operator @ velocities.reshape(self._shape)

    def linearise(self, step: Step, exact: bool, share: float) -> None:
        velocities = self.velocities("trial_velocity")
        self._part.linearise(velocities, exact, step.gap_rate, share)

    def accept(self) -> None:
        super().accept()
        self._start = self.pairing.places

    def mobility(self) -> np.ndarray:
        mobility = np.concatenate([trace.mobility() for trace in self.traces])
        return square(self.pairing.operator) @ mobility.reshape(self._shape)

    def describe(self) -> str:
        return f"{self.solids[1].name!r}, {len(self.pairing.master.cells)} facets"

    def positions(self) -> np.ndarray:
        return self.pairing.places[: self._n]

    @property
    def area(self) -> np.ndarray:
        return self.pairing.area

    def near(self) -> np.ndarray:
        return self.pairing.near


def side_of(solid: Solid, facets: str, surface: Surface | None = None) -> Side:
    """The side that the named facets of a solid are, in the numbers of the surface, if given."""
    points, cells, cell = solid.mesh.boundary(facets)
    inside = solid.mesh.behind(facets)
    if surface is not None:
        points, cells = surface.points, surface.cell_nodes
    return Side(points, cells, cell, inside, getattr(solid, "degree", 1))
