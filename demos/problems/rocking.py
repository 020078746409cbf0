# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rocking block against Housner (1963), and the block tilted past its tipping angle."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from fenicsx_contact import Contact, Discrete, History, Lagrange, RigidSolid, Scene, ThetaScheme
from fenicsx_contact.references.housner import Block
from fenicsx_contact.references.housner import rocking as housner
from fenicsx_contact.references.swings import swings
from fenicsx_contact.study import Problem

from .shapes import FLOOR, G, rectangle

#: The paper's block, and friction that it sticks with (Code_Aster, SDNV105).
BLOCK = Block(width=0.36, height=0.80, mass=417.6)
FRICTION = 0.9
#: Mass that a corner feels, kg.
CORNER = 1 / (1 / BLOCK.mass + (BLOCK.width / 2) ** 2 / BLOCK.inertia_centre)


def relaxation(stiffness: float) -> float:
    """c/k of dashpots twice critical, s, beside springs of a stiffness, N/m."""
    return 4 * float(np.sqrt(CORNER / stiffness))


def _scene(
    tilt: float,
    theta: float,
    formulation: str,
    located: bool,
    normal_augmentation: float,
    tangential_augmentation: float,
    stiffness: float = 1.0,
) -> tuple[Scene, RigidSolid]:
    b, mass = BLOCK.width / 2, BLOCK.mass
    corners = [(-b, 0.0), (b, 0.0)]
    formulations: dict[str, Any] = {
        "lagrange": Lagrange(points=corners),
        "discrete": Discrete(stiffness, relaxation(stiffness) * stiffness, points=corners),
    }
    block = RigidSolid(
        rectangle(BLOCK.width, BLOCK.height),
        mass=mass,
        gravity=(0, -G),
        rotation=tilt,
        about=corners[0],
    )
    contact = Contact(
        block,
        "base",
        FLOOR,
        formulations.get(formulation, formulation),
        friction=FRICTION,
        normal_augmentation=normal_augmentation,
        tangential_augmentation=tangential_augmentation,
    )
    return Scene([block], [contact], ThetaScheme(theta), locate_impacts=located), block


def rocking(
    *,
    tilt: float,
    share: float,
    impacts: int = 3,
    theta: float = 0.5,
    formulation: str = "velocity",
    located: bool = False,
    step_error: float | None = None,
    normal_augmentation: float = 1.0,
    tangential_augmentation: float = 1.0,
    stiffness: float = 1e12,
) -> Problem:
    """A rigid block released at a tilt; error: the worst of its first kinetic-energy maxima.

    Bound: a uniform step rounds each impact to its end and samples the maximum before it, each
    2 dt/T of an energy that grows as t² over the quarter period T; errors add up over the
    impacts; theta away from 1/2 adds its own 4 |theta - 1/2| dt/T. With impacts located nothing
    is rounded, and what is left is of second order, (dt/T)² for each swing. A corner is closed
    from the gap tolerance on, which is a share of each lift; springs bear after the time c/k of
    their dashpots, which counts like dt.

    Args:
        tilt: rad, below the tipping angle 0.4229.
        share: step over the time to the first impact; a little less, so that steps fit the run.
        impacts: how many maxima are compared.
        theta, formulation, located, step_error, normal_augmentation, tangential_augmentation: as
            usual.
        stiffness: of the springs of "discrete", N/m.
    """
    exact = housner(BLOCK, tilt, impacts=impacts + 1)
    times = exact.impact_times
    until = times[-2] + 0.95 * (times[-1] - times[-2])
    dt = until / np.ceil(until / (share * times[0]))
    quarters = np.diff(times[:-1], prepend=-times[0]) / 2
    scene, block = _scene(
        tilt,
        theta,
        formulation,
        located,
        normal_augmentation,
        tangential_augmentation,
        stiffness,
    )

    def error(history: History) -> float:
        if located:  # the maxima are before the percussions; rows between may be few
            struck = np.flatnonzero(history["dt"] == 0)[1:]
            if len(struck) < impacts:
                return np.nan
            most = history["kinetic"][struck[:impacts] - 1]
        else:
            _, most = swings(history.time, history["tilt"], history["kinetic"], impacts)
        return float(np.abs(most / exact.kinetic_before[:-1] - 1).max())

    first = (4 + 4 * abs(theta - 0.5)) * dt / quarters
    if formulation == "discrete":  # springs take their time: that of their dashpots, c/k
        first += 4 * relaxation(stiffness) / quarters
    early = 2 * scene.contacts[0].tolerance / BLOCK.width / exact.peak_angles[:-1]
    return Problem(
        scene,
        until,
        dt,
        error,
        bound=float((early + ((dt / quarters) ** 2 if located else first)).sum()),
        probes={"tilt": lambda: float(block.rotation)},
        deepest=BLOCK.width * tilt,
        step_error=step_error,
    )


def toppling(*, tilt: float, share: float, theta: float = 0.5, located: bool = False) -> Problem:
    """The block tilted past its tipping angle: it falls about its corner,
    ``tilt'' = p² sin(tilt - alpha)``, followed for 2/p; error: of the angle fallen.

    Bound: of first order, dt over the time that is followed, times four; the motion has no
    impact, so located impacts make no difference.

    Args:
        tilt: rad, above the tipping angle.
        share: step over the time followed.
        theta, located: as usual.
    """
    p, until = BLOCK.p, 2 / BLOCK.p
    fall = solve_ivp(
        lambda _, s: [s[1], p**2 * np.sin(s[0] - BLOCK.alpha)],
        (0, until),
        [tilt, 0.0],
        rtol=1e-11,
        atol=1e-14,
    )
    end = float(fall.y[0, -1])
    scene, block = _scene(tilt, theta, "velocity", located, 1.0, 1.0)
    return Problem(
        scene,
        until,
        share * until,
        lambda history: abs(float(history["tilt"][-1]) - end) / (end - tilt),
        bound=4 * share,
        probes={"tilt": lambda: float(block.rotation)},
        deepest=BLOCK.width * share,
    )
