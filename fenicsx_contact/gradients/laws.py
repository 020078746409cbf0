# SPDX-License-Identifier: LGPL-3.0-or-later
"""The laws of contacts that are differentiated."""

from __future__ import annotations

from ..base import checks
from ..base.expressions import is_expression
from ..base.quoted import quoted
from ..contact.contact import Contact
from ..theory.formulations import Gap, Velocity
from ..theory.friction import Coulomb, Tresca


def refuse_law(contact: Contact) -> None:
    """Refuse formulations and laws that are not differentiated."""
    name = f"gradients: contact {contact.name!r}"
    if type(contact.formulation) not in (Velocity, Gap):
        raise checks.InputError(
            f"{name} has the formulation {type(contact.formulation).__name__}; 'velocity' "
            "and 'gap' themselves are differentiated"
        )
    law = contact.friction_law
    if law is not None and type(law) not in (Coulomb, Tresca):
        raise checks.InputError(
            f"{name} has the law {type(law).__name__}; Coulomb and Tresca are differentiated"
        )
    number = getattr(law, "mu", getattr(law, "stress", 0.0))
    if not isinstance(number, float) and not is_expression(number):
        raise checks.InputError(
            f"{name} has a law of place or time: {quoted(number)}; those of a "
            "number are differentiated"
        )
