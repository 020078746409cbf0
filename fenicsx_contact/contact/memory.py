# SPDX-License-Identifier: LGPL-3.0-or-later
"""What interface laws remember from step to step: named fields on the points of a surface.

A law says in UFL what a field becomes in a time; that happens when a step is accepted, and never
else, so steps that are tried and not taken leave no trace. A law that remembers nothing makes none.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from typing import Any, Protocol

import numpy as np

from ..base import checks, compat


class Points(Protocol):
    """What the memory asks of a surface."""

    @property
    def scalars(self) -> Any: ...
    @property
    def cell_nodes(self) -> np.ndarray: ...
    @property
    def size(self) -> int: ...
    def scalar(self) -> Any: ...


class Unknowns(Protocol):
    """What it asks of the equations of a surface: w point by point, then the multipliers."""

    values: np.ndarray

    def being(self, values: np.ndarray) -> AbstractContextManager[None]: ...


class Memory:
    """The remembered fields of one surface.

    Attributes:
        fields: in UFL, by name.
        values: of each field at the points, (n,), by name; they may be set between two steps.
        recess: how far the surface has worn back at the points, (n,) in m; 0.0 if it never does.
        receding: how fast it did in the last step, (n,) in m/s; 0.0 if it never does.
        begun, given: what each field is at the very start (None: numbers), and what it becomes when
            a step is accepted, in UFL, by name.
    """

    def __init__(self, surface: Points) -> None:
        self._surface = surface
        self.fields: dict[str, Any] = {}
        self.values: dict[str, np.ndarray] = {}
        self.recess: np.ndarray | float = 0.0
        self.receding: np.ndarray | float = 0.0
        self.begun: dict[str, Any] = {}
        self._starts: dict[str, np.ndarray] = {}
        self.given: dict[str, Any] = {}
        self._rules: dict[str, compat.PointExpression] = {}
        self._struck: set[str] = set()

    def field(self, name: str, start: np.ndarray | float, given: Any = None) -> Any:
        """A new field with these values, (n,) or one number, which were given in UFL; InputError if
        there is one of that name."""
        if name in self.values:
            raise checks.InputError(
                f"name = {name!r}: two laws of a contact remember something by that name; each "
                "field needs one of its own"
            )
        field = self._surface.scalar()
        self.fields[name], self.values[name] = field, field.x.array
        self.values[name][:] = start
        self.begun[name] = given
        self._starts[name] = self.values[name].copy()
        return field

    def rule(self, name: str, new: Any, struck: bool = False) -> None:
        """What a field becomes when a step is accepted, in UFL, or also when an impact is; that
        counts as a step of a second, of which its impulses are the forces."""
        self.given[name] = new
        if struck:
            self._struck.add(name)

    def wear(self, name: str) -> None:
        """The surface recedes by a field."""
        self.recess, self.receding = self.values[name], np.zeros(self._surface.size)

    def compile(self, read: Callable[[Any], Any]) -> None:
        """All rules, which in the form of the contact are ``read`` so."""
        for name, new in self.given.items():
            self._rules[name] = compat.PointExpression(read(new), self._surface.scalars)

    def advance(self, equations: Unknowns, jump: np.ndarray, dt: float) -> None:
        """A step of ``dt`` seconds is accepted, with these jumps (n, d) [m/s] at all points, also
        where there are no equations: all fields become what their rules say; in an impact those
        that it changes."""
        rules = {name: r for name, r in self._rules.items() if self.changes(name, dt)}
        if not rules:
            return
        with equations.being(np.concatenate([jump.ravel(), equations.values[jump.size :]])):
            new = {name: at_points(self._surface, rule) for name, rule in rules.items()}
        before = np.array(self.recess)
        for name, values in new.items():
            self.values[name][:] = values
        if np.ndim(self.recess) and dt:
            self.receding = (self.recess - before) / dt

    def changes(self, name: str, dt: float) -> bool:
        """Whether a field does in a step of ``dt`` seconds."""
        return bool(dt) or name in self._struck

    def fresh(self, name: str) -> bool:
        """Whether a field is what it was at the very start."""
        return np.array_equal(self.values[name], self._starts[name])

    def reset(self) -> None:
        """All fields as they were at the very start."""
        for name, start in self._starts.items():
            self.values[name][:] = start
        self.receding = 0.0 * self.receding

    def state(self) -> dict[str, np.ndarray]:
        """The arrays from which :meth:`restore` continues identically."""
        state = {f"memory.{name}": values.copy() for name, values in self.values.items()}
        return {**state, "receding": np.array(self.receding)} if np.ndim(self.recess) else state

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Take up a state that :meth:`state` gave."""
        for name, values in self.values.items():
            values[:] = state[f"memory.{name}"]
        if np.ndim(self.recess):
            self.receding = np.array(state["receding"])


def at_points(surface: Points, expression: compat.PointExpression) -> np.ndarray:
    """Values of an expression at the points of a surface, (n,)."""
    values = np.empty(surface.size)
    values[surface.cell_nodes.ravel()] = expression().ravel()
    return values
