# SPDX-License-Identifier: LGPL-3.0-or-later
"""What ``stability_map.py`` runs. To add an axis: another entry of ``MAPS``.

Bounds are those of the problems' docstrings.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

import problems
from fenicsx_contact.study import Axis, Map, Problem


def decades(low: float, high: float, count: int) -> list[float]:
    """Values evenly spread over powers of ten, both exponents included."""
    return [float(f"{value:.3g}") for value in np.logspace(low, high, count)]


def rocking_or_toppling(*, tilt: float, **others: Any) -> Problem:
    """The block at any tilt: :func:`rocking` below the tipping angle, :func:`toppling` above."""
    if tilt < problems.rocking_angle:
        return problems.rocking(tilt=tilt, **others)
    return problems.toppling(tilt=tilt, **others)


DT = "step / time to first impact"
FRICTION = Axis("friction", [0, 0.1, 0.3, 0.6, 1, 1.5, 2, 3, 5, 10], "friction [-]")
THETA = Axis("theta", [0, 0.25, 0.45, 0.5, 0.55, 0.75, 1.0], "theta [-]")
NU = Axis("poisson_ratio", [0.0, 0.2, 0.3, 0.45, 0.49, 0.499, 0.4999], "Poisson's ratio [-]")
ASPECT = Axis("aspect", decades(-3, 3, 7), "length / height of a cell [-]")
RHO_N = Axis("normal_augmentation", decades(-6, 6, 7), "rho_n / its scale [-]")
RHO_T = Axis("tangential_augmentation", decades(-6, 6, 7), "rho_t / its scale [-]")
TILT = Axis(
    "tilt",
    [1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 0.3, 0.42, 0.43, 0.6],
    "tilt [rad]; tipping at 0.423",
)
CFL = Axis("cfl", decades(-2.5, 1.5, 9), "cells that a wave crosses in a step")
YOUNG = Axis("youngs_modulus", decades(6, 16, 11), "Young's modulus [Pa]")
LAWS = Axis("formulation", ["velocity", "gap", "lagrange"], "formulation")
MASS = Axis("mass_ratio", decades(-4, 4, 9), "mass of one body / of the other")
MESH = Axis(
    "mesh_ratio",
    [0.02, 0.05, 0.15, 0.5, 1.0, 2.0, 7.0, 20.0, 50.0],
    "cells of the slave / of the master",
)
SEED = Axis("seed", list(range(100)), "E, size, friction, slope and strain drawn by number")
START = Axis("start", ["open", "touching", "overlapping"], "start")
CLEARANCE = Axis("clearance", decades(-7, 0, 8), "clearance / diameter of the rod")

MAPS: list[Map] = [
    Map(
        "rocking_theta_dt",
        "Rocking block, velocity",
        partial(problems.rocking, tilt=1e-3, impacts=1),
        Axis("share", decades(-4.5, -0.5, 9), DT),
        THETA,
    ),
    Map(
        "rocking_formulation_dt",
        "Rocking block, theta = 1",
        partial(problems.rocking, tilt=1e-3, impacts=2, theta=1.0),
        Axis("share", decades(-3.5, -1.5, 5), DT),
        Axis("formulation", ["velocity", "gap", "lagrange", "discrete"], "formulation"),
    ),
    Map(
        "tilt_dt",
        "Rocking and toppling",
        partial(rocking_or_toppling),
        Axis("share", decades(-3, -1.5, 4), DT),
        TILT,
    ),
    Map(
        "tilt_dt_located",
        "Rocking and toppling, impacts located",
        partial(rocking_or_toppling, located=True),
        Axis("share", [0.01, 0.03, 0.1, 0.3], DT),
        TILT,
    ),
    Map(
        "rocking_rho",
        "Rocking block",
        partial(problems.rocking, tilt=1e-3, share=2e-3),
        RHO_N,
        RHO_T,
    ),
    Map(
        "bar_theta_cfl",
        "Bar at a wall, velocity, forces at theta",
        partial(problems.bar_at_wall, cells=20),
        CFL,
        THETA,
    ),
    Map(
        "bar_theta_cfl_end",
        "Bar at a wall, velocity, forces at the end",
        partial(problems.bar_at_wall, cells=20, forces="end"),
        CFL,
        THETA,
    ),
    Map(
        "bar_theta_cfl_massless",
        "Bar at a wall, gap, mass redistributed",
        partial(problems.bar_at_wall, cells=20, formulation="gap", massless=True),
        CFL,
        THETA,
    ),
    Map(
        "bar_aspect_cfl",
        "Bar at a wall, velocity",
        partial(problems.bar_at_wall, cells=20),
        Axis("cfl", decades(-1, 1, 5), CFL.label),
        ASPECT,
    ),
    Map(
        "bar_speed",
        "Neo-Hookean bar at a wall, velocity",
        partial(problems.bar_at_wall, cells=20, hyperelastic=True),
        Axis("cfl", [0.1, 0.3, 1.0], CFL.label),
        Axis("speed", decades(-6, 0, 7), "speed / wave speed [-]"),
    ),
    Map(
        "bar_speed_along_strain",
        "Neo-Hookean bar at a wall, velocity, energy-momentum",
        partial(problems.bar_at_wall, cells=20, hyperelastic=True, along_strain=True),
        Axis("cfl", [0.1, 0.3, 1.0], CFL.label),
        Axis("speed", decades(-6, 0, 7), "speed / wave speed [-]"),
    ),
    Map("squeezed_young_nu", "Square between planes", problems.squeezed, YOUNG, NU),
    Map("squeezed_aspect_nu", "Block between planes", problems.squeezed, ASPECT, NU),
    Map(
        "squeezed_young_dt",
        "Square between planes",
        problems.squeezed,
        Axis("periods", decades(0.5, 4.5, 5), "step / time of a wave"),
        YOUNG,
    ),
    Map(
        "sliding_young_dt",
        "Elastic block sliding to rest",
        problems.sliding_elastic,
        Axis("share", decades(-3, -1, 5), "step / time to rest"),
        YOUNG,
    ),
    Map("sliding_rho", "Elastic block sliding to rest", problems.sliding_elastic, RHO_N, RHO_T),
    Map(
        "sliding_friction_speed",
        "Rigid block sliding to rest",
        problems.sliding_rigid,
        FRICTION,
        Axis("speed", decades(-3, 3, 7), "speed [m/s]"),
    ),
    Map(
        "incline",
        "Block on a slope",
        problems.incline,
        FRICTION,
        Axis("slope", [0.01, 0.2, 0.5, 0.9, 1.2, 2.5, 8.0], "tangent of the slope"),
    ),
    Map(
        "klarbring",
        "Klarbring's node, coming to rest",
        problems.klarbring,
        FRICTION,
        Axis("dt", [0.3, 1.0, 3.0, 10.0, 30.0], "step [s]"),
    ),
    Map(
        "painleve",
        "Painleve's rod",
        problems.painleve,
        FRICTION,
        Axis("angle", [15, 30, 45, 60, 70, 80, 88], "angle to the floor [degree]"),
    ),
    Map(
        "at_rest",
        "Rigid block at rest",
        problems.at_rest,
        Axis("dt", decades(-5, 1, 7), "step [s]"),
        Axis("gravity", [0.0, *decades(-6, 6, 7)], "gravity [m/s²]"),
    ),
    Map("lying", "Elastic block on a slope, static", problems.lying, SEED, START),
    Map(
        "dropped",
        "Rigid block falling flat",
        problems.dropped,
        Axis("share", decades(-4, -1, 4), "step [s]"),
        Axis("speed", decades(-3, 3, 7), "speed [m/s]"),
    ),
    Map(
        "dropped_located",
        "Rigid block falling flat, impacts located",
        partial(problems.dropped, located=True),
        Axis("share", decades(-4, -1, 4), "step [s]"),
        Axis("speed", decades(-3, 3, 7), "speed [m/s]"),
    ),
    Map(
        "sliding_gravity_speed",
        "Rigid block sliding, gravity down to none",
        partial(problems.sliding_rigid, friction=0.3),
        Axis("gravity", [0.0, *decades(-6, 6, 7)], "gravity [m/s²]"),
        Axis("speed", decades(-3, 3, 7), "speed [m/s]"),
    ),
    Map(
        "collision_mass_dt",
        "Two bars collide, velocity",
        problems.collision,
        MASS,
        Axis("cfl", decades(-1, 1.5, 6), CFL.label),
    ),
    Map(
        "collision_mass_law",
        "Two bars collide, theta = 1",
        partial(problems.collision, theta=1.0, forces="end"),
        MASS,
        LAWS,
    ),
    Map(
        "stacked_mass_dt",
        "Rigid block on another, velocity",
        problems.stacked,
        MASS,
        Axis("dt", decades(-6, 0, 7), "step [s]"),
    ),
    Map("stacked_mass_law", "Rigid block on another", problems.stacked, MASS, LAWS),
    Map(
        "pressed_mesh_stiffness",
        "Two blocks pressed, patch test",
        problems.pressed,
        MESH,
        Axis("stiffness_ratio", decades(-4, 4, 9), "Young's modulus of slave / of master"),
    ),
    Map("pressed_mesh_nu", "Two blocks pressed, patch test", problems.pressed, MESH, NU),
    Map(
        "pressed_mesh_law",
        "Two blocks pressed, fixed point",
        partial(problems.pressed, geometry="fixed point"),
        MESH,
        Axis("formulation", ["gap", "lagrange"], "formulation"),
    ),
    Map(
        "tube_clearance_friction",
        "Rod in a leaning tube, velocity",
        problems.leaning_tube,
        CLEARANCE,
        FRICTION,
    ),
    Map(
        "tube_clearance_dt",
        "Rod in a leaning tube, velocity",
        problems.leaning_tube,
        CLEARANCE,
        Axis("share", decades(-3.5, -0.5, 7), "step [s]"),
    ),
    Map(
        "tube_clearance_law",
        "Rod in a leaning tube",
        problems.leaning_tube,
        CLEARANCE,
        LAWS,
    ),
    Map(
        "bent_clearance_amplitude",
        "Rod bent by a sine",
        problems.bent_rod,
        CLEARANCE,
        Axis("amplitude", [1.0, 2.0, 5.0, 10.0, 20.0, 30.0], "amplitude of the sine [mm]"),
    ),
]
