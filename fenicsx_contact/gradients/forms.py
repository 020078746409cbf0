# SPDX-License-Identifier: LGPL-3.0-or-later
"""Derivatives of a contact's rows by what they read besides their unknowns, by UFL.

Rows are integrated by the nodes, so that each point's depend on its own values alone: the
derivative in the direction that is 1 at all points holds those of all.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl

from ..base import compat
from ..contact.contact import Contact


class _Along:
    def __init__(self, contact: Contact, form: Any, field: Any, one: Any = None) -> None:
        fields = contact.equations.fields
        if one is None:
            one = fields.surface.scalar()
            one.x.array[:] = 1.0
        derivative = ufl.algorithms.expand_derivatives(ufl.derivative(form, field, one))
        # what a law does not read has no form
        self._assemble = None if derivative.empty() else compat.VectorAssembler(derivative)
        self._order, self._shape = fields.dofs.T, (fields.surface.size, fields.components)

    def __call__(self) -> np.ndarray:
        """Of the rows of each point, (n, unknowns of a point), with the fields as they are."""
        if self._assemble is None:
            return np.zeros(self._shape)
        self._assemble.refresh_constants()
        return self._assemble()[self._order]


class ByField(_Along):
    """By a scalar field, point by point."""

    def __init__(self, contact: Contact, field: Any) -> None:
        super().__init__(contact, contact.equations.tangents.form, field)


class ByVector:
    """By a vector field, (n, unknowns of a point, d)."""

    def __init__(self, contact: Contact, field: Any) -> None:
        self._d, self._one = contact.surface.dim, contact.surface.vector()
        form = contact.equations.tangents.form
        self._along = _Along(contact, form, field, self._one)

    def __call__(self) -> np.ndarray:
        result, one = [], self._one.x.array.reshape(-1, self._d)
        for axis in range(self._d):
            one[:] = np.arange(self._d) == axis
            result.append(self._along())
        return np.stack(result, axis=2)


class ByConstant(_Along):
    """By a constant of the form."""

    def __init__(self, contact: Contact, constant: Any) -> None:
        self._constant, self._field = constant, contact.surface.scalar()
        form = ufl.replace(contact.equations.tangents.form, {constant: self._field})
        super().__init__(contact, form, self._field)

    def __call__(self) -> np.ndarray:
        self._field.x.array[:] = float(self._constant.value)
        return super().__call__()
