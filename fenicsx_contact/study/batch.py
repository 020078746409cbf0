# SPDX-License-Identifier: LGPL-3.0-or-later
"""Many independent runs over the processes of a machine, each a line of a file."""

from __future__ import annotations

import inspect
import json
import multiprocessing
import os
import pickle
import random
import sys
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from hashlib import sha256
from itertools import islice
from pathlib import Path
from threading import Thread
from time import sleep
from typing import Any

import numpy as np

from ..base import checks
from ..base.quoted import quoted
from ..base.told import digits
from ..output.storage import writing
from .names import named
from .records import begin, listed, records
from .workers import how_many

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

    The processes are forks of this one: what it has imported, made and kept is theirs, too, and a
    generator of random numbers that is kept gives all of them the same; let each case seed its own
    (numpy's and Python's own global ones are seeded by the case). A batch that was stopped goes on
    where it was; a line that was cut off is done again.

    Args:
        function: at the top of a module; from a case, by name, to results, by other names.
        cases: numbers or texts, by the same names each; what stands there twice is run once.
        file: of JSON lines, appended to: a case, its results and the function each, by its name
            and by what a ``partial``, a method or an object binds to it. Results count as long as
            the function does the same: with other code, or other values around it that it reads,
            its cases are run again. Lines that do not tell are taken to be of this function.
        processes: how many; default: one for each core.
        progress: show a bar; default: if a person watches.

    Returns:
        The cases with their results, in their order, as they are on file (tuples are lists, numbers
        that name something texts).

    Raises:
        InputError: no such function; no list of cases, or of names that differ or are none of its
            arguments; a file of something else, or of another function, which stays as it is; no
            processes, or under mpirun; results that a file of JSON cannot hold, or by names of the
            case.
        RuntimeError: a process died; the message names the cases that were under way. Or a full
            disk, for one (NotWritten), which it names; what is on file stays.
        Exception: what the function raised first; its cause tells the case. Those that ran beside
            it are done and on file, and no other is begun.
    """
    from tqdm import tqdm

    file = checks.path("file", file)
    cases = checks.sequence("cases", cases, Mapping, "dicts")
    _check_function(function)
    count = how_many(processes)
    for i, case in enumerate(cases):
        if set(case) != set(cases[0]):
            raise checks.InputError(
                f"cases[{i}]: is of {sorted(case)}, cases[0] of {sorted(cases[0])}; all need the "
                "same names"
            )
        _check_case(function, i, case)
    found, name = records(file, START, _record, "a batch"), named(function)
    version = digits(function)
    if others := sorted({of for *_, of, _ in found} - {name, ""}):
        raise checks.InputError(
            f"file = {str(file)!r}: holds results of {others[0]}, not of {name}; each function "
            "needs a file of its own"
        )
    known = {_key(case): results for case, results, _, of in found if of in (version, "")}
    todo = list({_key(case): case for case in cases if _key(case) not in known}.values())
    begin(file)
    show = sys.stderr.isatty() if progress is None else progress
    fork = multiprocessing.get_context("fork")
    failures: list[tuple[dict[str, Any], BaseException]] = []
    bar = tqdm(total=len(cases), initial=len(cases) - len(todo), disable=not show)
    pool = ProcessPoolExecutor(count, fork, _ends_with, (os.getpid(),))
    with pool, bar:
        for case, done in _each(pool, count, partial(_line, name, version, function), todo):
            if failure := done.exception():
                failures.append((dict(case), failure))
                continue
            known[_key(case)] = json.loads(done.result())["results"]
            with writing(file), file.open("a") as out:
                out.write(done.result() + "\n")
            bar.update()
    if failures:
        raise _told(failures, file)
    return [{**case, **known[_key(case)]} for case in cases]


def _ends_with(parent: int) -> None:
    """Let this process end with the one that forked it: killed, that cannot tell the others, and
    each holds open what the next waits for."""

    def watch() -> None:
        while os.getppid() == parent:
            sleep(1.0)
        os._exit(1)

    Thread(target=watch, daemon=True).start()


def _each(
    pool: ProcessPoolExecutor,
    count: int,
    call: Callable[[Mapping[str, Any]], str],
    cases: Iterable[Mapping[str, Any]],
) -> Iterator[tuple[Mapping[str, Any], Future]]:
    """Cases as they are done, so many at a time. The others wait here: after one that failed, or
    when this process is stopped, only those that run are waited for."""
    waiting, failed = iter(cases), False
    running: dict[Future, Mapping[str, Any]] = {}
    while True:
        try:
            for case in islice(waiting, 0 if failed else count - len(running)):
                running[pool.submit(call, case)] = case
        except BrokenProcessPool:
            if not running:  # who died was at no case
                raise
        if not running:
            return
        for done in wait(running, return_when=FIRST_COMPLETED).done:
            failed = failed or done.exception() is not None
            yield running.pop(done), done


def _told(failures: Sequence[tuple[dict[str, Any], BaseException]], file: Path) -> BaseException:
    """The first failure, which tells its case; that of a process, those that were under way."""
    case, first = failures[0]
    if isinstance(first, BrokenProcessPool):
        under_way = [case for case, each in failures if isinstance(each, BrokenProcessPool)]
        return RuntimeError(
            f"a process died; under way were the cases {under_way}; what was done by then is in "
            f"{file}"
        )
    whose = RuntimeError(f"function(**{case}) failed; what else was done by then is in {file}")
    whose.__cause__, first.__cause__ = first.__cause__, whose  # that of the other process is first
    return first


def _check_function(function: Any) -> None:
    checks.function("function", function)
    try:
        pickle.dumps(function)
    except Exception:  # of whatever kind
        raise checks.InputError(
            f"function = {quoted(function)}: must stand at the top of a module, by "
            "a name, for other "
            "processes to find it"
        ) from None


def _check_case(function: Callable[..., Any], i: int, case: Mapping[str, Any]) -> None:
    try:
        _key(case)
    except (TypeError, ValueError) as problem:
        raise checks.InputError(
            f"cases[{i}] = {quoted(case)}: must be of numbers or texts by names ({problem})"
        ) from None
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):  # of what is not written in Python nobody knows
        return
    try:
        signature.bind(**case)
    except TypeError as problem:
        raise checks.InputError(
            f"cases[{i}] = {quoted(case)}: are no arguments of {quoted(function)} ({problem})"
        ) from None


def _line(name: str, version: str, function: Callable[..., Any], case: Mapping[str, Any]) -> str:
    """Of a file; in a process of the batch, which has its generators of random numbers from another
    as they were."""
    seed = int(sha256(_key(case).encode()).hexdigest()[:8], 16)
    np.random.seed(seed)  # noqa: NPY002
    random.seed(seed)
    results = _called(function, case)
    what = f"function(**{dict(case)}) = {results!r}"
    if not isinstance(results, Mapping):
        raise checks.InputError(f"{what}: must be results by their names, a dict")
    if both := sorted(set(case) & set(map(str, results))):
        raise checks.InputError(f"{what}: {both} are of the case; results need other names")
    try:
        line = {"case": case, "results": results, "function": name, "version": version}
        return json.dumps(line, default=listed)
    except (TypeError, ValueError) as problem:
        raise checks.InputError(
            f"{what}: must be of numbers, texts and lists of them ({problem})"
        ) from None


def _called(function: Callable[..., Any], case: Mapping[str, Any]) -> Any:
    """What the function says of a case, or an error that another process can be told."""
    try:
        return function(**case)
    except SystemExit as end:  # which would end that one, without a word
        raise RuntimeError(f"function(**{dict(case)}) ends by sys.exit({end.code!r})") from None
    except Exception as error:
        try:
            pickle.loads(pickle.dumps(error))
        except Exception:  # of whatever kind
            kind = type(error).__name__
            raise RuntimeError(f"{kind}: {error}\n{traceback.format_exc()}") from None
        raise


def _key(case: Mapping[str, Any]) -> str:
    return json.dumps(case, sort_keys=True, default=listed)


def _record(line: Any) -> tuple[dict[str, Any], dict[str, Any], str, str]:
    function, version = (str(line.get(name, "")) for name in ("function", "version"))
    return dict(line["case"]), dict(line["results"]), function, version
