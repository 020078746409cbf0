# SPDX-License-Identifier: LGPL-3.0-or-later
"""Points of a solid in a linearised step, before what bears was put back to its gaps: where they
are, how they move, and how forces at them act on it."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..solids import MonolithicTrace
from ..theory.scheme import Step
from .kinematics import Arms
from .motion import Motion
from .rigid import RigidMotion


class Points:
    """Points of a solid whose places are linear in its unknowns.

    Args:
        motion: of the solid.
        trace: of the points, which has followed it.
        step: that was solved.

    Attributes:
        old, new: kinematics at the start and at the end of the step.
        old_places, places: there, (n, d) in m; ``old_velocities``, ``velocities``: (n, d) in m/s.
        forces: operator whose transpose takes forces at them to the solid, (n d, size).
        ends, end_places: kinematics and places where the step ends.
    """

    def __init__(self, motion: Motion, trace: MonolithicTrace, step: Step) -> None:
        solid, J, x = motion.solid, trace.seeing(), trace.positions()
        self.forces = J
        self.old = self.new = self.ends = motion.seen(J)
        self.places = self.end_places = x
        way = J @ (solid.trial_displacement - solid.displacement)
        self.old_places = x - way.reshape(x.shape)
        self.old_velocities, self.velocities = (
            trace.jump(v).reshape(x.shape) for v in (solid.velocity, solid.trial_velocity)
        )

    def turned(self, forces: np.ndarray) -> dict[str, Any]:
        """Derivatives of what forces (n, d) are to the solid by what else these depend on: its
        places ``"q_old"`` and ``"q"``."""
        return {}


class RigidPoints(Points):
    """Points of a rigid solid.

    Attributes:
        arms: from its centre to the points, at the start and at the end.
    """

    def __init__(self, motion: RigidMotion, trace: MonolithicTrace, step: Step) -> None:
        solid, d, x = motion.solid, motion.solid.dim, trace.positions()
        ends, back = x - solid.trial_place, solid.trial_turn.T
        self.arms = [Arms(ends @ (turn @ back).T) for turn in motion.turn]
        spins = [velocity[d:] for velocity in motion.velocity]
        self.old, self.new = (arm.kinematics(spin) for arm, spin in zip(self.arms, spins))
        self.ends, self.end_places = Arms(ends).kinematics(spins[1]), x
        self._held, self._weight = motion.held, step.scheme.force_weight
        self.forces = self._weight * self.new.place + (1 - self._weight) * self.old.place
        self.forces[:, self._held] = 0.0
        self.old_places, self.places = (at + a.arms for at, a in zip(motion.place, self.arms))
        self.old_velocities, self.velocities = (
            (k.place @ v).reshape(x.shape) for k, v in zip((self.old, self.new), motion.velocity)
        )

    def turned(self, forces: np.ndarray) -> dict[str, Any]:
        result = []
        for share, arms in zip((1 - self._weight, self._weight), self.arms):
            block = share * arms.turned(forces)
            block[self._held] = 0.0
            result.append(block)
        return dict(zip(("q_old", "q"), result))


def points_of(motion: Motion, trace: MonolithicTrace, step: Step) -> Points:
    """Those of a trace."""
    rigid = isinstance(motion, RigidMotion)
    return (RigidPoints if rigid else Points)(motion, trace, step)  # type: ignore[arg-type]
