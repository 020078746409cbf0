# SPDX-License-Identifier: LGPL-3.0-or-later
"""Exact derivatives of runs, through impacts and friction: tangents and adjoints of the discrete
steps. What is not supported is refused by name, where a derivative does not exist it is told."""

from .kinks import Kink, NoDerivative
from .materials import Material, Modulus
from .parameters import Gravity, Law, Mass, ObstacleShift, Parameter, Start
from .quantities import At, Centre, Kinetic, Quantity, Turn
from .sensitivities import Adjoints, Tangents, adjoints, tangents

__all__ = [
    "Adjoints",
    "At",
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
    "Quantity",
    "Start",
    "Tangents",
    "Turn",
    "adjoints",
    "tangents",
]
