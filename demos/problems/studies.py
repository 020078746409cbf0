# SPDX-License-Identifier: LGPL-3.0-or-later
"""What ``error_against_run_time.py`` measures. To add one: ``STUDIES["name"] = Study(...)``."""

from __future__ import annotations

from functools import partial
from math import radians

from fenicsx_contact.study import Study, ladder

from . import bar_at_wall, bar_released, bent_drop, hertz, leaning_drop, oscillator, rocking

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

_ELEMENTS = [3, 4, 6, 9]
_LOADED = {"formulation": "velocity", "steps": 10, "drift_correction": 1.0}
_HERTZ_TWO = {
    "gap, newton, condensed": ladder("elements", _ELEMENTS, solver="condensed"),
    "gap, newton, monolithic": ladder("elements", _ELEMENTS, solver="monolithic"),
    "gap, fixed point": ladder("elements", _ELEMENTS, geometry="fixed point"),
    "lagrange": ladder("elements", _ELEMENTS, formulation="lagrange"),
    "velocity, corrected, 10 load steps": ladder("elements", _ELEMENTS, **_LOADED),
}
_HERTZ_ONE = {
    "gap, newton": ladder("elements", [*_ELEMENTS, 14], geometry="newton"),
    "gap, fixed point": ladder("elements", [*_ELEMENTS, 14]),
    "lagrange": ladder("elements", [*_ELEMENTS, 14], formulation="lagrange"),
    "velocity, corrected, 10 load steps": ladder("elements", _ELEMENTS, **_LOADED),
    "velocity, 6 elements, load steps": ladder(
        "steps", [10, 40, 160], elements=6, formulation="velocity"
    ),
}

_DROP = [8e-3, 4e-3, 2e-3, 1e-3]
_LEANING = {
    name: ladder("dt", _DROP, formulation=name)
    for name in ("velocity", "gap", "lagrange", "discrete")
} | {"velocity, theta = 1": ladder("dt", _DROP, theta=1.0)}
_BENT = {
    name: ladder("dt", _DROP[:3], formulation=name)
    for name in ("velocity", "gap", "lagrange", "discrete")
} | {"velocity, theta = 1": ladder("dt", _DROP[:3], theta=1.0)}

_STEPS = [10, 20, 40, 80]
_WORST = "the worst of the first three kinetic-energy maxima"
_IMPULSE = "the largest of the wall's impulse at any time"
_PRESSURE = "the pressure in L2"
_DROP_TIME = "the worse of the times to the dashpot and to the end"

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
        Study(
            "hertz",
            "Hertz: two cylinders",
            _PRESSURE,
            hertz,
            _HERTZ_TWO,
            over="elements",
        ),
        Study(
            "hertz_plane",
            "Hertz: a cylinder on a rigid plane",
            _PRESSURE,
            partial(hertz, bodies=1),
            _HERTZ_ONE,
            over="elements",
        ),
        Study(
            "rod_drop",
            "Rod drop in a leaning tube",
            _DROP_TIME,
            leaning_drop,
            _LEANING,
        ),
        Study(
            "rod_drop_bent",
            "Rod drop in an S with a kink",
            _DROP_TIME + ", against the velocity law's own at 0.5 ms",
            bent_drop,
            _BENT,
        ),
    )
}
