# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a contact remembers from step to step, linearised: rows of its points beside those of their
multipliers, which say what becomes of it.

Laws say in UFL what their fields become; by what tangential springs are stretched follows from
their tractions.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
import ufl
from dolfinx import fem

from ..base import checks
from ..base.vectors import slices
from ..contact.contact import Contact
from ..contact.tangent import SurfaceTangent
from ..theory.scheme import Step
from .forms import ByConstant


class RememberedRows(Protocol):
    """Numbers that each point of a contact remembers.

    Attributes:
        count: how many.
    """

    count: int

    def take_up(self, step: Step) -> None:
        """The step has been solved."""

    def own(self) -> np.ndarray:
        """Derivatives of what they become by the unknowns of the point, (n, count, unknowns)."""

    def by(self, name: str) -> np.ndarray | float:
        """And by what the contact reads, (n, count, its size), 0 if they do not."""

    def by_constant(self, constant: Any) -> np.ndarray | float:
        """And by a number of the law, (n, count)."""

    def begun(self, constant: Any) -> np.ndarray | float:
        """Derivative by a number of the law of what they are at the very start, (n, count); 0
        where they are no longer."""


def columns(fields: Mapping[str, Any]) -> dict[str, slice]:
    """Where the components of fields stand one after another."""
    return dict(zip(fields, slices(int(np.prod(field.ufl_shape)) for field in fields.values())))


def moving(contact: Contact) -> list[str]:
    """What the law of a contact remembers that changes with the motion, or with its numbers."""
    k, memory = contact.equations.fields, contact.memory
    moves = [k.unknowns, k.gap, k.normal, k.start_jump_n, k.start_slip, *k.numbers.values()]
    moves += [k.place] if k.located else []
    found: list[str] = []
    while more := [
        name
        for name, rule in memory.given.items()
        if name not in found
        and any(_depends(each, field) for each in (rule, memory.begun[name]) for field in moves)
    ]:
        found += more
        moves = [memory.fields[name] for name in more]
    return found


def _depends(expression: Any, field: Any) -> bool:
    """Whether an expression has a derivative by a field that is not zero everywhere, or reads a
    constant."""
    if expression is None:
        return False
    if isinstance(field, fem.Constant):
        terminals = ufl.corealg.traversal.traverse_unique_terminals(ufl.as_ufl(expression))
        return any(each is field for each in terminals)
    form = ufl.derivative(expression * ufl.dx(field.function_space.mesh), field)
    return not ufl.algorithms.expand_derivatives(form).empty()


class Fields:
    """Fields of a law that change with the motion; see :class:`RememberedRows`.

    Args:
        contact: the contact.
        names: of the fields.
        reads: all that the contact reads, these included, by name.
    """

    def __init__(self, contact: Contact, names: list[str], reads: Mapping[str, Any]) -> None:
        k, e = contact.equations.fields, contact.equations
        if len(names) > k.components:
            raise checks.InputError(
                f"gradients: contact {contact.name!r} remembers {len(names)} fields that change "
                f"with the motion; {k.components} at most are differentiated"
            )
        self._contact, self._names, self.count = contact, names, len(names)
        self._form = self._rows(contact.memory.given)
        self._tangent = SurfaceTangent(k, self._form, e.order)
        self._by = self._tangent.by([*reads.values()])
        self._columns = columns(reads)
        self._constants: dict[Any, ByConstant] = {}

    def _rows(self, given: Mapping[str, Any]) -> ufl.Form:
        """What is said of them, as rows of the unknowns of a point."""
        k = self._contact.equations.fields
        tests = ufl.split(ufl.TestFunction(k.unknowns.function_space))
        said = [0.0 if given[name] is None else given[name] for name in self._names]
        rules = [k.read(ufl.as_ufl(each)) for each in said]
        return sum(rule * test * k.surface.dx for rule, test in zip(rules, tests))

    def take_up(self, step: Step) -> None:
        contact, e = self._contact, self._contact.equations
        self._stays = np.array([not contact.memory.changes(n, step.dt) for n in self._names])
        jump = contact.candidates.told(contact.trial_jump, step)
        self._values = np.concatenate([jump.ravel(), e.values[jump.size :]])
        with e.being(self._values):
            for each in (self._tangent, self._by):
                each.refresh_constants()
            self._own = self._share(self._tangent.blocks())
            self._read = self._share(self._by())

    def _share(self, rows: np.ndarray) -> np.ndarray:
        """Rows of points as they are before they are integrated, none of what stays."""
        area = self._contact.surface.nodal_area
        result = rows[:, : self.count] / area.reshape(-1, *[1] * (rows.ndim - 1))
        result[:, self._stays] = 0.0
        return result

    def own(self) -> np.ndarray:
        return self._own

    def by(self, name: str) -> np.ndarray | float:
        result = self._read[:, :, self._columns[name]].copy()
        if name in self._names and self._stays[at := self._names.index(name)]:
            result[:, at] = 1.0
        return result

    def by_constant(self, constant: Any) -> np.ndarray | float:
        if constant not in self._constants:
            fields = self._contact.equations.fields
            self._constants[constant] = ByConstant(fields, self._form, constant)
        with self._contact.equations.being(self._values):
            return self._share(self._constants[constant]())

    def begun(self, constant: Any) -> np.ndarray | float:
        memory, k = self._contact.memory, self._contact.equations.fields
        rows = ByConstant(k, self._rows(memory.begun), constant)()[:, : self.count]
        fresh = [memory.fresh(name) for name in self._names]
        return rows * fresh / self._contact.surface.nodal_area[:, None]


class Stretch:
    """The stretch of tangential springs in the plane, along the tangent, as
    :class:`RememberedRows`.

    Of what sticks it grows with the slip, of which the traction tells the share that the scheme
    takes; of what slips it is that of the traction.
    """

    count = 1

    def __init__(self, contact: Contact) -> None:
        self._contact = contact
        numbers = contact.equations.fields.numbers
        self._stiff = numbers.get("tangential_stiffness", numbers.get("stiffness"))
        self._stiffness = contact.formulation.stiffness_t  # type: ignore[attr-defined]

    def take_up(self, step: Step) -> None:
        e = self._contact.equations
        sticks = e.statuses() == 1
        self._share = np.where(sticks, 1 / (step.scheme.force_weight or 1.0), 1.0)
        self._tau = e.values[e.tractions :]

    def own(self) -> np.ndarray:
        k = self._contact.equations.fields
        result = np.zeros((len(self._share), 1, k.components))
        result[:, 0, -1] = self._share / self._stiffness
        return result

    def by(self, name: str) -> np.ndarray | float:
        if name != "stretch":
            return 0.0
        sticks = self._contact.equations.statuses() == 1
        return np.where(sticks, 1 - self._share, 0.0)[:, None, None]

    def by_constant(self, constant: Any) -> np.ndarray | float:
        if constant is not self._stiff:
            return 0.0
        return (-self._share * self._tau / self._stiffness**2)[:, None]

    def begun(self, constant: Any) -> np.ndarray | float:
        return 0.0
