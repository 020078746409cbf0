# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a run leaves: a table with one row a step and impact, its end, and the time it spent."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..base.vectors import largest
from .stops import advice

#: Columns of every history; each contact adds those of :func:`contact_columns`.
COLUMNS = (
    "time",
    "dt",
    "kinetic",
    "strain",
    "potential",
    "impact",
    "friction",
    "drive",
    "damping",
    "scheme",
    "balance",
    "certificate",
    "newton",
    "geometry",
)


def contact_columns(name: str, dim: int) -> list[str]:
    """Columns that a contact adds: force on the solid, statuses, deepest penetration."""
    forces = [f"{name}.force_{axis}" for axis in "xyz"[:dim]]
    return [*forces, *(f"{name}.{what}" for what in ("bearing", "slipping", "penetration"))]


@dataclass
class History:
    """The course of a run. Each column is an attribute-like item: ``history["kinetic"]``.

    The first row is the initial state. Energies and works in J (J/m in 2D):

    * ``kinetic`` (none without inertia), ``strain``, ``potential``: of the state at ``time`` [s];
    * ``impact``, ``friction``: work of the normal and tangential contact forces on the jumps since
      the start (negative: a loss). In a step in which slip turns round one of them may gain a
      little on behalf of the other; their sum does not;
    * ``drive``: work since the start of what is applied (force, torque, tractions, body force) on
      the way really gone, of prescribed motions, and of obstacles that move;
    * ``damping``: work of the damping of solids on their mean velocities since the start, a loss;
    * ``scheme``: energy that the time scheme has made (positive) or damped since the start; with
      forces of the ends of steps, as in statics, ``drive`` is a sum of rectangles, and the work
      along a closed way ``drive`` + ``scheme``;
    * ``balance``: what is left of the sum, as a check of the whole: round-off, or a remark tells;
    * ``certificate``: the largest relative error of the accepted state, see
      :mod:`fenicsx_contact.steps.certificate`;
    * ``dt``, ``newton``, ``geometry``: length of the step, iterations, linearisations;
    * ``<contact>.force_x`` ...: mean force in the step on the solid, N; in an impact (a row with
      ``dt`` = 0) its percussion, N s;
      ``bearing``, ``slipping``: points by status; ``penetration`` of the deepest point, m, between
      two solids of those at which they are compared, whether their gaps, means over facets, say
      so or not;
    * last the probes of the run.

    Attributes:
        reason: why the run ended; ``"finished"`` if it reached the end. Others end with the name
            by which the page *When it stops* explains them.
        times: seconds spent by phase.
        remarks: (time, text) of what a reader of the run should know (shortened steps,
            ping-pong).
    """

    columns: tuple[str, ...]
    reason: str = "not run"
    times: dict[str, float] = field(default_factory=dict)
    remarks: list[tuple[float, str]] = field(default_factory=list)
    _rows: np.ndarray = field(default_factory=lambda: np.empty((0, 0)))
    _count: int = 0

    def __post_init__(self) -> None:
        self._rows = np.empty((1024, len(self.columns)))

    def append(self, row: Sequence[float]) -> None:
        """Add a row."""
        if self._count == len(self._rows):
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
        self._rows[self._count] = row
        self._count += 1

    def rows(self, start: int = 0) -> np.ndarray:
        """Rows from ``start`` on, (rows, columns)."""
        return self._rows[start : self._count]

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, column: str) -> np.ndarray:
        if column not in self.columns:
            raise KeyError(f"{column!r}: the columns are {', '.join(self.columns)}")
        return self._rows[: self._count, self.columns.index(column)]

    @property
    def finished(self) -> bool:
        """Whether the run reached its end."""
        return self.reason == "finished"

    @property
    def advice(self) -> str:
        """Cause and remedy of what the reason says, a line each; nothing if it finished."""
        return advice(self.reason)

    @property
    def time(self) -> np.ndarray:
        """Times of the rows, s."""
        return self["time"]

    def _of(self, column: str) -> np.ndarray:
        """A column, of no rows if the history is one without it."""
        return self[column] if column in self.columns else np.empty(0)

    @property
    def steps(self) -> int:
        """The number of steps; the start and impacts, which have no length, are none."""
        return int(np.count_nonzero(self._of("dt")))

    @property
    def run_time(self) -> float:
        """Seconds spent in the time loop, set-up and output left out."""
        return sum(t for phase, t in self.times.items() if phase not in ("set-up", "output"))

    @property
    def span(self) -> np.ndarray:
        """What turns the forces of the rows into impulses, s: their dt, and 1 in impacts, whose
        forces are percussions."""
        return np.where(self["dt"] > 0, self["dt"], 1.0)

    def impulse(self, contact: str) -> np.ndarray:
        """Impulse of a contact on its solid since the start, (rows, d) in N s.

        Raises:
            KeyError: no such contact; the message lists those that there are.
        """
        names = [f"{contact}.force_{axis}" for axis in "xyz"]
        forces = [name for name in names if name in self.columns]
        if not forces:
            ends = ".force_x"
            there = [name[: -len(ends)] for name in self.columns if name.endswith(ends)]
            raise KeyError(f"{contact!r}: the contacts are {', '.join(there) or 'none'}")
        rates = np.stack([self[c] for c in forces], axis=1)
        return np.cumsum(rates * self.span[:, None], axis=0)

    def table(self) -> dict[str, np.ndarray]:
        """All columns by name; ``pandas.DataFrame(history.table())`` is a data frame."""
        return {column: self[column] for column in self.columns}

    def save_csv(self, path: str | Path) -> Path:
        """Write all columns as comma-separated values, to all digits, with a line of names.

        Args:
            path: of the file; its directory is made.

        Raises:
            OSError: it cannot be written.
        """
        path = Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        names = io.StringIO()
        csv.writer(names, lineterminator="").writerow(self.columns)  # commas in names are quoted
        np.savetxt(path, self.rows(), "%.17g", ",", header=names.getvalue(), comments="")
        return path

    def summary(self) -> dict[str, Any]:
        """A few numbers about the run."""
        return {
            "reason": self.reason,
            "steps": self.steps,
            "newton": float(self._of("newton").sum()),
            "geometry": float(self._of("geometry").sum()),
            "run_time_s": self.run_time,
            "times_s": dict(self.times),
            "balance": largest(self._of("balance")),
        }

    def __repr__(self) -> str:
        end = self.time[-1] if len(self) else 0.0
        return f"History({self.steps} steps to {end:.6g} s, {self.reason})"
