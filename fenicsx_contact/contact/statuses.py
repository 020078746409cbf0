# SPDX-License-Identifier: LGPL-3.0-or-later
"""What round-off must not decide: which points a step ends with, and which arrive together."""

from __future__ import annotations

import numpy as np

from ..base.vectors import dot, largest, longest
from ..theory.scheme import Step


def kept(
    status: np.ndarray,
    presses: np.ndarray,
    slip: np.ndarray,
    back: np.ndarray,
    resolution: float,
) -> np.ndarray:
    """Statuses to be kept (n,), by slips (n, d) in m/s: what moves along the surface by less than
    ``resolution``, m/s, sticks, and what hardly presses is open. What has no mean slip, as it has
    turned to ``back`` of (3'), (n, d) in m/s, slips."""
    if status.max() > 1:
        still = dot(slip, slip) <= resolution**2
        status = np.where(still, np.minimum(status, 1.0), status)
    if back.any():
        turned = dot(2 * slip - back, back) > 0  # it is nearer to that than to rest
        status = np.where(turned & (status == 1), 2.0, status)
    return np.where(presses, status, 0.0)


def coming(gap: np.ndarray, left: np.ndarray, horizon: float) -> np.ndarray:
    """The speeds, m/s, with which points that bear may arrive at the end of a step, (n,), from
    their gaps at its start, m: those by which they get there, or by which those come back that
    have left at w_n = ``left``, m/s."""
    return np.maximum(-gap, 0.0) / horizon + np.maximum(-left, 0.0)


def leaving(
    jump: np.ndarray, normal: np.ndarray, extent: float, step: Step, thrown: bool
) -> np.ndarray:
    """At which w_n points leave, (n,) in m/s, that may come back in a step, times the share of that
    by which they then do.

    Args:
        jump, normal: at the start, (n, d) in m/s and 1.
        extent: of the surface, m.
        step: that is solved.
        thrown: whether an impact has just let them go, of what rebounds. Else what leaves falls
            back, but for what the turn of the points about each other in the step may make of
            their velocities.
    """
    w = dot(jump, normal)
    if thrown:
        return w
    if len(jump) == 1:  # nobody knows how it turns
        return 0 * w
    turn = np.ptp(w) * step.dt / extent  # of the normal
    lifts = turn * longest(jump - jump.mean(axis=0))
    return step.limit_rate * np.where(w < -lifts, w, 0.0)


def at_once(
    touches: np.ndarray,
    bore: np.ndarray,
    gap: np.ndarray,
    approach: np.ndarray,
    resolution: float,
    tolerance: float,
) -> np.ndarray:
    """Points that touch, (n,) of bool, and those that arrive in the same instant as the fresh ones
    among them, which did not bear and come faster than the ``resolution`` [m/s].

    Where a face lands flat its points arrive at once, but one within the tolerance [m] leaves the
    gaps [m] of others open by as much more as they are faster, w_n [m/s]. What leaves does not
    arrive.
    """
    fresh = touches & ~bore & (approach > resolution)
    off = tolerance + largest(gap[touches])
    instant = off / approach[fresh].min(initial=np.inf)
    comes = (approach >= -resolution) & (gap + instant * approach >= -tolerance)
    return np.asarray(touches | comes)
