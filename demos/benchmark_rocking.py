# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # Benchmark: the rocking block against compiled rigid-body codes
#
# **The question.** The block of section 3, released at 0.01 degree: what error of the first three
# kinetic-energy maxima does a run time buy, here and in two compiled codes for rigid bodies?
# Siconos steps by Moreau and Jean's scheme with the same law as ours; MuJoCo by its own soft
# contact, made as stiff as it goes. Both round impacts to a step; `locate_impacts=True` does not.
#
# The peers run in Pythons of their own, named by the environment variables `SICONOS_PYTHON`
# (Debian: `python3-siconos`, and a C compiler) and `MUJOCO_PYTHON` (PyPI: `mujoco`); one that is
# not installed is left out. All times are of the loop alone, medians of three, in this one run.

# %%
import json
import os
import subprocess
import sys
from math import radians
from pathlib import Path
from typing import Any

import numpy as np
from problems.rocking import BLOCK
from problems.studies import STUDIES

import fenicsx_contact
from fenicsx_contact.output.report import quick_asked, whence, write_summary, write_table
from fenicsx_contact.references.housner import rocking
from fenicsx_contact.references.swings import swings
from fenicsx_contact.study import Study, ladder, measure

RESULTS = Path("results") / "benchmark_rocking"
PEERS = Path(fenicsx_contact.__file__).resolve().parents[1] / "demos" / "peers"
TILT, IMPACTS = radians(0.01), 3  # rad, -: how many maxima are compared
EXACT = rocking(BLOCK, TILT, IMPACTS + 1)
UNTIL = float(EXACT.impact_times[-2:].mean())  # s, past the last of these impacts
STEPS = (1e-4, 3e-5, 1e-5, 3e-6, 1e-6)  # s, of the peers
OURS, THEIRS = 1e-4, 1.5e-3  # the errors at which run times are compared


# %%
def ours(quick: bool) -> list[dict[str, Any]]:
    """Located impacts, few steps, uniform and adaptive: errors and run times."""
    shares = [1 / 2, 1 / 8] if quick else [1, 0.7, 1 / 2, 1 / 4, 1 / 8, 1 / 16]
    errors = [1e-5] if quick else [1e-4, 1e-5, 1e-6]
    settings = ladder("share", shares, located=True, impacts=IMPACTS)
    settings += ladder("step_error", errors, share=1, located=True, impacts=IMPACTS)
    build = STUDIES["rocking_degree"].build
    study = Study("located", "impacts located", "first maxima", build, {"ours": settings})
    samples = measure(study, 1 if quick else 3)
    return [
        {"setting": s.setting, "error": s.error} | _cost(s.run_time_s, s.steps) for s in samples
    ]


def peer(name: str, quick: bool) -> list[dict[str, Any]] | str:
    """The same of a peer, or why it is left out."""
    python = os.environ.get(f"{name.upper()}_PYTHON", sys.executable)
    steps = [repr(dt) for dt in (STEPS[:2] if quick else STEPS)]
    command = [python, str(PEERS / f"rocking_{name}.py"), repr(TILT), repr(UNTIL), *steps]
    try:
        run = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    except (OSError, subprocess.TimeoutExpired) as failure:
        return f"left out: {failure}"
    if run.returncode:
        return f"left out: {(run.stderr.strip().splitlines() or ['failed'])[-1]}"
    exact = EXACT.kinetic_before[:IMPACTS]
    result = []
    for line in run.stdout.splitlines():
        if not line.startswith("{"):
            continue
        row = json.loads(line)
        _, most = swings(*np.array(row["rows"]).T, IMPACTS)
        error = float(np.abs(most / exact - 1).max())
        cost = _cost(row["run_time_s"], len(row["rows"]))
        result.append({"setting": {"dt": row["dt"]}, "error": error} | cost)
    return result


def _cost(run_time: float, steps: int) -> dict[str, Any]:
    return {"run_time_s": run_time, "steps": steps, "us_per_step": 1e6 * run_time / max(steps, 1)}


def cheapest(rows: Any, error: float) -> float:
    """The smallest run time, s, that came with at most this error; NaN if none did."""
    times = [row["run_time_s"] for row in rows if row["error"] <= error]
    return min(times, default=np.nan)


def table(summary: dict[str, Any]) -> str:
    """All runs, as Markdown."""
    lines = [f"| code | setting | error of {IMPACTS} maxima | run time | steps | per step |"]
    lines.append("|---|---|---|---|---|---|")
    for name, rows in summary.items():
        if isinstance(rows, str):
            lines.append(f"| {name} | {rows} | | | | |")
            continue
        for row in rows:
            setting = ", ".join(f"{k} = {row['setting'][k]:.3g}" for k in list(row["setting"])[:1])
            lines.append(
                f"| {name} | {setting} | {row['error']:.2g} | {row['run_time_s']:.2g} s "
                f"| {row['steps']} | {row['us_per_step']:.0f} µs |"
            )
    return "\n".join(lines)


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    summary: dict[str, Any] = {"fenicsx_contact, impacts located": ours(quick)}
    for name in ("siconos", "mujoco"):
        summary[name] = peer(name, quick)
    text = table(summary)
    print(text)
    own = cheapest(summary["fenicsx_contact, impacts located"], OURS)
    times = {f"ours to {OURS:g}": own}
    for name in ("siconos", "mujoco"):
        if not isinstance(summary[name], str):
            times[f"{name} to {THEIRS:g}"] = cheapest(summary[name], THEIRS)
    summary["compared_s"] = times
    write_summary(RESULTS, summary)
    write_table(RESULTS, text, quick)
    print("; ".join(f"{what}: {time:.3g} s" for what, time in times.items()) + f"; {whence()}")
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - `IMPACTS = 10`: ten maxima.
# - In `peers/rocking_mujoco.py` a softer `solimp`: the maxima are then too low.
#
# ## Sources
#
# - V. Acary, F. Pérignon, *Siconos: a software platform for modeling, simulation, analysis and
#   control of nonsmooth dynamical systems*, inria-00162911.
# - E. Todorov, T. Erez, Y. Tassa (2012), *MuJoCo: a physics engine for model-based control*, IROS,
#   doi:10.1109/IROS.2012.6386109.
