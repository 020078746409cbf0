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
from ..contact.contact import Contact


class ByConstant:
    """By a constant of the form."""

    def __init__(self, contact: Contact, constant: Any) -> None:
        fields = contact.equations.fields
        self._constant, self._field = constant, contact.surface.scalar()
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
        return self._assemble()[self._order]
