# SPDX-License-Identifier: LGPL-3.0-or-later
"""One linear system of the full Newton method, condensed on the surfaces.

The solids enter by the compliance of their active points; for linear solids it is known.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.checks import InputError
from ..base.vectors import largest, worst
from ..solids import Solid
from ..theory.scheme import Step
from .problem import Assembly
from .surface_problem import SurfaceSystem

#: Changes of forces count this much of errors: what a correction leaves is of second order.
SETTLED = 1e-7


class Condensed:
    """Linear systems in the velocities of the active points and the multipliers.

    Attributes:
        near: the error up to which derivatives of the geometry are used.
        surfaces: the surface problem.
        patient: whether old tangents of the solids may serve: a new one costs a new compliance.
    """

    near = np.inf
    patient = True

    def __init__(self, assembly: Assembly) -> None:
        self._all = assembly
        self.surfaces = assembly.surface_system()
        self._force: np.ndarray | float = 0.0  # of the last state
        self._carried: Any = 0.0  # under which the solids moved last
        self._moved: list[np.ndarray] = []  # as fast
        self._near = False  # and are taken about there
        self._able: list[Any] = [s for s in assembly.solids if hasattr(s, "respond")]
        self._others = [s for s in assembly.solids if not hasattr(s, "respond")]

    def restart(self) -> None:
        """A step begins: what is kept between iterations is that of the state."""
        self.surfaces.forget()
        self._force, self._carried, self._moved = 0.0, 0.0, []

    def free(self) -> np.ndarray:
        """Velocities of all points without contact, flat, as the solids are linearised now."""
        self._free = self._all.free()
        return self._free

    def freeze(self, step: Step, first: bool) -> SurfaceSystem:
        """The contact problem with solids and geometry linearised as they are, after `free`."""
        self.surfaces.restart()
        self._take_up()
        return self.surfaces

    def carry(self, step: Step, force: np.ndarray) -> None:
        """Move the solids under the forces on all points, flat in N."""
        self._carried = force
        self._all.spread(force)
        for solid in self._all.solids:
            solid.correct(step)
        self._moved = [solid.trial_velocity for solid in self._all.solids]

    def _go_on(self, step: Step, change: np.ndarray) -> None:
        """Move linear solids on by what changes the forces carried, to all digits of this."""
        self._all.spread(change)
        for solid in self._able:
            solid.respond(step)
        self._carried = self._carried + change
        self._all.spread(self._carried)
        for other in self._others:
            other.correct(step)
        self._moved = [solid.trial_velocity for solid in self._all.solids]

    def settle(self, step: Step, force: np.ndarray, tolerance: float = 0.0) -> bool:
        """Move the solids under the forces of the solution, unless linearised ones that are the
        same have; whether they moved. Of points that hardly press both may differ by all they are
        where speeds are resolved, and no solid would balance them."""
        change = force - self._carried
        if not largest(change) > tolerance * largest(force):
            return False
        if self._near:
            self._go_on(step, change)
        else:
            self.carry(step, force)
        return True

    def hold(self, floating: Sequence[Solid], loose: Sequence[Solid]) -> None:
        """Solids that only contact holds have no compliance: they cannot be condensed."""
        if names := [solid.name for solid in floating]:
            raise InputError(f"solver = 'condensed': only contact holds {names}; use 'monolithic'")

    def begin(self, step: Step) -> tuple[float, np.ndarray]:
        """Residual of the present state: its largest relative error, and the forces on all points
        (flat, N)."""
        self.free()
        self._take_up()
        force = self.surfaces.force()
        self._all.spread(force)
        asked = [solid for solid in self._all.solids if not solid.linear]
        errors = self._all.imbalances(step, asked)
        self._errors = [(f"the momentum balance of {s.name!r}", e) for s, e in zip(asked, errors)]
        if self.surfaces.size:
            errors.append(self.surfaces.error(0.0, self._balance(force)))
            errors.append(change := SETTLED * self._changed(force))
            self._errors.append(("the change of the contact forces", change))
            self.surfaces.remember()
        return worst(errors), force

    def renew(self, step: Step) -> None:
        """Take up the derivatives of the geometry, which have been seen since `begin`."""
        self._take_up()
        if self.surfaces.size:
            self.surfaces.error(0.0, self._balance(self.surfaces.force()))

    def _take_up(self) -> None:
        """Solids and geometry as they are linearised now. Linear solids are taken as they move now:
        without contact a belt would fly so far from its drum that round-off of that were seen."""
        active = self.surfaces.arrange()
        compliance, carried = self._all.compliance(active), self._carried
        self._near = self._knows() and not np.delete(carried, active).any()
        if not self._near:
            self.surfaces.begin(self._free[active], compliance)
            return
        moved, borne = self._all.moved()[active], carried[active]
        self.surfaces.begin(moved, compliance, borne)

    def _knows(self) -> bool:
        """Whether all solids are linear, and move as the forces carried let them."""
        solids = self._all.solids
        return len(self._moved) == len(solids) and all(
            solid.linear and solid.trial_velocity is moved
            for solid, moved in zip(solids, self._moved)
        )

    def _balance(self, force: np.ndarray) -> float:
        """Error of the momentum balances of linear solids, as far as it is known."""
        if not self._near:
            return np.inf
        size = max([largest(force), *(solid.load_size() for solid in self._able)])
        return largest(self.surfaces.unbalanced) / size if size > self._all.noise() else np.inf

    def _changed(self, force: np.ndarray) -> float:
        """By how much the last correction changed the forces, over the largest. Where a fine mesh
        of a stiff solid meets a soft one, small errors of gaps hide large ones of forces."""
        before, self._force = self._force, force
        size = largest(force)
        return 0.0 if size <= self._all.noise() else float(np.abs(force - before).max() / size)

    def iterate(self, step: Step) -> bool:
        """Solve, and move the solids; False if the system is singular."""
        surfaces = self.surfaces
        if surfaces.size and not surfaces.iterate(by_pieces=True):
            return False
        share, carried, change = surfaces.share, self._carried, surfaces.linear_change()
        before = [solid.trial_velocity.copy() for solid in self._all.solids if share < 1]
        if self._near:
            self._go_on(step, change)
        else:
            self.carry(step, change)
        for solid, old in zip(self._all.solids, before):
            solid.go(old + share * (solid.trial_velocity - old), step)
        if share < 1:
            self._carried = carried + share * (self._carried - carried)
        self._moved = [solid.trial_velocity for solid in self._all.solids]
        return True

    def stall(self) -> str:
        """What stalls or flips."""
        if not self.surfaces.size:
            return "the momentum balance stalls"
        rows, others = self.surfaces.worst, max(self._errors, key=lambda each: each[1])
        if others[1] > rows:
            stalls = f"{others[0]} stalls at a relative error of {others[1]:.3g}"
        else:
            stalls = self.surfaces.stall()
        return f"{stalls}; {self.surfaces.flips()}"
