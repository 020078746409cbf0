# SPDX-License-Identifier: LGPL-3.0-or-later
"""Elastic bars at a wall: exact solutions of Doyen, Ern & Piperno (2011) and of Chouly, Hild &
Renard (2015), without any loss of energy."""

from __future__ import annotations

from typing import Any

import numpy as np

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    EnergyMomentum,
    HalfSpace,
    History,
    HyperelasticSolid,
    Scene,
    ThetaScheme,
    neo_hookean,
)
from fenicsx_contact.solids.deformable import DeformableSolid
from fenicsx_contact.study import Problem

from .shapes import rectangle


def front_width(cells: int, cfl: float, theta: float, forces: str, travelled: float) -> float:
    """Expected error of an impulse: how wide a front has become, over the contact of 2 L/c.

    By the modified equation a front that has travelled s is sqrt(2 D s/c) wide by numerical
    diffusion, D = c² dt times theta - 1/2 (forces at the theta-point) or theta/2 (at the end),
    and (3 q s)^(1/3) by dispersion, q = (h² + (c dt)²/2)/12, Gibbs' ripples behind it as wide
    again. The velocity law stops a node of mass h/2, and an impact is rounded to a step.
    All lengths over the bar's.
    """
    h, step = 1 / cells, cfl / cells
    diffusion = step * (max(theta - 0.5, 0.0) if forces == "theta" else theta / 2)
    dispersion = (3 * (h**2 + step**2 / 2) / 12 * travelled) ** (1 / 3)
    width = np.sqrt(2 * diffusion * travelled) + 2 * dispersion
    return float((width + step + h) / 2)


def impulse_error(history: History, contact: str, axis: int, exact: Any, total: float) -> float:
    """Largest error of a contact's impulse so far, over the whole impulse."""
    impulse = history.impulse(contact)[:, axis]
    return float(np.abs(impulse - exact(history.time)).max() / total)


def bar_at_wall(
    *,
    cells: int = 40,
    cfl: float = 1.0,
    theta: float = 0.5,
    forces: str = "theta",
    formulation: str = "velocity",
    massless: bool = False,
    step_error: float | None = None,
    speed: float = 1 / 3,
    aspect: float = 1.0,
    hyperelastic: bool = False,
    along_strain: bool = False,
    normal_augmentation: float = 1.0,
    allow_growth: bool = False,
) -> Problem:
    """A bar thrown at a rigid wall: reaction rho c v for 2 L/c, then rigid flight; E = 900 Pa,
    rho = 1 kg/m³, L = 10 m, no gravity. Error: the largest of the wall's impulse at any time.

    Bound: see the width of a front; nonlinear elasticity adds its strain, ``speed``, which
    changes modulus and length at first order (3 times in all for neo-Hooke's law).

    Args:
        cells: along the bar.
        cfl: cells that a wave crosses in a step.
        theta, forces, formulation, step_error, normal_augmentation, allow_growth: as usual.
        massless: whether the mass of the contact node is moved inwards.
        speed: of the bar over that of its waves.
        aspect: length over height of a cell.
        hyperelastic: neo-Hooke's law in place of Hooke's.
        along_strain: the energy-momentum scheme in place of theta.
    """
    length, c = 10.0, 30.0
    height = length / cells / aspect
    contact_time = 2 * length / c
    gap = 0.1 * contact_time * speed * c
    material: dict[str, Any] = {"youngs_modulus": c**2, "poisson_ratio": 0.0}
    kind: Any = ElasticSolid
    if hyperelastic:
        kind, material = HyperelasticSolid, {"energy": neo_hookean(c**2, 0.0)}
    bar: DeformableSolid = kind(
        rectangle(length, height, (cells, 1)),
        **material,
        density=1.0,
        mass_redistribution=["left"] if massless else [],
        velocity=lambda x: np.stack([-speed * c + 0 * x[0], 0 * x[1]]),
    )
    wall = HalfSpace((-length / 2 - gap, 0), (1, 0))
    contact = Contact(
        bar, "left", wall, formulation, name="wall", normal_augmentation=normal_augmentation
    )
    reaction = c * speed * c * height
    start = 0.1 * contact_time

    def exact(time: np.ndarray) -> np.ndarray:
        return reaction * np.clip(time - start, 0, contact_time)

    nonlinear = 3 * speed if hyperelastic else 0.0
    dt = length / cells / c * cfl
    scheme = EnergyMomentum() if along_strain else ThetaScheme(theta, forces)
    return Problem(
        Scene([bar], [contact], scheme, allow_growth=allow_growth),
        until=1.5 * contact_time,
        dt=dt,
        error=lambda history: impulse_error(history, "wall", 0, exact, reaction * contact_time),
        bound=front_width(cells, cfl, theta, forces, 2.0) + nonlinear,
        deepest=2 * speed * c * dt + 1e-9 * length,
        step_error=step_error,
    )


def bar_released(
    *,
    cells: int = 40,
    cfl: float = 1.0,
    theta: float = 0.5,
    forces: str = "theta",
    formulation: str = "velocity",
    massless: bool = False,
    step_error: float | None = None,
) -> Problem:
    """A bar fixed at one end and released stretched by half: contact in [1, 2], [4, 5], [7, 8]
    with the reaction 1/2; E = rho = L = 1. Error: the largest of the wall's impulse at any time.

    Args:
        as for :func:`bar_at_wall`.
    """
    height = 1 / cells
    bar = ElasticSolid(
        rectangle(1.0, height, (cells, 1)),
        youngs_modulus=1.0,
        poisson_ratio=0.0,
        density=1.0,
        fixed=["right"],
        mass_redistribution=["left"] if massless else [],
        displacement=lambda x: np.stack([(0.5 - x[0]) / 2, 0 * x[1]]),
    )
    contact = Contact(bar, "left", HalfSpace((-0.5, 0), (1, 0)), formulation, name="wall")

    def exact(time: np.ndarray) -> np.ndarray:
        return np.sum([height / 2 * np.clip(time - start, 0, 1) for start in (1, 4, 7)], axis=0)

    return Problem(
        Scene([bar], [contact], ThetaScheme(theta, forces)),
        until=9.0,
        dt=cfl / cells,
        error=lambda history: impulse_error(history, "wall", 0, exact, 1.5 * height),
        bound=2 / 3 * front_width(cells, cfl, theta, forces, 8.0),
        deepest=0.5,
        step_error=step_error,
    )
