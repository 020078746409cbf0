# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a run leaves behind: how its state changes with the parameters, where that is asked for; and
for going back through it its linearised steps as long as there is room for them, and states from
which the others are run once more."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..solids.factor import Factorisation
from ..steps.trial import Trial
from .blocks import LinearStep
from .kinks import NoDerivative
from .seeds import Row

#: Cost: bytes of linearised steps that are kept; what is beyond them is run once more.
ROOM = 2**29


@dataclass
class Part:
    """Steps between two states.

    Attributes:
        start: the first one.
        end: when the other one is, s.
        row: of the history at its start.
        steps: the steps that were linearised.
        seeds: what quantities are in their rows, the start's first.
    """

    start: dict[str, np.ndarray]
    end: float
    row: int
    steps: list[tuple[Trial, LinearStep]] = field(default_factory=list)
    seeds: list[Row] = field(default_factory=list)


class Along:
    """Derivatives of the state by the parameters along a run, brought up to where it is when they
    are asked for: by an adjoint seldom.

    Args:
        state: those at its start, (size, parameters).

    Attributes:
        begun: whether a step has been accepted.
    """

    def __init__(self, state: np.ndarray) -> None:
        self._state, self.begun = state, False
        self._steps: list[tuple[Trial, LinearStep]] = []  # since then
        self._last: tuple[Trial, LinearStep] | None = None
        self._change: np.ndarray | None = None

    def solved(self, trial: Trial, step: LinearStep) -> None:
        """Take up the linearised step that goes on from the present state."""
        self._last, self._change = (trial, step), None

    def accept(self) -> None:
        """The state is at the end of the step."""
        assert self._last is not None
        self.begun = True
        if self._change is None:
            self._steps.append(self._last)
        else:
            self._state = self._change[: len(self._state)]

    @property
    def state(self) -> np.ndarray:
        """Of the state at the start of the step that was taken up last, after it was accepted at
        its end, (size, parameters)."""
        self.bring()
        return self._state

    def bring(self) -> None:
        """Bring them to that state; steps before it are not asked any more."""
        for trial, step in self._steps:
            self._state = _tangent(trial, step, self._state)[: len(self._state)]
        self._steps.clear()

    @property
    def change(self) -> np.ndarray:
        """Of all unknowns of that step, (unknowns, parameters); before it is accepted.

        Raises:
            NoDerivative: it is singular.
        """
        assert self._last is not None
        if self._change is None:
            self._change = _tangent(*self._last, self.state)
        return self._change


def _tangent(trial: Trial, step: LinearStep, start: np.ndarray) -> np.ndarray:
    return finite(trial, step.tangent(start))


def finite(trial: Trial, values: np.ndarray) -> np.ndarray:
    """The values, which are finite.

    Raises:
        NoDerivative: they are not.
    """
    if not np.isfinite(values).all():
        raise NoDerivative(
            f"t = {trial.step.end:.9g} s: the linearised step is singular; "
            "contact leaves a solid free to move, or says nothing of some of its forces"
        )
    return values


class Room:
    """Counts the bytes of what is kept.

    Args:
        most: bytes.
    """

    def __init__(self, most: float) -> None:
        self._left = most
        self._known: set[int] = set()  # what steps have in common counts once

    def take(self, things: list[Any]) -> bool:
        """Take room for arrays, and for what is made of such; whether some is left."""
        asked = list(things)
        while asked:
            thing = asked.pop()
            if id(thing) in self._known:
                continue
            self._known.add(id(thing))
            if isinstance(thing, np.ndarray):
                if thing.base is None:
                    self._left -= thing.nbytes
                else:
                    asked.append(thing.base)
            elif isinstance(thing, Factorisation):
                self._left -= thing.bytes
            elif isinstance(thing, (list, tuple)):
                asked += thing
            elif isinstance(thing, dict):
                asked += thing.values()
            elif sp.issparse(thing) or type(thing).__module__.startswith(_HERE):
                asked += vars(thing).values()
        return self._left > 0


_HERE = __name__.rpartition(".")[0]
