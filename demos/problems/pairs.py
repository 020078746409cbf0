# SPDX-License-Identifier: LGPL-3.0-or-later
"""Two bodies of unlike mass, stiffness and mesh: they collide, lie on each other, are pressed."""

from __future__ import annotations

from typing import Any

import numpy as np

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    History,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
)
from fenicsx_contact.solve.newton import Newton
from fenicsx_contact.study import Problem

from .bar import front_width, impulse_error
from .block import EXACT
from .shapes import FLOOR, G, rectangle


def collision(
    *,
    mass_ratio: float,
    cells: int = 20,
    cfl: float = 1.0,
    theta: float = 0.5,
    forces: str = "theta",
    formulation: str = "velocity",
    allow_growth: bool = False,
) -> Problem:
    """An elastic bar strikes another one at rest, of the same length and wave speed, along both.
    With impedances ``Z = rho c`` the seam moves at ``V = Z1 v/(Z1 + Z2)`` under ``Z2 V`` until both
    waves are back, 2 L/c; then the bars part at ``v``, as point masses do that lose no energy
    (d'Alembert; St. Venant 1867). L = 10 m, c = 30 m/s, v = c/30. Error: the largest of the seam's
    impulse at any time.

    Bound: the width of a front, as for :func:`~.bar.bar_at_wall`, whatever the masses.

    Args:
        mass_ratio: mass of the bar that strikes over that of the other; stiffnesses likewise.
        cells: along each bar.
        cfl: cells that a wave crosses in a step.
        theta, forces, formulation, allow_growth: as usual.
    """
    length, c, speed = 10.0, 30.0, 1.0
    width, duration = length / cells, 2 * length / c
    gap, dt = 0.1 * duration * speed, length / cells / c * cfl

    def bar(name: str, low: float, density: float, velocity: float) -> ElasticSolid:
        return ElasticSolid(
            rectangle(width, length, (1, cells), low),
            youngs_modulus=density * c**2,
            poisson_ratio=0.0,
            density=density,
            velocity=lambda x: np.stack([0 * x[0], velocity + 0 * x[0]]),
            name=name,
        )

    struck = bar("struck", 0.0, 1.0, 0.0)
    thrown = bar("thrown", length + gap, mass_ratio, -speed)
    contact = Contact(thrown, "base", (struck, "top"), formulation, name="seam")
    force = width * c * speed * mass_ratio / (1 + mass_ratio)

    def exact(time: np.ndarray) -> np.ndarray:
        return force * np.clip(time - 0.1 * duration, 0, duration)

    return Problem(
        Scene([struck, thrown], [contact], ThetaScheme(theta, forces), allow_growth=allow_growth),
        1.5 * duration,
        dt,
        lambda history: impulse_error(history, "seam", 1, exact, force * duration),
        front_width(cells, cfl, theta, forces, 2.0),
        deepest=2 * speed * dt + 1e-9 * length,
    )


def stacked(
    *,
    mass_ratio: float,
    dt: float = 1e-3,
    steps: int = 100,
    formulation: str = "velocity",
    friction: float = 0.3,
) -> Problem:
    """A rigid block lies on another one on a floor. Error: of both contacts' forces over the
    weights that they bear, each less one, and motion over the size.

    Bound: exact in any scheme, 1e-8; the lighter weight beneath the heavier one is a difference
    of forces, of which round-off takes 1e-15 times the ratio. They may move, and sink in, by what
    Newton's tolerance leaves of the speed g dt in every step; how much of it is round-off's choice.

    Args:
        mass_ratio: upper mass over the lower one, 100 kg.
        dt, steps: s, -.
        formulation, friction: as usual.
    """
    lower, upper = 100.0, 100.0 * mass_ratio
    low = RigidSolid(rectangle(1.0, 0.5, (4, 1)), mass=lower, gravity=(0, -G), name="low")
    high = RigidSolid(
        rectangle(0.7, 0.5, (3, 1), low=0.5), mass=upper, gravity=(0, -G), name="high"
    )
    contacts = [
        Contact(low, "base", FLOOR, formulation, friction, name="floor"),
        Contact(high, "base", (low, "top"), formulation, friction, name="seam"),
    ]
    blocks = (low, high)
    start = [block.place for block in blocks]
    left = Newton().tolerance * G * dt * steps * dt

    def error(history: History) -> float:
        weights = {"floor": (lower + upper) * G, "seam": upper * G}
        off = [np.abs(history[f"{name}.force_y"][1:] / w - 1).max() for name, w in weights.items()]
        moved = [np.abs(block.place - place).max() for block, place in zip(blocks, start)]
        return float(max(*off, *moved))

    return Problem(
        Scene([low, high], contacts, ThetaScheme(1.0)),
        steps * dt,
        dt,
        error,
        EXACT + 1e-15 * max(mass_ratio, 1 / mass_ratio) + left,
        energy_size=(lower + upper) * G,
        deepest=1e-9 + left,
    )


