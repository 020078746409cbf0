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

from ..base import checks


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
        cases: numbers or texts, by the same names each; what stands there twice is run once.
        file: of JSON lines, appended to: a case and its results each, all of one function.
        processes: how many; default: one for each core.
        progress: show a bar; default: if a person watches.

    Returns:
        The cases with their results, in their order.

    Raises:
        InputError: no list of cases, or of different names; a file of something else; no processes.
        Exception: what the function raised; other cases that are done by then are on file.
    """
    from tqdm import tqdm

    file = checks.path("file", file)
    cases = checks.sequence("cases", cases, Mapping, "dicts")
    if processes is not None:
        checks.whole_number("processes", processes, at_least=1)
    for i, case in enumerate(cases):
        if set(case) != set(cases[0]):
            raise checks.InputError(
                f"cases[{i}]: is of {sorted(case)}, cases[0] of {sorted(cases[0])}; all need the "
                "same names"
            )
    known = {_key(case): results for case, results in _lines(file)}
    todo = {_key(case): case for case in cases if _key(case) not in known}
    file.parent.mkdir(parents=True, exist_ok=True)
    show = sys.stderr.isatty() if progress is None else progress
    fork = multiprocessing.get_context("fork")
    with ProcessPoolExecutor(processes or os.cpu_count(), fork) as pool, file.open("a") as out:
        found = {pool.submit(function, **case): case for case in todo.values()}
        done = len(cases) - len(todo)
        try:
            for each in tqdm(as_completed(found), total=len(cases), initial=done, disable=not show):
                case, results = found[each], dict(each.result())
                known[_key(case)] = results
                line = {"case": case, "results": results}
                out.write(json.dumps(line, default=listed) + "\n")
                out.flush()
        finally:
            pool.shutdown(cancel_futures=True)  # who is stopped does not wait for all the others
    return [{**case, **known[_key(case)]} for case in cases]


def listed(value: Any) -> Any:
    """What numpy gives as Python's own numbers."""
    if not hasattr(value, "tolist"):
        raise TypeError(f"{value!r} is no number or text")
    return value.tolist()


def _key(case: Mapping[str, Any]) -> str:
    return json.dumps(case, sort_keys=True, default=listed)


def _lines(file: Path) -> list[tuple[dict[str, Any], dict[str, Any]]]:
    """Cases and their results; a line that a kill cut short is taken out."""
    if file.is_dir():
        raise checks.InputError(f"file = {str(file)!r}: is a directory")
    lines = file.read_text().splitlines(keepends=True) if file.is_file() else []
    if lines and not lines[-1].endswith("\n"):
        file.write_text("".join(lines[:-1]))
        lines.pop()
    try:
        found = map(json.loads, lines)
        return [(line["case"], line["results"]) for line in found]
    except (ValueError, LookupError, TypeError):
        raise checks.InputError(f"file = {str(file)!r}: is none of a batch") from None
