# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the points of a contact surface meet: an obstacle, or another solid.

Both give gaps, normals and jumps at the nodes of the slave, and the part of the surface system in
which they enter. Nothing else in a contact knows which of the two it is.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from functools import cached_property
from math import inf

import numpy as np

from ..base import checks
from ..base.quoted import quoted
from ..base.vectors import dot, largest, spread
from ..solids import Solid, Trace
from ..theory.scheme import Step
from .clearance import Clearance
from .part import Part


class Coupling(ABC):
    """Traces of the solids on their points, and what they mean for the slave's nodes.

    Attributes:
        solids, traces: the slave's first.
        part: the equations, in the velocities of the traces' points.
        fixed_normal: whether the normals never change.
        driven: whether the other side moves as it is told.
        encloses: whether it is around the slave, which then passes through no wall.
        by_means: whether gaps are means over facets, which are others where solids are put back.
        shares: whether points of rigid solids share what they bear by their areas.
        blocked: why the slave cannot go on like that, in the followed state, or "".
        time: of the trial state, s.
        by_means_alone: by how much more gaps were inside than any point, at most, m, and when, s.
        deepest_gap: of those that are means, in accepted states, m.
        apart, late: how far what bears was from what it meets, at most, when it began to, m, and
            how far inside.
        recess: how far the surface has worn back, (n,) in m, or 0.
        acting: what acts on the slave's nodes, (n, d) in N, where the law alone does not say it.
    """

    solids: list[Solid]
    traces: list[Trace]
    part: Part
    fixed_normal: bool
    driven = False
    encloses = by_means = False
    shares = True
    time = 0.0
    by_means_alone = 0.0, 0.0
    deepest_gap = apart = late = 0.0
    recess: np.ndarray | float = 0.0
    acting: np.ndarray | None = None

    @property
    def remark(self) -> str:
        """What a reader of a run should know of the other side, or nothing."""
        return ""

    @property
    def blocked(self) -> str:
        return ""

    def begin(self, step: Step) -> None:
        """Take up what is given of the other side in a step; of a solid nothing is."""
        self.time = step.end

    def stand(self, bears: np.ndarray, step: Step) -> bool:
        """Ask where a step starts what stands on a corner, given what bears, (n,) of bool; whether
        gaps and jumps have become others by that."""
        return False

    @abstractmethod
    def follow(self) -> None:
        """Take up the trial states of the solids."""

    def gaps(self) -> np.ndarray:
        """Gaps d_n in the followed state, positive: penetration, (n,) in m."""
        return self._depths() - self.recess

    @abstractmethod
    def _depths(self) -> np.ndarray:
        """Those of a surface without wear."""

    def inside(self) -> float:
        """How deep either side reaches into the other in the followed state, as far as points tell
        at which they are compared, m."""
        return largest(np.maximum(self.gaps(), 0.0))

    def keep_apart(self, clearance: Clearance) -> None:
        """Let the followed state have this clearance, whatever the meshes say."""
        if clearance is not None:
            told = f"clearance = {quoted(clearance)}: is between two solids"
            raise checks.InputError(f"{told}; move the obstacle instead")

    def swallowed(self, most: float) -> str:
        """How far a solid lies inside another, unseen by what the points meet and by more than
        ``most``, m; or nothing."""
        return ""

    def deepest(self, asked: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        """The largest gap of the points that are ``asked``, (n,) of bool, on their ways in the
        step, as far as that can be told, from the gaps at both ends, (n,) in m."""
        return end

    def dips(self) -> np.ndarray | float:
        """How far the straight ways of points from the start of the step to the followed state dip
        below arcs that turn as the normals between both do, at most, (n,) in m."""
        return 0.0

    def other_side(self, asked: np.ndarray) -> np.ndarray:
        """Which of the points that are ``asked``, (n,) of bool, get inside on their ways by another
        side than they are before in the followed state, likewise."""
        return np.zeros_like(asked)

    @abstractmethod
    def normals(self) -> np.ndarray:
        """Outward unit normals of the slave, (n, d)."""

    def start_normals(self) -> np.ndarray:
        """Those at the start of the step, along which what comes there is seen, (n, d)."""
        return self.normals()

    keep_normals = start_normals  #: those where a step starts, which are to be known in it

    def begun_gaps(self, gap: np.ndarray, step: Step) -> np.ndarray:
        """Gaps where the step starts (n,), from those of what was met there, of what is met now."""
        return gap

    def coming(self, jump: np.ndarray, touches: np.ndarray) -> np.ndarray:
        """How fast points come by jumps at the start of the step (n, d), (n,) in m/s: along the
        normals there where they touch, (n,) of bool; elsewhere along those where they are about to
        be, which may be beyond what they would meet."""
        start, now = self.start_normals(), self.normals()
        along = self.start_along(jump, now)
        return along if start is now else np.where(touches, dot(jump, start), along)

    def start_along(self, jump: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """Jumps at the start of the step (n, d) along normals at its end, (n,): how fast the gap
        there changes by them."""
        return dot(jump, normals)

    @abstractmethod
    def to_jump(self, velocities: np.ndarray) -> np.ndarray:
        """Nodal jumps (n, d) from velocities of the traces' points, flat."""

    @abstractmethod
    def force(self, force: np.ndarray) -> np.ndarray:
        """Forces on the slave at its nodes, (n, d) in N, from those on the traces' points, flat."""

    def borne(self, law: np.ndarray, force: np.ndarray) -> np.ndarray:
        """What the slave bears at its nodes, (n, d) in N, of such forces: those there, (n, d), of
        the contact's law, and flat; ``acting``: those that act where facets are covered in part."""
        return law

    def evened(self, force: np.ndarray, area: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Forces on the slave's nodes, (n, d) in N, and areas, (n,): of what acts at one place."""
        return force, area

    @abstractmethod
    def linearise(self, step: Step, exact: bool, share: float, kept: bool = False) -> None:
        """Take up the geometry where it is; see :class:`~.pair_equations.PairedEquations`."""

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

    def arrived(self, jump: np.ndarray) -> np.ndarray:
        """Nodal jumps (n, d) in the accepted state, from those by the operators of the step."""
        return jump

    def velocities(self, which: str) -> np.ndarray:
        """Those of the traces' points, by the solids' ``velocity`` at the start or trial ones."""
        pairs = zip(self.solids, self.traces)
        if which == "velocity":  # an own trace need not tell, if where it is changes no velocity
            parts = [getattr(t, "start_jump", t.jump)(s.velocity) for s, t in pairs]
        else:
            parts = [t.jump(s.trial_velocity) for s, t in pairs]
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def fastest(self, which: str) -> float:
        """What sets the scale of speeds, m/s: by how much the velocities of the points differ,
        whatever they have in common; before an obstacle the largest less its own."""
        return spread(self.velocities(which).reshape(-1, self.solids[0].dim))

    def jump(self, which: str) -> np.ndarray:
        """Nodal jumps (n, d), likewise."""
        return self.to_jump(self.velocities(which))

    def struck_jump(self) -> np.ndarray:
        """Nodal jumps (n, d) at the start of the begun step, if it starts with a percussion."""
        return self.arrived(self.jump("velocity"))

    def loaded(self, free: np.ndarray, start: np.ndarray) -> np.ndarray:
        """By how much the loads of a step change speeds of approach, (n,) in m/s, from velocities
        of the traces' points without contact, flat, and the jumps at its start, (n, d)."""
        return np.abs(dot(self.to_jump(free) - start, self.start_normals()))

    def mean_jump(self, means: Mapping[int, np.ndarray], step: Step) -> np.ndarray:
        """Nodal jumps from mean velocities of solids, by id, by operators that spread forces."""
        return self.to_jump(self.mean_velocities(means))

    def mean_velocities(self, means: Mapping[int, np.ndarray]) -> np.ndarray:
        """Velocities of the traces' points from mean velocities of the solids, by id, flat."""
        parts = [t.mean_jump(means[id(s)]) for s, t in zip(self.solids, self.traces)]
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def carried(self, step: Step) -> np.ndarray | float:
        """Mean velocities in the step of what moves as it is told, (n, d)."""
        return 0.0

    def drift(self) -> np.ndarray | None:
        """The velocity at which an obstacle is at rest, (d,) in m/s; solids tell none."""
        return None

    def aside(self, step: Step) -> np.ndarray | float:
        """By how much these are other than the mean of those at both ends, (n, d)."""
        return 0.0

    def started_along(self, vectors: np.ndarray) -> np.ndarray:
        """Velocities with which what moves as it is told starts the step, along vectors (n, d)."""
        return np.zeros(len(vectors))

    def sudden(self, gap: np.ndarray, step: Step) -> float:
        """After how long in a step what moves as it is told changes its velocity at once, so that
        it reaches points with these gaps, (n,) in m, s; inf if it does not."""
        return inf

    def turns(self, old: np.ndarray, new: np.ndarray, step: Step) -> np.ndarray:
        """Where normals at the start and at the end of a step, (n, d), are those of what turns on
        the way, (n,) of bool, not of two faces that meet at an edge."""
        return np.asarray(dot(old, new) > 0)

    def begun(
        self, old: np.ndarray, new: np.ndarray, touches: np.ndarray, step: Step
    ) -> tuple[np.ndarray, np.ndarray]:
        """The normals at the start that count in the mean along which forces act, (n, d), and where
        they do, (n,) of bool, from those at both ends, (n, d), and what touches at the start."""
        return old, touches & self.turns(old, new, step)

    def end_share(self, step: Step) -> float:
        """What the normals at the end of a step count in the mean along which forces act."""
        return (1 + step.implicitness) / 2

    def state(self) -> dict[str, np.ndarray]:
        """The arrays from which :meth:`restore` continues identically, beside the solids'."""
        return {}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Take up a state that :meth:`state` gave; the solids have been restored before."""
        self.acting = None
        self.follow()
        self.accept()

    @abstractmethod
    def jump_rows(self, rows: np.ndarray) -> list[np.ndarray]:
        """For each solid these rows of the operator from its unknowns to the nodal jumps, dense."""

    @abstractmethod
    def mobility(self) -> np.ndarray:
        """What a unit force moves the slave's nodes against the other side, about, (n, d)."""

    @abstractmethod
    def describe(self) -> str:
        """The master in a few words."""

    @cached_property
    def held_components(self) -> np.ndarray:
        """Components of the traces' points that nothing but supports moves, (N, d) of bool."""
        held = [(getattr(t, "held", False), t.positions().size) for t in self.traces]
        parts = [np.broadcast_to(*each) for each in held]
        return np.concatenate(parts).reshape(-1, self.solids[0].dim)

    def held(self) -> np.ndarray:
        """Points whose gaps no forces change, as supports hold both sides of them, (n,) of bool."""
        return np.zeros(len(self.positions()), dtype=bool)

    def positions(self) -> np.ndarray:
        """Places of the slave's nodes, (n, d) in m."""
        return self.traces[0].positions()

    @property
    def reference(self) -> np.ndarray:
        """Those in the reference placement, (n, d) in m."""
        return self.part.equations.fields.surface.points
