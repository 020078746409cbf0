# SPDX-License-Identifier: LGPL-3.0-or-later
"""Exact derivatives of runs, through impacts and friction: tangents and adjoints of the discrete
steps. What is not supported is refused by name, where a derivative does not exist it is told."""

from .beam_parameters import DriveLaw, Stiffness, Widening
from .bearing import Force, Pressure
from .kinks import Kink, NoDerivative
from .materials import Damped, Material, Modulus
from .memories import Remembered
from .obstacles import Bend, ObstacleShift, Shape
from .parameters import Gravity, Law, Mass, Parameter, Start
from .passing import Instant, Passing, passing
from .quantities import At, Centre, Kinetic, Quantity, Strain, Travel, Turn
from .results import Adjoints, Tangents
from .sensitivities import adjoints, tangents

__all__ = [
    "Adjoints",
    "At",
    "Bend",
    "Centre",
    "Damped",
    "DriveLaw",
    "Force",
    "Gravity",
    "Instant",
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
    "Pressure",
    "Quantity",
    "Remembered",
    "Shape",
    "Start",
    "Stiffness",
    "Strain",
    "Tangents",
    "Travel",
    "Turn",
    "Widening",
    "adjoints",
    "passing",
    "tangents",
]
