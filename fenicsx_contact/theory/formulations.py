# SPDX-License-Identifier: LGPL-3.0-or-later
"""The four formulations of contact that the paper compares, VELOCITY, GAP, LAGRANGE and DISCRETE,
and PRINTED, the first as it stands there.

Each is a small frozen object with only its own parameters. It gives the contact terms of the weak
form (7) on the contact surface, and the velocities that its law allows. Nothing here knows a mesh,
a solid or a solver.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol

import numpy as np
import ufl

from ..base import checks
from ..base.quoted import quoted
from .springs import Springs
from .step_data import StepData
from .weak_form import ContactFields, weak_form


class Formulation(Protocol):
    """What a contact asks of its formulation; an own one is any object with these members.

    Attributes:
        name: for messages.
        multipliers: whether it has lam (and tau): springs have none.
        tractions: of one without lam that has it, and True: with friction it has tau all the same.
        percussive: whether it limits velocities, so that it can be struck: impacts are then solved
            as percussions. Laws of positions and springs are not.
        at_points: whether its forces act at points [N] instead of on areas [Pa].
        points: coordinates (k, d) of the points that it acts on, None for all nodes.
        gap_share: which gap the form reads: 0 that of the start of the step, 1 that of its end as
            it depends on w.
        pushes: of one that has it, and True: its normal forces only push, and what has no lam does
            so only inside, beside what it does to points that touched (and are glued). Of others
            without lam all points are asked, however open. See :func:`only_pushes`.
        rebounds: of a percussive one that has it, and True: what it strikes leaves again.
        reads_areas: of a class that says False itself: forces are the same for any areas.

    Optional is ``closed(predicted_gap, tolerance)``: Su, (n,) of bool, where it is decided before
    the step, from the gaps (n,) [m] at the end of an explicit prediction, equal up to a tolerance
    [m]. Without it the form decides. No surface wears by one that has it.
    """

    @property
    def name(self) -> str: ...
    @property
    def multipliers(self) -> bool: ...
    @property
    def percussive(self) -> bool: ...
    @property
    def at_points(self) -> bool: ...
    @property
    def points(self) -> Any: ...
    @property
    def gap_share(self) -> float: ...

    def form(self, k: ContactFields) -> tuple[ufl.Form, Any]:
        """Contact terms of (7), and the status of each point: 0 open, 1 stick, 2 slip. What is not
        open bears, whether it is pushed or pulled, and is asked again in the next step. If there is
        a law of friction, ``k.friction``, it must ask for its bound, or the law is refused."""

    def limit(self, data: StepData) -> np.ndarray | None:
        """The w_n (n,) [m/s] that the law allows at most; None for springs."""


@dataclass(frozen=True)
class Velocity:
    """VELOCITY: contact at the level of velocities, every point a candidate.

    A point may approach as fast as it would arrive by the end of the step, less what it is too fast
    at the start, and fall back as fast as it left:

        w_n <= max(c - r max(w_n^- - c, 0), -r w_n^-, 0),   lam <= 0,   complementary,
        c = max(-d_n, 0)/dt,   r = (1 - theta)/theta,

    in place of Su in (1)-(2): what starts with c at most may end with c, and what is slowed down
    arrives where it should, not beyond. What bears then never moves outwards in the step,
    ``dt (theta w_n + (1 - theta) w_n^-) >= 0``, so that a contact does no positive work, and a
    closed point keeps to the printed ``w_n <= 0``. A point that starts faster than c is struck: an
    impact, which is solved as a percussion for all points at once, ``M (v+ - v-) = J' P`` with
    ``w_n <= c``.

    Args:
        drift_correction: kappa in [0, 1]; where d_n > 0, ``w_n <= max(-kappa (d_n/dt + (1 - theta)
            min(w_n^-, 0)), -r min(w_n^-, 0) - kappa d_n/(theta dt))``: in the end 1 - kappa of d_n
            is left by each step, and of the velocity of the return nothing rings on; what leaves
            faster may lose it again, as at d_n = 0. That is work of the law; in impacts nothing
            moves.
    """

    drift_correction: float = 0.0
    name: ClassVar[str] = "velocity"
    reads_areas: ClassVar[bool] = False
    pushes: ClassVar[bool] = True
    multipliers: ClassVar[bool] = True
    percussive: ClassVar[bool] = True
    at_points: ClassVar[bool] = False
    points: ClassVar[None] = None
    gap_share: ClassVar[float] = 0.0

    def __post_init__(self) -> None:
        checks.keep(self, "drift_correction", at_least=0, at_most=1)

    def form(self, k: ContactFields) -> tuple[ufl.Form, Any]:
        """Contact terms of (7) and the status of each point."""
        return weak_form(k, k.jump_n - self.allowed(k))

    def allowed(self, k: ContactFields) -> Any:
        """The w_n that the law allows at most, in UFL."""
        deep = ufl.gt(k.gap, 0)
        return self._most(k, ufl.max_value, lambda back, else_: ufl.conditional(deep, back, else_))

    def _most(self, k: Any, larger: Callable, where_deep: Callable) -> Any:
        c = larger(-k.gap, 0.0) / k.horizon
        slowed = c - k.limit_rate * larger(k.start_jump_n - c, 0.0)
        limit = larger(larger(slowed, 0.0), -k.limit_rate * k.start_jump_n)
        if not self.drift_correction:
            return limit
        leaving = k.limit_rate / (1 + k.limit_rate) * larger(-k.start_jump_n, 0.0)
        back = self.drift_correction * k.gap / k.horizon
        slow, fast = self.drift_correction * leaving - back, limit - (1 + k.limit_rate) * back
        return where_deep(larger(slow, fast), limit)

    def limit(self, data: StepData) -> np.ndarray:
        """The w_n that the law allows at most."""
        return self._most(data, np.maximum, lambda back, else_: np.where(data.gap > 0, back, else_))


@dataclass(frozen=True)
class Printed(Velocity):
    """The velocity law as the paper prints it, (1)-(2): ``w_n <= 0`` where Su = 1.

    A point is closed, Su = 1, when the explicit prediction of its gap at the end of the step is;
    Su stays frozen within the step (read at the end of the step it has no fixed point). A point
    that lands within a step is stopped short of the obstacle or beyond it.

    Args:
        drift_correction: kappa in [0, 1]; ``w_n <= -kappa d_n/dt`` of a closed point.
    """

    name: ClassVar[str] = "printed"
    reads_areas: ClassVar[bool] = False
    pushes: ClassVar[bool] = True
    percussive: ClassVar[bool] = False

    def form(self, k: ContactFields) -> tuple[ufl.Form, Any]:
        return weak_form(k, k.jump_n + self.drift_correction * k.gap / k.horizon, k.closed)

    def closed(self, predicted_gap: np.ndarray, tolerance: float) -> np.ndarray:
        """Su: the points whose predicted gap is closed."""
        return predicted_gap >= -tolerance

    def limit(self, data: StepData) -> np.ndarray:
        return -self.drift_correction * data.gap / data.horizon


@dataclass(frozen=True)
class Gap:
    """GAP: continuous, the classical displacement law ``d_n <= 0, lam <= 0, lam d_n = 0`` at the
    end of the step in place of (1)-(2); same fields and integration as VELOCITY.

    With theta = 1/2 a point that lands bounces off again; theta = 1 stops it.
    """

    name: ClassVar[str] = "gap"
    reads_areas: ClassVar[bool] = False
    pushes: ClassVar[bool] = True
    multipliers: ClassVar[bool] = True
    percussive: ClassVar[bool] = False
    at_points: ClassVar[bool] = False
    points: Any = field(default=None, init=False)
    gap_share: ClassVar[float] = 1.0

    def form(self, k: ContactFields) -> tuple[ufl.Form, Any]:
        """Contact terms of (7) with the gap law, and the status of each point."""
        return weak_form(k, k.jump_n + k.gap / k.gap_rate)

    def limit(self, data: StepData) -> np.ndarray:
        """The w_n that the law allows at most."""
        return -data.gap / data.gap_rate


@dataclass(frozen=True)
class Lagrange(Gap):
    """LAGRANGE: point multipliers (forces, in N) with the displacement law.

    Args:
        points: coordinates (k, d) of the points, each a node of the facets (the corners of a
            block, say); ``None`` takes every node.
    """

    points: Sequence[Sequence[float]] | np.ndarray | None = None
    name: ClassVar[str] = "lagrange"
    reads_areas: ClassVar[bool] = False
    at_points: ClassVar[bool] = True


@dataclass(frozen=True)
class Discrete(Springs):
    """DISCRETE: springs and dashpots at points, acting in compression only; no multipliers.

    Args:
        stiffness: of each spring, N/m.
        damping: of each dashpot, N s/m.
        tangential_stiffness: of the springs that carry friction, N/m (default: ``stiffness``).
        points: as for :class:`Lagrange`.
    """

    stiffness: float
    damping: float = 0.0
    tangential_stiffness: float | None = None
    points: Sequence[Sequence[float]] | np.ndarray | None = None
    name: ClassVar[str] = "discrete"
    at_points: ClassVar[bool] = True

    def __post_init__(self) -> None:
        checks.keep(self, "stiffness", above=0)
        checks.keep(self, "damping", at_least=0)
        if self.tangential_stiffness is not None:
            checks.keep(self, "tangential_stiffness", above=0)

    @property
    def stiffness_t(self) -> float:
        """Tangential stiffness, N/m."""
        return self.stiffness if self.tangential_stiffness is None else self.tangential_stiffness

    def reaction(self, k: ContactFields, depth: Any) -> Any:
        """Force of a spring that is penetrated so deep."""
        return k.field("stiffness", self.stiffness) * depth

    def mean_reaction(self, k: ContactFields, a: Any, b: Any) -> Any:
        """Its mean over the way from one depth to another."""
        return 0.5 * k.field("stiffness", self.stiffness) * (a + b)


VELOCITY = Velocity()
GAP = Gap()
LAGRANGE = Lagrange()
PRINTED = Printed()
_NAMED: dict[str, Formulation] = {
    "velocity": VELOCITY,
    "gap": GAP,
    "lagrange": LAGRANGE,
    "printed": PRINTED,
}


def only_pushes(law: Formulation) -> bool:
    """Whether a formulation says that it ``pushes`` only, and no class derived from the one that
    says so has written another form."""
    for place in (law, *type(law).__mro__):
        if says := {"pushes", "form"} & getattr(place, "__dict__", {}).keys():
            return "pushes" in says and bool(law.pushes)  # type: ignore[attr-defined]
    return False


def formulation(value: Formulation | str) -> Formulation:
    """A formulation from an object or a name ("velocity", "gap", "lagrange", "printed").

    Raises:
        InputError: unknown name, "discrete", which has no stiffness by default, or an object that
            lacks a member of :class:`Formulation`.
    """
    if isinstance(value, str):
        if value == "discrete":
            raise checks.InputError(
                "formulation = 'discrete': springs need a stiffness, pass Discrete(stiffness=...)"
            )
        return _NAMED[checks.choice("formulation", value, [*_NAMED, "discrete"])]
    asked = [name for name in vars(Formulation) if not name.startswith("_")]
    members = [name for name in asked if not hasattr(value, name)]
    if members or isinstance(value, type):
        raise checks.InputError(
            f"formulation = {quoted(value)}: must be one of {[*_NAMED, 'discrete']} "
            "or an object with "
            f"the members of Formulation; it lacks {members or 'its parameters: call it'}"
        )
    return value
