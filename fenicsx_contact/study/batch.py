# SPDX-License-Identifier: LGPL-3.0-or-later
"""Many independent runs over the processes of a machine, each a line of a file."""

from __future__ import annotations

import inspect
import json
import multiprocessing
import os
import pickle
import sys
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

from ..base import checks
from .names import named
from .records import listed, records

#: How a line of a batch begins.
START = '{"case": {'


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
        file: of JSON lines, appended to: a case, its results and the function each, by its name
            and by what a ``partial``, a method or an object binds to it; older ones have no name,
            and are taken to be of this function.
        processes: how many; default: one for each core.
        progress: show a bar; default: if a person watches.

    Returns:
        The cases with their results, in their order, as they are on file (tuples are lists).

    Raises:
        InputError: no such function; no list of cases, or of names that differ or are none of its
            arguments; a file of something else, or of another function, which stays as it is; no
            processes; results that a file of JSON cannot hold.
        RuntimeError: a process died; the message names the cases that were under way.
        Exception: what the function raised; other cases that are done by then are on file.
    """
    from tqdm import tqdm

    file = checks.path("file", file)
    cases = checks.sequence("cases", cases, Mapping, "dicts")
    _check_function(function)
    if processes is not None:
        checks.whole_number("processes", processes, at_least=1)
    for i, case in enumerate(cases):
        if set(case) != set(cases[0]):
            raise checks.InputError(
                f"cases[{i}]: is of {sorted(case)}, cases[0] of {sorted(cases[0])}; all need the "
                "same names"
            )
        _check_case(function, i, case)
    found, name = records(file, START, _record, "a batch"), named(function)
    if others := sorted({of for *_, of in found} - {name, ""}):
        raise checks.InputError(
            f"file = {str(file)!r}: holds results of {others[0]}, not of {name}; each function "
            "needs a file of its own"
        )
    known = {_key(case): results for case, results, _ in found}
    todo = list({_key(case): case for case in cases if _key(case) not in known}.values())
    file.parent.mkdir(parents=True, exist_ok=True)
    show = sys.stderr.isatty() if progress is None else progress
    fork = multiprocessing.get_context("fork")
    working, count = fork.RawArray("b", len(todo)), processes or os.cpu_count()
    with ProcessPoolExecutor(count, fork, initializer=_share, initargs=(working,)) as pool:
        calls = {pool.submit(_call, i, function, case): case for i, case in enumerate(todo)}
        bar = tqdm(total=len(cases), initial=len(cases) - len(todo), disable=not show)
        try:
            with bar, file.open("a") as out:
                for each in as_completed(calls):
                    line = _line(name, calls[each], each.result())
                    known[_key(calls[each])] = json.loads(line)["results"]
                    out.write(line + "\n")
                    out.flush()
                    bar.update()
        except BrokenProcessPool:
            under_way = [dict(case) for case, works in zip(todo, working) if works]
            raise RuntimeError(
                f"a process died; under way were the cases {under_way}; what was done by then is "
                f"in {file}"
            ) from None
        finally:
            pool.shutdown(cancel_futures=True)  # who is stopped does not wait for all the others
    return [{**case, **known[_key(case)]} for case in cases]


_SHARED: dict[str, Any] = {}  # with the first process


def _share(working: Any) -> None:
    _SHARED["working"] = working


def _call(i: int, function: Callable[..., Any], case: Mapping[str, Any]) -> Any:
    """In a process of the batch; the first one can see which cases are under way."""
    _SHARED["working"][i] = True
    try:
        return function(**case)
    finally:
        _SHARED["working"][i] = False


def _check_function(function: Any) -> None:
    if not checks.is_function(function):
        raise checks.InputError(f"function = {function!r}: must be a function")
    try:
        pickle.dumps(function)
    except Exception:  # of whatever kind
        raise checks.InputError(
            f"function = {function!r}: must stand at the top of a module, by a name, for other "
            "processes to find it"
        ) from None


def _check_case(function: Callable[..., Any], i: int, case: Mapping[str, Any]) -> None:
    try:
        _key(case)
    except (TypeError, ValueError) as problem:
        raise checks.InputError(
            f"cases[{i}] = {case!r}: must be of numbers or texts by names ({problem})"
        ) from None
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):  # of what is not written in Python nobody knows
        return
    try:
        signature.bind(**case)
    except TypeError as problem:
        raise checks.InputError(
            f"cases[{i}] = {case!r}: are no arguments of {function!r} ({problem})"
        ) from None


def _line(function: str, case: Mapping[str, Any], results: Any) -> str:
    name = f"function(**{dict(case)})"
    if not isinstance(results, Mapping):
        raise checks.InputError(f"{name} = {results!r}: must be results by their names, a dict")
    try:
        line = {"case": case, "results": results, "function": function}
        return json.dumps(line, default=listed)
    except (TypeError, ValueError) as problem:
        raise checks.InputError(
            f"{name} = {results!r}: must be of numbers, texts and lists of them ({problem})"
        ) from None


def _key(case: Mapping[str, Any]) -> str:
    return json.dumps(case, sort_keys=True, default=listed)


def _record(line: Any) -> tuple[dict[str, Any], dict[str, Any], str]:
    return dict(line["case"]), dict(line["results"]), str(line.get("function", ""))
