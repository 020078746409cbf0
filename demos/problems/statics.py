# SPDX-License-Identifier: LGPL-3.0-or-later
"""A block lies on a slope, without inertia: of any stiffness and size, held by friction or not."""

from __future__ import annotations

from typing import Any

import numpy as np

from fenicsx_contact import Contact, ElasticSolid, HalfSpace, History, QuasiStatic, Scene
from fenicsx_contact.study import Problem

from .block import EXACT
from .shapes import rectangle

#: Distance from the floor at the start over the width of the block.
STARTS = {"open": 1e-4, "touching": 0.0, "overlapping": -1e-4}
#: Each so manieth block has no friction, and one of its sides is held.
HELD = 5


def lying(*, seed: int, start: str = "touching", formulation: str = "velocity") -> Problem:
    """A flat elastic block, ten times as wide as high, lies on a slope that it does not slide on,
    in two steps without inertia. Error: the floor's force over the weight, and the mean
    compression and shear over what the weight makes of them.

    Those are exact whatever the pressure's course is, in any mesh: virtual work of the fields
    ``(0, y)`` and ``(y, 0)``, which do nothing at the base, gives the mean stresses, and without a
    Poisson effect each strain is its own stress over a modulus: ``-rho g H/2E`` normal to the
    slope, ``rho g H/2G`` along it.

    Bound: exact in any scheme, 1e-8, but positions are rounded to 1e-16 of the block's size, whose
    share of its compression is that over the strain, times a thousand.

    Args:
        seed: draws Young's modulus (1e3 to 1e12 Pa), size (1e-6 to 1e3 m), friction (to 3), slope
            (to 0.999 of the friction angle) and strain (1e-8 to 1e-3); each fifth block lies level
            on a smooth floor, one side held.
        start: "open", "touching" or "overlapping".
        formulation: as usual.
    """
    draw = np.random.default_rng(seed)
    modulus, size, strain = 10.0 ** draw.uniform([3, -6, -8], [12, 3, -3])
    friction, share = draw.uniform([0.0, 0.0], [3.0, 0.999])
    cells = tuple(int(n) for n in draw.integers([1, 1], [9, 4]))
    held = seed % HELD == 0
    if held:
        friction = share = 0.0
    angle, height, density = share * np.arctan(friction), 0.1 * size, 1000.0
    gravity = strain * modulus / density / height
    pull = np.array([np.sin(angle), -np.cos(angle)])
    gap = STARTS[start] * size
    sides: dict[str, Any] = {"left": (0.0, None)} if held else {}
    block = ElasticSolid(
        rectangle(size, height, (cells[0], cells[1])),
        youngs_modulus=modulus,
        poisson_ratio=0.0,
        density=density,
        gravity=gravity * pull,
        prescribed=sides,
        name="block",
    )
    floor = HalfSpace((0, -gap), (0, 1))
    contact = Contact(block, "base", floor, formulation, friction, name="floor")
    weight = density * gravity * size * height

    def error(history: History) -> float:
        force = np.array([history["floor.force_x"][-1], history["floor.force_y"][-1]])
        x, u = block.mesh.mesh.geometry.x[:, :2], block.fields()["displacement"]

        def mean(axis: int, end: float) -> np.ndarray:
            side = np.abs(x[:, axis] - end) < 1e-6 * height
            order = np.argsort(x[side, 1 - axis])
            values = u[side][order]
            return (values[:-1] + values[1:]).mean(axis=0) / 2

        across = (mean(1, height) - mean(1, 0.0)) / height
        along = (mean(0, size / 2) - mean(0, -size / 2)) / size
        found = np.array([across[0] + along[1], across[1]])
        off = found - strain / 2 * pull * [2.0, 1.0]
        return float(max(np.abs(force / weight + pull).max(), np.abs(off).max() / (strain / 2)))

    return Problem(
        Scene([block], [contact], QuasiStatic()),
        2.0,
        1.0,
        error,
        EXACT + 1e-13 / strain,
        energy_size=weight * strain * height,
        supplied=weight * abs(gap),
        deepest=abs(gap) + strain * height + 1e-9 * size,
    )
