# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # A map of control-rod drops
#
# **The question.** In 2009 one drop took 100 hours. What does the drop time look like over a whole
# plane of what one does not know, the friction coefficient and the amplitude of the bow?
#
# ## The problem
#
# The drop of `rod_drop.py`, with its rod, guide and water, for 13 coefficients of friction and 9
# amplitudes of an S with a kinked inlet: 117 drops. Where the rod jams there is no drop time, and
# the map says so.
#
# ## How
#
# Every drop is independent, so each process of the machine takes the next one. A finished drop is a
# line in `drops.jsonl`: a map that was stopped goes on where it was.

# %%
from pathlib import Path
from typing import Any

import numpy as np
from rod_drop import BOTTOM, DASHPOT, Assumed, drop

from fenicsx_contact.output.report import quick_asked, write_summary
from fenicsx_contact.study import batch

RESULTS = Path("results") / "rod_drop_map"
FRICTION = np.round(np.linspace(0.0, 0.6, 13), 3)
AMPLITUDE = np.round(np.linspace(0.0, 16e-3, 9), 5)
DT, PATIENCE = 1e-3, 4.0  # s; T5 differs by 0.01 % from that at a tenth of the step

# %% [markdown]
# ## One drop, and many


# %%
def one(friction: float, amplitude: float, dt: float) -> dict[str, Any]:
    """A drop: what the file has of it beside its numbers."""
    case = Assumed(friction=friction, amplitude=amplitude, kinked=True)
    fallen = drop(case, dt=dt, until=PATIENCE)
    return {
        "T5_s": fallen.time_at(DASHPOT),
        "total_s": fallen.time_at(BOTTOM),
        "travel_m": fallen.rod.travel,
        "run_time_s": fallen.history.run_time,
        "reason": fallen.history.reason,
    }


def compute(
    frictions: np.ndarray, amplitudes: np.ndarray, dt: float
) -> dict[tuple[float, float], dict[str, Any]]:
    """All drops, over the machine's processes, with a bar; those on file are not repeated."""
    cases = [
        {"friction": float(f), "amplitude": float(a), "dt": dt}
        for f in frictions
        for a in amplitudes
    ]
    found = batch(one, cases, RESULTS / "drops.jsonl", progress=True)
    return {(drop["friction"], drop["amplitude"]): drop for drop in found}


# %% [markdown]
# ## The map


# %%
def draw(drops: dict[tuple[float, float], dict[str, Any]]) -> None:
    """T5 and total over friction and amplitude; crosses where the rod jams."""
    from fenicsx_contact.output import plots

    frictions, amplitudes = (np.unique([case[i] for case in drops]) for i in (0, 1))
    fig, axes = plots.figure(1, 2, size=(10, 4))
    for ax, what, title in zip(axes, ("T5_s", "total_s"), ("to the dashpot", "in all")):
        values = np.array([[drops[f, a][what] for f in frictions] for a in amplitudes])
        shown = np.ma.masked_invalid(values)
        picture = ax.contourf(frictions, 1e3 * amplitudes, shown, 20, cmap="viridis")
        lines = ax.contour(frictions, 1e3 * amplitudes, shown, [1.52], colors="w", linewidths=1.5)
        ax.clabel(lines, fmt="%.2f s")
        jammed = [(f, 1e3 * a) for (f, a), r in drops.items() if not np.isfinite(r[what])]
        if jammed:
            ax.plot(*np.transpose(jammed), "rx", label=f"not within {PATIENCE:g} s")
            ax.legend(fontsize=7)
        fig.colorbar(picture, ax=ax, label="time [s]")
        ax.set_xlabel("coefficient of friction")
        ax.set_title(f"drop time {title}", fontsize=9)
    axes[0].set_ylabel("amplitude of the S, kinked inlet [mm]")
    plots.save(fig, RESULTS / "map.png")


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    if quick:
        drops = compute(FRICTION[[0, 6]], AMPLITUDE[[0, 5]], 4e-3)
    else:
        drops = compute(FRICTION, AMPLITUDE, DT)
    results = list(drops.values())
    fallen = [r for r in results if np.isfinite(r["total_s"])]
    summary = {
        "drops": len(results),
        "jammed": len(results) - len(fallen),
        "T5_s": [min(r["T5_s"] for r in fallen), max(r["T5_s"] for r in fallen)],
        "total_s": [min(r["total_s"] for r in fallen), max(r["total_s"] for r in fallen)],
        "run_time_s": sum(r["run_time_s"] for r in results),
        "map": results,
    }
    write_summary(RESULTS, summary)
    draw(drops)
    print(
        f"{summary['drops']} drops in {summary['run_time_s']:.0f} s of computing: T5 from "
        f"{summary['T5_s'][0]:.3f} to {summary['T5_s'][1]:.3f} s, {summary['jammed']} jammed"
    )
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - Stop it and start it again: the bar begins where it was.
# - `Assumed(kinked=False)`: a smooth inlet, and the map goes nearly flat.
# - Another pair of unknowns: the clearance of the cards, the friction of the drive line.
#
# ## Sources
#
# Those of `rod_drop.py`.
