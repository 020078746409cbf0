# SPDX-License-Identifier: LGPL-3.0-or-later
"""Many independent runs over the processes of a machine, each a line of a file."""

from __future__ import annotations

import json
import multiprocessing
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any


def batch(
    function: Callable[..., Mapping[str, Any]],
    cases: Sequence[Mapping[str, Any]],
    file: Path,
    *,
    processes: int | None = None,
    progress: bool | None = None,
) -> list[dict[str, Any]]:
    """Call a function for all cases that a file does not hold yet.

    The processes are forks of this one: what it has imported, made and kept is theirs, too. A batch
    that was stopped goes on where it was; a line that was cut off is done again.

    Args:
        function: at the top of a module; from a case, by name, to results, by other names.
        cases: numbers or texts, by the same names each.
        file: of JSON lines, appended to: a case and its results each.
        processes: how many; default: one for each core.
        progress: show a bar; default: if a person watches.

    Returns:
        The lines of the cases, in their order.

    Raises:
        Exception: what the function raised; other cases that are done by then are on file.
    """
    from tqdm import tqdm

    names = list(cases[0]) if cases else []

    def key(line: Mapping[str, Any]) -> str:
        return json.dumps([line.get(name) for name in names])

    known = {key(line): line for line in _lines(file)}
    todo = [case for case in cases if key(case) not in known]
    file.parent.mkdir(parents=True, exist_ok=True)
    show = sys.stderr.isatty() if progress is None else progress
    fork = multiprocessing.get_context("fork")
    with ProcessPoolExecutor(processes or os.cpu_count(), fork) as pool, file.open("a") as out:
        found = {pool.submit(function, **case): case for case in todo}
        done = len(cases) - len(todo)
        try:
            for each in tqdm(as_completed(found), total=len(cases), initial=done, disable=not show):
                line = {**found[each], **each.result()}
                known[key(line)] = line
                out.write(json.dumps(line) + "\n")
                out.flush()
        finally:
            pool.shutdown(cancel_futures=True)  # who is stopped does not wait for all the others
    return [known[key(case)] for case in cases]


def _lines(file: Path) -> list[dict[str, Any]]:
    """The whole lines of a file; one that a kill cut short is taken out."""
    lines = file.read_text().splitlines(keepends=True) if file.is_file() else []
    if lines and not lines[-1].endswith("\n"):
        file.write_text("".join(lines[:-1]))
        lines.pop()
    return [json.loads(line) for line in lines]
