# SPDX-License-Identifier: LGPL-3.0-or-later
"""Jumps across gaps that are not closed: of springs, and of meshes with a clearance between them.

**Normal ones** are the rates of the gaps, all of them: besides what rises along the normals, means
change because their weights move with the surfaces. The forces, by the transpose, are then the
gradients of what springs store in these gaps: they give back what they took.

**Tangential ones** are what slips. The two points of a pair are a gap d_n n apart; where both
solids turn together their velocities differ by ``d_n dn/dt``, though nothing slips, so

    w - d_n N v,        dn/dt = N v.

Its transpose gives friction across a gap the moment that balances it: ``N' d_n`` turns the facets
by what the arm between the two forces is.
"""

from __future__ import annotations

import numpy as np

from .matrices import by_point
from .mortar import Pairing
from .rates import Rates


class Carried(Pairing):
    """A pairing whose jumps are those of gaps, and of what turns with them.

    Attributes:
        rates: in its present places.
    """

    carries = True

    def _operate(self) -> None:
        super()._operate()
        self.rates = Rates(self)
        apart = np.where(self.paired, self.gap + self.recess, 0.0)  # of the nodes
        apart = apart[:, None, None] * np.eye(self.slave.dim)
        moved = self.at_normals(self.rates.gap - self.rises)
        self.operator = self.operator + moved - by_point(apart, self.rates.normal)
