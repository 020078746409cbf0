# SPDX-License-Identifier: LGPL-3.0-or-later
"""Single frictional problems: taken from a scene, solved by themselves, kept in FCLib's files."""

from .export import frictional_problem
from .fclib import FclibFile, read_fclib, write_fclib
from .problem import FrictionalProblem, FrictionalSolution

__all__ = [
    "FclibFile",
    "FrictionalProblem",
    "FrictionalSolution",
    "frictional_problem",
    "read_fclib",
    "write_fclib",
]
