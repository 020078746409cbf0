# SPDX-License-Identifier: LGPL-3.0-or-later
"""Blocks that lie, fall flat, or are squeezed: what is trivial must stay so in extreme cases."""

from __future__ import annotations

import numpy as np

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    History,
    RigidSolid,
    Scene,
    ThetaScheme,
)
from fenicsx_contact.study import Problem

from .shapes import FLOOR, G, rectangle

#: Relative error to which what is exact in the scheme must be computed.
EXACT = 1e-8


def at_rest(
    *, gravity: float = G, dt: float = 1e-3, steps: int = 200, friction: float = 0.3
) -> Problem:
    """A rigid block lies on a floor; error: its motion over its size, and the floor's force over
    the weight less one. Bound: exact in any scheme, 1e-8, and the round-off of the way that it
    would fall in a step, 1e-13 of it.

    Args:
        gravity: m/s²; 0 leaves a block that touches and must not notice.
        dt: step, s.
        steps: how many.
        friction: Coulomb's coefficient.
    """
    block = RigidSolid(rectangle(1.0, 0.5, (4, 1)), mass=100.0, gravity=(0, -gravity))
    contact = Contact(block, "base", FLOOR, friction=friction, name="floor")
    start = block.place

    def error(history: History) -> float:
        moved = max(float(np.abs(history[what]).max()) for what in ("x", "y", "turn"))
        weight = 100.0 * gravity
        off = np.abs(history["floor.force_y"][1:] - weight).max()
        return max(moved, float(off) / (weight or 1.0))

    probes = {
        "x": lambda: float((block.place - start)[0]),
        "y": lambda: float((block.place - start)[1]),
        "turn": lambda: float(block.rotation),
    }
    round_off = 1e-13 * gravity * dt**2
    size = 100.0 * gravity * 1.0  # the work of the weight over the block's width
    return Problem(
        Scene([block], [contact]),
        steps * dt,
        dt,
        error,
        EXACT + round_off,
        probes,
        energy_size=size or 1.0,
        deepest=1e-9 + round_off,
    )


def dropped(
    *,
    speed: float,
    share: float,
    theta: float = 0.5,
    formulation: str = "velocity",
    located: bool = False,
) -> Problem:
    """A rigid block falls flat on a floor and rests; error: of the impulse m v + m g t, and of the
    rest, after 1 s. Bound: momentum is exact in any scheme, 1e-8; but a uniform step rounds the
    impact to its end, and may stop the block as high as v dt above the floor, from where it falls
    again: sqrt(2 g v dt) over v + g t. With impacts located 1e-8.

    Args:
        speed: at the start, m/s; the block starts where it takes 1/9 s at this speed.
        share: step over 1 s.
        theta, formulation, located: as usual.
    """
    height = speed / 9
    block = RigidSolid(
        rectangle(1.0, 0.5, (4, 1)), mass=100.0, gravity=(0, -G), velocity=(0, -speed)
    )
    contact = Contact(
        block, "base", HalfSpace((0, -height), (0, 1)), formulation, friction=0.3, name="floor"
    )

    def error(history: History) -> float:
        impulse = history.impulse("floor")[-1, 1]
        exact = 100.0 * (speed + G * history.time[-1])
        moving = 100.0 * float(np.abs(block.velocity).max())
        return max(abs(float(impulse) / exact - 1), moving / exact)

    return Problem(
        Scene([block], [contact], ThetaScheme(theta), locate_impacts=located),
        until=1.0,
        dt=share,
        error=error,
        bound=EXACT + (0.0 if located else np.sqrt(2 * G * speed * share) / (speed + G)),
        deepest=2 * share * (speed + G),
    )


def squeezed(
    *,
    youngs_modulus: float = 1e9,
    poisson_ratio: float = 0.3,
    aspect: float = 1.0,
    cells: int = 4,
    normal_augmentation: float = 1.0,
    periods: float = 10.0,
) -> Problem:
    """A square between two rigid planes without friction that are 0.1 % too near: homogeneous
    plane strain, ``lam = -E d/(H (1 - nu²))``. Error: of the mean pressure, after 40 damped steps.

    Bound: the elements hold the solution exactly; a step of many periods leaves (c dt/H)^-40 of
    the transients, so 1e-8, but for what a solve with the condition number of nearly
    incompressible material loses: 1e-16 times 1/(1 - 2 nu), times aspect², times the square of
    the periods in a step, times a hundred.

    Args:
        youngs_modulus, poisson_ratio: Pa, -.
        aspect: length over height of an element.
        cells: along the longer side.
        normal_augmentation: as usual.
        periods: step over the time of a wave through the block.
    """
    squeeze, rho = 1e-3, 1000.0
    n = (cells, cells)
    width, height = (aspect, 1.0) if aspect >= 1 else (1.0, 1 / aspect)
    block = ElasticSolid(
        rectangle(width, height, n),
        youngs_modulus=youngs_modulus,
        poisson_ratio=poisson_ratio,
        density=rho,
    )
    depth = squeeze * min(width, height) / 2
    contacts = [
        Contact(block, name, plane, "gap", name=name, normal_augmentation=normal_augmentation)
        for name, plane in (
            ("base", HalfSpace((0, depth), (0, 1))),
            ("top", HalfSpace((0, height - depth), (0, -1))),
        )
    ]
    exact = youngs_modulus * 2 * depth / height / (1 - poisson_ratio**2) * width

    def error(history: History) -> float:
        forces = history["base.force_y"][-1], -history["top.force_y"][-1]
        return float(np.abs(np.array(forces) / exact - 1).max())

    dt = periods * max(width, height) / np.sqrt(youngs_modulus / rho)
    condition = max(aspect, 1 / aspect) ** 2 * periods**2 / (1 - 2 * poisson_ratio)
    return Problem(
        Scene([block], contacts, ThetaScheme(1.0, "end")),
        40 * dt,
        dt,
        error,
        EXACT + 1e-14 * condition,
        energy_size=exact * depth,
        supplied=2 * exact * depth,
        deepest=2 * depth,
    )
