# SPDX-License-Identifier: LGPL-3.0-or-later
"""The trial state before a correction, to go back to."""

from __future__ import annotations

from ..theory.scheme import Step
from .problem import Assembly


class Before:
    """What velocities solids had, and unknowns contacts."""

    def __init__(self, problem: Assembly) -> None:
        self._solids = [(solid, solid.trial_velocity.copy()) for solid in problem.solids]
        self._contacts = [(contact, contact.equations.values) for contact in problem.contacts]

    def halve(self, step: Step) -> None:
        """Go back half of the way."""
        for solid, old in self._solids:
            solid.go(0.5 * (old + solid.trial_velocity), step)
        for contact, values in self._contacts:
            contact.equations.values = 0.5 * (values + contact.equations.values)
            contact.follow()

    def restore(self, step: Step) -> None:
        """Go back all of it."""
        for solid, old in self._solids:
            solid.go(old.copy(), step)
        for contact, values in self._contacts:
            contact.equations.values = values
            contact.follow()
