# SPDX-License-Identifier: LGPL-3.0-or-later
"""Derivatives of the rows of a contact's points by the numbers of its law, by UFL.

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
from ..contact.surface_fields import SurfaceFields


class ByConstant:
    """By a constant of a form.

    Args:
        k: the fields of the form.
        form: which is integrated by the nodes.
        constant: of it.
    """

    def __init__(self, k: SurfaceFields, form: ufl.Form, constant: Any) -> None:
        self._constant = constant
        self._field, one = k.surface.scalar(), k.surface.scalar()
        one.x.array[:] = 1.0
        form = ufl.replace(form, {constant: self._field})
        derivative = ufl.algorithms.expand_derivatives(ufl.derivative(form, self._field, one))
        # what a law does not read has no form
        self._assemble = None if derivative.empty() else compat.VectorAssembler(derivative)
        self._order, self._shape = k.dofs.T, (k.surface.size, k.components)

    def __call__(self) -> np.ndarray:
        """Of the rows of each point, (n, unknowns of a point), with the fields as they are."""
        if self._assemble is None:
            return np.zeros(self._shape)
        self._field.x.array[:] = float(self._constant.value)
        self._assemble.refresh_constants()
        return self._assemble()[self._order]


def directed(contact: Contact, rows: np.ndarray) -> np.ndarray:
    """Derivatives of the rows of each point by a number, (n, unknowns of a point), without friction
    where it has no direction."""
    d, k, idle = contact.normal.shape[1], contact.equations.fields, undirected(contact)
    normal = k.mean_normal()[idle]
    rows[idle, :d] = dot(rows[idle, :d], normal)[:, None] * normal
    rows[idle, d + int(k.multiplier is not None) :] = 0.0
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
