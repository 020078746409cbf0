# SPDX-License-Identifier: LGPL-3.0-or-later
"""The generalised-alpha scheme for nonsmooth dynamics.

Of second order in smooth motion; it damps what the mesh and the step do not resolve, as much as
asked for, and little else. (Q. Chen, V. Acary, G. Virlez, O. Brüls, "A nonsmooth generalized-alpha
scheme for flexible multibody systems with unilateral constraints", Int. J. Numer. Meth. Engng 96,
487-511, 2013; without contact: J. Chung, G. M. Hulbert, J. Appl. Mech. 60, 371-375, 1993.)

The forces F of a smooth motion go through the filter of the scheme, percussions W do not::

    (1 - alpha_m) a+ + alpha_m a- = (1 - alpha_f) F+/M + alpha_f F-/M
    v+ = v- + h ((1 - gamma) a- + gamma a+) + W
    u+ = u- + h v- + h² ((1/2 - beta) a- + beta a+) + h W/2

Solved for a+, the second row gives the mean force with what is carried, M a-. Eliminating a+ from
the third one leaves, with r = beta/gamma >= 1/2,

    u+ = u- + h ((1 - r) v- + r v+) + (1/2 - r) h (h a- + W)

where this file differs from the paper: it writes h A- for h a- + W, A being the acceleration by the
same filter with the percussions in it, A+ = ((v+ - v-)/h - (1 - gamma) A-)/gamma. Without contact
the two are the same. With it r h W enters the position at once, and (1/2 - r) h W in the steps that
follow, as the filter fades: in sum the paper's h W/2. In return u+ depends on v+ and on what is
known, in contact or not, and what rests stays: A fades to zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..base import checks
from .scheme import Points


@dataclass(frozen=True)
class GeneralisedAlpha:
    """The scheme, with the parameters of Chung and Hulbert; a :class:`~.scheme.Scheme`.

    Its memory has two rows: M a, the filtered force (N), and A, the filtered acceleration (m/s²).
    A begins with 0 and knows nothing of located impacts: each costs (r - 1/2) h² of an
    acceleration, once. What A differs from a by fades to |1 - 3 rho_inf|/(3 - rho_inf) in a step.

    Args:
        rho_inf: spectral radius at infinite frequency, in [0, 1]: the share of the highest
            frequencies that a step leaves. 1 damps nothing and is theta = 1/2, 0 all of them.

    Raises:
        InputError: rho_inf outside [0, 1].
    """

    rho_inf: float = 0.8
    inertia: ClassVar[float] = 1.0
    memory_rows: ClassVar[int] = 2
    force_weight: ClassVar[float] = 0.5  # percussions are not filtered: in the middle of the step
    growth: ClassVar[str] = ""
    bounds_work: ClassVar[bool] = False  # F is filtered: its works have no sign

    def __post_init__(self) -> None:
        checks.keep(self, "rho_inf", at_least=0, at_most=1)

    @property
    def alpha_m(self) -> float:
        """Weight of the old acceleration."""
        return (2 * self.rho_inf - 1) / (self.rho_inf + 1)

    @property
    def alpha_f(self) -> float:
        """Weight of the old force."""
        return self.rho_inf / (self.rho_inf + 1)

    @property
    def gamma(self) -> float:
        """That of second order."""
        return 0.5 + self.alpha_f - self.alpha_m

    @property
    def beta(self) -> float:
        """That of the largest damping at high frequencies."""
        return (self.gamma + 0.5) ** 2 / 4

    @property
    def position_rate(self) -> float:
        """r = beta/gamma."""
        return self.beta / self.gamma

    @property
    def linear_weights(self) -> tuple[float, float]:
        """Of F- and F+; the rest is carried."""
        total = self.gamma / (1 - self.alpha_m)
        return total * self.alpha_f, total * (1 - self.alpha_f)

    @property
    def force_points(self) -> Points:
        """At both ends."""
        before, after = self.linear_weights
        return [(0.0, before), (1.0, after)] if before else [(1.0, after)]

    @property
    def load_points(self) -> Points:
        """As internal forces."""
        return self.force_points

    @property
    def error_constant(self) -> float:
        """The filtered acceleration is that of h (alpha_f - alpha_m) later."""
        return self.beta + (self.alpha_f - self.alpha_m) / 2 - 1 / 6

    def increment(
        self,
        dt: float,
        v_old: np.ndarray,
        v_new: np.ndarray,
        memory: np.ndarray | None,
    ) -> np.ndarray:
        """u+ - u-, m."""
        r, known = self.position_rate, _kept(memory)
        return dt * ((1 - r) * v_old + r * v_new) + (0.5 - r) * dt**2 * known[1]

    def mean(self, v_old: np.ndarray, v_new: np.ndarray) -> np.ndarray:
        """Of the velocities at both ends."""
        return 0.5 * (v_old + v_new)

    def first(self, force: np.ndarray) -> np.ndarray:
        """Equilibrium of the momentum with the forces, and A = 0."""
        return np.stack([force, np.zeros_like(force)])

    def carried(self, memory: np.ndarray | None) -> np.ndarray:
        """What the weights leave to M a-."""
        return (1 - sum(self.linear_weights)) * _kept(memory)[0]

    def remember(
        self,
        dt: float,
        v_old: np.ndarray,
        v_new: np.ndarray,
        force: np.ndarray,
        memory: np.ndarray | None,
    ) -> np.ndarray:
        """Both rows by the filter: mean = (1 - gamma) old + gamma new."""
        mean = np.stack([force, (v_new - v_old) / dt])
        return (mean - (1 - self.gamma) * _kept(memory)) / self.gamma

    def describe(self) -> str:
        """Its name and parameter."""
        return f"generalised alpha, rho_inf = {self.rho_inf!r}"


def _kept(memory: np.ndarray | None) -> np.ndarray:
    if memory is None:
        raise checks.InputError(
            "GeneralisedAlpha: a solid keeps no memory, which this scheme needs; it recalls one in "
            "predict, and remembers in accept"
        )
    return memory
