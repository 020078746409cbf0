# SPDX-License-Identifier: LGPL-3.0-or-later
"""Curves; the only module that imports matplotlib."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.colors
import matplotlib.patches
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


def thinned(*arrays: np.ndarray, points: int = 4000) -> list[np.ndarray]:
    """Every so many entries of arrays that hold more points than a figure can show."""
    step = max(1, len(arrays[0]) // points)
    return [array[::step] for array in arrays]


def error_against_run_time(axes: Any, results: dict[str, Sequence[tuple[float, float]]]) -> None:
    """A log-log plot of (run time [s], error) for each method."""
    for name, pairs in results.items():
        seconds, errors = np.array(pairs).T
        axes.loglog(seconds, errors, "o-", color=COLOURS.get(name), label=name)
    axes.set_xlabel("run time of the loop [s]")
    axes.set_ylabel("relative error")
    axes.grid(True, which="both", alpha=0.3)
    axes.legend()


def fronts(
    axes: Any,
    samples: Sequence[Any],
    pareto: Callable[[Sequence[Any]], Sequence[Any]],
    colours: dict[str, str] | None = None,
) -> None:
    """Error against run time, log-log: all samples of a study as dots, each method's front as a
    line, the front of all of them in grey behind.

    Args:
        axes: to draw in.
        samples: of a study, with ``method``, ``run_time_s`` and ``error``.
        pareto: those of samples that no other beats (:func:`fenicsx_contact.study.pareto`).
        colours: of methods, where :data:`COLOURS` has none.
    """
    known = {**COLOURS, **(colours or {})}
    others = (f"C{i}" for i in range(10) if f"C{i}" not in known.values())
    best = pareto(samples)
    axes.loglog([s.run_time_s for s in best], [s.error for s in best], color="0.85", lw=7, zorder=0)
    for method in dict.fromkeys(s.method for s in samples):
        mine = [s for s in samples if s.method == method and np.isfinite(s.error)]
        colour = known.get(method) or next(others, None)
        front = pareto(mine)
        (line,) = axes.loglog(
            [s.run_time_s for s in front], [s.error for s in front], color=colour, label=method
        )
        axes.loglog(
            [s.run_time_s for s in mine], [s.error for s in mine], "o", ms=4, color=line.get_color()
        )
    axes.set_xlabel("run time of the loop [s]")
    axes.set_ylabel("error")
    axes.grid(True, which="both", alpha=0.3)
    axes.legend(fontsize=7)


#: Colours of the classes of a stability map, from good to never acceptable.
CLASS_COLOURS = {
    "within_error": "#4c9f70",
    "refused": "#9ecae1",
    "off": "#f2c14e",
    "stopped": "#b8b8b8",
    "energy_created": "#d62728",
    "nonsense": "#000000",
}


def stability_map(axes: Any, chart: Any, kinds: Sequence[str]) -> None:
    """One map: a coloured square for each cell.

    Args:
        axes: to draw in.
        chart: a :class:`fenicsx_contact.study.Map`.
        kinds: the classes of its cells, in their order.
    """
    names = list(CLASS_COLOURS)
    x, y = chart.x, chart.y
    grid = np.array([names.index(kind) for kind in kinds]).reshape(len(y.values), len(x.values))
    colours = matplotlib.colors.ListedColormap(list(CLASS_COLOURS.values()))
    axes.pcolormesh(grid, cmap=colours, vmin=-0.5, vmax=len(names) - 0.5, ec="white", lw=1)

    def text(value: Any) -> str:
        return f"{value:.4g}" if isinstance(value, float) else str(value)

    axes.set_xticks(np.arange(len(x.values)) + 0.5, [text(v) for v in x.values], rotation=60)
    axes.set_yticks(np.arange(len(y.values)) + 0.5, [text(v) for v in y.values])
    axes.tick_params(labelsize=6)
    axes.set_xlabel(x.label, fontsize=7)
    axes.set_ylabel(y.label, fontsize=7)
    axes.set_title(chart.title, fontsize=8)


def class_legend(fig: Any) -> None:
    """The legend of the classes, below a figure of maps."""
    patches = [
        matplotlib.patches.Patch(color=colour, label=kind.replace("_", " "))
        for kind, colour in CLASS_COLOURS.items()
    ]
    fig.legend(handles=patches, loc="lower center", ncols=len(patches), fontsize=8)


def animate_curves(
    path: Path,
    frames: int,
    draw: Callable[[Any, int], None],
    size: tuple[float, float] = (5, 5),
    fps: int = 15,
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
    FuncAnimation(fig, frame, frames).save(path, PillowWriter(fps=fps), dpi=100)
    plt.close(fig)
    return show(path)
