# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bounds of friction below 0, by which friction would push: refused where they are seen before the
first step, named where a step ends with one."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from ..base import checks
from ..base.quoted import quoted


class Solved(Protocol):
    """What is asked of a contact."""

    @property
    def name(self) -> str: ...
    @property
    def equations(self) -> Any: ...
    @property
    def surface(self) -> Any: ...


def refuse_negative(equations: Any, law: Any) -> None:
    """Refuse a law whose bound is negative at the start, where all points bear.

    Raises:
        InputError: with where it is.
    """
    if law is None:
        return
    gap, pressed = equations.gap.copy(), np.zeros(equations.size)
    equations.gap[:] = 1.0  # m, of springs
    pressed[equations.jumps : equations.tractions] = -1.0  # Pa
    with equations.being(pressed):
        at = np.flatnonzero(equations.statuses() < 0)
    equations.gap[:] = gap
    if len(at):
        where = equations.fields.surface.points[at[0]].tolist()
        raise checks.InputError(
            f"friction = {quoted(law)}: its bound must be >= 0 under any pressure; at {where} it "
            "is negative"
        )


def statuses(contact: Solved) -> np.ndarray:
    """0 open, 1 stick, 2 slip of each point of a contact, (n,), in a step that is solved.

    Raises:
        StepFailed: a bound of friction is negative.
    """
    found = contact.equations.statuses()
    if (found < 0).any():
        bound = f"the bound of friction of contact {contact.name!r}"
        strange = f"at {contact.surface.points[int(found.argmin())].tolist()} it is negative"
        raise checks.StepFailed(f"{bound} must be finite and >= 0; {strange}")
    return np.asarray(found)
