# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rods in guides of any clearance: one that slides down a leaning tube, one bent by a sine."""

from __future__ import annotations

from math import asin, cos, inf, pi, sin

import numpy as np

from fenicsx_contact import (
    BeamSolid,
    Fall,
    Gap,
    History,
    Lagrange,
    Scene,
    Section,
    Support,
    ThetaScheme,
    Velocity,
    axis_mesh,
)
from fenicsx_contact.references.rod import endless_insertion_force
from fenicsx_contact.rods import Guide, GuideContact, Sine, Straight, Tube, settle
from fenicsx_contact.study import Problem
from fenicsx_contact.theory.formulations import Formulation

from .block import EXACT
from .shapes import G

#: The 24 rods of a cluster in parallel (Code_Aster, FDNL100), and the diameter of one (BEAVRS).
BENDING, LENGTH, DIAMETER = 850.0, 3.86, 9.68e-3  # N m², m, m
RODS = Section(mass=16.662, bending=BENDING)
#: The laws as rods need them: gaps that were caught off the wall close.
LAWS: dict[str, Formulation] = {
    "velocity": Velocity(drift_correction=0.1),
    "gap": Gap(),
    "lagrange": Lagrange(),
}


def leaning_tube(
    *,
    clearance: float,
    friction: float = 0.3,
    share: float = 1e-3,
    formulation: str = "velocity",
    theta: float = 1.0,
    cells: int = 20,
) -> Problem:
    """A rod let go in the middle of a straight tube that leans by arcsin 0.1. It falls on the
    wall, and slides: by momentum the wall has taken ``m g sin(phi) t`` when it lies, wherever it
    was, and friction mu of it. So its speed is ``g t (cos(phi) - mu sin(phi))`` for any clearance,
    or it sticks. Error: of the speed after 1 s over g t.

    Bound: momentum is exact, 1e-8; but a uniform step may stop the rod as high as v dt above the
    wall, from where it falls again: mu times sqrt(2 g sin(phi) v dt) over g t, v the speed at which
    it lands and what a step adds; and the solver's 1e-10 of its speed, mu times, in each step.

    Args:
        clearance: radial, over the diameter of the rod.
        friction: Coulomb's coefficient.
        share: step over 1 s.
        formulation, theta: as usual.
        cells: of the rod.
    """
    lean = asin(0.1)
    across, along, free = G * sin(lean), G * cos(lean), clearance * DIAMETER
    rod = BeamSolid(
        axis_mesh((0, 0), (0, 1), rod=(LENGTH, cells)),
        RODS,
        gravity=(across, -along),
        law=Fall(),
        name="rod",
    )
    guide = Guide([Tube(-LENGTH - 1, 10.0, free, Straight())])
    contact = GuideContact(rod, "rod", guide, LAWS[formulation], friction, name="guide")
    exact = max(0.0, along - friction * across)
    lands = np.sqrt(2 * across * free) + across * share
    again = np.sqrt(2 * across * share * lands)
    return Problem(
        Scene([rod], [contact], ThetaScheme(theta)),
        1.0,
        share,
        lambda history: abs(rod.speed / float(history.time[-1]) - exact) / G,
        EXACT + friction * again / G + 1e-10 * friction / share,
        energy_size=rod.mass * G * DIAMETER,
        deepest=0.05 * free + across * share**2,
    )


def bent_rod(*, clearance: float, amplitude: float = 10.0, cells: int = 37) -> Problem:
    """Half a wavelength, 1.83 m, of an endless rod, at rest in a sine with clearance: it is pressed
    against the crests by its own stiffness. Error: of the sum of the normal forces, against
    :func:`~fenicsx_contact.references.rod.endless_insertion_force`.

    Bound: walls are met at the nodes, so curvatures are off by (k h)², k the wave number, and the
    height of a crest between two of them by a (k h)²/8; settling leaves 1e-4 c: both of the way by
    which the rod is bent, a - c. A rod that fits unbent bears nothing: its error is over the force
    at no clearance.

    Args:
        clearance: radial, over the diameter of the rod.
        amplitude: of the sine, mm.
        cells: over half a wavelength.
    """
    wave, high, free = 3.66, 1e-3 * amplitude, clearance * DIAMETER
    rod = BeamSolid(
        axis_mesh((0, -wave / 2), (0, 1), rod=(wave / 2, cells)),
        RODS,
        supports=[Support(0, lateral=inf, axial=inf), Support(wave / 2, lateral=inf)],
        name="rod",
    )
    guide = Guide([Tube(-0.01, wave / 2 + 0.01, free, Sine(high, wave, "kinked"))])
    settle(rod, "rod", guide)
    contact = GuideContact(rod, "rod", guide, LAWS["velocity"], name="guide")
    exact = endless_insertion_force(high, free, wave, BENDING) / 2
    whole = endless_insertion_force(high, 1e-9 * high, wave, BENDING) / 2
    coarse = (pi / cells) ** 2
    left = (1e-4 * free + coarse / 8 * high) / abs(high - free)
    period = rod.matrices.slowest_period()

    def error(history: History) -> float:
        return abs(contact.normal_force() - exact) / (exact or whole)

    return Problem(
        Scene([rod], [contact], ThetaScheme(1.0, "end")),
        10 * period,
        period,
        error,
        coarse + left,
        energy_size=whole * high,
        supplied=1e-4 * whole * free,
        deepest=0.05 * free + 1e-9,
    )
