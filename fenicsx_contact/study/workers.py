# SPDX-License-Identifier: LGPL-3.0-or-later
"""Calls in processes of their own, each with a time limit; a process serves many calls."""

from __future__ import annotations

import multiprocessing
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from time import monotonic
from typing import Any

from mpi4py import MPI

from ..base import checks

#: A process imports the package anew, so that nothing of MPI or PETSc is shared.
_SPAWN = multiprocessing.get_context("spawn")

Call = tuple[Callable[..., Any], tuple[Any, ...]]


def how_many(processes: int | None) -> int:
    """Processes that a study starts: so many or, by default, one for each core.

    Raises:
        InputError: no number, or the script itself runs on several, each of which would.
    """
    if MPI.COMM_WORLD.size > 1:
        raise checks.InputError(
            "processes: a study starts its own, one for each core; run it without mpirun, here "
            f"with {MPI.COMM_WORLD.size} processes"
        )
    if processes is not None:
        checks.whole_number("processes", processes, at_least=1)
    return processes or os.cpu_count() or 1


@dataclass(frozen=True)
class _Word:
    """What a process says of itself: that it has read a call, or why it cannot."""

    fault: str = ""


def _serve(pipe: Connection) -> None:
    while True:
        try:
            function, arguments = pipe.recv()
        except EOFError:
            return
        except Exception as failure:
            return pipe.send(_Word(f"a process cannot read its call: {failure}"))
        pipe.send(_Word())
        try:
            pipe.send(function(*arguments))
        except Exception as failure:
            pipe.send(f"{type(failure).__name__}: {failure}")


class _Worker:
    """A process, the call that it is at, and until when."""

    def __init__(self) -> None:
        self.pipe, theirs = _SPAWN.Pipe()
        self.process = _SPAWN.Process(target=_serve, args=(theirs,), daemon=True)
        self.process.start()
        theirs.close()
        self.begun = False

    def start(self, index: int, call: Call, limit: float) -> None:
        self.index = index
        self.has(limit)
        self.pipe.send(call)

    def has(self, limit: float) -> None:
        self.limit, self.until = limit, monotonic() + limit

    def heard(self, limit: float) -> Any:
        """What came through the pipe: a value, or a word of the process about itself, after which
        its call has its time.

        Raises:
            EOFError, ConnectionError: it died.
            RuntimeError: it cannot begin, or cannot read its call.
        """
        try:
            result = self.pipe.recv()
        except (EOFError, ConnectionError):
            self.process.join()
            if not self.begun:
                raise RuntimeError(
                    f"a process ended as it began, code {self.process.exitcode}: it imports the "
                    'calling script, of which what runs must stand below if __name__ == "__main__":'
                ) from None
            raise
        if isinstance(result, _Word):
            if result.fault:
                raise RuntimeError(result.fault)
            self.begun = True
            self.has(limit)
        return result

    def end(self) -> None:
        self.pipe.close()
        self.process.kill()
        self.process.join()


def each(
    calls: Sequence[Call],
    limit: float,
    processes: int | None = None,
    progress: bool | None = None,
    start_up: float = 60.0,
) -> Iterator[tuple[int, Any]]:
    """Make calls, in any order.

    Args:
        calls: functions at the top of modules, and their arguments.
        limit: of each call, s.
        processes: how many at a time; default: one for each core.
        progress: show a bar; default: if a person watches.
        start_up: until a process has read a call, s, for which it imports what the call names.

    Yields:
        The index of a call, and its value; a text if it raised, passed its limit or died.

    Raises:
        InputError: no number of processes, or under mpirun.
        RuntimeError: a process cannot begin, or read its call.
    """
    from tqdm import tqdm

    count = min(how_many(processes), len(calls))
    queue = iter(enumerate(calls))
    workers: list[_Worker] = []
    show = sys.stderr.isatty() if progress is None else progress
    bar = tqdm(total=len(calls), unit="cell", disable=not show, smoothing=0.02)
    try:
        for _ in range(count):
            workers.append(_Worker())
            workers[-1].start(*next(queue), start_up)
        while workers:
            left = max(0.0, min(w.until for w in workers) - monotonic())
            ready = wait([w.pipe for w in workers], timeout=left)
            for i in reversed(range(len(workers))):
                worker = workers[i]
                alive = True
                if worker.pipe in ready:
                    try:
                        result = worker.heard(limit)
                    except (EOFError, ConnectionError):
                        result, alive = f"process died, code {worker.process.exitcode}", False
                    if isinstance(result, _Word):
                        continue
                elif monotonic() >= worker.until:
                    result, alive = f"time limit of {worker.limit:g} s passed", False
                else:
                    continue
                yield worker.index, result
                bar.update()
                if (call := next(queue, None)) is None:
                    workers.pop(i).end()
                    continue
                if not alive:
                    worker.end()
                    worker = workers[i] = _Worker()
                worker.start(*call, start_up)
    finally:
        bar.close()
        for worker in workers:
            worker.end()
