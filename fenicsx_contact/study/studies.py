# SPDX-License-Identifier: LGPL-3.0-or-later
"""The studies that are shipped. To add one: ``STUDIES["name"] = Study(...)``."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from math import radians
from typing import Any

from .measure import Study
from .problems import bar_at_wall, bar_released, oscillator, rocking


def ladder(name: str, values: Sequence[Any], **fixed: Any) -> list[dict[str, Any]]:
    """Settings that differ in one argument, coarse to fine."""
    return [{name: value, **fixed} for value in values]


#: Steps over the time to the first impact.
_UNIFORM = [1 / 50, 1 / 200, 1 / 800, 1 / 3200]
_LOCATED = [1 / 4, 1 / 8, 1 / 16, 1 / 32]
#: What a step may add to the error, relative to the way.
_ERRORS = [1e-3, 1e-4, 1e-5, 1e-6]

_ROCKING = {
    "velocity": ladder("share", _UNIFORM, theta=0.5),
    "velocity, theta = 1": ladder("share", _UNIFORM, theta=1.0),
    "velocity, impacts located": ladder("share", _LOCATED, located=True),
    "velocity, located, adaptive": ladder("step_error", _ERRORS, share=1.0, located=True),
    "gap": ladder("share", _UNIFORM, formulation="gap", theta=1.0),
    "lagrange": ladder("share", _UNIFORM, formulation="lagrange", theta=1.0),
    "discrete": ladder("share", _UNIFORM, formulation="discrete", theta=1.0),
}

_CELLS = [25, 50, 100, 200]
_BAR = {
    "velocity": ladder("cells", _CELLS),
    "velocity, adaptive": ladder("cells", _CELLS, cfl=4.0, step_error=0.03),
    "velocity, forces at the end": ladder("cells", _CELLS, forces="end"),
    "velocity, theta = 1": ladder("cells", _CELLS, theta=1.0, forces="end"),
    "gap": ladder("cells", _CELLS, formulation="gap"),
    "gap, theta = 1": ladder("cells", _CELLS, formulation="gap", theta=1.0, forces="end"),
    "gap, mass redistributed": ladder("cells", _CELLS, formulation="gap", massless=True),
    "gap, mass redistributed, half steps": ladder(
        "cells", _CELLS, formulation="gap", massless=True, cfl=0.5
    ),
}

_STEPS = [10, 20, 40, 80]
_WORST = "the worst of the first three kinetic-energy maxima"
_IMPULSE = "the largest of the wall's impulse at any time"

STUDIES: dict[str, Study] = {
    study.name: study
    for study in (
        Study(
            "rocking_degree",
            "Rocking block, 0.01 degree",
            _WORST,
            partial(rocking, tilt=radians(0.01)),
            _ROCKING,
        ),
        Study(
            "rocking_radian",
            "Rocking block, 0.01 radian",
            _WORST,
            partial(rocking, tilt=0.01),
            _ROCKING,
        ),
        Study("bar_at_wall", "Bar thrown at a wall", _IMPULSE, bar_at_wall, _BAR),
        Study("bar_released", "Bar released at a wall", _IMPULSE, bar_released, _BAR),
        Study(
            "oscillator",
            "Friction oscillator",
            "the worst turning point",
            oscillator,
            {
                "velocity": ladder("steps", _STEPS),
                "velocity, adaptive": ladder("step_error", [1e-2, *_ERRORS[:3]], steps=5),
                "velocity, forces at the end": ladder("steps", _STEPS, forces="end"),
                "velocity, theta = 1": ladder("steps", _STEPS, theta=1.0, forces="end"),
            },
        ),
    )
}
