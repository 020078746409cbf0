# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a law does to the points of a contact by itself, beside its multipliers: glue draws them."""

from __future__ import annotations

import numpy as np

from .contact import Contact
from .equations import SurfaceEquations


def applies(contact: Contact) -> bool:
    """Whether it may do anything: not springs, nor laws whose forces are the same for any areas."""
    known = vars(type(contact.formulation)).get("reads_areas", True)
    return bool(known) and contact.equations.tractions > contact.equations.jumps


def applied(equations: SurfaceEquations) -> np.ndarray:
    """These forces, (n, d) in N: without multipliers, what in the rows of the jumps does not go
    with rho. All else goes with it, by powers of two to the last digit."""
    e, fields = equations, equations.fields
    values, rows = e.values, []
    values[e.jumps :] = 0.0
    rho = [(each.x.array, each.x.array.copy()) for each in (fields.rho_n, fields.rho_t)]
    faint = np.finfo(float).eps ** 4
    with e.being(values):
        for share in (faint, 2 * faint):
            for array, full in rho:
                array[:] = share * full
            rows.append(e.residual()[: e.jumps])
    for array, full in rho:
        array[:] = full
    return (rows[1] - 2 * rows[0]).reshape(-1, fields.surface.dim)
