# SPDX-License-Identifier: LGPL-3.0-or-later
"""One linear system of the full Newton method, solids and multipliers together, sparse.

    [ A + T' C_yy T   T' C_ym ] [dv]     [ r + T' f ]
    [ C_my T          C_mm    ] [dm] = - [ F_m      ]

with r the solids' momentum balances, T their traces, and f, F, C the contacts' forces, rows and
tangents. Rows are distributed as the solids are; the multipliers, which every process knows, belong
to the last one.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI

from ..solids import MonolithicSolid
from ..theory.theta import Step
from .flips import flips
from .numbering import Numbering, numbered_traces
from .problem import Assembly
from .solid_rows import SolidRows
from .yielding import COMPLIANCE, Yielding

#: Springs that hold what nothing holds yet, in shares of the stiffest entry of the matrices.
WEAK = 1e-10


class Monolithic(ABC):
    """Linear systems in the velocities of all solids and the multipliers.

    Attributes:
        near, patient: as of :class:`~fenicsx_contact.solve.condensed.Condensed`.
    """

    near = np.inf
    patient = False

    def __init__(self, assembly: Assembly) -> None:
        self._all = assembly
        self.comm = assembly.solids[0].mesh.mesh.comm
        self._solids = [s for s in assembly.solids if isinstance(s, MonolithicSolid)]
        self._parts = [contact.part for contact in assembly.contacts]
        self._places = Numbering(self._solids, self.comm)
        self._traces = [numbered_traces(c, self._solids) for c in assembly.contacts]
        self._kept: dict[tuple[int, str], tuple] = {}
        self._solid_rows = SolidRows(self._solids, self._places, self.comm)
        self._floating = np.zeros(self._places.size)
        self._falling = False
        self._hyperstatic = any(solid.shiftable for solid in self._solids)
        self._yielding = Yielding()
        self.restart()

    def restart(self) -> None:
        """A step begins: nothing is softened, nothing frozen."""
        self._softness, self._centre = COMPLIANCE, np.empty(0)
        self._yielding.restart()
        self._frozen = False

    def begin(self, step: Step) -> tuple[float, np.ndarray]:
        """Residual of the present state: its largest relative error, and the forces on all points
        (flat, N)."""
        self.assemble()
        errors = [0.0, *(float(np.abs(rows).max(initial=0.0)) for rows in self._rows)]
        errors += self._all.imbalances(step, self._solids)
        self._errors = errors
        return float(np.max(errors)), self.force

    def assemble(self, falling: bool = False) -> None:
        """Rows of the multipliers, and the forces of the contacts, which are spread; none if the
        solids fall."""
        everything = self._all.parts[-1].stop if self._all.parts else 0
        self.force = np.zeros(everything)
        self._rows = []
        for part, places in zip(self._parts, self._all.parts):
            residual, active = part.active_residual(), part.active_places
            self.force[places.start + active] = -residual[: len(active)]
            self._rows.append(residual[len(active) :] * part.scales()[1][len(active) :])
        if self._centre.size:
            strained = self._softness * (self.multipliers() - self._centre)
            cuts = np.cumsum([len(rows) for rows in self._rows])[:-1]
            self._rows = [r - s for r, s in zip(self._rows, np.split(strained, cuts))]
        if falling:
            self.force[:] = 0.0
            self._rows = [np.zeros(len(rows)) for rows in self._rows]
        self._all.spread(self.force)

    def multipliers(self) -> np.ndarray:
        """The active multipliers of all contacts, scaled."""
        scaled = [np.empty(0)]
        for part in self._parts:
            n = len(part.active_places)
            scaled.append(part.active_values()[n:] / part.scales()[0][n:])
        return np.concatenate(scaled)

    def iterate(self, step: Step) -> bool:
        """Solve, and move the solids; False if the system is singular."""
        if self._hyperstatic and not self._centre.size:
            self._yielding.next(max(float(np.abs(rows).max(initial=0.0)) for rows in self._rows))
            self._softness = self._yielding.compliance
        change = self._solve()
        if not np.isfinite(change).all():
            return False
        for solid, own in zip(self._solids, self._places.own):
            solid.go(solid.trial_velocity - change[own], step)
        last = self._places.size
        for part in self._parts:
            n, m = len(part.active_places), part.multipliers
            multipliers = change[last : last + m] * part.scales()[0][n:]
            part.move(np.concatenate([np.zeros(n), -multipliers]))
            last += m
        return True

    @abstractmethod
    def _solve(self) -> np.ndarray:
        """The whole solution, scaled, on every process; NaN where there is none."""

    def hold(self, floating: Sequence[MonolithicSolid]) -> None:
        """Let weak springs hold these solids, in the matrix, not in the residual: so it is regular
        while nothing else holds them."""
        for solid, own in zip(self._solids, self._places.own):
            if any(solid is each for each in floating):
                self._floating[own] = 1.0
        if self.comm.size > 1:
            self._floating = self.comm.allreduce(self._floating)

    def freeze(self, step: Step) -> FrozenContact:
        """The contact problem with solids and geometry linearised as they are."""
        return FrozenContact(self, step)

    @property
    def _size(self) -> int:
        """Number of unknowns and multipliers."""
        return self._places.size + sum(part.multipliers for part in self._parts)

    def _residual(self) -> np.ndarray:
        """Scaled residual of all rows; of those of the solids only this process's."""
        values = np.zeros(self._size)
        for solid, own in zip(self._solids, self._places.own):
            values[own] = solid.linear_residual() if self._frozen else solid.residual()
        values[self._places.size :] = np.concatenate([*self._rows, np.empty(0)])
        return values

    def _contact_block(self, frozen: bool = False) -> sp.csr_matrix:
        """What the contacts add to the matrix, scaled, (size, size), on every process; if
        ``frozen`` without the derivatives of the geometry."""
        block, last = sp.csr_matrix((self._size, self._size)), self._places.size
        if self._falling:
            return block
        for contact, part in enumerate(self._parts):
            n, (columns, rows) = len(part.active_places), part.scales()
            columns[:n] = rows[:n] = 1.0
            tangent = part.sparse_tangent(frozen)
            tangent.data *= np.repeat(rows, np.diff(tangent.indptr)) * columns[tangent.indices]
            push, see = (self._onto(contact, which, last) for which in ("spreading", "seeing"))
            block = block + push.T @ (tangent @ see)
            last += part.multipliers
        return block

    def _onto(self, contact: int, which: str, last: int) -> sp.csr_matrix:
        """From the unknowns of the system to the active ones of a contact, its multipliers, whose
        numbers begin with ``last``, behind; by the operators of the traces of that name. Kept
        while nothing changes."""
        part, traces = self._parts[contact], self._traces[contact]
        operators = [getattr(trace, which)() for _, trace in traces]
        active, m = part.active_places, part.multipliers
        key = (*map(id, operators), active.tobytes(), last, m, self._size)
        if key != self._kept.get((contact, which), ((), None, None))[0]:
            numbered = [self._places.renumber(each, k) for each, (k, _) in zip(operators, traces)]
            velocities = sp.vstack(numbered, "csr")[active]
            own = sp.csr_matrix((np.ones(m), (np.arange(m), last + np.arange(m))), (m, self._size))
            velocities.resize(len(active), self._size)
            self._kept[contact, which] = key, sp.vstack([velocities, own], "csr"), operators
        return self._kept[contact, which][1]

    def _compliance(self) -> sp.csr_matrix:
        """The compliance that makes the multipliers unique, where they are not."""
        n, m = self._places.size, self._size - self._places.size
        diagonal = np.repeat([0.0, -1.0 if self._falling else -self._softness], [n, m])
        if self._floating.any():
            stiff = np.abs(self._solid_rows.diagonal()).max()
            diagonal[:n] = WEAK * stiff * self._floating
        return sp.diags(diagonal, format="csr")

    @property
    def _rows_here(self) -> slice:
        """This process's rows of the system."""
        mine, final = self._places.mine, self.comm.rank == self.comm.size - 1
        return slice(mine.start, self._size if final else mine.stop)

    def _matrix(self, extra: sp.csr_matrix) -> sp.csr_matrix:
        """This process's rows of the solids' matrices and of what else there is, which is the same
        on every process and, for the multipliers, may be larger."""
        size, start = extra.shape[0], self._places.mine.start
        rows = slice(start, min(self._rows_here.stop, size))
        return extra[rows] + self._solid_rows(rows.stop - start, size)

    def stall(self) -> str:
        """What stalls."""
        names = [f"the system of contact {c.name!r}" for c in self._all.contacts]
        names += [f"the momentum balance of {s.name!r}" for s in self._solids]
        worst = int(np.argmax(self._errors[1:]))
        return f"{names[worst]} stalls at a relative error of {self._errors[1 + worst]:.3g}"


