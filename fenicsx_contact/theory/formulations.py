# SPDX-License-Identifier: LGPL-3.0-or-later
"""The four formulations of contact that the paper compares: VELOCITY, GAP, LAGRANGE, DISCRETE.

Each is a small frozen object with only its own parameters. It gives the contact terms of the weak
form (7) on the contact surface, and the rule by which a point is a candidate in a step. Nothing
here knows a solid or a solver.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import ufl

from ..base import checks
from ..contact.surface import SurfaceFields
from .laws import (
    augmented_multiplier,
    augmented_semi_multiplier,
    ball_projection,
    contact_status,
    friction_status,
    indicator,
    slipping,
)


def weak_form(k: SurfaceFields, approach: Any, Su: Any) -> tuple[ufl.Form, Any]:
    """The contact terms of (7): jump, multiplier and semi-multiplier rows.

    ``approach`` is w_n for the velocity law and the gap over theta dt for the displacement law.
    The last row has the sign that makes the stick tangent symmetric (the printed sign makes it
    antisymmetric), and its second term the dimension of the first one (the printed one has not).
    Its weight mu |lam|/rho_t is that of the last iterate: it only scales an equation, and its
    derivative would make the rows of a hyperstatic contact contradict each other.

    Returns:
        The form, and the status of each point as an expression: 0 open, 1 stick, 2 slip.
    """
    lam = k.multiplier
    g_n = augmented_multiplier(lam, k.rho_n, approach)
    S = contact_status(Su, g_n)

    form = -k.integral(S * g_n * k.test_jump_n)
    form += -1 / k.rho_n * k.integral((lam - S * g_n) * k.test_multiplier)
    if not k.has_friction:
        return form, S

    mu, Lam = k.friction, k.semi_multiplier
    g_t = augmented_semi_multiplier(Lam, k.rho_t, k.jump_t)
    P = ball_projection(g_t)
    S = friction_status(S, lam)
    weight = mu * k.bearing / k.rho_t
    scale = mu * k.pressure_scale / k.rho_t

    form += -k.integral(mu * S * lam * ufl.dot(P, k.test_jump_t))
    form += -k.integral(S * weight * ufl.dot(Lam - P, k.test_semi_multiplier))
    form += -k.integral(scale * (1 - S) * ufl.dot(Lam, k.test_semi_multiplier))
    return form, contact_status(Su, g_n) + S * slipping(g_t)


def _spring_form(k: SurfaceFields, spring: Discrete) -> tuple[ufl.Form, Any]:
    """Springs in compression only, with dashpots, and elastic-plastic springs for friction."""
    penetration = k.gap + k.gap_rate * k.jump_n
    push = spring.stiffness * penetration + spring.damping * k.jump_n
    lam = -indicator(-penetration) * ufl.max_value(push, 0.0)
    form = -k.integral(lam * k.test_jump_n)
    status = indicator(-penetration)
    if k.has_friction:
        # elongation of the tangential spring since it was last at rest, and its radial return
        stretch = k.tangential(k.elongation) + k.gap_rate * k.jump_t
        force = spring.stiffness_t * stretch
        size = ufl.dot(force, force)
        limit = k.friction * abs(lam)
        tiny = 1e-24 * (spring.stiffness_t * k.length) ** 2
        cone = limit / ufl.sqrt(ufl.max_value(ufl.max_value(limit**2, size), tiny))
        form += k.integral(cone * ufl.dot(force, k.test_jump_t))
        status = status + status * ufl.conditional(ufl.gt(size, limit**2), 1.0, 0.0)
    return form, status


@dataclass(frozen=True)
class Velocity:
    """VELOCITY: the paper's continuous formulation, at the level of velocities (1)-(7).

    A point is a candidate (Su = 1) when the explicit prediction of its gap at the end of the step
    is closed; Su stays frozen within the step (read at the end of the step it has no fixed point).

    Args:
        drift_correction: kappa in [0, 1]; the law asks ``w_n <= -kappa d_n/dt`` of a candidate, so
            that the drift of a velocity law, into the obstacle or off it, decays instead of
            staying.
    """

    drift_correction: float = 0.0
    name: ClassVar[str] = "velocity"
    multipliers: ClassVar[bool] = True
    points: ClassVar[None] = None

    def __post_init__(self) -> None:
        checks.number("drift_correction", self.drift_correction, at_least=0, at_most=1)

    def form(self, k: SurfaceFields) -> tuple[ufl.Form, Any]:
        """Contact terms of (7) and the status of each point."""
        approach = k.jump_n
        if self.drift_correction:
            approach = k.jump_n + self.drift_correction * k.gap / k.dt
        return weak_form(k, approach, k.closed)

    def candidates(self, predicted_gap: np.ndarray, tolerance: float) -> np.ndarray:
        """Su: the points whose predicted gap [m] is closed."""
        return predicted_gap >= -tolerance

    def gap_share(self, force_weight: float) -> float:
        """The form reads the gap at the start of the step."""
        return 0.0

    def speed_limit(self, gap: np.ndarray, gap_rate: float, dt: float) -> np.ndarray:
        """The w_n that the law allows at most."""
        return -self.drift_correction * gap / dt


@dataclass(frozen=True)
class Gap:
    """GAP: continuous, the classical displacement law ``d_n <= 0, lam <= 0, lam d_n = 0`` at the
    end of the step in place of (1)-(2); same fields and integration as VELOCITY.

    With theta = 1/2 a point that lands bounces off again; theta = 1 stops it.

    Args:
        reach: only points whose predicted gap is within so many metres are candidates; choose it
            larger than what a step can change in the prediction. Infinite: every point is.
    """

    name: ClassVar[str] = "gap"
    multipliers: ClassVar[bool] = True
    points: Any = None
    reach: float = math.inf

    def __post_init__(self) -> None:
        if self.reach != math.inf:
            checks.number("reach", self.reach, above=0)

    def form(self, k: SurfaceFields) -> tuple[ufl.Form, Any]:
        """Contact terms of (7) with the gap law, and the status of each point."""
        return weak_form(k, k.jump_n + k.gap / k.gap_rate, 1.0)

    def candidates(self, predicted_gap: np.ndarray, tolerance: float) -> np.ndarray:
        """Every point within reach."""
        return predicted_gap >= -self.reach

    def gap_share(self, force_weight: float) -> float:
        """The form reads the gap at the end of the step."""
        return 1.0

    def speed_limit(self, gap: np.ndarray, gap_rate: float, dt: float) -> np.ndarray:
        """The w_n that the law allows at most."""
        return -gap / gap_rate


@dataclass(frozen=True)
class Lagrange(Gap):
    """LAGRANGE: point multipliers (forces, in N) with the displacement law.

    Args:
        points: coordinates (k, d) of the points, each a node of the facets (the corners of a
            block, say); ``None`` takes every node.
        reach: as for :class:`Gap`.
    """

    points: Sequence[Sequence[float]] | np.ndarray | None = None
    name: ClassVar[str] = "lagrange"


@dataclass(frozen=True)
class Discrete:
    """DISCRETE: springs and dashpots at points, acting in compression only; no multipliers.

    Args:
        stiffness: of each spring, N/m.
        damping: of each dashpot, N s/m.
        tangential_stiffness: of the springs that carry friction, N/m (default: ``stiffness``).
        points, reach: as for :class:`Lagrange`.
    """

    stiffness: float
    damping: float = 0.0
    tangential_stiffness: float | None = None
    points: Sequence[Sequence[float]] | np.ndarray | None = None
    reach: float = math.inf
    name: ClassVar[str] = "discrete"
    multipliers: ClassVar[bool] = False

    def __post_init__(self) -> None:
        checks.number("stiffness", self.stiffness, above=0)
        checks.number("damping", self.damping, at_least=0)
        if self.reach != math.inf:
            checks.number("reach", self.reach, above=0)
        checks.number("tangential_stiffness", self.stiffness_t, above=0)

    @property
    def stiffness_t(self) -> float:
        """Tangential stiffness, N/m."""
        given = self.tangential_stiffness
        return self.stiffness if given is None else given

    def form(self, k: SurfaceFields) -> tuple[ufl.Form, Any]:
        """Forces of the springs and the status of each point."""
        return _spring_form(k, self)

    def candidates(self, predicted_gap: np.ndarray, tolerance: float) -> np.ndarray:
        """Every point within reach."""
        return predicted_gap >= -self.reach

    def gap_share(self, force_weight: float) -> float:
        """The form reads the gap where the internal forces are taken."""
        return force_weight

    def speed_limit(self, gap: np.ndarray, gap_rate: float, dt: float) -> None:
        """Springs allow any speed."""


Formulation = Velocity | Gap | Lagrange | Discrete

VELOCITY = Velocity()
GAP = Gap()
LAGRANGE = Lagrange()
_NAMED: dict[str, Formulation] = {"velocity": VELOCITY, "gap": GAP, "lagrange": LAGRANGE}


def formulation(value: Formulation | str) -> Formulation:
    """A formulation from an object or a name ("velocity", "gap", "lagrange").

    Raises:
        InputError: unknown name, or "discrete", which has no stiffness by default.
    """
    if isinstance(value, (Velocity, Gap, Discrete)):
        return value
    if value == "discrete":
        raise checks.InputError(
            "formulation = 'discrete': springs need a stiffness, pass Discrete(stiffness=...)"
        )
    return _NAMED[checks.choice("formulation", value, [*_NAMED, "discrete"])]
