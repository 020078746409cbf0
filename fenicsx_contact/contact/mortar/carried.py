# SPDX-License-Identifier: LGPL-3.0-or-later
"""Jumps across a gap that is not closed, as springs and meshes with a clearance have it.

The two points of a pair are a gap d_n n apart. Where both solids turn together their velocities
differ, by ``d_n dn/dt``, though nothing slips. What slips is the rest,

    w - d_n N v,        dn/dt = N v,

and its transpose gives friction across a gap the moment that balances it: ``N' d_n`` turns the
facets by what the arm between the two forces is. Normal jumps stay as they are, for n . N = 0.
"""

from __future__ import annotations

import numpy as np

from .matrices import by_point
from .mortar import Pairing
from .rates import Rates


class Carried(Pairing):
    """A pairing whose jumps are those of what turns with it.

    Attributes:
        rates: in its present places.
    """

    def _operate(self) -> None:
        super()._operate()
        self.rates = Rates(self)
        apart = np.where(self.paired, self.gap, 0.0)[:, None, None] * np.eye(self.slave.dim)
        self.operator = self.operator - by_point(apart, self.rates.normal)
