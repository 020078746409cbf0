# SPDX-License-Identifier: LGPL-3.0-or-later
"""One linear system of the full Newton method, solids and multipliers together, sparse.

    [ A + T' C_yy T   T' C_ym ] [dv]     [ r + T' f ]
    [ C_my T          C_mm    ] [dm] = - [ F_m      ]

with r the solids' momentum balances, T their traces, and f, F, C the contacts' forces, rows and
tangents. Rows are distributed as the solids are.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from mpi4py import MPI

from ..base.processes import any_of
from ..base.vectors import largest
from ..solids import DeformableSolid, MonolithicSolid
from ..theory.scheme import Step
from .frozen import FrozenContact
from .grip import Grip
from .numbering import Numbering, numbered_traces
from .problem import Assembly
from .solid_rows import SolidRows
from .statics import FREE
from .yielding import COMPLIANCE, FIRM, Yielding


class Monolithic(ABC):
    """Linear systems in the velocities of all solids and the multipliers.

    Attributes:
        near, patient: as of :class:`~fenicsx_contact.solve.condensed.Condensed`.
        frozen: whether solids and geometry stay as they were linearised.
        held: whether the multipliers stay.
        rigid: whether no solid deforms.
        rows: scaled residuals of the multipliers, contact by contact.
        added: scaled multipliers, far larger than what they stand for, that were added to tell
            statuses and that the next solution takes away again; None: none.
    """

    near = np.inf
    patient = False

    def __init__(self, assembly: Assembly) -> None:
        self.assembly = assembly
        self.solids = [s for s in assembly.solids if isinstance(s, MonolithicSolid)]
        # of rigid bodies every process has all
        flexible = [s for s in assembly.solids if isinstance(s, DeformableSolid)]
        self.rigid = not flexible
        self.comm = flexible[0].mesh.mesh.comm if flexible else MPI.COMM_SELF
        self.parts = [contact.part for contact in assembly.contacts]
        self.places = Numbering(self.solids, self.comm)
        self._traces = [numbered_traces(c, self.solids) for c in assembly.contacts]
        self._solid_rows = SolidRows(self.solids, self.places, self.comm)
        self._weakly = np.zeros(len(self.solids), dtype=bool)  # held by weak springs
        self._grip: Grip | None = None
        self.hyperstatic, self.crowded = assembly.hyperstatic, assembly.crowded
        self._yielding = Yielding()
        self.added: np.ndarray | None = None
        self.restart()

    def restart(self) -> None:
        """A step begins: nothing is softened, nothing frozen."""
        self._softness, self.held = COMPLIANCE if self.hyperstatic else FIRM, False
        self._yielding.restart()
        self.frozen = False

    def free(self) -> np.ndarray:
        """Velocities of all points without contact, flat, of rigid solids."""
        return self.assembly.free()

    def begin(self, step: Step) -> tuple[float, np.ndarray]:
        """Residual of the present state: its largest relative error, and the forces on all points
        (flat, N)."""
        self.assemble()
        errors = [0.0, *(largest(rows) for rows in self.rows)]
        errors += self.assembly.imbalances(step, self.solids)
        self._errors = errors
        return float(np.max(errors)), self.force

    def assemble(self) -> None:
        """Rows of the multipliers, and the forces of the contacts, which are spread."""
        everything = self.assembly.parts[-1].stop if self.assembly.parts else 0
        self.force = np.zeros(everything)
        self.rows = []
        for part, places in zip(self.parts, self.assembly.parts):
            residual, active = part.active_residual(), part.active_places
            self.force[places.start + active] = -residual[: len(active)]
            self.rows.append(residual[len(active) :] * part.scales()[1][len(active) :])
        if self.held:
            self.rows = [np.zeros(len(rows)) for rows in self.rows]
        self.assembly.spread(self.force)

    def settle(self, step: Step, force: np.ndarray, tolerance: float = 0.0) -> bool:
        """Its rows balance the solids under these forces."""
        return False

    def iterate(self, step: Step) -> bool:
        """Solve, and move the solids; False if the system is singular."""
        if self.hyperstatic and not self.held:
            statuses = np.concatenate([part.statuses() for part in self.parts])
            self._yielding.next(max(largest(rows) for rows in self.rows), statuses)
            self._softness = self._yielding.compliance
        changes, multipliers = self._change()
        finite = all(np.isfinite(each).all() for each in (*changes, multipliers))
        if any_of(self.comm, not finite)[0]:
            return False
        for solid, change in zip(self.solids, changes):
            solid.go(solid.trial_velocity - change, step)
        last = 0
        for part in self.parts:
            n, m = len(part.active_places), part.multipliers
            scaled = multipliers[last : last + m] * part.scales()[0][n:]
            part.move(np.concatenate([np.zeros(n), -scaled]))
            last += m
        return True

    @abstractmethod
    def _change(self) -> tuple[list[np.ndarray], np.ndarray]:
        """The solution: of each solid's velocities those that this process holds, and, scaled, all
        multipliers; NaN where there is none."""

    def hold(self, floating: Sequence[MonolithicSolid], loose: Sequence[MonolithicSolid]) -> None:
        """Let weak springs hold solids that only contact holds, in the matrix, not in the residual:
        so it is regular while nothing else holds them; those that are ``loose``, springs of their
        own may."""
        self._grip = Grip(self.solids, self.assembly.contacts, loose)
        self._weakly = np.array([any(s is each for each in floating) for s in self.solids])

    def _weak_spring(self, diagonal: np.ndarray) -> float:
        """The stiffness of these springs, of this process's part of the solids' diagonal. What
        supports hold says where it is: its rows are of another unit."""
        own = [0.0]
        for solid, places in zip(self.solids, self.places.own):
            if isinstance(solid, DeformableSolid):
                here = diagonal[places - self.places.mine.start]
                own.append(largest(np.delete(here, solid.fixed_unknowns)))
        return FREE * float(self.comm.allreduce(max(own), op=MPI.MAX))

    def freeze(self, step: Step, first: bool) -> FrozenContact:
        """The contact problem with solids and geometry linearised as they are. Where what bore does
        not hold what only contact holds, a step begins, ``first``, as its grip takes it; where what
        slides turns round, as if what bore were glued."""
        frozen = FrozenContact(self, step)
        if not (first and self._grip):
            return frozen
        # round-off may differ between processes, what they begin with may not
        points = self.comm.bcast(self._grip.taken(step))
        if points is None and frozen.turns_round():
            points = [1 * bears for bears in self._grip.bearing()]
            self._yielding.restart()
        if points:
            frozen.glue(points)
        return frozen

    def carry(self, step: Step, force: np.ndarray) -> None:
        """The solids have moved with the contact, under these forces."""
        self.force = force

    @property
    def size(self) -> int:
        """Number of unknowns and multipliers."""
        return self.places.size + sum(part.multipliers for part in self.parts)

    def stall(self) -> str:
        """What stalls."""
        names = [f"the system of contact {c.name!r}" for c in self.assembly.contacts]
        names += [f"the momentum balance of {s.name!r}" for s in self.solids]
        worst = int(np.argmax(self._errors[1:]))
        return f"{names[worst]} stalls at a relative error of {self._errors[1 + worst]:.3g}"
