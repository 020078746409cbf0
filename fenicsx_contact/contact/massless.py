# SPDX-License-Identifier: LGPL-3.0-or-later
"""Friction on boundaries without mass."""

from __future__ import annotations

from ..theory.scheme import Scheme
from .contact import Contact


def undamped(contact: Contact, scheme: Scheme) -> str:
    """What a reader should know of friction on a boundary without mass by a scheme whose forces are
    means over the step, and that damps nothing: such a boundary swings from step to step for ever,
    between stick and slip; or nothing."""
    light = [solid.name for solid in contact.solids if solid.massless]
    if not (light and contact.friction_law and scheme.inertia) or scheme.position_rate > 0.5:
        return ""
    return (
        f"contact {contact.name!r} rubs on a boundary of {light[0]!r} without mass, which "
        f"{scheme.describe()} does not damp: it may stick and slip by turns, and lose some percent "
        "of its friction; ThetaScheme(0.55) and GeneralisedAlpha(0.8) keep it"
    )
