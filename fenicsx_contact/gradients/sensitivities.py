# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs with their derivatives: tangents (forwards) and adjoints (backwards)."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import contextmanager

from typing import Any
from collections.abc import Iterator

import numpy as np

from ..base import checks
from ..output.history import History
from ..scene import Scene
from ..steps.step import Trial
from .blocks import LinearStep, Solver
from .linearise import Linearisation
from .parameters import Parameter


def tangents(scene, until, dt, parameters, **options):
    lin = Linearisation(scene, list(parameters.values()))
    state = [lin.start()]
    solver = Solver()
    rows=[state[0]]
    def watch(trial):
        step = lin.step(trial)
        x = step.tangent(solver, state[0])
        state[0] = x[: lin.size]
        rows.append(state[0])
    scene.stepper.watchers.append(watch)
    try:
        history = scene.run(until, dt, **options)
    finally:
        scene.stepper.watchers.remove(watch)
    return history, lin, rows, solver
