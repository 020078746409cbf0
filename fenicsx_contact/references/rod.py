# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rods in guides: one-dof drops, exact insertion forces.

The drop of one degree of freedom is ``(M + m_a(z)) z'' = (M - m_w) g - F(z) - C(z) z'|z'|``; the
numbers of its water reproduce the states of EDF's test FDNL100 (see
:class:`~fenicsx_contact.rods.water.GuideTubeWater`). The insertion force of an endless beam in a
sinusoidal corridor follows from the beam equation between its contacts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from ..rods.water import Water


def one_dof_drop(
    travels: Sequence[float],
    *,
    mass: float,
    water: Water,
    force: Callable[[float], float] | float = 0.0,
    gravity: float = 9.81,
) -> tuple[np.ndarray, np.ndarray]:
    """Times and speeds at which a rod falling from rest passes some travels.

    Args:
        travels: that rise, m.
        mass: M, kg.
        water: buoyancy, drag, added mass.
        force: what holds the rod back, N; a number, or a function of the travel.
        gravity: m/s².

    Returns:
        Times [s] and speeds [m/s]; NaN for travels that it does not reach.
    """

    def rates(_: float, state: np.ndarray) -> list[float]:
        z, v = state
        held = force(z) if callable(force) else force
        driving = (mass - water.buoyancy) * gravity - held - water.drag(z)[0] * v * abs(v)
        return [v, driving / (mass + water.added_mass(z))]

    events = []
    for i, travel in enumerate(travels):

        def passes(_: float, state: np.ndarray, travel: float = travel) -> float:
            return state[0] - travel

        passes.terminal = i + 1 == len(travels)  # type: ignore[attr-defined]
        events.append(passes)
    found = solve_ivp(
        rates, (0, 100.0), [0.0, 0.0], events=events, rtol=1e-10, atol=1e-12, max_step=2e-3
    )
    times, speeds = np.full(len(travels), np.nan), np.full(len(travels), np.nan)
    for i, (when, states) in enumerate(zip(found.t_events, found.y_events)):
        if len(when):
            times[i], speeds[i] = when[0], states[0][1]
    return times, speeds


def endless_insertion_force(
    amplitude: float, clearance: float, wavelength: float, bending: float
) -> float:
    """Sum of the normal forces per wavelength on an endless beam in ``a sin kx`` with clearance c.

    With f = k times the free length from an inflexion to the contact at a crest,
    ``c/a = sin f - f cos f - f² sin f/3`` and ``N = 4 EI k³ a sin f/f``; for c/a > 0.1775 the beam
    touches each crest at one point, ``N = 768 EI (a - c)/L³``, and not at all for c >= a.

    Args:
        amplitude, clearance, wavelength: a, c, L in m.
        bending: E I, N m².

    Returns:
        N, in newtons per wavelength.
    """
    k, ratio = 2 * np.pi / wavelength, clearance / amplitude
    if ratio >= 1:
        return 0.0

    def remainder(f: float) -> float:
        return np.sin(f) - f * np.cos(f) - f * f * np.sin(f) / 3 - ratio

    if remainder(np.pi / 2) <= 0:
        return 768 * bending * (amplitude - clearance) / wavelength**3
    f = brentq(remainder, 1e-3, np.pi / 2, xtol=1e-15)
    return 4 * bending * k**3 * amplitude * np.sin(f) / f
