# SPDX-License-Identifier: LGPL-3.0-or-later
"""Drops of a control rod (Code_Aster, FDNL100; tubes of BEAVRS) in water: down a leaning straight
tube, where the drop of one degree of freedom is exact, and down a tube bent into an S."""

from __future__ import annotations

from functools import cache, partial
from math import asin, cos, sin
from typing import Any

import numpy as np

from fenicsx_contact import (
    BeamSolid,
    Discrete,
    Fall,
    Gap,
    GuideTubeWater,
    History,
    Lagrange,
    Scene,
    Section,
    ThetaScheme,
    Velocity,
    axis_mesh,
)
from fenicsx_contact.references.rod import one_dof_drop
from fenicsx_contact.rods import Card, Guide, GuideContact, Sine, Tube, settle, time_at
from fenicsx_contact.study import Problem
from fenicsx_contact.theory.formulations import Formulation

from .shapes import G

#: Depth of the tip at release, travels to the dashpot (T5) and to the end, length, clearance, m.
INSIDE, TRAVELS, LENGTH, CLEARANCE = 0.22, (3.05, 3.61), 3.86, 0.775e-3
MASS, BENDING, FRICTION = 126.4176, 850.0, 0.3  # kg, N m², -
#: The laws; the springs sink by micrometres, their dashpots are about critical.
LAWS: dict[str, Formulation] = {
    "velocity": Velocity(drift_correction=0.1),
    "gap": Gap(),
    "lagrange": Lagrange(),
    "discrete": Discrete(stiffness=1e6, damping=20.0),
}
#: Step of the reference of the S: a quarter of the finest that is measured against it.
FINE = 5e-4


def _times(history: History) -> np.ndarray:
    """When the rod passed the travels, s."""
    return np.array([time_at(history, travel) for travel in TRAVELS])


def _problem(
    rod: BeamSolid, guide: Guide, exact: Any, dt: float, formulation: str, theta: float
) -> Problem:
    contact = GuideContact(rod, "rod", guide, LAWS[formulation], FRICTION, name="guide")
    return Problem(
        Scene([rod], [contact], ThetaScheme(theta)),
        4.0,
        dt,
        lambda history: float(np.abs(_times(history) / exact() - 1).max()),
        probes={"travel": lambda: rod.travel, "speed": lambda: rod.speed},
        deepest=CLEARANCE,
        stop_when=lambda: rod.travel >= TRAVELS[1],
    )


def _rod(cells: int, lean: float = 0.0) -> BeamSolid:
    """All of the cluster's mass in its rods."""
    return BeamSolid(
        axis_mesh((0, -INSIDE), (0, 1), rod=(LENGTH, cells)),
        Section(mass=MASS / LENGTH, bending=BENDING),
        gravity=(G * sin(lean), -G * cos(lean)),
        law=Fall(GuideTubeWater()),
        name="rod",
    )


def leaning_drop(
    *, dt: float, formulation: str = "velocity", theta: float = 0.5, cells: int = 39
) -> Problem:
    """The tube leans by arcsin 0.25; the rod lies on its wall and slides with mu = 0.3, so it is
    held back by mu m g sin(phi) (93 N) all the way. Error: the worse of the times to the dashpot
    and to the end, against the exact drop of one degree of freedom.

    Args:
        dt: s.
        formulation, theta: as usual.
        cells: of the rod.
    """
    lean = asin(0.25)
    rod = _rod(cells, lean)
    rod.deflect(np.full((cells + 1, 1), CLEARANCE))
    held = FRICTION * MASS * G * sin(lean)
    exact, _ = one_dof_drop(
        TRAVELS, mass=MASS, water=GuideTubeWater(), force=held, gravity=G * cos(lean)
    )
    guide = Guide([Tube(-LENGTH, INSIDE + TRAVELS[1] + 0.2, CLEARANCE)])
    return _problem(rod, guide, lambda: exact, dt, formulation, theta)


def bent_drop(
    *, dt: float, formulation: str = "velocity", theta: float = 0.6, cells: int = 39
) -> Problem:
    """The tube is an S of 10 mm with a kink under a straight guide of 0.9 m and nine cards. There
    is no exact solution: error of the same two times against the velocity law's own at a step of
    0.5 ms (a self-reference: it shows what steps cost, and where the laws differ, not the truth).

    Args:
        dt, formulation, theta, cells: as for :func:`leaning_drop`.
    """
    rod, guide = _rod(cells), _s_guide()
    settle(rod, "rod", guide)
    return _problem(rod, guide, partial(_fine_times, cells), dt, formulation, theta)


def _s_guide() -> Guide:
    cards = [Card(-0.9 - 0.28 * (i + 1), 0.5e-3) for i in range(9)]
    end = INSIDE + TRAVELS[1] + 0.2
    bent = Tube(0.0, end, CLEARANCE, Sine(10e-3, 3.66, "kinked"))
    return Guide([*cards, Tube(-0.9, 0.0, 0.5e-3), bent])


@cache
def _fine_times(cells: int) -> np.ndarray:
    return _times(bent_drop(dt=FINE, cells=cells).run())