class FrozenContact:
    """The contact problem with solids and geometry linearised: what the inner loop of Newton's
    method solves; see :class:`~fenicsx_contact.solve.newton.ContactProblem`.

    Args:
        system: begun.
        step: that it is for.
    """

    def __init__(self, system: Monolithic, step: Step) -> None:
        self._system, self._step = system, step
        self.names = [contact.name for contact in system._all.contacts]
        self.parts = system._parts
        self.history: list[np.ndarray] = []
        self.worst = np.inf
        self.size = system._size
        self._see()

    def fall(self) -> None:
        """Move the solids as if nothing touched them: which way what is to be held would go says
        where contacts bear, and whether they hold it along the surface."""
        system = self._system
        for part in self.parts:
            n = len(part.active_places)
            part.move(np.concatenate([np.zeros(n), -part.active_values()[n:]]))
        for solid in system._solids:
            solid.drop_forces()
        system.assemble(falling=True)
        system._falling = True
        self.iterate()
        system._falling = False

    def iterate(self, enough: float = 0.0) -> bool:
        """One Newton step; False where the tangent is singular."""
        system = self._system
        system._frozen = True
        done = system.iterate(self._step)
        system._frozen = False
        if done:
            self._see()
        return done

    def _see(self) -> None:
        """Take up the velocities that the solids have now, by the operators as they are."""
        system = self._system
        for contact, part in zip(system._all.contacts, self.parts):
            velocities = contact.coupling.velocities("trial_velocity")
            part.set_places(velocities[part.active_places])
        for solid in system._solids:
            solid.drop_forces()
        system.assemble()

    def error(self) -> float:
        """The largest error of any row; of the momentum balances relative to their terms."""
        system = self._system
        rows = [float(np.abs(r).max(initial=0.0)) for r in system._rows]
        momentum = [0.0]
        for solid in system._solids:
            left, size = solid.linear_residual(), solid.load_size()
            momentum.append(float(np.abs(left).max(initial=0.0)) / (size or 1.0))
        errors = system.comm.allreduce(max(momentum), op=MPI.MAX)
        self.worst = max([errors, *rows])
        return self.worst if np.isfinite(self.worst) else np.inf

    def soften(self, compliance: float) -> None:
        """Put springs in series with the contact; see :class:`SurfaceSystem`."""
        system = self._system
        system._softness = compliance or COMPLIANCE
        system._centre = system.multipliers() if compliance else np.empty(0)
        for part in self.parts:
            part.equations.freeze_bound(compliance > 0)
        self._see()

    def remember(self) -> np.ndarray:
        """Statuses of all points of all contacts, kept to tell which ones flip."""
        self.history.append(np.concatenate([p.statuses() for p in self.parts]))
        return self.history[-1]

    def flips(self) -> str:
        """Which points changed their status among the last iterations."""
        return flips(self.history, self.parts, self.names)

    def stall(self) -> str:
        """What stalls."""
        return f"the contact problem stalls at a relative error of {self.worst:.3g}"

    def force(self) -> np.ndarray:
        """Forces on the solids at all points, flat, N."""
        return self._system.force
