# SPDX-License-Identifier: LGPL-3.0-or-later
"""Derivatives of a contact's rows by the numbers of its law, by UFL.

Rows are integrated by the nodes, so that each point's depend on its own values alone: the
derivative in the direction that is 1 at all points holds those of all.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl

from ..base import compat
from ..base.constants import ROUND_OFF
from ..base.vectors import dot, orthogonal
from ..contact.contact import Contact


class ByConstant:
    """By a constant of the form."""

    def __init__(self, contact: Contact, constant: Any) -> None:
        fields = contact.equations.fields
        self._contact, self._constant = contact, constant
        self._field = contact.surface.scalar()
        form = ufl.replace(contact.equations.tangents.form, {constant: self._field})
        one = contact.surface.scalar()
        one.x.array[:] = 1.0
        derivative = ufl.algorithms.expand_derivatives(ufl.derivative(form, self._field, one))
        # what a law does not read has no form
        self._assemble = None if derivative.empty() else compat.VectorAssembler(derivative)
        self._order, self._shape = fields.dofs.T, (fields.surface.size, fields.components)

    def __call__(self) -> np.ndarray:
        """Of the rows of each point, (n, unknowns of a point), with the fields as they are."""
        if self._assemble is None:
            return np.zeros(self._shape)
        self._field.x.array[:] = float(self._constant.value)
        self._assemble.refresh_constants()
        rows = self._assemble()[self._order]
        d, idle = self._contact.normal.shape[1], undirected(self._contact)
        normal = self._contact.equations.fields.mean_normal()[idle]
        rows[idle, :d] = dot(rows[idle, :d], normal)[:, None] * normal
        rows[idle, d + 1 :] = 0.0
        return rows


def undirected(contact: Contact) -> np.ndarray:
    """Points without friction that slip in no direction but that of round-off: not at all, or back
    by a part of the way that they came, against which a small friction would do nothing, (n,)."""
    e, back = contact.equations, contact.equations.fields.back
    if e.size == e.tractions:
        return np.zeros(len(back), dtype=bool)
    tau = e.values[e.tractions :].reshape(-1, len(back))
    slip = orthogonal(contact.normal, contact.trial_jump)
    size = dot(back, back)
    share = np.clip(dot(slip, back) / np.where(size > 0, size, 1.0), 0.0, 1.0)
    left = np.linalg.norm(slip - share[:, None] * back, axis=1)
    noise = ROUND_OFF * np.linalg.norm(contact.trial_jump, axis=1)
    return np.asarray(~tau.any(axis=0) & (left <= noise))
