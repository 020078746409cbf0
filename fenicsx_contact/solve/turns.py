# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plain corrections of the full Newton method and contact settled on frozen geometry, by turns.

Plain corrections converge quadratically, from near. Where they gain no more, or before the first
one where nothing but contact holds a solid, the contact is settled: by the paper's fixed point,
which converges from farther away. They follow again as soon as the error is half of that at which
they failed, or as settling gains no more itself.
"""

from __future__ import annotations

import numpy as np

from .multipliers import Patience


class Turns:
    """What comes next, from the errors.

    Args:
        settles: whether the first round is to settle.
    """

    def __init__(self, settles: bool) -> None:
        self._settles, self._failed, self._last = settles, np.inf, np.inf
        self._first, self._patience = True, Patience(1.0, gain=1.0)

    def settles(self, error: float, spent: bool = False) -> bool:
        """Whether to settle now, at this relative error; the first tells little. It is to be where
        the iterations of Newton's method are ``spent``."""
        if spent:
            self._settles, self._failed = True, self._patience.best
        elif self._first:
            self._first = False
        elif self._settles:
            self._settles = error < self._last and 2 * error > self._failed
            self._patience = Patience(error, gain=1.0)
        else:
            best = self._patience.best
            if not best <= error < self._last:  # on its way down
                self._patience.see(error)
            if not self._patience.lasts:
                self._settles, self._failed = True, self._patience.best
        self._last = error
        return self._settles
