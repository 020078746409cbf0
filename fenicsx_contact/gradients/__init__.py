# SPDX-License-Identifier: LGPL-3.0-or-later
"""Exact derivatives of runs, through impacts and friction: tangents and adjoints of the discrete
steps. What is not supported is refused by name, where a derivative does not exist it is told."""

from .kinks import Kink, NoDerivative
from .materials import Material, Modulus
from .parameters import Bend, Gravity, Law, Mass, ObstacleShift, Parameter, Start
from .passing import Passing, passing
from .quantities import At, Centre, Kinetic, Quantity, Strain, Travel, Turn
from .sensitivities import Adjoints, Tangents, adjoints, tangents

__all__ = [
    "Adjoints",
    "At",
    "Bend",
    "Centre",
    "Gravity",
    "Kinetic",
    "Kink",
    "Law",
    "Mass",
    "Material",
    "Modulus",
    "NoDerivative",
    "ObstacleShift",
    "Parameter",
    "Passing",
    "Quantity",
    "Start",
    "Strain",
    "Tangents",
    "Travel",
    "Turn",
    "adjoints",
    "passing",
    "tangents",
]
