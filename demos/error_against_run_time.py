# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # Error against run time
#
# **The question.** Which method is worth its time? A table of errors at one step tells nothing: a
# method may be twice as accurate and ten times as slow. What counts is the error that a given run
# time buys, so: run each method with coarse and fine settings and plot one against the other. The
# methods that no other beats in both form the *front*.
#
# ## The problems
#
# All but one have an exact solution: the rocking block (Housner 1963) at the paper's angle and at
# Code_Aster's, a bar thrown at a wall (Doyen, Ern & Piperno 2011), a bar released against a wall
# (Chouly, Hild & Renard), the friction oscillator (Code_Aster, SDND100), two cylinders and a
# cylinder on a plane (Hertz 1881), and the control rod that slides down a leaning tube, which is a
# problem of one degree of freedom. In the bent tube it has none: there the reference is the
# velocity law's own at a fine step, which shows the cost of steps and the distance of the laws, not
# the truth. They stand, with what is compared, in `problems`, beside this file.
#
# ## What is measured
#
# Run time is that of the time loop alone, the median of repeated runs; building the scene and
# fetching its compiled forms stand apart, in the column "set-up". The rate is fitted to the errors
# over the number of steps; for Hertz, where time only orders the loads, over that of elements. What
# fails stays in the table, with its reason. A bar's front jumps: the error is the largest of the
# wall's *impulse* at any time, for a reaction that jumps has no better norm in which a numerical
# one converges.

# %%
import sys
from pathlib import Path
from typing import Any

from problems.studies import STUDIES

from fenicsx_contact.output.report import quick_asked, whence, write_summary, write_table
from fenicsx_contact.study import Sample, Study, measure, pareto, rate, table

RESULTS = Path("results") / "error_against_run_time"

# %% [markdown]
# ## The lines that measure
#
# A study is a function that makes a problem, and ladders of its arguments. Another one is added by
# `STUDIES["name"] = Study(name, title, quantity, build, methods)`.


# %%
def run(study: Study, quick: bool = False) -> list[Sample]:
    """Measure a study; with ``quick`` the two coarsest settings of each method, once."""
    from tqdm import tqdm

    chosen = study.shortened() if quick else study
    total = sum(len(settings) for settings in chosen.methods.values())
    with tqdm(total=total, desc=study.title, disable=not sys.stderr.isatty()) as bar:
        return measure(chosen, 1 if quick else 3, lambda _: bar.update())


# %% [markdown]
# ## Figures


# %%
def draw(study: Study, samples: list[Sample]) -> None:
    """Dots: all samples; lines: each method's front; grey: the front of all."""
    from fenicsx_contact.output import plots
    from fenicsx_contact.study.plots import fronts

    fig, ax = plots.figure(size=(6.5, 4.5))
    fronts(ax, samples)
    ax.set_title(f"{study.title}\nerror of {study.quantity}", fontsize=8)
    ax.set_ylabel("relative error")
    plots.save(fig, RESULTS / f"{study.name}.png")


HEAD = """| scene | method | coarse: error, time | fine: error, time | rate |
|---|---|---|---|---|"""


def ends(study: Study, samples: list[Sample]) -> list[str]:
    """The coarsest and the finest run of each method on the front, as rows of a table."""
    rows: list[str] = []
    for method in dict.fromkeys(sample.method for sample in pareto(samples)):
        mine = [s for s in samples if s.method == method and s.error == s.error]
        title = "" if rows else study.title
        first, last = mine[0], mine[-1]
        cells = [f"{s.error:.2g}, {s.run_time_s:.2g} s" for s in (first, last)]
        rows.append(f"| {title} | {method} | {' | '.join(cells)} | {rate(mine, study.over):.1f} |")
    return rows


def main(quick: bool = False) -> dict[str, Any]:
    """All studies; returns the summary that is also written: for each study and method a list of
    samples, and beside the studies the rates and fronts of all."""
    summary: dict[str, Any] = {"rates": {}, "front": {}}
    rows = [HEAD]
    for study in STUDIES.values():
        samples = run(study, quick)
        draw(study, samples)
        methods = dict.fromkeys(sample.method for sample in samples)
        summary[study.name] = {
            method: [s.as_dict() for s in samples if s.method == method] for method in methods
        }
        summary["rates"][study.name] = {
            method: rate((s for s in samples if s.method == method), study.over)
            for method in methods
        }
        summary["front"][study.name] = [(s.method, s.setting) for s in pareto(samples)]
        print(f"\n### {study.title}: error of {study.quantity}\n\n{table(samples, study.over)}")
        rows += ends(study, samples)
        write_summary(RESULTS, summary)
        write_table(RESULTS, "\n".join(rows), quick)
    print(
        f"\nmedians of {1 if quick else 3} runs; * on the front; {whence()}; figures in {RESULTS}"
    )
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - A study of your own beside those of `problems/studies.py`, by another ladder (it is of
#   `fenicsx_contact.study`): `ladder("theta", [0.5, 0.6, 0.7], share=1e-3)` for the block.
# - There, `bar_at_wall` with a `cfl` other than 1: a wave is no longer carried from node to node.
#
# ## Sources
#
# - Those of `rocking_block.py`, `bar_impact.py`, `stick_slip.py`, `hertz.py` and `rod_drop.py`.
