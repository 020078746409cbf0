# SPDX-License-Identifier: LGPL-3.0-or-later
"""Adhesion: what touches holds against a pull, up to a traction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import ufl

from ...base import checks
from ...base.quoted import quoted
from ..formulations import Formulation, formulation, only_pushes
from ..parameter import Parameter, keep_parameter, told
from ..weak_form import ContactFields


@dataclass(frozen=True)
class Adhesive:
    """Any law with multipliers, its pressure shifted: the contact bears ``lam + s``, lam <= 0.

    What touches at the start of a step is drawn by s throughout it; so a pull up to s leaves it
    closed, and a larger one opens it. What is open is not drawn, and what touches again is. In the
    step in which it opens s acts to its end. Each step has the one solution that its law has.
    Coulomb's bound is ``mu |lam|`` of the shifted pressure: what adheres rubs, also if nothing
    presses it. An impact takes no time, and s holds nothing in it.

    B.V. Derjaguin, V.M. Muller, Yu.P. Toporov, J. Colloid Interface Sci. 53, 314-326, 1975, with a
    range that tends to zero.

    Args:
        stress: s, Pa (N at points), >= 0; it may vary, see
            :data:`~fenicsx_contact.theory.parameter.Parameter`.
        law: a formulation with multipliers, or its name.

    Raises:
        InputError: s < 0, a law of springs.
    """

    stress: Parameter
    law: Any = "velocity"

    def __post_init__(self) -> None:
        keep_parameter(self, "stress")
        if not formulation(self.law).multipliers:
            raise checks.InputError(
                f"law = {quoted(self.law)}: must be a formulation with multipliers"
            )

    @property
    def _law(self) -> Formulation:
        return formulation(self.law)

    @property
    def name(self) -> str:
        """For messages."""
        return f"{self._law.name}, adhesive up to {told(self.stress)}"

    @property
    def pushes(self) -> bool:
        """As the law does, beside the traction of what touches."""
        return only_pushes(self._law)

    def __getattr__(self, name: str) -> Any:
        """All else as the law has it."""
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self._law, name)

    def form(self, k: ContactFields) -> tuple[ufl.Form, Any]:
        """That of the law, and the traction of what touches."""
        form, status = self._law.form(k)
        drawn = k.field("adhesive stress", self.stress) * k.touched
        return form - k.integral(drawn * k.test_jump_n), status
