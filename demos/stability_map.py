# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # Stability maps
#
# **The question.** A method that is accurate at the settings of its paper may fail where it is
# stiff or extreme: a step of a whole swing, a nearly rigid or nearly incompressible solid, a
# friction coefficient of ten, a tilt of ten nanoradians, a body ten thousand times as heavy as the
# one beneath, fifty cells against one, a clearance of a nanometre. What happens there, cell by cell
# of a grid over two such arguments? And does a failure say that it is one?
#
# ## The classes
#
# | class | meaning |
# |---|---|
# | within error | finished, and the error is below the stated bound |
# | refused | before the first step, with a reason |
# | off | finished, but above the bound, or an error of 100 % and more whatever the bound |
# | stopped | ended early, with a reason in `history.reason` (or by the time limit) |
# | energy created | the total rose above that of the start: never acceptable |
# | nonsense | numbers not finite, books that do not close, a body inside: never acceptable |
#
# ## The bounds
#
# A bound must follow from what is expected, not from what comes out: a uniform step rounds an
# impact to its end, so the rocking block is of first order with a factor that counts the impacts;
# a wave front widens by numerical diffusion and dispersion as the modified equation says; a block
# at rest, a slope, a percussion, the patch test between two meshes are exact but for round-off; a
# rod that slides down its tube has an exact speed whatever the clearance, by momentum. Each is
# stated where the problem is: in `problems`, beside this file. In the longest steps it may be 100 %
# and more: there "within error" says that books close and nothing is inside. These are counted.

# %%
from pathlib import Path
from typing import Any

import numpy as np
from problems.maps import MAPS

from fenicsx_contact.output.report import quick_asked, whence, write_summary, write_table
from fenicsx_contact.study import CLASSES, Map, Verdict, run_maps, summary

RESULTS = Path("results") / "stability_map"

# %% [markdown]
# ## The lines that run it
#
# Each cell runs in a worker process with a time limit, and is written to a file of JSON lines as it
# ends: a run that was stopped goes on where it was. Another axis is one more
# `Map(name, title, problem, Axis(...), Axis(...))`.


# %%
def run(quick: bool = False) -> tuple[list[Map], dict[str, list[Verdict]]]:
    """Judge all cells; with ``quick`` four maps of at most 3 x 3."""
    quickly = ("tilt_dt_located", "incline", "painleve", "squeezed_young_nu")
    maps = [m.thinned(3) for m in MAPS if m.name in quickly] if quick else MAPS
    return maps, run_maps(maps, RESULTS / "cells.jsonl", limit=300.0)


# %% [markdown]
# ## Figures and table


# %%
def draw(maps: list[Map], verdicts: dict[str, list[Verdict]]) -> None:
    """All maps, six to a figure."""
    from fenicsx_contact.output import plots
    from fenicsx_contact.study.plots import class_legend, stability_map

    for page, first in enumerate(range(0, len(maps), 6), start=1):
        shown = maps[first : first + 6]
        fig, axes = plots.grid(2, 3, size=(13, 8))
        for ax, chart in zip(np.ravel(axes), shown):
            stability_map(ax, chart, [v.kind for v in verdicts[chart.name]])
        for ax in np.ravel(axes)[len(shown) :]:
            ax.set_visible(False)
        class_legend(fig)
        plots.save(fig, RESULTS / f"maps_{page}.png")


def table(maps: list[Map], verdicts: dict[str, list[Verdict]]) -> str:
    """Counts of each map, and of all, as Markdown."""
    rows = ["| map | cells | within error | refused | off | stopped | energy created | nonsense |"]
    rows.append("|---|---|---|---|---|---|---|---|")
    everything = [v for m in maps for v in verdicts[m.name]]
    for title, some in [*((m.title, verdicts[m.name]) for m in maps), ("**all**", everything)]:
        rows.append(f"| {title} | " + " | ".join(str(n) for n in summary(some).values()) + " |")
    return "\n".join(rows)


def totals(result: dict[str, Any]) -> str:
    """The counts of all maps, and the cells that are not good, as Markdown."""
    rows = [f"| {result['cells']} cells in {len(result['maps'])} maps | |", "|---|---|"]
    rows += [f"| {kind.replace('_', ' ')} | {result[kind]} |" for kind in CLASSES]
    rows.insert(3, f"| of these by a bound of 100 % and more | {result['loosely_bounded']} |")
    for bad in result["not_good"]:
        cell = ", ".join(f"{key} = {value}" for key, value in bad["cell"].items())
        reason = "" if bad["reason"] == "finished" else bad["reason"]
        rows.append(f"| {bad['class']}: {bad['map']}, {cell} | {reason} |")
    return "\n".join(rows)


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    maps, verdicts = run(quick)
    counts = summary(v for some in verdicts.values() for v in some)
    bad = [
        {"map": m.name, "cell": cell, "class": v.kind, "error": v.error, "bound": v.bound}
        | {"reason": v.reason}
        for m in maps
        for cell, v in zip(m.cells(), verdicts[m.name])
        if v.kind not in ("within_error", "refused")
    ]
    result = {
        **counts,
        "loosely_bounded": sum(
            v.kind == "within_error" and v.bound >= 1 for some in verdicts.values() for v in some
        ),
        "maps": {m.name: summary(verdicts[m.name]) for m in maps},
        "not_good": bad,
    }
    write_summary(RESULTS, result)
    write_table(RESULTS, totals(result), quick)
    draw(maps, verdicts)
    print(table(maps, verdicts))
    for row in bad:
        print(f"{row['map']} {row['cell']}: {row['class']}, {row['reason']}")
    good = counts["within_error"] + counts["refused"]
    print(
        f"{counts['cells']} cells, {100 * good / counts['cells']:.1f} % within the stated error or "
        f"refused; {whence()}; maps in {RESULTS}"
    )
    return result


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - One cell that you doubt, `cell = MAPS[0].cells()[-1]`: `judge(lambda: MAPS[0].problem(**cell))`,
#   with `from fenicsx_contact.study import judge`; `MAPS[0].problem(**cell).run()` is its history.
# - Softer springs: `rocking(tilt=1e-3, share=1e-3, formulation="discrete", stiffness=1e10)`, with
#   `from problems import rocking`; on 1e6 N/m the block sinks in by more than it was tilted.
#
# ## Sources
#
# - A. Klarbring (1990), *Examples of non-uniqueness and non-existence of solutions to quasistatic
#   contact problems with friction*, Ingenieur-Archiv 60, 529-541.
# - P. Painlevé (1895), *Sur les lois du frottement de glissement*, C. R. Acad. Sci. Paris 121.
# - J.J. Moreau (1988), CISM 302, doi:10.1007/978-3-7091-2624-0_1: the percussion that resolves it.
