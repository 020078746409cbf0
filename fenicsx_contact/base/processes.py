# SPDX-License-Identifier: LGPL-3.0-or-later
"""Several processes: what one of them meets, all of them end with."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from functools import cache
from time import monotonic, sleep
from types import TracebackType
from typing import Any, TypeVar

import numpy as np
from mpi4py import MPI

from .checks import InputError, StepFailed

T = TypeVar("T")
#: Cost: seconds for which a process on which something failed waits for the others to end.
PATIENCE = 60.0


def on_first(comm: Any, action: Callable[[], T]) -> T:
    """What an action returns or raises on the first process, on every process."""
    if comm.size == 1:
        return action()
    result: Any = None
    failure: Exception | None = None
    if comm.rank == 0:
        try:
            result = action()
        except Exception as problem:  # whatever it is, the others wait
            failure = problem
    result, failure = comm.bcast((result, failure))
    if failure is not None:
        raise failure
    return result


def together(comm: Any, action: Callable[[], T], kind: type[Exception] = StepFailed) -> T:
    """What an action returns on each process; what fails by an error of this kind on any, or exits
    there (``sys.exit``, of which no hook is told), does so on all."""
    if comm.size == 1:
        return action()
    result: Any = None
    failure: Exception | SystemExit | None = None
    try:
        result = action()
    except (kind, SystemExit) as problem:  # the others have not met it
        failure = problem
    failed = [each for each in comm.allgather(failure) if each is not None]
    if failed:
        raise failed[0]
    return result


@cache
def _aside_of_all() -> Any:
    return MPI.COMM_WORLD.Dup()


class _Known(StepFailed):
    """A step failed by what all processes know."""


class Meeting:
    """Where processes meet after each has done its share of something that they do together, apart
    from the messages of that: what one of them broke off may wait for it.

    Args:
        comm: the processes.
    """

    def __init__(self, comm: Any) -> None:
        self._comm = comm
        if comm.size > 1:  # communicators are few
            all_of_them = MPI.Comm.Compare(comm, MPI.COMM_WORLD) <= MPI.CONGRUENT
            self._comm = _aside_of_all() if all_of_them else comm.Dup()

    def after(self, action: Callable[[], T]) -> T:
        """What an action returns. A step that fails on one process does so on all; where these do
        not come to know, for they wait for it within, all are ended with its message. Where they
        meet within the action, too, nobody is told again what all know since."""
        if self._comm.size == 1:
            return action()
        failure, result = None, None
        try:
            result = action()
        except _Known:
            raise
        except StepFailed as problem:
            failure = problem
        failed = np.zeros(self._comm.size, dtype=np.int32)
        request = self._comm.Iallgather(np.array([failure is not None], dtype=np.int32), failed)
        end = monotonic() + PATIENCE
        while failure and not request.Test():
            if monotonic() > end:
                told = f"process {self._comm.rank} stops, and others wait for it: {failure}"
                print(told, file=sys.stderr, flush=True)
                MPI.COMM_WORLD.Abort(1)
            sleep(1e-3)
        request.Wait()
        if failed.any():
            raise _Known(self._comm.bcast(str(failure), root=int(failed.argmax()))) from failure
        return result  # type: ignore[return-value]


def any_of(comm: Any, *truths: bool) -> list[bool]:
    """Of each of these, whether it holds on any process."""
    if comm.size == 1:
        return list(truths)
    return [any(each) for each in zip(*comm.allgather(truths))]


def refuse_unlike(comm: Any, given: Mapping[str, Any]) -> None:
    """What processes that go on together must have in common, by its names; with other ends or
    steps they would wait for each other for ever.

    Raises:
        InputError: on every process, if anything is another on one of them.
    """
    every = comm.allgather({name: repr(each) for name, each in given.items()})
    for rank, other in enumerate(every):
        for name, value in every[0].items():
            if other.get(name) != value:
                raise InputError(
                    f"{name} = {other.get(name)} on process {rank}, {value} on process 0: must be "
                    "the same on every process"
                )


def end_together() -> None:
    """Let an error that nobody catches on one process end all of them: the others would wait for
    it for ever. Its message is printed first. Sessions with a prompt stay as they are."""
    if MPI.COMM_WORLD.size == 1 or hasattr(sys, "ps1") or sys.flags.interactive:
        return
    shown = sys.excepthook

    def hook(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        shown(kind, error, trace)
        sys.stdout.flush()
        sys.stderr.flush()
        MPI.COMM_WORLD.Abort(1)

    sys.excepthook = hook
