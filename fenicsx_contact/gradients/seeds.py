# SPDX-License-Identifier: LGPL-3.0-or-later
"""Functionals of a run, and what they put into its adjoint row by row."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from ..base import checks
from ..base.quoted import quoted
from ..base.told import name_of
from ..output.history import History
from .bearing import OfContact
from .kinks import alike
from .linearise import Linearisation
from .memories import Remembered
from .parameters import Parameter
from .quantities import Quantity
from .said import numbers

#: From the history of a run: a value, and its derivatives by the rows (rows,) of quantities, and of
#: ``"time"``, by their names.
Functional = Callable[[History], tuple[float, Mapping[str, np.ndarray]]]


def gradient(linear: Linearisation, quantity: Quantity, unknowns: int = 0) -> np.ndarray:
    """Of a quantity by the state, or by as many unknowns of the step that was linearised last."""
    result, given = np.zeros(unknowns or linear.size), quantity.gradient()
    what = f"{name_of(quantity)}.gradient"
    if not isinstance(given, (tuple, list)) or len(given) != 2:
        raise checks.InputError(f"{what}: gives {quoted(given)}; must be derivatives by q and by v")
    for kind, each in zip(("q", "v"), given):
        part = result[linear.at.part(kind, quantity.solid)]
        part[:] = numbers(f"{what}: {kind}", each, len(part))
    if isinstance(quantity, Remembered):
        result[linear.at.memory(quantity.contact, quantity.name)] = quantity.weights
    if unknowns and isinstance(quantity, OfContact):
        points, pressures, forces = linear.at.bearing(quantity.contact)
        by_pressure, by_force = quantity.borne(points)
        result[forces] = by_force.ravel()
        if quantity.contact.multiplier is not None:  # springs have no pressures
            result[pressures] = -by_pressure
    return result


def explicit(parameters: Mapping[str, Parameter], quantity: Quantity) -> np.ndarray:
    """Derivatives of a quantity by the parameters at a fixed state, (parameters,)."""
    return np.array([quantity.explicit(parameter) for parameter in parameters.values()])


class Row(NamedTuple):
    """What quantities are in a row of the history; None where nobody asks.

    Attributes:
        by: derivatives by the unknowns of its step, of the start by the state, (unknowns,
            quantities).
        explicit: by the parameters at a fixed state, (parameters, quantities).
        shared: by how much, and of what, quantities change by another way to share what contacts
            bear, by name.
    """

    by: np.ndarray | None
    explicit: np.ndarray | None
    shared: Mapping[str, tuple[float, float]] = {}


def _asked(
    what: str, functional: Functional, history: History
) -> tuple[float, dict[str, np.ndarray]]:
    """The value of a functional and its derivatives, or a refusal."""
    given = checks.called(what, functional, history)
    if not isinstance(given, tuple) or len(given) != 2:
        raise checks.InputError(
            f"{what} gives {given!r}: must be its value, and its derivatives by quantities by name"
        )
    weights = checks.mapping(f"{what}: derivatives", given[1], "of arrays by name")
    rows = len(history)
    told = {k: checks.vector(f"{what}: derivatives {k!r}", w, rows) for k, w in weights.items()}
    return checks.number(f"{what}: value", given[0]), told


class Seeds:
    """What functionals put into an adjoint: a probe of the run along which it goes back.

    Beside the functionals stand the quantities at the end of the run.

    Args:
        linear: linearises its steps.
        parameters, quantities, functionals: by name.

    Attributes:
        values: of quantities at the end and of functionals, (k of them), after :meth:`weigh`.
        unknowns: of the step that was linearised last, 0 at the start of a run.
        shared: by how much quantities change there, as in :class:`Row`.
        found: the rows since the last :meth:`begin`.

    Raises:
        InputError: two of one name.
    """

    values: dict[str, float]

    def __init__(
        self,
        linear: Linearisation,
        parameters: Mapping[str, Parameter],
        quantities: Mapping[str, Quantity],
        functionals: Mapping[str, Functional],
    ) -> None:
        self._linear, self._parameters = linear, parameters
        self._quantities, self._functionals = quantities, functionals
        self._weights: np.ndarray | None = None
        self.shared: dict[str, tuple[float, float]] = {}
        self._since: dict[str, int] = {}
        for name in functionals:
            if name in quantities:
                raise checks.InputError(f"functionals: {name!r} is a quantity, too")

    def weigh(self, history: History) -> None:
        """Take the values and the weights of a run.

        Raises:
            InputError: derivatives by what is no quantity.
        """
        quantities, rows, end = self._quantities, len(history), np.eye(len(history))[-1]
        self.values = {name: float(history[name][-1]) for name in quantities}
        every: list[Mapping[str, np.ndarray]] = [{name: end} for name in quantities]
        for name, functional in self._functionals.items():
            self.values[name], weights = _asked(f"functionals[{name!r}]", functional, history)
            for column in weights:
                if column not in quantities and column != "time":
                    raise checks.InputError(
                        f"functionals[{name!r}]: gives derivatives by {column!r}, no quantity"
                    )
            every.append(weights)
        nothing = np.zeros(rows)
        names = (*quantities, "time")
        table = [[each.get(name, nothing) for each in every] for name in names]
        self._weights = np.array(table).transpose(2, 0, 1)  # rows, names, functionals

    def begin(self, row: int) -> None:
        """Begin at a row of the history."""
        self._row, self.unknowns, self.shared = row, 0, {}
        self.found: list[Row] = []

    def __call__(self) -> float:
        if self._weights is None:  # the end is asked for when it is known
            asked = bool(self._functionals)
        else:
            asked = bool(self._weights[self._row, :-1].any())
        self.found.append(self.row() if asked else Row(None, None))
        self._row += 1
        return 0.0

    def row(self) -> Row:
        """That of the present state."""
        linear, every = self._linear, self._quantities.values()
        by = [gradient(linear, quantity, self.unknowns) for quantity in every]
        told = [explicit(self._parameters, quantity) for quantity in every]
        if not by:  # the time alone is asked for
            return Row(None, None)
        return Row(np.array(by).T, np.array(told).T, self.shared)

    def since(self, time: np.ndarray) -> dict[str, float]:
        """What hangs on how contacts share what they bear, and since when, s."""
        return {name: float(time[row]) for name, row in self._since.items()}

    def of(self, row: int, found: Row, unknowns: int) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the k by the unknowns of a row's step and by the parameters, (unknowns, k)
        and (parameters, k)."""
        assert self._weights is not None
        weights = self._weights[row]
        if found.by is None or found.explicit is None:
            count = weights.shape[1]
            seed, by = np.zeros((unknowns, count)), np.zeros((len(self._parameters), count))
        else:
            seed, by = found.by @ weights[:-1], found.explicit @ weights[:-1]
            change, terms = np.array([found.shared.get(n, (0.0, 0.0)) for n in self._quantities]).T
            hang = ~alike(change @ weights[:-1], terms @ np.abs(weights[:-1]))
            for name in (name for name, so in zip(self.values, hang) if so):
                self._since[name] = min(row, self._since.get(name, row))
        seed[self._linear.at.time] += weights[-1]
        return seed, by
