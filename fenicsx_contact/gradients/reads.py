# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the rows of a contact read of a step, and their derivatives by that.

Laws are UFL, and so are these derivatives, whatever the law; by what it does not read they are
zero. The rows of what a contact remembers (:mod:`~.remembered`) stand behind those of its unknowns.
"""

from __future__ import annotations

from copy import copy
from typing import Any, NamedTuple

import numpy as np

from ..contact.contact import Contact
from ..theory.scheme import Step
from .forms import ByConstant, directed
from .remembered import Fields, RememberedRows, Stretch, columns, moving


class Weights(NamedTuple):
    """Derivatives of the rows of points, (k, rows, d or 1).

    Attributes:
        jump: by the jump at the end, and ``start``, ``slip``: by its normal component at the start,
            and by what friction reads of it.
        normal, old_normal: by the normals at the end, and where they turn at the start.
        gap, end: by the gaps at the start and at the end.
        place, old_place: by the places at the end and at the start, of a law that reads them.
        old: by what is remembered at the start, (k, rows, its numbers).
    """

    jump: np.ndarray
    start: np.ndarray
    slip: np.ndarray
    normal: np.ndarray
    old_normal: np.ndarray
    gap: np.ndarray
    end: np.ndarray
    place: np.ndarray
    old_place: np.ndarray
    old: np.ndarray


class Reads:
    """Derivatives of the rows of a contact, point by point.

    Args:
        contact: the contact.

    Attributes:
        remembered, names: how many numbers each point remembers, and what they are called.
        own: derivatives by the unknowns of the point, (n, rows, unknowns).
    """

    def __init__(self, contact: Contact) -> None:
        self._contact, k = contact, contact.equations.fields
        names = ["gap", "normal", "start_jump_n", "start_slip"]
        names += ["start_normal"] * (k.start_normal is not None) + ["place"] * k.located
        names += ["start_gap"] * (k.multiplier is None)
        stretches = k.multiplier is None and k.friction is not None
        fields = {name: getattr(k, name) for name in names + ["elongation"] * stretches}
        self.names = moving(contact)
        fields |= {name: contact.memory.fields[name] for name in self.names}
        self._by, self._columns = contact.equations.tangents.by([*fields.values()]), columns(fields)
        self._parts: list[RememberedRows] = []
        if self.names:
            self._parts.append(Fields(contact, self.names, fields))
        if stretches:
            self._parts.append(Stretch(contact))
            self.names.append("stretch")
        self.remembered = sum(part.count for part in self._parts)
        self._constants: dict[Any, ByConstant] = {}

    def another(self) -> Reads:
        """The same, which may take up something else."""
        result = copy(self)
        result._parts = [copy(part) for part in self._parts]
        return result

    def take_up(self, step: Step) -> None:
        """Those of the step that has been solved."""
        for part in self._parts:
            part.take_up(step)
        e = self._contact.equations
        own, idle = e.tangents.blocks(frozen=True), np.ones(len(self._contact.normal), dtype=bool)
        idle[e.candidates] = False
        self.own = np.concatenate([own, *(part.own() for part in self._parts)], axis=1)
        self.own[idle, own.shape[1] :] = 0.0  # where nothing acts
        self._by.refresh_constants()
        every, n = self._by(), len(own)
        self._values: dict[str, np.ndarray] = {}
        for name, at in self._columns.items():
            size = at.stop - at.start
            more = [np.zeros((n, part.count, size)) + part.by(name) for part in self._parts]
            self._values[name] = np.concatenate([every[:, :, at], *more], axis=1)
        if "stretch" in self.names:
            self._stretch(step)

    def _stretch(self, step: Step) -> None:
        """Of springs in the plane, which read a stretch s and the way w- r of the start along the
        tangents then, laid along those at the end: ``(s + r w- . t-) t``."""
        contact, k = self._contact, self._contact.equations.fields
        (tangent,), (before,) = (k.frame(n)[1] for n in (contact.normal, contact.start_normal))
        by = self._values.pop("elongation")
        turn = np.array([[0.0, -1.0], [1.0, 0.0]])  # t = turn n
        length = (k.elongation.x.array.reshape(tangent.shape) * tangent).sum(axis=1)
        self._values["normal"] += length[:, None, None] * (by @ turn)
        along = by @ tangent[:, :, None]
        more = [np.zeros((len(by), part.count, 1)) + part.by("stretch") for part in self._parts]
        at = by.shape[1] - self.remembered
        stretch = along.copy()
        stretch[:, at:] += np.concatenate(more, axis=1)
        self._values["stretch"] = stretch
        rest = step.scheme.force_weight * (step.dt - step.gap_rate)
        self._values["start_jump"] = rest * along * before[:, None]
        self._values["spring_normal"] = rest * along * (contact.jump @ turn)[:, None]

    def at(self, points: np.ndarray, name: str, size: int) -> np.ndarray:
        """By a field, of some points, (k, rows, size); 0 if it is not read."""
        if name not in self._values:
            return np.zeros((len(points), self.own.shape[1], size))
        return self._values[name][points]

    def old(self, points: np.ndarray, gap: np.ndarray) -> np.ndarray:
        """By what is remembered at the start, (k, rows, numbers), where rows have derivatives by
        the gap (k, rows, 1): from that of the solid a surface has worn back."""
        every = [np.zeros((*gap.shape[:2], 0)), *(self.at(points, n, 1) for n in self.names)]
        memory = self._contact.memory
        for i, name in enumerate(self.names):
            if memory.values.get(name) is memory.recess:
                every[1 + i] = every[1 + i] - gap
        return np.concatenate(every, axis=2)

    def by_constant(self, constant: Any) -> np.ndarray:
        """By a number of the law, (n, rows)."""
        contact = self._contact
        if constant not in self._constants:
            form = contact.equations.tangents.form
            self._constants[constant] = ByConstant(contact.equations.fields, form, constant)
        rows, n = directed(contact, self._constants[constant]()), len(contact.normal)
        more = [np.zeros((n, part.count)) + part.by_constant(constant) for part in self._parts]
        return np.concatenate([rows, *more], axis=1)

    def begun(self, constant: Any) -> np.ndarray:
        """Derivative of what is remembered at the start of the run by one, (n, numbers)."""
        n = len(self._contact.normal)
        every = [np.zeros((n, part.count)) + part.begun(constant) for part in self._parts]
        return np.concatenate(every, axis=1)
