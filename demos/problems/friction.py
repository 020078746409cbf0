# SPDX-License-Identifier: LGPL-3.0-or-later
"""Slopes, sliding blocks and the friction oscillator: exact solutions of Coulomb's law."""

from __future__ import annotations

from math import atan, cos, pi, sin

import numpy as np

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    History,
    HyperelasticSolid,
    RigidSolid,
    Scene,
    ThetaScheme,
)
from fenicsx_contact.study import Problem

from .block import EXACT
from .shapes import FLOOR, G, rectangle


def sliding_rigid(
    *, friction: float, speed: float, share: float = 0.01, gravity: float = G
) -> Problem:
    """A flat rigid block thrown along a floor stops after v/(mu g) at v²/(2 mu g), or, without
    friction or gravity, never. Error: of the distance, at 1.2 times the time to rest (1 s).

    Bound: the stop is rounded to a step, at a vanishing speed: the step over the time to rest,
    squared, doubled; without a stop 1e-8.

    Args:
        friction: Coulomb's coefficient.
        speed: m/s.
        share: step over the time to rest.
        gravity: m/s².
    """
    stops = friction * gravity > 0
    rest = speed / (friction * gravity) if stops else 1.0
    block = RigidSolid(
        rectangle(20.0, 0.05, (4, 1)), mass=10.0, gravity=(0, -gravity), velocity=(speed, 0)
    )
    contact = Contact(block, "base", FLOOR, friction=friction)
    start = float(block.place[0])
    way = speed * rest * (0.5 if stops else 1.2)

    def error(history: History) -> float:
        return abs(float(history["x"][-1]) / way - 1)

    return Problem(
        Scene([block], [contact]),
        1.2 * rest,
        share * rest,
        error,
        bound=2 * share**2 + EXACT if stops else EXACT,
        probes={"x": lambda: float(block.place[0]) - start},
        deepest=1e-6 + 1e-15 * way,  # what the last digit of the way is
    )


def incline(*, friction: float, slope: float, steps: int = 50) -> Problem:
    """A rigid block on a slope sticks if its tangent is at most mu, else slides with
    g (sin - mu cos). Error: of the speed after 1 s over g. Bound: exact in the scheme, 1e-8.

    Args:
        friction: Coulomb's coefficient.
        slope: tangent of the slope's angle.
        steps: to 1 s.
    """
    angle = atan(slope)
    exact = G * max(0.0, sin(angle) - friction * cos(angle))
    block = RigidSolid(
        rectangle(20.0, 0.05, (4, 1)), mass=10.0, gravity=(G * sin(angle), -G * cos(angle))
    )
    return Problem(
        Scene([block], [Contact(block, "base", FLOOR, friction=friction)]),
        1.0,
        1.0 / steps,
        lambda history: abs(float(block.velocity[0]) - exact) / G,
        EXACT,
        energy_size=10.0 * G,
        deepest=1e-6,
    )


def sliding_elastic(
    *,
    youngs_modulus: float = 1e8,
    poisson_ratio: float = 0.3,
    share: float = 0.01,
    theta: float = 1.0,
    forces: str = "end",
    normal_augmentation: float = 1.0,
    tangential_augmentation: float = 1.0,
) -> Problem:
    """An elastic block, one metre square, thrown along a floor at 2 m/s, unloaded at the start;
    mu = 0.3. Error: of the distance of its centre of mass, v²/(2 mu g) if it were rigid.

    Bound: it is out of balance for some periods of its waves, in which the floor's impulse is off
    by the weight times a period: 4 (dt + H/c) over the time to rest, c of shear waves, in which
    it leans as well.

    Args:
        youngs_modulus, poisson_ratio: Pa, -.
        share: step over the time to rest.
        theta, forces, normal_augmentation, tangential_augmentation: as usual.
    """
    friction, speed, rho = 0.3, 2.0, 1000.0
    rest = speed / friction / G
    block = ElasticSolid(
        rectangle(1.0, 1.0, (4, 4)),
        youngs_modulus=youngs_modulus,
        poisson_ratio=poisson_ratio,
        density=rho,
        gravity=(0, -G),
        velocity=lambda x: np.stack([speed + 0 * x[0], 0 * x[1]]),
    )
    contact = Contact(
        block,
        "base",
        FLOOR,
        friction=friction,
        normal_augmentation=normal_augmentation,
        tangential_augmentation=tangential_augmentation,
    )
    way = speed * rest / 2
    # N: a cell is strained by the difference of two u, each rounded in its last digit
    noise = 2 * 1.1e-16 * youngs_modulus * way * 4
    shear = np.sqrt(youngs_modulus / (2 + 2 * poisson_ratio) / rho)
    return Problem(
        Scene([block], [contact], ThetaScheme(theta, forces)),
        1.5 * rest,
        share * rest,
        lambda history: abs(float(history["x"][-1]) / way - 1),
        bound=4 * (share + 1 / shear / rest),
        probes={"x": lambda: float(block.mean(block.displacement)[0])},
        round_off=noise * way / (rho * speed**2 / 2),
        deepest=0.01 + 10 * rho * G / youngs_modulus,
    )


def oscillator(
    *, steps: int, theta: float = 0.5, forces: str = "theta", step_error: float | None = None
) -> Problem:
    """The friction oscillator (Code_Aster, SDND100): released at 0.85 mm it turns at -0.65, 0.45,
    -0.25, 0.05 mm and sticks. Error: the worst turning point or rest, over 0.85 mm.

    Spring and mass are one cell that resists shear only, held at its top: the moving mass is a
    third of its own, 1 kg, the stiffness its shear modulus, 1e4 N/m; mu N = 1 N.

    Args:
        steps: to half a period.
        theta, forces, step_error: as usual.
    """
    half = pi / 100  # s
    turns = np.array([-0.65, 0.45, -0.25, 0.05]) * 1e-3
    solid = HyperelasticSolid(
        rectangle(1.0, 1.0),
        energy=lambda F: 1e4 / 2 * F[0, 1] ** 2,
        density=3.0,
        gravity=(0.0, -20 / 3),
        fixed=["top"],
        displacement=lambda x: np.stack([0.85e-3 * (1 - x[1]), 0 * x[1]]),
    )
    foot = int(np.flatnonzero(solid.displacement)[0])

    def error(history: History) -> float:
        x, swing = history["x"], history.time / half
        swings = [x[(swing > k - 0.5) & (swing < k + 0.5)] for k in (1, 2, 3, 4)]
        found = [f(swing) for f, swing in zip((np.min, np.max) * 2, swings)]
        off = np.abs(np.array([*found, x[-1]]) - [*turns, turns[-1]])
        return float(off.max() / 0.85e-3)

    return Problem(
        Scene([solid], [Contact(solid, "base", FLOOR, friction=0.1)], ThetaScheme(theta, forces)),
        until=6 * half,
        dt=half / steps,
        error=error,
        probes={"x": lambda: float(solid.displacement[foot])},
        step_error=step_error,
    )
