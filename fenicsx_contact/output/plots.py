# SPDX-License-Identifier: LGPL-3.0-or-later
"""Curves, by matplotlib."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

from .inline import show

#: One colour for each formulation, the same in all figures.
COLOURS = {
    "velocity": "C3",
    "velocity, impacts located": "C1",
    "gap": "C0",
    "lagrange": "C6",
    "discrete": "C2",
}


def figure(
    rows: int = 1, columns: int = 1, size: tuple[float, float] = (7, 4), *, sharey: bool = True
) -> tuple[Any, Any]:
    """A figure and its axes (one, or an array of them)."""
    return plt.subplots(rows, columns, figsize=size, sharex=True, sharey=sharey, squeeze=True)


def grid(rows: int, columns: int, size: tuple[float, float]) -> tuple[Any, Any]:
    """A figure of axes that share nothing, with room between them."""
    return plt.subplots(rows, columns, figsize=size, gridspec_kw={"hspace": 0.5, "wspace": 0.3})


def save(fig: Any, path: Path) -> Path:
    """Write a figure and close it; in a notebook it is shown, too."""
    path.parent.mkdir(parents=True, exist_ok=True)
    fig.savefig(path, dpi=150, bbox_inches="tight")
    plt.close(fig)
    return show(path)


def thinned(*arrays: np.ndarray) -> list[np.ndarray]:
    """Every so many entries of arrays that hold more than a figure can show, 4000 points."""
    step = max(1, len(arrays[0]) // 4000)
    return [array[::step] for array in arrays]


def animate_curves(
    path: Path,
    frames: int,
    draw: Callable[[Any, int], None],
    size: tuple[float, float] = (5, 5),
) -> Path:
    """An animation (GIF) of curves: ``draw(axes, i)`` draws the i-th frame on cleared axes.

    A PNG of the first frame is put beside it.
    """
    from matplotlib.animation import FuncAnimation, PillowWriter

    path.parent.mkdir(parents=True, exist_ok=True)
    fig, axes = plt.subplots(figsize=size, layout="constrained")

    def frame(i: int) -> None:
        axes.clear()
        draw(axes, i)

    frame(0)
    fig.savefig(path.with_suffix(".png"), dpi=100)
    FuncAnimation(fig, frame, frames).save(path, PillowWriter(fps=15), dpi=100)
    plt.close(fig)
    return show(path)
