# SPDX-License-Identifier: LGPL-3.0-or-later
"""The contact terms of the weak form (7), on the contact surface as a domain of its own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import ufl

from .friction import FrictionBound
from .laws import (
    Expr,
    augmented_multiplier,
    bounded,
    contact_status,
    lasting,
    slipping,
    turning,
)


class ContactFields(Protocol):
    """What the form of a contact is written in: fields and constants on its surface.

    Attributes:
        velocity_jump: w, m/s, an unknown; ``jump_n``, ``jump_t`` its parts. Of the test functions
            parts are those along which forces act: where normals turn in a step, along their mean.
        multiplier: lam, Pa (N at points), an unknown; None for springs.
        traction: tau, d - 1 components, Pa (N), an unknown; None without friction, and where a law
            without multipliers does not ask for it.
        normal, gap: n and d_n [m, positive: penetration], coefficients; ``x``: reference
            coordinates, m.
        start_jump_n, start_jump_t: w_n and w_t at the start of the step, m/s, 0 where they were not
            resolved, along tangents that turn with the normals; ``limit_rate``: (1 - theta)/theta.
        closed: Su of a law that is decided before the step, 0 or 1.
        rho_n, rho_t: augmentation, Pa s/m, coefficients.
        start_gap, mean_share: d_n at the start of the step [m], and how far the scheme takes forces
            in the mean, of a law without multipliers only.
        gap_rate: derivative of the end position by the end velocity, s; ``dt``: the step, s;
            ``horizon``: over which a law of velocities looks ahead, s.
        friction: the law of friction, None if there is none.
        frozen, known_pressure: 1 where the bound is to be that of a known pressure [Pa], else 0.

    What only some laws ask for is made when they do (:mod:`fenicsx_contact.contact.law_fields`). It
    is that of the time at which the scheme takes the forces of contacts:

        t, elapsed: that time [s], and how long it is after the start of the step [s];
        place: where the points are [m];
        slip_speed: |w_t| where it bears, else 0 [m/s]; in an impact of the mean of both ends;
        touched: 1 where a point touches as time begins to pass, else 0;
        loaded: 1 where time passes, 0 in an impact;
        field(name, value): a parameter (:data:`~fenicsx_contact.theory.parameter.Parameter`);
        state(name, start, evolve): a field that the law remembers, and what it becomes in a time;
        wears(name, evolve): a depth [m] that does, by which the surface recedes; the gap that the
        form reads is less by that, in the step, too.
    """

    velocity_jump: Any
    multiplier: Any
    test_multiplier: Any
    traction: Any
    test_traction: Any
    normal: Any
    gap: Any
    start_gap: Any
    mean_share: Any
    start_jump_n: Any
    limit_rate: Any
    closed: Any
    rho_n: Any
    rho_t: Any
    gap_rate: Any
    dt: Any
    horizon: Any
    friction: FrictionBound | None
    frozen: Any
    known_pressure: Any

    @property
    def x(self) -> Expr: ...
    @property
    def jump_n(self) -> Expr: ...
    @property
    def test_jump_n(self) -> Expr: ...
    @property
    def jump_t(self) -> Expr: ...
    @property
    def test_jump_t(self) -> Expr: ...
    def integral(self, f: Expr) -> ufl.Form: ...
    @property
    def start_jump_t(self) -> Expr: ...
    @property
    def slip_speed(self) -> Expr: ...
    @property
    def t(self) -> Expr: ...
    @property
    def elapsed(self) -> Expr: ...
    @property
    def place(self) -> Expr: ...
    @property
    def touched(self) -> Expr: ...
    @property
    def loaded(self) -> Expr: ...
    def constant(self, value: float) -> Any: ...
    def field(self, name: str, value: Any) -> Expr: ...
    def state(self, name: str, start: Any, evolve: Callable[[Expr, Expr], Expr]) -> Expr: ...
    def wears(self, name: str, evolve: Callable[[Expr, Expr], Expr]) -> None: ...


def weak_form(k: ContactFields, approach: Expr, Su: Expr = 1.0) -> tuple[ufl.Form, Expr]:
    """The contact terms of (7): jump, multiplier and friction rows.

    The printed last row, ``(mu S |lam|/rho_t)(Lam - P(g_t)) . Lam* + (1 - S) Lam . Lam*``, stands
    here as (4'): in tractions it is one term, regular without pressure, symmetric with the jump
    row while it sticks (see :mod:`fenicsx_contact.theory.laws`).

    Args:
        k: the fields.
        approach: w_n less what the law allows, m/s: w_n itself in (2).
        Su: the part of S that is decided before the step.

    Returns:
        The form, and the status of each point as an expression: 0 open, 1 stick, 2 slip.
    """
    lam = k.multiplier
    g_n = augmented_multiplier(lam, k.rho_n, approach)
    S = contact_status(Su, g_n)

    form = -k.integral(S * g_n * k.test_jump_n)
    form += -k.integral((lam - S * g_n) / k.rho_n * k.test_multiplier)
    if k.friction is None:
        return form, S

    tau = k.traction
    g_t, back = tau + k.rho_t * k.jump_t, k.limit_rate * k.start_jump_t
    s = turning(g_t, k.rho_t, back)
    g_t += k.rho_t * (s + lasting(k.jump_t, back)) * back
    pressure = k.frozen * k.known_pressure - (1 - k.frozen) * g_n
    b = k.friction.bound(k, S * pressure, S)
    P = bounded(b, g_t)

    form += k.integral(ufl.dot(P, k.test_jump_t))
    form += -k.integral(ufl.dot(tau - P, k.test_traction) / k.rho_t)
    return form, S + S * slipping(b, g_t, s)
