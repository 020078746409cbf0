# SPDX-License-Identifier: LGPL-3.0-or-later
"""The contact terms of springs and dashpots that formulations without multipliers have.

A spring that acts in compression only makes energy where its force is read at one point of a step:
the work of that force is not the change of the stored energy. So the force is the mean over the way
of the gap from ``a`` to ``b`` in the step, which for ``k max(d, 0)`` is exactly

    k (a+ + b+)/2  s,        s = share of the way that is penetrated,   x+ = max(x, 0)

(of another spring s times its own mean from a+ to b+), as far as the scheme takes its forces in the
mean (all of it for theta = 1/2: springs then conserve energy), and the force at the end for the
rest, which only dissipates. A dashpot acts over the same share s, so that its force grows from zero
as a point dips in, and takes ``(b - a)/dt``.

Friction, ``tau = P_b(k_t s)`` of the stretch s = s0 + r w_t, sticks in a range of slip speeds as
narrow as the springs are stiff, over which Newton's steps leap from slip to slip the other way. So
the traction is an unknown, as it is of laws without springs, whose compliance stands in its row:

    tau = P_b(tau + rho (w_t + (s0 - tau/k_t)/r)),

which says the same for any rho; here with the smaller of rho and k_t r, which is the return itself.
"""

from __future__ import annotations

from typing import Any, ClassVar

import ufl

from .laws import Expr, bounded, slipping
from .step_data import StepData
from .weak_form import ContactFields


def _positive(x: Expr) -> Expr:
    return ufl.max_value(x, 0.0)


def _penetrated_share(a: Expr, b: Expr) -> Expr:
    """Share of the way from a to b that is penetrated."""
    top = ufl.max_value(a, b)
    mixed = ufl.And(ufl.gt(top, 0), ufl.lt(ufl.min_value(a, b), 0))
    way = ufl.conditional(mixed, abs(b - a), 1.0)
    return ufl.conditional(mixed, top / way, ufl.conditional(ufl.gt(top, 0), 1.0, 0.0))


def spring_form(k: Any, spring: Any) -> tuple[ufl.Form, Expr]:
    """Springs in compression only, with dashpots, and elastic-plastic springs for friction.

    Args:
        k: the fields; ``gap`` is that of the end of the step as it depends on w, ``start_gap`` that
            of its start, ``mean_share`` how far the scheme takes forces in the mean.
        spring: ``reaction`` at a depth, its mean from one depth to another, damping, stiffness_t.

    Returns:
        The form, and the status of each point as an expression: 0 open, 1 stick, 2 slip.
    """
    a, b = k.start_gap, k.gap + k.gap_rate * k.jump_n
    damping = k.field("damping", spring.damping) if spring.damping else 0.0
    damper = damping * (b - a) / k.dt
    m, share = k.mean_share, _penetrated_share(a, b)
    mean = spring.mean_reaction(k, _positive(a), _positive(b))
    force = m * _positive(share * (mean + damper))
    # a dashpot that acted at once would jump as b touches
    end = _positive(spring.reaction(k, _positive(b)) + share * damper)
    force += (1 - m) * ufl.conditional(ufl.gt(b, 0), end, 0.0)
    form = k.integral(force * k.test_jump_n)
    status = ufl.conditional(ufl.gt(force, 0), 1.0, 0.0)
    if k.friction is not None:
        # the spring's stretch where the scheme takes forces
        stretch = k.tangential(k.elongation) + k.force_rate * k.jump_t
        own = getattr(spring, "tangential_stiffness", spring.stiffness_t)
        name = "stiffness" if own is None else "tangential_stiffness"
        tau, stiffness = k.traction, k.field(name, spring.stiffness_t)
        share = k.rho_t / ufl.max_value(k.rho_t, stiffness * k.force_rate)
        g_t = tau + share * (stiffness * stretch - tau)
        limit = k.friction.bound(k, force, status)
        P = bounded(limit, g_t)
        form += k.integral(ufl.dot(P, k.test_jump_t))
        form += -k.integral(ufl.dot(tau - P, k.test_traction) / k.rho_t)
        status = status + status * slipping(limit, g_t)
    return form, status


class Springs:
    """What such formulations have in common."""

    pushes: ClassVar[bool] = True
    multipliers: ClassVar[bool] = False
    tractions: ClassVar[bool] = True
    percussive: ClassVar[bool] = False
    gap_share: ClassVar[float] = 1.0

    def form(self, k: ContactFields) -> tuple[ufl.Form, Any]:
        """Forces of the springs, or pressures, and the status of each point."""
        return spring_form(k, self)

    def limit(self, data: StepData) -> None:
        """Springs allow any speed."""
