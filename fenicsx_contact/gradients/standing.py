# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where everything stands in the state of a linearised run, and among the unknowns of a step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base import checks
from ..contact.contact import Contact
from .motion import Motion
from .rigid import RigidMotion
from .surface import ContactRows


class Standing:
    """Where everything stands, by the ids of motions and of contacts.

    Args:
        motions, contacts: the rows of solids and contacts.

    Attributes:
        q, v: of the solids; ``s``: by what rigid ones were put back.
        r: what contacts remember; ``time``: the time; ``size``: of the state.
        before, moving: q and v at the end of the step before rigid solids were put back.
        m, f, y: multipliers and forces of contacts, point by point, and places of nodes, by which
            forces of two solids on each other change.
        unknowns: number of those of the step.
    """

    def __init__(self, motions: Sequence[Motion], contacts: Sequence[ContactRows]) -> None:
        self._motions, self._contacts = motions, contacts
        self.q: dict[int, slice] = {}
        self.v: dict[int, slice] = {}
        self.s: dict[int, slice] = {}
        self.r: dict[int, slice] = {}
        self._end = 0
        for m in motions:
            self.q[id(m)], self.v[id(m)] = self._next(m.size), self._next(m.size)
            if isinstance(m, RigidMotion):
                self.s[id(m)] = self._next(m.size)
        for rows in contacts:
            self.r[id(rows.contact)] = self._next(rows.remembered)
        self.time = self._next(1)
        self.size = self._end

    def _next(self, size: int) -> slice:
        first, self._end = self._end, self._end + size
        return slice(first, self._end)

    def see(self) -> int:
        """The motions and contacts have taken up a step: its unknowns, of which it has so many."""
        self._end = self.size
        self.before, self.moving = dict(self.q), dict(self.v)
        self.m: dict[int, slice] = {}
        self.f: dict[int, slice] = {}
        self.y: dict[int, slice] = {}
        for m in self._motions:
            if isinstance(m, RigidMotion):  # before what bears is put back to its gaps
                self.before[id(m)], self.moving[id(m)] = self._next(m.size), self._next(m.size)
        for rows in self._contacts:
            key, points = id(rows.contact), len(rows.points)
            self.m[key] = self._next(rows.unknowns)
            self.f[key] = self._next(points * rows.contact.surface.dim)
            nodes = sum(seen.shape[0] for _, seen in rows.read()) if points else 0
            self.y[key] = self._next(nodes)
        self.unknowns = self._end
        return self.unknowns

    def part(self, which: str, solid: Any) -> slice:
        """Where a solid's ``"q"`` or ``"v"`` stands in the state."""
        at = self.q if which == "q" else self.v
        return next(at[id(m)] for m in self._motions if m.solid is solid)

    def bearing(self, contact: Contact) -> tuple[np.ndarray, slice, slice]:
        """The candidates of a contact in the step, (k,), and where their lam (k,) and forces (k d,)
        stand among its unknowns."""
        rows = next(rows for rows in self._contacts if rows.contact is contact)
        multipliers = self.m[id(contact)]
        each = rows.unknowns // max(1, len(rows.points))
        lam = slice(multipliers.start, multipliers.stop, each or 1)
        return rows.points, lam, self.f[id(contact)]

    def memory(self, contact: Contact, name: str) -> slice:
        """Where a field that a contact remembers stands in the state, point by point.

        Raises:
            InputError: it is none that changes with the motion.
        """
        rows = next((rows for rows in self._contacts if rows.contact is contact), None)
        names = rows.reads.names if rows else []
        if name not in names:
            raise checks.InputError(
                f"Remembered: {name!r} of contact {contact.name!r} does not change with the motion"
            )
        at = self.r[id(contact)]
        return slice(at.start + names.index(name), at.stop, len(names))

    def multipliers(self, rows: ContactRows) -> slice:
        """Where those of a contact stand among the unknowns of the step, point by point."""
        return self.m[id(rows.contact)]

    def read(self, rows: ContactRows) -> tuple[dict[str, slice], dict[str, slice]]:
        """Where what the rows of a contact read stands among the unknowns, and in the state."""
        ends = {"m": self.multipliers(rows)}
        starts = {"r_old": self.r[id(rows.contact)]}
        for i, m in enumerate(rows.motions):
            key = id(m)
            ends |= {rows.key("v", i): self.moving[key], rows.key("q", i): self.before[key]}
            starts |= {rows.key("v_old", i): self.v[key], rows.key("q_old", i): self.q[key]}
        return ends, starts

    def changes(self, rows: ContactRows, x: np.ndarray, start: np.ndarray) -> dict[str, np.ndarray]:
        """Changes of what the rows of a contact read, but its multipliers."""
        ends, starts = self.read(rows)
        del ends["m"]
        found = {name: x[at] for name, at in ends.items()}
        return found | {name: start[at] for name, at in starts.items()}
