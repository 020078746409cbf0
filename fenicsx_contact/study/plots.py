# SPDX-License-Identifier: LGPL-3.0-or-later
"""Figures of studies and maps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib.colors
import matplotlib.patches
import numpy as np

from ..output.plots import COLOURS
from .maps import Map
from .measure import Sample, pareto

#: Colours of the classes of a stability map, from good to never acceptable.
CLASS_COLOURS = {
    "within_error": "#4c9f70",
    "refused": "#9ecae1",
    "off": "#f2c14e",
    "stopped": "#b8b8b8",
    "energy_created": "#d62728",
    "nonsense": "#000000",
}


def error_against_run_time(axes: Any, results: dict[str, Sequence[tuple[float, float]]]) -> None:
    """A log-log plot of (run time [s], error) for each method."""
    for name, pairs in results.items():
        seconds, errors = np.array(pairs).T
        axes.loglog(seconds, errors, "o-", color=COLOURS.get(name), label=name)
    axes.set_xlabel("run time of the loop [s]")
    axes.set_ylabel("relative error")
    axes.grid(True, which="both", alpha=0.3)
    axes.legend()


def fronts(axes: Any, samples: Sequence[Sample]) -> None:
    """Error against run time, log-log: all samples of a study as dots, each method's front as a
    line, the front of all of them in grey behind.

    Args:
        axes: to draw in.
        samples: of a study.
    """
    others = (f"C{i}" for i in range(10) if f"C{i}" not in COLOURS.values())
    best = pareto(samples)
    axes.loglog([s.run_time_s for s in best], [s.error for s in best], color="0.85", lw=7, zorder=0)
    for method in dict.fromkeys(s.method for s in samples):
        mine = [s for s in samples if s.method == method and np.isfinite(s.error)]
        colour = COLOURS.get(method) or next(others, None)
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


def stability_map(axes: Any, chart: Map, kinds: Sequence[str]) -> None:
    """One map: a coloured square for each cell.

    Args:
        axes: to draw in.
        chart: the map.
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
