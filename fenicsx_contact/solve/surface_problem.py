# SPDX-License-Identifier: LGPL-3.0-or-later
"""The surface problem of a step: the equations of all contacts and the compliance that joins them.

With F the assembled contact terms of (7), ``w_free`` the jump without contact and
``W = J A^-1 J'``, it reads::

    w - w_free + W F_w(w, lam, tau) = 0          F_lam = 0          F_tau = 0

over the candidates of the step. Between two solids the unknowns are the velocities of the nodes
on both sides that the candidates meet, and J stands in F. Unknowns and rows are scaled (speed,
pressure).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..base.vectors import largest, worst
from ..contact.part import Part
from .by_points import ByPoints, Place
from .crowds import CrowdTangent
from .factored import Factored, by_factors
from .statuses import Statuses
from .yielding import COMPLIANCE, FIRM, Yielding

#: Speeds below this share of those that the contact forces stand for are not resolved: where forces
#: balance each other, as in a squeezed body, jumps are far smaller, down to round-off.
SLOW = 1e-4
#: Cost: above so many unknowns those of the points are condensed first: before obstacles, where
#: factors of W are kept, and between solids, where J changes in each iteration; of many bodies
#: those are sparse.
MANY = 60, 250


class SurfaceSystem(Statuses):
    """The stacked equations of the contacts of a scene, restricted to the candidates.

    Args:
        parts, names: of the contacts.
        hyperstatic: whether W may be singular, or forces are not unique, see
            :attr:`~.problem.Assembly.hyperstatic`.
        crowded: whether these are many, that meet each other.

    Attributes:
        parts, names: of the contacts; ``placed``: those that have unknowns, and where these stand.
        W, free: compliance of the active points, and velocities without contact or as begun with.
        unbalanced: forces on them that are carried less those of the contacts, N.
        worst: the largest error of any row, after :meth:`error`.
        share: of the last step that was gone.
    """

    def __init__(
        self,
        parts: Sequence[Part],
        names: Sequence[str],
        hyperstatic: bool,
        crowded: bool = False,
    ) -> None:
        self._by_points, self._yielding = ByPoints(), Yielding()
        super().__init__(parts, names)
        self.hyperstatic, self.crowded = hyperstatic, crowded
        self._total = sum(p.places for p in self.parts)
        self._revision = -1
        self._sizes = np.empty(0), np.empty(0)
        self.W, self.free, self.carried = np.empty((0, 0)), np.empty(0), np.empty(0)
        self._many = False
        self._yields: Any = self.W
        self.worst, self.share, self._judged = 0.0, 1.0, np.empty(0)
        self._firm = COMPLIANCE if hyperstatic else FIRM
        self._compliance, self._centre = self._firm, np.empty(0)
        self._tangent: Factored | None = None
        self._crowd: CrowdTangent | None = None

    def arrange(self) -> np.ndarray:
        """Take up which points are active; their velocities' indices among all."""
        revision = sum(p.revision for p in self.parts)
        if revision != self._revision:
            self._revision = revision
            self._arrange()
        return self.active

    def begin(self, free: np.ndarray, compliance: np.ndarray, carried: Any = 0.0) -> None:
        """Take up the velocities (flat) of the active points without contact, or under forces that
        are carried (flat, N), and W, after `arrange`."""
        few = self.hyperstatic or self.size <= MANY[0]
        self._many = not few and self.size > MANY[any(p is not p.equations for p in self.parts)]
        self.W, self.free, self.carried = compliance, free, carried
        # of many bodies each yields alone
        self._yields = sp.csr_matrix(compliance) if self.crowded else compliance
        self.worst, self.share = 0.0, 1.0
        if self.size:
            self.update()

    def _arrange(self) -> None:
        """Places of the active unknowns: all velocities, then the multipliers by contact."""
        offset, active = 0, [np.empty(0, dtype=np.int64)]
        for part in self.parts:
            active.append(part.active_places + offset)
            offset += part.places
        self.active = np.concatenate(active)
        self.placed: list[Place] = []
        w, m = 0, len(self.active)
        for part in self.parts:
            count, extra = len(part.active_places), part.multipliers
            place = np.concatenate([np.arange(w, w + count), np.arange(m, m + extra)])
            if len(place):
                self.placed.append(Place(part, place))
            w, m = w + count, m + extra
        self.size = m
        if m:
            columns, rows = np.empty(m), np.empty(m)
            for part, place in self.placed:
                columns[place], rows[place] = part.scales()
            self._columns, self._rows = columns, rows
            self._scaling = np.empty(0)  # made where all unknowns are solved for together

    def _gather(self, arrays: Sequence[np.ndarray]) -> np.ndarray:
        if len(arrays) == 1:
            return arrays[0]
        result = np.empty(self.size)
        for (_, place), array in zip(self.placed, arrays):
            result[place] = array
        return result

    def update(self) -> None:
        """Assemble the residual from the unknowns that the parts hold."""
        nw = len(self.active)
        self.assembled = self._gather([part.active_residual() for part, _ in self.placed])
        self.unbalanced = self.assembled[:nw] + self.carried
        w = self._gather(self.state())[:nw]
        self.residual = self.assembled.copy()
        self.residual[:nw] = w - self.free + self._yields @ self.unbalanced
        self.residual *= self._rows
        if self._centre.size:
            self.residual[nw:] -= self._compliance * (self._multipliers() - self._centre)

    def _multipliers(self) -> np.ndarray:
        """The active multipliers, scaled."""
        nw = len(self.active)
        return self._gather(self.state())[nw:] / self._columns[nw:]

    def soften(self, compliance: float) -> None:
        """Put springs in series with the contact, so compliant (scaled), that are without strain at
        the present multipliers; 0: take them away. What gives way more than the points do is
        augmented less: points that slip together would turn round in every step."""
        self._centre = self._multipliers() if compliance else np.empty(0)
        self._compliance = compliance or self._firm
        for part in self.parts:
            part.equations.freeze_bound(min(1.0, 1 / compliance) if compliance else 0.0)
        self.update()

    def forget(self) -> None:
        super().forget()
        self._tangent = None
        self._by_points.forget()
        self.restart()

    def restart(self) -> None:
        """What follows begins with a plain step again."""
        self._yielding.restart()

    def begin_again(self) -> bool:
        """It would not help: with the solids condensed no function falls."""
        return False

    def iterate(self, enough: float = 0.0, by_pieces: bool = False) -> bool:
        """One Newton step; False where the tangent is singular. One of a hyperstatic contact is
        judged; the error is not to be below ``enough``. If ``by_pieces`` it may be cut short."""
        if not self.hyperstatic or self._centre.size:
            return self._iterate()
        done, self.share = self._yielding.step(self, enough, by_pieces)
        return done

    def yields(self, compliance: float) -> bool:
        """The same, not judged, with multipliers so compliant."""
        self._compliance = compliance
        return self._iterate()

    def state(self) -> list[np.ndarray]:
        """The active unknowns of the contacts."""
        return [part.active_values() for part, _ in self.placed]

    def go_back(self, state: list[np.ndarray], share: float = 1.0) -> None:
        """Return to what :meth:`state` was, or only a share of the way."""
        for (part, _), old in zip(self.placed, state):
            part.move(share * (old - part.active_values()))
        self.update()

    def _iterate(self) -> bool:
        points = self._many and not self._centre.size
        return self._iterate_points() if points else self._iterate_all()

    def _iterate_points(self) -> bool:
        """By the forces of the points alone."""
        scales = self._columns, self._rows
        found = self._by_points.step(self.W, self.placed, self.residual, scales)
        if found is None:
            return False
        step, change = found
        return self._go(step * self._columns, change)

    def _iterate_all(self) -> bool:
        """By all unknowns together; if two solids keep their tangent, so do the others."""
        tangent = self._tangent
        pairs = [part for part in self.parts if part is not part.equations]
        kept = bool(pairs) and all(part.keeps for part in pairs)
        if not (kept and tangent and tangent.of(self.active, self.size)):
            self._tangent = tangent = self._factored()
        if tangent is None:
            return False
        step = tangent.solve(self.residual, self._rows)
        return self._go(-step, tangent.stiffness @ step)

    def _go(self, step: np.ndarray, change: np.ndarray) -> bool:
        """A step of the unknowns, and how the forces of the contacts change along it; True."""
        self._linear_change = change - self.unbalanced
        for part, place in self.placed:
            part.move(step[place])
        self.update()
        return True

    def _factored(self) -> Factored | None:
        """The tangent of all unknowns; None where it is singular."""
        nw, scales = len(self.active), (self._rows, self._columns)
        if self.crowded and self.size > MANY[1]:
            if not (self._crowd and self._crowd.of(self.placed, self._yields)):
                self._crowd = CrowdTangent(self.placed, self._yields, scales)
            return self._crowd.factored(self.active, self._compliance, bool(self._centre.size))
        if len(self.placed) == 1:
            A = self.placed[0].part.active_tangent().copy()  # which is used again
        else:
            A = np.zeros((self.size, self.size))
            for part, place in self.placed:
                A[np.ix_(place, place)] = part.active_tangent()
        stiffness = A[:nw].copy()
        A[:nw] = self.W @ stiffness
        A.flat[: nw * self.size : self.size + 1] += 1.0
        if not self._scaling.size:
            self._scaling = self._rows[:, None] * self._columns
        A *= self._scaling
        regular = A.copy()
        # high pressures weigh in the rows of friction, and again in the forces of their unknowns
        weight = np.maximum(1.0, np.abs(A[nw:, :nw]).max(axis=1, initial=0.0))
        softer = self._compliance * (1.0 if self._centre.size else weight**2)
        regular.flat[nw * (self.size + 1) :: self.size + 1] -= softer
        if (inverse := by_factors(regular)) is None:
            return None
        return Factored(stiffness, None if self._centre.size else A, inverse, *scales, self.active)

    def error(self, slow: float = SLOW, balance: float = np.inf) -> float:
        """The largest error that the residual of any row stands for; speeds are resolved down to
        the share ``slow`` of those that the forces stand for, and their errors no larger than that
        of the momentum ``balance``."""
        if self._judged is self.residual and slow == SLOW:
            return self.worst
        nw, scaled = len(self.active), self.residual.copy()
        if slow:
            resolved = slow * (self._absolute() @ np.abs(self.assembled[:nw])) * self._rows[:nw]
            scaled[:nw] /= np.maximum(1.0, resolved)
        np.clip(scaled[:nw], -balance, balance, out=scaled[:nw])
        errors = [largest(part.equations.natural(scaled[place])) for part, place in self.placed]
        self.worst = most if np.isfinite(most := worst(errors)) else np.inf
        self._judged = self.residual if slow == SLOW else np.empty(0)
        return self.worst

    def _absolute(self) -> np.ndarray:
        """The absolute values of W, which changes rarely."""
        if self._sizes[0] is not self.W:
            self._sizes = self.W, np.abs(self.W)
        return self._sizes[1]

    def force(self) -> np.ndarray:
        """Forces on the solids at all points, flat, N."""
        return self._spread(-self.assembled[: len(self.active)] if self.size else np.empty(0))

    def linear_change(self) -> np.ndarray:
        """After :meth:`iterate`: how those that are carried change by the linearised equations."""
        return self._spread(self._linear_change if self.size else np.empty(0))

    def _spread(self, force: np.ndarray) -> np.ndarray:
        result = np.zeros(self._total)
        result[self.active] = force
        return result

    def stall(self) -> str:
        """Which row errs most."""
        if not np.isfinite(self.residual).all():
            return "the contact equations have no finite solution"
        rows = [np.abs(p.equations.natural(self.residual[place])) for p, place in self.placed]
        most = int(np.argmax([largest(each) for each in rows]))
        kind = self.placed[most].part.kind(int(rows[most].argmax()))
        return f"a {kind} row stalls at a scaled residual of {self.worst:.3g}"
