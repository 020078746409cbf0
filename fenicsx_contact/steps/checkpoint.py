# SPDX-License-Identifier: LGPL-3.0-or-later
"""The state of a scene, which is taken up as a whole or not at all; and that of a run as any number
of processes can take it up: the unknowns of distributed solids whole, numbered as their meshes were
given."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ..base.checks import InputError
from ..base.processes import any_of
from ..solids import DeformableSolid, Solid
from ..solids.vector_space import VectorSpace


def _distributed(solids: Sequence[Solid]) -> Iterator[tuple[str, VectorSpace]]:
    """Names of the arrays that hold owned unknowns, and of which space."""
    for i, solid in enumerate(solids):
        if isinstance(solid, DeformableSolid):
            for name in solid.distributed:
                yield f"solid.{solid.name}.{name}", solid.vectors
            # accelerations by which the next step is guessed, and its error estimated
            yield f"impacts.rate.{i}", solid.vectors
            yield f"run.error.acceleration.{i}", solid.vectors


def collect(solids: Sequence[Solid], state: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """A state of this process with all unknowns, on the first process; asks every process."""
    whole = {name: v.whole(state[name]) for name, v in _distributed(solids) if name in state}
    return {**state, **whole}


def spread(solids: Sequence[Solid], state: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The part of this process in a state with all unknowns."""
    part = {name: v.part(state[name]) for name, v in _distributed(solids) if name in state}
    return {**state, **part}


def state_of(things: Sequence[tuple[str, Any]]) -> dict[str, np.ndarray]:
    """Copies of all that things with states continue from; before each name what it is of."""
    states = [(prefix, thing.state()) for prefix, thing in things]
    return {f"{of}{name}": np.array(v) for of, state in states for name, v in state.items()}


def take_up(things: Sequence[tuple[str, Any]], state: Mapping[str, np.ndarray], comm: Any) -> None:
    """Let things take up a state that :func:`state_of` gave of them.

    Raises:
        InputError: it is none, on this process or another; the things are as they were.
    """
    before = state_of(things)
    problem = _difference(before, state, present=False)
    if not any_of(comm, bool(problem))[0]:
        try:
            _restore(things, state)
            problem = _difference(state_of(things), state, present=True)
        except KeyError as missing:
            problem = f"{missing} is missing"
        except Exception as failure:  # of what does not fit
            problem = f"{type(failure).__name__}: {failure}"
        if not any_of(comm, bool(problem))[0]:
            return
        _restore(things, before)
    problem = problem or "another process refuses it"
    raise InputError(f"state: must be one that state() gave of this scene; {problem}")


def _restore(things: Sequence[tuple[str, Any]], state: Mapping[str, np.ndarray]) -> None:
    for prefix, thing in things:
        of_it = [name for name in state if name.startswith(prefix)]
        thing.restore({name.removeprefix(prefix): state[name] for name in of_it})


def _difference(
    own: Mapping[str, np.ndarray], state: Mapping[str, np.ndarray], present: bool
) -> str:
    """What tells a state from one of the things that have their own, or nothing. ``present``: they
    have taken it up; before, what they remember may be missing, empty or new."""
    for name in {**own, **state} if present else own.keys() & state.keys():
        if name not in state or name not in own:
            return f"{name!r} is {'missing' if name in own else 'none of its names'}"
        given, mine = np.asarray(state[name]), own[name]
        if given.shape != mine.shape and (present or (given.size and mine.size)):
            return f"{name!r} has the shape {given.shape}, not {mine.shape}"
        if given.dtype.kind == "f" and np.isnan(given).any():
            return f"{name!r} holds NaN"
    return ""
