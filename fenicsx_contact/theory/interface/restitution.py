# SPDX-License-Identifier: LGPL-3.0-or-later
"""Restitution: what is struck rebounds, by Newton's law in Moreau's form."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
import ufl

from ...base import checks
from ..formulations import Velocity
from ..step_data import StepData
from ..weak_form import ContactFields


@dataclass(frozen=True)
class Restitution(Velocity):
    """The velocity law, whose percussions obey ``w_n^+ + e w_n^- <= 0, lam <= 0``, complementary.

    A percussion strikes points that start a step faster than the law allows, first those that would
    arrive first; the jump before it is that with which the step starts. Between percussions the
    law is VELOCITY's, so what loads bring to rest stays there. By uniform steps what strikes turns
    round at the start of the step, by located impacts (``locate_impacts=True``) where it touches.
    Bodies that touch when one of a row is struck are struck together, as Moreau's law has it: of
    five equal ones that begin 1 um apart the last leaves with all of the speed, of five that touch
    the first with -0.6 and the others with 0.4 of it; energy is kept both times.

    e is a property of rigid bodies; a deformable one rebounds by its own waves. With friction and
    e > 0 in oblique impacts of bodies that turn Newton's law can give energy (Kane's paradox);
    such a step has no certificate and is refused.

    I. Newton, Principia, 1687; J.J. Moreau, in: Nonsmooth Mechanics and Applications, CISM 302,
    1988; on energy: T.R. Kane, Stanford Mechanics Alumni Club Newsletter, 1983.

    Args:
        coefficient: e in [0, 1]; 0 is VELOCITY.
        drift_correction: as for VELOCITY.

    Raises:
        InputError: e outside of [0, 1].
    """

    coefficient: float = 0.0
    drift_correction: float = field(default=0.0, kw_only=True)  # else Restitution(0.7) were that
    name: ClassVar[str] = "velocity with restitution"
    reads_areas: ClassVar[bool] = False

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.keep(self, "coefficient", at_least=0, at_most=1)

    @property
    def rebounds(self) -> bool:
        """What is struck leaves again."""
        return self.coefficient > 0

    def allowed(self, k: ContactFields) -> Any:
        """What VELOCITY allows, or in a percussion of what is struck the rebound."""
        limit = super().allowed(k)
        if not self.coefficient:
            return limit
        struck = ufl.And(ufl.lt(k.loaded, 0.5), ufl.gt(k.start_jump_n, limit))
        e = k.field("restitution", self.coefficient)
        return ufl.conditional(struck, -e * k.start_jump_n, limit)

    def limit(self, data: StepData) -> np.ndarray:
        """The same in numpy."""
        limit = super().limit(data)
        if not self.coefficient or data.loaded:
            return limit
        rebound = -self.coefficient * data.start_jump_n
        return np.where(data.start_jump_n > limit, rebound, limit)
