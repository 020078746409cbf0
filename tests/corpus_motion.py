# SPDX-License-Identifier: LGPL-3.0-or-later
"""Blocks and bars in motion by which a solver is judged, and what is exact of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from corpus_meshes import points_base
from scenes import G, rectangle

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    History,
    RigidSolid,
    Scene,
    ThetaScheme,
)


def standing(
    facets: int,
    law: Any = "velocity",
    theta: float = 0.5,
    *,
    uneven: bool = False,
    dim: int = 2,
    size: Sequence[float] = (0.36, 0.80),
    tilt: float = 0.0,
    floor: float = 0.0,
    friction: float = 0.9,
    located: bool = False,
    **motion: Any,
) -> Scene:
    """A rigid block of 417.6 kg, tilted about an edge of its base or not, over a floor."""
    edge, up = np.zeros(dim), np.eye(dim)[-1]
    edge[0] = -size[0] / 2
    block = RigidSolid(
        points_base(facets, uneven, dim, size),
        mass=417.6,
        gravity=-G * up,
        rotation=tilt if dim == 2 else (0.0, -tilt, 0.0),
        about=edge,
        name="block",
        **motion,
    )
    contact = Contact(block, "base", HalfSpace(floor * up, up), law, friction, name="c")
    return Scene([block], [contact], ThetaScheme(theta), locate_impacts=located)


def landed_energies(history: History, exact: Any) -> np.ndarray:
    """Energy above rest after each landing, over that of the release: at the peak that follows in
    this run, whose swings may be shorter than the exact ones."""
    moments = history.time > np.roll(history.time, 1)  # without impacts, and the release
    height = history["potential"][moments]
    total = height + history["kinetic"][moments]
    peaks = 1 + np.flatnonzero((height[1:-1] >= height[:-2]) & (height[1:-1] > height[2:]))
    rest = 417.6 * G * exact.block.height / 2
    release = history["kinetic"][0] + history["potential"][0]
    return (total[peaks[: len(exact.impact_times) - 1]] - rest) / (release - rest)


# -- a bar dropped under gravity --

BAR = {"length": 10.0, "speed": 30.0, "fall": 20.0, "gravity": 10.0}


def dropped_bar(cells: int, law: Any, theta: float = 0.5, cfl: float = 1.0) -> tuple[Scene, float]:
    """An upright bar, E = 900, rho = 1, dropped from 20 m (Doyen, Ern & Piperno), and its step."""
    length, c = BAR["length"], BAR["speed"]
    bar = ElasticSolid(
        rectangle((1, cells), (1.0, length)),
        youngs_modulus=c**2,
        poisson_ratio=0.0,
        density=1.0,
        gravity=(0, -BAR["gravity"]),
        name="bar",
    )
    floor = HalfSpace((0, -BAR["fall"]), (0, 1))
    contact = Contact(bar, "base", floor, law, name="c")
    return Scene([bar], [contact], ThetaScheme(theta)), cfl * length / cells / c


def spells(time: np.ndarray, bears: np.ndarray, apart: float = 0.7) -> np.ndarray:
    """Start and end of each contact, what is ``apart`` by less counting as one, (m, 2)."""
    at = time[bears]
    breaks = np.flatnonzero(np.diff(at) > apart)
    return np.stack([at[np.r_[0, breaks + 1]], at[np.r_[breaks, len(at) - 1]]], axis=1)


def exact_bar(until: float, cells: int = 1000) -> np.ndarray:
    """Its contacts by characteristics: steps in which a wave crosses a cell solve d'Alembert's
    equation exactly at the nodes; the floor stops the lowest of them."""
    length, c, fall, g = (BAR[key] for key in ("length", "speed", "fall", "gravity"))
    dt = length / cells / c
    old = np.full(cells + 1, fall)
    now = old - g * dt**2 / 2
    bears = []
    for _ in range(round(until / dt)):
        new = np.empty_like(now)
        new[1:-1] = now[2:] + now[:-2] - old[1:-1]
        new[0], new[-1] = 2 * now[1] - old[0], 2 * now[-2] - old[-1]
        new -= g * dt**2
        bears.append(new[0] <= 0)
        new[0] = max(new[0], 0.0)
        old, now = now, new
    return spells(dt * np.arange(2, len(bears) + 2), np.array(bears))