def pressed(
    *,
    mesh_ratio: float = 1.0,
    stiffness_ratio: float = 1.0,
    poisson_ratio: float = 0.3,
    formulation: str = "gap",
    geometry: str = "newton",
    solver: str | None = None,
) -> Problem:
    """The patch test: two blocks, a metre wide and half as high, between smooth side walls, the
    upper one moved down by a thousandth of its height: each is strained uniaxially, with the
    modulus ``E (1 - nu)/((1 + nu)(1 - 2 nu))``, and the pressure is the same everywhere. Error: the
    worst nodal pressure.

    Bound: the elements hold the solution, and in the plane the mortar integrals are exact, 1e-8;
    a solve loses 1e-16 times its condition number, which grows with the square of the cells and
    the ratio of the moduli and 1/(1 - 2 nu), times ten. Gaps are differences of coordinates, which
    are rounded to 2e-16 m; such an error is worth the stiffer modulus over the finer cells.

    Args:
        mesh_ratio: cells of the upper block, the slave, along the seam over those of the lower
            one; the coarser has two.
        stiffness_ratio: Young's modulus of the upper block over that of the lower, 1e9 Pa.
        poisson_ratio: of both.
        formulation, geometry, solver: as usual.
    """
    height, strain, coarse = 0.5, 1e-3, 2
    cells = [round(coarse * max(1.0, ratio)) for ratio in (1 / mesh_ratio, mesh_ratio)]
    moduli = [1e9, 1e9 * stiffness_ratio]
    depth = strain * height
    motions: list[dict[str, Any]] = [
        {"base": (None, 0.0)},
        {"top": lambda t: (None, -depth * t)},
    ]
    lower, upper = (
        ElasticSolid(
            rectangle(1.0, height, (n, 2), low),
            youngs_modulus=modulus,
            poisson_ratio=poisson_ratio,
            density=1.0,
            prescribed={"left": (0.0, None), "right": (0.0, None), **motion},
            name=name,
        )
        for name, n, low, modulus, motion in zip(
            ("lower", "upper"), cells, (0.0, height), moduli, motions
        )
    )
    contact = Contact(upper, "base", (lower, "top"), formulation, name="seam")
    confined = (1 - poisson_ratio) / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))
    pressure = confined * depth / height / sum(1 / modulus for modulus in moduli)

    def error(history: History) -> float:
        return float(np.abs(contact.force[:, 1] / contact.surface.area / pressure - 1).max())

    condition = max(cells) ** 2 * max(stiffness_ratio, 1 / stiffness_ratio)
    condition /= 1 - 2 * poisson_ratio
    return Problem(
        Scene([lower, upper], [contact], QuasiStatic(), geometry=geometry, solver=solver),
        1.0,
        1.0,
        error,
        EXACT + 1e-15 * condition + 2e-16 * max(cells) * max(moduli) / pressure,
        energy_size=pressure * depth,
        supplied=pressure * depth,
        deepest=depth,
    )
