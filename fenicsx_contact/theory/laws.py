# SPDX-License-Identifier: LGPL-3.0-or-later
"""The laws (1)-(6) of contact and Coulomb friction, in UFL: the whole theory on one page.

Kham, Torkhani, Massin & Ben Dhia (2009), hal-01422173. Signs: ``n`` is the outward normal of the
slave side, ``d_n`` the gap (positive: penetration), ``w`` the velocity jump slave - master
(``w_n > 0``: approaching), ``lam <= 0`` the contact pressure, ``Lam`` the friction semi-multiplier
(tangential components, ``|Lam| <= 1``). The slave bears the traction ``lam n + mu lam Lam``.

    (1)  d_n <  0:  lam = 0
         d_n >= 0:  w_n <= 0,  lam <= 0,  lam w_n = 0         Signorini-Moreau
    (2)  lam = Su Sv g_n,   g_n = lam - rho_n w_n,   Su = chi(-d_n),   Sv = chi(g_n)
    (3)  |r| <= mu |lam|;   w_t = 0 inside;   w_t = -alpha r, alpha >= 0, on it    Coulomb
    (4)  r = mu lam Lam,    Lam = P(g_t),    g_t = Lam + rho_t w_t
    (5)  (1 - S) Lam = 0,   S = Su Sv

The package solves for the traction ``tau = mu |lam| Lam`` in place of the semi-multiplier (the
slave bears ``lam n - tau``). With the bound ``b = mu S max(-lam, 0)`` of (3) and the ball ``P_b``
of that radius, (4) and (5) are one row

    (4')  tau = P_b(tau + rho w_t),    P_b(x) = b x / max(b, |x|),    b = mu S max(-lam, 0)

with g_n (2) read for lam in b, which is lam wherever (2) holds. For b P(x / b) = P_b(x): this is b
times the printed ``Lam = P(Lam + rho_t w_t)``, its free number chosen as ``rho_t = rho / b``. The
printed row has no equation for Lam where the pressure vanishes; (4') says tau = 0 there. ``Lam =
tau / b`` is an output. Another law of friction is another b.

(3) reads the slip at the end of a step, whose work is done by the mean ``theta w_t + (1 - theta)
w_t^-``: friction that stops a slip at once and then holds the other way would push. As a point may
fall back as fast as it left, so may a slip that began with w_t^- turn round as fast, and friction
is against what goes beyond:

    (3')  w_t + s a = -alpha r, alpha >= 0, on the cone, 0 inside,  a = (1 - theta)/theta w_t^-,
          s in [0, 1]:  s = 0 where -r . a > 0,  s = 1 where -r . a < 0

-r is a subgradient of mu |lam| times the distance of w_t from the way between 0 and -a: convex in
w_t, and 0 at -a, so that ``r . (w_t + a) <= 0``, no work of any step. What goes on, ends or rests
has s = 0 and (3), and so has all with theta = 1. The row is (4') of ``g + rho s a``, g = tau + rho
w_t, where -s a is what of that way is nearest to g / rho: of the two projections, on the ball and
on the half-space where friction is against a, as far as s reaches.

In space the direction of a slip that goes on, w_t . a > 0, turns, and friction is against its mean:

    (3'')  w_t + s a = -alpha r, alpha >= 0, on the cone,    s = min(w_t . a / |a|^2, 1)

What is not slowed down has s = 1, which makes theta = 1/2 of second order; what ends has s = 0 and
(3), and rests. Here, too, ``r . (w_t + a) <= 0``, and along a line it is (3). It is no gradient (of
those that stick at 0 and are on the cone elsewhere (3) alone is), but the w_t of a mass is unique:
free velocities that end with one |w_t + s a| are an oval, around those of each smaller one.

Nothing here knows a mesh. The printed (1) has ``w_n < 0``, which forbids a persistent contact, the
printed (3) a plus sign, and (5)-(6) lack ``Su``, which (7) has.
"""

from __future__ import annotations

from typing import Any

import ufl

Expr = Any  # ufl.core.expr.Expr; UFL is not typed


def indicator(x: Expr) -> Expr:
    """chi(x): 1 where x <= 0, else 0."""
    return ufl.conditional(ufl.le(x, 0), 1.0, 0.0)


def ball_projection(g: Expr) -> Expr:
    """P(g): projection on the unit ball.

    The operand of the root is protected, not its result: UFL differentiates both branches of a
    conditional, and g/|g| at g = 0 would give 0 x NaN.
    """
    return g / ufl.sqrt(ufl.max_value(1.0, ufl.dot(g, g)))


def augmented_multiplier(lam: Expr, rho_n: Expr, approach: Expr) -> Expr:
    """g_n = lam - rho_n w_n (2); ``approach`` is w_n, or what a formulation puts in its place."""
    return lam - rho_n * approach


def augmented_semi_multiplier(Lam: Expr, rho_t: Expr, w_t: Expr) -> Expr:
    """g_t = Lam + rho_t w_t (4)."""
    return Lam + rho_t * w_t


def contact_status(Su: Expr, g_n: Expr) -> Expr:
    """S = Su Sv (2): 1 where the contact bears."""
    return Su * indicator(g_n)


def bounded(b: Expr, g: Expr) -> Expr:
    """P_b(g) = b g / max(b, |g|): projection on the ball of radius b >= 0.

    The operand of the root is protected, as in :func:`ball_projection`: no tangent is NaN, and of a
    ball without extent (b = 0: no pressure) the tangent is zero, also at g = 0. A bound that is no
    number makes a projection that is none, not one without bound.
    """
    size = ufl.dot(g, g)
    safe = ufl.conditional(ufl.gt(size, 0), size, 1.0)
    return ufl.conditional(ufl.lt(size, b**2), 1.0, b / ufl.sqrt(safe)) * g


def turning(g: Expr, rho: Expr, a: Expr) -> Expr:
    """s of (3'), in [0, 1]: how far a slip turns round, of the way to -a; protected like
    :func:`bounded`."""
    size = ufl.dot(a, a)
    share = -ufl.dot(g, a) / (rho * ufl.conditional(ufl.gt(size, 0), size, 1.0))
    return ufl.min_value(ufl.max_value(share, 0.0), 1.0)


def lasting(w_t: Expr, a: Expr) -> Expr:
    """s of (3''), in [0, 1]: how much of the slip at the start is in the mean that friction is
    against; protected like :func:`bounded`. Along a line nothing asks for it."""
    if len(w_t) == 1:
        return 0.0
    size = ufl.dot(a, a)
    share = ufl.dot(w_t, a) / ufl.conditional(ufl.gt(size, 0), size, 1.0)
    return ufl.min_value(ufl.max_value(share, 0.0), 1.0)


def slipping(b: Expr, g: Expr, s: Expr = 0.0) -> Expr:
    """1 where the traction is told (slip), else 0 (stick): g has left the ball of radius b, or a
    slip is on its way between 0 and -a (3')."""
    turns = ufl.conditional(ufl.gt(ufl.as_ufl(s * (1 - s)), 0), 1.0, 0.0)
    return ufl.conditional(ufl.gt(ufl.dot(g, g), b**2), 1.0, turns)


def magnitude(v: Expr) -> Expr:
    """|v|, whose derivative at v = 0 is taken as 0; protected like :func:`bounded`."""
    size = ufl.dot(v, v)
    there = ufl.gt(size, 0)
    return ufl.conditional(there, ufl.sqrt(ufl.conditional(there, size, 1.0)), 0.0)
