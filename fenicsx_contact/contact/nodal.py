# SPDX-License-Identifier: LGPL-3.0-or-later
"""The points of a contact surface before an obstacle, at rest or moving as it is told."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..base.constants import BRIEF
from ..base.vectors import dot
from ..solids import Solid, Trace
from ..solids.trace import DeformableTrace
from ..theory.theta import Step
from .equations import SurfaceEquations
from .inside import swallowed
from .jump import Coupling
from .leaps import refuse_leaps
from .wall import Obstacle, Wall


class NodalJump(Coupling):
    """Nodes of a solid before an obstacle: their velocities less the obstacle's are the jumps.

    An obstacle that moves ends a step with a velocity that suits the scheme: by theta = 1 with its
    mean velocity in the step, with which a point that sticks goes exactly the obstacle's way; by
    theta = 1/2 with that of the very end. A step starts with the velocity with which the last one
    ended; where the motion has a corner there, a percussion sees the new one.

    Args:
        solid, obstacle: what may touch.
        equations: of the solid's surface.
        trace: the solid seen from its points, or by means.
        bulge: how far these lie outside of the points, (n,) in m.
    """

    def __init__(
        self,
        solid: Solid,
        equations: SurfaceEquations,
        obstacle: Obstacle,
        trace: Trace | None = None,
        bulge: np.ndarray | float = 0.0,
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
        # velocities of the obstacle: before the begun step, in it at the start and at the end
        self._before: np.ndarray | None = None
        self._start = self._end = np.zeros(self._shape)
        self._start_positions = self.traces[0].positions()
        self._seen: np.ndarray | None = None  # depths in the followed state, once asked for
        self._normals: np.ndarray | None = None

    def begin(self, step: Step) -> None:
        self._seen = None
        if not self.driven:
            return
        super().begin(step)
        self._step, x = step, self._start_positions
        new = self._velocity_at(x, step.start, BRIEF * step.horizon)
        self._before = new if self._before is None else self._before
        late = step.implicitness
        self._struck = (1 - late) * new + late * self._before
        self._start = self._before if step.dt else self._struck
        self._end = self._last_velocity(x)
        if late < 1:
            refuse_leaps(self.wall, x, self.normals(), new, step)

    def _last_velocity(self, x: np.ndarray) -> np.ndarray:
        """Velocities of the obstacle beside these places at the end of the begun step."""
        step = self._step
        assert step is not None
        if not step.dt:
            return self._struck
        late, end = step.implicitness, step.end
        velocity = np.zeros(self._shape)
        if late < 1:
            velocity += (1 - late) * self._velocity_at(x, end, -BRIEF * step.dt)
        if late:
            velocity += late * self.wall.velocity(x, step.start, end)
        return velocity

    def _velocity_at(self, x: np.ndarray, time: float, brief: float) -> np.ndarray:
        """Velocities of the obstacle at an instant, by what follows in a brief time, s, or, if that
        is negative, by what went before: of second order in it."""
        one, two = (self.wall.velocity(x, *sorted((time, time + k * brief))) for k in (1.0, 2.0))
        return np.asarray(2 * one - two)

    def follow(self) -> None:
        self._seen = None
        self.traces[0].follow()
        if self._step:
            self._end = self._last_velocity(self.positions())

    def accept(self) -> None:
        super().accept()
        if self.driven or not self.fixed_normal:
            self._start_positions = self.positions()
        if self.driven:
            self._before = self._end if self._step else self._before

    def _depths(self) -> np.ndarray:
        if self._seen is None:
            self._seen = -self.wall.distance(self.traces[0].positions(), self.time) - self.bulge
        return self._seen

    def normals(self) -> np.ndarray:
        if self._normals is None or not self.fixed_normal:
            self._normals = -self.wall.normals(self.traces[0].positions(), self.time)
        return self._normals

    def turns(self, old: np.ndarray, new: np.ndarray, step: Step) -> np.ndarray:
        places = 0.5 * (self._start_positions + self.traces[0].positions())
        midway = -self.wall.normals(places, 0.5 * (step.start + step.end))
        # before an edge or behind it that is one of them, along a round wall their mean
        length = np.linalg.norm(old + new, axis=1)
        mean = (old + new) / np.where(length > 0, length, 1.0)[:, None]
        off, before, behind = (dot(each, each) for each in (midway - n for n in (mean, old, new)))
        return super().turns(old, new, step) & (off <= np.minimum(before, behind))

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

    def force(self, force: np.ndarray) -> np.ndarray:
        return force.reshape(self._shape)

    def linearise(self, step: Step, exact: bool, share: float, kept: bool = False) -> None:
        e = self.equations
        if self.driven:
            e.carried[:] = self._end.ravel()
        e.tangents.turn()
        if not exact:
            return
        jump, values = self.jump("trial_velocity"), e.values
        values[: e.jumps] = jump.ravel()
        e.values = values
        curvature = self.wall.curvature(self.traces[0].positions(), self.time)
        if curvature is not None:
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
        last, wall, time = self.positions(), self.wall, self.time
        way = last - self._start_positions
        if self._step:  # as seen from a wall that moves
            way = way - self._step.dt * self.carried(self._step)
        # what moves less than it was and is away goes through nothing
        asked = asked & (np.linalg.norm(way, axis=1) > -np.minimum(start, end))
        if not asked.any():
            return end

        # the gap is largest where the point, which came nearer, begins to leave
        def place(share: np.ndarray) -> np.ndarray:
            return last - (1 - share)[:, None] * way

        def leaves(share: np.ndarray) -> np.ndarray:
            return dot(wall.normals(place(share), time), way) > 0

        near, far = np.zeros(len(end)), np.ones(len(end))
        turns = asked & ~leaves(near) & leaves(far)
        if not turns.any():
            return end
        for _ in range(np.finfo(float).nmant // 2):  # there gaps hardly change
            middle = 0.5 * (near + far)
            back = leaves(middle)
            near, far = np.where(back, near, middle), np.where(back, middle, far)
        return np.where(turns, -wall.distance(place(near), time) - self.bulge - self.recess, end)

    def swallowed(self, most: float) -> str:
        solid = self.solids[0]
        depth = 0.0 if self.encloses else swallowed(solid, self.wall, most)
        return f"the obstacle, {depth:.4g} deep, inside {solid.name!r}" if depth else ""

    @property
    def reference(self) -> np.ndarray:
        trace = self.traces[0]
        return trace.reference if isinstance(trace, DeformableTrace) else super().reference

    def mobility(self) -> np.ndarray:
        return self.traces[0].mobility().reshape(self._shape)

    def state(self) -> dict[str, np.ndarray]:
        carried = {} if self._before is None else {"carried": self._before}
        return {"time": np.array(self.time), **carried}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        self._step, self.time = None, float(state["time"])
        self._before = np.array(state["carried"]) if "carried" in state else None
        self._start = self._end = np.zeros(self._shape) if self._before is None else self._before
        super().restore(state)

    def jump_rows(self, rows: np.ndarray) -> list[np.ndarray]:
        return [self.traces[0].rows(rows)]

    def describe(self) -> str:
        return self.wall.describe()
