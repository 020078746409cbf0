# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stability maps: a problem over a grid of two axes, each cell judged in a process of its own.

Results are appended, one JSON line a cell, to a file; a later call does what is missing there.
"""

from __future__ import annotations

import hashlib
import inspect
import json
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from ..base import checks
from ..base.told import digits
from ..output.storage import writing
from .judge import CLASSES, Verdict, judge
from .names import named
from .problem import Problem
from .records import begin, listed, records
from .workers import each, how_many

#: How a line of a file of maps begins.
START = '{"key": "'


@dataclass(frozen=True)
class Axis:
    """An argument of a problem and the values that it takes.

    Args:
        name: of the argument.
        values: numbers or names.
        label: for the figure; with the unit.

    Raises:
        InputError: no name, no values, one of them twice, NaN.
    """

    name: str
    values: Sequence[Any]
    label: str

    def __post_init__(self) -> None:
        checks.label("name", self.name)
        allowed = "numbers or names, one at least"
        if not (values := checks.listed("values", self.values, allowed)):
            raise checks.InputError(f"values = [] of axis {self.name!r}: must be {allowed}")
        for i, value in enumerate(values):
            if value != value:  # noqa: PLR0124 - NaN
                at = f"values[{i}] = {value} of axis {self.name!r}"
                raise checks.InputError(f"{at}: must be a number or a name")
            if value in values[:i]:
                raise checks.InputError(f"values of axis {self.name!r}: {value!r} is there twice")

    def thinned(self, count: int) -> Axis:
        """At most ``count`` >= 1 of the values, the first and the last among them."""
        checks.whole_number("count", count, at_least=1)
        last = len(self.values) - 1
        picked = np.unique(np.linspace(0, last, min(count, last + 1)).round().astype(int))
        return Axis(self.name, [self.values[i] for i in picked], self.label)


@dataclass(frozen=True)
class Map:
    """A problem over a grid.

    Args:
        name: for files.
        title: for people.
        problem: a function at the top of a module (it is sent to other processes), or a
            ``partial`` of one; its docstring states reference, error and bound.
        x, y: the axes.

    Raises:
        InputError: no axes, or of one name; no function of arguments called like them.
    """

    name: str
    title: str
    problem: Callable[..., Problem]
    x: Axis
    y: Axis

    def __post_init__(self) -> None:
        for name in "xy":
            checks.instance(name, getattr(self, name), Axis, "an Axis")
        names = self.x.name, self.y.name
        if names[0] == names[1]:
            raise checks.InputError(f"x, y: both axes are called {names[0]!r}")
        if not checks.is_function(self.problem):
            raise checks.InputError(f"problem = {self.problem!r}: must be a function")
        try:
            inspect.signature(self.problem).bind(**dict.fromkeys(names))
        except TypeError as failure:
            asked = " and ".join(map(repr, names))
            raise checks.InputError(f"problem: is to take {asked} alone: {failure}") from None

    def cells(self) -> list[dict[str, Any]]:
        """The settings of all cells, row by row."""
        return [{self.x.name: x, self.y.name: y} for y in self.y.values for x in self.x.values]

    def thinned(self, count: int) -> Map:
        """The same with at most ``count`` values on each axis."""
        return replace(self, x=self.x.thinned(count), y=self.y.thinned(count))

    def key(self, cell: dict[str, Any]) -> str:
        """What a cell is found by in a file of results: the map's name, the problem with what is
        bound to it and what it does, and where the cell is."""
        whole = [self.name, named(self.problem), self._version, cell]
        text = json.dumps(whole, sort_keys=True, default=listed)
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    @cached_property
    def _version(self) -> str:
        return digits(self.problem)


def judge_cell(problem: Callable[..., Problem], cell: dict[str, Any]) -> Verdict:
    """Judge one cell; this is what a worker process calls."""
    return judge(partial(problem, **cell))


def run_maps(
    maps: Sequence[Map],
    file: Path,
    *,
    limit: float = 120.0,
    processes: int | None = None,
    progress: bool | None = None,
) -> dict[str, list[Verdict]]:
    """Judge all cells of some maps that a file does not hold yet.

    A process that passes its time limit is ended, and its cell counts as stopped for this reason;
    one that dies, or whose problem raises other than an ``InputError``, counts as nonsense. Both
    are judged again when the file is taken up again; so are all cells of a problem that does
    something else by then: that has other code, or reads other values from around it.
    Processes import the calling script: what it runs stands below ``if __name__ == "__main__":``.

    Args:
        maps: the maps.
        file: of JSON lines, appended to.
        limit: of a cell, s, once its process has imported the problem, for which it has a minute.
        processes: how many at a time; default: one for each core.
        progress: show a bar; default: if a person watches.

    Returns:
        For each map its verdicts in the order of its cells.

    Raises:
        InputError: no maps; two of one name; a limit that is not > 0; no processes, or under
            mpirun; a file of something else, which stays as it is, or that cannot be written.
        RuntimeError: a process ends as it begins, or does not find the problem. Or a full disk, for
            one (NotWritten), which it names; what is on file stays.
    """
    checks.number("limit", limit, above=0)
    how_many(processes)
    maps, file = checks.sequence("maps", maps, Map, "Maps"), checks.path("file", file)
    if twice := [name for name, n in Counter(m.name for m in maps).items() if n > 1]:
        raise checks.InputError(f"maps: two are called {twice[0]!r}; each needs a name of its own")
    found = records(file, START, _record, "maps")
    known = {key: verdict for key, verdict in found if _judged(verdict)}
    todo = [(m, cell) for m in maps for cell in m.cells() if m.key(cell) not in known]
    begin(file)
    calls = [(judge_cell, (m.problem, cell)) for m, cell in todo]
    for i, result in each(calls, limit, processes, progress):
        verdict = result if isinstance(result, Verdict) else _failed(result)
        m, cell = todo[i]
        known[m.key(cell)] = verdict
        line = {"key": m.key(cell), "map": m.name, "cell": cell, **asdict(verdict)}
        with writing(file), file.open("a") as out:
            out.write(json.dumps(line, default=listed) + "\n")
    return {m.name: [known[m.key(cell)] for cell in m.cells()] for m in maps}


def _failed(reason: Any) -> Verdict:
    return Verdict("stopped" if _cut(str(reason)) else "nonsense", reason=str(reason))


def _cut(reason: str) -> bool:
    """Whether a cell was ended by its time limit, which tells of the machine."""
    return reason.startswith("time limit")


def _judged(verdict: Verdict) -> bool:
    """Whether it tells of a run, or of a refusal: what was cut, died or raised may be mended."""
    return verdict.kind == "refused" or bool(np.isfinite(verdict.run_time_s))


def _record(row: Any) -> tuple[str, Verdict]:
    fields = {k: v for k, v in row.items() if k not in ("key", "map", "cell")}
    return row["key"], Verdict(**fields)


def summary(verdicts: Iterable[Verdict]) -> dict[str, int]:
    """How many cells there are, and of each class."""
    counts = Counter(verdict.kind for verdict in verdicts)
    return {"cells": sum(counts.values()), **{kind: counts[kind] for kind in CLASSES}}
