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

    def settle(self, step: Step, force: np.ndarray, tolerance: float) -> bool:
        """Move the solids under the forces of the solution, unless linearised ones that are the
        same have; whether they moved. Of points that hardly press both may differ by all they are
        where speeds are resolved, and no solid would balance them."""
        if not largest(force - self._carried) > tolerance * largest(force):
            return False
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
            errors.append(self.surfaces.error(slow=0.0))
            errors.append(change := SETTLED * self._changed(force))
            self._errors.append(("the change of the contact forces", change))
            self.surfaces.remember()
        return worst(errors), force

    def renew(self, step: Step) -> None:
        """Take up the derivatives of the geometry, which have been seen since `begin`."""
        self._take_up()
        if self.surfaces.size:
            self.surfaces.error(slow=0.0)

    def _take_up(self) -> None:
        """Solids and geometry as they are linearised now."""
        active = self.surfaces.arrange()
        compliance = self._all.compliance(active)
        self.surfaces.begin(self._apart(active, compliance), compliance)

    def _apart(self, active: np.ndarray, compliance: np.ndarray) -> np.ndarray:
        """Velocities of the active points without contact: of linear solids those that they have
        less what contact does to these. That of a belt without its drum is so much larger that in
        what is left of it round-off would be seen."""
        solids, carried = self._all.solids, self._carried
        known = len(self._moved) == len(solids) and all(
            solid.linear and solid.trial_velocity is moved
            for solid, moved in zip(solids, self._moved)
        )
        if not known or np.count_nonzero(carried) > np.count_nonzero(carried[active]):
            return self._free[active]
        return np.asarray(self._all.moved()[active] - compliance @ carried[active])

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
        share, carried, force = surfaces.share, self._carried, surfaces.linear_force()
        before = [solid.trial_velocity.copy() for solid in self._all.solids if share < 1]
        self.carry(step, force)
        for solid, old in zip(self._all.solids, before):
            solid.go(old + share * (solid.trial_velocity - old), step)
        self._carried = carried + share * (force - carried)
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
