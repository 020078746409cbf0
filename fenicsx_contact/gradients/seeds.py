# SPDX-License-Identifier: LGPL-3.0-or-later
"""Functionals of a run, and what they put into its adjoint row by row."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ..base import checks
from ..output.history import History
from .bearing import OfContact
from .linearise import Linearisation
from .parameters import Parameter
from .quantities import Quantity

#: From the history of a run: a value, and its derivatives by the rows (rows,) of quantities, and of
#: ``"time"``, by their names.
Functional = Callable[[History], tuple[float, Mapping[str, np.ndarray]]]


def gradient(linear: Linearisation, quantity: Quantity, unknowns: int = 0) -> np.ndarray:
    """Of a quantity by the state, or by as many unknowns of the step that was linearised last."""
    result, (q, v) = np.zeros(unknowns or linear.size), quantity.gradient()
    result[linear.part("q", quantity.solid)] = q
    result[linear.part("v", quantity.solid)] = v
    if unknowns and isinstance(quantity, OfContact):
        points, pressures, forces = linear.bearing(quantity.contact)
        by_pressure, by_force = quantity.borne(points)
        result[pressures], result[forces] = -by_pressure, by_force.ravel()
    return result


def explicit(parameters: Mapping[str, Parameter], quantity: Quantity) -> np.ndarray:
    """Derivatives of a quantity by the parameters at a fixed state, (parameters,)."""
    return np.array([quantity.explicit(parameter) for parameter in parameters.values()])


class Seeds:
    """What functionals put into an adjoint: a probe of the run along which it goes back.

    Beside the functionals stand the quantities at the end of the run.

    Args:
        linear: linearises its steps.
        parameters, quantities, functionals: by name.
        history: of the run, with the quantities.

    Attributes:
        values: of quantities at the end and of functionals, (k of them).
        unknowns: of the step that was linearised last, 0 at the start of a run.
        found: row by row the derivatives of the k by the unknowns of its step, of the start by the
            state, and those by the parameters at a fixed state, (unknowns, k) and (parameters, k).

    Raises:
        InputError: two of one name, derivatives by what is no quantity.
    """

    def __init__(
        self,
        linear: Linearisation,
        parameters: Mapping[str, Parameter],
        quantities: Mapping[str, Quantity],
        functionals: Mapping[str, Functional],
        history: History,
    ) -> None:
        self._linear, self._parameters, self._quantities = linear, parameters, quantities
        end = np.eye(len(history))[-1]
        self.values = {name: float(history[name][-1]) for name in quantities}
        rows: list[Mapping[str, np.ndarray]] = [{name: end} for name in quantities]
        for name, functional in functionals.items():
            if name in self.values:
                raise checks.InputError(f"functionals: {name!r} is a quantity, too")
            self.values[name], weights = functional(history)
            for column in weights:
                if column not in quantities and column != "time":
                    raise checks.InputError(
                        f"functionals[{name!r}]: gives derivatives by {column!r}, no quantity"
                    )
            rows.append(weights)
        nothing = np.zeros(len(history))
        self._weights = {
            name: np.stack([each.get(name, nothing) for each in rows], axis=1)
            for name in (*quantities, "time")
        }

    def begin(self, row: int) -> None:
        """Begin at a row of the history."""
        self._row, self.unknowns = row, 0
        self.found: list[tuple[np.ndarray, np.ndarray]] = []

    def __call__(self) -> float:
        count, linear = len(self.values), self._linear
        seed = np.zeros((self.unknowns or linear.size, count))
        by = np.zeros((len(self._parameters), count))
        seed[linear.time] = self._weights["time"][self._row]
        for name, quantity in self._quantities.items():
            weights = self._weights[name][self._row]
            if weights.any():
                seed += np.outer(gradient(linear, quantity, self.unknowns), weights)
                by += np.outer(explicit(self._parameters, quantity), weights)
        self.found.append((seed, by))
        self._row += 1
        return 0.0
