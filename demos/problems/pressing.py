# SPDX-License-Identifier: LGPL-3.0-or-later
"""Hertz's contact of cylinders (1881): a curved block pressed on a rigid plane or on another block.

The bodies are blocks of 40 half widths and half as high, the one with the base ``x²/(2 R)``, on
grids that grow from the contact outwards: all of a grid is refined by its number of elements, and
what is left of a block's finite size is of the order of (a/W)², 1e-3. The axis stands a quarter of
an element beside a node, so that the two edges of the contact fall on different places of theirs.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    History,
    NamedMesh,
    QuasiStatic,
    Scene,
    Velocity,
)
from fenicsx_contact.references.hertz import LineContact, effective_modulus
from fenicsx_contact.study import Problem

from .shapes import rectangle

#: Half width aimed at and radius, m; half the size of a block and extent of its fine part over it.
AIM, RADIUS, SIZE, FINE = 0.004, 1.0, 40.0, 2.0
E, NU = 1e9, 0.3  # Pa, -
#: How far the top is moved down, m: by so much does a half-plane yield to half of the load that
#: makes AIM, a²/(2 R) (2 log(2 depth/a) - nu/(1 - nu)) (Johnson 1985, 5.57).
APPROACH = AIM**2 / RADIUS / 4 * (2 * np.log(SIZE) - NU / (1 - NU))


def hertz(
    *,
    elements: int,
    bodies: int = 2,
    formulation: str = "gap",
    drift_correction: float = 0.0,
    geometry: str | None = None,
    solver: str | None = None,
    steps: int = 1,
) -> Problem:
    """Two elastic cylinders, or one on a plane, pressed together. Error: of the pressure in L2 over
    the surface, against Hertz's profile for the force that is measured.

    Bound: pressures rise as a square root at an edge that falls anywhere between two nodes:
    ``sqrt(log(n))/n`` in L2, doubled, with n elements over the half width; the finite size, 1e-3.
    The velocity law holds what was caught in a step: 1/steps besides.

    Args:
        elements: over the half width, at the middle.
        bodies: 1 or 2.
        formulation, drift_correction, geometry, solver: as usual.
        steps: in which the load is put on.
    """
    upper = _block("upper", elements, 1.0)
    master: Any = HalfSpace((0, 0), (0, 1))
    solids, modulus = [upper], effective_modulus(E, NU)
    if bodies == 2:
        lower = _block("lower", round(0.8 * elements), -1.0)
        solids, master = [lower, upper], (lower, "top")
        modulus = effective_modulus(E, NU, E, NU)
    law = Velocity(drift_correction) if formulation == "velocity" else formulation
    contact = Contact(upper, "base", master, law, name="seam")

    def error(history: History) -> float:
        exact = LineContact(float(history["seam.force_y"][-1]), modulus, RADIUS)
        area = contact.surface.area
        x = contact.surface.points[:, 0] - _axis(elements)
        p, expected = contact.force[:, 1] / area, exact.pressure(x)
        return float(np.sqrt((area * (p - expected) ** 2).sum() / (area * expected**2).sum()))

    load = LineContact.of_half_width(AIM, modulus, RADIUS).load  # more than is reached
    late = 1 / steps if formulation == "velocity" else 0.0
    return Problem(
        Scene(solids, [contact], QuasiStatic(), geometry=geometry, solver=solver),
        1.0,
        1.0 / steps,
        error,
        2 * np.sqrt(np.log(elements)) / elements + 1e-3 + late,
        supplied=load * APPROACH,
        deepest=AIM**2 / RADIUS,
    )


def _block(name: str, elements: int, up: float) -> ElasticSolid:
    """The curved upper block (``up`` = 1), which is moved down, or the flat lower one."""
    mesh = _grid(elements, up)
    motion: dict[str, Any] = {"top": lambda t: (0.0, -APPROACH * t)} if up > 0 else {}
    return ElasticSolid(
        mesh,
        youngs_modulus=E,
        poisson_ratio=NU,
        density=1.0,
        fixed=[] if up > 0 else ["base"],
        prescribed=motion,
        name=name,
    )


def _grid(elements: int, up: float) -> NamedMesh:
    """A grid with ``elements`` over the half width at the contact, which grows outwards as sinh."""
    fine, growth = FINE * AIM, np.arcsinh(SIZE / FINE)
    count = round(elements * FINE * growth)
    named = rectangle(2.0, 1.0, (2 * count, count), low=0.0 if up > 0 else -1.0)
    x = named.mesh.geometry.x
    x[:, :2] = fine * np.sinh(growth * x[:, :2])
    if up > 0:  # the base is curved, its curvature fades upwards
        height = fine * np.sinh(growth)
        x[:, 1] += (1 - x[:, 1] / height) * (x[:, 0] - _axis(elements)) ** 2 / (2 * RADIUS)
    return named


def _axis(elements: int) -> float:
    """Where the cylinder's axis stands, m."""
    return 0.25 * AIM / elements
