# SPDX-License-Identifier: LGPL-3.0-or-later
"""The points of a contact surface before an obstacle, at rest or moving as it is told."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf

import numpy as np

from ..base.constants import RIGHT, SHARP
from ..base.vectors import dot, longest
from ..solids import Solid, Trace
from ..solids.trace import DeformableTrace
from ..theory.scheme import Step
from .edges import Faces
from .equations import SurfaceEquations
from .inside import swallowed
from .jump import Coupling
from .ride import Ride
from .wall import Obstacle, Wall
from .ways import Ways, heights


class NodalJump(Coupling):
    """Nodes of a solid before an obstacle: their velocities less the obstacle's are the jumps.

    Args:
        solid, obstacle: what may touch.
        equations: of the solid's surface.
        trace: the solid seen from its points, or by means.
        bulge: how far these lie outside of the points, (n,) in m.
        percussive: whether the law of the contact knows percussions.
    """

    def __init__(
        self,
        solid: Solid,
        equations: SurfaceEquations,
        obstacle: Obstacle,
        trace: Trace | None = None,
        bulge: np.ndarray | float = 0.0,
        percussive: bool = True,
    ) -> None:
        self.obstacle, self.wall = obstacle, Wall(obstacle)
        self.part = self.equations = equations
        self.solids = [solid]
        self.bulge = bulge
        self.traces = [trace or solid.trace(equations.fields.surface.points)]
        self.fixed_normal, self.driven = self.wall.flat, self.wall.moving
        self._shape = equations.fields.surface.points.shape
        self._everywhere = np.ones(self._shape[0], dtype=bool)
        self._step: Step | None = None
        self._ahead = 0.0
        self.ride = Ride(self.wall, self._shape, percussive)  #: how the obstacle moves beside them
        self._start_positions = self.traces[0].positions()
        self._seen: np.ndarray | None = None  # depths in the followed state, once asked for
        self._normals: np.ndarray | None = None
        self._start_normals: np.ndarray | None = None
        surface = equations.fields.surface
        self.by_faces = self.wall.edged and not (self.fixed_normal or self.encloses)
        self._by_way = Faces(self.wall, surface.cell_nodes, surface.extent)

    def begin(self, step: Step) -> None:
        self._forget()
        self._ahead = 0.0 if step.dt else step.horizon  # s: who comes by then may be struck now
        if not self.driven:
            return
        super().begin(step)
        self._step = step
        met = self._start_normals if self.by_faces else None
        self.ride.begin(step, self._start_positions, met)

    def _forget(self) -> None:
        self._seen = None
        if not self.fixed_normal:
            self._normals = None

    def follow(self) -> None:
        self._forget()
        self.traces[0].follow()
        if self._step:
            self.ride.follow(self.positions())

    def accept(self) -> None:
        super().accept()
        if self.driven or not self.fixed_normal:
            self._start_positions = self.positions()
        if self.driven:
            self.ride.accept()

    def _depths(self) -> np.ndarray:
        if self._seen is None and self.by_faces:
            return self._meet()[1]
        if self._seen is None:
            self._seen = -self.wall.distance(self.traces[0].positions(), self.time) - self.bulge
        return self._seen

    def normals(self) -> np.ndarray:
        if self._normals is None and self.by_faces:
            return self._meet()[0]
        if self._normals is None:
            self._normals = -self.wall.normals(self.traces[0].positions(), self.time)
        return self._normals

    def _meet(self) -> tuple[np.ndarray, np.ndarray]:
        """Normals and depths of faces."""
        way = (x := self.traces[0].positions()) - self._start_positions
        if (step := self._step) and step.dt:
            way -= step.dt * self.wall.velocity(x, step.start, step.end)
        self._way, look = way, self._by_way.meet
        if self._ahead:
            way, look = self._ahead * self.jump("velocity"), self._by_way.ahead
        outward, distance = look(x, way, self.time)
        self._normals, self._seen = -outward, -distance - self.bulge
        return self._normals, self._seen

    def keep_normals(self) -> np.ndarray:
        self._start_normals = self.normals()
        if self.by_faces:
            self._by_way.start(-self._start_normals, -self._depths() - self.bulge)
        return self._start_normals

    def start_normals(self) -> np.ndarray:
        # a guide is asked where its points will be, beyond a kink
        kept = self._start_normals
        return self.normals() if self.encloses or kept is None else kept

    def start_along(self, jump: np.ndarray, normals: np.ndarray) -> np.ndarray:
        along = super().start_along(jump, normals)
        if not self.driven or self.fixed_normal:
            return along
        ride = self.ride
        return along + dot(ride.start, normals) - ride.start_speed(self.positions(), normals)

    def begun_gaps(self, gap: np.ndarray, step: Step) -> np.ndarray:
        if not (other := self.other_faces(step)).any():
            return gap
        return np.where(other, self.gaps() - dot(self._way, self.normals()), gap)

    def other_faces(self, step: Step) -> np.ndarray:
        """Points that meet another face now than where the step started, (n,) of bool."""
        if not self.by_faces:
            return ~self._everywhere
        old, new = self.start_normals(), self.normals()
        other = (np.abs(new - old) > RIGHT).any(axis=1)
        return other & ~self.turns(old, new, step) if other.any() else other

    def turns(self, old: np.ndarray, new: np.ndarray, step: Step) -> np.ndarray:
        places = 0.5 * (self._start_positions + self.traces[0].positions())
        midway = -self.wall.normals(places, 0.5 * (step.start + step.end))
        # before an edge or behind it that is one of them, along a round wall their mean
        length = np.linalg.norm(old + new, axis=1)
        mean = (old + new) / np.where(length > 0, length, 1.0)[:, None]
        off, before, behind = (dot(each, each) for each in (midway - n for n in (mean, old, new)))
        return super().turns(old, new, step) & (off <= np.minimum(before, behind))

    def to_jump(self, velocities: np.ndarray) -> np.ndarray:
        return velocities.reshape(self._shape) - self.ride.end

    def jump(self, which: str) -> np.ndarray:
        own = self.ride.start if which == "velocity" else self.ride.end  # 0 of what stands
        return self.velocities(which).reshape(self._shape) - own

    def fastest(self, which: str) -> float:
        return longest(self.jump(which))

    def struck_jump(self) -> np.ndarray:
        return self.velocities("velocity").reshape(self._shape) - self.ride.struck

    def mean_jump(self, means: Mapping[int, np.ndarray], step: Step) -> np.ndarray:
        jump = self.traces[0].mean_jump(means[id(self.solids[0])]).reshape(self._shape)
        return jump - self.carried(step)

    def started_along(self, vectors: np.ndarray) -> np.ndarray:
        return dot(self.ride.start, vectors)

    def sudden(self, gap: np.ndarray, step: Step) -> float:
        if not self.driven:
            return inf
        own = self.velocities("velocity").reshape(self._shape)
        return self.ride.sudden(self._start_positions, own, gap, step)

    def carried(self, step: Step) -> np.ndarray | float:
        if not self.driven:
            return 0.0
        return step.scheme.mean(self.ride.start, self.ride.end) + self.aside(step)

    def drift(self) -> np.ndarray:
        return self.ride.start.mean(axis=0)  # none of what stands

    def aside(self, step: Step) -> np.ndarray | float:
        k = self.equations.fields
        if not self.driven or self.fixed_normal or k.start_normal is None:
            return 0.0
        old = k.start_normal.x.array.reshape(self._shape) if self.encloses else None
        normals, share = (old, self.normals()), k.end_share.x.array
        return self.ride.aside(self.positions(), normals, k.mean_normal(), share)

    def force(self, force: np.ndarray) -> np.ndarray:
        return force.reshape(self._shape)

    def linearise(self, step: Step, exact: bool, share: float, kept: bool = False) -> None:
        e = self.equations
        if self.driven:
            e.carried[:] = self.ride.end.ravel()
        e.tangents.turn()
        if not exact:
            return
        jump, values = self.jump("trial_velocity"), e.values
        values[: e.jumps] = jump.ravel()
        e.values = values
        curvature = self.wall.curvature(self.traces[0].positions(), self.time)
        if curvature is not None:
            if self.by_faces:  # of a plane there is none
                curvature = np.where(self._by_way.kept[:, None, None], 0.0, curvature)
            # n = -(outward normal); the gap read is that of the end less gap_rate w . n
            turn = -step.gap_rate * curvature
            e.tangents.turn(-share * step.gap_rate * np.einsum("pi,pij->pj", jump, turn), turn)

    @property
    def area(self) -> np.ndarray:
        return self.equations.fields.surface.area

    def near(self) -> np.ndarray:
        return self._everywhere

    def deepest(self, asked: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        if self.fixed_normal:
            return end
        way, step = self.positions() - self._start_positions, self._step
        # as seen from a wall that moves; what moves less than it was and is away meets nothing
        seen = way - step.dt * self.carried(step) if step else way
        asked = asked & (np.linalg.norm(seen, axis=1) > -np.minimum(start, end))
        deep = self._ways().depths(asked, end)
        if not step:
            return deep
        # What accelerates beside a wall that does goes by no chord: what comes back to the same
        # side goes through only if it does by the parabola of the velocities at both ends, too.
        ends = "velocity", "trial_velocity"
        first, last = (self.velocities(which).reshape(way.shape) for which in ends)
        back = asked & (deep > end) & (dot(self.start_normals(), self.normals()) > SHARP)
        arcs = self._ways(0.5 * step.dt * (first - last)).depths(back, end)
        return np.where(back, np.minimum(deep, arcs), deep)

    def dips(self) -> np.ndarray | float:
        if self.fixed_normal or (old := self._start_normals) is None:
            return 0.0
        return heights(self.positions() - self._start_positions, old, self.normals())

    def other_side(self, asked: np.ndarray) -> np.ndarray:
        other = np.zeros(len(asked), dtype=bool)
        asked = asked & ~self._by_way.kept if self.by_faces else asked
        if not self.fixed_normal and (points := asked.nonzero()[0]).size:
            ways = self._ways()
            entries = ways.entries(points, ways.deepest(asked)[points])
            enters = -ways.normals(points, entries)
            other[points] = dot(enters, self.normals()[points]) < SHARP
        return other

    def _ways(self, bend: np.ndarray | None = None) -> Ways:
        ends, step = self.positions(), self._step
        span = (step.start, step.end) if step else (self.time,) * 2
        off = self.bulge + self.recess + np.zeros(len(ends))
        return Ways(self.wall, ends, ends - self._start_positions, span, off, bend)

    def swallowed(self, most: float) -> str:
        return "" if self.encloses else swallowed(self.solids[0], self.wall, most)

    def held(self) -> np.ndarray:
        return np.asarray((self.held_components | (self.normals() == 0)).all(axis=1))

    @property
    def reference(self) -> np.ndarray:
        trace = self.traces[0]
        return trace.reference if isinstance(trace, DeformableTrace) else super().reference

    def mobility(self) -> np.ndarray:
        return self.traces[0].mobility().reshape(self._shape)

    def state(self) -> dict[str, np.ndarray]:
        return self.ride.state() | (self._by_way.state() if self.by_faces else {})

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        self.ride.restore(state)
        self._step, self._ahead, self.time = None, 0.0, self.ride.time
        self._start_normals = np.array(state["normal"])
        if self.by_faces:
            self._start_normals = -self._by_way.restore(state)
        super().restore(state)

    def jump_rows(self, rows: np.ndarray) -> list[np.ndarray]:
        return [self.traces[0].rows(rows)]

    @property
    def remark(self) -> str:
        return str(getattr(self.obstacle, "remark", ""))

    def describe(self) -> str:
        return self.wall.describe()
