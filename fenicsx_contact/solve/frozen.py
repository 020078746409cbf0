# SPDX-License-Identifier: LGPL-3.0-or-later
"""The contact problem with solids and geometry linearised, solids and multipliers together."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt
from typing import Protocol

import numpy as np
from mpi4py import MPI

from ..base.processes import any_of
from ..base.vectors import largest, worst
from ..contact.equations import SurfaceEquations
from ..contact.part import Part
from ..solids import MonolithicSolid
from ..theory.scheme import Step
from .numbering import Numbering
from .problem import Assembly
from .statuses import Statuses


class LinearSystem(Protocol):
    """What this asks of :class:`~fenicsx_contact.solve.monolithic.Monolithic`."""

    assembly: Assembly
    solids: list[MonolithicSolid]
    parts: list[Part]
    places: Numbering
    comm: MPI.Comm
    frozen: bool
    held: bool
    hyperstatic: bool
    crowded: bool
    force: np.ndarray
    rows: list[np.ndarray]
    added: np.ndarray | None

    @property
    def size(self) -> int: ...
    def assemble(self) -> None: ...
    def iterate(self, step: Step) -> bool: ...


class FrozenContact(Statuses):
    """What the inner loop of Newton's method solves, a
    :class:`~fenicsx_contact.solve.newton.ContactProblem`.

    With the multipliers held it is Tresca's problem with springs: the forces of the contacts are
    projections, the gradient of a convex function of the velocities, which vanishes where this is
    least. A line search then makes Newton's method converge from anywhere (for its use in a method
    of multipliers, X.D. Zhao, D. Sun & K.C. Toh, SIAM J. Optim. 20, 1737-1765, 2010).

    Args:
        system: begun.
        step: that it is for.
    """

    def __init__(self, system: LinearSystem, step: Step) -> None:
        self._system, self._step = system, step
        super().__init__(system.parts, [contact.name for contact in system.assembly.contacts])
        self.worst = np.inf
        self.size, self.hyperstatic = system.size, system.hyperstatic
        self.crowded = system.crowded
        self._start: list[np.ndarray] | None = None
        self.update()

    def glue(self, points: Sequence[np.ndarray]) -> None:
        """Begin with the solids as if of these points, (n,) for each contact, those of 1 were
        glued, and those of -1 open: what is then pulled opens, and what is dragged by more than
        friction bears slips. Where nothing else holds them only such a start knows of all contacts
        at once, those between solids that would fall alike among them. Springs have no multipliers
        to say so; they bear where they are."""
        added = [np.empty(0)]
        for part, glued in zip(self.parts, points):
            e, n = part.equations, len(part.active_places)
            m = len(e.candidates) * (e.tractions > e.jumps)
            scales, values = part.scales()[0][n:], part.active_values()[n:].copy()
            told = glued[e.candidates[:m]]
            far = -told * scales[:m] / sqrt(np.finfo(float).eps)  # whatever gaps say
            values[:m] = np.where(told, far, values[:m])
            change = values - part.active_values()[n:]
            part.move(np.concatenate([np.zeros(n), change]))
            added.append(change / scales)
        self.update()
        self._system.added = np.concatenate(added)
        self.iterate()
        self._system.added = None

    def turns_round(self) -> bool:
        """Whether points slide, and a first step from there moves a solid against the way it went
        in the step before: what drives it has turned, and slips of before lead far off. The state
        stays."""
        system, start = self._system, self.state()
        if not any_of(system.comm, bool((self.now() > 1).any()))[0]:
            return False
        self.iterate()
        solids = range(len(system.solids))
        ways = [self._product(*each) for each in zip(solids, zip(start, self.state()))]
        self.go_back(start)
        return min(ways) < 0

    def iterate(self, enough: float = 0.0) -> bool:
        """One Newton step, with multipliers held as far as the function falls; False where the
        tangent is singular."""
        system = self._system
        old = [solid.trial_velocity.copy() for solid in system.solids]
        system.frozen = True
        done = system.iterate(self._step)
        system.frozen = False
        if not done:
            return False
        self.update()
        if system.held:
            self._search(old)
        return True

    def state(self) -> list[np.ndarray]:
        """Velocities of the solids, then the unknowns of the contacts."""
        velocities = [solid.trial_velocity.copy() for solid in self._system.solids]
        return velocities + [part.equations.values for part in self.parts]

    def go_back(self, state: list[np.ndarray], share: float = 1.0) -> None:
        """Return to what :meth:`state` was, or only a share of the way."""
        solids = self._system.solids
        for solid, old in zip(solids, state):
            now = solid.trial_velocity
            solid.go(now + share * (old - now), self._step)
        for part, old in zip(self.parts, state[len(solids) :]):
            now = part.equations.values
            part.equations.values = now + share * (old - now)
        self.update()

    def _search(self, old: list[np.ndarray]) -> None:
        """Go from the old velocities towards the present ones, and beyond, as far as the function
        falls: its slope rises along any line. Where all points slip nothing but a weak spring in
        the matrix says how long a step is, and it may be far too short as well as too long."""
        way = [solid.trial_velocity - a for solid, a in zip(self._system.solids, old)]
        first, last = (self._slope(share, old, way) for share in (0.0, 1.0))
        if first > 0:  # a solid that buckles: nothing is least, and Newton's step stands
            self.buckles = True
            return
        low, high, share = 0.0, np.inf, 1.0
        for _ in range(np.finfo(float).nmant):  # doublings or halvings to round-off
            if 2 * abs(last) <= abs(first):
                return
            low, high = (share, high) if last < 0 else (low, share)
            share = min(2 * share, 0.5 * (low + high))
            last = self._slope(share, old, way)

    def _slope(self, share: float, old: list[np.ndarray], way: list[np.ndarray]) -> float:
        """Of the function along the way, where this share of it is gone."""
        system = self._system
        for solid, a, b in zip(system.solids, old, way):
            solid.go(a + share * b, self._step)
        self.update()
        products = zip(way, [solid.linear_residual() for solid in system.solids])
        return sum(self._product(k, each) for k, each in enumerate(products))

    def _product(self, solid: int, both: tuple[np.ndarray, np.ndarray]) -> float:
        """Of two fields of a solid, by its number."""
        own, mine = self._system.places.own[solid], self._system.places.mine
        here = (own >= mine.start) & (own < mine.stop)  # of rigid ones every process has all
        return float(self._system.comm.allreduce(float(both[0][here] @ both[1][here])))

    def update(self) -> None:
        """Take up the velocities that the solids have now, by the operators as they are."""
        system = self._system
        for contact, part in zip(system.assembly.contacts, self.parts):
            velocities = contact.coupling.velocities("trial_velocity")
            part.set_places(velocities[part.active_places])
        for solid in system.solids:
            solid.drop_forces()
        system.assemble()

    def error(self) -> float:
        """The largest error of any row; of the momentum balances relative to their terms and those
        of what they meet, of a rigid body at rest to what stops it at the typical speed."""
        system = self._system
        rows = [largest(r) for r in system.rows]
        own = np.array([self._size(solid) for solid in system.solids])
        sizes = dict(zip(map(id, system.solids), np.max(system.comm.allgather(own), axis=0)))
        momentum = [0.0]
        for solid in system.solids:
            size = max(sizes[id(other)] for other in system.assembly.partners(solid))
            momentum.append(largest(solid.linear_residual()) / (size or 1.0))
        self.worst = worst([*system.comm.allgather(worst(momentum)), *rows])
        return self.worst if np.isfinite(self.worst) else np.inf

    def _size(self, solid: MonolithicSolid) -> float:
        """Of what acts on a solid, or did as the step began, N: all may be taken away in it."""
        size = max(solid.load_size(), self._system.assembly.borne(solid))
        return max(size, self._system.assembly.stopping_force(solid)) if solid.shiftable else size

    def soften(self, compliance: float) -> None:
        """Hold the multipliers, so that the jump rows see springs, so compliant, on top of them;
        0: let the multipliers be what these then bear."""
        system = self._system
        if not self._start:
            self._start = self.state()
        for part in self.parts:
            if system.held:
                _project_multipliers(part.equations)
            part.equations.freeze_bound(1 / compliance if compliance else 0.0)
        system.held = compliance > 0
        self.update()

    def begin_again(self) -> bool:
        """Go back to where the springs came, if there is a function that is least somewhere."""
        if self._start and not self.buckles:
            self.go_back(self._start)
        return not self.buckles

    def stall(self) -> str:
        """What stalls."""
        return f"the contact problem stalls at a relative error of {self.worst:.3g}"

    def force(self) -> np.ndarray:
        """Forces on the solids at all points, flat, N."""
        return self._system.force


def _project_multipliers(e: SurfaceEquations) -> None:
    """Let the multipliers be what bears in the jump rows: S g_n and P_b(g_t)."""
    rho, values = e.augmentation.rho, e.values
    rho = np.repeat(rho, np.diff([e.jumps, e.tractions, e.size]) // rho.shape[1], axis=0)
    bears = rho / np.where(e.weight > 0, e.weight, 1.0)
    values[e.jumps :] += bears.ravel() * e.residual()[e.jumps :]
    e.values = values
